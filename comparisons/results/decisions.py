"""Which verdicts decide: on each quantity of a setting, a method or a scene; what bars stand for.

Every quantity is judged once, at equal prescribed load (the prescribed one, force or penetration,
at an equal value of the other), by the step that `comparisons.judging.verdicts.judged` selects.
The page, the terminal, advice, tables and notebooks all use these words and numbers. Errors at the
other load are listed (`second_rows`) but never affect a verdict. A bar is one of 95 % where
calibration shows it, else an estimate by the same rules (`confidence`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import Any

from comparisons.facts.methods import METHODS, MODEL, NOT_ASKED, is_known
from comparisons.facts.quantities import FIELDS, main_axis, quantity
from comparisons.judging.verdicts import LAST_LOAD, NO_RESULT, Verdict
from comparisons.results import selection
from comparisons.results.store import SceneRecord, once
from comparisons.scene.half_space import DEPTH_KEYS
from comparisons.scene.physics.tables import TABLES
from comparisons.tasks.stresses import FROM_PRESSURE

NOBODY = "not computed by any method that was run"


def equal_at(record: SceneRecord, name: str) -> str:
    """Return what is equal where a quantity is judged."""
    return LAST_LOAD if name in FIELDS else main_axis(record.along, name)


@once
def unanswered(record: SceneRecord) -> dict[str, str]:
    """Return the asked quantities that can be judged for no method at all, each with the reason."""
    reasons = {item.quantity: item.reason for item in record.verdicts if not item.counts}
    return {name: reasons[name] for name in record.quantities if name in reasons}


def asked_in_vain(records: Iterable[SceneRecord]) -> list[str]:
    """Return a line for each quantity that was asked for and that no method gives."""
    return [
        f"{record.name}: compare.quantities: {name}: {reason}"
        for record in records
        for name, reason in unanswered(record).items()
        if reason.startswith(NOBODY)
    ]


@once
def levels(record: SceneRecord, method: str) -> list[int]:
    """Return the resolutions at which a method was run, ascending, but for the truth itself."""
    run = map(int, selection.run_at(record, method))
    return [n for n in run if not selection.is_reference(record, method, n)]


@once
def finest(record: SceneRecord, method: str) -> int | None:
    """Return the finest resolution, but the truth's, among those that solved the most steps."""
    rows = selection.solved_rows(record, method)
    resolution, step = (rows[key] for key in ("resolution", "step"))
    counts = {n: len(set(step[resolution == n])) for n in levels(record, method)}
    most = max(counts.values(), default=0)
    return max((n for n, count in counts.items() if count == most), default=None)


@once
def setting_verdicts(record: SceneRecord, method: str, resolution: float) -> tuple[Verdict, ...]:
    """Return the verdict on each asked quantity of one method at one resolution."""
    known = _judged(record).get((method, float(resolution)), {})
    nothing, unasked = (
        unanswered(record),
        f"the {selection.title(record, method)} was not asked for",
    )
    return tuple(
        known.get(name)
        or Verdict(
            method=method,
            quantity=name,
            at=equal_at(record, name),
            tolerance=record.tolerance,
            reason=nothing.get(name, unasked),
            counts=name not in nothing,
        )
        for name in record.quantities
    )


@once
def _judged(record: SceneRecord) -> dict[tuple[str, float], dict[str, Verdict]]:
    """Return the verdicts that decide: method and resolution -> quantity -> verdict."""
    settings: dict[tuple[str, float], dict[str, Verdict]] = {}
    for item in record.verdicts:
        if item.at == equal_at(record, item.quantity):
            settings.setdefault((item.method, item.resolution), {})[item.quantity] = item
    return settings


def by_chance(record: SceneRecord, method: str) -> str:
    """Return why a method of lines or statistics holds by chance where it holds; else ""."""
    row = METHODS.get(method)
    return record.reference.chance if row is not None and row.dimension < 3 else ""


def verdicts(record: SceneRecord, method: str = MODEL) -> tuple[Verdict, ...]:
    """Return a verdict per asked quantity: the method's at its finest resolution."""
    return setting_verdicts(record, method, finest(record, method) or 0)


def second_rows(record: SceneRecord) -> list[Verdict]:
    """Return what is known of the model at the other load: to be looked up, it decides nothing."""
    level = finest(record, MODEL)
    return [
        item
        for item in record.verdicts
        if item.method == MODEL
        and item.resolution == level
        and item.quantity in record.quantities
        and item.at != equal_at(record, item.quantity)
        and item.word != NO_RESULT
    ]


def judged_methods(record: SceneRecord) -> list[str]:
    """Return whose verdicts a page leads with: the reduced model, and methods of the user's own."""
    # A report is made without the solvers, and some of our methods bring their rows with them.
    user_methods = [
        name for name in selection.methods(record) if not is_known(name) or METHODS[name].user_made
    ]
    return [*([] if user_methods and not_asked(record, MODEL) else [MODEL]), *user_methods]


def not_asked(record: SceneRecord, method: str) -> bool:
    """Tell whether a method was left out by the scene."""
    refused = selection.unsupported(record)
    return method not in selection.methods(record) or refused.get(method) == NOT_ASKED


# Quantities whose bars `roughline calibrate` holds against true errors.
SINGLE_CONTACTS = ("force", "penetration", "contact_area", "stiffness")
ROUGH_SURFACES = ("contact_area", "penetration", "mean_gap", "stiffness")
WHERE = (
    "95 % where calibration shows it: force, penetration, contact area, mean gap and stiffness of "
    "frictionless, elastic contacts on uniform half-spaces; elsewhere an estimate by the same rules"
)


def depends_on_depth(tables: Mapping[str, Any]) -> bool:
    """Tell whether the half-space of a scene has layers, a rigid base, or is graded."""
    half_space = tables.get("half_space")
    return isinstance(half_space, dict) and any(half_space.get(key) for key in DEPTH_KEYS)


def is_calibrated(tables: Mapping[str, Any], name: str) -> bool:
    """Tell whether calibration covers the bar of a quantity of a scene, given by its tables."""
    if depends_on_depth(tables) or "body" in tables or any(key in tables for key in TABLES):
        return False
    return name in (ROUGH_SURFACES if "surface" in tables else SINGLE_CONTACTS)


def confidence(record: SceneRecord) -> str:
    """Say what the bars of a scene stand for, in words."""
    if record.reference.exact:
        cells = (
            " and of stresses read off pressures" if FROM_PRESSURE & {*record.quantities} else ""
        )
        return f"The truth is exact; u is that of the reduced model's own discretisation{cells}."
    covered = [name for name in record.quantities if is_calibrated(record.tables, name)]
    rest = [quantity(name).label for name in record.quantities if name not in covered]
    if not covered:
        return "u is an estimate from several resolutions; no calibration covers such scenes."
    but = f"; of {', '.join(rest)} an estimate that no calibration covers" if rest else ""
    # one in thirteen errors at a single load of a rough surface is beyond its bar: docs/claims.md
    over = " over the loads (92 % at one load)" if "surface" in record.tables else ""
    return f"u is a 95 % half-width{over}, by calibration{but}."
