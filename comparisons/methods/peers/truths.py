"""Other people's solvers that check ours: on our grids, and finite elements on their own meshes.

The methods `tamaas`, `contactmechanics` and `ngsolve`.
"""

from __future__ import annotations

import statistics
from importlib import metadata, util

import numpy as np

from comparisons.facts.methods import METHODS
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.isolation import parent
from comparisons.isolation.parent import Limits
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods import Refused, Scene, Solution, Solver, Task, needed
from comparisons.methods.fem.indenter import FemSolver, contact_stretch
from comparisons.methods.normal.grid import cells, contact_step, make_grid
from comparisons.peers import client
from comparisons.scene.indenters.not_round import Ellipsoid
from comparisons.scene.options import PeerOptions
from comparisons.tasks.steps import record
from reference.closed_form import ellipsoid
from reference.fem.contact import moment_radius
from reference.halfspace import FreeOperator, PeriodicOperator

# Double arrays of one grid that a peer's process holds, twice padded, beside ours.
ARRAYS = 100


class PeerSolver(Solver[Geometry]):
    """The same prepared heights and loads as `bem_fft`, solved in the peer's own process.

    Times are taken there, around the solve; the violation is measured here, and the peer's
    tolerance changed until it is within the option `tolerance` (`comparisons.peers.client`).
    """

    def __init__(self, scene: Scene, options: PeerOptions) -> None:
        super().__init__(scene)
        if scene.indenter is not None and scene.indenter.flat:
            raise Refused("sharp edges inside cells are not supported")
        self.periodic = scene.surface is not None and scene.surface.periodic
        if scene.loading.control == "mean_gap" and not self.periodic:
            raise Refused("no mean-gap control on a free half-space: use bem_fft")
        if not client.installed(self.name):  # last: installing helps only who can do the scene
            raise Refused("not installed: pip install 'roughline[peers]'", missing=True)
        self.tolerance, self.seconds = options.tolerance, options.seconds
        self.note = f"{client.versions(self.name)}, in its own process"

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return the surface's own points; for indenters one grid: it checks, not leads."""
        return geometry.points[:1] if isinstance(geometry, RoughGeometry) else (32,)

    def memory(self, task: Task) -> float:
        pressures = len(task.realisations) * (len(task.loads.values) + 2)
        return 8.0 * (ARRAYS + 3 * pressures) * cells(task.geometry, task.resolution)

    def model(self, geometry: Geometry) -> str:
        return f"{METHODS[self.name].title}, a public code, on the same cells as bem_fft"

    def solve(self, task: Task) -> Solution:
        solution = Solution.empty(task)
        grids = [
            make_grid(task.geometry, task.resolution, realisation)
            for realisation in task.realisations
        ]
        solution.unknowns = int(np.isfinite(grids[0].gap).sum())
        kind = PeriodicOperator if self.periodic else FreeOperator
        operator = kind(grids[0].gap.shape, grids[0].spacing, self.scene.effective_modulus)
        gaps = np.array([grid.gap for grid in grids])
        result = client.press(
            self.name,
            client.Problem(operator, gaps, task.loads.control, task.loads.values),
            self.tolerance,
            limits=Limits(self.seconds, MEMORY_SHARE * free_memory()),
        )
        for index, reason in result.reasons.items():
            solution.fail(index, reason)
        for (row, step), contact in result.contacts.items():
            record(solution, (row, step), contact_step(task, operator, contact, grids[row]), task)
        if result.seconds:
            solution.seconds = statistics.median(result.seconds)
        solution.setup_seconds = result.setup_seconds
        solution.compile_seconds = result.compile_seconds
        solution.memory = result.memory
        return solution


class Tamaas(PeerSolver):
    """Tamaas (Frérot, Anciaux, Rey, Pham-Ba & Molinari, J. Open Source Softw. 5 (2020) 2121)."""

    name = "tamaas"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene, scene.methods.tamaas)

    def model(self, geometry: Geometry) -> str:
        searches = self.scene.loading.control == "penetration" and not self.periodic
        search = "; it controls the force, and the penetration is searched for"
        return super().model(geometry) + (search if searches else "")


class ContactMechanics(PeerSolver):
    """ContactMechanics (Pastewka and others, github.com/ContactEngineering)."""

    name = "contactmechanics"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene, scene.methods.contactmechanics)


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
