"""The common header of all records on disk, and the reading of untrusted records."""

from __future__ import annotations

from pathlib import Path
from typing import TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from comparisons.errors import ResultsError


class Form(BaseModel):
    """Types as JSON has them; keys that a later version adds are kept."""

    model_config = ConfigDict(strict=True, extra="allow", frozen=True, allow_inf_nan=False)


class Header(Form):
    """A run of a campaign.

    Attributes
    ----------
    created, command, effort : str
        ISO date and time of the run; the command line; "quick" or "full".
    seconds : float
        Wall time, with that of the runs it resumed.
    machine, versions : dict
        Where it ran, with which packages.
    interrupted : bool
        True where it was stopped before all was done.
    """

    created: str
    command: str
    effort: str
    seconds: float
    machine: dict[str, str | int | float | None]
    versions: dict[str, str]
    interrupted: bool


Record = TypeVar("Record", bound=Header)


def read_record(form: type[Record], file: Path, missing: str) -> Record:
    """Read a record; ResultsError where it is damaged, or there is none (said as `missing`)."""
    try:
        return form.model_validate_json(file.read_text(encoding="utf-8"))
    except FileNotFoundError as error:
        raise ResultsError(missing) from error
    except (ValidationError, OSError, UnicodeDecodeError) as error:
        first = " ".join(str(error).splitlines()[:3])
        raise ResultsError(f"{file}: damaged results ({first})") from error
