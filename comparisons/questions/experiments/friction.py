"""Tangential loads (19.18), (19.19): sticking contacts, partial slip, and fretting (19.6).

Springs on the half-space, under smooth bodies and below rough surfaces.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from comparisons.judging.uncertainty import SAFE, grid_uncertainty
from comparisons.questions.experiments.experiment import (
    Effort,
    Finding,
    Fraction,
    Positive,
    experiment,
)
from comparisons.questions.experiments.proved import EQUAL_AREA, face_rule
from comparisons.questions.experiments.rough_ensemble import Surface, compare, truth
from comparisons.solving.shared import shared
from reduced.friction.slide import (
    Friction,
    follow,
    slide,
    slide_lines,
    stiffness_ratio,
    tangential_modulus,
)
from reduced.loads import Load, LoadPath
from reduced.profiles import equivalents
from reduced.springs.line import Springs
from reduced.wear import Oscillation, RoundBody, wear
from reference import closed_form
from reference import loads as reference_loads
from reference.closed_form.worn import FrettingLimit
from reference.halfspace import areas
from reference.halfspace.friction import FrictionalPress, sweep, tangential_stiffness
from reference.halfspace.traction import Compliance, NormalAndTangential

# Side of the grid in units of the contact half-width.
_SIDE = 2.1


@experiment("tangential-stiffness", "Poisson's ratio nu")
def tangential_stiffness_of_square(
    effort: str, *, poisson_ratio: Annotated[float, Field(gt=-1)] = 0.3
) -> Finding:
    """Tangential stiffness G* D of a square contact, D = (4A/pi)^(1/2), against the half-space.

    True are the ratio k_x/k_z on cells, where errors at the edges cancel, known by three grids, and
    the proved bounds of k_z.
    """
    resolutions = (32, 64, 96) if effort == "quick" else (64, 96, 128)
    ratios = []
    for points in resolutions:
        step = _SIDE / points
        compliance = Compliance.of(1.0, poisson_ratio)
        body = NormalAndTangential((points,) * 2, (step,) * 2, compliance)
        x = np.abs((np.arange(points) - points / 2 + 0.5) * step)
        mask = np.maximum(x[:, None], x) < 1
        along = tangential_stiffness(body, mask)[0]
        ratios.append(along / areas.contact_stiffness(body.normal, mask))
    of_grids = grid_uncertainty(np.array(resolutions), np.array(ratios)[:, None])
    normal = face_rule(effort, rule=EQUAL_AREA)
    stated, true = stiffness_ratio(poisson_ratio) * normal.stated, ratios[-1] * normal.true
    bar = float(of_grids[0]) + normal.uncertainty
    details = {"k_x/k_z of the half-space": ratios[-1], "error of k_z": normal.error}
    return Finding(stated, true, bar * (1 + abs(stated / true - 1)), details)


EXACT = 1e-12
# Incompressible: normal and tangential tractions are uncoupled. E* = R = 1.
_POISSON, _SHEAR_MODULUS, _FRICTION = 0.5, 0.25, 0.5
_MODULUS = tangential_modulus(_SHEAR_MODULUS, _POISSON)
_DEPTH = 0.01  # over the radius of the ball; forces are scaled, so the value is arbitrary
_SPRINGS = 2001  # enough for a discretisation error far below that of any grid
# Cells per contact radius and steps of the path, coarse and fine: their difference is the bar.
_GRIDS: dict[Effort, tuple[tuple[int, int], ...]] = {
    "quick": ((8, 6), (16, 12)),
    "full": ((16, 16), (32, 32)),
}


@experiment("stick-radius", "tangential force F_x/(mu F)")
def stick_radius(
    effort: str,
    *,
    share: Fraction = 0.5,
) -> Finding:
    """Length of the springs that stick against the stick radius in closed form.

    Half their length under a paraboloid, F_x = share mu F. The reference is Cattaneo's and
    Mindlin's.
    """
    form = closed_form.power_law(2.0, 1.0, 1.0)
    exact = closed_form.PartialSlip(form, _DEPTH, friction=_FRICTION, modulus_ratio=_MODULUS)
    path = exact.along([share * exact.limit])
    profile = equivalents.power_law(2.0, 1.0)
    springs, finer = (
        slide(
            Springs(profile, 1.0, per_radius=count),
            Friction(_MODULUS, _FRICTION),
            Load("penetration", _DEPTH),
            LoadPath("tangential_force", path.tangential_force),
        ).stick_length[0]
        / 2
        for count in ((40, 80) if effort == "quick" else (80, 160))
    )
    true = float(path.stick_radius[0])
    details = {
        "displacement over that at which all slides": float(
            path.tangential_displacement[0] / exact.sliding_displacement
        ),
    }
    return Finding(float(finer), true, float(abs(finer - springs) / true) + EXACT, details)


@experiment("changing-load", "last penetration over the first")
def changing_load(
    effort: Effort,
    *,
    final: Positive = 0.5,
) -> Finding:
    """Tangential force on a ball that is pushed while its depth changes, against the half-space.

    The ball is pressed in, then displaced by half the displacement of full sliding, while the
    depth changes to `final` times its value. The difference is relative to mu F. Springs take
    the path in one proportional step, the half-space in steps that halve with the cells.
    """
    radius = float(np.sqrt(_DEPTH * max(final, 1.0)))

    def way(steps: int) -> tuple[np.ndarray, np.ndarray]:
        """Return depth and displacement: pressed in one step, then proportional changes."""
        part = np.linspace(0.0, 1.0, steps + 1)
        limit = _FRICTION * _DEPTH / _MODULUS  # displacement of full sliding at the first depth
        return _DEPTH * (1 + (final - 1) * part), 0.5 * limit * part

    x = np.linspace(-1.05 * radius, 1.05 * radius, _SPRINGS)
    springs = follow(x**2, x[1] - x[0], 1.0, Friction(_MODULUS, _FRICTION), *way(1))
    stated = springs.tangential_force[-1] / (_FRICTION * springs.force[-1])
    shares = []
    for cells, steps in _GRIDS[effort]:
        spacing = float(np.sqrt(_DEPTH)) / cells
        count = 2 * int(np.ceil(1.1 * radius / spacing))
        side = (np.arange(count) - (count - 1) / 2) * spacing
        compliance = Compliance.of(_SHEAR_MODULUS, _POISSON)
        body = NormalAndTangential((count, count), (spacing, spacing), compliance)
        depth, shift = way(steps)
        *_, last = sweep(
            FrictionalPress(body, (side[:, None] ** 2 + side**2) / 2, _FRICTION),
            reference_loads.LoadPath("penetration", depth),
            reference_loads.LoadPath("tangential_displacement", shift),
        )
        shares.append(last.tangential_force / (_FRICTION * last.force))
    details = {
        "share of the springs that stick": float(
            springs.stick_length[-1] / springs.contact_length[-1]
        ),
    }
    bar = SAFE * abs(shares[1] - shares[0])
    return Finding(float(stated), shares[1], bar + EXACT, details, of=1)


# Steps of the tangential force as fractions.
_PARTS = np.array([1 / 3, 2 / 3, 1.0])
_TOLERANCE = 1e-5
_COUNTS: dict[Effort, tuple[int, int]] = {"quick": (36, 300), "full": (1200, 4000)}


@shared(maxsize=256)
def slip_of_surface(
    surface: Surface, load: float, share: float, realisation: int, factor: int
) -> float:
    """Return the tangential displacement of a surface at F_x = share mu F."""
    points = surface.points * factor
    compliance = Compliance.of(_SHEAR_MODULUS, _POISSON)
    body = NormalAndTangential((points,) * 2, (1 / points,) * 2, compliance)
    heights = surface.heights(realisation, factor)
    press = FrictionalPress(body, heights.max() - heights, _FRICTION)
    path = reference_loads.LoadPath("tangential_force", share * _FRICTION * load * _PARTS)
    stays = reference_loads.LoadPath("force", load)
    *_, last = sweep(press, stays, path, tolerance=_TOLERANCE)
    return last.tangential_displacement


def slip_of_lines(surface: Surface, load: float, share: float, count: int) -> np.ndarray:
    """Return the tangential displacements of lines with the same spectrum."""
    friction = Friction(_MODULUS, _FRICTION)
    path = LoadPath("tangential_force", share * _FRICTION * load)
    answer = slide_lines(surface.lines(count, 4).draw(), 1.0, friction, Load("force", load), path)
    return answer.tangential_displacement[:, -1]


@experiment("rough-slip", "tangential force F_x/(mu F)")
def rough_slip(
    effort: Effort,
    *,
    share: Positive = 0.9,
    load: Positive = 0.02,
    surface: Surface = Surface(48, roll_off=2.0, shortest=6.0),
) -> Finding:
    """Tangential displacement of lines on springs that slip, against rough surfaces.

    Means at F_x = share mu F. Surfaces with H = 0.8, waves of a half to an eighth of the side.
    Sources of the bar: the scatter of both ensembles, and the grid.
    """
    if not share < 1:
        raise ValueError(f"share must be below 1, where the contact slides, not {share!r}")
    surfaces, count = _COUNTS[effort]

    def sample(factor: int, number: int) -> np.ndarray:
        return np.array([slip_of_surface(surface, load, share, k, factor) for k in range(number)])

    true, grid_bar = truth(sample, surfaces, effort)
    details = {
        "surfaces": float(surfaces),
        "lines": float(count),
        "bar: grid": grid_bar,
    }
    return compare(slip_of_lines(surface, load, share, count), true, grid_bar, details)


# Springs over the first contact radius: what touches in the end is at most pi/2 as wide (a cone).
_BEYOND = 1.6


@experiment("fretting-limit", "G* U/(mu E* d)")
def fretting_limit(
    effort: Effort, *, lag: float = 0.5, shape: Literal["paraboloid", "cone"] = "paraboloid"
) -> Finding:
    """Force after many cycles of fretting against that of the limit shape.

    On springs; half as many give the bar. `lag` is G* U/(mu E* d). All have k = E* = d = 1; the
    stick circle is that of d - lag, and k E* U n is six contact radii of a paraboloid.
    """
    limit = FrettingLimit(getattr(closed_form, shape)(1.0, 1.0), 1.0, lag)
    profile = getattr(equivalents, shape)(1.0)
    load, cycles, swing = Load("penetration", 1.0), np.array([6.0]), Oscillation(1.0, lag)

    def worn(number: int) -> float:
        """Return the force on so many springs in the stick radius."""
        spacing = limit.stick_radius / number
        count = int(np.ceil(float(profile.contact_radius(1.0)) * _BEYOND / spacing))
        (state,) = wear(RoundBody(profile, count * spacing, count), 1.0, load, 1.0, cycles, swing)
        return state.force

    finest = 8 if effort == "quick" else 16
    fine, coarse = (worn(n) for n in (finest, finest // 2))
    return Finding(fine, limit.force, abs(fine - coarse) / limit.force, {})
