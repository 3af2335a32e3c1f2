"""The method `reduced`: the model under test, a profile on independent springs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.estimates import elastic_body, grading_of
from comparisons.geometry.prepare import IndenterGeometry, equivalent_profile
from comparisons.methods.normal.closed_form import profile_fields, unit_rings
from comparisons.methods.runner import run
from comparisons.methods.solver import Refused, Solver, needed
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.task import Task
from reduced.errors import ConvergenceError
from reduced.loads import Load
from reduced.profiles import equivalents
from reduced.springs import stress
from reduced.springs.indent import Indentation, indent
from reduced.springs.layers import Coatings, Grading
from reduced.springs.line import Springs
from reference.layered.stack import Stack

# Rounds in which a force finds the radius that its own modulus depends on.
_ROUNDS = 200
_SETTLED = 1e-13


@dataclass(frozen=True)
class Bed:
    """The springs under a profile."""

    profile: equivalents.Profile
    modulus: float  # E* of all springs; of a graded body that of the springs at its depth c0
    # Their stiffness in words, and by which reading.
    springs: str = "E* dx"
    note: str = ""
    coatings: Coatings | None = None  # from which the modulus of each contact follows
    grading: Grading | None = None

    @property
    def uniform(self) -> bool:
        """Whether springs know one modulus, so that a pressure follows from them."""
        return self.coatings is None and self.grading is None

    def press(self, load: Load, per_radius: int, edges: str) -> Indentation:
        """Press the profile on the springs, at all loads at once."""
        if self.grading is not None:
            assert self.profile.section is not None
            even = self.grading.profile(self.profile.section)
            contact = indent(Springs(even, self.modulus, per_radius, edges=edges), load)
            return replace(contact, contact_radius=self.grading.place(contact.contact_radius))
        if self.coatings is None:
            return indent(Springs(self.profile, self.modulus, per_radius, edges=edges), load)
        # Springs of unit modulus; each contact has the modulus of its radius.
        springs = Springs(self.profile, 1.0, per_radius, edges=edges)
        moduli = np.ones(load.values.size)
        for _ in range(_ROUNDS):
            values = load.values / moduli if load.control == "force" else load.values
            contact = indent(springs, Load(load.control, values))
            before, moduli = moduli, self.coatings.modulus(contact.contact_radius)
            if load.control != "force" or np.abs(moduli / before - 1).max() <= _SETTLED:
                return replace(
                    contact,
                    force=contact.force * moduli,
                    stiffness=contact.stiffness * moduli,
                    # no potential: the modulus changes with the radius
                    energy=np.full_like(moduli, np.nan),
                )
        raise ConvergenceError("no radius has the modulus that its force asks for", [])


def bed_of(scene: Scene, profile: equivalents.Profile) -> Bed:
    """Return the springs for a scene's elastic body, by the reading of its options."""
    table = scene.half_space
    if table.grading is not None:
        if profile.section is None or scene.methods.reduced.rule != "mdr":
            raise Refused("springs for a graded half-space are known under bodies of revolution")
        grading, law = grading_of(scene), "c_N |x/c0|^k dx"
        note = "springs graded with the distance from the axis (Hess 2016)"
        return Bed(profile, grading.spring_modulus, law, note, grading=grading)
    if table.uniform:
        return Bed(profile, scene.effective_modulus)
    reading, body = scene.methods.reduced.layers, elastic_body(scene)
    assert isinstance(body, Stack)
    if reading == "effective":
        moduli = [material.effective_modulus for material in body.materials]
        base = np.inf if body.base is None else body.base.effective_modulus
        coatings = Coatings(body.thicknesses, moduli, base, body.top.poisson_ratio)
        note = "one modulus for each contact radius (Xu & Pharr 2006)"
        return Bed(profile, coatings.base, "E*(a) dx", note, coatings)
    lowest = "substrate" if body.base is not None else "layer on the rigid base"
    modulus, note = scene.effective_modulus, f"layers read as a half-space of the {lowest}"
    if reading == "layer":
        modulus, note = (
            body.top.effective_modulus,
            "layers read as a half-space of the uppermost one",
        )
    return Bed(profile, modulus, "E* dx", note)


# That compile everything.
_FEW_SPRINGS = 4
NO_PLANE = "the contact is not that of an indenter on a plane surface"


class ProfileSolver(Solver[IndenterGeometry]):
    """An equivalent profile on springs, whatever happens to it: what all physics share."""

    bodies = True
    rough = False  # rough surfaces become lines
    depths = True
    # What the physics adds to the model, in words.
    beside = ""
    # Why a scene without an indenter is none for this physics.
    only_indenters = NO_PLANE

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, self.only_indenters if scene.rough else NO_PLANE)
        rule = scene.methods.reduced.rule
        self.profile = equivalent_profile(self.indenter)
        if rule == "half_radius":
            if self.profile.section is None:
                raise Refused("the half-radius rule needs an axisymmetric section")
            self.profile = equivalents.half_radius(self.profile.section)
            read = "half the radius of curvature (19.17), for any shape"
        elif self.indenter.axisymmetric:
            read = "exact transform (MDR) of the axisymmetric profile"
        elif self.indenter.flat:
            read = "circle of equal area, D = (4 A/pi)^(1/2)"
        else:
            read = "Gaussian radius of curvature sqrt(Rx Ry)"
        self.modulus = scene.effective_modulus
        self.bed = bed_of(scene, self.profile)
        self.note = "; ".join(filter(None, [read, self.bed.note]))
        if scene.body is not None:
            self.note = "treats the [body] as a half-space; its error includes this approximation"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Springs per contact radius."""
        return self.series(40, 40, 1000)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        geometry = task.geometry
        return NO_PLANE if isinstance(geometry, BodyGeometry) and not geometry.flat_surface else ""

    def memory(self, task: Task[IndenterGeometry]) -> float:
        return 130.0 * task.resolution

    def model(self, geometry: IndenterGeometry) -> str:
        text = f"an equivalent 1-D profile on springs of stiffness {self.bed.springs}; {self.note}"
        return f"{text}; {self.beside}" if self.beside else text

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs: a few of them solve the task, whatever becomes of it."""
        run(self, replace(task, resolution=_FEW_SPRINGS, with_body=False))


class ReducedProfile(ProfileSolver):
    """Method of dimensionality reduction (chapter 19; Popov & Hess 2015)."""

    name = "reduced"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.edges = scene.methods.reduced.edges
        # The pressure below other outlines is no function of the line.
        self.stress = scene.methods.reduced.stress if self.indenter.axisymmetric else None

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        load = Load(task.loads.control, task.loads.values)
        contact = self.bed.press(load, task.resolution, self.edges)
        depths, radii = contact.penetration, np.asarray(contact.contact_radius)
        curves = {
            "penetration": depths,
            "force": contact.force,
            "equivalent_radius": radii,
            "contact_length": 2 * radii,
            "stiffness": contact.stiffness,
            "energy": contact.energy,
        }
        if not np.isfinite(contact.energy).all():
            del curves["energy"]
        solution = Solution.of(task, curves, unknowns=int(contact.springs))
        last = float(depths[-1]), float(radii[-1])
        solution.fields = line_picture(self.profile, *last, contact.spacing)
        if task.wants_pressure and self.stress is not None and self.bed.uniform:
            solution.fields |= self._pressure(*last)
            for step, (depth, radius) in enumerate(zip(depths, radii, strict=True)):
                solution.keep(task, (0, step), partial(self._pressure, float(depth), float(radius)))
        return solution

    def _pressure(self, depth: float, radius: float) -> dict[str, np.ndarray]:
        r = radius * unit_rings()[0]
        contact = self.profile, self.bed.modulus, depth, r
        if self.stress == "abel":
            pressure = stress.abel(*contact)
        elif self.stress == "one_radius":
            pressure = stress.one_radius_rule(*contact)
        else:
            pressure, valid = stress.local_rule(*contact)
            # Where the rule has no real value there is no pressure to show: NaN, and the report
            # counts it.
            pressure = np.where(valid, pressure, np.nan)
        return profile_fields(radius, radius, r, np.asarray(pressure))


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
