"""The method `ngsolve`: third-party finite elements for single contacts."""

from __future__ import annotations

from importlib import metadata, util

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.isolation import parent
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods.fem.indenter import FemSolver, contact_stretch
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.indenters.ellipsoid import Ellipsoid
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reference.closed_form import ellipsoid
from reference.fem.contact import moment_radius

SHAPES = (
    *("paraboloid", "sphere", "cone", "power_law", "rounded_punch", "ellipsoid"),
    *("cylinder", "elliptic_punch"),
)
WORK = "comparisons.peers.run_ngsolve:solve"
LARGEST_POISSON = 0.499
# Measured: 25 700 unknowns at two elements per radius, 37 900 at three; 20 kB of factor for each.
UNKNOWNS_PER_SQUARE, BYTES_PER_UNKNOWN = 6_500, 20_000
# How much a radius from the moments of the pressure may differ from that of the stiffness.
AGREES = 0.05


class NgSolve(Solver[IndenterGeometry]):
    """NGSolve and Netgen (Schöberl, J. Comput. Vis. Sci. 1 (1997) 41; ngsolve.org)."""

    name = "ngsolve"
    span = FemSolver.span  # each load scales the mesh onto its own contact

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        reason = "single contacts only: its mesh is fitted to one contact edge"
        self.indenter = needed(scene.indenter, reason)
        if self.indenter.shape not in SHAPES:
            raise Refused(f"no mesh is fitted to a {self.indenter.in_words}")
        nu = scene.elastic_constants[1]
        if nu > LARGEST_POISSON:
            raise Refused(f"nu = {nu:g}: displacement elements, up to {LARGEST_POISSON}")
        if util.find_spec("ngsolve") is None:  # last: installing helps only who can do the scene
            raise Refused("not installed: pip install 'roughline[peers]'", missing=True)
        self.seconds = scene.methods.ngsolve.seconds
        self.note = f"ngsolve {metadata.version('ngsolve')}, in its own process"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return elements per contact radius; one mesh: it checks, not leads."""
        return (3,) if self.scene.compare.tolerance < 0.003 else (2,)

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the factorisation."""
        return BYTES_PER_UNKNOWN * UNKNOWNS_PER_SQUARE * float(task.resolution) ** 2

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the mesh and the contact."""
        return (
            "NGSolve, a public code: a quarter ball of tetrahedra of fourth order fitted to the "
            "contact edge, penalty contact at integration points by an active set, outside it the "
            "Boussinesq field of the force"
        )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Solve all loads in one process of the peer."""
        geometry, solution = task.geometry, Solution.empty(task)
        # the scales of each load step, and its load in them; a step without any has failed
        steps, modulus = {}, task.scene.effective_modulus
        for step, load in enumerate(task.loads.values):
            radius, depth = _scales(task, geometry, step)
            if not (radius > 0.0 and depth > 0.0):
                solution.fail((0, step), geometry.unreached.get(step, "no estimate of its contact"))
                continue
            unit = depth if task.loads.control == "penetration" else modulus * radius * depth
            steps[step] = {"radius": radius, "depth": depth, "load": float(load / unit)}
        if not steps:
            return solution
        shape = geometry.indenter.model_dump()
        problem = {
            "resolution": task.resolution,
            "poisson_ratio": task.scene.elastic_constants[1],
            "stretch": list(contact_stretch(geometry.indenter)),
            "shape": shape.pop("shape"),
            "parameters": shape,
            "control": task.loads.control,
            "steps": list(steps.values()),
        }
        outcome = parent.run(
            WORK,
            problem,
            seconds=self.seconds,
            memory=MEMORY_SHARE * free_memory(),
        )
        if not outcome.ok:
            for step in steps:
                solution.fail((0, step), f"NGSolve: {outcome.reason}")
            return solution
        for (step, scales), answer in zip(steps.items(), outcome.answer["steps"], strict=True):
            solution.iterations[0, step] = answer["rounds"]
            if answer["reason"]:
                solution.fail((0, step), answer["reason"])
                continue
            radius, depth = scales["radius"], scales["depth"]
            raw = radius**2 * answer["counted_area"]
            values = {
                "penetration": depth * answer["penetration"],
                "force": modulus * radius * depth * answer["force"],
                "contact_area": _area(geometry, radius, raw, answer),
                "contact_area_raw": raw,
                "stiffness": modulus * radius * answer["stiffness"],
                "contact_length_stiffness": radius * answer["stiffness"],
            }
            solution.put((0, step), values)
        if solution.converged[0, -1]:
            solution.fields = {"penetration": solution.quantities["penetration"][0, -1]}
        for name in ("unknowns", "seconds", "setup_seconds", "memory"):
            setattr(solution, name, outcome.answer[name])
        return solution


def _scales(task: Task, geometry: IndenterGeometry, step: int) -> tuple[float, float]:
    """Return the contact radius and penetration that the mesh is fitted to.

    The estimates of the reduced model are exact but for ellipsoids: these take Hertz's ellipse.
    """
    indenter = geometry.indenter
    if not isinstance(indenter, Ellipsoid):
        return geometry.contact_radii[step], geometry.penetrations[step]
    form = ellipsoid(indenter.radius_x, indenter.radius_y, task.scene.effective_modulus)
    load = task.loads.values[step]
    depth = float(load if task.loads.control == "penetration" else form.penetration(load))
    return float(np.sqrt(np.prod(form.semi_axes(depth)))), depth


def _area(geometry: IndenterGeometry, radius: float, raw: float, answer: dict[str, float]) -> float:
    """Return the face of a punch, the disc of a round contact, or the counted area.

    Points counted along the edge of a round contact are noise where the pressure is steep (a cone
    loses a quarter of them), its stiffness 2 E* a is not (Johnson 1985, eq. 3.36; a percent here);
    the moments of the pressure are better still where they apply.
    """
    if geometry.indenter.face_area is not None:
        return geometry.indenter.face_area
    if not geometry.indenter.axisymmetric:
        return raw
    stiff = 0.5 * answer["stiffness"]
    best = moment_radius(answer["second"], answer["fourth"])
    relative = best if best is not None and abs(best / stiff - 1) < AGREES else stiff
    return np.pi * (radius * relative) ** 2
