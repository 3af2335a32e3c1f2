"""The method `reduced`: the model under test, a profile on independent springs."""

from __future__ import annotations

from functools import partial

import numpy as np

from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.prepare import IndenterGeometry, equivalent_profile
from comparisons.methods.normal.radial import profile_fields, unit_rings
from comparisons.methods.normal.reduced_bed import bed_of
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.options import ReducedOptions
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.loads import Load
from reduced.profiles import equivalents
from reduced.springs import stress
from reduced.springs.indent import Indentation, indent
from reduced.springs.line import Springs

NO_PLANE = "the contact is not that of an indenter on a plane surface"


class ReducedProfile(Solver[IndenterGeometry]):
    """Method of dimensionality reduction (chapter 19; Popov & Hess 2015)."""

    name = "reduced"
    bodies = True
    depths = True
    options_read = frozenset({"rule", "stress", "edges", "layers"})
    # Why a scene without an indenter is none for this physics.
    only_indenters = NO_PLANE

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.options = scene.methods.reduced
        self.indenter = needed(scene.indenter, self.only_indenters if scene.rough else NO_PLANE)
        self.profile = _profile(self.indenter, self.options)
        self.modulus = scene.effective_modulus
        self.rule = _rule(self.indenter, self.options)
        self.bed = bed_of(scene, self.profile)
        self.note = "; ".join(filter(None, [self.rule, self.bed.note]))
        if not self.bed.layered:
            self.options_read -= {"layers"}
        if not self.indenter.axisymmetric:  # whose pressure a line does not tell
            self.options_read -= {"stress"}
        if scene.body is not None:
            self.note = "treats the [body] as a half-space; its error includes this approximation"

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Indenters: rough surfaces become lines."""
        return not scene.rough

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Springs per contact radius."""
        finest = int(np.clip(40 * np.sqrt(0.01 / self.scene.compare.tolerance), 40, 1000))
        return finest // 4, finest // 2, finest

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        """Refuse bodies whose surface is no plane."""
        geometry = task.geometry
        return NO_PLANE if isinstance(geometry, BodyGeometry) and not geometry.flat_surface else ""

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the springs."""
        return 130.0 * task.resolution

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line."""
        return f"an equivalent 1-D profile on springs of stiffness {self.bed.springs}; {self.note}"

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs of a profile."""
        small = equivalents.power_law(4.0, 1.0)
        springs = Springs(small, 1.0, per_radius=4, edges=self.options.edges)
        indent(springs, Load(task.loads.control, [0.5, 1.0]))

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Press the profile to all loads at once."""
        load = Load(task.loads.control, task.loads.values)
        contact = self.bed.press(load, task.resolution, self.options.edges)
        radius = np.asarray(contact.contact_radius)
        curves = {
            "penetration": contact.penetration,
            "force": contact.force,
            "equivalent_radius": radius,
            "contact_length": 2 * radius,
            "stiffness": contact.stiffness,
            "energy": contact.energy,
        }
        if not np.isfinite(contact.energy).all():
            del curves["energy"]
        solution = Solution.of(task, curves, unknowns=int(contact.springs))
        solution.fields = self._fields(task, contact)
        if self._has_pressure(task):
            for step, depth in enumerate(contact.penetration):
                build = partial(self._radial, float(depth), float(radius[step]))
                solution.keep((0, step), build)
        return solution

    def _fields(self, task: Task[IndenterGeometry], contact: Indentation) -> dict[str, np.ndarray]:
        depth, radius = float(contact.penetration[-1]), float(contact.contact_radius[-1])
        fields = line_picture(self.profile, depth, radius, contact.spacing)
        return fields | (self._radial(depth, radius) if self._has_pressure(task) else {})

    def _has_pressure(self, task: Task[IndenterGeometry]) -> bool:
        """Tell whether a pressure is asked for and exists: a map from 1-D does for round bodies."""
        return task.wants_pressure and self.indenter.axisymmetric and self.bed.uniform

    def _radial(self, depth: float, radius: float) -> dict[str, np.ndarray]:
        r = radius * unit_rings()[0]
        return profile_fields(radius, radius, r, self._pressure(depth, r))

    def _pressure(self, depth: float, r: np.ndarray) -> np.ndarray:
        if self.options.stress == "abel":
            return np.asarray(stress.abel(self.profile, self.bed.modulus, depth, r))
        if self.options.stress == "one_radius":
            return np.asarray(stress.one_radius_rule(self.profile, self.bed.modulus, depth, r))
        pressure, valid = stress.local_rule(self.profile, self.bed.modulus, depth, r)
        # Where the rule has no real value there is no pressure to show: NaN, and the report counts
        # it.
        return np.where(valid, pressure, np.nan)


def _rule(indenter: Indenter, options: ReducedOptions) -> str:
    if options.rule == "half_radius":
        return "half the radius of curvature (19.17), for any shape"
    if indenter.axisymmetric:
        return "exact transform (MDR) of the axisymmetric profile"
    if indenter.flat:
        return "circle of equal area, D = (4 A/pi)^(1/2)"
    return "Gaussian radius of curvature sqrt(Rx Ry)"


def _profile(indenter: Indenter, options: ReducedOptions) -> equivalents.Profile:
    """Return the 1-D profile of an indenter, by the rule of the options."""
    profile = equivalent_profile(indenter)
    if options.rule == "mdr":
        return profile
    if profile.section is None:
        raise Refused("the half-radius rule needs an axisymmetric section")
    return equivalents.half_radius(profile.section)


def line_picture(
    profile: equivalents.Profile, penetration: float, contact_radius: float, spacing: float
) -> dict[str, np.ndarray]:
    """Return the fields that the report draws the one-dimensional model from."""
    x = np.linspace(-1.5, 1.5, 301) * contact_radius
    x = x[np.abs(x) <= profile.edge]
    return {
        "penetration": np.array(penetration),
        "profile_x": x,
        "profile_height": np.asarray(profile.height(np.abs(x))),
        "profile_spacing": np.array(spacing),
    }
