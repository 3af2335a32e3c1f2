"""Quantities of contacts that yield."""

from comparisons.facts.quantities.row import Quantity

_YIELDS = ("plasticity",)

ROWS = (
    Quantity(
        "residual_depth",
        "depth that remains after unloading",
        "d_res",
        "m",
        comparable=True,
        physics=_YIELDS,
    ),
    Quantity(
        "plastic_share",
        "share of the contact that yields",
        "A_p/A",
        comparable=True,
        physics=_YIELDS,
    ),
    Quantity(
        "first_yield",
        "penetration at first yield",
        "d_y",
        "m",
        comparable=True,
        physics=_YIELDS,
        single=True,
    ),
)
