"""Full effort: refine the truth until its bar is a fifth of the tolerance, or say why not."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import replace

from comparisons.facts.methods import growth
from comparisons.judging.truth import Reference, choose_reference, known_to
from comparisons.solving.planning import MethodPlan, Plan, refusal
from comparisons.tasks.solution import Solution, Solved

SHARE = 0.2
# Seconds that one refined solve may be expected to take, from the time of the last one and the
# growth of work when N doubles.
BUDGET = 600.0


def refined(
    plan: Plan,
    solved: Callable[[Plan], Solved],
    solve: Callable[[Plan], None],
    budget: float = BUDGET,
) -> Plan:
    """Return the plan with as many finer resolutions of its reference as the tolerance needs.

    Parameters
    ----------
    plan : Plan
    solved : callable
        Returns the solutions of a plan.
    solve : callable
        Solves whatever of a plan is not solved yet.
    budget : float
        Seconds that one more solve may be expected to take.
    """
    steps = refinements(plan, solved, budget)
    while True:
        try:
            enlarged = next(steps)
        except StopIteration as end:
            final: Plan = end.value
            return final
        solve(enlarged)


def refinements(
    plan: Plan, solved: Callable[[Plan], Solved], budget: float = BUDGET
) -> Generator[Plan, None, Plan]:
    """Yield the plan with one more resolution at a time, to be solved; return the final plan.

    A scene that lists its resolutions means these: nothing is refined beyond them, and the plan
    says so where they do not suffice. The generator is asked for more when all of the last plan
    is solved, so the refinements of many scenes can go on side by side.
    """
    control = plan.loads.axis
    main = next((q for q in plan.compared if q != "pressure"), None)
    wanted = SHARE * plan.scene.compare.tolerance
    while main is not None:
        known = solved(plan)
        reference = choose_reference(known, plan.compared)
        if reference is None or known_to(control, reference, main) <= wanted:
            return plan
        if plan.scene.compare.resolutions is not None:
            note = "full: not refined beyond the resolutions that the scene lists"
            return replace(plan, notes=(*plan.notes, note))
        finer = 2 * reference.resolution
        why = refusal(plan, reference.method, finer) or _over_budget(reference, known, budget)
        if why:
            note = f"full: refinement of {reference.method} ends at N = {reference.resolution}, "
            return replace(plan, notes=(*plan.notes, note + why))
        plan = replace(plan, methods=tuple(_with(m, reference, finer) for m in plan.methods))
        yield plan
        solution = solved(plan).get((reference.method, finer))
        if solution is None or not solution.converged.any(axis=0).all():
            note = f"full: {reference.method} found no answer at N = {finer}"
            return replace(plan, notes=(*plan.notes, note))
    return plan


def _over_budget(reference: Reference, known: Solved, budget: float) -> str:
    last: Solution = known[reference.method, reference.resolution]
    expected = last.seconds * growth(reference.method)
    if expected <= budget:
        return ""
    return f"the next would take about {expected:.0f} s, more than the budget of {budget:.0f} s"


def _with(planned: MethodPlan, reference: Reference, resolution: int) -> MethodPlan:
    if planned.method != reference.method:
        return planned
    return replace(planned, resolutions=(*planned.resolutions, resolution))
