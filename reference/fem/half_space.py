"""Half-spaces for one round contact, and for a rectangular grid of contact points."""

from __future__ import annotations

import time
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray

from reference.fem import pardiso
from reference.fem.body import CondensedBody, condensed_body
from reference.fem.elasticity import LARGEST_POISSON_RATIO
from reference.fem.mesh import (
    Planes,
    edge_lines,
    graded_lines,
    growing_lines,
    ring_mesh,
    stretched,
    tensor_mesh,
)

# Planes of symmetry x = 0 and y = 0, of which only the positive sides are meshed.
SYMMETRIES = {
    "none": (False, False),
    "half_x": (True, False),
    "half_y": (False, True),
    "quarter": (True, True),
}
SOLVERS = ("nested_dissection", "pardiso", "multigrid")
# Beyond them the elements are too distorted for a definite matrix in double precision.
LARGEST_ASPECT, LARGEST_EXTENT = 100, 1000


def ball_body(
    contact_radius: float,
    youngs_modulus: float,
    poisson_ratio: float,
    *,
    elements: int = 6,
    symmetry: str = "quarter",
    edge: float | None = None,
    sharp: bool = False,
    stretch: tuple[float, float] = (1.0, 1.0),
    far_field: str = "boussinesq",
    extent: float = 2.5,
    reduced_integration: bool = True,
    solver: str = "nested_dissection",
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
        ``-1 < nu <= 0.5``; beyond 0.4999 in the mixed form of `reference.fem.mixed`.
    elements : int
        Elements per contact radius (each has two node spacings).
    symmetry : {"quarter", "half_x", "half_y", "none"}
        "quarter" for gaps that are even in x and in y: a fourth of the work; "half_x" for gaps that
        are even in x (only x >= 0 is meshed), "half_y" in y.
    edge : float, optional
        Radius of a sharp edge or a kink of the indenter, at most `contact_radius`. The mesh has a
        circle there, towards which the elements crowd.
    sharp : bool
        The edge is that of a flat punch: more rings, which crowd more.
    stretch : (float, float)
        Factors on x and y: contact ellipse with semi-axes ``contact_radius * stretch``, up to
        1:100.
    far_field : {"boussinesq", "fixed"}
        "fixed" clamps the outer boundary; for comparisons with published models only.
    extent : float
        Radius and depth of the mesh in contact radii, 2 to 1000.
    reduced_integration : bool
        False shows locking.
    solver : {"nested_dissection", "pardiso", "multigrid"}
        "pardiso" needs the optional package pypardiso and is no faster; "multigrid" condenses
        nothing (see `reference.fem.multigrid`) and fits where a factorisation does not.

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
        solver,
    )
    started = time.perf_counter()
    ring = 1.0 if edge is None else edge / contact_radius
    rings, depths, cells = _rings(elements, edge and ring, sharp, extent, stretch)
    grid = ring_mesh(
        rings,
        depths,
        core_cells=cells,
        round_from=ring,
        stretch=stretch,
        planes=SYMMETRIES[symmetry],
    )
    limits = _candidate_reach(rings, stretch, extent)
    return condensed_body(
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
        solver=solver,
        started=started,
    )


def _candidate_reach(
    rings: NDArray[np.float64], stretch: tuple[float, float], extent: float
) -> NDArray[np.float64]:
    """Half-axes of the mesh ellipse that lies 1.2 contact radii out, or next to it."""
    limit = rings[np.searchsorted(rings, 1.2 - 1e-9)]
    return stretched(np.diag([limit, limit]), np.asarray(stretch), extent).diagonal()


def _rings(
    elements: int,
    ring: float | None,
    sharp: bool,
    extent: float,
    stretch: tuple[float, float],
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    if ring is None:
        return _even_rings(elements, extent, stretch)
    return _edge_rings(elements, ring, sharp, extent, stretch)


def _even_rings(
    elements: int, extent: float, stretch: tuple[float, float]
) -> tuple[NDArray[np.float64], NDArray[np.float64], int]:
    """Mesh circles and depths in contact radii, and the cells of the core; no edge to fit."""
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
    """Mesh circles and depths in contact radii, and the cells of the core: contact ends at `ring`.

    Cells crowd towards the edge. Where the pressure vanishes like a root there, a size that goes
    with the root of the distance gives fourth order in the number of cells; at a sharp edge, where
    it is singular, with the power 3/4 (the last cell goes as count^-4 then, and the error with it).
    A circular contact is smooth along the edge: there two cells per 45 degrees serve 1e-5.
    """
    exponent = 0.75 if sharp else 0.5
    cells = max(2, -(-elements // 4)) if sharp else -(-elements // 2)
    core = 0.5 if sharp else 0.55
    inside = graded_lines(core, 1.0, elements if sharp else cells, exponent)

    def outward(reach: float) -> NDArray[np.float64]:
        # as many cells for each factor of e as a mesh of radius 2.5 has
        count = round(1.5 * elements * np.log1p(reach) / np.log1p(1.5))
        return edge_lines(reach, count, exponent)

    outer = outward(extent / ring - 1.0)
    narrow, wide = min(stretch), max(stretch)
    depths = ring * narrow * outward(extent * wide / (ring * narrow))
    return ring * np.concatenate([inside, 1.0 + outer[1:]]), depths, cells


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
    solver: str = "nested_dissection",
) -> CondensedBody:
    """Build a half-space with a rectangular grid of candidate contact points.

    The grid lines go straight down; beyond the grid and with depth the cells grow.

    Parameters
    ----------
    x_nodes, y_nodes : (nx,), (ny,)
        Strictly increasing mesh lines. All their crossings are candidates (and with ``order=2``
        the mid-points too). Towards a plane of symmetry they start at 0.
    youngs_modulus, poisson_ratio : float
    symmetry : {"none", "half_x", "half_y", "quarter"}
        As in `ball_body`.
    order : {1, 2}
        8-node or 27-node hexahedra.
    far_field : {"boussinesq", "fixed"}
    extent : float
        Distance of the outer boundary from the centre, in half-widths of the grid.
    growth : float
        Ratio of neighbouring cells outside the grid.
    reduced_integration, solver
        As in `ball_body`.

    Returns
    -------
    CondensedBody
        Candidates in C order: index ``i * ny + j`` for ``(x_i, y_j)``.
    """
    x, y = np.asarray(x_nodes, dtype=float), np.asarray(y_nodes, dtype=float)
    _check_tensor(
        x, y, youngs_modulus, poisson_ratio, symmetry, order, far_field, extent, growth, solver
    )
    started = time.perf_counter()
    planes = SYMMETRIES[symmetry]
    length = 2.0 ** round(np.log2(_half_width(x, y, planes)))
    centre = [
        0.0 if plane else 0.5 * (line[0] + line[-1])
        for line, plane in zip((x, y), planes, strict=True)
    ]
    x, y = (x - centre[0]) / length, (y - centre[1]) / length
    grid = tensor_mesh(*_tensor_planes(x, y, planes, extent, growth), order=order, planes=planes)
    (x0, x1), (y0, y1) = [(line[0], line[-1]) for line in (x, y)]
    body = condensed_body(
        grid,
        lambda px, py: (px >= x0) & (px <= x1) & (py >= y0) & (py <= y1),
        (0.5 * x1, 0.5 * y1),
        ring=None,
        stretch=(1.0, 1.0),
        length=length,
        modulus=youngs_modulus,
        poisson_ratio=poisson_ratio,
        spacing=float(np.sqrt(np.mean(np.diff(x)) * np.mean(np.diff(y)))),
        fixed=far_field == "fixed",
        reduced_integration=reduced_integration,
        solver=solver,
        started=started,
    )
    offset = np.array(centre) / length
    return replace(body, scaled_points=body.scaled_points + offset, offset=offset)


def tensor_unknowns(
    x_nodes: NDArray[np.float64],
    y_nodes: NDArray[np.float64],
    *,
    symmetry: str = "none",
    order: int = 1,
    extent: float = 3.0,
    growth: float = 1.5,
) -> int:
    """Count the displacements of the mesh that `tensor_body` would build, without building it.

    Examples
    --------
    >>> lines = np.linspace(0.0, 1.0, 4)
    >>> body = tensor_body(lines, lines, 1.0, 0.3)
    >>> tensor_unknowns(lines, lines) == body.grid.mesh.p.size
    True
    """
    x, y = np.asarray(x_nodes, dtype=float), np.asarray(y_nodes, dtype=float)
    lines = _tensor_planes(x - x.mean(), y - y.mean(), SYMMETRIES[symmetry], extent, growth)
    return 3 * int(np.prod([order * (len(line) - 1) + 1 for line in lines]))


def _half_width(x: NDArray[np.float64], y: NDArray[np.float64], planes: Planes) -> float:
    """Larger half-width of the grid, with its mirror images."""
    widths = [
        np.ptp(line) if plane else 0.5 * np.ptp(line)
        for line, plane in zip((x, y), planes, strict=True)
    ]
    return float(max(widths))


def _tensor_planes(
    x: NDArray[np.float64], y: NDArray[np.float64], planes: Planes, extent: float, growth: float
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    """Mesh planes in x, y and z of the grid (centred) and of the block around and below it."""
    reach = extent * _half_width(x, y, planes)
    wide_x, wide_y = (
        _extended(line, reach, growth, plane) for line, plane in zip((x, y), planes, strict=True)
    )
    finest = min(np.min(np.diff(line)) for line in (x, y))
    return wide_x, wide_y, growing_lines(0.0, reach, finest, growth)


def _extended(
    line: NDArray[np.float64], reach: float, growth: float, symmetric: bool
) -> NDArray[np.float64]:
    """Grid lines with growing cells out to the boundary of the mesh."""
    right = growing_lines(line[-1], reach, growth * (line[-1] - line[-2]), growth)[1:]
    if symmetric:
        return np.concatenate([line, right])
    left = -growing_lines(-line[0], reach, growth * (line[1] - line[0]), growth)[1:]
    return np.concatenate([left[::-1], line, right])


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
    solver: str,
) -> None:
    wrong = _common_faults(youngs_modulus, poisson_ratio, symmetry, far_field, solver)
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
    elif max(stretch) > LARGEST_ASPECT * min(stretch):
        wrong.append(f"stretch must be at most 1:{LARGEST_ASPECT}, got {stretch!r}")
    if not 2.0 <= extent <= LARGEST_EXTENT:
        wrong.append(f"extent must be 2 to {LARGEST_EXTENT} contact radii, got {extent!r}")
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
    solver: str,
) -> None:
    wrong = _common_faults(youngs_modulus, poisson_ratio, symmetry, far_field, solver)
    planes = SYMMETRIES.get(symmetry, (False, False))
    for name, line, plane in (("x_nodes", x, planes[0]), ("y_nodes", y, planes[1])):
        if line.ndim != 1 or len(line) < 2 or not np.all(np.diff(line) > 0.0):
            wrong.append(f"{name} must be strictly increasing, at least 2 values, got {line!r}")
        elif plane and line[0] != 0.0:
            wrong.append(f"{name} must start at 0 with {symmetry} symmetry, got {float(line[0])!r}")
    if order not in (1, 2):
        wrong.append(f"order must be 1 or 2, got {order!r}")
    elif order == 1 and poisson_ratio > LARGEST_POISSON_RATIO:
        wrong.append(
            f"poisson_ratio {poisson_ratio!r} is incompressible: 8-node elements cannot carry its "
            "mean stress without checkerboards; take order = 2"
        )
    if not 1.5 <= extent <= LARGEST_EXTENT:
        wrong.append(f"extent must be 1.5 to {LARGEST_EXTENT} half-widths, got {extent!r}")
    if not 1.0 < growth <= 4.0:
        wrong.append(f"growth must lie in (1, 4], got {growth!r}")
    if wrong:
        raise ValueError("; ".join(wrong))


def _common_faults(
    youngs_modulus: float, poisson_ratio: float, symmetry: str, far_field: str, solver: str
) -> list[str]:
    wrong = []
    if not (np.isfinite(youngs_modulus) and youngs_modulus > 0.0):
        wrong.append(f"youngs_modulus must be positive and finite, got {youngs_modulus!r}")
    if not -1.0 < poisson_ratio <= 0.5:
        wrong.append(f"poisson_ratio must lie in (-1, 0.5], got {poisson_ratio!r}")
    elif poisson_ratio > LARGEST_POISSON_RATIO and solver != SOLVERS[0]:
        wrong.append(
            f"poisson_ratio above {LARGEST_POISSON_RATIO} takes a mixed form, which is indefinite: "
            f"solver must be {SOLVERS[0]!r}, got {solver!r}"
        )
    if symmetry not in SYMMETRIES:
        wrong.append(f"symmetry must be one of {tuple(SYMMETRIES)}, got {symmetry!r}")
    if far_field not in ("boussinesq", "fixed"):
        wrong.append(f"far_field must be 'boussinesq' or 'fixed', got {far_field!r}")
    if solver not in SOLVERS:
        wrong.append(f"solver must be one of {SOLVERS}, got {solver!r}")
    elif solver == "pardiso" and not pardiso.available():
        wrong.append("solver = 'pardiso' needs the package pypardiso (pip install roughline[fast])")
    return wrong
