"""Validated scenes.

``load_scene`` reads TOML, converts units, and lists all errors at once, each with its path in the
file, the expected and the actual value.
"""

from __future__ import annotations

import re
from collections.abc import Mapping
from contextlib import suppress
from copy import deepcopy
from functools import cache, cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

import tomli_w
from pydantic import Field, ValidationError, create_model, field_validator, model_validator

from comparisons.errors import InputError
from comparisons.facts.methods import is_known
from comparisons.facts.quantities import COMPARABLE, DEFAULT
from comparisons.files import parse_toml, plain, read_toml
from comparisons.reasons import in_kind, near
from comparisons.scene.combinations import table_problems, walks_a_path, with_defaults
from comparisons.scene.fields import KnownMethod, Positive, SceneTable, fail
from comparisons.scene.half_space import RELAXES, Body, HalfSpace, with_material
from comparisons.scene.indenters import AnyIndenter
from comparisons.scene.loading import PATH, Loading
from comparisons.scene.options import MethodOptions
from comparisons.scene.physics.tables import TABLES
from comparisons.scene.problems import in_file, missing_files
from comparisons.scene.surface import SelfAffine, Surface

MOST_PROBLEMS = 50
MOST_SWEPT = 100
# What variants of a map are swept along, no key of theirs (`solving.planning`).
PREPARATION = "preparation"


class SceneError(InputError):
    """A scene file is wrong; ``problems`` lists every one of them."""

    def __init__(self, source: str, problems: list[str]) -> None:
        more = len(problems) - MOST_PROBLEMS
        if more > 0:
            problems = [*problems[:MOST_PROBLEMS], f"... and {more} more"]
        self.source = source
        self.problems = problems
        super().__init__(f"{source}:\n" + "\n".join(f"  {problem}" for problem in problems))

    def __reduce__(self) -> tuple[Any, ...]:
        return type(self), (self.source, self.problems)


class Compare(SceneTable):
    """What is compared, how well, and by which methods."""

    quantities: tuple[Literal[COMPARABLE], ...] = DEFAULT  # type: ignore[valid-type]
    tolerance: Positive = 0.01
    resolutions: tuple[Annotated[int, Field(strict=True, ge=1, le=2**20)], ...] | None = None
    methods: tuple[KnownMethod, ...] | None = None
    proved: Annotated[bool, Field(strict=True)] | Literal["if_any"] = False
    measured: Annotated[str, Field(min_length=1, max_length=4096)] | None = None
    fit_zero: Annotated[bool, Field(strict=True)] = False

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
            raise fail("expected a non-empty list without repetitions", list(value))
        return value if value is None or isinstance(value[0], str) else tuple(sorted(value))


class _Bodies(SceneTable):
    """What touches."""

    name: str
    title: Annotated[str, Field(max_length=300)] = ""
    half_space: HalfSpace
    counter_body: HalfSpace | None = None
    indenter: AnyIndenter | None = None
    surface: Surface | None = None
    surface2: Surface | None = None
    body: Body | None = None


if TYPE_CHECKING:
    from comparisons.scene.physics.tables.adhesion import Adhesion
    from comparisons.scene.physics.tables.dynamics import Dynamics
    from comparisons.scene.physics.tables.friction import Friction
    from comparisons.scene.physics.tables.lubrication import Lubrication
    from comparisons.scene.physics.tables.plasticity import Plasticity
    from comparisons.scene.physics.tables.rolling import Rolling
    from comparisons.scene.physics.tables.sliding import Sliding
    from comparisons.scene.physics.tables.viscoelastic import Viscoelastic
    from comparisons.scene.physics.tables.wear import Wear

    class _Physics(_Bodies):
        """Beside them, one table for each that `comparisons.scene.physics.tables` holds."""

        rolling: Rolling | None = None
        lubrication: Lubrication | None = None
        friction: Friction | None = None
        viscoelastic: Viscoelastic | None = None
        sliding: Sliding | None = None
        adhesion: Adhesion | None = None
        plasticity: Plasticity | None = None
        dynamics: Dynamics | None = None
        wear: Wear | None = None

else:
    _tables = {key: (table | None, None) for key, table in TABLES.items()}
    _Physics = create_model("_Physics", __base__=_Bodies, **_tables)


class Scene(_Physics):
    """A validated scene; see the contract of scene files in docs/scenes.md."""

    # Only an impact has no loads: its mass finds its own way.
    loading: Loading = Field(default_factory=Loading.model_construct)
    compare: Compare = Compare()
    methods: MethodOptions = MethodOptions()
    # Of a member of a sweep, the key that is varied and its value here.
    sweep: dict[str, str | bool | int | float] = Field(default_factory=dict)
    directory: str = Field(default=".", exclude=True)

    @field_validator("name", mode="before")
    @classmethod
    def _slug(cls, value: Any) -> Any:
        if not isinstance(value, str) or not re.fullmatch(r"[a-z0-9][a-z0-9-]{0,99}", value):
            raise fail("expected a slug of a-z, 0-9 and -, at most 100 characters", value)
        return value

    @field_validator("sweep", mode="before")
    @classmethod
    def _one_member(cls, value: Any) -> Any:
        table = _dotted(value)
        if isinstance(table, dict) and any(isinstance(item, list) for item in table.values()):
            raise fail("expected one scene, got those of a sweep: `roughline run` solves them all")
        return table

    @property
    def rough(self) -> bool:
        """Whether the scene presses a rough surface rather than an indenter."""
        return self.surface is not None

    @property
    def surfaces(self) -> tuple[Surface, ...]:
        """The rough faces: none, one, or those of both bodies."""
        return tuple(face for face in (self.surface, self.surface2) if face is not None)

    @property
    def random(self) -> bool:
        """Whether every realisation has a surface of its own."""
        return any(isinstance(face, SelfAffine) for face in self.surfaces)

    @property
    def realisations(self) -> int:
        """How many surfaces there are, or lines that stand for a measured one."""
        random = [face for face in self.surfaces if isinstance(face, SelfAffine)]
        return max((face.realisations for face in random or self.surfaces), default=1)

    @model_validator(mode="after")
    def _tables_that_fit(self) -> Scene:
        """Refuse what no single table shows."""
        indenter, loading = self.indenter, self.loading
        flat = indenter is not None and indenter.flat
        if len({face.periodic for face in self.surfaces}) > 1:
            raise fail("surface2.periodic: expected both surfaces periodic, or both free patches")
        if self.counter_body is not None and self.body is not None:
            raise fail("counter_body: expected no [body]: the indenter of a meshed body is rigid")
        if self.counter_body is not None and flat:
            raise fail(
                "counter_body: expected an [indenter] without a sharp edge: an elastic punch is "
                "not a half-space, and its compliance does not add"
            )
        for name in self.physics:
            getattr(self, name).check(self)
        # without adhesion no force of a path pulls, and one of them presses
        if loading.forces is not None and self.adhesion is None:
            if min(loading.forces.values) < 0:
                raise fail("loading.force: expected no negative force without [adhesion]")
            if max(loading.forces.values) == 0 and self.dynamics is None:
                raise fail("loading.force: expected at least one positive force")
        if loading.pressure is not None and self.surface is None and not flat:
            raise fail(
                "loading.pressure: expected a [surface] or a flat face, whose area makes it a "
                "force: prescribe force"
            )
        simple = indenter is not None and self.body is None and self.half_space.uniform
        if self.compare.measured is not None and (self.physics or not simple):
            raise fail(
                "compare.measured: expected an [indenter] on a uniform half-space without further "
                "physics, where the force is proportional to the modulus"
            )
        if self.compare.fit_zero and self.compare.measured is None:
            raise fail("compare.fit_zero: expected only together with compare.measured")
        return self

    @cached_property
    def physics(self) -> tuple[str, ...]:
        """Which physics beyond frictionless elastic contact the scene switches on."""
        return tuple(name for name in TABLES if getattr(self, name) is not None)

    @property
    def only_pressed(self) -> bool:
        """Whether its loads are static contacts without further physics, as an impact's end is."""
        stopped = self.physics == ("dynamics",) and self.loading.time is None
        return stopped or not self.physics

    @property
    def remembers(self) -> bool:
        """Whether its normal loads are a path, because what they do depends on those before."""
        return any(TABLES[name].remembers for name in self.physics)

    @property
    def poisson_ratio(self) -> float:
        """Poisson ratio of the [half_space]; where only E* is given that of rubber, or 0.3."""
        if self.viscoelastic is not None and self.half_space.poisson_ratio is None:
            return 0.5
        return self.half_space.nu

    @property
    def effective_modulus(self) -> float:
        """E* of the contact: 1/E* = (1 - nu1^2)/E1 + (1 - nu2^2)/E2 where both bodies are elastic.

        Hertz's addition of compliances (Johnson 1985, eq. 4.5): exact for two frictionless
        half-spaces. Of a viscoelastic body E* = 2 G/(1 - nu) with its long-term shear modulus, or
        the instantaneous one of a fluid.
        """
        if self.viscoelastic is not None:
            modulus = self.viscoelastic.long_term_modulus or self.viscoelastic.instantaneous_modulus
            return 2.0 * modulus / (1.0 - self.poisson_ratio)
        if self.counter_body is None:
            return self.half_space.modulus
        return 1.0 / (1.0 / self.half_space.modulus + 1.0 / self.counter_body.modulus)

    @property
    def tangential_modulus(self) -> float:
        """G* = 4 G/(2 - nu) of (19.18), from E* = 2 G/(1 - nu)."""
        nu = self.poisson_ratio
        return 2.0 * self.effective_modulus * (1.0 - nu) / (2.0 - nu)

    @property
    def shear_modulus(self) -> float:
        """G = E*(1 - nu)/2 of the half-space as a whole."""
        return self.effective_modulus * (1.0 - self.poisson_ratio) / 2.0

    @property
    def elastic_constants(self) -> tuple[float, float]:
        """E and nu of one half-space that is as soft under a rigid shape as both bodies together.

        Frictionless contact depends on E* alone; nu, which the error of a mesh depends on, is the
        mean of both bodies, weighted by their compliances: exchanging them changes nothing.
        """
        nu = self.poisson_ratio
        if self.counter_body is not None:
            share = self.effective_modulus / self.counter_body.modulus
            nu = (1 - share) * nu + share * self.counter_body.nu
        return self.effective_modulus * (1 - nu**2), nu

    @property
    def heading(self) -> str:
        """The title, or the name where there is none."""
        return self.title or self.name

    @cached_property
    def text(self) -> str:
        """The scene as TOML in SI units: the same scene, whatever it was written in."""
        return tomli_w.dumps(self.model_dump(exclude_none=True, exclude_defaults=True))


# Named sets of built-in scenes.
SINGLE = (
    *("paraboloid", "sphere", "cone", "power-law-3", "power-law-4", "rounded-punch"),
    *("ellipsoid-2", "ellipsoid-5", "cylinder", "elliptic-punch", "square-punch"),
    "triangle-punch",
)
ROUGH = ("rough-patch", "rough-free", "rough-periodic", "measured-map")
# Scenes with friction, memory, sliding, rolling, films, adhesion, yield, wear, inertia, layers.
PHYSICS = (
    *("impact-ball", "impact-square", "impact-course", "pushed-ball"),
    *("rubber-ball", "rubber-again", "rubber-creep", "impact-rubber"),
    *("friction-rubber", "friction-steel", "friction-rough"),
    *("adhesive-ball", "adhesive-ball-range", "adhesive-punch"),
    *("sliding-ball", "sliding-rough", "rolling-ball", "rolling-rubber", "plastic-ball"),
    *("plastic-ellipsoid", "plastic-rough"),
    *("coated-ball", "layer-on-base", "graded-ball"),
    *("soft-ball-film", "wavy-ball-film", "squeezed-ball"),
    *("worn-ball", "worn-punch", "worn-rough", "fretting-ball"),
)
SUITES: dict[str, tuple[str, ...]] = {
    "quick": (*SINGLE, *ROUGH),
    "single": SINGLE,
    "rough": ROUGH,
    "physics": PHYSICS,
}


def builtin_folder() -> Path:
    """Return the folder of the built-in scenes."""
    return Path(__file__).parent / "built_in"


@cache
def builtin_names() -> tuple[str, ...]:
    """Return the names of the built-in scenes, in alphabetical order."""
    return tuple(sorted(path.stem for path in builtin_folder().glob("*.toml")))


def beginning(kind: str) -> str:
    """Return the text of a scene with comments to begin with, or that of a built-in scene."""
    begun = sorted((Path(__file__).parent / "beginnings").glob("*.toml"))
    files = {path.stem: path for path in (*begun, *builtin_folder().glob("*.toml"))}
    if kind not in files:
        expected = (
            f"expected {', '.join(path.stem for path in begun)} or the name of a built-in scene"
        )
        raise InputError(f"new: {expected}, got {kind!r}{near(kind, files)}")
    return files[kind].read_text(encoding="utf-8")


def load_scene(
    source: str | Path | Mapping[str, Any] | Scene, overrides: Mapping[str, Any] | None = None
) -> Scene:
    """Read a scene from a file, by the name of a built-in one, or from its tables.

    A str is a name from `builtin_names`, else a path. Files of tables are relative to the working
    folder; a scene is changed. `overrides`: dotted path of a key -> value, put in before
    validation, as {"methods.fem.penalty": 10}. SceneError lists every problem of the scene.
    """
    if isinstance(source, Scene) and not overrides:
        return source
    return make_scene(*_read(source), overrides)


def load_scenes(
    source: str | Path | Mapping[str, Any] | Scene, overrides: Mapping[str, Any] | None = None
) -> list[Scene]:
    """Read a scene as `load_scene` does, or one for each value of its ``[sweep]``.

    A sweep has one dotted key with a list: ``"indenter.radius" = ["1 mm", "2 mm"]``. Its scenes
    are called ``NAME-1-mm``, ``NAME-2-mm``, ...
    """
    data, origin, folder = _read(source)
    table = _dotted(data.get("sweep"))
    if not (isinstance(table, dict) and any(isinstance(v, list) for v in table.values())):
        return [make_scene(data, origin, folder, overrides)]
    (path, values), *more = table.items()
    number = len(values) if isinstance(values, list) else 0
    if path in ("name", "title", "sweep"):
        raise SceneError(origin, [f"sweep.{path}: expected a key that changes the scene"])
    if path in (overrides or {}):
        raise SceneError(origin, [f"sweep.{path}: swept here, and set by an option"])
    if more or not 2 <= number <= MOST_SWEPT or len({*map(str, values)}) < number:
        expected = f'one key with a list of 2 to {MOST_SWEPT} different values, "indenter.radius"'
        raise SceneError(origin, [f"sweep: expected {expected} = [...], got {table!r:.60}"])
    scenes, words, name = [], path.split(".")[-1].replace("_", " "), data.get("name")
    for value in values:
        changes = {
            **(overrides or {}),
            path: value,
            "sweep": {path: value},
            "title": f"{data.get('title') or name}, {words} {value}"[:300],
        }
        if isinstance(name, str):
            changes["name"] = member(name, value)
        scenes.append(make_scene(deepcopy(data), f"{origin}, {path} = {value}", folder, changes))
    return scenes


def _dotted(table: Any) -> Any:
    """Return a table by dotted keys: where these were not quoted, they are tables in tables."""
    if not isinstance(table, dict):
        return table
    flat: dict[str, Any] = {}
    for key, item in table.items():
        inside = (
            {f".{k}": v for k, v in _dotted(item).items()} if isinstance(item, dict) else {"": item}
        )
        flat |= {f"{key}{rest}": value for rest, value in inside.items()}
    return flat


def member(name: str, value: object) -> str:
    """Return the name of a scene of a sweep, or of a series.

    >>> member("ball", "-2.5 µm")
    'ball-minus-2-5-um'
    """
    text = re.sub("^-", "minus ", str(value).lower().replace("µ", "u").replace("μ", "u"))
    return f"{name}-{re.sub('[^a-z0-9]+', '-', text).strip('-')}"[:100].rstrip("-")


def _read(source: str | Path | Mapping[str, Any] | Scene) -> tuple[dict[str, Any], str, Path]:
    """Return the tables of a scene, what to call it, and the folder of its files."""
    if isinstance(source, Scene):
        return parse_toml(source.text), source.name, Path(source.directory)
    if isinstance(source, Mapping):
        # Copied, so that overrides leave the caller's tables alone; arrays become lists.
        return plain(dict(source)), "scene", Path.cwd()
    given: Any = source  # callers without types pass what they like
    if not isinstance(given, (str, Path)):
        expected = "expected a name, the path of a file, its tables, or a Scene"
        raise SceneError("scene", [f"{expected}, got {in_kind(given)}"])
    path, name = Path(source), str(source).lower()
    if name in builtin_names() and (name == str(source) or not path.is_file()):
        path = builtin_folder() / f"{name}.toml"
    if path.is_dir():
        raise SceneError(str(source), ["a folder, not a scene file"])
    if not path.is_file():
        hint = near(path.stem, builtin_names())
        if is_known(name):
            hint += f"; {name} is a method: `--methods {name}`"
        problem = "no such file"
        if not path.suffix:
            problem, hint = "no such file or built-in scene", f"{hint}; see `roughline list scenes`"
        raise SceneError(str(source), [problem + hint])
    try:
        return read_toml(path), str(source), path.parent.resolve()
    except ValueError as error:
        hint = (
            ""
            if path.suffix.lower() == ".toml"
            else (
                f'; a scene names its map of heights: [surface] kind = "map", file = "{path.name}"'
            )
        )
        raise SceneError(str(source), [f"{error}{hint}"]) from error


def parse_scene(
    text: str, source: str, directory: Path, overrides: Mapping[str, Any] | None = None
) -> Scene:
    """Read a scene from TOML text; files it names are relative to `directory`."""
    try:
        data = parse_toml(text)
    except ValueError as error:
        raise SceneError(source, [str(error)]) from error
    return make_scene(data, source, directory, overrides)


def as_changes(given: Any) -> dict[str, Any]:
    """Return changes of a scene, {dotted key: value}; what is no mapping is refused."""
    if not isinstance(given, Mapping | None):
        expected = 'expected a dict such as {"indenter.radius": "5 mm"}'
        raise SceneError("changes", [f"{expected}, got {in_kind(given)}"])
    return dict(given or {})


def override(data: Any, path: str, value: Any) -> None:
    """Set a nested key of a scene's tables by its dotted path, numbers being places in a list.

    Where a table is expected and something else stands, validation says so.
    """
    *tables, last = path.split(".")
    for key in tables:
        data = data.setdefault(key, {}) if isinstance(data, dict) else _item(data, key)
    if isinstance(data, dict):
        data[last] = value
    elif _item(data, last) is not None:
        data[int(last)] = value


def _item(values: Any, key: str) -> Any:
    """Return an item of a list by the digits of its place, None where there is none."""
    if isinstance(values, list) and key.isdecimal() and int(key) < len(values):
        return values[int(key)]
    return None


def make_scene(
    data: dict[str, Any], source: str, directory: Path, overrides: Mapping[str, Any] | None = None
) -> Scene:
    """Change the tables of a scene and validate them, listing all problems at once."""
    swept = data.get("sweep")
    for path, value in as_changes(overrides).items():
        override(data, path, deepcopy(value))
        if isinstance(swept, dict) and not isinstance(swept.get(path), list):
            swept.pop(path, None)  # a scene of a sweep that is changed in its key leaves it
    problems = table_problems(data)
    filled = with_defaults(with_material(data))
    try:
        tables = {k: v for k, v in filled.items() if k != "directory"}
        scene = validated({**tables, "directory": str(directory)})
    except ValidationError as error:
        messages = in_file(error, Scene)
        if "body" in data and "half_space" not in data:
            messages = [re.sub("^half_space", "body", message) for message in messages]
        problems = messages + problems + missing_files(data, directory)
        raise SceneError(source, problems) from error
    own = {path: value for path, value in scene.sweep.items() if path != PREPARATION}
    for path, value in own.items():  # a scene of a sweep has the value that is its own
        single = deepcopy(filled)
        override(single, path, value)
        same = False
        with suppress(ValidationError):
            same = validated({**single, "directory": str(directory)}) == scene
        if not same:
            problems.append(f"sweep.{path}: expected a list of values, got {value!r}")
    if problems:
        raise SceneError(source, problems + missing_files(data, directory))
    return scene


def validated(data: dict[str, Any]) -> Scene:
    """Return a scene of tables; what one of them means for the others is told to validation."""
    context = {PATH: walks_a_path(data), RELAXES: "viscoelastic" in data}
    return Scene.model_validate(data, context=context)
