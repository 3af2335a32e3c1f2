"""A linear-elastic half-space condensed once onto the points that may touch."""

from __future__ import annotations

import time
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.fem.elasticity import lame_parameters, stiffness_matrices
from reference.fem.far_field import exterior_stiffness, group_field, source_groups
from reference.fem.mesh import (
    GradedMesh,
    facet_nodes,
    facet_quadrature,
    graded_lines,
    growing_lines,
    ring_mesh,
    stretched,
    tensor_mesh,
)
from reference.fem.nested_dissection import LinearSystem, condense


@dataclass(frozen=True)
class CondensedBody:
    """A half-space known only through the flexibility between its candidate contact points.

    The body is linear, so one condensation serves every gap and every load. Numbers are kept for a
    unit Young's modulus and lengths in units of `length`; the properties return consistent units.

    Attributes
    ----------
    length, youngs_modulus : float
        The units in which the scaled quantities are kept.
    poisson_ratio : float
    scaled_points : (n, 2)
        Candidate positions on the surface / length.
    scaled_weights : (n,)
        Area that belongs to each candidate / length^2 (of the meshed part).
    scaled_compliance : (n, n)
        Normal displacement at i for a unit normal force at j (meshed part), times E length.
    symmetry : int
        Number of equal parts of which one is meshed: 4 with quarter symmetry, otherwise 1.
    offset : (2,)
        What the mesh coordinates lack to `scaled_points` (the mesh is centred).
    spacing_scaled : float
        Size of the surface elements in the contact / length.
    ring : float or None
        Radius of the mesh circle / length before stretching; None for a tensor body.
    stretch : (float, float)
        Semi-axes of the mesh ellipse over the radius of the circle.
    unknowns : int
        Free displacements of the mesh and far-field unknowns.
    solver : str
        What condensed the body.
    seconds : dict
        Time spent on "mesh", "assembly", "condensation".
    grid : GradedMesh
    system : LinearSystem
        For the recovery of the interior.
    exterior : (k, k)
        Far-field stiffness.
    """

    length: float
    youngs_modulus: float
    poisson_ratio: float
    scaled_points: NDArray[np.float64]
    scaled_weights: NDArray[np.float64]
    scaled_compliance: NDArray[np.float64]
    symmetry: int
    offset: NDArray[np.float64]
    spacing_scaled: float
    ring: float | None
    stretch: tuple[float, float]
    unknowns: int
    solver: str
    seconds: dict[str, float]
    grid: GradedMesh
    system: LinearSystem
    exterior: NDArray[np.float64]

    @property
    def points(self) -> NDArray[np.float64]:
        """Candidate contact positions (n, 2)."""
        return self.scaled_points * self.length

    @property
    def weights(self) -> NDArray[np.float64]:
        """Tributary areas (n,) of the candidates, of the meshed part."""
        return self.scaled_weights * self.length**2

    @cached_property
    def compliance(self) -> NDArray[np.float64]:
        """Normal displacements (n, n) for unit nodal forces on the meshed part."""
        return self.scaled_compliance / (self.youngs_modulus * self.length)

    @property
    def spacing(self) -> float:
        """Size of the surface elements in the contact."""
        return self.spacing_scaled * self.length

    @cached_property
    def scaled_radii(self) -> NDArray[np.float64]:
        """Distance (n,) of the candidates from the centre / length, before stretching."""
        return np.hypot(*(self.scaled_points / np.asarray(self.stretch)).T)

    @property
    def inside_ring(self) -> NDArray[np.bool_]:
        """Which candidates (n,) lie within or on the mesh circle; none for a tensor body."""
        return self.scaled_radii <= (0.0 if self.ring is None else self.ring * (1.0 + 1e-9))

    @property
    def effective_modulus(self) -> float:
        """``E* = E/(1 - nu^2)``; the indenter is rigid."""
        return self.youngs_modulus / (1.0 - self.poisson_ratio**2)

    def scaled(self, factor: float) -> CondensedBody:
        """Return the same mesh `factor` times larger.

        A half-space has no length, so nothing has to be solved again: compliances divide by the
        factor.
        """
        if not (np.isfinite(factor) and factor > 0.0):
            raise ValueError(f"factor must be positive and finite, got {factor!r}")
        return replace(self, length=self.length * factor)


def ball_body(
    contact_radius: float,
    youngs_modulus: float,
    poisson_ratio: float,
    *,
    elements: int = 6,
    symmetry: str = "quarter",
    edge: float | None = None,
    stretch: tuple[float, float] = (1.0, 1.0),
    far_field: str = "boussinesq",
    extent: float = 4.0,
    reduced_integration: bool = True,
) -> CondensedBody:
    """Build a half-space for one contact inside a circle or ellipse.

    27-node hexahedra in rings around a square core, with a mesh circle exactly at the contact
    radius (or at `edge`), in a cylinder of radius and depth ``extent`` contact radii; outside it
    Boussinesq fields (see `reference.fem.far_field`).

    Parameters
    ----------
    contact_radius : float
        Contact radius at the largest load; candidates reach 1.3 times as far.
    youngs_modulus, poisson_ratio : float
        ``-1 < nu <= 0.4999``.
    elements : int
        Elements per contact radius (each has two node spacings).
    symmetry : {"quarter", "none"}
        "quarter" for gaps that are even in x and in y: a fourth of the work.
    edge : float, optional
        Radius of a sharp edge or a kink of the indenter, at most `contact_radius`. The mesh has a
        circle there, towards which the elements crowd.
    stretch : (float, float)
        Factors on x and y: contact ellipse with semi-axes ``contact_radius * stretch``.
    far_field : {"boussinesq", "fixed"}
        "fixed" clamps the outer boundary; for comparisons with published models only.
    extent : float
        Radius and depth of the mesh in contact radii.
    reduced_integration : bool
        False shows locking.

    Raises
    ------
    ValueError
        For every argument out of range, with the value that came.
    """
    _check_ball(
        contact_radius,
        youngs_modulus,
        poisson_ratio,
        elements,
        symmetry,
        edge,
        stretch,
        far_field,
        extent,
    )
    started = time.perf_counter()
    ring = 1.0 if edge is None else edge / contact_radius
    rings, depths, cells = _rings(elements, ring, edge is not None, extent, stretch)
    quarter = symmetry == "quarter"
    grid = ring_mesh(
        rings,
        depths,
        core_cells=cells,
        round_from=ring,
        stretch=stretch,
        quarter=quarter,
    )
    limit = rings[np.searchsorted(rings, 1.2 - 1e-9)]
    limits = stretched(np.diag([limit, limit]), np.asarray(stretch), extent).diagonal()
    return _condensed(
        grid,
        lambda x, y: np.hypot(x / limits[0], y / limits[1]) <= 1.0 + 1e-9,
        (0.6 * stretch[0], 0.6 * stretch[1]),
        ring=ring,
        stretch=stretch,
        length=contact_radius,
        modulus=youngs_modulus,
        poisson_ratio=poisson_ratio,
        spacing=float(np.sqrt(stretch[0] * stretch[1])) / elements,
        fixed=far_field == "fixed",
        reduced_integration=reduced_integration,
        started=started,
    )


def _rings(
    elements: int, ring: float, graded: bool, extent: float, stretch: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Mesh circles and depths in units of the contact radius, and the cells of the core.

    Towards an edge the cells shrink with the square root of the distance, which suits both the
    vanishing pressure of a smooth shape and the singular one of a punch; without one they are even.
    """
    cells = max(1, round(0.5 * elements))
    growth = 1.0 + 1.2 / np.sqrt(elements)
    core = 0.5 * ring
    inside = graded_lines(core, ring, elements if graded else cells, 0.5 if graded else 0.0)
    size = inside[-1] - inside[-2]
    between = growing_lines(ring, 1.0, min(size, 1.0 / elements), growth)
    last = between[-1] - between[-2] if ring < 1.0 else size
    outside = growing_lines(1.0, extent, last, growth)
    rings = np.concatenate([inside, between[1:] if ring < 1.0 else [], outside[1:]])
    first = min(stretch) * (size if graded else 0.8 * size)
    return rings, growing_lines(0.0, extent * max(stretch), first, growth), cells


def tensor_body(
    x_nodes: NDArray[np.float64],
    y_nodes: NDArray[np.float64],
    youngs_modulus: float,
    poisson_ratio: float,
    *,
    symmetry: str = "none",
    order: int = 1,
    far_field: str = "boussinesq",
    extent: float = 3.0,
    growth: float = 1.5,
    reduced_integration: bool = True,
) -> CondensedBody:
    """Build a half-space with a rectangular grid of candidate contact points.

    The grid lines go straight down; beyond the grid and with depth the cells grow.

    Parameters
    ----------
    x_nodes, y_nodes : (nx,), (ny,)
        Strictly increasing mesh lines. All their crossings are candidates (and with ``order=2``
        the mid-points too). With quarter symmetry they start at 0.
    youngs_modulus, poisson_ratio : float
    symmetry : {"none", "quarter"}
    order : {1, 2}
        8-node or 27-node hexahedra.
    far_field : {"boussinesq", "fixed"}
    extent : float
        Distance of the outer boundary from the centre, in half-widths of the grid.
    growth : float
        Ratio of neighbouring cells outside the grid.

    Returns
    -------
    CondensedBody
        Candidates in C order: index ``i * ny + j`` for ``(x_i, y_j)``.
    """
    x, y = np.asarray(x_nodes, dtype=float), np.asarray(y_nodes, dtype=float)
    _check_tensor(x, y, youngs_modulus, poisson_ratio, symmetry, order, far_field, extent, growth)
    started = time.perf_counter()
    quarter = symmetry == "quarter"
    half = 0.5 * max(np.ptp(x), np.ptp(y)) * (2.0 if quarter else 1.0)
    length = 2.0 ** round(np.log2(half))
    centre = (0.0, 0.0) if quarter else (0.5 * (x[0] + x[-1]), 0.5 * (y[0] + y[-1]))
    lines = [(x - centre[0]) / length, (y - centre[1]) / length]
    reach = extent * half / length
    wide = [_extended(line, reach, growth, quarter) for line in lines]
    finest = min(np.min(np.diff(line)) for line in lines)
    z = growing_lines(0.0, reach, finest, growth)
    grid = tensor_mesh(wide[0], wide[1], z, order=order, quarter=quarter)
    (x0, x1), (y0, y1) = [(line[0], line[-1]) for line in lines]
    body = _condensed(
        grid,
        lambda px, py: (px >= x0) & (px <= x1) & (py >= y0) & (py <= y1),
        (0.5 * x1, 0.5 * y1),
        ring=None,
        stretch=(1.0, 1.0),
        length=length,
        modulus=youngs_modulus,
        poisson_ratio=poisson_ratio,
        spacing=float(np.sqrt(np.mean(np.diff(lines[0])) * np.mean(np.diff(lines[1])))),
        fixed=far_field == "fixed",
        reduced_integration=reduced_integration,
        started=started,
    )
    offset = np.array(centre) / length
    return replace(body, scaled_points=body.scaled_points + offset, offset=offset)


def _extended(
    line: NDArray[np.float64], reach: float, growth: float, quarter: bool
) -> NDArray[np.float64]:
    """Grid lines with growing cells out to the boundary of the mesh."""
    right = growing_lines(line[-1], reach, growth * (line[-1] - line[-2]), growth)[1:]
    if quarter:
        return np.concatenate([line, right])
    left = -growing_lines(-line[0], reach, growth * (line[1] - line[0]), growth)[1:]
    return np.concatenate([left[::-1], line, right])


def _condensed(
    grid: GradedMesh,
    candidate: object,
    sources: tuple[float, float],
    *,
    ring: float | None,
    stretch: tuple[float, float],
    length: float,
    modulus: float,
    poisson_ratio: float,
    spacing: float,
    fixed: bool,
    reduced_integration: bool,
    started: float,
) -> CondensedBody:
    """Assemble and condense a graded mesh."""
    seconds = {"mesh": time.perf_counter() - started}
    mark = time.perf_counter()
    nodes, weights = _candidates(grid, candidate)
    matrices = stiffness_matrices(grid.mesh, poisson_ratio, reduced_integration=reduced_integration)
    groups = [] if fixed else source_groups(*sources, quarter=grid.quarter)
    system = _linear_system(grid, matrices, nodes, groups, poisson_ratio)
    exterior = np.zeros((0, 0))
    if groups:
        exterior = exterior_stiffness(grid.mesh, grid.outer, groups, poisson_ratio)
    seconds["assembly"] = time.perf_counter() - mark
    mark = time.perf_counter()
    stiffness = condense(system, exterior)
    compliance = cho_solve(cho_factor(stiffness), np.eye(len(stiffness)))
    seconds["condensation"] = time.perf_counter() - mark
    return CondensedBody(
        length=length,
        youngs_modulus=modulus,
        poisson_ratio=poisson_ratio,
        scaled_points=grid.mesh.p[:2, nodes].T.copy(),
        scaled_weights=weights,
        scaled_compliance=0.5 * (compliance + compliance.T),
        symmetry=4 if grid.quarter else 1,
        offset=np.zeros(2),
        ring=ring,
        stretch=stretch,
        spacing_scaled=spacing,
        unknowns=system.first + len(groups),
        solver="nested dissection",
        seconds=seconds,
        grid=grid,
        system=system,
        exterior=exterior,
    )


def _candidates(
    grid: GradedMesh, candidate: object
) -> tuple[NDArray[np.int64], NDArray[np.float64]]:
    """Surface nodes that may touch, ordered by x then y, and their tributary areas."""
    mesh = grid.mesh
    numbers, shapes, _, areas = facet_quadrature(mesh, grid.surface, 3)
    shares = np.abs(areas[..., 2]) @ shapes.T
    weights = np.bincount(numbers.ravel(), shares.ravel(), minlength=mesh.p.shape[1])
    nodes = facet_nodes(mesh, grid.surface)
    nodes = nodes[candidate(mesh.p[0, nodes], mesh.p[1, nodes])]
    place = np.round(mesh.p[:2, nodes], 9)
    nodes = nodes[np.lexsort((place[1], place[0]))]
    return nodes, weights[nodes]


def _linear_system(
    grid: GradedMesh,
    matrices: NDArray[np.float64],
    candidates: NDArray[np.int64],
    groups: list[NDArray[np.float64]],
    poisson_ratio: float,
) -> LinearSystem:
    """Give numbers to the free displacements, then to those that follow the far field."""
    mesh = grid.mesh
    total = mesh.p.shape[1]
    fixed = np.zeros((total, 3), dtype=bool)
    if grid.quarter:
        fixed[:, :2] = mesh.p[:2].T == 0.0
    outer = facet_nodes(mesh, grid.outer)
    number = np.zeros((total, 3), dtype=np.int64)
    number[outer] = 1
    number[fixed] = -1
    if not groups:
        number[outer] = -1
    free, following = number == 0, number == 1
    number[free] = np.arange(free.sum())
    number[following] = free.sum() + np.arange(following.sum())
    fields = [group_field(mesh.p.T[outer], group, poisson_ratio)[0] for group in groups]
    boundary = np.zeros((int(following.sum()), len(groups)))
    for column, field in enumerate(fields):
        everywhere = np.zeros((total, 3))
        everywhere[outer] = field
        boundary[:, column] = everywhere[following]
    elements = mesh.dofs.element_dofs.T
    return LinearSystem(
        matrices=matrices,
        unknowns=number[elements].reshape(len(elements), -1),
        boundary=boundary,
        first=int(free.sum()),
        retained=number[candidates, 2],
        centres=mesh.p[:, mesh.t].mean(axis=1).T,
    )


def _check_ball(
    contact_radius: float,
    youngs_modulus: float,
    poisson_ratio: float,
    elements: int,
    symmetry: str,
    edge: float | None,
    stretch: tuple[float, float],
    far_field: str,
    extent: float,
) -> None:
    wrong = _common_faults(youngs_modulus, poisson_ratio, symmetry, far_field)
    if not (np.isfinite(contact_radius) and contact_radius > 0.0):
        wrong.append(f"contact_radius must be positive and finite, got {contact_radius!r}")
    if int(elements) != elements or elements < 2:
        wrong.append(f"elements must be an integer of at least 2, got {elements!r}")
    if edge is not None and not 0.2 * contact_radius <= edge <= contact_radius:
        wrong.append(
            f"edge must lie between 0.2 and 1 contact_radius ({contact_radius!r}), got {edge!r}"
        )
    if len(stretch) != 2 or not all(np.isfinite(s) and s > 0.0 for s in stretch):
        wrong.append(f"stretch must be two positive factors, got {stretch!r}")
    if not (np.isfinite(extent) and extent >= 2.0):
        wrong.append(f"extent must be at least 2 contact radii, got {extent!r}")
    if wrong:
        raise ValueError("; ".join(wrong))


def _check_tensor(
    x: NDArray[np.float64],
    y: NDArray[np.float64],
    youngs_modulus: float,
    poisson_ratio: float,
    symmetry: str,
    order: int,
    far_field: str,
    extent: float,
    growth: float,
) -> None:
    wrong = _common_faults(youngs_modulus, poisson_ratio, symmetry, far_field)
    for name, line in (("x_nodes", x), ("y_nodes", y)):
        if line.ndim != 1 or len(line) < 2 or not np.all(np.diff(line) > 0.0):
            wrong.append(f"{name} must be strictly increasing, at least 2 values, got {line!r}")
        elif symmetry == "quarter" and line[0] != 0.0:
            wrong.append(f"{name} must start at 0 with quarter symmetry, got {line[0]!r}")
    if order not in (1, 2):
        wrong.append(f"order must be 1 or 2, got {order!r}")
    if not (np.isfinite(extent) and extent >= 1.5):
        wrong.append(f"extent must be at least 1.5 half-widths, got {extent!r}")
    if not 1.0 < growth <= 4.0:
        wrong.append(f"growth must lie in (1, 4], got {growth!r}")
    if wrong:
        raise ValueError("; ".join(wrong))


def _common_faults(
    youngs_modulus: float, poisson_ratio: float, symmetry: str, far_field: str
) -> list[str]:
    wrong = []
    if not (np.isfinite(youngs_modulus) and youngs_modulus > 0.0):
        wrong.append(f"youngs_modulus must be positive and finite, got {youngs_modulus!r}")
    try:
        lame_parameters(poisson_ratio)
    except ValueError as fault:
        wrong.append(str(fault))
    if symmetry not in ("quarter", "none"):
        wrong.append(f"symmetry must be 'quarter' or 'none', got {symmetry!r}")
    if far_field not in ("boussinesq", "fixed"):
        wrong.append(f"far_field must be 'boussinesq' or 'fixed', got {far_field!r}")
    return wrong
