"""Bodies of layers as operators for the solvers of `halfspace.fft`, on a patch or on a period."""

from __future__ import annotations

import math
from typing import Self, TypeGuard

import numpy as np
from numpy.typing import NDArray
from scipy import fft
from scipy.interpolate import BarycentricInterpolator, CubicSpline

from reference.contact.body import ElasticBody
from reference.halfspace import kernels
from reference.halfspace.operators import RIM_EXCESS, FreeOperator
from reference.layered.radial import Body, cell_coefficients
from reference.layered.stack import Stack, plane_modulus

Array = NDArray[np.float64]

# Thicknesses of layers on a rigid base beyond which nothing is displaced: exp(-0.74 x 32) = 5e-11
# for nu = 0.5, the slowest decay.
_RANGE = 32.0
# Nodes per factor e of the table of compliances: cubic splines err by 1e-11.
_PER_UNIT = 150
_NODES = 24


class OfBody(ElasticBody):
    """What operators of layered bodies share."""

    body: Body

    def wave_stiffness(self, wavenumber: Array) -> Array:
        """Return pressure over displacement of waves, in units of `effective_modulus`/2."""
        if is_half_space(self.body):
            return wavenumber
        with np.errstate(divide="ignore", invalid="ignore"):
            stiffness = 2 / (self.effective_modulus * self.body.compliance(wavenumber))
        return np.where(wavenumber > 0, stiffness, 0.0)


def cell_modulus(body: Body, spacing: tuple[float, float]) -> float:
    """Effective modulus of the half-space that gives way as much to waves of four cells."""
    if is_half_space(body):
        return plane_modulus(body.top)
    return float(body.modulus(np.pi / 2 / max(spacing)))


def is_half_space(body: Body) -> TypeGuard[Stack]:
    """Whether a body is the same at all depths."""
    return isinstance(body, Stack) and not body.thicknesses and body.base is not None


def is_local(
    body: Body, shape: tuple[int, int], period: tuple[int, int], spacing: tuple[float, float]
) -> TypeGuard[Stack]:
    """Whether nothing reaches from one end of a grid to the image of the other in a period."""
    if not isinstance(body, Stack) or body.base is not None:
        return False
    sides = zip(period, shape, spacing, strict=True)
    return all((m - n) * step >= _RANGE * body.total for m, n, step in sides)


class LayeredPeriodic(OfBody):
    """A layered body under periodic pressure.

    Parameters
    ----------
    shape, spacing
        As for `PeriodicOperator`.
    body : Stack or Graded
    kernel : {"continuum", "cells"}
        As for `PeriodicOperator`.

    On a half-space the mean displacement is zero; on a rigid base it is that of the mean pressure.

    Examples
    --------
    >>> from reference.elasticity import Material
    >>> steel = Material(1 - 0.3**2, 0.3)
    >>> x = np.arange(16) / 16
    >>> p = np.broadcast_to(np.cos(2 * np.pi * x)[:, None], (16, 16))
    >>> body = LayeredPeriodic((16, 16), (1 / 16, 1 / 16), Stack([0.1], [steel], steel))
    >>> bool(np.allclose(body.apply(p), p / np.pi))
    True
    """

    periodic = True

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        body: Body,
        kernel: kernels.Kernel = "continuum",
    ) -> None:
        super().__init__(shape, spacing, cell_modulus(body, spacing))
        if kernel not in RIM_EXCESS:
            raise ValueError(f"kernel must be 'continuum' or 'cells', not {kernel!r}")
        self.body, self.kernel = body, kernel
        self.rim_excess = RIM_EXCESS[kernel]
        self._padded = self.shape

    def _transfer(self) -> Array:
        if self.kernel == "cells":
            return cell_modes(self.body, self.shape, self.spacing)
        return modes(self.body, self.shape, self.spacing)

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        return type(self)(shape, spacing, self.body, self.kernel)


class LayeredFree(OfBody, FreeOperator):
    """A layered body under a rectangle of cells, free around it.

    Pressures are uniform on the cells, as on the half-space. Below a layer on a rigid base that is
    thin against the rectangle they are the band-limited function through the cells' values: rubber
    that is thinner than the cells is displaced by gradients of pressure, of which cells have none.

    Parameters
    ----------
    shape, spacing
        As for `FreeOperator`.
    body : Stack or Graded

    Examples
    --------
    >>> from reference.elasticity import Material
    >>> steel = Material(1 - 0.3**2, 0.3)
    >>> layered = LayeredFree((9, 9), (1.0, 1.0), Stack([0.1], [steel], steel))
    >>> plain = FreeOperator((9, 9), (1.0, 1.0), 1.0)
    >>> bool(np.allclose(layered.coefficients((9, 9)), plain.coefficients((9, 9)), rtol=1e-9))
    True
    """

    def __init__(self, shape: tuple[int, int], spacing: tuple[float, float], body: Body) -> None:
        super().__init__(shape, spacing, cell_modulus(body, spacing))
        self.body = body

    @property
    def lifts(self) -> bool:
        """Whether pressure on a cell raises another one, as on rubber that is held below."""
        return bool(self.coefficients(self.shape).min() < 0)

    @property
    def _local(self) -> bool:
        return is_local(self.body, self.shape, self._padded, self.spacing)

    def _transfer(self) -> Array:
        return modes(self.body, self._padded, self.spacing) if self._local else super()._transfer()

    def coefficients(self, shape: tuple[int, int]) -> Array:
        """Displacement per pressure at offsets from zero to less than `shape`."""
        coefficients: Array = self.cached("coefficients", self._coefficients)
        return coefficients[: shape[0], : shape[1]]

    def _coefficients(self) -> Array:
        if self._local:
            whole = fft.irfft2(self._transfer(), self._padded, workers=1)
            return whole[: self.shape[0], : self.shape[1]].copy()
        return cell_coefficients(self.body, self.shape, self.spacing)

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        return type(self)(shape, spacing, self.body)


def uniform(body: Body) -> float:
    """Compliance of the zero mode: of a half-space zero, the datum of the periodic problem."""
    squeezed = body.squeezed if isinstance(body, Stack) else np.inf
    return squeezed if np.isfinite(squeezed) else 0.0


def modes(body: Body, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Transfer function for the band-limited pressure through the cells' values."""
    transfer = body.compliance(np.hypot(*kernels.wavenumbers(shape, spacing)))
    transfer[0, 0] = uniform(body)
    return transfer


def cell_modes(body: Body, shape: tuple[int, int], spacing: tuple[float, float]) -> Array:
    """Transfer function for pressures uniform on cells, read at their centres: a sum of aliases.

    `kernels.periodic` has the same of the half-space. All aliases but the wave itself are functions
    of the wave without a singularity nearby, known everywhere from few points (`_NODES` Chebyshev
    points a side err by 1e-12).
    """
    if is_half_space(body):
        return kernels.periodic(shape, spacing, plane_modulus(body.top), "cells")
    qx, qy = (np.abs(q.ravel()) for q in kernels.wavenumbers(shape, spacing))
    zone = np.pi / spacing[0], np.pi / spacing[1]
    points = [_chebyshev(end, max(spacing) / step) for end, step in zip(zone, spacing, strict=True)]
    others = _other_aliases(body, points[0], points[1], spacing)
    along = BarycentricInterpolator(points[0], others)(qx)
    transfer: Array = BarycentricInterpolator(points[1], along.T)(qy).T
    waves = np.hypot(qx[:, None], qy)
    own = [np.sinc(q * step / (2 * np.pi)) for q, step in zip((qx, qy), spacing, strict=True)]
    waves[0, 0] = waves[-1, -1]
    transfer += body.compliance(waves) * own[0][:, None] * own[1]
    transfer[0, 0] = uniform(body)
    return transfer


def _chebyshev(end: float, ratio: float) -> Array:
    """Return Chebyshev points from zero to an end.

    Along the short side of long cells the nearest aliases come close to the waves, by the ratio of
    the sides: the points needed grow with its root.
    """
    number = math.ceil(_NODES * math.sqrt(ratio))
    return end * (1 - np.cos(np.pi * (np.arange(number) + 0.5) / number)) / 2


def _other_aliases(body: Body, qx: Array, qy: Array, spacing: tuple[float, float]) -> Array:
    """Sum of all aliases of the waves (qx, qy), without the waves themselves."""
    kx, sinc_x = kernels.aliases(qx, spacing[0])
    ky, sinc_y = kernels.aliases(qy, spacing[1])
    waves = np.hypot(kx[:, :, None, None], ky)
    logs = np.log(waves)
    ends = logs.min() - 0.1, logs.max() + 0.1
    nodes = np.linspace(*ends, int(_PER_UNIT * (ends[1] - ends[0])) + 8)
    table = CubicSpline(nodes, np.log(body.compliance(np.exp(nodes))))
    terms = np.exp(table(logs))
    middle = len(kx) // 2
    terms[middle, :, middle, :] = 0.0
    return np.einsum("mi,minj,nj->ij", sinc_x, terms, sinc_y)
