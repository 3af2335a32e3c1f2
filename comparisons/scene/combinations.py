"""Tables of a scene that go together: checked before they are read, to list all errors at once."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import Any

from pydantic import ValidationError

from comparisons.facts.quantities import DEFAULT, DISTRIBUTIONS, TANGENTIAL, quantity
from comparisons.scene.half_space import DEPTH_KEYS, HalfSpace, with_material
from comparisons.scene.loading import PRESCRIBED
from comparisons.scene.physics.tables import TABLES
from comparisons.scene.physics.tables.viscoelastic import SAME_MODULUS


def switched_on(data: Mapping[str, Any]) -> tuple[str, ...]:
    """Return which tables of physics a scene has."""
    return tuple(name for name in TABLES if name in data)


def walks_a_path(data: Mapping[str, Any]) -> bool:
    """Tell whether the normal loads are a path: in time, or because a table has a memory."""
    return "time" in _table(data, "loading") or any(
        TABLES[name].remembers for name in switched_on(data)
    )


def with_defaults(data: dict[str, Any]) -> dict[str, Any]:
    """Fill in what physics decides: rubber's Poisson ratio, and the compared quantities."""
    tables = switched_on(data)
    if "viscoelastic" in tables and "half_space" not in data:
        data = data | {"half_space": {"poisson_ratio": 0.5}}
    compare = data.get("compare", {})
    if not tables or not isinstance(compare, dict) or "quantities" in compare:
        return data
    quantities = next((TABLES[name].compared for name in tables if TABLES[name].compared), None)
    if quantities is None:
        quantities = (*DEFAULT, *(added for name in tables for added in TABLES[name].adds))
    if "dynamics" in tables and "time" in _table(data, "loading"):
        quantities = ("penetration", "force", "contact_area")
    return data | {"compare": {**compare, "quantities": list(quantities)}}


def table_problems(data: dict[str, Any]) -> list[str]:
    """Return the problems across tables: found even where the tables themselves are wrong."""
    return [*_body_problems(data), *_physics_problems(data)]


def _table(data: Mapping[str, Any], key: str) -> Mapping[str, Any]:
    """Return a raw table, empty where it is none."""
    value = data.get(key)
    return value if isinstance(value, dict) else {}


def _body_problems(data: dict[str, Any]) -> Iterator[str]:
    """Yield what does not go together in what touches, and in the loads and grids of it."""
    loading, half_space = _table(data, "loading"), _table(data, "half_space")
    if "directory" in data:
        yield "directory: unknown key"
    bodies = [key for key in ("indenter", "surface") if key in data]
    if len(bodies) != 1 and "body" not in data:
        came = " and ".join(f"[{b}]" for b in bodies) or "none"
        yield f"expected exactly one of [indenter] and [surface], got {came}"
    if "surface2" in data and "surface" not in data:
        yield "surface2: expected a [surface] beside it, the face of the other body"
    if "indenter" in data:
        force = loading.get("force")
        if "mean_gap" in loading:
            yield "loading.mean_gap: expected a [surface], an indenter has no mean gap"
        if isinstance(force, dict) and "relative_to" in force:
            yield "loading.force.relative_to: expected a [surface], which has h' and A0"
    if data.get("body") is not None:
        table = _table(data, "body")
        if "surface" in data:
            yield "surface: expected an [indenter] with a [body], or none for a rigid plane"
        if table.get("symmetric_parts", 1) != 1 and "position" not in table:
            yield "body.position: expected, because the mesh is a part (symmetric_parts)"
        if "effective_modulus" in _table(with_material(data), "half_space"):
            yield "body: expected E or G with nu: a finite body needs two elastic constants"
        if "indenter" not in data and "mean_gap" in loading:
            yield "loading.mean_gap: expected force or penetration, a [body] has no mean gap"
    levels = _table(data, "compare").get("resolutions")
    if "body" not in data and isinstance(levels, (list, tuple)) and 1 in levels:
        path = f"compare.resolutions.{levels.index(1)}"
        yield f"{path}: expected greater than or equal to 2 without a [body], got 1"
    # what depends on depth does so in one body alone, by one law
    for key in DEPTH_KEYS:
        if key in _table(data, "counter_body"):
            yield f"counter_body.{key}: expected it in [half_space] alone"
    keys = [key for key in DEPTH_KEYS if key in half_space]
    if not keys:
        return
    if "effective_modulus" in half_space:
        yield f"half_space: expected E or G with nu: {keys[0]} needs two elastic constants"
    if "grading" in keys and len(keys) > 1:
        others = " and ".join(keys[:-1])
        yield f"half_space.grading: expected no {others} beside it: one law for all depths"
    if "layers" in keys and half_space["layers"] == []:
        yield "half_space.layers: expected at least one layer"
    for other in ("body", "counter_body"):
        if other in data:
            yield f"{other}: expected none beside half_space.{keys[0]}: one body depends on depth"


def _physics_problems(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield what does not go together with physics, and what needs it."""
    tables, half_space = switched_on(data), _table(data, "half_space")
    for table in tables:
        for partner, reason in TABLES[table].apart.items():
            if partner in tables:
                yield f"{table}: expected no [{partner}] beside it: {reason}"
    if tables:
        cause = _either(tables)
        if "body" in data:
            yield f"body: expected no {cause}: meshed bodies are elastic and frictionless"
        one_body = [name for name in tables if TABLES[name].one_body]
        if "counter_body" in data and one_body:
            yield (
                f"counter_body: expected no {_either(one_body)} beside it: only the moduli of "
                f"frictionless elastic bodies add up to one{_instead_of_two(data, one_body)}"
            )
        for key in DEPTH_KEYS:
            if key in half_space:
                yield f"half_space.{key}: expected no {cause} beside it: no method here has both"
        for name in tables:
            if "effective_modulus" in half_space and TABLES[name].two_constants:
                yield f"half_space: expected E or G with nu: {TABLES[name].two_constants}"
    loading = data.get("loading", {})
    if isinstance(loading, dict):  # which loads are missing, and which have nothing to act on
        if "loading" not in data and "dynamics" not in tables:
            yield "loading: expected, but missing"
        if tables and "mean_gap" in loading:
            yield f"loading.mean_gap: expected penetration or force with {_either(tables)}"
        for name, (needed, text) in _ACTS_ON.items():
            if name in loading and not set(needed) & set(tables):
                yield f"loading.{name}: expected {text}"
        for name in tables:
            yield from TABLES[name].misfits(data, loading)
        pressed = any(name in loading for name in PRESCRIBED)
        if "time" in loading and not pressed and "dynamics" not in tables:
            yield "loading: expected exactly one of penetration and force for each time, got none"
        if "substeps" in loading and not (set(TANGENTIAL) & set(loading) or walks_a_path(data)):
            yield "loading.substeps: expected a path of loads; increasing loads are already steps"
    names = _table(data, "compare").get("quantities")
    for name in names if isinstance(names, (list, tuple)) else ():
        needed = quantity(name).physics if isinstance(name, str) else ()
        if needed and not set(needed) & set(tables):
            yield f"compare.quantities: {name}: expected {_either(needed)} in the scene"
        if name in DISTRIBUTIONS and (tables or "surface" not in data):
            yield f"compare.quantities: {name}: expected an elastic, frictionless rough [surface]"


def _instead_of_two(data: Mapping[str, Any], one_body: list[str]) -> str:
    """Advise one half-space in place of two, where there is one that does the same."""
    try:
        below, above = (
            HalfSpace.model_validate(data.get(key)) for key in ("half_space", "counter_body")
        )
    except ValidationError:  # wrong moduli are told elsewhere
        return ""
    if not below.uniform:
        return ""
    gigapascals = 1e-9 / (1 / below.modulus + 1 / above.modulus)
    alike = below.nu == above.nu and math.isclose(
        below.modulus, above.modulus, rel_tol=SAME_MODULUS
    )
    if "friction" in one_body and alike:
        return (
            "; two equal bodies act as one of half the modulus on a rigid one: drop "
            'counter_body, halve E, set friction.coupling = "none"'
        )
    if one_body == ["plasticity"] and below.poisson_ratio is not None:
        # the same pressures, and by its own nu the same stresses below them
        young = gigapascals * (1 - below.poisson_ratio**2)
        return (
            "; up to first yield one body does the same: drop counter_body, set "
            f'half_space.youngs_modulus = "{young:.5g} GPa" (beyond first yield the results are '
            "those of the softer body; if the counter body yields, swap the two tables first)"
        )
    if {"wear", "lubrication"}.issuperset(one_body):
        return (
            f'; effective_modulus = "{gigapascals:.5g} GPa" alone in [half_space] presses like '
            "both: drop counter_body"
        )
    return ""


# Loads that only some tables of physics have a use for, and why.
_TRANSMITS = "a [friction] table, which transmits tangential loads"
_ACTS_ON = {
    **dict.fromkeys(TANGENTIAL, (("friction",), _TRANSMITS)),
    "squeeze_speed": (("lubrication",), "a [lubrication] table: there is no film"),
    "time": (
        ("viscoelastic", "dynamics"),
        "[viscoelastic] or [dynamics]: nothing else depends on time",
    ),
}


def _either(names: tuple[str, ...] | list[str]) -> str:
    return " or ".join(f"[{name}]" for name in names)
