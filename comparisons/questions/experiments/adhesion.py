"""Adhesion of flat faces that are not round, with a finite range, and of rough surfaces.

On a grid the attraction needs a zone of several cells, 0.8 E* w/sigma0^2 wide (Maugis 1992). The
pull-off force approaches that of short range in proportion to the zone, so a few zones with equally
many cells give the limit without any calibrated edge: for a disc it is Kendall's (tested).

Constant tension has Maugis' closed-form solution; exponentially decreasing tension of the same
strength and work of adhesion is solved on grids.

Rough surfaces are as in `rough_ensemble`, periodic: E* = A0 = h' = 1. The tension falls as
exp(-gap/rho), the law of the Contact Mechanics Challenge (Mueser et al. 2017). The work of adhesion
is given by the number S, attraction over repulsion where the range is short,

    S = pi kappa (w/(E* h' rho)) (3 rho/(4 h' d))^(2/3),   d = 4 h'/h'',

with kappa = 2 and h'' the rms of half the Laplacian: from S = 1 on surfaces should stick. This is
L. Pastewka & M. O. Robbins (PNAS 111 (2014) 3298), as the example ``adhesive_simulation_rough`` of
ContactEngineering's package Adhesion prints kappa, d and (rho h''/h'^2)^(2/3) for it; the constant
pi (3/16)^(2/3) = 1.03 before that is their "about 1", from memory.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from comparisons.judging.uncertainty import OF_TWO, SAFE, combined
from comparisons.questions.experiments.adhesive_minimum import Adhesive
from comparisons.questions.experiments.experiment import (
    Effort,
    Finding,
    Positive,
    experiment,
    one_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    PeriodicSurface,
    Surface,
    compare,
    press,
    truth,
)
from comparisons.solving.shared import shared
from reduced.adhesion import pull_off
from reduced.loads import Load
from reduced.profiles.equivalents import equivalent_punch, paraboloid
from reduced.rough.press import press as press_lines
from reduced.springs.line import Springs
from reference.closed_form import elliptic_punch
from reference.closed_form.adhesive import MaugisForm, strength_of
from reference.halfspace import Contact, FreeOperator, areas
from reference.halfspace.cohesive import CohesiveLaw, CohesiveProblem, dugdale, exponential, trace
from reference.surfaces import SelfAffine, amplitude_spectrum

# Cells across the zone, and cells per radius of the disc of equal area.
_ZONE = 6
_GRIDS: dict[Effort, tuple[int, ...]] = {"quick": (10, 20), "full": (16, 32, 48)}
_RAMP, _TOLERANCE = 0.3, 1e-6
# The path ends when the force exceeds its minimum by this factor.
_RISEN = 0.05


@experiment("adhesive-face", "ratio of the axes")
def adhesive_face(
    effort: Effort, *, aspect: Positive = 1.0, shape: Literal["ellipse", "square"] = "ellipse"
) -> Finding:
    """Pull-off force of a flat face against a half-space with attraction of ever less range.

    By the edge-stretch rule for the disc of equal area. Sources of the bar, with Roache's safety
    factors: the change of the limit from the two coarser zones to the two finer ones (for two
    zones, half of the extrapolation), the change of the widest zone on twice as many cells, and
    what the stairs of the outline do to the limits.
    """
    counts = np.array(_GRIDS[effort])
    pulls = np.array([_ratio(int(n), _ZONE, shape, aspect) for n in counts])
    limits = _limits(counts, pulls)
    last = limits[-2] if len(limits) > 1 else 0.5 * (limits[-1] + pulls[-1])
    finer = _ratio(2 * int(counts[0]), 2 * _ZONE, shape, aspect)
    # What an outline of cells does to a limit: the normal stiffness of the same cells, extrapolated
    # alike, against that of the elliptic punch in closed form. The largest deviation counts twice,
    # as the pull-off force depends on the edge alone. The square has no stairs.
    outline = 0.0
    if shape == "ellipse":
        values = []
        for cells in counts:
            operator, gap = _face(int(cells), shape, aspect)
            mask = np.isfinite(gap)
            of_disc = 2 * np.sqrt(mask.sum() * operator.cell_area / np.pi)
            values.append(areas.contact_stiffness(operator, mask) / of_disc)
        exact = float(elliptic_punch(aspect, 1.0, 1.0).force(1.0)) / (2 * np.sqrt(aspect))
        outline = 2 * float(np.abs(_limits(counts, np.array(values)) / exact - 1).max())
    bars = {
        "bar: range": SAFE * float(abs(1 - last / limits[-1])),
        "bar: cells of the zone": SAFE * float(abs(finer / pulls[0] - 1)),
        "bar: outline in cells": SAFE * outline,
    }
    true = float(limits[-1])  # the rule's force is one
    details = {
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
        risen=_RISEN,
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


@experiment("adhesive-range", "Maugis' parameter lambda")
def adhesive_range(
    effort: Effort, *, parameter: Positive = 1.0, law: Annotated[str, one_of(*LAWS)] = "constant"
) -> Finding:
    """Pull-off force of a ball against a tension of finite range.

    ``"constant"``: out to a fixed gap (Maugis 1992). ``"exponential"``: sigma0 exp(-sigma0 h/w).
    """
    rule = pull_off(Springs(paraboloid(1.0), 1.0), 1.0).before.force
    strength = strength_of(1.0, 1.0, 1.0, parameter)
    form = MaugisForm(1.0, 1.0, 1.0, strength)
    constant = float(form.force(form.pull_off()))
    details = {"pull-off force over pi w R, by Maugis": -constant / math.pi}
    if law == "constant":
        return Finding(rule, constant, _EXACT, details)
    low, high = _RESOLVED
    if not low <= parameter <= high:
        raise ValueError(f"parameter must lie from {low} to {high} on grids, not {parameter!r}")
    tension, pulls = exponential(1.0, 1.0 / strength), []
    unit = (math.pi / (4 / 3)) ** (2 / 3)  # Maugis' unit of depth, ((pi w)^2 R/K^2)^(1/3)
    for points in _RANGE_GRIDS[effort]:  # off-centre
        step = 2 * math.sqrt(2 * (_TAIL * tension.reach + _RISE * unit)) / points
        x = (np.arange(points) - (points - 1) / 2 + 0.13) * step
        y = (np.arange(points) - (points - 1) / 2 - 0.21) * step
        operator = FreeOperator((points, points), (step, step), 1.0)
        problem = CohesiveProblem(operator, (x[:, None] ** 2 + y**2) / 2, tension)
        fold = trace(problem, 0.3 * unit, -2.5 * unit, steps=40).pull_off()
        if fold is None:
            raise ArithmeticError("the path ended before the pull-off")
        pulls.append(fold[1])
    coarse, fine = pulls
    details["pull-off force over pi w R, exponential"] = -fine / math.pi
    bar = rule / fine * OF_TWO * abs(coarse / fine - 1) + _EXACT
    return Finding(rule, fine, bar, details)


# The theories of each quantity.
THEORIES = {
    "attraction": ("gaps", "energy", "line"),
    "pull_off": ("gaps", "line"),
    "contact_area": ("pastewka_robbins",),
}
_KAPPA = 2.0
_SURFACES, _LINES, _FINER = 6, 100, 8
# Loads at which theories of the pull-off are evaluated, of surfaces and of lines, which are cheap;
# number of mean gaps on the way out; how closely the largest is found, of a step either way.
_LOADS = tuple(np.geomspace(0.05, 1e-4, 10).tolist())
_LINE_LOADS = tuple(np.geomspace(0.05, 1e-4, 80).tolist())
_WAY, _CLOSE = 12, 0.003
_STEP = 0.05  # of the load, for the change of the energy
Array = NDArray[np.float64]


@lru_cache(maxsize=64)
def attraction_law(surface: Surface, strength: float, reach: float) -> CohesiveLaw:
    """Return the law of tension for a number S and a reach in rms heights."""
    n = surface.points
    power = amplitude_spectrum(n, 1.0, SelfAffine(**surface.recipe)) ** 2
    q = 2 * np.pi * np.hypot(*np.meshgrid(*(np.fft.fftfreq(n, 1 / n),) * 2, indexing="ij"))
    rho = reach * float(np.sqrt(power.sum()))
    diameter = 8 / float(np.sqrt(np.sum(power * q**4)))
    share = (3 * rho / (4 * diameter)) ** (2 / 3)
    return exponential(strength * rho / (np.pi * _KAPPA * share), rho)


def _across(law: CohesiveLaw, gap: np.ndarray, apart: np.ndarray) -> float:
    """Return the attraction per area across the gaps outside a contact."""
    return float(np.mean(law.tension(gap) * apart))


@shared(maxsize=64)
def _surfaces(
    surface: Surface,
    adhesion: tuple[float, float],
    load: float,
    quantity: str,
    factor: int,
    count: int,
) -> dict[str, np.ndarray]:
    """Return the quantity with adhesion and its value by each theory, for each surface.

    ``"attraction"``: what adhesion takes from the load at an equal mean gap. ``"energy"`` is
    -d<phi>/d<h> on the way without adhesion, exact for weak adhesion as the energy of the
    equilibrium is stationary. ``"contact_area"``: under compression, over that without adhesion.
    """
    law, rows = attraction_law(surface, *adhesion), []
    for number in range(count):
        heights = surface.heights(number, factor)
        body = Adhesive(surface.operator(factor), heights.max() - heights, law)

        def pressed(force: float, heights: np.ndarray = heights) -> Contact:
            return press(surface.operator(factor), heights, force)[0]

        if quantity == "pull_off":
            rows.append(_pulled_off(body, pressed))
            continue
        contact = pressed(load)
        if quantity == "contact_area":
            area = body.at_force(load, contact.gap).mask.sum()
            rows.append({"true": float(area / contact.mask.sum())})
            continue
        stuck = body.at_mean_gap(contact.mean_gap, contact.gap, load)
        below, above = pressed(load * (1 + _STEP)), pressed(load * (1 - _STEP))
        lost = law.energy(below.gap).mean() - law.energy(above.gap).mean()
        rows.append(
            {
                "true": load - stuck.force,
                "gaps": _across(law, contact.gap, ~contact.mask),
                "energy": float(lost) / (above.mean_gap - below.mean_gap),
            }
        )
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _pulled_off(body: Adhesive, pressed: Callable[[float], Contact]) -> dict[str, float]:
    """Return the largest pull on the way out, and the one by the gaps without adhesion."""
    law, gap = body.law, body.initial
    state = pressed(_LOADS[0]).gap
    on_the_way: dict[float, Array] = {}

    def pulled(mean: float) -> float:
        """Return the pull at a mean gap, coming from the next smaller one."""
        before = [place for place in on_the_way if place < mean]
        settled = body.at_setting(mean, on_the_way[max(before)] if before else state)
        on_the_way[mean] = settled.gap
        return -settled.force

    def surplus(place: float) -> float:
        load = float(np.exp(place))
        contact = pressed(load)
        return _across(law, contact.gap, ~contact.mask) - load

    way = np.linspace(state.mean(), gap.mean() + law.reach, _WAY).tolist()
    touching = float(law.tension(gap).mean())
    return {
        "true": largest(pulled, way),
        "gaps": max(touching, largest(surplus, np.log(_LOADS[::-1]).tolist())),
    }


def largest(value: Callable[[float], float], places: list[float]) -> float:
    """Return the largest value near some ordered places: Brent's search about the best of them.

    The pull has an edge where the first spot touches, at weak adhesion: a parabola would miss it.

    >>> round(largest(lambda x: 1 - abs(x - 0.3), [-1.0, 0.0, 1.0]), 2)
    1.0
    """
    values = [value(place) for place in places]
    best = int(np.argmax(values))
    low, high = places[max(best - 1, 0)], places[min(best + 1, len(places) - 1)]
    peak = minimize_scalar(
        lambda place: -value(float(place)),
        bounds=(low, high),
        method="bounded",
        options={"xatol": _CLOSE * (high - low)},
    )
    return float(max(values[best], -peak.fun))


@experiment("rough-adhesion", "Pastewka and Robbins' number S")
def rough_adhesion(
    effort: str,
    *,
    strength: Positive = 0.1,
    quantity: Annotated[str, one_of(*THEORIES)] = "attraction",
    theory: str = "gaps",
    reach: Positive = 0.3,
    load: Positive = 0.02,
    surface: Surface = PeriodicSurface(32, roll_off=2.0, shortest=4.0),
) -> Finding:
    """Adhesion of rough surfaces beside theories and the line.

    ``"attraction"``: what adhesion takes from the load at an equal mean gap; ``"pull_off"``: the
    largest pull; ``"contact_area"``: pressed area over that without adhesion, at an equal load.
    ``"gaps"``: the tension across the gaps without adhesion (Persson & Scaraggi 2014);
    ``"energy"``: Derjaguin's way, the loss of surface energy with the mean gap; ``"line"``: the
    tension across the gaps of lines; ``"pastewka_robbins"``: 1/(1 - S).
    """
    if theory not in THEORIES[quantity]:
        raise ValueError(f"theory must be one of {', '.join(THEORIES[quantity])}, not {theory!r}")
    if quantity == "contact_area" and strength >= 1:
        raise ValueError(f"strength must be below 1, where surfaces stick, not {strength!r}")
    adhesion = strength, reach

    def sample(factor: int, number: int) -> np.ndarray:
        values = _surfaces(surface, adhesion, load, quantity, factor, number)
        return values["true"] / values[theory] if theory in values else values["true"]

    true, grid_bar = truth(sample, _SURFACES, effort, fewest=_SURFACES // 2)
    stated: np.ndarray | list[float] = [1.0]
    if theory == "line":
        law, lines = attraction_law(surface, *adhesion), surface.lines(_LINES, _FINER).draw()
        loads = (load,) if quantity == "attraction" else _LINE_LOADS
        force = Load("force", list(loads[::-1]))
        depths = press_lines(lines, 1.0, force).penetration[:, ::-1]
        depths = np.column_stack([depths, np.zeros(len(lines))])
        below = lines.heights.max(axis=1, keepdims=True) - lines.heights
        pulls = []  # across the gaps, per patch
        for place, carried in enumerate((*loads, 0.0)):
            gap = below - depths[:, place, None]
            across = np.mean(law.tension(np.maximum(gap, 0.0)) * (gap > 0), axis=1)
            pulls.append(across - (carried if quantity == "pull_off" else 0.0))
        stated = pulls[0] if quantity == "attraction" else np.max(pulls, axis=0)
    elif theory == "pastewka_robbins":
        stated = [1 / (1 - strength)]
    details = {"tension over E* h'": attraction_law(surface, *adhesion).strength}
    return compare(stated, true, grid_bar, details)
