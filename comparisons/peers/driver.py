"""Driver in a peer's process: solves of all surfaces and loads, with times of the solves only.

A driver module (`run_tamaas`, `run_contactmechanics`) makes a `Peer`; this module contains their
common part. The problem is dimensionless: E* = 1, lengths in units of the domain, heights in units
of a typical penetration (`comparisons.peers.client`), which avoids trouble with units.
"""

from __future__ import annotations

import resource
import statistics
import time
from collections.abc import Callable
from typing import Any, NamedTuple, Protocol

import numpy as np
import psutil

Problem = dict[str, Any]


class Peer(Protocol):
    """A solver with its model and kernel set up for one grid."""

    def surface(self, gap: np.ndarray) -> None:
        """Set a new surface: its gap (nx, ny), +inf where contact is impossible."""

    def step(self, load: float, tolerance: float, depth: float, start: np.ndarray) -> PeerAnswer:
        """Solve one load from an initial pressure; `depth` is a rough guess of the penetration."""


class PeerAnswer(NamedTuple):
    """A pressure with the peer's number of iterations (0: unknown), or a reason for failure."""

    pressure: np.ndarray | None
    iterations: int = 0
    reason: str = ""


def drive(problem: Problem, make: Callable[[Problem], Peer]) -> dict[str, Any]:
    """Solve a problem by the peer that `make` imports and sets up, for every repeat.

    The problem: gaps and starts (m, nx, ny), spacing, periodic, control, loads (k,), tolerance and
    depth (m, k), repeats (at most), repeat_seconds (none starts later). The answer: pressure (m, k,
    nx, ny), iterations (m, k), reasons [[row, step, text], ...], seconds and processor_seconds by
    repeat, setup_seconds, compile_seconds (imports, plans of the first solve), memory (rise of the
    peak).
    """
    begin = time.perf_counter()
    peer = make(problem)  # imports
    before = psutil.Process().memory_info().rss
    peer.surface(problem["gaps"][0])
    # The first solve plans its transforms; a loose tolerance suffices.
    peer.step(problem["loads"][0], 1e-2, problem["depth"][0, 0], problem["starts"][0])
    compile_seconds = time.perf_counter() - begin
    seconds: list[float] = []
    processor: list[float] = []
    setups: list[float] = []
    while len(seconds) < problem["repeats"]:
        if seconds and sum(seconds) > problem["repeat_seconds"]:
            break
        start, before_work = time.perf_counter(), time.process_time()
        peer = make(problem)
        setups.append(time.perf_counter() - start)
        answer = _press(problem, peer)
        seconds.append(time.perf_counter() - start)
        processor.append(time.process_time() - before_work)
    return answer | {
        "seconds": seconds,
        "processor_seconds": processor,
        "setup_seconds": statistics.median(setups),
        "compile_seconds": compile_seconds,
        "memory": float(1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before),
    }


def _press(problem: Problem, peer: Peer) -> dict[str, Any]:
    gaps, loads = problem["gaps"], problem["loads"]
    pressure = np.zeros((len(gaps), len(loads), *gaps.shape[1:]))
    iterations = np.zeros(pressure.shape[:2], dtype=int)
    reasons = []
    for row, gap in enumerate(gaps):
        peer.surface(gap)
        start = problem["starts"][row]
        for step, load in enumerate(loads):
            tolerance, depth = problem["tolerance"][row, step], problem["depth"][row, step]
            step_answer = peer.step(float(load), float(tolerance), float(depth), start)
            if step_answer.pressure is None:
                reasons.append([row, step, step_answer.reason])
                continue
            pressure[row, step] = step_answer.pressure
            iterations[row, step] = step_answer.iterations
            start = pressure[row, step]  # warm start of the next load
    return {"pressure": pressure, "iterations": iterations, "reasons": reasons}
