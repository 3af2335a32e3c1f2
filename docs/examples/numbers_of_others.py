"""Hold numbers that CONTACT prints against the suite's solvers: the tables of docs/other-codes.md.

The data stay where they are: a folder with ``contact_cmcc/cases.csv``, the printed results of
CONTACT's examples (Vollebregt & Kalker; as of July 2025), of which two cases in three are stored.
Run from the repository's root; all examples or those that are named; ``--cases`` prints every
number that differs. ``limits`` solves examples on finer cells, and ``1``, ``2`` or ``4`` CONTACT's
timing of that name::

    python docs/examples/numbers_of_others.py FOLDER NAME --cases
"""

# %%
import csv
import sys
import tomllib
from collections.abc import Iterator
from decimal import Decimal
from itertools import islice
from pathlib import Path
from time import process_time
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, root
from scipy.special import ellipe, ellipk
from threadpoolctl import threadpool_limits

from comparisons.judging.uncertainty import grid_uncertainty
from reference.contact.press import press
from reference.elasticity import largest_shear, von_mises
from reference.halfspace.friction import FrictionalPress, FrictionStep, slide_inside, sweep
from reference.halfspace.stress_below import stress_below
from reference.halfspace.traction import Compliance, NormalAndTangential, cell_integrals
from reference.loads import Load, LoadPath
from reference.rolling.roll import Creep, RollingStep, Upstream, rigid_slip, roll, steady

Values = dict[str, float]  # by columns of the file, as sizes; N, mm, J, and W or J of friction
JOULE = 1e-3  # N mm
MORE = Path(__file__).with_suffix(".toml")


class Number(NamedTuple):
    """A printed number and ours."""

    case: int
    column: str
    printed: str
    ours: float

    @property
    def digit(self) -> float:
        """A unit of the last printed digit."""
        return 10.0 ** Decimal(self.printed).as_tuple().exponent

    @property
    def off(self) -> float:
        """The difference in units of the last printed digit."""
        return (abs(self.ours) - abs(float(self.printed))) / self.digit

    @property
    def agrees(self) -> bool:
        """Whether ours is printed alike; 1 % of a digit for halves."""
        return abs(self.off) <= 0.51


def grid(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    body: Compliance,
    middle: float = 0.0,
    fine: int = 1,
) -> tuple[NormalAndTangential, np.ndarray, np.ndarray]:
    """Return a half-space, and x and y of its cells around a middle.

    Cells are divided by `fine` each way, but for a single row of a cylinder.
    """
    parts = [1 if n == 1 else fine for n in shape]
    shape = (shape[0] * parts[0], shape[1] * parts[1])
    spacing = (spacing[0] / parts[0], spacing[1] / parts[1])
    x, y = ((np.arange(n) - (n - 1) / 2) * d + middle for n, d in zip(shape, spacing, strict=True))
    return NormalAndTangential(shape, spacing, body), x[:, None], y


def energy(
    body: NormalAndTangential, pressure: np.ndarray, traction: np.ndarray, coupled: bool = False
) -> float:
    """Return the elastic energy in J."""
    moved = body.shear(traction) + (2 * body.drag(pressure) if coupled else 0.0)
    work = (pressure * body.normal.apply(pressure)).sum() + (traction * moved).sum()
    return 0.5 * JOULE * work * body.cell_area


def cells(pressure: np.ndarray, sticking: np.ndarray) -> Values:
    """Return the numbers of cells, and the largest pressure."""
    loaded, stuck = int((pressure > 0).sum()), int(sticking.sum())
    return {"pmax": pressure.max(), "NCON": loaded, "NADH": stuck, "NSLIP": loaded - stuck}


def pulled(body: NormalAndTangential, step: FrictionStep) -> Values:
    """Return what is printed of a ball pulled once."""
    return {
        "elastic_energy": energy(body, step.pressure, step.traction),
        "friction_power_or_work": JOULE * step.dissipation,
        "approach_mm": step.penetration,
        **cells(step.pressure, step.sticking),
    }


def rolled(body: NormalAndTangential, step: RollingStep, speed: float, coupled: bool) -> Values:
    """Return what is printed of a roller, the speed in m/s."""
    return {
        "elastic_energy": energy(body, step.pressure, step.traction, coupled),
        "friction_power_or_work": speed * step.loss,
        "approach_mm": step.penetration,
        **cells(step.pressure, step.sticking),
    }


# %% [markdown]
# Bodies of equal constants, of which neither pressure nor tractions move the other's points: half
# the shear modulus of one.


# %%
def cattaneo(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Pull a ball by 7/8 of its friction: R 50, G 200, nu 0.42, mu 0.4."""
    body, x, y = grid((17, 17), (2 / 15, 2 / 15), Compliance.of(100.0, 0.42), fine=fine)
    ball = FrictionalPress(body, (x**2 + y**2) / 100, 0.4, coupled=False)
    pulls = LoadPath("tangential_force", [0.0, 0.35 * 9.1954])
    steps = sweep(ball, LoadPath("force", 9.1954), pulls, tolerance=1e-9)
    for case, step in enumerate(steps, 1):
        yield case, pulled(body, step) | {"col2": step.tangential_displacement}


def catt_to_cart(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Roll from Cattaneo's state to Carter's under constant forces: G 1, nu 0.28, mu 0.4013.

    The first of three runs prescribes the normal force, in coordinates that move with the contact;
    the other two, which are one problem, in coordinates at rest, the approach after their first
    case: there the rigid shift per step is printed, in the first the creep.
    """
    body, x, y = grid((34, 33), (0.25, 0.25), Compliance.of(0.5, 0.28), fine=fine)
    gap, mu, step = 0.002963 * ((x - 0.125) ** 2 + y**2), 0.4013, 0.25
    held = press(body.normal, gap, Load("force", 0.4705), tolerance=1e-10)
    moved = press(body.normal, gap, Load("penetration", 0.07258), tolerance=1e-10)
    for first, contacts in ((1, [held] * 57), (58, [held] + [moved] * 56)):
        before = traction = np.zeros((2, *body.shape))
        for place, contact in enumerate(contacts):
            pull = 0.657 * mu * contact.force
            shift = work = 0.0
            for _ in range(fine if place else 1):  # by a cell each
                solved = slide_inside(
                    body, mu * contact.pressure, before, pull / body.cell_area, traction, 1e-9
                )
                traction = solved.traction
                shift += solved.shift
                work += JOULE * (traction * solved.slip).sum() * body.cell_area
                before = np.zeros_like(before)
                before[:, :-1] = solved.displacement[:, 1:]
            rolled = place > 0 and first == 1
            sticking = contact.mask & ~solved.sliding
            values = {
                "col2": shift / (step if rolled else 1),
                "elastic_energy": energy(body, contact.pressure, traction),
                "friction_power_or_work": work * (1.0 / (JOULE * step) if rolled else 1.0),
                "approach_mm": contact.penetration,
                **cells(contact.pressure, sticking),
            }
            yield first + place, values
            if first > 1:
                yield first + 57 + place, values  # printed twice


CREEPS = (1e-5, *np.arange(1, 16) * 4e-4, 0.008, *np.arange(1, 6) / 100, *np.arange(3, 11) / 40)


def tractcurv(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Roll a wheel at growing creep: F 106.7 kN, R 625, a/b 0.5, G 82 GPa, nu 0.28, mu 0.33."""
    return traction_curve(48, fine)


def euro_tractcurv(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Roll the same wheel, on 44 cells along the rolling direction."""
    return traction_curve(44, fine)


def traction_curve(count: int, fine: int) -> Iterator[tuple[int, Values]]:
    """Roll at 10 m/s.

    The grid spans 1.1 times the ellipse of Hertz (Johnson 1985, eqs. (3.65)), which follows from
    the curvature along x, a/b and the force, 1.0001 of which is found on cells.
    """
    steel, force, curvature, ratio = Compliance.of(41000.0, 0.28), 106.7e3, 0.8e-3, 0.5
    m = 1 - ratio**2
    k, e = ellipk(m), ellipe(m)
    across = e / ratio**2 - k
    a = np.cbrt(
        3 * force * ratio**3 * across / (2 * np.pi * steel.effective_modulus * m * curvature)
    )
    other = curvature * (k - e) / across
    body, x, y = grid((count, 44), (2.2 * a / count, 2.2 * a / ratio / 44), steel, fine=fine)
    wheel = FrictionalPress(body, curvature * x**2 + other * y**2, 0.33, coupled=False)
    for case, step in enumerate(roll(wheel, Load("force", force), map(Creep, CREEPS)), 1):
        driven = {"FX": step.tangential_force, "col2": step.tangential_force / (0.33 * step.force)}
        yield case, rolled(body, step, 10.0, coupled=False) | driven


def bank(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Pull a ball by a shift (case 1) and a force (10), on steel; roll one steadily (7)."""
    for case, side, normal, tangential in (
        (1, 0.13333, ("penetration", 0.01131), ("tangential_displacement", 0.00304)),
        (10, 2.26666 / 17, ("force", 1722.0), ("tangential_force", 0.875 * 0.3 * 1722.0)),
    ):
        body, x, y = grid((17, 17), (side, side), Compliance.of(41000.0, 0.28), fine=fine)
        ball = FrictionalPress(body, 0.0056566 * (x**2 + y**2), 0.3, coupled=False)
        (step,) = sweep(ball, LoadPath(*normal), LoadPath(*tangential), tolerance=1e-9)
        moved = {"col2": step.tangential_displacement} if case == 10 else {}
        yield case, pulled(body, step) | {"FX": step.tangential_force} | moved
    body, x, y = grid((41, 41), (0.2, 0.2), Compliance.of(0.5, 0.28), fine=fine)
    ball = FrictionalPress(body, 0.002963 * (x**2 + y**2), 0.4013, coupled=False)
    (step,) = roll(ball, Load("force", 0.4705), [Creep(0.00304)])
    driven = {"FX": step.tangential_force, "col2": step.tangential_force / (0.4013 * step.force)}
    yield 7, rolled(body, step, 1.0, coupled=False) | driven


def carter2d(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Roll a cylinder of radius 500 at a creep of 0.024 %: Carter's problem, a = 1."""
    body, x, y = grid((55, 1), (0.04, 200.0), Compliance.of(41000.0, 0.28), 0.03, fine)
    cylinder = FrictionalPress(body, 0.001 * x**2 + 0 * y, 0.3, coupled=False)
    (step,) = roll(cylinder, Load("force", 35780.0), [Creep(-0.00024)], tolerance=1e-9)
    driven = {"FX": step.tangential_force, "col2": step.tangential_force / (0.3 * step.force)}
    yield 1, rolled(body, step, 30.0, coupled=False) | driven


SPIN = 0.000625  # 1/mm, and the lateral creep
# Flexibilities of CONTACT's FASTSIM as it prints them, by creep along and across and by spin.
FLEXIBLE = np.array([0.4937e-4, 0.5152e-4, 0.4090e-4])


def fastsim(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Roll with spin: an ellipse of 8 x 4 under 82 kN, on the half-space (case 1) and springs."""
    body, x, y = grid((44, 44), (0.4, 0.2), Compliance.of(41000.0, 0.28), fine=fine)
    wheel = FrictionalPress(body, 0.8464e-3 * x**2 + 0.2406e-2 * y**2, 0.3, coupled=False)
    (step,) = roll(wheel, Load("force", 82e3), [Creep(0.0, -SPIN, SPIN)])
    turned = {"FY": step.lateral_force, "MZ": step.moment}
    yield 1, rolled(body, step, 30.0, coupled=False) | turned
    for case, count, parabolic in ((2, 44, True), (3, 44, False), (5, 220, True), (6, 220, False)):
        yield case, on_springs(fine * count, parabolic)
    yield 8, on_springs(fine * 220, True)  # the mirror image of case 5


def on_springs(count: int, parabolic: bool) -> Values:
    """Follow the rows of cells from the leading edge, by the printed flexibilities.

    The bound is a parabola or Hertz's ellipse; spin is taken a sixth of a cell ahead.
    """
    a, b, force, friction = 8.0, 4.0, 82e3, 0.3
    dx, dy = 2.2 * a / count, 2.2 * b / count
    x, y = ((np.arange(count) - (count - 1) / 2) * side for side in (dx, dy))
    left = np.maximum(1 - (x[:, None] / a) ** 2 - (y / b) ** 2, 0.0)
    shape = 2 * left if parabolic else 1.5 * np.sqrt(left)
    bound = friction * force / (np.pi * a * b) * shape
    traction, slip = np.zeros((2, 2, count, count))
    before = np.zeros((2, count))
    for row in reversed(range(count)):
        across = -SPIN / FLEXIBLE[1] + SPIN * (x[row] + dx / 6) / FLEXIBLE[2]
        stuck = before + dx * np.stack([-SPIN * y / FLEXIBLE[2], np.full(count, across)])
        share = np.minimum(1.0, bound[row] / np.hypot(*stuck))
        before = stuck * share
        traction[:, row], slip[:, row] = before, (1 - share) * stuck * FLEXIBLE[:2, None] / dx
    moment = (x[:, None] * traction[1] - y * traction[0]).sum() * dx * dy
    sliding = np.hypot(*slip) > 0
    return {
        "FY": traction[1].sum() * dx * dy,
        "MZ": moment,
        "friction_power_or_work": 30.0 * (traction * slip)[:, bound > 0].sum() * dx * dy,
        **cells(bound / friction, (bound > 0) & ~sliding),
    }


def subsurf() -> Iterator[tuple[int, Values]]:
    """Press a unit square uniformly, and pull it: G 1, nu 0.28; stresses below the pressure."""
    body, _, _ = grid((1, 1), (1.0, 1.0), Compliance.of(0.5, 0.28))
    pressure, traction = np.ones((1, 1)), np.zeros((2, 1, 1))
    one = {"approach_mm": float(body.normal.apply(pressure)[0, 0]), "pmax": 1.0}
    yield 1, one | {"elastic_energy": energy(body, pressure, traction)} | stresses()
    traction[0] = 0.999
    free, _, _ = grid((2, 1), (1.0, 1.0), Compliance.of(0.5, 0.28))
    moved = free.shear(np.pad(traction, ((0, 0), (0, 1), (0, 0))))[0, :, 0]
    pulled_too = {"col2": moved[0] - moved[1], "elastic_energy": energy(body, pressure, traction)}
    yield 2, one | pulled_too


def stresses() -> Values:
    """Return the extremes on the axis of the square (block 1) and on cells of 0.2 (block 2)."""
    pressure = np.pad(np.ones((5, 5)), 8)  # centres at multiples of 0.2, where CONTACT has points
    depths = (1e-6, *np.arange(1, 11) / 10, 1.25, 1.667, 2.5, 5.0)
    field = np.array([stress_below(pressure, (0.2, 0.2), z, 0.28) for z in depths])
    values = {}
    for block, part in ((1, field[:, :, 10:11, 10:11]), (2, field)):
        stress = np.moveaxis(part, 1, -1)
        principal = np.linalg.eigvalsh(stress[..., [[0, 5, 4], [5, 1, 3], [4, 3, 2]]])
        values |= {
            f"SIGHYD {block}": np.abs(principal.mean(axis=-1)).max(),
            f"SIGVM {block}": von_mises(stress).max(),
            f"SIGTR {block}": 2 * largest_shear(stress).max(),
            f"SIGMA1 {block}": principal.max(),
            f"SIGMA3 {block}": -principal.min(),
        }
        values |= {
            f"SIG{axis * 2} {block}": np.abs(stress[..., place]).max()
            for place, axis in enumerate("XYZ")
        }
    return values


def visc_cylindr(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Roll cylinders of PA6 that relax, driven by 0.6 of the friction: G 1143, nu 0.4, R 100.

    The creep function is (2 - exp(-t/tau))/G: the displacement is that of the pressure now, and of
    the pressures that a point has met, 1/(V tau) exp(-s/(V tau)) of those at a way s. The cells are
    solved densely, contact and slip by changing sets.
    """
    count, dx, dy, force, friction = 99 * fine, 0.16 / fine, 1000.0, 6e5, 0.3
    place = np.arange(count)
    gap = 0.01 * (dx * (place - (count - 1) / 2) - 0.08) ** 2
    offsets = place[:, None] - place + count + 1
    for case, way in ((1, 0.0), (2, 9.0), (3, 45.0), (4, 2000.0), (5, 0.0), (6, np.inf)):
        normal, along = relaxed(np.arange(-count - 1, count + 2), dx, dy, way)
        body, shear = normal[offsets], along[offsets]
        flow = shear - along[offsets + 1]
        inside = np.ones(count, dtype=bool)
        for _ in range(100):
            (pressure, approach) = held(body, -gap, inside, force / (dx * dy), -1.0)
            new = (pressure > 0) | (~inside & (body @ pressure + gap < approach))
            if (new == inside).all():
                break
            inside = new
        bound, sticking = friction * pressure, inside.copy()
        for _ in range(100):
            slipping = np.where(sticking, 0.0, bound)
            pull = 0.6 * friction * force / (dx * dy) - slipping.sum()
            stuck, creep = held(flow, -flow @ slipping, sticking, pull, -dx)
            traction = stuck + slipping
            slip = creep * dx - flow @ traction
            new = inside & np.where(sticking, traction <= bound, slip < 0)
            if (new == sticking).all():
                break
            sticking = new
        work = pressure @ body @ pressure + traction @ shear @ traction
        yield (
            case,
            {
                "col2": creep,
                "elastic_energy": 0.5 * JOULE * work * dx * dy,
                "friction_power_or_work": (traction * slip)[~sticking].sum() * dy,
                "approach_mm": approach,
                **cells(pressure, sticking),
            },
        )


def held(
    matrix: np.ndarray, right: np.ndarray, inside: np.ndarray, total: float, rigid: float
) -> tuple[np.ndarray, float]:
    """Solve M t + rigid c = right inside, where t is not zero and has this sum; return t and c."""
    size = int(inside.sum())
    system = np.zeros((size + 1, size + 1))
    system[:size, :size] = matrix[np.ix_(inside, inside)]
    system[:size, size], system[size, :size] = rigid, 1.0
    solved = np.linalg.solve(system, np.append(right[inside], total))
    values = np.zeros(inside.size)
    values[inside] = solved[:size]
    return values, float(solved[size])


def relaxed(places: np.ndarray, dx: float, dy: float, way: float) -> np.ndarray:
    """Return displacements by unit pressure and traction on a cell, at offsets in cells.

    `way` is V tau. The past is summed from far away on, in halves of cells.
    """
    polyamide = Compliance.of(1143.0 / 2, 0.4)

    def now(x: np.ndarray) -> np.ndarray:
        cell = cell_integrals(np.abs(x) / dx, np.zeros_like(x), (dx, dy))
        both = polyamide.normal * (cell.xx + cell.yy)
        return np.array([both, both + polyamide.lateral * cell.xx]) / (2 * np.pi)

    def passed(start: float, edges: np.ndarray) -> np.ndarray:
        """Integrate over the ways between the edges."""
        half, middle = np.diff(edges)[:, None] / 2, (edges[1:] + edges[:-1])[:, None] / 2
        s = middle + half * nodes
        return np.array((now(start + s) * np.exp(-s / way) / way * weights * half).sum((1, 2)))

    present = now(dx * places.astype(float))
    if way in (0.0, np.inf):
        return present * (2.0 if way == 0 else 1.0)
    nodes, weights = np.polynomial.legendre.leggauss(8)
    past = np.zeros_like(present)
    far = np.append(0.0, np.geomspace(dx, 60 * way, 400))
    past[:, -1] = passed(dx * places[-1], far)
    for k in reversed(range(places.size - 1)):
        near = passed(dx * places[k], np.array([0.0, dx / 2, dx]))
        past[:, k] = past[:, k + 1] * np.exp(-dx / way) + near
    return present + past


# %% [markdown]
# Bodies of different constants: pressure and friction act on each other.


# %%
def spence35(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Press a rigid ball in 35 stages into a half-space that sticks and slips: G 1/2, nu 0.

    Stages are divided as cells are.
    """
    soft, stiff = Compliance.of(0.5, 0.0), Compliance.of(1e5, 0.0)
    both = Compliance(soft.normal + stiff.normal, 0.0, soft.coupling - stiff.coupling)
    body, x, y = grid((45, 45), (0.2, 0.2), both, 1e-4, fine)
    ball = FrictionalPress(body, 0.004116 * (x**2 + y**2), 0.2986)
    forces = (np.arange(1, 35 * fine + 1) / fine / 45) ** 3
    forces[fine - 1 :: fine] = np.round(forces[fine - 1 :: fine], 6)
    steps = sweep(
        ball, LoadPath("force", forces), LoadPath("tangential_displacement", 0.0), tolerance=1e-8
    )
    lost = 0.0
    for case, step in enumerate(islice(steps, fine - 1, None, fine), 1):
        yield (
            case,
            {
                "elastic_energy": energy(body, step.pressure, step.traction, coupled=True),
                "friction_power_or_work": JOULE * (step.dissipation - lost),
                "approach_mm": step.penetration,
                **cells(step.pressure, step.sticking),
            },
        )
        lost = step.dissipation


def bentall(fine: int = 1) -> Iterator[tuple[int, Values]]:
    """Roll a cylinder of aluminium on one of steel, of radius 50, freely or driven (cases 5, 6)."""
    soft, stiff = Compliance.of(23000.0, 0.31), Compliance.of(82000.0, 0.28)
    both = Compliance(
        soft.normal + stiff.normal, soft.lateral + stiff.lateral, soft.coupling - stiff.coupling
    )
    body, x, y = grid((216, 1), (0.001, 1000.0), both, fine=fine)
    for case, friction, share, least in (
        (2, 1e-4, 0.0, 3.5e-4),
        (3, 10.0, 0.0, 3.5e-4),  # none slips; slower creeps do not converge
        (4, 0.05, 0.0, 3.5e-4),
        (5, 0.05, -0.75, 1e-4),
        (6, 0.05, 0.75, 3.5e-4),
    ):
        if fine > 1 and friction > 1:
            continue  # where nothing slips, normal and tangential problem in turn diverge
        cylinder = FrictionalPress(body, 0.02 * x**2 + 0 * y, friction)

        def at(creep: float, cylinder: FrictionalPress = cylinder) -> RollingStep:
            (step,) = roll(cylinder, Load("force", 16201.9), [Creep(creep)], tolerance=1e-9)
            return step

        def missing(creep: float, pull: float = share * friction * 16201.9) -> float:
            return at(creep).tangential_force - pull

        creep = brentq(missing, least, 6e-4, xtol=1e-11)
        yield case, rolled(body, at(creep), 1.0, coupled=True) | {"col2": creep}


def wheel(parts: int) -> str:
    """Roll a wheel of a measured profile with spin under given forces, and tell how long it took.

    The problem of CONTACT's timings ``tang_problm_1f``, ``2f`` and ``4f``, by `parts`: what is
    sought are the creeps of Fx = 0.573 and Fy = 0.327 of the friction. CONTACT stops at 1e-7.
    """
    began, friction, spin, side = process_time(), 0.3, 3e-4, 0.1 / parts
    x, y = (
        first + (np.arange(n) + 0.5) * side
        for first, n in ((-3.55, 72 * parts - 1), (-6.15, {1: 81, 2: 161, 4: 323}[parts]))
    )
    heights = tomllib.loads(MORE.read_text(encoding="utf-8"))["profile"]
    gap = x[:, None] ** 2 / (2 * 483.931) + np.interp(y, -12 + 0.1 * np.arange(271), heights)
    body = NormalAndTangential(gap.shape, (side, side), Compliance.of(41000.0, 0.28))
    deep = Load("penetration", 0.02084 - gap.min())
    contact = press(body.normal, gap - gap.min(), deep, tolerance=1e-7)
    flow, bound, solved = Upstream(body, body.shape), friction * contact.pressure, []

    def missing(creep: np.ndarray) -> np.ndarray:
        """Return the forces that are missing; creeps are those at the origin, in 1e-3."""
        along, across = 1e-3 * creep + spin * np.array([-y.mean(), x.mean()])
        rigid = rigid_slip(Creep(along, across, spin), body.shape, body.spacing)
        start = solved[-1].traction if solved else None
        solved.append(steady(flow, bound, rigid, start, 1e-7))
        return solved[-1].traction.sum(axis=(1, 2)) / bound.sum() - [0.573, 0.327]

    creeps = root(missing, [0.3, 0.3], options={"xtol": 1e-6, "eps": 1e-3}).x
    cells = f"{(bound > 0).sum()} cells in contact, {solved[-1].sliding.sum()} slip"
    work = f"{sum(one.rounds for one in solved)} rounds, {process_time() - began:.1f} s"
    return f"{cells}: creeps {creeps[0]:.4f} and {creeps[1]:.4f} per mille, {work} of the processor"


# %%
EXAMPLES = {
    "examples/cattaneo": cattaneo,
    "examples/catt_to_cart": catt_to_cart,
    "examples/spence35": spence35,
    "examples/bentall": bentall,
    "examples/carter2d": carter2d,
    "examples/fastsim": fastsim,
    "examples/visc_cylindr": visc_cylindr,
    "examples/subsurf": subsurf,
    "examples/tractcurv": tractcurv,
    "testbank/examples_temp/euro_tractcurv": euro_tractcurv,
    "testbank/testbank": bank,
}
NO_LIMIT = ("examples/subsurf", "testbank/examples_temp/euro_tractcurv")  # no cells; as tractcurv
CYLINDERS = ("examples/bentall", "examples/carter2d", "examples/visc_cylindr")


def compared(folder: Path, example: str, ours: dict[int, Values] | None = None) -> list[Number]:
    """Return the numbers of an example that are printed and not zero; `ours` by cases."""
    with (folder / "contact_cmcc" / "cases.csv").open(encoding="utf-8") as stream:
        rows = [row for row in csv.DictReader(stream) if row["file"] == f"{example}.ref_out"]
    printed = {int(row["case"]): row for row in rows}
    for case, more in tomllib.loads(MORE.read_text(encoding="utf-8")).get(example, {}).items():
        printed[int(case)] = printed.get(int(case), {}) | more
    return [
        Number(case, column, printed[case][column], float(value))
        for case, values in (ours or dict(EXAMPLES[example]())).items()
        if case in printed
        for column, value in values.items()
        if float(printed[case].get(column) or 0)
    ]


class Limit(NamedTuple):
    """A printed number, ours on cells of a third of the side, and its relative error bar."""

    number: Number
    ours: float
    bar: float

    @property
    def off(self) -> float:
        """How far the printed number is from ours, relatively."""
        return abs(float(self.number.printed)) / abs(self.ours) - 1

    @property
    def inside(self) -> bool:
        """Whether the printed number, as it is rounded, lies in the bar."""
        return abs(self.off) <= self.bar + 0.51 * self.number.digit / abs(self.ours)


def limits(folder: Path, example: str) -> list[Limit]:
    """Solve an example on its cells, their halves and their thirds; numbers of cells are areas.

    Error bars are the grid convergence index of each column over all cases.
    """
    parts = np.array([1, 2, 3])
    solved = [dict(EXAMPLES[example](fine)) for fine in parts]
    columns: dict[str, list[Number]] = {}
    for number in compared(folder, example, solved[0]):
        if number.case in solved[-1]:
            columns.setdefault(number.column, []).append(number)
    found = []
    for column, numbers in columns.items():
        curves = np.array([[ours[n.case][column] for n in numbers] for ours in solved], float)
        if column in ("NCON", "NADH", "NSLIP"):
            curves /= parts[:, None] ** (1 if example in CYLINDERS else 2)
        bars = grid_uncertainty(parts, curves)
        found += [Limit(*one) for one in zip(numbers, curves[-1], bars, strict=True)]
    return found


def limits_row(name: str, found: list[Limit]) -> str:
    """Return a line of the table of limits, of an example or of a column of all."""
    worst = max(found, key=lambda one: abs(one.off) - one.bar)
    off, bar = np.median([abs(one.off) for one in found]), np.median([one.bar for one in found])
    largest = f"{worst.off:+.2%} ± {worst.bar:.2%} ({worst.number.column} of {worst.number.case})"
    counts = [len(found), sum(one.inside for one in found)]
    texts = [f"| `{name}`", *map(str, counts), f"{off:.2%}", f"{bar:.2%}", largest, ""]
    return " | ".join(texts).strip()


def row(example: str, numbers: list[Number]) -> str:
    """Return a line of the table."""
    cases = {number.case for number in numbers}
    wrong = [number for number in numbers if not number.agrees]
    worst = max(wrong, key=lambda n: abs(n.off), default=None)
    largest = f"{worst.off:+.1f} ({worst.column} of case {worst.case})" if worst else ""
    equal = len(cases - {number.case for number in wrong})
    counts = [len(cases), equal, len(numbers), len(numbers) - len(wrong)]
    return " | ".join(["", f"`{example}`", *map(str, counts), largest, ""]).strip()


if __name__ == "__main__":
    threadpool_limits(limits=1)  # vectors are too short for threads
    source, *names = [word for word in sys.argv[1:] if word != "--cases"]
    folder, every = Path(source), "--cases" in sys.argv
    examples = [one for one in EXAMPLES if one.rsplit("/", 1)[-1] in names]
    if "limits" in names:
        print("| example | numbers | inside | off, median | error bar, median | farthest outside |")
        print("|---|---|---|---|---|---|")
        everything = []
        for example in examples or [one for one in EXAMPLES if one not in NO_LIMIT]:
            everything += (found := limits(folder, example))
            print(limits_row(example, found), flush=True)
            for (case, column, printed, _), ours, bar in found if every else []:
                print(f"  {case} {column}: {printed}, ours {ours:.6g} ± {bar:.3%}")
        for column in dict.fromkeys(one.number.column for one in everything):
            found = [one for one in everything if one.number.column == column]
            print(limits_row(column, found))
    elif examples or not names:
        print("| example | cases | all digits | numbers | equal | largest, last digits |")
        print("|---|---|---|---|---|---|")
        for example in examples or EXAMPLES:
            numbers = compared(folder, example)
            print(row(example, numbers), flush=True)
            for case, column, printed, ours in [n for n in numbers if every and not n.agrees]:
                print(f"  {case} {column}: {printed}, ours {ours:.8g}")
    for parts in [int(word) for word in names if word.isdecimal()]:
        print(wheel(parts))
