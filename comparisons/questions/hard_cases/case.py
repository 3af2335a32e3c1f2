"""What a hard case is: a scene, its truth, and what each method is expected to do with it."""

from __future__ import annotations

import re
from copy import deepcopy
from math import nan
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationInfo,
    field_validator,
    model_validator,
)

from comparisons.facts.methods import BUILT_IN
from comparisons.questions.hard_cases.formulas import Formula
from comparisons.questions.hard_cases.recipes import Recipe, Table
from comparisons.scene.fields import Positive, fail
from comparisons.scene.scene import Scene, make_scene, override

ACCURATE, DEGRADED, REFUSED, NOT_FOR = ("accurate", "degraded", "refused", "not for")
OUTCOME_KEYS = ("accurate", "degraded", "refused", "not_for")
# Larger errors are degraded ones.
ACCURATE_TO = 0.01
# The methods that every case expects something of; those of others are shown as they are.
JUDGED = tuple(name for name, row in BUILT_IN.items() if not row.peer)

Judged = Literal[JUDGED]  # type: ignore[valid-type]
Text = Annotated[str, Field(min_length=1, max_length=500)]
Count = Annotated[int, Field(strict=True, ge=1)]


def _listed(value: Any) -> Any:
    return value if isinstance(value, (list, tuple)) else (value,)


Bounds = Annotated[
    tuple[Positive, ...], BeforeValidator(_listed), Field(min_length=1, max_length=2)
]


def _npy(name: str) -> str:
    if not re.fullmatch(r"[a-z0-9-]+\.npy", name):
        raise fail("expected a file name of a-z, 0-9 and - that ends in .npy", name)
    return name


MapName = Annotated[str, AfterValidator(_npy)]


class Expected(Table):
    """What one method does with one case: exactly one of the first four keys says it.

    accurate, degraded: a number, with the largest relative error over the load steps of the main
    quantity (the force at equal penetration, the penetration at equal force; the first one compared
    where the scene's physics has another axis) and, after it, that of the contact area, each
    together with the bar of the truth. What is not given is not bounded: there is no truth for it.
    refused: no number but a reason that contains this text.
    not_for: the method was never meant for such a scene, for a reason that contains this text.
    lost: load steps without an answer, counted from 0; all others have one.
    text: part of the reason of the lost steps.
    why: why a method degrades.
    """

    accurate: Bounds = ()
    degraded: Bounds = ()
    refused: Annotated[str, Field(max_length=500)] = ""
    not_for: Annotated[str, Field(max_length=500)] = ""
    lost: tuple[Annotated[int, Field(strict=True, ge=0)], ...] = ()
    text: Annotated[str, Field(max_length=500)] = ""
    why: Annotated[str, Field(max_length=500)] = ""

    @model_validator(mode="after")
    def _one_outcome(self) -> Expected:
        came = [key for key in OUTCOME_KEYS if getattr(self, key)]
        problems = []
        if len(came) != 1:
            got = " and ".join(came) or "none"
            problems.append(f"expected exactly one of {', '.join(OUTCOME_KEYS)}, got {got}")
        if self.accurate and self.accurate[0] > ACCURATE_TO:
            problems.append(f"expected accurate to at most {ACCURATE_TO:g}, else degraded")
        if bool(self.degraded) != bool(self.why):
            problems.append("expected why beside degraded, and nowhere else")
        if not (self.accurate or self.degraded) and (self.lost or self.text):
            problems.append("expected lost and text only where there are numbers")
        if problems:
            raise fail("; ".join(problems))
        return self

    @property
    def kind(self) -> str:
        """The outcome, as the tables show it."""
        return next(key for key in OUTCOME_KEYS if getattr(self, key)).replace("_", " ")

    @property
    def error(self) -> float:
        """Largest relative error of the main quantity; NaN where there is no number."""
        return (self.accurate or self.degraded or (nan,))[0]

    @property
    def area(self) -> float:
        """Largest relative error of the contact area; NaN where it is not bounded."""
        return (*(self.accurate or self.degraded), nan, nan)[1]

    @property
    def reason(self) -> str:
        """Part of the reason of a refusal, or of the lost steps."""
        return self.refused or self.not_for or self.text


class Truth(Table):
    """What the methods are judged by: a method on several resolutions, or a formula.

    method, resolutions: whose answer on the finest resolution counts; the differences of the
    resolutions are its bar. With one resolution only the solver is in doubt, not the grid.
    scene: keys, by path, in which the scene that it solves differs from that of the case.
    formula: the answer itself, exact but for round-off; source: where it stands.
    """

    method: Judged = "closed_form"
    resolutions: Annotated[tuple[Count, ...], Field(min_length=1)] = (1,)
    scene: dict[str, Any] = Field(default={})
    formula: Formula | None = None
    source: Annotated[str, Field(max_length=500)] = ""

    @model_validator(mode="after")
    def _solved_or_known(self) -> Truth:
        solved = sorted(self.model_fields_set & {"method", "resolutions", "scene"})
        if self.formula is not None and solved:
            raise fail(f"expected a formula or a method that solves, got {' and '.join(solved)}")
        if bool(self.formula) != bool(self.source):
            raise fail("expected a source beside a formula, and nowhere else")
        return self


class HardCase(Table):
    """One entry of the catalogue.

    id, title: a slug and a heading.
    hard: what is hard about it, in one sentence.
    scene: keys of the scene, by path; its name is the id.
    maps: files that the scene names, and how their heights are made.
    truth: by default the scene's closed form.
    only: why methods without an expectation are not run; absent if all are.
    expected: what each method does; of all of them, unless `only` is given.
    resolutions: of methods; by default what ``roughline solve`` takes.
    slow: methods that only ``--full`` runs: finite elements take seconds, the others milliseconds.
    """

    id: Annotated[str, Field(max_length=60)]
    title: Text
    hard: Text
    scene: Annotated[dict[str, Any], Field(min_length=1)]
    maps: dict[MapName, Recipe] = Field(default={})
    truth: Truth = Truth()
    only: Annotated[str, Field(max_length=500)] = ""
    expected: dict[Judged, Expected]
    resolutions: dict[Judged, Count] = Field(default={})
    slow: frozenset[Judged] = frozenset({"fem"})

    @field_validator("id")
    @classmethod
    def _slug(cls, value: str) -> str:
        if not re.fullmatch(r"[a-z0-9][a-z0-9-]*", value):
            raise fail("expected a slug of a-z, 0-9 and -", value)
        return value

    @field_validator("maps")
    @classmethod
    def _starts(cls, value: dict[str, Recipe]) -> dict[str, Recipe]:
        problems = []
        for name, recipe in value.items():
            points = value.get(recipe.start, recipe).points
            if not points:
                problems.append(f"{name}: expected from = a map that is made from nothing")
            elif recipe.point is not None and max(recipe.point.index) >= points:
                problems.append(f"{name}.point.index: expected places below {points}")
        if problems:
            raise fail("; ".join(problems))
        return value

    @field_validator("expected")
    @classmethod
    def _of_every_method(
        cls, value: dict[str, Expected], info: ValidationInfo
    ) -> dict[str, Expected]:
        missing = [name for name in JUDGED if name not in value]
        if missing and not info.data.get("only"):
            raise fail(f"expected something of every method, got nothing of {', '.join(missing)}")
        return value

    def expects(self, method: str) -> Expected | None:
        """Return what a method is to do; None where nothing is expected of it."""
        only = Expected(not_for=self.only) if self.only else None
        return self.expected.get(method, only)

    def scene_in(self, folder: Path, changes: dict[str, Any] | None = None) -> Scene:
        """Return the scene, or one that differs from it, with its maps in a folder.

        Raises
        ------
        SceneError
        """
        data: dict[str, Any] = {"name": self.id}
        for path, value in (self.scene | (changes or {})).items():
            override(data, path, deepcopy(value))
        return make_scene(data, f"{self.id}.toml", folder)

    def write_maps(self, folder: Path) -> None:
        """Write the maps that the scene names."""
        for name, recipe in self.maps.items():
            recipe.save(folder / name, self.maps)
