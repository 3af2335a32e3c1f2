"""Cost of the FFT solver: growth with N, fraction spent in FFTs, peak memory."""

from __future__ import annotations

import time
from collections.abc import Callable
from functools import partial

import numpy as np

from comparisons.isolation import parent
from comparisons.questions.benchmarks import bem_cases
from comparisons.questions.benchmarks.yardstick import Measurement, interleaved, measurement
from reference.halfspace import fft
from reference.halfspace.solution import Press
from reference.loads import Load

SIZES = tuple(2**k for k in range(6, 12))
LARGEST, MOST_BYTES = 2048, 2e9
CUTOFF = 16
TOLERANCE = 1e-8


def rows() -> list[Measurement]:
    """Return the rows: cost against N, its exponent, and peak memory of the largest grid."""
    costs = [_size(points) for points in SIZES]
    return [*costs, _growth([row.seconds for row in costs]), _memory()]


def _size(points: int) -> Measurement:
    """Return the cost of a solve relative to a pair of transforms, and its fraction in FFTs."""
    case = bem_cases.rough(points, CUTOFF, bem_cases.MEDIUM, None)
    tasks = {"solve": partial(case.solve, TOLERANCE), "transforms": partial(_transforms, points)}
    times = interleaved(tasks, 3, time.process_time)
    share = fft_share(case)
    return measurement(
        f"{case.name}: {share:.0%} of the time inside FFTs",
        times["solve"],
        f"rfft2 and irfft2 of {points}^2",
        times["transforms"],
    )


def _transforms(points: int) -> np.ndarray:
    from scipy import fft

    field = np.ones((points, points))
    return np.asarray(fft.irfft2(fft.rfft2(field), s=field.shape, overwrite_x=True))


def fft_share(case: bem_cases.Case) -> float:
    """Return the fraction of a solve's time spent in transforms.

    It is the number of convolutions on the finest grid in either precision times their cost; the
    coarser grids of the start are not counted.
    """
    operator, load = case.operator(), Load(case.control, float(case.loads[-1]))
    solve = partial(fft.solve, Press(operator, case.gaps[0]), load, tolerance=TOLERANCE)
    single, double = solve().convolutions
    tasks: dict[str, Callable[[], object]] = {"solve": solve}
    for name in ("float32", "float64"):
        field = np.ones(operator.shape, name)
        tasks[name] = partial(operator.convolution(name), field)
    times = interleaved(tasks, 5, time.process_time)
    cost = {name: float(np.median(samples)) for name, samples in times.items()}
    return (single * cost["float32"] + double * cost["float64"]) / cost["solve"]


def _growth(seconds: list[float]) -> Measurement:
    """Fit the exponent of the cost in N per side; N^2 log N is the cost of a transform."""
    sizes = np.array(SIZES, dtype=float)
    exponent = float(np.polyfit(np.log(sizes), np.log(seconds), 1)[0])
    bound = float(np.polyfit(np.log(sizes), np.log(sizes**2 * np.log(sizes)), 1)[0])
    name = f"exponent of the cost in N per side from {SIZES[0]} to {SIZES[-1]}: {exponent:.2f}"
    at_bound = seconds[0] * float((sizes[-1] / sizes[0]) ** bound)
    yardstick = f"N^2 log N from the same start ({bound:.2f})"
    return Measurement(name, seconds[-1], yardstick, at_bound, seconds[-1] / at_bound)


def _memory() -> Measurement:
    """Return the peak memory of the largest periodic grid, measured in a separate process."""
    outcome = parent.run(f"{__name__}:largest", LARGEST, seconds=3600)
    name = f"peak memory of periodic {LARGEST}^2"
    if not outcome.ok:
        return Measurement(f"{name}: {outcome.reason}", float("nan"), "2 GB", None, None, 1.0)
    peak, spent = outcome.answer["peak"], outcome.answer["seconds"]
    text = f"{name}: {peak / 1e9:.2f} GB, the whole process"
    return Measurement(text, spent, "2 GB", None, peak / MOST_BYTES, 1.0)


def largest(points: int) -> dict[str, float]:
    """Solve a large periodic grid; return the seconds and the peak memory of this process."""
    import resource

    case = bem_cases.rough(points, CUTOFF, bem_cases.MEDIUM, None)
    start = time.perf_counter()
    case.solve(TOLERANCE)
    spent = time.perf_counter() - start
    return {"seconds": spent, "peak": 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss}
