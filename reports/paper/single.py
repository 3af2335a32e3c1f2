"""Figures of single results: one method's load curve, and a claim along its parameter."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.questions.claims.record import ClaimRecord
from comparisons.questions.single import SingleResult
from comparisons.scene.loading import NORMAL
from reports.paper.drawing import draw_errors_axis, finish_scale, wrapped
from reports.paper.style import PaperFigure, axis_label, house_style, literal, look, new_figure
from reports.plots.curves import error_range
from reports.plots.style import wants_log


def solution_figure(result: SingleResult, quantity: str | None = None) -> PaperFigure:
    """Draw a quantity over the prescribed load: by default force and penetration together."""
    columns = result.columns()
    control, axis = result.plan.loads.control, result.plan.loads.axis
    along = "time" if axis == "time" and "time" in columns else control
    if quantity is None:
        given = [q for q in result.plan.scene.compare.quantities if q in columns and q != along]
        quantity = given[0] if given else next(iter(columns))
    x, y = np.asarray(columns[along], dtype=float), np.asarray(columns[quantity], dtype=float)
    scales = [
        fmt.prefix_for(v, fmt.quantity(n).unit) for v, n in ((x, along), (y, quantity))
    ]  # fmt: skip
    own = look(result.method)
    with house_style():
        figure = new_figure()
        axes = figure.subplots()
        axes.plot(
            x * scales[0].factor, y * scales[1].factor, own.marker, ls=own.dash, color=own.colour,
            markersize=own.size, label=own.label,
        )  # fmt: skip
        if along in NORMAL and wants_log(x) and (y[np.isfinite(y)] > 0).all():
            axes.loglog()
            finish_scale(axes.xaxis)
            finish_scale(axes.yaxis)
        axes.set_xlabel(axis_label(along, scales[0].unit))
        axes.set_ylabel(wrapped(axis_label(quantity, scales[1].unit)))
        figure.legend(loc="outside upper center")
    return figure


def claim_figure(claim: ClaimRecord) -> PaperFigure | None:
    """Draw a claim's error along its parameter, with bars; None without a parameter."""
    points = [p for p in claim.points if p.parameter is not None and p.error is not None]
    if not points:
        return None
    at = np.array([p.parameter for p in points], dtype=float)
    error = np.abs(np.array([p.error for p in points], dtype=float))
    bar = np.array([np.nan if p.uncertainty is None else p.uncertainty for p in points])
    low, high = error_range(np.concatenate([error, error + np.nan_to_num(bar)]), claim.tolerance)
    size = np.maximum(error, low)
    own = look(claim.method)
    with house_style():
        figure = new_figure()
        axes = figure.subplots()
        if claim.spacing == "log":
            axes.set_xscale("log")
        down = np.minimum(np.nan_to_num(bar), size - low)
        axes.errorbar(
            at, size, yerr=[down, np.nan_to_num(bar)], fmt=own.marker, ms=own.size, lw=0.8,
            color=own.colour, capsize=1.5, label=own.label,
        )  # fmt: skip
        for each in claim.ranges:
            axes.axvspan(each.low, each.high, color="#00624a", alpha=0.08, lw=0, label="holds")
        draw_errors_axis(axes, claim.tolerance, low, high, "error")
        axes.set_xlabel(literal(claim.parameter))
        finish_scale(axes.xaxis)
        handles = dict(zip(*reversed(axes.get_legend_handles_labels()), strict=True))
        figure.legend(handles.values(), handles.keys(), loc="outside upper center", ncols=3)
    return figure
