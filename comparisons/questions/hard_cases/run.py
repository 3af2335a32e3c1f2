"""Hard cases run: one outcome for every method and case, whatever happens."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.errors import InputError
from comparisons.facts.methods import METHODS
from comparisons.formatting import relative
from comparisons.judging.levels import mean_curves
from comparisons.judging.metrics import relative_error
from comparisons.judging.truth import ENSEMBLE, EXACT, GRID, truths
from comparisons.judging.uncertainty import combined
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal
from comparisons.questions.hard_cases.case import (
    ACCURATE,
    ACCURATE_TO,
    DEGRADED,
    NOT_FOR,
    REFUSED,
    Expected,
    HardCase,
)
from comparisons.questions.hard_cases.formulas import Curves
from comparisons.solving.execution import execute
from comparisons.solving.executors import Executor, Job, SerialExecutor
from comparisons.solving.planning import EXACT as EXACT_LEVELS
from comparisons.solving.planning import Plan, plan_scene, refusal, single_resolution, task_of
from comparisons.tasks.solution import REALISATIONS, Solution, Solved

# Bytes that the methods of a case are taken to need, one after the other.
MEMORY = 2e9
PEER = "nothing is promised for other people's code: it is shown as it is"
LOST, LEFT_OUT = "lost", "left out"


@dataclass(frozen=True)
class Outcome:
    """What one method did with one case.

    Attributes
    ----------
    case, title, method : str
    kind : str
        "accurate", "degraded", "refused", "not for", or "lost" (no number where one was meant).
    error, area_error, bar : float
        Largest relative errors over the load steps (main quantity, contact area) and the bar of the
        truth at the main quantity; NaN where there is none.
    seconds : float
    resolution : int
        0 where nothing was solved.
    reason : str
        Why there is no number, or why steps are lost.
    lost : tuple of int
        Load steps without an answer.
    expected : str
        The expectation in words; "" where there is none (a method from outside).
    deviation : str
        How the outcome differs from the expectation; "" where it does not.
    """

    case: str
    title: str
    method: str
    kind: str
    error: float = float("nan")
    area_error: float = float("nan")
    bar: float = float("nan")
    seconds: float = float("nan")
    resolution: int = 0
    reason: str = ""
    lost: tuple[int, ...] = ()
    expected: str = ""
    deviation: str = ""


@dataclass(frozen=True)
class _Truth:
    curves: Curves
    bars: Curves


def run_cases(
    cases: Iterable[HardCase],
    methods: Iterable[str],
    *,
    full: bool,
    executor: Executor | None = None,
) -> Iterator[list[Outcome]]:
    """Yield the outcomes of each case; without `full`, slow pairs are left out, and say so.

    With several workers the cases come in the order in which they are finished.
    """
    executor, methods = executor or SerialExecutor(), list(methods)
    known = {case.id: case for case in cases}
    executor.add(
        Job(case.id, _run_chosen, (case, methods, full), MEMORY) for case in known.values()
    )
    for done in executor.finished():
        case = known[done.job.key]
        yield done.value or [
            Outcome(case.id, case.title, name, LOST, reason=done.lost) for name in methods
        ]


def _run_chosen(case: HardCase, methods: list[str], full: bool) -> list[Outcome]:
    chosen = [name for name in methods if full or name not in case.slow]
    found = {each.method: each for each in run_case(case, chosen)} if chosen else {}
    return [
        found.get(name) or Outcome(case.id, case.title, name, LEFT_OUT, reason="--full runs it")
        for name in methods
    ]


def run_case(case: HardCase, methods: Iterable[str]) -> list[Outcome]:
    """Return what each of the methods does with a case."""
    with tempfile.TemporaryDirectory(prefix="roughline-") as folder:
        case.write_maps(Path(folder))
        try:
            plan = plan_scene(case.scene_in(Path(folder)), "full")[0]
        except InputError as error:
            # The door refuses before any method sees the scene.
            return [_judged(case, name, kind=REFUSED, reason=str(error)) for name in methods]
        truth = _truth(case, plan, Path(folder))
        return [_outcome(case, plan, truth, name) for name in methods]


def _outcome(case: HardCase, plan: Plan, truth: _Truth, name: str) -> Outcome:
    if case.only and name not in case.expected:
        return _judged(case, name, kind=NOT_FOR, reason=case.only)
    (planned,) = [each for each in plan.methods if each.method == name]
    resolution = case.resolutions.get(name)
    solver = solver_for(name, plan.scene)
    if isinstance(solver, Refusal):
        return _judged(case, name, kind=NOT_FOR, reason=solver.reason)
    if resolution is None or solver.resolutions(plan.geometry) == EXACT_LEVELS:
        levels = planned.resolutions
        resolution = single_resolution(levels, plan.geometry) if levels else 0
    why = planned.reason if not planned.supported else ""
    if resolution and not why:
        why = refusal(plan, name, resolution)
    if why:
        return _judged(case, name, kind=REFUSED, reason=why)
    solution, warned = _solve(plan, name, resolution)
    return _measured(case, plan, truth, name, resolution, solution, warned)


def _solve(plan: Plan, name: str, resolution: int) -> tuple[Solution, list[str]]:
    """Solve all blocks; a warning of the numerics is a flaw, and is told."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", RuntimeWarning)
        tasks = [task_of(plan, name, resolution, block) for block in plan.blocks(name, resolution)]
        solution = Solution.concat([execute(task) for task in tasks], axis=REALISATIONS)
    texts = [str(each.message) for each in caught if issubclass(each.category, RuntimeWarning)]
    return solution, list(dict.fromkeys(texts))


def _measured(
    case: HardCase,
    plan: Plan,
    truth: _Truth,
    name: str,
    resolution: int,
    solution: Solution,
    warned: list[str],
) -> Outcome:
    lost = tuple(int(step) for step in np.flatnonzero(~solution.converged.all(axis=0)))
    reasons = list(dict.fromkeys(solution.reasons.values()))
    reason = "; ".join([*reasons, *(f"warned: {text}" for text in warned)])
    common: dict[str, Any] = {"reason": reason, "lost": lost, "resolution": resolution}
    if not solution.converged.any():
        expected = case.expected.get(name)
        # Whether the door or the solver refuses is no matter, if it says what the catalogue says.
        meant = expected is not None and expected.kind == REFUSED and expected.reason in reason
        return _judged(case, name, kind=REFUSED if meant else LOST, **common)
    common["seconds"] = solution.seconds
    main = main_quantity(plan)
    error, bar = _largest_error(truth, solution, main)
    area, area_bar = _largest_error(truth, solution, "contact_area")
    if not np.isfinite(error):
        return _judged(case, name, kind=LOST, **common | {"reason": f"gives no {main}; {reason}"})
    kind = ACCURATE if error + bar <= ACCURATE_TO else DEGRADED
    return _judged(
        case, name, kind=kind, error=error, bar=bar, area_error=area + area_bar, **common
    )


def main_quantity(plan: Plan) -> str:
    """Return what a case is judged by: the other load, or what the physics of the scene is about.

    Along a path, in time or over speeds that is the first quantity that is compared.
    """
    if not plan.loads.compares_itself:
        return plan.compared[0]
    return "force" if plan.loads.control != "force" else "penetration"


def _largest_error(truth: _Truth, solution: Solution, name: str) -> tuple[float, float]:
    """Return the largest relative error over the answered steps, and the truth's bar there."""
    curves = mean_curves(solution)
    if name not in curves or name not in truth.curves:
        return float("nan"), 0.0
    error = np.abs(relative_error(curves[name], truth.curves[name], path=solution.path))
    if not np.isfinite(error).any():
        return float("nan"), 0.0
    step = int(np.nanargmax(error))
    return float(error[step]), float(truth.bars[name][step])


def _truth(case: HardCase, plan: Plan, folder: Path) -> _Truth:
    """Return what the case is judged by: a formula, the closed form, or a trusted method."""
    truth = case.truth
    if truth.formula is not None:
        curves = truth.formula.curves(plan)
        return _Truth(curves, {name: np.full(len(v), EXACT) for name, v in curves.items()})
    if truth.scene:
        plan = plan_scene(case.scene_in(folder, truth.scene), "full")[0]
    solved: Solved = {
        (truth.method, n): _solve(plan, truth.method, n)[0] for n in truth.resolutions
    }
    trusted = next(iter(truths(solved, plan.loads.axis)), None)
    if trusted is None:  # the trusted method refuses the scene, as others are expected to
        return _Truth({}, {})
    # All methods solve the same surfaces, so the scatter between surfaces is no error; and on the
    # very same grid only the solver is in doubt.
    left_out = {ENSEMBLE, GRID} if len(truth.resolutions) == 1 else {ENSEMBLE}
    bars = {
        name: combined(
            np.full(len(trusted.curves[name]), EXACT),
            *(bar for source, bar in sources.items() if source not in left_out),
        )
        for name, sources in trusted.sources.items()
    }
    return _Truth(trusted.curves, bars)


def _judged(case: HardCase, name: str, **found: Any) -> Outcome:
    outcome = Outcome(case.id, case.title, name, **found)
    expectation = case.expects(name)
    if expectation is None and METHODS[name].peer:
        return replace(outcome, expected=PEER)
    if expectation is None:
        return outcome
    return replace(outcome, expected=words(expectation), deviation=_deviation(outcome, expectation))


def words(expectation: Expected) -> str:
    """Return an expectation as the table shows it."""
    if expectation.kind in (REFUSED, NOT_FOR):
        return f"{expectation.kind}: {expectation.reason}"
    bounds = [f"error at most {relative(expectation.error)}"]
    if np.isfinite(expectation.area):
        bounds.append(f"area {relative(expectation.area)}")
    if expectation.lost:
        steps = ", ".join(str(step + 1) for step in expectation.lost)
        bounds.append(f"no answer at step {steps}: {expectation.text}")
    why = f" ({expectation.why})" if expectation.why else ""
    return f"{expectation.kind}, {', '.join(bounds)}{why}"


def _deviation(outcome: Outcome, expectation: Expected) -> str:
    """Return in words how an outcome differs from what was expected, "" where it does not."""
    allowed = {DEGRADED: (ACCURATE, DEGRADED)}  # better than expected is as expected
    if outcome.kind not in allowed.get(expectation.kind, (expectation.kind,)):
        return f"{outcome.kind} instead of {expectation.kind}"
    found = []
    total = outcome.error + outcome.bar
    if total > expectation.error:
        found.append(f"error {relative(total)} instead of at most {relative(expectation.error)}")
    if outcome.area_error > expectation.area:
        found.append(
            f"area off by {relative(outcome.area_error)} instead of at most "
            f"{relative(expectation.area)}"
        )
    if outcome.kind not in (LOST, REFUSED) and outcome.lost != expectation.lost:
        found.append(f"lost steps {outcome.lost} instead of {expectation.lost}")
    if expectation.lost and not outcome.reason:
        found.append("no reason is given for the lost steps")
    if expectation.reason not in outcome.reason:
        found.append(f"the reason does not say {expectation.reason!r}")
    if "warned: " in outcome.reason:
        found.append("it warns")
    return "; ".join(found)
