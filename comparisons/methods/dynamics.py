"""Masses that collide, in elastic or viscoelastic contact.

Springs by energy or in steps of time, closed forms, and the static load curve of methods that
compute forces but not energies.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import Any, ClassVar

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry, equivalent_profile, indenter_geometry
from comparisons.methods import Refused, Solution, Solver, Step, Task, needed
from comparisons.methods.fem.indenter import Fem
from comparisons.methods.normal.bem import BemDense, BemFft
from comparisons.methods.normal.closed_form import FormSolver
from comparisons.methods.normal.reduced import ProfileSolver
from comparisons.methods.runner import run
from comparisons.methods.viscoelastic import SOURCES, body_of, circular, material_of, springs_of
from comparisons.scene.loading import AbsoluteLoads, loads_of
from comparisons.scene.physics.tables.dynamics import Dynamics
from comparisons.scene.scene import Scene, validated
from reduced.errors import ConvergenceError
from reduced.memory.in_time import impact as strike_viscoelastic
from reduced.memory.row import RelaxingSprings
from reduced.motion.course import Mass, Push, Stepping, move
from reduced.motion.elastic_impact import SpringContact, impact_depth, strike
from reduced.springs.line import Springs
from reference import viscoelastic as reference
from reference.dynamics.collision import collide, collide_curve, course

PHYSICS = frozenset({"dynamics"})
VISCOELASTIC = frozenset({"viscoelastic", "dynamics"})
NO_TABLE = "no [dynamics]"
ONLY_INDENTERS = "impacts are for single contacts only, not for rough surfaces"
# Steps per shortest period of the motion, for each spring per contact radius.
_STEPS_PER_SPRING = 25
_MOST_STEPS = 10_000_000
_RECORDS = 20_000
_DEEPER, _ROUNDS = 1.5, 12

History = tuple[np.ndarray, np.ndarray] | None


def history_of(loads: AbsoluteLoads, times: np.ndarray) -> History:
    """Return times and forces on the mass, None where nothing pushes it."""
    return (times, loads.values) if loads.control == "force" else None


def _force(task: Task, force: np.ndarray) -> dict[str, np.ndarray]:
    """Return the contact's force, but where one on the mass is prescribed: that is another."""
    return {} if task.loads.control == "force" else {"force": np.asarray(force)}


def struck(velocity: float, hit: Any, penetration: float, force: float) -> dict[str, float]:
    """Return the quantities of an impact; elastic bodies give back all of the energy."""
    return {
        "velocity": float(velocity),
        "restitution": getattr(hit, "restitution", 1.0),
        "penetration": penetration,
        "force": force,
        "contact_duration": hit.duration,
    }


# The ladder: from this share of the shallowest impact to this multiple of the deepest estimate.
_SHALLOWEST, _DEEPEST = 0.05, 1.2
_PER_DECADE, _FEWEST = 10, 12


def static_scene(scene: Scene, penetration: np.ndarray) -> Scene:
    """Return the same contact without a mass, pressed slowly to the given penetrations."""
    data = scene.model_dump(exclude_defaults=True)
    data["directory"] = scene.directory
    data["loading"] = {"penetration": {"values": penetration.tolist()}}
    data["compare"] = data.get("compare", {}) | {"quantities": ["force"]}
    del data["dynamics"]
    return validated(data)


def _striking(scene: Scene) -> Dynamics:
    """Return the mass that strikes once; refuse where the course of the impact is asked for."""
    if scene.loading.time is not None:
        raise Refused("computes impacts, not their time history")
    return needed(scene.dynamics, NO_TABLE)


class CurveImpact(Solver[IndenterGeometry]):
    """A 3-D method that strikes along its own static load curve.

    `static` is the solver that presses. `ladder_span` is the largest ratio of contact radii on one
    of its grids: energy sums up the curve from its beginning, so that contacts differ less than
    where each load stands for itself.
    """

    physics = PHYSICS
    static: ClassVar[type[Solver[Any]]]
    ladder_span = 3.0

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, ONLY_INDENTERS)
        self.dynamics = _striking(scene)
        # Any depth will do: only the kind of load matters here.
        self.slow = self.static(static_scene(scene, np.array([1e-9])))
        self.note = self.slow.note

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        return self.slow.resolutions(geometry)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        return self.slow.refusal(task)

    def memory(self, task: Task[IndenterGeometry]) -> float:
        return self.slow.memory(task)

    def model(self, geometry: IndenterGeometry) -> str:
        return f"{self.slow.model(geometry)}; the impact by energy along its load curve"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        self.slow.warm_up(self._pressed(task, deep=False))

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        slow = self._pressed(task)
        pressed = run(self.static(slow.scene), slow, span=self.ladder_span, reason=str)
        answered = pressed.converged[0]
        solution = Solution.empty(task, unknowns=pressed.unknowns)
        solution.setup_seconds = pressed.setup_seconds
        solution.exact = ("restitution",)
        curve = (slow.loads.values[answered], pressed.quantities["force"][0, answered])
        mass = self.dynamics.mass
        for step, velocity in enumerate(task.loads.values):
            try:
                hit = collide_curve(*curve, mass, float(velocity), bar=pressed.truncation)
            except (ValueError, RuntimeError) as error:
                solution.fail((0, step), str(error))
                continue
            solution.put((0, step), struck(velocity, hit, hit.penetration, hit.force))
            solution.truncation = max(solution.truncation, hit.bar)
        solution.iterations[:] = pressed.iterations.sum()
        solution.violation[:] = float(np.nanmax(pressed.violation, initial=0.0))
        return solution

    def _pressed(
        self, task: Task[IndenterGeometry], *, deep: bool = True
    ) -> Task[IndenterGeometry]:
        """Return the task of the slow contact, on a ladder of penetrations.

        Its first one alone, if not `deep`: a fast impact may go beyond the shape.
        """
        slowest = 0.5 * self.dynamics.mass * float(task.loads.values[0]) ** 2
        profile = equivalent_profile(self.indenter)
        low = _SHALLOWEST * impact_depth(profile, self.scene.effective_modulus, slowest)
        high = _DEEPEST * task.geometry.penetration
        count = max(_FEWEST, round(_PER_DECADE * np.log10(high / low)) + 1)
        depths = np.geomspace(low, high, count)
        slow = static_scene(self.scene, depths if deep else depths[:1])
        loads = loads_of(slow)
        pressed = indenter_geometry(slow, loads)
        return replace(
            task, scene=slow, geometry=pressed, loads=loads, quantities=("force",), with_body=False
        )


class ReducedImpact(ProfileSolver):
    """The mass on the springs of its equivalent profile: by energy, or in steps of time."""

    name = "reduced"
    physics = PHYSICS
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.edges = scene.methods.reduced.edges
        if scene.loading.time is not None and self.edges == "nodal":
            raise Refused("time stepping needs sub-cell contact edges (edges = 'sub_cell')")
        self.dynamics = needed(scene.dynamics, NO_TABLE)
        course = "by its energy, without time steps"
        if scene.loading.time is not None:
            course = "in steps of time that keep the energy, refined with the springs"
        self.beside = f"the impact {course}"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        unknowns = 2 * task.resolution
        mass, times = self.dynamics.mass, task.loads.times
        if times is not None:  # springs and steps are refined together
            speed, resolution = self.dynamics.velocity.values[0], task.resolution
            end, history = float(times[-1]), history_of(task.loads, times)
            push = 0.0 if history is None else max(0.0, float(history[1].max()))
            deepest = impact_depth(self.profile, self.modulus, 0.5 * mass * speed**2, push)
            for _ in range(_ROUNDS):
                row = Springs(self.profile, self.modulus, per_radius=resolution)
                contact = SpringContact(row, deepest)
                stiffness = float(contact.respond(deepest)[2])
                period = 2 * np.pi * np.sqrt(mass / stiffness)
                steps = int(np.ceil(max(_STEPS_PER_SPRING * resolution * end / period, 1.0)))
                stride = max(1, steps // _RECORDS)
                steps = stride * -(-steps // stride)
                if steps > _MOST_STEPS:
                    reason = f"{steps} steps of {period:.3g} s/{resolution}: too long"
                    raise ConvergenceError(reason, [])
                motion = move(
                    contact,
                    Mass(mass, velocity=speed),
                    Stepping(end / steps, steps, stride=stride),
                    Push() if history is None else Push(history=history),
                )
                reached = float(motion.position.max())
                if reached <= deepest:
                    break
                # a force that swings in time may drive the mass deeper than its energy at the start
                deepest = _DEEPER * reached
            else:
                raise ConvergenceError("the penetration grows without limit", [deepest])
            x = motion.at(times)[0]
            force, _, stiff = contact.respond(x)
            curves = {"penetration": x, "equivalent_radius": stiff / (2 * self.modulus)}
            curves |= _force(task, force)
            return Solution.of(task, curves, unknowns=unknowns, iterations=motion.evaluations)
        row = Springs(self.profile, self.modulus, task.resolution, edges=self.edges)
        hit = strike(row, mass, task.loads.values)
        curves = {
            "velocity": hit.velocity,
            "penetration": hit.penetration,
            "force": hit.force,
            "restitution": hit.restitution,
            "contact_duration": hit.duration,
        }
        return Solution.of(task, curves, unknowns=unknowns)


class ClosedFormImpact(FormSolver):
    """The static closed form: integrated over the impact to round-off, or in time."""

    name = "closed_form"
    physics = PHYSICS
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.dynamics = needed(scene.dynamics, NO_TABLE)

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        if task.loads.times is None:
            return super().solve(task)
        times, form, mass = task.loads.times, self.form, self.dynamics.mass
        x, later, speed = np.zeros(times.size), times > 0, self.dynamics.velocity.values[0]
        x[later] = course(form, mass, speed, times[later], history_of(task.loads, times))[0]
        inside = np.maximum(x, 0.0)
        curves = {"penetration": x, "contact_area": np.asarray(form.contact_area(inside))}
        return Solution.of(task, curves | _force(task, form.force(inside)), violation=0.0)

    def steps(self, task: Task[IndenterGeometry], loads: np.ndarray) -> Iterator[Step]:
        for velocity in loads:
            hit = collide(self.form, self.dynamics.mass, float(velocity))
            yield Step(struck(velocity, hit, hit.penetration, hit.force), violation=0.0)


class FftImpact(CurveImpact):
    """Along the load curve of the half-space on a grid."""

    name = "bem_fft"
    static = BemFft
    shared_cells = BemFft.shared_cells


class DenseImpact(CurveImpact):
    """Along the load curve of the dense half-space solver."""

    name = "bem_dense"
    static = BemDense


class FemImpact(CurveImpact):
    """Along the load curve of the finite-element body."""

    name = "fem"
    static = Fem
    span = Fem.span
    ladder_span = Fem.span  # each load scales the mesh onto its own contact


# Steps in the duration of an elastic impact for each spring per contact radius.
STEPS = 10


class ReducedViscoelasticImpact(ProfileSolver):
    """A mass on springs with memory, step by step."""

    name = "reduced"
    physics = VISCOELASTIC
    beside = "each with memory; the mass in implicit steps"
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.edges = scene.methods.reduced.edges
        self.mass = _striking(scene).mass
        self.material = springs_of(body_of(scene))

    def steps(self, task: Task[IndenterGeometry], loads: np.ndarray) -> Iterator[Step]:
        ratio, springs = self.scene.poisson_ratio, task.resolution
        row = RelaxingSprings(self.profile, self.material, ratio, springs, edges=self.edges)
        for velocity in loads:
            hit = strike_viscoelastic(row, self.mass, float(velocity), steps=STEPS * springs)
            deepest, strongest = float(hit.penetration.max()), float(hit.force.max())
            yield Step(struck(velocity, hit, deepest, strongest), unknowns=2 * springs)


class ClosedFormViscoelasticImpact(FormSolver):
    """The hereditary integrals as states of an initial value problem."""

    name = "closed_form"
    physics = VISCOELASTIC
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.mass = _striking(scene).mass
        self.form = circular(self.form)
        self.material = material_of(body_of(scene))
        self.note = f"{SOURCES}; {self.note}"

    def steps(self, task: Task[IndenterGeometry], loads: np.ndarray) -> Iterator[Step]:
        for velocity in loads:
            hit = reference.impact(
                *(self.form, self.modulus, self.material, self.mass, float(velocity)),
                poisson_ratio=self.scene.poisson_ratio,
            )
            yield Step(struck(velocity, hit, hit.penetration, hit.force), violation=hit.error)
