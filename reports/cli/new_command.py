"""The command ``roughline new``: a scene file to begin with."""

from __future__ import annotations

from pathlib import Path
from typing import Literal

from reports.printable import say


def new(kind: Literal["ball", "map", "punch"], file: Path | None = None) -> int:
    """Write a scene file with comments, to be changed into yours.

    Parameters
    ----------
    kind
        What touches: a ball, a measured map, or a flat punch.
    file
        The file to write; default: KIND.toml in this folder. An existing one stays.
    """
    from comparisons.errors import InputError
    from comparisons.files import write_named_text
    from comparisons.scene.scene import beginning

    path = file or Path(f"{kind}.toml")
    if path.exists():
        raise InputError(f"{path}: exists; choose another name")
    write_named_text(path, beginning(kind))
    say(f"{path}: change it, then `roughline run {path}`")
    return 0
