"""Tangential contact with Coulomb friction: springs with stick and slip, closed form, 3-D grid."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.friction.path import finer_path, held_steps, normal_load
from comparisons.methods.normal.bem_fft import BemFft
from comparisons.methods.normal.closed_form import ClosedForm
from comparisons.methods.normal.grid import Grid, cells, make_grid
from comparisons.methods.normal.reduced import ReducedProfile, line_picture
from comparisons.methods.normal.reduced_lines import Lines, ReducedLines
from comparisons.methods.solver import Refused, needed
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import NoAnswerError, Row, Step, solve_rows
from comparisons.tasks.task import Task
from reduced.friction.slide import Friction, TangentialPath, slide, slide_lines
from reduced.loads import Load, LoadPath
from reduced.rough.lines import RoughLines
from reduced.rough.press import press
from reduced.springs.indent import Indentation, indent
from reduced.springs.line import Springs
from reference import loads as reference_loads
from reference.closed_form import PartialSlip
from reference.halfspace import areas
from reference.halfspace.cerruti import Compliance
from reference.halfspace.friction import FrictionalPress, FrictionStep, sweep, tangential_stiffness
from reference.halfspace.traction import NormalAndTangential

PHYSICS = frozenset({"friction"})
NO_TABLE = "no [friction]"
SLIDES = "the tangential force reaches the friction limit: full sliding"
SPRINGS = "tangential springs of 4G/(2 - nu) dx that stick and slip one by one"
# Rough grids of more points a side take minutes a surface along a path: where pressing and shearing
# act on each other, and where they do not.
LARGEST_COUPLED, LARGEST_ROUGH = 160, 200
# Tighter ones are not asked of a path on a grid.
LEAST_TOLERANCE = 1e-6


class ReducedFriction(ReducedProfile):
    """Springs 4G/(2 - nu) dx that slip at mu times their normal force (19.18), (19.19)."""

    physics = PHYSICS
    options_read = frozenset({"rule", "edges"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.friction = needed(scene.friction, NO_TABLE).coefficient

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line, and the tangential springs."""
        return f"{super().model(geometry)}; {SPRINGS}"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs of a profile."""
        self._slide(task, springs=4)

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Follow the path as far as the contact holds."""
        normal, path, steps_held = self._slide(task, task.resolution)
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
            solution.fail((0, step), SLIDES)
        solution.fields = line_picture(self.profile, steady["penetration"], contact, normal.spacing)
        return solution

    def _slide(
        self, task: Task[IndenterGeometry], springs: int
    ) -> tuple[Indentation, TangentialPath, int]:
        """Return the normal contact, the path as far as it holds, and the number of its steps."""
        control, load = normal_load(task)
        line = Springs(self.profile, self.modulus, springs, edges=self.options.edges)
        stays = Load(control, load)
        normal = indent(line, stays)
        holding = held_steps(task, self.friction, float(normal.force[0]))
        path = LoadPath(task.loads.control, task.loads.values[: max(holding, 1)] * (holding > 0))
        friction = Friction(self.scene.tangential_modulus, self.friction)
        return normal, slide(line, friction, stays, path), holding


class ReducedFrictionLines(ReducedLines):
    """The same springs along rough lines, each line by itself."""

    physics = PHYSICS
    options_read = ReducedLines.options_read - {"stress"}

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.friction = needed(scene.friction, NO_TABLE).coefficient

    def model(self, geometry: RoughGeometry) -> str:
        """Name the line, and the tangential springs."""
        return f"{super().model(geometry)}; {SPRINGS}"

    def warm_up(self, task: Task[RoughGeometry]) -> None:
        """Compile the walk along a line."""
        line = RoughLines(np.cos(np.arange(16.0)), 1.0)
        press(line, 1.0, Load("penetration", 0.5))
        press(line, 1.0, Load("force", 0.5))

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        """Follow the path on each line."""
        return solve_rows(task, self.rows(task))

    def rows(self, task: Task[RoughGeometry]) -> Iterator[Row]:
        """Draw all lines."""
        lines = self.draw(task)
        for row, line in enumerate(lines.rough.heights):
            yield Row(partial(self._steps, task, lines, row), unknowns=line.size)

    def _steps(
        self, task: Task[RoughGeometry], lines: Lines, row: int, loads: np.ndarray
    ) -> Iterator[Step]:
        """Yield the steps of one line as far as it holds; it stands for `patches` patches."""
        line, patches, edges = lines.rough[row], lines.patches, self.options.edges
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
            raise NoAnswerError(SLIDES)


class ClosedFormFriction(ClosedForm):
    """Jaeger's and Ciavarella's superposition, where nothing is left out by it."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if scene.poisson_ratio != 0.5:
            raise Refused("no exact solution with elastic coupling (nu < 1/2)")
        if self.indenter.shape != "cylinder":
            raise Refused("Cattaneo's superposition neglects slip transverse to the load")
        self.friction = needed(scene.friction, NO_TABLE).coefficient
        self.note = "Mindlin 1949: all of a flat circle sticks until all of it slips"

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Press the circle."""
        yield Row(partial(self._steps, task))

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Follow the path."""
        return solve_rows(task, self.rows(task))

    def _steps(self, task: Task[IndenterGeometry], loads: np.ndarray) -> Iterator[Step]:
        control, load = normal_load(task)
        depth = load if control == "penetration" else float(self.form.penetration(load))
        ratio = self.scene.tangential_modulus / self.modulus
        slip = PartialSlip(self.form, depth, self.friction, ratio)
        stiffness = ratio * float(self.form.stiffness(depth))
        area = float(self.form.contact_area(depth))
        at, force = 0.0, 0.0
        for value in loads:
            if task.loads.control == "tangential_force":
                if abs(value) > slip.limit:
                    raise NoAnswerError(SLIDES)
                at, force = at + (value - force) / stiffness, float(value)
            else:
                moved = force + stiffness * (value - at)
                at, force = float(value), float(np.clip(moved, -slip.limit, slip.limit))
            values = {
                "tangential_force": force,
                "tangential_displacement": at,
                "friction_coefficient": force / slip.force,
                "tangential_stiffness": stiffness,
                "penetration": depth,
                "force": slip.force,
                "contact_area": area,
                "stick_area": area if abs(force) < slip.limit else 0.0,
            }
            yield Step(values, violation=0.0)


class GridFriction(BemFft):
    """The half-space with Cerruti's kernels; normal and tangential tractions coupled."""

    physics = PHYSICS
    options_read = frozenset({"tolerance"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        friction = needed(scene.friction, NO_TABLE)
        self.friction = friction.coefficient
        if self.options.tolerance <= LEAST_TOLERANCE:
            self.options_read -= {"tolerance"}
        self.coupled = friction.coupling == "full" and scene.poisson_ratio < 0.5

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Half the cells of a frictionless contact; rough, the grids that a path affords."""
        if isinstance(geometry, RoughGeometry):
            planned = super().resolutions(geometry)
            most = LARGEST_COUPLED if self.coupled else LARGEST_ROUGH
            return tuple(n for n in planned if n <= most) or planned[:1]
        finest = int(np.clip(32 * np.sqrt(0.01 / self.scene.compare.tolerance), 16, 64))
        return finest // 4, finest // 2, finest

    def model(self, geometry: Geometry) -> str:
        """Name the domain, and what acts on what."""
        text = "tangential tractions with Cerruti's kernel, slip in any direction"
        both = "normal and tangential tractions coupled"
        coupling = both if self.coupled else "pressure uncoupled from them"
        return f"{super().model(geometry)}; {text}; {coupling}"

    def refusal(self, task: Task) -> str:
        """Refuse rough grids that a path would take hours on."""
        geometry = task.geometry
        if isinstance(geometry, RoughGeometry) and cells(geometry, task.resolution) > 512**2:
            return "a path on more than 512 x 512 cells takes hours"
        return super().refusal(task)

    def warm_up(self, task: Task) -> None:
        """Solve a small step of a paraboloid."""
        x = np.arange(8.0) - 3.5
        body = NormalAndTangential((8, 8), (1.0, 1.0), Compliance.of(1.0, 0.3))
        gap = (x[:, None] ** 2 + x**2) / 16
        for _ in sweep(
            FrictionalPress(body, gap, 0.5),
            reference_loads.LoadPath("penetration", 1.0),
            reference_loads.LoadPath("tangential_displacement", [0.1]),
        ):
            pass

    @property
    def face(self) -> None:
        """None: a flat face has no edge cells here."""

    def rows(self, task: Task) -> Iterator[Row]:
        """Yield the grid of each realisation, all on the same half-space."""
        body = None
        for realisation in task.realisations:
            grid = make_grid(task.geometry, task.resolution, realisation)
            body = body or self._body(task, grid)
            unknowns = 3 * int(np.isfinite(grid.gap).sum())
            yield Row(partial(self._path, task, body, grid), unknowns=unknowns)

    def _body(self, task: Task, grid: Grid) -> NormalAndTangential:
        """Return the half-space under the grid."""
        nu = self.scene.poisson_ratio
        periodic = isinstance(task.geometry, RoughGeometry) and task.geometry.periodic
        compliance = Compliance.of(self.scene.shear_modulus, nu)
        return NormalAndTangential(grid.gap.shape, grid.spacing, compliance, periodic=periodic)

    def _path(
        self, task: Task, body: NormalAndTangential, grid: Grid, loads: np.ndarray
    ) -> Iterator[Step]:
        """Yield the steps of the scene's path, finer ones and those of pressing left out."""
        rough = isinstance(task.geometry, RoughGeometry)
        # The resolution of a round contact; of a rough one that of its sixteenth.
        per_radius = task.resolution // 16 if rough else task.resolution
        way = finer_path(task, per_radius, self.coupled)
        tolerance = max(self.options.tolerance, LEAST_TOLERANCE)
        press = FrictionalPress(body, grid.gap, self.friction, self.coupled)
        for step in way.scene_steps(sweep(press, *way.loads, tolerance=tolerance)):
            violation = max(step.violation, step.error)
            values = _quantities(task, body, step, grid)
            yield Step(values, iterations=step.iterations, violation=violation)


def _quantities(
    task: Task, body: NormalAndTangential, step: FrictionStep, grid: Grid
) -> dict[str, float]:
    """Return the quantities of one step."""
    mask, periodic = step.pressure > 0, body.periodic
    raw = float(areas.raw_area(mask, grid.spacing))
    area = float(areas.corrected_area(mask, grid.spacing, periodic=periodic))
    stick = float(areas.corrected_area(step.sticking, grid.spacing, periodic=periodic))
    values = {
        "tangential_force": step.tangential_force,
        "tangential_displacement": step.tangential_displacement,
        "friction_coefficient": step.tangential_force / step.force,
        "stick_area": stick,
        "penetration": step.penetration,
        "force": step.force,
        "contact_area": area,
        "contact_area_raw": raw,
    }
    if "tangential_stiffness" in task.quantities:
        values["tangential_stiffness"] = tangential_stiffness(body, mask)[0]
    if "stiffness" in task.quantities:
        values["stiffness"] = float(areas.contact_stiffness(body.normal, mask))
    return values
