"""What the springs of the reduced model stand for: a half-space, layers, a graded body."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from comparisons.geometry.elastic_body import elastic_body
from comparisons.geometry.estimates import grading_of
from comparisons.methods.solver import Refused
from comparisons.scene.scene import Scene
from reduced.errors import ConvergenceError
from reduced.loads import Load
from reduced.profiles import equivalents
from reduced.profiles.graded import Grading
from reduced.springs.coating import Coatings
from reduced.springs.indent import Indentation, indent
from reduced.springs.line import Springs
from reference.layered.stack import Stack, plane_modulus

# Rounds in which a force finds the radius that its own modulus depends on.
_ROUNDS = 200
_SETTLED = 1e-13


@dataclass(frozen=True)
class Bed:
    """The springs under a profile.

    Attributes
    ----------
    profile : Profile
    modulus : float
        E* of all springs; of a graded body that of the springs at its depth c0.
    springs, note : str
        Their stiffness in words, and by which reading.
    coatings : Coatings, optional
        From which the modulus of each contact follows.
    grading : Grading, optional
    layered : bool
        Whether it is a reading of layers.
    """

    profile: equivalents.Profile
    modulus: float
    springs: str = "E* dx"
    note: str = ""
    coatings: Coatings | None = None
    grading: Grading | None = None
    layered: bool = False

    @property
    def uniform(self) -> bool:
        """Whether springs know one modulus, so that a pressure follows from them."""
        return self.coatings is None and self.grading is None

    def press(self, load: Load, per_radius: int, edges: str) -> Indentation:
        """Press the profile on the springs, at all loads at once."""
        if self.grading is not None:
            even = self.grading.profile(self._section)
            contact = indent(Springs(even, self.modulus, per_radius, edges=edges), load)
            return replace(contact, contact_radius=self.grading.place(contact.contact_radius))
        springs = Springs(self.profile, 1.0, per_radius, edges=edges)
        if self.coatings is None:
            return indent(replace(springs, effective_modulus=self.modulus), load)
        return _of_its_radius(springs, load, self.coatings)

    @property
    def _section(self) -> equivalents.Section:
        assert self.profile.section is not None
        return self.profile.section


def bed_of(scene: Scene, profile: equivalents.Profile) -> Bed:
    """Return the springs for a scene's elastic body, by the reading of its options.

    Raises
    ------
    Refused
        For a shape that is not of revolution on a graded body.
    """
    table, reading = scene.half_space, scene.methods.reduced.layers
    if table.grading is not None:
        if profile.section is None or scene.methods.reduced.rule != "mdr":
            raise Refused("springs for a graded half-space are known under bodies of revolution")
        grading, law = grading_of(scene), "c_N |x/c0|^k dx"
        note = "springs graded with the distance from the axis (Hess 2016)"
        return Bed(profile, grading.spring_modulus, law, note, grading=grading)
    if table.uniform:
        return Bed(profile, scene.effective_modulus)
    return _of_layers(scene, profile, reading)


def _of_layers(scene: Scene, profile: equivalents.Profile, reading: str) -> Bed:
    body = elastic_body(scene)
    assert isinstance(body, Stack)
    if reading == "effective":
        moduli = [plane_modulus(material) for material in body.materials]
        base = np.inf if body.base is None else plane_modulus(body.base)
        coatings = Coatings(body.thicknesses, moduli, base, body.top.poisson_ratio)
        note = "one modulus for each contact radius (Xu & Pharr 2006)"
        return Bed(profile, coatings.base, "E*(a) dx", note, coatings, layered=True)
    lowest = "substrate" if body.base is not None else "layer on the rigid base"
    modulus, note = scene.effective_modulus, f"layers read as a half-space of the {lowest}"
    if reading == "layer":
        modulus, note = plane_modulus(body.top), "layers read as a half-space of the uppermost one"
    return Bed(profile, modulus, "E* dx", note, layered=True)


def _of_its_radius(springs: Springs, load: Load, coatings: Coatings) -> Indentation:
    """Press springs of unit modulus, and give each contact the modulus of its radius."""
    moduli = np.ones(load.values.size)
    for _ in range(_ROUNDS):
        values = load.values / moduli if load.control == "force" else load.values
        contact = indent(springs, Load(load.control, values))
        before, moduli = moduli, coatings.modulus(contact.contact_radius)
        if load.control != "force" or np.abs(moduli / before - 1).max() <= _SETTLED:
            return replace(
                contact,
                force=contact.force * moduli,
                stiffness=contact.stiffness * moduli,
                # no potential: the modulus changes with the radius
                energy=np.full_like(moduli, np.nan),
            )
    raise ConvergenceError("no radius has the modulus that its force asks for", [])
