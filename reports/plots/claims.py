"""The evidence for claims: error against a parameter, maps of two, and where scenes stand."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.geometry.plausibility import STEEPEST
from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN
from comparisons.questions.claims.nearest import Measured, Nearest, nearest_to
from comparisons.questions.claims.record import ClaimRecord, NuisanceRecord, PointRecord
from comparisons.questions.claims.wording import error_text, value
from comparisons.results.record import SceneRecord
from reports.plots.axes import error_axis, error_range, tolerance_line
from reports.plots.figure import Axis, Figure, Series, Stretch
from reports.plots.style import BLUE, CIRCLE, DOTTED, GREEN, INK, MUTED, VERMILION, Look, Marker

LOOKS = {
    WITHIN: Look("within", GREEN, CIRCLE, size=9),
    OUTSIDE: Look("outside", VERMILION, Marker("x", "X"), size=9),
    NOT_RESOLVED: Look("not resolved", BLUE, CIRCLE, size=9),
}
STEEP = Look("slopes too large: agreement says nothing", MUTED, CIRCLE, DOTTED, 6)
BOUNDARY = Look("boundary", INK, CIRCLE, size=4)
SCENE = Look("scene of this study", INK, Marker("diamond-tall", "d"), size=13)
FEWEST = 4  # points that carry a shaded interval
# What a row of the map names the parameter of its claim by; others by their words.
SYMBOLS = {
    "exponent n": "n",
    "depth over radius d/R": "d/R",
    "ratio of the radii of curvature R'/R''": "R'/R''",
    "Poisson's ratio nu": "nu",
    "creep over that of full slip": "creep/full slip",
    "load F/(E* A0 h')": "F/(E* A0 h')",
    "Hurst exponent H": "H",
    "Maugis' parameter lambda": "lambda",
}
VALIDITY = (
    "Each row is a claim on the reduced model along its own parameter, from the least value that "
    "was measured, left, to the largest, judged at the tolerance in its name. Diamonds: where the "
    "scenes of this study stand, at their largest error where loads spread; at an edge: beyond it."
)


def evidence(
    claim: ClaimRecord, nuisance: NuisanceRecord | None = None, fewest: int = 2
) -> Figure | None:
    """Return the errors at `fewest` or more values of the claim's parameter, or of a nuisance.

    None where less was measured, or the nuisance is a choice.
    """
    measured = nuisance or claim
    key, parameter = "evidence", claim.parameter
    if nuisance:
        key, parameter = f"along-{claim.nuisances.index(nuisance)}", nuisance.name
    points = [p for p in measured.points if p.parameter is not None and p.error is not None]
    if len(points) < fewest or (nuisance and nuisance.choices):
        return None
    low, high = error_range(np.array([abs(p.error or 0.0) for p in points]), claim.tolerance)
    series = []
    for word, style in LOOKS.items():
        if own := [p for p in points if p.word == word]:
            x = np.array([p.parameter for p in own], dtype=float)
            y = np.array([max(abs(p.error or 0.0), low) for p in own])  # not below the axis
            bars = np.array([p.uncertainty or 0.0 for p in own])
            hover, hollow = tuple(map(_hover, own)), word == NOT_RESOLVED
            series.append(Series(style, x, y, line=False, hollow=hollow, bars=bars, hover=hover))
    axis = Axis(fmt.greek(parameter), log=measured.spacing == "log")
    return Figure(
        key,
        f"Error against {axis.title}",
        "Error magnitude with its bar at every measured value. The claim holds in the shaded "
        "interval, whose ends are known to the spacing of the neighbouring markers.",
        axis,
        error_axis(low, high, "magnitude of relative error"),
        tuple(series),
        levels=(tolerance_line(claim.tolerance),),
        stretches=tuple(
            Stretch(interval.low, interval.high, GREEN, "holds")
            for interval in measured.ranges
            if sum(interval.low <= (p.parameter or 0.0) <= interval.high for p in points) >= FEWEST
        ),
    )


def boundary_map(claim: ClaimRecord) -> Figure | None:
    """Return where a claim holds in two parameters, or None if that was not measured.

    A boundary is between a point within and the next one outside; points that are not resolved are
    on neither side, and beside them alone no boundary is certain.
    """
    drawn = claim.map
    if drawn is None:
        return None
    series = []
    for word, style in LOOKS.items():
        points = [(p, row.number) for row in drawn.rows for p in row.points if p.word == word]
        if points:
            x = np.array([p.parameter for p, _ in points], dtype=float)
            y = np.array([number for _, number in points], dtype=float)
            hover, hollow = tuple(_hover(p) for p, _ in points), word == NOT_RESOLVED
            series.append(Series(style, x, y, line=False, hollow=hollow, hover=hover))
    ends = [
        (row.number, low.parameter, high.parameter)
        for row in drawn.rows
        for low, high in pairwise(p for p in row.points if p.word in (WITHIN, OUTSIDE))
        if low.word != high.word
    ]
    x = np.array([float(end) for _, low, high in ends for end in (low or 0.0, high or 0.0, np.nan)])
    y = np.repeat([number for number, *_ in ends], 3)
    series.append(Series(BOUNDARY, x, y, marks=False, width=5.0))
    ticks = tuple((float(place), fmt.greek(name)) for place, name in enumerate(drawn.choices))
    return Figure(
        "map",
        f"Where it holds: {fmt.greek(claim.parameter)} and {fmt.greek(drawn.up)}",
        "Each row is a search along the parameter across. The bars are the boundaries: each lies "
        "somewhere on its bar.",
        Axis(fmt.greek(claim.parameter), log=claim.spacing == "log"),
        Axis(fmt.greek(drawn.up), log=drawn.spacing == "log", ticks=ticks),
        tuple(series),
    )


def _hover(point: PointRecord) -> str:
    lines = [f"{value(point.parameter or 0.0)}: {error_text(point)}"]
    lines += [f"{key}: {detail(number)}" for key, number in point.details.items()]
    return "\n".join(lines)


def detail(number: float | str | None) -> str:
    """Return a detail of a measurement as text."""
    return number if isinstance(number, str) else fmt.without_padding(fmt.number(number))


def validity_map(scenes: Sequence[SceneRecord]) -> Figure | None:
    """Return the rows of all claims that a scene of the study lies on, or None without any."""
    rows: dict[str, list[tuple[str, Nearest]]] = {}
    for record in scenes:
        for answer in nearest_to(record):
            key = f"{quantity(answer.quantity).label} ({answer.measured.claim})"
            rows.setdefault(key, []).append((record.name, answer))
    if not rows:
        return None
    # The measured points of each claim by their word, those that hold joined to a bar.
    series, caption = [], VALIDITY
    claims = [items[0][1].measured for items in rows.values()]
    for word, style in {**LOOKS, STEEP.label: STEEP}.items():
        points: list[tuple[float, float, str]] = []
        for row, measured in enumerate(claims):
            for point in measured.row:
                place, found = point.place, point.word(measured.tolerance)
                own = (found if place <= measured.until else STEEP.label) == word
                text = f"claim {measured.claim}: {measured.parameter} = {place:.3g}"
                text += f"\n{fmt.plus_minus(point.error, point.uncertainty)}"
                points.append((_place(measured, place) if own else np.nan, float(row), text))
            points.append((np.nan, float(row), ""))
        x, y, hover = zip(*points, strict=True)
        if np.isfinite(x).any():
            at = np.array(x), np.array(y)
            joined = style in (LOOKS[WITHIN], STEEP)
            if style == STEEP:
                steep = f"d/a above {STEEPEST}, slopes that every method takes as small"
                caption += f" Dotted: {steep}."
            series.append(Series(style, *at, line=joined, hover=hover, width=6.0))
    marks = []
    for row, items in enumerate(rows.values()):
        for name, answer in items:
            # The scene's own value, or the measured one that decides where its loads spread.
            low, high = answer.here
            place = low if low == high else min(max(answer.point.place, low), high)
            marks.append((_place(answer.measured, place), float(row), f"{name}\n{answer.place}"))
    x, y, hover = zip(*marks, strict=True)
    series.append(
        Series(SCENE, np.array(x), np.array(y), line=False, hollow=True, hover=tuple(hover))
    )
    ticks = tuple((float(row), _row(items[0][1])) for row, items in enumerate(rows.values()))
    ends = ((0.0, "least"), (1.0, "largest"))
    return Figure(
        "validity",
        "Validity map: where these scenes stand",
        caption,
        Axis("parameter of the row", limits=(-0.05, 1.05), ticks=ends),
        Axis("", limits=(len(rows) - 0.5, -0.5), ticks=ticks),
        tuple(series),
    )


def _row(answer: Nearest) -> str:
    """Return quantity, tolerance and ends of a row: "force, 1 %: d/R = 0.0001 … 1"."""
    parameter = answer.measured.parameter
    least, largest = (fmt.without_padding(fmt.number(end)) for end in answer.measured.ends)
    symbol = fmt.greek(SYMBOLS.get(parameter, parameter))
    name = f"{quantity(answer.quantity).label}, {fmt.tolerance(answer.measured.tolerance)}"
    return f"{name}: {symbol} = {least} \N{HORIZONTAL ELLIPSIS} {largest}"


def _place(measured: Measured, value: float) -> float:
    return float(np.clip(measured.share(value), -0.02, 1.02))
