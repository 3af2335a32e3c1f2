"""Cost of the FFT solver: growth with N, fraction spent in FFTs, memory per cell, the floor."""

from __future__ import annotations

import resource
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import Literal

import numpy as np
import psutil
from scipy import fft

from comparisons.isolation import parent
from comparisons.methods.normal.bem_fft import BYTES_FREE, BYTES_PERIODIC, EXTRAPOLATED, STIFFNESS
from comparisons.questions.benchmarks import bem
from comparisons.questions.benchmarks.yardstick import (
    Measurement,
    exponent,
    interleaved,
    measurement,
)
from reference.contact import pieces
from reference.contact.body import ElasticBody
from reference.contact.press import Contact, press, sweep
from reference.halfspace import FreeOperator, PeriodicOperator, areas
from reference.loads import Load

SIZES = tuple(2**k for k in range(6, 12))
LARGEST = 2048
CUTOFF = 16
TOLERANCE = 1e-8
LARGE = (1024, 2048, 4096)
# Most of the time of one thread that two may take.
SHARED = 1 / 1.7
# Largest acceptable multiple of the processor's floor for a convolution: SciPy's take some four.
FLOOR = 5.0
# Points a side of a grid that compiles all; side of matrices and length of copies that measure the
# machine (128 MB: beyond the caches of most).
_WARM, _SQUARE, _COPIED = 512, 1024, 2**25

Kind = Literal["periodic", "free"]
# What is held beside a solve, and the bytes per cell that the plan adds for it.
Beside = Literal["nothing", "a load before", "a stiffness"]
BESIDE: dict[Beside, int] = {"nothing": 0, "a load before": EXTRAPOLATED, "a stiffness": STIFFNESS}


def measure() -> list[Measurement]:
    """Return the rows: cost against N, its exponent, and peak memory of the largest grid."""
    costs = [_size(points) for points in SIZES]
    # N^2 log N is the cost of a transform
    sizes, seconds = np.array(SIZES, dtype=float), [row.seconds for row in costs]
    found = exponent(sizes, np.array(seconds))
    bound = exponent(sizes, sizes**2 * np.log(sizes))
    at_bound = seconds[0] * float((sizes[-1] / sizes[0]) ** bound)
    growth = Measurement(
        f"exponent of the cost in N per side from {SIZES[0]} to {SIZES[-1]}: {found:.2f}",
        seconds[-1],
        f"N^2 log N from the same start ({bound:.2f})",
        at_bound,
        seconds[-1] / at_bound,
    )
    return [
        *costs,
        growth,
        *(_memory(kind, beside) for kind in ("periodic", "free") for beside in BESIDE),
        *(_floor(points) for points in LARGE),
        *(_shared(points) for points in LARGE),
    ]


def _size(points: int) -> Measurement:
    """Return the cost of a solve relative to a pair of transforms, and its fraction in FFTs."""
    case, field = bem.rough(points, CUTOFF, bem.MEDIUM, None), np.ones((points, points))

    def transforms() -> object:
        return fft.irfft2(fft.rfft2(field), s=field.shape, overwrite_x=True)

    tasks: dict[str, Callable[[], object]] = {"solve": partial(case.solve, TOLERANCE)}
    times = interleaved(tasks | {"transforms": transforms}, 3, time.process_time)
    share = fft_share(case)
    return measurement(
        f"{case.name}: {share:.0%} of the time inside FFTs",
        times["solve"],
        f"rfft2 and irfft2 of {points}^2",
        times["transforms"],
    )


def fft_share(case: bem.Case) -> float:
    """Return the fraction of a solve's time spent in transforms.

    It is the number of convolutions on the finest grid in either precision times their cost; the
    coarser grids of the start are not counted.
    """
    operator, load = case.operator(), Load(case.control, float(case.loads[-1]))
    solve = partial(press, operator, case.gaps[0], load, tolerance=TOLERANCE)
    single, double = solve().convolutions
    tasks: dict[str, Callable[[], object]] = {"solve": solve}
    for name in ("float32", "float64"):
        field = np.ones(operator.shape, name)
        tasks[name] = partial(operator.convolution(name), field)
    times = interleaved(tasks, 5, time.process_time)
    cost = {name: float(np.median(samples)) for name, samples in times.items()}
    return (single * cost["float32"] + double * cost["float64"]) / cost["solve"]


def _memory(kind: Kind, beside: Beside) -> Measurement:
    """Return the largest memory per cell of a solve, measured in a separate process."""
    plan = BYTES_FREE if kind == "free" else BYTES_PERIODIC + BESIDE[beside]
    outcome = parent.run(f"{__name__}:largest", LARGEST, kind, beside, seconds=3600)
    name = f"memory of {kind} {LARGEST}^2" + (f" with {beside}" if beside != "nothing" else "")
    yardstick = f"the plan, {plan} bytes per cell"
    if not outcome.ok:
        reason = f"{name}: {outcome.reason}"
        return Measurement(reason, float("nan"), yardstick, target=1.0)
    answer = outcome.answer
    text = (
        f"{name}: {answer['bytes_per_cell']:.0f} bytes per cell with the surface and its making, "
        f"{answer['iterations']} iterations, {answer['peak'] / 1e9:.2f} GB with the whole process"
    )
    ratio = answer["bytes_per_cell"] / plan
    return Measurement(text, answer["seconds"], yardstick, None, ratio, 1.0)


def largest(points: int, kind: Kind = "periodic", beside: Beside = "nothing") -> dict[str, float]:
    """Solve a large grid at once; return what it took of this process.

    Beside it there may be a load before, or the stiffness of the contact thereafter.

    Returns
    -------
    dict
        seconds of processor time; peak, the memory of the process in bytes; bytes_per_cell, what
        surface and solve took of it; iterations; convolutions in single and in double precision;
        share of cells in contact; violation.
    """
    _solved(_WARM, kind, beside)  # compiles
    before = psutil.Process().memory_info().rss
    start = time.process_time()
    contact = _solved(points, kind, beside)
    spent = time.process_time() - start
    peak = 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
    single, double = contact.convolutions
    return {
        "seconds": spent,
        "peak": peak,
        "bytes_per_cell": (peak - before) / points**2,
        "iterations": contact.iterations,
        "single": single,
        "double": double,
        "contact": float(np.count_nonzero(contact.pressure)) / points**2,
        "violation": contact.violation,
    }


def _solved(points: int, kind: Kind, beside: Beside = "nothing") -> Contact:
    """Return the contact of a surface of 16 cells to the shortest wave, 22 to 24 % of it."""
    gap = bem.surface(points, CUTOFF)
    body, force = _half_space(points, kind)
    if beside == "a load before":
        *_, contact = sweep(body, gap, Load("force", [force / 2, force]), tolerance=TOLERANCE)
        return contact
    contact = press(body, gap, Load("force", force), tolerance=TOLERANCE)
    if beside == "a stiffness":
        contact.forget_displacement()
        areas.contact_stiffness(body, contact.mask)
    return contact


def _half_space(points: int, kind: Kind) -> tuple[ElasticBody, float]:
    operator_class = PeriodicOperator if kind == "periodic" else FreeOperator
    operator = operator_class((points, points), (1 / points, 1 / points), 1.0)
    return operator, bem.MEDIUM * bem.SLOPE / 2


def _shared(points: int) -> Measurement:
    """Compare a solve by two threads with one by one thread, in time on the wall.

    Beside it, what two threads gain that share nothing: products of matrices and copies.
    """
    gap = bem.surface(points, CUTOFF)

    def solve(threads: int) -> object:
        body, force = _half_space(points, "periodic")
        with pieces.threads(threads):
            return press(body, gap, Load("force", force), tolerance=TOLERANCE)

    tasks: dict[str, Callable[[], object]] = {"one": partial(solve, 1), "two": partial(solve, 2)}
    with ThreadPoolExecutor(2) as pool:

        def together(works: tuple[Callable[[], object], ...]) -> object:
            return list(pool.map(lambda work: work(), works))

        for name, task in _machine().items():
            tasks[name] = task
            tasks[f"{name} twice"] = partial(together, (task, _machine()[name]))
        times = interleaved(tasks, 5)
    least = {name: min(samples) for name, samples in times.items()}
    product, copy = (2 * least[name] / least[f"{name} twice"] for name in ("product", "copy"))
    return Measurement(
        f"solve of periodic {points}^2 by two threads; two that share nothing gain {product:.2f} "
        f"times in products of matrices, {copy:.2f} times in copies",
        least["two"],
        "by one thread, least of turns",
        least["one"],
        least["two"] / least["one"],
        SHARED,
    )


def _machine() -> dict[str, Callable[[], object]]:
    """Return what measures the machine: a product of matrices and a copy, in single precision."""
    matrix, product = np.ones((_SQUARE, _SQUARE), np.float32), np.empty((_SQUARE, _SQUARE), "f4")
    source, target = np.ones(_COPIED, np.float32), np.ones(_COPIED, np.float32)
    return {
        "product": partial(np.matmul, matrix, matrix, out=product),
        "copy": partial(np.copyto, target, source),
    }


def _floor(points: int) -> Measurement:
    """Compare a convolution in single precision with what this machine's processor must take.

    5 N^2 log2 N^2 operations at the speed of the product of two matrices, and three passes through
    memory (rows, columns, rows: each reads and writes as many bytes as the field has) at the speed
    of a copy; one thread, readings in turns.
    """
    operator = PeriodicOperator((points, points), (1 / points, 1 / points), 1.0)
    field = np.ones((points, points), np.float32)
    convolve, out = operator.convolution(np.float32), np.empty_like(field)
    tasks: dict[str, Callable[[], object]] = {"convolution": partial(convolve, field, out)}
    tasks |= _machine()
    times = interleaved(tasks, 5, time.process_time)
    operations = 5 * points**2 * np.log2(points**2) / (2 * _SQUARE**3)
    passes = 3 * points**2 / _COPIED
    floor = [
        operations * product + passes * copy
        for product, copy in zip(times["product"], times["copy"], strict=True)
    ]
    speed = 2e-9 * _SQUARE**3 / float(np.median(times["product"]))
    memory = 8e-9 * _COPIED / float(np.median(times["copy"]))
    yardstick = f"operations at {speed:.0f} GFlop/s and three passes at {memory:.0f} GB/s"
    name = f"convolution of periodic {points}^2 in single precision"
    return measurement(name, times["convolution"], yardstick, floor, FLOOR)
