"""Hexahedral meshes of a part of a half-space: fitted to one contact, or to a grid of points.

z points into the half-space, the surface is z = 0. Curved rings have exact mid-nodes.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_simpson
from skfem import MeshHex, MeshHex2

from reference.arrays import Array, Integers, Mask
from reference.errors import choice_faults, count_faults, positive_faults, refuse
from reference.fem.solid_mesh import KINDS, SolidMesh

Planes = tuple[bool, bool]
Region = Callable[[Array, Array], Mask]

# Whether x = 0 and y = 0 are planes of symmetry, of which only the positive sides are meshed.
SYMMETRIES = {
    "none": (False, False),
    "half_x": (True, False),
    "half_y": (False, True),
    "quarter": (True, True),
}
# Beyond these limits the elements are too distorted for a definite matrix in double precision.
LARGEST_ASPECT, LARGEST_EXTENT = 100, 1000


def growing_lines(start: float, end: float, first: float, growth: float) -> Array:
    """Return lines from `start` to `end`, with a first cell near `first`, growing by `growth`.

    >>> growing_lines(0.0, 7.0, 1.0, 2.0)
    array([0., 1., 3., 7.])
    """
    count = max(1, round(np.log1p((end - start) * (growth - 1.0) / first) / np.log(growth)))
    lines = np.concatenate([[0.0], np.cumsum(growth ** np.arange(count))])
    return start + (end - start) * lines / lines[-1]


def graded_lines(start: float, end: float, count: int, exponent: float) -> Array:
    """Return lines from `start` to `end`, refined towards `end`.

    The distance to `end` is proportional to ``(j/count)^(1/(1 - exponent))``; exponent 0 is
    uniform.
    """
    return end - (end - start) * np.linspace(1.0, 0.0, count + 1) ** (1.0 / (1.0 - exponent))


def power_lines(cells: int, exponent: float, end: float) -> Array:
    """Return lines from 0 to `end` at t^exponent (1 + t)^2 with t = j/cells, but for a factor.

    >>> power_lines(2, 1.0, 4.0).round(3).tolist()
    [0.0, 1.125, 4.0]
    """
    t = np.arange(64 * cells) / cells
    grown = t**exponent * (1 + t) ** 2
    last = int(np.searchsorted(grown, end))
    return grown[: last + 1] * (end / grown[last])


@dataclass(frozen=True, eq=False)
class GradedMesh:
    """A mesh, its facets at z = 0 and towards the unmeshed exterior, and its planes of symmetry."""

    mesh: MeshHex
    surface: Integers
    outer: Integers
    planes: Planes = (False, False)

    @property
    def held(self) -> Mask:
        """The displacements (nodes, 3) that symmetry holds."""
        held = np.zeros((self.mesh.p.shape[1], 3), dtype=bool)
        for axis, plane in enumerate(self.planes):
            held[:, axis] = plane & (self.mesh.p[axis] == 0.0)
        return held


def ring_mesh(
    rings: Array,  # radii of the circles; the first is the half-width of the core along the axes
    depths: Array,  # of the mesh planes, from 0
    *,
    core_cells: int,  # per half-width of the core and per 45 degrees of the rings
    round_from: float,  # radius of the first true circle, one of the rings
    stretch: tuple[float, float] = (1.0, 1.0),
    planes: Planes = (True, True),  # symmetry about x = 0, y = 0: the positive sides are meshed
) -> GradedMesh:
    """Return a cylinder of 27-node hexahedra: a square core with circular rings.

    Stretched in x and y, circles up to radius 1 are ellipses; beyond, they become round again, so
    that the outer boundary is equidistant from the load.
    """
    # a quarter disc of lattices: a bilinear core with the corners (0, 0), (core, 0),
    # (corner, corner), (0, core), and two sectors, linear from the square to the circle
    # `round_from`, circles beyond it
    core, corner = rings[0], 0.85 * rings[0]
    s = np.linspace(0.0, 1.0, 2 * core_cells + 1)
    u, v = np.meshgrid(s, s, indexing="ij")
    square = np.stack([u * (core + v * (corner - core)), v * (core + u * (corner - core))], -1)
    angle = 0.25 * np.pi * s
    arc = np.stack([np.cos(angle), np.sin(angle)], axis=-1)
    radii = _with_midpoints(rings)
    fraction = np.clip((radii - core) / (round_from - core), 0.0, 1.0)[:, None, None]
    circle = arc * np.maximum(radii, round_from)[:, None, None]
    sector = (1.0 - fraction) * square[-1, :] + fraction * circle
    # every cell is a 3 x 3 block of numbers into one array of points
    parts, blocks, start = [], [], 0
    for lattice in (square, sector, sector[..., ::-1]):
        numbers = start + np.arange(lattice.shape[0] * lattice.shape[1]).reshape(lattice.shape[:2])
        windows = np.lib.stride_tricks.sliding_window_view(numbers, (3, 3))[::2, ::2]
        blocks.append(windows.reshape(-1, 3, 3))
        parts.append(lattice.reshape(-1, 2))
        start += numbers.size
    points, cells = np.concatenate(parts), np.concatenate(blocks)
    # both sides of what is no plane of symmetry
    for axis in (0, 1):
        if not planes[axis]:
            sign = np.where(np.arange(2) == axis, -1, 1)
            cells = np.concatenate([cells, cells + len(points)])
            points = np.concatenate([points, points * sign])
    # coincident points match to rounding; 1e-9 is far above it and far below any cell size
    keys = np.round(points * 1e9).astype(np.int64)
    _, index, inverse = np.unique(keys, axis=0, return_index=True, return_inverse=True)
    points = np.where(np.abs(points) < 1e-12, 0.0, points)[index]
    cells = inverse.reshape(-1)[cells]
    points = stretched(points, np.asarray(stretch), rings[-1])
    # extruded along the depth: 3 x 3 x 3 nodes of a cell, in scikit-fem's order
    z, layer, kind = _with_midpoints(depths), len(points), KINDS["hexahedron27"]
    nodes = np.concatenate([np.tile(points, (len(z), 1)), np.repeat(z, layer)[:, None]], axis=1)
    levels = layer * (2 * np.arange(len(depths) - 1)[:, None] + np.arange(3))
    bricks = (cells[None, :, :, :, None] + levels[:, None, None, None, :]).reshape(-1, 3, 3, 3)
    i, j, k = (2 * kind.locations.T).astype(int)
    mesh, _ = SolidMesh(kind, nodes, bricks[:, i, j, k]).to_scikit()
    rim = np.hypot(mesh.p[0], mesh.p[1]) > rings[-1] * max(stretch) * (1 - 1e-9)
    return _with_boundaries(mesh, [rim], depths[-1], planes)


def tensor_mesh(x: Array, y: Array, z: Array, *, order: int, planes: Planes) -> GradedMesh:
    """Return a mesh of a box with planes x, y, z; `order` 1 (8 nodes) or 2 (27 nodes)."""
    mesh = MeshHex.init_tensor(x, y, z)
    if order == 2:
        mesh = MeshHex2.from_mesh(mesh)
    sides = [mesh.p[0] == x[-1], mesh.p[1] == y[-1]]
    sides += [mesh.p[axis] == line[0] for axis, line in enumerate((x, y)) if not planes[axis]]
    return _with_boundaries(mesh, sides, z[-1], planes)


def stretched(points: Array, stretch: Array, reach: float) -> Array:
    """Return points stretched to ellipses within radius 1, and to circles at `reach`."""
    radius = np.hypot(points[:, 0], points[:, 1])
    rounding = np.clip((radius - 1.0) / (reach - 1.0), 0.0, 1.0)[:, None]
    return points * (stretch + (stretch.max() - stretch) * rounding)


def _with_midpoints(lines: Array) -> Array:
    result = np.empty(2 * len(lines) - 1)
    result[::2] = lines
    result[1::2] = 0.5 * (lines[:-1] + lines[1:])
    return result


def _with_boundaries(mesh: MeshHex, sides: list[Mask], depth: float, planes: Planes) -> GradedMesh:
    """Return the mesh with surface and outer facets, those with all corners on a side."""
    surface, *outer = (
        side[mesh.facets].all(axis=0) for side in (mesh.p[2] == 0.0, mesh.p[2] == depth, *sides)
    )
    return GradedMesh(mesh, np.flatnonzero(surface), np.flatnonzero(np.any(outer, axis=0)), planes)


class Meshed(NamedTuple):
    """A meshed block of a half-space, lengths in units of `length`; see `CondensedBody`."""

    grid: GradedMesh
    candidate: Region  # selects candidate surface nodes (x, y)
    sources: tuple[float, float]  # of the outer point forces of the far field from the centre
    length: float
    spacing: float  # size of the surface elements in the contact
    offset: Array  # (2,), positions minus mesh coordinates (the mesh is centred)
    ring: float | None = None
    stretch: tuple[float, float] = (1.0, 1.0)


@dataclass(frozen=True)
class RingMesh:
    """A mesh for one contact inside a circle or ellipse.

    27-node hexahedra in rings around a square core, with a mesh circle exactly at the contact
    radius (or at `edge`), in a cylinder of radius and depth ``extent`` contact radii.

    Parameters
    ----------
    contact_radius : float
        Contact radius at the largest load; candidates extend to 1.3 times this radius.
    elements : int
        Elements (two node spacings) per contact radius.
    symmetry : {"quarter", "half_x", "half_y", "none"}
        "quarter" for gaps even in x and y, with a quarter of the work; "half_x" for gaps even in x
        (only x >= 0 is meshed), "half_y" in y.
    edge : float, optional
        Radius of a sharp edge or a kink of the indenter, at most `contact_radius`. The mesh has a
        circle there, towards which the elements are refined.
    sharp : bool
        Edge of a flat punch: more rings, with stronger refinement.
    stretch : (float, float)
        Factors on x and y: contact ellipse with semi-axes ``contact_radius * stretch``, up to
        1:100.
    extent : float
        Radius and depth of the mesh in contact radii, 2 to 1000.
    """

    contact_radius: float
    elements: int = 6
    symmetry: str = "quarter"
    edge: float | None = None
    sharp: bool = False
    stretch: tuple[float, float] = (1.0, 1.0)
    extent: float = 2.5

    # 27-node elements have a mixed form, too.
    order = 2

    def __post_init__(self) -> None:
        radius, edge, stretch = self.contact_radius, self.edge, self.stretch
        faults = positive_faults(contact_radius=radius) + count_faults(2, elements=self.elements)
        faults += choice_faults("symmetry", self.symmetry, tuple(SYMMETRIES))
        if edge is not None and not 0.2 * radius <= edge <= radius:
            faults.append(
                f"edge must lie between 0.2 and 1 contact_radius ({radius!r}), not {edge!r}"
            )
        if len(stretch) != 2 or not all(np.isfinite(s) and s > 0.0 for s in stretch):
            faults.append(f"stretch must be two positive factors, not {stretch!r}")
        elif max(stretch) > LARGEST_ASPECT * min(stretch):
            faults.append(f"stretch must be at most 1:{LARGEST_ASPECT}, not {stretch!r}")
        if not 2.0 <= self.extent <= LARGEST_EXTENT:
            faults.append(
                f"extent must be 2 to {LARGEST_EXTENT} contact radii, not {self.extent!r}"
            )
        refuse(faults)

    @property
    def unknowns(self) -> int:
        """Number of displacements of the mesh, without constructing it.

        >>> mesh = RingMesh(1.0, elements=2, symmetry="half_x")
        >>> mesh.unknowns == mesh.meshed().grid.mesh.p.size
        True
        """
        _, outward, down = self.lattice
        cells = self._lines()[2]
        rings = outward - cells - 1
        # of a quarter, and of those on a line of symmetry
        quarter, line = (2 * cells + 1) ** 2 + rings * (4 * cells + 1), 2 * cells + 1 + rings
        plane = {"quarter": quarter, "none": 4 * (quarter - line) + 1}
        return 3 * plane.get(self.symmetry, 2 * quarter - line) * down

    @property
    def lattice(self) -> tuple[int, int, int]:
        """Number of nodes around the contact, outward and down."""
        rings, depths, cells = self._lines()
        quarters = 4 // 2 ** sum(SYMMETRIES[self.symmetry])
        return quarters * 4 * cells + 1, 2 * len(rings) - 1 + cells, 2 * len(depths) - 1

    @property
    def _ring(self) -> float:
        """Radius of the mesh circle at the edge over the contact radius."""
        return 1.0 if self.edge is None else self.edge / self.contact_radius

    def _lines(self) -> tuple[Array, Array, int]:
        """Return mesh circles and depths in contact radii, and core cells.

        Towards an edge, cells are refined. If the pressure vanishes as a square root, cell sizes
        proportional to the root of the distance give fourth order in the number of cells; at a
        sharp edge, where it is singular, the power is 3/4 (the last cell and the error are then
        proportional to count^-4). A circular contact is smooth along the edge, where two cells per
        45 degrees suffice for 1e-5.
        """
        elements, extent = self.elements, self.extent
        narrow, wide = min(self.stretch), max(self.stretch)
        if not self.edge:
            cells = max(1, round(0.5 * elements))
            size, growth = 0.5 / cells, 1.0 + 1.2 / np.sqrt(elements)
            outer = growing_lines(1.0, extent, size, growth)
            depths = growing_lines(0.0, extent * wide, 0.8 * size * narrow, growth)
            return np.concatenate([np.linspace(0.5, 1.0, cells + 1), outer[1:]]), depths, cells
        ring, sharp = self._ring, self.sharp
        core, exponent = (0.5, 0.75) if sharp else (0.55, 0.5)
        cells = max(2, -(-elements // 4)) if sharp else -(-elements // 2)
        inside = graded_lines(core, 1.0, elements if sharp else cells, exponent)

        def outward(reach: float) -> Array:
            # cells of a size ~ t^exponent (1 + t)^(1 - exponent) at t: the first power suits a
            # field with a root or a singularity at 0, the second one that decays with 1 + t. As
            # many per factor of e as in a mesh of radius 2.5; t = reach s^(1/(1 - exponent)) makes
            # the integral of 1/size smooth
            count = round(1.5 * elements * np.log1p(reach) / np.log1p(1.5))
            s = np.linspace(0.0, 1.0, 4001)
            grown = (1.0 + reach * s ** (1.0 / (1.0 - exponent))) ** (exponent - 1.0)
            number = cumulative_simpson(grown, x=s, initial=0.0)
            place = np.interp(np.linspace(0.0, number[-1], count + 1), number, s)
            return reach * place ** (1.0 / (1.0 - exponent))

        outer = outward(extent / ring - 1.0)
        depths = ring * narrow * outward(extent * wide / (ring * narrow))
        return ring * np.concatenate([inside, 1.0 + outer[1:]]), depths, cells

    def meshed(self) -> Meshed:
        """Return the mesh."""
        stretch, ring = self.stretch, self._ring
        rings, depths, cells = self._lines()
        grid = ring_mesh(
            rings,
            depths,
            core_cells=cells,
            round_from=ring,
            stretch=stretch,
            planes=SYMMETRIES[self.symmetry],
        )
        # candidates lie within the mesh ellipse at or next to 1.2 contact radii
        limit = rings[np.searchsorted(rings, 1.2 - 1e-9)]
        limits = stretched(np.diag([limit, limit]), np.asarray(stretch), self.extent).diagonal()
        return Meshed(
            grid,
            lambda x, y: np.hypot(x / limits[0], y / limits[1]) <= 1.0 + 1e-9,
            (0.6 * stretch[0], 0.6 * stretch[1]),
            length=self.contact_radius,
            spacing=float(np.sqrt(stretch[0] * stretch[1])) / self.elements,
            offset=np.zeros(2),
            ring=ring,
            stretch=stretch,
        )


@dataclass(frozen=True, eq=False)
class TensorMesh:
    """A mesh with a rectangular grid of candidate contact points.

    Grid lines are vertical; cells grow beyond the grid and with depth.

    Parameters
    ----------
    x, y : (nx,), (ny,)
        Strictly increasing mesh lines. All crossings are candidates (with ``order=2`` also
        mid-points), in C order: index ``i * ny + j`` for ``(x_i, y_j)``. On a plane of symmetry
        they start at 0.
    symmetry : {"none", "half_x", "half_y", "quarter"}
        As of `RingMesh`.
    order : {1, 2}
        8-node or 27-node hexahedra.
    extent : float
        Distance of the outer boundary from the centre, in half-widths of the grid.
    growth : float
        Ratio of neighbouring cell sizes outside the grid.
    """

    x: Array
    y: Array
    symmetry: str = "none"
    order: int = 1
    extent: float = 3.0
    growth: float = 1.5

    def __post_init__(self) -> None:
        faults = choice_faults("symmetry", self.symmetry, tuple(SYMMETRIES))
        faults += choice_faults("order", self.order, (1, 2))
        for name, plane in zip("xy", SYMMETRIES.get(self.symmetry, (False, False)), strict=True):
            line = np.asarray(getattr(self, name), dtype=float)
            object.__setattr__(self, name, line)
            if line.ndim != 1 or len(line) < 2 or not np.all(np.diff(line) > 0.0):
                faults.append(
                    f"{name} must be strictly increasing, at least 2 values, not {line!r}"
                )
            elif plane and line[0] != 0.0:
                faults.append(
                    f"{name} must start at 0 with {self.symmetry} symmetry, not {float(line[0])!r}"
                )
        if not 1.5 <= self.extent <= LARGEST_EXTENT:
            faults.append(
                f"extent must be 1.5 to {LARGEST_EXTENT} half-widths, not {self.extent!r}"
            )
        if not 1.0 < self.growth <= 4.0:
            faults.append(f"growth must lie in (1, 4], not {self.growth!r}")
        refuse(faults)

    @property
    def unknowns(self) -> int:
        """Number of displacements of the mesh, without constructing it.

        >>> mesh = TensorMesh(np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, 4))
        >>> mesh.unknowns == mesh.meshed().grid.mesh.p.size
        True
        """
        return 3 * int(np.prod(self.lattice))

    @property
    def lattice(self) -> tuple[int, int, int]:
        """Number of nodes along x, y and z."""
        nodes = [self.order * (len(line) - 1) + 1 for line in self._lines()[0]]
        return nodes[0], nodes[1], nodes[2]

    def meshed(self) -> Meshed:
        """Return the mesh."""
        lines, (x, y), length, offset = self._lines()
        (x0, x1), (y0, y1) = [(line[0], line[-1]) for line in (x, y)]
        return Meshed(
            tensor_mesh(*lines, order=self.order, planes=SYMMETRIES[self.symmetry]),
            lambda px, py: (px >= x0) & (px <= x1) & (py >= y0) & (py <= y1),
            (0.5 * x1, 0.5 * y1),
            length=length,
            spacing=float(np.sqrt(np.mean(np.diff(x)) * np.mean(np.diff(y)))),
            offset=offset,
        )

    def _lines(self) -> tuple[list[Array], list[Array], float, Array]:
        """Return planes x, y, z, the centred grid, the unit of length, and the centre in it."""
        planes, growth = SYMMETRIES[self.symmetry], self.growth

        def half_width(*grid: Array) -> float:
            pairs = zip(grid, planes, strict=True)
            return float(max(np.ptp(line) * (1.0 if plane else 0.5) for line, plane in pairs))

        # a power of two, by which nothing is rounded
        length = 2.0 ** round(np.log2(half_width(self.x, self.y)))
        centre = np.array(
            [
                0.0 if plane else 0.5 * (line[0] + line[-1])
                for line, plane in zip((self.x, self.y), planes, strict=True)
            ]
        )
        grid = [(line - c) / length for line, c in zip((self.x, self.y), centre, strict=True)]
        reach = self.extent * half_width(*grid)
        lines = []
        for line, plane in zip(grid, planes, strict=True):
            right = growing_lines(line[-1], reach, growth * (line[-1] - line[-2]), growth)[1:]
            left = -growing_lines(-line[0], reach, growth * (line[1] - line[0]), growth)[1:]
            lines.append(np.concatenate([left[:0] if plane else left[::-1], line, right]))
        finest = min(np.min(np.diff(line)) for line in grid)
        return [*lines, growing_lines(0.0, reach, finest, growth)], grid, length, centre / length
