"""What the methods for yielding half-spaces share: the table, and which shape presses."""

from __future__ import annotations

from comparisons.methods.solver import Refused, needed
from comparisons.scene.indenters import Indenter
from comparisons.scene.physics.tables.plasticity import Plasticity
from comparisons.scene.scene import Scene
from reference.plastic.materials import yield_depth, yield_pressure

PHYSICS = frozenset({"plasticity"})
ONLY_INDENTERS = "for single indenters on a plane"


def tables_of(scene: Scene) -> tuple[Indenter, Plasticity]:
    """Return what presses, and the table.

    Raises
    ------
    Refused
        If it is no indenter, or a flat one, under whose edge the stress has no bound.
    """
    indenter = needed(scene.indenter, ONLY_INDENTERS)
    if indenter.flat:
        raise Refused("under a flat face the edge yields at first touch")
    return indenter, needed(scene.plasticity, "no [plasticity]")


def radius_of(indenter: Indenter) -> float:
    """Return the radius of a ball.

    Raises
    ------
    Refused
        If it is none.
    """
    if indenter.shape not in ("sphere", "paraboloid"):
        raise Refused("for spheres and paraboloids only")
    return float(indenter.parameters["radius"])


def depth_of_yield(scene: Scene, radius: float) -> float:
    """Return the penetration at which a ball first makes the half-space yield.

    That of the pressure of Hertz's contact below which von Mises' stress first reaches Y (Johnson
    1985, 6.1).
    """
    plasticity = needed(scene.plasticity, "no [plasticity]")
    pressure = yield_pressure(scene.poisson_ratio) * plasticity.yield_stress
    return yield_depth(radius, scene.effective_modulus, pressure)
