"""Rubber that slides steadily: springs and lines of Problem 1, the half-space in three dimensions.

Every speed is a problem of its own, under the last normal load. Grids fit the contact at each
speed: fast rubber is stiff, and its contact small.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.base import Solution, Support, Task
from comparisons.methods.bem_fft import BemFft
from comparisons.methods.grid import make_grid
from comparisons.methods.memory import material_of, springs_of
from comparisons.methods.reduced import Reduced, draw_lines, profile_of
from comparisons.scene.scene import Scene
from reduced import errors as reduced_errors
from reduced.profiles import shapes
from reduced.rubber.steady import SteadySliding, slide
from reference.errors import ConvergenceError
from reference.halfspace import areas
from reference.sliding.cells import LIMIT
from reference.sliding.contact import SlidingContact, solve
from reference.sliding.operators import Travelling
from reference.sliding.studies import slide_shape, window_depth
from reference.viscoelastic.materials import GeneralisedMaxwell

PHYSICS = frozenset({"viscoelastic", "sliding"})
# A line reaches this many radii of the geometric overlap to each side, and its springs lie off the
# axis by this share of their spacing.
_MARGIN, _OFFSET = 1.1, 0.382
# Lines that are tried to fit the contact at a speed, each with the radius found on the last.
_FITS = 8


def _refused(scene: Scene) -> str:
    """Return why a scene has no steady sliding, "" where it has."""
    assert scene.viscoelastic is not None
    if not scene.viscoelastic.long_term_modulus > 0:
        return "a fluid sinks without end: nothing is steady"
    if scene.indenter is not None and scene.indenter.flat:
        return "a flat face slides on its sharp edge, where pressures have no bound"
    return ""


def _relative_stiffness(scene: Scene) -> float:
    """E*/(4 G): one for rubber, whose Poisson ratio is 1/2."""
    return 0.5 / (1 - scene.poisson_ratio)


class ReducedSliding(Reduced):
    """Problem 1 as corrected: the steady state of every speed at once."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Shapes with an equivalent profile, and rough lines."""
        reason = _refused(scene)
        if not reason and scene.indenter is None and scene.loading.control != "force":
            reason = "rough lines slide under a force here"
        return Support(False, reason) if reason else super().supports(scene)

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the line and its springs."""
        return f"{super().model(scene, geometry)}; steady sliding on springs with memory (19.31)"

    def warm_up(self, task: Task) -> None:
        """Compile the springs."""
        line = -(np.linspace(-1.0, 1.0, 17) ** 2)
        slide(line, 0.125, springs_of(task.scene), task.loads.values[:1], 1e-9, periodic=True)

    def solve(self, task: Task) -> Solution:
        """Slide the profile or the lines at every speed."""
        solution = Solution.empty(task)
        try:
            if isinstance(task.geometry, RoughGeometry):
                self._slide_lines(task, solution)
            else:
                self._slide_profile(task, solution)
        except reduced_errors.ConvergenceError as error:
            for row, step in np.argwhere(~solution.converged):
                solution.fail((int(row), int(step)), error.reason)
        return solution

    def _slide_lines(self, task: Task, solution: Solution) -> None:
        with solution.setup():
            lines, spacing, patches = draw_lines(task, task.geometry)
        found = slide(
            *(lines, spacing, springs_of(task.scene).scaled(_relative_stiffness(task.scene))),
            *(task.loads.values, patches * _normal(task)["force"]),
        )
        solution.quantities = _curves(found, patches)
        solution.converged[:] = True
        solution.unknowns = lines.shape[1]

    def _slide_profile(self, task: Task, solution: Solution) -> None:
        profile = profile_of(task.scene)
        solution.unknowns = int(2 * _MARGIN * task.resolution)
        for step, speed in enumerate(task.loads.values):
            found = self._settled(task, profile, float(speed))
            values = {name: float(curve[0, 0]) for name, curve in _curves(found, 1.0).items()}
            solution.put((0, step), values | {"speed": float(speed)})

    def _settled(self, task: Task, profile: shapes.Profile, speed: float) -> SteadySliding:
        """Slide on a line fitted to the contact, whose radius a coarse line tells for a force."""
        load = _normal(task)
        radius = task.geometry.contact_radius
        if "penetration" in load:
            radius = float(profile.contact_radius(load["penetration"]))
        material = springs_of(task.scene).scaled(_relative_stiffness(task.scene))
        for _ in range(_FITS):
            spacing = radius / task.resolution
            count = int(np.ceil(_MARGIN * task.resolution)) + 1
            # springs off the axis: on it, symmetric sums would be better than they are
            x = (np.arange(-count, count + 1) + _OFFSET) * spacing
            line = -np.asarray(profile.height(np.abs(x)), dtype=float)
            # depths are counted from the axis, the line's from its highest spring
            top = float(line.max())
            deep = {name: value + top for name, value in load.items() if name == "penetration"}
            found = slide(line, spacing, material, speed, **(load | deep), periodic=False)
            found = replace(found, penetration=found.penetration - top)
            wide = float(profile.contact_radius(found.penetration[0, 0]))
            if "penetration" in load or wide > 0.9 * radius:
                break
            radius = wide
        return found


def _normal(task: Task) -> dict[str, float]:
    """Return the normal load as a keyword."""
    normal = task.loads.normal
    assert normal is not None
    return {str(normal.control): float(normal.values[-1])}


def _curves(found: SteadySliding, patches: float) -> dict[str, np.ndarray]:
    """Quantities of lines that each stand for a number of patches, per patch."""
    area = found.contact_area / patches
    return {
        "friction_coefficient": found.friction_coefficient,
        "tangential_force": found.tangential_force / patches,
        "force": found.force / patches,
        "penetration": found.penetration,
        "contact_area": area,
        "contact_area_raw": area,
        "equivalent_radius": np.sqrt(area / np.pi),
        "contact_length": found.contact_length / patches,
        "contact_count": found.contact_count / patches,
    }


class BemFftSliding(BemFft):
    """The half-space under travelling pressure, its unsymmetric contact solved directly."""

    physics = PHYSICS

    def supports(self, scene: Scene) -> Support:
        """Shapes that are no flat faces, and rough surfaces."""
        reason = _refused(scene)
        return Support(not reason, reason)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Cells per half-width of the overlap; points per side of a rough surface."""
        if isinstance(geometry, RoughGeometry):
            return tuple(f * geometry.points[0] for f in (1, 2, 4) if f * geometry.points[0] <= 256)
        finest = 16 * int(np.clip(np.ceil(4 * np.sqrt(0.01 / scene.compare.tolerance)), 2, 6))
        return finest // 4, finest // 2, finest

    def refused(self, task: Task) -> str:
        """Refuse contacts too large to factorise."""
        if not isinstance(task.geometry, RoughGeometry):
            return ""
        normal = task.loads.normal
        assert normal is not None
        geometry, modulus = task.geometry, task.scene.effective_modulus
        cells = task.resolution**2 * geometry.points[1] / geometry.points[0]
        share = 1.0
        if normal.control == "force":
            nominal = modulus * geometry.area * geometry.rms_slope
            share = min(1.0, 2.5 * float(normal.values[-1]) / nominal)
        if cells * share <= LIMIT:
            return ""
        return f"about {cells * share:.0f} cells in contact, of which {LIMIT} can be factorised"

    def memory(self, task: Task) -> float:
        """Bytes of the largest factor, and of the transforms of one grid."""
        cells = 16 * task.resolution**2
        contact = LIMIT if isinstance(task.geometry, RoughGeometry) else 2 * task.resolution**2
        return 16.0 * min(contact, LIMIT) ** 2 + 400.0 * cells

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the domain, and the kernel."""
        return f"{super().model(scene, geometry)}; of pressure that travels over a creeping body"

    def warm_up(self, task: Task) -> None:
        """Compile the contact."""
        material = self._material(task)
        speed = float(task.loads.values[0])
        x = np.linspace(-1.0, 1.0, 8)
        operator = Travelling((8, 8), (0.25, 0.25), material, speed)
        solve(operator, x[:, None] ** 2 + x**2, penetration=0.3)

    def solve(self, task: Task) -> Solution:
        """Slide every realisation at every speed."""
        solution = Solution.empty(task)
        for row, realisation in enumerate(task.realisations):
            before: SlidingContact | None = None
            for step, speed in enumerate(task.loads.values):
                try:
                    found = self._slid(task, realisation, float(speed), before)
                except ConvergenceError as error:
                    solution.fail((row, step), error.reason)
                    continue
                before = found
                values = _quantities(found, task)
                solution.put((row, step), values | {"speed": float(speed)})
                solution.violation[row, step] = found.violation
                solution.iterations[row, step] = found.rounds
                solution.unknowns = max(solution.unknowns, int(found.mask.sum()))
        return solution

    @staticmethod
    def _material(task: Task) -> GeneralisedMaxwell:
        factor, body = _relative_stiffness(task.scene), material_of(task.scene)
        return GeneralisedMaxwell(
            factor * body.equilibrium_modulus,
            factor * body.arm_moduli,
            body.arm_times,
            factor * body.viscosity,
        )

    def _slid(
        self, task: Task, realisation: int, speed: float, before: SlidingContact | None
    ) -> SlidingContact:
        """Slide once; a surface's contact starts from the one at the speed before."""
        material, load = self._material(task), _normal(task)
        if isinstance(task.geometry, IndenterGeometry):
            gap, reach = task.geometry.indenter.gap, task.geometry.indenter.reach
            depth = window_depth(gap, reach, material, speed, **load)
            cells = 2 * task.resolution
            return slide_shape(gap, reach(depth), material, speed, cells, **load)
        grid = make_grid(task.geometry, task.resolution, realisation)
        operator = Travelling(
            *(grid.gap.shape, grid.spacing, material, speed), periodic=task.geometry.periodic
        )
        return solve(operator, grid.gap, start=None if before is None else before.mask, **load)


def _quantities(found: SlidingContact, task: Task) -> dict[str, float]:
    spacing = found.operator.spacing
    area = float(areas.corrected_area(found.mask, spacing, periodic=found.operator.periodic))
    return {
        "friction_coefficient": found.friction_coefficient,
        "tangential_force": found.tangential_force,
        "force": found.force,
        "penetration": found.penetration,
        "contact_area": area,
        "contact_area_raw": float(areas.raw_area(found.mask, spacing)),
        "equivalent_radius": float(np.sqrt(area / np.pi)),
    }


WIRINGS = (ReducedSliding(), BemFftSliding())
