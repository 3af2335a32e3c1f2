"""Contact pressures compared at the last load: L2 difference, integral, peak."""

from __future__ import annotations

from typing import Any

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from comparisons.facts.methods import METHODS, leading
from comparisons.geometry.prepare import IndenterGeometry
from comparisons.judging.metrics import SINGULAR_RING, grid_pressure_at, pressure_difference
from comparisons.judging.truth import Reference
from comparisons.judging.uncertainty import SAFE
from comparisons.methods.closed_form import form_of
from comparisons.scene.polygons import distance_to_outline
from comparisons.solving.planning import Plan
from comparisons.tasks.solution import Solved

# The grid solver that others are compared with cell by cell.
(COUNTERPART, *_) = (name for name in leading(METHODS) if METHODS[name].grid)
Fields = dict[str, np.ndarray]


def pressure_measures(
    plan: Plan, solved: Solved, method: str, resolution: int, reference: Reference
) -> list[dict[str, Any]]:
    """Return name, error and bar of each pressure measure of one solution.

    Where the truth is singular (a sharp edge, the tip of a cone) a ring of SINGULAR_RING contact
    radii is left out of the L2 difference, and there is no peak.
    """
    solution = solved[method, resolution]
    fields = solution.fields
    if "pressure" not in fields or not solution.converged[0, -1]:
        return []
    force = float(solution.quantities["force"][0, -1])
    whole = float(np.nansum(fields["pressure"] * fields["pressure_weight"]) / force - 1)
    found = [{"quantity": "pressure_integral", "error": whole, "bar": 0.0}]
    same = same_grid_difference(solved, method, resolution)
    if same is not None:
        found.append({"quantity": "pressure_same_grid", "error": same, "bar": 0.0})
    truth = _true_pressure(plan, solved, reference, fields)
    if truth is None:
        return found
    keep = regular_points(plan, reference, fields) & np.isfinite(fields["pressure"])
    distance = pressure_difference(fields["pressure"], fields["pressure_weight"], truth, keep)
    bar = _bar(plan, solved, reference)
    found.append({"quantity": "pressure", "error": distance, "bar": bar})
    if keep.all() and np.max(truth) > 0:
        peak = float(np.max(fields["pressure"]) / np.max(truth) - 1)
        found.append({"quantity": "pressure_peak", "error": peak, "bar": bar})
    return found


def same_grid_difference(solved: Solved, method: str, resolution: int) -> float | None:
    """Return the relative L2 distance of a grid solver's pressure from FFT BEM's on its cells.

    Both solve the same equations, so this is no discretisation error: it is of the order of their
    violations of the contact conditions, or one of them is wrong. None where there is no such pair.
    """
    other = solved.get((COUNTERPART, resolution))
    fields = solved[method, resolution].fields
    if method == COUNTERPART or other is None or "pressure_shape" not in fields:
        return None
    theirs = other.fields
    if not other.converged[0, -1] or not np.array_equal(
        fields["pressure_shape"], theirs.get("pressure_shape", ())
    ):
        return None
    everywhere = np.ones(fields["pressure"].shape, dtype=bool)
    return pressure_difference(
        fields["pressure"], fields["pressure_weight"], theirs["pressure"], everywhere
    )


def regular_points(plan: Plan, reference: Reference, fields: Fields) -> np.ndarray:
    """Return which points lie away from every singularity of the true pressure."""
    x, y = fields["pressure_x"], fields["pressure_y"]
    everywhere = np.ones(len(x), dtype=bool)
    if not isinstance(plan.geometry, IndenterGeometry):
        return everywhere
    indenter = plan.geometry.indenter
    form = form_of(indenter, plan.scene.effective_modulus)
    if form is not None:
        if not form.pressure_is_singular:
            return everywhere
        rho = form.relative_radius(x, y, float(reference.curves["penetration"][-1]))
        centre = 1.0 if form.singular_at == "edge" else 0.0
        return np.abs(rho - centre) > SINGULAR_RING
    corners = indenter.outline
    if corners is None:
        return everywhere
    return distance_to_outline(x, y, corners) > SINGULAR_RING * plan.geometry.contact_radius


def _true_pressure(
    plan: Plan, solved: Solved, reference: Reference, fields: Fields
) -> np.ndarray | None:
    """Return the reference's pressure at a method's points."""
    x, y = fields["pressure_x"], fields["pressure_y"]
    if reference.method == "closed_form":
        assert isinstance(plan.geometry, IndenterGeometry)
        form = form_of(plan.geometry.indenter, plan.scene.effective_modulus)
        assert form is not None
        return np.asarray(form.pressure(x, y, float(reference.curves["penetration"][-1])))
    stored = solved[reference.method, reference.resolution].fields
    return _look_up(stored, fields) if "pressure" in stored else None


def _look_up(stored: Fields, fields: Fields) -> np.ndarray:
    """Return a stored pressure at the points of other fields."""
    x, y = fields["pressure_x"], fields["pressure_y"]
    if "pressure_shape" in stored:
        given = fields.get("pressure_shape")
        shape = None if given is None else tuple(int(n) for n in given)
        return grid_pressure_at(stored, x, y, shape)
    points = np.stack([stored["pressure_x"], stored["pressure_y"]], axis=-1)
    # a half or a quarter stands for the whole
    x, y = (np.abs(c) if (p >= 0).all() else c for c, p in zip((x, y), points.T, strict=True))
    look_up = LinearNDInterpolator(points, stored["pressure"], fill_value=0.0)
    return np.asarray(look_up(x, y))


def truth_bar(plan: Plan, solved: Solved, reference: Reference) -> float | None:
    """Return how well the reference's pressure is known, None where it gives none."""
    fields = solved[reference.method, reference.resolution].fields
    if reference.method != "closed_form" and "pressure" not in fields:
        return None
    return _bar(plan, solved, reference)


def _bar(plan: Plan, solved: Solved, reference: Reference) -> float:
    """Return how well the reference's pressure is known, as an L2 difference.

    The change from its next coarser resolution, at first order: with r the ratio of resolutions,
    1.25 times that change over r - 1. NaN with one resolution.
    """
    if reference.method == "closed_form":
        return 0.0
    levels = [n for m, n in solved if m == reference.method and n < reference.resolution]
    if not levels:
        return float("nan")
    coarse = solved[reference.method, max(levels)].fields
    if "pressure" not in coarse:
        return float("nan")
    truth = _true_pressure(plan, solved, reference, coarse)
    if truth is None:
        return float("nan")
    keep = regular_points(plan, reference, coarse)
    change = pressure_difference(coarse["pressure"], coarse["pressure_weight"], truth, keep)
    return SAFE * change / (reference.resolution / max(levels) - 1)
