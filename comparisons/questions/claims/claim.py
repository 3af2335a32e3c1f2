"""Claim files: precise, refutable statements about the reduced model.

A claim consists of either a scene (with a method and a quantity) or an experiment, optionally a
parameter along which the statement is tested, and a tolerance. The same statement may occur twice,
literally as printed and as corrected, which ``reading`` distinguishes.
"""

from __future__ import annotations

import re
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Field,
    StrictBool,
    ValidationError,
    field_validator,
    model_validator,
)

from comparisons.errors import InputError
from comparisons.facts.methods import METHODS, MODEL
from comparisons.facts.quantities import COMPARABLE, FIELDS
from comparisons.questions.claims.headlines import builtin_claims, chapter_order
from comparisons.questions.claims.verdicts import VERDICTS
from comparisons.questions.experiments import EXPERIMENTS
from comparisons.scene.fields import Finite, KnownMethod, Positive, fail
from comparisons.scene.problems import readable
from comparisons.scene.scene import load_scene
from comparisons.scene.toml_files import read_toml
from comparisons.scene.units import number_and_unit

# The contact area that the equivalent diameter predicts from the true stiffness.
AREA_FROM_STIFFNESS = "area_from_stiffness"
# Possible quantities of claims: those of scenes, and derived ones.
CLAIMED = tuple(dict.fromkeys((*COMPARABLE, *FIELDS, AREA_FROM_STIFFNESS)))
MEASURES = ("maximum", "rms", "last")
RESOLUTION = "resolution"
MOST_STEPS = 200


class ClaimError(InputError):
    """Invalid claim files; ``problems`` lists all errors, one entry per file and key."""

    def __init__(self, problems: list[str]) -> None:
        self.problems = problems
        super().__init__("\n".join(problems))


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


def _listed(value: Any) -> Any:
    return (value,) if isinstance(value, str) else value


Name = Annotated[str, Field(min_length=1, max_length=200)]
Prose = Annotated[str, Field(min_length=1, max_length=2000)]
Names = Annotated[tuple[Name, ...], BeforeValidator(_listed), Field(min_length=1)]


class Vary(_Table):
    """A parameter and the initial grid of values for the search.

    path: keys of the scene that get the value (``indenter.radius_x``; numbers index lists; several
    keys get the same value), or ``resolution`` of the judged method; not used for experiments,
    which define their parameter.
    name: the parameter in words, with its symbol; default: the path, or the experiment's name.
    unit: factor between the number and the value in the scene ("10 mm").
    integer: whole numbers only (points, terms, springs).
    bisections: number of bisections of a grid interval with a boundary at full effort; half as many
    at quick effort.
    """

    path: Annotated[tuple[Name, ...], BeforeValidator(_listed)] = ()
    name: Annotated[str, Field(max_length=100)] = ""
    start: Annotated[Finite, Field(alias="from")]
    end: Annotated[Finite, Field(alias="to")]
    steps: Annotated[int, Field(strict=True, ge=2, le=MOST_STEPS)]
    spacing: Literal["linear", "log"] = "linear"
    unit: Annotated[str, Field(max_length=40)] = ""
    integer: StrictBool = False
    bisections: Annotated[int, Field(strict=True, ge=0, le=40)] = 6

    @field_validator("unit")
    @classmethod
    def _readable_unit(cls, value: str) -> str:
        if value:
            try:
                number_and_unit(value)
            except ValueError as error:
                raise fail(f"expected a number with a unit ({error})", value) from error
        return value

    @model_validator(mode="after")
    def _a_range(self) -> Vary:
        if not self.start < self.end:
            raise fail(f"expected from < to, got from = {self.start:g}, to = {self.end:g}")
        if self.spacing == "log" and self.start <= 0:
            raise fail("expected from > 0 for logarithmic spacing", self.start)
        return self

    @property
    def is_integer(self) -> bool:
        """Whether the parameter takes whole numbers only."""
        return self.integer or self.path == (RESOLUTION,)

    def halvings(self, effort: str) -> int:
        """Return the number of bisections of an interval."""
        return self.bisections if effort == "full" else self.bisections // 2

    def value(self, number: float) -> Any:
        """Return the value in the scene for a number: a multiple of the unit, as text."""
        if self.is_integer:
            return int(number)
        if not self.unit:
            return number
        factor, unit = number_and_unit(self.unit)
        return f"{float(number * factor)!r} {unit}"


class Claim(_Table):
    """A validated claim file; docs/claims.md explains every key."""

    id: str
    text: Prose
    equation: Annotated[str, Field(max_length=100)]
    reading: Literal["printed", "corrected"] = "printed"
    corrects: str | None = None
    scene: Name | None = None
    changes: dict[str, Any] = {}
    experiment: Name | None = None
    parameters: dict[str, Any] = {}
    vary: Vary | None = None
    method: KnownMethod = MODEL
    quantity: Names = ()
    at: Literal["penetration", "force"] | None = None
    measure: Literal[MEASURES] = "maximum"  # type: ignore[valid-type]
    tolerance: Positive
    tolerance_from: Literal["chapter", "ours"] = "ours"
    refuted_by: Prose
    theorem: Annotated[str, Field(max_length=500)] = ""
    expected: Literal[VERDICTS] | None = None  # type: ignore[valid-type]
    directory: str = Field(default=".", exclude=True)

    @field_validator("id")
    @classmethod
    def _slug(cls, value: str) -> str:
        if not re.fullmatch(r"[a-z0-9][a-z0-9-]{0,59}", value):
            raise fail("expected a slug of a-z, 0-9 and -, at most 60 characters", value)
        return value

    @field_validator("quantity")
    @classmethod
    def _claimable(cls, value: tuple[str, ...]) -> tuple[str, ...]:
        unknown = [name for name in value if name not in CLAIMED]
        if unknown:
            raise fail(f"expected quantities among {', '.join(CLAIMED)}", unknown)
        return value

    @property
    def source(self) -> str | Path:
        """The scene as an argument of `load_scene`: a file beside the claim, or a built-in name."""
        assert self.scene is not None
        beside = Path(self.directory) / self.scene
        return beside if beside.is_file() else self.scene

    @property
    def parameter(self) -> str:
        """The varied parameter in words, "" if there is none."""
        if self.vary is None:
            return ""
        parameter = EXPERIMENTS[self.experiment].parameter if self.experiment else ""
        return self.vary.name or parameter or ", ".join(self.vary.path)


def about_method(claims: list[Claim], method: str) -> list[Claim]:
    """Return the claims on scenes as claims about a method other than the reduced model.

    Nothing is expected of this method; claims with experiments are left out.

    Raises
    ------
    ClaimError
        If there is no such method, or no claim applies to it.
    """
    if method not in METHODS:
        raise ClaimError([f"--method: expected one of {', '.join(METHODS)}, got {method!r}"])
    about = [
        claim.model_copy(update={"method": method, "expected": None})
        for claim in claims
        if claim.scene is not None and claim.method == MODEL
    ]
    if not about:
        raise ClaimError([f"--method: no claim here is about a scene that {method} could solve"])
    return about


def load_claims(names: tuple[str, ...] = ()) -> list[Claim]:
    """Read claim files, or built-in claims by id; by default all, in the chapter's order.

    Raises
    ------
    ClaimError
        Lists all problems of all files.
    """
    builtin_paths = builtin_claims()
    claims, problems = [], []
    for name in names or tuple(builtin_paths):
        path = builtin_paths.get(name, Path(name))
        try:
            claims.append(_load(path))
        except ClaimError as error:
            problems += error.problems
    ids = [claim.id for claim in claims]
    problems += [
        f"{name}: expected different ids, two claims have this one"
        for name in sorted({claim_id for claim_id in ids if ids.count(claim_id) > 1})
    ]
    if problems:
        raise ClaimError(problems)
    return (
        claims
        if names
        else sorted(claims, key=lambda claim: chapter_order(claim.equation, claim.id))
    )


def _load(path: Path) -> Claim:
    if not path.is_file():
        raise ClaimError([f"{path}: no such claim or file; see `roughline list claims`"])
    try:
        data = read_toml(path)
    except ValueError as error:
        raise ClaimError([f"{path}: {error}"]) from error
    return make_claim(data, str(path), path.parent.resolve())


def make_claim(data: dict[str, Any], source: str, directory: Path) -> Claim:
    """Return the claim of a table; errors list all problems at once."""
    problems = _problems(data)
    try:
        claim = Claim.model_validate({**data, "directory": str(directory)})
        problems += _scene_problems(claim)
    except ValidationError as error:
        problems = [readable(problem) for problem in error.errors()] + problems
    if problems:
        raise ClaimError([f"{source}: {problem}" for problem in problems])
    return claim


def _problems(data: dict[str, Any]) -> list[str]:
    """Return problems between keys, even if single keys are invalid."""
    problems = ["directory: unknown key"] if "directory" in data else []
    kinds = [key for key in ("scene", "experiment") if key in data]
    if len(kinds) != 1:
        came = " and ".join(kinds) or "none"
        return [*problems, f"expected exactly one of scene and experiment, got {came}"]
    if kinds == ["experiment"]:
        # Values of other types are reported with the single keys.
        if isinstance(data["experiment"], str) and data["experiment"] not in EXPERIMENTS:
            experiments = ", ".join(EXPERIMENTS) or "none"
            problems.append(
                f"experiment: expected one of {experiments}, got {data['experiment']!r}"
            )
        return problems + [f"{key}: only with a scene" for key in ("changes", "at") if key in data]
    vary = data.get("vary")
    if isinstance(vary, dict) and not vary.get("path"):
        problems.append("vary.path: expected, but missing: which key of the scene varies")
    if "quantity" not in data:
        problems.append("quantity: expected, but missing")
    return problems + [f"{key}: only with an experiment" for key in ("parameters",) if key in data]


def _scene_problems(claim: Claim) -> list[str]:
    """Return the problems of the scene as modified by the claim, at both ends of the range."""
    if claim.scene is None:
        return []
    ends = (None,) if claim.vary is None else (claim.vary.start, claim.vary.end)
    scenes, problems = [], []
    for end in ends:
        try:
            scenes.append(load_scene(claim.source, overrides(claim, end)))
        except InputError as error:
            problems.append(f"scene: {error}")
    if claim.at is not None and any(scene.physics for scene in scenes):
        problems.append("at: expected nothing, steps of this scene are no loads to interpolate at")
    same = len(scenes) == 2 and scenes[0] == scenes[1]
    if same and claim.vary is not None and claim.vary.path != (RESOLUTION,):
        problems.append(f"vary.path: {', '.join(claim.vary.path)} changes nothing in the scene")
    return problems


def overrides(claim: Claim, number: float | None) -> dict[str, Any]:
    """Return the keys that a claim sets in its scene at a value of its parameter."""
    changed = dict(claim.changes)
    if claim.vary is not None and number is not None:
        changed |= {key: claim.vary.value(number) for key in claim.vary.path if key != RESOLUTION}
    computed = {AREA_FROM_STIFFNESS: "stiffness"} | dict.fromkeys(FIELDS, "pressure")
    changed["compare.quantities"] = list(dict.fromkeys(computed.get(q, q) for q in claim.quantity))
    changed["compare.tolerance"] = min(claim.tolerance, 0.5)
    return changed
