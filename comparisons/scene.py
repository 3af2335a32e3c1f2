"""Scenes: the validated form of a scene file.

``load_scene`` reads TOML, converts units, and lists everything that is wrong at once, each
problem with its path in the file, what was expected and what came.
"""

from __future__ import annotations

import json
import re
import tomllib
from collections.abc import Mapping
from functools import cached_property
from pathlib import Path
from typing import Annotated, Any, Literal

from pydantic import (
    BaseModel,
    BeforeValidator,
    ConfigDict,
    Discriminator,
    Field,
    StrictBool,
    Tag,
    ValidationError,
    field_validator,
    model_validator,
)

from comparisons import body_table
from comparisons.body_table import Body
from comparisons.errors import InputError
from comparisons.loading import Loading
from comparisons.options import MethodName, MethodOptions
from comparisons.quantities import Finite, Length, Modulus, Positive, fail, shown
from comparisons.shapes import SHAPES, AnyIndenter

QUANTITIES = (
    *("force", "penetration", "penetration_mean_plane", "contact_area", "contact_area_raw"),
    *("contact_radius", "equivalent_radius", "stiffness", "mean_gap", "contact_length"),
    *("contact_length_stiffness", "contact_count", "pressure", "energy"),
)
DEFAULT_QUANTITIES = ("force", "penetration", "contact_area")
FEM_DEFAULT_POISSON = 0.3
LARGEST_FILE = 10_000_000
# The parser's time and memory grow with the square of the parts of a dotted key.
DEEPEST_KEY = 20
KEYS = re.compile(r"^[ \t]*\[{0,2}((?:[\w\"'-]+[ \t]*\.[ \t]*)+)", re.MULTILINE)
MOST_PROBLEMS = 50
BARE = re.compile(r"[A-Za-z0-9_-]+")


class SceneError(InputError):
    """A scene file is wrong; ``problems`` lists every one of them."""

    def __init__(self, source: str, problems: list[str]) -> None:
        more = len(problems) - MOST_PROBLEMS
        if more > 0:
            problems = [*problems[:MOST_PROBLEMS], f"... and {more} more"]
        self.source = source
        self.problems = problems
        super().__init__(f"{source}:\n" + "\n".join(f"  {each}" for each in problems))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.source, self.problems)


class _Table(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True, populate_by_name=True)


class HalfSpace(_Table):
    """Elastic half-space: E and nu, or G and nu, or E* alone."""

    youngs_modulus: Modulus | None = None
    shear_modulus: Modulus | None = None
    effective_modulus: Modulus | None = None
    poisson_ratio: float | None = None

    @field_validator("poisson_ratio", mode="before")
    @classmethod
    def _poisson_range(cls, value: Any) -> Any:
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not -1 < value <= 0.5:
            raise fail("expected a number with -1 < nu <= 0.5", value)
        return float(value)

    @model_validator(mode="after")
    def _one_way(self) -> HalfSpace:
        given = {name for name in type(self).model_fields if getattr(self, name) is not None}
        ways = (
            {"youngs_modulus", "poisson_ratio"},
            {"shear_modulus", "poisson_ratio"},
            {"effective_modulus"},
        )
        if given not in ways:
            raise fail(
                "expected youngs_modulus and poisson_ratio, or shear_modulus and poisson_ratio, "
                f"or effective_modulus alone, got {', '.join(sorted(given)) or 'nothing'}"
            )
        return self

    @property
    def modulus(self) -> float:
        """Effective modulus E* = E / (1 - nu^2) = 2 G / (1 - nu)."""
        if self.effective_modulus is not None:
            return self.effective_modulus
        nu = self.poisson_ratio or 0.0
        if self.shear_modulus is not None:
            return 2 * self.shear_modulus / (1 - nu)
        assert self.youngs_modulus is not None
        return self.youngs_modulus / (1 - nu**2)

    @property
    def elastic_constants(self) -> tuple[float, float]:
        """E and nu; nu = 0.3 where only E* is given (normal contact depends on E* alone)."""
        nu = FEM_DEFAULT_POISSON if self.poisson_ratio is None else self.poisson_ratio
        return self.modulus * (1 - nu**2), nu


def _pair(value: Any) -> Any:
    return tuple(value) if isinstance(value, (list, tuple)) else (value, value)


# TOML has whole numbers and switches of its own: "64", 64.0 or true in their place are mistakes.
Points = Annotated[int, Field(strict=True, ge=4, le=2**20)]
Seed = Annotated[int, Field(strict=True, ge=0, lt=2**63)]
Count = Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
Index = Annotated[int, Field(strict=True, ge=0)]
Window = Annotated[int, Field(strict=True, ge=2)]
PointsPair = Annotated[tuple[Points, Points], BeforeValidator(_pair)]
SizePair = Annotated[tuple[Length, Length], BeforeValidator(_pair)]


class SelfAffine(_Table):
    """A synthetic self-affine surface, (19.22) with fixed amplitudes and random phases."""

    kind: Literal["self_affine"]
    size: SizePair
    points: PointsPair
    hurst: Annotated[Finite, Field(ge=0, le=1)] | None = None
    power: Annotated[Finite, Field(ge=0, le=8)] | None = None
    rms_slope: Positive | None = None
    rms_height: Length | None = None
    long_cutoff: Length | None = None
    short_cutoff: Length | None = None
    periodic: StrictBool = False
    seed: Seed = 0
    realisations: Count = 1

    @model_validator(mode="after")
    def _complete(self) -> SelfAffine:
        problems = []
        if (self.hurst is None) == (self.power is None):
            problems.append("expected exactly one of hurst and power")
        if (self.rms_slope is None) == (self.rms_height is None):
            problems.append("expected exactly one of rms_slope and rms_height")
        shortest = 2 * max(s / n for s, n in zip(self.size, self.points, strict=True))
        short = self.short_cutoff or shortest
        long = self.long_cutoff or min(self.size)
        if short < shortest * (1 - 1e-9):
            problems.append(
                f"short_cutoff: expected at least 2 cells = {shortest:g} m, got {short:g} m"
            )
        if not short <= long <= max(self.size) * (1 + 1e-9):
            problems.append(
                f"long_cutoff: expected from short_cutoff = {short:g} m to the side "
                f"{max(self.size):g} m, got {long:g} m"
            )
        if problems:
            raise fail("; ".join(problems))
        return self


class MeasuredMap(_Table):
    """A measured surface, read and treated by comparisons.topography."""

    kind: Literal["map"]
    file: Annotated[str, Field(min_length=1, max_length=4096)]
    size: SizePair | None = None
    height_unit: Annotated[str, Field(max_length=20)] | None = None
    channel: Annotated[str, Field(max_length=200)] | None = None
    detrend: Literal["none", "mean", "tilt", "curvature"] = "tilt"
    crop: tuple[Index, Index, Window, Window] | None = None
    invert: StrictBool = False
    undefined: Literal["interpolate", "lowest", "refuse"] | None = None
    periodic: StrictBool = False
    seed: Seed = 0
    realisations: Count = 100


def _kind(value: Any) -> str | None:
    return value.get("kind") if isinstance(value, dict) else getattr(value, "kind", None)


Surface = Annotated[
    Annotated[SelfAffine, Tag("self_affine")] | Annotated[MeasuredMap, Tag("map")],
    Discriminator(_kind),
]


class Compare(_Table):
    """What is compared, how well, and by which methods."""

    quantities: tuple[Literal[QUANTITIES], ...] = DEFAULT_QUANTITIES  # type: ignore[valid-type]
    tolerance: Positive = 0.01
    resolutions: tuple[Annotated[int, Field(strict=True, ge=1, le=2**20)], ...] | None = None
    methods: tuple[MethodName, ...] | None = None

    @field_validator("tolerance")
    @classmethod
    def _below_one(cls, value: float) -> float:
        if value >= 1:
            raise fail("expected a relative tolerance below 1", value)
        return value

    @field_validator("quantities", "methods", "resolutions")
    @classmethod
    def _not_empty_nor_repeated(cls, value: tuple[Any, ...] | None) -> tuple[Any, ...] | None:
        if value is not None and (not value or len(set(value)) != len(value)):
            raise fail("expected a list without repetitions and not empty", list(value))
        return value if value is None or isinstance(value[0], str) else tuple(sorted(value))


class Scene(_Table):
    """A validated scene; see the contract of scene files in docs/scenes.md."""

    name: str
    title: Annotated[str, Field(max_length=300)] = ""
    half_space: HalfSpace
    counter_body: HalfSpace | None = None
    indenter: AnyIndenter | None = None
    surface: Surface | None = None
    body: Body | None = None
    loading: Loading
    compare: Compare = Compare()
    methods: MethodOptions = MethodOptions()
    directory: str = Field(default=".", exclude=True)

    @field_validator("name", mode="before")
    @classmethod
    def _slug(cls, value: Any) -> Any:
        if not isinstance(value, str) or not re.fullmatch(r"[a-z0-9][a-z0-9-]{0,99}", value):
            raise fail("expected a slug of a-z, 0-9 and -, at most 100 characters", value)
        return value

    @property
    def rough(self) -> bool:
        """Whether the scene presses a rough surface rather than an indenter."""
        return self.surface is not None

    @model_validator(mode="after")
    def _counter_body_is_a_half_space(self) -> Scene:
        if self.counter_body is None:
            return self
        if self.body is not None:
            raise fail("counter_body: expected no [body] beside it: what presses on one is rigid")
        if self.indenter is not None and self.indenter.flat:
            raise fail(
                "counter_body: expected an [indenter] without a sharp edge: an elastic punch is no "
                "half-space, and 1/E* does not add"
            )
        return self

    @property
    def effective_modulus(self) -> float:
        """E* of the contact: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 where both bodies are elastic.

        Hertz's addition of compliances (Johnson 1985, eq. 4.5): exact for two frictionless
        half-spaces.
        """
        if self.counter_body is None:
            return self.half_space.modulus
        return 1.0 / (1.0 / self.half_space.modulus + 1.0 / self.counter_body.modulus)

    @property
    def elastic_constants(self) -> tuple[float, float]:
        """E and nu of one half-space that is as soft under a rigid shape as both bodies together.

        nu is that of the [half_space]; frictionless contact depends on E* alone.
        """
        nu = self.half_space.elastic_constants[1]
        return self.effective_modulus * (1 - nu**2), nu

    @property
    def heading(self) -> str:
        """The title, or the name where there is none."""
        return self.title or self.name

    @cached_property
    def text(self) -> str:
        """The scene as TOML in SI units: the same scene, whatever it was written in."""
        return to_toml(self.model_dump(exclude_none=True, exclude_defaults=True))


def to_toml(tables: Mapping[str, Any]) -> str:
    """Write nested tables as TOML (tables one level deep, the rest inline).

    Examples
    --------
    >>> print(to_toml({"name": "a", "half_space": {"effective_modulus": 1e9}}))
    name = "a"
    <BLANKLINE>
    [half_space]
    effective_modulus = 1000000000.0
    """
    lines = [f"{k} = {_inline(v)}" for k, v in tables.items() if not isinstance(v, Mapping)]
    for name, table in tables.items():
        if isinstance(table, Mapping):
            lines += ["", f"[{name}]", *(f"{k} = {_inline(v)}" for k, v in table.items())]
    return "\n".join(lines)


def _inline(value: Any) -> str:
    if isinstance(value, Mapping):
        pairs = [(k if BARE.fullmatch(k) else _inline(k), v) for k, v in value.items()]
        return "{ " + ", ".join(f"{k} = {_inline(v)}" for k, v in pairs) + " }"
    if isinstance(value, (list, tuple)):
        return "[" + ", ".join(_inline(each) for each in value) + "]"
    if isinstance(value, str):
        # JSON's escapes are TOML's, but for DEL, which JSON leaves as it is, and for what lies
        # beyond 16 bits, which JSON would escape as two surrogates: it stands as it is.
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007F")
    return json.dumps(value)


def builtin_folder() -> Path:
    """Return the folder of the built-in scenes."""
    return Path(__file__).parent / "scenes"


def builtin_names() -> list[str]:
    """Return the names of the built-in scenes, in alphabetical order."""
    return sorted(path.stem for path in builtin_folder().glob("*.toml"))


def load_scene(source: str | Path, overrides: Mapping[str, Any] | None = None) -> Scene:
    """Read a scene from a file, or by the name of a built-in one.

    Parameters
    ----------
    source : str or Path
        Path of a TOML file, or a name from ``builtin_names()``.
    overrides : mapping, optional
        Dotted path of a key -> value, put in before validation: {"methods.fem.penalty": 10}.

    Raises
    ------
    SceneError
        Listing every problem of the file.
    """
    path = Path(source)
    if str(source) in builtin_names():
        path = builtin_folder() / f"{source}.toml"
    if not path.is_file():
        what = "a folder, not a scene file" if path.is_dir() else "no such file or built-in scene"
        hint = "" if path.suffix or path.is_dir() else "; `roughline list scenes` names them"
        raise SceneError(str(source), [what + hint])
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise SceneError(str(source), [f"expected at most {LARGEST_FILE} bytes"])
        text = path.read_bytes().decode("utf-8-sig")
    except (OSError, UnicodeDecodeError) as error:
        raise SceneError(str(source), [f"not a readable text file ({error})"]) from error
    return parse_scene(text, str(source), path.parent.resolve(), overrides)


def parse_scene(
    text: str, source: str, directory: Path, overrides: Mapping[str, Any] | None = None
) -> Scene:
    """Read a scene from TOML text; files it names are relative to `directory`."""
    if any(key.count(".") > DEEPEST_KEY for key in KEYS.findall(text)):
        raise SceneError(source, [f"expected keys of at most {DEEPEST_KEY + 1} parts"])
    try:
        data = tomllib.loads(text)
    except (tomllib.TOMLDecodeError, RecursionError, ValueError) as error:
        raise SceneError(source, [f"not valid TOML: {error}"]) from error
    for path, value in (overrides or {}).items():
        _override(data, path.split("."), value)
    return make_scene(data, source, directory)


def _override(data: Any, path: list[str], value: Any) -> None:
    """Set a nested key, numbers being places in a list.

    Where a table is expected and something else stands, validation says so.
    """
    for key in path[:-1]:
        data = data.setdefault(key, {}) if isinstance(data, dict) else _item(data, key)
    if isinstance(data, dict):
        data[path[-1]] = value
    elif _item(data, path[-1]) is not None:
        data[int(path[-1])] = value


def _item(values: Any, key: str) -> Any:
    """Return an item of a list by the digits of its place, None where there is none."""
    if isinstance(values, list) and key.isdecimal() and int(key) < len(values):
        return values[int(key)]
    return None


def make_scene(data: dict[str, Any], source: str, directory: Path) -> Scene:
    """Validate the tables of a scene, listing all problems at once."""
    problems = _table_problems(data)
    try:
        tables = {k: v for k, v in body_table.with_material(data).items() if k != "directory"}
        scene = Scene.model_validate({**tables, "directory": str(directory)})
    except ValidationError as error:
        found = [readable(each) for each in error.errors()]
        if "body" in data and "half_space" not in data:
            found = [re.sub("^half_space", "body", each) for each in found]
        problems = found + problems + _missing_files(data, directory)
        raise SceneError(source, problems) from error
    if problems:
        raise SceneError(source, problems + _missing_files(data, directory))
    return scene


def _missing_files(data: dict[str, Any], directory: Path) -> list[str]:
    """Problems with the map that a wrong scene names: told together with the others."""
    surface = data.get("surface")
    file = surface.get("file") if isinstance(surface, dict) else None
    if not isinstance(file, str) or not file or len(file) > 4096 or "\0" in file:
        return []
    return [] if (directory / file).is_file() else [f"surface.file: {file}: no such file"]


def _table_problems(data: dict[str, Any]) -> list[str]:
    """Problems across tables: found even where the tables themselves are wrong."""
    problems = []
    if "directory" in data:
        problems.append("directory: unknown key")
    problems += body_table.table_problems(data)
    bodies = [key for key in ("indenter", "surface") if key in data]
    if len(bodies) != 1 and "body" not in data:
        came = " and ".join(f"[{b}]" for b in bodies) or "none"
        problems.append(f"expected exactly one of [indenter] and [surface], got {came}")
    compare = data.get("compare")
    levels = compare.get("resolutions") if isinstance(compare, dict) else None
    if "body" not in data and isinstance(levels, (list, tuple)) and 1 in levels:
        path = f"compare.resolutions.{levels.index(1)}"
        problems.append(f"{path}: expected greater than or equal to 2 without a [body], got 1")
    loading = data.get("loading")
    if isinstance(loading, dict) and "indenter" in data:
        if "mean_gap" in loading:
            problems.append("loading.mean_gap: expected a [surface], an indenter has no mean gap")
        if isinstance(loading.get("force"), dict) and "relative_to" in loading["force"]:
            problems.append("loading.force.relative_to: expected a [surface], which has h' and A0")
    return problems


# What pydantic says in the language of Python, in the language of scene files.
_PLAIN = {
    "model_type": "expected a table",
    "model_attributes_type": "expected a table",
    "tuple_type": "expected a list",
    "too_long": "expected a shorter list",
    "string_type": "expected a text",
    "string_too_short": "expected a text that is not empty",
    "int_type": "expected a whole number",
    "int_from_float": "expected a whole number",
    "bool_type": "expected true or false",
}


def readable(error: Mapping[str, Any]) -> str:
    """Turn one of pydantic's errors into ``path: expected ..., got ...``."""
    tags = ("self_affine", "map")
    location = [each for each in error["loc"] if each not in tags]
    if len(location) > 1 and location[0] == "indenter":
        # The tag of the discriminated union stands second: indenter.cone.slope.
        location = [location[0], *location[2:]]
    path = ".".join(str(each) for each in location)
    kind, context, came = error["type"], error.get("ctx", {}), error.get("input")
    if kind == "extra_forbidden":
        return f"{path}: unknown key"
    if kind == "missing":
        return f"{path}: expected, but missing"
    if kind in ("union_tag_invalid", "union_tag_not_found"):
        key, known = ("shape", SHAPES) if path == "indenter" else ("kind", tags)
        tag = context.get("tag")
        came = "nothing" if tag is None else shown(tag)
        return f"{path}.{key}: expected one of {', '.join(known)}, got {came}"
    if kind == "scene":
        return f"{path}: {error['msg']}" if path else error["msg"]
    message = _PLAIN.get(kind, error["msg"]).replace("Input should be", "expected")
    message = message[0].lower() + message[1:]
    return f"{path}: {message}, got {shown(came)}"
