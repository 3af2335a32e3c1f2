"""Cost of the reduced model, with the sorting of its input as yardstick."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

import numpy as np

from comparisons.questions.benchmarks.yardstick import (
    Measurement,
    exponent,
    interleaved,
    measurement,
)
from reduced.loads import Load
from reduced.memory.materials import kelvin_voigt
from reduced.profiles import equivalents
from reduced.rough import ensemble
from reduced.rough.line_spectrum import LineSpectrum
from reduced.rough.press import RoughLines, press
from reduced.rubber.history import slide_in_time
from reduced.springs.indent import indent
from reduced.springs.line import Springs

SPRINGS, LOADS = 10**6, 100
LINES, POINTS, FEW_LOADS = 450, 64, 15
SIZES = tuple(10**k for k in range(2, 8))
EDGES = ("sub_cell", "nodal")
SORT_TARGET, BATCH_TARGET, EXP_TARGET = 1.5, 3.0, 10.0
SLIDING_LINES, SLIDING_POINTS, SLIDING_STEPS = 20, 1024, 4096
_EXPONENT_FROM = 10**4  # with fewer points, the call costs as much as the line


def measure() -> list[Measurement]:
    """Run all measurements; about a minute on one thread."""
    lines = rough_lines(LINES, POINTS)
    batch = _against_argsort(
        f"{LINES} lines x {POINTS} points x {FEW_LOADS} loads",
        _presses(lines, FEW_LOADS),
        lines.heights,
        "np.argsort of the batch",
        BATCH_TARGET,
    )
    # one contact of 40 springs, as in scenes of a single shape
    springs, loads = Springs(equivalents.paraboloid(1.0), 1.0), np.geomspace(1e-3, 0.1, 7)
    single = _against_argsort(
        "paraboloid, 40 springs x 7 loads",
        {name: partial(indent, springs, Load(name, loads)) for name in ("penetration", "force")},
        np.random.default_rng(0).normal(size=80),
        "np.argsort of 80 numbers",
        None,
    )
    return [*_long_line(0.8), *_long_line(0.3), *batch, *single, *_sizes(), *_sliding()]


def _against_argsort(
    title: str,
    tasks: Mapping[str, Callable[[], object]],
    values: np.ndarray,
    yardstick: str,
    target: float | None,
) -> list[Measurement]:
    """Return the cost of each task relative to sorting values along their last axis."""
    times = interleaved({"argsort": partial(np.argsort, values, axis=-1), **tasks}, 21)
    return [
        measurement(f"{title}, {name}", times[name], yardstick, times["argsort"], target)
        for name in tasks
    ]


def rough_lines(count: int, points: int, hurst: float = 0.8) -> RoughLines:
    """Return self-affine lines with all resolved waves, rms height 1, dx = 1."""
    mode = np.arange(1, (points - 1) // 2 + 1)
    power = mode ** (-1 - 2 * hurst)
    source = LineSpectrum(2 * np.pi * mode, power / (2 * power.sum()), 1.0)
    return RoughLines(ensemble.RandomLines(source, points, count, seed=1).draw().heights, 1.0)


def load_lists(lines: RoughLines, loads: int) -> list[Load]:
    """Return three decades of force up to about half contact, and equivalent other loads."""
    heights = lines.heights
    depth = float(np.mean(heights.max(axis=1) - heights.mean(axis=1)))
    ladder = np.geomspace(1e-3, 1, loads)
    return [
        Load("force", 0.2 * ladder * depth * heights.shape[1]),
        Load("penetration", ladder * depth),
        Load("mean_gap", depth * np.linspace(0.05, 0.99, loads)),
    ]


def _presses(lines: RoughLines, loads: int) -> dict[str, Callable[[], object]]:
    return {
        f"{load.control}, {edges}": partial(press, lines, 1.0, load, edges=edges)
        for load in load_lists(lines, loads)
        for edges in EDGES
    }


def _long_line(hurst: float) -> list[Measurement]:
    line = rough_lines(1, SPRINGS, hurst)
    tasks, heights = _presses(line, LOADS), line.single()
    sorts = {"argsort": partial(np.argsort, heights), "sort": partial(np.sort, heights)}
    times = interleaved(sorts | tasks, 5)
    title = f"1e6 springs x {LOADS} loads, H = {hurst}"
    rows = [
        measurement(f"{title}, {name}", times[name], "np.argsort", times["argsort"], SORT_TARGET)
        for name in tasks
    ]
    name = f"force, {EDGES[0]}"
    against_sort = f"{title}, {name}, against np.sort"
    return [*rows, measurement(against_sort, times[name], "np.sort", times["sort"])]


def _sliding() -> list[Measurement]:
    """Return the cost of Problem 1 relative to one np.exp per point and step, slow to fast sliding.

    A tenth of the line is in contact at rest; for half of it, there is no target.
    """
    heights = rough_lines(SLIDING_LINES, SLIDING_POINTS).heights
    lines = RoughLines(1e-2 * heights, 1 / SLIDING_POINTS)
    points = np.random.default_rng(0).normal(size=lines.heights.shape)

    def exponentials() -> None:
        for _ in range(SLIDING_STEPS):
            np.exp(points)

    rows = []
    for load, target in ((1e-3, EXP_TARGET), (2e-2, None)):
        tasks = {
            f"v tau = {reach:g} dx": partial(
                slide_in_time,
                lines,
                kelvin_voigt(1.0, 1.0),
                reach / SLIDING_POINTS,
                load,
                steps=SLIDING_STEPS,
            )
            for reach in (1e-3, 1.0, 10.0, 100.0)
        }
        times = interleaved({"exp": exponentials, **tasks}, 3)
        share = "a tenth" if target else "half"
        rows += [
            measurement(
                f"Problem 1, {SLIDING_LINES} lines x {SLIDING_POINTS} points x {SLIDING_STEPS} "
                f"steps, {share} in contact, {name}",
                times[name],
                "np.exp per point and step",
                times["exp"],
                target,
            )
            for name in tasks
        ]
    return rows


def _sizes() -> list[Measurement]:
    """Return the cost against N, and its growth from 1e4 to 1e7 relative to N log N."""
    rows, seconds_by_points = [], {}
    for points in SIZES:
        line = rough_lines(1, points)
        pressing = partial(press, line, 1.0, load_lists(line, LOADS)[0])
        sorting = partial(np.argsort, line.single())
        times = interleaved({"argsort": sorting, "press": pressing}, 5)
        rows.append(
            measurement(
                f"N = {points:.0e}, {LOADS} loads, force",
                times["press"],
                "np.argsort",
                times["argsort"],
            )
        )
        seconds_by_points[points] = rows[-1].seconds
    sizes = np.array([n for n in seconds_by_points if n >= _EXPONENT_FROM], dtype=float)
    cost = np.array([seconds_by_points[int(n)] for n in sizes])
    found, bound = exponent(sizes, cost), exponent(sizes, sizes * np.log(sizes))
    first, last = sizes[0], sizes[-1]
    growth = Measurement(
        f"exponent of the cost in N from {first:.0e} to {last:.0e}: {found:.2f}",
        float(cost[-1]),
        f"N log N from the same start ({bound:.2f})",
        float(cost[0] * (last / first) ** bound),
        float((last / first) ** (found - bound)),
        1.0,
    )
    return [*rows, growth]
