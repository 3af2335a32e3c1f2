"""Quantities of contacts that wear."""

from comparisons.facts.quantities.row import Quantity

_WEARS = ("wear",)

ROWS = (
    Quantity("worn_volume", "worn volume", "V", "m3", comparable=True, physics=_WEARS),
    Quantity("wear_depth", "largest worn depth", "h_w", "m", comparable=True, physics=_WEARS),
)
