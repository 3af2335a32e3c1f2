"""Validity of the edge-stretch rule for attraction of finite range, by two laws of tension.

Constant tension has Maugis' closed-form solution; exponentially decreasing tension of the same
strength and work of adhesion is solved on grids.
"""

from __future__ import annotations

import math
from typing import Annotated

import numpy as np

from comparisons.judging.uncertainty import RULE
from comparisons.questions.experiments.experiment import Above, Effort, Finding, OneOf, experiment
from comparisons.solving.shared import shared
from reduced.adhesion.adhere import pull_off
from reduced.profiles.equivalents import paraboloid
from reduced.springs.line import Springs
from reference.closed_form.adhesive import MaugisForm, strength_of
from reference.halfspace import FreeOperator
from reference.halfspace.cohesive import CohesiveProblem
from reference.halfspace.cohesive_laws import exponential
from reference.halfspace.cohesive_path import trace

LAWS = ("constant", "exponential")
# R = E* = w = 1: in Maugis' units one parameter remains. His equations are solved to 1e-12, and the
# force is minimised to 1e-9 of the radius, with a much smaller error of the minimum.
_EXACT = 1e-10
# Points per side of the coarse and fine grid, and the limits of the parameter between which they
# resolve and contain the zone of tension.
_GRIDS: dict[Effort, tuple[int, int]] = {"quick": (32, 48), "full": (64, 96)}
_RESOLVED = (0.3, 1.0)
# The grid contains the tension down to exp(-8) for a surface pulled up by 1.2 units of depth.
_TAIL, _RISE = 8.0, 1.2


@experiment(
    "adhesive-range",
    "Pull-off force of a ball against a tension of finite range",
    "parameter",
    "Maugis' parameter lambda",
)
def adhesive_range(
    effort: Effort,
    *,
    parameter: Annotated[float, Above(0)] = 1.0,
    law: Annotated[str, OneOf(*LAWS)] = "constant",
) -> Finding:
    """Measure the relative error of the rule's pull-off force for a tension of finite range.

    ``"constant"``: out to a fixed gap (Maugis 1992). ``"exponential"``: sigma0 exp(-sigma0 h/w).
    """
    rule = pull_off(Springs(paraboloid(1.0), 1.0), 1.0).before.force
    strength = strength_of(1.0, 1.0, 1.0, parameter)
    form = MaugisForm(1.0, 1.0, 1.0, strength)
    constant = float(form.force(form.pull_off()))
    details: dict[str, float | str] = {"pull-off force over pi w R, by Maugis": -constant / math.pi}
    if law == "constant":
        return Finding(rule, constant, _EXACT, details)
    low, high = _RESOLVED
    if not low <= parameter <= high:
        raise ValueError(f"parameter must lie from {low} to {high} on grids, not {parameter!r}")
    coarse, fine = (_on_grid(strength, points) for points in _GRIDS[effort])
    details["pull-off force over pi w R, exponential"] = -fine / math.pi
    bar = rule / fine * RULE.two * abs(coarse / fine - 1) + _EXACT
    return Finding(rule, fine, bar, details)


@shared(maxsize=64)
def _on_grid(strength: float, points: int) -> float:
    """Return the pull-off force by the exponential law on an off-centre grid."""
    law = exponential(1.0, 1.0 / strength)
    unit = (math.pi / (4 / 3)) ** (2 / 3)  # Maugis' unit of depth, ((pi w)^2 R/K^2)^(1/3)
    step = 2 * math.sqrt(2 * (_TAIL * law.reach + _RISE * unit)) / points
    x = (np.arange(points) - (points - 1) / 2 + 0.13) * step
    y = (np.arange(points) - (points - 1) / 2 - 0.21) * step
    operator = FreeOperator((points, points), (step, step), 1.0)
    problem = CohesiveProblem(operator, (x[:, None] ** 2 + y**2) / 2, law)
    fold = trace(problem, 0.3 * unit, -2.5 * unit, steps=40).pull_off()
    if fold is None:
        raise ArithmeticError("the path ended before the pull-off")
    return fold[1]
