"""Steady rolling with friction and creep.

Springs; the half-space below a grid, with Cerruti's kernels between its cells; finite elements in
the stationary frame, through which the material flows; FASTSIM and Kalker's linear theory.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial
from typing import Any

import numpy as np

from comparisons.facts.quantities.rows import HALF_AXES
from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.methods import Refused, Row, Scene, Solution, Solver, Step, Task, needed
from comparisons.methods.friction import FrictionalGrid, normal_load
from comparisons.methods.normal.closed_form import form_of
from comparisons.methods.normal.grid import (
    SMALL_BALL,
    Grid,
    cells,
    counted_quantities,
    half_axes,
    make_grid,
)
from comparisons.methods.normal.reduced import ProfileSolver, line_picture
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.indenters.not_round import Ellipsoid
from comparisons.scene.physics.tables.friction import Friction
from comparisons.scene.physics.tables.rolling import Rolling
from comparisons.tasks.shown_loads import grid_pressure
from reduced.friction import slide
from reduced.friction.roll import roll as roll_springs
from reduced.loads import Load
from reduced.springs.line import Springs
from reference import loads as reference_loads
from reference.fem import Material
from reference.fem.grid_body import ShearBody
from reference.halfspace import areas
from reference.halfspace.friction import FrictionalPress
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.rolling.creep_theories import EllipticContact, Rolled, fastsim, kalker, linear
from reference.rolling.roll import Creep, RollingStep, roll

PHYSICS = frozenset({"friction", "rolling"})
# A force of rolling that is a smaller share of mu F is none.
ROUND_OFF = 1e-9
Pair = tuple[Any, Any]


def tables_of(scene: Scene) -> tuple[Rolling, Friction]:
    """Return both tables of a scene that rolls."""
    rolling = needed(scene.rolling, "no [rolling]")
    friction = needed(scene.friction, "no [friction]")
    indenter: Indenter | None = scene.indenter
    if indenter is not None and indenter.flat:
        raise Refused("a flat face does not roll")
    return rolling, friction


def quantities(creep: Pair, forces: Pair, friction: float, force: float) -> dict[str, Any]:
    """Return the quantities of creeps and forces, each along and across; no round-off of zero."""
    least = ROUND_OFF * friction * np.asarray(force)
    along, across = (np.where(np.abs(part) <= least, 0.0, part) for part in forces)
    return {
        "tangential_force": along,
        "lateral_force": across,
        "traction": along / (friction * force),
        "friction_coefficient": along / force,
        "creep": creep[0],
        "lateral_creep": creep[1],
    }


def pairs(rolling: Rolling, values: np.ndarray) -> list[tuple[float, float]]:
    """Return creep and lateral creep of several steps."""
    return [rolling.both(float(value)) for value in values]


class ReducedRolling(ProfileSolver):
    """Springs that enter the contact unstretched and slip at mu times their normal force."""

    name = "reduced"
    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.edges = scene.methods.reduced.edges
        self.rolling, friction = tables_of(scene)
        if self.rolling.spin:
            raise Refused("springs on a line have no spin")
        # G* of the springs: the chapter's, or that of the half-space's first slope
        modulus, stiffness = scene.tangential_modulus, "4G/(2 - nu) dx"
        if scene.methods.reduced.rolling == "matched":
            lateral = any(self.rolling.lateral_creep.values)
            if lateral and any(self.rolling.creep.values):
                raise Refused("springs of one stiffness cannot match the slopes of both creeps")
            nu = scene.poisson_ratio
            if nu < 0:
                raise Refused("Kalker's coefficients begin at nu = 0")
            modulus = scene.shear_modulus * kalker(1.0, nu)[lateral]
            stiffness = "C G dx, C Kalker's coefficient of a circle"
        self.friction = slide.Friction(modulus, friction.coefficient)
        self.beside = f"tangential springs of {stiffness} that enter unstretched"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        line = Springs(self.profile, self.modulus, task.resolution, edges=self.edges)
        along, across = np.array(pairs(self.rolling, task.loads.values)).T
        answer = roll_springs(line, self.friction, Load(*normal_load(task)), along, across)
        forces = answer.tangential_force, answer.lateral_force
        rolled = quantities((along, across), forces, self.friction.coefficient, answer.force)
        contact = {
            "penetration": answer.penetration,
            "force": answer.force,
            "equivalent_radius": answer.contact_radius,
            "contact_length": 2 * answer.contact_radius,
            "stick_area": np.pi * (answer.stick_length / 2) ** 2,
        }
        solution = Solution.of(task, rolled | contact, unknowns=2 * task.resolution)
        spacing = answer.contact_radius / task.resolution
        solution.fields = line_picture(
            self.profile, answer.penetration, answer.contact_radius, spacing
        )
        return solution


# Where on a cell spin acts is a choice, and its error on three grids not monotone: a part of the
# bar, in cells on half the length of the contact. Measured: docs/friction.md, other contacts.
SPIN_DOUBT = 0.5


class GridRolling(FrictionalGrid):
    """Stick and slip of a steady contact, by Newton's method on its unsymmetric equations."""

    name = "bem_fft"
    physics = PHYSICS
    tractions = "steady tractions with Cerruti's kernel"
    least_tolerance = 1e-8

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.rolling, _ = tables_of(scene)

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Cells per contact radius: tractions are known to 1 % on 16, of first order."""
        return self.series(24, 12, 28, multiple=4)

    def memory(self, task: Task) -> float:
        """Bytes of one grid and of thirty pairs of directions and their images on it."""
        return 1500.0 * cells(task.geometry, task.resolution)

    def warm_up(self, task: Task) -> None:
        ball = FrictionalPress(self.body(SMALL_BALL.shape, (1.0, 1.0)), SMALL_BALL, 0.5)
        list(roll(ball, reference_loads.Load("penetration", 0.5), [Creep(0.1)]))

    def body(self, shape: tuple[int, int], spacing: tuple[float, float]) -> NormalAndTangential:
        """Return the elastic body below the grid."""
        nu = self.scene.poisson_ratio
        compliance = Compliance.of(self.scene.shear_modulus, nu)
        return NormalAndTangential(shape, spacing, compliance)

    def rows(self, task: Task) -> Iterator[Row]:
        grid = make_grid(task.geometry, task.resolution)
        body = self.body(grid.gap.shape, grid.spacing)
        press = FrictionalPress(body, grid.gap, self.friction, self.coupled)
        along, across = task.geometry.reach
        cells_along = task.resolution * np.sqrt(along / across)
        doubt = float(SPIN_DOUBT / cells_along) if self.rolling.spin else 0.0

        def steps(values: np.ndarray) -> Iterator[Step]:
            """Yield the steps; each starts from the tractions of the one before."""
            creeps = [Creep(*pair, self.rolling.spin) for pair in pairs(self.rolling, values)]
            load = reference_loads.Load(*normal_load(task))
            for step in roll(press, load, creeps, tolerance=self.tolerance):
                forces = step.tangential_force, step.lateral_force
                rolled = quantities(step.creep[:2], forces, self.friction, step.force)
                contact = counted_quantities(step, grid.spacing)
                contact["stick_area"] = float(areas.corrected_area(step.sticking, grid.spacing))
                if not self.coupled:
                    contact |= half_axes(task, *grid.centres, step.pressure)
                yield Step(
                    rolled | contact,
                    iterations=step.rounds,
                    violation=max(step.violation, step.error),
                    unknowns=2 * int(np.count_nonzero(step.pressure)),
                    pressure=partial(self._fields, grid, step),
                    fields=partial(self._fields, grid, step) if task.wants_pressure else None,
                )

        yield Row(steps, truncation=doubt)

    def _fields(self, grid: Grid, step: RollingStep) -> dict[str, np.ndarray]:
        """Return pressure and tractions, and what part of the bound they use."""
        bound, size = self.friction * step.pressure, np.hypot(*step.traction)
        return grid_pressure(*grid.centres, step.pressure) | {
            "penetration": np.array(step.penetration),
            "pressure_weight": np.full(step.pressure.size, grid.spacing[0] * grid.spacing[1]),
            "friction_used": np.divide(
                size, bound, out=np.full(size.shape, np.nan), where=bound > 0
            ).ravel(),
            "traction_x": step.traction[0].ravel(),
            "traction_y": step.traction[1].ravel(),
        }


class FemRolling(GridRolling):
    """Columns of elements below a grid; stick and slip as on the half-space."""

    name = "fem"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.element, self.inertia = scene.methods.fem.element, scene.methods.fem.inertia
        if scene.poisson_ratio < 0:
            raise Refused("rolling on finite elements: nu from 0")

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Elements per contact radius, one below each cell."""
        return self.series(16, 12, 24, multiple=4)

    def model(self, geometry: Geometry) -> str:
        both = "normal and tangential forces coupled" if self.coupled else "uncoupled from pressure"
        flow = f", inertia rho V^2/G = {self.inertia:g}" if self.inertia else ""
        return (
            "a mesh of equal cells that stands still while the material flows through it "
            f"(arbitrary Lagrange-Euler){flow}; {both}"
        )

    def body(self, shape: tuple[int, int], spacing: tuple[float, float]) -> ShearBody:
        nu = self.scene.poisson_ratio
        material = Material(self.scene.effective_modulus * (1 - nu**2), nu)
        return ShearBody(shape, spacing, material, element=self.element, inertia=self.inertia)


class Theory(Solver[IndenterGeometry]):
    """A theory of elliptic contacts; normal and tangential loads do not act on each other."""

    physics = PHYSICS

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.rolling, friction = tables_of(scene)
        self.friction = friction.coefficient
        reason = "for elliptic contacts of paraboloids and ellipsoids only"
        indenter = needed(scene.indenter, reason)
        if indenter.shape not in ("paraboloid", "ellipsoid"):
            raise Refused(reason)
        self.form = needed(form_of(indenter, scene.effective_modulus), reason)  # Hertz's contact
        half_x, half_y = self.form.semi_axes(1.0)
        try:
            kalker(float(half_x / half_y), scene.poisson_ratio)
        except ValueError as error:
            raise Refused(f"Kalker's table: {error}") from error

    def steps(self, task: Task[IndenterGeometry], values: np.ndarray) -> Iterator[Step]:
        control, load = normal_load(task)
        depth = load if control == "penetration" else float(self.form.penetration(load))
        force, area = float(self.form.force(depth)), float(self.form.contact_area(depth))
        a, b = (float(axis) for axis in self.form.semi_axes(depth))
        nu = self.scene.poisson_ratio
        contact = EllipticContact((a, b), self.scene.shear_modulus, nu, self.friction * force)
        steady = {"penetration": depth, "force": force, "contact_area": area}
        if isinstance(task.geometry.indenter, Ellipsoid):
            steady |= dict(zip(HALF_AXES, (a, b), strict=True))
        for creep in pairs(self.rolling, values):
            rolled = self.rolled(contact, (*creep, self.rolling.spin), task.resolution)
            forces = rolled.tangential_force, rolled.lateral_force
            found = quantities(creep, forces, self.friction, force)
            found["stick_area"] = rolled.stick_area
            yield Step(steady | found, unknowns=4 * task.resolution**2)

    def rolled(
        self, contact: EllipticContact, creep: tuple[float, float, float], resolution: int
    ) -> Rolled:
        """Return the forces at a creep: along, across, and spin."""
        raise NotImplementedError


class Fastsim(Theory):
    """FASTSIM (Kalker 1982): strips of independent springs under a parabolic bound."""

    name = "fastsim"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Return strips across half of the contact, as many steps along half a strip."""
        return self.series(40, 40, 400)

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        fastsim(EllipticContact((1.0, 1.0), 1.0, 0.25, 1.0), 0.1, cells=2)

    def rolled(
        self, contact: EllipticContact, creep: tuple[float, float, float], resolution: int
    ) -> Rolled:
        return fastsim(contact, *creep, cells=resolution)


class Kalker(Theory):
    """Kalker's linear theory (1967): all of the contact sticks, whatever the friction."""

    name = "kalker"

    def rolled(
        self, contact: EllipticContact, creep: tuple[float, float, float], resolution: int
    ) -> Rolled:
        return linear(contact, *creep)
