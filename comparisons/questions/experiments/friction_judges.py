"""Judges of friction from outside: Lubkin's torsion, Spence's pressing, an oblique impact.

All of a rigid ball on a half-space, R = 1; forces are scaled.
"""

from __future__ import annotations

from typing import Literal

import numpy as np
from scipy.integrate import cumulative_trapezoid
from scipy.optimize import brentq
from scipy.special import ellipkm1

from comparisons.judging.uncertainty import SAFE
from comparisons.questions.experiments.experiment import (
    Effort,
    Finding,
    Positive,
    experiment,
)
from comparisons.solving.shared import shared
from reduced.friction import slide as line_friction
from reduced.friction.slide import Friction, tangential_modulus
from reduced.profiles import equivalents
from reference.closed_form import paraboloid
from reference.closed_form.partial_slip import Torsion
from reference.contact.press import press
from reference.contact.slide import slide
from reference.halfspace.friction import FrictionalGrid, FrictionalPress, sweep
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.loads import Load, LoadPath

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
    stick: float = 0.5,
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
    if not 0 < stick <= 1:
        raise ValueError(f"stick must be above 0 and at most 1, not {stick!r}")
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
        pressure = press(half_space.normal, gap, Load("penetration", 1.0)).pressure
        along, across = np.meshgrid(x, x, indexing="ij")
        turned = angle * np.array([-across, along])
        grid = FrictionalGrid(half_space)
        q = slide(grid, FRICTION * pressure, turned, tolerance=1e-7).traction
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
        LoadPath("penetration", np.geomspace(0.02, 1.0, steps)),
        LoadPath("tangential_displacement", 0.0),
    )
    return float(np.sqrt(last.sticking.sum() / (last.pressure > 0).sum()))


@experiment("pressing-with-friction", "Poisson's ratio")
def pressing_with_friction(
    effort: Effort,
    *,
    poisson_ratio: float = 0.0,
    friction: Positive = 0.2986,
    statement: Literal["printed", "one_way"] = "printed",
) -> Finding:
    """What sticks of a rigid ball that is pressed into an elastic body with friction.

    ``"printed"``: half the contact radius at nu = 0 and mu = 0.2986 (Spence 1975, as CONTACT has
    it). ``"one_way"``: arctanh(s) = (mu/beta) s K'(s), beta = (1 - 2 nu)/(2 (1 - nu)), which leaves
    Hertz's pressure as it is; `friction` is mu at nu = 0, with mu/beta the same for every nu. Steps
    of pressing are extrapolated to first order; the bar is the change by it and by the cells.
    """
    if not -0.9 < poisson_ratio < 0.5:
        raise ValueError(f"poisson_ratio must be between -0.9 and 0.5, not {poisson_ratio!r}")
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
        force = line_friction.follow(*line, depth, shift).tangential_force
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
            LoadPath("penetration", depth[loaded] / scale),
            LoadPath("tangential_displacement", shift[loaded] / scale),
        )
        true = np.zeros(len(time))
        # depths scale with d, forces with d^1.5
        true[loaded] = np.array([step.tangential_force for step in way]) * scale**1.5
        most = FRICTION * 2.0  # mu times the normal impulse 2 m v
        impulses.append((np.trapezoid(force, time) / most, np.trapezoid(true, time) / most))
    (_, coarse), (stated, fine) = impulses
    bar = SAFE * abs(float((impulses[0][0] - coarse) - (stated - fine)))
    return Finding(float(stated), float(fine), bar, {}, of=1)
