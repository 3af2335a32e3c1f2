"""Files of a problem sheet for other people's solvers: scene, heights, an entry to fill in."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.files import write_atomically, write_text
from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.questions.problems.entry import BLANK_SOLVER
from comparisons.questions.problems.sheet import Sheet


def write_problem(sheet: Sheet, folder: Path) -> list[Path]:
    """Write the files of a sheet and return their paths."""
    geometry, loads = prepare(sheet.scene)
    steps = len(loads.values)
    paths = [folder / "scene.toml", folder / "entry.json"]
    write_text(paths[0], sheet.scene.text)
    write_text(paths[1], json.dumps(blank_entry(sheet, steps), indent=1) + "\n")
    if isinstance(geometry, RoughGeometry):
        heights = geometry.heights(0, geometry.points[0])
        paths.append(folder / "heights.csv")
        write_atomically(paths[-1], lambda s: np.savetxt(s, heights, delimiter=",", fmt="%.17g"))
    return paths


def blank_entry(sheet: Sheet, steps: int) -> dict[str, Any]:
    """Return an entry without values: every place is to be filled in, or stays null."""
    return {
        "problem": sheet.id,
        "version": sheet.version,
        "solver": BLANK_SOLVER,
        "author": "",
        "machine": "",
        "notes": "",
        "threads": 1,
        "unknowns": None,
        "seconds": None,
        "values": {name: [None] * steps for name in sheet.quantities},
    }
