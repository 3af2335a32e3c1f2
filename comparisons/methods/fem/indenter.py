"""The method `fem` for single contacts: below a rigid shape, or between two elastic bodies.

Under flat faces with straight sides mesh lines follow the sides: where all of them lie along x or
y, as on a square or an L-shape, they crowd there, in elements of second order; needles take an even
grid of first order. Oblique sides are staircases on such a grid.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise
from typing import ClassVar, TypeVar

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods import NoAnswerError, Refused, Row, Solution, Solver, Step, Task, needed
from comparisons.methods.fem.step import (
    bytes_of_elements,
    bytes_of_elimination,
    bytes_of_iteration,
    contact_step,
    recovered,
    round_area,
)
from comparisons.methods.normal.grid import half_axes
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.indenters.not_round import Ellipsoid, EllipticPunch, PolygonPunch
from comparisons.scene.polygons import distance_to_outline
from comparisons.scene.scene import Scene
from reference import fem
from reference.closed_form import ellipsoid
from reference.fem.two_bodies import couple
from reference.loads import Load, LoadPath

G = TypeVar("G", bound=Geometry)

LARGEST_POISSON = 0.4999
LARGEST_ASPECT = 50
# What the far field beyond the mesh leaves out, measured by doubling the extent of the mesh and
# rounded up: it falls with the cube of the elements where the mesh is fitted to the contact, smooth
# or sharp (`tests/reference` has the measurement), and is constant on grids of straight lines.
TRUNCATION_SMOOTH, TRUNCATION_SHARP, TRUNCATION_SQUARE, TRUNCATION_GRID = 6e-3, 4e-2, 7e-4, 5e-3
# Meshes of fitted contacts for tolerances down to these. Largest measured errors of the force over
# smooth shapes (and of the stiffness of a cylinder) at 4, 6, 8 and 10 elements per contact radius:
# 1e-4 (1.1e-3), 2e-5 (2.7e-4), 1e-5 (9e-5), and below; a fifth of the tolerance is the aim.
FITTED_LEVELS = ((3e-3, (2, 3, 4)), (3e-4, (3, 4, 6)), (5e-5, (4, 6, 8)))
FINEST = (6, 8, 10)
# What is meshed with no, one and two planes of symmetry.
PARTS = ("", "half of ", "a quarter of ")
FAR = "outside it Boussinesq fields"


class FemSolver(Solver[G]):
    """Elastic bodies of hexahedra with a Boussinesq far field, condensed onto the surface."""

    span = 1e6  # each load scales the mesh onto its own contact
    solver: str  # of the linear equations, where it is an option
    # A factorisation of more takes more than 4 GB and a minute: conjugate gradients take its place.
    most_factorised: ClassVar[int] = 300_000
    # Their steps grow as (1/2 - nu)^(-1/2): 250 here, 700 of at most 1000 at 0.4999.
    largest_poisson: ClassVar[float] = 0.499
    iteration: ClassVar[str] = "conjugate gradients"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        nu = scene.elastic_constants[1]
        if meshes_both(scene):
            nu = max(body.nu for body in (scene.half_space, scene.counter_body) if body)
        if nu > LARGEST_POISSON and not _quadratic(scene):
            raise Refused(
                f"nu = {nu:g} is incompressible and needs mixed 27-node elements, which this scene "
                "does not use; 8-node elements are limited to 0.4999"
            )
        if scene.loading.control == "mean_gap":
            raise Refused("no mean-gap control on this mesh: use bem_fft, or prescribe the force")
        unfit = options_problem(scene)
        if unfit:
            raise Refused(unfit)
        if scene.surface is not None and scene.surface.periodic:
            raise Refused("models a free patch, not a periodic half-space")

    def linear_solver(self, unknowns: int) -> str:
        """Return the solver of so many unknowns: a factorisation up to the size where it pays."""
        if self.solver != "automatic":
            return self.solver
        if unknowns <= self.most_factorised or self.stiff:
            return "nested_dissection"
        unable = solver_problem(self.scene, "conjugate_gradients")
        return "nested_dissection" if unable else "conjugate_gradients"

    @property
    def stiff(self) -> bool:
        """Whether conjugate gradients take many steps, as the body hardly changes its volume."""
        return self.scene.elastic_constants[1] > self.largest_poisson

    def solved(self) -> str:
        """Say how the linear equations are solved."""
        if self.solver == "conjugate_gradients":
            return f"solved by {self.iteration}"
        condensed = "condensed by nested dissection"
        if self.solver != "automatic" or solver_problem(self.scene, "conjugate_gradients"):
            return condensed
        if self.stiff:
            above = f"nu above {self.largest_poisson:g}"
            return f"{condensed} ({above}: many steps for conjugate gradients)"
        most = f"{self.most_factorised // 1000} 000 unknowns"
        return f"{condensed} (above {most} solved by {self.iteration})"


def meshes_both(scene: Scene) -> bool:
    """Whether both bodies get a mesh: an indenter with a counter body, and a coupling."""
    pair = scene.counter_body is not None and scene.indenter is not None
    return pair and scene.methods.fem.coupling != "effective_modulus"


class Fem(FemSolver[IndenterGeometry]):
    """Single contacts: a mesh around the contact, fitted to its edge or along straight sides."""

    name = "fem"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.enforcement = enforcement_of(scene)
        self.points, self.solver = scene.methods.fem.points, scene.methods.fem.solver
        self.indenter = needed(scene.indenter, "single contacts only")
        self.straight = self.indenter.outline is not None
        self.stretch = contact_stretch(self.indenter)

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Rigid indenters on a half-space, and two elastic bodies put into one."""
        mesh_fits = scene.half_space.uniform and not meshes_both(scene)
        return mesh_fits and not scene.rough and scene.body is None

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Elements per contact radius, that of the circle of equal area."""
        tolerance = self.scene.compare.tolerance
        if self.straight and not second_order(self.indenter):
            return 5, 7, 9  # trilinear cells, and a staircase along oblique edges
        if self.straight and isinstance(self.indenter, PolygonPunch):
            return 3, 4, 5
        if self.straight:
            return (4, 6, 8) if tolerance < 0.003 else (3, 4, 6)
        return next((levels for least, levels in FITTED_LEVELS if tolerance >= least), FINEST)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        if self.straight:
            number = face_grid(task.geometry, task.resolution).unknowns
            most = MOST_UNKNOWNS
            return f"about {number} unknowns, more than {most}" if number > most else ""
        return elongated(self.stretch)

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the elimination, or of the factors in conjugate gradients."""
        mesh = self._mesh(task)
        solver = self.linear_solver(mesh.unknowns)
        if isinstance(mesh, fem.RingMesh) and solver == "conjugate_gradients":
            return bytes_of_iteration(mesh)
        return bytes_of_elimination(mesh)

    def model(self, geometry: IndenterGeometry) -> str:
        part = PARTS[sum(self.indenter.even)]
        fitted = "" if self.straight else ", scaled to each load"
        block = f"{part}a block of graded hexahedra around the contact{fitted}"
        if self.scene.counter_body is not None:
            block += ", with the compliances of both bodies, which add exactly without friction"
        return f"{block}; {FAR}; {self.solved()}"

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        body = self.body(task)
        truncation = TRUNCATION_SQUARE if second_order(self.indenter) else TRUNCATION_GRID
        if body.ring is not None:
            largest = TRUNCATION_SHARP if self._sharp(task.geometry) else TRUNCATION_SMOOTH
            truncation = largest / task.resolution**3

        def steps(loads: np.ndarray) -> Iterator[Step]:
            """Scale the mesh onto the edge of the contact at each load; a face has a fixed mesh."""
            points, shape = self.points, self.indenter.gap
            contacts: Iterator[tuple[fem.CondensedBody, fem.NodalContact]]
            load = LoadPath(task.loads.control, loads)
            if body.ring is None:
                pressed = body if points == "nodes" else fem.at_quadrature_points(body)
                x, y = pressed.points.T
                gap = shape(x, y)
                if self.indenter.outline is not None:  # a node on a side belongs to the face
                    away = distance_to_outline(x, y, self.indenter.outline)
                    gap = np.where(away < 1e-9 * task.geometry.contact_radius, 0.0, gap)
                found = fem.press(pressed, gap, load, self.enforcement)
                contacts = ((pressed, contact) for contact in found)
            else:
                contacts = fem.indent(body, shape, load, self.enforcement, points=points)
            for scaled, contact in contacts:
                if body.ring is not None:
                    gap = shape(*scaled.points.T)
                # The face of a flat punch is known.
                face = self.indenter.face_area
                area = contact.contact_area if face is None else face
                inside = partial(recovered, scaled, contact.reactions)
                x, y = scaled.points.T
                axes = half_axes(task, x, y, contact.reactions)
                yield contact_step(
                    *(task, scaled, gap, contact, area), body_fields=inside, quantities=axes
                )

        yield Row(steps, unknowns=body.unknowns, truncation=truncation)

    def body(self, task: Task[IndenterGeometry]) -> fem.CondensedBody:
        """Return the half-space that fits the scene's contact."""
        mesh, material = self._mesh(task), fem.Material(*self.scene.elastic_constants)
        return fem.half_space_body(mesh, material, solver=self.linear_solver(mesh.unknowns))

    def _mesh(self, task: Task[IndenterGeometry]) -> fem.RingMesh | fem.TensorMesh:
        geometry = task.geometry
        if self.straight:
            return face_grid(geometry, task.resolution)
        # The size is arbitrary: a half-space has no length, and each load scales the mesh.
        return fem.RingMesh(
            geometry.contact_radius,
            elements=task.resolution,
            edge=geometry.contact_radius,
            sharp=self._sharp(geometry),
            stretch=self.stretch,
        )

    def _sharp(self, geometry: IndenterGeometry) -> bool:
        """Whether the pressure is singular at the edge of the contact, or nearly so."""
        return self.indenter.flat or self.indenter.flat_within > 0.3 * geometry.contact_radius


def enforcement_of(scene: Scene) -> fem.Enforcement:
    """Return how contact is enforced; an active set has no use for a penalty, which is not read."""
    options = scene.methods.fem
    if options.contact == "active_set":
        return fem.Enforcement(options.contact)
    return fem.Enforcement(options.contact, options.penalty)


def options_problem(scene: Scene) -> str:
    """Return why points or solver that a scene asks for cannot be had, or an empty text."""
    changes = scene.methods.fem.changes
    if "points" not in changes:
        return solver_problem(scene, changes.get("solver", "automatic"))
    if changes.get("contact") != "penalty":
        return 'points = "quadrature" takes contact = "penalty" only: there are more than nodes'
    if scene.indenter is None or scene.body is not None or meshes_both(scene):
        return 'points = "quadrature" is for a rigid indenter on a half-space'
    if changes.get("solver") == "conjugate_gradients":
        return 'points = "quadrature" needs a condensed body, no conjugate gradients'
    return solver_problem(scene, changes.get("solver", "automatic"))


def solver_problem(scene: Scene, solver: str) -> str:
    """Return why a linear solver cannot do the scene, or an empty text."""
    if scene.body is not None or solver != "conjugate_gradients":
        return ""
    if not _quadratic(scene) or (scene.indenter and scene.indenter.outline is not None):
        return f"solver {solver} is for single contacts on a mesh that is fitted to them"
    if scene.elastic_constants[1] > LARGEST_POISSON:
        return f"solver {solver} needs a definite matrix: nu up to {LARGEST_POISSON}"
    if "contact" in scene.methods.fem.changes:
        return "solver conjugate_gradients takes contact = active_set only"
    return ""


def _quadratic(scene: Scene) -> bool:
    """Whether the body is a half-space of 27-node elements, which have a mixed form."""
    if scene.indenter is None or meshes_both(scene) or scene.body is not None:
        return False
    if scene.indenter.outline is not None:
        return second_order(scene.indenter)
    return scene.indenter.quarter_symmetric


def contact_stretch(indenter: Indenter) -> tuple[float, float]:
    """Return how the contact ellipse deviates from the circle of equal area."""
    if isinstance(indenter, Ellipsoid):
        half_x, half_y = ellipsoid(indenter.radius_x, indenter.radius_y, 1.0).semi_axes(1.0)
    elif isinstance(indenter, EllipticPunch):
        half_x, half_y = indenter.semi_axes
    elif indenter.axisymmetric or indenter.outline is not None:
        return 1.0, 1.0
    else:
        raise Refused(f"no mesh is fitted to the contact of a {indenter.in_words}")
    ratio = float(np.sqrt(half_x / half_y))
    return ratio, 1 / ratio


def elongated(stretch: tuple[float, float]) -> str:
    """Return why a very elongated contact is out of reach, or an empty text."""
    longer = max(stretch) ** 2
    if longer <= LARGEST_ASPECT:
        return ""
    return f"a contact {longer:.0f} times as long as wide: elements are tested to {LARGEST_ASPECT}"


# Twenty seconds of elimination on one core.
MOST_UNKNOWNS = 150_000
# Faces longer than this, in widths, take an even grid of first order: crowded lines along all of
# the length would be too many.
LONGEST_CROWDED = 8
SYMMETRIES = {planes: name for name, planes in fem.SYMMETRIES.items()}


def second_order(indenter: Indenter) -> bool:
    """Whether a face is meshed with crowded lines and elements of second order."""
    corners = indenter.outline
    if corners is None:
        return False
    sides = np.abs(np.roll(corners, -1, axis=0) - corners)
    right_angled = bool((sides.min(axis=1) <= 1e-9 * sides.max()).all())
    short, long = sorted(indenter.reach(0.0))
    return right_angled and long <= LONGEST_CROWDED * short


def face_grid(geometry: IndenterGeometry, resolution: int) -> fem.TensorMesh:
    """Return the mesh lines of a face; on the positive side only, where it is its mirror image."""
    indenter = geometry.indenter
    assert indenter.outline is not None
    crowded = second_order(indenter)
    lines = []
    for marks, half, mirrored in zip(
        indenter.outline.T, geometry.reach, indenter.even, strict=True
    ):
        # On the short side of a long face no fewer cells than a square would have: else the series
        # of resolutions would refine the long side only, and tell nothing.
        square = round(np.sqrt(np.pi) / 2 * resolution)
        count = max(2, square, round(half * resolution / geometry.contact_radius))
        if mirrored:
            marks = np.append(np.abs(marks), 0.0)
        # through the marks, but for those too close to another
        step = half / count
        first, *inner, last = np.unique(marks)
        through = [first]
        for mark in inner:
            if min(mark - through[-1], last - mark) > 0.5 * step:
                through.append(mark)
        through.append(last)
        # Crowded, lines come closer to the marks with the square of their number; not to the first
        # one where that is a plane of symmetry and no edge.
        parts = []
        for low, high in pairwise(through):
            share = np.linspace(0.0, 1.0, 1 + max(2, round((high - low) / step)))[:-1]
            if crowded and (low > first or not mirrored):
                share = np.where(share < 0.5, 2.0 * share**2, 1.0 - 2.0 * (1.0 - share) ** 2)
            elif crowded:
                share = 1.0 - (1.0 - share) ** 2
            parts.append(low + (high - low) * share)
        lines.append(np.append(np.concatenate(parts), last))
    return fem.TensorMesh(lines[0], lines[1], SYMMETRIES[indenter.even], 2 if crowded else 1)


# Cells of the grid per element along a contact radius: it covers the geometric overlap.
COVERED = 1.45
# Gaps beyond so many penetrations count as these: none of them closes, and the pressure functions
# of quadratic elements have both signs, so that an edge that rises steeply within an element would
# be a negative gap on the flat face beside it.
WIDEST = 2.0


class FemPair(FemSolver[IndenterGeometry]):
    """Two elastic half-spaces in quarter symmetry, pressed together load by load."""

    name = "fem"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, "an indenter and its counter body only")
        self.stretch = contact_stretch(self.indenter)
        self.coupling = scene.methods.fem.coupling
        self.counter_body = needed(scene.counter_body, "no [counter_body]")

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        return meshes_both(scene)

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Elements per contact radius."""
        return (3, 4, 6) if self.scene.compare.tolerance < 0.003 else (2, 3, 4)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        return elongated(self.stretch)

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the elements of one body, and of the elimination of the other, the larger."""
        first, second = (_mesh(task, cells) for cells in _cells(task))
        return bytes_of_elements(first) + bytes_of_elimination(second)

    def model(self, geometry: IndenterGeometry) -> str:
        coupling = self.coupling.replace("_", "-")
        return (
            f"a quarter of both bodies, on grids that do not match, {coupling} contact between "
            "them, scaled to each load; outside them Boussinesq fields"
        )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Solve as others do; its meshes are not fitted to the contact."""
        solution = super().solve(task)
        return replace(solution, contact="pair") if solution.contact == "single" else solution

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        tables = self.scene.half_space, self.counter_body
        bodies = [
            fem.half_space_body(_mesh(task, cells), fem.Material(*table.elastic_constants))
            for cells, table in zip(_cells(task), tables, strict=True)
        ]
        pair = couple(*bodies, coupling=self.coupling)
        geometry, steps = task.geometry, len(task.loads.values)

        def press(loads: np.ndarray) -> Iterator[Step]:
            for step in range(steps - len(loads), steps):
                size = geometry.contact_radii[step] / geometry.contact_radius
                if not size > 0.0:
                    raise NoAnswerError(geometry.unreached.get(step, "no estimate of its contact"))
                scaled = pair.scaled(size)
                load = Load(task.loads.control, task.loads.values[step])
                deep = WIDEST * geometry.penetrations[step]

                def below(x: np.ndarray, y: np.ndarray, deep: float = deep) -> np.ndarray:
                    return np.minimum(self.indenter.gap(x, y), deep)

                (contact,) = scaled.press(below, load)
                body, area = scaled.combined, contact.contact_area
                if self.indenter.axisymmetric:
                    area = round_area(body, contact)
                gap = self.indenter.gap(*body.points.T)
                # The fields in the half-space of the scene, on which the pressures live.
                inside = partial(recovered, scaled.slave, scaled.forces(contact)[0])
                yield contact_step(task, body, gap, contact, area, body_fields=inside)

        yield Row(press, unknowns=pair.combined.unknowns)


def _cells(task: Task[IndenterGeometry]) -> tuple[int, int]:
    """Return elements per contact radius of both bodies, whose grids do not match."""
    return task.resolution, task.resolution + 1


def _mesh(task: Task[IndenterGeometry], cells: int) -> fem.TensorMesh:
    share = np.linspace(0.0, 1.0, round(COVERED * cells) + 1)
    half_x, half_y = task.geometry.reach
    return fem.TensorMesh(half_x * share, half_y * share, symmetry="quarter", order=2)
