"""Plausibility of a scene: units, and the limits of linear contact mechanics.

`youngs_modulus = 210` means 210 Pa, and a reduced model that agrees with a 3-D solver to 1 % proves
nothing if the slopes are large, because both assume small slopes. The plan, the terminal and the
report therefore question implausible values. For roughness see `comparisons.geometry.roughness`.
"""

from __future__ import annotations

from comparisons.formatting import number, with_unit
from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.scene.scene import Scene

# First word of notes that ask the reader to check something; the terminal repeats them after a run.
CHECK = "check the "
# E* below the softest gels in indentation tests, and above diamond on diamond.
SOFTEST, STIFFEST = 1e3, 2e12
# Penetration over contact radius: a/R of a paraboloid, the mean slope of a body in the contact. At
# 0.3 a paraboloid differs from a ball by 2 % of the penetration, and strains are about 0.2 x 0.3.
STEEPEST = 0.3
# No elastic contact is deeper than wide.
DEEPEST = 2.0


def scene_notes(scene: Scene, geometry: Geometry) -> list[str]:
    """Return notes on doubtful units and large slopes in a scene."""
    doubts, slopes = _of_modulus(scene.effective_modulus), []
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
    units = [f"{CHECK}units of the scene: {'; '.join(doubts)}"] if doubts else []
    return units + slopes


def _of_modulus(modulus: float) -> list[str]:
    stated = f"E* = {with_unit(modulus, 'Pa')}"
    if modulus < SOFTEST:
        return [f"{stated} is softer than any gel ({with_unit(SOFTEST, 'Pa')})"]
    if modulus > STIFFEST:
        return [f"{stated} is stiffer than diamond ({with_unit(STIFFEST, 'Pa')})"]
    return []
