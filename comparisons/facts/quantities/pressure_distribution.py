"""The share of the surface that carries a pressure."""

from comparisons.facts.quantities.row import Bins, Quantity

ROWS = (
    Quantity(
        "pressure_distribution",
        "contact pressure, distribution",
        "P(p)",
        "Pa",
        comparable=True,
        field=True,
        norm=True,
        bins=Bins("pressure", 1e-5, 1e2),
    ),
)
