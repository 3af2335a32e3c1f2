r"""Finite elements on a grid that repeats: the surface's compliance, one wave vector at a time.

A mesh of equal cells in x and y, graded in depth, has a stiffness matrix that is the same for every
cell. A displacement of one wave vector q = (theta_x/dx, theta_y/dy),

    u(node) = U_k exp(i (theta_x m + theta_y n)),

therefore stays one of that wave vector, and all that is left of the problem is a column: three
components at each depth. Eliminated from below it gives the displacement of the surface under a
pressure of that wave vector, C(q). It is the finite-element answer, not an approximation of it; the
contact problem costs no more than an FFT.

With i u_x, i u_y in place of u_x, u_y (the tangential motion is a quarter of a wave ahead) all
numbers are real. In depth the elements are quadratic.

Volume changes are taken as the pressures of a mixed method, which are linear in the depth of an
element and jump to the next: nothing locks, and nu = 0.5 is a material like any other. The mean
pressure p of an element and its slope obey

    r div u - s p = 0,    r = lambda/(|lambda| + mu),    s = mu/(|lambda| + mu),

in units of mu, which is regular from lambda = 0 to infinity.

In x and y the elements are one of three kinds,

``"linear"``
    bilinear, with pressures constant in x and y;
``"splines"``
    quadratic B-splines, with bilinear pressures;
``"quadratic"``
    hexahedra of 27 nodes, with pressures that are linear in each (Hex2: Q2/P1, inf-sup stable).

The nodes of the first two stand in the middles of the cells of a contact solver, the elements of
the third are these cells. Their integrals are sums over all cells with the phases of a wave, each
class of nodes with those of its own places. They are even but for a complex conjugate, so that
integrals of two values, of two slopes and, over i, of a value and a slope are real. So are those of
pressures that are odd in a cell, if i is taken into them. The columns are eliminated from below
without pivoting: what is left of the displacements is positive definite where the top is held, and
pressures have one sign. The equation of a pressure is scaled by the root of |r|, which makes the
matrix symmetric.

Forces are those of pressures uniform on the cells; displacements are read at their centres.
"""

from __future__ import annotations

from dataclasses import replace
from typing import Literal, NamedTuple

import numpy as np
from numba import njit

from reference.arrays import Array, Indices
from reference.elasticity import Material
from reference.errors import choice_faults, positive_faults, refuse
from reference.layered.stack import Stack

Element = Literal["linear", "splines", "quadratic"]
ELEMENTS: tuple[Element, ...] = ("linear", "splines", "quadratic")


# Deeper than this many wavelengths over 2 pi nothing reaches the surface: 1e-13 of the compliance;
# of waves of two cells on "linear" and "splines", which are stiff there at nu = 0.5, 4e-6.
_REACH = 30.0
# Wave vectors that are taken at once: 0.1 GB of column matrices; of these, a group is eliminated
# side by side, by vector instructions.
_AT_ONCE, _GROUP = 16384, 16
# Thickness of the uppermost elements over the cells' smaller side, and its growth with depth.
_FIRST, _GROWTH = 0.35, 1.25


# Quadratic shape functions on a unit interval, nodes at 0, 1/2, 1: mass, stiffness, and the
# integrals of a function (row) and a slope (column). Pressures: 1 and 2 z - 1.
MASS = np.array([[4.0, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30
STIFFNESS = np.array([[7.0, -8, 1], [-8, 16, -8], [1, -8, 7]]) / 3
MIXED = np.array([[-3.0, 4, -1], [-4, 0, 4], [1, -4, 3]]) / 6
PRESSED = np.array([[1.0, 4, 1], [-1, 0, 1]]) / 6
PRESSED_SLOPE = np.array([[-3.0, 0, 3], [2, -4, 2]]) / 3
PRESSURES = np.array([1.0, 1 / 3])

# Gauss points on the unit interval, exact to rounding for half a wave, and the functions there.
_PLACES, _WEIGHTS = (part / 2 for part in np.polynomial.legendre.leggauss(12))
_PLACES = _PLACES + 0.5
_SHAPES = np.array(
    [(1 - _PLACES) * (1 - 2 * _PLACES), 4 * _PLACES * (1 - _PLACES), _PLACES * (2 * _PLACES - 1)]
)

# A wave whose pressures do not act on the displacements at all, as two cells long: they are left
# out.
_MUTE = 1e-12


class Symbols(NamedTuple):
    """Integrals over a cell in one direction, for waves of phase theta from cell to cell."""

    mass: Array  # (waves, classes, classes), of two shape functions
    stiffness: Array  # of their slopes, times h^2
    mixed: Array  # of one and the other's slope, times h and over i
    value: Array  # (waves, pressures, classes), of a pressure and a shape function
    slope: Array  # and its slope, times h and over i
    pressure: Array  # (waves, pressures), of two pressures
    force: Array  # (waves, classes), of a shape function over the cell of a contact solver
    point: Array  # its value at the cell's centre
    wave: Array  # of it and the wave itself

    @classmethod
    def of(cls, element: Element, theta: Array) -> Symbols:
        """Return the symbols of an element; classes are corners and middles of "quadratic"."""
        cos, half = np.cos(theta), theta / 2
        if element == "linear":  # hat functions: exact integrals of piecewise polynomials
            ones = np.ones_like(theta)
            pairs = [(2 + cos) / 3, 4 * np.sin(half) ** 2, np.sin(theta)]
            pairs += [np.cos(half), 2 * np.sin(half)]
            single = [ones, (3 + cos) / 4, ones, np.sinc(theta / (2 * np.pi)) ** 2]
        elif element == "splines":  # their integrals are B-splines of higher degree, at numbers
            hats = (2 + cos) / 3
            pairs = [
                (33 + 26 * cos + np.cos(2 * theta)) / 60,
                4 * np.sin(half) ** 2 * hats,
                (10 * np.sin(theta) + np.sin(2 * theta)) / 12,
                (11 * np.cos(half) + np.cos(3 * half)) / 12,
                2 * np.sin(half) * hats,
            ]
            single = [hats, hats, (3 + cos) / 4, np.sinc(theta / (2 * np.pi)) ** 3]
        else:  # the nodes of an element at 0, 1/2, 1 by those of its class
            nodes = np.zeros((theta.size, 3, 2), dtype=complex)
            nodes[:, 0, 0], nodes[:, 2, 0] = np.exp(-0.5j * theta), np.exp(0.5j * theta)
            nodes[:, 1, 1] = 1.0
            conjugate = nodes.conj().transpose(0, 2, 1)
            odd = np.array([[1.0], [-1j]])  # conjugate of what is taken into odd pressures
            along = np.exp(1j * theta[:, None] * (_PLACES - 0.5)) * _WEIGHTS
            return cls(
                mass=(conjugate @ MASS @ nodes).real,
                stiffness=(conjugate @ STIFFNESS @ nodes).real,
                mixed=(conjugate @ MIXED @ nodes).imag,
                value=(odd * PRESSED @ nodes).real,
                slope=(odd * PRESSED_SLOPE @ nodes).imag,
                pressure=np.broadcast_to(PRESSURES, (theta.size, 2)),
                force=(PRESSED[0] @ nodes).real,
                point=np.broadcast_to([0.0, 1.0], (theta.size, 2)),
                wave=(conjugate @ (along @ _SHAPES.T)[:, :, None]).real[:, :, 0],
            )
        return cls(*(part[:, None, None] for part in pairs), *(part[:, None] for part in single))


# Degrees in x, y and depth of the pressures of an element.
_UNIFORM = (0, 0, 0), (0, 0, 1)
_PRESSURE_DEGREES: dict[Element, tuple[tuple[int, int, int], ...]] = {
    "linear": _UNIFORM,
    "splines": _UNIFORM,
    "quadratic": ((0, 0, 0), (1, 0, 0), (0, 1, 0), (0, 0, 1)),
}


class WaveIntegrals(NamedTuple):
    """Products of the symbols of both directions, per area of the surface; the waves come last."""

    # displacements: mass; stiffness along x and y; both slopes; one slope, in x and in y
    moves: Array  # (6, nodes, nodes, waves)
    volumes: Array  # (3, pressures, nodes, waves): pressures and slopes along x and y, and values
    stored: Array  # (pressures, waves): two pressures
    mute: Array  # (pressures, waves): 1 for pressures that act on nothing
    degrees: Indices  # (pressures,), in depth
    force: Array  # (nodes, waves): of a pressure on the cell
    point: Array  # at its centre
    wave: Array  # of the wave


def in_plane(
    element: Element, along: Array, across: Array, sides: tuple[float, float]
) -> WaveIntegrals:
    """Return the integrals in x and y for waves of given phases."""
    dx, dy = sides
    x, y = Symbols.of(element, along), Symbols.of(element, across)

    def pairs(first: Array, second: Array) -> Array:
        size = first.shape[1] * second.shape[1]
        return np.einsum("wij,wkl->wikjl", first, second).reshape(len(first), size, size)

    def both(first: Array, second: Array) -> Array:
        product = first[:, :, :, None] * second[:, :, None, :]
        return product.reshape(*product.shape[:2], -1)

    moves = [
        pairs(x.mass, y.mass),
        pairs(x.stiffness, y.mass) / dx**2,
        pairs(x.mass, y.stiffness) / dy**2,
        pairs(x.mixed, y.mixed) / (dx * dy),
        pairs(x.mixed, y.mass) / dx,
        pairs(x.mass, y.mixed) / dy,
    ]
    i, j, degrees = np.array(_PRESSURE_DEGREES[element]).T
    volumes = np.array(
        [
            both(x.slope[:, i], y.value[:, j]) / dx,
            both(x.value[:, i], y.slope[:, j]) / dy,
            both(x.value[:, i], y.value[:, j]),
        ]
    )
    mute = (np.abs(volumes).sum(axis=(0, 3)) < _MUTE).T
    volumes = volumes.transpose(0, 2, 3, 1)
    volumes[:, mute.nonzero()[0], :, mute.nonzero()[1]] = 0.0
    stored = (x.pressure[:, i] * y.pressure[:, j]).T
    return WaveIntegrals(
        np.ascontiguousarray(np.array(moves).transpose(0, 2, 3, 1)),
        np.ascontiguousarray(volumes),
        np.ascontiguousarray(np.where(mute, 0.0, stored)),
        np.ascontiguousarray(mute, dtype=float),
        np.ascontiguousarray(degrees),
        *(
            both(first[:, None], second[:, None])[:, 0].T
            for first, second in ((x.force, y.force), (x.point, y.point), (x.wave, y.wave))
        ),
    )


def elements_of(
    body: Stack, first: float = _FIRST, growth: float = _GROWTH
) -> list[tuple[float, Material]]:
    """Return thickness and material of each layer of elements, from the surface down.

    Thicknesses grow from `first` by a factor, whatever the depth; the last one of a material takes
    what is left of it.
    """
    cells, step = [], first
    for thickness, material in zip(body.thicknesses, body.materials, strict=True):
        left = thickness
        while left > (1 + growth / 2) * step:
            cells.append((step, material))
            left -= step
            step *= growth
        cells.append((left, material))
    return cells


def compliance(
    phases: tuple[Array, Array],
    spacing: tuple[float, float],
    body: Stack,
    *,
    element: Element = "splines",
    first: float = _FIRST,
    growth: float = _GROWTH,
    smooth: bool = False,
) -> Array:
    """Displacement C of the surface per pressure, for waves of given phases from cell to cell.

    For long waves on a deep body 2/(E* |q|); at q = 0 `Stack.squeezed`.

    Parameters
    ----------
    phases : (ndarray, ndarray)
        theta_x and theta_y of every wave, between -pi and pi, broadcast against each other.
    spacing : (float, float)
        Sides of the cells.
    body : Stack
        At least one layer. A half-space below enters by the stiffness of its surface: the theory of
        the half-space solvers, where a rigid base shares none.
    first : float
        Thickness of the uppermost elements over the smaller side of the cells.
    growth : float
        Of the thickness of elements from one to the next below.
    smooth : bool
        Whether pressures are the waves themselves, in place of steps from cell to cell, and C is
        twice the elastic energy per area and amplitude squared: what elements err by without cells.

    Examples
    --------
    A half-space, a wave of 32 cells:

    >>> wave = (np.array([2 * np.pi / 32]), np.array([0.0]))
    >>> body = Stack([100.0], [Material(1.0, 0.3)])
    >>> C = compliance(wave, (1.0, 1.0), body)
    >>> bool(abs(C[0] / (2 * (1 - 0.3**2) * 32 / (2 * np.pi)) - 1) < 2e-3)
    True

    Four elements of 27 nodes a smooth wave, on a deep body: 0.3 %.

    >>> wave = (np.array([np.pi / 2]), np.array([0.0]))
    >>> C = compliance(wave, (1.0, 1.0), body, element="quadratic", smooth=True)
    >>> round(float(C[0] * np.pi / 4 / (1 - 0.3**2)), 3)
    0.997
    """
    waves = phases, spacing, body, element
    result = _of_waves(*waves, (2,), first=first, growth=growth, smooth=smooth)[..., 0, 0]
    result[result == 0] = body.squeezed
    return result


def tensor(
    phases: tuple[Array, Array],
    spacing: tuple[float, float],
    body: Stack,
    *,
    element: Element = "splines",
    inertia: float = 0.0,
) -> Array:
    """Displacement of the surface per traction of any direction, (3, 3, ...); as `compliance`.

    Real, between i u_x, i u_y, u_z and i q_x, i q_y, p; zero where both phases are.

    `inertia` is rho V^2/G of a body that flows along x with the speed V under tractions that stand
    still: its kinetic energy -rho V^2 |dx(u)|^2/2 belongs to the stationary frame (Nackenhorst
    2004). Below the square of Rayleigh's speed over that of shear waves, 0.76 at nu = 0.

    Shear along a wave of 32 cells is softer than across it by 1 - nu:

    >>> waves = (np.array([2 * np.pi / 32, 0.0]), np.array([0.0, 2 * np.pi / 32]))
    >>> C = tensor(waves, (1.0, 1.0), Stack([100.0], [Material(1.0, 0.3)]))
    >>> round(float(C[0, 0, 0] / C[0, 0, 1]), 2)
    0.7
    """
    if not 0 <= inertia < 1:
        raise ValueError(f"inertia must be at least 0 and below 1, not {inertia!r}")
    if inertia and body.base:
        raise ValueError("inertia must be 0 above a half-space, whose stiffness is that at rest")
    result = _of_waves(phases, spacing, body, element, (0, 1, 2), inertia=inertia)
    return np.moveaxis(result, (-2, -1), (0, 1))


def _of_waves(
    phases: tuple[Array, Array],
    spacing: tuple[float, float],
    body: Stack,
    element: Element,
    axes: tuple[int, ...],
    *,
    first: float = _FIRST,
    growth: float = _GROWTH,
    smooth: bool = False,
    inertia: float = 0.0,
) -> Array:
    """Displacements (..., axes, axes) under tractions along axes, zero for the zero wavenumber."""
    faults = choice_faults("element", element, ELEMENTS)
    faults += positive_faults(dx=spacing[0], dy=spacing[1], first=first)
    if not 1 <= growth < 4:
        faults.append(f"growth must lie between 1 and 4, not {growth!r}")
    if not body.thicknesses:
        faults.append("thicknesses must be at least one: elements have no depth without layers")
    refuse(faults)
    # in units of the smaller side of the cells, and of the shear modulus at the top
    unit = min(spacing)
    sides = spacing[0] / unit, spacing[1] / unit
    scaled = replace(body, thicknesses=[thickness / unit for thickness in body.thicknesses])
    cells = elements_of(scaled, first, growth)
    top = cells[0][1]
    shear = top.shear_modulus
    table, above = np.empty((len(cells), 4)), np.empty(len(cells) + 1)
    for row, (thickness, material) in zip(table, cells, strict=True):
        nu = material.poisson_ratio
        # lambda/mu = 2 nu/(1 - 2 nu); both divided by |lambda|/mu + 1
        whole = 2 * abs(nu) + 1 - 2 * nu
        row[:] = thickness, material.shear_modulus / shear, 2 * nu / whole, (1 - 2 * nu) / whole
    above[0], above[1:] = 0.0, np.cumsum(table[:, 0])
    along, across = np.broadcast_arrays(*(np.asarray(theta, dtype=float) for theta in phases))
    shape = along.shape
    along, across = along.ravel(), across.ravel()
    wavenumber = np.hypot(along / sides[0], across / sides[1])
    count = len(axes)
    result = np.zeros((along.size, count, count))
    # long waves first, which reach furthest down
    waves = np.argsort(wavenumber, kind="stable")[np.count_nonzero(wavenumber == 0) :]
    for start in range(0, waves.size, _AT_ONCE):
        part = waves[start : start + _AT_ONCE]
        # groups of waves are whole; those beyond the last one are it
        full = part[np.minimum(np.arange(-(-part.size // _GROUP) * _GROUP), part.size - 1)]
        plane = in_plane(element, along[full], across[full], sides)
        # how many waves reach each layer and the half-space below; the others' base is rigid
        with np.errstate(divide="ignore"):
            reached = np.searchsorted(wavenumber[part], _REACH / above)
        reached[-1] = reached[-1] if body.base else 0
        stiffness = np.zeros((3 * len(plane.wave), 3 * len(plane.wave), full.size))
        if body.base:
            base = _base(plane.wave, along[full] / sides[0], across[full] / sides[1], body.base)
            stiffness[:] = base / shear
        _eliminate(plane, table, reached, inertia, stiffness)
        # copied, as the solvers want whole matrices one after the other
        matrices = np.ascontiguousarray(stiffness.transpose(2, 0, 1))[: part.size]
        ends = (plane.wave, plane.wave) if smooth else (plane.force, plane.point)
        force, point = (end.T[: part.size] for end in ends)
        load = np.zeros((*force.shape, 3, count))
        load[:, :, axes, range(count)] = force[..., None]
        moved = np.linalg.solve(matrices, load.reshape(part.size, -1, count)).reshape(load.shape)
        result[part] = np.einsum("wn,wnij->wij", point, moved[:, :, axes])
    return result.reshape(*shape, count, count) * (unit / shear)


def _base(wave: Array, qx: Array, qy: Array, material: Material) -> Array:
    """Return the stiffness of a half-space for nodes on its surface, (unknowns, unknowns, waves).

    Tractions over displacements of a wave are, along it and in depth, and across it G q,

        2 G q/(3 - 4 nu) [[2 (1 - nu), 2 nu - 1], [2 nu - 1, 2 (1 - nu)]]

    (Johnson 1985, ch. 13, solved for the tractions). Of the nodes' displacement it holds the wave
    itself: its aliases have died away some cells below the surface.
    """
    q, nu = np.hypot(qx, qy), material.poisson_ratio
    flat, ones = np.zeros_like(q), np.ones_like(q)
    ahead, deep = np.array([qx / q, qy / q, flat]), np.array([flat, flat, ones])
    across = np.array([-ahead[1], ahead[0], flat])

    def pair(first: Array, second: Array) -> Array:
        return np.einsum("iw,jw->ijw", first, second)

    plane = 2 * (1 - nu) * (pair(ahead, ahead) + pair(deep, deep))
    plane -= (1 - 2 * nu) * (pair(ahead, deep) + pair(deep, ahead))
    stiffness = material.shear_modulus * q * (2 / (3 - 4 * nu) * plane + pair(across, across))
    size = 3 * len(wave)
    return np.einsum("mw,nw,ijw->minjw", wave, wave, stiffness).reshape(size, size, -1)


# Of the displacements and of the pressures of an element along the depth.
_DEPTH = np.array([MASS, STIFFNESS, MIXED])
_PRESSED = np.array([PRESSED, PRESSED_SLOPE])


# Loops in place of slices, whose checks of shapes take longer to compile than all the rest.
@njit(cache=True, error_model="numpy", fastmath={"contract"})
def _eliminate(plane, layers, reached, inertia, result):
    """Turn the stiffness of the base (unknowns, unknowns, waves) into that of the surface.

    The unknowns of a layer are the displacements at its bottom, in the middle, the pressures, and
    the displacements at the top: three components on each node. Layers (thickness, shear modulus, r
    and s) count from the top down; `reached` has one number more, of waves that reach the base.
    """
    size, pressures = result.shape[0], plane.stored.shape[0]
    last = 2 * size + pressures
    matrix, factor = np.empty((last + size, last + size, _GROUP)), np.empty(_GROUP)
    for start in range(0, result.shape[2], _GROUP):
        carried = reached[-1] > start
        for layer in range(len(layers) - 1, -1, -1):
            if reached[layer] <= start:
                continue
            _fill(matrix, plane, layers[layer], inertia, start)
            # what is below carries the bottom, which else is held
            if carried:
                for i in range(size):
                    for j in range(size):
                        for w in range(_GROUP):
                            matrix[i, j, w] += result[i, j, start + w]
            # all but the top is eliminated from the lower triangle
            for k in range(0 if carried else size, last):
                for i in range(k + 1, len(matrix)):
                    for w in range(_GROUP):
                        factor[w] = matrix[i, k, w] / matrix[k, k, w]
                    for j in range(k + 1, i + 1):
                        for w in range(_GROUP):
                            matrix[i, j, w] -= factor[w] * matrix[j, k, w]
            for i in range(size):
                for j in range(i + 1):
                    for w in range(_GROUP):
                        result[i, j, start + w] = matrix[last + i, last + j, w]
                        result[j, i, start + w] = matrix[last + i, last + j, w]
            carried = True


@njit(cache=True, error_model="numpy")
def _fill(matrix, plane, layer, inertia, start):
    """Fill the matrices of one layer of elements: 2 e : e, less inertia, and the pressures."""
    thickness, modulus, ratio, storing = layer
    moves, volumes, stored, mute = plane.moves, plane.volumes, plane.stored, plane.mute
    nodes, pressures = moves.shape[1], stored.shape[0]
    size = 3 * nodes
    # by depth: top, middle, bottom; the pressures stand before the top
    places = (2 * size + pressures, size, 0)
    for a in range(3):
        for b in range(3):
            flat = _DEPTH[0, a, b] * thickness * modulus
            steep = _DEPTH[1, a, b] / thickness * modulus
            turned = _DEPTH[2, b, a] * modulus
            for i in range(nodes):
                for j in range(nodes):
                    row, column = places[a] + 3 * i, places[b] + 3 * j
                    for w in range(_GROUP):
                        at = start + w
                        along, across = moves[1, i, j, at] * flat, moves[2, i, j, at] * flat
                        upright, slanted = moves[0, i, j, at] * steep, moves[3, i, j, at] * flat
                        moving = inertia * along
                        matrix[row, column, w] = 2 * along + across + upright - moving
                        matrix[row + 1, column + 1, w] = along + 2 * across + upright - moving
                        matrix[row + 2, column + 2, w] = along + across + 2 * upright - moving
                        matrix[row, column + 1, w] = slanted
                        matrix[row + 1, column, w] = slanted
                        for axis in range(2):
                            matrix[row + axis, column + 2, w] = moves[4 + axis, i, j, at] * turned
                            matrix[column + 2, row + axis, w] = moves[4 + axis, i, j, at] * turned
    for k in range(pressures):
        for m in range(pressures):
            for w in range(_GROUP):
                matrix[2 * size + k, 2 * size + m, w] = 0.0
    sign, root = -1.0 if ratio < 0 else 1.0, np.sqrt(abs(ratio)) * modulus
    for k in range(pressures):
        row, degree = 2 * size + k, plane.degrees[k]
        share = sign * thickness * modulus * (1 / 3 if degree else 1.0)
        for w in range(_GROUP):
            kept = storing * stored[k, start + w] + mute[k, start + w]
            matrix[row, row, w] = -kept * share
        for a in range(3):
            flat = -_PRESSED[0, degree, a] * thickness * root
            factors = (flat, flat, _PRESSED[1, degree, a] * root)
            for i in range(nodes):
                for axis in range(3):
                    column = places[a] + 3 * i + axis
                    for w in range(_GROUP):
                        value = volumes[axis, k, i, start + w] * factors[axis]
                        matrix[row, column, w] = value
                        matrix[column, row, w] = value
