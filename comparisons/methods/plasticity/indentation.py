"""What the methods for an indenter on a yielding half-space share: material, shape, first yield."""

from __future__ import annotations

import numpy as np

from comparisons.methods.solver import Refused, needed
from comparisons.scene.indenters.ellipsoid import Ellipsoid
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.physics.tables.plasticity import Plasticity
from comparisons.scene.scene import Scene
from reduced.loads import Load
from reduced.profiles.equivalents import Profile
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference.closed_form import ellipsoid
from reference.elasticity import Material
from reference.plastic import PlasticMaterial, yield_depth, yield_pressure
from reference.plastic.first_yield import elliptic_yield_pressure

PHYSICS = frozenset({"plasticity"})
ONLY_INDENTERS = "for single indenters on a plane"
# Mean pressures over Y at which a contact first yields, and beyond which it is fully plastic.
FIRST_PRESSURE, _FULL_PRESSURE = 1.07, 2.7


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


def depth_of_yield(scene: Scene) -> float:
    """Return the penetration at which an indenter first makes the half-space yield.

    That of the pressure of Hertz's contact below which von Mises' stress first reaches Y (Johnson
    1985, 6.1, and the same of ellipses).

    Raises
    ------
    Refused
        If the contact is no ellipse, or one whose stresses have no formula here.
    """
    indenter, plasticity = tables_of(scene)
    nu, modulus = scene.poisson_ratio, scene.effective_modulus
    if not isinstance(indenter, Ellipsoid):
        pressure = yield_pressure(nu) * plasticity.yield_stress
        return yield_depth(radius_of(indenter), modulus, pressure)
    form = ellipsoid(indenter.radius_x, indenter.radius_y, modulus)
    narrow, wide = sorted(float(np.asarray(axis)) for axis in form.semi_axes(1.0))
    largest = 1.5 * float(form.force(1.0)) / (np.pi * narrow * wide)  # goes with the depth's root
    try:
        pressure = elliptic_yield_pressure(nu, narrow / wide) * plasticity.yield_stress
    except ValueError as error:
        raise Refused(f"first yield below ellipses: {error}") from None
    return (pressure / largest) ** 2


def material_of(scene: Scene) -> PlasticMaterial:
    """Return elastic constants, yield stress and hardening of the half-space."""
    plasticity = needed(scene.plasticity, "no [plasticity]")
    exponent = plasticity.hardening_exponent
    return PlasticMaterial(
        Material(*scene.elastic_constants),
        plasticity.yield_stress,
        exponent or plasticity.hardening,
        "power" if exponent else "linear",
    )


def estimated_radius(scene: Scene, profile: Profile, control: str, load: float) -> float:
    """Estimate a contact radius, between that of Hertz and that of a rigid-plastic body."""
    indenter, plasticity = tables_of(scene)
    contact = indent(Springs(profile, scene.effective_modulus), Load(control, load))
    radius, force = float(contact.contact_radius[0]), float(contact.force[0])
    over = force / (np.pi * radius**2) / (FIRST_PRESSURE * plasticity.yield_stress)
    if over <= 1:
        return radius
    if control == "force":
        return max(
            radius, float(np.sqrt(force / (np.pi * _FULL_PRESSURE * plasticity.yield_stress)))
        )
    widest = float(np.sqrt(np.prod(indenter.reach(load))))
    return float(radius * (widest / radius) ** min(1.0, 2 * np.log10(over) / 3))
