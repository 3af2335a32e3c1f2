"""What else must be solved for a tolerance: more surfaces and lines, then finer grids.

A plan begins with a few surfaces on each grid and a thousand lines. Their variances, and what a
surface costs on each grid (measured once: `solving.plan.surface_cost`), give the cheapest
numbers for which the means scatter no more than a share of the tolerance (`levels.allocate`).
Nothing in that depends on the clock, on workers or parts: the same scene has the same numbers, and
digits, everywhere. The lines, which are free, scatter no more than three tenths of what the
surfaces may: that widens a bar by 4 % of itself at most.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import replace

import numpy as np

from comparisons.facts.methods import GRID, INDEPENDENT, METHODS, MODEL
from comparisons.facts.quantities import FIELDS
from comparisons.formatting import relative
from comparisons.judging.levels import Levels, allocate, variances, within_budget
from comparisons.judging.metrics import rms_and_maximum
from comparisons.judging.truth import choose_truth
from comparisons.solving.jobs import JobKind
from comparisons.solving.plan import Effort, Plan, surface_cost
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
) -> Iterator[Plan]:
    """Yield the plan with one more resolution at a time, to be solved, and last with its notes.

    Nothing is refined beyond resolutions that a scene lists. The generator is asked for more when
    all of the last plan is solved. On one rough surface a second candidate of other code goes
    along, up to `FOLLOWED` points a side. `enough` is by default a bar of `SHARE` of the tolerance
    in the quantity named first.
    """
    main = next((q for q in plan.compared if q not in FIELDS), None)
    target = SHARE * plan.scene.compare.tolerance
    note = ""
    while main is not None and not note:
        solutions = solved(plan)
        truth = choose_truth(solutions, plan.loads.axis, plan.compared)
        if truth is None:
            return
        if enough(plan, solutions) if enough else rms_and_maximum(truth.bar(main))[0] <= target:
            return
        finer = 2 * truth.resolution
        expected = truth.solution.seconds * METHODS[truth.method].growth
        if plan.scene.compare.resolutions is not None:
            note = "not refined beyond the resolutions that the scene lists"
            break
        reason = refusal(plan, truth.method, finer)
        if not reason and expected > budget:
            reason = f"the next would take about {expected:.0f} s, more than "
            reason += f"the budget of {budget:.0f} s"
        if reason:
            note = f"refinement of {truth.method} ends at N = {truth.resolution}, {reason}"
        else:
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
            if solution is None or not solution.answered.any(axis=0).all():
                note = f"{truth.method} found no answer at N = {finer}"
    if note:
        yield replace(plan, notes=(*plan.notes, note))


# What of the tolerance the scatter of the means may take.
SCATTER: Mapping[Effort, float] = {"quick": 0.75, "full": 0.1}
# In solves of 64 x 64 points: some seconds, and some minutes.
SURFACES_BUDGET: Mapping[Effort, float] = {"quick": 300.0, "full": 15000.0}
# The scatter of the lines is no more than this share of that; quick, as many lines as on which the
# baseline of `check` stands. And what they may cost, in points of all lines: one second, some five.
LINES_SHARE: Mapping[Effort, float] = {"quick": 0.216, "full": 0.3}
LINE_POINTS: Mapping[Effort, float] = {"quick": 1e7, "full": 5e7}
# Chosen from few surfaces, the numbers aim at somewhat less than is wanted.
_AIM = 0.95
_NORMAL = 1.96
_LEAST_PART = 0.05


def expected(plan: Plan, effort: Effort) -> list[JobKind]:
    """Return the jobs that a plan typically adds to its pilots: surfaces for all its budget."""
    grid = next((m for m in plan.methods if m.method == GRID and m.numbers), None)
    if grid is None:
        return []
    cost = np.array([surface_cost(GRID, n) for n in grid.resolutions])
    most = min(SURFACES_BUDGET[effort], plan.scene.realisations * float(cost.sum()))
    coarsest = grid.resolutions[0]
    block = plan.block(GRID, coarsest)
    blocks = (most - float(cost @ np.array(grid.numbers))) / (float(cost[0]) * block)
    return [JobKind(plan.scene.name, GRID, coarsest, block, sort="rough")] * int(blocks)


def enlarged(plan: Plan, solved: Solved, effort: Effort) -> Plan:
    """Return the plan with the surfaces and lines that its bars need, by its pilots' scatter."""
    wanted = SCATTER[effort] * plan.scene.compare.tolerance
    methods, notes = {m.method: m for m in plan.methods}, list(plan.notes)
    judged = [n for n in plan.compared if n not in FIELDS and n not in plan.loads.columns]
    for method in (GRID, MODEL):
        planned = methods.get(method)
        if planned is None or not planned.numbers:
            continue
        if not all((method, n) in solved for n in planned.resolutions):
            continue
        levels, lines = Levels.of(solved, method), method == MODEL
        means = levels.curves(planned.resolutions[-1])
        sizes = {name: np.abs(means[name]) for name in judged if name in means}
        if lines:
            # As many as make no part of the bar. A mean may scatter by a share of what the truth's
            # may; where it nearly vanishes at a load (the gap of lines that are almost closed), by
            # a share of a part of its largest value: there is no error that its scatter could hide.
            aim = _AIM * LINES_SHARE[effort] * wanted
            sizes = {n: size for n, size in sizes.items() if np.isfinite(size).any()}
            sizes = {n: np.fmax(s, _LEAST_PART * np.nanmax(s)) for n, s in sizes.items()}
            cost, budget = np.array([2.0 * n for n in planned.resolutions]), LINE_POINTS[effort]
        else:
            aim, budget = _AIM * wanted, SURFACES_BUDGET[effort]
            cost = np.array([surface_cost(GRID, n) for n in planned.resolutions])
        # the variances a_l of each mean over that allowed, (m, j); of means that allow any
        columns = [np.zeros((len(levels.solutions), 0))]
        for name, size in sizes.items():
            grids = [s.quantities[name] for s in levels.solutions.values() if name in s.quantities]
            if len(grids) == len(levels.solutions):
                with np.errstate(invalid="ignore", divide="ignore"):
                    columns.append(variances(grids) * (_NORMAL / (aim * size)) ** 2)
        needs = np.hstack(columns)
        needs = needs[:, np.isfinite(needs).all(axis=0)]
        if not needs.shape[1] and not lines:
            notes.append("numbers of surfaces: the first ones have no answer to choose them from")
            continue
        first, most = np.array(planned.numbers), 10**9 if lines else plan.scene.realisations
        needed, few = first, "the scene's realisations"
        if needs.shape[1]:
            needed = np.maximum(allocate(needs, cost, np.ones(needs.shape[1])), first)
        chosen = np.minimum(needed, most)
        if float(chosen @ cost) > max(budget, float(first @ cost)):
            least = max(budget, 3 * float(cost.sum()))
            chosen = np.maximum(within_budget(chosen, cost, least), first)
            few = f"what {budget:.0f} solves of 64 x 64 points cost"
        # whole tasks, and no more on finer grids
        blocks = np.array([plan.block(method, n) for n in planned.resolutions])
        whole = np.minimum(-(-chosen // blocks) * blocks, most)
        chosen = np.maximum.accumulate(whole[::-1])[::-1]
        if not lines and (chosen < needed).any():
            left = float(np.sqrt((needs / chosen[:, None]).sum(axis=0).max())) * _AIM * wanted
            notes.append(
                f"no more surfaces than {few}: their scatter leaves {relative(left)} instead of "
                f"{relative(wanted)} in the worst mean"
            )
        methods[method] = replace(planned, numbers=tuple(int(n) for n in chosen))
    return replace(plan, methods=tuple(methods.values()), notes=tuple(notes))
