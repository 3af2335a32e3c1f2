"""What a claim depends on, in words: along each nuisance parameter, and over a sample of all."""

from __future__ import annotations

from collections import Counter
from itertools import groupby

import numpy as np

from comparisons.judging.verdicts import NO_RESULT, OUTSIDE, WITHIN
from comparisons.questions.claims.boundaries import Point, ranges_of
from comparisons.questions.claims.claim import Claim
from comparisons.questions.claims.nuisances import Along, Draw, Openness, Row, Setting
from comparisons.questions.claims.wording import error_text, stretch_words, value


def conditions(claim: Claim, openness: Openness) -> str:
    """Return for what the claim holds beyond the setting at which it is stated, "" if for all.

    For example: "The statement leaves open (at load 0.01): roll-off: within from 1 to 1.5 (not at
    1.8); half-space: free 2 % (within), periodic -40 % (outside). Of 8 draws over all of it: 3
    within, 5 outside; the largest error is -87 % (load 0.05, roll-off 3.2, half-space periodic)."
    """
    if not openness.along:
        return ""
    at = openness.along[0].at
    where = "" if at is None else f" (at {claim.parameter} {value(at)})"
    along = "; ".join(_along(claim, line) for line in openness.along)
    beyond = f"{_draws(claim, openness.draws)}{_rows(claim, openness.rows)}"
    return f"The statement leaves open{where}: {along}.{beyond}"


def in_words(claim: Claim, setting: Setting) -> dict[str, str]:
    """Return a setting in words, by the names of the parameters."""
    return {
        n.name: n.choice(setting[n.key]) if n.values else value(setting[n.key])
        for n in claim.nuisance
    }


def _along(claim: Claim, line: Along) -> str:
    nuisance = line.nuisance
    if nuisance.values:
        outcomes = (f"{nuisance.choice(p.parameter)} {_outcome(claim, p)}" for p in line.points)
        return f"{nuisance.name}: {', '.join(outcomes)}"
    first, last = (value(line.points[end].parameter) for end in (0, -1))
    verdicts = {point.word for point in line.points}
    if len(verdicts) == 1:
        return f"{nuisance.name}: {verdicts.pop()} from {first} to {last}"
    stretches = "; ".join(stretch_words(stretch) for stretch in ranges_of(line.points))
    if stretches:
        return f"{nuisance.name}: within {stretches}"
    return f"{nuisance.name}: nowhere within from {first} to {last}"


def _rows(claim: Claim, rows: list[Row]) -> str:
    """Return where the claim holds along its own parameter, row by row of its map."""
    if claim.map is None or not rows:
        return ""
    up = next(nuisance for nuisance in claim.nuisance if nuisance.key == claim.map.up)
    places = []
    for stretches, alike in groupby(rows, key=_stretches):
        numbers = [up.choice(row.number) if up.values else value(row.number) for row in alike]
        places.append(f"{', '.join(numbers)}: {stretches or 'nowhere'}")
    return f" Within, for {claim.parameter}, by {up.name}: {'. '.join(places)}."


def _stretches(row: Row) -> str:
    return "; ".join(stretch_words(stretch) for stretch in ranges_of(row.points))


def _outcome(claim: Claim, point: Point) -> str:
    if point.word == NO_RESULT:
        return point.word
    return f"{error_text(point.measurement, claim.factor)} ({point.word})"


def _draws(claim: Claim, draws: list[Draw]) -> str:
    """Return how many draws got which word, and the largest error with its place."""
    if not draws:
        return ""
    counts = Counter(draw.point.word for draw in draws)
    order = (WITHIN, OUTSIDE, *sorted(set(counts) - {WITHIN, OUTSIDE}))
    counted = ", ".join(f"{counts[word]} {word}" for word in order if counts[word])
    size = [np.nan_to_num(abs(draw.point.measurement.error), nan=-1.0) for draw in draws]
    worst = draws[int(np.argmax(size))]
    place = [f"{name} {text}" for name, text in in_words(claim, worst.setting).items()]
    if claim.parameter:
        place.insert(0, f"{claim.parameter} {value(worst.point.parameter)}")
    noun = worst.point.measurement.noun
    error = error_text(worst.point.measurement, claim.factor)
    if claim.premise is not None and worst.point.parameter > claim.premise.to:
        place.append("beyond the premise")
    return (
        f" Of {len(draws)} draws over all of it: {counted}; the largest {noun} is {error} "
        f"({', '.join(place)})."
    )
