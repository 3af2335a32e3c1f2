"""Steady sliding on rubber: springs and lines of Problem 1, and the half-space in 3-D.

Every speed is an independent problem under the last normal load. Grids are fitted to the contact at
each speed, because fast rubber is stiff and its contact small.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.friction.path import normal_load
from comparisons.methods.normal.bem_fft import BemFft
from comparisons.methods.normal.grid import Grid, make_grid
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.normal.reduced_lines import ReducedLines
from comparisons.methods.solver import Refused
from comparisons.methods.viscoelastic.indentation import body_of, material_of, springs_of
from comparisons.scene.physics.tables.viscoelastic import Viscoelastic
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution, Stopwatch
from comparisons.tasks.steps import Row, Step, solve_rows
from comparisons.tasks.task import Task
from reduced.loads import LoadPath
from reduced.memory.materials import Prony
from reduced.rough.lines import RoughLines
from reduced.rubber.steady import SteadySliding, slide
from reference import loads as reference_loads
from reference.halfspace import areas
from reference.sliding.rubber import LIMIT, SlidingContact, slide_on_rubber
from reference.sliding.studies import slide_shape, window_depth
from reference.sliding.travelling import Travelling
from reference.viscoelastic.materials import GeneralisedMaxwell

PHYSICS = frozenset({"viscoelastic", "sliding"})
# A line reaches this many radii of the geometric overlap to each side, and its springs lie off the
# axis by this share of their spacing.
_MARGIN, _OFFSET = 1.1, 0.382
# Lines that are tried to fit the contact at a speed, each with the radius found on the last.
_FITS = 8


def _sliding(scene: Scene) -> Viscoelastic:
    """Return the body of a scene that slides steadily.

    Raises
    ------
    Refused
        If nothing is steady, or has no bound.
    """
    body = body_of(scene)
    if not body.long_term_modulus > 0:
        raise Refused("on a fluid the penetration never becomes steady")
    if scene.indenter is not None and scene.indenter.flat:
        raise Refused("a sliding flat face has unbounded pressures at its leading edge")
    return body


def _relative_stiffness(scene: Scene) -> float:
    """E*/(4 G): one for rubber, whose Poisson ratio is 1/2."""
    return 0.5 / (1 - scene.poisson_ratio)


def _springs(scene: Scene) -> Prony:
    return springs_of(_sliding(scene)).scaled(_relative_stiffness(scene))


def _compile(material: Prony, speeds: np.ndarray) -> None:
    line = -(np.linspace(-1.0, 1.0, 17) ** 2)
    slide(RoughLines(line, 0.125), material, speeds[:1], LoadPath("force", 1e-9))


STEADY = "steady sliding on springs with memory (19.31)"


class ReducedSliding(ReducedProfile):
    """Problem 1 as corrected: the steady state of a profile at each speed."""

    physics = PHYSICS
    options_read = frozenset({"rule"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.material = _springs(scene)

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line and its springs."""
        return f"{super().model(geometry)}; {STEADY}"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs."""
        _compile(self.material, task.loads.values)

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Slide the profile at every speed."""
        return solve_rows(task, self.rows(task))

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Nothing is set up: each speed has a line of its own."""
        yield Row(partial(self._steps, task), unknowns=int(2 * _MARGIN * task.resolution))

    def _steps(self, task: Task[IndenterGeometry], speeds: np.ndarray) -> Iterator[Step]:
        for speed in speeds:
            state = self._settled(task, float(speed))
            values = {name: float(curve[0, 0]) for name, curve in _curves(state, 1.0).items()}
            yield Step(values | {"speed": float(speed)})

    def _settled(self, task: Task[IndenterGeometry], speed: float) -> SteadySliding:
        """Slide on a line fitted to the contact, whose radius a coarse line tells for a force."""
        control, load = normal_load(task)
        by_depth = control == "penetration"
        profile, radius = self.profile, task.geometry.contact_radius
        if by_depth:
            radius = float(profile.contact_radius(load))
        for _ in range(_FITS):
            spacing = radius / task.resolution
            count = int(np.ceil(_MARGIN * task.resolution)) + 1
            # springs off the axis: on it, symmetric sums would be better than they are
            x = (np.arange(-count, count + 1) + _OFFSET) * spacing
            line = -np.asarray(profile.height(np.abs(x)), dtype=float)
            # depths are counted from the axis, the line's from its highest spring
            top = float(line.max())
            fitted = RoughLines(line, spacing, periodic=False)
            pressed = LoadPath(control, load + top if by_depth else load)
            state = slide(fitted, self.material, speed, pressed)
            state = replace(state, penetration=state.penetration - top)
            wide = float(profile.contact_radius(state.penetration[0, 0]))
            if by_depth or wide > 0.9 * radius:
                break
            radius = wide
        return state


class ReducedSlidingLines(ReducedLines):
    """Problem 1 as corrected: the steady state of rough lines at every speed at once."""

    physics = PHYSICS
    options_read = ReducedLines.options_read - {"stress", "edges"}

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.material = _springs(scene)
        if scene.loading.control != "force":
            raise Refused("rough lines slide under prescribed force only")

    def model(self, geometry: RoughGeometry) -> str:
        """Name the line and its springs."""
        return f"{super().model(geometry)}; {STEADY}"

    def warm_up(self, task: Task[RoughGeometry]) -> None:
        """Compile the springs."""
        _compile(self.material, task.loads.values)

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        """Slide the lines at every speed."""
        with Stopwatch() as setup:
            lines = self.draw(task)
        force = LoadPath("force", lines.patches * normal_load(task)[1])
        state = slide(lines.rough, self.material, task.loads.values, force)
        curves = _curves(state, lines.patches)
        return Solution.of(task, curves, unknowns=lines.points, setup_seconds=setup.seconds)


def _curves(state: SteadySliding, patches: float) -> dict[str, np.ndarray]:
    """Quantities of lines that each stand for a number of patches, per patch."""
    return {
        "friction_coefficient": state.friction_coefficient,
        "tangential_force": state.tangential_force / patches,
        "force": state.force / patches,
        "penetration": state.penetration,
        "contact_area": state.contact_area / patches,
        "contact_length": state.contact_length / patches,
        "contact_count": state.contact_count / patches,
    }


class GridSliding(BemFft):
    """The half-space under travelling pressure, its unsymmetric contact solved directly."""

    physics = PHYSICS
    options_read = frozenset()

    @property
    def face(self) -> None:
        """None: every speed has a grid of its own, with no edge cells."""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        body, factor = material_of(_sliding(scene)), _relative_stiffness(scene)
        self.material = GeneralisedMaxwell(
            factor * body.equilibrium_modulus,
            (factor * body.arm_moduli).tolist(),
            body.arm_times.tolist(),
            factor * body.viscosity,
        )

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Cells per half-width of the overlap; points per side of a rough surface."""
        if isinstance(geometry, RoughGeometry):
            return tuple(f * geometry.points[0] for f in (1, 2, 4) if f * geometry.points[0] <= 256)
        tolerance = self.scene.compare.tolerance
        finest = 16 * int(np.clip(np.ceil(4 * np.sqrt(0.01 / tolerance)), 2, 6))
        return finest // 4, finest // 2, finest

    def refusal(self, task: Task) -> str:
        """Refuse contacts too large to factorise."""
        geometry = task.geometry
        if not isinstance(geometry, RoughGeometry):
            return ""
        control, load = normal_load(task)
        cells = task.resolution**2 * geometry.points[1] / geometry.points[0]
        share = 1.0
        if control == "force":
            nominal = self.scene.effective_modulus * geometry.area * geometry.rms_slope
            share = min(1.0, 2.5 * load / nominal)
        if cells * share <= LIMIT:
            return ""
        return f"about {cells * share:.0f} cells in contact, of which {LIMIT} can be factorised"

    def memory(self, task: Task) -> float:
        """Bytes of the largest factor, and of the transforms of one grid."""
        cells = 16 * task.resolution**2
        contact = LIMIT if isinstance(task.geometry, RoughGeometry) else 2 * task.resolution**2
        return 16.0 * min(contact, LIMIT) ** 2 + 400.0 * cells

    def model(self, geometry: Geometry) -> str:
        """Name the domain, and the kernel."""
        return f"{super().model(geometry)}; of pressure that travels over a creeping body"

    def warm_up(self, task: Task) -> None:
        """Compile the contact."""
        speed = float(task.loads.values[0])
        x = np.linspace(-1.0, 1.0, 8)
        operator = Travelling((8, 8), (0.25, 0.25), self.material, speed)
        slide_on_rubber(operator, x[:, None] ** 2 + x**2, reference_loads.Load("penetration", 0.3))

    def rows(self, task: Task) -> Iterator[Row]:
        """Yield each realisation; an indenter's grids are made for each speed."""
        for realisation in task.realisations:
            if isinstance(task.geometry, IndenterGeometry):
                yield Row(partial(self._shape_steps, task, task.geometry))
            else:
                grid = make_grid(task.geometry, task.resolution, realisation)
                yield Row(_SurfaceSweep(self.material, grid, task))

    def _shape_steps(
        self, task: Task, geometry: IndenterGeometry, speeds: np.ndarray
    ) -> Iterator[Step]:
        control, load = normal_load(task)
        gap, reach = geometry.indenter.gap, geometry.indenter.reach
        for speed in speeds:
            depth = window_depth(
                gap, reach, self.material, float(speed), reference_loads.Load(control, load)
            )
            window = reach(depth), self.material, float(speed), 2 * task.resolution
            yield _step(
                slide_shape(gap, *window, reference_loads.Load(control, load)), float(speed)
            )


class _SurfaceSweep:
    """Speeds one after the other; a surface's contact starts from the one at the speed before."""

    def __init__(self, material: GeneralisedMaxwell, grid: Grid, task: Task) -> None:
        self._material, self._grid, self._task = material, grid, task
        self._mask: np.ndarray | None = None

    def __call__(self, speeds: np.ndarray) -> Iterator[Step]:
        control, load = normal_load(self._task)
        grid, periodic = self._grid, self._task.geometry.periodic
        for speed in speeds:
            where = grid.gap.shape, grid.spacing, self._material, float(speed)
            operator = Travelling(*where, periodic=periodic)
            state = slide_on_rubber(
                operator, grid.gap, reference_loads.Load(control, load), start=self._mask
            )
            self._mask = state.mask
            yield _step(state, float(speed))


def _step(state: SlidingContact, speed: float) -> Step:
    return Step(
        _quantities(state) | {"speed": speed},
        iterations=state.rounds,
        violation=state.violation,
        unknowns=int(state.mask.sum()),
    )


def _quantities(state: SlidingContact) -> dict[str, float]:
    spacing = state.operator.spacing
    area = float(areas.corrected_area(state.mask, spacing, periodic=state.operator.periodic))
    return {
        "friction_coefficient": state.friction_coefficient,
        "tangential_force": state.tangential_force,
        "force": state.force,
        "penetration": state.penetration,
        "contact_area": area,
        "contact_area_raw": float(areas.raw_area(state.mask, spacing)),
    }
