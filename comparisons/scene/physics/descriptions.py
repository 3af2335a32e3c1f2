"""Descriptions in the plan: physics switched on, and physics left out with the reason."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from comparisons.facts.quantities import quantity
from comparisons.formatting import number, unpadded, with_unit
from comparisons.scene.physics.absolute_loads import AbsoluteLoads

if TYPE_CHECKING:
    from comparisons.scene.half_space import HalfSpace
    from comparisons.scene.scene import Scene


def switched_on(scene: Scene, loads: AbsoluteLoads) -> Iterable[tuple[str, str]]:
    """Yield each part of the physics beyond frictionless elastic contact, and how it acts."""
    if not scene.half_space.uniform:
        yield "elastic body", _depths(scene.half_space)
    for name in scene.physics:
        yield getattr(scene, name).description(scene.poisson_ratio)
    if scene.physics:
        yield "load axis", _axis(loads)


def left_out(scene: Scene) -> Iterable[tuple[str, str]]:
    """Yield the physics that a scene leaves out, with the reason."""
    if scene.half_space.layers or scene.half_space.thickness is not None:
        yield "slip and gaps between layers", "layers are bonded to what lies below"
    if not scene.physics:
        return  # memory, friction, adhesion and inertia were never in question
    if scene.viscoelastic is None:
        yield "memory of the material", "no [viscoelastic] in the scene: nothing relaxes"
    if scene.friction is None and scene.sliding is None:
        yield "tangential displacements at the surface", "no friction in the scene"
    if scene.friction is not None and scene.poisson_ratio != 0.5:
        effect = "tangential displacements due to pressure, in the reduced model"
        yield (
            effect,
            "its normal and tangential springs are uncoupled, which is exact only at ν = 1/2",
        )
    if scene.adhesion is None:
        yield "attraction of the surfaces", "no [adhesion] in the scene"
    if scene.dynamics is None and not scene.methods.fem.inertia:
        yield "inertia", "no [dynamics] in the scene: loading is quasi-static"
    elif scene.dynamics is not None:
        yield (
            "waves in the half-space",
            "the impact is slow compared with them: the response is quasi-static",
        )
    if scene.sliding is not None:
        yield "Coulomb friction at the surface", "the loss is due to the body alone"


def _depths(body: HalfSpace) -> str:
    """Say what the elastic body consists of, from its surface down."""
    if body.grading is not None:
        law = f"E (z/{with_unit(body.grading.depth, 'm')})^{number(body.grading.exponent)}"
        return f"a half-space graded as {law} at the depth z, E = {_modulus(body)}"
    parts = [
        f"{with_unit(layer.thickness, 'm')} of E = {with_unit(layer.youngs_modulus, 'Pa')}, "
        f"ν = {number(layer.poisson_ratio)}"
        for layer in body.layers
    ]
    main = f"E = {_modulus(body)}, ν = {number(body.nu)}"
    if body.thickness is None:
        return "; ".join([*parts, f"below a half-space of {main}"])
    return "; ".join([*parts, f"{with_unit(body.thickness, 'm')} of {main}", "below a rigid base"])


def _modulus(body: HalfSpace) -> str:
    return with_unit(body.elastic_constants[0], "Pa")


def _axis(loads: AbsoluteLoads) -> str:
    """Say what the steps are, and at which normal load."""
    steps = len(loads.values)
    control_label = quantity(loads.control).label
    if loads.axis == "step":
        text = f"a path of {steps} steps in {control_label}"
    elif loads.axis == "time":
        history = "" if loads.control == "time" else f" of {control_label}"
        text = f"a history{history} in {steps} times"
    else:
        text = f"{steps} independent values of {control_label}"
    if loads.normal is None:
        return text
    normal = quantity(loads.normal.control)
    return f"{text}, at {normal.label} {unpadded(float(loads.normal.values[0]), normal.unit)}"
