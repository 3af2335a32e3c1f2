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

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from reference.fem.columns import Element, Layers, compliance
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


class PeriodicBody(HalfSpace):
    """Finite elements below one period of a surface, zero mean displacement.

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
        If shape, spacing or modulus is not positive; an unknown element when it is first needed.

    Examples
    --------
    >>> x = np.arange(32) / 32
    >>> p = np.broadcast_to(np.cos(2 * np.pi * x)[:, None], (32, 32))
    >>> body = PeriodicBody((32, 32), (1 / 32, 1 / 32), Material(1 - 0.3**2, 0.3))
    >>> bool(np.allclose(body.apply(p), p / np.pi, rtol=2e-3, atol=1e-12))
    True
    """

    periodic = True

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        material: Material,
        element: Element = "splines",
        contact_compliance: float = 0.0,
    ) -> None:
        super().__init__(shape, spacing, plane_modulus(material))
        self.material, self.element = material, element
        self.contact_compliance = contact_compliance
        self._padded = self.shape

    def _transfer(self) -> Array:
        transfer = modes(self.shape, self.spacing, self.material, self.element)
        transfer[0, 0] = 0.0
        return transfer + self.contact_compliance

    def softened(self, compliance: float) -> PeriodicBody:
        """Return the same body with more overlap per pressure (kept)."""

        def make() -> PeriodicBody:
            total = self.contact_compliance + compliance
            body = PeriodicBody(self.shape, self.spacing, self.material, self.element, total)
            body._cache["transfer"] = self.transfer + compliance
            return body

        return self.cached(("softened", compliance), make)

    def coarser(self) -> PeriodicBody | None:
        """Return the body below every second point (kept), or None if the period has an odd one."""
        if any(n % 2 for n in self.shape):
            return None
        shape = self.shape[0] // 2, self.shape[1] // 2
        spacing = 2 * self.spacing[0], 2 * self.spacing[1]
        more = self.material, self.element, self.contact_compliance
        return self.cached("coarser", lambda: PeriodicBody(shape, spacing, *more))


class FreeBody(FreeOperator):
    """Finite elements below a rectangle of cells, free around it.

    Parameters
    ----------
    shape, spacing, material, element, contact_compliance
        As for `PeriodicBody`.

    Raises
    ------
    ValueError
        As `PeriodicBody`, and if a cell is more than `LONGEST` times longer than wide.

    Examples
    --------
    >>> body = FreeBody((40, 40), (1.0, 1.0), Material(1 - 0.3**2, 0.3))
    >>> one = np.zeros((40, 40))
    >>> one[4, 4] = 1.0  # far from one loaded cell: 1/(pi E* r)
    >>> bool(np.isclose(body.apply(one)[4, 36], 1 / (32 * np.pi), rtol=1e-2))
    True
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
        if max(spacing) > LONGEST * min(spacing):
            raise ValueError(
                f"spacing must be sides within a factor of {LONGEST} below a free patch, "
                f"not {spacing!r}"
            )
        self.material, self.element = material, element
        self.contact_compliance = contact_compliance

    @property
    def lifts(self) -> bool:
        """Whether pressure on a cell raises another one, as elements below long cells do."""
        return bool(self.coefficients(self.shape).min() < 0)

    def coefficients(self, shape: tuple[int, int]) -> Array:
        """Coefficients at offsets from zero to less than `shape`: Love's, and what elements add."""
        coefficients: Array = self.cached("body", self._coefficients)
        return coefficients[: shape[0], : shape[1]]

    def _coefficients(self) -> Array:
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
        whole = kernels.love(i, j, self.spacing, self.effective_modulus) + nearby
        whole[0, 0] += self.contact_compliance
        return whole

    def softened(self, compliance: float) -> FreeBody:
        """Return the same body with more overlap per pressure (kept)."""

        def make() -> FreeBody:
            total = self.contact_compliance + compliance
            body = FreeBody(self.shape, self.spacing, self.material, self.element, total)
            body._cache["body"] = self.coefficients(self.shape).copy()
            body._cache["body"][0, 0] += compliance
            return body

        return self.cached(("softened", compliance), make)

    def coarser(self) -> FreeBody:
        """Return the body below every second point (kept)."""
        shape = (self.shape[0] + 1) // 2, (self.shape[1] + 1) // 2
        spacing = 2 * self.spacing[0], 2 * self.spacing[1]
        more = self.material, self.element, self.contact_compliance
        return self.cached("coarser", lambda: FreeBody(shape, spacing, *more))

    def restrict(self, shape: tuple[int, int]) -> FreeBody:
        """Return the same body below a smaller rectangle of the same cells (kept)."""

        def make() -> FreeBody:
            part = FreeBody(
                shape, self.spacing, self.material, self.element, self.contact_compliance
            )
            part._cache["body"] = self.coefficients(shape)
            return part

        return self.cached(("restricted", shape), make)


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
