"""The reduced model, its profile or rough line; beside a rough surface why their areas differ."""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import NORMAL
from comparisons.methods.normal.grid import block_means
from comparisons.results.record import MEAN, SceneRecord
from reports.plots.axes import log_axis, padded, value_axis, wants_log
from reports.plots.figure import (
    MOST_PIXELS,
    Axis,
    Band,
    Figure,
    Level,
    Map,
    Series,
    coarsened,
    line,
    map_figure,
    moving,
    outer,
)
from reports.plots.pressure import Field, leading_map, pressure_fields
from reports.plots.stored import SliderSteps, at_last_load, slider_steps, stored_fields
from reports.plots.style import CIRCLE, CONTACT, DASHED, DOTTED, INK, MUTED, Look, look

MOST_LINE_POINTS = 1500
MOST_PROFILE_POINTS = 160
LINE, TOUCHING = Look("line of the model", MUTED), Look("in contact", CONTACT)
PROFILE = Look("equivalent profile g(x)", INK)
# Of the scale of a map: heights end below, contacts begin where little of a block touches.
HEIGHTS, FAINTEST = 0.85, 0.9
LEAST = 1e-6  # of the nominal area: what lies below is no contact to be seen
LENGTH = Look("length of the line in contact", look(MODEL).colour, CIRCLE, DOTTED, 6)
NOW = Look("load of the slider", INK)


def reduced_picture(scene: SceneRecord) -> Figure | None:
    """Return the one-dimensional model: the profile or the rough line, and its springs."""
    if not scene.resolutions_solved(MODEL):  # no load has an answer
        return None
    fields = next((item.fields for item in stored_fields(scene, [MODEL])), {})
    if {"line_x", "line_height", "line_penetration"} <= fields.keys():
        return _line_figure(scene, fields)
    if {"profile_x", "profile_height", "penetration"} <= fields.keys():
        return _profile_figure(scene, fields)
    return None


def _line_figure(scene: SceneRecord, fields: dict[str, np.ndarray]) -> Figure:
    heights = np.ravel(fields["line_height"])
    x, height = thinned(np.ravel(fields["line_x"]), heights)
    last = float(fields["line_penetration"])
    share = np.mean(heights >= heights.max() - last)
    empty = Figure(
        "reduced-line",
        "Reduced model",
        "The first rough line of the reduced model. Points above the dashed level compress "
        f"springs ({fmt.relative(share)} of the line{at_last_load(scene)}).",
        Axis("along the line x", scale=fmt.prefix_for(x, "m")),
        Axis("height h", scale=fmt.prefix_for(height, "m")),
    )
    frames = []
    for depth in (*_earlier_depths(scene), last):
        level = heights.max() - depth
        touching = line(TOUCHING, x, np.where(height >= level, height, np.nan), 3.0)
        drawn = line(LINE, x, height, 1.0), touching
        frames.append(replace(empty, series=drawn, levels=(Level(level, dash=DASHED),)))
    return moving(frames)


def _profile_figure(scene: SceneRecord, fields: dict[str, np.ndarray]) -> Figure | None:
    x, height = np.ravel(fields["profile_x"]), np.ravel(fields["profile_height"])
    last = float(fields["penetration"])
    keep = np.flatnonzero(np.isfinite(height) & (height <= 2 * last))
    if len(keep) < 2:
        return None
    keep = keep[:: -(-len(keep) // MOST_PROFILE_POINTS)]
    x, height = x[keep], height[keep]
    if x.min() >= 0:  # given on one side only
        x, height = np.concatenate([-x[::-1], x]), np.concatenate([height[::-1], height])
    moves = scene.control in NORMAL and not scene.is_path
    reached = f"{fmt.with_unit(last, 'm')}{at_last_load(scene) if moves else ''}"
    empty = Figure(
        "reduced-profile",
        "Reduced model",
        "The equivalent one-dimensional profile, indented to the dashed level "
        f"({reached}). The shaded height is the compression of the springs.",
        Axis("along the line x", scale=fmt.prefix_for(x, "m")),
        Axis("profile g", scale=fmt.prefix_for(last, "m")),
        (line(PROFILE, x, height),),
        legend=False,
    )
    frames = []
    for depth in (*_earlier_depths(scene), last):
        inside = height <= depth
        level = np.full(int(inside.sum()), depth)
        springs = Band(x[inside], height[inside], level, CONTACT, 0.35)
        frames.append(replace(empty, bands=(springs,), levels=(Level(depth, dash=DASHED),)))
    return moving(frames)


def _earlier_depths(scene: SceneRecord) -> list[float]:
    """Return the penetration of realisation 0 at all loads but the last; NaN where it failed."""
    rows = scene.solved_rows(MODEL)
    finest = rows["resolution"] == scene.resolutions_solved(MODEL)[-1]
    rows = rows.where(finest & (rows["realisation"] != MEAN))
    steps, depth = rows["step"], rows["penetration"]
    # The first realisation stands first.
    first = [depth[steps == step][:1] for step in slider_steps(scene).steps[:-1]]
    return [float(depths[0]) if len(depths) else float("nan") for depths in first]


def thinned(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Keep the highest point of each bin, because the peaks make the contact."""
    if len(x) <= MOST_LINE_POINTS:
        return x, y
    edges = np.linspace(0, len(x), MOST_LINE_POINTS + 1).astype(int)
    keep = np.array([a + int(np.argmax(y[a:b])) for a, b in pairwise(edges)])
    return x[keep], y[keep]


def failure_view(scene: SceneRecord) -> list[Figure]:
    """Return the surface and its line with their contacts, and both fractions over the load.

    Nothing where a scene has no rough surface, or where one of the two was not solved.
    """
    of_line = reduced_picture(scene)
    if of_line is None or of_line.key != "reduced-line":
        return []
    fields = [item for item in pressure_fields(scene) if item.rough and item.on_a_grid]
    if not fields:
        return []
    loads = slider_steps(scene)
    item = leading_map(scene, fields)
    shown = replace(
        of_line,
        title="Contact of its line",
        caption=f"{of_line.caption} Each contact of length l counts as a disc, A = πl²/4 (19.29).",
        quantity="contact_area",
    )
    heights = scene.load_fields(item.method, item.resolution).get("heights", np.empty(0))
    known = heights.shape == item.shape
    relief = heights - heights.min() if known else np.zeros(item.shape)
    relief = HEIGHTS * (0.02 + 0.98 * relief / (float(np.max(relief)) or 1.0))
    frames = []
    step = -(-max(item.shape) // MOST_PIXELS)
    blocks = np.arange(0, item.shape[0], step), np.arange(0, item.shape[1], step)
    x, y, relief = coarsened(*item.axes, relief)
    for at_load in item.at_loads:
        pressure = np.zeros(item.shape) if at_load is None else at_load.pressure
        cells = pressure.reshape(item.shape) > 0 if item.share is None else item.share
        share = block_means(cells, blocks)
        values = np.where(share > 0, FAINTEST + (1 - FAINTEST) * share, relief)
        frames.append(Map(x, y, values, "contact", highest=1.0, contacts=True))
    nominal = float(np.prod([np.diff(outer(axis))[0] for axis in item.axes]))
    several = scene.realisations(item.method, item.resolution)
    rows = (
        several.where(several["realisation"] == "0")
        if len(several)
        else scene.curve(item.method, item.resolution)
    )
    areas = rows["contact_area"]
    touching = float(areas[-1]) / nominal if len(areas) else float("nan")
    merged = step > 1 or item.share is not None
    marks = " Each mark is a block of cells, the paler the less of it touches." if merged else ""
    surface = map_figure(
        "failure-surface",
        "Contact of the surface",
        f"Heights, grey, and contacts, orange: {fmt.relative(touching)} of this surface"
        f"{at_last_load(scene)}. {item.label}.{marks}",
        frames,
        "contact_area",
    )
    return [surface, shown, *_fractions(scene, item, nominal, loads)]


def _fractions(scene: SceneRecord, item: Field, nominal: float, loads: SliderSteps) -> list[Figure]:
    """Return contact area and length over the load as shares, with the load of the slider."""
    truth = scene.reference.method or item.method
    along = scene.drawn_along
    drawn: list[Series] = []
    steps: list[np.ndarray] = []
    for method, name, style, whole in (
        (truth, "contact_area", look(truth, scene), nominal),
        (MODEL, "contact_area", look(MODEL, scene), nominal),
        (MODEL, "contact_length", LENGTH, float(np.sqrt(nominal))),
    ):
        rows = scene.curve(method)
        share = rows[name] / whole
        label = style.label if style is LENGTH else f"area, {style.label}"
        if (share > LEAST).any():
            x = rows[along]
            drawn.append(Series(style.labelled(label), x, share, hover=label))
            steps.append(rows["step"])
    if len(drawn) < 2 or scene.of_one_load:
        return []
    reached, places = (np.concatenate([getattr(series, axis) for series in drawn]) for axis in "yx")
    limits = padded(reached[reached > LEAST], 0.05, 0.2)  # a tick at least
    in_words = ""
    if len(drawn) == 3 and all(len(series.y) for series in drawn):
        surface, discs, length = (fmt.relative(float(series.y[-1])) for series in drawn)
        in_words = (
            f"At the last load the line touches along {length} of its length, its discs add up to "
            f"{discs} of the area, and the surface touches on {surface}. "
        )
    empty = Figure(
        "failure-fractions",
        "In contact, as a share of the whole",
        f"Means over the surfaces and over the lines. {in_words}Ring: the load of the slider.",
        value_axis(along, places, wants_log(places)),
        log_axis("share in contact", limits, fmt.tolerance),
        quantity="contact_area",
    )

    def ring(step: int) -> Series:
        """Return rings around the points of a load step (-1: the last)."""
        pairs = [
            (x, y)
            for series, own in zip(drawn, steps, strict=True)
            for x, y, at in zip(series.x, series.y, own, strict=True)
            if at == (own.max() if step < 0 else step)
        ]
        x, y = np.array(pairs).T if pairs else (np.empty(0), np.empty(0))
        return Series(NOW, x, y, line=False, hollow=True, size=15)

    return [moving([replace(empty, series=(*drawn, ring(s))) for s in loads.steps or (-1,)])]
