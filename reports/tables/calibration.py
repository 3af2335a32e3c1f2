"""Tables of the calibration: coverage and width by part, the rule and how it was fixed."""

from __future__ import annotations

from collections.abc import Iterable

from comparisons import formatting as fmt
from comparisons.judging.uncertainty import SHARES, Shares
from comparisons.questions.calibration_cases import (
    ROUGH,
    SINGLE,
    Case,
    Summary,
    at_loads,
    held,
    scaled,
    summary,
)
from reports.plots.style import look
from reports.tables import cells
from reports.tables.table import Cell, Table, table

ONE, ROUGHNESS = "single contacts", "rough surfaces"
# What the grid's part of all bars is multiplied by, to see what other widths would do.
SCALES = (0.8, 0.9, 1.0, 1.1, 1.2)
_HEADS = ("cases", "covered", "width", "at a load", "width there")


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
        label = ", ".join(_label(name, str(getattr(case, name))) for name in names)
        parts.setdefault(label, []).append(case)
    parts["all"] = cases
    return table((kind, *_HEADS), [(label, *_quality(part)) for label, part in parts.items()])


def _label(name: str, value: str) -> str:
    return look(value).label if name == "method" else value.replace("_", " ")


def _quality(cases: list[Case]) -> tuple[Cell, ...]:
    over, at = summary(cases), at_loads(cases)
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
    return [
        table((kind, *_HEADS, "miss proofs"), [_wider(part, by) for by in SCALES])
        for kind, part in kinds(cases).items()
    ]


def _wider(cases: list[Case], by: float) -> tuple[str | Cell, ...]:
    made = scaled(cases, by)
    proved = held(made)
    reported = [case for case in made if case.half == "reported"]
    missed = cells.number(f"{proved.missed} of {proved.bars}", proved.missed)
    return f"{by:g} times as wide", *_quality(reported), missed
