r"""An elastic body of finite elements below a grid of cells, as an operator for contact solvers.

The compliance of the columns (`columns.compliance`) on all modes of an FFT is the condensed
stiffness of a mesh that repeats; with it the solvers of `halfspace.fft`, stiffnesses and energies
work on finite elements as they do on the half-space, and share its contact iteration.

A periodic body is clamped two periods below its layers, where no more than 1e-8 of the longest
wave's compliance comes from: nothing of it is taken from the half-space. With an impedance bottom
the mesh ends eight cells below its layers, on the stiffness of a half-space's surface: a third of
the elements at 256 points a side, no floor from their growth, but a theory shared with half-space
solvers. On a free surface the body
differs from the continuum within some cells only, where the elements do:

    K_free = K_continuum + (K_columns - K_cells),

with the coefficients of pressures uniform on cells (Love's on a half-space), and the same with all
periodic images. A layer on a rigid base that is thin against the patch needs no continuum.
"""

from __future__ import annotations

import math
from functools import lru_cache
from typing import Literal, Self

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from reference.arguments import choice_faults, refuse
from reference.contact.body import check_grid
from reference.elasticity import Material
from reference.fem.column_elements import ELEMENTS, Element
from reference.fem.columns import Layers, compliance
from reference.halfspace.operators import FreeOperator
from reference.layered.graded import Graded
from reference.layered.operators import OfBody, cell_modes, cell_modulus, is_local, uniform
from reference.layered.radial import Body, cell_coefficients
from reference.layered.stack import Stack, plane_modulus

Array = NDArray[np.float64]
Bottom = Literal["clamped", "impedance"]
BOTTOMS: tuple[Bottom, ...] = ("clamped", "impedance")

# Where a body without a base is clamped, in the longer period.
_DEPTH = 2.0
# Where a half-space's stiffness takes over, in the longer side of a cell: aliases of the longest
# waves have died away to exp(-50) there.
_SHALLOW = 8.0
# Slices of a graded body: the uppermost in cells, and each over the one above.
_FIRST, _SLICE = 0.05, 1.1
# Long sides of cells from one loaded cell to its image where elements and continuum are the same.
_APART = 64
# How far outside Hertz's circle the law of cells puts the rim, in cells: for nu = 0 and 1/2.
_RIM_EXCESS: dict[Element, tuple[float, float]] = {
    "linear": (0.007, 0.049),
    "splines": (-0.013, -0.002),
    "quadratic": (0.005, 0.016),
}
# What is kept of the last bodies: some of up to 1024 points a side, on 2048, in 40 MB.
_KEPT, _LARGEST = 4, 1.2e6
# Longer cells need more modes for that than there is use for them.
LONGEST = 100


class GridBody(OfBody):
    """What both bodies share: what they are made of, and the same again on other cells.

    Parameters
    ----------
    shape : (int, int)
        Number of cells (nx, ny).
    spacing : (float, float)
        Cell sides (dx, dy), consistent units.
    body : Material, Stack or Graded
        A half-space, layers, or a modulus that is a power of the depth.
    element : {"linear", "splines", "quadratic"}
        See `column_elements`.
    contact_compliance : float
        Depth per pressure by which shape and body may overlap, on top of all displacements: the
        penalty method, 1/eps.
    bottom : {"clamped", "impedance"}
        Of bodies with a half-space at their base.

    Raises
    ------
    ValueError
        For an unknown element or bottom; for an impedance without a half-space; if shape, spacing
        or modulus is not positive.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        body: Material | Body,
        element: Element = "splines",
        contact_compliance: float = 0.0,
        bottom: Bottom = "clamped",
    ) -> None:
        self.body: Body = Stack([], [], body) if isinstance(body, Material) else body
        check_grid(shape, spacing, plane_modulus(self.body.top))
        super().__init__(shape, spacing, cell_modulus(self.body, spacing))
        faults = choice_faults("element", element, ELEMENTS)
        faults += choice_faults("bottom", bottom, BOTTOMS)
        if bottom == "impedance" and not ends_uniform(self.body):
            faults.append("bottom must be clamped where no half-space of one modulus lies below")
        refuse([*faults, *self._cell_faults()])
        self.element, self.bottom = element, bottom
        compressible, incompressible = _RIM_EXCESS[element]
        ratio = self.body.top.poisson_ratio
        self.rim_excess = compressible + 2 * ratio * (incompressible - compressible)
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
        return type(self)(shape, spacing, self.body, self.element, total, self.bottom)

    def softened(self, compliance: float) -> Self:
        """Return the same body with more overlap per pressure (kept)."""
        return self.cached(("softened", compliance), lambda: self._softer(compliance))

    def _softer(self, compliance: float) -> Self:
        body = self._alike(self.shape, self.spacing, compliance)
        body._cache["elastic"] = self.elastic
        return body


class PeriodicBody(GridBody):
    """Finite elements below one period of a surface, zero mean displacement.

    Parameters
    ----------
    shape, spacing, body, element, contact_compliance, bottom
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
        return modes(self.shape, self.spacing, self.body, self.element, self.bottom)

    def _transfer(self) -> Array:
        return self.elastic + self.contact_compliance


class FreeBody(GridBody, FreeOperator):
    """Finite elements below a rectangle of cells, free around it.

    Parameters
    ----------
    shape, spacing, body, element, contact_compliance, bottom
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
        more = modes(period, self.spacing, self.body, self.element, self.bottom)
        local = is_local(self.body, self.shape, period, self.spacing)
        if not local:
            more -= cell_modes(self.body, period, self.spacing)
        nearby = fft.irfft2(more, period, workers=1)[:rows, :columns].copy()
        return nearby if local else cell_coefficients(self.body, self.shape, self.spacing) + nearby

    def _part(self, shape: tuple[int, int]) -> Self:
        part = self._alike(shape, self.spacing)
        part._cache["elastic"] = self.elastic[: shape[0], : shape[1]]
        return part


def ends_uniform(body: Body) -> bool:
    """Whether a half-space of one modulus lies below all layers.

    >>> ends_uniform(Stack([1.0], [Material(1.0, 0.3)]))  # on a rigid base
    False
    """
    return isinstance(body, Stack) and body.base is not None


def modes(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    body: Body,
    element: Element,
    bottom: Bottom,
) -> Array:
    """Compliance on the modes of `rfft2`, from an octant or a quarter of them; length/pressure.

    That of a uniform pressure is zero where no rigid base is, the datum of a periodic half-space.
    """
    small = (shape[0] // 2 + 1) * (shape[1] // 2 + 1) <= _LARGEST
    quarter = (_kept if small else _quarter)(shape, spacing, body, element, bottom)
    whole: Array = quarter[np.minimum(np.arange(shape[0]), shape[0] - np.arange(shape[0]))]
    return whole


def _quarter(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    body: Body,
    element: Element,
    bottom: Bottom,
) -> Array:
    rows, columns = shape[0] // 2 + 1, shape[1] // 2 + 1
    along, across = (
        2 * np.pi * np.arange(rows) / shape[0],
        2 * np.pi * np.arange(columns) / shape[1],
    )
    layers = _meshed(body, shape, spacing, bottom)
    if shape[0] == shape[1] and spacing[0] == spacing[1]:
        m, n = np.tril_indices(rows)
        quarter = np.empty((rows, columns))
        values = compliance((along[m], across[n]), spacing, layers, element=element)
        quarter[m, n] = quarter[n, m] = values
    else:
        quarter = compliance((along[:, None], across), spacing, layers, element=element)
    quarter[0, 0] = uniform(body)
    quarter.flags.writeable = False
    return quarter


# The next realisation, load or repetition of a solve on the same cells has no set-up.
_kept = lru_cache(maxsize=_KEPT)(_quarter)


def _meshed(
    body: Body, shape: tuple[int, int], spacing: tuple[float, float], bottom: Bottom
) -> Layers:
    """Return the layers of a body down to a rigid base or to a half-space."""
    depth = _DEPTH * max(n * step for n, step in zip(shape, spacing, strict=True))
    if isinstance(body, Graded):
        ratio = depth / (_FIRST * min(spacing))
        number = int(np.ceil(np.log(ratio) / np.log(_SLICE)))
        ends = np.append(0.0, depth * ratio ** -(np.arange(number, -1, -1.0) / number))
        return Layers(np.diff(ends).tolist(), body.slices(ends))
    if body.base is None:
        return Layers(body.thicknesses, body.materials)
    below = body.base if bottom == "impedance" else None
    thickness = depth if below is None else _SHALLOW * max(spacing)
    return Layers([*body.thicknesses, thickness], [*body.materials, body.base], below)
