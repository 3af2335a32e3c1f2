"""The elastic half-space under pressure on rectangular cells: free around the grid, or periodic.

Love's influence coefficients on the free half-space, accurate at any distance, and the transfer
functions of the half-space under periodic pressure. All lengths and moduli are in consistent units;
u is positive into the half-space.
"""

from collections.abc import Callable
from typing import Literal, Self

import numpy as np
from numba import njit
from numpy.typing import ArrayLike
from scipy import fft
from scipy.special import erfc

from reference.arrays import Array
from reference.closed_form.numerics import gauss_rule
from reference.contact import pieces
from reference.contact.body import LARGEST_KEPT, ElasticBody, quarter, wavenumbers, window

Kernel = Literal["continuum", "cells"]

# Beyond this many sides of the cell 4 x 4 Gauss points integrate 1/r to 1e-14, while the closed
# form loses a digit for every factor of ten in distance; at the limit both are accurate to 1e-14.
FAR = 16.0

# Window of the alternating alias sum: terms to |m| = 24, smoothly windowed; the remainder is below
# 1e-11.
_ALIASES = 24


def love(
    i: ArrayLike, j: ArrayLike, spacing: tuple[float, float], effective_modulus: float
) -> Array:
    r"""Return the displacement at a cell centre under unit pressure on another cell (Love 1929).

    With the edges a, b = (i +- 1/2) dx and c, d = (j +- 1/2) dy of the loaded cell,

        pi E* K = a ln[(c + sqrt(a^2+c^2)) / (d + sqrt(a^2+d^2))]
                + b ln[(d + sqrt(b^2+d^2)) / (c + sqrt(b^2+c^2))]
                + c ln[(a + sqrt(a^2+c^2)) / (b + sqrt(b^2+c^2))]
                + d ln[(b + sqrt(b^2+d^2)) / (a + sqrt(a^2+d^2))],

    A. E. H. Love, Phil. Trans. R. Soc. A 228 (1929) 377; K. L. Johnson, Contact Mechanics (1985),
    eq. (3.25); the chapter's (19.3), which is misprinted (docs/half-space.md). Relative error below
    1e-12 at any distance for aspect ratios of the cell up to 1:100 (tested against 50 digits): the
    logarithms are log1p of rationalised ratios, and beyond 16 cell sides 4 x 4 Gauss points
    integrate 1/r.

    Offsets i, j are in cells, broadcast, of either sign. Fractions give points between the
    centres.

    >>> own = love(0, 0, (1.0, 1.0), 1.0)
    >>> bool(np.isclose(own, 4 * np.log(1 + np.sqrt(2)) / np.pi, rtol=1e-15))
    True
    """
    dx, dy = spacing
    x = np.abs(np.asarray(i, dtype=float)) * dx
    y = np.abs(np.asarray(j, dtype=float)) * dy
    x, y = np.broadcast_arrays(x, y)
    far = np.maximum(x, y) > FAR * max(dx, dy)
    integral = np.empty(x.shape)
    integral[far] = over_cell(
        lambda x, y, weight: weight / np.sqrt(x**2 + y**2), x[far], y[far], spacing
    )
    x, y = x[~far], y[~far]
    integral[~far] = across_integral(x, y, dx, dy) + across_integral(y, x, dy, dx)
    return integral / (np.pi * effective_modulus)


def over_cell(
    integrand: Callable[[Array, Array, float], Array],
    x: Array,
    y: Array,
    spacing: tuple[float, float],
    points: int = 4,
) -> Array:
    """Return the integral over cells centred at x, y by Gauss points, so many a side.

    ``integrand(x, y, weight)`` is the function times the weight of the point.
    """
    nodes, weights = gauss_rule(points)
    total = np.zeros(())
    for node_x, weight_x in zip(nodes, weights, strict=True):
        for node_y, weight_y in zip(nodes, weights, strict=True):
            at = x + node_x * spacing[0] / 2, y + node_y * spacing[1] / 2
            total = total + integrand(*at, weight_x * weight_y)
    return total * (spacing[0] * spacing[1] / 4)


def across_integral(x: Array, y: Array, dx: float, dy: float) -> Array:
    """Return the integral of y^2/r^3 over the cell, for x, y >= 0, one of two parts of 1/r."""
    a, b, c, d = x + dx / 2, x - dx / 2, y + dy / 2, y - dy / 2
    return a * _log_ratio(a, c, d, dy, y) - b * _log_ratio(b, c, d, dy, y)


def _log_ratio(across: Array, upper: Array, lower: Array, side: float, centre: Array) -> Array:
    """Return ln[(upper + hypot(upper, across))/(lower + hypot(lower, across))] to full accuracy.

    upper - lower = side and upper + lower = 2 centre are arguments because they are known exactly.
    """
    far_root, near_root = np.hypot(upper, across), np.hypot(lower, across)
    # lower is negative only in the row of the loaded cell: there the denominator is rationalised
    least = 1e-290 * side  # on an edge, across = 0, the ratio is infinite, and counts zero times
    rationalised = across**2 / np.maximum(near_root + np.abs(lower), least)
    below = np.maximum(np.where(lower >= 0, lower + near_root, rationalised), least)
    return np.log1p(side * (1 + 2 * centre / (far_root + near_root)) / below)


def whole(values: Array, rows: int) -> Array:
    """Return a function even in q_x on the modes of `rfft2`, from those of q_x >= 0."""
    return values[np.minimum(np.arange(rows), rows - np.arange(rows))]


def periodic(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    effective_modulus: float,
    kernel: Kernel = "continuum",
) -> Array:
    r"""Return T of the periodic half-space, u^(q) = T(q) p^(q), on the modes of `rfft2`.

    ``"continuum"``: T = 2/(E*|q|) (Johnson 1985, ch. 13): the pressure is the band-limited
    function through the cell values. ``"cells"``: Love's cells summed over all periodic images,
    T = sum over G of 2/(E*|q+G|) sinc((q+G)_x dx/2) sinc((q+G)_y dy/2), with G running over the
    aliases (2 pi m/dx, 2 pi n/dy). The sum alternates and is smoothly windowed at |m| = 24, with a
    relative error below 1e-10.

    The q = 0 term is zero in both: the displacement has zero mean, the datum of the periodic
    problem.

    Returns
    -------
    ndarray, shape (nx, ny//2 + 1)

    Examples
    --------
    >>> T = periodic((8, 8), (1.0, 1.0), 2.0)
    >>> float(round(T[1, 0] * 2 * 3.141592653589793 / 8, 12)), float(T[0, 0])
    (1.0, 0.0)
    """
    return whole(periodic_quarter(shape, spacing, effective_modulus, kernel), shape[0])


def periodic_quarter(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    effective_modulus: float,
    kernel: Kernel = "continuum",
) -> Array:
    """Return `periodic` for q_x, q_y >= 0, of shape (nx//2 + 1, ny//2 + 1)."""
    if kernel == "cells":
        transfer = _alias_sum(shape, spacing)
    elif kernel == "continuum":
        transfer = quarter(shape, spacing)
        with np.errstate(divide="ignore"):
            np.divide(1, transfer, out=transfer)
    else:
        raise ValueError(f"kernel must be 'continuum' or 'cells', not {kernel!r}")
    transfer[0, 0] = 0.0
    transfer *= 2 / effective_modulus
    return transfer


def _alias_sum(
    shape: tuple[int, int], spacing: tuple[float, float], *, energy: bool = False
) -> Array:
    """Return the sum of sinc sinc/|q + G| over the aliases, as of `aliases`; q_x, q_y >= 0."""
    qx, qy = wavenumbers(shape, spacing)
    kx, sinc_x = aliases(qx.ravel()[: shape[0] // 2 + 1], spacing[0], energy=energy)
    ky, sinc_y = aliases(qy.ravel(), spacing[1], energy=energy)
    return np.asarray(_sum_modes(kx, sinc_x, ky, sinc_y))


def aliases(wavenumber: Array, step: float, *, energy: bool = False) -> tuple[Array, Array]:
    """Return the aliases of waves along one side of the cells, and their windowed sincs.

    Both are of shape (aliases, waves), the waves themselves in the middle. For energies the sincs
    are squared, which do not alternate, and not windowed.
    """
    orders = np.arange(-_ALIASES, _ALIASES + 1)[:, None]
    window = 0.5 * erfc((np.abs(orders) - _ALIASES / 2) / (0.5 * np.sqrt(_ALIASES)))
    k = wavenumber[None, :] + 2 * np.pi * orders / step
    sinc = np.sinc(k * step / (2 * np.pi))
    return k, sinc**2 if energy else window * sinc


def cell_energies(
    shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
) -> tuple[Array, Array]:
    r"""Return the transfer function of <p, K p> for pressures uniform on cells, and its remainder.

    For one mode of cell values the pressure has all aliases q + G, reduced by the two sincs, so
    that the mean of p K p over a cell has T = sum over G of 2/(E*|q+G|) sinc((q+G)_x dx/2)^2
    sinc((q+G)_y dy/2)^2. All terms are positive; those beyond |m| = 24 in either direction are
    bounded: with s^2 = sin(q_x dx/2)^2 the sum of the squared sincs over |m| > M is at most 2
    s^2/(pi^2 (M - 1/2)), over all n it is one, and 1/|q+G| at most dx/(2 pi (M + 1/2)).

    Returns
    -------
    transfer, remainder : ndarray, shape (nx, ny//2 + 1)
        The exact sum is between the first and the sum of both. Zero at q = 0.
    """
    qx, qy = wavenumbers(shape, spacing)
    transfer = whole(_alias_sum(shape, spacing, energy=True), shape[0])
    along, across = (np.sin(q * step / 2) ** 2 for q, step in zip((qx, qy), spacing, strict=True))
    beyond = np.pi**-3 / (_ALIASES - 0.5) / (_ALIASES + 0.5)
    remainder = beyond * (along * spacing[0] + across * spacing[1])
    transfer[0, 0] = remainder[0, 0] = 0.0
    return transfer * (2 / effective_modulus), remainder * (2 / effective_modulus)


@njit(cache=True, error_model="numpy")
def _sum_modes(kx, sinc_x, ky, sinc_y):
    """Sum the products over all pairs of aliases; the mode q = 0 is infinite."""
    total = np.zeros((kx.shape[1], ky.shape[1]))
    for i in range(kx.shape[1]):
        for m in range(kx.shape[0]):
            square, factor = kx[m, i] ** 2, sinc_x[m, i]
            for n in range(ky.shape[0]):
                for j in range(ky.shape[1]):
                    total[i, j] += factor * sinc_y[n, j] / np.sqrt(square + ky[n, j] ** 2)
    return total


# The rim of pressures through the cells' values lies further out than that of uniform ones.
RIM_EXCESS: dict[str, float] = {"continuum": 0.016, "cells": 0.0}
# Arrays that Love's formula needs beside its result.
_TEMPORARIES = 16


class FreeOperator(ElasticBody):
    """Free half-space under a rectangle of cells with uniform pressure: u = K p, (19.2).

    The sum over cells is an exact linear convolution with Love's coefficients (`love`),
    by real FFTs on a zero-padded grid, without periodic images.

    Of cells (nx, ny) of sides (dx, dy), and E*, in consistent units.

    >>> K = FreeOperator((3, 3), (1.0, 1.0), 1.0)
    >>> u = K.apply(np.ones((3, 3)))
    >>> bool(np.isclose(u[1, 1], 3 * 4 * np.log(1 + np.sqrt(2)) / np.pi))
    True
    """

    periodic = False

    @property
    def bounded(self) -> bool:
        """Whether contact lies where g < d: on the half-space pressure lifts no cell, u >= 0."""
        return True

    def __init__(
        self, shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
    ) -> None:
        super().__init__(shape, spacing, effective_modulus)
        # an even number of cells, so that the kernel's transform is one of cosines
        self._padded = tuple(2 * fft.next_fast_len(n, real=True) for n in self.shape)

    def coefficients(self, shape: tuple[int, int]) -> Array:
        """Love's coefficients at offsets from zero to less than `shape`; (19.3)."""
        coefficients = self._cache.get("coefficients")
        if coefficients is None or any(
            n > k for n, k in zip(shape, coefficients.shape, strict=True)
        ):
            # more than needed, as the next window of a sweep may be larger
            size = tuple(min(n, max(64, k)) for n, k in zip(self.shape, shape, strict=True))
            coefficients = np.empty(size)

            def fill(part: slice) -> None:  # some rows at a time
                i, j = np.ix_(np.arange(part.start, part.stop), np.arange(size[1]))
                coefficients[part] = love(i, j, self.spacing, self.effective_modulus)

            pieces.over(size[0], pieces.rows_of(_TEMPORARIES * size[1]), fill)
            self._cache["coefficients"] = coefficients
        return coefficients[: shape[0], : shape[1]]

    def _transfer(self) -> Array:
        """Return the transform of the even kernel, by cosines; unused offsets are zero."""
        kernel = np.zeros([n // 2 + 1 for n in self._padded])
        kept = "coefficients" in self._cache
        kernel[: self.shape[0], : self.shape[1]] = self.coefficients(self.shape)
        if not kept and kernel.size > LARGEST_KEPT:
            self._cache.pop("coefficients", None)  # no window has asked for them
        for axis in (0, 1):
            kernel = fft.dct(kernel, type=1, axis=axis, overwrite_x=True, workers=1)
        return kernel

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        return type(self)(shape, spacing, self.effective_modulus)

    def restrict(self, shape: tuple[int, int]) -> Self:
        """Return the operator of the same body on a smaller rectangle of cells (cached)."""
        parts: dict[tuple[int, int], Self] = self.cached("restricted", dict)
        return window(parts, shape, self._part)

    def _part(self, shape: tuple[int, int]) -> Self:
        part = self._alike(shape, self.spacing)
        part._cache["coefficients"] = self.coefficients(shape)
        return part


class PeriodicOperator(ElasticBody):
    """Half-space under periodic pressure with zero mean displacement: u^(q) = T(q) p^(q).

    The period is (nx dx, ny dy). With the kernel "continuum" T = 2/(E*|q|), with "cells" the
    same for pressures uniform on cells: see `periodic`.
    """

    periodic = True

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        effective_modulus: float,
        kernel: Kernel = "continuum",
    ) -> None:
        super().__init__(shape, spacing, effective_modulus)
        self.kernel = kernel
        self.rim_excess = RIM_EXCESS.get(kernel, 0.0)
        _ = self.unit  # raises for an unknown kernel

    def _transfer(self) -> Array:
        grid = self.shape, self.spacing
        return periodic_quarter(*grid, self.effective_modulus, self.kernel)

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        return type(self)(shape, spacing, self.effective_modulus, self.kernel)
