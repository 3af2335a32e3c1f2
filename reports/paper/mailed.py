"""The report for mail: one page of tables and printed figures, without scripts, below 1 MB."""

from __future__ import annotations

from io import BytesIO
from pathlib import Path

from PIL import Image

from comparisons.files import write_text
from comparisons.results.finding import methods_of
from comparisons.results.folder import MAILED
from comparisons.results.store import StudyRecord
from reports.pages.page import render
from reports.paper.figures import overview, sheet
from reports.paper.style import PaperFigure
from reports.plots.sweeps import sweeps
from reports.tables.card import card
from reports.tables.judged import finding_table, methods_table

SWEEP = "sweep of all scenes"
# Of the images together; with many scenes they get fewer colours and pixels.
MOST_BYTES = 600_000
QUALITIES = ((130, 64), (100, 32), (80, 16), (60, 8))  # dots per inch, colours


def write_mailed(record: StudyRecord, directory: Path) -> Path:
    """Write the page beside the report, and return its path."""
    figures = {scene.name: overview(scene) for scene in record.scenes}
    figures[SWEEP] = sheet(sweeps(record.scenes))
    for dots, colours in QUALITIES:
        images = {
            name: b"" if figure is None else _png(figure, dots, colours)
            for name, figure in figures.items()
        }
        if sum(map(len, images.values())) <= MOST_BYTES:
            break
    path = directory / MAILED
    page = render(
        "static.html.j2",
        {},
        static=True,
        record=record,
        swept=images[SWEEP],
        findings=[finding_table(record.scenes, method) for method in methods_of(record.scenes)],
        scenes=[
            (scene, card(scene), methods_table(scene), images[scene.name])
            for scene in record.scenes
        ],
    )
    write_text(path, page)
    return path


def _png(figure: PaperFigure, dots: int, colours: int) -> bytes:
    """Return a figure as an image of few colours."""
    drawn, small = BytesIO(), BytesIO()
    figure.savefig(drawn, format="png", dpi=dots)
    Image.open(drawn).convert("RGB").quantize(colours).save(small, "png", optimize=True)
    return small.getvalue()
