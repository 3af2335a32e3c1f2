"""Viscoelastic normal contact in time: springs, hereditary integrals, grids.

The scene's times are where the answer is wanted. Methods that have an error in time divide the
stretches between them further, in proportion to their resolution, so that one refinement refines
both and the bar covers both.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods.base import Solution, Support, Task
from comparisons.methods.bem_fft import BemFft
from comparisons.methods.closed_form import ClosedForm, form_of
from comparisons.methods.grid import make_grid
from comparisons.methods.reduced import Reduced, line_picture, profile_of
from comparisons.scene.options import FftOptions, ReducedOptions
from comparisons.scene.physics.loads import Loads, loads_of
from comparisons.scene.scene import Scene
from reduced import errors as reduced_errors
from reduced.memory.indent import History, graded_times, indent_in_time
from reduced.memory.materials import Prony, prony
from reduced.profiles.shapes import paraboloid
from reference import viscoelastic as reference
from reference.errors import ConvergenceError
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


def springs_of(scene: Scene) -> Prony:
    """Return the material of the scene for the springs."""
    body = scene.viscoelastic
    assert body is not None
    moduli, times = zip(*body.branches, strict=True) if body.branches else ((), ())
    return prony(body.long_term_modulus, moduli, times, viscosity=body.dashpot_viscosity)


def material_of(scene: Scene) -> GeneralisedMaxwell:
    """Return the material of the scene for the references."""
    body = scene.viscoelastic
    assert body is not None
    moduli, times = zip(*body.branches, strict=True) if body.branches else ((), ())
    return GeneralisedMaxwell(body.long_term_modulus, moduli, times, body.dashpot_viscosity)


def _refused(scene: Scene) -> str:
    """Return why a scene has no history that the methods here walk, "" where it has one."""
    loads = loads_of(scene)
    if loads.control == "force" and (loads.values[1:] <= 0).any():
        return "a force that ends leaves the depth open: the body has left, or rests"
    damped = scene.viscoelastic is not None and scene.viscoelastic.dashpot_viscosity > 0
    if damped and loads.control == "penetration" and loads.values[0] > 0:
        return "the dashpot of a Kelvin-Voigt body resists a jump of the depth without bound"
    return ""


def _divided(loads: Loads, steps: int, *, graded: bool = False) -> tuple[np.ndarray, int]:
    """Return the times with each stretch divided, in all about `steps`, and by how much.

    Graded, the first stretch has its short steps first.
    """
    times = loads.times
    assert times is not None
    parts = max(1, -(-steps // max(1, times.size - 1)))
    shares = np.arange(1, parts + 1) / parts
    inner = [(1 - shares) * a + shares * b for a, b in pairwise(times)]
    if graded and inner:
        inner[0] = times[0] + graded_times(float(times[1] - times[0]), parts)[1:]
    return np.concatenate([times[:1], *inner]), parts


class ReducedViscoelastic(Reduced):
    """Springs with memory, exact in time under a prescribed depth."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Every indenter."""
        if scene.indenter is None:
            return Support(False, "rough lines with memory slide here, they are not pressed")
        reason = _refused(scene)
        return Support(False, reason) if reason else super().supports(scene)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the line and its springs."""
        return f"{super().model(scene, geometry)}; each with the memory of (19.31), on its own"

    def warm_up(self, task: Task) -> None:
        """Compile the springs on a history that cannot fail."""
        indent_in_time(_BALL, _SOLID, [0.0, 1.0], penetration=[0.1, 0.05], springs=4)

    def solve(self, task: Task) -> Solution:
        """Walk through the history once."""
        solution = Solution.empty(task)
        try:
            found, parts = self._solved(task, springs=task.resolution)
        except reduced_errors.ConvergenceError as error:
            return _lost(solution, error.reason)
        radius = found.contact_radius[::parts]
        area = np.pi * radius**2
        curves = {
            "penetration": found.penetration[::parts],
            "force": found.force[::parts],
            "contact_area": area,
            "contact_area_raw": area,
            "equivalent_radius": radius,
            "contact_length": found.contact_length[::parts],
        }
        assert task.scene.indenter is not None
        if task.scene.indenter.axisymmetric:
            curves["contact_radius"] = radius
        solution.quantities = {name: values[None, :] for name, values in curves.items()}
        solution.converged[:] = True
        largest = int(np.argmax(found.contact_radius))
        solution.unknowns = int(2 * found.contact_radius[largest] / found.spacing)
        solution.fields = line_picture(
            profile_of(task.scene),
            float(found.penetration[largest]),
            float(found.contact_radius[largest]),
            found.spacing,
        )
        return solution

    def _solved(self, task: Task, springs: int) -> tuple[History, int]:
        loads, material = task.loads, springs_of(task.scene)
        forced = loads.control == "force"
        times, parts = _divided(
            loads,
            STEPS_OF_SPRINGS * springs if forced else 1,
            graded=forced and material.viscosity > 0,
        )
        options = task.options
        assert isinstance(options, ReducedOptions)
        assert loads.times is not None
        history = {loads.control: np.interp(times, loads.times, loads.values)}
        found = indent_in_time(
            *(profile_of(task.scene), material, times),
            **history,
            poisson_ratio=task.scene.poisson_ratio,
            springs=springs,
            edges=options.edges,
        )
        return found, parts


def _lost(solution: Solution, reason: str) -> Solution:
    """Record that the whole history has no answer."""
    for step in range(solution.converged.shape[1]):
        solution.fail((0, step), reason)
    return solution


class ClosedFormViscoelastic(ClosedForm):
    """Lee & Radok's and Ting's integrals, on the static closed form."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Bodies of revolution on histories that the integrals know."""
        reason = "" if scene.indenter is None else _refused(scene)
        support = super().supports(scene)
        if reason or not support.ok:
            return Support(False, reason) if reason else support
        if not circular(scene):
            return Support(False, "the integrals of Lee-Radok and Ting are for circular contacts")
        try:
            _integrated(scene, loads_of(scene), np.array([loads_of(scene).values.size - 1]))
        except ValueError as error:
            return Support(False, str(error))
        return Support(True, f"Lee & Radok 1960, Ting 1968; {support.reason}")

    def solve(self, task: Task) -> Solution:
        """Evaluate the integrals at every time."""
        solution = Solution.empty(task)
        found = _integrated(task.scene, task.loads, np.arange(task.loads.values.size))
        area = np.pi * found.contact_radius**2
        curves = {
            "penetration": found.penetration,
            "force": found.force,
            "contact_area": area,
            "contact_area_raw": area,
            "equivalent_radius": found.contact_radius,
            "contact_radius": found.contact_radius,
        }
        solution.quantities = {name: values[None, :] for name, values in curves.items()}
        solution.converged[:] = True
        solution.violation[:] = 0.0
        return solution


def circular(scene: Scene) -> bool:
    """Whether the closed form of the shape knows a contact radius."""
    assert scene.indenter is not None
    form = form_of(scene.indenter, scene.effective_modulus)
    return form is not None and form.contact_radius is not None


def _integrated(scene: Scene, loads: Loads, steps: np.ndarray) -> reference.Curve:
    """Evaluate the integral of the scene's control at some of its steps."""
    assert scene.indenter is not None
    assert loads.times is not None
    modulus = scene.effective_modulus
    form = form_of(scene.indenter, modulus)
    assert form is not None
    integrate = reference.creep if loads.control == "force" else reference.indentation
    return integrate(
        *(form, modulus, material_of(scene), loads.times, loads.values, loads.times[steps]),
        poisson_ratio=scene.poisson_ratio,
    )


class BemFftViscoelastic(BemFft):
    """The half-space in time: a contact problem per step, on a surface that remembers."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Every shape that is no flat face, and every surface."""
        reason = _refused(scene)
        if not reason and scene.indenter is not None and scene.indenter.flat:
            reason = "a flat face has edges inside cells; its contact stays, and needs no history"
        return Support(not reason, reason)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """As for one load, but no finer than a history of some hundred steps can pay for."""
        if not isinstance(geometry, IndenterGeometry):
            return super().resolutions(scene, geometry)[:2]
        finest = int(np.clip(64 * np.sqrt(0.01 / scene.compare.tolerance), 32, 128))
        return finest // 4, finest // 2, finest

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the domain, and what a step is."""
        return f"{super().model(scene, geometry)}; pressures linear in time, with all memory"

    def solve(self, task: Task) -> Solution:
        """Walk every realisation through the history."""
        solution, options = Solution.empty(task), task.options
        assert isinstance(options, FftOptions)
        cells = task.resolution if isinstance(task.geometry, IndenterGeometry) else STEPS_OF_SURFACE
        times, parts = _divided(task.loads, STEPS_OF_CELLS * cells)
        for row, realisation in enumerate(task.realisations):
            with solution.setup():
                grid = make_grid(task.geometry, task.resolution, realisation)
                operator = self.operator(task, grid.gap.shape, grid.spacing)
                operator.convolution(np.float64)
                solution.unknowns = int(np.isfinite(grid.gap).sum())
            assert task.loads.times is not None
            history = {task.loads.control: np.interp(times, task.loads.times, task.loads.values)}
            instants: list[reference.Instant] = []
            reason = ""
            try:
                instants.extend(
                    reference.press_in_time(
                        *(operator, grid.gap, material_of(task.scene), times),
                        **history,
                        poisson_ratio=task.scene.poisson_ratio,
                        tolerance=options.tolerance,
                    )
                )
            except ConvergenceError as error:
                reason = error.reason
            _record(task, solution, row, instants, grid.spacing, operator.periodic, parts)
            for step in np.flatnonzero(~solution.converged[row]):
                solution.fail((row, int(step)), reason or "no instant")
        return solution


def _record(
    task: Task,
    solution: Solution,
    row: int,
    instants: list[reference.Instant],
    spacing: tuple[float, float],
    periodic: bool,
    parts: int,
) -> None:
    """Put the instants at the scene's times into a solution.

    Against a dashpot instants lie in the middles of steps: at its end a stretch has the line
    through its last two, and before the first step nothing has moved.
    """

    def values(instant: reference.Instant) -> dict[str, float]:
        mask = instant.pressure > 0
        area = float(areas.corrected_area(mask, spacing, periodic=periodic))
        found = {
            "penetration": instant.penetration,
            "force": instant.force,
            "contact_area_raw": float(areas.raw_area(mask, spacing)),
            "contact_area": area,
            "equivalent_radius": float(np.sqrt(area / np.pi)),
        }
        indenter = task.scene.indenter
        if indenter is not None and indenter.axisymmetric:
            found["contact_radius"] = found["equivalent_radius"]
        return found

    damped = springs_of(task.scene).viscosity > 0
    for step, load in enumerate(task.loads.values):
        last = step * parts - damped
        if last >= len(instants):
            break
        if damped and step == 0:
            found = dict.fromkeys(values(instants[0]), 0.0) if instants else {}
        else:
            found = values(instants[last])
        if damped and step > 0:
            before = values(instants[last - 1])
            found = {name: 1.5 * found[name] - 0.5 * before[name] for name in found}
        solution.put((row, step), found | {task.loads.control: float(load)})
        solution.violation[row, step] = instants[max(last, 0)].violation
        solution.iterations[row, step] = 0


WIRINGS = (ReducedViscoelastic(), ClosedFormViscoelastic(), BemFftViscoelastic())
