"""Whether a scene is one of contact mechanics at all, or has a number without its unit.

`youngs_modulus = 210` are 210 Pa, and a model within 1 % of a solver that is asked the same is no
help: both hold for small slopes only. The plan, the terminal and the report question what leaves
them. Roughness has its own limits, see `comparisons.geometry.roughness`.
"""

from __future__ import annotations

from comparisons.formatting import number, with_unit
from comparisons.geometry.prepare import Geometry, IndenterGeometry
from comparisons.scene.scene import Scene

# How a note begins that the terminal repeats after a run: the reader has something to check.
CHECK = "check the "
# E* of the softest gels that are pressed, and above that of diamond on diamond.
SOFTEST, STIFFEST = 1e3, 2e12
# Penetration over contact radius: a/R of a paraboloid, the mean slope of a body where it touches.
# At 0.3 a parabola misses its ball by 2 % of the depth, and strains are some 0.2 x 0.3.
STEEPEST = 0.3
# Nothing elastic is pressed in deeper than the contact is wide.
DEEPEST = 2.0


def scene_notes(scene: Scene, geometry: Geometry) -> list[str]:
    """Return what is to be checked in a scene: units, and whether slopes are small."""
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
