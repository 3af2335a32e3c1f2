"""Uses of section 19.6: first yield, and the fraction of a rough contact above a hardness."""

from __future__ import annotations

from collections.abc import Callable
from typing import Annotated, Literal

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from comparisons.questions.experiments.experiment import (
    Above,
    Finding,
    OneOf,
    experiment,
    number_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    Surface,
    compare,
    each_line,
    press,
    truth,
)
from comparisons.solving.shared import shared
from reduced.profiles import equivalents
from reduced.rough import regions
from reduced.springs import stress
from reference.closed_form import ClosedForm, power_law, rounded_punch, sphere

RULES = ("own_curvature", "one_radius", "abel")


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


# Equivalent profile and closed form by exponent and flat radius: shapes of unit size, E* = 1.
_SHAPES: dict[str, Callable[[float, float], tuple[equivalents.Profile, ClosedForm]]] = {
    "power_law": lambda n, b: (equivalents.power_law(n, 1.0), power_law(n, 1.0, 1.0)),
    "sphere": lambda n, b: (equivalents.sphere(1.0), sphere(1.0, 1.0)),
    "rounded_punch": lambda n, b: (equivalents.rounded_punch(b, 1.0), rounded_punch(b, 1.0, 1.0)),
}


@experiment(
    "first-yield",
    "Force at first yield by the local stress rule (19.37)",
    "exponent",
    "exponent n of f = c r^n",
)
def first_yield(
    effort: str,
    *,
    exponent: float = 4.0,
    shape: Annotated[str, OneOf(*_SHAPES)] = "power_law",
    edge: float = 0.1,
    limit: Annotated[float, Above(0)] = 0.05,
    rule: Annotated[str, OneOf(*RULES)] = "own_curvature",
    criterion: Literal["pressure", "mises"] = "pressure",
) -> Finding:
    """Compare the forces at which the stress (19.37) and the true stress reach `limit` E*.

    Shapes: f = r^n of unit coefficient, the sphere and the rounded punch (flat to `edge`) of unit
    radius. ``criterion="mises"``: true first yield occurs below the surface, while the rule
    compares sigma with the yield stress. For the paraboloid only (Johnson 1985, 4.2: on the axis,
    nu = 0.3). The closed forms are exact to 1e-12, the search for the maximum to 1e-9.
    """
    if shape == "power_law" and rule == "own_curvature" and exponent < 2:
        raise ValueError(f"exponent {exponent!r}: below 2 the rule is infinite on the axis")
    if shape == "rounded_punch" and rule == "own_curvature":
        raise ValueError("rounded_punch: the rule is infinite at the edge of the flat, at any load")
    if criterion == "mises" and (shape, exponent) != ("power_law", 2):
        raise ValueError("criterion 'mises' is for the paraboloid, exponent = 2")
    profile, form = _SHAPES[shape](float(exponent), float(edge))

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
    details: dict[str, float | str] = {
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
    """Return the stress (19.37) of the springs in contact, one array per line.

    Also the fraction of springs without a real value, which count as unstressed.
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


@experiment(
    "above-hardness",
    "Share of a rough contact whose stress is above a hardness",
    "hardness",
    "hardness over E* h'",
)
def above_hardness(
    effort: str,
    *,
    hardness: Annotated[float, Above(0)] = 0.5,
    load: Annotated[float, Above(0)] = 0.03,
    rule: Annotated[str, OneOf(*regions.RULES)] = "own_curvature",
    points: float = 64,
    hurst: float = 0.8,
    roll_off: float = 1.0,
    shortest: float = 4.0,
    periodic: bool = False,
    realisations: Annotated[float, Above(2)] = 120,
) -> Finding:
    """Compare the contact fraction above `hardness` E* h' of springs with that of surface cells."""
    surface = Surface.of(points, hurst, roll_off, shortest, periodic)
    count = number_of(realisations, effort, 12)

    def sample(factor: int, number: int) -> np.ndarray:
        return _shares(_pressures(surface, float(load), factor, number), hardness)

    true, grid_bar = truth(sample, "refined", count, effort)
    if true.mean() == 0:
        raise ValueError(f"no cell of any surface is above {hardness!r} E* h'")
    stresses, undefined = _stresses(surface, float(load), rule, 4 * count)
    stated = _shares(stresses, hardness)
    details: dict[str, float | str] = {"springs without a value": float(undefined.mean())}
    return compare(stated, true, grid_bar, details)
