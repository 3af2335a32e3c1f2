"""Fig. 19.6: two rough elastic bodies as two rough lines, or as one combined line."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import numpy as np

from comparisons.questions.experiments.experiment import (
    Above,
    Finding,
    OneOf,
    experiment,
    number_of,
)
from comparisons.questions.experiments.rough_ensemble import (
    QUANTITIES,
    Surface,
    compare,
    press,
    truth,
)
from comparisons.solving.shared import shared
from reduced.loads import Load
from reduced.rough import press as rough_line

# First realisation of the second body, distinct from those of the first.
_SECOND = 100_000
_NAMES = tuple(name for name in QUANTITIES if name != "contact_area_raw")


@shared(maxsize=64)
def _surfaces(
    first: Surface, second: Surface, correlation: float, load: float, factor: int, count: int
) -> dict[str, np.ndarray]:
    """Return quantities of pairs of surfaces; in the half-space problem only their sum matters."""
    operator = first.operator(factor)
    independent = np.sqrt(1 - correlation**2)
    rows = []
    for k in range(count):
        own, other = first.heights(k, factor), second.heights(_SECOND + k, factor)
        # keeps the rms gradient of the second body for any correlation
        both = own + correlation * own + independent * other
        rows.append(press(operator, both, load, True)[1])
    return {name: np.array([row[name] for row in rows]) for name in _NAMES}


@shared(maxsize=64)
def _lines(
    first: Surface, second: Surface, load: float, count: int, combined: bool
) -> dict[str, np.ndarray]:
    """Return quantities of pairs of lines, or of one line with the sum of their spectra."""
    of_first, of_second = first.lines(count, 2), second.lines(count, 2)
    if combined:
        power = of_first.spectrum.power + of_second.spectrum.power
        lines = replace(of_first, spectrum=replace(of_first.spectrum, power=power)).draw()
    else:
        later = range(_SECOND, _SECOND + count)
        lines = of_first.draw()
        lines = replace(lines, heights=lines.heights + of_second.draw(later).heights)
    # the springs of both bodies in series have the combined modulus, 1/E* = 1/E1* + 1/E2*
    contact = rough_line.press(lines, 1.0, Load("force", load))
    return {name: getattr(contact, name)[:, 0] for name in _NAMES}


@experiment(
    "two-rough-bodies",
    "Two rough bodies as two lines, against one combined line or the surfaces",
    "load",
    "load F/(E* A0 h')",
)
def two_rough_bodies(
    effort: str,
    *,
    load: Annotated[float, Above(0)] = 0.01,
    quantity: Annotated[str, OneOf(*_NAMES)] = "contact_area",
    against: Literal["combined_line", "surfaces"] = "combined_line",
    correlation: float = 0.0,
    hurst: float = 0.8,
    second_hurst: float = 0.8,
    points: float = 64,
    realisations: Annotated[float, Above(2)] = 450,
) -> Finding:
    """Compare two lines in contact with one combined line, or with the two surfaces.

    Both bodies have the rms gradient one; `load` is F/(E* A0 h') with h' = sqrt 2, that of their
    sum if they are independent. `correlation` (in [0, 1) or negative, for mating faces) makes the
    second surface's heights c h1 + sqrt(1 - c^2) h2; lines have random phases, without any
    correlation.
    """
    if not -1 < correlation < 1:
        raise ValueError(f"correlation must lie in (-1, 1), not {correlation!r}")
    if correlation and hurst != second_hurst:
        raise ValueError("correlated bodies have one spectrum: hurst = second_hurst")
    first, second = (Surface.of(points, h, 1.0, 2.0, False) for h in (hurst, second_hurst))
    force = float(load) * np.sqrt(2)
    count = number_of(realisations, effort, 20)
    number = max(20 * count, 2000)
    two = _lines(first, second, force, number, False)[quantity]
    if against == "combined_line":
        if correlation:
            raise ValueError("correlation matters against surfaces only")
        true, grid_bar = _lines(first, second, force, number, True)[quantity], 0.0
    else:

        def sample(factor: int, many: int) -> np.ndarray:
            return _surfaces(first, second, float(correlation), force, factor, many)[quantity]

        true, grid_bar = truth(sample, "refined", count, effort)
    details: dict[str, float | str] = {
        "scatter of two lines": float(two.std() / two.mean()),
        f"scatter of {against}": float(true.std() / true.mean()),
    }
    return compare(two, true, grid_bar, details)
