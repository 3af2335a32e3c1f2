"""Which solution counts as the truth of a scene, how well it is known, and who disagrees."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from types import MappingProxyType

import numpy as np

from comparisons.facts.methods import CLOSED_FORM, METHODS, leading
from comparisons.facts.quantities import FIELDS, main_axis, quantity
from comparisons.facts.quantities.rows import ENCLOSED
from comparisons.formatting import duration, relative, relative_range
from comparisons.judging.levels import Levels
from comparisons.judging.metrics import at_equal, relative_error, rms_and_maximum
from comparisons.judging.uncertainty import combined
from comparisons.judging.verdicts import Number, of_steps
from comparisons.tasks.solution import Solution, Solved

# Closed forms are evaluated to some ten last digits.
EXACT = 1e-12
# Bars are missed by chance, in calibration by up to half of themselves; an exact solution is not.
_DOUBT = 2.0
# Share of the tolerance that references may differ by without a word: what their bars aim at.
MATTERS = 0.2
# What the uncertainty of a truth consists of.
DISCRETISATION, SOLVER, TRUNCATION = "discretisation", "solver", "truncation"
READ_OFF = "reading it off cells or elements"
ENSEMBLE, ARITHMETIC = "realisations", "arithmetic"
# What a model on a line adds to the bar of its error.
LINES, SPRINGS = "realisations of the line", "discretisation of the line"
# What a 3-D method adds, which solves some of the same surfaces.
PAIRS = "realisations in pairs"
# What is wrong whatever the tolerance.
CLINGS = "an answer where no equilibrium exists"
Curves = dict[str, np.ndarray]
Sources = dict[str, np.ndarray]


@dataclass(frozen=True)
class Truth:
    """What a scene is judged by: one method's finest solution, with its uncertainty.

    All bars are relative 95 % half-widths, one per load step, (k,).
    """

    # Along what the load steps are compared: the prescribed load, "step", "time" or "speed".
    axis: str
    levels: Levels  # the method's solutions at all resolutions
    resolution: int  # that of the finest
    curves: Curves  # quantity -> (k,) mean over realisations
    # Quantity -> source -> (k,) bar at the prescribed load; NaN where it is not known. The sources:
    # DISCRETISATION, SOLVER, TRUNCATION, ENSEMBLE; ARITHMETIC of closed forms; READ_OFF.
    sources: dict[str, Sources]
    checks: tuple[Truth, ...] = ()  # the other 3-D methods' finest solutions, which should agree

    @property
    def method(self) -> str:
        """The name of its method."""
        return self.levels.method

    @property
    def exact(self) -> bool:
        """Whether it is a closed form."""
        return METHODS[self.method].exact

    @property
    def solution(self) -> Solution:
        """The finest solution itself."""
        return self.levels.solutions[self.resolution]

    @property
    def path(self) -> bool:
        """Whether errors and bars are relative to the largest value along the steps."""
        return self.solution.path

    @property
    def label(self) -> str:
        """Method and resolution, as in results.csv."""
        return self.method if self.exact else f"{self.method} {self.resolution}"

    def knows(self, name: str, *curves: Curves) -> bool:
        """Tell whether it has a quantity, and so have the given curves."""
        return all(name in curves for curves in (self.curves, *curves))

    def errors(
        self, curves: Curves, name: str, at: str, apart: np.ndarray | bool = False
    ) -> np.ndarray:
        """Return the signed relative error of a quantity at equal `at`, per load step.

        Curves are (k,), or (m, k) of several realisations. At the other load than the prescribed
        one the truth is interpolated. Where no equilibrium exists, to say so (`apart`, (k,)) is
        right, and where many do, any value is; zero is where the truth is zero, too.
        """
        if not (self.knows(name, curves) and (at == self.axis or self.knows(at, curves))):
            return np.full_like(curves.get(name, self.solution.converged[0]), np.nan, dtype=float)
        if at == self.axis:
            error = relative_error(curves[name], self.curves[name], path=self.path)
            right = apart & self.solution.valueless_steps
            right = right | (self.solution.undetermined.all(axis=0) & np.isfinite(curves[name]))
            right = right | ((curves[name] == 0) & (self.curves[name] == 0))
            return np.where(right & np.isfinite(error).any(), 0.0, error)
        true = at_equal(curves[at], self.curves[at], self.curves[name])
        return relative_error(curves[name], true)

    def why_missing(self, curves: Curves, name: str, at: str, lost: np.ndarray) -> str:
        """Return why there is no error at the load steps `lost`, and at how many, kind by kind."""
        true, same = self.curves[name], at == self.axis
        kinds = {
            "no answer": np.isnan(curves[name]),
            CLINGS: same & self.solution.no_equilibrium.all(axis=0),
            "infinite": np.isinf(curves[name]),
            "the reference has no value": same & ~np.isfinite(true),
            "zero in the reference": same & (true == 0),
            f"outside the reference's range of {quantity(at).label}": ~np.isnan(curves[name]),
        }
        told = []
        for kind, steps in kinds.items():
            if (steps & lost).any():
                told.append(f"{kind} at {of_steps(steps & lost, at)}")
            lost = lost & ~steps
        return ", ".join(told)

    def bar_sources(self, name: str, at: str, *, same_surfaces: bool = False) -> Sources:
        """Return the sources of the uncertainty of a quantity at equal `at`.

        At the other load, its uncertainty enters through the slope of the curve. Methods that solve
        the very same surfaces do not differ by the scatter over realisations (`same_surfaces`).
        """
        sources = dict(self.sources[name])
        if same_surfaces:
            sources.pop(ENSEMBLE, None)
        if at == self.axis or at not in self.curves:
            return sources
        x, y = self.curves[at], self.curves[name]
        if len(x) < 2 or not (np.all(x > 0) and np.all(y > 0)):
            return sources
        steps = np.diff(np.log(x))
        monotone = bool(np.all(steps > 0) or np.all(steps < 0))
        slope = np.gradient(np.log(y), np.log(x)) if monotone else np.ones(len(x))
        load = self.sources[at]
        return {key: combined(part, slope * load.get(key, 0.0)) for key, part in sources.items()}

    def bar(self, name: str, at: str = "", *, same_surfaces: bool = False) -> np.ndarray:
        """Return the uncertainty of a quantity, all sources together.

        By default at the load where the quantity is judged (`facts.quantities.main_axis`).
        """
        at = at or main_axis(self.axis, name)
        return combined(*self.bar_sources(name, at, same_surfaces=same_surfaces).values())

    def error_sources(self, judged: Levels, resolution: int, name: str, at: str) -> Sources:
        """Return the sources of the bar of a method's error in a quantity at equal `at`.

        Errors are relative to the truth: what is not known of it, or of the method, counts in
        e = value/truth - 1 times value/truth, five times where a method is wrong by 400 %. Nothing
        is known relative to a truth that may be zero.

        A 3-D method solves some of the truth's surfaces, and only the scatter of the differences on
        these is an uncertainty. A model on a line has lines of its own, and springs whose number
        matters at its finest resolution; a theory is of all surfaces.
        """
        line = METHODS[judged.method].dimension != 3
        parts = self.bar_sources(name, at, same_surfaces=not line)
        unknown = combined(*parts.values()) >= 1  # it may be zero
        if line:
            parts[LINES] = judged.scatter(name, resolution)
            for source, part in _read_off(judged.solutions[resolution], name).items():
                parts[source] = combined(parts.get(source, 0.0), part)
            if resolution == judged.finest:
                parts[SPRINGS] = np.nan_to_num(judged.discretisation(name), nan=0.0)
        elif not self.exact:
            parts[PAIRS] = judged.apart(name, resolution, self.levels, self.resolution)
        if self.path:
            return parts
        ratio = np.abs(1 + self.errors(judged.curves(resolution), name, at))
        ratio = np.where(unknown, np.nan, np.where(np.isfinite(ratio), ratio, 1.0))
        return {key: part * ratio for key, part in parts.items()}

    def sentence(
        self,
        quantities: tuple[str, ...],
        fields: Mapping[str, np.ndarray] = MappingProxyType({}),
        titles: Mapping[str, str] = MappingProxyType({}),
    ) -> str:
        """Return which solution is the truth, and how well each compared quantity is known.

        `fields` has the bars of measures at the last load, as of the pressure; `titles` are those
        of the methods in this scene.
        """
        if self.exact:
            read = [name for name in quantities if name in self.solution.bars]
            labels = ", ".join(f"{quantity(n).label} {relative_range(self.bar(n))}" for n in read)
            but = f"; what is read off its pressure is known to: {labels}" if read else ""
            return f"The reference is the closed form, exact to round-off{but}."
        ensemble = self.levels.ensemble
        mean = f", mean over {ensemble}" if ensemble else ""
        title = titles.get(self.method) or METHODS[self.method].title
        text = f"The reference is the finest solution of {title} (N = {self.resolution}{mean})"
        bars = {name: self.bar(name) for name in quantities if self.knows(name)}
        ranges = [
            f"{quantity(name).label} {relative_range(bar)}"
            for name, bar in {**bars, **fields}.items()
            if np.isfinite(bar).any()
        ]
        known = f", known to: {', '.join(ranges)}" if ranges else ""
        unknown = [name for name, bar in bars.items() if not np.isfinite(bar).all()]
        if unknown and len(self.levels.solutions) == 1:
            return f"{text}{known}; only one resolution was run, so its error is not known."
        reasons: dict[str, list[str]] = {}  # what is missing for bars -> of which quantities
        for name in unknown:
            steps = enumerate(self.levels.missing(name, self.resolution), start=1)
            lacking = next((f"at load step {k} {reason}" for k, reason in steps if reason), "")
            if not lacking and (np.isnan(self.bar(name)) & (self.curves[name] == 0)).any():
                lacking = "it is zero on the finest grid"
            reasons.setdefault(lacking or "two grids have no common answer", []).append(name)
        for reason, several in reasons.items():
            labels = ", ".join(quantity(name).label for name in several)
            known += f"; {labels} not at every load: {reason}"
        return f"{text}{known}."

    def disagreements(
        self,
        quantities: tuple[str, ...],
        tolerance: float = 0.0,
        titles: Mapping[str, str] = MappingProxyType({}),
    ) -> tuple[str, ...]:
        """Return a sentence for each quantity in which a check differs by more than both bars.

        At the prescribed load, by the rms over the load steps, or at one step by twice its bars: of
        hundreds of 95 % bars some are missed by chance. Only differences beyond `MATTERS` of the
        tolerance: others change no verdict. `titles` are what methods are called on this scene, if
        not by their own.
        """
        sentences: list[str] = []
        for check in self.checks:
            pair = check.method, self.method
            both = " and ".join(titles.get(name) or METHODS[name].title for name in pair)
            sentences += [
                f"{both} differ in {quantity(name).label} by {excess}."
                for name, difference, excess in self._differing(check, quantities)
                if np.nanmax(difference) > MATTERS * tolerance
            ]
        return tuple(sentences)

    def disputed(self, name: str) -> np.ndarray:
        """Return by how much the checks differ in a quantity beyond the bars, (k,).

        Zero where all agree. Where they do not, one of the bars is wrong, and it is not known
        which: the truth is then known no better than to their difference. Beside a closed form the
        bar of the check is the likelier one, and counts as measured up to `_DOUBT` times itself.
        """
        beyond = [np.zeros(self.solution.converged.shape[1])]
        bars = _DOUBT if self.exact else 1.0
        for check in self.checks:
            beyond += [difference for _, difference, _ in self._differing(check, (name,), bars)]
        return np.nan_to_num(np.max(beyond, axis=0))

    def _differing(
        self, second: Truth, quantities: tuple[str, ...], times: float = 1.0
    ) -> Iterator[tuple[str, np.ndarray, str]]:
        """Yield quantity, difference (k,), and in words by how much, beyond `times` bars."""
        for name in quantities:
            if not self.knows(name, second.curves):
                continue
            curve, theirs = self.curves[name], second.curves[name]
            difference = np.abs(relative_error(theirs, curve, path=self.path))
            bars = [truth.bar(name, truth.axis, same_surfaces=True) for truth in (second, self)]
            allowed = times * combined(*bars) + EXACT
            finite = np.isfinite(difference) & np.isfinite(allowed)
            if not finite.any():
                continue
            typical = rms_and_maximum(difference[finite])[0]
            limit = rms_and_maximum(allowed[finite])[0]
            if typical > limit:
                excess = f"{relative(typical)} (rms over the loads), more than their bars of "
                yield name, difference, excess + relative(limit)
                continue
            ratio = np.where(finite, difference / np.where(finite, allowed, 1.0), 0.0)
            step = int(np.argmax(ratio))
            if ratio[step] > 2:
                excess = f"{relative(difference[step])} at load step {step + 1}, more than twice "
                yield name, difference, f"{excess}their bars of {relative(allowed[step])}"


def choose_truth(solved: Solved, axis: str, quantities: tuple[str, ...]) -> Truth | None:
    """Return the best truth: the closed form, else the 3-D method known best.

    That is the one whose compared quantities have the smallest bar; equal or unknown bars follow
    their order of preference. Methods on the cells of a grid have much the same error on the same
    one: only the finest is a candidate, lest a bar that is small by chance wins. What knows none of
    the quantities, or has loads beyond its range, is a truth only where nothing else is.
    """
    everyone = truths(solved, axis)
    able = [truth for truth in everyone if not METHODS[truth.method].peer]
    if not set(quantities) & set(FIELDS):
        able = [truth for truth in able if set(quantities) & truth.curves.keys()] or able
    able = [truth for truth in able if not truth.solution.out_of_range.any()] or able
    grids = [truth for truth in able if METHODS[truth.method].grid or truth.levels.rough]
    finest = max(grids, key=lambda grid: grid.resolution, default=None)
    able = [truth for truth in able if truth is finest or truth not in grids]
    if not able:
        return None

    def widest(truth: Truth) -> float:
        bars = [combined(*s.values()) for name, s in truth.sources.items() if name in quantities]
        finite = [float(np.nanmax(bar)) for bar in bars if np.isfinite(bar).any()]
        return max(finite, default=np.inf)

    best = able[0] if able[0].exact else min(able, key=widest)
    return replace(best, checks=tuple(truth for truth in everyone if truth is not best))


def truths(solved: Solved, axis: str) -> list[Truth]:
    """Return every 3-D method's finest solution as a candidate, in order of preference."""
    candidates = (candidate(solved, name, axis) for name in leading(METHODS))
    return [truth for truth in candidates if truth is not None]


def candidate(solved: Solved, method: str, axis: str) -> Truth | None:
    """Return the finest solution of a named method with its bars; None where it has none."""
    levels = Levels.of(solved, method)
    resolution = levels.finest
    if resolution is None:
        return None
    curves, solution = levels.curves(resolution), levels.solutions[resolution]
    steps, gone = solution.converged.shape[1], solution.valueless_steps
    residual = np.where(np.isnan(solution.violation), 0.0, solution.violation).max(axis=0)
    sources: dict[str, Sources] = {}
    for name in curves:
        if METHODS[method].exact:
            known = {ARITHMETIC: np.full(steps, EXACT)}
        else:
            known = {
                DISCRETISATION: levels.discretisation(name),
                SOLVER: residual,
                TRUNCATION: np.full(steps, 0.0 if name in solution.exact else solution.truncation),
                ENSEMBLE: levels.scatter(name, resolution),
            }
        known |= _read_off(solution, name)
        sources[name] = {key: np.where(gone, 0, part) for key, part in known.items()}
    return Truth(axis, levels, resolution, curves, sources)


def _read_off(solution: Solution, name: str) -> Sources:
    """Return what reading a quantity off a solution adds; nothing for others."""
    return {READ_OFF: np.fmax.reduce(solution.bars[name])} if name in solution.bars else {}


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
            "interval in which the answer lies by theorem, at most "
            f"{relative(self.width)} wide in force or penetration; {reached}. "
            f"It took {duration(self.seconds)}, the reference {duration(self.truth_seconds)}."
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
    # Quantity -> source -> its part of the relative 95 % half-width at each load; NaN: not known.
    sources: dict[str, dict[str, list[Number]]] = field(default_factory=dict)
    bars: dict[str, Bar] = field(default_factory=dict)  # quantity that it gives -> `Bar`
    footnotes: tuple[str, ...] = ()  # disagreements that are small against the tolerance, in words
    proved: Verification | None = None  # its bars held against theorems
    # Why lines that agree with it do so by chance (`comparisons.results.recording`).
    chance: str = ""

    @property
    def exact(self) -> bool:
        """Whether it is a closed form."""
        return self.method == CLOSED_FORM

    def bar(self, name: str) -> np.ndarray:
        """Return the relative 95 % half-width of a quantity at each load; empty if not known."""
        parts = self.sources.get(name)
        return combined(*parts.values()) if parts else np.array([])

    def known_to(self, name: str) -> np.ndarray:
        """Return the bars of a quantity that are known; of a field that at the last load."""
        last = [self.bars[name].bar] if name in self.bars else []
        bars = self.bar(name) if self.sources.get(name) else np.array(last)
        return bars[np.isfinite(bars)]


NO_REFERENCE = Reference("", 0, "")
