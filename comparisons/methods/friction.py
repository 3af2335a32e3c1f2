"""Tangential contact with Coulomb friction: springs that stick and slip, against 3-D."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.base import Solution, Support, Task
from comparisons.methods.bem_fft import BemFft
from comparisons.methods.closed_form import ClosedForm, form_of
from comparisons.methods.friction_path import finer_path, normal_load
from comparisons.methods.grid import Grid, cells, make_grid
from comparisons.methods.reduced import Reduced, draw_lines, line_picture, profile_of
from comparisons.scene.options import FftOptions, ReducedOptions
from comparisons.scene.scene import Scene
from reduced.errors import ConvergenceError as ReducedError
from reduced.friction.slide import TangentialPath, slide, slide_lines
from reduced.rough.press import press
from reduced.springs.indent import Indentation, indent
from reference.closed_form import PartialSlip
from reference.errors import ConvergenceError
from reference.halfspace import areas
from reference.halfspace.cerruti import Compliance
from reference.halfspace.friction import FrictionStep, sweep, tangential_stiffness
from reference.halfspace.traction import NormalAndTangential

PHYSICS = frozenset({"friction"})
SLIDES = "the tangential force is not below friction times the normal force: it slides as a whole"
# Rough grids of more points a side take minutes a surface along a path: where pressing and shearing
# act on each other, and where they do not.
LARGEST_COUPLED, LARGEST_ROUGH = 160, 200


def _friction(scene: Scene) -> float:
    assert scene.friction is not None
    return scene.friction.coefficient


def _steps_below(task: Task, force: float) -> int:
    """Return how many steps of the path come before the contact slides as a whole."""
    if task.loads.control != "tangential_force":
        return len(task.loads.values)
    above = np.abs(task.loads.values) > _friction(task.scene) * force
    return int(np.argmax(above)) if above.any() else len(above)


class ReducedTangential(Reduced):
    """Springs 4G/(2 - nu) dx that slip at mu times their normal force (19.18), (19.19)."""

    physics = PHYSICS

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the line, and the tangential springs."""
        springs = "tangential springs of 4G/(2 - nu) dx that stick and slip one by one"
        return f"{super().model(scene, geometry)}; {springs}"

    def warm_up(self, task: Task) -> None:
        """Compile the springs of a profile, or the walk along a line."""
        if isinstance(task.geometry, RoughGeometry):
            line = np.cos(np.arange(16.0))
            press(line, 1.0, 1.0, penetration=[0.5])
            press(line, 1.0, 1.0, force=[0.5])
        else:
            _slide_profile(task, springs=4)

    def solve(self, task: Task) -> Solution:
        """Follow the path on one profile, or on each of a set of lines."""
        solution = Solution.empty(task)
        solve = _slide_lines if isinstance(task.geometry, RoughGeometry) else _solve_profile
        try:
            solve(task, solution)
        except ReducedError as error:
            for row, step in np.argwhere(~solution.converged):
                solution.fail((int(row), int(step)), error.reason)
        return solution


def _slide_profile(task: Task, springs: int) -> tuple[Indentation, TangentialPath, int]:
    """Return the normal contact, the path as far as it holds, and the number of its steps."""
    control, load = normal_load(task)
    options, scene = task.options, task.scene
    assert isinstance(options, ReducedOptions)
    profile, modulus = profile_of(scene), scene.effective_modulus
    line: dict[str, Any] = {control: [load], "springs": springs, "edges": options.edges}
    normal = indent(profile, modulus, **line)
    held = _steps_below(task, float(normal.force[0]))
    path: dict[str, Any] = {task.loads.control: task.loads.values[: max(held, 1)] * (held > 0)}
    answer = slide(
        *(profile, modulus, scene.tangential_modulus, _friction(scene)),
        **path,
        **line | {control: load},
    )
    return normal, answer, held


def _solve_profile(task: Task, solution: Solution) -> None:
    """Fill a solution from one profile."""
    normal, answer, held = _slide_profile(task, task.resolution)
    radius = answer.stick_length / 2
    values = {
        "tangential_force": answer.tangential_force,
        "tangential_displacement": answer.tangential_displacement,
        "friction_coefficient": answer.tangential_force / answer.force,
        "stick_area": np.pi * radius**2,
    }
    contact = float(normal.contact_radius[0])
    held_fixed = {
        "penetration": answer.penetration,
        "force": answer.force,
        "contact_area": np.pi * contact**2,
        "contact_area_raw": np.pi * contact**2,
        "equivalent_radius": contact,
        "contact_length": 2 * contact,
        "stiffness": float(normal.stiffness[0]),
        "tangential_stiffness": task.scene.tangential_modulus * 2 * contact,
    }
    _fill(solution, 0, values, held_fixed, held)
    solution.unknowns = int(normal.springs)
    profile = profile_of(task.scene)
    solution.fields = line_picture(profile, answer.penetration, contact, normal.spacing)


def _fill(
    solution: Solution,
    row: int,
    values: dict[str, np.ndarray],
    held_fixed: dict[str, float],
    held: int,
) -> None:
    """Store the steps of a path up to where the contact slides as a whole."""
    for step in range(solution.converged.shape[1]):
        if step >= held:
            solution.fail((row, step), SLIDES)
            continue
        along = {name: float(array[step]) for name, array in values.items()}
        solution.put((row, step), held_fixed | along)


def _slide_lines(task: Task, solution: Solution) -> None:
    """Fill a solution from lines; each stands for `patches` patches, see `Reduced`."""
    options, scene = task.options, task.scene
    assert isinstance(options, ReducedOptions)
    assert isinstance(task.geometry, RoughGeometry)
    with solution.setup():
        lines, spacing, patches = draw_lines(task, task.geometry)
    control, load = normal_load(task)
    normal: dict[str, Any] = {control: load * (patches if control == "force" else 1.0)}
    for row, line in enumerate(lines):
        contact = press(
            line,
            spacing,
            scene.effective_modulus,
            **{control: [normal[control]]},
            edges=options.edges,
        )
        force = float(contact.force[0, 0])
        held = _steps_below(task, force / patches)
        shares = patches if task.loads.control == "tangential_force" else 1.0
        path: dict[str, Any] = {
            task.loads.control: task.loads.values[: max(held, 1)] * (held > 0) * shares
        }
        answer = slide_lines(
            *(line, spacing, scene.effective_modulus, scene.tangential_modulus, _friction(scene)),
            **normal,
            **path,
            edges=options.edges,
        )
        values = {
            "tangential_force": answer.tangential_force[0] / patches,
            "tangential_displacement": answer.tangential_displacement[0],
            "friction_coefficient": answer.tangential_force[0] / force,
        }
        area = float(contact.contact_area[0, 0]) / patches
        held_fixed = {
            "penetration": float(contact.penetration[0, 0]),
            "force": force / patches,
            "contact_area": area,
            "contact_area_raw": area,
            "equivalent_radius": float(np.sqrt(area / np.pi)),
            "stiffness": float(contact.stiffness[0, 0]) / patches,
            "tangential_stiffness": scene.tangential_modulus
            * float(contact.contact_length[0, 0])
            / patches,
        }
        _fill(solution, row, values, held_fixed, held)
    solution.unknowns = lines.shape[1]


class ClosedFormTangential(ClosedForm):
    """Jaeger's and Ciavarella's superposition, where nothing is left out by it."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Take a flat circular punch at nu = 1/2: nothing else has an exact solution."""
        support = super().supports(scene)
        if not support.ok:
            return support
        assert scene.indenter is not None
        if scene.poisson_ratio != 0.5:
            return Support(False, "no exact solution where pressing drags the surface (nu < 1/2)")
        if scene.indenter.model_dump()["shape"] != "cylinder":
            return Support(False, "Cattaneo's superposition leaves out slip across the load")
        return Support(True, "Mindlin 1949: all of a flat circle sticks until all of it slips")

    def solve(self, task: Task) -> Solution:
        """Follow the path."""
        scene, solution = task.scene, Solution.empty(task)
        assert scene.indenter is not None
        form = form_of(scene.indenter, scene.effective_modulus)
        assert form is not None
        control, load = normal_load(task)
        depth = load if control == "penetration" else float(form.penetration(load))
        ratio = scene.tangential_modulus / scene.effective_modulus
        slip = PartialSlip(form, depth, _friction(scene), ratio)
        stiffness = ratio * float(form.stiffness(depth))
        at, force = 0.0, 0.0
        for step, value in enumerate(task.loads.values):
            if task.loads.control == "tangential_force":
                if abs(value) > slip.limit:
                    for late in range(step, len(task.loads.values)):
                        solution.fail((0, late), SLIDES)
                    break
                at, force = at + (value - force) / stiffness, float(value)
            else:
                moved = force + stiffness * (value - at)
                at, force = float(value), float(np.clip(moved, -slip.limit, slip.limit))
            area = float(form.contact_area(depth))
            sticks = abs(force) < slip.limit
            solution.put(
                (0, step),
                {
                    "tangential_force": force,
                    "tangential_displacement": at,
                    "friction_coefficient": force / slip.force,
                    "tangential_stiffness": stiffness,
                    "penetration": depth,
                    "force": slip.force,
                    "contact_area": area,
                    "contact_area_raw": area,
                    "stick_area": area if sticks else 0.0,
                },
            )
        solution.violation[:] = 0.0
        return solution


class BemFftTangential(BemFft):
    """The half-space with Cerruti's kernels; pressing and shearing act on each other."""

    physics = PHYSICS

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Half the cells of a frictionless contact; rough, the grids that a path affords."""
        if isinstance(geometry, RoughGeometry):
            planned = super().resolutions(scene, geometry)
            most = LARGEST_COUPLED if _coupled(scene) else LARGEST_ROUGH
            return tuple(n for n in planned if n <= most) or planned[:1]
        finest = int(np.clip(32 * np.sqrt(0.01 / scene.compare.tolerance), 16, 64))
        return finest // 4, finest // 2, finest

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the domain, and what acts on what."""
        text = "tangential tractions with Cerruti's kernel, slip in any direction"
        coupled = _coupled(scene)
        how = "pressing and shearing act on each other" if coupled else "pressure as without them"
        return f"{super().model(scene, geometry)}; {text}; {how}"

    def refused(self, task: Task) -> str:
        """Refuse rough grids that a path would take hours on."""
        geometry = task.geometry
        if isinstance(geometry, RoughGeometry) and cells(geometry, task.resolution) > 512**2:
            return "a path on more than 512 x 512 cells takes hours"
        return super().refused(task)

    def warm_up(self, task: Task) -> None:
        """Solve a small step of a paraboloid."""
        x = np.arange(8.0) - 3.5
        body = NormalAndTangential((8, 8), (1.0, 1.0), Compliance.of(1.0, 0.3))
        gap = (x[:, None] ** 2 + x**2) / 16
        for _ in sweep(body, gap, 0.5, penetration=1.0, tangential_displacement=[0.1]):
            pass

    def solve(self, task: Task) -> Solution:
        """Follow the path on every realisation."""
        solution = Solution.empty(task)
        body = None
        for row, realisation in enumerate(task.realisations):
            with solution.setup():
                grid = make_grid(task.geometry, task.resolution, realisation)
                body = body or _body(task, grid)
                solution.unknowns = 3 * int(np.isfinite(grid.gap).sum())
            try:
                for step, found in enumerate(_path(task, body, grid)):
                    solution.put((row, step), _quantities(task, body, found, grid))
                    solution.iterations[row, step] = found.iterations
                    solution.violation[row, step] = max(found.violation, found.slip_error)
            except ConvergenceError as error:
                for late in np.flatnonzero(~solution.converged[row]):
                    solution.fail((row, int(late)), error.reason)
        return solution


def _coupled(scene: Scene) -> bool:
    options = scene.methods.bem_fft
    assert isinstance(options, FftOptions)
    return options.coupling == "full" and scene.poisson_ratio < 0.5


def _body(task: Task, grid: Grid) -> NormalAndTangential:
    """Return the half-space under the grid."""
    scene = task.scene
    nu = scene.poisson_ratio
    periodic = isinstance(task.geometry, RoughGeometry) and task.geometry.periodic
    compliance = Compliance.of(scene.effective_modulus * (1 - nu) / 2, nu)
    return NormalAndTangential(grid.gap.shape, grid.spacing, compliance, periodic=periodic)


def _path(task: Task, body: NormalAndTangential, grid: Grid) -> Iterator[FrictionStep]:
    """Yield the steps of the scene's path, finer ones and those of pressing left out."""
    coupled = _coupled(task.scene)
    way = finer_path(task, _cells_per_radius(task), coupled)
    options = task.options
    assert isinstance(options, FftOptions)
    steps = sweep(
        *(body, grid.gap, _friction(task.scene)),
        **way.loads,
        coupled=coupled,
        tolerance=max(options.tolerance, 1e-6),
    )
    yield from way.asked(steps)


def _cells_per_radius(task: Task) -> int:
    """Return the resolution of a round contact; of a rough one that of its sixteenth."""
    rough = isinstance(task.geometry, RoughGeometry)
    return task.resolution // 16 if rough else task.resolution


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
        "equivalent_radius": float(np.sqrt(area / np.pi)),
    }
    if "tangential_stiffness" in task.quantities:
        values["tangential_stiffness"] = tangential_stiffness(body, mask)[0]
    if "stiffness" in task.quantities:
        values["stiffness"] = float(areas.contact_stiffness(body.normal, mask))
    return values


WIRINGS = (ReducedTangential(), ClosedFormTangential(), BemFftTangential())
