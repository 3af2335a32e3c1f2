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

What the elements are in x and y is said by `column_elements`.

Forces are those of pressures uniform on the cells; displacements are read at their centres.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.arguments import choice_faults, positive_faults, refuse
from reference.elasticity import Material
from reference.fem.column_elements import ELEMENTS, Element, in_plane
from reference.fem.elimination import GROUP, eliminated

Array = NDArray[np.float64]

# Deeper than this many wavelengths over 2 pi nothing reaches the surface: 1e-13 of the compliance;
# of waves of two cells on "linear" and "splines", which are stiff there at nu = 0.5, 4e-6.
_REACH = 30.0
# Wave vectors that are taken at once: 0.1 GB of column matrices.
_AT_ONCE = 16384
# Thickness of the uppermost elements over the cells' smaller side, and its growth with depth.
_FIRST, _GROWTH = 0.35, 1.25


@dataclass(frozen=True)
class Layers:
    """Materials below the surface, each down to a depth, on a rigid base or on a half-space.

    Parameters
    ----------
    thicknesses : sequence of float
        From the surface down.
    materials : sequence of Material
    below : Material, optional
        Of a half-space below them all, which enters by the stiffness of its surface (`_base`): the
        theory of the half-space solvers, where clamped columns share none. None: a rigid base.
    """

    thicknesses: Sequence[float]
    materials: Sequence[Material]
    below: Material | None = None

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
    element : {"linear", "splines", "quadratic"}
    first : float
        Thickness of the uppermost elements over the smaller side of the cells.
    growth : float
        Of the thickness of elements from one to the next below.

    Returns
    -------
    ndarray
        C in length per pressure. For long waves on a deep body 2/(E* |q|); at q = 0 the sum of
        thickness (1 - 2 nu)(1 + nu)/(E (1 - nu)), infinite on a half-space.

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
    result[flat] = np.inf if layers.below else _squeezed(mesh.cells)
    return result * unit


def of_smooth_pressure(
    phases: tuple[Array, Array],
    spacing: tuple[float, float],
    layers: Layers,
    *,
    element: Element = "splines",
    growth: float = _GROWTH,
) -> Array:
    """Compliance to pressures that are the waves themselves: what elements err by without cells.

    Twice the elastic energy per area and amplitude of the pressure squared.

    Parameters
    ----------
    phases, spacing, layers, element, growth
        As for `compliance`.

    Returns
    -------
    ndarray
        In length per pressure; zero where both phases are.

    Examples
    --------
    Four elements of 27 nodes a wave, on a deep body: 0.3 %.

    >>> wave = (np.array([np.pi / 2]), np.array([0.0]))
    >>> body = Layers([16.0], [Material(1.0, 0.3)])
    >>> C = of_smooth_pressure(wave, (1.0, 1.0), body, element="quadratic")
    >>> round(float(C[0] * np.pi / 4 / (1 - 0.3**2)), 3)
    0.997
    """
    result, unit = _of_waves(
        phases, _Mesh(spacing, layers, element, _FIRST, growth), _pressed_by_waves
    )
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
    if inertia and layers.below:
        raise ValueError("inertia must be 0 above a half-space, whose stiffness is that at rest")
    mesh = _Mesh(spacing, layers, element, _FIRST, _GROWTH, inertia)
    result, unit = _of_waves(phases, mesh, _pulled, (3, 3))
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
        self.element, self.inertia, self.below = element, inertia, layers.below


def _of_waves(
    phases: tuple[Array, Array],
    mesh: _Mesh,
    read: Callable[[Array, _Ends], Array],
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
    for start in range(0, waves.size, _AT_ONCE):
        part = waves[start : start + _AT_ONCE]
        result[part] = read(*_surface(along[part], across[part], mesh))
    top = mesh.cells[0][1]
    modulus = top.youngs_modulus / (2 * (1 + top.poisson_ratio))
    return result.reshape(*shape, *size), mesh.unit / modulus


def _pressed(stiffness: Array, ends: _Ends) -> Array:
    """Return u_z per p."""
    return _sunk(stiffness, ends.force, ends.point)


def _pressed_by_waves(stiffness: Array, ends: _Ends) -> Array:
    """Return the work of a wave of pressure on what it displaces, twice and per p^2."""
    return _sunk(stiffness, ends.wave, ends.wave)


def _sunk(stiffness: Array, force: Array, read: Array) -> Array:
    load = np.zeros((*stiffness.shape[:2], 1))
    load[:, 2::3, 0] = force
    moved = np.linalg.solve(stiffness, load)[:, 2::3, 0]
    return np.asarray((moved * read).sum(axis=1), dtype=np.float64)


def _pulled(stiffness: Array, ends: _Ends) -> Array:
    """Return the displacement in all directions per traction in all, (waves, 3, 3)."""
    waves, nodes = ends.force.shape
    load = np.zeros((waves, nodes, 3, 3))
    for axis in range(3):
        load[:, :, axis, axis] = ends.force
    moved = np.linalg.solve(stiffness, load.reshape(waves, 3 * nodes, 3))
    result: Array = np.einsum("wn,wnij->wij", ends.point, moved.reshape(waves, nodes, 3, 3))
    return result


def _squeezed(cells: list[tuple[float, Material]]) -> float:
    """Compliance under uniform pressure, nothing moves sideways; units as of `_eliminated`."""
    top = cells[0][1].youngs_modulus / (2 + 2 * cells[0][1].poisson_ratio)
    return sum(
        thickness * top * (1 - 2 * m.poisson_ratio) * (1 + m.poisson_ratio)
        / (m.youngs_modulus * (1 - m.poisson_ratio))
        for thickness, m in cells
    )  # fmt: skip


class _Ends(NamedTuple):
    """What forces and displacements of cells are of the nodes', and the wave; (waves, nodes)."""

    force: Array
    point: Array
    wave: Array


def _surface(along: Array, across: Array, mesh: _Mesh) -> tuple[Array, _Ends]:
    """Return the stiffness of the surface for waves in the order of their wavenumbers.

    In units of modulus over side, (waves, unknowns, unknowns).
    """
    # groups of waves are whole; those beyond the last one are it
    full = np.minimum(np.arange(-(-along.size // GROUP) * GROUP), along.size - 1)
    plane = in_plane(mesh.element, along[full], across[full], mesh.sides)
    wavenumber = np.hypot(along / mesh.sides[0], across / mesh.sides[1])
    top = mesh.cells[0][1]
    shear = top.youngs_modulus / (2 + 2 * top.poisson_ratio)
    layers, active, depth = np.empty((len(mesh.cells), 4)), [], 0.0
    for row, (thickness, material) in zip(layers, mesh.cells, strict=True):
        active.append(np.searchsorted(wavenumber, _REACH / depth) if depth > 0 else along.size)
        depth += thickness
        nu = material.poisson_ratio
        # lambda/mu = 2 nu/(1 - 2 nu); both divided by |lambda|/mu + 1
        whole = 2 * abs(nu) + 1 - 2 * nu
        modulus = material.youngs_modulus / (2 + 2 * nu) / shear
        row[:] = thickness, modulus, 2 * nu / whole, (1 - 2 * nu) / whole
    base = None
    if mesh.below is not None:
        stored = _base(plane.wave, (along[full], across[full]), mesh.sides, mesh.below)
        base = stored / shear, int(np.searchsorted(wavenumber, _REACH / depth))
    stiffness = eliminated(plane, layers, np.array(active), mesh.inertia, base)
    ends = (part.T[: along.size] for part in (plane.force, plane.point, plane.wave))
    return stiffness[: along.size], _Ends(*ends)


def _base(
    wave: Array, phases: tuple[Array, Array], sides: tuple[float, float], material: Material
) -> Array:
    """Stiffness of a half-space for the nodes on its surface, (unknowns, unknowns, waves).

    Tractions over displacements of a wave are, along it and in depth, and across it G q,

        2 G q/(3 - 4 nu) [[2 (1 - nu), 2 nu - 1], [2 nu - 1, 2 (1 - nu)]]

    (Johnson 1985, ch. 13, solved for the tractions). Of the nodes' displacement it holds the wave
    itself: its aliases have died away some cells below the surface.
    """
    slopes = np.array([theta / side for theta, side in zip(phases, sides, strict=True)])
    q, nu = np.hypot(*slopes), material.poisson_ratio
    ahead = np.zeros((3, q.size))
    ahead[:2] = slopes / q
    across = np.array([-ahead[1], ahead[0], ahead[2]])
    deep = np.array([[0.0], [0.0], [1.0]]) * np.ones_like(q)

    def pair(first: Array, second: Array) -> Array:
        return np.einsum("iw,jw->ijw", first, second)

    plane = 2 * (1 - nu) * (pair(ahead, ahead) + pair(deep, deep))
    plane -= (1 - 2 * nu) * (pair(ahead, deep) + pair(deep, ahead))
    shear = material.youngs_modulus / (2 + 2 * nu)
    stiffness = shear * q * (2 / (3 - 4 * nu) * plane + pair(across, across))
    size = 3 * len(wave)
    held: Array = np.einsum("mw,nw,ijw->minjw", wave, wave, stiffness)
    return np.ascontiguousarray(held.reshape(size, size, -1))
