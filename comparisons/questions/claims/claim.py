"""Claims: precise, refutable statements about the reduced model (files: `families`).

A claim has two sides, what is stated and what is true, optionally a parameter along which the
statement is tested, and a tolerance. A side is a scene that is solved, or a number with its source.
What no scene can test is an experiment, which returns both sides. The same statement may occur
twice, literally as printed and as corrected, which ``reading`` distinguishes.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import Field, ValidationError, field_validator, model_validator

from comparisons.errors import InputError, ProblemsError
from comparisons.facts.methods import METHODS, MODEL, method_named
from comparisons.facts.quantities import COMPARABLE, DISTRIBUTIONS, FIELDS
from comparisons.questions.claims.families import HERE, builtin_claims, read_family
from comparisons.questions.claims.parameters import (
    RESOLUTION,
    Choice,
    Map,
    Name,
    Names,
    Nuisance,
    Place,
    Premise,
    Prose,
    Side,
    Vary,
)
from comparisons.questions.claims.record import HOLDS, VERDICTS
from comparisons.questions.claims.wording import limit_words
from comparisons.questions.experiments import EXPERIMENTS
from comparisons.reasons import near
from comparisons.scene.fields import KnownMethod, Positive, SceneTable, fail
from comparisons.scene.problems import in_file
from comparisons.scene.scene import Scene, load_scene

# The contact area that the equivalent diameter predicts from the true stiffness.
AREA_FROM_STIFFNESS = "area_from_stiffness"
# The depth that remains, over the penetration: its error is a share of the penetration.
REMAINING_SHARE = "remaining_share"
# Possible quantities of claims: those of scenes, and derived ones.
CLAIMED = tuple(dict.fromkeys((*COMPARABLE, *FIELDS, AREA_FROM_STIFFNESS, REMAINING_SHARE)))
MEASURES = ("maximum", "rms", "last")
SAYS = ("chapter", "literature", "ours")
# Keys of scenes that other keys of a claim set.
_SET_BY = {
    "compare.quantities": "quantity",
    "compare.tolerance": "tolerance",
    "compare.methods": "method",
}


class Claim(SceneTable):
    """A validated claim; docs/claims.md explains every key. A setting: nuisance key -> number."""

    id: str
    text: Prose
    equation: Annotated[str, Field(max_length=100)]
    reading: Literal["printed", "corrected"] = "printed"
    corrects: str | None = None
    says: Literal[SAYS] = "chapter"  # type: ignore[valid-type]
    citation: Annotated[str, Field(max_length=300)] = ""
    confirmed_by: Literal[VERDICTS] = HOLDS  # type: ignore[valid-type]
    scene: Name | None = None
    changes: dict[str, Any] = Field(default_factory=dict)
    stated: Side = Side()
    true: Side = Side()
    experiment: Name | None = None
    parameters: dict[str, Any] = Field(default_factory=dict)
    vary: Vary | None = None
    premise: Premise | None = None
    nuisance: tuple[Nuisance, ...] = ()
    draws: Annotated[int, Field(strict=True, ge=0, le=256)] = 8
    map: Map | None = None
    method: KnownMethod = MODEL
    quantity: Names = ()
    at: Literal["penetration", "force"] | None = None
    measure: Literal[MEASURES] = "maximum"  # type: ignore[valid-type]
    tolerance: Positive
    factor: Annotated[float, Field(gt=1, le=1000)] | None = None
    tolerance_from: Literal["chapter", "ours"] = "ours"
    refuted_by: Prose = ""  # by default an error beyond the tolerance
    theorem: Annotated[str, Field(max_length=500)] = ""
    expected: Literal[VERDICTS] | None = None  # type: ignore[valid-type]
    # Which number of a scene varies, and what stands still (`nearest`): of built-in claims only.
    nearest: Place | None = Field(None, exclude=True)
    fixed: dict[str, float | str] = Field(default_factory=dict, exclude=True)
    directory: str = Field(default=".", exclude=True)

    @model_validator(mode="before")
    @classmethod
    def _what_follows(cls, data: Any) -> Any:
        """Put f - 1, for a factor f between stated and true, as the tolerance."""
        if isinstance(data, dict) and isinstance(data.get("factor"), (int, float)):
            data = {"tolerance": data["factor"] - 1, **data}
        return data

    @model_validator(mode="after")
    def _literature_is_cited(self) -> Claim:
        if self.says == "literature" and not self.citation:
            raise fail("expected a citation of what the literature says")
        if self.premise is not None and self.vary is None:
            raise fail("expected vary, whose values have the premise", self.premise.to)
        keys = [nuisance.key for nuisance in self.nuisance]
        if len(set(keys)) < len(keys):
            raise fail("expected different nuisance parameters", keys)
        if self.map is not None and (self.vary is None or self.map.up not in keys):
            raise fail("expected a map of vary and a nuisance parameter", self.map.up)
        if self.factor is not None and self.tolerance != self.factor - 1:
            raise fail("expected either a factor or a tolerance")
        if self.stated.method is not None:
            raise fail("stated.method: expected none, the judged method is the claim's own")
        for side in (self.stated, self.true):
            if side.number is not None:
                side.in_si(self.quantity)
        if not self.refuted_by:
            limit = limit_words(self.tolerance, self.factor)
            where = f" at some {self.parameter}" if self.vary else ""
            object.__setattr__(self, "refuted_by", f"An error beyond {limit}{where}.")  # frozen
        return self

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

    def sides(self, number: float | None = None) -> tuple[Side, Side]:
        """Return what is stated and what is true at a value of the claim's parameter.

        Each with what the claim says of both; what a side sets itself does not vary.
        """
        changes = dict(self.changes)
        if self.vary is not None and number is not None:
            changes |= {k: self.vary.value(number) for k in self.vary.path if k != RESOLUTION}
        stated, true = (
            side.model_copy(
                update={
                    "scene": side.scene or self.scene,
                    # Its own keys come last: of a list and one of its members the later one counts.
                    "changes": {k: v for k, v in changes.items() if k not in side.changes}
                    | side.changes,
                }
            )
            for side in (self.stated, self.true)
        )
        return stated.model_copy(update={"method": self.method}), true

    @property
    def author(self) -> str:
        """Who says it: the chapter as printed or as corrected, the literature, or we."""
        if self.says == "chapter":
            return f"chapter, {self.reading}"
        return self.citation if self.says == "literature" else self.says

    @property
    def what(self) -> str:
        """What is measured, in words."""
        if self.experiment is not None:
            return EXPERIMENTS[self.experiment].title
        names = " and ".join(name.replace("_", " ") for name in self.quantity)
        at = f" at equal {self.at}" if self.at else ""
        stated, true = self.sides()
        parts = [] if true.same_scene(stated) else [true.words]
        parts += [METHODS[true.method].title] if true.method else []
        against = f", against {' by '.join(parts)}" if parts else ""
        return f"{names}{at} on {stated.words}{against}"

    @property
    def as_stated(self) -> dict[str, float]:
        """The setting at which the claim is measured along its own parameter."""
        return {nuisance.key: nuisance.stated_number for nuisance in self.nuisance}

    def under(self, setting: Mapping[str, float]) -> Claim:
        """Return the claim as it stands under a setting of its nuisance parameters."""
        values: dict[str, Choice] = {
            path: nuisance.value(setting[nuisance.key])
            for nuisance in self.nuisance
            for path in nuisance.path
        }
        place = "parameters" if self.experiment is not None else "changes"
        return self.model_copy(update={place: {**getattr(self, place), **values}})

    @property
    def parameter(self) -> str:
        """The varied parameter in words, "" if there is none."""
        if self.vary is None:
            return ""
        parameter = EXPERIMENTS[self.experiment].parameter if self.experiment else ""
        return self.vary.name or parameter or ", ".join(self.vary.path)


def about_method(claims: list[Claim], method: str) -> list[Claim]:
    """Return the claims on scenes as claims about a method other than the reduced model.

    Nothing is expected of this method, and no theorem is about it; claims with experiments are left
    out. InputError if there is no such method, or no claim applies to it.
    """
    method = method_named(method)
    about = [
        claim.model_copy(update={"method": method, "expected": None, "theorem": ""})
        for claim in claims
        if claim.experiment is None and claim.stated.number is None and claim.method == MODEL
    ]
    if not about:
        raise ProblemsError(f"--method: no claim here is about a scene that {method} could solve")
    return about


def load_claims(names: tuple[str, ...] = ()) -> list[Claim]:
    """Return built-in claims by id and all of files, by default all; or all problems."""
    builtin = builtin_claims()
    claims: list[Claim] = []
    problems: list[str] = []
    for name in names or builtin:
        try:
            if name in builtin:
                claims.append(make_claim(builtin[name], name, HERE))
                continue
            path = Path(name)
            if not path.is_file():
                where = "see `roughline list claims`"
                told = f"{path}: no such claim or file; {where}{near(name, builtin)}"
                raise ProblemsError(told)
            for member, keys in read_family(path).items():
                claims.append(make_claim(keys, f"{path}: {member}", path.parent.resolve()))
        except ProblemsError as error:
            problems += error.problems
        except ValueError as error:
            problems.append(f"{name}: {error}")
    ids = [claim.id for claim in claims]
    problems += [
        f"{name}: expected different ids, two claims have this one"
        for name in sorted({claim_id for claim_id in ids if ids.count(claim_id) > 1})
    ]
    if problems:
        raise ProblemsError(*problems)
    return claims


def make_claim(data: dict[str, Any], source: str, directory: Path) -> Claim:
    """Return the claim of a table; errors list all problems at once."""
    problems = _key_problems(data)
    try:
        claim = Claim.model_validate({**data, "directory": str(directory)})
        if claim.experiment is None:
            problems += [p for which in (0, 1) for p in _scene_problems(claim, which)]
    except ValidationError as error:
        problems = in_file(error, Claim) + problems
    if problems:
        raise ProblemsError(*(f"{source}: {problem}" for problem in problems))
    return claim


def _key_problems(data: dict[str, Any]) -> list[str]:
    """Return problems between keys, even if single keys are invalid."""
    problems = ["directory: unknown key"] if "directory" in data else []
    sides = [data.get(key) for key in ("stated", "true")]
    whole = [isinstance(side, dict) and not {"scene", "number"}.isdisjoint(side) for side in sides]
    kinds = [key for key in ("scene", "experiment") if key in data]
    if len(kinds) != 1 and not (all(whole) and not kinds):
        came = " and ".join(kinds) or "none"
        return [*problems, f"expected exactly one of scene and experiment, got {came}"]
    if kinds == ["experiment"]:
        # Values of other types are reported with the single keys.
        if isinstance(data["experiment"], str) and data["experiment"] not in EXPERIMENTS:
            experiments = ", ".join(EXPERIMENTS) or "none"
            problems.append(
                f"experiment: expected one of {experiments}, got {data['experiment']!r}"
            )
        of_scenes = ("changes", "at", "stated", "true")
        return problems + [f"{key}: only with a scene" for key in of_scenes if key in data]
    vary, nuisances, changes = (data.get(key) for key in ("vary", "nuisance", "changes"))
    if isinstance(vary, dict) and not vary.get("path"):
        problems.append("vary.path: expected, but missing: which key of the scene varies")
    if "quantity" not in data:
        problems.append("quantity: expected, but missing")
    if "at" in data and any(sides):
        problems.append("at: expected nothing where the sides are apart")
    open_keys = [vary, *(nuisances if isinstance(nuisances, list) else ())]
    paths = [table.get("path") for table in open_keys if isinstance(table, dict)]
    keys = {str(k) for path in paths for k in (path if isinstance(path, list) else [path])}
    tables = [changes, *(side.get("changes") for side in sides if isinstance(side, dict))]
    keys |= {key for table in tables if isinstance(table, dict) for key in table}
    problems += [
        f"{key}: expected no value, because the claim's own key `{_SET_BY[key]}` sets it"
        for key in _SET_BY
        if key in keys
    ]
    return problems + [f"{key}: only with an experiment" for key in ("parameters",) if key in data]


def _scene_problems(claim: Claim, which: int) -> list[str]:
    """Return the problems of a side's scene as the claim changes it, at the ends of its ranges."""
    stated, true = claim.sides()
    side = (stated, true)[which]
    if not side.solved or side.scene is None or (which and true.same_scene(stated)):
        return []
    problems: list[str] = []

    def at(setting: Mapping[str, float], number: float | None) -> Scene | None:
        there = claim.under(setting)
        try:
            return scene_of(there, there.sides(number)[which])
        except InputError as error:
            problems.append(f"scene: {error}")
            return None

    ends = (None,) if claim.vary is None else (claim.vary.start, claim.vary.end)
    scenes = [at(claim.as_stated, end) for end in ends]
    for nuisance in claim.nuisance:
        others = [
            at({**claim.as_stated, nuisance.key: number}, ends[0])
            for number in nuisance.numbers()
            if number != nuisance.stated_number
        ]
        if scenes[0] in [scene for scene in others if scene is not None]:
            problems.append(f"nuisance: {nuisance.key} changes nothing in the scene")
    if claim.at is not None and any(scene is not None and scene.physics for scene in scenes):
        problems.append("at: expected nothing, steps of this scene are no loads to interpolate at")
    same = len(scenes) == 2 and scenes[0] is not None and scenes[0] == scenes[1]
    if same and not which and claim.vary is not None and claim.vary.path != (RESOLUTION,):
        problems.append(f"vary.path: {', '.join(claim.vary.path)} changes nothing in the scene")
    return problems


def scene_of(claim: Claim, side: Side, more: Mapping[str, Any] | None = None) -> Scene:
    """Return the scene of a side (a file beside the claim, or built-in), with changed keys."""
    assert side.scene is not None
    beside = Path(claim.directory) / side.scene
    computed = {AREA_FROM_STIFFNESS: "stiffness", REMAINING_SHARE: "residual_depth"}
    computed |= {name: "pressure" for name in FIELDS if name not in DISTRIBUTIONS}
    quantities = list(dict.fromkeys(computed.get(q, q) for q in claim.quantity))
    compared = {"compare.quantities": quantities, "compare.tolerance": min(claim.tolerance, 0.5)}
    source = beside if beside.is_file() else side.scene
    return load_scene(source, {**side.changes, **compared, **(more or {})})
