"""Why the contact area fails: the contact of a rough surface and of its line, over the load."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.plots.axes import log_axis, padded, value_axis, wants_log
from reports.plots.figure import Axis, Figure, Map, Series
from reports.plots.load_slider import SliderSteps, slider_steps
from reports.plots.model import reduced_picture
from reports.plots.pressure import Field, at_loads, coarsened, leading_map, outer, pressure_fields
from reports.plots.style import CIRCLE, DOTTED, INK, Look, look

# Of the scale of a map: heights end below, contacts stand at its top.
HEIGHTS = 0.85
LEAST = 1e-6  # of the nominal area: what lies below is no contact to be seen
LENGTH = Look("length of the line in contact", look(MODEL).colour, CIRCLE, DOTTED, 6)
NOW = Look("load of the slider", INK)


def failure_view(scene: SceneRecord) -> list[Figure]:
    """Return the surface and its line with their contacts, and both fractions over the load.

    Nothing where a scene has no rough surface, or where one of the two was not solved.
    """
    line = reduced_picture(scene)
    if line is None or line.key != "reduced-line":
        return []
    fields = [item for item in pressure_fields(scene) if item.rough and item.on_a_grid]
    if not fields:
        return []
    loads = slider_steps(scene)
    item = leading_map(scene, fields)
    touching = float(np.mean(item.pressure > 0))
    shown = replace(
        line,
        title="Contact of its line",
        caption=f"{line.caption} Each contact of length l counts as a disc, A = πl²/4 (19.29).",
        quantity="contact_area",
    )
    fractions = _fractions(scene, item, loads)
    return [_surface(scene, item, touching, loads), shown, *fractions]


def _surface(scene: SceneRecord, item: Field, touching: float, loads: SliderSteps) -> Figure:
    """Return the heights of the surface with its contacts in one colour."""
    heights = scene.load_fields(item.method, item.resolution).get("heights", np.empty(0))
    x, y = item.x.reshape(item.shape)[:, 0], item.y.reshape(item.shape)[0, :]
    known = heights.shape == item.shape
    relief = heights - heights.min() if known else np.zeros(item.shape)
    relief = HEIGHTS * (0.02 + 0.98 * relief / (float(np.max(relief)) or 1.0))
    frames = [
        relief if frame is None else np.where(_touched(frame, item), 1.0, relief)
        for frame in at_loads(item, loads)
    ]
    across = fmt.prefix_for(np.concatenate([x, y]), "m")
    shown = [coarsened(values, x, y) for values in frames]
    figures = [
        Figure(
            "failure-surface",
            "Contact of the surface",
            f"Heights, grey, and contacts, orange: {fmt.relative(touching)} of this surface at the "
            f"last load. {look(item.method, scene).label}, N = {item.resolution}.",
            Axis("x", scale=across, limits=outer(along)),
            Axis("y", scale=across, limits=outer(up)),
            map=Map(along, up, values, "contact", highest=1.0, contacts=True),
            quantity="contact_area",
        )
        for values, along, up in shown
    ]
    return replace(figures[-1], earlier=tuple(figures[:-1]))


def _touched(frame: Field, item: Field) -> np.ndarray:
    return (frame.pressure > 0).reshape(item.shape)


def _fractions(scene: SceneRecord, item: Field, loads: SliderSteps) -> list[Figure]:
    """Return contact area and length over the load as shares, with the load of the slider."""
    x, y = item.x.reshape(item.shape)[:, 0], item.y.reshape(item.shape)[0, :]
    nominal = float(np.diff(outer(x))[0] * np.diff(outer(y))[0])
    curves = []
    for method, name, whole in (
        (selection.reference(scene)[0] or item.method, "contact_area", nominal),
        (MODEL, "contact_area", nominal),
        (MODEL, "contact_length", float(np.sqrt(nominal))),
    ):
        rows = selection.curve(scene, method)
        share = selection.column(rows, name) / whole
        style = LENGTH if name == "contact_length" else look(method, scene)
        if (share > LEAST).any():
            style = style if name == "contact_length" else style.labelled(f"area, {style.label}")
            curves.append((style, rows, share))
    if len(curves) < 2:
        return []
    along = selection.drawn_along(scene)
    drawn = [
        Series(style, selection.column(rows, along), share, hover=style.label)
        for style, rows, share in curves
    ]
    reached = np.concatenate([series.y for series in drawn])
    limits = padded(reached[reached > LEAST], 0.05, 0.2)  # a tick at least
    places = np.concatenate([series.x for series in drawn])
    steps = [selection.column(rows, "step") for _, rows, _ in curves]
    empty = Figure(
        "failure-fractions",
        "In contact, as a share of the whole",
        f"Means over the surfaces and over the lines. {_in_words(drawn)}Ring: the load of the "
        "slider.",
        value_axis(along, places, wants_log(places)),
        log_axis("share in contact", limits, fmt.tolerance),
        quantity="contact_area",
    )
    figures = [
        replace(empty, series=(*drawn, _ring(drawn, steps, step))) for step in loads.steps or (-1,)
    ]
    return [replace(figures[-1], earlier=tuple(figures[:-1]))]


def _in_words(drawn: list[Series]) -> str:
    """Return what the three shares are at the last load, where all are known."""
    if len(drawn) != 3 or not all(len(series.y) for series in drawn):
        return ""
    surface, model, length = (fmt.relative(float(series.y[-1])) for series in drawn)
    return (
        f"At the last load the line touches along {length} of its length, its discs add up to "
        f"{model} of the area, and the surface touches on {surface}. "
    )


def _ring(drawn: list[Series], steps: list[np.ndarray], step: int) -> Series:
    """Return rings around the points of a load step (-1: the last)."""
    pairs = [
        (x, y)
        for series, own in zip(drawn, steps, strict=True)
        for x, y, at in zip(series.x, series.y, own, strict=True)
        if at == (own.max() if step < 0 else step)
    ]
    x, y = np.array(pairs).T if pairs else (np.empty(0), np.empty(0))
    return Series(NOW, x, y, line=False, hollow=True, size=15)
