r"""Finite elements on a grid that repeats: the surface's compliance, one wave vector at a time.

A mesh of equal cells in x and y, graded in depth, has a stiffness matrix that is the same for every
cell. A displacement of one wave vector q = (theta_x/dx, theta_y/dy),

    u(node) = U_k exp(i (theta_x m + theta_y n)),

therefore stays one of that wave vector, and all that is left of the problem is a column: three
components at each depth. Eliminated from below it gives the displacement of the surface under a
pressure of that wave vector, C(q). It is the finite-element answer, not an approximation of it; the
contact problem costs no more than an FFT.

With i u_x, i u_y in place of u_x, u_y (the tangential motion is a quarter of a wave ahead) all
numbers are real. Integrals over x and y are functions of theta: of two values (mass), two slopes
(stiffness), and of one value and one slope. In depth the elements are quadratic.

Volume changes are taken as the pressures of a mixed method, which are linear in the depth of an
element and jump to the next: nothing locks, and nu = 0.5 is a material like any other. The mean
pressure p of an element and its slope obey

    r div u - s p = 0,    r = lambda/(|lambda| + mu),    s = mu/(|lambda| + mu),

in units of mu, which is regular from lambda = 0 to infinity.

In x and y there are two kinds of elements, whose degrees of freedom stand in the middles of the
cells of a contact solver:

``"linear"``
    bilinear, with pressures constant in x and y;
``"splines"``
    quadratic B-splines, with bilinear pressures.

Forces are those of pressures uniform on the cells; displacements are read at their centres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.arguments import choice_faults, positive_faults, refuse
from reference.fem.elasticity import Material

Array = NDArray[np.float64]
Element = Literal["linear", "splines"]
ELEMENTS: tuple[Element, ...] = ("linear", "splines")

# Deeper than this many wavelengths over 2 pi nothing reaches the surface: exp(-2 x 22) = 1e-19.
_REACH = 22.0
# Wave vectors that are taken at once: 0.1 GB of column matrices.
_AT_ONCE = 16384
# Thickness of the uppermost elements over the cells' smaller side, and its growth with depth.
_FIRST, _GROWTH = 0.35, 1.25
# A wave whose pressures do not act on the displacements at all, as two cells long: they are left
# out.
_MUTE = 1e-12


class Symbols(NamedTuple):
    """Integrals over a cell in one direction, for waves of phase theta from cell to cell.

    Attributes
    ----------
    mass, stiffness, mixed : ndarray
        Of two shape functions, of their slopes (times h^2), of one and the other's slope (times h
        and over i).
    value, slope, pressure : ndarray
        Of a pressure and a shape function, and its slope (times h and over i), and of two
        pressures.
    force, point : ndarray
        Of a shape function over the cell about the node, and its value there.
    """

    mass: Array
    stiffness: Array
    mixed: Array
    value: Array
    slope: Array
    pressure: Array
    force: Array
    point: Array


def _linear(theta: Array) -> Symbols:
    """Hat functions: exact integrals of piecewise polynomials."""
    cos, half = np.cos(theta), theta / 2
    return Symbols(
        mass=(2 + cos) / 3,
        stiffness=4 * np.sin(half) ** 2,
        mixed=np.sin(theta),
        value=np.cos(half),
        slope=2 * np.sin(half),
        pressure=np.ones_like(theta),
        force=(3 + cos) / 4,
        point=np.ones_like(theta),
    )


def _splines(theta: Array) -> Symbols:
    """Quadratic B-splines: their integrals are B-splines of higher degree at whole numbers."""
    cos, half, hats = np.cos(theta), theta / 2, (2 + np.cos(theta)) / 3
    return Symbols(
        mass=(33 + 26 * cos + np.cos(2 * theta)) / 60,
        stiffness=4 * np.sin(half) ** 2 * hats,
        mixed=(10 * np.sin(theta) + np.sin(2 * theta)) / 12,
        value=(11 * np.cos(half) + np.cos(3 * half)) / 12,
        slope=2 * np.sin(half) * hats,
        pressure=hats,
        force=hats,
        point=(3 + cos) / 4,
    )


_SYMBOLS: dict[Element, Callable[[Array], Symbols]] = {"linear": _linear, "splines": _splines}


@dataclass(frozen=True)
class Layers:
    """Materials below the surface, each down to a depth, on a rigid base.

    Parameters
    ----------
    thicknesses : sequence of float
        From the surface down.
    materials : sequence of Material

    Raises
    ------
    ValueError
        Listing everything wrong.
    """

    thicknesses: Sequence[float]
    materials: Sequence[Material]

    def __post_init__(self) -> None:
        faults = []
        if not self.thicknesses or len(self.thicknesses) != len(self.materials):
            count = f"{len(self.thicknesses)} and {len(self.materials)}"
            faults.append(f"thicknesses and materials must be as many, at least one, not {count}")
        for index, thickness in enumerate(self.thicknesses):
            faults += positive_faults(**{f"thicknesses[{index}]": thickness})
        refuse(faults)

    def elements(self, first: float, growth: float) -> list[tuple[float, Material]]:
        """Return thickness and material of each layer of elements, from the surface down.

        Thicknesses grow from `first` by a factor, whatever the depth; the last one of a material
        takes what is left of it.
        """
        cells, step = [], first
        for thickness, material in zip(self.thicknesses, self.materials, strict=True):
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
    layers: Layers,
    *,
    element: Element = "splines",
    first: float = _FIRST,
    growth: float = _GROWTH,
) -> Array:
    """Displacement of the surface per pressure, for waves of given phases from cell to cell.

    Parameters
    ----------
    phases : (ndarray, ndarray)
        theta_x and theta_y of every wave, between -pi and pi, broadcast against each other.
    spacing : (float, float)
        Sides of the cells.
    layers : Layers
    element : {"linear", "splines"}
    first : float
        Thickness of the uppermost elements over the smaller side of the cells.
    growth : float
        Of the thickness of elements from one to the next below.

    Returns
    -------
    ndarray
        C in length per pressure. For long waves on a deep body 2/(E* |q|); at q = 0 the sum of
        thickness (1 - 2 nu)(1 + nu)/(E (1 - nu)).

    Raises
    ------
    ValueError
        Listing everything wrong.

    Examples
    --------
    A half-space, a wave of 32 cells:

    >>> wave = (np.array([2 * np.pi / 32]), np.array([0.0]))
    >>> body = Layers([100.0], [Material(1.0, 0.3)])
    >>> C = compliance(wave, (1.0, 1.0), body)
    >>> bool(abs(C[0] / (2 * (1 - 0.3**2) * 32 / (2 * np.pi)) - 1) < 2e-3)
    True
    """
    mesh = _Mesh(spacing, layers, element, first, growth)
    result, unit = _of_waves(phases, mesh, _pressed)
    flat = result == 0  # no wave, but uniform
    result[flat] = _squeezed(mesh.cells)
    return result * unit


def tensor(
    phases: tuple[Array, Array],
    spacing: tuple[float, float],
    layers: Layers,
    *,
    element: Element = "splines",
    inertia: float = 0.0,
) -> Array:
    """Displacement of the surface per traction of any direction, for waves as of `compliance`.

    Parameters
    ----------
    phases, spacing, layers, element
        As for `compliance`.
    inertia : float
        rho V^2/G of a body that flows along x with the speed V under tractions that stand still:
        its kinetic energy -rho V^2 |dx(u)|^2/2 belongs to the stationary frame (Nackenhorst 2004).
        Below the square of Rayleigh's speed over that of shear waves, 0.76 at nu = 0.

    Returns
    -------
    ndarray, shape (3, 3, ...)
        Real, between i u_x, i u_y, u_z and i q_x, i q_y, p; zero where both phases are.

    Raises
    ------
    ValueError
        Listing everything wrong.

    Examples
    --------
    Shear along a wave of 32 cells is softer than across it by 1 - nu:

    >>> waves = (np.array([2 * np.pi / 32, 0.0]), np.array([0.0, 2 * np.pi / 32]))
    >>> C = tensor(waves, (1.0, 1.0), Layers([100.0], [Material(1.0, 0.3)]))
    >>> round(float(C[0, 0, 0] / C[0, 0, 1]), 2)
    0.7
    """
    if not 0 <= inertia < 1:
        raise ValueError(f"inertia must be at least 0 and below 1, not {inertia!r}")
    mesh = _Mesh(spacing, layers, element, _FIRST, _GROWTH, inertia)
    result, unit = _of_waves(phases, mesh, _inverted, (3, 3))
    return np.moveaxis(result, (-2, -1), (0, 1)) * unit


class _Mesh:
    """Elements of columns, in units of the smaller side of the cells."""

    def __init__(
        self,
        spacing: tuple[float, float],
        layers: Layers,
        element: Element,
        first: float,
        growth: float,
        inertia: float = 0.0,
    ) -> None:
        faults = choice_faults("element", element, ELEMENTS)
        faults += positive_faults(dx=spacing[0], dy=spacing[1], first=first)
        if not 1 <= growth < 4:
            faults.append(f"growth must lie between 1 and 4, not {growth!r}")
        refuse(faults)
        self.unit = min(spacing)
        scaled = Layers([t / self.unit for t in layers.thicknesses], layers.materials)
        self.cells = scaled.elements(first, growth)
        self.sides = spacing[0] / self.unit, spacing[1] / self.unit
        self.element, self.inertia = element, inertia


def _of_waves(
    phases: tuple[Array, Array],
    mesh: _Mesh,
    read: Callable[[Array], Array],
    size: tuple[int, ...] = (),
) -> tuple[Array, float]:
    """Return what is read from the stiffness of the surface, zero at no wave, and its unit."""
    along, across = (np.asarray(theta, dtype=float) for theta in phases)
    along, across = np.broadcast_arrays(along, across)
    shape = along.shape
    along, across = along.ravel(), across.ravel()
    wavenumber = np.hypot(along / mesh.sides[0], across / mesh.sides[1])
    result = np.zeros((along.size, *size))
    waves = np.argsort(wavenumber, kind="stable")[np.count_nonzero(wavenumber == 0) :]
    for part in np.array_split(waves, -(-waves.size // _AT_ONCE) or 1):
        stiffness, share = _surface(along[part], across[part], mesh)
        result[part] = read(stiffness) * share.reshape(-1, *(1 for _ in size))
    top = mesh.cells[0][1]
    modulus = top.youngs_modulus / (2 * (1 + top.poisson_ratio))
    return result.reshape(*shape, *size), mesh.unit / modulus


def _pressed(stiffness: Array) -> Array:
    """Return u_z per p."""
    unit = np.broadcast_to([[0.0], [0.0], [1.0]], (len(stiffness), 3, 1))
    return np.linalg.solve(stiffness, unit)[:, 2, 0]


def _inverted(stiffness: Array) -> Array:
    inverse: Array = np.asarray(np.linalg.inv(stiffness), dtype=np.float64)
    return inverse


def _squeezed(cells: list[tuple[float, Material]]) -> float:
    """Compliance under uniform pressure, nothing moves sideways; units as of `_eliminated`."""
    top = cells[0][1].youngs_modulus / (2 + 2 * cells[0][1].poisson_ratio)
    return sum(
        thickness * top * (1 - 2 * m.poisson_ratio) * (1 + m.poisson_ratio)
        / (m.youngs_modulus * (1 - m.poisson_ratio))
        for thickness, m in cells
    )  # fmt: skip


def _surface(along: Array, across: Array, mesh: _Mesh) -> tuple[Array, Array]:
    """Return the stiffness of the surface for waves in the order of their wavenumbers.

    In units of modulus over side; and what forces and displacements of cells are of the nodes'.
    """
    sides, cells, element = mesh.sides, mesh.cells, mesh.element
    x, y = _SYMBOLS[element](along), _SYMBOLS[element](across)
    plane = _in_plane(x, y, sides)
    wavenumber = np.hypot(along / sides[0], across / sides[1])
    shear = [material.youngs_modulus / (2 + 2 * material.poisson_ratio) for _, material in cells]
    depth = sum(thickness for thickness, _ in cells)
    stiffness = np.zeros((0, 3, 3))
    for (thickness, material), modulus in zip(reversed(cells), reversed(shear), strict=True):
        depth -= thickness
        active = int(np.searchsorted(wavenumber, _REACH / depth)) if depth > 0 else along.size
        matrix = _layer(plane, active, thickness, material, mesh.inertia) * (modulus / shear[0])
        stiffness = _condensed(matrix, stiffness)
    return stiffness, x.force * y.force * x.point * y.point


def _condensed(matrix: Array, below: Array) -> Array:
    """Stiffness at the top of a layer of elements that stands on a body of a known one.

    The unknowns are the displacements at the top, in the middle and at the bottom, and the
    pressures. Waves that do not reach the body below stand on a rigid one.
    """
    carried = len(below)
    result = np.empty((len(matrix), 3, 3))
    matrix[:carried, 6:9, 6:9] += below
    inner = np.r_[3:11]
    if carried:
        result[:carried] = _schur(matrix[:carried], inner)
    if carried < len(matrix):
        result[carried:] = _schur(matrix[carried:], np.r_[3:6, 9:11])
    return result


def _schur(matrix: Array, inner: NDArray[np.intp]) -> Array:
    """Complement of the first three unknowns after some others are eliminated."""
    left = matrix[:, :3][:, :, inner]
    block = matrix[:, inner][:, :, inner]
    right = matrix[:, inner][:, :, :3]
    condensed = matrix[:, :3, :3] - left @ np.linalg.solve(block, right)
    symmetric: Array = (condensed + condensed.transpose(0, 2, 1)) / 2
    return symmetric


class _Plane(NamedTuple):
    """Products of the symbols of both directions, each (waves,), per area of the surface.

    `deviatoric` has nine: what multiplies the depth's mass matrix in xx, yy, zz and xy; its
    stiffness matrix in xx (and yy) and zz; its mixed one in xz, yz.
    """

    mass: Array
    bend_x: Array
    bend_y: Array
    cross: Array
    tilt_x: Array
    tilt_y: Array
    grow_x: Array
    grow_y: Array
    sink: Array
    pressure: Array


def _in_plane(x: Symbols, y: Symbols, sides: tuple[float, float]) -> _Plane:
    dx, dy = sides
    plane = _Plane(
        mass=x.mass * y.mass,
        bend_x=x.stiffness * y.mass / dx**2,
        bend_y=x.mass * y.stiffness / dy**2,
        cross=x.mixed * y.mixed / (dx * dy),
        tilt_x=x.mixed * y.mass / dx,
        tilt_y=x.mass * y.mixed / dy,
        grow_x=x.slope * y.value / dx,
        grow_y=x.value * y.slope / dy,
        sink=x.value * y.value,
        pressure=x.pressure * y.pressure,
    )
    mute = np.abs(plane.grow_x) + np.abs(plane.grow_y) + np.abs(plane.sink) < _MUTE
    for acts in (plane.grow_x, plane.grow_y, plane.sink):
        acts[mute] = 0.0
    return plane


# Quadratic shape functions on a unit interval, nodes at 0, 1/2, 1: mass, stiffness, and the
# integrals of a function (row) and a slope (column). Pressures: 1 and 2 z - 1.
_MASS = np.array([[4, 2, -1], [2, 16, 2], [-1, 2, 4]]) / 30
_STIFFNESS = np.array([[7, -8, 1], [-8, 16, -8], [1, -8, 7]]) / 3
_MIXED = np.array([[-3, 4, -1], [-4, 0, 4], [1, -4, 3]]) / 6
_PRESSED = np.array([[1, 4, 1], [-1, 0, 1]]) / 6
_PRESSED_SLOPE = np.array([[-3, 0, 3], [2, -4, 2]]) / 3
_PRESSURES = np.array([1.0, 1 / 3])


def _layer(
    plane: _Plane, active: int, thickness: float, material: Material, inertia: float
) -> Array:
    """Matrices of one layer of elements for the first waves, (active, 11, 11), unit shear modulus.

    Of 2 e : e with e the strain, less the inertia of a flow along x, and of the pressures.
    """
    mass, stiffness, mixed = _MASS * thickness, _STIFFNESS / thickness, _MIXED
    p = _Plane(*(part[:active, None, None] for part in plane))
    matrix = np.zeros((active, 11, 11))
    x, y, z = (slice(axis, 9, 3) for axis in range(3))
    matrix[:, x, x] = (2 * p.bend_x + p.bend_y) * mass + p.mass * stiffness
    matrix[:, y, y] = (2 * p.bend_y + p.bend_x) * mass + p.mass * stiffness
    matrix[:, z, z] = (p.bend_x + p.bend_y) * mass + 2 * p.mass * stiffness
    for axis in (x, y, z):
        matrix[:, axis, axis] -= inertia * p.bend_x * mass
    matrix[:, x, y] = p.cross * mass
    matrix[:, x, z] = p.tilt_x * mixed.T
    matrix[:, y, z] = p.tilt_y * mixed.T
    for row, column in ((x, y), (x, z), (y, z)):
        matrix[:, column, row] = matrix[:, row, column].transpose(0, 2, 1)
    volume = np.empty((active, 2, 9))
    volume[:, :, x] = -p.grow_x * _PRESSED * thickness
    volume[:, :, y] = -p.grow_y * _PRESSED * thickness
    volume[:, :, z] = p.sink * _PRESSED_SLOPE
    nu = material.poisson_ratio
    # lambda/mu = 2 nu/(1 - 2 nu); both divided by |lambda|/mu + 1
    whole = 2 * abs(nu) + 1 - 2 * nu
    matrix[:, :9, 9:] = volume.transpose(0, 2, 1)
    matrix[:, 9:, :9] = volume * (2 * nu / whole)
    mute = (p.sink == 0) & (p.grow_x == 0) & (p.grow_y == 0)
    stored = np.where(mute, 1.0, (1 - 2 * nu) / whole)[:, :, 0] * p.pressure[:, :, 0] * thickness
    matrix[:, [9, 10], [9, 10]] = -stored * _PRESSURES
    return matrix
