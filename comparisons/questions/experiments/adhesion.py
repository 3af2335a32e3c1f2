"""Adhesion of flat faces that are not round, and of attraction with a finite range.

On a grid the attraction needs a zone of several cells, 0.8 E* w/sigma0^2 wide (Maugis 1992). The
pull-off force approaches that of short range in proportion to the zone, so a few zones with equally
many cells give the limit without any calibrated edge: for a disc it is Kendall's (tested).

Constant tension has Maugis' closed-form solution; exponentially decreasing tension of the same
strength and work of adhesion is solved on grids.
"""

from __future__ import annotations

import math
from typing import Annotated, Literal

import numpy as np

from comparisons.judging.uncertainty import RULE, SAFE, combined
from comparisons.questions.experiments.experiment import Above, Effort, Finding, OneOf, experiment
from comparisons.solving.shared import shared
from reduced.adhesion import pull_off
from reduced.profiles.equivalents import equivalent_punch, paraboloid
from reduced.springs.line import Springs
from reference.closed_form import elliptic_punch
from reference.closed_form.adhesive import MaugisForm, strength_of
from reference.halfspace import FreeOperator, areas
from reference.halfspace.cohesive import CohesiveProblem, Ending, dugdale, exponential, trace

# Cells across the zone, and cells per radius of the disc of equal area.
_ZONE = 6
_GRIDS: dict[Effort, tuple[int, ...]] = {"quick": (12, 24), "full": (16, 32, 48)}
_RAMP, _TOLERANCE = 0.3, 1e-6
# The path ends when the force exceeds its minimum by this factor.
_RISEN = 0.05


@experiment(
    "adhesive-face",
    "Pull-off force of a flat face against a half-space with attraction of ever less range",
    "aspect",
    "ratio of the axes",
)
def adhesive_face(
    effort: Effort,
    *,
    shape: Literal["ellipse", "square"] = "ellipse",
    aspect: Annotated[float, Above(0)] = 1.0,
) -> Finding:
    """Measure the pull-off force of the edge-stretch rule for the disc of equal area.

    Sources of the bar, with Roache's safety factors: the change of the limit from the two coarser
    zones to the two finer ones (for two zones, half of the extrapolation), the change of the widest
    zone on twice as many cells, and what the stairs of the outline do to the limits.
    """
    counts = np.array(_GRIDS[effort])
    pulls = np.array([_ratio(int(n), _ZONE, shape, aspect) for n in counts])
    limits = _limits(counts, pulls)
    last = limits[-2] if len(limits) > 1 else 0.5 * (limits[-1] + pulls[-1])
    finer = _ratio(2 * int(counts[0]), 2 * _ZONE, shape, aspect)
    bars = {
        "bar: range": SAFE * float(abs(1 - last / limits[-1])),
        "bar: cells of the zone": SAFE * float(abs(finer / pulls[0] - 1)),
        "bar: outline in cells": SAFE * _outline(counts, shape, aspect),
    }
    true = float(limits[-1])  # the rule's force is one
    details: dict[str, float | str] = {
        "pull-off force over the rule's": true,
        **{
            f"the same, zone of {_ZONE / n:.3g} radii": float(p)
            for n, p in zip(counts, pulls, strict=True)
        },
    }
    return Finding(1.0, true, float(combined(*bars.values())) / true, {**details, **bars})


def _limits(counts: np.ndarray, values: np.ndarray) -> np.ndarray:
    """Return what neighbouring grids extrapolate to, at first order in 1/counts."""
    limits: np.ndarray = values[1:] + np.diff(values) * counts[:-1] / np.diff(counts)
    return limits


def _outline(counts: np.ndarray, shape: str, aspect: float) -> float:
    """Return the effect of an outline of cells on a limit of pull-off forces.

    The normal stiffness of the same cells, extrapolated alike, against that of the elliptic punch
    in closed form: the largest deviation, twice, since the pull-off force depends on the edge
    alone. The square has no stairs.
    """
    if shape == "square":
        return 0.0
    values = []
    for cells in counts:
        operator, gap = _face(int(cells), shape, aspect)
        mask = np.isfinite(gap)
        of_disc = 2 * np.sqrt(mask.sum() * operator.cell_area / np.pi)
        values.append(areas.contact_stiffness(operator, mask) / of_disc)
    exact = float(elliptic_punch(aspect, 1.0, 1.0).force(1.0)) / (2 * np.sqrt(aspect))
    return 2 * float(np.abs(_limits(counts, np.array(values)) / exact - 1).max())


def _ratio(cells: int, zone: int, shape: str, aspect: float) -> float:
    """Return the pull-off force over that of the rule for a disc of equal area; E* = w = 1."""
    operator, gap = _face(cells, shape, aspect)
    radius = float(np.sqrt(np.isfinite(gap).sum() * operator.cell_area / np.pi))
    strength = float(np.sqrt(0.8 / (zone * operator.spacing[0])))
    problem = CohesiveProblem(operator, gap, dugdale(1.0, strength, ramp=_RAMP))
    stretch = float(np.sqrt(2 * np.pi * radius))
    path = trace(
        *(problem, 0.02 * stretch, -1.3 * stretch - 1 / strength),
        tolerance=_TOLERANCE,
        ending=Ending(risen=_RISEN),
    )
    side = path.pull_off()
    assert side is not None  # the path has passed its minimum force
    rule = pull_off(Springs(equivalent_punch(np.pi * radius**2), 1.0), 1.0).before.force
    return side[1] / rule


def _face(cells: int, shape: str, aspect: float) -> tuple[FreeOperator, np.ndarray]:
    """Return the operator and the gap, zero on the cells of a face of area pi, else infinite."""
    if shape == "square":
        count = 2 * round(0.5 * np.sqrt(np.pi) * cells)
        step = float(np.sqrt(np.pi)) / count
        return FreeOperator((count, count), (step, step), 1.0), np.zeros((count, count))
    half = float(np.sqrt(aspect)), float(1 / np.sqrt(aspect))
    nx, ny = (2 * int(np.ceil(side * cells - 1e-9)) for side in half)
    x, y = ((np.arange(n) - (n - 1) / 2) / cells for n in (nx, ny))
    inside = (x[:, None] / half[0]) ** 2 + (y[None, :] / half[1]) ** 2 <= 1
    return FreeOperator((nx, ny), (1 / cells,) * 2, 1.0), np.where(inside, 0.0, np.inf)


LAWS = ("constant", "exponential")
# R = E* = w = 1: in Maugis' units one parameter remains. His equations are solved to 1e-12, and the
# force is minimised to 1e-9 of the radius, with a much smaller error of the minimum.
_EXACT = 1e-10
# Points per side of the coarse and fine grid, and the limits of the parameter between which they
# resolve and contain the zone of tension.
_RANGE_GRIDS: dict[Effort, tuple[int, int]] = {"quick": (32, 48), "full": (64, 96)}
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
    coarse, fine = (_on_grid(strength, points) for points in _RANGE_GRIDS[effort])
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
