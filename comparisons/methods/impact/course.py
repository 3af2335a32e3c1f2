"""Time history of an impact, on springs and on the closed form."""

from __future__ import annotations

import numpy as np

from comparisons.scene.physics.absolute_loads import AbsoluteLoads
from comparisons.scene.physics.tables.dynamics import Dynamics
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.errors import ConvergenceError
from reduced.motion.course import Mass, Motion, Push, move
from reduced.motion.elastic_impact import SpringContact, impact_depth, spring_contact
from reduced.motion.stepping import Stepping
from reduced.profiles.equivalents import Profile
from reduced.springs.line import Springs
from reference.closed_form import ClosedForm
from reference.dynamics.vibration import course

# Steps per shortest period of the motion, for each spring per contact radius.
_STEPS_PER_SPRING = 25
_MOST_STEPS = 10_000_000
_RECORDS = 20_000
_DEEPER, _ROUNDS = 1.5, 12

History = tuple[np.ndarray, np.ndarray] | None


def history_of(loads: AbsoluteLoads, times: np.ndarray) -> History:
    """Return times and forces on the mass, None where nothing pushes it."""
    return (times, loads.values) if loads.control == "force" else None


def closed_course(task: Task, times: np.ndarray, form: ClosedForm, dynamics: Dynamics) -> Solution:
    """Integrate the motion on the closed form of the contact."""
    x = np.zeros(times.size)
    later, history = times > 0, history_of(task.loads, times)
    x[later] = course(form, dynamics.mass, dynamics.velocity.values[0], times[later], history)[0]
    inside = np.maximum(x, 0.0)
    curves = {"penetration": x, "contact_area": np.asarray(form.contact_area(inside))}
    return Solution.of(task, curves | _force(task, form.force(inside)), violation=0.0)


def spring_course(
    task: Task, times: np.ndarray, profile: Profile, dynamics: Dynamics, resolution: int
) -> Solution:
    """Step the mass on the springs; springs and steps are refined together."""
    modulus, history = task.scene.effective_modulus, history_of(task.loads, times)
    contact, motion = _moved(profile, modulus, dynamics, history, float(times[-1]), resolution)
    x = motion.at(times)[0]
    force, _, stiffness = contact.respond(x)
    curves = {"penetration": x, "equivalent_radius": stiffness / (2 * modulus)}
    curves |= _force(task, force)
    return Solution.of(task, curves, unknowns=2 * resolution, iterations=motion.evaluations)


def _force(task: Task, force: np.ndarray) -> dict[str, np.ndarray]:
    """Return the contact's force, but where one on the mass is prescribed: that is another."""
    return {} if task.loads.control == "force" else {"force": np.asarray(force)}


def _moved(
    profile: Profile,
    modulus: float,
    dynamics: Dynamics,
    history: History,
    end: float,
    resolution: int,
) -> tuple[SpringContact, Motion]:
    """Lay out springs and steps for the deepest point, and again where the motion goes deeper.

    A force that swings in time may drive the mass deeper than its energy at the start.
    """
    mass, speed = dynamics.mass, dynamics.velocity.values[0]
    push = 0.0 if history is None else max(0.0, float(history[1].max()))
    deepest = impact_depth(profile, modulus, 0.5 * mass * speed**2, push)
    for _ in range(_ROUNDS):
        contact = spring_contact(Springs(profile, modulus, per_radius=resolution), deepest)
        stiffness = float(contact.respond(deepest)[2])
        period = 2 * np.pi * np.sqrt(mass / stiffness)
        steps = int(np.ceil(max(_STEPS_PER_SPRING * resolution * end / period, 1.0)))
        stride = max(1, steps // _RECORDS)
        steps = stride * -(-steps // stride)
        if steps > _MOST_STEPS:
            raise ConvergenceError(f"{steps} steps of {period:.3g} s/{resolution}: too long", [])
        motion = move(
            contact,
            Mass(mass, velocity=speed),
            Stepping(end / steps, steps, stride=stride),
            Push() if history is None else Push(history=history),
        )
        reached = float(motion.position.max())
        if reached <= deepest:
            return contact, motion
        deepest = _DEEPER * reached
    raise ConvergenceError("the penetration grows without limit", [deepest])
