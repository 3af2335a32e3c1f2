"""Execution of hard cases: always one outcome per method and case."""

from __future__ import annotations

import tempfile
import warnings
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any, Unpack

import numpy as np
import pandas as pd

from comparisons.errors import InputError
from comparisons.facts.methods import METHODS
from comparisons.facts.quantities import NORMAL
from comparisons.files import plain, write_table
from comparisons.formatting import relative
from comparisons.judging.levels import mean_curves
from comparisons.judging.metrics import relative_error
from comparisons.judging.truth import DISCRETISATION, ENSEMBLE, EXACT, truths
from comparisons.judging.uncertainty import combined
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import NO_GRID, Refusal
from comparisons.questions.campaign import Campaign, Options
from comparisons.questions.hard_cases.case import (
    ACCURATE,
    ACCURATE_TO,
    DEGRADED,
    NOT_FOR,
    RECORD,
    REFUSED,
    TABLE,
    Expected,
    HardCase,
    HardCasesRecord,
    OutcomeRecord,
)
from comparisons.results.folder import PAGE, Header, Layout
from comparisons.solving.execution import execute
from comparisons.solving.inquiries import Inquiry, solve_job, together
from comparisons.solving.plan import Plan
from comparisons.solving.planning import plan_scene, refusal, single_resolution
from comparisons.tasks.solution import REALISATIONS, Solution, Solved
from comparisons.tasks.task import Task

PEER = "nothing is promised for other people's code: it is shown as it is"
LOST, LEFT_OUT = "lost", "left out"
WARNED = "warned: "
Known = dict[str, tuple[np.ndarray, np.ndarray]]  # quantity -> exact values and their bars


class HardCases(Campaign[list[OutcomeRecord], HardCasesRecord]):
    """Cases, methods to be tried, and the folder of outcomes; only full effort runs slow pairs."""

    layout = Layout(RECORD, (TABLE, PAGE))

    def __init__(
        self,
        cases: Sequence[HardCase],
        methods: Sequence[str],
        directory: Path,
        **options: Unpack[Options],
    ) -> None:
        super().__init__(directory, **options)
        self.cases, self.methods = cases, methods

    def inquiries(self) -> dict[str, Inquiry[list[OutcomeRecord]]]:
        """Return one inquiry per case."""
        full = self.effort == "full"
        return {case.id: outcomes(case, self.methods, full=full) for case in self.cases}

    def record_of(
        self, header: Header, answers: Mapping[str, list[OutcomeRecord]]
    ) -> HardCasesRecord:
        """Return the outcomes of the completed cases in order."""
        return HardCasesRecord(
            **header.model_dump(),
            hard={case.id: case.hard for case in self.cases},
            outcomes=[outcome for case in self.cases for outcome in answers.get(case.id, [])],
        )

    def save(self, record: HardCasesRecord) -> None:
        """Write hard-cases.json and hard-cases.csv."""
        rows = [
            outcome.model_dump() | {"lost": " ".join(map(str, outcome.lost))}
            for outcome in record.outcomes
        ]
        table = pd.DataFrame(rows, columns=list(OutcomeRecord.model_fields))
        record.write(self.directory / RECORD)
        write_table(self.directory / TABLE, table)


def outcomes(case: HardCase, methods: Sequence[str], *, full: bool) -> Inquiry[list[OutcomeRecord]]:
    """Request the reference of a case and the solves of all methods; return the outcomes."""
    found = {
        name: OutcomeRecord(
            case=case.id, title=case.title, method=name, kind=LEFT_OUT, reason="--full runs it"
        )
        for name in methods
        if not full and name in case.slow
    }
    tried = [name for name in methods if name not in found]
    if not tried:
        return [found[name] for name in methods]
    with tempfile.TemporaryDirectory(prefix="roughline-") as folder:
        case.write_maps(Path(folder))
        try:
            plan = plan_scene(case.scene_in(Path(folder)), "full")[0]
        except InputError as refused:
            # Validation refuses the scene before any method is tried.
            reason = str(refused)
            found |= {n: _judged(case, n, kind=REFUSED, reason=reason) for n in tried}
            return [found[name] for name in methods]
        true_plan = plan
        if case.truth.scene:
            true_plan = plan_scene(case.scene_in(Path(folder), case.truth.scene), "full")[0]
    settings = []
    for name in tried:  # the resolution of a method, or why it is not asked
        kind, reason, resolution = NOT_FOR, "", case.resolutions.get(name)
        planned = next((method for method in plan.methods if method.method == name), None)
        if case.only and name not in case.expected:
            reason = case.only
        elif planned is None:
            reason = "a method for other scenes"
        elif isinstance(solver := solver_for(name, plan.scene), Refusal):
            reason = solver.reason
        else:
            if resolution is None or solver.resolutions(plan.geometry) == NO_GRID:
                levels = planned.resolutions
                resolution = single_resolution(levels, plan.geometry) if levels else 0
            kind, reason = REFUSED, "" if planned.supported else planned.reason
            if resolution and not reason:
                reason = refusal(plan, name, resolution)
        if reason:
            found[name] = _judged(case, name, kind=kind, reason=reason)
        else:
            settings.append((name, resolution or 0))
    judge, trusted = case.truth.method, list[tuple[str, int]]()
    if case.truth.formula is None and not isinstance(solver_for(judge, true_plan.scene), Refusal):
        trusted = [(judge, n) for n in case.truth.resolutions]
    solutions, solved = yield from together([_solved(plan, settings), _solved(true_plan, trusted)])
    # the reference with its bars: a formula, a closed form, or the trusted method
    known: Known = {}
    if case.truth.formula is not None:
        curves = case.truth.formula.curves(true_plan)
        known = {name: (curve, np.full(len(curve), EXACT)) for name, curve in curves.items()}
    elif references := truths(solved, true_plan.loads.axis):  # none where it refuses the scene
        truth = references[0]
        # All methods solve the same surfaces, so the scatter between surfaces is not an error; on
        # an identical grid, only the solvers differ.
        left_out = {ENSEMBLE, DISCRETISATION} if len(trusted) == 1 else {ENSEMBLE}
        for name, sources in truth.sources.items():
            parts = [bar for source, bar in sources.items() if source not in left_out]
            curve = truth.curves[name]
            known[name] = curve, combined(np.full(len(curve), EXACT), *parts)
    # the other load; of paths, histories and speed ranges the first compared quantity
    main = "force" if plan.loads.control != "force" else "penetration"
    if plan.loads.axis not in NORMAL:
        main = plan.compared[0]
    for (name, resolution), solution in solutions.items():
        lost = tuple(int(step) for step in np.flatnonzero(~solution.converged.all(axis=0)))
        reason = "; ".join(dict.fromkeys((*solution.reasons.values(), *solution.warnings)))
        measured: dict[str, Any] = {"reason": reason, "lost": lost, "resolution": resolution}
        kind = LOST
        if not solution.converged.any():
            expected = case.expected.get(name)
            # Either validation or the solver may refuse, if the reason matches the catalogue.
            if expected and expected.kind == REFUSED and expected.reason in reason:
                kind = REFUSED
        else:
            measured["seconds"] = solution.seconds
            error, bar = _largest_error(known, solution, main)
            area, area_bar = _largest_error(known, solution, "contact_area")
            if np.isfinite(error):
                kind = ACCURATE if error + bar <= ACCURATE_TO else DEGRADED
                measured |= {"error": error, "bar": bar, "area_error": area + area_bar}
            else:
                measured["reason"] = f"gives no {main}; {reason}"
        found[name] = _judged(case, name, kind=kind, **measured)
    return [found[name] for name in methods]


def solve_warned(task: Task) -> Solution:
    """Solve a task for its curves; numerical warnings are flaws, and kept with them."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("ignore")
        warnings.simplefilter("always", RuntimeWarning)
        solution = execute(task)
    solution.fields.clear()
    arithmetic = (warned for warned in caught if issubclass(warned.category, RuntimeWarning))
    solution.warnings = tuple(f"{WARNED}{warned.message}" for warned in arithmetic)
    return solution


def _solved(plan: Plan, settings: Sequence[tuple[str, int]]) -> Inquiry[Solved]:
    """Solve methods of a plan at resolutions; what is killed again and again has no answer."""
    jobs = {
        (name, n): [solve_job(task, solve_warned) for task in plan.tasks_at(name, n)]
        for name, n in settings
    }
    done = yield [job for several in jobs.values() for job in several]
    solved = {}
    for setting, several in jobs.items():
        ended = [done[job.key] for job in several]
        parts = [Solution.lost(d.job.arguments[0], d.lost) if d.lost else d.value for d in ended]
        solved[setting] = Solution.concat(parts, axis=REALISATIONS)
    return solved


def _largest_error(known: Known, solution: Solution, name: str) -> tuple[float, float]:
    """Return the largest relative error over the answered steps, and the reference's bar there."""
    curves = mean_curves(solution)
    if name not in curves or name not in known:
        return float("nan"), 0.0
    exact, bars = known[name]
    error = np.abs(relative_error(curves[name], exact, path=solution.path))
    if not np.isfinite(error).any():
        return float("nan"), 0.0
    step = int(np.nanargmax(error))
    return float(error[step]), float(bars[step])


def _judged(case: HardCase, name: str, kind: str, **found: Any) -> OutcomeRecord:
    """Return the outcome of a method, compared with its expectation."""
    expectation = case.expects(name)
    expected, deviation = PEER if METHODS[name].peer else "", ""
    if expectation is not None:
        expected = expectation_text(expectation)
        reason, lost = found.get("reason", ""), found.get("lost", ())
        total = found.get("error", np.nan) + found.get("bar", np.nan)
        area = found.get("area_error", np.nan)
        bounds = ("error", total, expectation.error), ("area off by", area, expectation.area)
        differences = [
            f"{what} {relative(error)} instead of at most {relative(most)}"
            for what, error, most in bounds
            if error > most
        ]
        if kind not in (LOST, REFUSED) and lost != expectation.lost:
            differences.append(f"lost steps {lost} instead of {expectation.lost}")
        if expectation.lost and not reason:
            differences.append("no reason is given for the lost steps")
        if expectation.reason not in reason:
            differences.append(f"the reason does not say {expectation.reason!r}")
        if WARNED in reason:
            differences.append("it warns")
        deviation = "; ".join(differences)
        better = (kind, expectation.kind) == (ACCURATE, DEGRADED)
        if kind != expectation.kind and not better:
            deviation = f"{kind} instead of {expectation.kind}"
    return OutcomeRecord(
        case=case.id,
        title=case.title,
        method=name,
        kind=kind,
        expected=expected,
        deviation=deviation,
        **plain(found),
    )


def expectation_text(expectation: Expected) -> str:
    """Return an expectation as shown in tables."""
    if expectation.kind in (REFUSED, NOT_FOR):
        return f"{expectation.kind}: {expectation.reason}"
    bounds = [f"error at most {relative(expectation.error)}"]
    if np.isfinite(expectation.area):
        bounds.append(f"area {relative(expectation.area)}")
    if expectation.lost:
        steps = ", ".join(str(step + 1) for step in expectation.lost)
        bounds.append(f"no answer at step {steps}: {expectation.text}")
    note = f" ({expectation.why})" if expectation.why else ""
    return f"{expectation.kind}, {', '.join(bounds)}{note}"
