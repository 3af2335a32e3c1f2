"""Solution of a contact problem by a peer, with our own check of the answer.

Tolerances differ in meaning: an energy in Tamaas, absolute lengths and forces in ContactMechanics.
Therefore the violation of the contact conditions by the returned pressure is evaluated in double
precision with our operator, and the peer's tolerance is adjusted until the violation is as
requested.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from importlib import metadata, util
from typing import Any

import numpy as np

from comparisons.isolation import parent
from comparisons.isolation.parent import Limits
from reference.contact.body import ElasticBody
from reference.contact.press import assemble, certify, overlap_depth, overlap_pressure
from reference.halfspace import Contact
from reference.loads import Load

# Method -> packages whose versions determine its answer; the first is the solver.
PACKAGES = {
    "tamaas": ("tamaas",),
    "contactmechanics": ("ContactMechanics", "muGrid", "SurfaceTopography"),
}
# Largest number and duration (s) of timed repeats, as for our own methods.
REPEATS, REPEAT_SECONDS = 3, 1.0
# Number of changes of a tolerance, and the target as a fraction of the requested violation.
ATTEMPTS, AIM = 6, 0.5
# The tolerance is loosened only if the violation is below this fraction of the requested one.
MUCH_BELOW = 0.25
_LOOSEST, _TIGHTEST = 1e-2, 1e-15


@dataclass(frozen=True)
class Problem:
    """Surfaces under a list of loads: gaps (m, nx, ny), one operator, loads (k,) of one control."""

    operator: ElasticBody
    gaps: np.ndarray
    control: str
    loads: np.ndarray

    def depths(self) -> np.ndarray:
        """Return rough penetrations (m, k) for all surfaces and loads."""
        shape = (len(self.gaps), len(self.loads))
        if self.control == "penetration":
            return np.broadcast_to(self.loads, shape)
        if self.control == "mean_gap":
            return self.gaps.mean(axis=(1, 2))[:, None] - self.loads
        rows = [[overlap_depth(self.operator, gap, f) for f in self.loads] for gap in self.gaps]
        return np.array(rows)


@dataclass
class PeerResult:
    """Answers of a peer, with measured violations and times."""

    # (surface, load) -> Contact; its `violation` includes tension and the error in force.
    contacts: dict[tuple[int, int], Contact] = field(default_factory=dict)
    # (surface, load) -> reason for a missing answer.
    reasons: dict[tuple[int, int], str] = field(default_factory=dict)
    # (m, k), the peer's tolerance in the last attempt.
    tolerance: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    # Wall-clock times of the repeats of the whole problem inside the peer's process, with set-up,
    # without imports and planning; empty if there is no answer.
    seconds: list[float] = field(default_factory=list)
    # The same in processor time, which is independent of other load on the machine.
    processor_seconds: list[float] = field(default_factory=list)
    # Model and kernel; imports and planned transforms; rise of the peak memory in bytes.
    setup_seconds: float = 0.0
    compile_seconds: float = 0.0
    memory: float = float("nan")

    @property
    def worst(self) -> float:
        """The largest violation of all contacts."""
        return max((c.violation for c in self.contacts.values()), default=float("nan"))


def installed(peer: str) -> bool:
    """Return whether a peer is installed, without importing it."""
    return util.find_spec(PACKAGES[peer][0]) is not None


def versions(peer: str) -> str:
    """Return the name of a peer and the versions of its packages."""
    return ", ".join(f"{name} {metadata.version(name)}" for name in PACKAGES[peer])


def press(
    peer: str,
    problem: Problem,
    violation: float,
    *,
    limits: Limits,
    repeats: int = REPEATS,
    loosen: bool = False,
) -> PeerResult:
    """Solve a problem with a peer to at most a relative violation, as `tolerance` of our solvers.

    `loosen` also loosens its tolerance if the violation is much below, for benchmarks at equal
    accuracy. Steps that exceed the violation at every tolerance are failures, with the reason.
    """
    tolerance = np.full((len(problem.gaps), len(problem.loads)), violation)
    best: PeerResult | None = None
    result = PeerResult()
    for _ in range(ATTEMPTS):
        result = attempt(peer, problem, tolerance, limits=limits, repeats=repeats)
        measured = np.full(tolerance.shape, np.nan)  # of missing answers
        for index, contact in result.contacts.items():
            measured[index] = contact.violation
        bad = measured > violation
        if not bad.any():
            if best is None or result.worst > best.worst:
                best = result
            far = measured < MUCH_BELOW * violation
            if not (loosen and far.any()):
                return best
            bad = far
        elif best is not None:  # loosened too far
            return best
        factor = AIM * violation / np.maximum(measured, 1e-3 * violation)
        changed = np.where(bad, tolerance * np.clip(factor, 1e-3, 1e3), tolerance)
        changed = np.clip(changed, _TIGHTEST, _LOOSEST)
        if (changed == tolerance).all():
            break
        tolerance = changed
    if best is not None:
        return best
    for index, contact in list(result.contacts.items()):
        if contact.violation > violation:
            result.reasons[index] = (
                f"violates the contact conditions by {contact.violation:.1e}, more than "
                f"{violation:.1e}, whatever its own tolerance ({result.tolerance[index]:.0e})"
            )
            del result.contacts[index]
    return result


def attempt(
    peer: str,
    problem: Problem,
    tolerance: np.ndarray,
    *,
    limits: Limits,
    repeats: int = REPEATS,
    repeat_seconds: float = REPEAT_SECONDS,
) -> PeerResult:
    """Solve once with given tolerances (m, k) of the peer; other arguments as in `press`."""
    stated, unit = _dimensionless(problem, tolerance)
    outcome = parent.run(
        "comparisons.peers.driver:solve",
        stated | {"repeats": repeats, "repeat_seconds": repeat_seconds},
        peer,
        seconds=limits.seconds,
        memory=limits.memory,
    )
    result = PeerResult(tolerance=tolerance)
    if not outcome.ok:
        reason = f"{outcome.ended}: {outcome.reason}"
        result.reasons = dict.fromkeys(np.ndindex(*tolerance.shape), reason)
        return result
    answer = outcome.answer
    result.reasons = {(row, step): reason for row, step, reason in answer["reasons"]}
    for index in np.ndindex(*tolerance.shape):
        if index in result.reasons:
            continue
        # the answer as a contact with its violation, or why it is none
        operator, gap = problem.operator, problem.gaps[index[0]]
        load = float(problem.loads[index[1]])
        signed = unit * answer["pressure"][index]
        tension, pressure = max(0.0, -float(signed.min())), np.maximum(signed, 0.0)
        mask = pressure > 0
        if not mask.any():
            result.reasons[index] = "no cell carries pressure"
            continue
        if not np.isfinite(gap[mask]).all():
            result.reasons[index] = "pressure where the shape has no material"
            continue
        if problem.control == "penetration":
            depth = load
        elif problem.control == "mean_gap":
            depth = float(gap.mean()) - load
        else:
            depth = float((gap + operator.apply(pressure))[mask].mean())
        iterations = int(answer["iterations"][index])
        contact = assemble(operator, gap, pressure, depth, iterations, [])
        found = certify(operator, gap, Load(problem.control, load), contact)
        worst = max(found, tension / float(pressure[mask].mean()))
        result.contacts[index] = replace(contact, violation=worst)
    for name in ("seconds", "processor_seconds", "setup_seconds", "compile_seconds", "memory"):
        setattr(result, name, answer[name])
    return result


def _dimensionless(problem: Problem, tolerance: np.ndarray) -> tuple[dict[str, Any], float]:
    """Return the problem with E* = 1 and lengths near 1, and its unit of pressure."""
    operator, depths = problem.operator, problem.depths()
    side = 2.0 ** np.round(np.log2(operator.shape[0] * operator.spacing[0]))
    height = 2.0 ** np.round(np.log2(depths.max()))
    unit = operator.effective_modulus * height / side
    starts = [
        overlap_pressure(operator, gap, depth[0]) / unit
        for gap, depth in zip(problem.gaps, depths, strict=True)
    ]
    load = unit * side**2 if problem.control == "force" else height
    return {
        "gaps": problem.gaps / height,
        "starts": np.array(starts),
        "spacing": tuple(step / side for step in operator.spacing),
        "periodic": operator.periodic,
        "control": problem.control,
        "loads": problem.loads / load,
        "tolerance": tolerance,
        "depth": depths / height,
    }, unit
