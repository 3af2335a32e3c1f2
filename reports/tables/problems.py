"""Tables of problem sheets, and of an entry that was judged by one."""

from __future__ import annotations

from collections.abc import Iterable

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.questions.problem_sheets import Judged, Sheet
from reports.tables import cells
from reports.tables.cells import Cell, Table, table

DIGITS = 6
# Bars below are those of closed forms.
NOTHING_UNKNOWN = 1e-10


def problem_list(sheets: Iterable[Sheet]) -> Table:
    """Return all sheets, a line each."""
    rows = [
        (
            sheet.id,
            sheet.title,
            ", ".join(quantity(name).label for name in sheet.quantities),
            "sealed" if sheet.sealed else "published",
        )
        for sheet in sheets
    ]
    return table(("problem", "title", "quantities", "reference"), rows)


def sheet_text(sheet: Sheet) -> str:
    """Return what a sheet says beside its numbers."""
    from comparisons.results.record import is_calibrated  # reads results: not for a list

    bars = [bar for known in sheet.reference.values() for bar in known.bars]
    if sheet.sealed:
        reference = (
            f"sealed: SHA-256 {sheet.sealed.sha256} of {sheet.sealed.digits} digits; "
            "`roughline submit` computes it anew"
        )
    elif max(bars, default=0.0) <= NOTHING_UNKNOWN:
        reference = "published below, exact to its digits"
    elif all(is_calibrated(sheet.tables, name) for name in sheet.quantities):
        reference = "published below; ±: 95 % half-width of its error, by calibration"
    else:
        reference = "published below; ±: an estimate of its error, which no calibration covers"
    return (
        f"{sheet.id}, version {sheet.version}: {sheet.title}\n\n{sheet.definition}\n\n"
        f"Tolerance: {fmt.tolerance(sheet.tolerance)}\n"
        f"Reference: {sheet.source}\n{reference}\nLicence of this sheet: {sheet.licence}\n"
    )


def sheet_table(sheet: Sheet) -> Table:
    """Return the loads of a sheet, and the reference if it is published."""
    from comparisons.geometry.prepare import prepare  # half of the solvers: not for a list

    _, loads = prepare(sheet.scene)
    control = quantity(loads.control)
    heads = [f"{control.label} / {control.unit}"]
    heads += [f"{quantity(n).label} / {quantity(n).unit}".rstrip(" /") for n in sheet.quantities]
    rows = []
    for step, load in enumerate(loads.values):
        row = [cells.number(f"{load:.{DIGITS}g}", float(load))]
        for name in sheet.quantities:
            known = sheet.reference.get(name)
            if known is None:
                row.append(Cell("wanted"))
                continue
            value, bar = known.values[step], known.bars[step]
            text = f"{value:.{DIGITS}g}"
            if bar > NOTHING_UNKNOWN:
                text += f" ± {fmt.relative(bar)}"
            if known.lower:
                text += f", proved {known.lower[step]:.{DIGITS}g} to {known.upper[step]:.{DIGITS}g}"
            row.append(cells.number(text, value))
        rows.append(row)
    return table(heads, rows)


def judged_table(judged: Judged, sheet: Sheet) -> Table:
    """Return the verdict on every quantity of an entry."""
    rows = []
    for name, verdict in judged.verdicts.items():
        solved = verdict.step >= 0
        proved = "beyond what is proved" if name in judged.beyond else ""
        at = f"load {verdict.step + 1}" if solved else ""
        lost = judged.lost(name)
        if lost:
            at = f"{at}; no value at load {', '.join(map(str, lost))}".removeprefix("; ")
        word = cells.verdict(verdict.word, text=f"{verdict.word} {fmt.tolerance(sheet.tolerance)}")
        rows.append((quantity(name).label, cells.of_verdict(verdict), at, word, proved))
    return table(("quantity", "largest error", "at", "verdict", "theorem"), rows)


def judged_text(judged: Judged, sheet: Sheet) -> str:
    """Return the verdict on an entry in one sentence."""
    entry, verdict = judged.entry, judged.verdicts[judged.worst]
    cost = f"{fmt.duration(entry.seconds)} as stated" if entry.seconds else "no time stated"
    return (
        f"{entry.solver} on {sheet.id}: {verdict.word} {fmt.tolerance(sheet.tolerance)} "
        f"({quantity(judged.worst).label} decides), {cost}, {fmt.count(entry.threads)} "
        f"thread{'s' if entry.threads > 1 else ''}; SHA-256 {entry.digest}"
    )
