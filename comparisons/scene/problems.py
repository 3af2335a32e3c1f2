"""Validation errors in the terms of scene files."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from comparisons.scene.fields import excerpt
from comparisons.scene.indenters import SHAPES

# What pydantic says in the language of Python, in the language of scene files.
_PLAIN = {
    "model_type": "expected a table",
    "model_attributes_type": "expected a table",
    "dict_type": "expected a table",
    "tuple_type": "expected a list",
    "list_type": "expected a list",
    "frozen_set_type": "expected a list",
    "too_long": "expected a shorter list",
    "string_type": "expected a text",
    "string_too_short": "expected a non-empty text",
    "int_type": "expected a whole number",
    "int_from_float": "expected a whole number",
    "bool_type": "expected true or false",
}


def readable(error: Mapping[str, Any]) -> str:
    """Turn one of pydantic's errors into ``path: expected ..., got ...``."""
    tags = ("self_affine", "map")
    location = list(error["loc"])
    if len(location) > 1 and location[0] in ("indenter", "surface", "surface2"):
        # The tag of the discriminated union stands second: indenter.cone.slope.
        del location[1]
    path = ".".join(str(key) for key in location)
    kind, context, came = error["type"], error.get("ctx", {}), error.get("input")
    if kind == "extra_forbidden":
        return f"{path}: unknown key"
    if kind == "missing":
        return f"{path}: expected, but missing"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        key, known_tags = ("shape", SHAPES) if path == "indenter" else ("kind", tags)
        tag = context.get("tag")
        came = "nothing" if tag is None else excerpt(tag)
        return f"{path}.{key}: expected one of {', '.join(known_tags)}, got {came}"
    if kind == "scene":
        return f"{path}: {error['msg']}" if path else error["msg"]
    message = _PLAIN.get(kind, error["msg"]).replace("Input should be", "expected")
    message = message[0].lower() + message[1:]
    return f"{path}: {message}, got {excerpt(came)}"
