"""The method `ngsolve`: third-party finite elements for single contacts."""

from __future__ import annotations

from importlib import metadata, util

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.isolation import parent
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods.fem.indenter import FemSolver, contact_stretch
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.indenters.not_round import Ellipsoid
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
        return BYTES_PER_UNKNOWN * UNKNOWNS_PER_SQUARE * float(task.resolution) ** 2

    def model(self, geometry: IndenterGeometry) -> str:
        return (
            "NGSolve, a public code: a quarter ball of tetrahedra of fourth order fitted to the "
            "contact edge, penalty contact at integration points by an active set, outside it the "
            "Boussinesq field of the force"
        )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        geometry, solution = task.geometry, Solution.empty(task)
        # the scales of each load step, and its load in them; a step without any has failed
        steps, modulus = {}, task.scene.effective_modulus
        indenter, by_depth = geometry.indenter, task.loads.control == "penetration"
        for step, load in enumerate(task.loads.values):
            radius, depth = geometry.contact_radii[step], geometry.penetrations[step]
            if isinstance(indenter, Ellipsoid):
                # estimates are exact but for ellipsoids, which take Hertz's ellipse
                form = ellipsoid(indenter.radius_x, indenter.radius_y, modulus)
                depth = float(load if by_depth else form.penetration(load))
                radius = float(np.sqrt(np.prod(form.semi_axes(depth))))
            if not (radius > 0.0 and depth > 0.0):
                solution.fail((0, step), geometry.unreached.get(step, "no estimate of its contact"))
                continue
            unit = depth if by_depth else modulus * radius * depth
            steps[step] = {"radius": radius, "depth": depth, "load": float(load / unit)}
        if not steps:
            return solution
        shape = indenter.model_dump()
        problem = {
            "resolution": task.resolution,
            "poisson_ratio": task.scene.elastic_constants[1],
            "stretch": list(contact_stretch(indenter)),
            "shape": shape.pop("shape"),
            "parameters": shape,
            "control": task.loads.control,
            "steps": list(steps.values()),
        }
        outcome = parent.run(
            WORK, problem, seconds=self.seconds, memory=MEMORY_SHARE * free_memory()
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
            raw = area = radius**2 * answer["counted_area"]
            if indenter.face_area is not None:
                area = indenter.face_area
            elif indenter.axisymmetric:
                # Points counted along the edge of a round contact are noise where the pressure is
                # steep (a cone loses a quarter of them), its stiffness 2 E* a is not (Johnson 1985,
                # eq. 3.36; a percent here); the moments of the pressure are better still where they
                # apply.
                stiff = 0.5 * answer["stiffness"]
                best = moment_radius(answer["second"], answer["fourth"])
                relative = best if best is not None and abs(best / stiff - 1) < AGREES else stiff
                area = np.pi * (radius * relative) ** 2
            values = {
                "penetration": depth * answer["penetration"],
                "force": modulus * radius * depth * answer["force"],
                "contact_area": area,
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
