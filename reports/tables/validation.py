"""Tables for validation: claims, hard cases, the calibration of the bars, benchmarks, drift."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from typing import TYPE_CHECKING

from comparisons import formatting as fmt
from comparisons.judging.uncertainty import SHARES, Shares
from comparisons.questions.calibration_cases import ROUGH, SINGLE, Case, Summary, held, summary
from comparisons.questions.claims.record import ClaimRecord, ClaimsRecord, PointRecord
from reports.plots.claims import detail
from reports.plots.style import look
from reports.tables import cells
from reports.tables.cells import Cell, Head, Table, table

if TYPE_CHECKING:
    from comparisons.questions.benchmarks.yardstick import Measurement
    from comparisons.questions.check import Finding  # a page of results needs no solver
    from comparisons.questions.hard_cases.case import HardCasesRecord

NAN = float("nan")
MET = {None: "", True: "met", False: "not met"}
ONE, ROUGHNESS = "single contacts", "rough surfaces"
# What the grid's part of all bars is multiplied by, to see what other widths would do.
SCALES = (0.8, 0.9, 1.0, 1.1, 1.2)
_HEADS = ("cases", "covered", "width", "at a load", "width there")


def claims(record: ClaimsRecord) -> Table:
    """Return the verdict on every claim, unexpected ones highlighted."""
    rows = []
    for claim in record.claims:
        expected = f", expected {claim.expected}" if claim.differs else ""
        word = cells.verdict(claim.verdict, text=f"{claim.verdict}{expected}")
        rows.append((claim.id, claim.equation, claim.author, word, fmt.greek(claim.finding)))
    heads = ("claim", "equation", "who says it", "verdict", "finding")
    strong = frozenset(place for place, claim in enumerate(record.claims) if claim.differs)
    return table(heads, rows, title=f"Claims, {record.effort}", strong=strong)


POINT = ("error", "verdict", Head("time", csv="time / s"), "details")


def measurements(claim: ClaimRecord) -> Table:
    """Return every measurement of a claim: parameter, error with its bar, word, time, details."""
    if not claim.parameter:
        return table(POINT, map(_measured, claim.points))
    rows = []
    for point in claim.points:
        value = NAN if point.parameter is None else point.parameter
        rows.append((cells.number(fmt.number(point.parameter, 4), value), *_measured(point)))
    return table((fmt.greek(claim.parameter), *POINT), rows)


def beyond(claim: ClaimRecord) -> Table:
    """Return the measurements over what a statement leaves open: one parameter at a time, draws."""
    rows: list[tuple[Cell | str, ...]] = []
    for nuisance in claim.nuisances:
        for point in nuisance.points:
            place = fmt.number(point.parameter, 4)
            if nuisance.choices:
                place = nuisance.choices[int(point.parameter or 0)]
            rows.append((f"{fmt.greek(nuisance.name)} {place}", *_measured(point)))
    for point in claim.draws:
        setting = [f"{fmt.greek(name)} {text}" for name, text in point.setting.items()]
        if claim.parameter:
            setting.insert(0, f"{fmt.greek(claim.parameter)} {fmt.number(point.parameter, 4)}")
        rows.append((", ".join(setting), *_measured(point)))
    return table(("setting, else as stated", *POINT), rows)


def _measured(point: PointRecord) -> tuple[Cell, ...]:
    error, bar = (NAN if v is None else v for v in (point.error, point.uncertainty))
    details = "; ".join(f"{key}: {detail(number)}" for key, number in point.details.items())
    word, seconds = cells.verdict(point.word), cells.duration(point.seconds)
    return cells.error(error, bar), word, seconds, Cell(details, details, "wrap")


def outcomes(record: HardCasesRecord) -> Table:
    """Return the outcome of every method on every hard case; (!) marks unexpected ones."""
    rows = []
    for case, by_method in record.cases.items():
        row: list[Cell | str] = [case]
        for name in record.methods:
            known = by_method.get(name)
            if known is None:
                row.append("")
                continue
            number = "" if known.error is None else f" {cells.size(known.error)}"
            text = f"{known.kind}{number}{' (!)' if known.deviation else ''}"
            row.append(cells.verdict(known.kind, text=text))
        rows.append(row)
    return table(("case", *record.methods), rows, title=f"Hard cases ({record.effort})")


def kinds(cases: Iterable[Case]) -> dict[str, list[Case]]:
    """Return the cases of single contacts, and those of rough surfaces, if there are any."""
    both: dict[str, list[Case]] = {ONE: [], ROUGHNESS: []}
    for case in cases:
        both[ROUGHNESS if case.rough else ONE].append(case)
    return {kind: part for kind, part in both.items() if part}


def by_quantity(cases: Iterable[Case]) -> list[Table]:
    """Return coverage and width by quantity and method, or of rough surfaces free and periodic."""
    return [
        _parts(part, kind, "quantity", "kind" if kind == ROUGHNESS else "method")
        for kind, part in kinds(cases).items()
    ]


def by_shape(cases: Iterable[Case]) -> list[Table]:
    """Return coverage and width by shape or spectrum."""
    return [_parts(part, kind, "shape") for kind, part in kinds(cases).items()]


def _parts(cases: list[Case], kind: str, *names: str) -> Table:
    parts: dict[str, list[Case]] = {}
    for case in cases:
        values = {name: str(getattr(case, name)).replace("_", " ") for name in names}
        if "method" in values:
            values["method"] = look(case.method).label
        parts.setdefault(", ".join(values.values()), []).append(case)
    parts["all"] = cases
    return table((kind, *_HEADS), [(label, *_quality(part)) for label, part in parts.items()])


def _quality(cases: list[Case]) -> tuple[Cell, ...]:
    over, at = summary(cases), summary(cases, at_loads=True)
    return cells.count(over.count), *_reached(over), *_reached(at)


def _reached(of: Summary) -> tuple[Cell, Cell]:
    coverage = cells.number(f"{100 * of.coverage:.1f} %", of.coverage)
    return coverage, cells.number(fmt.number(of.width, 2), of.width)


def rule(fitted: Shares) -> Table:
    """Return the factors in use, what they must cover of the fitting half, and what that asks."""
    rows: list[tuple[Cell | str, ...]] = []
    for known, used in SHARES.items():
        name, kind = known
        least, raised = SINGLE.get(known, ROUGH)
        asked = fitted[known]
        rows.append(
            (
                f"{name.replace('_', ' ')}, {kind}",
                f"{used.order:g}",
                f"{100 * least:g} %",
                cells.number(f"{raised:g}", raised),
                *(
                    cells.number(f"{n:.3g}", n)
                    for n in (used.factor, asked.factor, used.two, asked.two)
                ),
            )
        )
    note = (
        "Must cover: of the bars at every load. Two: what the factor is multiplied by for two "
        "grids or meshes. Of areas of rough surfaces it is the part that changes tell, without the "
        "contact line."
    )
    heads = ("rule", "order", "must cover", "raised by", "factor", "asked", "two", "asked")
    return table(heads, rows, note=note)


def other_widths(cases: Iterable[Case]) -> list[Table]:
    """Return what bars so many times as wide would reach on the reported half, and miss."""
    tables = []
    for kind, part in kinds(cases).items():
        rows: list[tuple[Cell | str, ...]] = []
        for by in SCALES:
            made = [replace(case, widened=by) for case in part]
            proved = held(made)
            missed = cells.number(f"{proved.missed} of {proved.bars}", proved.missed)
            reported = [case for case in made if case.half == "reported"]
            rows.append((f"{by:g} times as wide", *_quality(reported), missed))
        tables.append(table((kind, *_HEADS, "miss proofs"), rows))
    return tables


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
