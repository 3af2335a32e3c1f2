r"""Bodies of layers as operators for `reference.contact.press`, on a patch or on a period.

On a period, a wave of pressure is displaced by C(q): `modes`, `cell_modes`. On a patch, the
displacement by a point force, with M(q) = q C(q)/(q C(q) at short waves), is

    G(r) = S(r)/(pi E1 r),    S(r) = 1 + int_0^inf (M(x/r) - 1) J0(x) dx,

a function of log r without steps, from 1 near the force to E1/E of the base far away; integrated
over cells, it is the table of `cell_coefficients`.
"""

import math
from collections.abc import Callable
from functools import cache
from typing import Self, TypeGuard

import numpy as np
from scipy import fft
from scipy.interpolate import BarycentricInterpolator, CubicSpline
from scipy.special import j0, jn_zeros

from reference.arrays import Array
from reference.closed_form.numerics import gauss_rule
from reference.contact.body import ElasticBody
from reference.halfspace import kernels
from reference.halfspace.kernels import RIM_EXCESS, FreeOperator
from reference.layered.stack import PER_DECADE, Graded, Stack

Pair = tuple[float, float]
Body = Stack | Graded
Radial = Callable[[Array], Array]

# Thicknesses of layers on a rigid base beyond which nothing is displaced: exp(-0.74 x 32) = 5e-11
# for nu = 0.5, the slowest decay.
_RANGE = 32.0


def is_half_space(body: Body) -> TypeGuard[Stack]:
    """Whether a body is the same at all depths."""
    return isinstance(body, Stack) and not body.thicknesses and body.base is not None


def is_local(
    body: Body, shape: tuple[int, int], period: tuple[int, int], spacing: Pair
) -> TypeGuard[Stack]:
    """Whether nothing reaches from one end of a grid to the image of the other in a period."""
    if not isinstance(body, Stack) or body.base is not None:
        return False
    sides = zip(period, shape, spacing, strict=True)
    return all((m - n) * step >= _RANGE * body.total for m, n, step in sides)


def cell_modulus(body: Body, spacing: Pair) -> float:
    """Effective modulus of the half-space that gives way as much to waves of four cells."""
    if is_half_space(body):
        return body.top.effective_modulus
    q = np.pi / 2 / max(spacing)
    return float(2 / (q * body.compliance(q)))


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


class LayeredPeriodic(OfBody):
    """A layered body under periodic pressure; arguments as for `PeriodicOperator`.

    On a half-space the mean displacement is zero; on a rigid base it is that of the mean pressure.
    """

    periodic = True

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: Pair,
        body: Body,
        kernel: kernels.Kernel = "continuum",
    ) -> None:
        super().__init__(shape, spacing, cell_modulus(body, spacing))
        if kernel not in RIM_EXCESS:
            raise ValueError(f"kernel must be 'continuum' or 'cells', not {kernel!r}")
        self.body, self.kernel = body, kernel
        self.rim_excess = RIM_EXCESS[kernel]

    def _transfer(self) -> Array:
        if self.kernel == "cells":
            return cell_modes(self.body, self.shape, self.spacing)
        return modes(self.body, self.shape, self.spacing)

    def _alike(self, shape: tuple[int, int], spacing: Pair) -> Self:
        return type(self)(shape, spacing, self.body, self.kernel)


class LayeredFree(OfBody, FreeOperator):
    """A layered body under a rectangle of cells, free around it; arguments as for `FreeOperator`.

    Pressures are uniform on the cells, as on the half-space. Below a layer on a rigid base that is
    thin against the rectangle they are the band-limited function through the cells' values: rubber
    that is thinner than the cells is displaced by gradients of pressure, of which cells have none.
    """

    def __init__(self, shape: tuple[int, int], spacing: Pair, body: Body) -> None:
        super().__init__(shape, spacing, cell_modulus(body, spacing))
        self.body = body

    @property
    def bounded(self) -> bool:
        """Not so where pressure on a cell raises another one, as on rubber that is held below."""
        return bool(self.coefficients(self.shape).min() >= 0)

    @property
    def _local(self) -> bool:
        return is_local(self.body, self.shape, self._padded, self.spacing)

    def _transfer(self) -> Array:
        return modes(self.body, self._padded, self.spacing) if self._local else super()._transfer()

    def coefficients(self, shape: tuple[int, int]) -> Array:
        """Displacement per pressure at offsets from zero to less than `shape`."""

        def make() -> Array:
            if self._local:
                whole = fft.irfft2(self._transfer(), self._padded, workers=1)
                return whole[: self.shape[0], : self.shape[1]].copy()
            return cell_coefficients(self.body, self.shape, self.spacing)

        return self.cached("coefficients", make)[: shape[0], : shape[1]]

    def _alike(self, shape: tuple[int, int], spacing: Pair) -> Self:
        return type(self)(shape, spacing, self.body)


def uniform(body: Body) -> float:
    """Compliance of the zero mode: of a half-space zero, the datum of the periodic problem."""
    squeezed = body.squeezed if isinstance(body, Stack) else np.inf
    return squeezed if np.isfinite(squeezed) else 0.0


def modes(body: Body, shape: tuple[int, int], spacing: Pair) -> Array:
    """Transfer function for the band-limited pressure through the cells' values."""
    transfer = body.compliance(np.hypot(*kernels.wavenumbers(shape, spacing)))
    transfer[0, 0] = uniform(body)
    return transfer


def cell_modes(body: Body, shape: tuple[int, int], spacing: Pair) -> Array:
    """Transfer function for pressures uniform on cells, read at their centres: a sum of aliases.

    `kernels.periodic` has the same of the half-space. All aliases but the wave itself are functions
    of the wave without a singularity nearby, known everywhere from few Chebyshev points: 24 a side
    err by 1e-12. Along the short side of long cells the nearest aliases come close to the waves, by
    the ratio of the sides: the points needed grow with its root.
    """
    if is_half_space(body):
        return kernels.periodic(shape, spacing, body.top.effective_modulus, "cells")
    qx, qy = (np.abs(q.ravel()) for q in kernels.wavenumbers(shape, spacing))
    points, weights = [], []
    for step in spacing:
        number = math.ceil(24 * math.sqrt(max(spacing) / step))
        angles = np.pi * (np.arange(number) + 0.5) / number
        points.append(np.pi / step * (1 - np.cos(angles)) / 2)
        # of the interpolant; SciPy would find them in an order that it draws at random
        weights.append((-1.0) ** np.arange(number) * np.sin(angles))
    # the other aliases there, by a table of compliances (150 nodes per factor e err by 1e-11)
    kx, sinc_x = kernels.aliases(points[0], spacing[0])
    ky, sinc_y = kernels.aliases(points[1], spacing[1])
    logs = np.log(np.hypot(kx[:, :, None, None], ky))
    ends = logs.min() - 0.1, logs.max() + 0.1
    nodes = np.linspace(*ends, int(150 * (ends[1] - ends[0])) + 8)
    terms = np.exp(CubicSpline(nodes, np.log(body.compliance(np.exp(nodes))))(logs))
    middle = len(kx) // 2
    terms[middle, :, middle, :] = 0.0
    others = np.einsum("mi,minj,nj->ij", sinc_x, terms, sinc_y)
    along = BarycentricInterpolator(points[0], others, wi=weights[0])(qx)
    transfer: Array = BarycentricInterpolator(points[1], along.T, wi=weights[1])(qy).T
    # and the waves themselves
    waves = np.hypot(qx[:, None], qy)
    own = [np.sinc(q * step / (2 * np.pi)) for q, step in zip((qx, qy), spacing, strict=True)]
    waves[0, 0] = waves[-1, -1]
    transfer += body.compliance(waves) * own[0][:, None] * own[1]
    transfer[0, 0] = uniform(body)
    return transfer


def cell_coefficients(body: Body, shape: tuple[int, int], spacing: Pair) -> Array:
    """Displacement at cell centres under unit pressure on another, offsets from zero to `shape`.

    It is the integral of G over the cell: from three cells' sides on by Gauss points, of which far
    cells take fewer, and nearby by triangles from the force to one side, a distance Y away and X
    long,

        int_0^asinh(X/Y) I(Y cosh s)/cosh s ds,    I(R) = int_0^R G(r) r dr.

    Stacks on a rigid base lose digits where they are thin against the distances: their displacement
    decays there, as a difference of numbers that do not.
    """
    if isinstance(body, Stack) and not body.thicknesses:
        i, j = np.ix_(np.arange(shape[0]), np.arange(shape[1]))
        return kernels.love(i, j, spacing, body.top.effective_modulus)
    dx, dy = spacing
    largest = float(np.hypot(shape[0] * dx, shape[1] * dy)) + max(spacing)
    point: Radial
    disc: Radial
    if isinstance(body, Graded):  # powers of the distance
        k, factor = body.exponent, body.point_factor
        point, disc = lambda r: factor * r**-k, lambda r: factor * r ** (1 - k) / (1 - k)
    else:
        point, disc = _layered_force(body, 1e-4 * min(spacing), largest)
    x, y = np.broadcast_arrays(np.arange(shape[0])[:, None] * dx, np.arange(shape[1]) * dy)
    reach = np.maximum(x, y) / max(spacing)
    result = np.zeros(shape)

    def from_force(x: Array, y: Array, weight: float) -> Array:
        r = np.hypot(x, y)
        return weight * point(r) / r

    near, far = reach < 3.0, reach > 16.0
    for part, rule in ((~near & ~far, 8), (far, 4)):
        result[part] = kernels.over_cell(from_force, x[part], y[part], spacing, rule)

    def triangle(length: Array, distance: Array) -> Array:
        nodes, weights = gauss_rule(40)
        span = np.arcsinh(length / distance)
        total = np.zeros(length.shape)
        for node, weight in zip(nodes, weights, strict=True):
            cosh = np.cosh(span * (node + 1) / 2)
            total += weight * disc(distance * cosh) / cosh
        return total * span / 2

    # A cell is four rectangles from the force to its corners, odd in both coordinates, and a
    # rectangle two triangles.
    total = np.zeros(np.count_nonzero(near))
    for sign_x in (1, -1):
        for sign_y in (1, -1):
            right, upper = x[near] + sign_x * dx / 2, y[near] + sign_y * dy / 2
            wide, high = np.abs(right), np.abs(upper)
            corner = np.sign(right * upper) * (triangle(wide, high) + triangle(high, wide))
            total += sign_x * sign_y * corner
    result[near] = total
    return result


def _layered_force(body: Stack, smallest: float, largest: float) -> tuple[Radial, Radial]:
    """Return r G(r) and I(r) from a table of S(r) over log r, for distances in a range."""
    # below the range, far below the cells, the body is taken as its uppermost material
    scale = 1 / (np.pi * body.top.effective_modulus)
    smallest = min(smallest, 1e-3 * min(body.thicknesses))
    number = int(PER_DECADE * np.log10(1.1 * largest / smallest)) + 8
    logs = np.linspace(np.log(smallest), np.log(1.1 * largest), number)
    r = np.exp(logs)
    excess = body.softening(1e-13 / r[-1], 1e3 / body.thicknesses[0])
    x, weights = _bessel_rule()
    values = np.array([1 + weights @ excess(x / radius) for radius in r]) * scale
    table = CubicSpline(logs, values)
    within = CubicSpline(logs, values * r).antiderivative()
    # S begins as a straight line
    start = smallest * (scale + values[0]) / 2

    def disc(radius: Array) -> Array:
        inside = start + within(np.log(np.maximum(radius, smallest)))
        return np.where(radius < smallest, scale * radius, inside)

    return lambda radius: table(np.log(radius)), disc


@cache
def _bessel_rule() -> tuple[Array, Array]:
    """Points and weights of int_0^inf f(x) J0(x) dx, for smooth f that need not decay.

    Ten Gauss points a panel: 46 panels below the first zero of J0, each half of the next, as f may
    vary anywhere, then the first zeros, and as an alternating sum between the next 28, by Euler's
    averages.
    """
    averaged = 28
    zeros = jn_zeros(0, 16 + averaged)
    first = zeros[0] * 0.5 ** np.arange(46, -1, -1.0)
    ends = np.concatenate([[0.0], first, zeros[1:]])
    nodes, weights = gauss_rule(10)
    middle, half = (ends[1:] + ends[:-1]) / 2, np.diff(ends) / 2
    x = middle[:, None] + half[:, None] * nodes
    whole = half[:, None] * weights * j0(x)
    share = np.ones(len(middle))
    odds = np.cumprod([1.0] + [(averaged - i) / (i + 1) for i in range(averaged)])
    share[-averaged:] = 1 - np.cumsum(odds)[:-1] / 2.0**averaged
    return x.ravel(), (whole * share[:, None]).ravel()
