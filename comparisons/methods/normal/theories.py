"""Theories of rough contact that know a surface by its spectrum: Persson's, and asperities."""

from __future__ import annotations

from collections.abc import Callable
from typing import ClassVar

import numpy as np
from scipy.optimize import brentq

from comparisons.geometry.prepare import RoughGeometry
from comparisons.methods import Refused, Scene, Solution, Solver, Task
from comparisons.methods.normal.reduced import whole_spectrum
from comparisons.tasks.distributions import edges, wanted
from reference.closed_form.rough_theories import (
    BushGibsonThomas,
    GreenwoodWilliamson,
    Moments,
    greenwood_williamson,
)
from reference.closed_form.rough_theories import Persson as PerssonTheory
from reference.closed_form.rough_theories import PerssonXu as XuTheory


class RoughTheory(Solver[RoughGeometry]):
    """A theory of an unbounded surface with the spectrum of the scene's, at a nominal pressure."""

    named_only = True

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if not scene.rough:
            raise Refused("a theory of rough surfaces")
        if scene.loading.penetration is not None:
            raise Refused("an unbounded surface has no highest point that depths could start from")
        self.modulus = scene.effective_modulus

    def pressures(self, task: Task[RoughGeometry]) -> np.ndarray:
        """Return the nominal pressures F/(E* A0) of prescribed forces."""
        return np.asarray(task.loads.values / (self.modulus * task.geometry.area))

    def solution(self, task: Task[RoughGeometry], relative: dict[str, np.ndarray]) -> Solution:
        """Return the solution: pressure, area and stiffness are given per A0 and E*."""
        area, force = task.geometry.area, self.modulus * task.geometry.area
        curves = {
            "force": relative["pressure"] * force,
            "contact_area": relative["area"] * area,
            "mean_gap": relative["gap"],
            "stiffness": relative["stiffness"] * force,
        }
        return Solution.of(task, curves, violation=0.0)


class SpreadingTheory(RoughTheory):
    """Pressure spreads like heat as shorter waves of the surface are added."""

    theory: ClassVar[type[PerssonTheory | XuTheory]]

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        # the wavenumbers of rings of modes, those which keep the mean square gradients of the
        # rings, and what they add to the mean square height
        spectrum = whole_spectrum(task.geometry)
        q, power = np.ravel(spectrum.magnitude), np.ravel(spectrum.power)
        ring = np.rint(np.ravel(spectrum.place)).astype(int)
        counted = (np.bincount(ring, power * q**order) for order in (0, 2))
        height, steep = (np.asarray(part, dtype=float) for part in counted)
        some = height > 0
        theory = self.theory(np.sqrt(steep[some] / height[some]), height[some])
        if task.loads.control == "mean_gap":
            rms = float(np.sqrt(np.sum(theory.power)))
            slope = float(np.sqrt(np.sum(theory.wavenumber**2 * theory.power)))
            least = np.finfo(float).tiny  # in full contact the gap is zero

            def excess(pressure: float, gap: float) -> float:
                return float(np.log(max(theory.mean_gap(float(np.exp(pressure))), least) / gap))

            found = []
            for gap in map(float, task.loads.values):
                ends = np.log(slope) - 40.0 - 3 * gap / rms, np.log(slope) + 3.0
                found.append(float(np.exp(brentq(excess, *ends, args=(gap,), xtol=1e-12))))
            pressures = np.array(found)
        else:
            pressures = self.pressures(task)
        solution = self.solution(
            task,
            {
                "pressure": pressures,
                "area": np.array([theory.area(p) for p in pressures]),
                "gap": np.array([theory.mean_gap(p) for p in pressures]),
                "stiffness": np.array([theory.stiffness(p) for p in pressures]),
            },
        )
        # the distributions that are asked for; of sizes the theory says nothing
        last = float(pressures[-1])
        below = {"pressure_distribution": lambda p: theory.pressure_below(last, p / self.modulus)}
        if isinstance(theory, PerssonTheory):
            below["gap_distribution"] = lambda gap: theory.gap_below(last, gap)
        for name in below.keys() & set(wanted(task)):
            inner = edges(name, task.scene, task.geometry)[1:-1]
            # the outer bins are open, as what lies beyond counts to them
            counts = np.diff(below[name](np.concatenate([[0.0], inner, [np.inf]])))
            solution.put_distributions(0, {name: counts})
        return solution


class Persson(SpreadingTheory):
    """Persson's theory."""

    name = "persson"
    note = "Persson 2001, mean gap of Yang & Persson 2008, gaps of Almqvist et al. 2011"
    theory = PerssonTheory


class Xu(SpreadingTheory):
    """Persson's theory with less deformation in partial contact."""

    name = "persson_xu"
    note = "Xu, Zhou, Müser et al. 2024, gamma = 0.42"
    theory = XuTheory


class AsperityTheory(RoughTheory):
    """Summits of a Gaussian surface as Hertz's contacts that do not know of each other."""

    asperities: Callable[[Moments], GreenwoodWilliamson | BushGibsonThomas]

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        """Evaluate the model at every load; without interaction the mean gap is the separation."""
        model = self.asperities(moments(task.geometry))
        gaps = task.loads.values
        if task.loads.control != "mean_gap":
            gaps = np.array([model.separation(float(p)) for p in self.pressures(task)])
        values = {
            name: np.array([float(getattr(model, name)(float(gap))) for gap in gaps])
            for name in ("pressure", "area", "stiffness")
        }
        return self.solution(task, {**values, "gap": gaps})


class Greenwood(AsperityTheory):
    """Round asperities of one radius with normal heights, those of the surface's summits."""

    name = "greenwood_williamson"
    note = "Greenwood & Williamson 1966, with the summits of a Gaussian surface (Nayak 1971)"
    asperities = staticmethod(greenwood_williamson)


class Bush(AsperityTheory):
    """Elliptic asperities with the heights and curvatures of the surface's summits."""

    name = "bush_gibson_thomas"
    note = "Bush, Gibson & Thomas 1975"
    asperities = BushGibsonThomas


def moments(geometry: RoughGeometry) -> Moments:
    """Return m0, m2 and m4 of the spectrum, averaged over directions."""
    spectrum = whole_spectrum(geometry)
    q, power = spectrum.magnitude, spectrum.power
    m0, m2, m4 = (float(np.sum(power * q**order)) for order in (0, 2, 4))
    return Moments(m0, m2 / 2, 3 / 8 * m4)
