"""Verdicts on each quantity of a setting, a method or a scene.

Every quantity is judged once, at equal prescribed load (the prescribed one, force or penetration,
at an equal value of the other), by the step that `comparisons.judging.verdicts.judged` selects.
The page, the terminal, advice, tables and notebooks all use these words and numbers. Errors at the
other load are listed (`second_rows`) but never affect a verdict.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.facts.methods import METHODS, MODEL, NOT_ASKED, is_known
from comparisons.facts.quantities import FIELDS, QUANTITIES, main_axis, quantity
from comparisons.judging.verdicts import NO_RESULT, OUTSIDE, WITHIN, severity, word_for
from comparisons.results import selection
from comparisons.results.store import SceneRecord, once

LAST_LOAD, NEVER = "last load", "never"
NOT_COMPUTED = "not computed by the method"
NAN = math.nan


@dataclass(frozen=True)
class Verdict:
    """One quantity of one setting.

    Attributes
    ----------
    quantity, at : str
        What was compared, and what was equal when it was ("penetration", "force", "last load").
    word : str
        "within", "outside", "not resolved" or "no result".
    tolerance : float
    step : int
        The load step that decided, counted from 0; -1 where it is not known.
    error, uncertainty : float
        The error at that step and the 95 % half-width of its bar (NaN: no result; bar not known).
    signed, ratio : bool
        Whether `error` has its sign, or is a size (norms); and whether it
        is a ratio minus 1 (along paths errors are relative to the largest value).
    low, high : float
        The largest |e| - u and |e| + u over the load steps; NaN where unknown.
    rms : float
        Root mean square of e over the load steps.
    reason : str
        Why there is no result.
    counts : bool
        False for a quantity that the scene's solutions cannot answer for any method.
    offered : bool
        False for a quantity that this method does not compute: a dash, no verdict on the method.
    outside_band : str
        Load steps, from 1, at which the one surface of a map is outside the band of single lines,
        or "never"; "" where there is no such band. The error is that of the lines' mean.
    single_low, single_high, single_step : float, float, int
        5 and 95 % quantiles of single realisations' errors, at the step where they reach furthest.
    """

    quantity: str
    at: str
    word: str
    tolerance: float
    step: int = -1
    error: float = NAN
    uncertainty: float = NAN
    low: float = NAN
    high: float = NAN
    rms: float = NAN
    reason: str = ""
    resolution: float = NAN
    signed: bool = True
    ratio: bool = True
    counts: bool = True
    offered: bool = True
    outside_band: str = ""
    single_low: float = NAN
    single_high: float = NAN
    single_step: int = -1

    @property
    def single(self) -> str:
        """The band of single realisations' errors: "−31 to +37 %"; "–" where there is none."""
        return fmt.between(self.single_low, self.single_high)

    @property
    def band(self) -> str:
        """Where the one surface of a map lies: "in the lines' band", or outside it and when."""
        if not self.outside_band:
            return ""
        if self.outside_band == NEVER:
            return "in the lines' band"
        steps = [int(step) for step in self.outside_band.split()]
        if len(steps) == 1:
            return f"outside the lines' band at load step {steps[0]}"
        whole = steps[-1] - steps[0] + 1 == len(steps) > 2
        several = f"{steps[0]} to {steps[-1]}" if whole else ", ".join(map(str, steps))
        return f"outside the lines' band at load steps {several}"

    @property
    def number(self) -> str:
        """The error with its bar, as everything prints it."""
        return fmt.plus_minus(self.error, self.uncertainty, signed=self.signed, ratio=self.ratio)

    @property
    def when(self) -> str:
        """The step that decided: "load step 4", "step 2", "last load"; "" for round-off."""
        if self.at == LAST_LOAD:
            return LAST_LOAD
        if self.step < 0 or self.number == "round-off":
            return ""
        # Creeps, speeds, times and places along a path are steps, but no loads.
        return f"{'load step' if quantity(self.at).load else 'step'} {self.step + 1}"

    @property
    def where(self) -> str:
        """That step and what was equal there: "load step 4, equal force"; on maps the band."""
        equal = f"equal {quantity(self.at).label}" if self.at in QUANTITIES else ""
        return "; ".join(filter(None, [", ".join(filter(None, [self.when, equal])), self._place]))

    @property
    def _place(self) -> str:
        return f"the lines' mean, the surface {self.band}" if self.band else ""

    @property
    def because(self) -> str:
        """The comparison that decided: "|e| + u = 0.99 % ≤ t = 1 %", or why there is none."""
        if self.word == NO_RESULT:
            return self.reason
        limit = f"t = {fmt.tolerance(self.tolerance)}"
        if self.high < fmt.ROUND_OFF:
            return f"round-off ≤ {limit}"
        least, most = (fmt.relative(max(end, 0.0)) for end in (self.low, self.high))
        if self.word == WITHIN:
            return f"|e| + u = {most} ≤ {limit}"
        if self.word == OUTSIDE:
            return f"|e| − u = {least} > {limit}"
        unknown = "u is not known" if not fmt.finite(self.high) else f"{limit} < |e| + u = {most}"
        return f"|e| − u = {least} ≤ {limit}, but {unknown}" if fmt.finite(self.low) else unknown

    @property
    def text(self) -> str:
        """Quantity, number and step, or why there is none: "force 2.3 ± 0.1 % at load step 4"."""
        label = quantity(self.quantity).label
        if self.word == NO_RESULT:
            return f"{label}: {self.reason}"
        return f"{label} {self.number}" + (f" at {self.when}" if self.when else "")


def worst(items: Iterable[Verdict], *, asked: bool = False) -> Verdict:
    """Return the verdict that decides over several quantities.

    The worst one (`comparisons.judging.verdicts.severity`). Quantities that nothing answers, or
    that the method does not compute, decide only where all are such; with `asked` the method has to
    compute all that some method answers.
    """
    several = list(items)
    counted = [verdict for verdict in several if verdict.counts]
    offered = [] if asked else [verdict for verdict in counted if verdict.offered]
    return min(
        offered or counted or several,
        key=lambda item: severity(item.word, item.low, item.high, item.error),
    )


def equal_at(record: SceneRecord, name: str) -> str:
    """Return what is equal where a quantity is judged."""
    return LAST_LOAD if name in FIELDS else main_axis(record.along, name)


@once
def unanswered(record: SceneRecord) -> dict[str, str]:
    """Return the asked quantities that can be judged for no method at all, each with the reason."""
    reasons = {name: _why_unanswered(record, name) for name in record.quantities}
    return {name: reason for name, reason in reasons.items() if reason}


def _why_unanswered(record: SceneRecord, name: str) -> str:
    truth = str(record.reference.get("method") or "")
    if not truth:
        return "no reference: no 3-D method finished"
    rows = (row for (other, *_), row in _judged_rows(record).items() if other == name)
    if any(math.isfinite(_float(row.get("maximum"))) for row in rows):
        return ""
    if zero := _why_zero(record, name, selection.column(selection.solved(record), name)):
        return f"zero in every answer: {zero}"
    if name in record.reference.get("bars", {}):
        alone = name == record.along and _loads(record) < 2
        return f"only one load, so no comparison at equal {equal_at(record, name)}" if alone else ""
    if name not in answered(record):
        return "not computed by any method that was run"
    return f"not computed by the reference ({selection.title(record, truth)})"


def asked_in_vain(records: Iterable[SceneRecord]) -> list[str]:
    """Return a line for each quantity that was asked for and that no method gives."""
    return [
        f"{record.name}: compare.quantities: {name}: not computed by any method that was run"
        for record in records
        for name in record.quantities
        if record.reference and name not in answered(record)
    ]


@once
def answered(record: SceneRecord) -> set[str]:
    """Return the asked quantities that some solution has."""
    quantities = {
        name
        for name in record.quantities
        if np.isfinite(selection.column(selection.solved(record), name)).any()
    }
    quantities |= set(record.reference.get("bars", {}))
    return quantities | set(selection.texts(record.measures, "quantity"))


def _loads(record: SceneRecord) -> int:
    return len(set(selection.column(selection.solved(record), "step")))


@once
def _judged_rows(record: SceneRecord) -> dict[tuple[str, str, float], dict]:
    """Return (quantity, method, resolution) -> the row of measures.csv that is judged."""
    rows: dict[tuple[str, str, float], dict] = {}
    table = selection.compared_measures(record)
    at, resolution = selection.texts(table, "at"), selection.column(table, "resolution")
    methods = selection.texts(table, "method")
    for row, where, method, level in zip(
        table.to_dict("records"), at, methods, resolution, strict=True
    ):
        if where == equal_at(record, row["quantity"]):
            rows.setdefault((row["quantity"], method, float(level)), row)
    return rows


@once
def levels(record: SceneRecord, method: str) -> list[int]:
    """Return the resolutions at which a method was run, ascending, but for the truth itself."""
    run = map(int, selection.run_at(record, method))
    return [n for n in run if not selection.is_reference(record, method, n)]


@once
def finest(record: SceneRecord, method: str) -> int | None:
    """Return the finest resolution, but the truth's, among those that solved the most steps."""
    rows = selection.solved_rows(record, method)
    resolution, step = (selection.column(rows, key) for key in ("resolution", "step"))
    counts = {n: len(set(step[resolution == n])) for n in levels(record, method)}
    most = max(counts.values(), default=0)
    return max((n for n, count in counts.items() if count == most), default=None)


@once
def setting_verdicts(record: SceneRecord, method: str, resolution: int) -> tuple[Verdict, ...]:
    """Return the verdict on each asked quantity of one method at one resolution."""
    nothing = unanswered(record)
    judgements = []
    for name in record.quantities:
        row = _judged_rows(record).get((name, method, float(resolution)))
        verdict = None if row is None else verdict_of(record, row)
        if name in nothing:
            verdict = _no_result(record, name, nothing[name], resolution, counts=False)
        elif verdict is None or verdict.word == NO_RESULT:
            verdict = _missing(record, name, method, resolution)
        judgements.append(verdict)
    return tuple(judgements)


def verdicts(record: SceneRecord, method: str = MODEL) -> list[Verdict]:
    """Return a verdict per asked quantity: the method's at its finest resolution."""
    level = finest(record, method)
    if level is not None:
        return list(setting_verdicts(record, method, level))
    nothing = unanswered(record)
    return [
        _no_result(record, name, nothing[name], NAN, counts=False)
        if name in nothing
        else _missing(record, name, method, NAN)
        for name in record.quantities
    ]


def second_rows(record: SceneRecord, method: str = MODEL) -> list[Verdict]:
    """Return what is known at the other load: to be looked up, it decides nothing."""
    table = selection.compared_measures(record, method)
    level = finest(record, method)
    matching = table[_is_setting(table, method, -1 if level is None else level)]
    judgements = [verdict_of(record, row) for row in matching.to_dict("records")]
    return [v for v in judgements if v.at != equal_at(record, v.quantity) and v.word != NO_RESULT]


def judged_methods(record: SceneRecord) -> list[str]:
    """Return whose verdicts a page leads with: the reduced model, and methods of the user's own."""
    # A report is made without the solvers, and some of our methods bring their rows with them.
    user_methods = [
        name for name in selection.methods(record) if not is_known(name) or METHODS[name].user_made
    ]
    return [*([] if user_methods and _not_asked(record, MODEL) else [MODEL]), *user_methods]


def _is_setting(table: pd.DataFrame, method: str, resolution: int) -> np.ndarray:
    names = np.array(selection.texts(table, "method"), dtype=object)
    return (names == method) & (selection.column(table, "resolution") == resolution)


def verdict_of(record: SceneRecord, row: dict) -> Verdict:
    """Return the verdict in a row of measures.csv."""
    word, low, high = str(row.get("verdict") or NO_RESULT), NAN, NAN
    if word != NO_RESULT:  # the tolerance may be another one than that of the run
        low, high = _float(row.get("low")), _float(row.get("high"))
        word = word_for(low, high, record.tolerance)
    error = _float(row.get("error"))
    signed = math.isfinite(error)
    return Verdict(
        quantity=str(row["quantity"]),
        at=str(row.get("at", "") or ""),
        word=word,
        tolerance=record.tolerance,
        step=_step(row.get("step")),
        error=error if signed else _float(row.get("maximum")),
        signed=signed,
        ratio=not record.is_path,
        uncertainty=_float(row.get("uncertainty")),
        low=low,
        high=high,
        rms=_float(row.get("rms")),
        resolution=_float(row.get("resolution")),
        outside_band=_text(row.get("outside_band")),
        single_low=_float(row.get("single_low")),
        single_high=_float(row.get("single_high")),
        single_step=_step(row.get("single_step")),
    )


def _no_result(
    record: SceneRecord,
    name: str,
    reason: str,
    resolution: float,
    *,
    counts: bool = True,
    offered: bool = True,
) -> Verdict:
    return Verdict(
        name,
        equal_at(record, name),
        NO_RESULT,
        record.tolerance,
        reason=reason,
        resolution=resolution,
        counts=counts,
        offered=offered,
    )


def _missing(record: SceneRecord, name: str, method: str, resolution: float) -> Verdict:
    reason = _why_missing(record, name, method)
    return _no_result(record, name, reason, resolution, offered=reason != NOT_COMPUTED)


def _not_asked(record: SceneRecord, method: str) -> bool:
    refused = selection.unsupported(record)
    return method not in selection.methods(record) or refused.get(method) == NOT_ASKED


def _why_missing(record: SceneRecord, name: str, method: str) -> str:
    """Return why a method has no error in a quantity that others have."""
    title = selection.title(record, method)
    lost = [item.reason for item in selection.failures(record) if item.method == method]
    if method == record.reference.get("method"):
        return lost[0] if lost else "this is the reference itself"
    if _not_asked(record, method):
        return f"the {title} was not asked for"
    refused = selection.unsupported(record)
    if method in refused:
        return refused[method]
    solved = selection.solved_rows(record, method)
    gives = np.isfinite(selection.column(solved, name)).any()
    if lost and (gives or solved.empty or name in FIELDS):
        return lost[0]
    if not gives:
        return NOT_COMPUTED
    truth, resolution = selection.reference(record)
    true = selection.setting_rows(record, truth, resolution)
    if zero := _why_zero(record, name, selection.column(true, name)):
        return f"zero in the reference ({zero}), but not in the {title}: no relative error"
    lost = [item.reason for item in selection.failures(record) if item.method == truth]
    if lost:
        return f"the reference has no value at these loads: {lost[0]}"
    return f"no value of the {title} is in the reference's range of {equal_at(record, name)}"


def _why_zero(record: SceneRecord, name: str, values: np.ndarray) -> str:
    """Return why a quantity is zero at all loads; "" where it is not."""
    known = values[np.isfinite(values)]
    if not len(known) or known.any():
        return ""
    area = selection.column(selection.solved(record), "contact_area")
    if np.isfinite(area).any() and not np.nan_to_num(area).any():
        return "nothing touches at any load"
    return "nothing yields" if "plasticity" in quantity(name).physics else "nothing happens"


def _text(value: object) -> str:
    """Return a text of measures.csv, where a whole number stands for one step."""
    if isinstance(value, float):
        return f"{value:.0f}" if math.isfinite(value) else ""
    return "" if value is None else str(value)


def _step(value: object) -> int:
    number = _float(value)
    return int(number) if math.isfinite(number) else -1


def _float(value: object) -> float:
    try:
        return float(value)  # type: ignore[arg-type]
    except (TypeError, ValueError):
        return NAN
