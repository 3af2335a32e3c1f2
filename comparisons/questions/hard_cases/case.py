"""A hard case: a scene, its reference, and the outcome of every method, expected and found.

References may be formulas, exact up to round-off. What was found is stored in
hard-cases.json and hard-cases.csv, which are validated when read.
"""

from __future__ import annotations

import math
import re
import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal, NamedTuple, cast

import numpy as np
from pydantic import (
    AfterValidator,
    BeforeValidator,
    Field,
    ValidationError,
    ValidationInfo,
    field_validator,
    model_validator,
)

from comparisons.errors import ProblemsError
from comparisons.facts.methods import BUILT_IN
from comparisons.facts.quantities import COMPARABLE
from comparisons.files import read_toml
from comparisons.reasons import near
from comparisons.results.folder import Form, Header, read_record
from comparisons.scene.fields import Length, Positive, SceneTable, fail
from comparisons.scene.problems import readable
from comparisons.scene.scene import Scene, SceneError, make_scene, override

if TYPE_CHECKING:
    from comparisons.geometry.prepare import RoughGeometry
    from comparisons.solving.plan import Plan

RECORD, TABLE = "hard-cases.json", "hard-cases.csv"
ACCURATE, DEGRADED, REFUSED, NOT_FOR = ("accurate", "degraded", "refused", "not for")
OUTCOME_KEYS = ("accurate", "degraded", "refused", "not_for")
# Largest error of an accurate outcome; larger errors count as degraded.
ACCURATE_TO = 0.01
# Methods with expected outcomes; outcomes of other methods are only shown.
JUDGED = tuple(name for name, row in BUILT_IN.items() if not row.peer)
# Those that have one in every case: the others run where a scene names them.
EVERYWHERE = tuple(name for name in JUDGED if not BUILT_IN[name].on_request)

Judged = Literal[JUDGED]  # type: ignore[valid-type]
Text = Annotated[str, Field(min_length=1, max_length=500)]
Count = Annotated[int, Field(strict=True, ge=1)]


Bounds = Annotated[
    tuple[Positive, ...],
    BeforeValidator(lambda value: value if isinstance(value, (list, tuple)) else (value,)),
    Field(min_length=1, max_length=2),
]
Curves = dict[str, np.ndarray]


def _npy(name: str) -> str:
    if not re.fullmatch(r"[a-z0-9-]+\.npy", name):
        raise fail("expected a file name of a-z, 0-9 and - that ends in .npy", name)
    return name


MapName = Annotated[str, AfterValidator(_npy)]


class Expected(SceneTable):
    """Expected outcome of a method in a case, by exactly one of the first four keys."""

    # Largest relative error over the load steps, first of the main quantity
    # (the force at equal penetration, the penetration at equal force, or the first compared
    # quantity for other physics), then of the contact area, both including the bar of the
    # reference. An omitted error is not bounded, for lack of a reference.
    accurate: Bounds = ()
    degraded: Bounds = ()
    # No number, for a reason that contains this text.
    refused: Annotated[str, Field(max_length=500)] = ""
    # The method is not intended for such a scene, for a reason that contains this text.
    not_for: Annotated[str, Field(max_length=500)] = ""
    # The load steps without an answer, counted from 0.
    lost: tuple[Annotated[int, Field(strict=True, ge=0)], ...] = ()
    text: Annotated[str, Field(max_length=500)] = ""  # part of the reason of the lost steps
    why: Annotated[str, Field(max_length=500)] = ""  # reason for a degraded outcome

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
        """The outcome as shown in tables."""
        return next(key for key in OUTCOME_KEYS if getattr(self, key)).replace("_", " ")

    @property
    def error(self) -> float:
        """Largest relative error of the main quantity, NaN without a number."""
        return (self.accurate or self.degraded or (math.nan,))[0]

    @property
    def area(self) -> float:
        """Largest relative error of the contact area, NaN if unbounded."""
        return (*(self.accurate or self.degraded), math.nan, math.nan)[1]

    @property
    def reason(self) -> str:
        """Part of the reason of a refusal or of lost steps."""
        return self.refused or self.not_for or self.text


# The keys of a scene that formulas need.
_NEEDED = {
    "hertz": ("surface", "loading.penetration"),
    "stuck": ("indenter.radius", "friction", "loading.tangential_force"),
    "creeping": ("indenter.radius", "viscoelastic", "sliding"),
    "closed_gap": ("surface",),
}
_Used = Literal[True] | None


class Formula(SceneTable):
    """Exactly one formula of the planned scene at its steps."""

    constant: dict[Literal[COMPARABLE], float] | None = None  # type: ignore[valid-type]
    # F = 4/3 E* sqrt(R) d^1.5, A = pi R d for a tip that the scene samples by a map: its radius.
    hertz: Length | None = None
    # u = F_x/(2 a G*) (Mindlin 1949): stick in the whole Hertzian contact, at the last normal
    # force; at mu = 1e6 a rim of 1e-7 slips.
    stuck: _Used = None
    # mu = (eta/G) v/R, eta = sum G_i tau_i: the 3-D limit of slow sliding on rubber.
    creeping: _Used = None
    # Full contact of a periodic surface, the first one: d = max h - <h>, A = A0.
    closed_gap: _Used = None

    @model_validator(mode="after")
    def _exactly_one(self) -> Formula:
        if len(self.model_fields_set) != 1:
            got = " and ".join(sorted(self.model_fields_set)) or "none"
            keys = ", ".join(type(self).model_fields)
            raise fail(f"expected exactly one of {keys}, got {got}")
        return self

    def missing(self, scene: Scene) -> list[str]:
        """Return the keys that the formula needs and the scene lacks."""
        (name,) = self.model_fields_set
        return [key for key in _NEEDED.get(name, ()) if _at(scene, key) is None]

    def curves(self, plan: Plan) -> Curves:
        """Return the quantities; those that no load changes are equal at all steps."""
        scene, loads = plan.scene, plan.loads.values
        modulus, radius, found = scene.effective_modulus, _at(scene, "indenter.radius"), {}
        if self.constant is not None:
            found = dict(self.constant)
        elif self.hertz is not None:
            force = 4 / 3 * modulus * np.sqrt(self.hertz) * loads**1.5
            found = {"force": force, "contact_area": np.pi * self.hertz * loads}
        elif self.stuck:
            assert plan.loads.normal is not None
            contact = np.cbrt(0.75 * plan.loads.normal.values[-1] / modulus * radius)
            shift = loads / (2 * contact * scene.tangential_modulus)
            found = {"tangential_displacement": shift, "contact_area": np.pi * contact**2}
        elif self.creeping:
            material = scene.viscoelastic
            assert material is not None
            viscosity = sum(stiff * time for stiff, time in material.branches)
            slope = viscosity / material.long_term_modulus / radius
            found = {"friction_coefficient": slope * loads}
        elif self.closed_gap:
            rough = cast("RoughGeometry", plan.geometry)
            depth = rough.top(0) - rough.heights(0, rough.points[0]).mean()
            found = {"penetration": depth, "contact_area": rough.area}
        return {name: values * np.ones(loads.size) for name, values in found.items()}


def _at(scene: Scene, path: str) -> Any:
    table: Any = scene
    for key in path.split("."):
        table = getattr(table, key, None)
    return table


class Truth(SceneTable):
    """The reference: a method at several resolutions, or a formula."""

    # The answer at the finest resolution counts; the differences between
    # resolutions give its bar. With a single resolution the bar covers the solver, not the grid.
    method: Judged = "closed_form"
    resolutions: Annotated[tuple[Count, ...], Field(min_length=1)] = (1,)
    # Keys, by path, in which the scene of the reference differs from that of the case.
    scene: dict[str, Any] = Field(default={})
    formula: Formula | None = None  # the answer, exact up to round-off
    source: Annotated[str, Field(max_length=500)] = ""  # its origin

    @model_validator(mode="after")
    def _solved_or_known(self) -> Truth:
        solved = sorted(self.model_fields_set & {"method", "resolutions", "scene"})
        if self.formula is not None and solved:
            raise fail(f"expected a formula or a method that solves, got {' and '.join(solved)}")
        if bool(self.formula) != bool(self.source):
            raise fail("expected a source beside a formula, and nowhere else")
        return self


class HardCase(SceneTable):
    """One entry of the catalogue."""

    id: Annotated[str, Field(max_length=60)]  # a slug
    title: Text
    hard: Text  # the difficulty, in one sentence
    # Keys of the scene, by path; its name is the id.
    scene: Annotated[dict[str, Any], Field(min_length=1)]
    # Files named in the scene, with recipes of their heights.
    maps: dict[MapName, Recipe] = Field(default={})
    truth: Truth = Truth()  # the reference, by default the scene's closed form
    # Reason for not running methods without an expectation; absent if all are run.
    only: Annotated[str, Field(max_length=500)] = ""
    expected: dict[Judged, Expected]  # outcomes by method, for all methods unless `only` is given
    # By method; by default those of ``roughline solve``.
    resolutions: dict[Judged, Count] = Field(default={})
    # Methods run by ``--full`` only: finite elements take seconds, others milliseconds.
    slow: frozenset[Judged] = frozenset({"fem", "mca"})

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
        missing = [name for name in EVERYWHERE if name not in value]
        if missing and not info.data.get("only"):
            raise fail(f"expected something of every method, got nothing of {', '.join(missing)}")
        return value

    def expects(self, method: str) -> Expected | None:
        """Return the expected outcome of a method, or None."""
        only = Expected(not_for=self.only) if self.only else None
        return self.expected.get(method, only)

    def scene_in(self, folder: Path, changes: dict[str, Any] | None = None) -> Scene:
        """Return the scene with its maps in a folder, and changed keys; or SceneError."""
        data: dict[str, Any] = {"name": self.id}
        for path, value in (self.scene | (changes or {})).items():
            override(data, path, deepcopy(value))
        return make_scene(data, f"{self.id}.toml", folder)

    def write_maps(self, folder: Path) -> None:
        """Write the maps named in the scene."""
        for name, recipe in self.maps.items():
            np.save(folder / name, recipe.heights(self.maps))


Seed = Annotated[int, Field(strict=True, ge=0)]
MAKERS = ("self_affine", "paraboloid", "checkerboard", "level")


class RoughMap(SceneTable):
    """A rough surface as in scenes: the first realisation of `reference.surfaces.self_affine`."""

    hurst: Annotated[Positive, Field(le=1)]
    rms_slope: Positive
    seed: Seed


class Point(SceneTable):
    """A replaced height at one point, in metres."""

    index: tuple[Seed, Seed]
    height: float


class Recipe(SceneTable, populate_by_name=True):
    """Recipe of a square map: made by one of the first five keys, then modified in this order."""

    # Another map of the case, which has no `from` itself; else points and side of the
    # map, and one of the four that follow.
    start: Annotated[str, Field(alias="from")] = ""
    points: Annotated[int, Field(strict=True, ge=2, le=4096)] = 0
    side: Length = 0.0
    self_affine: RoughMap | None = None  # a rough surface
    paraboloid: Length | None = None  # radius of a tip in the middle, symmetric to the last digit
    checkerboard: Length | None = None  # amplitude of alternating heights
    level: float | None = None  # height of all points, in metres
    factor: Positive | None = None  # factor of the heights
    seed: Seed = 0
    # Relative standard deviation of normal errors, drawn with the seed.
    noise: Positive | None = None
    # Approximate fraction of points without height (NaN), drawn with the seed.
    undefined: Annotated[Positive, Field(le=1)] | None = None
    point: Point | None = None  # a height to be replaced
    step: Length | None = None  # quantisation of the heights
    cut: float | None = None  # upper limit of heights, in metres
    # Data type of the stored heights.
    precision: Literal["float64", "float32", "float16"] = "float64"

    @model_validator(mode="after")
    def _one_start(self) -> Recipe:
        makers = [key for key in MAKERS if getattr(self, key) is not None]
        came = makers + ["from"] * bool(self.start)
        if len(came) != 1:
            got = " and ".join(came) or "none"
            raise fail(f"expected exactly one of from, {', '.join(MAKERS)}, got {got}")
        if makers and not (self.points and self.side):
            raise fail(f"expected points and side beside {makers[0]}")
        return self

    def heights(self, maps: Mapping[str, Recipe]) -> np.ndarray:
        """Return the map; `maps` are those of the case by name."""
        from reference.surfaces import SelfAffine, self_affine

        grid = (self.points, self.points)
        if self.start:
            heights = maps[self.start].heights(maps)
        elif self.self_affine is not None:
            rough = self.self_affine
            spectrum = SelfAffine(hurst=rough.hurst, rms_slope=rough.rms_slope)
            sides = (self.side, self.side)
            heights = self_affine(grid, sides, spectrum, seed=rough.seed, realisation=0).copy()
        elif self.paraboloid is not None:
            x = (np.arange(self.points) - (self.points - 1) / 2) * self.side / self.points
            heights = -(x[:, None] ** 2 + x**2) / (2 * self.paraboloid)
        elif self.checkerboard is not None:
            places = np.arange(self.points)
            heights = self.checkerboard * (-1.0) ** np.add.outer(places, places)
        else:
            heights = np.full(grid, self.level)
        random = np.random.default_rng(self.seed)
        if self.factor is not None:
            heights = heights * self.factor
        if self.noise is not None:
            heights = heights * (1 + self.noise * random.normal(size=heights.shape))
        if self.undefined is not None:
            heights[random.random(heights.shape) < self.undefined] = np.nan
        if self.point is not None:
            heights[self.point.index] = self.point.height
        if self.step is not None:
            heights = np.round(heights / self.step) * self.step
        if self.cut is not None:
            heights = np.minimum(heights, self.cut)
        return heights.astype(self.precision)


class OutcomeRecord(Form):
    """Outcome of a method in a case; None for missing numbers."""

    case: str
    title: str
    method: str
    # "accurate", "degraded", "refused", "not for", or "lost" (a number is missing unexpectedly).
    kind: str
    # Largest relative errors over the load steps (main quantity, contact area) and the bar of the
    # reference for the main quantity.
    error: float | None = None
    area_error: float | None = None
    bar: float | None = None
    seconds: float | None = None
    resolution: int = 0  # 0 without a solve
    reason: str = ""  # reason for a missing number or lost steps
    lost: list[int] = Field(default=[])  # load steps without an answer
    expected: str = ""  # the expectation in words; "" if there is none (a user-supplied method)
    # Difference of the outcome from the expectation in words; "" if there is none.
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
    def cases(self) -> dict[str, dict[str, OutcomeRecord]]:
        """Case -> method -> outcome."""
        cases: dict[str, dict[str, OutcomeRecord]] = {}
        for outcome in self.outcomes:
            cases.setdefault(outcome.case, {})[outcome.method] = outcome
        return cases

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
    """Read the outcomes in a folder; ResultsError if there are none, or the file is invalid."""
    missing = f"{directory}: no hard cases were run here"
    return read_record(HardCasesRecord, directory / RECORD, missing)


FOLDER = Path(__file__).parent
# Key of an expectation that applies to all methods.
ALL = "all"


class Family(SceneTable):
    """A file of hard cases."""

    order: float = math.inf  # position of its cases relative to other files; by default last
    like: str = ""  # the default baseline of its cases
    # Common keys of cases, by name; available to all files.
    baselines: dict[str, dict[str, Any]] = Field(default={})
    # The keys of a `HardCase` by its id, and `like`: the baseline that they override.
    cases: dict[str, dict[str, Any]] = Field(default={})


class Layer(NamedTuple):
    """The keys of a case or baseline as written in its file, and their location."""

    source: str
    keys: Mapping[str, Any]


@cache
def catalogue() -> Mapping[str, HardCase]:
    """Return the built-in hard cases by id, ordered by family."""
    return {case.id: case for case in read_cases(builtin_files())}


def builtin_files() -> list[Path]:
    """Return the files of the built-in cases."""
    return sorted(FOLDER.glob("*.toml"))


def load_cases(names: Iterable[str]) -> list[HardCase]:
    """Return cases by id, and all of user files; ProblemsError lists all problems of both."""
    builtin_cases, files, problems = catalogue(), [], []
    for name in names:
        if name not in builtin_cases and Path(name).is_file():
            files.append(Path(name))
        elif name not in builtin_cases:
            problem = f"--case: no such case or file: {name!r}; see `roughline list hard-cases`"
            problems.append(problem + near(name, builtin_cases))
    file_cases: list[HardCase] = []
    try:
        file_cases = read_cases(files, builtin_files())
    except ProblemsError as error:
        problems += error.problems
    if problems:
        raise ProblemsError(*problems)
    chosen = [builtin_cases[name] for name in names if name in builtin_cases]
    return list({case.id: case for case in (*chosen, *file_cases)}.values())


def read_cases(files: Iterable[Path], context_files: Iterable[Path] = ()) -> list[HardCase]:
    """Return the cases of files, which may use baselines of others, or all their problems."""
    problems: list[str] = []
    families, context = _families(files, problems), _families(context_files, problems)
    baselines: dict[str, Layer] = {}
    names: Counter[str] = Counter()
    for file, family in (*context, *families):
        names.update(list(family.cases))
        for name, keys in family.baselines.items():
            layer = Layer(f"{file}: baselines.{name}", keys)
            if name in baselines:
                problems.append(f"{layer.source}: expected a name that is not taken")
            baselines[name] = layer
    cases: list[HardCase] = []
    for file, family in families:
        shared = {"like": family.like} if family.like else {}
        for name, keys in family.cases.items():
            lineage = [Layer(f"{file}: {name}", shared | keys)]  # with its successive baselines
            if names[name] > 1:
                problems.append(f"{lineage[0].source}: expected an id that is not taken")
            while "like" in lineage[-1].keys:
                source, like = lineage[-1].source, lineage[-1].keys["like"]
                if not isinstance(like, str) or like not in baselines:
                    known = ", ".join(baselines) or "none"
                    problems.append(f"{source}: like: expected one of {known}, got {like!r}")
                    break
                if baselines[like] in lineage:
                    circle = f"expected no circle, {like} is like this one"
                    problems.append(f"{source}: like: {circle}")
                    break
                lineage.append(baselines[like])
            merged: dict[str, Any] = {}
            for layer in reversed(lineage):
                merged = _put_over(merged, layer.keys)
            if "id" in merged:
                problems.append(f"{_owner(('id',), lineage).source}: id: unknown key")
            try:
                case = HardCase.model_validate(merged | {"id": name})
            except ValidationError as error:
                problems += [
                    f"{_owner(problem['loc'], lineage).source}: {readable(problem)}"
                    for problem in error.errors()
                ]
                continue
            problems += [f"{lineage[0].source}: {problem}" for problem in _scene_problems(case)]
            cases.append(case)
    if problems:
        raise ProblemsError(*dict.fromkeys(problems))
    return cases


def _families(files: Iterable[Path], problems: list[str]) -> list[tuple[Path, Family]]:
    """Return the families of files in order; errors are appended to the problems."""
    families = []
    for file in files:
        try:
            families.append((file, Family.model_validate(read_toml(file))))
        except ValidationError as error:
            problems += [f"{file}: {readable(problem)}" for problem in error.errors()]
        except ValueError as error:
            problems.append(f"{file}: {error}")
    return sorted(families, key=lambda pair: pair[1].order)


def _owner(location: tuple[int | str, ...], lineage: list[Layer]) -> Layer:
    """Return the layer that defines the value at a location, by default the case."""
    for layer in lineage:
        table: Any = layer.keys
        for key in location[:2]:
            table = table.get(key) if isinstance(table, Mapping) else None
        if table is not None:
            return layer
    return lineage[0]


def _put_over(base: Mapping[str, Any], keys: Mapping[str, Any]) -> dict[str, Any]:
    """Merge scenes by path, expectations by method, maps by file; other keys replace."""
    merged = {**base, **keys}
    merged.pop("like", None)
    for name in ("scene", "expected", "maps"):
        old, new = base.get(name, {}), keys.get(name, {})
        if not (isinstance(old, Mapping) and isinstance(new, Mapping) and (old or new)):
            continue
        merged[name] = {**old, **new}
        if name == "expected":
            merged[name] = dict.fromkeys(JUDGED, new[ALL]) if ALL in new else dict(old)
            for method, change in new.items():
                before = merged[name].get(method)
                if method == ALL:
                    continue
                if isinstance(before, Mapping) and isinstance(change, Mapping):
                    # another outcome replaces the baseline's, else it is completed by it
                    another = any(key in change and key not in before for key in OUTCOME_KEYS)
                    if not (another and any(key in before for key in OUTCOME_KEYS)):
                        change = {**before, **change}
                merged[name][method] = change
        if name == "scene":
            merged[name] = deepcopy(dict(old))
            for path, value in new.items():
                override(merged[name], path, deepcopy(value))
    return merged


def _scene_problems(case: HardCase) -> list[str]:
    """Return problems of the scene or the reference's scene, except for expected refusals."""
    with tempfile.TemporaryDirectory(prefix="roughline-") as folder:
        for name in case.maps:
            (Path(folder) / name).touch()
        try:
            scene = case.scene_in(Path(folder))
        except SceneError as error:
            expected = all(
                expectation.kind == REFUSED and expectation.reason in str(error)
                for expectation in case.expected.values()
            )
            return [] if expected else [f"scene: {problem}" for problem in error.problems]
        try:
            case.scene_in(Path(folder), case.truth.scene)
        except SceneError as error:
            return [f"truth.scene: {problem}" for problem in error.problems]
        file = getattr(scene.surface, "file", "")
        if file and not (Path(folder) / file).is_file():
            return [f"scene: surface.file: expected a file, or one of maps, got {file!r}"]
    missing = case.truth.formula.missing(scene) if case.truth.formula is not None else []
    return [f"truth.formula: expected {key} in the scene, which has none" for key in missing]
