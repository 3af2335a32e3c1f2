"""What is wrong with a file of ours, in its own terms."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import Any, get_args

from pydantic import BaseModel, ValidationError

from comparisons.formatting import listed
from comparisons.reasons import near
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


def first_problems(error: ValidationError, file: str) -> str:
    """Return where and why the first three values of a file that we write ourselves are wrong."""
    problems = error.errors(include_url=False, include_input=False)[:3]
    places = (".".join(str(key) for key in problem["loc"]) or file for problem in problems)
    return "; ".join(f"{at}: {p['msg']}" for at, p in zip(places, problems, strict=True))


def in_file(error: ValidationError, model: type[BaseModel]) -> list[str]:
    """Return what is wrong with a file of ours, and for unknown keys what they are near to.

    Where the kind of a table is wrong, keys that no kind has are told beside it.
    """
    lines = []
    for problem in error.errors():
        lines.append(readable(problem))
        if problem["type"] == "extra_forbidden":
            *tables, key = map(str, problem["loc"])
            meant = near(key, _keys(model, tables)) or _other_kinds(key, model, tables)
            lines[-1] += meant or _elsewhere(key, model, tables[0] if tables else "")
        if problem["type"] == "literal_error" and isinstance(problem["input"], str):
            lines[-1] += near(problem["input"], re.findall("'([^']+)'", problem["ctx"]["expected"]))
        if problem["type"] in ("union_tag_invalid", "union_tag_not_found"):
            known = _keys(model, problem["loc"])
            given = problem["input"] if isinstance(problem["input"], Mapping) else {}
            beside = [name for name in given if name not in known]
            where = ".".join(map(str, problem["loc"]))
            lines += [f"{where}.{name}: unknown key{near(str(name), known)}" for name in beside]
    return lines


def _other_kinds(key: str, model: type[BaseModel], tables: list[str]) -> str:
    """Return the end of a message on a key that a table has where it is of another kind."""
    if len(tables) != 2 or tables[0] not in model.model_fields:
        return ""
    tags = [
        tag
        for kind in _tables(model.model_fields[tables[0]].annotation)
        if key in kind.model_fields
        for name in ("kind", "shape")
        if name in kind.model_fields
        for tag in get_args(kind.model_fields[name].annotation)
    ]
    return f"; only {listed(tags)} {'has' if len(tags) == 1 else 'have'} it" if tags else ""


def _elsewhere(key: str, model: type[BaseModel], table: str) -> str:
    """Return the end of a message on a key that other tables of the file have."""
    found = [
        f"[{name}]"
        for name, field in model.model_fields.items()
        if name != table and any(key in kind.model_fields for kind in _tables(field.annotation))
    ]
    return f"; did you mean {' or '.join(found[:3])}?" if found else ""


def _keys(model: type[BaseModel], location: Iterable[str | int]) -> list[str]:
    """Return the keys of a table by its place; of a kind that is unknown, those of all kinds."""
    models = [model]
    for key in location:
        fields = [table.model_fields[key] for table in models if key in table.model_fields]
        deeper = [table for field in fields for table in _tables(field.annotation)]
        # Otherwise the kind of a table, or the place in a list.
        of_kind = [
            table
            for table in models
            if any(key in get_args(field.annotation) for field in table.model_fields.values())
        ]
        models = deeper or of_kind or models
    fields_of_all = [item for table in models for item in table.model_fields.items()]
    return [field.alias or name for name, field in fields_of_all if not field.exclude]


def _tables(annotation: Any) -> list[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        return [annotation]
    return [table for part in get_args(annotation) for table in _tables(part)]


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
        came = "nothing" if tag is None else excerpt(tag) + near(str(tag), known_tags)
        return f"{path}.{key}: expected one of {', '.join(known_tags)}, got {came}"
    if kind == "scene":
        return f"{path}: {error['msg']}" if path else error["msg"]
    message = _PLAIN.get(kind, error["msg"]).replace("Input should be", "expected")
    message = message[0].lower() + message[1:]
    where = f"{path}: " if path else ""  # the whole file
    return f"{where}{message}, got {excerpt(came)}"


def missing_files(data: dict[str, Any], directory: Path) -> list[str]:
    """Problems with the files that a wrong scene names: told together with the others."""
    problems = []
    for key, entry in (("surface", "file"), ("surface2", "file"), ("compare", "measured")):
        table = data.get(key)
        file = table.get(entry) if isinstance(table, dict) else None
        if not isinstance(file, str) or not file or len(file) > 4096 or "\0" in file:
            continue
        path = directory / file
        if not path.is_file():
            what = "a folder, not a file" if path.is_dir() else "no such file"
            problems.append(f"{key}.{entry}: {file}: {what}")
    return problems
