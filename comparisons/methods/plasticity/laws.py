"""A half-space that yields by a law: springs, Hertz's contact up to first yield, fits, hardness.

What all methods share (material, shape, first yield); springs by the readings of the chapter's rule
and by Zunker & Kamrin; Hertz (Johnson 1985); fits by Kogut & Etsion and by Jackson & Green of a
deformable ball under a rigid flat. Below rough surfaces a grid with its pressure capped at a
hardness, and lines with capped springs.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import suppress
from dataclasses import replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import brentq

from comparisons.formatting import with_unit
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods import Scene, Step, Task
from comparisons.methods.normal.bem import BemFft
from comparisons.methods.normal.closed_form import FormSolver
from comparisons.methods.normal.grid import Grid, block_means, blocks_of, contact_step
from comparisons.methods.normal.reduced import (
    LineSolver,
    ProfileSolver,
    line_curves,
    line_fields,
    line_picture,
)
from comparisons.methods.solver import ONLY_INDENTERS, Refused, Solver, ball_radius, needed
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.indenters.not_round import Ellipsoid
from comparisons.scene.loading import loads_of
from comparisons.scene.physics.tables.plasticity import HARDNESS, Plasticity
from comparisons.tasks.shown_loads import Fields
from comparisons.tasks.solution import Solution, Stopwatch
from reduced.errors import ConvergenceError
from reduced.loads import Load, LoadPath
from reduced.plasticity import Yielding, YieldingSprings, ZunkerKamrin, first_yield, walk
from reduced.profiles.equivalents import Profile
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference import loads as reference_loads
from reference.closed_form import ellipsoid
from reference.contact.body import ElasticBody
from reference.elasticity import Material
from reference.halfspace.areas import located_area
from reference.plastic import PlasticMaterial, capped, yield_depth, yield_pressure
from reference.plastic.dent_formulas import (
    Fit,
    FlattenedBall,
    elliptic_yield_pressure,
    jackson_green,
    kogut_etsion,
)

PHYSICS = frozenset({"plasticity"})
# Mean pressures over Y at which a contact first yields, and beyond which it is fully plastic.
FIRST_PRESSURE, _FULL_PRESSURE = 1.07, 2.7


def tables_of(scene: Scene) -> tuple[Indenter, Plasticity]:
    """Return what presses, and the table."""
    indenter = needed(scene.indenter, ONLY_INDENTERS)
    if indenter.flat:
        raise Refused("under a flat face the edge yields at first touch")
    return indenter, needed(scene.plasticity, "no [plasticity]")


def depth_of_yield(scene: Scene) -> float:
    """Return the penetration at which an indenter first makes the half-space yield.

    That of the pressure of Hertz's contact below which von Mises' stress first reaches Y (Johnson
    1985, 6.1, and the same of ellipses).
    """
    indenter, plasticity = tables_of(scene)
    nu, modulus = scene.poisson_ratio, scene.effective_modulus
    if not isinstance(indenter, Ellipsoid):
        pressure = yield_pressure(nu) * plasticity.yield_stress
        return yield_depth(ball_radius(scene), modulus, pressure)
    form = ellipsoid(indenter.radius_x, indenter.radius_y, modulus)
    narrow, wide = sorted(float(np.asarray(axis)) for axis in form.semi_axes(1.0))
    largest = 1.5 * float(form.force(1.0)) / (np.pi * narrow * wide)  # goes with the depth's root
    try:
        pressure = elliptic_yield_pressure(nu, narrow / wide) * plasticity.yield_stress
    except ValueError as error:
        raise Refused(f"first yield below ellipses: {error}") from None
    return (pressure / largest) ** 2


def material_of(scene: Scene) -> PlasticMaterial:
    """Return elastic constants, yield stress and hardening of the half-space."""
    plasticity = needed(scene.plasticity, "no [plasticity]")
    exponent = plasticity.hardening_exponent
    return PlasticMaterial(
        Material(*scene.elastic_constants),
        plasticity.yield_stress,
        exponent or plasticity.hardening,
        "power" if exponent else "linear",
    )


def estimated_radius(scene: Scene, profile: Profile, control: str, load: float) -> float:
    """Estimate a contact radius, between that of Hertz and that of a rigid-plastic body."""
    indenter, plasticity = tables_of(scene)
    contact = indent(Springs(profile, scene.effective_modulus), Load(control, load))
    radius, force = float(contact.contact_radius[0]), float(contact.force[0])
    over = force / (np.pi * radius**2) / (FIRST_PRESSURE * plasticity.yield_stress)
    if over <= 1:
        return radius
    if control == "force":
        return max(
            radius, float(np.sqrt(force / (np.pi * _FULL_PRESSURE * plasticity.yield_stress)))
        )
    widest = float(np.sqrt(np.prod(indenter.reach(load))))
    return float(radius * (widest / radius) ** min(1.0, 2 * np.log10(over) / 3))


# How often a line grows by a third until it holds the contact under a force.
_WIDENINGS = 60
_WORDS = {
    "stress": f"capped where their stress (19.37) reaches {HARDNESS} Y",
    "elastic_root": f"capped where the stress of their elastic part reaches {HARDNESS} Y",
    "zunker_kamrin": "under the uniform pressure of Zunker & Kamrin (2024)",
    "none": "that stay elastic",
}


class ReducedPlasticity(ProfileSolver):
    """Springs with a memory of how far they have yielded."""

    name = "reduced"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        indenter, self.plasticity = tables_of(scene)
        self.ball = None
        if self.plasticity.model == "zunker_kamrin":
            self.ball = ZunkerKamrin(
                ball_radius(scene),
                self.modulus,
                self.plasticity.yield_stress,
                sphere=indenter.shape == "sphere",
            )
        # That of first yield by the local rule, if it has one.
        self.yields_at: float | None = None
        pressure = yield_pressure(scene.poisson_ratio) * self.plasticity.yield_stress
        with suppress(ValueError):
            self.yields_at = first_yield(self.profile, self.modulus, pressure)
        if self.plasticity.model not in ("none", "zunker_kamrin") and self.yields_at is None:
            raise Refused(
                "the stress rule (19.37) needs a profile that is curved at its tip and beyond"
            )
        hardening = "; hardening is left out" if self.plasticity.hardens else ""
        self.beside = f"{_WORDS[self.plasticity.model]}{hardening}"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Nothing is compiled."""

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        path = LoadPath(task.loads.control, task.loads.values)
        if self.ball is not None:
            line = self.ball.walk(path)
        else:
            reading, reach = self.plasticity.model, task.geometry.penetration
            assert reading != "zunker_kamrin"
            for _ in range(_WIDENINGS):
                springs = YieldingSprings(
                    self.profile,
                    self.modulus,
                    self.plasticity.hardness,
                    reading,
                    reach=reach,
                    springs=task.resolution,
                )
                line = springs.walk(path)
                if line.penetration.max() <= reach * (1 + 1e-9):
                    break
                # Springs that yield go deeper under a force than elastic ones, from which this
                # came.
                reach *= 1.3
            else:
                raise ConvergenceError("the springs never carry this force")
        curves = {
            "penetration": line.penetration,
            "force": line.force,
            "equivalent_radius": line.contact_radius,
            "contact_length": 2 * line.contact_radius,
            "residual_depth": line.residual_depth,
        }
        if self.yields_at is not None:
            curves["first_yield"] = np.full(line.force.shape, self.yields_at)
        solution = Solution.of(task, curves, unknowns=2 * task.resolution)
        widest = float(line.contact_radius.max())
        depth = float(line.penetration[-1])
        solution.fields = line_picture(self.profile, depth, widest, widest / task.resolution)
        return solution


class ClosedFormPlasticity(FormSolver):
    """What does not yet make the half-space yield, round or elliptic; the load at which it does."""

    name = "closed_form"
    physics = PHYSICS
    only_indenters = ONLY_INDENTERS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.yields_at = depth_of_yield(scene)
        force, area = self.form.force(self.yields_at), self.form.contact_area(self.yields_at)
        first = (
            f"d = {with_unit(self.yields_at, 'm')}, F = {with_unit(force, 'N')}, "
            f"mean pressure {with_unit(force / area, 'Pa')}"
        )
        self.note += f"; first yield at {first}"
        self.range = f"exact up to first yield only ({first})"
        loads = loads_of(scene)
        depth = self._depths(loads.control, loads.values)
        if self._yielded(depth).all():
            raise Refused(
                f"{self.range}, and the first load is at {depth[0] / self.yields_at:.3g} times its "
                "penetration"
            )

    def _depths(self, control: str, loads: np.ndarray) -> np.ndarray:
        """Return the elastic penetration of loads; zero where nothing is pressed."""
        if control == "penetration":
            return np.maximum(loads, 0.0)
        return np.array([float(self.form.penetration(f)) if f > 0 else 0.0 for f in loads])

    def _yielded(self, depth: np.ndarray) -> np.ndarray:
        """Whether a load along the path, or one before it, is beyond first yield."""
        return np.asarray(np.maximum.accumulate(depth) > self.yields_at * (1 + 1e-12))

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Evaluate Hertz's formulas; nothing remains."""
        loads = task.loads.values
        depth = self._depths(task.loads.control, loads)
        pressed = depth > 0
        safe = np.where(pressed, depth, self.yields_at)
        force, area = np.asarray(self.form.force(safe)), np.asarray(self.form.contact_area(safe))
        curves: dict[str, ArrayLike] = {
            "penetration": loads if task.loads.control == "penetration" else depth,
            "force": np.where(pressed, force, 0.0),
            "contact_area": np.where(pressed, area, 0.0),
            "residual_depth": 0.0,
            "first_yield": self.yields_at,
        }
        solution = Solution.of(task, curves, violation=0.0)
        for step in np.flatnonzero(self._yielded(depth)):
            solution.fail((0, int(step)), self.range, out_of_range=True)
        return solution


class FittedBall(Solver[IndenterGeometry]):
    """A fit for an elastic-perfectly plastic ball on loading; for a half-space while a << R."""

    physics = PHYSICS
    fitted: Callable[[FlattenedBall], Fit]

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        _, plasticity = tables_of(scene)
        if plasticity.hardens:
            raise Refused("fitted without hardening")
        ball = FlattenedBall(
            ball_radius(scene),
            scene.effective_modulus,
            scene.poisson_ratio,
            plasticity.yield_stress,
        )
        self.fit = self.fitted(ball)
        loads = loads_of(scene)
        if (loads.values < 0).any() or (np.diff(loads.values) < 0).any():
            raise Refused("fitted on loading only")
        self.range = f"fitted up to {self.fit.largest:.3g} times the penetration of first yield"
        if (self._depths(loads.control, loads.values) > self.fit.largest).all():
            raise Refused(f"{self.range}, and every load is beyond that")
        self.note = self.fit.source

    def _depths(self, control: str, loads: np.ndarray) -> np.ndarray:
        """Return d/d_c of loads; beyond the range of the fit, infinity."""
        if control == "penetration":
            return np.asarray(loads / self.fit.yields_at)
        top = float(self.fit.force(np.array(self.fit.largest)))

        def depth(force: float) -> float:
            if force >= top:
                return self.fit.largest if force == top else np.inf
            root = brentq(
                lambda w: float(self.fit.force(np.array(w))) - force, 0.0, self.fit.largest
            )
            return float(root)

        return np.array([depth(float(load) / self.fit.force_unit) for load in loads])

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        fit = self.fit
        w = self._depths(task.loads.control, task.loads.values)
        beyond = w > fit.largest
        w[beyond] = np.nan
        curves = {
            "penetration": w * fit.yields_at,
            "force": fit.force(w) * fit.force_unit,
            "contact_area": fit.area(w) * fit.area_unit,
            "first_yield": np.full(w.shape, fit.yields_at),
        }
        if fit.residual is not None:
            curves["residual_depth"] = fit.residual(w) * fit.yields_at
        solution = Solution.of(task, curves, violation=0.0)
        for step in np.flatnonzero(beyond):
            solution.fail((0, int(step)), self.range, out_of_range=True)
        return solution


class KogutEtsion(FittedBall):
    """Kogut & Etsion (2002): power laws of finite elements, up to d/d_y = 110."""

    name = "kogut_etsion"
    fitted = staticmethod(kogut_etsion)


class JacksonGreen(FittedBall):
    """Jackson & Green (2005): a hardness that falls with the contact, up to a/R = 0.41."""

    name = "jackson_green"
    fitted = staticmethod(jackson_green)


class GridPlasticity(BemFft):
    """The half-space below a rough surface, elastic up to a hardness, perfectly plastic there."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.plasticity = needed(scene.plasticity, "no [plasticity]")
        if not scene.rough:
            raise Refused(
                "a pressure capped at a hardness is a model of rough surfaces; below one indenter "
                "the stress in the body says where it yields"
            )
        if self.plasticity.hardens:
            raise Refused("caps its pressure at one hardness: without hardening")
        self.beside = f"pressure capped at {HARDNESS} Y"

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return two grids: what yields is searched for at every load."""
        return super().resolutions(geometry)[:2]

    def _steps(
        self, task: Task, operator: ElasticBody, grid: Grid, loads: np.ndarray
    ) -> Iterator[Step]:
        hardness, tolerance = self.plasticity.hardness, self.tolerance
        path = reference_loads.LoadPath(task.loads.control, loads)
        for dent in capped.along(operator, grid.gap, hardness, path, tolerance=tolerance):
            # first, as the step of the elastic contact may forget the displacement
            area = located_area(dent.contact, hardness, patch=True)
            elastic = contact_step(task, operator, dent.contact, grid)
            yielded = {
                "contact_area": area,
                "residual_depth": dent.residual_depth,
                "plastic_share": dent.plastic_share,
            }
            yield replace(
                elastic,
                quantities={**elastic.quantities, **yielded},
                fields=partial(_fields, elastic, dent),
            )


def _fields(elastic: Step, dent: capped.Dent) -> Fields:
    """Return the fields of the contact, and the depth to which the surface stays dented."""
    assert elastic.fields is not None
    fields, sunk = dict(elastic.fields()), dent.sunk
    dented = block_means(sunk, blocks_of(sunk.shape))
    if "gap" in fields:
        fields["gap"] = fields["gap"] + dented.ravel()
    return fields | {"dent": dented}


class LinePlasticity(LineSolver):
    """Rough lines whose springs are capped by the local stress rule, with memory."""

    name = "reduced"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        options = scene.methods.reduced
        plasticity = needed(scene.plasticity, "no [plasticity]")
        if plasticity.model == "zunker_kamrin":
            raise Refused("Zunker & Kamrin's springs are for a ball")
        local = options.stress == "local" or plasticity.model == "elastic_root"
        if local and options.stress == "one_radius":
            raise Refused("with the elastic part of deflections, springs need their own curvature")
        self.springs = Yielding(
            self.modulus,
            plasticity.hardness,
            plasticity.model,
            "own_curvature" if local else "one_radius",
            options.edges,
        )
        self.beside = " that stay elastic"
        if plasticity.model != "none":
            whose = "their own curvature" if local else "their contact"
            part = "the elastic part of " if plasticity.model == "elastic_root" else ""
            hardening = "; hardening is left out" if plasticity.hardens else ""
            self.beside = (
                f", capped where the stress (19.37) by {part}their deflection and the radius of "
                f"{whose} reaches {HARDNESS} Y{hardening}"
            )

    def block(self, resolution: int) -> int:
        """Return how many lines are one task: they are led one by one."""
        return min(25, super().block(resolution))

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        with Stopwatch() as setup:
            lines = self.draw(task)
        yielded = walk(
            lines.rough, self.springs, LoadPath(task.loads.control, lines.loads(task.loads))
        )
        curves = line_curves(yielded.contact, lines) | {
            "residual_depth": yielded.residual_depth,
            "plastic_share": yielded.plastic_share,
        }
        solution = Solution.of(task, curves, unknowns=lines.points, setup_seconds=setup.seconds)
        solution.fields = line_fields(lines, float(yielded.contact.penetration[0, -1]))
        return solution
