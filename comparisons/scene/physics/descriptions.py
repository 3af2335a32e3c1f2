"""What the plan says about a scene's physics: what is switched on, and what is left out and why."""

from __future__ import annotations

from collections.abc import Iterable
from typing import TYPE_CHECKING

from comparisons.facts.quantities import quantity
from comparisons.formatting import given
from comparisons.scene.physics.loads import Loads

if TYPE_CHECKING:
    from comparisons.scene.physics import Viscoelastic
    from comparisons.scene.scene import Scene


def switched_on(scene: Scene, loads: Loads) -> Iterable[tuple[str, str]]:
    """Yield each part of the physics beyond frictionless elastic contact, and how it acts."""
    if scene.friction is not None:
        yield (
            "Coulomb friction",
            f"µ = {given(scene.friction.coefficient, '')}, sticking and slipping",
        )
    if scene.viscoelastic is not None:
        yield "memory of the material", _material(scene.viscoelastic, scene.poisson_ratio)
    if scene.sliding is not None:
        yield "steady sliding", "each speed by itself, after every start has been forgotten"
    if scene.adhesion is not None:
        work = given(scene.adhesion.work, "J/m²")
        short = "at the edge of the contact only (JKR)"
        reach = f"up to a distance of {given(scene.adhesion.range, 'm')}"
        yield "adhesion", f"w = {work}, {short if scene.adhesion.short_range else reach}"
    if scene.dynamics is not None:
        yield "inertia", f"of a rigid mass of {_mass(scene.dynamics.mass)}; the half-space has none"
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
        what = "the drag of pressing along the surface, in the reduced model"
        yield what, "its normal and tangential springs act apart, which is so at ν = 1/2 only"
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
    what = quantity(loads.control).words
    if loads.axis == "step":
        text = f"a path of {steps} steps in {what}"
    elif loads.axis == "time":
        history = "" if loads.control == "time" else f" of {what}"
        text = f"a history{history} in {steps} times"
    else:
        text = f"{steps} values of {what}, each by itself"
    if loads.normal is None:
        return text
    normal = quantity(loads.normal.control)
    return f"{text}, at {normal.words} {given(float(loads.normal.values[0]), normal.unit)}"


def _material(body: Viscoelastic, nu: float) -> str:
    """Name the model with its moduli and times."""
    lasting = given(body.long_term_modulus, "Pa")
    parts = [
        f"{given(modulus, 'Pa')} relaxing in {given(time, 's')}" for modulus, time in body.branches
    ]
    if body.dashpot_viscosity:
        parts = [f"a dashpot of {given(body.dashpot_viscosity, 'Pa s')}"]
    name = body.model.replace("_", "-")
    return f"{name}: G = {lasting} for good, and {', '.join(parts)}; ν = {given(nu, '')}"


def _mass(mass: float) -> str:
    return given(1e3 * mass, "g")
