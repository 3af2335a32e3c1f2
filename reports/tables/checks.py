"""Tables of the software checks: benchmarks, drift from a baseline, hard cases."""

from __future__ import annotations

from collections.abc import Iterable

from comparisons import formatting as fmt
from comparisons.questions.benchmarks.yardstick import Measurement
from comparisons.questions.check import Finding
from comparisons.questions.hard_cases.record import HardCasesRecord, OutcomeRecord
from reports.tables import cells
from reports.tables.table import Cell, Table, table

MET = {None: "", True: "met", False: "not met"}


def measured(name: str, rows: Iterable[Measurement]) -> Table:
    """Return the times of a benchmark as ratios to its yardsticks."""
    heads = ("benchmark", "time", "yardstick", "yardstick time", "ratio", "target", "")
    body = (
        (
            row.name,
            cells.duration(row.seconds),
            row.yardstick,
            "" if row.yardstick_seconds is None else cells.duration(row.yardstick_seconds),
            "" if row.ratio is None else f"{row.ratio:.3g}",
            "" if row.target is None else f"{row.target:g}",
            MET[row.met],
        )
        for row in rows
    )
    return table(heads, body, title=f"Benchmark: {name}")


def against_baseline(findings: list[Finding], baseline: str) -> Table:
    """Return every drift, highlighted, and further remarks."""
    rows: list[tuple[str, str, str]] = []
    drifted = set()
    for scene in dict.fromkeys(finding.scene for finding in findings):
        drifts = [e for e in findings if e.scene == scene and (e.drifted or e.notable)]
        if not drifts:
            rows.append((scene, "", "as in the baseline"))
        for index, drift in enumerate(drifts):
            if drift.drifted:
                drifted.add(len(rows))
            rows.append((scene if index == 0 else "", drift.subject, drift.text))
    title = f"Against {baseline}"
    return table(("scene", "subject", "finding"), rows, title=title, strong=frozenset(drifted))


def outcomes(record: HardCasesRecord) -> Table:
    """Return the outcome of every method on every hard case; (!) marks unexpected ones."""
    cases: dict[str, dict[str, OutcomeRecord]] = {}
    for outcome in record.outcomes:
        cases.setdefault(outcome.case, {})[outcome.method] = outcome
    rows = (
        (case, *(_outcome(row.get(name)) for name in record.methods)) for case, row in cases.items()
    )
    return table(("case", *record.methods), rows, title=f"Hard cases ({record.effort})")


def _outcome(outcome: OutcomeRecord | None) -> Cell | str:
    if outcome is None:
        return ""
    number = ""
    if outcome.error is not None:
        small = outcome.error < fmt.ROUND_OFF
        number = f" {'round-off' if small else fmt.relative(outcome.error)}"
    text = f"{outcome.kind}{number}{' (!)' if outcome.deviation else ''}"
    return cells.verdict(outcome.kind, text=text)
