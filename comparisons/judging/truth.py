"""Which solution counts as the truth of a scene, how well it is known, and who disagrees."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from comparisons.facts.methods import METHODS, leading
from comparisons.formatting import relative
from comparisons.judging.metrics import relative_error, rms_and_maximum, sizes_along_path
from comparisons.judging.uncertainty import combined, ensemble_uncertainty, grid_uncertainty
from comparisons.tasks.solution import Solution, Solved

# Closed forms are evaluated to some ten last digits.
EXACT = 1e-12
# The load that is compared at besides the prescribed one.
OTHER_AXIS = {"penetration": "force", "force": "penetration", "mean_gap": "force"}
# What the uncertainty of a truth consists of.
GRID, SOLVER, TRUNCATION = "discretisation", "solver", "truncation"
ENSEMBLE, ARITHMETIC = "realisations", "arithmetic"
Sources = dict[str, np.ndarray]


@dataclass(frozen=True)
class Reference:
    """The truth of a scene: one method's finest solution, with its uncertainty.

    Attributes
    ----------
    method, resolution : str, int
    curves : dict
        Quantity -> (k,) mean over realisations.
    sources : dict
        Quantity -> source -> (k,) relative 95 % half-width at the prescribed load; NaN where it
        is not known. The sources: GRID, SOLVER, TRUNCATION, ENSEMBLE; ARITHMETIC of closed forms.
    text : str
        One sentence for the report.
    path : bool
        Errors and bars are relative to the largest value along the steps.
    """

    method: str
    resolution: int
    curves: dict[str, np.ndarray]
    sources: dict[str, Sources]
    text: str
    path: bool = False

    @property
    def uncertainty(self) -> dict[str, np.ndarray]:
        """Quantity -> (k,) all sources together."""
        return {name: combined(*parts.values()) for name, parts in self.sources.items()}

    def systematic(self, name: str) -> Sources:
        """Return the sources that remain where both methods solve the very same surfaces."""
        return {key: part for key, part in self.sources[name].items() if key != ENSEMBLE}

    @property
    def label(self) -> str:
        """Method and resolution, as in results.csv."""
        return self.method if METHODS[self.method].exact else f"{self.method} {self.resolution}"


def mean_curves(solution: Solution) -> dict[str, np.ndarray]:
    """Return each quantity's mean over the realisations that converged, (k,)."""
    curves = {}
    for name, values in solution.quantities.items():
        count = np.isfinite(values).sum(axis=0)
        total = np.nansum(values, axis=0)
        curves[name] = np.divide(
            total, count, out=np.full(values.shape[1], np.nan), where=count > 0
        )
    return curves


def on_common_realisations(solved: Solved) -> Solved:
    """Take out of every 3-D ensemble the steps that another 3-D solution lost on the same surface.

    Means over different surfaces would differ by their scatter. A solution that lost a step on
    all surfaces takes part in nothing there, and removes nothing from the others.
    """
    ensembles = {
        key: solution
        for key, solution in solved.items()
        if METHODS[key[0]].dimension == 3 and len(solution.converged) > 1
    }
    if not ensembles:
        return solved
    kept = [s.converged | ~s.converged.any(axis=0) for s in ensembles.values()]
    common = np.logical_and.reduce(kept)
    if common.all():
        return solved
    return solved | {
        key: replace(
            solution,
            quantities={n: np.where(common, v, np.nan) for n, v in solution.quantities.items()},
        )
        for key, solution in ensembles.items()
    }


def finest(solved: Solved, method: str) -> int | None:
    """Return the finest resolution of a method among those that solved the most load steps."""
    steps = {
        resolution: int(solution.converged.any(axis=0).sum())
        for (name, resolution), solution in solved.items()
        if name == method
    }
    most = max(steps.values(), default=0)
    return max((n for n, count in steps.items() if count == most > 0), default=None)


def choose_reference(solved: Solved, quantities: tuple[str, ...]) -> Reference | None:
    """Return the best reference: the closed form, else the 3-D method known best.

    Among 3-D methods the one whose compared quantities have the smallest bar wins; equal or
    unknown bars follow their order of preference. Half-space solvers have the same error on the
    same grid: of them only the finest grid is a candidate, lest a bar that is small by chance on
    coarse grids wins.
    """
    candidates = [each for each in references(solved) if not METHODS[each.method].peer]
    grids = [each for each in candidates if METHODS[each.method].grid]
    best = max(grids, key=lambda grid: grid.resolution, default=None)
    candidates = [each for each in candidates if each is best or each not in grids]
    if not candidates:
        return None
    if METHODS[candidates[0].method].exact:
        return candidates[0]

    def widest(reference: Reference) -> float:
        bars = [u for q, u in reference.uncertainty.items() if q in quantities]
        finite = [float(np.nanmax(u)) for u in bars if np.isfinite(u).any()]
        return max(finite, default=np.inf)

    return min(candidates, key=widest)


def references(solved: Solved) -> list[Reference]:
    """Return every 3-D method's finest solution as a candidate, in order of preference."""
    found = []
    for name in leading(METHODS):
        resolution = finest(solved, name)
        if resolution is not None:
            found.append(_reference(solved, name, resolution))
    return found


def own_discretisation(solved: Solved, method: str, name: str) -> np.ndarray:
    """Return the grid uncertainty of a quantity of a method's finest solution, (k,)."""
    levels = sorted(resolution for (m, resolution) in solved if m == method)
    curves = [mean_curves(solved[method, n]).get(name) for n in levels]
    kept = [(n, c) for n, c in zip(levels, curves, strict=True) if c is not None]
    if not kept:
        return np.full(next(iter(solved.values())).converged.shape[1], np.nan)
    sizes = sizes_along_path(kept[-1][1]) if solved[method, levels[-1]].path else None
    return grid_uncertainty(
        np.array([n for n, _ in kept]), np.array([c for _, c in kept]), sizes=sizes
    )


def main_axis(control: str, name: str) -> str:
    """Return the load at which a quantity is compared: the prescribed one, or for it the other.

    Along a path, in time or over speeds there is no other.
    """
    return OTHER_AXIS.get(control, control) if name == control else control


def sources_of(
    control: str, reference: Reference, name: str, at: str, *, same_surfaces: bool = False
) -> Sources:
    """Return the sources of the reference's uncertainty of a quantity at equal `at`, (k,) each.

    At the other load, the uncertainty of that load enters through the slope of the curve.
    `same_surfaces` leaves out the scatter over realisations: methods that solve the very same
    surfaces do not differ by it.
    """
    own = dict(reference.systematic(name) if same_surfaces else reference.sources[name])
    if at == control or at not in reference.curves:
        return own
    x, y = reference.curves[at], reference.curves[name]
    if len(x) < 2 or not (np.all(x > 0) and np.all(y > 0)):
        return own
    steps = np.diff(np.log(x))
    monotone = bool(np.all(steps > 0) or np.all(steps < 0))
    slope = np.gradient(np.log(y), np.log(x)) if monotone else np.ones(len(x))
    load = reference.sources[at]
    return {key: combined(part, slope * load[key]) for key, part in own.items()}


def uncertainty_of(
    control: str, reference: Reference, name: str, at: str, *, same_surfaces: bool = False
) -> np.ndarray:
    """Return the reference's uncertainty of a quantity at equal `at`, all sources together."""
    parts = sources_of(control, reference, name, at, same_surfaces=same_surfaces)
    return combined(*parts.values())


def known_to(control: str, reference: Reference, name: str) -> float:
    """Return how well a quantity is known: the rms over the loads of its bar, NaN where unknown."""
    if name not in reference.curves:
        return float("nan")
    bar = uncertainty_of(control, reference, name, main_axis(control, name))
    return rms_and_maximum(bar)[0]


def known_from(control: str, reference: Reference, name: str) -> dict[str, float]:
    """Return the rms over the loads of each source of a quantity's bar."""
    if name not in reference.curves:
        return {}
    parts = sources_of(control, reference, name, main_axis(control, name))
    return {source: rms_and_maximum(part)[0] for source, part in parts.items()}


def _reference(solved: Solved, method: str, resolution: int) -> Reference:
    solution = solved[method, resolution]
    curves = mean_curves(solution)
    sources = {name: _sources(solved, method, resolution, name) for name in curves}
    count = len(solution.converged)
    text = "The truth is the closed form, exact to round-off."
    if not METHODS[method].exact:
        text = f"The truth is the finest solution of {METHODS[method].title} (N = {resolution}"
        text += f", mean of {count} realisations)" if count > 1 else ")"
    return Reference(method, resolution, curves, sources, text, solution.path)


def _sources(solved: Solved, method: str, resolution: int, name: str) -> Sources:
    """Return what is not known of a quantity of a solution, source by source."""
    solution = solved[method, resolution]
    steps = solution.converged.shape[1]
    if METHODS[method].exact:
        return {ARITHMETIC: np.full(steps, EXACT)}
    residual = np.where(np.isnan(solution.violation), 0.0, solution.violation).max(axis=0)
    return {
        GRID: own_discretisation(solved, method, name),
        SOLVER: residual,
        TRUNCATION: np.full(steps, 0.0 if name in solution.exact else solution.truncation),
        ENSEMBLE: ensemble_uncertainty(solution.quantities[name], path=solution.path),
    }


def sentence(control: str, reference: Reference, quantities: tuple[str, ...]) -> str:
    """Return which solution is the truth, and how well each compared quantity is known."""
    if METHODS[reference.method].exact:
        return reference.text
    known = {name: known_to(control, reference, name) for name in quantities}
    bars = [
        f"{name.replace('_', ' ')} {relative(bar)}"
        for name, bar in known.items()
        if np.isfinite(bar)
    ]
    if not bars:
        return reference.text + "; only one resolution was run, so its error is not known."
    return reference.text + f", known to (95 %, rms over the loads): {', '.join(bars)}."


def disagreements(
    solved: Solved, chosen: Reference | None, quantities: tuple[str, ...]
) -> tuple[str, ...]:
    """Return a sentence for each quantity in which two references differ by more than their bars.

    Over the load steps the rms of the difference must stay below the rms of the combined bars,
    and no single step may exceed twice its own: of hundreds of 95 % bars some are missed by
    chance. Curves at the prescribed load are compared; an unknown bar cannot be exceeded.
    """
    if chosen is None:
        return ()
    return tuple(
        f"{METHODS[other.method].title} and {METHODS[chosen.method].title} differ in "
        f"{name.replace('_', ' ')} by {words}."
        for other, name, _, words in _differing(solved, chosen, quantities)
    )


def disputed(solved: Solved, chosen: Reference, name: str) -> np.ndarray:
    """Return by how much other references differ from the chosen one beyond their bars, (k,).

    Zero where all agree. Where they do not, one of the bars is wrong, and it is not known which:
    the truth is then known no better than to their difference.
    """
    steps = len(next(iter(chosen.curves.values())))
    found = [difference for *_, difference, _ in _differing(solved, chosen, (name,))]
    return np.nan_to_num(np.max([np.zeros(steps), *found], axis=0))


def _differing(
    solved: Solved, chosen: Reference, quantities: tuple[str, ...]
) -> Iterator[tuple[Reference, str, np.ndarray, str]]:
    """Yield another reference, the quantity, the difference (k,), and by how much in words."""
    for other in references(solved):
        names = [n for n in quantities if n in other.curves and n in chosen.curves]
        for name in names if other.method != chosen.method else ():
            mine, theirs = chosen.curves[name], other.curves[name]
            difference = np.abs(relative_error(theirs, mine, path=chosen.path))
            bars = [combined(*each.systematic(name).values()) for each in (other, chosen)]
            words = _disagreement(difference, combined(*bars) + EXACT)
            if words:
                yield other, name, difference, words


def _disagreement(difference: np.ndarray, allowed: np.ndarray) -> str:
    known = np.isfinite(difference) & np.isfinite(allowed)
    if not known.any():
        return ""
    usual, limit = rms_and_maximum(difference[known])[0], rms_and_maximum(allowed[known])[0]
    if usual > limit:
        return f"{relative(usual)} (rms over the loads), more than their bars of {relative(limit)}"
    ratio = np.where(known, difference / np.where(known, allowed, 1.0), 0.0)
    step = int(np.argmax(ratio))
    if ratio[step] <= 2:
        return ""
    return (
        f"{relative(difference[step])} at load step {step + 1}, more than twice their bars of "
        f"{relative(allowed[step])}"
    )
