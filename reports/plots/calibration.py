"""Figures of the calibration: error bar against true error, and the distribution of widths."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.questions.calibration_cases import Case
from reports.plots.axes import error_axis
from reports.plots.figure import Axis, Figure, Guide, Series
from reports.plots.style import BLUE, DASHED, DOTTED, INK, SOLID, Look, drawing_order, look

SMALLEST = 1e-8  # errors below are the arithmetic's of the solvers
WIDTHS = (0.1, 1, 10, 100, 1000)


def covered(cases: list[Case]) -> Figure:
    """Return error bar against true error; points above the line are covered."""
    values = np.maximum([(case.error, case.bar) for case in cases], SMALLEST)
    low, high = 10.0 ** np.floor(np.log10(values.min())), 10.0 ** np.ceil(np.log10(values.max()))
    ends = np.array([low, high])
    looks = Look("bar = error", INK), Look("3 ×", INK, dash=DASHED)
    guides = [
        Series(drawn, ends, factor * ends, marks=False, width=1)
        for drawn, factor in zip(looks, (1, 3), strict=True)
    ]
    names = drawing_order(dict.fromkeys(case.method for case in cases))
    points = [_points([case for case in cases if case.method == name], name) for name in names]
    return Figure(
        "covered",
        "Does the bar cover the true error?",
        "Each marker is one quantity in one series of resolutions, on a shape not used to fit the "
        "estimator. Above the solid line the bar covers the true error; on the dashed line it is "
        "three times the error.",
        error_axis(low, high, "true error (rms over the loads)"),
        error_axis(low, high, "bar (95 %)"),
        (*guides, *points),
    )


def _points(cases: list[Case], method: str) -> Series:
    x, y = np.maximum([(case.error, case.bar) for case in cases], SMALLEST).T
    hover = tuple(_hover(case) for case in cases)
    return Series(look(method), x, y, line=False, size=6, faint=0.7, hover=hover)


def _hover(case: Case) -> str:
    levels = ", ".join(map(str, case.resolutions))
    return (
        f"{case.shape}, {case.quantity.replace('_', ' ')}\nN = {levels}\n"
        f"error {fmt.relative(case.error)}, bar {fmt.relative(case.bar)}"
    )


def widths(cases: list[Case]) -> Figure:
    """Return the fraction of cases whose bar is at most k times the error, against k."""
    ticks = tuple((float(width), f"{width:g}") for width in WIDTHS)
    return Figure(
        "widths",
        "How wide are the bars?",
        "Cumulative distribution of the ratio of bar to true error. Below 1 the bar misses the "
        "true error, in at most 5 % of the cases; the median should be below 3.",
        Axis("width: bar over true error", log=True, limits=(0.1, 1000.0), ticks=ticks),
        Axis("fraction of cases", scale=fmt.Scale(100.0, "%"), limits=(0.0, 1.0)),
        tuple(
            _shares(
                [case for case in cases if case.half == half], Look(f"{half} half", BLUE, dash=d)
            )
            for half, d in (("reported", SOLID), ("fitting", DOTTED))
        ),
        guides=(Guide(1.0, colour=INK), Guide(3.0, colour=INK)),
    )


def _shares(cases: list[Case], drawn: Look) -> Series:
    ratios = np.sort([case.bar / max(case.error, 1e-16) for case in cases])
    share = (np.arange(len(ratios)) + 1) / max(len(ratios), 1)
    x = np.clip(ratios, 0.1, 1e4)
    return Series(drawn, x, share, marks=False, stairs=True, hover=drawn.label)
