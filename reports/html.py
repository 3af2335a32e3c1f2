"""The report: one self-contained HTML page that a reader understands in two minutes.

The page needs no network: plotly.js, pictures, styles and data are all inside. Everything that
comes from scenes or results is escaped, and a content security policy that names the page's own
scripts by their hash forbids all others.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
from collections import Counter
from dataclasses import dataclass
from functools import cache
from pathlib import Path
from typing import Any, Protocol

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from markupsafe import Markup
from plotly.offline import get_plotlyjs

from comparisons import formatting as fmt
from comparisons.plain import plain
from comparisons.store import SceneRecord, StudyRecord, write_text
from reports import (
    figures,
    glossary,
    model_figure,
    pictures,
    pressure_figures,
    selection,
    speed_figure,
    tables,
)
from reports.figure_style import Figure, style
from reports.verdicts import NO_RESULT, NOT_RESOLVED, OUTSIDE, WITHIN, Verdict, verdicts, worst

TEMPLATES = Path(__file__).with_name("templates")
STRIP_DECADES = (-6.0, 0.0)  # the small error scale beside a verdict: 1 ppm to 100 %


class Judged(Protocol):
    """An error with its bar and the tolerance asked for."""

    @property
    def error(self) -> float:
        """Relative error."""

    @property
    def uncertainty(self) -> float:
        """Half-width of its bar."""

    @property
    def tolerance(self) -> float:
        """What was asked for."""


@dataclass(frozen=True)
class SceneView:
    """All that the template shows of one scene."""

    record: SceneRecord
    anchor: str
    verdicts: dict[str, Verdict]
    plan: list[dict[str, Any]]
    figures: dict[str, list[Figure]]
    picture: pictures.Picture
    settings: tables.Table
    steps: tables.Table
    seconds: float
    lost: list[str]


def write_report(record: StudyRecord, path: Path, *, pictures: bool = True) -> None:
    """Write a study as one HTML file.

    Parameters
    ----------
    record : StudyRecord
    path : Path
        The file to write, atomically.
    pictures : bool
        Render the three-dimensional pictures (a second or two each, in a separate process).
    """
    write_text(Path(path), page(record, with_pictures=pictures))


def page(record: StudyRecord, *, with_pictures: bool = True) -> str:
    """Return the whole page as text."""
    views = _views(record, with_pictures)
    drawn = {
        f"{view.anchor}-{figure.key}": figure.spec
        for view in views
        for group in view.figures.values()
        for figure in group
    }
    script = (TEMPLATES / "report.js").read_text(encoding="utf-8")
    library = get_plotlyjs()
    return (
        environment()
        .get_template("report.html.j2")
        .render(
            record=record,
            views=views,
            quantities=_columns(views),
            tally=_tally(views),
            policy=content_policy([library, script]),
            style=Markup((TEMPLATES / "report.css").read_text(encoding="utf-8")),  # noqa: S704
            script=Markup(script),  # noqa: S704  our own file
            library=Markup(library),  # noqa: S704  the plotly package's own file
            figure_data={key: embedded_json(spec) for key, spec in drawn.items()},
            glossary=glossary,
        )
    )


def embedded_json(value: Any) -> Markup:
    r"""Return JSON that is safe inside <script>: no '<', so no tag can open or close there.

    NaN and infinities, which browsers refuse in JSON, become null: a gap in a curve.

    >>> print(embedded_json({"a": "</script>"}))
    {"a":"\u003c/script>"}
    """
    text = json.dumps(plain(value), allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    for character in "<&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)  # noqa: S704


def content_policy(scripts: list[str]) -> str:
    """Return the content security policy: our scripts by hash, nothing from anywhere else."""
    hashes = (base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for s in scripts)
    allowed = " ".join(f"'sha256-{digest}'" for digest in hashes)
    return (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )


@cache
def environment() -> Environment:
    """Return the templates with everything that they share."""
    found = Environment(
        loader=FileSystemLoader(TEMPLATES),
        autoescape=select_autoescape(default=True, default_for_string=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    found.globals |= {
        "fmt": fmt,
        "method_style": style,
        "term": _term,
        "strip": _strip,
        "finite": fmt.finite,
        "data_uri": lambda png: "data:image/png;base64," + base64.b64encode(png).decode(),
    }
    return found


def _views(record: StudyRecord, with_pictures: bool) -> list[SceneView]:
    if with_pictures:
        images = pictures.draw(record.scenes)
    else:
        images = [pictures.Picture(note="Pictures were not asked for.")] * len(record.scenes)
    return [
        _view(scene, f"scene-{number}", image)
        for number, (scene, image) in enumerate(zip(record.scenes, images, strict=True), start=1)
    ]


def _view(scene: SceneRecord, anchor: str, picture: pictures.Picture) -> SceneView:
    found: dict[str, list[Verdict]] = {}
    for verdict in verdicts(scene):
        found.setdefault(verdict.quantity, []).append(verdict)
    decisive = {name: worst(items) for name, items in found.items()}
    reduced = model_figure.reduced_picture(scene)
    if reduced and picture.note == pictures.NOTHING:
        picture = pictures.Picture()  # the model's own figure is picture enough
    return SceneView(
        record=scene,
        anchor=anchor,
        verdicts=decisive,
        plan=tables.plan_rows(scene),
        figures={
            "model": [reduced] if reduced else [],
            "curves": figures.curves(scene),
            "errors": figures.errors(scene),
            "pressure": pressure_figures.pressures(scene),
            "speed": speed_figure.speed(scene),
        },
        picture=picture,
        settings=tables.settings(scene),
        steps=tables.load_steps(scene),
        seconds=_spent(scene),
        lost=tables.lost_solves(scene),
    )


def _spent(scene: SceneRecord) -> float:
    """Return the time all solves of a scene took together (each stands on many rows)."""
    rows = scene.rows.assign(seconds=selection.column(scene.rows, "seconds"))
    keys = [name for name in ("method", "options", "resolution") if name in rows]
    return float(rows.groupby(keys, dropna=False)["seconds"].max().sum()) if keys else 0.0


def _columns(views: list[SceneView]) -> list[str]:
    """Return the compared quantities of all scenes, known ones first and in their usual order."""
    found = list(dict.fromkeys(name for view in views for name in view.verdicts))
    known = [name for name in fmt.QUANTITIES if name in found]
    return known + [name for name in found if name not in known]


def _tally(views: list[SceneView]) -> list[tuple[str, int]]:
    words = Counter(item.word for view in views for item in view.verdicts.values())
    return [(word, words[word]) for word in (OUTSIDE, NOT_RESOLVED, WITHIN, NO_RESULT)]


def _term(key: str, text: str | None = None) -> Markup:
    """Return a term with its explanation on hover and a link to the glossary."""
    words, meaning = glossary.TERMS[key]
    return Markup('<a class="term" href="#term-{}"><abbr title="{}">{}</abbr></a>').format(
        key, meaning, text or words
    )


def _strip(verdict: Judged) -> Markup:
    """Return a small logarithmic scale from 1 ppm to 100 %: tolerance, error and its bar."""
    low, high = STRIP_DECADES

    def place(value: float) -> float:
        power = math.log10(value) if value > 0 else low
        return round(100 * (min(max(power, low), high) - low) / (high - low), 1)

    error = abs(verdict.error)
    bar = verdict.uncertainty if fmt.finite(verdict.uncertainty) else 0.0
    return Markup(
        '<svg class="strip" viewBox="-4 0 108 14" role="img" aria-label="{}">'
        '<line class="rail" x1="0" y1="7" x2="100" y2="7"/>'
        '<line class="mark" x1="{t}" y1="1" x2="{t}" y2="13"/>'
        '<line class="bar" x1="{a}" y1="7" x2="{b}" y2="7"/>'
        '<circle cx="{e}" cy="7" r="3.2"/></svg>'
    ).format(
        "error on a logarithmic scale, the tolerance as a tick",
        t=place(verdict.tolerance),
        a=place(error - bar),
        b=place(error + bar),
        e=place(error),
    )
