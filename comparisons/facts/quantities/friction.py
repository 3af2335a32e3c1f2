"""Quantities of frictional and sliding contacts."""

from comparisons.facts.quantities.row import Quantity

_STICKS, _DRAGS = ("friction",), ("friction", "sliding")

ROWS = (
    Quantity(
        "tangential_force",
        "tangential force",
        "Fₓ",
        "N",
        comparable=True,
        physics=_DRAGS,
        load="tangential",
    ),
    Quantity(
        "tangential_displacement",
        "tangential displacement",
        "uₓ",
        "m",
        comparable=True,
        physics=_STICKS,
        load="tangential",
    ),
    Quantity(
        "tangential_stiffness",
        "tangential stiffness",
        "kₓ",
        "N/m",
        comparable=True,
        physics=_STICKS,
    ),
    Quantity("stick_area", "sticking area", "A_stick", "m2", comparable=True, physics=_STICKS),
    Quantity(
        "friction_coefficient", "coefficient of friction", "µ", comparable=True, physics=_DRAGS
    ),
)
