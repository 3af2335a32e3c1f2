"""The share of the surface that is open by a gap."""

from comparisons.facts.quantities.row import Bins, Quantity

ROWS = (
    Quantity(
        "gap_distribution",
        "gap, distribution",
        "P(g)",
        "m",
        comparable=True,
        field=True,
        norm=True,
        bins=Bins("height", 1e-6, 1e2),
    ),
)
