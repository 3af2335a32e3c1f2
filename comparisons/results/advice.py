"""Choice of a method: the cheapest setting that was run and meets a tolerance, bar included.

All times are measured at the resolutions that were run, without interpolation.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

from comparisons.facts.methods import CLOSED_FORM
from comparisons.facts.quantities import quantity
from comparisons.files import plain
from comparisons.formatting import MISSING, count, duration, listed, relative, tolerance
from comparisons.judging.truth import Bar
from comparisons.judging.verdicts import (
    NO_RESULT,
    NOT_RESOLVED,
    OUTSIDE,
    WITHIN,
    Verdict,
    judged,
    worst,
)
from comparisons.results.record import Cost, SceneRecord, once
from comparisons.results.run_comparison import SLOWER

# Its errors are against a finer grid of its own.
ITSELF = "* same method as the reference"


@dataclass(frozen=True)
class Setting:
    """One method at one resolution, with its measured time and errors."""

    method: str
    resolution: int
    cost: Cost  # of all solves that the errors stand on, and of one surface or line
    # One per asked quantity. Of the truth itself: no error, and its bar.
    verdicts: tuple[Verdict, ...]
    is_truth: bool = False  # whether this is the solution that the others were compared with
    # Whether its method is that of the truth: it was compared with its own finest solution.
    judges_itself: bool = False
    title: str = ""  # what the method is called on the scene
    dimension: int = 3

    @property
    def seconds(self) -> float:
        """The time of all solves that the stated errors stand on."""
        return self.cost.seconds

    @property
    def solves_in_3d(self) -> bool:
        """Whether it solves the surface itself, in three dimensions."""
        return self.dimension == 3 and self.method != CLOSED_FORM

    @property
    def deciding(self) -> Verdict:
        """The verdict that decides over all quantities; one that it does not compute is missing."""
        return worst(self.verdicts, asked=True)

    @property
    def verdict(self) -> str:
        """Over all quantities: "within", "outside", "not resolved" or "no result"."""
        return self.deciding.word

    @property
    def text(self) -> str:
        """Method, time, resolution, surfaces, and how it stands to the truth."""
        place = filter(None, [f"N = {self.resolution}", self.cost.solves, self.bias])
        return f"{self.title} {duration(self.seconds)} ({', '.join(place)})"

    @property
    def starred(self) -> str:
        """The title, with a star that a note explains where it judges itself."""
        return f"{self.title}{'*' if self.judges_itself and not self.is_truth else ''}"

    @property
    def brief(self) -> str:
        """Method, time and resolution, starred."""
        return f"{self.starred} {duration(self.seconds)} (N = {self.resolution})"

    @property
    def bias(self) -> str:
        """What a reader must know of its errors: it is the truth, or judges itself."""
        if self.is_truth:
            return "the reference itself"
        return ITSELF.removeprefix("* ") if self.judges_itself else ""

    @property
    def counted(self) -> tuple[Verdict, ...]:
        """The verdicts on quantities that can be answered."""
        return tuple(verdict for verdict in self.verdicts if verdict.counts)

    def holds(self, error: float) -> bool:
        """Tell whether |e| + u is at most `error` in every quantity and at every load step."""
        return bool(self.counted) and all(verdict.high <= error for verdict in self.counted)


class Advice:
    """What a scene's measured results say about the choice of a method: ask for it by `advise`.

    A setting meets the tolerance where |e| + u does in every quantity that can be judged and at
    every load step; the truth where u does.
    """

    def __init__(self, record: SceneRecord) -> None:
        self.record = record
        nothing, truth = record.unanswered, record.reference.method
        # What has to be within the tolerance.
        self.quantities = tuple(name for name in record.quantities if name not in nothing)
        # Methods that hold by chance where they hold: none of their settings is advised.
        self.lucky = frozenset(name for name in record.methods if record.by_chance(name))
        settings = [
            Setting(
                method,
                level,
                record.cost(method, level),
                record.setting_verdicts(method, level),
                judges_itself=method == truth,
                title=record.title_of(method),
                dimension=record.dimension_of(method),
            )
            for method in record.methods
            for level in record.resolutions_judged(method)
        ]
        if truth:
            bars = []
            for name in record.quantities:
                asked: dict[str, Any] = {"quantity": name, "at": record.equal_at(name)}
                asked["steps"] = record.steps
                if name in nothing:
                    asked |= {"reason": nothing[name], "counts": False}
                    bars.append(Verdict(tolerance=record.tolerance, **asked))
                    continue
                known = record.reference.bars.get(name) or Bar(math.nan, -1)
                verdict = judged(0.0, known.bar, record.tolerance, **asked)
                bars.append(replace(verdict, step=known.step))
            level, called = record.reference.resolution, record.title_of(truth)
            spent = record.cost(truth, level)
            settings.append(Setting(truth, level, spent, tuple(bars), True, True, called))
        # Everything that was measured, fastest first.
        self.settings = tuple(sorted(settings, key=_by_time))

    @property
    def cheapest(self) -> Setting | None:
        """The fastest setting that is sure to meet the tolerance; closed forms need no choice."""
        return next(iter(self.reaching()), None)

    def reaching(self) -> list[Setting]:
        """Return the cheapest setting of each method for the tolerance, fastest first."""
        reached = self.cheapest_for(self.record.tolerance)
        choices = [setting for name, setting in reached.items() if setting and name != CLOSED_FORM]
        return sorted(choices, key=_by_time)

    def cheapest_for(self, error: float) -> dict[str, Setting | None]:
        """Return the cheapest setting that was run of each method that is sure of an error.

        All finer ones of its method must be, too: errors that cancel on a coarse grid are no way to
        get there. The truth counts with its own bar, where no other setting of its method will do.
        """
        cheapest = {}
        for method in dict.fromkeys(setting.method for setting in self.settings):
            settings = [setting for setting in self.settings if setting.method == method]
            finest_level, sure = self.record.finest(method) or 0, []
            for setting in sorted(settings, key=lambda one: one.resolution, reverse=True):
                if setting.is_truth or setting.resolution > finest_level or method in self.lucky:
                    continue
                if setting.holds(error):
                    sure.append(setting)
                elif setting.verdict != NO_RESULT or setting.resolution == finest_level:
                    break
            sure = sure or [one for one in settings if one.is_truth and one.holds(error)]
            cheapest[method] = min(sure, key=_by_time) if sure else None
        return cheapest

    @property
    def truth_known_to(self) -> tuple[float, str]:
        """The widest bar of the truth at any load, and in which quantity; NaN: none is known."""
        known = {name: self.record.reference.known_to(name) for name in self.quantities}
        widest = [(max(bars), name) for name, bars in known.items() if len(bars)]
        return max(widest, key=lambda item: item[0], default=(math.nan, ""))

    @cached_property
    def sentence(self) -> str:
        """The advice: "For 1 % in force: reduced model 0.7 ms (N = 10); outside: FFT BEM"."""
        record = self.record
        if not record.reference.method:
            return "No 3-D method finished, so no reference is available."
        if all(setting.is_truth for setting in self.settings):
            return f"{record.reference.text} Nothing else was run, so there is nothing to compare."
        reasons = [f"{quantity(name).label} ({why})" for name, why in record.unanswered.items()]
        left = f"; not judged: {', '.join(reasons)}" if reasons else ""
        if not self.quantities:
            return f"None of the requested quantities can be judged{left}."
        labels = [quantity(name).label for name in self.quantities]
        advice_text = f"For {tolerance(record.tolerance)} in {listed(labels)}: "
        # fastest first; what lies closer than times repeat is not ranked
        groups: list[list[Setting]] = []
        for setting in self.reaching():
            if groups and setting.seconds <= SLOWER * groups[-1][0].seconds:
                groups[-1].append(setting)
            else:
                groups.append([setting])
        ranked = ", ".join(
            " or ".join(one.text for one in group) + (" (too close to rank)" if group[1:] else "")
            for group in groups
        )
        advice_text += ranked or "no setting that was run is within tolerance"
        # methods that have no setting for the tolerance, each with what decided
        failures: dict[str, list[str]] = {word: [] for word in (NOT_RESOLVED, OUTSIDE, NO_RESULT)}
        for method, reached in self.cheapest_for(record.tolerance).items():
            settings = [s for s in self.settings if s.method == method and not s.is_truth]
            finest_one = [s for s in settings if s.resolution == record.finest(method)]
            if reached is not None or method == CLOSED_FORM or not finest_one:
                continue
            (last,) = finest_one
            luck = [
                s.resolution for s in settings if (s.verdict, last.verdict) == (WITHIN, OUTSIDE)
            ]
            chance = f"; within by chance at N = {min(luck)}" if luck else ""
            if last.verdict == WITHIN:  # of few contacts
                why = f"within by chance, N = {last.resolution}"
                failures[NOT_RESOLVED].append(f"{last.title} ({why})")
                continue
            grid = "" if last.verdict == NO_RESULT else f", N = {last.resolution}"
            failures[last.verdict].append(f"{last.title} ({last.deciding.text}{grid}{chance})")
        for word, methods in failures.items():
            advice_text += f"; {word}: {', '.join(methods)}" if methods else ""
        truth, level = record.reference.method, record.reference.resolution
        truth_text = "closed form"
        if truth != CLOSED_FORM:
            bar, widest = self.truth_known_to
            accuracy = f"known to {relative(bar)} in {quantity(widest).label}" if widest else ""
            if not widest:
                grids = set(record.solved_rows(truth)["resolution"])
                alone = ": only one resolution was run" if len(grids) == 1 else ""
                accuracy = f"its error is not known{alone}"
            ensemble = record.cost(truth, level).solves
            mean = f", mean over {ensemble}" if ensemble else ""
            truth_text = f"{record.title_of(truth)} (N = {level}{mean}), {accuracy}"
        return f"{advice_text}{left}; reference: {truth_text}."

    @cached_property
    def single(self) -> str:
        """What one line, or surface, of the judged method takes and errs by; "" without any."""
        record = self.record
        method = record.judged_methods[0]
        known = [verdict for verdict in record.verdicts_on(method) if verdict.single != MISSING]
        if not known:
            return ""
        level = int(known[0].resolution)
        spent, title = record.cost(method, level), record.title_of(method)
        noun = "line" if record.dimension_of(method) == 1 else "surface"
        errors = [
            f"{quantity(v.quantity).label} {v.single}"
            + (f" (load step {v.single_step + 1})" if v.single_step >= 0 and v.steps != 1 else "")
            for v in known
        ]
        return (
            f"One {noun} of the {title} takes {duration(spent.single_seconds)} (N = {level}); "
            f"90 % of the {count(spent.surfaces)} {noun}s err by: {', '.join(errors)}."
        )

    @property
    def document(self) -> dict[str, Any]:
        """The advice as plain data for JSON; what is not known is None."""
        return plain(
            {
                "scene": self.record.name,
                "tolerance": self.record.tolerance,
                "quantities": list(self.quantities),
                "unanswered": self.record.unanswered,
                "sentence": self.sentence,
                "cheapest": None if self.cheapest is None else _document(self.cheapest),
                "settings": [_document(setting) for setting in self.settings],
            }
        )


@once
def advise(record: SceneRecord) -> Advice:
    """Say which method to use for the asked quantities of a scene at its tolerance."""
    return Advice(record)


def _document(setting: Setting) -> dict[str, Any]:
    names = ("quantity", "at", "step", "error", "uncertainty", "rms", "word", "reason")
    single = ("single_low", "single_high", "single_step")
    return {
        "method": setting.method,
        "resolution": setting.resolution,
        "seconds": setting.seconds,
        "surfaces": setting.cost.surfaces,
        "single_seconds": setting.cost.single_seconds,
        "verdict": setting.verdict,
        "decided_by": setting.deciding.quantity,
        "is_truth": setting.is_truth,
        "judges_itself": setting.judges_itself,
        "verdicts": [
            {name: getattr(verdict, name) for name in (*names, *single)}
            for verdict in setting.verdicts
        ],
    }


def _by_time(setting: Setting) -> float:
    return setting.seconds if math.isfinite(setting.seconds) else math.inf


def wide_truth(record: SceneRecord, effort: str) -> str:
    """Return that the reference is known worse than the tolerance; "" where it is not."""
    bar, widest = advise(record).truth_known_to
    if not bar > record.tolerance:
        return ""
    truth = record.reference.method
    # no finer grid makes a closed form any better
    refined = ": --full refines it" if effort == "quick" and truth != CLOSED_FORM else ""
    limit = tolerance(record.tolerance)
    return (
        f"reference: {record.title_of(truth)}, known to {relative(bar)} in "
        f"{quantity(widest).label}, wider than the tolerance of {limit}{refined}"
    )
