"""Valid combinations of tables, checked on the raw tables so that all errors are listed at once."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from comparisons.facts.quantities import DEFAULT, DISTRIBUTIONS, TANGENTIAL, quantity
from comparisons.scene.half_space import DEPTH_KEYS
from comparisons.scene.loading import PRESCRIBED
from comparisons.scene.physics.tables import TABLES


def switched_on(data: Mapping[str, Any]) -> tuple[str, ...]:
    """Return which tables of physics a scene has."""
    return tuple(name for name in TABLES if name in data)


def walks_a_path(data: Mapping[str, Any]) -> bool:
    """Tell whether the normal loads are a path: in time, or because a table has a memory."""
    loading = data.get("loading")
    in_time = isinstance(loading, dict) and "time" in loading
    return in_time or any(TABLES[name].remembers for name in switched_on(data))


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
    loading = data.get("loading")
    in_time = isinstance(loading, dict) and "time" in loading
    if "dynamics" in tables and in_time:
        quantities = ("penetration", "force", "contact_area")
    return data | {"compare": {**compare, "quantities": list(quantities)}}


def combination_problems(data: Mapping[str, Any]) -> Iterator[str]:
    """Yield what does not go together in a scene, with the reason."""
    tables = switched_on(data)
    for table in tables:
        for partner, reason in TABLES[table].apart.items():
            if partner in tables:
                yield f"{table}: expected no [{partner}] beside it: {reason}"
    if tables:
        yield from _bodies(data, tables)
    yield from _loads(data, tables)
    compare = data.get("compare")
    names = compare.get("quantities") if isinstance(compare, dict) else None
    for name in names if isinstance(names, (list, tuple)) else ():
        needed = quantity(name).physics if isinstance(name, str) else ()
        if needed and not set(needed) & set(tables):
            yield f"compare.quantities: {name}: expected {_either(needed)} in the scene"
        if name in DISTRIBUTIONS and (tables or "surface" not in data):
            yield f"compare.quantities: {name}: expected an elastic, frictionless rough [surface]"


def _bodies(data: Mapping[str, Any], tables: tuple[str, ...]) -> Iterator[str]:
    cause = _either(tables)
    if "body" in data:
        yield f"body: expected no {cause}: meshed bodies are elastic and frictionless"
    one_body = [name for name in tables if TABLES[name].one_body]
    if "counter_body" in data and one_body:
        yield (
            f"counter_body: expected no {_either(one_body)} beside it: only the moduli of "
            "frictionless elastic bodies add up to one"
        )
    half_space = data.get("half_space")
    for key in DEPTH_KEYS:
        if isinstance(half_space, dict) and key in half_space:
            yield f"half_space.{key}: expected no {cause} beside it: no method here has both"
    if isinstance(half_space, dict) and "effective_modulus" in half_space:
        for name in tables:
            if TABLES[name].two_constants:
                yield f"half_space: expected E or G with nu: {TABLES[name].two_constants}"


def _loads(data: Mapping[str, Any], tables: tuple[str, ...]) -> Iterator[str]:
    """Yield which loads are missing, and which have nothing to act on."""
    loading = data.get("loading", {})
    if not isinstance(loading, dict):
        return
    # a nominal pressure is a force
    normal = ["force" if n == "pressure" else n for n in PRESCRIBED if n in loading]
    tangential = [name for name in TANGENTIAL if name in loading]
    if "loading" not in data and "dynamics" not in tables:
        yield "loading: expected, but missing"
    if tables and "mean_gap" in normal:
        yield f"loading.mean_gap: expected penetration or force with {_either(tables)}"
    if "rolling" in tables:
        yield from _rolls(data, tables, tangential)
    elif "wear" in tables:
        yield from _wears(data, tangential)
    elif "friction" in tables and not tangential:
        yield "friction: expected loading.tangential_force or loading.tangential_displacement"
    if "friction" not in tables:
        for name in tangential:
            yield f"loading.{name}: expected a [friction] table, which transmits tangential loads"
    yield from _lubricated(data, normal)
    if "sliding" in tables and "viscoelastic" not in tables:
        yield "sliding: expected [viscoelastic]: an elastic body slides without loss"
    yield from _times(loading, tables, normal)
    if "substeps" in loading and not (tangential or walks_a_path(data)):
        yield "loading.substeps: expected a path of loads; increasing loads are already steps"


def _rolls(
    data: Mapping[str, Any], tables: tuple[str, ...], tangential: list[str]
) -> Iterator[str]:
    if "friction" not in tables:
        yield "rolling: expected [friction], which transmits tangential forces"
    for name in tangential if "friction" in tables else ():
        yield f"loading.{name}: expected none with [rolling], whose creep is prescribed"
    if "surface" in data:
        yield "rolling: expected an [indenter]: a rough roller has no steady state"


def _wears(data: Mapping[str, Any], tangential: list[str]) -> Iterator[str]:
    table, friction = data.get("wear"), data.get("friction")
    swings = isinstance(table, dict) and "amplitude" in table
    if swings and friction is None:
        yield "wear.amplitude: expected [friction], which lets the middle of the contact stick"
    if swings and "surface" in data:
        yield "wear.amplitude: expected an [indenter]: fretting of rough surfaces is not modelled"
    if friction is not None and not swings:
        yield "friction: expected none with wear.sliding_distance: all of the contact slips"
    if swings and isinstance(friction, dict) and friction.get("coupling", "full") != "none":
        yield 'friction.coupling: expected "none" with [wear]: no method here wears with coupling'
    for name in tangential:
        yield f"loading.{name}: expected none with [wear], whose motion is in its own table"


def _lubricated(data: Mapping[str, Any], normal: list[str]) -> Iterator[str]:
    table, loading = data.get("lubrication"), data.get("loading", {})
    squeezed = "squeeze_speed" in loading
    if "lubrication" not in data:
        if squeezed:
            yield "loading.squeeze_speed: expected a [lubrication] table: there is no film"
        return
    if normal and normal != ["force"]:
        yield f"loading.{normal[0]}: expected a force with [lubrication], which the film carries"
    if isinstance(table, dict) and ("speed" in table) == squeezed:
        came = "both" if squeezed else "none"
        yield f"lubrication: expected speed or loading.squeeze_speed, got {came}"
    if "surface" in data:
        yield "lubrication: expected an [indenter]: rough films are not modelled"


def _times(loading: Mapping[str, Any], tables: tuple[str, ...], normal: list[str]) -> Iterator[str]:
    timed = "time" in loading
    if timed and not {"viscoelastic", "dynamics"} & set(tables):
        yield "loading.time: expected [viscoelastic] or [dynamics]: nothing else depends on time"
    if timed and "sliding" in tables:
        yield "loading.time: expected none with [sliding], which is steady"
    if timed and not normal and "dynamics" not in tables:
        yield "loading: expected exactly one of penetration and force for each time, got none"
    if "viscoelastic" in tables and not timed and not {"sliding", "dynamics"} & set(tables):
        yield "viscoelastic: expected loading.time, the time of each load: the material relaxes"
    if "dynamics" in tables and normal and not timed:
        yield f"loading.{normal[0]}: expected its times (loading.time) with [dynamics]"
    if "dynamics" in tables and "penetration" in normal:
        yield "loading.penetration: expected a force or nothing: the motion of the mass is computed"


def _either(names: tuple[str, ...] | list[str]) -> str:
    return " or ".join(f"[{name}]" for name in names)
