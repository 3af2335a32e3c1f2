"""A measured curve of force over penetration: a table whose first line names columns and units.

Decimal commas, semicolons and tabs are read as in tables of heights; further columns are ignored.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np

from comparisons.geometry.reading import FileError
from comparisons.scene.units import FORCE, LENGTH, to_si

DIMENSIONS = {"penetration": LENGTH, "force": FORCE}
HEADS = "penetration / nm, force / µN"
LARGEST_FILE = 5_000_000  # bytes
FEWEST, MOST = 3, 20_000  # points


def read_curve(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Return measured penetrations and forces in SI units, in the order of the file."""
    from comparisons.geometry.map_files.text import layout_of

    try:
        if path.stat().st_size > LARGEST_FILE:
            raise FileError(f"expected a file of at most {LARGEST_FILE / 1e6:g} MB")
        layout = layout_of(path)
        lines = [text for line in layout.lines(path) if (text := line.split("#", 1)[0].strip())]
    except FileError:
        raise
    except (OSError, ValueError) as error:
        raise FileError(str(error)) from error
    heads = re.split(r"[;\t,]", lines[0]) if lines else []
    places, scales, problems = [], [], []
    for name, dimension in DIMENSIONS.items():
        found = [k for k, head in enumerate(heads) if head.strip().lower().startswith(name)]
        if len(found) != 1:
            problems.append(
                f"first line: expected one column {name}, got {len(found)}, as in {HEADS!r}"
            )
            continue
        unit = heads[found[0]].strip()[len(name) :].strip(" /[]()")
        try:
            scales.append(to_si(f"1 {unit}" if unit else 1.0, dimension))
        except ValueError as error:
            problems.append(f"column {name}: {error}")
        places += found
    if problems:
        raise FileError(*problems)
    rows = []
    for line in lines[1:]:
        fields = line.split(layout.delimiter)
        try:
            rows.append([float(fields[place]) for place in places])
        except (ValueError, IndexError):
            raise FileError(f"expected numbers below the first line, got {line[:60]!r}") from None
    values = np.array(rows).reshape(-1, 2)
    if not FEWEST <= len(values) <= MOST:
        raise FileError(f"expected {FEWEST} to {MOST} points, got {len(values)}")
    if not np.isfinite(values).all():
        raise FileError("expected finite numbers only")
    if not values[:, 1].max() > 0:
        raise FileError("expected some positive (compressive) forces")
    depth, force = (values * scales).T
    return depth, force
