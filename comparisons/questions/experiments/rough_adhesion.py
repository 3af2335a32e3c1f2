"""Adhesion of rough surfaces: the half-space against theories and the reduced model's line.

Surfaces as in `rough_ensemble`, periodic: E* = A0 = h' = 1. The tension falls as exp(-gap/rho), the
law of the Contact Mechanics Challenge (Mueser et al. 2017). The work of adhesion is given by the
number S, attraction over repulsion where the range is short,

    S = pi kappa (w/(E* h' rho)) (3 rho/(4 h' d))^(2/3),   d = 4 h'/h'',

with kappa = 2 and h'' the rms of half the Laplacian: from S = 1 on surfaces should stick. This is
L. Pastewka & M. O. Robbins (PNAS 111 (2014) 3298), as the example ``adhesive_simulation_rough`` of
ContactEngineering's package Adhesion prints kappa, d and (rho h''/h'^2)^(2/3) for it; the constant
pi (3/16)^(2/3) = 1.03 before that is their "about 1", from memory.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import lru_cache
from typing import Annotated

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from comparisons.questions.experiments.experiment import Above, Finding, OneOf, experiment
from comparisons.questions.experiments.rough_ensemble import (
    Surface,
    compare,
    press,
    truth,
)
from comparisons.solving.shared import shared
from reduced.loads import Load
from reduced.rough.press import press as press_lines
from reference.halfspace import Contact
from reference.halfspace.cohesive import CohesiveLaw, exponential
from reference.halfspace.cohesive_minimum import Adhesive
from reference.surfaces import SelfAffine, amplitude_spectrum

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
Pressed = Callable[[float], Contact]


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
    """Return the quantity with adhesion and its value by each theory, for each surface."""
    law, rows = attraction_law(surface, *adhesion), []
    for number in range(count):
        heights = surface.heights(number, factor)
        body = Adhesive(surface.operator(factor), heights.max() - heights, law)

        def pressed(force: float, heights: np.ndarray = heights) -> Contact:
            return press(surface.operator(factor), heights, force)[0]

        measure = {"attraction": _attraction, "pull_off": _pulled_off, "contact_area": _enlarged}
        rows.append(measure[quantity](body, pressed, load))
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _attraction(body: Adhesive, pressed: Pressed, load: float) -> dict[str, float]:
    """Return what adhesion takes from the load at an equal mean gap.

    ``"energy"`` is -d<phi>/d<h> on the way without adhesion, exact for weak adhesion as the energy
    of the equilibrium is stationary.
    """
    law, contact = body.law, pressed(load)
    stuck = body.at_mean_gap(contact.mean_gap, contact.gap, load)
    below, above_ = pressed(load * (1 + _STEP)), pressed(load * (1 - _STEP))
    lost = law.energy(below.gap).mean() - law.energy(above_.gap).mean()
    return {
        "true": load - stuck.force,
        "gaps": _across(law, contact.gap, ~contact.mask),
        "energy": float(lost) / (above_.mean_gap - below.mean_gap),
    }


def _enlarged(body: Adhesive, pressed: Pressed, load: float) -> dict[str, float]:
    """Return the area under compression over that without adhesion."""
    contact = pressed(load)
    return {"true": float(body.at_force(load, contact.gap).mask.sum() / contact.mask.sum())}


def _pulled_off(body: Adhesive, pressed: Pressed, _: float) -> dict[str, float]:
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


@shared(maxsize=64)
def _of_lines(
    surface: Surface, adhesion: tuple[float, float], load: float, quantity: str
) -> np.ndarray:
    """Return the attraction across the gaps of equivalent lines, or their pull-off, per patch."""
    law = attraction_law(surface, *adhesion)
    lines = surface.lines(_LINES, _FINER).draw()
    loads = (load,) if quantity == "attraction" else _LINE_LOADS
    depths = press_lines(lines, 1.0, Load("force", list(loads[::-1]))).penetration[:, ::-1]
    depths = np.column_stack([depths, np.zeros(len(lines))])
    below = lines.heights.max(axis=1, keepdims=True) - lines.heights
    pulls = []
    for place, pressed in enumerate((*loads, 0.0)):
        gap = below - depths[:, place, None]
        across = np.mean(law.tension(np.maximum(gap, 0.0)) * (gap > 0), axis=1)
        pulls.append(across - (pressed if quantity == "pull_off" else 0.0))
    return pulls[0] if quantity == "attraction" else np.max(pulls, axis=0)


@experiment(
    "rough-adhesion",
    "Adhesion of rough surfaces beside theories and the line",
    "strength",
    "Pastewka and Robbins' number S",
)
def rough_adhesion(
    effort: str,
    *,
    strength: Annotated[float, Above(0)] = 0.1,
    quantity: Annotated[str, OneOf(*THEORIES)] = "attraction",
    theory: str = "gaps",
    reach: Annotated[float, Above(0)] = 0.3,
    load: Annotated[float, Above(0)] = 0.02,
    hurst: float = 0.8,
    roll_off: float = 2.0,
) -> Finding:
    """Compare a theory of rough adhesion, or the reduced model's line, with the half-space.

    ``"attraction"``: what adhesion takes from the load at an equal mean gap; ``"pull_off"``: the
    largest pull; ``"contact_area"``: pressed area over that without adhesion, at an equal load.
    ``"gaps"``: the tension across the gaps without adhesion (Persson & Scaraggi 2014);
    ``"energy"``: Derjaguin's way, the loss of surface energy with the mean gap; ``"line"``: the
    tension across the gaps of lines; ``"pastewka_robbins"``: 1/(1 - S).
    """
    OneOf(*THEORIES[quantity]).checked("theory", theory)
    if quantity == "contact_area" and strength >= 1:
        raise ValueError(f"strength must be below 1, where surfaces stick, not {strength!r}")
    surface = Surface.of(32, hurst, roll_off, 4.0, periodic=True)
    adhesion = float(strength), float(reach)

    def sample(factor: int, number: int) -> np.ndarray:
        values = _surfaces(surface, adhesion, float(load), quantity, factor, number)
        return values["true"] / values[theory] if theory in values else values["true"]

    true, grid_bar = truth(sample, "refined", _SURFACES, effort)
    stated: np.ndarray | list[float] = [1.0]
    if theory == "line":
        stated = _of_lines(surface, adhesion, float(load), quantity)
    elif theory == "pastewka_robbins":
        stated = [1 / (1 - strength)]
    details: dict[str, float | str] = {
        "tension over E* h'": attraction_law(surface, *adhesion).strength,
    }
    return compare(stated, true, grid_bar, details)
