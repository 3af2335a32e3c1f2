"""One load step on automata: quantities and arrays, of indenters and of rough patches."""

from __future__ import annotations

from functools import partial

import numpy as np

from comparisons.geometry.prepare import RoughGeometry
from comparisons.methods.normal.grid import Grid, contact_fields, pressure_of
from comparisons.tasks.steps import Step
from comparisons.tasks.task import Task
from reference.halfspace import Contact, FreeOperator
from reference.halfspace.contact_line import located_area
from reference.loads import Load
from reference.particles import ParticleContact, ParticleHalfSpace


def contact_step(
    task: Task,
    body: ParticleHalfSpace,
    contact: ParticleContact,
    net: tuple[np.ndarray, Grid],
) -> Step:
    """Return the step of a solved contact.

    Parameters
    ----------
    task : Task
    body : ParticleHalfSpace
    contact : ParticleContact
    net : (ndarray, Grid)
        The automata that are cells of the grid of results, and this grid.
    """
    numbers, grid = net
    cells = _as_cells(body, contact, numbers, grid)
    counted = float(np.count_nonzero(contact.active)) * body.spacing**2
    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area_raw": counted,
        "contact_area": counted,
    }
    if not contact.flowed.any():  # elastic: the pressure falls to zero at the edge as a root
        area = located_area(cells, patch=isinstance(task.geometry, RoughGeometry))
        values |= {"contact_area": area, "energy": contact.energy}
    face = None if task.scene.indenter is None else task.scene.indenter.face_area
    if face is not None:
        values["contact_area"] = face
    if isinstance(task.geometry, RoughGeometry):
        values["mean_gap"] = float(cells.gap.mean())
        values["penetration_mean_plane"] = contact.penetration - float(grid.gap.mean())
    if {"stiffness", "contact_length_stiffness"} & set(task.quantities):
        outline = values["contact_area"] / counted
        values["stiffness"] = np.sqrt(outline) * _stiffness(body, contact)
    return Step(
        values,
        iterations=contact.steps,
        violation=contact.imbalance,
        unknowns=body.bodies * 6 * body.automata.packing.free,
        pressure=pressure_of(task, cells, grid),
        fields=partial(contact_fields, task, cells, grid),
        body_fields=partial(_inside, body, contact),
    )


def _as_cells(
    body: ParticleHalfSpace, contact: ParticleContact, numbers: np.ndarray, grid: Grid
) -> Contact:
    """Return the contact as one on a grid of cells around the automata of the surface."""
    shape, area = grid.gap.shape, body.spacing**2
    operator = FreeOperator(shape, grid.spacing, body.effective_modulus)
    pressure = contact.reactions[numbers].reshape(shape) / area
    cells = Contact(
        penetration=contact.penetration,
        force=float(pressure.sum() * operator.cell_area),
        pressure=pressure,
        iterations=contact.steps,
        violation=contact.imbalance,
        operator=operator,
        initial_gap=grid.gap,
        history=list(contact.history),
    )
    # that of the automata, not what the operator would make of their pressure
    vars(cells)["displacement"] = contact.displacement[numbers].reshape(shape)
    return cells


def _stiffness(body: ParticleHalfSpace, contact: ParticleContact) -> float:
    """Return dF/dd of a flat punch on the automata that touch, of the area that is counted."""
    punch = np.where(contact.active, 0.0, np.inf)
    load = Load("penetration", contact.penetration)
    (pressed,) = body.press(punch, load)
    return pressed.force / pressed.penetration


def _inside(body: ParticleHalfSpace, contact: ParticleContact) -> dict[str, np.ndarray]:
    """Return places, displacements and von Mises stresses of the automata that move."""
    places, displacement, stresses = body.inside(contact)
    return {
        "particle_places": places,
        "particle_displacement": displacement,
        "particle_von_mises": stresses,
        "particle_spacing": np.array(body.spacing),
    }
