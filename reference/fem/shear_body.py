"""Finite elements below a grid, under tangential tractions: for friction and for rolling.

The counterpart of `grid_body.FreeBody` for `halfspace.traction.NormalAndTangential`: the solvers of
friction work on finite elements as they do on the half-space. Columns of elements
(`columns.tensor`) differ from the half-space within some cells only:

    K = K_Cerruti + (K_columns - K_cells),

with Cerruti's coefficients of tractions uniform on cells, and the same with all periodic images.
Under rollers the mesh stands still and the material flows through it (arbitrary Lagrange-Euler;
Nackenhorst 2004); its inertia, rho V^2, is a part of the columns.
"""

from __future__ import annotations

from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from reference.contact.body import window
from reference.elasticity import Material
from reference.fem.column_elements import Element
from reference.fem.columns import Layers, tensor
from reference.fem.grid_body import FreeBody
from reference.halfspace import kernels
from reference.halfspace.cerruti import Compliance, Transfer
from reference.halfspace.traction import NormalAndTangential

Array = NDArray[np.float64]

# Where the elements are clamped, in periods; cells from a load to its image, with inertia.
_DEPTH, _APART, _FAR = 2.0, 64, 4


class ShearBody(NormalAndTangential):
    """A half-space of finite elements below a rectangle of cells, free around it.

    Parameters
    ----------
    shape, spacing
        As for `NormalAndTangential`.
    material : Material
    element : {"linear", "splines", "quadratic"}
        See `column_elements`.
    inertia : float
        rho V^2/G of a body that flows along x; pressures and normal displacements at rest.

    Raises
    ------
    ValueError
        As `FreeBody` and `columns.tensor`.

    Examples
    --------
    >>> body = ShearBody((24, 24), (1.0, 1.0), Material(2.6, 0.3))
    >>> push = np.zeros((2, 24, 24))
    >>> push[0, 2, 2] = 1.0  # far away along x: 1/(2 pi G r)
    >>> bool(np.isclose(body.shear(push)[0, 22, 2], 1 / (2 * np.pi * 20), rtol=1e-2))
    True
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        material: Material,
        *,
        element: Element = "splines",
        inertia: float = 0.0,
    ) -> None:
        nu = material.poisson_ratio
        super().__init__(
            shape, spacing, Compliance.of(material.youngs_modulus / (2 * (1 + nu)), nu)
        )
        self.normal = FreeBody(shape, spacing, material, element)
        self.material, self.element, self.inertia = material, element, inertia

    def restrict(self, shape: tuple[int, int]) -> NormalAndTangential:
        """Return the same body of elements below a smaller rectangle of cells (cached)."""
        if shape == self.shape:
            return self
        return window(
            self._parts,
            shape,
            lambda part: ShearBody(
                part, self.spacing, self.material, element=self.element, inertia=self.inertia
            ),
        )

    @cached_property
    def period(self) -> tuple[int, int]:
        """Cells of the period on which elements and continuum are compared."""
        apart = _APART if self.inertia == 0 else max(_APART, _FAR * max(self.shape))
        longest = max(self.spacing)
        return tuple(
            2 * fft.next_fast_len(max(n, int(np.ceil(apart / 2 * longest / side))), real=True)
            for n, side in zip(self.shape, self.spacing, strict=True)
        )

    def free_coefficients(self) -> Transfer:
        """Displacements by tractions on a cell, at offsets from zero on."""
        nx, ny = self.shape
        cells = super().free_coefficients()
        more = beyond_cells(
            self.period, self.spacing, self.material, element=self.element, inertia=self.inertia
        )
        return Transfer(*(base + field[:nx, :ny] for base, field in zip(cells, more, strict=True)))


def beyond_cells(
    period: tuple[int, int],
    spacing: tuple[float, float],
    material: Material,
    *,
    element: Element,
    inertia: float,
) -> Transfer:
    """Return displacements of elements less those of the half-space, by tractions on a cell.

    Parameters
    ----------
    period : (int, int)
        Cells to the next images of load and displacement. One across: tractions that do not vary
        with y, plane strain.
    spacing, material, element, inertia
        As for `ShearBody`.

    Returns
    -------
    Transfer
        Fields of the shape of the period, at offsets modulo it, up to constants.
    """
    nu = material.poisson_ratio
    compliance = Compliance.of(material.youngs_modulus / (2 * (1 + nu)), nu)
    phases = (
        2 * np.pi * fft.fftfreq(period[0])[:, None],
        2 * np.pi * fft.rfftfreq(period[1])[None, :],
    )
    sides = [n * side for n, side in zip(period, spacing, strict=True)]
    layers = Layers([_DEPTH * max(sides)], [material])
    elements = tensor(phases, spacing, layers, element=element, inertia=inertia)
    # of the gauge i u_x, i u_y, u_z
    columns = Transfer(elements[0, 0], elements[1, 1], elements[0, 1], *-elements[2, :2])
    fields = []
    for ours, theirs, turned in zip(
        columns, _cells(period, spacing, compliance), _TURNED, strict=True
    ):
        difference = (ours - theirs).astype(complex)
        difference[0, 0] = 0.0
        if turned:
            difference *= 1j
        fields.append(fft.irfft2(difference, period, workers=1))
    return Transfer(*fields)


# Which of the components are odd in one coordinate only, of imaginary modes.
_TURNED = (False, False, False, True, True)


def _cells(period: tuple[int, int], spacing: tuple[float, float], body: Compliance) -> Transfer:
    """Return the factors of tractions uniform on cells, with all periodic images.

    Sums of `cerruti.periodic_transfer` over the aliases, times their sincs.
    """
    qx, qy = kernels.wavenumbers(period, spacing)
    shape = qx.size, qy.size
    sums = [np.zeros(shape) for _ in range(5)]
    along, sinc_x = kernels.aliases(qx.ravel(), spacing[0])
    across, sinc_y = kernels.aliases(qy.ravel(), spacing[1])
    c1, c2, c3 = body.normal, body.lateral, body.coupling
    for kx, share_x in zip(along, sinc_x, strict=True):
        for ky, share_y in zip(across, sinc_y, strict=True):
            x, y = kx[:, None], ky[None, :]
            square = x * x + y * y
            square[square == 0] = 1.0  # no wave: left out below
            share = share_x[:, None] * share_y / square
            size = np.sqrt(square)
            sums[0] += share * ((c1 + c2) * size - c2 * x * x / size)
            sums[1] += share * ((c1 + c2) * size - c2 * y * y / size)
            sums[2] -= share * c2 * x * y / size
            sums[3] -= share * c3 * x
            sums[4] -= share * c3 * y
    return Transfer(*sums)
