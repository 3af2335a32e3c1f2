"""Comparison of two results folders."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import pandas as pd

from comparisons.errors import InputError
from comparisons.results import run_comparison
from comparisons.results.run_comparison import MOVED, SAME, SLOWER, Change, RunComparison
from comparisons.results.store import StudyRecord, load_study
from reports.tables.runs import changes
from roughline import notebook
from roughline.studies import Results

MOST_ROWS = 20


@dataclass(frozen=True, repr=False)
class Changes:
    """The changes of every solve between two runs.

    Attributes
    ----------
    record : comparisons.results.run_comparison.RunComparison
    """

    record: RunComparison

    @property
    def notes(self) -> tuple[str, ...]:
        """Overall differences between the runs: versions, machines, scenes, references."""
        return self.record.notes

    @property
    def failed(self) -> tuple[Change, ...]:
        """Solves that moved, were lost, changed their verdict or became slower."""
        return self.record.failed

    def table(self) -> pd.DataFrame:
        """Return one row per solve of both runs."""
        rows = [
            {
                "scene": change.scene,
                "method": change.method,
                "resolution": change.resolution,
                "what": ", ".join(change.kinds),
                "quantity": change.quantity,
                "change": change.change,
                "error_before": change.errors[0],
                "error_after": change.errors[1],
                "seconds_before": change.seconds[0],
                "seconds_after": change.seconds[1],
                "bad": change.bad,
            }
            for change in self.record.changes
        ]
        return pd.DataFrame(rows)

    def __repr__(self) -> str:
        notable = [change for change in self.record.changes if change.kinds != (SAME,)]
        lines = [f"{c.scene} {c.method} {c.resolution}: {c.text}" for c in notable]
        return "\n".join([self._heading(), *self.notes, *lines])

    def _repr_html_(self) -> str:
        notable = sorted(
            (c for c in self.record.changes if c.kinds != (SAME,)), key=lambda c: not c.bad
        )
        body = notebook.table(changes(notable[:MOST_ROWS])) if notable else ""
        left = notebook.more(len(notable) - MOST_ROWS, "solves that changed")
        return notebook.block(self._heading(), *self.notes, body, left)

    def _heading(self) -> str:
        total = len(self.record.changes)
        same = sum(change.kinds == (SAME,) for change in self.record.changes)
        return f"{same} of {total} solves are the same, {len(self.failed)} are worse"


def compare_runs(
    before: str | Path | Results,
    after: str | Path | Results,
    *,
    tolerance: float = MOVED,
    slower: float = SLOWER,
) -> Changes:
    """Compare two results folders, solve by solve.

    Parameters
    ----------
    before, after : str, Path or Results
    tolerance : float
        Smallest relative change of a quantity that counts (iterations leave about 1e-6).
    slower : float
        Smallest ratio of times that counts; between different machines, times are not judged.

    Raises
    ------
    InputError
        If a folder has no results, or a threshold is invalid.
    """
    problems = [
        f"{name}: expected a number above {least}, got {number}"
        for name, number, least in (("tolerance", tolerance, 0), ("slower", slower, 1))
        if not least < number < float("inf")
    ]
    if problems:
        raise InputError("\n".join(problems))
    return Changes(run_comparison.compare_runs(_record(before), _record(after), tolerance, slower))


def _record(run: str | Path | Results) -> StudyRecord:
    return run.record if isinstance(run, Results) else load_study(run)
