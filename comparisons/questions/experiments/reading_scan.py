"""Best of many readings of Fig. 19.8: those for which the areas of line and surface coincide.

The readings are data, `readings.toml`: what the chapter leaves open, with the sentence that leaves
it open. A search over readings selects the one most favourable to the statement. Therefore all
readings are tried on some surfaces, and the best one is judged on others.
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

from comparisons.questions.experiments.experiment import (
    Count,
    Effort,
    Finding,
    Points,
    Positive,
    experiment,
)
from comparisons.questions.experiments.rough_contact import measure_area
from comparisons.questions.experiments.rough_ensemble import Drawing, Surface, press, pressed_lines
from comparisons.solving.shared import shared

LOADS = (0.001, 0.003, 0.01, 0.03, 0.1)
# Surfaces and lines of the search; the surfaces differ from those of the judgement. The choice must
# not depend on the effort: another reading is another statement.
_FIRST = 200_000
_COUNTS = 24, 450


@dataclass(frozen=True)
class Choice:
    """What the chapter leaves open, and the sentence that does so.

    Attributes
    ----------
    parameter, values
        Of the experiment `rough-contact`.
    name : str
        The parameter in words.
    sentence, unsaid : str
        From the chapter, and what it does not say.
    """

    parameter: str
    name: str
    values: tuple[float | str, ...]
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
    true = dict(zip(patches, _true.over((patch, surfaces) for patch in patches), strict=True))
    lines = dict(zip(families, _lines.over((*f, count) for f in families), strict=True))
    errors = {}
    for reading, family in read.items():
        chosen = parameters_of(reading)
        stated = lines[family][str(chosen["edges"]), int(chosen["sided"])]
        errors[reading] = stated / true[family[0]] - 1
    return errors


@shared(maxsize=256)
def _lines(
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
def _true(surface: Surface, count: int) -> np.ndarray:
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
