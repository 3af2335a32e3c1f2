"""Which solution counts as the truth of a scene, how well it is known, and who disagrees."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from comparisons.formatting import relative
from comparisons.methods import METHODS, Solution
from comparisons.metrics import relative_error, rms_and_maximum
from comparisons.uncertainty import combined, ensemble_uncertainty, grid_uncertainty

# Closed forms are evaluated to some ten last digits.
EXACT = 1e-12
PREFERENCE = ("closed_form", "bem_fft", "fem", "bem_dense")
GRIDS = ("bem_fft", "bem_dense")
Solved = dict[tuple[str, int], Solution]


@dataclass(frozen=True)
class Reference:
    """The truth of a scene: one method's finest solution, with its uncertainty.

    Attributes
    ----------
    method, resolution : str, int
    curves : dict
        Quantity -> (k,) mean over realisations.
    uncertainty : dict
        Quantity -> (k,) relative 95 % half-width; NaN where it is not known.
    text : str
        One sentence for the report.
    """

    method: str
    resolution: int
    curves: dict[str, np.ndarray]
    uncertainty: dict[str, np.ndarray]
    text: str

    @property
    def label(self) -> str:
        """Method and resolution, as in results.csv."""
        return self.method if self.method == "closed_form" else f"{self.method} {self.resolution}"


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


def finest(solved: Solved, method: str) -> int | None:
    """Return the finest resolution of a method with an answer at every load step."""
    complete = [
        resolution
        for (name, resolution), solution in solved.items()
        if name == method and solution.converged.any(axis=0).all()
    ]
    return max(complete, default=None)


def choose_reference(solved: Solved, quantities: tuple[str, ...]) -> Reference | None:
    """Return the best reference: the closed form, else the 3-D method known best.

    Among 3-D methods the one whose compared quantities have the smallest bar wins; equal or
    unknown bars follow the order of PREFERENCE. The dense half-space solver has the same error
    as the FFT one on the same grid: of the two only the finer grid is a candidate, lest a bar
    that is small by chance on coarse grids wins.
    """
    candidates = references(solved, quantities)
    grids = {each.method: each.resolution for each in candidates if each.method in GRIDS}
    if len(grids) == len(GRIDS):
        worse = "bem_dense" if grids["bem_fft"] >= grids["bem_dense"] else "bem_fft"
        candidates = [each for each in candidates if each.method != worse]
    if not candidates:
        return None
    if candidates[0].method == "closed_form":
        return candidates[0]

    def widest(reference: Reference) -> float:
        bars = [u for q, u in reference.uncertainty.items() if q in quantities]
        finite = [float(np.nanmax(u)) for u in bars if np.isfinite(u).any()]
        return max(finite, default=np.inf)

    return min(candidates, key=widest)


def references(solved: Solved, quantities: tuple[str, ...]) -> list[Reference]:
    """Return every 3-D method's finest solution as a candidate, in order of preference."""
    names = [name for name in PREFERENCE if name in METHODS]
    names += [n for n, m in METHODS.items() if m.dimension == 3 and n not in names]
    found = []
    for name in names:
        resolution = finest(solved, name)
        if resolution is not None:
            found.append(_reference(solved, name, resolution, quantities))
    return found


def own_discretisation(solved: Solved, method: str, name: str) -> np.ndarray:
    """Return the grid uncertainty of a quantity of a method's finest solution, (k,)."""
    levels = sorted(resolution for (m, resolution) in solved if m == method)
    curves = [mean_curves(solved[method, n]).get(name) for n in levels]
    kept = [(n, c) for n, c in zip(levels, curves, strict=True) if c is not None]
    if not kept:
        return np.full(next(iter(solved.values())).converged.shape[1], np.nan)
    return grid_uncertainty(np.array([n for n, _ in kept]), np.array([c for _, c in kept]))


def _reference(
    solved: Solved, method: str, resolution: int, quantities: tuple[str, ...]
) -> Reference:
    solution = solved[method, resolution]
    curves = mean_curves(solution)
    uncertainty = {}
    for name in curves:
        if method == "closed_form":
            uncertainty[name] = np.full(len(curves[name]), EXACT)
            continue
        residual = np.nan_to_num(np.fmax.reduce(solution.violation, axis=0), nan=0.0)
        uncertainty[name] = combined(
            own_discretisation(solved, method, name),
            residual,
            ensemble_uncertainty(solution.quantities[name]),
        )
    text = _sentence(method, resolution, len(solution.converged), uncertainty, quantities)
    return Reference(method, resolution, curves, uncertainty, text)


def _sentence(
    method: str,
    resolution: int,
    realisations: int,
    uncertainty: dict[str, np.ndarray],
    quantities: tuple[str, ...],
) -> str:
    if method == "closed_form":
        return "The truth is the closed form, exact to round-off."
    known = {
        name: rms_and_maximum(uncertainty[name])[0]
        for name in quantities
        if name in uncertainty and np.isfinite(uncertainty[name]).any()
    }
    known = {name: bar for name, bar in known.items() if bar > EXACT}
    what = f"The truth is the finest solution of {METHODS[method].title} (resolution {resolution}"
    what += f", mean of {realisations} realisations)" if realisations > 1 else ")"
    if not known:
        return what + "; only one resolution was run, so its error is not known."
    bars = ", ".join(f"{name.replace('_', ' ')} {relative(bar)}" for name, bar in known.items())
    return what + f", known to (95 %, rms over the loads): {bars}."


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
    found = []
    for other in references(solved, quantities):
        names = [n for n in quantities if n in other.curves and n in chosen.curves]
        for name in names if other.method != chosen.method else ():
            difference = np.abs(relative_error(other.curves[name], chosen.curves[name]))
            allowed = combined(other.uncertainty[name], chosen.uncertainty[name]) + EXACT
            sentence = _disagreement(difference, allowed)
            if sentence:
                found.append(
                    f"{METHODS[other.method].title} and {METHODS[chosen.method].title} differ in "
                    f"{name.replace('_', ' ')} by {sentence}."
                )
    return tuple(found)


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
