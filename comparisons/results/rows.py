"""The one schema of tables of results: the types of columns, given when they are recorded or read.

Text that is missing is "", a number that is missing or infinite is NaN.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    import pandas as pd

HASH = "scene_hash"  # by which a row that is stored is known as its scene's
TEXTS = frozenset(
    {"scene", "method", "options", "realisation", "reference", "reason", "machine"}
    | {"quantity", "at", "verdict", "outside_band", HASH}
)
FLAGS = frozenset({"converged", "no_equilibrium"})
# How they are written, by us and by spreadsheets.
YES, NO = ["true", "1", "1.0"], ["false", "0", "0.0"]
# Of the others, which are numbers, those that are whole.
WHOLE = ("resolution", "step", "surfaces", "unknowns", "iterations", "threads")
# Columns that a table of results must have; the texts among them in every row.
ROWS = ("scene", "method", "resolution", "step")
DISTRIBUTIONS = ("scene", "method", "quantity", "resolution", "low", "high", "amount")
LARGEST_RESOLUTION = 2**31


class Rows:
    """Rows of a table: ``rows["force"]`` is a column as an array.

    A column that the table has not is unknown in every row: "" or NaN. Selections share the columns
    of the table they are from: a page takes thousands of them.
    """

    def __init__(self, columns: dict[str, np.ndarray], chosen: np.ndarray) -> None:
        self._columns, self._chosen = columns, chosen

    @classmethod
    def of(cls, table: Mapping[str, Any] | pd.DataFrame, required: tuple[str, ...] = ()) -> Rows:
        """Return columns with their types; ValueError lists those that are missing or wrong."""
        length = max((len(table[name]) for name in table), default=0)
        # A table without rows (nothing was solved) need not have them all.
        expected = required if length or "scene" not in table else ()
        missing = [name for name in expected if name not in table]
        problems = [f"column {name}: missing" for name in missing]
        columns: dict[str, np.ndarray] = {}
        for name in table:
            stored = table[name]
            if name in TEXTS:
                texts = ["" if value is None or value != value else str(value) for value in stored]
                if name == "realisation":  # a spreadsheet may have saved 0 as 0.0
                    texts = [text.removesuffix(".0") for text in texts]
                columns[name] = np.array(texts, dtype=object)
                if name in required and "" in texts:
                    problems.append(f"column {name}: expected a text in every row")
            elif name in FLAGS:
                told = np.char.lower(np.asarray(stored).astype(str))
                columns[name] = np.isin(told, YES)
                if not np.isin(told, YES + NO).all():
                    problems.append(f"column {name}: expected True or False in every row")
            else:
                if isinstance(stored, list):  # of a file: what is missing is empty
                    stored = ["nan" if value == "" else value for value in stored]
                try:
                    numbers = np.array(stored, dtype=float)
                except (ValueError, TypeError):
                    numbers = np.full(length, np.nan)
                    problems.append(f"column {name}: expected numbers")
                columns[name] = np.where(np.isfinite(numbers), numbers, np.nan)
        level = columns.get("resolution", np.empty(0))
        if ((level < 0) | (level > LARGEST_RESOLUTION)).any():
            problems.append(f"column resolution: expected numbers from 0 to {LARGEST_RESOLUTION}")
        if problems:
            raise ValueError("; ".join(problems))
        return cls(columns, np.arange(length))

    @classmethod
    def stacked(cls, tables: Iterable[Mapping[str, Any]]) -> Rows:
        """Return tables one below the other: what is no array stands in every row of its own."""
        several = list(tables)
        lengths = [
            next((len(values) for values in table.values() if np.ndim(values)), 1)
            for table in several
        ]
        columns = {}
        for name in dict.fromkeys(name for table in several for name in table):
            kind, unknown = (object, "") if name in TEXTS else (float, np.nan)
            parts = [np.asarray(table.get(name, unknown), dtype=kind) for table in several]
            spread = map(np.broadcast_to, parts, lengths)
            columns[name] = np.concatenate(list(spread))
        return cls.of(columns)

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
        """Which have no answer, and not because no equilibrium exists."""
        return ~(self["converged"] | self["no_equilibrium"])

    def where(self, chosen: np.ndarray) -> Rows:
        """Return the rows of a mask, or at some places in their order."""
        return Rows(self._columns, self._chosen[chosen])

    @classmethod
    def joined(cls, parts: Sequence[Rows], most: int) -> Rows:
        """Return selections of one table one below the other, at most so many rows."""
        if not parts:
            return NO_ROWS
        return cls(parts[0]._columns, np.concatenate([part._chosen for part in parts])[:most])

    @property
    def whole(self) -> list[str]:
        """The columns of numbers that are whole."""
        return [name for name in WHOLE if name in self and not (self[name] % 1 > 0).any()]

    def written(self) -> dict[str, Any]:
        """Return all columns as they are written: whole numbers as such."""
        whole = {n: ["" if np.isnan(v) else int(v) for v in self[n]] for n in self.whole}
        return {name: self[name] for name in self} | whole

    def frame(self) -> pd.DataFrame:
        """Return all columns for export; whole numbers as such, also beside unknown ones."""
        import pandas as pd  # of all that is done with results only this needs it

        table = pd.DataFrame({name: self[name] for name in self})
        return table.astype(dict.fromkeys(self.whole, "Int64"))


NO_ROWS = Rows({}, np.empty(0, dtype=int))
