"""Cost of the FFT half-space solver, with the faster of two public codes as yardstick.

All codes get the same input, one thread and a separate process, and reach the same violation of the
contact conditions: ours results from a tolerance of 1e-8, and the peer's tolerance is adjusted
until its violation is at most the same and not much below. Times include set-up (kernel, model),
but not compilation, imports and planning of transforms. Both codes start a load from the solution
of the previous one. Processor times are used, which are independent of other load on the machine.
"""

from __future__ import annotations

import statistics
import tempfile
import time
from functools import partial
from pathlib import Path

from comparisons.isolation.parent import Limits
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.peers import client
from comparisons.questions.benchmarks import bem_cases, bem_cost, memory
from comparisons.questions.benchmarks.bem_cases import LIGHT, MEDIUM, Case
from comparisons.questions.benchmarks.yardstick import Measurement, interleaved, measurement
from comparisons.questions.study import Study
from comparisons.scene.scene import parse_scene
from comparisons.solving.planning import plan_scene

TOLERANCE = 1e-8
READINGS, PEER_READINGS = 3, 3
PEER_SECONDS = 1800.0
CUTOFFS = (16, 4)
# Targets: largest fractions of the faster peer's time.
MODERATE, FEW, LARGE, SWEEP, HERTZ, CROPPED, PATCHES = (
    1 / 8,
    1 / 4,
    1 / 10,
    1 / 10,
    1 / 20,
    1 / 5,
    0.25,
)
SURFACES, PEER_SURFACES, POINTS, LOADS = 450, 20, 64, 15
A_MINUTE = 60.0


def measure() -> list[Measurement]:
    """Run all measurements; about ten minutes, mostly for the peers."""
    rows = [against_peers(case) for case in cases()]
    rows += [whole_study(), *bem_cost.rows()]
    return [*rows, *memory.rows(memory.CASES["bem"])]


def cases() -> list[Case]:
    """Return the problems that are also solved by the peers."""
    rough_cases = []
    for cutoff in CUTOFFS:
        rough_cases += [
            bem_cases.rough(256, cutoff, MEDIUM, MODERATE),
            bem_cases.rough(256, cutoff, LIGHT, FEW),
            bem_cases.rough(512, cutoff, MEDIUM, LARGE),
            bem_cases.rough(512, cutoff, LIGHT, LARGE),
        ]
    return [
        *rough_cases,
        bem_cases.sweep(256, CUTOFFS[0], 30, SWEEP),
        bem_cases.hertz(256, 40, HERTZ, cropped=False),
        bem_cases.hertz(256, 40, CROPPED, cropped=True),
        bem_cases.ensemble(PEER_SURFACES, POINTS, LOADS, PATCHES),
    ]


def against_peers(case: Case) -> Measurement:
    """Compare our time with that of the faster peer at the same violation."""
    reached = float(case.solve(TOLERANCE).max())
    run = {"ours": partial(case.solve, TOLERANCE)}
    ours = interleaved(run, READINGS, time.process_time)["ours"]
    peers = {peer: _peer(peer, case, reached) for peer in client.PACKAGES if client.installed(peer)}
    answered = {peer: solution for peer, solution in peers.items() if solution.processor_seconds}
    if not answered:
        reasons = [next(iter(peer.reasons.values()), "no answer") for peer in peers.values()]
        yardstick = "; ".join(reasons) or "no peer installed: pip install 'roughline[peers]'"
        return Measurement(case.name, statistics.median(ours), yardstick, None, None, case.target)
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


def _peer(peer: str, case: Case, violation: float) -> client.PeerResult:
    """Adjust a peer's tolerance to the violation, then measure its times."""
    problem, limits = case.problem(), Limits(PEER_SECONDS, MEMORY_SHARE * free_memory())
    tuned = client.press(peer, problem, violation, limits=limits, repeats=1, loosen=True)
    if tuned.reasons:
        return client.PeerResult(reasons=tuned.reasons)
    return client.attempt(
        peer,
        problem,
        tuned.tolerance,
        limits=limits,
        repeats=PEER_READINGS,
        repeat_seconds=PEER_SECONDS,
    )


def whole_study() -> Measurement:
    """Time the study of all surfaces on two processes as a user runs it, including files."""
    scene = f"""
name = "ensemble"
[half_space]
effective_modulus = "1 GPa"
[surface]
kind = "self_affine"
hurst = {bem_cases.HURST}
rms_slope = {bem_cases.SLOPE}
size = "1 um"
points = {POINTS}
realisations = {SURFACES}
[loading]
force = {{ from = 1e-3, to = 1e-1, steps = {LOADS}, spacing = "log", relative_to = "E* A0 h'" }}
[compare]
methods = ["bem_fft"]
resolutions = [{POINTS}]
"""
    with tempfile.TemporaryDirectory(prefix="roughline-") as name:
        folder = Path(name)
        plans = plan_scene(parse_scene(scene, "ensemble", folder), "full")
        start = time.perf_counter()
        Study(plans, folder / "out", effort="full", workers=2).run()
        spent = time.perf_counter() - start
    title = f"study of {SURFACES} free {POINTS}^2 patches x {LOADS} loads, 2 processes, all files"
    return measurement(title, [spent], "a minute", [A_MINUTE], 1.0)
