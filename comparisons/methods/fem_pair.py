"""How the method `fem` solves two elastic bodies: a mesh for each, coupled at the contact.

Two half-spaces in quarter symmetry, the shape of the indenter as their initial distance. Their
grids do not match, and neither has a length of its own, so each load scales both to its contact.
"""

from __future__ import annotations

from functools import partial

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.base import Solution, Task
from comparisons.methods.fem_body import round_area
from comparisons.scene.options import FemOptions
from comparisons.scene.scene import Scene
from comparisons.tasks.shown_loads import point_pressure
from reference import fem
from reference.errors import ConvergenceError
from reference.fem.two_bodies import BodyPair, couple

# Cells of the grid per element along a contact radius: it covers the geometric overlap.
COVERED = 1.45
# Of one body, measured from 2 to 6 elements per radius.
UNKNOWNS_PER_SQUARE = 2_200


def meshes_both(scene: Scene, geometry: Geometry) -> bool:
    """Whether both bodies get a mesh: an indenter with a counter body, and a coupling."""
    options = scene.methods.fem
    return (
        scene.counter_body is not None
        and isinstance(geometry, IndenterGeometry)
        and options.coupling != "effective_modulus"
    )


def unknowns(resolution: int) -> int:
    """Return about how many unknowns the larger of the two bodies has."""
    return UNKNOWNS_PER_SQUARE * (resolution + 1) ** 2


def model(scene: Scene) -> str:
    """Say what is solved."""
    coupling = scene.methods.fem.coupling.replace("_", "-")
    return (
        f"a quarter of both bodies, on grids that do not match, {coupling} contact between them, "
        "scaled to each load; outside them Boussinesq fields"
    )


def solve(task: Task) -> Solution:
    """Condense and couple both bodies once, then press them together load by load."""
    geometry = task.geometry
    assert isinstance(geometry, IndenterGeometry)
    solution = Solution.empty(task)
    with solution.setup():
        pair = _pair(task, geometry)
    solution.unknowns = pair.combined.unknowns
    for step, load in enumerate(task.loads.values):
        size = geometry.contact_radii[step] / geometry.contact_radius
        if not size > 0.0:
            solution.fail((0, step), geometry.unreached.get(step, "no estimate of its contact"))
            continue
        scaled = pair.scaled(size)
        try:
            (contact,) = scaled.press(geometry.indenter.gap, **{task.loads.control: load})
        except ConvergenceError as error:
            solution.fail((0, step), error.reason)
            continue
        solution.put((0, step), _quantities(task, geometry, scaled, contact))
        solution.iterations[0, step] = contact.iterations
        solution.violation[0, step] = contact.violation
        if task.wants_pressure:
            build = partial(point_pressure, scaled.combined.points, contact.pressure)
            solution.keep((0, step), build)
        if step == len(task.loads.values) - 1:
            solution.fields = _fields(task, geometry, scaled, contact)
            if task.with_body:
                solution.body_fields = partial(_body_fields, scaled, contact)
    return solution


def _pair(task: Task, geometry: IndenterGeometry) -> BodyPair:
    """Return both bodies; the pressures live on the half-space of the scene."""
    scene, options = task.scene, task.options
    assert scene.counter_body is not None
    assert isinstance(options, FemOptions)
    bodies = []
    for cells, table in (
        (task.resolution, scene.half_space),
        (task.resolution + 1, scene.counter_body),
    ):
        share = np.linspace(0.0, 1.0, round(COVERED * cells) + 1)
        lines = [half * share for half in geometry.reach]
        moduli = table.elastic_constants
        bodies.append(fem.tensor_body(*lines, *moduli, symmetry="quarter", order=2))
    return couple(*bodies, coupling=options.coupling)


def _quantities(
    task: Task, geometry: IndenterGeometry, pair: BodyPair, contact: fem.Contact
) -> dict[str, float]:
    area = contact.contact_area
    if geometry.indenter.axisymmetric:
        area = round_area(pair.combined, contact)
    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area": area,
        "contact_area_raw": contact.contact_area_raw,
        "equivalent_radius": float(np.sqrt(area / np.pi)),
        "stiffness": contact.stiffness,
        "contact_length_stiffness": contact.stiffness / task.scene.effective_modulus,
        "energy": contact.energy,
    }
    if geometry.indenter.axisymmetric:
        values["contact_radius"] = values["equivalent_radius"]
    return values


def _fields(
    task: Task, geometry: IndenterGeometry, pair: BodyPair, contact: fem.Contact
) -> dict[str, np.ndarray]:
    fields = {"penetration": np.array(contact.penetration)}
    if not task.wants_pressure:
        return fields
    body = pair.combined
    gap = geometry.indenter.gap(*body.points.T)
    return fields | {
        "pressure_x": body.points[:, 0],
        "pressure_y": body.points[:, 1],
        "pressure": contact.pressure,
        "pressure_weight": body.symmetry * body.weights,
        # of both bodies together: what the indenter's own surface gives way counts too
        "displacement": contact.displacement,
        "gap": gap - contact.penetration + contact.displacement,
    }


def _body_fields(pair: BodyPair, contact: fem.Contact) -> dict[str, np.ndarray]:
    """Return the fields in the half-space of the scene."""
    recovered = fem.recover(pair.slave, pair.forces(contact)[0])
    return {
        "mesh_points": recovered.points,
        "mesh_cells": recovered.cells,
        "mesh_displacement": recovered.displacement,
        "mesh_von_mises": recovered.von_mises,
    }
