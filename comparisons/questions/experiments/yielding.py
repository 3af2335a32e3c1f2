"""Yielding (19.6): springs and closed forms, first yield by stress rules, rough surfaces.

A ball of R = E = 1, nu = 0.3, Y = 1/500 is pressed into finite elements, to depths in units of that
at first yield. Rough surfaces that yield have a capped pressure: those of the scene
`plastic-rough`, under forces that are a share of H A0.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache
from typing import Annotated, Literal, cast

import numpy as np
from pydantic import Field
from scipy.optimize import brentq, minimize_scalar

from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.methods.plasticity.solids import AREA
from comparisons.questions.experiments.experiment import (
    Count,
    Effort,
    Finding,
    Positive,
    experiment,
    number_of,
    one_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    PeriodicSurface,
    Surface,
    compare,
    each_line,
    press,
    truth,
)
from comparisons.scene.physics.tables.plasticity import HARDNESS
from comparisons.scene.scene import load_scene
from comparisons.solving.shared import shared
from reduced.loads import LoadPath as SpringPath
from reduced.plasticity import Reading, Yielded, YieldingSprings, ZunkerKamrin
from reduced.profiles import equivalents
from reduced.rough import regions
from reduced.springs import stress
from reference.closed_form import ClosedForm, power_law, sphere
from reference.elasticity import Material
from reference.halfspace import PeriodicOperator
from reference.halfspace.areas import located_area
from reference.layered import Stack
from reference.layered.stresses import inside
from reference.loads import LoadPath
from reference.plastic import PlasticMaterial, Walk, yield_depth, yield_pressure
from reference.plastic.capped import along
from reference.plastic.dent_formulas import (
    cavity_pressure,
    johnson_restitution,
    thornton_restitution,
)

NU, YIELD_STRESS = 0.3, 1 / 500
MODULUS = 1 / (1 - NU**2)
_DEPTH = yield_depth(1.0, MODULUS, yield_pressure(NU) * YIELD_STRESS)
_WORK = 8 / 15 * MODULUS * _DEPTH**2.5
READINGS = ("stress", "elastic_root", "zunker_kamrin", "none")
_FORMULAS = {"thornton": "restitution", "johnson": "restitution", "cavity": "mean_pressure"}
# Elements per radius, two grids; what a ball gives back asks for finer ones: at 2 and 4 its bars
# miss that of 5 and 8.
_GRIDS: dict[Effort, tuple[int, int]] = {"quick": (2, 4), "full": (5, 8)}
_REBOUND_GRIDS: dict[Effort, tuple[int, int]] = {"quick": (3, 5), "full": (5, 8)}
_SPRINGS = 2000
# Steps of springs down and up again, for their work.
_STEPS = 200


@dataclass(frozen=True)
class Dented:
    """A ball in a half-space, R = E = 1."""

    force: float
    area: float
    residual_depth: float
    work: float = 0.0  # of the force
    # Square root of the share of it that is given back: that of an impact far below the speed of
    # sound.
    restitution: float = 1.0
    unknowns: int = 0  # of the finite elements

    @property
    def mean_pressure(self) -> float:
        """Force over area."""
        return self.force / self.area


@shared(maxsize=256)
def elements(depth: float, per_radius: int, *, rebound: bool = False) -> Dented:
    """Press the ball to a depth into finite elements; let it rebound on demand."""
    share = depth / _DEPTH
    radius = np.sqrt(depth * min(2.0, 1 + 0.25 * max(np.log10(share), 0.0) ** 1.2))
    steel = PlasticMaterial(Material(1.0, NU), YIELD_STRESS)
    walk = Walk(steel, lambda r: r**2 / 2, float(radius), per_radius=per_radius)
    (moment,) = walk.along(LoadPath("penetration", depth))
    back = walk.given_back(moment) if rebound else moment.work
    return Dented(
        *(moment.force, walk.contact_area(moment), walk.residual_depth(moment), moment.work),
        *(float(np.sqrt(back / moment.work)), walk.mesh.size),
    )


def known_to(quantity: str, grids: tuple[int, int], values: tuple[float, float]) -> float:
    """Return the bar of a value on the finer of two grids.

    Steps and elements err in proportion to their size (Richardson's rule of first order).
    """
    (few, many), (coarse, fine) = grids, values
    bar = abs(fine - coarse) / (many / few - 1)
    return max(bar, AREA / many * fine) if quantity in ("area", "mean_pressure") else bar


def springs(depth: float, reading: str) -> Dented:
    """Press the ball to a depth onto springs."""
    line = _walked(reading, np.array([depth]))
    area = np.pi * float(line.contact_radius[0]) ** 2
    return Dented(float(line.force[0]), area, float(line.residual_depth[0]))


def _walked(reading: str, depths: np.ndarray) -> Yielded:
    path = SpringPath("penetration", depths)
    if reading == "zunker_kamrin":
        return ZunkerKamrin(1.0, MODULUS, YIELD_STRESS).walk(path)
    line = YieldingSprings(
        equivalents.paraboloid(1.0),
        MODULUS,
        HARDNESS * YIELD_STRESS,
        cast("Reading", reading),
        reach=float(depths.max()),
        springs=_SPRINGS,
    )
    return line.walk(path)


def spring_restitution(energy: float, depth: float, reading: str) -> float:
    """Return the restitution of springs that take an energy, near a penetration."""
    while True:
        down = depth * np.arange(_STEPS + 1) / _STEPS
        force = _walked(reading, down).force
        taken = np.concatenate([[0.0], np.cumsum((force[1:] + force[:-1]) / 2 * np.diff(down))])
        if taken[-1] >= energy:
            break
        depth *= 2
    deepest = float(np.interp(energy, taken, down))
    down = deepest * np.arange(_STEPS + 1) / _STEPS
    path = np.concatenate([down, down[-2::-1]])
    force = _walked(reading, path).force
    steps = (force[1:] + force[:-1]) / 2 * np.diff(path)
    return float(np.sqrt(-steps[_STEPS:].sum() / steps[:_STEPS].sum()))


@experiment("yielding-springs", "depth over that of first yield d/d_y")
def yielding_springs(
    effort: Effort,
    *,
    depth: Annotated[float, Field(ge=0.1, le=1000)] = 10.0,
    reading: Annotated[str, one_of(*READINGS, *_FORMULAS)] = "stress",
    quantity: Literal["restitution", "mean_pressure"] = "restitution",
) -> Finding:
    """Rebound of springs that yield, or a closed form, against finite elements.

    A rebound at equal energy, a cavity at equal contact radius.
    """
    if _FORMULAS.get(reading, "restitution") != quantity:
        raise ValueError(f"{reading} says nothing of the {quantity}")
    rebound = quantity == "restitution"
    grids = (_REBOUND_GRIDS if rebound else _GRIDS)[effort]
    on_few, on_many = (elements(depth * _DEPTH, n, rebound=rebound) for n in grids)
    coarse, fine = (float(getattr(dented, quantity)) for dented in (on_few, on_many))
    if reading == "thornton":
        stated = float(thornton_restitution(np.sqrt(on_many.work / _WORK)))
    elif reading == "johnson":
        energy = on_many.work / YIELD_STRESS
        stated = float(johnson_restitution(energy, YIELD_STRESS / MODULUS))
    elif reading == "cavity":
        strain = np.sqrt(on_many.area / np.pi) / YIELD_STRESS
        stated = float(cavity_pressure(strain, NU)) * YIELD_STRESS
    else:
        stated = spring_restitution(on_many.work, depth * _DEPTH, reading)
    details = {}
    if rebound:
        details["speed over that of first yield"] = float(np.sqrt(on_many.work / _WORK))
    bar = known_to(quantity, grids, (coarse, fine))
    return Finding(stated, fine, bar * stated / fine**2, details)


def _largest(pressure: Callable[[np.ndarray], np.ndarray]) -> float:
    """Return the largest value over relative radii in [0, 1), by a scan and a local search."""
    scan = np.linspace(0.0, 1.0, 400, endpoint=False)
    values = pressure(scan)
    best = int(np.argmax(values))
    low, high = scan[max(best - 1, 0)], scan[min(best + 1, len(scan) - 1)]
    optimum = minimize_scalar(
        lambda rho: -float(pressure(np.array([rho]))[0]),
        bounds=(low, high),
        method="bounded",
        options={"xatol": 1e-10},
    )
    return max(float(values[best]), -float(optimum.fun))


# Equivalent profile and closed form by exponent: shapes of unit size, E* = 1.
_SHAPES: dict[str, Callable[[float], tuple[equivalents.Profile, ClosedForm]]] = {
    "power_law": lambda n: (equivalents.power_law(n, 1.0), power_law(n, 1.0, 1.0)),
    "sphere": lambda n: (equivalents.sphere(1.0), sphere(1.0, 1.0)),
}


@experiment("first-yield", "exponent n of f = c r^n")
def first_yield(
    effort: str,
    *,
    exponent: float = 4.0,
    shape: Annotated[str, one_of(*_SHAPES)] = "power_law",
    limit: Positive = 0.05,
    rule: Literal["own_curvature", "one_radius", "abel"] = "own_curvature",
    criterion: Literal["pressure", "mises"] = "pressure",
) -> Finding:
    """Force at first yield by the local stress rule (19.37).

    The forces at which the stress (19.37) and the true stress reach `limit` E*. Shapes: f = r^n of
    unit coefficient, the sphere of unit radius.
    ``criterion="mises"``: true first yield occurs below the surface, while the rule compares sigma
    with the yield stress. For the paraboloid only (Johnson 1985, 4.2: on the axis, nu = 0.3). The
    closed forms are exact to 1e-12, the search for the maximum to 1e-9.
    """
    if shape == "power_law" and rule == "own_curvature" and exponent < 2:
        raise ValueError(f"exponent {exponent!r}: below 2 the rule is infinite on the axis")
    if criterion == "mises" and (shape, exponent) != ("power_law", 2):
        raise ValueError("criterion 'mises' is for the paraboloid, exponent = 2")
    profile, form = _SHAPES[shape](exponent)

    def stated(depth: float) -> float:
        a = float(profile.contact_radius(depth))
        rules = {
            "own_curvature": lambda r: stress.local_rule(profile, 1.0, depth, r)[0],
            "one_radius": lambda r: stress.one_radius_rule(profile, 1.0, depth, r),
            "abel": lambda r: stress.abel(profile, 1.0, depth, r),
        }
        return _largest(lambda rho: rules[rule](rho * a))

    def true(depth: float) -> float:
        a = float(form.semi_axes(depth)[0])
        largest = _largest(lambda rho: form.pressure(rho * a, 0.0, depth))
        return largest * (_largest_mises() if criterion == "mises" else 1.0)

    depths = [
        brentq(lambda d, at=at: at(np.exp(d)) / limit - 1, -40, -0.5, xtol=1e-12)
        for at in (stated, true)
    ]
    forces = [float(form.force(np.exp(d))) for d in depths]
    details = {
        "contact radius at true yield": float(form.semi_axes(np.exp(depths[1]))[0]),
        "largest stress at true yield, stated over true": stated(np.exp(depths[1])) / limit,
    }
    bar = 1e-6 * (1 + abs(forces[0] / forces[1] - 1))
    return Finding(forces[0], forces[1], bar, details)


def _largest_mises(poisson_ratio: float = 0.3) -> float:
    """Return the largest |sigma_z - sigma_r|/p0 on the axis for Hertz (Johnson 1985, (3.45))."""

    def negative(z: float) -> float:
        along = -1 / (1 + z * z)
        across = -(1 + poisson_ratio) * (1 - z * np.arctan(1 / z)) - along / 2
        return -abs(along - across)

    return -float(minimize_scalar(negative, bounds=(1e-3, 3), method="bounded").fun)


@shared(maxsize=16)
def _pressures(surface: Surface, load: float, factor: int, count: int) -> list[np.ndarray]:
    """Return the pressures of the contact cells, one array per realisation."""
    operator = surface.operator(factor)
    pressed = (press(operator, surface.heights(k, factor), load)[0] for k in range(count))
    return [contact.pressure[contact.mask] for contact in pressed]


@shared(maxsize=16)
def _stresses(
    surface: Surface, load: float, rule: str, count: int
) -> tuple[list[np.ndarray], np.ndarray]:
    """Return the stress (19.37) of the springs in contact, and the shares without a value, by line.

    Springs without a real value count as unstressed.
    """
    # second differences need eight times the points of the surface
    stresses = [
        regions.line_stress(line, 1.0, depth, rule=rule)
        for line, depth in each_line(surface, load, count, 8)
    ]
    return [s.pressure for s in stresses], np.array([s.undefined_share for s in stresses])


def _shares(stresses: list[np.ndarray], hardness: float) -> np.ndarray:
    """Return the fractions of the contacts above the hardness."""
    return np.array([float(np.mean(in_contact > hardness)) for in_contact in stresses])


@experiment("above-hardness", "hardness over E* h'")
def above_hardness(
    effort: str,
    *,
    hardness: Positive = 0.5,
    load: Positive = 0.03,
    rule: Annotated[str, one_of(*regions.RULES)] = "own_curvature",
    surface: Surface = Surface(shortest=4.0),
    realisations: Count = 120,
) -> Finding:
    """Share of a rough contact whose stress is above a hardness.

    Above `hardness` E* h': springs against cells of the surface.
    """
    count = number_of(realisations, effort, 12)

    def sample(factor: int, number: int) -> np.ndarray:
        return _shares(_pressures(surface, load, factor, number), hardness)

    true, grid_bar = truth(sample, count, effort)
    if true.mean() == 0:
        raise ValueError(f"no cell of any surface is above {hardness!r} E* h'")
    stresses, undefined = _stresses(surface, load, rule, 4 * count)
    stated = _shares(stresses, hardness)
    details = {"springs without a value": float(undefined.mean())}
    return compare(stated, true, grid_bar, details)


# Points per side, and surfaces.
_POINTS: dict[Effort, tuple[int, int]] = {"quick": (64, 128), "full": (128, 256)}
_SURFACES: dict[Effort, int] = {"quick": 4, "full": 8}


@cache
def _surfaces() -> RoughGeometry:
    geometry, _ = prepare(load_scene("plastic-rough", {"surface.realisations": 8}))
    assert isinstance(geometry, RoughGeometry)
    return geometry


@shared(maxsize=256)
def _compared(surface: int, points: int, index: float) -> dict[str, tuple[float, float]]:
    """Return what is stated and what is true of a surface on a grid, F = 0.1 H A0, E* = 1."""
    rough = _surfaces()
    hardness = rough.rms_slope / index
    heights = rough.heights(surface, points)
    body = PeriodicOperator((points, points), rough.spacing(heights), 1.0)
    gap, force = rough.top(surface) - heights, LoadPath("force", 0.1 * hardness * rough.area)
    (dent,), (elastic,) = (along(body, gap, cap, force) for cap in (hardness, np.inf))
    area = located_area(dent.contact, hardness, patch=True)
    pressure = elastic.contact.pressure
    over = np.count_nonzero(pressure >= hardness) / np.count_nonzero(pressure)
    return {
        "hardness_area": (dent.contact.force / hardness, area),
        "elastic_area": (located_area(elastic.contact, patch=True), area),
        "plastic_share": (over, dent.plastic_share),
    }


@experiment("rough-yield", "plasticity index E* h'/H")
def rough_yield(
    effort: Effort,
    *,
    index: Positive = 3.0,
    quantity: Literal["hardness_area", "elastic_area", "plastic_share"] = "hardness_area",
) -> Finding:
    """Rough contacts by their hardness, or elastic, against a capped pressure.

    The area F/H, the elastic one, or the elastic share above H, with what yields.
    """
    numbers = range(_SURFACES[effort])
    errors = []
    for points in _POINTS[effort]:
        pairs = [_compared(k, points, index)[quantity] for k in numbers]
        stated, true = np.transpose(pairs)
        if not true.mean() > 0:
            raise ValueError(f"nothing yields at an index of {index!r}")
        errors.append(float(stated.mean() / true.mean() - 1))
    residual = stated - (1 + errors[-1]) * true
    scatter = float(2 * np.std(residual, ddof=1) / np.sqrt(len(pairs)) / true.mean())
    # grids err in proportion to their cells (Richardson's rule of first order)
    coarse, fine = errors
    everything = [_compared(k, _POINTS[effort][-1], index) for k in numbers]
    details = {
        "share of the contact that yields": float(
            np.mean([pair["plastic_share"][1] for pair in everything])
        ),
        "F over H A": float(np.mean([np.divide(*pair["hardness_area"]) for pair in everything])),
    }
    return Finding(stated.mean(), true.mean(), abs(fine - coarse) + scatter, details)


# Depths in cells of the surface's own grid: nearly none, and on to where little is left.
DEPTHS = np.append(1e-6, 0.1 * 1.3 ** np.arange(16.0))


@shared(maxsize=16)
def largest_mises(
    surface: Surface, load: float, nu: float, factor: int, count: int
) -> tuple[np.ndarray, np.ndarray]:
    """Return the largest von Mises stress of every surface, and its depth in waves."""
    operator, side = surface.operator(factor), 1 / surface.points
    body = Stack([], [], Material(1 - nu**2, nu))
    stresses, depths = np.empty(count), np.empty(count)
    for k in range(count):
        contact, _ = press(operator, surface.heights(k, factor), load)
        fields = list(inside(body, contact.pressure, operator.spacing, DEPTHS * side))
        peaks = np.array([field.von_mises.max() for field in fields])
        stresses[k], depths[k] = peaks.max(), DEPTHS[peaks.argmax()] / surface.shortest
    return stresses, depths


@experiment("rough-first-yield", "load F/(E* A0 h')")
def rough_first_yield(
    effort: str,
    *,
    load: Positive = 0.03,
    rule: Annotated[str, one_of(*regions.RULES)] = "one_radius",
    surface: Surface = PeriodicSurface(32, shortest=4.0),
    realisations: Count = 90,
) -> Finding:
    """Largest local stress (19.37) of a line against von Mises below the rough contact.

    Periodic surfaces, pressed by F = `load` E* A0 h'; the stresses are those of waves in the
    half-space under the pressure of the cells, at seventeen depths.
    """
    count = number_of(realisations, effort, 12)

    def sample(factor: int, number: int) -> np.ndarray:
        return largest_mises(surface, load, NU, factor, number)[0]

    true, grid_bar = truth(sample, count, effort)
    # The largest local stress (19.37) of every line: second differences need eight times the points
    # of the surface.
    stated = [
        regions.line_stress(line, 1.0, depth, rule=rule).pressure.max()
        for line, depth in each_line(surface, load, 4 * count, 8)
    ]
    finest = 4 if effort == "full" else 2
    number = max(3, count // 30) if effort == "full" else max(6, count // 6)
    depths = largest_mises(surface, load, NU, finest, number)[1]
    details = {
        "depth of the largest, in shortest waves": float(depths.mean()),
        "surfaces that yield below their surface first": float((depths > 1e-3).mean()),
    }
    return compare(stated, true, grid_bar, details)
