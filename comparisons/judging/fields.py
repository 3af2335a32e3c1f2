"""What is compared at the last load: the pressure at every point, and distributions."""

from __future__ import annotations

from comparisons.facts.quantities import DISTRIBUTIONS
from comparisons.judging.distributions import TrueDistribution, distribution_measures
from comparisons.judging.metrics import Measure
from comparisons.judging.pressures import TruePressure, pressure_measures
from comparisons.judging.truth import Truth
from comparisons.solving.plan import Plan
from comparisons.tasks.solution import Solved


def field_measures(
    plan: Plan, solved: Solved, method: str, resolution: int, truth: Truth
) -> list[Measure]:
    """Return name, error and bar of each measure at the last load of one solution."""
    of_one = plan, solved, method, resolution, truth
    return [*pressure_measures(*of_one), *distribution_measures(*of_one)]


def field_bar(plan: Plan, truth: Truth, name: str) -> list[float]:
    """Return how well the truth knows a field at the last load; nothing where it gives none."""
    if name in DISTRIBUTIONS:
        distribution = TrueDistribution(plan, truth, name)
        return [distribution.bar()] if distribution.is_known else []
    pressure = TruePressure(plan, truth)
    return [pressure.bar()] if pressure.is_known else []
