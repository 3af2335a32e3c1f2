"""Snapshot of a model and its references as JSON: curves, agreement and speed."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from comparisons.errors import InputError
from comparisons.files import write_named_text
from comparisons.scene.problems import first_problems

# Made by `roughline check --update --baseline FILE`; a regression baseline, from our own output.
PACKAGED = Path(__file__).with_name("baseline.json")
LARGEST_FILE = 20_000_000
Curve = list[float | None]


class _Form(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Curves(_Form):
    """Quantities of a method over the loads, as means over realisations; None for failed steps."""

    resolution: int
    quantities: dict[str, Curve]

    def array(self, name: str) -> np.ndarray:
        """Return a quantity as an array, NaN for missing values."""
        return np.array([np.nan if v is None else v for v in self.quantities[name]])


class Speed(_Form):
    """Seconds of the model, of the yardstick measured in turns with it, and their ratio."""

    seconds: float = Field(gt=0)
    yardstick_seconds: float = Field(gt=0)
    ratio: float = Field(gt=0)


class SceneSnapshot(_Form):
    """One scene: the judged model, the references by name, and their agreement.

    ``alone`` lists references that differ from all others while those agree among themselves.
    ``scene`` identifies the problem ("" in old baselines).
    """

    scene: str = ""
    loads: list[float]
    model: Curves | None
    references: dict[str, Curves]
    disagreements: list[str]
    alone: list[str]
    speed: Speed | None


class Snapshot(_Form):
    """All scenes of a check, with the machine and versions."""

    format: int = Field(default=1, ge=1, le=1)
    method: str
    created: str
    machine: str
    versions: dict[str, str]
    scenes: dict[str, SceneSnapshot]


def load_baseline(path: Path) -> Snapshot:
    """Read a baseline.

    Raises
    ------
    InputError
        If it is missing or damaged, with the first invalid entries.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InputError(f"{path}: expected a baseline, got a file above {LARGEST_FILE} bytes")
        return Snapshot.model_validate_json(path.read_bytes())
    except OSError as error:
        raise InputError(
            f"{path}: no baseline can be read here ({error.strerror}); --update writes one"
        ) from error
    except ValidationError as error:
        places = first_problems(error, "the file")
        raise InputError(f"{path}: not a baseline of roughline: {places}") from error


def save_baseline(path: Path, snapshot: Snapshot) -> None:
    """Write a baseline atomically, one curve per line for readable diffs."""
    write_named_text(path, snapshot.model_dump_json(indent=1) + "\n")
