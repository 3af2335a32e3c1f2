"""Quantities of adhesive contacts."""

from comparisons.facts.quantities.row import Quantity

ROWS = (
    Quantity(
        "pull_off_force",
        "pull-off force",
        "F_off",
        "N",
        comparable=True,
        physics=("adhesion",),
        single=True,
    ),
)
