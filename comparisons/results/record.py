"""The record of one scene: its solutions compared, judged and put into words."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from comparisons.files import plain
from comparisons.judging.comparison import compare, truth_bars
from comparisons.judging.truth import Reference, disagreements, known_from, known_to, sentence
from comparisons.machine import versions, versions_text
from comparisons.results.advice import advise
from comparisons.results.store import SceneRecord
from comparisons.solving.execution import THREADS, this_machine
from comparisons.solving.planning import Plan
from comparisons.tasks.solution import Solved


def record_scene(
    plan: Plan, solved: Solved, fields: Mapping[tuple[str, int], Path] | None = None
) -> SceneRecord:
    """Compare the solutions of a plan with their best reference, and say what follows.

    Parameters
    ----------
    plan : Plan
    solved : dict
        (method, resolution) -> Solution.
    fields : mapping, optional
        (method, resolution) -> file with the arrays at the last load.
    """
    constants = {
        "threads": THREADS,
        "versions": versions_text(versions()),
        "machine": this_machine(),
    }
    result = compare(plan, solved, constants)
    scene, axis, reference = plan.scene, plan.loads.axis, result.reference
    asked = plan.compared
    record = SceneRecord(
        name=scene.name,
        title=scene.heading,
        text=scene.text,
        control=plan.loads.control,
        axis=axis,
        quantities=asked,
        tolerance=scene.compare.tolerance,
        plan=plan.document(),
        reference={} if reference is None else _reference_document(plan, solved, reference),
        answer="",
        disagreements=disagreements(solved, reference, asked),
        rows=result.rows,
        measures=result.measures,
        fields=dict(fields or {}),
    )
    return replace(record, answer=advise(record).sentence)


def _reference_document(plan: Plan, solved: Solved, reference: Reference) -> dict[str, Any]:
    axis, asked = plan.loads.axis, plan.compared
    return {
        "method": reference.method,
        "resolution": reference.resolution,
        "text": sentence(axis, reference, asked),
        "uncertainty": plain({name: known_to(axis, reference, name) for name in asked}),
        "sources": plain({name: known_from(axis, reference, name) for name in asked}),
        "bars": plain(truth_bars(plan, solved, reference)),
    }
