"""Tables of claims: the verdicts of a run, and the measurements behind each verdict."""

from __future__ import annotations

from comparisons import formatting as fmt
from comparisons.questions.claims.record import (
    ClaimRecord,
    ClaimsRecord,
    NuisanceRecord,
    PointRecord,
)
from reports.plots.claims import detail
from reports.tables import cells
from reports.tables.table import Cell, Head, Table, table

NAN = float("nan")


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


def measurements(claim: ClaimRecord) -> Table:
    """Return every measurement of a claim: parameter, error with its bar, word, time, details."""
    heads = ("error", "verdict", Head("time", csv="time / s"), "details")
    parameter = (fmt.greek(claim.parameter),) if claim.parameter else ()
    rows = ((*_parameter(claim, point), *_measured(point)) for point in claim.points)
    return table((*parameter, *heads), rows)


def beyond(claim: ClaimRecord) -> Table:
    """Return the measurements over what a statement leaves open: one parameter at a time, draws."""
    rows: list[tuple[Cell | str, ...]] = []
    for nuisance in claim.nuisances:
        rows += [
            (f"{fmt.greek(nuisance.name)} {_place(nuisance, point)}", *_measured(point))
            for point in nuisance.points
        ]
    for point in claim.draws:
        setting = [f"{fmt.greek(name)} {text}" for name, text in point.setting.items()]
        if claim.parameter:
            setting.insert(0, f"{fmt.greek(claim.parameter)} {fmt.number(point.parameter, 4)}")
        rows.append((", ".join(setting), *_measured(point)))
    heads = ("error", "verdict", Head("time", csv="time / s"), "details")
    return table(("setting, else as stated", *heads), rows)


def _place(nuisance: NuisanceRecord, point: PointRecord) -> str:
    if nuisance.choices:
        return nuisance.choices[int(point.parameter or 0)]
    return fmt.number(point.parameter, 4)


def _parameter(claim: ClaimRecord, point: PointRecord) -> tuple[Cell, ...]:
    if not claim.parameter:
        return ()
    value = NAN if point.parameter is None else point.parameter
    return (cells.number(fmt.number(point.parameter, 4), value),)


def _measured(point: PointRecord) -> tuple[Cell, ...]:
    error, bar = (NAN if v is None else v for v in (point.error, point.uncertainty))
    details = "; ".join(f"{key}: {detail(number)}" for key, number in point.details.items())
    return (
        cells.error(error, bar),
        cells.verdict(point.word),
        cells.duration(point.seconds),
        Cell(details, details, "wrap"),
    )
