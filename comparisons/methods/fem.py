"""The method `fem`: the 3-D finite-element body under a rigid shape."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods import fem_body, fem_pair, fem_punch
from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.methods.fem_punch import STRAIGHT_EDGED
from comparisons.methods.sweeps import outcomes
from comparisons.scene.method_names import METHOD_NAMES
from comparisons.scene.options import FemOptions
from comparisons.scene.scene import Scene
from comparisons.scene.shapes import Ellipsoid, EllipticPunch, Indenter, RoundedPunch
from comparisons.tasks.shown_loads import point_pressure
from reference import fem
from reference.closed_form import ellipsoid
from reference.errors import ConvergenceError
from reference.fem import pardiso
from reference.halfspace.areas import corrected_area

LARGEST_POISSON = 0.4999
# Surface points per side of a rough patch: 32 take 2 s, and the cost grows as the fourth power.
LARGEST_PATCH = 32
# Condensed compliance, elimination fronts and mesh, per unknown: measured 13 000 at 24 000 unknowns
# and 11 000 at 310 000 (``roughline bench fem``), rounded up.
BYTES_PER_UNKNOWN = 16_000
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


class Fem(Method):
    """Elastic body of hexahedra with a Boussinesq far field, condensed onto the surface."""

    name = "fem"
    title = METHOD_NAMES[name].title
    span = 1e6  # each load scales the mesh onto its own contact

    def supports(self, scene: Scene) -> Support:
        """Free half-space, force or penetration control; nu = 1/2 where elements are quadratic."""
        bodies = [each for each in (scene.half_space, scene.counter_body) if each is not None]
        nu = max(each.elastic_constants[1] for each in bodies)
        if nu > LARGEST_POISSON and not _quadratic(scene):
            return Support(
                False,
                f"nu = {nu:g} is incompressible: the mixed form needs 27-node elements, which this "
                "scene does not have; 8-node elements go to 0.4999",
            )
        if scene.loading.control == "mean_gap":
            return Support(False, "no mean-gap control")
        unfit = _points_problem(scene) or _solver_problem(scene)
        if unfit:
            return Support(False, unfit)
        if scene.surface is not None and scene.surface.periodic:
            return Support(False, "models one free patch, not a periodic half-space")
        return Support(True)

    def supports_body(self, geometry: BodyGeometry) -> Support:
        """Any: with the boundary conditions of its supports."""
        return Support(True)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Elements per contact radius; a rough patch takes the points of its map, then more."""
        if isinstance(geometry, BodyGeometry):
            return fem_body.resolutions(geometry)
        if isinstance(geometry, RoughGeometry):
            n, most = geometry.points[0], max(geometry.points)
            return tuple(f * n for f in (1, 2, 3) if f * most <= LARGEST_PATCH) or (n,)
        fine = scene.compare.tolerance < 0.003
        if fem_pair.meshes_both(scene, geometry):
            return (3, 4, 6) if fine else (2, 3, 4)
        if isinstance(geometry.indenter, STRAIGHT_EDGED):
            return fem_punch.resolutions(geometry.indenter, fine=fine)
        wanted = scene.compare.tolerance
        return next((levels for least, levels in FITTED_LEVELS if wanted >= least), FINEST)

    def refused(self, task: Task) -> str:
        """Refuse patches whose elimination would take minutes."""
        if isinstance(task.geometry, BodyGeometry):
            nu = task.scene.elastic_constants[1]
            return fem_body.unsuited(task.geometry, nu) or fem_body.refused(
                task.geometry, task.resolution
            )
        if not isinstance(task.geometry, RoughGeometry):
            return _elongated(task.geometry, task.resolution)
        points = max(task.geometry.points) * task.resolution // task.geometry.points[0]
        if points <= LARGEST_PATCH:
            return ""
        return f"{points} points per side, more than {LARGEST_PATCH}: the mesh would be too large"

    def memory(self, task: Task) -> float:
        """Bytes of the elimination, from the number of unknowns expected."""
        if isinstance(task.geometry, BodyGeometry):
            return BYTES_PER_UNKNOWN * fem_body.unknowns(task.geometry, task.resolution)
        if fem_pair.meshes_both(task.scene, task.geometry):
            return BYTES_PER_UNKNOWN * fem_pair.unknowns(task.resolution)
        if isinstance(task.geometry, RoughGeometry):
            return BYTES_PER_UNKNOWN * fem.tensor_unknowns(*_map_lines(task))
        if isinstance(task.geometry.indenter, STRAIGHT_EDGED):
            return BYTES_PER_UNKNOWN * fem_punch.face_grid(task.geometry, task.resolution).unknowns
        # Measured 110 N^3 unknowns on round contacts, 270 N^3 where they are 8 times as long.
        aspect = max(contact_stretch(task.geometry.indenter)) ** 2
        return BYTES_PER_UNKNOWN * 110.0 * task.resolution**3 * (1.0 + 0.8 * np.log(aspect))

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the mesh."""
        if isinstance(geometry, BodyGeometry):
            return fem_body.model(geometry)
        if fem_pair.meshes_both(scene, geometry):
            return fem_pair.model(scene)
        far = "outside it Boussinesq fields"
        if isinstance(geometry, RoughGeometry):
            return f"a block below the patch, mesh nodes at the points of the map; {far}"
        part = PARTS[sum(geometry.indenter.even)]
        fitted = "" if isinstance(geometry.indenter, STRAIGHT_EDGED) else ", scaled to each load"
        solver = scene.methods.fem.solver
        how = "solved by" if solver == "multigrid" else "condensed by"
        block = f"{part}a block of graded hexahedra around the contact{fitted}"
        return f"{block}; {far}; {how} {solver.replace('_', ' ')}"

    def solve(self, task: Task) -> Solution:
        """Build and condense the body once, then press it load by load."""
        if isinstance(task.geometry, BodyGeometry):
            return fem_body.solve(task)
        if fem_pair.meshes_both(task.scene, task.geometry):
            return fem_pair.solve(task)
        solution = Solution.empty(task)
        with solution.setup():
            body = make_body(task)
        solution.unknowns = body.unknowns
        solution.truncation = _truncation(task, fitted=body.ring is not None)
        last: Step | None = None
        for row, realisation in enumerate(task.realisations):
            sweep = _sweep(task, body, realisation)
            for index, outcome in enumerate(outcomes(sweep, task.loads.values, ConvergenceError)):
                if isinstance(outcome, ConvergenceError):
                    solution.fail((row, index), outcome.reason)
                    continue
                solution.put((row, index), _quantities(task, outcome))
                solution.iterations[row, index] = outcome.contact.iterations
                solution.violation[row, index] = outcome.contact.violation
                if task.wants_pressure:
                    place, pressure = outcome.body.points, outcome.contact.pressure
                    solution.keep((row, index), partial(point_pressure, place, pressure))
                if row == 0 and index == len(task.loads.values) - 1:
                    last = outcome
        if last is not None:
            solution.fields = _fields(task, last)
            if task.with_body:
                solution.body_fields = partial(_body_fields, last)
        return solution


def _truncation(task: Task, *, fitted: bool) -> float:
    if fitted:
        largest = TRUNCATION_SHARP if _sharp(task.geometry) else TRUNCATION_SMOOTH
        return largest / task.resolution**3
    geometry = task.geometry
    second = isinstance(geometry, IndenterGeometry) and fem_punch.second_order(geometry.indenter)
    return TRUNCATION_SQUARE if second else TRUNCATION_GRID


class Step(NamedTuple):
    """One load: the body (fitted to the contact where it is a single one), the gap, the contact."""

    body: fem.CondensedBody
    gap: np.ndarray
    contact: fem.Contact


def _sweep(
    task: Task, body: fem.CondensedBody, realisation: int
) -> Callable[[np.ndarray], Iterator[Step]]:
    """Return the solver as a function of the loads still to do.

    A single contact scales the mesh onto its edge at each load; everything else is pressed on a
    fixed mesh.
    """
    options, geometry = task.options, task.geometry
    assert isinstance(options, FemOptions)
    how = {"contact": options.contact, "penalty": options.penalty}
    points = options.points

    def fitted(loads: np.ndarray) -> Iterator[Step]:
        assert isinstance(geometry, IndenterGeometry)
        shape = geometry.indenter.gap
        load: dict[str, Any] = {task.loads.control: loads}
        for scaled, contact in fem.indent(body, shape, **load, **how, points=points):
            yield Step(scaled, shape(*scaled.points.T), contact)

    def fixed(loads: np.ndarray) -> Iterator[Step]:
        pressed = body if points == "nodes" else fem.at_quadrature_points(body)
        gap = _gap(task, pressed, realisation)
        load: dict[str, Any] = {task.loads.control: loads}
        for contact in fem.press(pressed, gap, **load, **how):
            yield Step(pressed, gap, contact)

    return fixed if body.ring is None else fitted


def make_body(task: Task) -> fem.CondensedBody:
    """Return the condensed half-space that fits the scene's contact."""
    modulus, nu = task.scene.elastic_constants
    geometry = task.geometry
    if isinstance(geometry, RoughGeometry):
        return fem.tensor_body(*_map_lines(task), modulus, nu)
    if isinstance(geometry.indenter, STRAIGHT_EDGED):
        return fem_punch.face_grid(geometry, task.resolution).body(modulus, nu)
    assert isinstance(task.options, FemOptions)
    # The size is arbitrary: a half-space has no length, and each load scales the mesh.
    return fem.ball_body(
        geometry.contact_radius,
        modulus,
        nu,
        elements=task.resolution,
        edge=geometry.contact_radius,
        sharp=_sharp(geometry),
        solver=task.options.solver,
        stretch=contact_stretch(geometry.indenter),
    )


def _map_lines(task: Task) -> list[np.ndarray]:
    """Return the mesh lines of a rough patch: through the points of the map."""
    geometry = task.geometry
    assert isinstance(geometry, RoughGeometry)
    counts = (n * task.resolution // geometry.points[0] for n in geometry.points)
    return [(np.arange(n) + 0.5) * side / n for n, side in zip(counts, geometry.size, strict=True)]


def _points_problem(scene: Scene) -> str:
    """Return why contact cannot be asked for at quadrature points, or an empty text."""
    options = scene.methods.fem
    if options.points == "nodes":
        return ""
    if options.contact != "penalty":
        return 'points = "quadrature" takes contact = "penalty" only: there are more than nodes'
    if scene.indenter is None or scene.body is not None or scene.counter_body is not None:
        return 'points = "quadrature" is for a rigid indenter on a half-space'
    if options.solver == "multigrid":
        return 'points = "quadrature" needs a condensed body, and solver multigrid condenses none'
    return ""


def _solver_problem(scene: Scene) -> str:
    """Return why the linear solver asked for cannot do the scene, or an empty text."""
    solver, contact = scene.methods.fem.solver, scene.methods.fem.contact
    if solver == "nested_dissection":
        return ""
    if not _quadratic(scene) or isinstance(scene.indenter, STRAIGHT_EDGED):
        return f"solver {solver} is for single contacts on a mesh that is fitted to them"
    if scene.half_space.elastic_constants[1] > LARGEST_POISSON:
        return f"solver {solver} needs a definite matrix: nu up to {LARGEST_POISSON}"
    if solver == "multigrid" and contact != "active_set":
        return "solver multigrid takes contact = active_set only"
    if solver == "pardiso" and not pardiso.available():
        return "pypardiso is not installed (pip install 'roughline[fast]')"
    return ""


def _quadratic(scene: Scene) -> bool:
    """Whether the body is a half-space of 27-node elements, which have a mixed form."""
    if scene.indenter is None or scene.counter_body is not None or scene.body is not None:
        return False
    if isinstance(scene.indenter, STRAIGHT_EDGED):
        return fem_punch.second_order(scene.indenter)
    return scene.indenter.quarter_symmetric


def _sharp(geometry: IndenterGeometry) -> bool:
    """Whether the pressure is singular at the edge of the contact, or nearly so."""
    indenter = geometry.indenter
    if isinstance(indenter, RoundedPunch):
        return indenter.flat_radius > 0.3 * geometry.contact_radius
    return indenter.flat


def contact_stretch(indenter: Indenter) -> tuple[float, float]:
    """Return how the contact ellipse deviates from the circle of equal area."""
    if isinstance(indenter, Ellipsoid):
        half_x, half_y = ellipsoid(indenter.radius_x, indenter.radius_y, 1.0).semi_axes(1.0)
    elif isinstance(indenter, EllipticPunch):
        half_x, half_y = indenter.semi_axes
    else:
        return 1.0, 1.0
    ratio = float(np.sqrt(half_x / half_y))
    return ratio, 1 / ratio


def _elongated(geometry: IndenterGeometry, resolution: int) -> str:
    """Return why a very elongated contact is out of reach, or an empty text."""
    if isinstance(geometry.indenter, STRAIGHT_EDGED):
        number, most = fem_punch.face_grid(geometry, resolution).unknowns, fem_punch.MOST_UNKNOWNS
        return f"about {number} unknowns, more than {most}" if number > most else ""
    longer = max(contact_stretch(geometry.indenter)) ** 2
    if longer <= LARGEST_ASPECT:
        return ""
    return f"a contact {longer:.0f} times as long as wide: elements are tested to {LARGEST_ASPECT}"


def _gap(task: Task, body: fem.CondensedBody, realisation: int) -> np.ndarray:
    if isinstance(task.geometry, RoughGeometry):
        heights = task.geometry.heights(realisation, task.resolution)
        return np.ravel(heights.max() - heights)
    assert isinstance(task.geometry, IndenterGeometry)
    return fem_punch.face_gap(task.geometry, body.points)


def _quantities(task: Task, step: Step) -> dict[str, float]:
    contact = step.contact
    area = _area(task.geometry, contact)
    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area": area,
        "contact_area_raw": contact.contact_area_raw,
        "equivalent_radius": float(np.sqrt(area / np.pi)),
        "stiffness": contact.stiffness,
        "contact_length_stiffness": contact.stiffness / step.body.effective_modulus,
        "energy": contact.energy,
    }
    if isinstance(task.geometry, RoughGeometry):
        gap = step.gap
        values["mean_gap"] = float(np.mean(gap + contact.displacement) - contact.penetration)
        values["penetration_mean_plane"] = contact.penetration - float(gap.mean())
    elif task.geometry.indenter.axisymmetric:
        values["contact_radius"] = values["equivalent_radius"]
    return values


def _area(geometry: Geometry, contact: fem.Contact) -> float:
    """Return the best estimate of the contact area.

    The nodes of a rough patch form a grid, so the perimeter correction of grids applies. The face
    of a flat punch is known.
    """
    if isinstance(geometry, RoughGeometry):
        points = round(np.sqrt(contact.active.size * geometry.points[0] / geometry.points[1]))
        mask = contact.active.reshape(points, -1)
        spacing = geometry.spacing(mask)
        return float(corrected_area(mask, spacing))
    if geometry.indenter.flat:
        return geometry.indenter.area
    return contact.contact_area


def _fields(task: Task, step: Step) -> dict[str, np.ndarray]:
    """Return the arrays that plots and pictures use."""
    body, contact = step.body, step.contact
    fields = {"penetration": np.array(contact.penetration)}
    if isinstance(task.geometry, RoughGeometry):
        fields["heights"] = task.geometry.heights(task.realisations[0], task.resolution)
        fields["size"] = np.array(task.geometry.size)
        fields["contact"] = (contact.pressure > 0).reshape(fields["heights"].shape)
    if not task.wants_pressure:
        return fields
    return fields | {
        "pressure_x": body.points[:, 0],
        "pressure_y": body.points[:, 1],
        "pressure": contact.pressure,
        # The symmetric parts count with the one that is meshed.
        "pressure_weight": body.symmetry * body.weights,
        "displacement": contact.displacement,
        "gap": step.gap - contact.penetration + contact.displacement,
    }


def _body_fields(step: Step) -> dict[str, np.ndarray]:
    recovered = fem.recover(step.body, step.contact.reactions)
    return {
        "mesh_points": recovered.points,
        "mesh_cells": recovered.cells,
        "mesh_displacement": recovered.displacement,
        "mesh_von_mises": recovered.von_mises,
    }
