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
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.isolation.parent import Limits
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.peers import client
from comparisons.questions.benchmarks.yardstick import Measurement, interleaved, measurement
from comparisons.questions.study import Study
from comparisons.scene.scene import parse_scene
from comparisons.solving.planning import plan_scene
from reference import surfaces
from reference.contact import press as unilateral
from reference.contact.body import ElasticBody
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.loads import Load

HURST, SLOPE = 0.8, 0.1
# Target contact fractions of loads, and the accepted deviation.
MEDIUM, LIGHT = 0.225, 0.04
_BESIDE = 0.1
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
    """Run the measurements against peers, and a whole study; some ten minutes."""
    cases = [
        rough(points, cutoff, fraction, target)
        for cutoff in CUTOFFS
        for points, fraction, target in (
            *((256, MEDIUM, MODERATE), (256, LIGHT, FEW)),
            *((512, MEDIUM, LARGE), (512, LIGHT, LARGE)),
        )
    ]
    cases += [
        sweep(256, CUTOFFS[0], 30, SWEEP),
        hertz(256, 40, HERTZ, cropped=False),
        hertz(256, 40, CROPPED, cropped=True),
        ensemble(PEER_SURFACES, POINTS, LOADS, PATCHES),
    ]
    return [*map(against_peers, cases), whole_study()]


@dataclass(frozen=True)
class Case:
    """A problem that is set up again for every reading, because set-up is part of the cost.

    `target` is the largest acceptable fraction of the peer's time.
    """

    name: str
    gaps: np.ndarray
    spacing: tuple[float, float]
    periodic: bool
    control: str
    loads: np.ndarray
    target: float | None = None

    def operator(self) -> ElasticBody:
        """Return a new operator."""
        kind = PeriodicOperator if self.periodic else FreeOperator
        return kind(self.gaps.shape[1:], self.spacing, 1.0)

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


def rough(points: int, cutoff: int, fraction: float, target: float | None) -> Case:
    """Return a periodic self-affine surface at a load with the given contact fraction."""
    gap = surface(points, cutoff)
    force, reached = _force_at(gap, fraction)
    name = f"periodic {points}^2, cutoff {cutoff} cells, {reached:.1%} contact"
    return Case(name, gap[None], _spacing(points), True, "force", np.array([force]), target)


def sweep(points: int, cutoff: int, steps: int, target: float | None) -> Case:
    """Return the same surface under increasing forces up to the default contact fraction."""
    gap = surface(points, cutoff)
    force, reached = _force_at(gap, MEDIUM)
    name = f"periodic {points}^2, cutoff {cutoff} cells, {steps} loads to {reached:.1%} contact"
    loads = force * np.linspace(1 / steps, 1, steps)
    return Case(name, gap[None], _spacing(points), True, "force", loads, target)


def hertz(points: int, radius: int, target: float | None, *, cropped: bool) -> Case:
    """Return a paraboloid on a large free grid, with the contact radius given in cells.

    If cropped, the grid is the box of the geometric overlap (sqrt(2) contact radii), which contains
    the contact.
    """
    side = 2 * int(np.ceil(np.sqrt(2) * radius)) if cropped else points
    # Off-centre, because real surfaces lack the symmetry of the grid.
    x = np.arange(side) - side / 2 + 0.3
    gap = (x[:, None] ** 2 + x**2) / 2 / points
    force = 4 / 3 * (radius**3 / points)
    where = f"cropped to {side}^2" if cropped else f"{points}^2"
    name = f"free Hertz, {where}, contact radius {radius} cells"
    return Case(name, gap[None], (1.0, 1.0), False, "force", np.array([force]), target)


def ensemble(count: int, points: int, loads: int, target: float | None) -> Case:
    """Return free patches with all resolved waves, and forces up to half of E* A0 h'."""
    gaps = np.array([surface(points, 2, k) for k in range(count)])
    forces = SLOPE * np.geomspace(1e-3, 0.1, loads)
    name = f"{count} free {points}^2 patches x {loads} loads"
    return Case(name, gaps, _spacing(points), False, "force", forces, target)


def _spacing(points: int) -> tuple[float, float]:
    return (1 / points, 1 / points)


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


def _force_at(gap: np.ndarray, fraction: float) -> tuple[float, float]:
    """Return a force with about the given fraction of cells in contact, and the actual fraction."""
    operator = PeriodicOperator(gap.shape, _spacing(len(gap)), 1.0)
    force = fraction * SLOPE / 2  # A/A0 = 2 F/(E* A0 h')
    while True:
        contact = unilateral.press(operator, gap, Load("force", force), tolerance=1e-3)
        reached = float(np.mean(contact.pressure > 0))
        if abs(reached / fraction - 1) < _BESIDE:
            return force, reached
        force *= fraction / reached


def against_peers(case: Case) -> Measurement:
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
    scene = f"""
name = "ensemble"
[half_space]
effective_modulus = "1 GPa"
[surface]
kind = "self_affine"
hurst = {HURST}
rms_slope = {SLOPE}
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
