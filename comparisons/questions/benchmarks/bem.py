"""Cost of the FFT half-space solver, with the faster of two public codes as yardstick; its growth.

All codes get the same input, one thread and a separate process, and reach the same violation of the
contact conditions: the peer's tolerance is adjusted until its own is at most ours and not much
below. Processor times include set-up, but not compilation, imports and planning of transforms.

Growth: cost against N, fraction spent in FFTs, the floor of the processor.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
from scipy import fft

from comparisons.isolation.parent import Limits
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.peers import client
from comparisons.questions.benchmarks.yardstick import Measurement, growth, interleaved, measurement
from comparisons.questions.study import Study
from comparisons.scene.scene import load_scene
from comparisons.solving.jobs import executor_for
from comparisons.solving.planning import plan_scene
from reference import surfaces
from reference.contact import pieces
from reference.contact import press as unilateral
from reference.contact.body import ElasticBody
from reference.contact.press import press
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.loads import Load

HURST, SLOPE = 0.8, 0.1
# Target contact fractions of loads, and the accepted deviation.
MEDIUM, LIGHT = 0.225, 0.04
_DEVIATION = 0.1
TOLERANCE = 1e-8
READINGS, PEER_READINGS = 3, 3
PEER_SECONDS = 1800.0
CUTOFFS = (16, 4)
# Targets: largest fractions of the faster peer's time.
MODERATE, FEW, LARGE, SWEEP = 1 / 8, 1 / 4, 1 / 10, 1 / 10
HERTZ, CROPPED, PATCHES = 1 / 20, 1 / 5, 1 / 4
SURFACES, PEER_SURFACES, POINTS, LOADS = 450, 20, 64, 15
A_MINUTE = 60.0


def measure() -> list[Measurement]:
    """Run the measurements against peers, a whole study, and what the machine could do."""
    cases = [
        rough(points, cutoff, fraction, target)
        for cutoff in CUTOFFS
        for points, fraction, target in (
            *((256, MEDIUM, MODERATE), (256, LIGHT, FEW)),
            *((512, MEDIUM, LARGE), (512, LIGHT, LARGE)),
        )
    ]
    cases += [
        rough(256, CUTOFFS[0], MEDIUM, SWEEP, 30),
        hertz(256, 40, HERTZ, cropped=False),
        hertz(256, 40, CROPPED, cropped=True),
        ensemble(PEER_SURFACES, POINTS, LOADS, PATCHES),
    ]
    costs = {points: _size(points) for points in SIZES}
    transform = "N^2 log N", lambda n: n**2 * np.log(n)
    return [
        *map(against_peers, cases),
        whole_study(),
        *costs.values(),
        growth(costs, "N per side", transform),
        *(_floor(points) for points in LARGE_GRIDS),
        *(_shared(points) for points in LARGE_GRIDS),
    ]


@dataclass(frozen=True)
class SetUp:
    """A problem that is set up again for every reading, because set-up is part of the cost.

    `target` is the largest acceptable fraction of the peer's time.
    """

    name: str
    gaps: np.ndarray
    spacing: float
    periodic: bool
    control: str
    loads: np.ndarray
    target: float | None = None

    def operator(self) -> ElasticBody:
        """Return a new operator."""
        kind = PeriodicOperator if self.periodic else FreeOperator
        return kind(self.gaps.shape[1:], (self.spacing, self.spacing), 1.0)

    def problem(self) -> client.Problem:
        """Return the problem for a peer."""
        return client.Problem(self.operator(), self.gaps, self.control, self.loads)

    def solve(self, tolerance: float) -> np.ndarray:
        """Solve all surfaces and loads with our own solver; return the violations (m, k)."""
        operator = self.operator()
        violations = []
        for gap in self.gaps:
            steps = unilateral.sweep(
                operator, gap, Load(self.control, self.loads), tolerance=tolerance
            )
            violations.append([contact.violation for contact in steps])
        return np.array(violations)


def rough(points: int, cutoff: int, fraction: float, target: float | None, steps: int = 1) -> SetUp:
    """Return a periodic self-affine surface under forces up to about a given contact fraction."""
    gap = surface(points, cutoff)
    operator = PeriodicOperator(gap.shape, (1 / points, 1 / points), 1.0)
    force, reached = fraction * SLOPE / 2, 0.0  # A/A0 = 2 F/(E* A0 h')
    while abs(reached / fraction - 1) >= _DEVIATION:
        force *= fraction / reached if reached else 1.0
        contact = unilateral.press(operator, gap, Load("force", force), tolerance=1e-3)
        reached = float(np.mean(contact.pressure > 0))
    loads = "" if steps == 1 else f"{steps} loads to "
    name = f"periodic {points}^2, cutoff {cutoff} cells, {loads}{reached:.1%} contact"
    forces = force * np.linspace(1 / steps, 1, steps)
    return SetUp(name, gap[None], 1 / points, True, "force", forces, target)


def hertz(points: int, radius: int, target: float | None, *, cropped: bool) -> SetUp:
    """Return a paraboloid on a free grid, contact radius in cells; cropped to the overlap's box."""
    side = 2 * int(np.ceil(np.sqrt(2) * radius)) if cropped else points
    # Off-centre, because real surfaces lack the symmetry of the grid.
    x = np.arange(side) - side / 2 + 0.3
    gap = (x[:, None] ** 2 + x**2) / 2 / points
    force = 4 / 3 * (radius**3 / points)
    where = f"cropped to {side}^2" if cropped else f"{points}^2"
    name = f"free Hertz, {where}, contact radius {radius} cells"
    return SetUp(name, gap[None], 1.0, False, "force", np.array([force]), target)


def ensemble(count: int, points: int, loads: int, target: float | None) -> SetUp:
    """Return free patches with all resolved waves, and forces up to half of E* A0 h'."""
    gaps = np.array([surface(points, 2, k) for k in range(count)])
    forces = SLOPE * np.geomspace(1e-3, 0.1, loads)
    name = f"{count} free {points}^2 patches x {loads} loads"
    return SetUp(name, gaps, 1 / points, False, "force", forces, target)


def surface(points: int, cutoff: int, realisation: int = 0) -> np.ndarray:
    """Return the gap of a periodic self-affine surface, in which `cutoff` cells are a wave."""
    heights = surfaces.self_affine(
        (points, points),
        (1.0, 1.0),
        surfaces.SelfAffine(hurst=HURST, rms_slope=SLOPE, short_cutoff=cutoff / points),
        seed=1,
        realisation=realisation,
    )
    return np.subtract(heights.max(), heights, out=heights)


def against_peers(case: SetUp) -> Measurement:
    """Compare our time with that of the faster peer at the same violation."""
    reached = float(case.solve(TOLERANCE).max())
    run = {"ours": partial(case.solve, TOLERANCE)}
    ours = interleaved(run, READINGS, time.process_time)["ours"]
    problem, peers = case.problem(), {}
    for peer in [peer for peer in client.PACKAGES if client.installed(peer)]:
        # The peer's tolerance is adjusted to the violation, then its times are measured.
        limits = Limits(PEER_SECONDS, MEMORY_SHARE * free_memory())
        tuned = client.press(peer, problem, reached, limits=limits, repeats=1, loosen=True)
        if tuned.reasons:
            peers[peer] = client.PeerResult(reasons=tuned.reasons)
            continue
        options: dict[str, Any] = {"repeats": PEER_READINGS, "repeat_seconds": PEER_SECONDS}
        peers[peer] = client.attempt(peer, problem, tuned.tolerance, limits=limits, **options)
    answered = {peer: solution for peer, solution in peers.items() if solution.processor_seconds}
    if not answered:
        reasons = [next(iter(peer.reasons.values()), "no answer") for peer in peers.values()]
        yardstick = "; ".join(reasons) or "no peer installed: pip install 'roughline[peers]'"
        return Measurement(case.name, statistics.median(ours), yardstick, target=case.target)
    # Measured again after the peers, so that both are measured under the same conditions.
    ours += interleaved(run, READINGS, time.process_time)["ours"]
    theirs = {peer: statistics.median(r.processor_seconds) for peer, r in answered.items()}
    faster = min(theirs, key=theirs.__getitem__)
    # Readings from separate processes cannot be paired: ours are divided by the median of the
    # peer's.
    return measurement(
        f"{case.name}, violation {reached:.0e}",
        ours,
        f"{client.PACKAGES[faster][0]}, violation {answered[faster].worst:.0e}",
        [theirs[faster]] * len(ours),
        case.target,
    )


def whole_study() -> Measurement:
    """Time the study of all surfaces on two processes as a user runs it, including files."""
    surface = {"kind": "self_affine", "hurst": HURST, "rms_slope": SLOPE}
    surface |= {"size": "1 um", "points": POINTS, "realisations": SURFACES}
    force = {"from": 1e-3, "to": 1e-1, "steps": LOADS, "spacing": "log"}
    tables = {
        "name": "ensemble",
        "half_space": {"effective_modulus": "1 GPa"},
        "surface": surface,
        "loading": {"force": force | {"relative_to": "E* A0 h'"}},
        "compare": {"methods": ["bem_fft"], "resolutions": [POINTS]},
    }
    with tempfile.TemporaryDirectory(prefix="roughline-") as name:
        folder = Path(name)
        plans = plan_scene(load_scene(tables), "full")
        start = time.perf_counter()
        Study(plans, folder / "out", effort="full", executor=executor_for(2)).run()
        spent = time.perf_counter() - start
    title = f"study of {SURFACES} free {POINTS}^2 patches x {LOADS} loads, 2 processes, all files"
    return measurement(title, [spent], "a minute", [A_MINUTE], 1.0)


SIZES = tuple(2**k for k in range(6, 12))
LARGE_GRIDS = (1024, 2048, 4096)
# Most of the time of one thread that two may take.
SHARED = 1 / 1.7
# Largest acceptable multiple of the processor's floor for a convolution: SciPy's take some four.
FLOOR = 5.0
# Side of matrices and length of copies that measure the machine (128 MB: beyond most caches).
_SQUARE, _COPIED = 1024, 2**25


def _size(points: int) -> Measurement:
    """Return the cost of a solve relative to a pair of transforms, and its fraction in FFTs.

    That is convolutions on the finest grid times their cost: without the coarser grids of the
    start.
    """
    case, field = rough(points, CUTOFFS[0], MEDIUM, None), np.ones((points, points))

    def transforms() -> object:
        return fft.irfft2(fft.rfft2(field), s=field.shape, overwrite_x=True)

    operator, load = case.operator(), Load(case.control, float(case.loads[-1]))
    counts = press(operator, case.gaps[0], load, tolerance=TOLERANCE).convolutions
    tasks: dict[str, Callable[[], object]] = {"solve": partial(case.solve, TOLERANCE)}
    tasks["transforms"] = transforms
    for name in ("float32", "float64"):
        tasks[name] = partial(operator.convolution(name), np.ones(operator.shape, name))
    times = interleaved(tasks, 3, time.process_time)
    cost = {name: statistics.median(readings) for name, readings in times.items()}
    share = (counts[0] * cost["float32"] + counts[1] * cost["float64"]) / cost["solve"]
    return measurement(
        f"{case.name}: {share:.0%} of the time inside FFTs",
        times["solve"],
        f"rfft2 and irfft2 of {points}^2",
        times["transforms"],
    )


def _shared(points: int) -> Measurement:
    """Compare two threads with one in time on the wall, beside two that share nothing."""
    gap, force = surface(points, CUTOFFS[0]), Load("force", MEDIUM * SLOPE / 2)

    def solve(threads: int) -> object:
        body = PeriodicOperator((points, points), (1 / points, 1 / points), 1.0)
        with pieces.threads(threads):
            return press(body, gap, force, tolerance=TOLERANCE)

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
