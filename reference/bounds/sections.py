r"""Horizontal finite elements of a layer below the surface: rings, or triangles.

The coefficients are those of Bernstein's polynomials, so that a function is nowhere below a level
that none of its coefficients is below.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from skfem import Basis, BilinearForm, ElementTriP2, MeshTri
from skfem.helpers import dot, grad

from reference.bounds.interval import EPSILON
from reference.bounds.lines import Line, numbers
from reference.bounds.outlines import nested

Array = NDArray[np.float64]
Indices = NDArray[np.int64]


@dataclass(frozen=True, eq=False)
class Side:
    """Outer edges of a section, each in a vertical plane at a distance h from the origin.

    With s along the edge from the foot of that distance, and f_s the derivative along it:
    stiffness, mass, swelling and moment are the integrals of f_s f_s, f f, (f + s f_s)^2 and
    (f + s f_s) f.
    """

    elements: Indices  # (s,), of the section
    local: Indices  # (s, k), which of the element's functions live on the edge
    distances: Array  # (s,)
    stiffness: Array  # (s, k, k)
    mass: Array
    swelling: Array
    moment: Array


@dataclass(frozen=True, eq=False)
class Section:
    """Element matrices of a horizontal section that is star-shaped about the origin.

    Attributes
    ----------
    stiffness, mass, swelling : (n, k, k)
        Integrals of grad f . grad f, f f and (f + x . grad f)^2 over the elements.
    unknowns : (n, k)
    points : (count, 2)
        Place of each unknown's function: a vertex, or the middle between two.
    ends : (count, 2)
        The unknowns of these two vertices; a vertex twice itself.
    rounding : float
        Relative rounding of the elements' sizes.
    side : Side
    """

    stiffness: Array
    mass: Array
    swelling: Array
    unknowns: Indices
    points: Array
    ends: Indices
    rounding: float
    side: Side

    @property
    def count(self) -> int:
        """Number of unknowns."""
        return len(self.points)

    @property
    def centres(self) -> Array:
        """Middles of the elements, roughly."""
        return self.points[self.unknowns].mean(axis=1)

    def bernstein(self, values: Array) -> Array:
        """Coefficients of the function with given values at the points, quadratic on elements.

        On the side between two vertices f(middle) = (f_1 + 2 b + f_2)/4.
        """
        middle = self.ends[:, 0] != self.ends[:, 1]
        outer = values[self.ends].mean(axis=1)
        return np.where(middle, 2 * values - outer, values)


def rings(radii: Array) -> Section:
    """Return the section of a body of revolution, whole, from the radii of its rings (0 first)."""
    line = Line(radii[:-1], radii[1:], bernstein=True)
    around = 2 * np.pi * line.places
    rim = np.full((1, 1, 1), 2 * np.pi * radii[-1])
    count = len(radii) - 1
    # the rim is round: nothing changes along it, which leaves f + s f_s = f
    side = Side(
        elements=np.array([count - 1]),
        local=np.array([[2]]),
        distances=radii[-1:],
        stiffness=np.zeros((1, 1, 1)),
        mass=rim,
        swelling=rim,
        moment=rim,
    )
    places = np.zeros((2 * count + 1, 2))
    places[::2, 0], places[1::2, 0] = radii, 0.5 * (radii[:-1] + radii[1:])
    number = np.arange(2 * count + 1)
    ends = np.stack([number - number % 2, number + number % 2], axis=1)
    return Section(
        stiffness=line.form(line.slopes, line.slopes, around),
        mass=line.form(line.values, line.values, around),
        swelling=line.form(line.swelling, line.swelling, around),
        unknowns=numbers(count),
        points=places,
        ends=ends,
        rounding=8 * EPSILON,
        side=side,
    )


def fan(shells: Array, *, closed: bool) -> tuple[Section, Indices]:
    """Triangles between shells about the origin, from the innermost to the outermost.

    Parameters
    ----------
    shells : (n, m + 1, 2)
        Points in the order of their angle, straight lines between them; on an open fan the first
        and the last points lie in planes of symmetry.
    closed : bool
        Whether the last point is followed by the first.

    Raises
    ------
    ValueError
        For shells that cross: what is put together on them is no function.

    Returns
    -------
    section : Section
    shell : (unknowns,)
        Number of the shell, from 1, that just contains the place of each unknown's function.
    """
    if not nested(shells, closed=closed):
        raise ValueError("shells about the origin must lie inside each other, and these cross")
    layers, count = shells.shape[:2]
    vertices = np.concatenate([np.zeros((1, 2)), shells.reshape(-1, 2)])
    # number of the vertex on shell j at point k: 1 + j count + k
    near = np.arange(count if closed else count - 1)
    far = (near + 1) % count
    core = np.stack([0 * near, 1 + near, 1 + far])
    first = 1 + count * np.arange(layers - 1)[:, None]
    inner, beside = (first + near).ravel(), (first + far).ravel()
    quads = [
        np.stack([inner, inner + count, beside + count]),
        np.stack([inner, beside + count, beside]),
    ]
    mesh = MeshTri(vertices.T, np.concatenate([core, *quads], axis=1))
    rank = np.concatenate([[0], np.repeat(np.arange(1, layers + 1), count)])
    basis = Basis(mesh, ElementTriP2(), intorder=4)
    corners = basis.element_dofs[:3]
    ends = np.zeros((basis.N, 2), dtype=np.int64)
    ends[corners] = corners[:, :, None]
    levels = np.zeros(basis.N, dtype=np.int64)
    levels[corners] = rank[mesh.t]
    for edge, pair in enumerate(_EDGES):
        ends[basis.element_dofs[3 + edge]] = corners[list(pair)].T
        levels[basis.element_dofs[3 + edge]] = rank[mesh.t[list(pair)]].max(axis=0)
    sides = np.diff(mesh.p[:, mesh.t[[0, 1, 2, 0]]], axis=1)
    doubled = np.abs(sides[0, 0] * sides[1, 1] - sides[1, 0] * sides[0, 1])
    slender = ((sides**2).sum(axis=0).max(axis=0) / doubled).max()
    outer = _side(basis, 1 + count * (layers - 1) + np.stack([near, far], axis=1))
    section = Section(
        stiffness=_elemental(basis, lambda u, v, w: dot(grad(u), grad(v))),
        mass=_elemental(basis, lambda u, v, w: u * v),
        swelling=_elemental(basis, lambda u, v, w: _swelling(u, w) * _swelling(v, w)),
        unknowns=basis.element_dofs.T.astype(np.int64),
        points=basis.doflocs.T,
        ends=ends,
        rounding=8 * EPSILON * float(slender),
        side=outer,
    )
    return section, levels


# Local edges of a triangle in scikit-fem, in the order of their unknowns after the vertices.
_EDGES = ((0, 1), (1, 2), (0, 2))

# Values at vertices and middles of edges for coefficients of Bernstein's polynomials.
_NODAL = np.eye(6)
for _edge, _pair in enumerate(_EDGES):
    _NODAL[3 + _edge] = 0
    _NODAL[3 + _edge, [*_pair, 3 + _edge]] = 0.25, 0.25, 0.5


def _swelling(u, w):
    return u + w.x[0] * u.grad[0] + w.x[1] * u.grad[1]


def _elemental(basis, form) -> Array:
    local = BilinearForm(form).elemental(basis).tolocal()
    return np.einsum("ai,eab,bj->eij", _NODAL, local, _NODAL)


def _side(basis, edges: Indices) -> Side:
    """Quadratic functions on the outermost edges, given by pairs of vertices."""
    triangles = basis.mesh.t
    elements, local = [], []
    for first, last in edges:
        owner = int(np.flatnonzero((triangles == first).any(0) & (triangles == last).any(0))[0])
        a, b = (int(np.flatnonzero(triangles[:, owner] == vertex)[0]) for vertex in (first, last))
        elements.append(owner)
        local.append([a, 3 + _EDGES.index((min(a, b), max(a, b))), b])
    start, end = basis.mesh.p[:, edges[:, 0]], basis.mesh.p[:, edges[:, 1]]
    along = (end - start) / np.hypot(*(end - start))
    line = Line((start * along).sum(0), (end * along).sum(0), bernstein=True)
    return Side(
        elements=np.array(elements),
        local=np.array(local),
        distances=np.abs(start[0] * along[1] - start[1] * along[0]),
        stiffness=line.form(line.slopes, line.slopes),
        mass=line.form(line.values, line.values),
        swelling=line.form(line.swelling, line.swelling),
        moment=line.form(line.swelling, line.values),
    )
