"""The record of one scene: comparison, verdicts and summary of its solutions."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

from comparisons.judging.comparison import compare, truth_bars
from comparisons.judging.proofs import Verification
from comparisons.judging.reference import NO_REFERENCE, Reference
from comparisons.judging.truth import Truth
from comparisons.results.advice import advise
from comparisons.results.reasons import explained
from comparisons.results.rows import Rows
from comparisons.results.store import SceneRecord
from comparisons.solving.execution import THREADS, this_machine
from comparisons.solving.plan import Plan
from comparisons.tasks.solution import Solved


def record_scene(
    plan: Plan,
    solved: Solved,
    fields: Mapping[tuple[str, int], Path] | None = None,
    *,
    prove: bool = True,
) -> SceneRecord:
    """Compare the solutions of a plan with the best reference, and record verdicts and advice.

    Parameters
    ----------
    plan : Plan
    solved : dict
        (method, resolution) -> Solution.
    fields : mapping, optional
        (method, resolution) -> file with the arrays at the last load.
    prove : bool
        As of `comparisons.judging.comparison.compare`.
    """
    constants = {"threads": THREADS, "machine": this_machine()}
    result = compare(plan, solved, constants, prove=prove)
    scene, truth, verification = plan.scene, result.truth, result.verification
    quantities = plan.compared
    record = SceneRecord(
        name=scene.name,
        title=scene.heading,
        text=scene.text,
        control=plan.loads.control,
        axis=plan.loads.axis,
        quantities=quantities,
        tolerance=scene.compare.tolerance,
        plan=plan.record,
        reference=NO_REFERENCE if truth is None else _reference(plan, truth, verification),
        verdicts=result.verdicts,
        answer="",
        disagreements=(
            *(() if truth is None else truth.disagreements(quantities, scene.compare.tolerance)),
            *(() if verification is None else verification.sentences),
        ),
        rows=Rows.of(result.rows),
        distributions=Rows.of(result.distributions),
        fields=dict(fields or {}),
    )
    record = replace(record, verdicts=explained(record))
    return replace(record, answer=advise(record).sentence)


def _reference(plan: Plan, truth: Truth, verification: Verification | None) -> Reference:
    quantities = plan.compared
    told = truth.disagreements(quantities, plan.scene.compare.tolerance)
    return Reference(
        method=truth.method,
        resolution=truth.resolution,
        text=truth.sentence(quantities),
        uncertainty={name: truth.known_to(name) for name in quantities},
        sources={name: truth.known_from(name) for name in quantities},
        bars=truth_bars(plan, truth),
        footnotes=tuple(text for text in truth.disagreements(quantities) if text not in told),
        proved=verification,
    )
