"""Cost of the reduced model, with the sorting of its input as yardstick."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from comparisons.questions.benchmarks.yardstick import Measurement, growth, in_turns
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
    rows: list[Measurement] = []
    for hurst in (0.8, 0.3):
        title, line = f"1e6 springs x {LOADS} loads, H = {hurst}", rough_lines(1, SPRINGS, hurst)
        tasks, heights = _presses(title, line, LOADS), line.single()
        rows += in_turns(tasks, "np.argsort", partial(np.argsort, heights), 5, SORT_TARGET)
        name, force = next(iter(tasks.items()))
        against = {f"{name}, against np.sort": force}
        rows += in_turns(against, "np.sort", partial(np.sort, heights), 5)
    lines = rough_lines(LINES, POINTS)
    tasks = _presses(f"{LINES} lines x {POINTS} points x {FEW_LOADS} loads", lines, FEW_LOADS)
    sort = partial(np.argsort, lines.heights, axis=-1)
    rows += in_turns(tasks, "np.argsort of the batch", sort, 21, BATCH_TARGET)
    # one contact of 40 springs, as in scenes of a single shape
    springs, loads = Springs(equivalents.paraboloid(1.0), 1.0), np.geomspace(1e-3, 0.1, 7)
    tasks = {
        f"paraboloid, 40 springs x 7 loads, {name}": partial(indent, springs, Load(name, loads))
        for name in ("penetration", "force")
    }
    few = np.random.default_rng(0).normal(size=80)
    rows += in_turns(tasks, "np.argsort of 80 numbers", partial(np.argsort, few), 21)
    of_size = {}
    for points in SIZES:
        line = rough_lines(1, points)
        pressing = partial(press, line, 1.0, load_lists(line, LOADS)[0])
        sort = partial(np.argsort, line.single())
        one = {f"N = {points:.0e}, {LOADS} loads, force": pressing}
        (of_size[points],) = in_turns(one, "np.argsort", sort, 5)
    late = {points: row for points, row in of_size.items() if points >= _EXPONENT_FROM}
    law = "N log N", lambda n: n * np.log(n)
    return [*rows, *of_size.values(), growth(late, "N", law, 1.0), *_sliding()]


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


def _presses(title: str, lines: RoughLines, loads: int) -> dict[str, Callable[[], object]]:
    return {
        f"{title}, {load.control}, {edges}": partial(press, lines, 1.0, load, edges=edges)
        for load in load_lists(lines, loads)
        for edges in EDGES
    }


def _sliding() -> list[Measurement]:
    """Return the cost of Problem 1 relative to one np.exp per point and step."""
    heights = rough_lines(SLIDING_LINES, SLIDING_POINTS).heights
    lines = RoughLines(1e-2 * heights, 1 / SLIDING_POINTS)
    points = np.random.default_rng(0).normal(size=lines.heights.shape)

    def exponentials() -> None:
        for _ in range(SLIDING_STEPS):
            np.exp(points)

    title = f"Problem 1, {SLIDING_LINES} lines x {SLIDING_POINTS} points x {SLIDING_STEPS} steps"
    rows = []
    for load, share, target in ((1e-3, "a tenth", EXP_TARGET), (2e-2, "half", None)):
        slide = partial(slide_in_time, lines, kelvin_voigt(1.0, 1.0), steps=SLIDING_STEPS)
        tasks = {
            f"{title}, {share} in contact, v tau = {reach:g} dx": partial(
                slide, reach / SLIDING_POINTS, load
            )
            for reach in (1e-3, 1.0, 10.0, 100.0)
        }
        rows += in_turns(tasks, "np.exp per point and step", exponentials, 3, target)
    return rows
