"""Tables written as TOML text."""

from __future__ import annotations

import json
import re
from collections.abc import Mapping
from typing import Any

BARE = re.compile(r"[A-Za-z0-9_-]+")


def to_toml(tables: Mapping[str, Any]) -> str:
    """Write nested tables as TOML (tables one level deep, the rest inline).

    Examples
    --------
    >>> print(to_toml({"name": "a", "half_space": {"effective_modulus": 1e9}}))
    name = "a"
    <BLANKLINE>
    [half_space]
    effective_modulus = 1000000000.0
    """
    lines = [f"{k} = {_inline(v)}" for k, v in tables.items() if not isinstance(v, Mapping)]
    for name, table in tables.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{name}]", *(f"{k} = {_inline(v)}" for k, v in table.items())]
    return "\n".join(lines)


def _inline(value: Any) -> str:
    if isinstance(value, Mapping):
        pairs = [(k if BARE.fullmatch(k) else _inline(k), v) for k, v in value.items()]
        return "{ " + ", ".join(f"{k} = {_inline(v)}" for k, v in pairs) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_inline(each) for each in value) + "]"
    if isinstance(value, str):
        # JSON's escapes are TOML's, but for DEL, which JSON leaves as it is, and for what lies
        # beyond 16 bits, which JSON would escape as two surrogates: it stands as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    return json.dumps(value)
