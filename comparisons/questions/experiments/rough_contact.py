"""Load curves of rough surfaces: the line (Fig. 19.8), asperities, two bodies, published values.

Greenwood and Williamson's model is taken on the summits of the very surfaces; two rough elastic
bodies (Fig. 19.6) as two rough lines, or as one combined line.

The published ensemble is that of Xu, Zhou, Müser et al. (2024), by Green's function molecular
dynamics of periodic rough surfaces: E* = 1, waves of 1e4 to 1e6 /m with C(q) = C0 q^(-2 - 2H), H =
0.8, rms height 6 um; no plateau. Mean gap and area at five pressures.

The readings of Fig. 19.8 are data, `readings.toml`: what the chapter leaves open, with the sentence
that leaves it open. A search over readings selects the one most favourable to the statement.
Therefore all readings are tried on some surfaces, and the best one is judged on others.
"""

from __future__ import annotations

import math
import tomllib
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import product
from pathlib import Path
from typing import Annotated, Any, Literal

import numpy as np
from pydantic import Field
from scipy import fft as transforms

from comparisons.judging.uncertainty import combined, ratio_of_means, share_uncertainty
from comparisons.questions.experiments.experiment import (
    Count,
    Details,
    Effort,
    Finding,
    Points,
    Positive,
    Share,
    experiment,
    number_of,
    one_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    QUANTITIES,
    SEED,
    Drawing,
    Surface,
    compare,
    line_samples,
    press,
    pressed_lines,
    pressed_surfaces,
    surface_samples,
    truth,
)
from comparisons.solving.shared import shared
from reduced.loads import Load
from reduced.rough import press as rough_line
from reference import loads as reference_loads
from reference import surfaces
from reference.closed_form.rough_theories import GreenwoodWilliamson, bush_gibson_thomas_area
from reference.contact.press import sweep
from reference.halfspace import PeriodicOperator
from reference.halfspace.areas import located_area
from reference.surfaces import summits

# Lines per surface and smallest number of lines; lines are cheap, so surfaces should limit the bar.
_LINES_PER_SURFACE, _LEAST_LINES = 4, 450


@experiment("rough-contact", "load F/(E* A0 h')")
def measure_area(
    effort: str,
    *,
    load: Positive = 0.01,
    quantity: Annotated[str, one_of(*QUANTITIES)] = "contact_area",
    grid: Literal["native", "refined"] = "refined",
    statement: Literal["line", "bush"] = "line",
    surface: Surface = Surface(),
    drawing: Drawing = Drawing(),
    realisations: Count = 450,
) -> Finding:
    """Load curves of random rough lines against those of the surfaces.

    Means at equal F/(E* A0 h'). Or what Bush, Gibson and Thomas say of light loads.
    """
    if statement != "line" and not quantity.startswith("contact_area"):
        raise ValueError(f"{statement} speaks of contact_area, not of {quantity}")
    count = number_of(realisations, effort, 20)
    share = surface_samples(surface, load, 1, count, quantity == "stiffness")
    if grid == "native":  # the surface is defined by its points, as in the chapter
        true, grid_bar = share[quantity], 0.0
    else:
        true, grid_bar = pressed_surfaces(surface, load, quantity, count, effort)
    if statement == "line":
        number = max(_LINES_PER_SURFACE * count, _LEAST_LINES)
        stated = line_samples(surface, load, number, drawing)[quantity]
    else:
        stated = np.atleast_1d(bush_gibson_thomas_area(load))
    details = {
        "bar of the grid": grid_bar,
        "realisations": float(count),
        "counted area share": float(share["contact_area_raw"].mean()),
        "L/lambda_l": surface.roll_off,
        "lambda_l/lambda_s": surface.points / surface.shortest / surface.roll_off,
        "half-space": "periodic" if surface.periodic else "free patch",
    }
    return compare(stated, true, grid_bar, details)


# Surfaces whose summits are counted, on grids so much finer that their curvatures have converged.
_SURFACES, _FACTOR = 12, 4


@lru_cache(maxsize=64)
def of_surface(surface: Surface) -> GreenwoodWilliamson:
    """Return the model with density, mean radius and heights of the surfaces' own summits."""
    step = 1 / (surface.points * _FACTOR)
    heights, radii, count = [], [], 0
    for k in range(_SURFACES):
        surface_map = surface.heights(k, _FACTOR)
        peaks = summits(surface_map, (step, step))
        heights.append(surface_map[tuple(peaks.places.T)])
        radii.append(1 / np.sqrt(peaks.curvatures.prod(axis=1)))
        count += len(peaks.places)
    pooled = np.concatenate(heights)
    return GreenwoodWilliamson(
        density=count / _SURFACES,
        radius=float(np.concatenate(radii).mean()),
        mean=float(pooled.mean()),
        deviation=float(pooled.std(ddof=1)),
    )


@experiment("asperities", "load F/(E* A0 h')")
def asperities(
    effort: str,
    *,
    load: Positive = 0.01,
    quantity: Literal["contact_area", "mean_gap", "stiffness"] = "contact_area",
    statement: Literal["model", "line_is_better"] = "model",
    surface: Surface = Surface(roll_off=4.0, shortest=4.0),
    realisations: Count = 60,
) -> Finding | Share:
    """Asperities of the surfaces themselves beside the surfaces and the line.

    Statements: ``"model"``, its relative error; ``"line_is_better"``, by how much the magnitude of
    the line's error exceeds the model's, zero where it does not.
    """
    count = number_of(realisations, effort, 20)
    true, grid_bar = pressed_surfaces(surface, load, quantity, count, effort)
    model = of_surface(surface)
    separation = model.separation(load)  # E* = A0 = h' = 1; without interaction the mean gap
    stated = {
        "contact_area": model.area(separation),
        "mean_gap": separation,
        "stiffness": model.stiffness(separation),
    }[quantity]
    line = line_samples(surface, load, max(4 * count, 450))[quantity]
    details: Details = {}
    of_model = compare([stated], true, grid_bar, details)
    of_line = compare(line, true, grid_bar, details)
    details |= {"error of the line": of_line.error, "error of the model": of_model.error}
    if statement == "model":
        return of_model
    excess = abs(of_line.error) - abs(of_model.error)
    doubt = float(np.hypot(of_model.uncertainty, of_line.uncertainty))
    low, high = max(excess - doubt, 0.0), max(excess + doubt, 0.0)
    return Share(0.5 * (low + high), 0.5 * (high - low), details, "excess")


# First realisation of the second body, distinct from those of the first.
_SECOND, _BODY = 100_000, Surface()
_NAMES = tuple(name for name in QUANTITIES if name != "contact_area_raw")


@shared(maxsize=64)
def _sums(correlation: float, load: float, factor: int, count: int) -> dict[str, np.ndarray]:
    """Return quantities of pairs of surfaces; in the half-space problem only their sum matters."""
    operator = _BODY.operator(factor)
    independent = np.sqrt(1 - correlation**2)
    rows = []
    for k in range(count):
        own, other = _BODY.heights(k, factor), _BODY.heights(_SECOND + k, factor)
        # keeps the rms gradient of the second body for any correlation
        both = own + correlation * own + independent * other
        rows.append(press(operator, both, load, True)[1])
    return {name: np.array([row[name] for row in rows]) for name in _NAMES}


@shared(maxsize=64)
def _lines(load: float, count: int, combined: bool) -> dict[str, np.ndarray]:
    """Return quantities of pairs of lines, or of one line with the sum of their spectra."""
    of_one = _BODY.lines(count, 2)
    if combined:
        power = 2 * of_one.spectrum.power
        lines = replace(of_one, spectrum=replace(of_one.spectrum, power=power)).draw()
    else:
        later = range(_SECOND, _SECOND + count)
        lines = of_one.draw()
        lines = replace(lines, heights=lines.heights + of_one.draw(later).heights)
    # the springs of both bodies in series have the combined modulus, 1/E* = 1/E1* + 1/E2*
    contact = rough_line.press(lines, 1.0, Load("force", load))
    return {name: getattr(contact, name)[:, 0] for name in _NAMES}


@experiment("two-rough-bodies", "load F/(E* A0 h')")
def two_rough_bodies(
    effort: str,
    *,
    load: Positive = 0.01,
    quantity: Annotated[str, one_of(*_NAMES)] = "contact_area",
    against: Literal["combined_line", "surfaces"] = "combined_line",
    correlation: Annotated[float, Field(gt=-1, lt=1)] = 0.0,
    realisations: Count = 450,
) -> Finding:
    """Two rough bodies as two lines, against one combined line or the surfaces.

    Both bodies have the rms gradient one; `load` is F/(E* A0 h') with h' = sqrt 2, that of their
    sum if they are independent. `correlation` (in [0, 1) or negative, for mating faces) makes the
    second surface's heights c h1 + sqrt(1 - c^2) h2; lines have random phases, without any
    correlation.
    """
    force = load * np.sqrt(2)
    count = number_of(realisations, effort, 20)
    number = max(20 * count, 2000)
    two = _lines(force, number, False)[quantity]
    if against == "combined_line":
        if correlation:
            raise ValueError("correlation matters against surfaces only")
        true, grid_bar = _lines(force, number, True)[quantity], 0.0
    else:

        def sample(factor: int, many: int) -> np.ndarray:
            return _sums(correlation, force, factor, many)[quantity]

        true, grid_bar = truth(sample, count, effort)
    details = {
        "scatter of two lines": float(two.std() / two.mean()),
        f"scatter of {against}": float(true.std() / true.mean()),
    }
    return compare(two, true, grid_bar, details)


LONGEST, SHORTEST, HURST, RMS = 1e4, 1e6, 0.8, 6e-6
# 2.4 points to the shortest wave on the coarsest grid.
POINTS_PER_ROLL_OFF, FACTORS = 240, (1, 2, 4)
PRESSURES = (1e-4, 0.001, 0.005, 0.010, 0.025)
# Mean gap over rms height, area over A0 on their finest set, and the area of their table.
PUBLISHED = {
    "mean_gap": (2.629, 1.883, 1.181, 0.8540, 0.4398),
    "area_finest": (0.000826, 0.007822, 0.037911, 0.074426, 0.177695),
    "area_tabulated": (0.000861, 0.008272, 0.039935, 0.077927, 0.185244),
}


def heights(roll_offs: int, number: int) -> np.ndarray:
    """Return a surface: amplitudes fixed, phases random; of the waves on the rim q0 one half.

    The sum over modes stands for an integral over |q| > q0: half the cell of a mode on the rim
    lies outside.
    """
    points, side = POINTS_PER_ROLL_OFF * roll_offs, _side(roll_offs)
    wave = 2 * np.pi * transforms.fftfreq(points, side / points)
    q = np.maximum(np.hypot(wave[:, None], wave), LONGEST / 1e3)
    exponent = 2 * HURST
    density = RMS**2 * exponent / (2 * np.pi * (LONGEST**-exponent - SHORTEST**-exponent))
    amplitude = np.sqrt(density) * q ** (-1 - HURST) * 2 * np.pi / side
    amplitude[(q < LONGEST * (1 - 1e-9)) | (q > SHORTEST)] = 0
    amplitude[np.isclose(q, LONGEST)] *= np.sqrt(0.5)
    noise = np.random.default_rng([SEED, number]).standard_normal((points, points))
    phases = transforms.fft2(noise)
    return np.asarray(transforms.ifft2(amplitude * phases / np.abs(phases)).real * points**2)


def _side(roll_offs: int) -> float:
    return roll_offs * 2 * np.pi / LONGEST


@shared(maxsize=8)
def _solved(roll_offs: int, factor: int, count: int) -> np.ndarray:
    """Return mean gap over rms height and located area over A0, (surfaces, 2, pressures).

    On grids so many times finer, at all pressures.
    """
    side, rows = _side(roll_offs), []
    load = reference_loads.Load("force", np.array(PRESSURES) * side**2)
    for number in range(count):
        surface = surfaces.subdivide(heights(roll_offs, number), factor)
        operator = PeriodicOperator(surface.shape, (side / len(surface),) * 2, 1.0)
        contacts = list(sweep(operator, surface.max() - surface, load))
        gaps = [contact.mean_gap / surface.std() for contact in contacts]
        rows.append((gaps, [located_area(contact) / side**2 for contact in contacts]))
    return np.array(rows)


@experiment("published-ensemble", "row of their table, from the lightest load")
def published_ensemble(
    effort: str,
    *,
    row: Annotated[int, Field(strict=False, ge=1, le=len(PRESSURES))] = 1,
    quantity: Annotated[str, one_of(*PUBLISHED)] = "mean_gap",
) -> Finding:
    """Mean gap and area that Xu, Zhou, Müser et al. (2024) publish, against our own surfaces.

    The means are those of patches of several roll-offs on the coarsest grid, scaled by what finer
    grids change on patches of one. Quick effort: half the side, half as many, two grids for three.
    """
    step, full = row - 1, effort == "full"
    side, count = (4, 8) if full else (2, 4)  # roll-offs to a side, surfaces
    index, kind = (0, "mean_gap") if quantity == "mean_gap" else (1, "contact_area")
    factors = FACTORS if full else FACTORS[:2]
    # Finest over coarsest grid, and the grids' 95 % bar, both (pressures,), on small patches: what
    # a finer grid changes is local, and scatters less than the values.
    levels = [_solved(1, factor, 6 if full else 4)[:, index] for factor in factors]
    ratio, scatter = ratio_of_means(levels[-1], levels[0], paired=True)
    means = np.array([level.mean(axis=0) for level in levels])
    grid = combined(scatter, share_uncertainty(np.array(factors), means, (kind, "periodic")))
    values = _solved(side, FACTORS[0], count)[:, index, step] * ratio[step]
    details = {"p/E*": PRESSURES[step], "surfaces": float(count), "roll-offs a side": float(side)}
    return compare([PUBLISHED[quantity][step]], values, float(grid[step]), details)


LOADS = (0.001, 0.003, 0.01, 0.03, 0.1)
# Surfaces and lines of the search; the surfaces differ from those of the judgement. The choice must
# not depend on the effort: another reading is another statement.
_FIRST = 200_000
_COUNTS = 24, 450


@dataclass(frozen=True)
class Choice:
    """What the chapter leaves open, and the sentence that does so."""

    parameter: str  # of the experiment `rough-contact`
    name: str  # the parameter in words
    values: tuple[float | str, ...]
    # From the chapter, and what it does not say.
    sentence: str
    unsaid: str


_DATA = tomllib.loads(Path(__file__).with_name("readings.toml").read_text(encoding="utf-8"))
CHOICES = tuple(Choice(**{**row, "values": tuple(row["values"])}) for row in _DATA["choice"])
# A reading: the values of the choices, in their order.
Reading = tuple[float | str, ...]
READINGS: tuple[Reading, ...] = tuple(product(*(choice.values for choice in CHOICES)))


def parameters_of(reading: Reading) -> dict[str, Any]:
    """Return a reading as parameters of the experiment `rough-contact`."""
    names = (choice.parameter for choice in CHOICES)
    return dict(zip(names, reading, strict=True))


# What it needs is shared, it is not: processes that need the same scan would wait for one of them.
@lru_cache(maxsize=4)
def scan(points: int = 64) -> dict[Reading, np.ndarray]:
    """Return counted area of the line over that of the surface, less one, at `LOADS`, by reading.

    Means over 24 surfaces and 450 lines: enough to rank readings, not to judge one.
    """
    surfaces, count = _COUNTS
    read = {}  # what draws the lines of a reading: several readings press the same lines
    for reading in READINGS:
        chosen = parameters_of(reading)
        surface = Surface(points, float(chosen["hurst"]), float(chosen["roll_off"]))
        read[reading] = surface, str(chosen["rule"]), float(chosen["line_length"])
    families = list(dict.fromkeys(read.values()))
    patches = list(dict.fromkeys(family[0] for family in families))
    true = dict(
        zip(patches, _read_surfaces.over((patch, surfaces) for patch in patches), strict=True)
    )
    lines = dict(zip(families, _read_lines.over((*f, count) for f in families), strict=True))
    errors = {}
    for reading, family in read.items():
        chosen = parameters_of(reading)
        stated = lines[family][str(chosen["edges"]), int(chosen["sided"])]
        errors[reading] = stated / true[family[0]] - 1
    return errors


@shared(maxsize=256)
def _read_lines(
    surface: Surface, rule: str, length: float, count: int
) -> dict[tuple[str, int], np.ndarray]:
    """Return the mean areas of lines at `LOADS`, per patch, by edges and sides of the spectrum.

    A spectrum of one side has all heights times sqrt(2): these lines have at a load the area that
    those of two sides have at 1/sqrt(2) of it.
    """
    loads = {2: LOADS, 1: tuple(load / math.sqrt(2) for load in LOADS)}
    ordered = tuple(sorted(loads[2] + loads[1]))
    areas = {}
    for edges in ("sub_cell", "nodal"):
        drawing = Drawing(rule=rule, edges=edges, line_length=length)
        pressed = pressed_lines(surface, ordered, count, drawing, ("contact_area",))
        means = pressed["contact_area"].mean(axis=0)
        for sided, several in loads.items():
            areas[edges, sided] = means[[ordered.index(load) for load in several]]
    return areas


@shared(maxsize=64)
def _read_surfaces(surface: Surface, count: int) -> np.ndarray:
    """Return the mean counted areas of the surfaces of the search at `LOADS`."""
    operator = surface.operator()
    maps = [surface.heights(_FIRST + k) for k in range(count)]
    return np.array(
        [
            np.mean([press(operator, heights, load)[1]["contact_area_raw"] for heights in maps])
            for load in LOADS
        ]
    )


def best_reading(points: int = 64, by: str = "largest", steepest: float = np.inf) -> Reading:
    """Return the reading whose error over `LOADS` is the smallest, as a factor.

    Of those with Hurst exponents up to `steepest`. By the largest error over the loads, if curves
    should coincide everywhere, or by the median one, if they should coincide over a part of them.
    """
    size: Callable[[np.ndarray], np.floating] = np.median if by == "median" else np.max
    tried = {
        reading: errors
        for reading, errors in scan(points).items()
        if parameters_of(reading)["hurst"] <= steepest
    }
    return min(tried, key=lambda reading: float(size(np.abs(np.log1p(tried[reading])))))


@experiment("best-reading", "load F/(E* A0 h')")
def best(
    effort: Effort,
    *,
    load: Positive = 0.01,
    points: Points = 64,
    realisations: Count = 450,
    by: Literal["largest", "median"] = "largest",
    steepest: Annotated[float, Field(allow_inf_nan=True)] = np.inf,
) -> Finding:
    """Contact area of line and surface under the best of 768 readings of Fig. 19.8.

    Counted areas, on fresh surfaces. `steepest`: the largest Hurst exponent that is allowed.
    """
    reading = parameters_of(best_reading(points, by, steepest))
    chosen = dict(reading)
    finding = measure_area(
        effort,
        load=load,
        quantity="contact_area_raw",
        grid="native",
        surface=Surface(points, chosen.pop("hurst"), chosen.pop("roll_off")),
        drawing=Drawing(**chosen),
        realisations=realisations,
    )
    names = {choice.name: reading[choice.parameter] for choice in CHOICES}
    tried = {"readings tried": float(len(READINGS)), **names}
    return replace(finding, details={**finding.details, **tried})
