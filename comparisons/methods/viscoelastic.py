"""Relaxing bodies: pressed in time, and sliding steadily.

The times of a scene are output times. Methods with a time discretisation error subdivide the
intervals in proportion to their resolution, so that one refinement reduces both errors and the bar
covers both. In sliding every speed is an independent problem under the last normal load. Grids are
fitted to the contact at each speed, because fast rubber is stiff and its contact small.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import partial
from itertools import pairwise

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.friction import normal_load
from comparisons.methods.normal.bem import BemFft, HalfSpaceGrid
from comparisons.methods.normal.closed_form import FormSolver
from comparisons.methods.normal.grid import Grid, counted_quantities, make_grid
from comparisons.methods.normal.reduced import LineSolver, ProfileSolver, line_picture
from comparisons.methods.solver import G, Refused, Solver, needed
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.loading import AbsoluteLoads, loads_of
from comparisons.scene.physics.tables.viscoelastic import Viscoelastic
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import STEPS, Solution, Stopwatch
from comparisons.tasks.steps import Row, Step, steps_of
from comparisons.tasks.task import Task
from reduced.loads import LoadPath
from reduced.memory.in_time import graded_times, indent_in_time
from reduced.memory.materials import Prony, prony
from reduced.memory.row import RelaxingSprings
from reduced.rough.press import RoughLines
from reduced.rubber.steady import SteadySliding, slide
from reference import closed_form as closed_forms
from reference import loads as reference_loads
from reference import viscoelastic as reference
from reference.contact.body import ElasticBody
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rubber import (
    LIMIT,
    SlidingContact,
    slide_on_rubber,
    slide_shape,
    window_depth,
)
from reference.viscoelastic.travelling import Travelling

PHYSICS = frozenset({"viscoelastic"})
# Steps in time of a whole history for each spring or cell per contact radius.
STEPS_OF_SPRINGS = 4
STEPS_OF_CELLS = 2
# Cells per contact radius that a rough surface counts as in this: its own are points per side.
STEPS_OF_SURFACE = 32
SOURCES = "Lee & Radok 1960, Ting 1968"


def body_of(scene: Scene) -> Viscoelastic:
    """Return the viscoelastic body of a scene, or refuse it."""
    return needed(scene.viscoelastic, "no [viscoelastic]")


def springs_of(body: Viscoelastic) -> Prony:
    """Return the material for the springs."""
    moduli, times = [g for g, _ in body.branches], [tau for _, tau in body.branches]
    return prony(body.long_term_modulus, moduli, times, viscosity=body.dashpot_viscosity)


def material_of(body: Viscoelastic, factor: float = 1.0) -> GeneralisedMaxwell:
    """Return the material for the references, all moduli times a factor."""
    moduli, times = [factor * g for g, _ in body.branches], [tau for _, tau in body.branches]
    viscosity = factor * body.dashpot_viscosity
    return GeneralisedMaxwell(factor * body.long_term_modulus, moduli, times, viscosity)


def _pressed(scene: Scene) -> Viscoelastic:
    """Return the body of a scene whose history the solvers here can walk; refuse others."""
    body, loads = body_of(scene), _until_let_go(loads_of(scene))
    jumps = loads.control == "penetration" and loads.values[0] > 0
    if body.dashpot_viscosity > 0 and jumps:
        raise Refused(
            "a step in penetration needs an infinite force on the dashpot of a Kelvin-Voigt body"
        )
    return body


LET_GO = "without a force the penetration is not determined (prescribe it to let the body go)"


def _until_let_go(loads: AbsoluteLoads) -> AbsoluteLoads:
    """Return a history up to where its force has dropped to zero."""
    gone = np.flatnonzero(loads.values[1:] <= 0)
    if loads.control != "force" or not gone.size:
        return loads
    held = slice(int(gone[0]) + 1)
    return replace(loads, values=loads.values[held], times=_times(loads)[held])


def _times(loads: AbsoluteLoads) -> np.ndarray:
    return needed(loads.times, "no history in time")


def _divided(loads: AbsoluteLoads, steps: int, *, graded: bool = False) -> tuple[np.ndarray, int]:
    """Return the times with each stretch divided, in all about `steps`, and by how much.

    Graded, the first stretch has its short steps first.
    """
    times = _times(loads)
    parts = max(1, -(-steps // max(1, times.size - 1)))
    shares = np.arange(1, parts + 1) / parts
    inner = [(1 - shares) * a + shares * b for a, b in pairwise(times)]
    if graded and inner:
        inner[0] = times[0] + graded_times(float(times[1] - times[0]), parts)[1:]
    return np.concatenate([times[:1], *inner]), parts


def _values(loads: AbsoluteLoads, times: np.ndarray) -> np.ndarray:
    """Return the prescribed load at the times of finer steps."""
    return np.interp(times, _times(loads), loads.values)


class InTime(Solver[G]):
    """What walks through a history of loads, as long as there is a force."""

    physics = PHYSICS

    def solve(self, task: Task[G]) -> Solution:
        """Solve the steps up to where the body is let go."""
        loads = _until_let_go(task.loads)
        solution = super().solve(replace(task, loads=loads))
        missing = task.shape[1] - loads.values.size
        if not missing:
            return solution
        rest = Solution.empty(replace(task, loads=replace(loads, values=np.zeros(missing))))
        for row, step in np.ndindex(rest.converged.shape):
            rest.fail((row, step), LET_GO, undetermined=True)
        return replace(Solution.concat([solution, rest], STEPS), fields=solution.fields)


class ReducedMemory(InTime[IndenterGeometry], ProfileSolver):
    """Springs with memory, exact in time under a prescribed depth."""

    name = "reduced"
    beside = "each with the memory of (19.31), on its own"
    only_indenters = "viscoelastic rough lines are implemented for sliding only"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.edges, self.material = scene.methods.reduced.edges, springs_of(_pressed(scene))

    def steps(self, task: Task[IndenterGeometry], _: np.ndarray) -> Iterator[Step]:
        loads, springs = task.loads, task.resolution
        forced = loads.control == "force"
        steps = STEPS_OF_SPRINGS * springs if forced else 1
        times, parts = _divided(loads, steps, graded=forced and self.material.viscosity > 0)
        ratio = self.scene.poisson_ratio
        row = RelaxingSprings(self.profile, self.material, ratio, springs, edges=self.edges)
        history = indent_in_time(row, times, LoadPath(loads.control, _values(loads, times)))
        largest = int(np.argmax(history.contact_radius))
        deepest, widest = history.penetration[largest], history.contact_radius[largest]
        curves = {
            "penetration": history.penetration[::parts],
            "force": history.force[::parts],
            "equivalent_radius": history.contact_radius[::parts],
            "contact_length": history.contact_length[::parts],
        }
        unknowns = int(2 * widest / history.spacing)
        size = float(deepest), float(widest), history.spacing
        picture = partial(line_picture, self.profile, *size)
        yield from steps_of(curves, unknowns=unknowns, fields=picture)


def circular(form: closed_forms.ClosedForm) -> closed_forms.ClosedForm:
    """Return a closed form whose contact is a circle; refuse another."""
    if form.contact_radius is None:
        raise Refused("the integrals of Lee-Radok and Ting are for circular contacts only")
    return form


class ClosedFormMemory(InTime[IndenterGeometry], FormSolver):
    """Lee & Radok's and Ting's integrals, on the static closed form."""

    name = "closed_form"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.material = material_of(_pressed(scene))
        self.form = circular(self.form)
        loads = _until_let_go(loads_of(scene))
        try:
            self._integrated(loads, np.array([loads.values.size - 1]))
        except ValueError as error:  # a history that the integrals do not know
            raise Refused(str(error)) from error
        self.note = f"{SOURCES}; {self.note}"

    def steps(self, task: Task[IndenterGeometry], _: np.ndarray) -> Iterator[Step]:
        curve = self._integrated(task.loads, np.arange(task.loads.values.size))
        curves = {
            "penetration": curve.penetration,
            "force": curve.force,
            "equivalent_radius": curve.contact_radius,
        }
        yield from steps_of(curves, violation=0.0)

    def _integrated(self, loads: AbsoluteLoads, steps: np.ndarray) -> reference.Curve:
        """Evaluate the integral of the control at some of the steps."""
        integrate = reference.creep if loads.control == "force" else reference.indentation
        times = _times(loads)
        history = reference_loads.History(loads.control, times, loads.values)
        return integrate(
            *(self.form, self.modulus, self.material, history, times[steps]),
            poisson_ratio=self.scene.poisson_ratio,
        )


class GridMemory(InTime[Geometry], BemFft):
    """The half-space in time: a contact problem per step, on a surface that remembers."""

    beside = "pressures linear in time, with all memory"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        body = _pressed(scene)
        if scene.indenter is not None and scene.indenter.flat:
            raise Refused("flat faces are not supported: their edges lie inside cells")
        self.material = material_of(body)
        self.damped = body.dashpot_viscosity > 0

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """As for one load, but no finer than a history of some hundred steps can pay for."""
        if not isinstance(geometry, IndenterGeometry):
            return super().resolutions(geometry)[:2]
        return self.series(64, 32, 128)

    def _steps(
        self, task: Task, operator: ElasticBody, grid: Grid, loads: np.ndarray
    ) -> Iterator[Step]:
        """Yield the steps at the scene's times.

        Against a dashpot instants lie in the middles of steps: at its end a stretch has the line
        through its last two, and before the first step nothing has moved.
        """
        cells = task.resolution if isinstance(task.geometry, IndenterGeometry) else STEPS_OF_SURFACE
        times, parts = _divided(task.loads, STEPS_OF_CELLS * cells)
        instants = reference.press_in_time(
            operator,
            grid.gap,
            self.material,
            reference_loads.History(task.loads.control, times, _values(task.loads, times)),
            poisson_ratio=self.scene.poisson_ratio,
            tolerance=self.tolerance,
        )
        step, before = 0, None
        for number, instant in enumerate(instants):
            while step < loads.size and max(step * parts - self.damped, 0) == number:
                values = _quantities(instant, grid, periodic=operator.periodic)
                if self.damped and step == 0:
                    values = dict.fromkeys(values, 0.0)
                elif self.damped and before is not None:
                    last = _quantities(before, grid, periodic=operator.periodic)
                    values = {name: 1.5 * values[name] - 0.5 * last[name] for name in values}
                prescribed = {task.loads.control: float(loads[step])}
                yield Step(values | prescribed, violation=instant.violation)
                step += 1
            before = instant


def _quantities(instant: reference.Instant, grid: Grid, *, periodic: bool) -> dict[str, float]:
    values = counted_quantities(instant, grid.spacing, periodic=periodic)
    # linear in time like the others, where it is drawn through two instants
    return values | {"equivalent_radius": float(np.sqrt(values["contact_area"] / np.pi))}


SLIDING = frozenset({"viscoelastic", "sliding"})
# A line reaches this many radii of the geometric overlap to each side, and its springs lie off the
# axis by this share of their spacing.
_MARGIN, _OFFSET = 1.1, 0.382
# Lines that are tried to fit the contact at a speed, each with the radius found on the last.
_FITS = 8


def _sliding(scene: Scene) -> Viscoelastic:
    """Return the body of a scene that slides steadily; refuse what is unsteady or unbounded."""
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


STEADY = "steady sliding on springs with memory (19.31)"


class ReducedSliding(ProfileSolver):
    """Problem 1 as corrected: the steady state of a profile at each speed."""

    name = "reduced"
    physics = SLIDING
    beside = STEADY

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.material = _springs(scene)

    def steps(self, task: Task[IndenterGeometry], speeds: np.ndarray) -> Iterator[Step]:
        control, load = normal_load(task)
        by_depth = control == "penetration"
        profile, resolution = self.profile, task.resolution
        count = int(np.ceil(_MARGIN * resolution)) + 1
        # springs off the axis: on it, symmetric sums would be better than they are
        places = np.arange(-count, count + 1) + _OFFSET
        for speed in map(float, speeds):
            radius = task.geometry.contact_radius
            if by_depth:
                radius = float(profile.contact_radius(load))
            for _ in range(_FITS):  # on a line fitted to the contact, which a coarse one tells
                spacing = radius / resolution
                line = -np.asarray(profile.height(np.abs(places * spacing)), dtype=float)
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
            values = {name: float(curve[0, 0]) for name, curve in _curves(state, 1.0).items()}
            unknowns = int(2 * _MARGIN * resolution)
            yield Step(values | {"speed": speed}, unknowns=unknowns)


class ReducedSlidingLines(LineSolver):
    """Problem 1 as corrected: the steady state of rough lines at every speed at once."""

    name = "reduced"
    physics = SLIDING
    beside = f"; {STEADY}"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.material = _springs(scene)
        if scene.loading.control != "force":
            raise Refused("rough lines slide under prescribed force only")

    def warm_up(self, task: Task[RoughGeometry]) -> None:
        line = RoughLines(-(np.linspace(-1.0, 1.0, 17) ** 2), 0.125)
        slide(line, self.material, task.loads.values[:1], LoadPath("force", 1e-9))

    def solve(self, task: Task[RoughGeometry]) -> Solution:
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


class GridSliding(HalfSpaceGrid):
    """The half-space under travelling pressure, its unsymmetric contact solved directly."""

    name = "bem_fft"
    physics = SLIDING
    beside = "of pressure that travels over a creeping body"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.material = material_of(_sliding(scene), _relative_stiffness(scene))

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Cells per half-width of the overlap; points per side of a rough surface."""
        if isinstance(geometry, RoughGeometry):
            return tuple(f * geometry.points[0] for f in (1, 2, 4) if f * geometry.points[0] <= 256)
        tolerance = self.scene.compare.tolerance
        finest = 16 * int(np.clip(np.ceil(4 * np.sqrt(0.01 / tolerance)), 2, 6))
        return finest // 4, finest // 2, finest

    def refusal(self, task: Task) -> str:
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

    def warm_up(self, task: Task) -> None:
        speed = float(task.loads.values[0])
        x = np.linspace(-1.0, 1.0, 8)
        operator = Travelling((8, 8), (0.25, 0.25), self.material, speed)
        slide_on_rubber(operator, x[:, None] ** 2 + x**2, reference_loads.Load("penetration", 0.3))

    def rows(self, task: Task) -> Iterator[Row]:
        """Yield each realisation; an indenter's grids are made for each speed."""
        geometry, load = task.geometry, reference_loads.Load(*normal_load(task))

        def of_shape(indenter: Indenter, speeds: np.ndarray) -> Iterator[Step]:
            gap, reach = indenter.gap, indenter.reach
            for speed in map(float, speeds):
                depth = window_depth(gap, reach, self.material, speed, load)
                window = reach(depth), self.material, speed, 2 * task.resolution
                yield _step(slide_shape(gap, *window, load), speed)

        def of_surface(grid: Grid, speeds: np.ndarray) -> Iterator[Step]:
            mask = None  # the contact starts from the one at the speed before
            for speed in map(float, speeds):
                operator = Travelling(
                    grid.gap.shape, grid.spacing, self.material, speed, periodic=geometry.periodic
                )
                state = slide_on_rubber(operator, grid.gap, load, start=mask)
                mask = state.mask
                yield _step(state, speed)

        for realisation in task.realisations:
            if isinstance(geometry, IndenterGeometry):
                yield Row(partial(of_shape, geometry.indenter))
            else:
                yield Row(partial(of_surface, make_grid(geometry, task.resolution, realisation)))


def _step(state: SlidingContact, speed: float) -> Step:
    surface = state.operator
    sliding = {
        "friction_coefficient": state.friction_coefficient,
        "tangential_force": state.tangential_force,
        "speed": speed,
    }
    return Step(
        counted_quantities(state, surface.spacing, periodic=surface.periodic) | sliding,
        iterations=state.rounds,
        violation=state.violation,
        unknowns=int(state.mask.sum()),
    )
