"""Tangential loads (19.18), (19.19): sticking contacts, partial slip, and fretting (19.6).

Springs on the half-space, under smooth bodies and below rough surfaces; and judges from outside, of
a rigid ball on a half-space, R = 1: Lubkin's torsion, Spence's pressing, an oblique impact.
"""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq
from scipy.special import ellipkm1

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
    slide_lines,
    stiffness_ratio,
    tangential_modulus,
)
from reduced.loads import Load, LoadPath
from reduced.profiles import equivalents
from reduced.wear import Oscillation, RoundBody, wear
from reference import closed_form
from reference import loads as reference_loads
from reference.closed_form import paraboloid
from reference.closed_form.partial_slip import Torsion
from reference.closed_form.worn import FrettingLimit
from reference.contact import slide as friction_bound
from reference.contact.press import press
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


@experiment("changing-load", "last penetration over the first")
def changing_load(effort: Effort, *, final: Positive = 0.5) -> Finding:
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
        )
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


@experiment("rough-slip", "tangential force F_x/(mu F)")
def rough_slip(
    effort: Effort,
    *,
    share: Fraction = 0.9,
    load: Positive = 0.02,
    surface: Surface = Surface(48, roll_off=2.0, shortest=6.0),
) -> Finding:
    """Tangential displacement of lines on springs that slip, against rough surfaces.

    Means at F_x = share mu F. Surfaces with H = 0.8, waves of a half to an eighth of the side.
    Sources of the bar: the scatter of both ensembles, and the grid.
    """
    surfaces, count = _COUNTS[effort]

    def sample(factor: int, number: int) -> np.ndarray:
        return np.array([slip_of_surface(surface, load, share, k, factor) for k in range(number)])

    true, grid_bar = truth(sample, surfaces, effort)
    details = {"surfaces": float(surfaces), "lines": float(count), "bar: grid": grid_bar}
    # lines with the same spectrum
    friction, lines = Friction(_MODULUS, _FRICTION), surface.lines(count, 4).draw()
    path = LoadPath("tangential_force", share * _FRICTION * load)
    stated = slide_lines(lines, 1.0, friction, Load("force", load), path)
    return compare(stated.tangential_displacement[:, -1], true, grid_bar, details)


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


Array = np.ndarray
FRICTION = 0.3
# A solid ball without slip: m/(1 + m R^2/I) resists the tangential force.
_ROLLING_MASS = 2 / 7


def _grid(cells: int, shear: float, poisson: float) -> tuple[NormalAndTangential, Array, Array]:
    """Return half-space, coordinates and gap of a ball of contact radius 1 at d = 1."""
    count = 2 * int(np.ceil(1.08 * cells))
    x = (np.arange(count) - (count - 1) / 2) / cells
    body = NormalAndTangential((count, count), (1 / cells,) * 2, Compliance.of(shear, poisson))
    return body, x, (x[:, None] ** 2 + x**2) / 2


@experiment("torsion", "stick radius over contact radius c/a")
def torsion(
    effort: Effort,
    *,
    stick: Annotated[float, Field(gt=0, le=1)] = 0.5,
    statement: Literal["closed_form", "springs"] = "springs",
    poisson_ratio: float = 0.3,
) -> Finding:
    """Torque of a ball that is pressed on and twisted, with partial slip.

    Compare torques at the angle at which the share `stick` of the contact radius sticks.
    ``"closed_form"``: Lubkin's against cells with Coulomb friction; ``"springs"``: springs 8 G dx
    along the circumference that slip at mu times their force, against Lubkin's.

    The chapter has no rule for torsion. Springs that move by b x, at the distance x from the axis,
    carry the torque (16/3) G a^3 b of every round contact that sticks (Popov & Hess 2015; exact
    after Reissner & Sagoci 1944). Whether they may slip one by one, each at mu times its normal
    force, as under a force along x (19.19), is a question to them: in full slip they carry mu E*
    int 2 x (d - g) dx, where the half-space carries mu int r p dA.
    """
    body = Compliance.of(0.25, poisson_ratio)
    ball = Torsion(paraboloid(1.0, body.effective_modulus), 1.0, FRICTION, 0.25)
    angle, exact = ball.angle(stick), ball.torque(stick)
    if statement == "springs":
        profile, number = equivalents.paraboloid(1.0), 4000
        step = float(profile.contact_radius(1.0)) / number
        x = (np.arange(number) + 0.5) * step
        limit = FRICTION * body.effective_modulus * (1.0 - profile.height(x))
        held = 8 * 0.25 * angle * x
        torque = float(2 * step * np.minimum(held, limit) @ x)
        stuck = float(step * (held < limit).sum())
        return Finding(torque, exact, 1e-6, {"springs stick to": stuck})
    torques = []
    for cells in (12, 24) if effort == "quick" else (24, 48):
        half_space, x, gap = _grid(cells, 0.25, poisson_ratio)
        pressure = press(half_space.normal, gap, reference_loads.Load("penetration", 1.0)).pressure
        along, across = np.meshgrid(x, x, indexing="ij")
        turned = angle * np.array([-across, along])
        q = friction_bound.slide(half_space, FRICTION * pressure, turned, tolerance=1e-7).traction
        torques.append(float((along * q[1] - across * q[0]).sum()) * half_space.cell_area)
    coarse, fine = torques
    bar = exact / fine * SAFE * abs(fine - coarse) / fine
    return Finding(exact, fine, bar, {"angle": angle})


@shared(maxsize=32)
def _pressed(poisson: float, friction: float, cells: int, steps: int) -> float:
    """Return the share of the contact radius that sticks after pressing in geometric steps."""
    body, _, gap = _grid(cells, 0.25, poisson)
    *_, last = sweep(
        FrictionalPress(body, gap, friction),
        reference_loads.LoadPath("penetration", np.geomspace(0.02, 1.0, steps)),
        reference_loads.LoadPath("tangential_displacement", 0.0),
    )
    return float(np.sqrt(last.sticking.sum() / (last.pressure > 0).sum()))


@experiment("pressing-with-friction", "Poisson's ratio")
def pressing_with_friction(
    effort: Effort,
    *,
    poisson_ratio: Annotated[float, Field(gt=-0.9, lt=0.5)] = 0.0,
    friction: Positive = 0.2986,
    statement: Literal["printed", "one_way"] = "printed",
) -> Finding:
    """What sticks of a rigid ball that is pressed into an elastic body with friction.

    ``"printed"``: half the contact radius at nu = 0 and mu = 0.2986 (Spence 1975, as CONTACT has
    it). ``"one_way"``: arctanh(s) = (mu/beta) s K'(s), beta = (1 - 2 nu)/(2 (1 - nu)), which leaves
    Hertz's pressure as it is; `friction` is mu at nu = 0, with mu/beta the same for every nu. Steps
    of pressing are extrapolated to first order; the bar is the change by it and by the cells.
    """
    beta = (1 - 2 * poisson_ratio) / (2 * (1 - poisson_ratio))
    ratio = 2 * friction
    stated = 0.5
    if statement == "one_way":
        stated = brentq(lambda s: np.arctanh(s) / s - ratio * ellipkm1(s * s), 1e-3, 1 - 1e-9)
    cells, steps = (16, 30) if effort == "quick" else (40, 80)
    mu = ratio * beta
    half, fine, other = (
        _pressed(poisson_ratio, mu, *grid)
        for grid in ((cells, steps // 2), (cells, steps), (cells // 2, steps))
    )
    true = 2 * fine - half
    bar = stated / true * float(np.hypot(fine - half, fine - other)) / true
    return Finding(stated, true, bar, {})


def impact(
    incidence: float, steps: int, springs: int, poisson_ratio: float = 0.5
) -> tuple[Array, Array, Array, Array]:
    """Return time, depth, shift and tangential force of springs in an oblique impact.

    m = 1, E* = 1, R = 1, speed 1 along the normal, mu = 0.3; `incidence` is G* v_x/(mu E* v_z).
    The normal motion is Hertz's; the tangential one is found as a whole, by integrating its own
    force again and again.
    """
    modulus = 1.0
    deepest = (15 / (16 * modulus)) ** 0.4  # m v^2/2 = (8/15) E* sqrt(R) d^2.5
    s = np.sin(np.linspace(0, np.pi / 2, steps + 1))
    with np.errstate(divide="ignore", invalid="ignore"):
        rate = np.cos(np.linspace(0, np.pi / 2, steps + 1)) / np.sqrt(1 - s**2.5)
    rate[-1] = np.sqrt(0.8)
    half = deepest * cumulative_trapezoid(rate, np.linspace(0, np.pi / 2, steps + 1), initial=0)
    time = np.concatenate([half, 2 * half[-1] - half[-2::-1]])
    depth = deepest * np.concatenate([s, s[-2::-1]])
    friction = Friction(tangential_modulus((1 - poisson_ratio) / 2, poisson_ratio), FRICTION)
    speed = incidence * FRICTION * modulus / friction.tangential_modulus
    x = np.linspace(-1.02, 1.02, springs) * np.sqrt(deepest)
    line = x**2, float(x[1] - x[0]), modulus, friction
    shift = speed * time
    for _ in range(200):
        force = follow(*line, depth, shift).tangential_force
        velocity = speed - cumulative_trapezoid(force, time, initial=0) / _ROLLING_MASS
        moved = cumulative_trapezoid(velocity, time, initial=0)
        change = float(np.abs(moved - shift).max() / np.abs(moved).max())
        shift = moved
        if change < 1e-6:
            return time, depth, shift, force
    raise ArithmeticError(f"the impact did not converge: {change:.1e} of the way")


@experiment("oblique-impact", "angle of incidence G* v_x/(mu E* v_z)")
def oblique_impact(effort: Effort, *, incidence: Positive = 1.0) -> Finding:
    """Tangential impulse of an oblique impact on springs, against the half-space.

    A solid ball, incompressible; over mu times the normal impulse, on the path that the springs
    take: if the forces agree on it, it is the path of the half-space, too (Maw, Barber & Fawcett
    1976).
    """
    impulses = []
    for steps, cells in ((16, 8), (32, 16)) if effort == "quick" else ((32, 12), (64, 24)):
        time, depth, shift, force = impact(float(incidence), steps, 801)
        body, _, gap = _grid(cells, 0.25, 0.5)
        scale = depth.max()
        loaded = depth > 1e-3 * scale
        way = sweep(
            FrictionalPress(body, gap, FRICTION),
            reference_loads.LoadPath("penetration", depth[loaded] / scale),
            reference_loads.LoadPath("tangential_displacement", shift[loaded] / scale),
        )
        true = np.zeros(len(time))
        # depths scale with d, forces with d^1.5
        true[loaded] = np.array([step.tangential_force for step in way]) * scale**1.5
        most = FRICTION * 2.0  # mu times the normal impulse 2 m v
        impulses.append((np.trapezoid(force, time) / most, np.trapezoid(true, time) / most))
    (_, coarse), (stated, fine) = impulses
    bar = SAFE * abs(float((impulses[0][0] - coarse) - (stated - fine)))
    return Finding(float(stated), float(fine), bar, {}, of=1)
