"""Contact pressures compared at the last load: L2 difference, integral."""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from math import gcd

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from comparisons.facts.methods import GRID
from comparisons.geometry.prepare import IndenterGeometry
from comparisons.judging.metrics import (
    SINGULAR_RING,
    Measure,
    grid_pressure_at,
    pressure_difference,
)
from comparisons.judging.truth import Truth
from comparisons.judging.uncertainty import SAFE
from comparisons.methods.normal.closed_form import form_of
from comparisons.scene.polygons import distance_to_outline
from comparisons.solving.plan import Plan
from comparisons.tasks.solution import Solved
from reference.closed_form import ClosedForm

Fields = dict[str, np.ndarray]


@dataclass(frozen=True)
class TruePressure:
    """The pressure that a truth gives at the last load."""

    plan: Plan
    truth: Truth

    @property
    def is_known(self) -> bool:
        """Whether there is one: a closed form has it everywhere, a solution where it was kept."""
        return self._formula is not None or "pressure" in self.truth.solution.fields

    @property
    def _penetration(self) -> float:
        return float(self.truth.curves["penetration"][-1])

    def at(self, fields: Fields) -> np.ndarray | None:
        """Return it at a method's points; None where the truth gives none."""
        x, y = fields["pressure_x"], fields["pressure_y"]
        if self._formula is not None:
            return np.asarray(self._formula.pressure(x, y, self._penetration))
        if not self.is_known:
            return None
        stored = self.truth.solution.fields
        if "pressure_shape" in stored:
            other_shape = fields.get("pressure_shape")
            shape = None if other_shape is None else tuple(int(n) for n in other_shape)
            return grid_pressure_at(stored, x, y, shape)
        points = np.stack([stored["pressure_x"], stored["pressure_y"]], axis=-1)
        # a half or a quarter stands for the whole
        x, y = (np.abs(c) if (p >= 0).all() else c for c, p in zip((x, y), points.T, strict=True))
        look_up = LinearNDInterpolator(points, stored["pressure"], fill_value=0.0)
        return np.asarray(look_up(x, y))

    def regular(self, fields: Fields) -> np.ndarray:
        """Return which points lie away from every singularity."""
        x, y = fields["pressure_x"], fields["pressure_y"]
        everywhere = np.ones(len(x), dtype=bool)
        geometry = self.plan.geometry
        if not isinstance(geometry, IndenterGeometry):
            return everywhere
        form = self._form
        if form is not None:
            if not form.pressure_is_singular:
                return everywhere
            rho = form.relative_radius(x, y, self._penetration)
            centre = 1.0 if form.singular_at == "edge" else 0.0
            return np.abs(rho - centre) > SINGULAR_RING
        corners = geometry.indenter.outline
        if corners is None:
            return everywhere
        return distance_to_outline(x, y, corners) > SINGULAR_RING * geometry.contact_radius

    def bar(self, fields: Fields | None = None) -> float:
        """Return how well it is known, as an L2 difference; NaN with one resolution.

        The change from the next coarser resolution, at first order: with r the ratio of
        resolutions, 1.25 times that change over r - 1. A compared solution (`fields`) on coarser
        cells meets the mean over k of the truth's cells, in which errors at the contact's edges
        cancel: its bar is that of the change between means over k cells of the coarser grid.
        """
        if self._formula is not None:
            return 0.0
        coarser = self.truth.levels.below(self.truth.resolution)
        if coarser is None:
            return float("nan")
        coarse = self.truth.levels.solutions[coarser].fields
        finest = self.at(coarse) if "pressure" in coarse else None
        if finest is None:
            return float("nan")
        weight, keep = coarse["pressure_weight"], self.regular(coarse)
        values = (coarse["pressure"], finest, weight, keep)
        if fields is not None:
            # how many of the truth's cells along x and y one cell of the solution covers
            own, other = (f.get("pressure_shape") for f in (self.truth.solution.fields, fields))
            cells = 1, 1
            if own is not None and other is not None:
                counts = [(int(n), int(m)) for n, m in zip(own, other, strict=True)]
                if all(n % m == 0 for n, m in counts):
                    cells = counts[0][0] // counts[0][1], counts[1][0] // counts[1][1]
            values = _over_cells(values, coarse, cells)
        before, after, weight, keep = values
        change = pressure_difference(before, weight, after, keep)
        return SAFE * change / (self.truth.resolution / coarser - 1)

    @cached_property
    def _form(self) -> ClosedForm | None:
        """The closed form of the shape, which knows where its pressure is singular."""
        geometry = self.plan.geometry
        scene = self.plan.scene
        if not isinstance(geometry, IndenterGeometry) or not scene.half_space.uniform:
            return None
        return form_of(geometry.indenter, scene.effective_modulus)

    @property
    def _formula(self) -> ClosedForm | None:
        """The closed form, if it is the truth."""
        return self._form if self.truth.exact else None


def pressure_measures(
    plan: Plan, solved: Solved, method: str, resolution: int, truth: Truth
) -> list[Measure]:
    """Return name, error and bar of each pressure measure of one solution.

    Where the truth is singular (a sharp edge, the tip of a cone) a ring of SINGULAR_RING contact
    radii is left out of the L2 difference.
    """
    solution = solved[method, resolution]
    fields = solution.fields
    if "pressure" not in fields or not solution.converged[0, -1]:
        return []
    force = float(solution.quantities["force"][0, -1])
    integral = float(np.nansum(fields["pressure"] * fields["pressure_weight"]) / force - 1)
    measures = [("pressure_integral", integral, 0.0)]
    same = same_grid_difference(solved, method, resolution)
    if same is not None:
        measures.append(("pressure_same_grid", same, 0.0))
    true = TruePressure(plan, truth)
    values = true.at(fields)
    if values is None:
        return measures
    keep = true.regular(fields) & np.isfinite(fields["pressure"])
    distance = pressure_difference(fields["pressure"], fields["pressure_weight"], values, keep)
    bar = true.bar(fields)
    return [*measures, ("pressure", distance, bar)]


def same_grid_difference(solved: Solved, method: str, resolution: int) -> float | None:
    """Return the relative L2 distance of a grid solver's pressure from FFT BEM's on its cells.

    Both solve the same equations, so this is no discretisation error: it is of the order of their
    violations of the contact conditions, or one of them is wrong. None where there is no such pair.
    """
    grid_solution = solved.get((GRID, resolution))
    fields = solved[method, resolution].fields
    if method == GRID or grid_solution is None or "pressure_shape" not in fields:
        return None
    theirs = grid_solution.fields
    if not grid_solution.converged[0, -1] or not np.array_equal(
        fields["pressure_shape"], theirs.get("pressure_shape", ())
    ):
        return None
    everywhere = np.ones(fields["pressure"].shape, dtype=bool)
    return pressure_difference(
        fields["pressure"], fields["pressure_weight"], theirs["pressure"], everywhere
    )


def _over_cells(
    values: tuple[np.ndarray, ...], fields: Fields, cells: tuple[int, int]
) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Return two pressures, weights and what is kept of a grid, as means over blocks of its cells.

    Of as many cells a block as divide the grid; a block is kept where all of its cells are.
    """
    before, after, weight, keep = values
    if cells == (1, 1) or "pressure_shape" not in fields:
        return before, after, weight, keep
    shape = [int(n) for n in fields["pressure_shape"]]
    block = [gcd(n, k) for n, k in zip(shape, cells, strict=True)]

    def in_blocks(array: np.ndarray) -> np.ndarray:
        split = array.reshape(shape[0] // block[0], block[0], shape[1] // block[1], block[1])
        return split.transpose(0, 2, 1, 3).reshape(-1, block[0] * block[1])

    area = in_blocks(weight).sum(axis=1)
    means = [(in_blocks(p) * in_blocks(weight)).sum(axis=1) / area for p in (before, after)]
    return means[0], means[1], area, np.asarray(in_blocks(keep).all(axis=1))
