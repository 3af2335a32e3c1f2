"""How long a plan would take: its coarse grids are timed, the finer ones scaled from them.

The planned solves are known in advance; how far full effort refines the reference is not, because
that depends on its error bar. Each refinement that may follow is therefore listed with its time.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from comparisons.facts.methods import METHODS, leading
from comparisons.formatting import count, duration, relative
from comparisons.judging.refinement import BUDGET, SHARE
from comparisons.solving.execution import execute
from comparisons.solving.forecast import Forecast, Kind
from comparisons.solving.plan import Plan, task_of
from comparisons.solving.planning import refusal

# A solve of this many seconds can be scaled from; shorter ones are mostly start-up.
TELLING = 0.2


@dataclass(frozen=True)
class ExpectedTime:
    """Expected seconds of a plan.

    Attributes
    ----------
    planned : float
        Of all solves that are planned.
    reference : str
        The method that would be refined; empty if it is exact or the scene lists its grids.
    refined : tuple of (int, float)
        Every finer grid that full effort may add, with the seconds of its solves.
    end : str
        Why the last grid is the last.
    """

    planned: float
    reference: str = ""
    refined: tuple[tuple[int, float], ...] = ()
    end: str = ""

    def sentence(self, plan: Plan) -> str:
        """Return the expected time as a sentence."""
        text = f"about {duration(self.planned)} for the planned solves"
        if not self.refined:
            return f"{text}; {self.end}"
        finer = ", ".join(f"N = {count(n)} {duration(seconds)}" for n, seconds in self.refined)
        goal = relative(SHARE * plan.scene.compare.tolerance)
        return (
            f"{text}; while the error bar of the reference exceeds {goal}, also "
            f"{METHODS[self.reference].title} at {finer}; then {self.end}"
        )


def expected_time(plan: Plan) -> ExpectedTime:
    """Time the coarse grids of a plan of full effort, and scale them by the growth of work.

    Each method is solved on finer and finer grids until a solve takes TELLING seconds.
    """
    forecast = Forecast()
    for planned in plan.methods:
        for resolution in planned.resolutions if planned.supported else ():
            block = plan.blocks(planned.method, resolution)[0]
            task = task_of(plan, planned.method, resolution, block)
            seconds = execute(task, repeats=1).seconds
            forecast.learn(Kind.of(task), seconds)
            if not seconds < TELLING:
                break
    costs = [forecast.cost(Kind.of(task)) for task in plan.tasks]
    return _with_refinements(plan, forecast, sum(cost for cost in costs if cost))


def _with_refinements(plan: Plan, forecast: Forecast, planned: float) -> ExpectedTime:
    candidates = {item.method: item for item in plan.methods if item.supported}
    best = next((name for name in leading(candidates) if not METHODS[name].peer), "")
    if not best or METHODS[best].exact:
        return ExpectedTime(planned, end="no reference is refined")
    if plan.scene.compare.resolutions is not None:
        return ExpectedTime(planned, end="the scene lists its resolutions")
    number, finest = candidates[best].resolutions[-1], candidates[best].resolutions[-1]
    surfaces = plan.number(best, finest)
    refined: list[tuple[int, float]] = []
    while True:
        number *= 2
        end = refusal(plan, best, number)
        seconds = forecast.cost(Kind(plan.scene.name, best, number)) or math.inf
        if not end and seconds * surfaces > BUDGET:
            end = f"the budget of {duration(BUDGET)} per grid is spent"
        if end:
            return ExpectedTime(planned, best, tuple(refined), end)
        refined.append((number, seconds * surfaces))
