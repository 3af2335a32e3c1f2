"""Drake's hydroelastic contact in a separate process: a rigid ball, a soft half-space.

Drake (https://drake.mit.edu, BSD-3) integrates a pressure E_h (depth)/(thickness) over the surface
where the ball overlaps the half-space. Nothing moves: the ball is placed, contact is evaluated.

A ball of radius 1, a slab of thickness 1. Drake refines its own sphere no further than a
`resolution_hint` of about 0.0075, too coarse for shallow contacts: ours is a cap, of rings that
grow geometrically.
"""

from __future__ import annotations

import time
from pathlib import Path
from typing import Any

import numpy as np
from pydrake.geometry import (
    AddCompliantHydroelasticPropertiesForHalfSpace,
    AddContactMaterial,
    AddRigidHydroelasticProperties,
    HalfSpace,
    Mesh,
    ProximityProperties,
)
from pydrake.math import RigidTransform
from pydrake.multibody.plant import AddMultibodyPlantSceneGraph, ContactModel, CoulombFriction
from pydrake.multibody.tree import SpatialInertia
from pydrake.systems.framework import DiagramBuilder

# Triangles around a ring, and rings to each factor e of the radius: they are about square.
AROUND = 128
PER_E_FOLD = 20


def solve(problem: dict[str, Any]) -> dict[str, Any]:
    """Place a ball of radius 1 at depths (k,), on a slab of a `hydroelastic_modulus`.

    Returns force and contact_area (k,), unknowns (faces of the last contact), seconds,
    setup_seconds.
    """
    begin = time.perf_counter()
    cap = Path("cap.obj").absolute()
    _write_cap(cap, problem["depths"])
    builder = DiagramBuilder()
    plant, _ = AddMultibodyPlantSceneGraph(builder, time_step=0.0)
    plant.set_contact_model(ContactModel.kHydroelastic)
    ball = plant.AddRigidBody("ball", SpatialInertia.SolidSphereWithMass(1.0, 1.0))
    rigid, soft = ProximityProperties(), ProximityProperties()
    AddRigidHydroelasticProperties(1.0, rigid)
    AddCompliantHydroelasticPropertiesForHalfSpace(1.0, problem["modulus"], soft)
    for properties in (rigid, soft):
        AddContactMaterial(
            dissipation=0.0, friction=CoulombFriction(0.0, 0.0), properties=properties
        )
    here = RigidTransform()
    plant.RegisterCollisionGeometry(ball, here, Mesh(str(cap), 1.0), "ball", rigid)
    plant.RegisterCollisionGeometry(plant.world_body(), here, HalfSpace(), "slab", soft)
    plant.Finalize()
    diagram = builder.Build()
    context = diagram.CreateDefaultContext()
    state = plant.GetMyMutableContextFromRoot(context)
    ready = time.perf_counter()
    rows, faces = [], 0
    for depth in problem["depths"]:
        plant.SetFreeBodyPose(state, ball, RigidTransform([0.0, 0.0, 1.0 - depth]))
        results = plant.get_contact_results_output_port().Eval(state)
        if not results.num_hydroelastic_contacts():
            rows.append((0.0, 0.0))
            continue
        contact = results.hydroelastic_contact_info(0)
        surface = contact.contact_surface()
        faces = surface.num_faces()
        rows.append((abs(contact.F_Ac_W().translational()[2]), surface.total_area()))
    force, area = np.array(rows).T
    return {
        "force": force,
        "contact_area": area,
        "unknowns": int(faces),
        "seconds": time.perf_counter() - begin,
        "setup_seconds": ready - begin,
    }


def _write_cap(file: Path, depths: list[float]) -> None:
    """Write the lower cap of the ball: rings from well inside the smallest overlap outwards."""
    inside, outside = 0.1 * np.sqrt(min(depths)), min(1.6 * np.sqrt(max(depths)), 1.0)
    rings = int(np.ceil(PER_E_FOLD * np.log(outside / inside))) + 1
    radius = np.geomspace(inside, outside, rings)[:, None]
    angle = 2 * np.pi * np.arange(AROUND) / AROUND
    height = -np.sqrt(np.maximum(1 - radius**2, 0)) + 0 * angle
    rim = np.stack([radius * np.cos(angle), radius * np.sin(angle), height], axis=-1)
    points = np.vstack([[0.0, 0.0, -1.0], rim.reshape(-1, 3)])
    number = 2 + np.arange(rings * AROUND).reshape(rings, AROUND)  # from 1, which is the pole
    following = np.roll(number, -1, axis=1)
    triangles = [
        (np.ones(AROUND, dtype=int), following[0], number[0]),
        (number[:-1], following[:-1], following[1:]),
        (number[:-1], following[1:], number[1:]),
    ]
    faces = np.vstack([np.stack(corners, axis=-1).reshape(-1, 3) for corners in triangles])
    with file.open("w") as text:
        np.savetxt(text, points, fmt="v %.17g %.17g %.17g")
        np.savetxt(text, faces, fmt="f %d %d %d")
