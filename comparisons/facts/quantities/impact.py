"""Quantities of impacts."""

from comparisons.facts.quantities.row import Quantity

_HITS = ("dynamics",)

ROWS = (
    Quantity("restitution", "coefficient of restitution", "e", comparable=True, physics=_HITS),
    Quantity("contact_duration", "duration of contact", "T", "s", comparable=True, physics=_HITS),
)
