"""The record of one scene: comparison, verdicts and summary of its solutions."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np

from comparisons.facts.quantities import FIELDS, quantity
from comparisons.formatting import count, number
from comparisons.geometry.prepare import RoughGeometry
from comparisons.judging.comparison import compare, truth_bars
from comparisons.judging.truth import NO_REFERENCE, Reference, Truth
from comparisons.judging.verdicts import NO_RESULT, Verdict
from comparisons.reasons import UNJUDGED
from comparisons.results.advice import advise
from comparisons.results.record import NOBODY, SceneRecord
from comparisons.results.rows import Rows
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
    """Compare a plan's solutions with the best reference; `fields`: files with last arrays."""
    constants = {"threads": THREADS, "machine": this_machine()}
    result = compare(plan, solved, constants, prove=prove)
    scene, truth, verification = plan.scene, result.truth, result.verification
    quantities = plan.compared
    reference = NO_REFERENCE
    disagreements: tuple[str, ...] = ()
    if truth is not None:
        titles = {planned.method: planned.title for planned in plan.methods}
        disagreements = truth.disagreements(quantities, scene.compare.tolerance, titles)
        every = truth.disagreements(quantities, titles=titles)
        small = [text for text in every if text not in disagreements]
        bars = truth_bars(plan, truth)
        fields_known = {name: np.array([bar.bar]) for name, bar in bars.items() if name in FIELDS}
        reference = Reference(
            method=truth.method,
            resolution=truth.resolution,
            text=truth.sentence(quantities, fields_known, titles),
            sources={name: truth.known_from(name) for name in quantities},
            bars=bars,
            footnotes=tuple(small),
            proved=verification,
            chance=chance(plan, truth),
        )
    record = SceneRecord(
        name=scene.name,
        title=scene.heading,
        text=scene.text,
        control=plan.loads.control,
        axis=plan.loads.axis,
        quantities=quantities,
        tolerance=scene.compare.tolerance,
        plan=plan.record,
        reference=reference,
        verdicts=result.verdicts,
        answer="",
        disagreements=(*disagreements, *(verification.sentences if verification else ())),
        rows=Rows.of(result.rows),
        distributions=Rows.of(result.distributions),
        fields=dict(fields or {}),
    )
    record = replace(record, verdicts=explained(record))
    return replace(record, answer=advise(record).sentence)


NOT_COMPUTED = "not computed by the method"


def explained(record: SceneRecord) -> tuple[Verdict, ...]:
    """Return a record's verdicts with one on each asked quantity of each setting, or why none."""
    nothing = {name: _why_unanswered(record, name) for name in record.quantities}
    verdicts = {
        (item.method, item.resolution, item.quantity, item.at): item for item in record.verdicts
    }
    for method in record.methods:
        missing = {name: _why_missing(record, name, method) for name in record.quantities}
        for level in record.resolutions_judged(method) or [0]:
            for name, reason in missing.items():
                key = (method, level, name, record.equal_at(name))
                found = verdicts.get(key)
                if found and found.word != NO_RESULT:
                    continue
                verdicts[key] = Verdict(
                    method=method,
                    resolution=float(level),
                    quantity=name,
                    at=key[-1],
                    tolerance=record.tolerance,
                    reason=nothing[name] or reason,
                    counts=not nothing[name],
                    offered=bool(nothing[name]) or reason != NOT_COMPUTED,
                )
    return tuple(verdicts.values())


def _why_unanswered(record: SceneRecord, name: str) -> str:
    if not record.reference.method:
        return "no reference: no closed form or 3-D method solved it"
    at = record.equal_at(name)
    known = (item for item in record.verdicts if (item.quantity, item.at) == (name, at))
    if any(math.isfinite(item.error) for item in known):
        return ""
    if zero := _why_zero(record, name, record.solved[name]):
        return f"zero in every answer: {zero}"
    if name in record.reference.bars:
        return "prescribed, the same for all" if name == record.control else ""
    judged = {item.quantity for item in record.verdicts if not item.reason}
    if name not in judged and not np.isfinite(record.solved[name]).any():
        return ": ".join(filter(None, [NOBODY, quantity(name).only]))
    truth = record.title_of(record.reference.method)
    return f"{UNJUDGED} ({truth})"


def _why_missing(record: SceneRecord, name: str, method: str) -> str:
    """Return why a method has no error in a quantity that others have."""
    title = record.title_of(method)
    rows, truth = (
        record.rows.where(record.rows["method"] == which)
        for which in (method, record.reference.method)
    )
    lost, untrue = ([text for text in part["reason"] if text] for part in (rows, truth))
    if method == record.reference.method:
        return lost[0] if lost else "this is the reference itself"
    if record.not_asked(method):
        return f"the {title} was not asked for"
    refused = record.unsupported
    if method in refused:
        return refused[method]
    if name in FIELDS:  # no column of the rows, and compared at the last load alone
        rows = rows.where(rows["step"] == record.steps - 1)
        lost = [reason for reason in rows["reason"] if reason]
        own = (item for item in record.verdicts if (item.method, item.quantity) == (method, name))
        gives = any(item.word != NO_RESULT for item in own)
    else:
        gives = np.isfinite(rows[name][rows["converged"]]).any()
    if lost and (gives or not rows["converged"].any()):
        return lost[0]
    if not gives or name in FIELDS:
        return NOT_COMPUTED
    true = record.setting_rows(record.reference.method, record.reference.resolution)
    if zero := _why_zero(record, name, true[name]):
        return f"zero in the reference ({zero}), but not in the {title}: no relative error"
    if untrue:
        return f"the reference has no value at these loads: {untrue[0]}"
    return f"no value of the {title} is in the reference's range of {record.equal_at(name)}"


def _why_zero(record: SceneRecord, name: str, values: np.ndarray) -> str:
    """Return why a quantity is zero at all loads; "" where it is not."""
    known = values[np.isfinite(values)]
    if not len(known) or known.any():
        return ""
    area = record.solved["contact_area"]
    if np.isfinite(area).any() and not np.nan_to_num(area).any():
        return "nothing touches at any load"
    return "nothing yields" if "plasticity" in quantity(name).physics else "nothing happens"


# F/(E* A0 h') from which on claims have compared lines with surfaces (rough_area.toml).
LIGHTEST = 1e-3
# Contacts below which the area of a single one is a large part of the whole.
FEWEST = 30
# Of the apparent area: above it contacts are few because they have merged, and surfaces alike.
MERGED = 0.1
UNKNOWN = np.array([np.nan])


def chance(plan: Plan, truth: Truth | None) -> str:
    """Return why lines that agree at the heaviest load do so by chance; "" where they do not."""
    geometry = plan.geometry
    if truth is None or not isinstance(geometry, RoughGeometry) or plan.scene.physics:
        return ""
    reasons = []
    force, area, contacts = (
        float(truth.curves.get(name, UNKNOWN)[-1])
        for name in ("force", "contact_area", "contact_count")
    )
    load = force / (plan.scene.effective_modulus * geometry.area * geometry.rms_slope)
    if load < LIGHTEST:
        reasons.append(f"F/(E* A₀ h') = {number(load)}, below {number(LIGHTEST, 1)}")
    surfaces = max(len(solution.converged) for solution in truth.levels.solutions.values())
    if area < MERGED * geometry.area and surfaces * contacts < FEWEST:
        number_of = count(surfaces * contacts)
        several = "" if number_of == "1" else "s"
        reasons.append(f"{number_of} contact{several}, fewer than {FEWEST}")
    if area < MERGED * geometry.area and surfaces == 1 and plan.scene.random:
        reasons.append("one surface of the many that its spectrum allows")
    return " and ".join(reasons)
