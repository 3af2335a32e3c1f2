"""Estimates of contacts on layered and graded bodies, which size grids and meshes."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.elastic_body import elastic_body
from comparisons.scene.physics.absolute_loads import AbsoluteLoads
from comparisons.scene.scene import Scene
from reduced.loads import Load
from reduced.profiles.graded import Grading
from reduced.profiles.section import Profile
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference.layered import RoundContact, Stack

# Loads that are estimated one by one; between them power laws interpolate.
_SINGLE = 6
# Of the contact radius.
_TOLERANCE = 1e-3
# Contacts on layers take a second; plans that differ in what is compared have the same ones.
_known: dict[tuple[str, str, bytes], tuple[np.ndarray, np.ndarray]] = {}
_MOST = 256


def grading_of(scene: Scene) -> Grading:
    """Return the reduced model's grading of a scene that has one."""
    table = scene.half_space.grading
    assert table is not None
    return Grading(scene.effective_modulus, scene.poisson_ratio, table.exponent, table.depth)


def contacts(scene: Scene, profile: Profile, loads: AbsoluteLoads) -> tuple[np.ndarray, np.ndarray]:
    """Return penetrations and contact radii at every load.

    Raises
    ------
    ValueError, RuntimeError, ArithmeticError
        If the shape cannot reach these contacts.
    """
    body = elastic_body(scene)
    if isinstance(body, Stack):
        text = scene.model_dump_json(exclude={"name", "title", "compare", "methods"})
        key = text, loads.control, loads.values.tobytes()
        if key not in _known:
            if len(_known) == _MOST:
                _known.clear()
            plain = Springs(profile, scene.effective_modulus)
            hertz = indent(plain, Load(loads.control, loads.values)).contact_radius
            _known[key] = _on_layers(body, profile, loads, hertz)
        return _known[key]
    if profile.section is None:
        raise ValueError("on a graded half-space expected a body of revolution")
    grading = grading_of(scene)
    springs = Springs(grading.profile(profile.section), grading.spring_modulus)
    contact = indent(springs, Load(loads.control, loads.values))
    return contact.penetration, grading.place(contact.contact_radius)


def _on_layers(
    body: Stack, profile: Profile, loads: AbsoluteLoads, guesses: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    values = loads.values
    chosen = np.unique(np.linspace(0, values.size - 1, _SINGLE).round().astype(int))
    contact = RoundContact(body, profile.height, profile.edge)
    steps = []
    for value, guess in zip(values[chosen], guesses[chosen], strict=True):
        steps.append(contact.at(loads.control, float(value), float(guess), _TOLERANCE))
    few = np.log(values[chosen])
    depth, radius = (
        np.exp(np.interp(np.log(values), few, np.log([getattr(step, name) for step in steps])))
        for name in ("penetration", "contact_radius")
    )
    return depth, radius
