"""The calibration page: coverage and width of the error bars."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.questions.calibration_cases import Case, fitted_shares, held, summary
from reports.pages.page import render
from reports.plots.axes import error_axis
from reports.plots.figure import Axis, Figure, Guide, Series
from reports.plots.style import BLUE, DASHED, DOTTED, INK, SOLID, Look, drawing_order, look
from reports.tables.validation import by_quantity, by_shape, kinds, other_widths, rule

SMALLEST = 1e-8  # errors below are the arithmetic's of the solvers
WIDTHS = (0.1, 1, 10, 100, 1000)


def calibration_page(cases: list[Case], command: str) -> str:
    """Return both figures and the tables as one HTML page."""
    reported = [case for case in cases if case.half == "reported"]
    single = [case for case in cases if not case.rough]
    drawn = [covered([case for case in single if case.half == "reported"]), widths(single)]
    return render(
        "calibration.html.j2",
        {figure.key: figure for figure in drawn},
        command=command,
        figures=drawn,
        halves=[
            (half, kind, summary(part), summary(part, at_loads=True))
            for half in ("reported", "fitting")
            for kind, part in kinds([case for case in cases if case.half == half]).items()
        ],
        parts=[*by_quantity(reported), *by_shape(reported)],
        rule=rule(fitted_shares(cases)),
        widths=other_widths(cases),
        held=held(cases),
    )


def covered(cases: list[Case]) -> Figure:
    """Return error bar against true error; points above the line are covered."""
    values = np.maximum([(case.error, case.bar) for case in cases], SMALLEST)
    low, high = 10.0 ** np.floor(np.log10(values.min())), 10.0 ** np.ceil(np.log10(values.max()))
    ends = np.array([low, high])
    once, thrice = Look("bar = error", INK), Look("3 ×", INK, dash=DASHED)
    series = [
        Series(once, ends, ends, marks=False, width=1),
        Series(thrice, ends, 3 * ends, marks=False, width=1),
    ]
    for method in drawing_order(dict.fromkeys(case.method for case in cases)):
        own = [case for case in cases if case.method == method]
        x, y = np.maximum([(case.error, case.bar) for case in own], SMALLEST).T
        hover = tuple(
            f"{case.shape}, {case.quantity.replace('_', ' ')}\n"
            f"N = {', '.join(map(str, case.resolutions))}\n"
            f"error {fmt.relative(case.error)}, bar {fmt.relative(case.bar)}"
            for case in own
        )
        series.append(Series(look(method), x, y, line=False, size=6, faint=0.7, hover=hover))
    return Figure(
        "covered",
        "Does the bar cover the true error?",
        "Each marker is one quantity in one series of resolutions, on a shape not used to fit the "
        "estimator. Above the solid line the bar covers the true error; on the dashed line it is "
        "three times the error.",
        error_axis(low, high, "true error (rms over the loads)"),
        error_axis(low, high, "bar (95 %)"),
        tuple(series),
    )


def widths(cases: list[Case]) -> Figure:
    """Return the fraction of cases whose bar is at most k times the error, against k."""
    series = []
    for half, dash in (("reported", SOLID), ("fitting", DOTTED)):
        style = Look(f"{half} half", BLUE, dash=dash)
        ratios = np.sort([c.bar / max(c.error, 1e-16) for c in cases if c.half == half])
        share = (np.arange(len(ratios)) + 1) / max(len(ratios), 1)
        x = np.clip(ratios, 0.1, 1e4)
        series.append(Series(style, x, share, marks=False, stairs=True, hover=style.label))
    ticks = tuple((float(width), f"{width:g}") for width in WIDTHS)
    return Figure(
        "widths",
        "How wide are the bars?",
        "Cumulative distribution of the ratio of bar to true error. Below 1 the bar misses the "
        "true error, in at most 5 % of the cases; the median should be below 3.",
        Axis("width: bar over true error", log=True, limits=(0.1, 1000.0), ticks=ticks),
        Axis("fraction of cases", scale=fmt.Scale(100.0, "%"), limits=(0.0, 1.0)),
        tuple(series),
        guides=(Guide(1.0, colour=INK), Guide(3.0, colour=INK)),
    )
