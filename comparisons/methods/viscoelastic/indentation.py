"""Viscoelastic normal contact in time: springs, hereditary integrals, grids.

The times of the scene are output times. Methods with a time discretisation error subdivide the
intervals in proportion to their resolution, so that one refinement reduces both errors and the bar
covers both.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.normal.bem_fft import BemFft
from comparisons.methods.normal.closed_form import ClosedForm
from comparisons.methods.normal.grid import Grid
from comparisons.methods.normal.reduced import ReducedProfile, line_picture
from comparisons.methods.solver import Refused, needed
from comparisons.scene.physics.absolute_loads import AbsoluteLoads, loads_of
from comparisons.scene.physics.tables.viscoelastic import Viscoelastic
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import Step
from comparisons.tasks.task import Task
from reduced.loads import LoadPath
from reduced.memory.indent_in_time import History, graded_times, indent_in_time
from reduced.memory.materials import Prony, prony
from reduced.memory.row import RelaxingSprings
from reduced.profiles.equivalents import paraboloid
from reference import closed_form as closed_forms
from reference import loads as reference_loads
from reference import viscoelastic as reference
from reference.contact.body import ElasticBody
from reference.halfspace import areas
from reference.viscoelastic.materials import GeneralisedMaxwell

PHYSICS = frozenset({"viscoelastic"})
# Steps in time of a whole history for each spring or cell per contact radius.
STEPS_OF_SPRINGS = 4
STEPS_OF_CELLS = 2
# Cells per contact radius that a rough surface counts as in this: its own are points per side.
STEPS_OF_SURFACE = 32
# What warms up the springs' code.
_BALL, _SOLID = paraboloid(1.0), prony(1.0, [1.0], [1.0])
SOURCES = "Lee & Radok 1960, Ting 1968"


def body_of(scene: Scene) -> Viscoelastic:
    """Return the viscoelastic body of a scene.

    Raises
    ------
    Refused
        If it has none.
    """
    return needed(scene.viscoelastic, "no [viscoelastic]")


def springs_of(body: Viscoelastic) -> Prony:
    """Return the material for the springs."""
    moduli, times = zip(*body.branches, strict=True) if body.branches else ((), ())
    return prony(body.long_term_modulus, moduli, times, viscosity=body.dashpot_viscosity)


def material_of(body: Viscoelastic) -> GeneralisedMaxwell:
    """Return the material for the references."""
    moduli, times = zip(*body.branches, strict=True) if body.branches else ((), ())
    return GeneralisedMaxwell(body.long_term_modulus, moduli, times, body.dashpot_viscosity)


def _pressed(scene: Scene) -> Viscoelastic:
    """Return the body of a scene whose history the solvers here can walk.

    Raises
    ------
    Refused
        If it has none.
    """
    body, loads = body_of(scene), loads_of(scene)
    if loads.control == "force" and (loads.values[1:] <= 0).any():
        raise Refused("the penetration is undetermined after the force has dropped to zero")
    jumps = loads.control == "penetration" and loads.values[0] > 0
    if body.dashpot_viscosity > 0 and jumps:
        reason = (
            "a step in penetration needs an infinite force on the dashpot of a Kelvin-Voigt body"
        )
        raise Refused(reason)
    return body


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


class ReducedMemory(ReducedProfile):
    """Springs with memory, exact in time under a prescribed depth."""

    physics = PHYSICS
    options_read = frozenset({"rule", "edges"})
    only_indenters = "viscoelastic rough lines are implemented for sliding only"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.material = springs_of(_pressed(scene))

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line and its springs."""
        return f"{super().model(geometry)}; each with the memory of (19.31), on its own"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs on a history that cannot fail."""
        indent_in_time(
            RelaxingSprings(_BALL, _SOLID, per_radius=4),
            [0.0, 1.0],
            LoadPath("penetration", [0.1, 0.05]),
        )

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Walk through the history once."""
        history, parts = self._walk(task.loads, springs=task.resolution)
        largest = int(np.argmax(history.contact_radius))
        deepest, widest = history.penetration[largest], history.contact_radius[largest]
        curves = {
            "penetration": history.penetration[::parts],
            "force": history.force[::parts],
            "equivalent_radius": history.contact_radius[::parts],
            "contact_length": history.contact_length[::parts],
        }
        solution = Solution.of(task, curves, unknowns=int(2 * widest / history.spacing))
        picture = self.profile, float(deepest), float(widest), history.spacing
        solution.fields = line_picture(*picture)
        return solution

    def _walk(self, loads: AbsoluteLoads, springs: int) -> tuple[History, int]:
        forced = loads.control == "force"
        steps = STEPS_OF_SPRINGS * springs if forced else 1
        times, parts = _divided(loads, steps, graded=forced and self.material.viscosity > 0)
        row = RelaxingSprings(
            self.profile,
            self.material,
            self.scene.poisson_ratio,
            springs,
            edges=self.options.edges,
        )
        path = LoadPath(loads.control, np.interp(times, _times(loads), loads.values))
        return indent_in_time(row, times, path), parts


def circular(form: closed_forms.ClosedForm) -> closed_forms.ClosedForm:
    """Return a closed form whose contact is a circle.

    Raises
    ------
    Refused
        If it is none.
    """
    if form.contact_radius is None:
        raise Refused("the integrals of Lee-Radok and Ting are for circular contacts only")
    return form


class ClosedFormMemory(ClosedForm):
    """Lee & Radok's and Ting's integrals, on the static closed form."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.material = material_of(_pressed(scene))
        self.form = circular(self.form)
        loads = loads_of(scene)
        try:
            self._integrated(loads, np.array([loads.values.size - 1]))
        except ValueError as error:  # a history that the integrals do not know
            raise Refused(str(error)) from error
        self.note = f"{SOURCES}; {self.note}"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Evaluate the integrals at every time."""
        curve = self._integrated(task.loads, np.arange(task.loads.values.size))
        curves = {
            "penetration": curve.penetration,
            "force": curve.force,
            "equivalent_radius": curve.contact_radius,
        }
        return Solution.of(task, curves, violation=0.0)

    def _integrated(self, loads: AbsoluteLoads, steps: np.ndarray) -> reference.Curve:
        """Evaluate the integral of the control at some of the steps."""
        integrate = reference.creep if loads.control == "force" else reference.indentation
        times = _times(loads)
        history = reference_loads.History(loads.control, times, loads.values)
        return integrate(
            *(self.form, self.modulus, self.material, history, times[steps]),
            poisson_ratio=self.scene.poisson_ratio,
        )


class GridMemory(BemFft):
    """The half-space in time: a contact problem per step, on a surface that remembers."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        body = _pressed(scene)
        if scene.indenter is not None and scene.indenter.flat:
            reason = "flat faces are not supported: their edges lie inside cells"
            raise Refused(reason)
        self.material = material_of(body)
        self.damped = body.dashpot_viscosity > 0

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """As for one load, but no finer than a history of some hundred steps can pay for."""
        if not isinstance(geometry, IndenterGeometry):
            return super().resolutions(geometry)[:2]
        finest = int(np.clip(64 * np.sqrt(0.01 / self.scene.compare.tolerance), 32, 128))
        return finest // 4, finest // 2, finest

    def model(self, geometry: Geometry) -> str:
        """Name the domain, and what a step is."""
        return f"{super().model(geometry)}; pressures linear in time, with all memory"

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
            tolerance=self.options.tolerance,
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
    mask = instant.pressure > 0
    area = float(areas.corrected_area(mask, grid.spacing, periodic=periodic))
    return {
        "penetration": instant.penetration,
        "force": instant.force,
        "contact_area_raw": float(areas.raw_area(mask, grid.spacing)),
        "contact_area": area,
        # linear in time like the others, where it is drawn through two instants
        "equivalent_radius": float(np.sqrt(area / np.pi)),
    }
