"""Memory that the plan expects of a solve against what it takes: rows of ``roughline bench``."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path
from typing import Any, NamedTuple

from comparisons.files import read_toml
from comparisons.isolation import parent
from comparisons.methods.registry import planned_solver
from comparisons.questions.benchmarks.yardstick import Measurement
from comparisons.scene.scene import Scene, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

# Largest ratio of plan and measured memory, either way.
WITHIN = 1.2
_SECONDS = 3600.0
_USUAL: dict[str, Any] = {
    "name": "memory",
    "half_space": {"youngs_modulus": 1.0, "poisson_ratio": 0.3},
    "loading": {"penetration": [1e-3, 1e-2]},
}


class Case(NamedTuple):
    """A way through a method at several resolutions."""

    title: str
    scene: dict[str, Any]
    resolutions: tuple[int, ...]
    method: str = "fem"

    def at(self, resolution: int) -> Scene:
        """Return the scene at one resolution."""
        chosen = {"methods": [self.method], "resolutions": [resolution]}
        compare = {"compare": chosen | self.scene.get("compare", {})}
        return load_scene({**_USUAL, **self.scene, **compare})


CASES = {
    kind: [Case(**case) for case in cases]
    for kind, cases in read_toml(Path(__file__).with_suffix(".toml")).items()
}


def rows(cases: Iterable[Case]) -> list[Measurement]:
    """Return a row for each case and resolution, each case measured in a process of its own."""
    yardstick, measured = "the plan, either way (ratio of both)", []
    for case in cases:
        work = f"{__name__}:{expected_and_taken.__name__}"
        outcome = parent.run(work, *case, seconds=_SECONDS)
        if not outcome.ok:
            text = f"memory of {case.title}: {outcome.reason}"
            measured.append(Measurement(text, float("nan"), yardstick, target=WITHIN))
            continue
        found = zip(case.resolutions, outcome.answer["memory"], strict=True)
        for resolution, (plan, taken, spent) in found:
            text = f"memory of {case.title}, {resolution}: {taken / 1e6:.0f} MB, "
            text += f"{plan / 1e6:.0f} MB by the plan"
            ratio = float(max(plan / taken, taken / plan))
            measured.append(Measurement(text, spent, yardstick, None, ratio, WITHIN))
    return measured


def expected_and_taken(*case: Any) -> dict[str, list[list[float]]]:
    """Return bytes by the plan, those of a second solve (the first compiles) and its seconds."""
    described, measured = Case(*case), []
    for resolution in described.resolutions:
        (plan, *_) = plan_scene(described.at(resolution), "full")
        task = task_of(plan, described.method, resolution)
        _, solution = execute(task, 1), execute(task, 1)
        if not solution.converged.all():
            raise RuntimeError(f"{described.title}, {resolution}: no answer")
        measured.append([planned_solver(task).memory(task), solution.memory, solution.seconds])
    return {"memory": measured}
