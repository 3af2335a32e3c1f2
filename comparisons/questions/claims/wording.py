"""Verdicts in words, derived from the measurements only: the sentence, and what it depends on."""

from __future__ import annotations

from collections import Counter
from itertools import groupby, pairwise
from typing import TYPE_CHECKING

import numpy as np

from comparisons.facts.quantities import quantity
from comparisons.formatting import finite, number, plus_minus, relative, tolerance, without_padding
from comparisons.judging.verdicts import NO_RESULT, OUTSIDE, WITHIN
from comparisons.questions.claims.record import FAILS, HOLDS, IN_A_RANGE, not_run, verdict_of

if TYPE_CHECKING:
    from comparisons.questions.claims.claim import Claim
    from comparisons.questions.claims.record import ClaimRecord, PointRecord, RangeRecord
    from comparisons.questions.experiments.experiment import Measurement


def finding(claim: Claim, record: ClaimRecord) -> str:
    """Return what was found, in words: as the claim is stated, and beyond."""
    verdict = verdict_of([point.word for point in record.points], record.effort)
    return f"{_sentence(claim, verdict, record)} {_conditions(claim, record)}".rstrip()


def _sentence(claim: Claim, verdict: str, record: ClaimRecord) -> str:
    """Return a sentence on the verdict with the decisive numbers.

    "Within 1 % for R'/R'' from 1 to 1.96; outside from 2.04 on. Error there -1.0 %, and -16 % at
    20."
    """
    limit, factor = limit_words(claim.tolerance, claim.factor), claim.factor
    points = record.points

    def at(point: PointRecord) -> str:
        text = error_text(point, factor)
        if point.error is not None and text.lstrip("+−") == limit:  # rounded onto it
            text = text.replace(limit, relative(abs(point.error), 3))
        return f"{text} at {value(point.parameter)}"

    first = points[0]
    if missing := not_run(points):
        return f"Not run: {missing}."
    if claim.vary is None:
        if first.word == NO_RESULT:
            return f"No result: {_reason(first)}."
        phrases = {WITHIN: f"within {limit}", OUTSIDE: f"outside {limit}"}
        phrase = phrases.get(first.word, f"the bar is wider than {limit} can bear")
        return f"{first.noun.capitalize()} {error_text(first, factor)}: {phrase}."
    judged = [point for point in points if point.word != NO_RESULT]
    failing = [point for point in judged if point.word == OUTSIDE]
    noun = judged[0].noun if judged else ""
    span = f"{claim.parameter} from {value(first.parameter)} to {value(points[-1].parameter)}"
    # Points outside between which the error changes sign: there the claim holds because two errors
    # cancel. Only signs that are certain within the bars count, and only between such points.
    sure = [
        (value(point.parameter), point.error)
        for point in points
        if point.word not in (WITHIN, NO_RESULT)
        and point.error is not None
        and point.uncertainty is not None
        and abs(point.error) > point.uncertainty
    ]
    crossings = [f"{low} and {high}" for (low, e), (high, f) in pairwise(sure) if e * f < 0]
    left = _open(points)
    if len(crossings) > 3:
        left += f"; the error changes sign {len(crossings)} times"
    elif crossings:
        left += f"; the error changes sign between {', and between '.join(crossings)}"
    if not judged:
        found = f"No result: {_reason(first)}."
    elif verdict == HOLDS:
        largest = at(max(judged, key=_size))
        found = f"Within {limit} for {span}; the largest {noun} is {largest}."
    elif verdict == FAILS:
        resolved = "" if len(failing) == len(points) else " wherever it is resolved,"
        smallest = at(min(failing, key=_size))
        found = f"Outside {limit}{resolved} for {span}; the smallest {noun} is {smallest}{left}."
    elif verdict == IN_A_RANGE:
        stretches = _stretches(record.ranges, points)
        largest = at(max(judged, key=_size))
        found = f"Within {limit} for {claim.parameter} {stretches}"
        if record.effort == "quick":
            hangs = ", and what it hangs on" if claim.nuisance else ""
            found += f"; a full run finds where the range ends{hangs}"
        found += ". "
        found += f"The largest {noun} is {largest}{left}."
    elif failing:
        where = ", ".join(value(point.parameter) for point in failing)
        found = f"Outside {limit} at {where}; whether it holds anywhere for {span} "
        found += f"is not resolved{left}."
    else:
        found = f"For {span} no {noun} beyond {limit} is certain{_open(points)}."
    if claim.premise is None:
        return found
    end = claim.premise.to
    within = ", ".join(at(p) for p in points if p.parameter is not None and p.parameter <= end)
    beyond = ", ".join(at(p) for p in points if p.parameter is not None and p.parameter > end)
    return f"{found} While {claim.premise.condition}: {within}; beyond: {beyond}."


def _conditions(claim: Claim, record: ClaimRecord) -> str:
    """Return for what the claim holds beyond the setting at which it is stated, "" if for all.

    "The statement leaves open (at load 0.01): roll-off (1 above): within from 1 to 1.5 (not at
    1.8). Of 8 draws over all of it: 3 within, 5 outside; the largest error is -87 % (load 0.05,
    ...)."
    """
    nuisances, draws, validity = record.nuisances, record.draws, record.map
    if not nuisances:
        return ""
    lines = []
    for nuisance in nuisances:
        points, words = nuisance.points, {point.word for point in nuisance.points}
        first, last = value(points[0].parameter), value(points[-1].parameter)
        stretches = _stretches(nuisance.ranges, points)
        choices, stated = nuisance.choices, nuisance.stated
        name = f"{nuisance.name} ({choices[int(stated)] if choices else value(stated)} above)"
        if choices:
            outcomes = []
            for point in points:
                error = error_text(point, claim.factor)
                outcome = point.word if point.word == NO_RESULT else f"{error} ({point.word})"
                outcomes.append(f"{choices[int(point.parameter or 0)]} {outcome}")
            lines.append(f"{name}: {', '.join(outcomes)}")
        elif len(words) == 1:
            lines.append(f"{name}: {words.pop()} from {first} to {last}")
        elif stretches:
            lines.append(f"{name}: within {stretches}")
        else:
            lines.append(f"{name}: nowhere within from {first} to {last}")
    at = nuisances[0].at
    where = "" if at is None else f" (at {claim.parameter} {value(at)})"
    text = f"The statement leaves open{where}: {'; '.join(lines)}."
    if draws:
        counts = Counter(draw.word for draw in draws)
        order = (WITHIN, OUTSIDE, *sorted(set(counts) - {WITHIN, OUTSIDE}))
        counted = ", ".join(f"{counts[word]} {word}" for word in order if counts[word])
        worst = max(draws, key=lambda draw: -1.0 if draw.word == NO_RESULT else _size(draw))
        place = [f"{name} {at_which}" for name, at_which in worst.setting.items()]
        if claim.parameter:
            place.insert(0, f"{claim.parameter} {value(worst.parameter)}")
        if claim.premise is not None and (worst.parameter or 0.0) > claim.premise.to:
            place.append("beyond the premise")
        text += (
            f" Of {len(draws)} draws over all of it: {counted}; the largest {worst.noun} is "
            f"{error_text(worst, claim.factor)} ({', '.join(place)})."
        )
    if validity is not None:
        places = []
        for stretches, rows in groupby(
            validity.rows, key=lambda row: _stretches(row.ranges, row.points)
        ):
            numbers = [
                validity.choices[int(row.number)] if validity.choices else value(row.number)
                for row in rows
            ]
            places.append(f"{', '.join(numbers)}: {stretches or 'nowhere'}")
        text += f" Within, for {claim.parameter}, by {validity.up}: {'. '.join(places)}."
    return text


def limit_words(limit: float, factor: float | None) -> str:
    """Return a tolerance in words.

    >>> limit_words(9.0, 10.0)
    'a factor of 10'
    """
    return tolerance(limit) if factor is None else f"a factor of {value(factor)}"


WRONG_SIGN = -1e9  # the error of a factor where stated and true differ in sign


def error_text(measured: Measurement | PointRecord, factor: float | None = None) -> str:
    """Return an error with its bar, or as a factor; distances of two fields have no sign.

    >>> from comparisons.questions.experiments.experiment import Measurement
    >>> [error_text(Measurement(None, e, 0.01), 10.0) for e in (3.9, -1.5, WRONG_SIGN)]
    ['a factor of 4.9', 'a factor of 0.4', 'of the other sign']
    """
    error = measured.error
    if factor is None or not finite(error):
        norm = quantity(str(measured.details.get("quantity"))).norm
        signed = measured.noun == "error" and not norm
        return plus_minus(error, measured.uncertainty, signed=signed)
    if error <= WRONG_SIGN:
        return "of the other sign"
    return f"a factor of {value(1 + error if error >= 0 else 1 / (1 - error))}"


def value(parameter: float | None) -> str:
    """Return a value of a parameter as text: four digits, without padding zeros.

    >>> value(20.0), value(1.9641), value(1e-9)
    ('20', '1.964', '1×10⁻⁹')
    """
    return without_padding(number(parameter, 4))


def _size(point: PointRecord) -> float:
    """Return the size of an error; of one that is not bounded infinity."""
    return np.inf if point.error is None else abs(point.error)


def _stretches(ranges: list[RangeRecord], points: list[PointRecord]) -> str:
    """Return intervals in words, with the next points beyond their ends and what these are."""
    words = {point.parameter: point.word for point in points}
    texts = []
    for stretch in ranges:
        low, high = value(stretch.low), value(stretch.high)
        text = f"at {low}" if stretch.low == stretch.high else f"from {low} to {high}"
        beyond: dict[str, list[str]] = {}
        for end in (stretch.below, stretch.above):
            if end is not None:
                beyond.setdefault(words[end].replace(OUTSIDE, "not"), []).append(value(end))
        asides = [f"{word} at {' nor at '.join(ends)}" for word, ends in beyond.items()]
        texts.append(f"{text} ({'; '.join(asides)})" if asides else text)
    return "; ".join(texts)


def _open(points: list[PointRecord]) -> str:
    """Return the unresolved points in words, "" if there are none."""
    left = [p for p in points if p.word not in (WITHIN, OUTSIDE)]
    if not left:
        return ""
    unmeasured = [point for point in left if point.word == NO_RESULT]
    bars = [np.inf if point.uncertainty is None else point.uncertainty for point in left]
    widest = (unmeasured or [left[int(np.argmax(bars))]])[0]
    if widest.word == NO_RESULT:
        detail = f"no result at {value(widest.parameter)}: {_reason(widest)}"
    else:
        detail = f"at {value(widest.parameter)} the {widest.noun} is {error_text(widest)}"
    return f"; {len(left)} of {len(points)} points are not resolved ({detail})"


def _reason(point: PointRecord) -> str:
    return str(point.details.get("no result", "the measurement gave no number"))
