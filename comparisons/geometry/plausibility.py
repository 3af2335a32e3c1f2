"""Plausibility of a scene: units, and the limits of linear contact mechanics.

`youngs_modulus = 210` means 210 Pa, and a reduced model that agrees with a 3-D solver to 1 % proves
nothing if the slopes are large, because both assume small slopes. The notes of the plan therefore
question implausible values, and whoever has a plan shows them. For roughness see
`comparisons.geometry.roughness`.
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from comparisons.formatting import number, relative, with_unit
from comparisons.geometry.prepare import Geometry, IndenterGeometry, equivalent_profile
from comparisons.scene.scene import Scene

# First word of notes that ask the reader to check something (`doubtful`).
CHECK = "check the "
# E* below the softest gels in indentation tests, and above diamond on diamond.
SOFTEST, STIFFEST = 1e3, 2e12
# Penetration over contact radius: a/R of a paraboloid, the mean slope of a body in the contact. At
# 0.3 a paraboloid differs from a ball by 2 % of the penetration, and strains are about 0.2 x 0.3.
STEEPEST = 0.3
# No elastic contact is deeper than wide.
DEEPEST = 2.0
# Wheels and tyres slip all over at a creep of 0.01 to 0.2; 1 is a locked wheel.
LARGEST_CREEP = 0.2


def doubtful(notes: Iterable[str]) -> list[str]:
    """Return those of a plan's notes that question the scene: a reader must see them first."""
    return [note for note in notes if note.startswith(CHECK)]


def scene_notes(scene: Scene, geometry: Geometry) -> list[str]:
    """Return notes on doubtful units and large slopes in a scene."""
    doubts, slopes = [*_of_modulus(scene.effective_modulus), *_of_physics(scene)], []
    if isinstance(geometry, IndenterGeometry):
        depth, radius = geometry.penetration, geometry.contact_radius
        if depth > STEEPEST * radius > 0:  # NaN is no contact
            stated = (
                f"a penetration of {with_unit(depth, 'm')} is {number(depth / radius)} times the "
                f"contact radius of {with_unit(radius, 'm')}"
            )
            slopes.append(
                f"{CHECK}slopes: {stated}; every method here holds for small slopes and strains "
                f"(below some {number(STEEPEST, 1)}), and their agreement says nothing beyond"
            )
            if depth > DEEPEST * radius:
                doubts.append("the contact is deeper than wide")
        elif scene.adhesion is not None and (times := _without_adhesion(geometry)) > STEEPEST:
            slopes.append(
                f"{CHECK}slopes, and the work of adhesion: it opens a contact of radius "
                f"{with_unit(radius, 'm')}, which without it takes a penetration of "
                f"{number(times)} times that; every method here holds below some "
                f"{number(STEEPEST, 1)}"
            )
    units = [f"{CHECK}units of the scene: {'; '.join(doubts)}"] if doubts else []
    return units + slopes


def _of_modulus(modulus: float) -> list[str]:
    stated = f"E* = {with_unit(modulus, 'Pa')}"
    if modulus < SOFTEST:
        return [f"{stated} is softer than any gel ({with_unit(SOFTEST, 'Pa')})"]
    if modulus > STIFFEST:
        return [f"{stated} is stiffer than diamond ({with_unit(STIFFEST, 'Pa')})"]
    return []


def _of_physics(scene: Scene) -> list[str]:
    doubts = []
    if scene.rolling is not None:
        creep = max(map(abs, (*scene.rolling.creep.values, *scene.rolling.lateral_creep.values)))
        if creep > LARGEST_CREEP:
            doubts.append(
                f"a creep of {number(creep)} is {relative(creep)} of the speed (wheels slip below "
                f"{relative(LARGEST_CREEP)}, at 100 % they are locked)"
            )
    if scene.plasticity is not None:
        slope, modulus = scene.plasticity.hardening, scene.half_space.elastic_constants[0]
        if slope > modulus:
            doubts.append(
                f"a hardening of {with_unit(slope, 'Pa')} is steeper than E = "
                f"{with_unit(modulus, 'Pa')} (metals harden by less than a tenth of it)"
            )
    return doubts


def _without_adhesion(geometry: IndenterGeometry) -> float:
    """Return penetration over radius of a contact as wide, pressed without adhesion; flat: 0."""
    profile, radius = equivalent_profile(geometry.indenter), geometry.contact_radius
    if not radius < profile.edge:
        return 0.0
    return float(profile.height(np.array([radius]))[0]) / radius
