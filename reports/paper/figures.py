"""The figures of a scene: single ones of one column, and all together across the page."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import Any

from comparisons.results.store import SceneRecord
from reports.paper import drawing
from reports.paper.notation import file_name
from reports.paper.style import PAGE, PaperFigure, house_style, new_figure


@dataclass(frozen=True)
class Panel:
    """One plot: what its file is called, and what draws it on axes."""

    key: str
    draw: Callable[[Any], None]


def panels(scene: SceneRecord) -> list[Panel]:
    """Return the plots that a scene's results allow: curves, errors, costs."""
    found = [
        Panel(file_name(up, across), partial(_curve, scene=scene, across=across, up=up))
        for across, up in drawing.curve_pairs(scene)
    ]
    found += [
        Panel(file_name("error", name), partial(_plain, drawing.draw_error, scene, name))
        for name in drawing.error_quantities(scene)
    ]
    found += [
        Panel(file_name("speed", name), partial(_plain, drawing.draw_speed, scene, name, at))
        for name, at in drawing.speed_quantities(scene)
    ]
    return found


def single(panel: Panel) -> PaperFigure:
    """Return a plot as a figure of one column (85 mm)."""
    with house_style():
        figure = new_figure()
        axes = figure.subplots()
        panel.draw(axes)
        _legend(figure, [axes], columns=3)
    return figure


def overview(scene: SceneRecord) -> PaperFigure | None:
    """Return curves, error and cost across the page (180 mm), lettered; None without them."""
    chosen = _chosen(panels(scene))
    if not chosen:
        return None
    rows = (len(chosen) + 1) // 2
    with house_style():
        figure = new_figure(PAGE, 12.0 + 58.0 * rows)
        cells = figure.add_gridspec(rows, 2)
        grid = [figure.add_subplot(cells[divmod(place, 2)]) for place in range(len(chosen))]
        for letter, panel, axes in zip("abcd", chosen, grid, strict=False):
            panel.draw(axes)
            axes.set_title(f"({letter})", loc="left", fontsize=8, fontweight="bold")
        _legend(figure, grid, columns=6)
    return figure


def _chosen(every: list[Panel]) -> list[Panel]:
    """Return two curves, an error and a cost, as far as there are such."""
    of = {
        kind: [each for each in every if each.key.startswith(kind)] for kind in ("error", "speed")
    }
    curves = [each for each in every if not each.key.startswith(("error", "speed"))]
    return curves[:2] + of["error"][:1] + of["speed"][:1]


def _curve(axes: Any, *, scene: SceneRecord, across: str, up: str) -> None:
    drawing.draw_curve(axes, scene, across, up)
    drawing.finish_scale(axes.xaxis)
    drawing.finish_scale(axes.yaxis)


def _plain(draw: Callable[..., None], *arguments: Any) -> None:
    *given, axes = arguments
    draw(axes, *given)


def _legend(figure: PaperFigure, grid: list[Any], columns: int) -> None:
    """Put one legend above the plots: each name once, whichever plots have it."""
    entries: dict[str, Any] = {}
    for axes in grid:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    labels = sorted(entries, key=drawing.legend_place)
    rows = -(-len(labels) // columns)
    columns = -(-len(labels) // rows)  # rows of equal length
    figure.legend(
        [entries[label] for label in labels], labels, loc="outside upper center", ncols=columns,
        fontsize=7, frameon=False, handlelength=2.4, columnspacing=1.2,
    )  # fmt: skip
