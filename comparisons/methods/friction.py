"""Tangential contact with Coulomb friction, along a path of loads.

Springs with stick and slip, the closed form of a flat circle, the half-space on a grid, and finite
elements as an independent check of the coupled problem.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from itertools import compress, pairwise
from typing import ClassVar

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods import Refused, Row, Scene, Solution, Solver, Step, Task, needed
from comparisons.methods.fem.indenter import LARGEST_POISSON, FemSolver
from comparisons.methods.normal.bem import HalfSpaceGrid
from comparisons.methods.normal.closed_form import FormSolver
from comparisons.methods.normal.grid import SMALL_BALL, Grid, cells, counted_quantities, make_grid
from comparisons.methods.normal.reduced import LineSolver, ProfileSolver, line_picture
from reduced.friction.slide import Friction, slide, slide_lines
from reduced.loads import Load, LoadPath
from reduced.rough.press import press
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference import loads as reference_loads
from reference.closed_form import PartialSlip
from reference.errors import NoEquilibriumError
from reference.fem import Material
from reference.fem.nodal_friction import follow, frictional_body
from reference.halfspace import areas
from reference.halfspace.friction import FrictionalPress, sweep, tangential_stiffness
from reference.halfspace.traction import Compliance, NormalAndTangential

# The contact is pressed in this many geometric steps from a share of its load, for the slip that
# pressing itself causes; per unit of resolution, at least.
PRESSING, LEAST_PRESSES, FIRST_SHARE = 0.5, 6, 0.02
# A stretch of the path is cut into one more step for each so many cells per contact radius.
CELLS_PER_PART = 16

Paths = tuple[reference_loads.LoadPath, reference_loads.LoadPath]


def normal_load(task: Task) -> tuple[str, float]:
    """Return the control and the normal load that is held."""
    normal = needed(task.loads.normal, "no normal load is held")
    return normal.control, float(normal.values[-1])


def held_steps(task: Task, friction: float, force: float) -> int:
    """Return how many steps of the path come before the contact slides as a whole."""
    if task.loads.control != "tangential_force":
        return len(task.loads.values)
    sliding = reference_loads.slides(task.loads.values, friction * force)
    return int(np.argmax(sliding)) if sliding.any() else len(sliding)


def finer_path(task: Task, per_radius: int, coupled: bool) -> tuple[Paths, np.ndarray]:
    """Cut a path into steps for a grid of so many cells, or spacings of nodes, per contact radius.

    Returns normal and tangential loads of all steps, and which of them the scene asked for.
    Steps grow finer with the grid, as the answer is of first order in both: then the bar that
    three resolutions give covers either. Without coupling pressing causes no slip: one step.
    """
    control, load = normal_load(task)
    presses = max(LEAST_PRESSES, round(PRESSING * per_radius)) if coupled else 1
    parts = 1 + per_radius // CELLS_PER_PART
    knots = np.concatenate([[0.0], task.loads.values])
    ways = [a + (b - a) * np.arange(1, parts + 1) / parts for a, b in pairwise(knots)]
    path = np.concatenate([np.zeros(presses), *ways])
    pressing = np.geomspace(FIRST_SHARE, 1.0, presses) if coupled else np.ones(1)
    normal = load * np.concatenate([pressing, np.ones(path.size - presses)])
    loads = (
        reference_loads.LoadPath(control, normal),
        reference_loads.LoadPath(task.loads.control, path),
    )
    asked = np.zeros(path.size, dtype=bool)
    asked[presses + parts - 1 :: parts] = True
    return loads, asked


PHYSICS = frozenset({"friction"})
NO_TABLE = "no [friction]"
SLIDES = "the tangential force reaches the friction limit: full sliding"
SPRINGS = "tangential springs of 4G/(2 - nu) dx that stick and slip one by one"
# Rough grids of more points a side take minutes a surface along a path: where pressing and shearing
# act on each other, and where they do not.
LARGEST_COUPLED, LARGEST_ROUGH = 160, 200


class ReducedFriction(ProfileSolver):
    """Springs 4G/(2 - nu) dx that slip at mu times their normal force (19.18), (19.19)."""

    name = "reduced"
    physics = PHYSICS
    beside = SPRINGS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.edges = scene.methods.reduced.edges
        self.friction = needed(scene.friction, NO_TABLE).coefficient

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Follow the path as far as the contact holds."""
        line = Springs(self.profile, self.modulus, task.resolution, edges=self.edges)
        stays = Load(*normal_load(task))
        normal = indent(line, stays)
        steps_held = held_steps(task, self.friction, float(normal.force[0]))
        loads = task.loads.values[: max(steps_held, 1)] * (steps_held > 0)
        friction = Friction(self.scene.tangential_modulus, self.friction)
        path = slide(line, friction, stays, LoadPath(task.loads.control, loads))
        contact, stick = float(normal.contact_radius[0]), path.stick_length / 2
        curves = {
            "tangential_force": path.tangential_force,
            "tangential_displacement": path.tangential_displacement,
            "friction_coefficient": path.tangential_force / path.force,
            "stick_area": np.pi * stick**2,
        }
        steady = {
            "penetration": float(normal.penetration[0]),
            "force": float(normal.force[0]),
            "equivalent_radius": contact,
            "contact_length": 2 * contact,
            "stiffness": float(normal.stiffness[0]),
            "tangential_stiffness": self.scene.tangential_modulus * 2 * contact,
        }
        solution = Solution.empty(task, unknowns=int(normal.springs))
        for step in range(steps_held):
            along = {name: float(values[step]) for name, values in curves.items()}
            solution.put((0, step), steady | along)
        for step in range(steps_held, task.shape[1]):
            solution.fail((0, step), SLIDES, no_equilibrium=True)
        solution.fields = line_picture(self.profile, steady["penetration"], contact, normal.spacing)
        return solution


class ReducedFrictionLines(LineSolver):
    """The same springs along rough lines, each line by itself."""

    name = "reduced"
    physics = PHYSICS
    beside = f"; {SPRINGS}"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.edges = scene.methods.reduced.edges
        self.friction = needed(scene.friction, NO_TABLE).coefficient

    def rows(self, task: Task[RoughGeometry]) -> Iterator[Row]:
        """Draw all lines; each is led as far as it holds, and stands for `patches` patches."""
        lines = self.draw(task)

        def steps(row: int, loads: np.ndarray) -> Iterator[Step]:
            line, patches, edges = lines.rough[row], lines.patches, self.edges
            control, load = normal_load(task)
            normal = Load(control, load * (patches if control == "force" else 1.0))
            contact = press(line, self.modulus, normal, edges=edges)
            force = float(contact.force[0, 0])
            holding = held_steps(task, self.friction, force / patches)
            share = patches if task.loads.control == "tangential_force" else 1.0
            path = LoadPath(task.loads.control, loads[: max(holding, 1)] * (holding > 0) * share)
            friction = Friction(self.scene.tangential_modulus, self.friction)
            answer = slide_lines(line, self.modulus, friction, normal, path, edges=edges)
            length = float(contact.contact_length[0, 0])
            steady = {
                "penetration": float(contact.penetration[0, 0]),
                "force": force / patches,
                "contact_area": float(contact.contact_area[0, 0]) / patches,
                "stiffness": float(contact.stiffness[0, 0]) / patches,
                "tangential_stiffness": self.scene.tangential_modulus * length / patches,
            }
            pulled, moved = answer.tangential_force[0], answer.tangential_displacement[0]
            for step in range(holding):
                along = {
                    "tangential_force": float(pulled[step] / patches),
                    "tangential_displacement": float(moved[step]),
                    "friction_coefficient": float(pulled[step] / force),
                }
                yield Step(steady | along)
            if holding < len(loads):
                raise NoEquilibriumError(SLIDES)

        for row, line in enumerate(lines.rough.heights):
            yield Row(partial(steps, row), unknowns=line.size)


class ClosedFormFriction(FormSolver):
    """Cattaneo's superposition of pressures, where nothing is left out by it."""

    name = "closed_form"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        friction, nu = needed(scene.friction, NO_TABLE), scene.poisson_ratio
        if friction.coupling == "full" and nu != 0.5:
            raise Refused("no exact solution with elastic coupling (nu < 1/2)")
        self.friction, self.flat = friction.coefficient, self.indenter.shape == "cylinder"
        self.note = "Mindlin 1949: all of a flat circle sticks until all of it slips"
        if not self.flat:
            pulled = scene.loading.tangential == "tangential_force"
            if nu != 0 or self.form.contact_radius is None or not pulled:
                raise Refused(
                    "Cattaneo's superposition neglects slip transverse to the load, but for flat "
                    "circles, and for round bodies under forces at nu = 0 without coupling"
                )
            self.note = "Mindlin & Deresiewicz 1953, Jaeger 1998: at nu = 0 nothing slips across"

    def steps(self, task: Task[IndenterGeometry], loads: np.ndarray) -> Iterator[Step]:
        control, load = normal_load(task)
        depth = load if control == "penetration" else float(self.form.penetration(load))
        ratio = self.scene.tangential_modulus / self.modulus
        slip = PartialSlip(self.form, depth, self.friction, ratio)
        normal = float(self.form.stiffness(depth))
        stiffness, area = ratio * normal, float(self.form.contact_area(depth))
        at, force, stuck = 0.0, 0.0, area
        held = held_steps(task, self.friction, slip.force)
        if not self.flat:
            path = slip.along(loads[:held])
            moved_to, sticking = path.tangential_displacement, np.pi * path.stick_radius**2
        for step, value in enumerate(loads):
            if step == held:
                raise NoEquilibriumError(SLIDES)
            if not self.flat:
                at, force, stuck = float(moved_to[step]), float(value), float(sticking[step])
            elif task.loads.control == "tangential_force":
                at, force = at + (value - force) / stiffness, float(value)
            else:
                moved = force + stiffness * (value - at)
                at, force = float(value), float(np.clip(moved, -slip.limit, slip.limit))
            values = {
                "tangential_force": force,
                "tangential_displacement": at,
                "friction_coefficient": force / slip.force,
                "tangential_stiffness": stiffness,
                "stiffness": normal,
                "penetration": depth,
                "force": slip.force,
                "contact_area": area,
                "stick_area": stuck if abs(force) < slip.limit else 0.0,
            }
            yield Step(values, violation=0.0)


class FrictionalGrid(HalfSpaceGrid):
    """The half-space below a grid with Cerruti's kernel, whatever slips on it.

    What acts tangentially is named by `tractions`; tighter tolerances than `least_tolerance` are
    not asked of it.
    """

    tractions: ClassVar[str]
    least_tolerance: ClassVar[float]

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        friction = needed(scene.friction, NO_TABLE)
        self.friction = friction.coefficient
        options, self.tolerance = scene.methods.bem_fft, self.least_tolerance
        if options.changes.get("tolerance", 0.0) > self.tolerance:  # a tighter one is not read
            self.tolerance = options.tolerance
        self.coupled = friction.coupling == "full" and scene.poisson_ratio < 0.5
        both = "normal and tangential tractions coupled"
        coupling = both if self.coupled else "pressure uncoupled from them"
        self.beside = f"{self.tractions}; {coupling}"


class GridFriction(FrictionalGrid):
    """The half-space with Cerruti's kernels; normal and tangential tractions coupled."""

    name = "bem_fft"
    physics = PHYSICS
    tractions = "tangential tractions with Cerruti's kernel, slip in any direction"
    least_tolerance = 1e-6

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Half the cells of a frictionless contact; rough, the grids that a path affords."""
        if isinstance(geometry, RoughGeometry):
            planned = super().resolutions(geometry)
            most = LARGEST_COUPLED if self.coupled else LARGEST_ROUGH
            return tuple(n for n in planned if n <= most) or planned[:1]
        return self.series(32, 16, 64)

    def refusal(self, task: Task) -> str:
        geometry = task.geometry
        if isinstance(geometry, RoughGeometry) and cells(geometry, task.resolution) > 512**2:
            return "a path on more than 512 x 512 cells takes hours"
        return super().refusal(task)

    def warm_up(self, task: Task) -> None:
        body = NormalAndTangential(SMALL_BALL.shape, (1.0, 1.0), Compliance.of(1.0, 0.3))
        for _ in sweep(
            FrictionalPress(body, SMALL_BALL, 0.5),
            reference_loads.LoadPath("penetration", 1.0),
            reference_loads.LoadPath("tangential_displacement", [0.1]),
        ):
            pass

    def rows(self, task: Task) -> Iterator[Row]:
        compliance = Compliance.of(self.scene.shear_modulus, self.scene.poisson_ratio)
        body = None
        for realisation in task.realisations:
            grid = make_grid(task.geometry, task.resolution, realisation)
            where = grid.gap.shape, grid.spacing
            body = body or NormalAndTangential(*where, compliance, periodic=task.geometry.periodic)
            unknowns = 3 * int(np.isfinite(grid.gap).sum())
            yield Row(partial(self._path, task, body, grid), unknowns=unknowns)

    def _path(
        self, task: Task, body: NormalAndTangential, grid: Grid, loads: np.ndarray
    ) -> Iterator[Step]:
        """Yield the steps of the scene's path, finer ones and those of pressing left out."""
        rough = isinstance(task.geometry, RoughGeometry)
        # The resolution of a round contact; of a rough one that of its sixteenth.
        per_radius = task.resolution // 16 if rough else task.resolution
        paths, asked = finer_path(task, per_radius, self.coupled)
        press = FrictionalPress(body, grid.gap, self.friction, self.coupled)
        for step in compress(sweep(press, *paths, tolerance=self.tolerance), asked):
            violation = max(step.violation, step.error)
            mask, stick = step.pressure > 0, step.sticking
            values = counted_quantities(step, grid.spacing, periodic=body.periodic) | {
                "tangential_force": step.tangential_force,
                "tangential_displacement": step.tangential_displacement,
                "friction_coefficient": step.tangential_force / step.force,
                "stick_area": float(areas.corrected_area(stick, grid.spacing, body.periodic)),
            }
            both = "stiffness_ratio" in task.quantities
            if both or "tangential_stiffness" in task.quantities:
                values["tangential_stiffness"] = tangential_stiffness(body, mask)[0]
            if both or "stiffness" in task.quantities:
                values["stiffness"] = float(areas.contact_stiffness(body.normal, mask))
            yield Step(values, iterations=step.iterations, violation=violation)


# The nodes that may touch reach this far, in contact radii: within it the shape must have a gap.
_REACH = 1.25
# Steps of the path are as fine as on a grid of so many cells per element: they are cheap here, and
# must grow finer with the mesh, so that the bar of three meshes covers them.
_CELLS_PER_ELEMENT = 8


class FemFriction(Solver[IndenterGeometry]):
    """Half of a half-space of 27-node elements, forces node after node (Jourdan et al. 1998)."""

    name = "fem"
    physics = PHYSICS
    span = FemSolver.span
    levels = (2, 4, 6)  # elements per contact radius; the mesh takes even numbers

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        reason = "finite elements with friction are for round smooth contacts only"
        self.indenter = needed(scene.indenter, reason)
        if not self.indenter.axisymmetric or self.indenter.flat:
            raise Refused(reason)
        nu = scene.poisson_ratio
        if nu > LARGEST_POISSON:
            raise Refused(f"finite elements with friction: nu up to {LARGEST_POISSON}, got {nu:g}")
        friction = needed(scene.friction, NO_TABLE)
        if friction.coupling != "full":
            raise Refused("the scene leaves out the coupling, which finite elements always include")
        self.friction = friction.coefficient

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        if task.resolution % 2 or task.resolution > 6:
            return "elements with friction take 2, 4 or 6 per contact radius"
        radius = np.array(_REACH * task.geometry.contact_radius)
        beyond = self.indenter.gap(radius, np.array(0.0))
        return "" if np.isfinite(beyond) else "the shape ends near the edge of the contact"

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the elimination: 23 000 unknowns of 6 elements per contact radius took 1 GB."""
        return 5e6 * task.resolution**3

    def model(self, geometry: IndenterGeometry) -> str:
        return (
            "half of a half-space of 27-node hexahedra around the contact; outside it the fields "
            "of Boussinesq and Cerruti; friction node after node, pressing and shearing coupled"
        )

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        body = frictional_body(1.0, Material(1.0, 0.3), elements=2)
        gap = (body.points**2).sum(axis=1) / 2
        shifted = reference_loads.LoadPath("tangential_displacement", 0.05)
        list(follow(body, gap, 0.3, reference_loads.LoadPath("penetration", 0.5), shifted))

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        nu, radius = self.scene.poisson_ratio, task.geometry.contact_radius
        modulus = self.scene.effective_modulus * (1 - nu**2)
        body = frictional_body(radius, Material(modulus, nu), elements=task.resolution)
        paths, asked = finer_path(task, _CELLS_PER_ELEMENT * task.resolution, coupled=True)

        def steps(_: np.ndarray) -> Iterator[Step]:
            """Yield the steps at the scene's own loads."""
            gap = self.indenter.gap(*body.points.T)
            for step in compress(follow(body, gap, self.friction, *paths), asked):
                # nodes in contact tell an area to a spacing only, so that none is given
                values = {
                    "tangential_force": step.tangential_force,
                    "tangential_displacement": step.tangential_displacement,
                    "friction_coefficient": step.tangential_force / step.force,
                    "penetration": step.penetration,
                    "force": step.force,
                }
                yield Step(values, iterations=step.sweeps, violation=step.error)

        yield Row(steps, unknowns=body.unknowns)
