"""Quantities of surfaces that attract each other."""

from comparisons.facts.quantities.row import Quantity

ROWS = (
    Quantity("pull_off_force", "pull-off force", "F_off", "N", asked=True, physics=("adhesion",)),
)
