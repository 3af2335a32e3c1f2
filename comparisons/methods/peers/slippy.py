"""The method `slippy`: boundary elements of others under test."""

from __future__ import annotations

from typing import Any

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.methods.peers.live import Code, LiveCode
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task


class Slippy(LiveCode):
    """slippy's boundary elements, 128 x 128 cells over six contact radii for each load."""

    name = "slippy"
    code = Code("slippy", {"slippy": "0.2.0"}, "see docs/live-codes.md")
    wants = "slippy is told the depth: prescribe penetrations"

    def fail_steps(
        self, task: Task[IndenterGeometry], solution: Solution, answer: dict[str, Any]
    ) -> None:
        """Mark the steps whose iterations did not converge."""
        for step, converged in enumerate(answer["converged"]):
            if not converged:
                solution.fail((0, step), "slippy did not converge")
