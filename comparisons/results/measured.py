"""The measured curve of a scene, and the modulus fitted to it with each method's curve."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL, title_of
from comparisons.judging.modulus_fit import ModulusFit, fit_modulus
from comparisons.results import selection
from comparisons.results.store import SceneRecord


def measured_curve(scene: SceneRecord) -> tuple[np.ndarray, np.ndarray] | None:
    """Return the measured penetrations and forces, or None."""
    stored = scene.plan.measured
    return (np.array(stored.penetration), np.array(stored.force)) if stored else None


def computed_curve(scene: SceneRecord, method: str) -> tuple[np.ndarray, np.ndarray]:
    """Return the penetrations and forces of a method at its finest resolution, increasing."""
    rows = selection.curve(scene, method)
    depth, force = (rows[name] for name in ("penetration", "force"))
    keep = (depth > 0) & (force > 0)
    order = np.argsort(depth[keep], kind="stable")
    return depth[keep][order], force[keep][order]


def modulus_fits(scene: SceneRecord) -> dict[str, ModulusFit]:
    """Return the fits with the curves of the reduced model and of the reference, where possible."""
    measured, stated = measured_curve(scene), scene.plan.measured
    if measured is None or stated is None:
        return {}
    fits = {}
    for name in dict.fromkeys([MODEL, scene.reference.method]):
        computed = computed_curve(scene, name)
        if len(computed[0]) < 2 or not (np.diff(computed[0]) > 0).all():
            continue
        fit = fit_modulus(measured, computed, stated.modulus, fit_zero=stated.fit_zero)
        if fit is not None:
            fits[name] = fit
    return fits


def modulus_sentence(scene: SceneRecord) -> str:
    """Return the fitted moduli in a sentence; empty without a measured curve.

    The interval is for independent errors of equal size; it does not cover drift or a wrong shape.
    """
    measured = measured_curve(scene)
    if measured is None:
        return ""
    fits = modulus_fits(scene)
    if not fits:
        return "Measured curve: no modulus, as too few points lie within the computed depths."
    moduli = ", ".join(f"{_fitted(fit)} by {title_of(name)}" for name, fit in fits.items())
    used, count = next(iter(fits.values())).used, len(measured[0])
    return (
        f"Measured curve: E* = {moduli}; 95 % intervals for independent noise, "
        f"{fmt.count(used)} of {fmt.count(count)} points."
    )


def _fitted(fit: ModulusFit) -> str:
    scale = fmt.prefix_for(fit.modulus, "Pa")
    spread = fmt.number(fit.half_width * scale.factor, 2)
    zero = f", first touch at {fmt.with_unit(fit.zero, 'm')}," if fit.zero else ""
    return f"{fmt.number(fit.modulus * scale.factor, 4)} ± {spread} {scale.unit}{zero}"
