"""What the plan says about a scene's physics: what is switched on, and what is left out and why."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from comparisons.facts.quantities import quantity
from comparisons.formatting import unpadded
from comparisons.scene.physics.loads import Loads

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene


def switched_on(scene: Scene, loads: Loads) -> Iterable[tuple[str, str]]:
    """Yield each part of the physics beyond frictionless elastic contact, and how it acts."""
    for name in scene.physics:
        yield getattr(scene, name).description(scene)
    if scene.physics:
        yield "load axis", _axis(loads)


def left_out(scene: Scene) -> Iterable[tuple[str, str]]:
    """Yield the physics that a scene leaves out, with the reason."""
    if scene.viscoelastic is None:
        yield "memory of the material", "the scene is elastic: nothing relaxes"
    if scene.friction is None and scene.sliding is None:
        yield "tangential displacements at the surface", "no friction in the scene"
    if not scene.physics:
        return
    if scene.friction is not None and scene.poisson_ratio != 0.5:
        effect = "the drag of pressing along the surface, in the reduced model"
        yield effect, "its normal and tangential springs act apart, which is so at ν = 1/2 only"
    if scene.adhesion is None:
        yield "attraction of the surfaces", "no [adhesion] in the scene: they never pull"
    if scene.dynamics is None:
        yield "inertia", "no [dynamics] in the scene: the loads are slow"
    else:
        yield "waves in the half-space", "the impact is slow against them: its answer is static"
    if scene.sliding is not None:
        yield "Coulomb friction at the surface", "the loss is that of the body alone"


def _axis(loads: Loads) -> str:
    """Say what the steps are, and at which normal load."""
    steps = len(loads.values)
    control_label = quantity(loads.control).label
    if loads.axis == "step":
        text = f"a path of {steps} steps in {control_label}"
    elif loads.axis == "time":
        history = "" if loads.control == "time" else f" of {control_label}"
        text = f"a history{history} in {steps} times"
    else:
        text = f"{steps} values of {control_label}, each by itself"
    if loads.normal is None:
        return text
    normal = quantity(loads.normal.control)
    return f"{text}, at {normal.label} {unpadded(float(loads.normal.values[0]), normal.unit)}"
