"""Quantities of impacts."""

from comparisons.facts.quantities.row import Quantity

_HITS = ("dynamics",)

ROWS = (
    Quantity("restitution", "coefficient of restitution", "e", asked=True, physics=_HITS),
    Quantity("contact_duration", "duration of contact", "T", "s", asked=True, physics=_HITS),
)
