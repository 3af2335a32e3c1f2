"""The report of a study: one self-contained HTML page.

The parts common to all pages (embedding, escaping, scripts) are in `reports.pages.page`. The page
judges anew for another question: it gets the ends of what every error may be, |e| - u and |e| + u
(`judging`), and applies the one rule of `comparisons.judging.verdicts` to another tolerance or to
fewer quantities.
"""

from __future__ import annotations

import os
from collections.abc import Callable, Iterable, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from threadpoolctl import threadpool_limits

from comparisons import formatting as fmt
from comparisons.errors import ResultsError
from comparisons.facts.methods import CLOSED_FORM, MODEL, ours, title_of
from comparisons.facts.quantities import in_order, quantity
from comparisons.files import write_text
from comparisons.judging.verdicts import NO_RESULT, NOT_RESOLVED, OUTSIDE, WITHIN, Verdict, worst
from comparisons.questions.claims.record import RECORD, ClaimsRecord, load_claims_record
from comparisons.results.advice import ITSELF, Advice, Setting, advise
from comparisons.results.finding import (
    family,
    is_found,
    largest_error,
    methods_of,
    symbol,
    unjudged,
)
from comparisons.results.folder import PAGE
from comparisons.results.record import SceneRecord, StudyRecord, title_in
from reports.pages.page import render, tally
from reports.pictures import NOTHING, Picture
from reports.plots import curves, errors, physics, pressure, speed, stored, surfaces
from reports.plots.claims import evidence, validity_map
from reports.plots.errors import sweeps
from reports.plots.figure import Figure
from reports.plots.model import failure_view, reduced_picture
from reports.plots.style import look
from reports.tables import cells
from reports.tables import scene as tables
from reports.tables.card import card, not_known_here
from reports.tables.cells import Cell, Head, Table
from reports.tables.judged import finding_table, not_computed, prepared_table
from reports.tables.runs import plan_rows

TURNING = "picture-view"
FOLDER = "claims"  # where `roughline claims` writes, beside the folders of studies
FIXED_ERRORS = (0.01, 0.001)
MOST_NAMED = 2  # cheapest settings of a scene in the summary
# The plots of a scene below its plan: name, heading, and what draws them.
EVIDENCE: tuple[tuple[str, str, Callable[[SceneRecord], list[Figure]]], ...] = (
    ("curves", "Curves", curves.curves),
    ("errors", "Errors at every step", errors.errors),
    ("pressure", "Contact pressure", pressure.pressures),
    ("distributions", "Distributions over the surface", surfaces.distributions),
    ("slip", "Stick and slip", physics.slips),
    ("film", "Film", physics.films),
    ("worn", "Worn profile", physics.worn_profiles),
    ("dent", "What yields", physics.dents),
    ("stress", "Stress below the contact", physics.stresses_below),
    ("speed", "Speed against error", speed.speed),
)


def write_report(record: StudyRecord, path: Path, *, pictures: bool = True) -> None:
    """Write a study as one HTML file, atomically.

    Three-dimensional pictures take one or two seconds each, in a separate process.
    """
    # Interpolation factors hundreds of tiny matrices: threads would wait longer than they work.
    with threadpool_limits(limits=1):
        text = page(record, with_pictures=pictures)
    write_text(Path(path), text)


def page(record: StudyRecord, *, with_pictures: bool = True) -> str:
    """Return the whole page as text."""
    views = _views(record, with_pictures)
    claims = claims_beside(record.directory)
    # Of one scene the first screen shows its card, and its section the settings.
    everything = speed.overview(record.scenes) if len(views) > 1 else None
    standing, swept = validity_map(record.scenes), sweeps(record.scenes)
    figures = [
        (view, figure) for view in views for group in view.figures.values() for figure in group
    ]
    drawn: dict[str, Figure | dict[str, Any]] = {
        f"{view.anchor}-{figure.key}": figure for view, figure in figures
    }
    drawn |= {f"{view.anchor}-{TURNING}": view.picture.view for view in views if view.picture.view}
    for number, figure in enumerate(claims.figures if claims else (), start=1):
        if figure:
            drawn[f"claim-{number}-evidence"] = figure
    families: dict[str, list[SceneView]] = {}  # in the order in which they first appear
    for view in views:
        families.setdefault(family(view.record), []).append(view)
    words = [next(iter(view.decided.values())).word for view in views if view.decided]
    called = {method: title_in(record.scenes, method) for method in methods_of(record.scenes)}
    return render(
        "report.html.j2",
        drawn | {item.key: item for item in (everything, standing, *swept) if item},
        data={"judging": judging(record.scenes) | {"places": speed.places(record.scenes)}},
        record=record,
        views=views,
        families=families,
        findings={method: finding_table(record.scenes, method) for method in called},
        called=called,
        model=MODEL,
        overview=everything,
        validity=standing,
        swept=swept,
        prepared=prepared_table(record.scenes),
        compared=compared_methods(record.scenes),
        lacking=[
            fmt.capitalised(f"{title}: {said}." if len(called) > 1 else f"{said}.")
            for method, title in called.items()
            if (said := not_computed(record.scenes, method))
        ],
        quantities=in_order(name for view in views for name in view.verdicts),
        choosable=in_order(
            {name for _, figure in figures for name in figure.quantity.split()}
            | {figure.quantity for figure in swept}
        ),
        tally=tally(words, (OUTSIDE, NOT_RESOLVED, WITHIN, NO_RESULT)),
        claims=claims,
        claims_folder=record.directory.parent / FOLDER,
        seeds={
            f"{scene.name}{which}": table.get("seed", 0)
            for scene in record.scenes
            for name, which in (("surface", ""), ("surface2", " (second surface)"))
            if isinstance(table := scene.tables.get(name), dict)
        },
        evidence=[(name, heading) for name, heading, _ in EVIDENCE],
        itself=ITSELF
        if any(s.starred != s.title for v in views for s in v.advice.settings)
        else "",
        in_words=in_words,
        card=card,
        not_known_here=not_known_here,
        plan_rows=plan_rows,
        slider_steps=stored.slider_steps,
        times_to_errors=times_to_errors,
        tables=tables,
    )


@dataclass(frozen=True)
class ClaimsBeside:
    """Claims tested next to a study, with the evidence for each, None where no parameter varies."""

    record: ClaimsRecord
    page: str  # the path of their own page relative to the report; "" if there is none
    figures: list[Figure | None]


def claims_beside(directory: Path) -> ClaimsBeside | None:
    """Return the claims tested next to a study's folder, or None.

    Damaged claims are also left out, so that they cannot prevent the report of the study.
    """
    folder = directory.resolve().parent / FOLDER
    if folder == directory.resolve() or not (folder / RECORD).exists():
        return None
    try:
        record = load_claims_record(folder)
    except ResultsError:
        return None
    page = folder / PAGE
    link = Path(os.path.relpath(page, directory.resolve())).as_posix() if page.exists() else ""
    return ClaimsBeside(record, link, list(map(evidence, record.claims)))


@dataclass(frozen=True, eq=False)
class SceneView:
    """What the page shows of a scene, beside tables and texts that its record gives.

    Judged methods are labelled by their titles, the model, where the page leads with it, by "".
    """

    record: SceneRecord
    anchor: str
    judged: dict[str, dict[str, Verdict]]  # label -> quantity -> verdict
    others: dict[str, dict[str, Verdict]]  # the same of methods that are not judged
    figures: dict[str, list[Figure]]
    picture: Picture = field(default_factory=Picture)

    @property
    def verdicts(self) -> dict[str, Verdict]:
        """Those on the method that the page leads with."""
        return next(iter(self.judged.values()))

    @property
    def decided(self) -> dict[str, Verdict]:
        """Label -> the verdict that decides over a judged method."""
        return {label: worst(known.values()) for label, known in self.judged.items() if known}

    @property
    def advice(self) -> Advice:
        """What its results say about the choice of a method."""
        return advise(self.record)

    @property
    def fastest(self) -> list[Setting]:
        """The cheapest settings that the summary names."""
        return self.advice.reaching()[:MOST_NAMED]

    @property
    def truth(self) -> str:
        """The reference, and how well it is known."""
        if not (method := self.record.reference.method):
            return "none"
        truth = look(method, self.record).label
        if method == CLOSED_FORM:
            return truth
        bar, widest = self.advice.truth_known_to
        return f"{truth} ± {fmt.relative(bar)} in {symbol(widest)}" if widest else f"{truth} ± ?"


def _views(record: StudyRecord, with_pictures: bool) -> list[SceneView]:
    # Rendering waits for a process of its own, and the plots need not wait for it.
    with ThreadPoolExecutor(1) as beside:
        images = None
        if with_pictures:
            from reports.pictures import pictures  # what draws takes long to import

            images = beside.submit(pictures.draw, record.scenes, record.directory)
        views = [scene_view(scene, anchor_of(number)) for number, scene in enumerate(record.scenes)]
        off = Picture(note="Pictures are switched off.")
        drawn = images.result() if images else [off] * len(views)
    # Where there is none, the model's own figure is picture enough.
    return [
        view
        if view.figures["model"] and picture.note == NOTHING
        else replace(view, picture=picture)
        for view, picture in zip(views, drawn, strict=True)
    ]


def anchor_of(number: int) -> str:
    """Return where the scene of a number, from 0, stands on the page."""
    return f"scene-{number + 1}"


def scene_view(scene: SceneRecord, anchor: str) -> SceneView:
    """Return what the page shows of a scene, but for its picture."""

    def by_quantity(verdicts: Iterable[Verdict]) -> dict[str, Verdict]:
        return {verdict.quantity: verdict for verdict in verdicts}

    failing = failure_view(scene)
    # The line stands beside its surface where there is one.
    reduced = None if failing else reduced_picture(scene)
    judged = {
        "" if name == MODEL else scene.title_of(name): by_quantity(scene.verdicts_on(name))
        for name in scene.judged_methods
    }
    others = {
        look(name, scene).label: by_quantity(several)
        for name, several in scene.other_verdicts.items()
    }
    figures = {
        "model": [reduced] if reduced else [],
        "failure": failing,
        "roughness": surfaces.roughness(scene),
        **{name: draw(scene) for name, _, draw in EVIDENCE},
    }
    return SceneView(scene, anchor, judged, others, figures)


def in_words(scene: SceneRecord, verdict: Verdict) -> str:
    """Return the error that decided, or why there is none: "contact area 2 % at d = 1.00 µm"."""
    return largest_error(scene, verdict, lambda name: quantity(name).label)


def compared_methods(scenes: tuple[SceneRecord, ...]) -> list[str]:
    """Return the labels of the methods that solved a scene and are not themselves judged."""
    judged = {MODEL, *(name for scene in scenes for name in scene.judged_methods)}
    names = [method for scene in scenes for method in scene.methods]
    solved = {m for scene in scenes for m in set(names) if len(scene.solved_rows(m))} - judged
    return [
        label
        for name in dict.fromkeys((*ours(), *names))
        if name in solved
        for label in dict.fromkeys(look(name, scene).label for scene in scenes)
    ]


def times_to_errors(scene: SceneRecord) -> Table:
    """Return the cheapest setting of each method that reaches 1 %, 0.1 % and the tolerance."""
    advice = advise(scene)
    errors = sorted({*FIXED_ERRORS, scene.tolerance}, reverse=True)
    reached = {error: advice.cheapest_for(error) for error in errors}
    methods = [m for m in scene.methods if any(m in settings for settings in reached.values())]

    def cell(setting: Setting | None) -> Cell:
        if setting is None:
            return cells.NOTHING
        star = "*" if setting.judges_itself and not setting.is_truth else ""
        text = f"{fmt.duration(setting.seconds)}{star} (N = {setting.resolution})"
        return cells.number(text, setting.seconds)

    columns = [(Head("method"), [cells.method(name, scene=scene) for name in methods])]
    for error, settings in reached.items():
        head = Head(f"time to {fmt.tolerance(error)}", csv=f"time to {error:g} / s")
        columns.append((head, [cell(settings.get(name)) for name in methods]))
    quantities = ", ".join(quantity(name).label for name in advice.quantities)
    note = (
        "Measured time of the cheapest setting that was run with |e| + u below this value in "
        f"{quantities}, at every load step, for this setting and all finer ones of the method. "
        f"–: none. {ITSELF}; the reference counts with its own error bar."
    )
    return cells.of_columns(columns, note=note)


# Tolerances that the slider offers; in the middle of a decade 2 and 5, as on every axis.
STEPS = (*(float(f"{step}e{power}") for power in range(-5, 0) for step in (1, 2, 5)), 1.0)


def judging(scenes: Sequence[SceneRecord]) -> dict[str, Any]:
    """Return what the page needs to judge scenes anew.

    Of the judged methods the page leads with the first.
    """
    return {
        "tolerances": STEPS,
        "labels": [fmt.tolerance(step) for step in STEPS],
        "exact": f"{title_of(CLOSED_FORM)} (exact)",
        "scenes": [
            {
                "anchor": anchor_of(number),
                "name": scene.name,
                "family": family(scene),
                "order": in_order(scene.quantities),
                "tolerance": scene.tolerance,
                "judged": {
                    method: [
                        _ends(verdict)
                        | {
                            "counts": is_found(scene, verdict),
                            "symbol": symbol(verdict.quantity),
                            "text": in_words(scene, verdict),
                            "largest": largest_error(scene, verdict),
                        }
                        for verdict in scene.verdicts_on(method)
                    ]
                    for method in scene.judged_methods
                },
                "others": [
                    [_ends(verdict) for verdict in known] for known in scene.other_verdicts.values()
                ],
                "lucky": sorted(advise(scene).lucky),
                "steep": scene.too_steep,
                "unjudged": unjudged(scene),
                "settings": [_setting(scene, setting) for setting in advise(scene).settings],
            }
            for number, scene in enumerate(scenes)
        ],
    }


def _ends(verdict: Verdict) -> dict[str, Any]:
    return {
        "quantity": verdict.quantity,
        "low": verdict.low,
        "high": verdict.high,
        "error": abs(verdict.error),
        "missing": verdict.word == NO_RESULT,
        "wrong": verdict.word == OUTSIDE and not fmt.finite(verdict.low),
        "counts": verdict.counts,
    }


def _setting(scene: SceneRecord, setting: Setting) -> dict[str, Any]:
    deepest = scene.finest(setting.method) or 0
    return {
        "method": setting.method,
        "title": setting.starred,
        "text": setting.brief,
        "time": fmt.duration(setting.seconds),
        "colour": look(setting.method).colour,
        "n": setting.resolution,
        "seconds": setting.seconds,
        "truth": setting.is_truth,
        # Beyond the finest grid that solved the most steps, a grid is no evidence.
        "judged": not setting.is_truth
        and setting.resolution <= deepest
        and setting.method not in advise(scene).lucky,
        "finest": setting.resolution == deepest,
        "ranked": setting.method != CLOSED_FORM,
        "solver": setting.solves_in_3d,
        "verdicts": [_ends(verdict) for verdict in setting.verdicts],
    }
