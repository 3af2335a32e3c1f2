"""Figures for papers: single columns, a page-wide overview of a scene, one of all verdicts."""

from __future__ import annotations

import re
from collections.abc import Sequence
from typing import Any

from comparisons.facts.methods import ours
from comparisons.results.finding import deciding
from comparisons.results.store import SceneRecord
from reports.paper.drawing import draw
from reports.paper.style import PAGE, PaperFigure, house_style, literal, new_figure
from reports.plots.curves import printed_curves
from reports.plots.errors import errors
from reports.plots.figure import Figure
from reports.plots.speed import speed
from reports.plots.style import look
from reports.plots.verdict_map import verdict_map


def file_name(*names: str) -> str:
    """Return names joined to a safe file name of letters, digits and hyphens.

    >>> file_name("../ball", "contact_area")
    'ball-contact-area'
    """
    parts = (re.sub("[^a-z0-9]+", "-", name.lower()).strip("-") for name in names)
    return "-".join(part for part in parts if part)[:150]


def panels(scene: SceneRecord) -> dict[str, Figure]:
    """Return the plots available for a scene, with their file names."""
    drawn = {
        file_name(figure.quantity, figure.x.quantity): figure for figure in printed_curves(scene)
    }
    return drawn | {file_name(figure.key): figure for figure in (*errors(scene), *speed(scene))}


def single(figure: Figure) -> PaperFigure:
    """Return a plot as a single-column figure (85 mm)."""
    with house_style():
        paper = new_figure()
        axes = paper.subplots()
        draw(axes, figure)
        _legend(paper, [axes], columns=3)
    return paper


def overview(scene: SceneRecord) -> PaperFigure | None:
    """Return a lettered, page-wide figure (180 mm) of curves, error and cost, or None.

    Error and cost are those of the quantity that decides the verdict of the scene.
    """
    chosen = [
        *printed_curves(scene)[:2],
        *_deciding_first(scene, errors(scene))[:1],
        *_deciding_first(scene, speed(scene))[:1],
    ]
    if not chosen:
        return None
    rows = (len(chosen) + 1) // 2
    with house_style():
        paper = new_figure(PAGE, 12.0 + 58.0 * rows)
        cells = paper.add_gridspec(rows, 2)
        grid = [paper.add_subplot(cells[divmod(place, 2)]) for place in range(len(chosen))]
        for letter, figure, axes in zip("abcd", chosen, grid, strict=False):
            draw(axes, figure)
            axes.set_title(f"({letter})", loc="left", fontsize=8, fontweight="bold")
        _legend(paper, grid, columns=6)
    return paper


def _deciding_first(scene: SceneRecord, figures: list[Figure]) -> list[Figure]:
    decisive = deciding(scene)
    name = decisive.quantity if decisive else ""
    return sorted(figures, key=lambda figure: figure.quantity != name)


def verdict_figure(scenes: Sequence[SceneRecord]) -> PaperFigure | None:
    """Return the page-wide figure of all verdicts, or None where nothing was asked for."""
    figure = verdict_map(scenes)
    if figure is None:
        return None
    with house_style():
        paper = new_figure(PAGE, 24.0 + 4.6 * len(scenes))
        axes = paper.subplots()
        draw(axes, figure)
        _legend(paper, [axes], columns=6)
    return paper


def _legend(paper: PaperFigure, grid: Sequence[Any], columns: int) -> None:
    """Draw one legend above the plots, with each name once, methods first."""
    entries: dict[str, Any] = {}
    for axes in grid:
        for handle, label in zip(*axes.get_legend_handles_labels(), strict=True):
            entries.setdefault(label, handle)
    first = [literal(look(method).label) for method in ours()]
    labels = sorted(entries, key=lambda name: first.index(name) if name in first else len(first))
    if not labels:
        return
    rows = -(-len(labels) // columns)
    columns = -(-len(labels) // rows)  # rows of equal length
    paper.legend(
        [entries[label] for label in labels],
        labels,
        loc="outside upper center",
        ncols=columns,
        columnspacing=1.2,
    )
