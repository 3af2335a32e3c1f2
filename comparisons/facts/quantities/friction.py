"""Quantities of contacts with friction, and of bodies that slide."""

from comparisons.facts.quantities.row import Quantity

_STICKS, _DRAGS = ("friction",), ("friction", "sliding")

ROWS = (
    Quantity(
        "tangential_force",
        "tangential force",
        "Fₓ",
        "N",
        asked=True,
        physics=_DRAGS,
        load="tangential",
    ),
    Quantity(
        "tangential_displacement",
        "tangential displacement",
        "uₓ",
        "m",
        asked=True,
        physics=_STICKS,
        load="tangential",
    ),
    Quantity(
        "tangential_stiffness", "tangential stiffness", "kₓ", "N/m", asked=True, physics=_STICKS
    ),
    Quantity("stick_area", "sticking area", "A_stick", "m2", asked=True, physics=_STICKS),
    Quantity("friction_coefficient", "coefficient of friction", "µ", asked=True, physics=_DRAGS),
)
