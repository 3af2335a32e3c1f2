"""Hexahedral meshes of a part of a half-space, fine in the contact.

z points into the half-space, the surface is z = 0. A mesh is built from lattices: every element is
a 3 x 3 x 3 block of node numbers into one array of points, so curved rings have exact mid-nodes,
and the same blocks give trilinear (corners only) or 27-node triquadratic elements.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.integrate import cumulative_simpson
from skfem import MeshHex, MeshHex2
from skfem.element import ElementHex1, ElementHex2, ElementQuad1, ElementQuad2

Planes = tuple[bool, bool]


@dataclass(frozen=True, eq=False)
class GradedMesh:
    """A mesh and parts of its boundary.

    Attributes
    ----------
    mesh : skfem.MeshHex or skfem.MeshHex2
    surface : (k,)
        Facets at z = 0.
    outer : (l,)
        Facets towards the unmeshed exterior of the half-space.
    planes : (bool, bool)
        Whether x = 0 and y = 0 are planes of symmetry, with only the positive side meshed.
    """

    mesh: MeshHex
    surface: NDArray[np.int64]
    outer: NDArray[np.int64]
    planes: Planes = (False, False)


def facet_nodes(mesh: MeshHex, facets: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return numbers of all nodes (corner, edge and face nodes) on the given facets."""
    return np.asarray(mesh.dofs.get_facet_dofs(facets).flatten(), dtype=np.int64)


def facet_quadrature(
    mesh: MeshHex, facets: NDArray[np.int64], per_direction: int
) -> tuple[NDArray[np.int64], NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return Gauss points on facets.

    Returns
    -------
    nodes : (facets, n)
        Node numbers of the facets.
    shapes : (n, points)
        Values of their shape functions.
    points : (facets, points, 3)
    areas : (facets, points, 3)
        Gauss weight times the normal area vector, of either sign.
    """
    nodes = mesh.facets[:, facets]
    element = ElementQuad1()
    if mesh.elem is ElementHex2:
        element = ElementQuad2()
        dofs = mesh.dofs
        nodes = np.vstack(
            [nodes, dofs.edge_dofs[0, mesh.f2e[:, facets]], dofs.facet_dofs[:, facets]]
        )
    line, weight = np.polynomial.legendre.leggauss(per_direction)
    X = 0.5 * (np.stack(np.meshgrid(line, line)).reshape(2, -1) + 1.0)
    values = [element.lbasis(X, i) for i in range(len(nodes))]
    shapes = np.array([value for value, _ in values])
    slopes = np.array([slope for _, slope in values])
    corners = mesh.p.T[nodes.T]
    points = np.einsum("fni,nq->fqi", corners, shapes)
    tangents = np.einsum("fni,ndq->dfqi", corners, slopes)
    areas = np.cross(tangents[0], tangents[1]) * np.outer(weight, weight).reshape(-1, 1) / 4.0
    return nodes.T, shapes, points, areas


def growing_lines(start: float, end: float, first: float, growth: float) -> NDArray[np.float64]:
    """Return lines from `start` to `end`, with a first cell near `first`, growing by `growth`.

    Examples
    --------
    >>> growing_lines(0.0, 7.0, 1.0, 2.0)
    array([0., 1., 3., 7.])
    """
    count = max(1, round(np.log1p((end - start) * (growth - 1.0) / first) / np.log(growth)))
    lines = np.concatenate([[0.0], np.cumsum(growth ** np.arange(count))])
    return start + (end - start) * lines / lines[-1]


def edge_lines(
    reach: float, count: int, exponent: float, far_exponent: float = 1.0
) -> NDArray[np.float64]:
    """Return lines from 0 to `reach` with cells refined towards 0 and growing beyond 1.

    The cell size at t is proportional to ``t^exponent (1 + t)^(far_exponent - exponent)``: the
    first power suits a field with a root or a singularity at 0, the second a field that decays with
    1 + t.

    Examples
    --------
    >>> np.round(edge_lines(3.0, 4, 0.5), 3)
    array([0.   , 0.112, 0.5  , 1.337, 3.   ])
    """
    # t = reach s^(1/(1 - exponent)) makes the integral of 1/size smooth
    s = np.linspace(0.0, 1.0, 4001)
    t = reach * s ** (1.0 / (1.0 - exponent))
    number = cumulative_simpson((1.0 + t) ** (exponent - far_exponent), x=s, initial=0.0)
    place = np.interp(np.linspace(0.0, number[-1], count + 1), number, s)
    return reach * place ** (1.0 / (1.0 - exponent))


def graded_lines(start: float, end: float, count: int, exponent: float) -> NDArray[np.float64]:
    """Return lines from `start` to `end`, refined towards `end`.

    The distance to `end` is proportional to ``(j/count)^(1/(1 - exponent))``; exponent 0 is
    uniform.
    """
    return end - (end - start) * np.linspace(1.0, 0.0, count + 1) ** (1.0 / (1.0 - exponent))


def ring_mesh(
    rings: NDArray[np.float64],
    depths: NDArray[np.float64],
    *,
    core_cells: int,
    round_from: float,
    stretch: tuple[float, float] = (1.0, 1.0),
    planes: Planes = (True, True),
) -> GradedMesh:
    """Return a cylinder of 27-node hexahedra: a square core with circular rings.

    Parameters
    ----------
    rings : (m + 1,)
        Radii of the mesh circles; the first is the half-width of the core along the axes.
    depths : (k + 1,)
        Depths of the mesh planes, from 0.
    core_cells : int
        Cells per half-width of the core and per 45 degrees of the rings.
    round_from : float
        Radius of the first true circle (one of `rings`).
    stretch : (float, float)
        Factors on x and y that stretch circles up to radius 1 to ellipses; beyond, they become
        round again, so that the outer boundary is equidistant from the load.
    planes : (bool, bool)
        Symmetry planes x = 0 and y = 0; with both, only the quadrant x, y >= 0 is meshed.
    """
    points, cells = _quadrant(rings, core_cells, round_from)
    for axis in (0, 1):
        if not planes[axis]:
            points, cells = _mirrored(points, cells, axis)
    points, cells = _merged(points, cells)
    points = stretched(points, np.asarray(stretch), rings[-1])
    mesh = _extruded(points, cells, depths)
    radius = np.hypot(mesh.p[0], mesh.p[1])
    rim = radius > rings[-1] * max(stretch) * (1 - 1e-9)
    return _with_boundaries(mesh, rim, depths[-1], planes)


def tensor_mesh(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    z: NDArray[np.float64],
    *,
    order: int,
    planes: Planes,
) -> GradedMesh:
    """Return a mesh of a box with planes x, y, z; `order` 1 (8 nodes) or 2 (27 nodes)."""
    mesh = MeshHex.init_tensor(x, y, z)
    sides = [mesh.p[0] == x[-1], mesh.p[1] == y[-1]]
    sides += [mesh.p[axis] == line[0] for axis, line in enumerate((x, y)) if not planes[axis]]
    if order == 2:
        mesh = MeshHex2.from_mesh(mesh)
    return _with_boundaries(mesh, sides, z[-1], planes)


def _quadrant(
    rings: NDArray[np.float64], cells: int, round_from: float
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return points and 3 x 3 node blocks of a quarter disc: the core, and rings of two sectors."""
    core = rings[0]
    corner = 0.85 * core
    s = np.linspace(0.0, 1.0, 2 * cells + 1)
    u, v = np.meshgrid(s, s, indexing="ij")
    # bilinear core with the corners (0, 0), (core, 0), (corner, corner), (0, core)
    blocks = [np.stack([u * (core + v * (corner - core)), v * (core + u * (corner - core))], -1)]
    inner = blocks[0][-1, :]
    angle = 0.25 * np.pi * s
    arc = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    radii = _with_midpoints(rings)
    # linear from the square to the circle `round_from`, circles beyond it
    fraction = np.clip((radii - rings[0]) / (round_from - rings[0]), 0.0, 1.0)[:, None, None]
    circle = arc * np.maximum(radii, round_from)[:, None, None]
    sector = (1.0 - fraction) * inner + fraction * circle
    blocks += [sector, sector[..., ::-1]]
    return _stacked(blocks)


def stretched(
    points: NDArray[np.float64], stretch: NDArray[np.float64], reach: float
) -> NDArray[np.float64]:
    """Return points stretched to ellipses within radius 1, and to circles at `reach`."""
    radius = np.hypot(points[:, 0], points[:, 1])
    rounding = np.clip((radius - 1.0) / (reach - 1.0), 0.0, 1.0)[:, None]
    return points * (stretch + (stretch.max() - stretch) * rounding)


def _stacked(
    blocks: list[NDArray[np.float64]],
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return all lattice points in one array, and the 3 x 3 node numbers of every cell."""
    points, cells, start = [], [], 0
    for block in blocks:
        numbers = start + np.arange(block.shape[0] * block.shape[1]).reshape(block.shape[:2])
        windows = np.lib.stride_tricks.sliding_window_view(numbers, (3, 3))[::2, ::2]
        cells.append(windows.reshape(-1, 3, 3))
        points.append(block.reshape(-1, 2))
        start += numbers.size
    return np.concatenate(points), np.concatenate(cells)


def _mirrored(
    points: NDArray[np.float64], cells: NDArray[np.int64], axis: int
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Return both sides of a plane of symmetry (with duplicate shared nodes)."""
    sign = np.where(np.arange(2) == axis, -1, 1)
    return np.concatenate([points, points * sign]), np.concatenate([cells, cells + len(points)])


def _merged(
    points: NDArray[np.float64], cells: NDArray[np.int64]
) -> tuple[NDArray[np.float64], NDArray[np.int64]]:
    """Merge coincident points."""
    # lattices match to rounding; 1e-9 is far above rounding and far below any cell size
    keys = np.round(points * 1e9).astype(np.int64)
    _, index, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    points = np.where(np.abs(points) < 1e-12, 0.0, points)
    return points[index], inverse.reshape(-1)[cells]


def _with_midpoints(lines: NDArray[np.float64]) -> NDArray[np.float64]:
    result = np.empty(2 * len(lines) - 1)
    result[::2] = lines
    result[1::2] = 0.5 * (lines[:-1] + lines[1:])
    return result


def _extruded(
    points: NDArray[np.float64], cells: NDArray[np.int64], depths: NDArray[np.float64]
) -> MeshHex2:
    """Return 27-node hexahedra over plane 9-node cells."""
    z = _with_midpoints(depths)
    layer = len(points)
    nodes = np.concatenate([np.tile(points, (len(z), 1)), np.repeat(z, layer)[:, None]], axis=1)
    offsets = layer * (2 * np.arange(len(depths) - 1)[:, None] + np.arange(3))
    blocks = cells[None, :, :, :, None] + offsets[:, None, None, None, :]
    return _triquadratic(nodes, blocks.reshape(-1, 3, 3, 3))


def _triquadratic(nodes: NDArray[np.float64], blocks: NDArray[np.int64]) -> MeshHex2:
    """Return a scikit-fem mesh with the given lattice points as nodes of its elements."""
    i, j, k = (2 * ElementHex1.doflocs.T).astype(int)
    corners = blocks[:, i, j, k]
    used, t = np.unique(corners, return_inverse=True)
    t = t.reshape(corners.shape).T
    straight = MeshHex(np.ascontiguousarray(nodes[used].T), np.ascontiguousarray(t))
    mesh = MeshHex2.from_mesh(straight)
    i, j, k = (2 * ElementHex2.doflocs.T).astype(int)
    locations = np.array(mesh.doflocs)
    locations[:, mesh.dofs.element_dofs] = nodes[blocks[:, i, j, k]].transpose(2, 1, 0)
    return MeshHex2(locations, mesh.t)


def _with_boundaries(
    mesh: MeshHex,
    sides: NDArray[np.bool_] | list[NDArray[np.bool_]],
    depth: float,
    planes: Planes,
) -> GradedMesh:
    """Return the mesh with surface and outer facets, identified by corner nodes."""

    def on(corners: NDArray[np.bool_]) -> NDArray[np.bool_]:
        return corners[mesh.facets].all(axis=0)

    vertices = slice(0, int(mesh.t.max()) + 1)
    sides = sides if isinstance(sides, list) else [sides[vertices]]
    bottom = mesh.p[2, vertices] == depth
    outer = np.any([on(side) for side in [*sides, bottom]], axis=0)
    surface = on(mesh.p[2, vertices] == 0.0)
    return GradedMesh(mesh, np.flatnonzero(surface), np.flatnonzero(outer), planes)
