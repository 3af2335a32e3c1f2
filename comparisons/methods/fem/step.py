"""One load step on condensed finite elements: common quantities and arrays for every mesh."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from functools import partial

import numpy as np

from comparisons.tasks.shown_loads import Fields, point_pressure
from comparisons.tasks.steps import Step
from comparisons.tasks.task import Task
from reference import fem
from reference.fem.contact import radius_from_moments


@dataclass(frozen=True)
class SolvedContact:
    """A contact at one load.

    Attributes
    ----------
    body : CondensedBody
        Whose points the pressures stand at.
    gap : (n,) ndarray
        Initial gap there.
    contact : NodalContact
    area : float
        Best estimate of the contact area.
    """

    body: fem.CondensedBody
    gap: np.ndarray
    contact: fem.NodalContact
    area: float


def contact_step(
    task: Task,
    solved: SolvedContact,
    *,
    body_fields: Callable[[], Fields],
    quantities: Mapping[str, float] | None = None,
    fields: Mapping[str, np.ndarray] | None = None,
) -> Step:
    """Return the step of a solved contact.

    Parameters
    ----------
    task : Task
    solved : SolvedContact
    body_fields : callable
        Computes the fields in the body.
    quantities, fields : mapping, optional
        What this kind of contact has beside the common ones.
    """
    contact = solved.contact
    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area": solved.area,
        "contact_area_raw": contact.contact_area_raw,
        "stiffness": contact.stiffness,
        "energy": contact.energy,
    }
    return Step(
        values | dict(quantities or {}),
        iterations=contact.iterations,
        violation=contact.violation,
        pressure=partial(point_pressure, solved.body.points, contact.pressure),
        fields=partial(_fields, task, solved, fields or {}),
        body_fields=body_fields,
    )


def _fields(
    task: Task, solved: SolvedContact, more: Mapping[str, np.ndarray]
) -> dict[str, np.ndarray]:
    """Return the arrays that plots and pictures use."""
    body, contact = solved.body, solved.contact
    fields = {"penetration": np.array(contact.penetration), **more}
    if not task.wants_pressure:
        return fields
    return fields | {
        "pressure_x": body.points[:, 0],
        "pressure_y": body.points[:, 1],
        "pressure": contact.pressure,
        # The symmetric parts count with the one that is meshed.
        "pressure_weight": body.symmetry * body.weights,
        # Of two bodies: what the indenter's own surface gives way counts, too.
        "displacement": contact.displacement,
        "gap": solved.gap - contact.penetration + contact.displacement,
    }


def recovered(body: fem.CondensedBody, forces: np.ndarray) -> dict[str, np.ndarray]:
    """Return displacement and von Mises stress in a body under the forces on its surface."""
    inside = fem.recover(body, forces)
    return {
        "mesh_points": inside.points,
        "mesh_cells": inside.cells,
        "mesh_displacement": inside.displacement,
        "mesh_von_mises": inside.von_mises,
    }


def round_area(body: fem.CondensedBody, contact: fem.NodalContact) -> float:
    """Return the area of a round contact on a plane.

    From the radius that the moments of the pressure give, where it agrees with the nodes that
    touch; else their tributary area, uncertain by half a spacing all round.
    """
    if not contact.active.any():
        return contact.contact_area
    radii = np.hypot(*body.points.T)
    radius = radius_from_moments(radii, contact.reactions)
    spacing = np.sqrt(body.weights[contact.active].max())
    if radius is None or abs(radius - radii[contact.active].max()) > spacing:
        return contact.contact_area
    return float(np.pi * radius**2)
