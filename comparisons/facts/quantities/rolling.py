"""Quantities of rolling contacts."""

from comparisons.facts.quantities.row import Quantity

_ROLLS = ("rolling",)

ROWS = (
    Quantity(
        "traction",
        "traction coefficient",
        "Fₓ/(µF)",
        comparable=True,
        physics=_ROLLS,
        signed=True,
    ),
    Quantity(
        "lateral_force", "lateral force", "F_y", "N", comparable=True, physics=_ROLLS, signed=True
    ),
    Quantity("creep", "creep", "ξ", signed=True),
    Quantity("lateral_creep", "lateral creep", "η", signed=True),
)
