"""Estimates of contacts in scenes with physics and on layered or graded bodies, and these bodies.

The estimates are not results. Those with physics use independent springs with the lowest modulus of
the material (in an impact with that of its duration), and take a millisecond.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from comparisons.scene.loading import AbsoluteLoads
from reduced.loads import Load
from reduced.motion.elastic_impact import impact_depth
from reduced.profiles import equivalents
from reduced.profiles.section import Profile
from reduced.springs.indent import indent
from reduced.springs.layers import Grading
from reduced.springs.line import Springs
from reference.elasticity import Material
from reference.layered import Graded, RoundContact, Stack

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene

# Contact radii and penetrations are sought between these fractions and the characteristic length of
# a shape.
SMALLEST, LARGEST = 1e-9, 1e6
# Number of impacts in a list that are estimated individually.
IMPACTS = 12
# Loads that are estimated one by one; between them power laws interpolate.
_SINGLE = 6
# Of the contact radius.
_TOLERANCE = 1e-3
_HALVINGS = 10
# Contacts on layers take a second; plans that differ in what is compared have the same ones.
_known: dict[tuple[str, str, bytes], tuple[np.ndarray, np.ndarray]] = {}
_MOST = 256


def largest_contact(
    scene: Scene, profile: equivalents.Profile, loads: AbsoluteLoads
) -> tuple[float, float]:
    """Return the penetration and contact radius of the largest contact in a scene."""
    if scene.dynamics is not None and loads.control != "force":
        depth = _struck(scene, profile, max(scene.dynamics.velocity.values))
        return depth, float(profile.contact_radius(depth))
    if scene.adhesion is not None:
        # JKR: d = g(a) - l(a), l = pull sqrt(a) (Hess); F = 2 E* (a d - int_0^a g dx)
        modulus, by_depth = scene.effective_modulus, loads.control == "penetration"
        pull = np.sqrt(2 * np.pi * scene.adhesion.work / modulus)
        radii = profile.length * np.geomspace(SMALLEST, LARGEST, 4000)
        radii = np.append(radii[radii < profile.edge], min(profile.edge, radii[-1]))
        load = float(loads.values.max())
        with np.errstate(invalid="ignore"):  # beyond the edge of a shape its height is infinite
            height = np.asarray(profile.height(radii), dtype=float)
            trapezia = 0.5 * (height[1:] + height[:-1]) * np.diff(radii)
            below = np.concatenate([[0.0], np.cumsum(trapezia)])
            depths = height - pull * np.sqrt(radii)
            forces = 2 * modulus * (radii * depths - below)
            within = np.flatnonzero((depths if by_depth else forces) <= load)
        # Of several equilibria the widest counts. If every contact carries more, the load is beyond
        # pull-off, and the smallest one does.
        widest = within[-1] if len(within) else 0
        a = float(radii[widest])
        depth = load if by_depth else 0.5 * load / (modulus * a) + float(below[widest]) / a
        return depth, a
    normal = loads if loads.normal is None else loads.normal
    modulus = scene.effective_modulus
    if scene.viscoelastic is not None and loads.times is not None:
        softest = scene.viscoelastic.softest_modulus(float(loads.times[-1] - loads.times[0]))
        modulus = 2.0 * softest / (1.0 - scene.poisson_ratio)
    largest = float(normal.values.max())
    if largest <= 0:
        raise ValueError("expected at least one positive load")
    contact = indent(Springs(profile, modulus), Load(normal.control, largest))
    depth, radius = float(contact.penetration[0]), float(contact.contact_radius[0])
    if scene.wear is not None and normal.control == "force":
        # It goes deeper by less than a rigid plane would have to cut the worn volume k F s off it;
        # in fretting also by less than the force presses its stick circle alone.
        table, body = scene.wear, profile.section or profile
        slip = 1.0 if table.amplitude is None else 4 * table.amplitude
        goal, first = table.coefficient * largest * slip * float(loads.values[-1]), radius
        while _cut(body, radius)[1] < goal and radius < profile.edge:
            radius = min(1.02 * radius, profile.edge)
        cut, volume = _cut(body, radius)
        cut += max(goal - volume, 0.0) / (np.pi * radius**2)
        if scene.friction is not None and table.amplitude is not None:
            modulus = scene.effective_modulus
            ratio = scene.tangential_modulus / (scene.friction.coefficient * modulus)
            stuck = depth - ratio * table.amplitude
            if stuck > 0:
                circle = float(profile.contact_radius(stuck))
                cut = min(cut, 0.5 * largest / (modulus * circle))
                radius = first
        depth += cut
    return depth, radius


def impact_contacts(
    scene: Scene, profile: equivalents.Profile, velocities: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return the penetrations and contact radii of impacts at increasing velocities.

    Some velocities are estimated; between them, power laws interpolate.
    """
    few = velocities[np.unique(np.linspace(0, velocities.size - 1, IMPACTS).round().astype(int))]
    depths = np.array([_struck(scene, profile, speed) for speed in few])
    between = np.interp(np.log(velocities), np.log(few), np.log(depths))
    depth = np.exp(between)
    return depth, np.asarray(profile.contact_radius(depth))


def _struck(scene: Scene, profile: equivalents.Profile, speed: float) -> float:
    """Return the penetration of an impact; rubber has the modulus of a strain that grows as fast.

    That modulus falls slower than 1/d as the depth d grows, and the depth rises with at most
    the root of the softness: each round halves the error.
    """
    assert scene.dynamics is not None
    energy = 0.5 * scene.dynamics.mass * speed**2
    depth = impact_depth(profile, scene.effective_modulus, energy)
    if scene.viscoelastic is not None:
        for _ in range(_HALVINGS):
            modulus = 2 * scene.viscoelastic.ramp_modulus(depth / speed) / (1 - scene.poisson_ratio)
            depth = impact_depth(profile, modulus, energy)
    return depth


def _cut(body: equivalents.Section, radius: float) -> tuple[float, float]:
    """Return height and volume of what a plane cuts off a body of revolution at a radius."""
    r = radius * np.linspace(0.0, 1.0, 200)
    height = np.asarray(body.height(r), dtype=float)
    volume = np.trapezoid(2 * np.pi * r * (height[-1] - height), r)
    return float(height[-1]), float(volume)


def elastic_body(scene: Scene) -> Stack | Graded:
    """Return the layers or the grading of a scene; a half-space is a stack without layers."""
    table = scene.half_space
    material = Material(*table.elastic_constants)
    if table.grading is not None:
        return Graded(material, table.grading.exponent, table.grading.depth)
    thicknesses = [layer.thickness for layer in table.layers]
    materials = [Material(layer.youngs_modulus, layer.poisson_ratio) for layer in table.layers]
    if table.thickness is None:
        return Stack(thicknesses, materials, material)
    return Stack([*thicknesses, table.thickness], [*materials, material])


def grading_of(scene: Scene) -> Grading:
    """Return the reduced model's grading of a scene that has one."""
    table = scene.half_space.grading
    assert table is not None
    return Grading(scene.effective_modulus, scene.poisson_ratio, table.exponent, table.depth)


def contacts(scene: Scene, profile: Profile, loads: AbsoluteLoads) -> tuple[np.ndarray, np.ndarray]:
    """Return penetrations and contact radii at every load."""
    body = elastic_body(scene)
    if isinstance(body, Stack):
        text = scene.model_dump_json(exclude={"name", "title", "compare", "methods"})
        key = text, loads.control, loads.values.tobytes()
        if key not in _known:
            if len(_known) == _MOST:
                _known.clear()
            plain = Springs(profile, scene.effective_modulus)
            hertz = indent(plain, Load(loads.control, loads.values)).contact_radius
            # some loads one by one, between them power laws
            chosen = np.unique(np.linspace(0, len(hertz) - 1, _SINGLE).round().astype(int))
            contact = RoundContact(body, profile.height, profile.edge)
            steps = [
                contact.at(loads.control, float(value), float(guess), _TOLERANCE)
                for value, guess in zip(loads.values[chosen], hertz[chosen], strict=True)
            ]
            at, few = np.log(loads.values), np.log(loads.values[chosen])
            depth, radius = (
                np.exp(np.interp(at, few, np.log([getattr(step, name) for step in steps])))
                for name in ("penetration", "contact_radius")
            )
            _known[key] = depth, radius
        return _known[key]
    if profile.section is None:
        raise ValueError("on a graded half-space expected a body of revolution")
    grading = grading_of(scene)
    springs = Springs(grading.profile(profile.section), grading.spring_modulus)
    pressed = indent(springs, Load(loads.control, loads.values))
    return pressed.penetration, grading.place(pressed.contact_radius)
