"""Outcomes of hard cases, and the files hard-cases.json and hard-cases.csv, validated when read."""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from comparisons.results.folder import Form, Header, read_record

RECORD, TABLE = "hard-cases.json", "hard-cases.csv"


class OutcomeRecord(Form):
    """Outcome of a method in a case; None for missing numbers.

    Attributes
    ----------
    case, title, method : str
    kind : str
        "accurate", "degraded", "refused", "not for", or "lost" (a number is missing unexpectedly).
    error, area_error, bar : float or None
        Largest relative errors over the load steps (main quantity, contact area) and the bar of the
        reference for the main quantity.
    seconds : float or None
    resolution : int
        0 without a solve.
    reason : str
        Reason for a missing number or lost steps.
    lost : list of int
        Load steps without an answer.
    expected : str
        The expectation in words; "" if there is none (a user-supplied method).
    deviation : str
        Difference of the outcome from the expectation in words; "" if there is none.
    """

    case: str
    title: str
    method: str
    kind: str
    error: float | None = None
    area_error: float | None = None
    bar: float | None = None
    seconds: float | None = None
    resolution: int = 0
    reason: str = ""
    lost: list[int] = Field(default=[])
    expected: str = ""
    deviation: str = ""


class HardCasesRecord(Header):
    """A complete run of hard cases."""

    hard: dict[str, str]
    outcomes: list[OutcomeRecord]

    @property
    def methods(self) -> list[str]:
        """The methods in order of execution."""
        return list(dict.fromkeys(outcome.method for outcome in self.outcomes))

    @property
    def deviations(self) -> list[OutcomeRecord]:
        """The deviations from the catalogue."""
        return [outcome for outcome in self.outcomes if outcome.deviation]

    @property
    def lost(self) -> list[OutcomeRecord]:
        """Failed solves of user-supplied methods."""
        return [
            outcome for outcome in self.outcomes if outcome.kind == "lost" and not outcome.expected
        ]


def load_record(directory: Path) -> HardCasesRecord:
    """Read the outcomes in a folder.

    Raises
    ------
    ResultsError
        If there are none, or the file is invalid.
    """
    missing = f"{directory}: no hard cases were run here"
    return read_record(HardCasesRecord, directory / RECORD, missing)
