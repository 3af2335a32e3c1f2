"""Rolling with creep (19.1): what the springs know of it, and that its solution does not change.

E* = R = a = 1 unless said otherwise; normal and tangential tractions are uncoupled.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache
from itertools import repeat
from typing import Annotated, Literal

import numpy as np

from comparisons.judging.uncertainty import ratio_of_means
from comparisons.questions.experiments.experiment import (
    Count,
    Effort,
    Finding,
    Fraction,
    Positive,
    Share,
    experiment,
    one_of,
)
from comparisons.questions.experiments.rolling_cylinders import (
    Carter,
    PlaneElements,
    PlaneSurface,
    RubberCylinder,
    hertz,
    moving_compliance,
)
from comparisons.questions.experiments.rough_ensemble import Surface
from comparisons.solving.shared import shared
from reduced.friction.roll import roll_rough
from reduced.friction.slide import Friction, tangential_modulus
from reference import loads as reference_loads
from reference.arrays import Array, Mask
from reference.contact import slide as stick_slip
from reference.errors import poisson_faults, positive_faults, refuse
from reference.fem import Material
from reference.fem.grid_body import ShearBody
from reference.halfspace.traction import Compliance, NormalAndTangential, cell_integrals
from reference.rolling.creep_theories import kalker, on_grid
from reference.rolling.roll import Creep, Upstream, pressed, roll_on, steady
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rubber import SlidingContact, slide_on_rubber
from reference.viscoelastic.travelling import TravellingPlane

_FRICTION, _POISSON = 0.3, 0.25
_COEFFICIENTS = ("C11", "C22", "C23", "C33")
_GRIDS: dict[Effort, tuple[int, ...]] = {"quick": (6, 8, 11), "full": (10, 14, 20)}


@experiment("creep-coefficient", "Poisson's ratio")
def creep_coefficient(
    effort: Effort,
    *,
    poisson_ratio: float = 0.25,
    axis_ratio: Positive = 1.0,
    coefficient: Annotated[str, one_of(*_COEFFICIENTS)] = "C11",
    of: Literal["springs", "table", "elements"] = "springs",
) -> Finding:
    """Slope of the creep curve against that of the half-space, extrapolated from grids.

    `of`: ``"springs"``, which know no spin; Kalker's ``"table"``; ``"elements"`` against cells of
    their size, eight or eleven on the shorter semi-axis, with the difference from coarser ones as
    the bar.
    """
    which = _COEFFICIENTS.index(coefficient)
    if which > 1 and of == "springs":
        raise ValueError(f"of must be 'table' or 'elements': springs have no {coefficient}")
    if of == "elements":
        coarse, fine = (
            _elements_on_cells(poisson_ratio, axis_ratio, count)[which]
            for count in ((6, 8) if effort == "quick" else (8, 11))
        )
        return Finding(fine, 1.0, abs(fine - coarse), {})
    study = _coefficients(poisson_ratio, axis_ratio, _GRIDS[effort])
    true, bar = float(study.limit[which]), float(study.uncertainty[which])
    stated = 4 / (2 - poisson_ratio)
    if of == "table":
        stated = kalker(axis_ratio, poisson_ratio)[which]
    return Finding(stated, true, bar * stated / true**2, {})


@shared(maxsize=256)
def _elements_on_cells(poisson_ratio: float, axis_ratio: float, count: int) -> tuple[float, ...]:
    """Return the coefficients of finite elements over those of cells of their size."""
    compliance = Compliance.of(1.0, poisson_ratio)
    material = Material(2 * (1 + poisson_ratio), poisson_ratio)
    cells = on_grid(
        lambda shape, side: NormalAndTangential(shape, (side, side), compliance), axis_ratio, count
    )
    elements = on_grid(
        lambda shape, side: ShearBody(shape, (side, side), material), axis_ratio, count
    )
    return tuple((elements / cells).tolist())


@experiment("creep-cylinder", "traction F_x/(mu F)")
def creep_cylinder(
    effort: Effort,
    *,
    traction: Fraction = 0.5,
    on: Literal["cells", "elements"] = "cells",
    inertia: float = 0.0,
) -> Finding:
    """Traction of a cylinder that rolls on cells against Carter's closed form.

    At his creep for `traction`. ``on = "cells"`` of the half-space, or ``"elements"`` of plane
    strain, whose `inertia` is rho V^2/G: a load that moves finds the half-space softer, and
    Carter's creep is larger by that.
    """
    if not 0 <= inertia <= (0.5 if on == "elements" else 0):
        raise ValueError(f"inertia must be from 0 to 0.5, and is of elements, not {inertia!r}")
    cylinder = Carter(1.0, 1.0, _FRICTION)
    compliance = Compliance.of(0.25, _POISSON)
    force = np.pi * compliance.effective_modulus / 4
    softer = moving_compliance(_POISSON, inertia)

    def on_cells(cells: int) -> float:
        x = (np.arange(-cells, cells + 1) + 0.5) / cells
        bound = _FRICTION * hertz(x, 1.0, force)[:, None]
        creep = np.zeros((2, x.size, 1))
        creep[0] = softer * cylinder.creep(traction)
        surface = PlaneSurface(x.size, 1 / cells, compliance)
        if on == "elements":
            grid = surface.cells, surface.width, compliance
            surface = PlaneElements(*grid, _POISSON, inertia=inertia)
        answer = steady(Upstream(surface, bound.shape), bound, creep)
        return float(answer.traction[0].sum() / bound.sum())

    coarse, fine = (on_cells(n) for n in ((80, 160) if effort == "quick" else (160, 320)))
    details = {
        "stick over contact": float(cylinder.stick_share(cylinder.creep(traction))),
        "F_x/(mu F) on the finest cells": fine,
    }
    # of first order: extrapolated
    return Finding(2 * fine - coarse, traction, abs(fine - coarse) / traction, details)


@experiment("rolling-steady", "way rolled over the contact radius")
def rolling_steady(effort: Effort, *, way: Positive = 6.0, share: Fraction = 0.5) -> Share:
    """Tractions after rolling on from Cattaneo's against those of the steady state.

    The steady state solves equations of its own. The largest difference of a traction after a `way`
    in contact radii, over the largest traction.
    """
    cells = 6 if effort == "quick" else 12
    x, y = (np.arange(-cells, cells + 1) + 0.5) / cells, (np.arange(-cells, cells) + 0.5) / cells
    compliance = Compliance.of((1 - _POISSON) / 2, _POISSON)
    body = NormalAndTangential((x.size, y.size), (1 / cells, 1 / cells), compliance)
    pressure = 2 / np.pi * np.sqrt(np.maximum(1 - x[:, None] ** 2 - y**2, 0.0))
    bound = _FRICTION * pressure
    still = np.zeros((2, *body.shape))
    held = stick_slip.slide(body, bound, still, total=share * bound.sum())
    creep = Creep(share * _FRICTION / 2)  # near that of the same force in steady rolling
    field = np.zeros((2, *body.shape))
    field[0] = creep.along
    end = steady(Upstream(body, body.shape), bound, field).traction
    steps = int(np.ceil(way * cells))
    tractions = list(roll_on(body, repeat(pressure, steps), _FRICTION, creep, held.traction))
    scale = float(np.abs(end).max())
    left = [float(np.abs(traction - end).max()) / scale for traction in tractions]
    limit = _FRICTION * float(pressure.sum() * body.cell_area)
    last = float(tractions[-1].sum(axis=(1, 2))[0] * body.cell_area)
    details = {
        "F_x/(mu F) at the start": share,
        "F_x/(mu F) in the end": last / limit,
        "F_x/(mu F) of the steady state": float(end[0].sum() * body.cell_area) / limit,
        "difference after a contact radius": left[cells - 1],
    }
    return Share(left[-1], 1e-5, details, "deviation")


@experiment("rolling-resistance", "way in the retardation time over half the contact")
def rolling_resistance(effort: Effort, *, way: Positive = 1.0) -> Finding:
    """Rolling resistance of a cylinder on rubber against Hunter's closed form.

    On strips. `way`: rolled in the retardation time, over half the width of the contact. The
    instantaneous modulus of the standard solid is eleven times that at rest.
    """
    cylinder = RubberCylinder(1.0, 100.0, way, 0.25, 11.0)
    rubber = GeneralisedMaxwell.standard(0.25, 2.5, 1 / 11)
    force = reference_loads.Load("force", cylinder.force)

    def on_strips(cells: int) -> SlidingContact:
        # the contact moves ahead of the axis; where to is not told to the solver
        x = cylinder.middle + (np.arange(3 * cells)[:, None] + 0.5) / cells - 1.5
        body = TravellingPlane(3 * cells, 1 / cells, rubber, way)
        return slide_on_rubber(body, x**2 / 200, force, slope=x / 100)

    coarse, fine = (on_strips(n) for n in ((12, 24) if effort == "quick" else (24, 48)))
    few, many = coarse.friction_coefficient, fine.friction_coefficient
    details = {
        "M/(F R) times R/way": cylinder.resistance * 100 / way,
        "half-width over Hunter's": fine.contact_area / 2,
        "middle of the contact over its half-width": cylinder.middle,
    }
    return Finding(many, cylinder.resistance, abs(many - few) / cylinder.resistance, details)


@experiment("rolling-rough", "rms gradient over a/R")
def rolling_rough(
    effort: Effort,
    *,
    slope: Positive = 0.5,
    share: Positive = 0.3,
    surface: Surface = Surface(48, roll_off=4.0),
    runs: Count = 8,
) -> Finding:
    """Traction of rough lines that roll against that of rough balls.

    The roughness has the rms gradient `slope` in units of a/R and travels with the surface; the
    creep is `share` of that at which the springs of a smooth ball slip everywhere. nu = 1/2.
    """
    radius = 0.3  # a, of a side of one
    curvature = 1 / (slope * radius)  # 1/R, for gradients of one
    force = 4 / 3 * radius**3 * curvature
    friction = Friction(tangential_modulus(0.25, 0.5), _FRICTION)
    creep = share * 2 * _FRICTION * radius * curvature / friction.tangential_modulus
    limit = _FRICTION * force
    count = runs if effort == "full" else max(2, runs // 4)
    n = surface.points
    x = (np.arange(n) - (n - 1) / 2) / n
    body = NormalAndTangential((n, n), (1 / n, 1 / n), Compliance.of(0.25, 0.5))
    gap, load = curvature * (x[:, None] ** 2 + x**2) / 2, reference_loads.Load("force", force)
    balls = []
    for number in range(count):
        heights = surface.heights(number)
        way = np.concatenate([heights, heights])
        fields = pressed(body, gap, way, load, 1e-4)
        tractions = roll_on(body, fields, _FRICTION, Creep(creep))
        forces = [q.sum(axis=(1, 2))[0] * body.cell_area for q in tractions]
        # the mean over a period; the first half of the way forgets that there was no traction
        balls.append(np.mean(forces[n // 2 :]))
    true = np.array(balls)
    n = 4 * surface.points
    x = (np.arange(n) - (n - 1) / 2) / n
    lines = surface.lines(64 * count, 4).draw().heights
    gap, rolled = curvature * x**2, (1 / n, 1.0, friction, force, creep)
    stated = np.array(
        [roll_rough(gap, np.concatenate([h, h]), *rolled).tangential_force for h in lines]
    )
    ratios, bars = ratio_of_means(stated[:, None], true[:, None], paired=False)
    details = {
        "F_x/(mu F) of lines": float(stated.mean() / limit),
        "F_x/(mu F) of balls": float(true.mean() / limit),
    }
    bar = float(ratios[0] * bars[0])
    return Finding(float(stated.mean()), float(true.mean()), bar, details)


@dataclass(frozen=True)
class CreepCoefficients:
    """Coefficients on several grids, and their limit."""

    cells: Array  # (k,): strips on half the width, and cells on each of them
    values: Array  # (k, 4): C11, C22, C23 and C33 on the grids
    limit: Array  # (4,): by a straight line over the square of the cell size
    # (4,): largest change of the limit where one of the grids is left out, or the way from the
    # finest grid to the limit if larger
    uncertainty: Array

    @classmethod
    def of(cls, cells: Sequence[int], values: Array) -> CreepCoefficients:
        """Return the study of values on grids."""
        numbers = np.array(cells, dtype=float)

        def line(kept: Mask) -> Array:
            return np.array(np.polyfit(numbers[kept] ** -2, values[kept], 1)[1])

        everything = np.ones(len(cells), dtype=bool)
        limit = line(everything)
        others = [line(np.arange(len(cells)) != left) for left in range(len(cells))]
        changes = np.abs(np.array(others) - limit).max(axis=0)
        left = np.abs(values[-1] - limit)
        return cls(numbers, values, limit, np.maximum(changes, left))


def creep_coefficients(
    poisson_ratio: float, axis_ratio: float, cells: Sequence[int] = (10, 14, 20)
) -> CreepCoefficients:
    """Return C11, C22, C23 and C33 of the half-space.

    The contact is cut into strips along the rolling direction, each as long as its area requires,
    and these into cells that are fine at both ends, x = h sin. The error is of second order in the
    cells, and a straight line over the square of their size gives the limit.

    `axis_ratio` is a/b, a the semi-axis along which the contact rolls. `cells` are strips on
    half the width, and cells on each; three grids at least, ascending.
    """
    faults = poisson_faults(poisson_ratio) + positive_faults(axis_ratio=axis_ratio)
    if len(cells) < 3 or list(cells) != sorted(set(cells)) or cells[0] < 1:
        faults.append(f"cells must be three ascending numbers at least, not {cells!r}")
    refuse(faults)
    compliance = Compliance.of(1.0, poisson_ratio)
    values = [_on_strips(axis_ratio, count, compliance) for count in cells]
    return CreepCoefficients.of(cells, np.array(values))


_coefficients = lru_cache(maxsize=256)(creep_coefficients)


def _on_strips(axis_ratio: float, count: int, compliance: Compliance) -> Array:
    """Return C11, C22, C23 and C33 from so many strips of as many cells on half of an ellipse."""
    a, b = np.sqrt(axis_ratio), 1 / np.sqrt(axis_ratio)
    edges = np.linspace(0.0, 1.0, count + 1)
    areas = np.diff(edges * np.sqrt(1 - edges**2) + np.arcsin(edges)) / 2
    half = a * count * areas  # of the length of a strip
    ends = np.sin(np.pi / 2 * np.linspace(-1.0, 1.0, count + 1))
    middle = (ends[1:] + ends[:-1]) / 2
    width = b / count
    y = (np.arange(count) + 0.5) * width
    x = half[:, None] * middle
    lengths = half[:, None] * np.diff(ends)
    # with a point ahead of each strip, from which material enters
    points = half[:, None] * np.append(middle, 2 - middle[-1])

    # u - u upstream by the tractions of cells and of their mirror images, shape (2, 3, n, n): u_x
    # by q_x, u_y by q_y, u_x by q_y
    table = np.empty((2, 3, x.size, x.size))
    c1, c2 = compliance.normal, compliance.lateral
    for source, (strip, place) in enumerate(np.ndindex(*x.shape)):
        length = float(lengths[strip, place])
        along = (points - x[strip, place]) / length
        for mirrored, at in enumerate((y[strip], -y[strip])):
            across = np.broadcast_to(((y - at) / width)[:, None], along.shape)
            cell = cell_integrals(along, across, (length, width))
            both = c1 * (cell.xx + cell.yy)
            parts = np.stack([both + c2 * cell.xx, both + c2 * cell.yy, c2 * cell.xy])
            table[mirrored, :, :, source] = -np.diff(parts, axis=2).reshape(3, -1)
    direct, image = table / (2 * np.pi)

    # the rigid slip from each cell to the next upstream, by creep along and across, and by spin,
    # (-y, x), whose integral is taken
    upstream = np.diff(points, axis=1)
    ways = np.zeros((3, 2, *upstream.shape))
    ways[0, 0] = ways[1, 1] = upstream
    ways[2] = -y[:, None] * upstream, np.diff(points**2, axis=1) / 2

    # tractions of full stick; their sums over 2 G, c = 1
    forces: list[float] = []
    for parity, chosen in ((1, ways[:1]), (-1, ways[1:])):
        # q_x has this parity in y, and q_y the other one
        xx, yy, xy, yx = (
            direct[part] + sign * parity * image[part]
            for part, sign in ((0, 1), (1, -1), (2, -1), (2, 1))
        )
        matrix = np.block([[xx, xy], [yx, yy]])
        tractions = np.linalg.solve(matrix, chosen.reshape(len(chosen), -1).T)
        for traction in tractions.T.reshape(-1, 2, *x.shape):
            sums = 2 * width * (traction * lengths).sum(axis=(1, 2))
            forces.append(float(sums[(1 - parity) // 2]))
    turning = traction[1] * x - traction[0] * y[:, None]  # by spin, the last
    forces.append(2 * width * float((turning * lengths).sum()))
    return np.array(forces) / 2
