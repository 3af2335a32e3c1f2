"""Outcomes of hard cases, and their files hard-cases.json and hard-cases.csv, checked when read."""

from __future__ import annotations

from dataclasses import asdict, dataclass, fields
from pathlib import Path

import pandas as pd
from pydantic import BaseModel, ConfigDict, ValidationError

from comparisons.errors import ResultsError
from comparisons.files import plain, write_table, write_text

RECORD, TABLE = "hard-cases.json", "hard-cases.csv"


@dataclass(frozen=True)
class Outcome:
    """What one method did with one case.

    Attributes
    ----------
    case, title, method : str
    kind : str
        "accurate", "degraded", "refused", "not for", or "lost" (no number where one was meant).
    error, area_error, bar : float
        Largest relative errors over the load steps (main quantity, contact area) and the bar of the
        truth at the main quantity; NaN where there is none.
    seconds : float
    resolution : int
        0 where nothing was solved.
    reason : str
        Why there is no number, or why steps are lost.
    lost : tuple of int
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
    error: float = float("nan")
    area_error: float = float("nan")
    bar: float = float("nan")
    seconds: float = float("nan")
    resolution: int = 0
    reason: str = ""
    lost: tuple[int, ...] = ()
    expected: str = ""
    deviation: str = ""


class _Form(BaseModel):
    """Types as JSON has them; keys that a later version adds are kept."""

    model_config = ConfigDict(strict=True, extra="allow", frozen=True, allow_inf_nan=False)


class OutcomeRecord(_Form):
    """An `Outcome`; None where there is no number."""

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


class HardCasesRecord(_Form):
    """A whole run of hard cases."""

    created: str
    command: str
    effort: str
    seconds: float
    machine: dict[str, str | int | float | None]
    versions: dict[str, str]
    interrupted: bool
    hard: dict[str, str]
    outcomes: list[OutcomeRecord]

    @property
    def methods(self) -> list[str]:
        """The methods, in the order in which they were run."""
        return list(dict.fromkeys(each.method for each in self.outcomes))

    @property
    def deviations(self) -> list[OutcomeRecord]:
        """What differs from the catalogue."""
        return [each for each in self.outcomes if each.deviation]

    @property
    def lost(self) -> list[OutcomeRecord]:
        """Solves of methods from outside that came to nothing."""
        return [each for each in self.outcomes if each.kind == "lost" and not each.expected]


def recorded(outcome: Outcome) -> OutcomeRecord:
    """Return an outcome as it is stored."""
    return OutcomeRecord.model_validate(plain(asdict(outcome)))


def save_record(directory: Path, record: HardCasesRecord) -> None:
    """Write hard-cases.json and hard-cases.csv, atomically."""
    write_text(directory / RECORD, record.model_dump_json(indent=1) + "\n")
    columns = [each.name for each in fields(Outcome)]
    rows = [each.model_dump() | {"lost": " ".join(map(str, each.lost))} for each in record.outcomes]
    write_table(directory / TABLE, pd.DataFrame(rows, columns=columns))


def load_record(directory: Path) -> HardCasesRecord:
    """Read the outcomes of a folder back.

    Raises
    ------
    ResultsError
        If there are none, or the file is not as it should be.
    """
    file = directory / RECORD
    try:
        return HardCasesRecord.model_validate_json(file.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ResultsError(f"{directory}: no hard cases were run here") from error
    except (ValidationError, OSError, UnicodeDecodeError) as error:
        first = " ".join(str(error).splitlines()[:3])
        raise ResultsError(f"{file}: damaged results ({first})") from error
