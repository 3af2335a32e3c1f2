"""The same contact problem, pressed by a peer, and its answer measured by our own check.

Tolerances mean something else in every code: an energy in Tamaas, absolute lengths and forces in
ContactMechanics. What counts here is the violation of the contact conditions by the pressure that
comes back, evaluated in double precision with our operator; the peer's tolerance is changed until
that is as wanted.
"""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from importlib import metadata, util
from typing import Any

import numpy as np

from comparisons.isolation import parent
from comparisons.isolation.parent import Limits
from reference.halfspace import Contact, HalfSpace
from reference.halfspace.overlap import overlap_depth, overlap_pressure
from reference.halfspace.solution import Press, assemble

# Name of the method -> packages whose versions make its answer; the first is the solver.
PACKAGES = {
    "tamaas": ("tamaas",),
    "contactmechanics": ("ContactMechanics", "muGrid", "SurfaceTopography"),
}
# Timed repeats until so many or so long, as for our own methods.
REPEATS, REPEAT_SECONDS = 3, 1.0
# How often a tolerance is changed, and the share of the wanted violation that is then aimed at.
ATTEMPTS, AIM = 6, 0.5
# Loosened only when the violation is this far below the wanted one.
MUCH_BELOW = 0.25
_LOOSEST, _TIGHTEST = 1e-2, 1e-15


@dataclass(frozen=True)
class Problem:
    """Surfaces under a list of loads: gaps (m, nx, ny), one operator, loads (k,) of one control."""

    operator: HalfSpace
    gaps: np.ndarray
    control: str
    loads: np.ndarray

    def depths(self) -> np.ndarray:
        """Return a rough penetration for each surface and load, (m, k)."""
        shape = (len(self.gaps), len(self.loads))
        if self.control == "penetration":
            return np.broadcast_to(self.loads, shape)
        if self.control == "mean_gap":
            return self.gaps.mean(axis=(1, 2))[:, None] - self.loads
        rows = [[overlap_depth(self.operator, gap, f) for f in self.loads] for gap in self.gaps]
        return np.array(rows)


@dataclass
class PeerResult:
    """What a peer found, measured.

    Attributes
    ----------
    contacts : dict
        (surface, load) -> Contact; its `violation` contains tension and a force that is missed.
    reasons : dict
        (surface, load) -> why there is no answer.
    tolerance : ndarray, shape (m, k)
        The peer's own tolerance at last.
    seconds : list of float
        Wall-clock of each repeat of the whole problem inside the peer's process, set-up included,
        without imports and planning; empty where it has no answer at all.
    processor_seconds : list of float
        The same in processor time, which other work on the machine does not prolong.
    setup_seconds, compile_seconds, memory : float
        Model and kernel; imports and planned transforms; rise of the peak memory in bytes.
    """

    contacts: dict[tuple[int, int], Contact] = field(default_factory=dict)
    reasons: dict[tuple[int, int], str] = field(default_factory=dict)
    tolerance: np.ndarray = field(default_factory=lambda: np.empty((0, 0)))
    seconds: list[float] = field(default_factory=list)
    processor_seconds: list[float] = field(default_factory=list)
    setup_seconds: float = 0.0
    compile_seconds: float = 0.0
    memory: float = float("nan")

    @property
    def worst(self) -> float:
        """The largest violation of all contacts."""
        return max((c.violation for c in self.contacts.values()), default=float("nan"))


def installed(peer: str) -> bool:
    """Whether a peer can be imported; nothing is imported."""
    return util.find_spec(PACKAGES[peer][0]) is not None


def versions(peer: str) -> str:
    """Return a peer and the versions of its packages."""
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
    """Solve a problem with a peer, with a violation of at most the wanted one.

    Parameters
    ----------
    peer : {"tamaas", "contactmechanics"}
    problem : Problem
    violation : float
        Largest violation, relative; as our solvers' `tolerance`.
    limits : Limits
        Of each process.
    repeats : int
        Timed repeats, at most.
    loosen : bool
        Loosen the peer's tolerance, too, while its violation is much below the wanted one: for
        benchmarks, where equal work is compared.

    Returns
    -------
    PeerResult
        Steps that miss the violation whatever the tolerance are failures, with the reason.
    """
    tolerance = np.full((len(problem.gaps), len(problem.loads)), violation)
    best: PeerResult | None = None
    result = PeerResult()
    for _ in range(ATTEMPTS):
        result = attempt(peer, problem, tolerance, limits=limits, repeats=repeats)
        measured = _violations(result, tolerance.shape)
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
    return best or _without_misses(result, violation)


def _violations(result: PeerResult, shape: tuple[int, int]) -> np.ndarray:
    """Return the measured violations, NaN where there is no contact."""
    violations = np.full(shape, np.nan)
    for index, contact in result.contacts.items():
        violations[index] = contact.violation
    return violations


def _without_misses(result: PeerResult, violation: float) -> PeerResult:
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
    """Solve once with given tolerances (m, k) of the peer's own kind; other arguments: `press`."""
    stated, unit = _dimensionless(problem, tolerance)
    outcome = parent.run(
        f"comparisons.peers.run_{peer}:solve",
        stated | {"repeats": repeats, "repeat_seconds": repeat_seconds},
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
        pressure = unit * answer["pressure"][index]
        contact = _measured(problem, index, pressure, int(answer["iterations"][index]))
        if isinstance(contact, str):
            result.reasons[index] = contact
        else:
            result.contacts[index] = contact
    for name in ("seconds", "processor_seconds", "setup_seconds", "compile_seconds", "memory"):
        setattr(result, name, answer[name])
    return result


def _dimensionless(problem: Problem, tolerance: np.ndarray) -> tuple[dict[str, Any], float]:
    """Return the problem with E* = 1 and lengths near 1, and the unit of its pressures.

    Scales of length are powers of two; the pressure's unit follows from E* and the two.
    """
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


def _measured(
    problem: Problem, index: tuple[int, int], pressure: np.ndarray, iterations: int
) -> Contact | str:
    """Return a peer's pressure as a Contact with its violation, or what is wrong with it."""
    operator, gap = problem.operator, problem.gaps[index[0]]
    load = float(problem.loads[index[1]])
    tension = max(0.0, -float(pressure.min()))
    pressure = np.maximum(pressure, 0.0)
    mask = pressure > 0
    if not mask.any():
        return "no cell carries pressure"
    if not np.isfinite(gap[mask]).all():
        return "pressure where the shape has no material"
    if problem.control == "penetration":
        depth = load
    elif problem.control == "mean_gap":
        depth = float(gap.mean()) - load
    else:
        depth = float((gap + operator.apply(pressure))[mask].mean())
    contact = assemble(Press(operator, gap), pressure, depth, iterations, [])
    missed = abs(contact.force / load - 1) if problem.control == "force" else 0.0
    worst = max(contact.violation, tension / float(pressure[mask].mean()), missed)
    return replace(contact, violation=worst)
