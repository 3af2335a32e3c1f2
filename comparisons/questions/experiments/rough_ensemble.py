"""Ensembles of rough surfaces and of their equivalent lines, at one load.

Lengths are in units of the side L, E* and the rms gradient h' are one: in the linear half-space
problem every relative result depends on F/(E* A0 h') alone. Averages needed by several claims are
cached within the process.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy import stats

from comparisons.judging.uncertainty import OF_TWO, SAFE, combined, ratio_of_means, standard_error
from comparisons.questions.experiments.experiment import Finding, Points
from comparisons.solving.shared import shared
from reduced.loads import Load
from reduced.rough import ensemble, line_spectrum
from reduced.rough.press import RoughLines
from reduced.rough.surface_spectrum import SelfAffineLaw
from reference import loads as reference_loads
from reference import surfaces
from reference.contact import press as unilateral
from reference.contact.body import ElasticBody
from reference.contact.press import Contact
from reference.halfspace import FreeOperator, PeriodicOperator, areas

# Overlap relative to the penetration: far below the scatter of the ensembles.
_TOLERANCE = 1e-4
SEED = 1
QUANTITIES = (
    *("contact_area", "contact_area_raw", "penetration", "mean_gap", "contact_length"),
    "stiffness",
)


@dataclass(frozen=True)
class Surface:
    """Self-affine random surface of side one with rms gradient one; keywords of experiments."""

    points: Points = 64  # points per side
    hurst: float = 0.8  # Hurst exponent H, C2D ~ q^(-2 (1 + H)); above one it is a steeper spectrum
    # L/lambda_l >= 1, the side over the longest wavelength of the power law; longer waves form a
    # plateau. One for no plateau.
    roll_off: Annotated[float, Field(ge=1)] = 1.0
    # lambda_s/dx >= 2, the shortest wavelength over the spacing.
    shortest: Annotated[float, Field(ge=2)] = 2.0
    periodic: bool = False  # a periodic half-space, or a free patch

    @property
    def recipe(self) -> dict[str, float | None]:
        """Keyword arguments of the synthesis in both packages."""
        return {
            "power": 2 * (1 + self.hurst),
            "rms_slope": 1.0,
            "long_cutoff": 1 / self.roll_off if self.roll_off > 1 else None,
            "short_cutoff": self.shortest / self.points,
        }

    def heights(self, realisation: int, factor: int = 1) -> np.ndarray:
        """Return a realisation on a grid refined by `factor`."""
        native = surfaces.self_affine(
            self.points, 1.0, surfaces.SelfAffine(**self.recipe), seed=SEED, realisation=realisation
        )
        return surfaces.subdivide(native, factor)

    def operator(self, factor: int = 1) -> ElasticBody:
        """Return the half-space operator on that grid."""
        n = self.points * factor
        kind = PeriodicOperator if self.periodic else FreeOperator
        return kind((n, n), (1 / n, 1 / n), 1.0)

    def line(self, rule: str) -> line_spectrum.LineSpectrum:
        """Return the spectrum of the surface's equivalent line."""
        return line_spectrum.prescribed(self.points, 1.0, SelfAffineLaw(**self.recipe), rule=rule)

    def lines(self, count: int, finer: int, rule: str = "rings") -> ensemble.RandomLines:
        """Return `count` equivalent lines, with `finer` points for one of the surface."""
        return ensemble.RandomLines(self.line(rule), finer * self.points, count, seed=SEED)


@dataclass(frozen=True)
class PeriodicSurface(Surface):
    """One whose half-space is periodic, for what has no meaning on a free patch."""

    periodic: Literal[True] = True


def press(
    operator: ElasticBody, heights: np.ndarray, load: float, stiffness: bool = False
) -> tuple[Contact, dict[str, float]]:
    """Return the contact of a map under the force `load` (E* = A0 = 1), and its quantities."""
    contact = unilateral.press(
        operator, heights.max() - heights, reference_loads.Load("force", load), tolerance=_TOLERANCE
    )
    mask, periodic = contact.mask, operator.periodic
    spots = areas.patches(mask, operator.spacing, periodic)
    row = {
        "contact_area": areas.corrected_area(mask, operator.spacing, periodic),
        "contact_area_raw": areas.raw_area(mask, operator.spacing),
        "penetration": contact.penetration,
        "mean_gap": contact.mean_gap,
        "contact_length": float(np.sqrt(4 * spots.areas / np.pi).sum()),
    }
    if stiffness:
        row["stiffness"] = areas.contact_stiffness(operator, mask, tolerance=1e-4)
    return contact, row


@shared(maxsize=512)
def surface_samples(
    surface: Surface, load: float, factor: int, count: int, stiffness: bool = False
) -> dict[str, np.ndarray]:
    """Return the quantities of `count` realisations at F = load E* A0 h', arrays (count,)."""
    operator = surface.operator(factor)
    rows = [press(operator, surface.heights(k, factor), load, stiffness)[1] for k in range(count)]
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


@dataclass(frozen=True)
class Drawing:
    """Rules for drawing lines from a surface of side L."""

    rule: str = "rings"  # relation between the spectra of line and surface
    edges: str = "sub_cell"  # treatment of contact edges, see `reduced.rough.press.press`
    line_length: Annotated[float, Field(gt=0, le=1024)] = 1.0  # length of a line over L
    # Points per L; by default twice those of the surface, to resolve the modes in the corners of
    # its spectrum.
    line_points: Annotated[int, Field(strict=False, ge=0, le=10**6)] = 0
    # Sides of the spectrum C1D: two as in (19.28), or one, which doubles the mean square height.
    sided: Annotated[int, Field(strict=False, ge=1, le=2)] = 2


ONE_SIDE = Drawing()


@shared(maxsize=512)
def line_samples(
    surface: Surface, load: float, count: int, drawing: Drawing = ONE_SIDE
) -> dict[str, np.ndarray]:
    """Return the quantities of `count` lines at the same nominal pressure, per patch L^2.

    A line of length L1 stands for a patch of side L1: it carries F = p L1^2, and its area, force
    and stiffness count per L^2.
    """
    names = ("contact_area", "penetration", "mean_gap", "contact_length", "stiffness")
    pressed = pressed_lines(surface, (load,), count, drawing, names)
    samples = {name: values[:, 0] for name, values in pressed.items()}
    return samples | {"contact_area_raw": samples["contact_area"]}


def pressed_lines(
    surface: Surface, loads: tuple[float, ...], count: int, drawing: Drawing, names: Sequence[str]
) -> dict[str, np.ndarray]:
    """Return quantities of `count` lines at several loads, arrays (count, loads), per patch L^2."""
    length = drawing.line_length
    per_side = drawing.line_points or 2 * surface.points
    spectrum = surface.line(drawing.rule)
    spectrum = replace(spectrum, power=spectrum.power * (2 / drawing.sided))
    lines = ensemble.RandomLines(
        spectrum, round(per_side * length), count, seed=SEED, length=length
    )
    force = Load("force", [load * length**2 for load in loads])
    pressed = ensemble.press_ensemble(lines, 1.0, force, edges=drawing.edges, quantities=names)
    per_patch = ("contact_area", "contact_length", "stiffness")
    return {
        name: pressed.samples[name] / (length**2 if name in per_patch else 1.0) for name in names
    }


def each_line(
    surface: Surface, load: float, count: int, finer: int
) -> Iterator[tuple[RoughLines, float]]:
    """Yield lines one by one, each with its penetration under the load."""
    lines = surface.lines(count, finer)
    pressed = ensemble.press_ensemble(lines, 1.0, Load("force", load), quantities=["penetration"])
    for k, depth in enumerate(pressed.samples["penetration"][:, 0]):
        yield lines.draw([k]), float(depth)


def truth(
    sample: Callable[[int, int], np.ndarray], count: int, effort: str, *, fewest: int = 6
) -> tuple[np.ndarray, float]:
    """Return samples scaled to the best mean, and the relative 95 % bar of the grid.

    ``sample(factor, number)`` are the values of the first `number` surfaces on grids `factor` times
    finer than their own. The same realisations are solved on grids two and four times finer (a
    sixth and a thirtieth of them, because ratios scatter far less than values); the bar is the last
    change times Roache's factor at first order, the order of areas, with the scatter of the ratios.
    Quick effort stops at the first refinement, with the factor for two grids, on `fewest` surfaces
    at least.
    """
    samples = sample(1, count)
    ratios, bars = [], []
    steps = [(2, max(6 if effort == "full" else fewest, count // 6))]
    if effort == "full":
        steps.append((4, max(3, count // 30)))
    for factor, number in steps:
        fine, coarse = sample(factor, number), sample(factor // 2, number)
        ratio, bar = ratio_of_means(fine[:, None], coarse[:, None], paired=True)
        ratios.append(float(ratio[0]))
        bars.append(float(bar[0]))
    change, safety = abs(1 - 1 / ratios[-1]), SAFE if effort == "full" else OF_TWO
    return samples * float(np.prod(ratios)), float(combined(safety * change, *bars))


def pressed_surfaces(
    surface: Surface, load: float, quantity: str, count: int, effort: str
) -> tuple[np.ndarray, float]:
    """Return samples of a quantity of surfaces under a load, and the bar of the grid: `truth`."""
    stiffness = quantity == "stiffness"

    def sample(factor: int, number: int) -> np.ndarray:
        return surface_samples(surface, load, factor, number, stiffness)[quantity]

    return truth(sample, count, effort)


def compare(
    statement: Sequence[float] | np.ndarray,
    true: np.ndarray,
    grid_bar: float,
    details: Mapping[str, float | str],
) -> Finding:
    """Return the mean of a statement beside that of the truth, with the error's 95 % half-width.

    The ensembles are independent; a statement of one value (a theory) has no scatter.
    """
    stated = np.asarray(statement, dtype=float)
    mean = float(true.mean())
    ratio = float(stated.mean()) / mean
    scatter = [
        float(standard_error(sample[:, None])[0]) * stats.t.ppf(0.975, sample.size - 1) / mean
        for sample in (stated, true)
        if sample.size > 1
    ]
    # the scatter of the statement is absolute, so that a statement of zero has a bar
    stated_scatter, true_scatter = scatter if stated.size > 1 else (0.0, *scatter)
    bar = float(combined(stated_scatter, ratio * true_scatter, ratio * grid_bar))
    return Finding(float(stated.mean()), mean, bar, details)
