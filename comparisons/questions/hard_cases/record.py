"""Outcomes of hard cases, and their files hard-cases.json and hard-cases.csv, checked when read."""

from __future__ import annotations

from pathlib import Path

import pandas as pd

from comparisons.files import write_table, write_text
from comparisons.results.header import Form, Header, read_record

RECORD, TABLE = "hard-cases.json", "hard-cases.csv"


class OutcomeRecord(Form):
    """What one method did with one case; None where there is no number.

    Attributes
    ----------
    case, title, method : str
    kind : str
        "accurate", "degraded", "refused", "not for", or "lost" (no number where one was meant).
    error, area_error, bar : float or None
        Largest relative errors over the load steps (main quantity, contact area) and the bar of the
        truth at the main quantity.
    seconds : float or None
    resolution : int
        0 where nothing was solved.
    reason : str
        Why there is no number, or why steps are lost.
    lost : list of int
        Load steps without an answer.
    expected : str
        The expectation in words; "" where there is none (a method from outside).
    deviation : str
        How the outcome differs from the expectation; "" where it does not.
    """

    case: str
    title: str
    method: str
    kind: str
    error: float | None
    area_error: float | None
    bar: float | None
    seconds: float | None
    resolution: int
    reason: str
    lost: list[int]
    expected: str
    deviation: str


class HardCasesRecord(Header):
    """A whole run of hard cases."""

    hard: dict[str, str]
    outcomes: list[OutcomeRecord]

    @property
    def methods(self) -> list[str]:
        """The methods, in the order in which they were run."""
        return list(dict.fromkeys(outcome.method for outcome in self.outcomes))

    @property
    def deviations(self) -> list[OutcomeRecord]:
        """What differs from the catalogue."""
        return [outcome for outcome in self.outcomes if outcome.deviation]

    @property
    def lost(self) -> list[OutcomeRecord]:
        """Solves of methods from outside that came to nothing."""
        return [
            outcome for outcome in self.outcomes if outcome.kind == "lost" and not outcome.expected
        ]


def save_record(directory: Path, record: HardCasesRecord) -> None:
    """Write hard-cases.json and hard-cases.csv, atomically."""
    write_text(directory / RECORD, record.model_dump_json(indent=1) + "\n")
    rows = [
        outcome.model_dump() | {"lost": " ".join(map(str, outcome.lost))}
        for outcome in record.outcomes
    ]
    write_table(directory / TABLE, pd.DataFrame(rows, columns=list(OutcomeRecord.model_fields)))


def load_record(directory: Path) -> HardCasesRecord:
    """Read the outcomes of a folder back.

    Raises
    ------
    ResultsError
        If there are none, or the file is not as it should be.
    """
    missing = f"{directory}: no hard cases were run here"
    return read_record(HardCasesRecord, directory / RECORD, missing)
