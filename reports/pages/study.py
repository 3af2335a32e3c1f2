"""The report of a study: one self-contained HTML page.

The parts common to all pages (embedding, escaping, scripts) are in `reports.pages.page`.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import in_order
from comparisons.files import write_text
from comparisons.judging.verdicts import NO_RESULT, NOT_RESOLVED, OUTSIDE, WITHIN
from comparisons.results.advice import ITSELF, Advice, advise
from comparisons.results.confidence import confidence
from comparisons.results.cost import spent
from comparisons.results.decisions import Verdict, judged_methods, second_rows, verdicts
from comparisons.results.families import family
from comparisons.results.finding import methods_of
from comparisons.results.store import SceneRecord, StudyRecord
from reports.pages import glossary
from reports.pages.claims import FOLDER, ClaimsBeside, claims_beside
from reports.pages.judging import judging
from reports.pages.page import render
from reports.pages.summary import Summary, compared_methods, summary, times_to_errors
from reports.pictures import pictures
from reports.plots import curves, errors, physics, pressure, speed, stored, surfaces
from reports.plots.claims import validity_map
from reports.plots.figure import Figure
from reports.plots.model import failure_view, reduced_picture
from reports.plots.style import look
from reports.tables import scene as tables
from reports.tables.judged import finding_table
from reports.tables.plans import plan_rows
from reports.tables.table import Table

TURNING = "picture-view"
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


@dataclass(frozen=True)
class SceneView:
    """The data that the template shows for one scene."""

    record: SceneRecord
    anchor: str
    verdicts: dict[str, Verdict]
    judged: dict[str, dict[str, Verdict]]
    at_other_load: list[Verdict]
    advice: Advice
    plan: list[dict[str, Any]]
    figures: dict[str, list[Figure]]
    picture: pictures.Picture
    summary: Summary
    loads: stored.SliderSteps
    settings: Table
    times: Table
    stability: Table
    steps: Table
    seconds: float

    @property
    def title(self) -> str:
        """The title of the scene, or its name."""
        return self.record.title or self.record.name

    @property
    def answer(self) -> str:
        """The advice in one sentence."""
        return self.advice.sentence

    @property
    def confidence(self) -> str:
        """What its bars stand for."""
        return confidence(self.record)

    @property
    def family(self) -> str:
        """What kind of scene it is."""
        return family(self.record)


def write_report(record: StudyRecord, path: Path, *, pictures: bool = True) -> None:
    """Write a study as one HTML file.

    Parameters
    ----------
    record : StudyRecord
    path : Path
        The file to write, atomically.
    pictures : bool
        Render the three-dimensional pictures (one or two seconds each, in a separate process).
    """
    write_text(Path(path), page(record, with_pictures=pictures))


def page(record: StudyRecord, *, with_pictures: bool = True) -> str:
    """Return the whole page as text."""
    views = _views(record, with_pictures)
    claims = claims_beside(record.directory)
    settings = [(view.anchor, view.record, view.advice) for view in views]
    everything = speed.overview(settings)
    standing = validity_map(record.scenes)
    return render(
        "report.html.j2",
        _drawn(views, claims) | {item.key: item for item in (everything, standing) if item},
        data={
            "judging": judging(
                [
                    (
                        view.anchor,
                        view.record,
                        {name: verdicts(view.record, name) for name in judged_methods(view.record)},
                        view.advice,
                    )
                    for view in views
                ]
            )
            | {"places": speed.places(settings)}
        },
        record=record,
        views=views,
        families=_families(views),
        findings={
            method: finding_table(record.scenes, method) for method in methods_of(record.scenes)
        },
        overview=everything,
        validity=standing,
        compared=compared_methods(record.scenes),
        quantities=_columns(views),
        choosable=_shown_quantities(views),
        tally=_tally(views),
        claims=claims,
        claims_folder=record.directory.parent / FOLDER,
        seeds=_seeds(record),
        evidence=[(name, heading) for name, heading, _ in EVIDENCE],
        glossary=glossary,
        itself=ITSELF,
        of_means=tables.OF_MEANS,
    )


def _families(views: list[SceneView]) -> dict[str, list[SceneView]]:
    """Return the scenes of each family, in the order in which the families first appear."""
    groups: dict[str, list[SceneView]] = {}
    for view in views:
        groups.setdefault(view.family, []).append(view)
    return groups


def _drawn(
    views: list[SceneView], claims: ClaimsBeside | None
) -> dict[str, Figure | dict[str, Any]]:
    """Return all figures by the keys of their canvases."""
    drawn: dict[str, Figure | dict[str, Any]] = {
        f"{view.anchor}-{figure.key}": figure
        for view in views
        for group in view.figures.values()
        for figure in group
    }
    for view in views:
        if view.picture.view:
            drawn[f"{view.anchor}-{TURNING}"] = view.picture.view
    for number, figure in enumerate(claims.figures if claims else (), start=1):
        if figure:
            drawn[f"claim-{number}-evidence"] = figure
    return drawn


def _shown_quantities(views: list[SceneView]) -> list[str]:
    """Return the plotted quantities in standard order, for the page's menu."""
    names = {
        name
        for view in views
        for group in view.figures.values()
        for figure in group
        for name in figure.quantity.split()
    }
    return in_order(names)


def _views(record: StudyRecord, with_pictures: bool) -> list[SceneView]:
    off = [pictures.Picture(note="Pictures are switched off.")] * len(record.scenes)
    # Rendering waits for a process of its own, and the plots need not wait for it.
    with ThreadPoolExecutor(1) as beside:
        images = (
            beside.submit(pictures.draw, record.scenes, record.directory) if with_pictures else None
        )
        views = [
            _view(scene, f"scene-{number}") for number, scene in enumerate(record.scenes, start=1)
        ]
        drawn = off if images is None else images.result()
    return [_with_picture(view, image) for view, image in zip(views, drawn, strict=True)]


def _with_picture(view: SceneView, picture: pictures.Picture) -> SceneView:
    if view.figures["model"] and picture.note == pictures.NOTHING:
        return view  # the model's own figure is picture enough
    return replace(view, picture=picture)


def _view(scene: SceneRecord, anchor: str) -> SceneView:
    judged = {name: verdicts(scene, name) for name in judged_methods(scene)}
    decided = next(iter(judged.values()))
    failing = failure_view(scene)
    # The line stands beside its surface where there is one.
    reduced = None if failing else reduced_picture(scene)
    advice = advise(scene)
    return SceneView(
        record=scene,
        anchor=anchor,
        verdicts={verdict.quantity: verdict for verdict in decided},
        judged={
            "" if name == MODEL else look(name).label: {
                verdict.quantity: verdict for verdict in items
            }
            for name, items in judged.items()
        },
        at_other_load=second_rows(scene),
        advice=advice,
        plan=plan_rows(scene),
        figures={
            "model": [reduced] if reduced else [],
            "failure": failing,
            "roughness": surfaces.roughness(scene),
            **{name: draw(scene) for name, _, draw in EVIDENCE},
        },
        picture=pictures.Picture(),
        summary=summary(scene, decided, advice),
        loads=stored.slider_steps(scene),
        settings=tables.settings(scene),
        times=times_to_errors(scene, advice),
        stability=tables.stability(scene),
        steps=tables.load_steps(scene),
        seconds=spent(scene),
    )


def _seeds(record: StudyRecord) -> dict[str, int]:
    """Return the seed of every scene with random surfaces; the default is 0."""
    seeds = {}
    for scene in record.scenes:
        for name, surface in (("surface", ""), ("surface2", " (second surface)")):
            table = scene.tables.get(name)
            if isinstance(table, dict):
                seeds[f"{scene.name}{surface}"] = table.get("seed", 0)
    return seeds


def _columns(views: list[SceneView]) -> list[str]:
    """Return the compared quantities of all scenes, known ones first, in standard order."""
    return in_order(name for view in views for name in view.verdicts)


def _tally(views: list[SceneView]) -> list[tuple[str, int]]:
    """Return how many scenes have which verdict."""
    counts = Counter(view.summary.decisive.word for view in views if view.summary.decisive)
    return [(word, counts[word]) for word in (OUTSIDE, NOT_RESOLVED, WITHIN, NO_RESULT)]
