"""Meshes of half-spaces: for one round contact, and for a rectangular grid of contact points."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from reference.arguments import choice_faults, count_faults, positive_faults, refuse
from reference.fem.mesh import (
    GradedMesh,
    Planes,
    edge_lines,
    graded_lines,
    growing_lines,
    ring_mesh,
    stretched,
    tensor_mesh,
)

Region = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.bool_]]

# Planes of symmetry x = 0 and y = 0, of which only the positive sides are meshed.
SYMMETRIES = {
    "none": (False, False),
    "half_x": (True, False),
    "half_y": (False, True),
    "quarter": (True, True),
}
# Beyond these limits the elements are too distorted for a definite matrix in double precision.
LARGEST_ASPECT, LARGEST_EXTENT = 100, 1000


class Meshed(NamedTuple):
    """A meshed block of a half-space, lengths in units of `length`.

    Attributes
    ----------
    grid : GradedMesh
    candidate : callable
        Function that selects candidate surface nodes (x, y).
    sources : (float, float)
        Distances in x and y of the outer point forces of the far field from the centre.
    length, spacing : float
        Unit of length, and size of the surface elements in the contact.
    offset : (2,)
        Positions minus mesh coordinates (the mesh is centred).
    ring, stretch
        As for `CondensedBody`.
    """

    grid: GradedMesh
    candidate: Region
    sources: tuple[float, float]
    length: float
    spacing: float
    offset: NDArray[np.float64]
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

        Examples
        --------
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

    def _lines(self) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
        """Return mesh circles and depths in contact radii, and core cells."""
        if self.edge:
            return _edge_rings(self.elements, self._ring, self.sharp, self.extent, self.stretch)
        return _even_rings(self.elements, self.extent, self.stretch)

    @property
    def _ring(self) -> float:
        """Radius of the mesh circle at the edge over the contact radius."""
        return 1.0 if self.edge is None else self.edge / self.contact_radius

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
        limits = _candidate_reach(rings, stretch, self.extent)
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


def _candidate_reach(
    rings: NDArray[np.float64], stretch: tuple[float, float], extent: float
) -> NDArray[np.float64]:
    """Return the semi-axes of the mesh ellipse at or next to 1.2 contact radii."""
    limit = rings[np.searchsorted(rings, 1.2 - 1e-9)]
    return stretched(np.diag([limit, limit]), np.asarray(stretch), extent).diagonal()


def _even_rings(
    elements: int, extent: float, stretch: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return mesh circles and depths in contact radii, and core cells, without an edge."""
    cells = max(1, round(0.5 * elements))
    growth = 1.0 + 1.2 / np.sqrt(elements)
    inside = np.linspace(0.5, 1.0, cells + 1)
    size = 0.5 / cells
    outer = growing_lines(1.0, extent, size, growth)
    first = 0.8 * size * min(stretch)
    depths = growing_lines(0.0, extent * max(stretch), first, growth)
    return np.concatenate([inside, outer[1:]]), depths, cells


def _edge_rings(
    elements: int, ring: float, sharp: bool, extent: float, stretch: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Return mesh circles and depths in contact radii, and core cells, with an edge at `ring`.

    Cells are refined towards the edge. If the pressure vanishes as a square root, cell sizes
    proportional to the root of the distance give fourth order in the number of cells; at a sharp
    edge, where it is singular, the power is 3/4 (the last cell and the error are then proportional
    to count^-4). A circular contact is smooth along the edge, where two cells per 45 degrees
    suffice for 1e-5.
    """
    exponent = 0.75 if sharp else 0.5
    cells = max(2, -(-elements // 4)) if sharp else -(-elements // 2)
    core = 0.5 if sharp else 0.55
    inside = graded_lines(core, 1.0, elements if sharp else cells, exponent)

    def outward(reach: float) -> NDArray[np.float64]:
        # as many cells per factor of e as in a mesh of radius 2.5
        count = round(1.5 * elements * np.log1p(reach) / np.log1p(1.5))
        return edge_lines(reach, count, exponent)

    outer = outward(extent / ring - 1.0)
    narrow, wide = min(stretch), max(stretch)
    depths = ring * narrow * outward(extent * wide / (ring * narrow))
    return ring * np.concatenate([inside, 1.0 + outer[1:]]), depths, cells


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

    x: NDArray[np.float64]
    y: NDArray[np.float64]
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

        Examples
        --------
        >>> mesh = TensorMesh(np.linspace(0.0, 1.0, 4), np.linspace(0.0, 1.0, 4))
        >>> mesh.unknowns == mesh.meshed().grid.mesh.p.size
        True
        """
        return 3 * int(np.prod(self.lattice))

    @property
    def lattice(self) -> tuple[int, int, int]:
        """Number of nodes along x, y and z."""
        x, y, _, _ = self._scaled()
        lines = _tensor_planes(x, y, SYMMETRIES[self.symmetry], self.extent, self.growth)
        nodes = [self.order * (len(line) - 1) + 1 for line in lines]
        return nodes[0], nodes[1], nodes[2]

    def meshed(self) -> Meshed:
        """Return the mesh."""
        planes = SYMMETRIES[self.symmetry]
        x, y, length, offset = self._scaled()
        lines = _tensor_planes(x, y, planes, self.extent, self.growth)
        (x0, x1), (y0, y1) = [(line[0], line[-1]) for line in (x, y)]
        return Meshed(
            tensor_mesh(*lines, order=self.order, planes=planes),
            lambda px, py: (px >= x0) & (px <= x1) & (py >= y0) & (py <= y1),
            (0.5 * x1, 0.5 * y1),
            length=length,
            spacing=float(np.sqrt(np.mean(np.diff(x)) * np.mean(np.diff(y)))),
            offset=offset,
        )

    def _scaled(
        self,
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], float, NDArray[np.float64]]:
        """Return the centred lines, the unit of length, and the original centre in this unit."""
        planes = SYMMETRIES[self.symmetry]
        length = 2.0 ** round(np.log2(_half_width(self.x, self.y, planes)))
        centre = [
            0.0 if plane else 0.5 * (line[0] + line[-1])
            for line, plane in zip((self.x, self.y), planes, strict=True)
        ]
        x, y = (self.x - centre[0]) / length, (self.y - centre[1]) / length
        return x, y, length, np.array(centre) / length


def _half_width(x: NDArray[np.float64], y: NDArray[np.float64], planes: Planes) -> float:
    """Return the larger half-width of the grid, with its mirror images."""
    widths = [
        np.ptp(line) if plane else 0.5 * np.ptp(line)
        for line, plane in zip((x, y), planes, strict=True)
    ]
    return float(max(widths))


def _tensor_planes(
    x: NDArray[np.float64], y: NDArray[np.float64], planes: Planes, extent: float, growth: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Return the mesh planes in x, y and z of the centred grid and the surrounding block."""
    reach = extent * _half_width(x, y, planes)
    wide_x, wide_y = (
        _extended(line, reach, growth, plane) for line, plane in zip((x, y), planes, strict=True)
    )
    finest = min(np.min(np.diff(line)) for line in (x, y))
    return wide_x, wide_y, growing_lines(0.0, reach, finest, growth)


def _extended(
    line: NDArray[np.float64], reach: float, growth: float, symmetric: bool
) -> NDArray[np.float64]:
    """Return grid lines with growing cells up to the boundary of the mesh."""
    right = growing_lines(line[-1], reach, growth * (line[-1] - line[-2]), growth)[1:]
    if symmetric:
        return np.concatenate([line, right])
    left = -growing_lines(-line[0], reach, growth * (line[1] - line[0]), growth)[1:]
    return np.concatenate([left[::-1], line, right])
