"""Verdicts in words, derived from the measurements only."""

from __future__ import annotations

from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np

from comparisons.facts.quantities import quantity
from comparisons.formatting import finite, number, plus_minus, tolerance, without_padding
from comparisons.judging.verdicts import NO_RESULT, OUTSIDE, WITHIN
from comparisons.questions.claims.verdicts import FAILS, HOLDS, IN_A_RANGE

if TYPE_CHECKING:
    from comparisons.questions.claims.boundaries import Point, Range
    from comparisons.questions.claims.claim import Claim
    from comparisons.questions.claims.record import PointRecord
    from comparisons.questions.experiments.experiment import Measurement


def sentence(claim: Claim, verdict: str, points: list[Point], ranges: list[Range]) -> str:
    """Return a sentence on the verdict with the decisive numbers.

    For example: "Within 1 % for R'/R'' from 1 to 1.96; outside from 2.04 on. Error there -1.0 %,
    and -16 % at 20."
    """
    finding = _finding(claim, verdict, points, ranges)
    return finding if claim.premise is None else f"{finding} {_by_premise(claim, points)}"


def _by_premise(claim: Claim, points: list[Point]) -> str:
    """Return the error at every value, first where the statement's premise holds."""
    assert claim.premise is not None
    end = claim.premise.to
    within = ", ".join(_at(p, claim.factor) for p in points if p.parameter <= end)
    beyond = ", ".join(_at(p, claim.factor) for p in points if p.parameter > end)
    return f"While {claim.premise.condition}: {within}; beyond: {beyond}."


def _finding(claim: Claim, verdict: str, points: list[Point], ranges: list[Range]) -> str:
    limit = limit_words(claim.tolerance, claim.factor)
    if claim.vary is None:
        return _single(points[0], limit, claim.factor)
    judged = [point for point in points if point.word != NO_RESULT]
    if not judged:
        return f"No result: {_reason(points[0])}."
    largest = _at(max(judged, key=_size), claim.factor)
    noun = judged[0].measurement.noun
    stretch = f"{claim.parameter} from {value(points[0].parameter)} to "
    stretch += value(points[-1].parameter)
    if verdict == HOLDS:
        return f"Within {limit} for {stretch}; the largest {noun} is {largest}."
    if verdict == FAILS:
        failing = [point for point in judged if point.word == OUTSIDE]
        resolved = "" if len(failing) == len(points) else " wherever it is resolved,"
        smallest = _at(min(failing, key=_size), claim.factor)
        return (
            f"Outside {limit}{resolved} for {stretch}; the smallest {noun} is {smallest}"
            f"{_open(points)}{_sign_changes(points)}."
        )
    if verdict == IN_A_RANGE:
        stretches = "; ".join(stretch_words(stretch) for stretch in ranges)
        return (
            f"Within {limit} for {claim.parameter} {stretches}. "
            f"The largest {noun} is {largest}{_open(points)}{_sign_changes(points)}."
        )
    failing = [point for point in points if point.word == OUTSIDE]
    if failing:
        where = ", ".join(value(point.parameter) for point in failing)
        return (
            f"Outside {limit} at {where}; whether it holds anywhere for {stretch} is not resolved"
            f"{_open(points)}{_sign_changes(points)}."
        )
    return f"For {stretch} no {noun} beyond {limit} is certain{_open(points)}."


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


def value(parameter: float) -> str:
    """Return a value of a parameter as text: four digits, without padding zeros.

    >>> value(20.0), value(1.9641), value(1e-9)
    ('20', '1.964', '1×10⁻⁹')
    """
    return without_padding(number(parameter, 4))


def _single(point: Point, limit: str, factor: float | None) -> str:
    if point.word == NO_RESULT:
        return f"No result: {_reason(point)}."
    error = error_text(point.measurement, factor)
    phrases = {WITHIN: f"within {limit}", OUTSIDE: f"outside {limit}"}
    phrase = phrases.get(point.word, f"the bar is wider than {limit} can bear")
    return f"{point.measurement.noun.capitalize()} {error}: {phrase}."


def _at(point: Point, factor: float | None) -> str:
    return f"{error_text(point.measurement, factor)} at {value(point.parameter)}"


def _size(point: Point) -> float:
    return abs(point.measurement.error)


def stretch_words(stretch: Range) -> str:
    """Return an interval in words, with the next points beyond its ends."""
    low, high = value(stretch.low), value(stretch.high)
    text = f"at {low}" if stretch.low == stretch.high else f"from {low} to {high}"
    beyond = [value(end) for end in (stretch.below, stretch.above) if end is not None]
    return f"{text} (not at {' nor at '.join(beyond)})" if beyond else text


def _sign_changes(points: list[Point]) -> str:
    """Return the points outside between which the error changes sign, in words; "" if none.

    There the claim holds because two errors cancel. Only signs that are certain within the bars
    count, and only between points that are not within.
    """
    sure = [
        p
        for p in points
        if p.word not in (WITHIN, NO_RESULT)
        and abs(p.measurement.error) > p.measurement.uncertainty
    ]
    crossings = [
        f"{value(low.parameter)} and {value(high.parameter)}"
        for low, high in pairwise(sure)
        if low.measurement.error * high.measurement.error < 0
    ]
    if len(crossings) > 3:
        return f"; the error changes sign {len(crossings)} times"
    return (
        f"; the error changes sign between {', and between '.join(crossings)}" if crossings else ""
    )


def _open(points: list[Point]) -> str:
    """Return the unresolved points in words, "" if there are none."""
    left = [p for p in points if p.word not in (WITHIN, OUTSIDE)]
    if not left:
        return ""
    widest = max(left, key=lambda p: np.nan_to_num(p.measurement.uncertainty, nan=np.inf))
    if widest.word == NO_RESULT:
        detail = f"no result at {value(widest.parameter)}: {_reason(widest)}"
    else:
        detail = f"at {value(widest.parameter)} the {widest.measurement.noun} is "
        detail += error_text(widest.measurement)
    return f"; {len(left)} of {len(points)} points are not resolved ({detail})"


def _reason(point: Point) -> str:
    return str(point.measurement.details.get("no result", "the measurement gave no number"))
