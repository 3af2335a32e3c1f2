"""The influence coefficient (19.3) as printed, against Love's solution."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.judging.metrics import relative_error
from comparisons.questions.experiments.experiment import Above, Finding, OneOf, experiment
from reference.halfspace import kernels

READINGS = ("letter", "bracket", "corrected")


def printed_kernel(i: np.ndarray, j: np.ndarray, reading: str) -> np.ndarray:
    """Return K of (19.3) for unit spacing and modulus, offsets i, j >= 0 in cells.

    ``"letter"``: the chapter's two slips, the root sqrt(a^2+b^2) in the first term and the bracket
    that closes before the last two terms, so that these lack the factor dx/(pi E*).
    ``"bracket"``: with the bracket corrected. ``"corrected"``: with both, Love's formula.
    """
    a, b, c, d = i + 0.5, i - 0.5, j + 0.5, j - 0.5
    root = np.hypot(a, d) if reading == "corrected" else np.hypot(a, b)
    first = a * np.log((c + np.hypot(a, c)) / (d + root))
    first += b * np.log((d + np.hypot(b, d)) / (c + np.hypot(b, c)))
    edges = c * np.log((a + np.hypot(a, c)) / (b + np.hypot(c, b)))
    edges += d * np.log((b + np.hypot(b, d)) / (a + np.hypot(a, d)))
    return (first / np.pi + edges) if reading == "letter" else (first + edges) / np.pi


@experiment(
    "influence-coefficient",
    "Influence coefficient (19.3) against Love's, over the offsets of a grid",
    "offset",
    "largest offset in cells",
)
def influence_coefficient(
    effort: str,
    *,
    offset: Annotated[int, Above(-1)] = 63,
    reading: Annotated[str, OneOf(*READINGS)] = "letter",
) -> Finding:
    """Measure the largest error for all pairs of cells up to `offset` apart in both directions.

    One quadrant suffices by symmetry. Love's coefficients are accurate to 1e-13
    (tests/reference/test_halfspace_kernels.py), which is the bar.
    """
    reach = np.arange(int(offset) + 1)
    i, j = np.meshgrid(reach, reach, indexing="ij")
    true = kernels.love(i, j, (1.0, 1.0), 1.0)
    stated = printed_kernel(i, j, reading)
    error = relative_error(stated, true)
    worst = np.unravel_index(np.argmax(np.abs(error)), error.shape)
    near = np.abs(error[: min(2, len(reach)), : min(2, len(reach))])
    details: dict[str, float | str] = {
        "worst offset": f"({worst[0]}, {worst[1]})",
        "median error": float(np.median(np.abs(error))),
        "largest error of neighbours": float(near.max()),
        "own cell": float(error[0, 0]),
    }
    if reach[-1] >= 7:
        details["error at (5, 7)"] = float(error[5, 7])
    bar = 1e-13 * (1 + abs(float(error[worst])))
    return Finding(float(stated[worst]), float(true[worst]), bar, details)
