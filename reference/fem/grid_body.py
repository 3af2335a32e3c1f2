r"""An elastic body of finite elements below a grid of cells, as an operator for contact solvers.

The compliance of the columns (`columns.compliance`) on all modes of an FFT is the condensed
stiffness of a mesh that repeats; with it the solvers of `halfspace.fft`, stiffnesses and energies
work on finite elements as they do on the half-space, and share its contact iteration.

A periodic body is clamped two periods below the surface, where no more than 1e-8 of the longest
wave's compliance comes from: nothing of it is taken from the half-space. On a free surface the body
differs from the half-space within some cells only, where the elements differ from the continuum:

    K_free = K_Love + (K_columns - K_cells),

with Love's coefficients of pressures uniform on cells, and the same with all periodic images.
"""

from __future__ import annotations

import math
from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from reference.arguments import choice_faults, refuse
from reference.fem.columns import ELEMENTS, Element, Layers, compliance
from reference.fem.elasticity import Material
from reference.halfspace import kernels
from reference.halfspace.operators import FreeOperator, HalfSpace

Array = NDArray[np.float64]

# Where a body without a base is clamped, in the longer period.
_DEPTH = 2.0
# Long sides of cells from one loaded cell to its image where elements and continuum are the same.
_APART = 64
# Longer cells need more modes for that than there is use for them.
LONGEST = 100


class GridBody(HalfSpace):
    """What both bodies share: what they are made of, and the same again on other cells.

    Parameters
    ----------
    shape : (int, int)
        Number of cells (nx, ny).
    spacing : (float, float)
        Cell sides (dx, dy), consistent units.
    material : Material
    element : {"linear", "splines"}
        See `columns`.
    contact_compliance : float
        Depth per pressure by which shape and body may overlap, on top of all displacements: the
        penalty method, 1/eps.

    Raises
    ------
    ValueError
        For an unknown element; if shape, spacing or modulus is not positive.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        material: Material,
        element: Element = "splines",
        contact_compliance: float = 0.0,
    ) -> None:
        super().__init__(shape, spacing, plane_modulus(material))
        refuse([*choice_faults("element", element, ELEMENTS), *self._cell_faults()])
        self.material, self.element = material, element
        self.contact_compliance = contact_compliance

    def _cell_faults(self) -> list[str]:
        """Return what is wrong with the cells for this kind of body."""
        return []

    def _elastic(self) -> Array:
        """Compliance of the body without its contact's, as the kind of body keeps it."""
        raise NotImplementedError

    @property
    def elastic(self) -> Array:
        """Compliance of the body alone (kept)."""
        return self.cached("elastic", self._elastic)

    def _alike(
        self, shape: tuple[int, int], spacing: tuple[float, float], more: float = 0.0
    ) -> Self:
        """Return a body of the same elements on other cells, with more overlap per pressure."""
        total = self.contact_compliance + more
        return type(self)(shape, spacing, self.material, self.element, total)

    def softened(self, compliance: float) -> Self:
        """Return the same body with more overlap per pressure (kept)."""
        return self.cached(("softened", compliance), lambda: self._softer(compliance))

    def _softer(self, compliance: float) -> Self:
        body = self._alike(self.shape, self.spacing, compliance)
        body._cache["elastic"] = self.elastic
        return body

    def _twice(self, shape: tuple[int, int]) -> Self:
        """Return the body below cells of twice the sides (kept)."""
        spacing = 2 * self.spacing[0], 2 * self.spacing[1]
        return self.cached("coarser", lambda: self._alike(shape, spacing))


class PeriodicBody(GridBody):
    """Finite elements below one period of a surface, zero mean displacement.

    Parameters
    ----------
    shape, spacing, material, element, contact_compliance
        As for `GridBody`.

    Raises
    ------
    ValueError
        As `GridBody`.

    Examples
    --------
    >>> x = np.arange(32) / 32
    >>> p = np.broadcast_to(np.cos(2 * np.pi * x)[:, None], (32, 32))
    >>> body = PeriodicBody((32, 32), (1 / 32, 1 / 32), Material(1 - 0.3**2, 0.3))
    >>> bool(np.allclose(body.apply(p), p / np.pi, rtol=2e-3, atol=1e-12))
    True
    """

    periodic = True

    def _elastic(self) -> Array:
        transfer = modes(self.shape, self.spacing, self.material, self.element)
        transfer[0, 0] = 0.0
        return transfer

    def _transfer(self) -> Array:
        return self.elastic + self.contact_compliance

    def coarser(self) -> Self | None:
        """Return the body below every second point (kept), or None if the period has an odd one."""
        if any(n % 2 for n in self.shape):
            return None
        return self._twice((self.shape[0] // 2, self.shape[1] // 2))


class FreeBody(GridBody, FreeOperator):
    """Finite elements below a rectangle of cells, free around it.

    Parameters
    ----------
    shape, spacing, material, element, contact_compliance
        As for `GridBody`.

    Raises
    ------
    ValueError
        As `GridBody`, and if a cell is more than `LONGEST` times longer than wide.

    Examples
    --------
    >>> body = FreeBody((40, 40), (1.0, 1.0), Material(1 - 0.3**2, 0.3))
    >>> one = np.zeros((40, 40))
    >>> one[4, 4] = 1.0  # far from one loaded cell: 1/(pi E* r)
    >>> bool(np.isclose(body.apply(one)[4, 36], 1 / (32 * np.pi), rtol=1e-2))
    True
    """

    def _cell_faults(self) -> list[str]:
        if max(self.spacing) <= LONGEST * min(self.spacing):
            return []
        return [
            f"spacing must be sides within a factor of {LONGEST} below a free patch, "
            f"not {self.spacing!r}"
        ]

    @property
    def lifts(self) -> bool:
        """Whether pressure on a cell raises another one, as elements below long cells do."""
        return bool(self.elastic.min() < 0)

    def coefficients(self, shape: tuple[int, int]) -> Array:
        """Coefficients at offsets from zero to less than `shape`: Love's, and what elements add."""
        coefficients: Array = self.cached("body", self._coefficients)
        return coefficients[: shape[0], : shape[1]]

    def _coefficients(self) -> Array:
        whole = self.elastic.copy()
        whole[0, 0] += self.contact_compliance
        return whole

    def _elastic(self) -> Array:
        rows, columns = self.shape
        # half of an even period, so that the grid sees none of its images
        half = [
            int(
                fft.next_fast_len(
                    max(n, math.ceil(_APART / 2 * max(self.spacing) / step - 1e-9)), real=True
                )
            )
            for n, step in zip(self.shape, self.spacing, strict=True)
        ]
        period = 2 * half[0], 2 * half[1]
        more = modes(period, self.spacing, self.material, self.element)
        cells = kernels.periodic(period, self.spacing, self.effective_modulus, "cells")
        more -= cells
        more[0, 0] = 0.0
        nearby = fft.irfft2(more, period, workers=1)[:rows, :columns]
        i, j = np.ix_(np.arange(rows), np.arange(columns))
        return kernels.love(i, j, self.spacing, self.effective_modulus) + nearby

    def coarser(self) -> Self:
        """Return the body below every second point (kept)."""
        return self._twice(((self.shape[0] + 1) // 2, (self.shape[1] + 1) // 2))

    def restrict(self, shape: tuple[int, int]) -> Self:
        """Return the same body below a smaller rectangle of the same cells (kept)."""
        return self.cached(("restricted", shape), lambda: self._part(shape))

    def _part(self, shape: tuple[int, int]) -> Self:
        part = self._alike(shape, self.spacing)
        part._cache["elastic"] = self.elastic[: shape[0], : shape[1]]
        return part


def plane_modulus(material: Material) -> float:
    """E/(1 - nu^2): the effective modulus of a body under a rigid one."""
    return material.youngs_modulus / (1 - material.poisson_ratio**2)


def modes(
    shape: tuple[int, int], spacing: tuple[float, float], material: Material, element: Element
) -> Array:
    """Compliance on the modes of `rfft2`, from an octant or a quarter of them; length/pressure."""
    rows, columns = shape[0] // 2 + 1, shape[1] // 2 + 1
    along, across = (
        2 * np.pi * np.arange(rows) / shape[0],
        2 * np.pi * np.arange(columns) / shape[1],
    )
    depth = _DEPTH * max(n * step for n, step in zip(shape, spacing, strict=True))
    layers = Layers([depth], [material])
    if shape[0] == shape[1] and spacing[0] == spacing[1]:
        m, n = np.tril_indices(rows)
        quarter = np.empty((rows, columns))
        values = compliance((along[m], across[n]), spacing, layers, element=element)
        quarter[m, n] = quarter[n, m] = values
    else:
        quarter = compliance((along[:, None], across), spacing, layers, element=element)
    whole: Array = quarter[np.minimum(np.arange(shape[0]), shape[0] - np.arange(shape[0]))]
    return whole
