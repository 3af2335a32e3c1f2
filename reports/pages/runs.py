"""The comparison page of two runs: changes in value, error and time."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from comparisons import formatting as fmt
from comparisons.results.run_comparison import KINDS, ONE_SIDED, SAME, Change, RunComparison
from reports.pages.page import render, tally
from reports.plots.axes import log_axis, per_cent
from reports.plots.figure import Figure, Series
from reports.plots.style import DOTTED, MUTED, Look, drawing_order, look
from reports.tables.runs import changes

MARGIN = 1.6
DIAGONAL = Look("unchanged", MUTED, dash=DOTTED)
ERRORS = (
    "One marker per solve (a method at a resolution): its largest error before and after, relative "
    "to the reference of its run. Above the line it has grown. Hollow: answer or verdict changed."
)
TIMES = (
    "One marker per solve: its time before and after. Above the line it took longer. A run keeps "
    "no scatter of times, and on a busy machine it is large: roughline bench measures times. "
    "Hollow: answer or verdict changed."
)


def comparison_page(record: RunComparison, command: str, *, static: bool = False) -> str:
    """Return the comparison as one HTML page; a static one is without plots."""
    solves = list(record.changes)
    figures = [] if static else before_and_after(solves)
    timed = [change for change in solves if change.only_timed]
    one_sided, same = ([c for c in solves if kind in c.kinds] for kind in (ONE_SIDED, SAME))
    unlike = [c for c in solves if not c.only_timed and not {SAME, ONE_SIDED} & c.kinds.keys()]
    alike = [c for c in unlike if c.moved and c.scene in record.alike]
    return render(
        "comparison.html.j2",
        {figure.key: figure for figure in figures},
        static=static,
        record=record,
        command=command,
        tally=tally((kind for change in solves for kind in change.kinds), KINDS),
        notable=changes([c for c in unlike if c not in alike]),
        alike=changes(alike),
        timed=changes(timed),
        one_sided=changes(one_sided),
        unchanged=changes(same),
        figures=figures,
    )


def before_and_after(solves: Sequence[Change]) -> list[Figure]:
    """Return the plots of errors and of times, those that have a point."""
    figures = []
    methods = dict.fromkeys(solve.method for solve in solves)
    errors = np.maximum([change.errors for change in solves], fmt.ROUND_OFF)
    times = np.array([change.seconds for change in solves], dtype=float)
    for word, caption, both, label in (
        ("error", ERRORS, errors, per_cent),
        ("time", TIMES, times, fmt.duration),
    ):
        pairs = both.reshape(-1, 2)
        known = np.flatnonzero((np.isfinite(pairs) & (pairs > 0)).all(axis=1)).tolist()
        if not known:
            continue
        span = float(pairs[known].min()) / MARGIN, float(pairs[known].max()) * MARGIN
        ends = np.array(span)
        series = [Series(DIAGONAL, ends, ends, marks=False, legend=False, width=1)]
        for method in drawing_order(methods):
            for changed in (False, True):  # each has its legend
                own = [k for k in known if (solves[k].method, solves[k].bad) == (method, changed)]
                if not own:
                    continue
                drawn, (x, y) = look(method, among=methods), pairs[own].T
                hover = tuple(
                    f"{drawn.label}, {solves[k].scene}, N = {solves[k].resolution}: "
                    f"{label(pairs[k, 0])} before, {label(pairs[k, 1])} after; "
                    f"{', '.join(solves[k].kinds)}"
                    for k in own
                )
                at = drawn.labelled(f"{drawn.label}, changed") if changed else drawn, x, y
                series.append(Series(*at, line=False, hollow=changed, hover=hover, faint=0.8))
        figures.append(
            Figure(
                f"{word}s",
                f"{word.capitalize()} before and after",
                caption,
                log_axis(f"{word} before", span, label, most=5),  # room for them on a phone
                log_axis(f"{word} after", span, label),
                tuple(series),
            )
        )
    return figures
