"""Claims on scenes of a kind: with the same bodies, physics and choices, whatever their numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from comparisons.facts.methods import MODEL
from comparisons.questions.claims.families import HERE, builtin_claims
from comparisons.questions.claims.record import ClaimRecord, stored
from comparisons.scene.scene import Scene, load_scene

# One modulus is written in several ways.
MODULI = {"youngs_modulus", "shear_modulus", "effective_modulus", "poisson_ratio"}


def claims_on(scene: Scene) -> list[ClaimRecord]:
    """Return the claims on the reduced model of such a scene, whose numbers may be others.

    Of claims that differ in their tolerance alone the nearest one; none against a printed number.
    """
    found, own = [], _kind(scene)
    for name, keys in builtin_claims().items():
        side = keys | keys.get("stated", {})
        general = "number" not in keys.get("true", {}) and keys.get("method", MODEL) == MODEL
        if "scene" in side and general and name in stored():
            beside = HERE / side["scene"]
            changes = keys.get("changes", {}) | side.get("changes", {})
            claimed = load_scene(beside if beside.is_file() else side["scene"], changes)
            if _kind(claimed) == own:
                claim = stored()[name]
                found.append((f"{claim.what}, {claim.parameter}, {changes}", claim))
    found.sort(key=lambda pair: -abs(np.log(pair[1].tolerance / scene.compare.tolerance)))
    return list(dict(found).values())


def _kind(scene: Scene) -> Any:
    """Return what a scene is but for its numbers, the unit of its moduli and how it is loaded."""

    def kind(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: kind(item) for key, item in value.items() if key not in MODULI}
        if isinstance(value, (list, tuple)):
            members = [kind(item) for item in value]
            return 0 if members and not any(members) else members
        return 0 if type(value) in (int, float) else value

    document = scene.model_dump(exclude={"name", "title", "loading", "compare", "methods", "sweep"})
    paths = scene.loading.model_dump(exclude_none=True).keys() & {"time", "tangential_force"}
    if scene.indenter is not None and scene.indenter.shape == "sphere":
        document["indenter"]["shape"] = "paraboloid"  # which stands for one
    return kind(document), paths, kind(scene.methods.reduced.model_dump())
