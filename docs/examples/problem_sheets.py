"""Write into the problem sheets what is known of their quantities, or its seal.

    python docs/examples/problem_sheets.py

Every second sheet is sealed: it states a hash of the rounded reference.
"""

from __future__ import annotations

from pathlib import Path

import numpy as np
import tomli_w

from comparisons.questions.problem_sheets import FOLDER, Known, Sheet, computed, read_sheet, seal

MARK = "\n# What is known, written by docs/examples/problem_sheets.py\n"
SEALED_DIGITS = 6
# Other processors have other last digits: no value may be this close to being rounded differently.
CLEAR = 1e-9


def known_text(sheet: Sheet) -> str:
    """Return the tables of a sheet that state its reference."""
    known = computed(sheet)
    if int(sheet.id[-3:]) % 2 == 0:
        if any(distance_from_rounding(p.values, SEALED_DIGITS) < CLEAR for p in known.values()):
            raise ValueError(f"{sheet.id}: a value lies where {SEALED_DIGITS} digits change")
        return tomli_w.dumps({"sealed": seal(known, SEALED_DIGITS).model_dump()})
    return tomli_w.dumps({"reference": {name: _table(part) for name, part in known.items()}})


def distance_from_rounding(values: tuple[float, ...], digits: int) -> float:
    """Return how far, relative to itself, the nearest value is from being rounded differently."""
    array = np.abs(np.asarray(values, dtype=float))
    unit = 10.0 ** (np.floor(np.log10(array)) - digits + 1)
    return float((np.abs(array / unit % 1 - 0.5) * unit / array).min())


def _table(known: Known) -> dict[str, list[float]]:
    return {name: list(values) for name, values in known.model_dump().items() if values}


def renew(path: Path) -> None:
    """Write one sheet anew."""
    text = path.read_text(encoding="utf-8").partition(MARK)[0]
    path.write_text(text + MARK + "\n" + known_text(read_sheet(path)), encoding="utf-8")


if __name__ == "__main__":
    for path in sorted(FOLDER.glob("*.toml")):
        renew(path)
        print(path.name)
