"""Refine the truth until its bar is a fifth of the tolerance, or say why not."""

from __future__ import annotations

from collections.abc import Callable, Generator
from dataclasses import replace

from comparisons.facts.methods import INDEPENDENT, growth
from comparisons.facts.quantities import FIELDS
from comparisons.judging.truth import choose_truth
from comparisons.solving.plan import Plan
from comparisons.solving.planning import refusal
from comparisons.tasks.solution import Solved

SHARE = 0.2
# Seconds that one refined solve may be expected to take, from the time of the last one and the
# growth of work when N doubles.
BUDGET = 600.0
# Points a side up to which a second candidate follows the truth: two answers on the finest grid.
FOLLOWED = 512


def refinements(
    plan: Plan,
    solved: Callable[[Plan], Solved],
    budget: float = BUDGET,
    enough: Callable[[Plan, Solved], bool] | None = None,
) -> Generator[Plan, None, Plan]:
    """Yield the plan with one more resolution at a time, to be solved; return the final plan.

    A scene that lists its resolutions means these: nothing is refined beyond them, and the plan
    says so where they do not suffice. The generator is asked for more when all of the last plan
    is solved, so the refinements of many scenes can go on side by side. On one rough surface a
    second candidate of other code goes along, up to `FOLLOWED` points a side.

    What is enough is by default a bar of a fifth of the tolerance in the quantity named first.
    """
    main = next((q for q in plan.compared if q not in FIELDS), None)
    target = SHARE * plan.scene.compare.tolerance
    while main is not None:
        solutions = solved(plan)
        truth = choose_truth(solutions, plan.loads.axis, plan.compared)
        if truth is None:
            return plan
        if enough(plan, solutions) if enough else truth.known_to(main) <= target:
            return plan
        if plan.scene.compare.resolutions is not None:
            note = "not refined beyond the resolutions that the scene lists"
            return replace(plan, notes=(*plan.notes, note))
        finer = 2 * truth.resolution
        expected = truth.solution.seconds * growth(truth.method)
        reason = refusal(plan, truth.method, finer)
        if not reason and expected > budget:
            reason = f"the next would take about {expected:.0f} s, more than "
            reason += f"the budget of {budget:.0f} s"
        if reason:
            note = f"refinement of {truth.method} ends at N = {truth.resolution}, "
            return replace(plan, notes=(*plan.notes, note + reason))
        single = plan.scene.rough and plan.realisations == 1 and finer <= FOLLOWED
        second = {
            planned.method
            for planned in plan.methods
            if single
            and planned.method in INDEPENDENT
            and planned.resolutions[-1:] == (truth.resolution,)
            and not refusal(plan, planned.method, finer)
        }
        methods = (
            m.finer(finer) if m.method in {truth.method, *second} else m for m in plan.methods
        )
        plan = replace(plan, methods=tuple(methods))
        yield plan
        solution = solved(plan).get((truth.method, finer))
        if solution is None or not solution.converged.any(axis=0).all():
            note = f"{truth.method} found no answer at N = {finer}"
            return replace(plan, notes=(*plan.notes, note))
    return plan
