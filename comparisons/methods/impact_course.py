"""The course of an impact in time: on springs in steps, and on the closed form."""

from __future__ import annotations

import numpy as np

from comparisons.methods.base import Solution, Task
from comparisons.methods.closed_form import form_of
from comparisons.methods.reduced import profile_of
from reduced.errors import ConvergenceError
from reduced.motion.contact import SpringContact, impact_depth, spring_contact
from reduced.motion.course import Motion, move
from reference.dynamics.course import course

# Steps per shortest period of the motion, for each spring per contact radius.
_STEPS_PER_SPRING = 25
_MOST_STEPS = 10_000_000
_RECORDS = 20_000
_DEEPER, _ROUNDS = 1.5, 12

History = tuple[np.ndarray, np.ndarray] | None


def history_of(task: Task) -> History:
    """Return times and forces on the mass, None where nothing pushes it."""
    if task.loads.control != "force":
        return None
    assert task.loads.times is not None
    return task.loads.times, task.loads.values


def closed_course(task: Task) -> Solution:
    """Integrate the motion on the closed form of the contact."""
    solution, scene = Solution.empty(task), task.scene
    assert scene.indenter is not None
    assert scene.dynamics is not None
    assert task.loads.times is not None
    form = form_of(scene.indenter, scene.effective_modulus)
    assert form is not None
    times, start = task.loads.times, scene.dynamics.velocity.values[0]
    x = np.zeros(times.size)
    later = times > 0
    x[later] = course(form, scene.dynamics.mass, start, times[later], history_of(task))[0]
    inside = np.maximum(x, 0.0)
    _fill(solution, task, x, np.asarray(form.force(inside)), np.asarray(form.contact_area(inside)))
    solution.violation[:] = 0.0
    return solution


def spring_course(task: Task, resolution: int) -> Solution:
    """Step the mass on the springs; springs and steps are refined together."""
    solution = Solution.empty(task, unknowns=2 * resolution)
    try:
        contact, motion = _moved(task, resolution)
    except ConvergenceError as error:
        for step in range(len(task.loads.values)):
            solution.fail((0, step), error.reason)
        return solution
    x = motion.at(task.loads.times)[0]
    force, _, stiffness = contact.respond(x)
    radius = stiffness / (2 * task.scene.effective_modulus)
    _fill(solution, task, x, force, np.pi * radius**2)
    solution.iterations[:] = motion.evaluations
    return solution


def _fill(
    solution: Solution, task: Task, x: np.ndarray, force: np.ndarray, area: np.ndarray
) -> None:
    """Store the curves; where a force on the mass is prescribed, that of the contact is another."""
    curves = {"penetration": x, "contact_area": area, "contact_area_raw": area}
    if task.loads.control != "force":
        curves["force"] = force
    solution.quantities = {name: values[None, :] for name, values in curves.items()}
    solution.converged[:] = True


def _moved(task: Task, resolution: int) -> tuple[SpringContact, Motion]:
    """Lay out springs and steps for the deepest point, and again where the motion goes deeper.

    A force that swings in time may drive the mass deeper than its energy at the start.
    """
    scene, history = task.scene, history_of(task)
    assert scene.dynamics is not None
    assert task.loads.times is not None
    profile, modulus, mass = profile_of(scene), scene.effective_modulus, scene.dynamics.mass
    speed = scene.dynamics.velocity.values[0]
    push = 0.0 if history is None else max(0.0, float(history[1].max()))
    deepest = impact_depth(profile, modulus, 0.5 * mass * speed**2, push)
    end = float(task.loads.times[-1])
    for _ in range(_ROUNDS):
        contact = spring_contact(profile, modulus, deepest, springs=resolution)
        stiffness = float(contact.respond(deepest)[2])
        period = 2 * np.pi * np.sqrt(mass / stiffness)
        steps = int(np.ceil(max(_STEPS_PER_SPRING * resolution * end / period, 1.0)))
        every = max(1, steps // _RECORDS)
        steps = every * -(-steps // every)
        if steps > _MOST_STEPS:
            raise ConvergenceError(f"{steps} steps of {period:.3g} s/{resolution}: too long", [])
        motion = move(
            *(contact, mass),
            step=end / steps,
            steps=steps,
            velocity=speed,
            history=history,
            every=every,
        )
        reached = float(motion.position.max())
        if reached <= deepest:
            return contact, motion
        deepest = _DEEPER * reached
    raise ConvergenceError("the mass goes ever deeper", [deepest])
