"""The measured curve of a scene, and the modulus fitted to it with each method's curve.

Without friction, adhesion and plasticity the force at a given depth is proportional to the modulus:
F(d) = k F0(d - d0), with F0 computed at the modulus of the scene. Least squares give k, and d0 if
the depth at first touch is not known. Between the computed loads, and beyond them, F0 is a power
law in d through the two nearest.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.optimize import curve_fit
from scipy.special import stdtrit

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL, title_of
from comparisons.results.record import SceneRecord


def computed_curve(scene: SceneRecord, method: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the penetrations and forces of a method at its finest resolution, increasing."""
    rows = scene.curve(method)
    depth, force = (rows[name] for name in ("penetration", "force"))
    keep = (depth > 0) & (force > 0)
    order = np.argsort(depth[keep], kind="stable")
    return depth[keep][order], force[keep][order]


def modulus_fits(scene: SceneRecord) -> dict[str, ModulusFit]:
    """Return the fits with the curves of the reduced model and of the reference, where possible."""
    measured = scene.plan.measured
    if measured is None:
        return {}
    fits = {}
    for name in dict.fromkeys([MODEL, scene.reference.method]):
        computed = computed_curve(scene, name)
        if len(computed[0]) < 2 or not (np.diff(computed[0]) > 0).all():
            continue
        fit = fit_modulus(measured.curve, computed, measured.modulus, fit_zero=measured.fit_zero)
        if fit is not None:
            fits[name] = fit
    return fits


def modulus_sentence(scene: SceneRecord) -> str:
    """Return the fitted moduli in a sentence; empty without a measured curve."""
    measured = scene.plan.measured
    if measured is None:
        return ""
    fits = modulus_fits(scene)
    if not fits:
        return "Measured curve: no modulus fits, or too few points lie within the computed depths."
    moduli = []
    for name, fit in fits.items():
        scale = fmt.prefix_for(fit.modulus, "Pa")
        spread = fmt.number(fit.half_width * scale.factor, 2)
        zero = f", first touch at {fmt.with_unit(fit.zero, 'm')}," if fit.zero else ""
        text = f"{fmt.number(fit.modulus * scale.factor, 4)} ± {spread} {scale.unit}{zero}"
        moduli.append(f"{text} by {title_of(name)}")
    used, count = next(iter(fits.values())).used, len(measured.force)
    return (
        f"Measured curve: E* = {', '.join(moduli)}; 95 % intervals for independent noise, "
        f"{fmt.count(used)} of {fmt.count(count)} points."
    )


LEVEL = 0.95
# Choices of points, and how many of them may still take points in.
MOST_ROUNDS, FREE_ROUNDS = 1000, 10


@dataclass(frozen=True)
class ModulusFit:
    """A fitted modulus."""

    # E* and the half-width of its 95 % interval, in Pa, for independent errors of equal size.
    modulus: float
    half_width: float
    zero: float  # depth at first touch, m; 0 where it was not fitted
    used: int  # number of points within the computed depths


def fit_modulus(
    measured: tuple[np.ndarray, np.ndarray],
    computed: tuple[np.ndarray, np.ndarray],
    modulus: float,
    *,
    fit_zero: bool = False,
) -> ModulusFit | None:
    """Fit E*, or return None if too few points lie within the computed depths; SI units.

    Three are needed, or four with `fit_zero` (fit the depth at first touch, too); depths count from
    the fitted first touch, so that no point is compared with a continuation of the computed curve
    to larger loads. Curves are (penetration, force); the computed one is positive, increasing, at
    `modulus`.
    """
    reach, largest = float(computed[0][-1]), float(computed[1][-1])
    depth, force = measured[0], measured[1] / largest
    parameters = 1 + fit_zero

    def within(zero: float) -> np.ndarray:
        """Tell which depths, counted from first touch, lie within the computed ones."""
        below: np.ndarray = depth - zero
        return (below > 0) & (below <= reach * (1 + 1e-9))

    def model(at: np.ndarray, factor: float, shift: float = 0.0) -> np.ndarray:
        return factor * force_at(at - shift * reach, computed) / largest

    inside = within(0.0)
    for round_number in range(MOST_ROUNDS):
        points = depth[inside], force[inside]
        freedom = len(points[0]) - parameters
        if freedom <= 1:
            return None
        shape = model(points[0], 1.0)
        start = [float(shape @ points[1] / (shape @ shape)), 0.0][:parameters]
        scale = [abs(start[0]) or 1.0, 0.1][:parameters]
        try:
            found, covariance = curve_fit(model, *points, start, method="trf", x_scale=scale)
        except RuntimeError:  # no modulus fits: a force that falls with the depth, or noise alone
            return None
        zero = float(found[1] * reach) if fit_zero else 0.0
        # Another first touch moves points in and out of the computed depths.
        now = within(zero)
        if round_number >= FREE_ROUNDS:
            now &= inside  # points that come and go by turns stay out, so that it ends
        if (now == inside).all():
            half = float(stdtrit(freedom, (1 + LEVEL) / 2)) * float(np.sqrt(covariance[0, 0]))
            return ModulusFit(found[0] * modulus, half * modulus, zero, len(points[0]))
        inside = now
    return None


def force_at(depth: np.ndarray, computed: tuple[np.ndarray, np.ndarray]) -> np.ndarray:
    """Return the force at depths, by power laws between the computed loads; 0 without contact.

    >>> float(force_at(np.array([2.0]), (np.array([1.0, 4.0]), np.array([1.0, 8.0])))[0].round(9))
    2.828427125
    """
    known, force = np.log(computed[0]), np.log(computed[1])
    slopes = np.diff(force) / np.diff(known)
    wanted = np.log(np.maximum(depth, 1e-300))
    place = np.clip(np.searchsorted(known, wanted) - 1, 0, len(slopes) - 1)
    power = force[place] + slopes[place] * (wanted - known[place])
    return np.where(depth > 0, np.exp(power), 0.0)
