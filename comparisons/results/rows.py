"""The one schema of tables of results: the types of columns, given when they are recorded or read.

Text that is missing is "", a number that is missing or infinite is NaN.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
import pandas as pd

from comparisons.tasks.solution import FLAGS

TEXTS = frozenset(
    {"scene", "method", "options", "realisation", "reference", "reason", "machine"}
    | {"quantity", "at", "verdict", "outside_band"}
)
# How they are written, by us and by spreadsheets.
YES, NO = ["true", "1", "1.0"], ["false", "0", "0.0"]
# Of the others, which are numbers, those that are whole.
WHOLE = ("resolution", "step", "surfaces", "unknowns", "iterations", "threads")
# Columns that a table of results must have; the texts among them in every row.
ROWS = ("scene", "method", "resolution", "step")
DISTRIBUTIONS = ("scene", "method", "quantity", "resolution", "low", "high", "amount")
LARGEST_RESOLUTION = 2**31


class Rows:
    """Rows of a table: ``rows["force"]`` is a column as an array, of "" or NaN where there is none.

    Selections share the columns of the table they are from: a page takes thousands of them.
    """

    def __init__(self, columns: dict[str, np.ndarray], chosen: np.ndarray) -> None:
        self._columns, self._chosen = columns, chosen

    @classmethod
    def of(cls, table: pd.DataFrame, required: tuple[str, ...] = ()) -> Rows:
        """Return a table with its types; ValueError lists columns that are missing or wrong."""
        # A table without rows (nothing was solved) need not have them all.
        expected = required if len(table) or "scene" not in table else ()
        missing = [name for name in expected if name not in table]
        problems = [f"column {name}: missing" for name in missing]
        columns: dict[str, np.ndarray] = {}
        for name in table:
            stored = table[name]
            if name in TEXTS:
                known = zip(stored.to_numpy(dtype=object), stored.isna(), strict=True)
                columns[name] = np.array(["" if no else str(v) for v, no in known], dtype=object)
                if name == "realisation":  # a spreadsheet may have saved 0 as 0.0
                    whole = [text.removesuffix(".0") for text in columns[name]]
                    columns[name] = np.array(whole, dtype=object)
                if name in required and (columns[name] == "").any():
                    problems.append(f"column {name}: expected a text in every row")
            elif name in FLAGS:
                told = stored.astype(str).str.lower()
                columns[name] = told.isin(YES).to_numpy()
                if not told.isin(YES + NO).all():
                    problems.append(f"column {name}: expected True or False in every row")
            else:
                values = pd.to_numeric(stored, errors="coerce")
                if (values.isna() & stored.notna()).any():
                    problems.append(f"column {name}: expected numbers")
                numbers = values.to_numpy(dtype=float)
                columns[name] = np.where(np.isfinite(numbers), numbers, np.nan)
        level = columns.get("resolution", np.empty(0))
        if ((level < 0) | (level > LARGEST_RESOLUTION)).any():
            problems.append(f"column resolution: expected numbers from 0 to {LARGEST_RESOLUTION}")
        if problems:
            raise ValueError("; ".join(problems))
        return cls(columns, np.arange(len(table)))

    def __len__(self) -> int:
        return len(self._chosen)

    def __iter__(self) -> Iterator[str]:
        return iter(self._columns)

    def __getitem__(self, name: str) -> np.ndarray:
        if name in self._columns:
            return self._columns[name][self._chosen]
        if name in FLAGS:
            return np.full(len(self), name == "converged")
        if name in TEXTS:
            return np.full(len(self), "", dtype=object)
        return np.full(len(self), np.nan)

    @property
    def lost(self) -> np.ndarray:
        """Which have no answer, not even one without values."""
        return ~np.any([self[name] for name in FLAGS], axis=0)

    def where(self, chosen: np.ndarray) -> Rows:
        """Return the rows of a mask, or at some places in their order."""
        return Rows(self._columns, self._chosen[chosen])

    @classmethod
    def joined(cls, parts: Sequence[Rows], most: int) -> Rows:
        """Return selections of one table one below the other, at most so many rows."""
        if not parts:
            return NO_ROWS
        return cls(parts[0]._columns, np.concatenate([part._chosen for part in parts])[:most])

    def frame(self) -> pd.DataFrame:
        """Return all columns for export; whole numbers as such, also beside unknown ones."""
        table = pd.DataFrame({name: self[name] for name in self})
        whole = [name for name in WHOLE if name in table and not (table[name] % 1 > 0).any()]
        return table.astype(dict.fromkeys(whole, "Int64"))


NO_ROWS = Rows({}, np.empty(0, dtype=int))
