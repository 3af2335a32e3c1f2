"""The number of contacts of a size."""

from comparisons.facts.quantities.row import Bins, Quantity

ROWS = (
    Quantity(
        "contact_sizes",
        "areas of single contacts, distribution",
        "n(A)",
        "m2",
        comparable=True,
        field=True,
        norm=True,
        bins=Bins("area", 1e-8, 1.0),
    ),
)
