"""Quantities of lubricated contacts."""

from comparisons.facts.quantities.row import Quantity

_LUBRICATED = ("lubrication",)

ROWS = (
    Quantity(
        "film_central", "central film thickness", "h_c", "m", comparable=True, physics=_LUBRICATED
    ),
    Quantity(
        "film_minimum", "minimum film thickness", "h_min", "m", comparable=True, physics=_LUBRICATED
    ),
    Quantity(
        "lubrication_force",
        "force of the film",
        "F_film",
        "N",
        comparable=True,
        physics=_LUBRICATED,
    ),
    Quantity(
        "friction_force", "friction of the film", "F_fr", "N", comparable=True, physics=_LUBRICATED
    ),
)
