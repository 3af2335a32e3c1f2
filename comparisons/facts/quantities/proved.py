"""The sides of the intervals that theorems prove: columns beside what they enclose."""

from comparisons.facts.quantities.contact import ROWS as CONTACT
from comparisons.facts.quantities.row import Quantity

# What is enclosed, the load at which it is not prescribed itself.
ENCLOSED = ("force", "penetration", "stiffness", "energy")
SIDES = {"lower": "proved not below", "upper": "proved not above"}

ROWS = tuple(
    Quantity(f"{row.name}_{side}", f"{row.label}, {meaning}", row.symbol, row.unit)
    for row in CONTACT
    if row.name in ENCLOSED
    for side, meaning in SIDES.items()
)
