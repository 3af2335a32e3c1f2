"""The truth of a scene as it is kept with the results, and its bars held against theorems."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from comparisons.facts.methods import CLOSED_FORM
from comparisons.facts.quantities import quantity
from comparisons.facts.quantities.rows import ENCLOSED
from comparisons.formatting import duration, relative
from comparisons.judging.verdicts import Number

if TYPE_CHECKING:
    from comparisons.judging.truth import Truth


def missed_by(
    value: np.ndarray, bar: np.ndarray, lower: np.ndarray, upper: np.ndarray
) -> np.ndarray:
    """By how much a value with its relative bar lies outside an interval, relative; zero inside.

    >>> import numpy as np
    >>> low, high = np.full(2, 0.98), np.full(2, 0.99)
    >>> missed_by(np.ones(2), np.array([0.02, 0.005]), low, high).round(3)
    array([0.   , 0.005])
    """
    size = np.abs(value)
    beyond = np.maximum(value - bar * size - upper, lower - value - bar * size)
    return np.maximum(beyond, 0.0) / size


@dataclass(frozen=True)
class Verification:
    """All references of a scene, held against what theorems prove of it."""

    # Known bars that have an interval beside them: of each reference, quantity and load step.
    bars: int
    missed: int  # how many of them do not reach the interval
    # A sentence for each reference and quantity whose bar does not reach the interval.
    sentences: tuple[str, ...]
    width: Number  # largest relative width of the intervals of force and penetration
    # What the intervals took, and what the solve of the truth that they judge.
    seconds: float
    truth_seconds: float

    @property
    def in_words(self) -> str:
        """How wide the intervals are, how many bars reach them, what it all took."""
        if not self.bars:
            return f"theorems enclose none of the loads, as {duration(self.seconds)} have shown."
        reached = "every bar of a reference reaches it"
        if self.missed:
            reached = f"{self.missed} of {self.bars} bars miss it"
        return (
            "interval in which the truth lies by theorem, at most "
            f"{relative(self.width)} wide in force or penetration; {reached}. "
            f"It took {duration(self.seconds)}, the truth {duration(self.truth_seconds)}."
        )


def tally(several: Iterable[Verification]) -> str:
    """Say in how many scenes bars are held against theorems, and in how many of them they miss.

    Scenes are counted: the loads and quantities of one are often one number.

    >>> from dataclasses import replace
    >>> ball = Verification(bars=6, missed=0, sentences=(), width=0.1, seconds=1, truth_seconds=2)
    >>> lines = tally([ball, replace(ball, missed=1, width=0.25)]).splitlines()
    >>> lines[0]
    'Proved: the references of 2 scenes are held against theorems; bars miss in 1.'
    >>> "at most 25" in lines[1]
    True
    >>> tally([replace(ball, bars=0)])
    ''
    """
    known = [item for item in several if item.bars]
    if not known:
        return ""
    own = duration(sum(item.seconds for item in known))
    judged = duration(sum(item.truth_seconds for item in known))
    missed = sum(item.missed > 0 for item in known)
    widest = relative(max(item.width for item in known))
    scenes = f"{len(known)} scene{'s' if len(known) > 1 else ''}"
    return (
        f"Proved: the references of {scenes} are held against theorems; "
        f"{f'bars miss in {missed}' if missed else 'no bar misses'}.\n"
        f"The intervals are at most {widest} wide in force or penetration.\n"
        f"They took {own}, the solves that they judge {judged}."
    )


def verified(truth: Truth, sides: Mapping[str, np.ndarray], seconds: float) -> Verification:
    """Hold the bars of a truth and of its checks against the proved intervals.

    A bar that does not reach its interval is too narrow by a theorem, not by another estimate. An
    unknown bar misses nothing and is not counted.
    """
    bars, missed, sentences = 0, 0, []
    for reference in (truth, *truth.checks):
        for name in ENCLOSED:
            if name not in reference.curves or f"{name}_lower" not in sides:
                continue
            bar = reference.bar(name, reference.axis)
            lower, upper = sides[f"{name}_lower"], sides[f"{name}_upper"]
            beyond = missed_by(reference.curves[name], bar, lower, upper)
            bars += int(np.isfinite(bar + upper).sum())
            missed += int((beyond > 0).sum())
            if np.nanmax(beyond, initial=0.0) > 0:
                step = int(np.nanargmax(beyond))
                sentences.append(
                    f"The bar of {reference.label} in {quantity(name).label} misses the proved "
                    f"interval by {relative(beyond[step])} at load step {step + 1}."
                )
    widths = [
        np.nanmax(1 - sides[f"{name}_lower"] / sides[f"{name}_upper"], initial=0.0)
        for name in ("force", "penetration")
        if f"{name}_upper" in sides
    ]
    taken = seconds, truth.solution.seconds
    return Verification(bars, missed, tuple(sentences), float(max(widths)), *taken)


@dataclass(frozen=True)
class Bar:
    """The widest bar of a quantity on the very same surfaces, and at which load step."""

    bar: Number
    step: int


@dataclass(frozen=True)
class Reference:
    """Which solution the others were compared with, and how well it is known."""

    # "" where there is none; the text is a sentence.
    method: str
    resolution: int
    text: str
    # Quantity -> relative 95 % half-width, rms over the load steps; NaN where not known.
    uncertainty: dict[str, Number] = field(default_factory=dict)
    # Quantity -> source -> its part of that.
    sources: dict[str, dict[str, Number]] = field(default_factory=dict)
    bars: dict[str, Bar] = field(default_factory=dict)  # quantity that it gives -> `Bar`
    footnotes: tuple[str, ...] = ()  # disagreements that are small against the tolerance, in words
    proved: Verification | None = None  # its bars held against theorems
    # Why lines that agree with it do so by chance (`comparisons.results.scene_record`).
    chance: str = ""

    @property
    def exact(self) -> bool:
        """Whether it is a closed form."""
        return self.method == CLOSED_FORM


NO_REFERENCE = Reference("", 0, "")
