"""The record of a study and of its scenes: the same objects after a run and read from a folder.

A cost is that of the stated error: the error of a mean over random surfaces belongs to the time of
all solves that the mean stands on, the time of one to the errors of single ones. Every quantity is
judged once, at equal prescribed load (the prescribed one at an equal value of the other): errors at
the other load (`verdicts_at_other_load`) affect no verdict. A bar is one of 95 % where calibration
shows it, else an estimate by the same rules (`confidence`).
"""

from __future__ import annotations

import tomllib
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field, fields
from functools import cached_property, lru_cache, wraps
from pathlib import Path
from typing import Annotated, Any, Literal, ParamSpec, TypeVar

import numpy as np
from pydantic import ConfigDict, Field, PlainSerializer, PlainValidator, ValidationInfo

from comparisons.errors import ResultsError
from comparisons.facts.methods import (
    GRID,
    METHODS,
    MODEL,
    NOT_ASKED,
    Method,
    is_known,
    ours,
    title_of,
)
from comparisons.facts.quantities import FIELDS, main_axis, quantity
from comparisons.files import read_arrays
from comparisons.formatting import count
from comparisons.judging.truth import Reference
from comparisons.judging.verdicts import LAST_LOAD, NO_RESULT, Verdict
from comparisons.reasons import STEEP
from comparisons.results.folder import PartHeader
from comparisons.results.rows import NO_ROWS, Rows
from comparisons.scene.half_space import DEPTH_KEYS
from comparisons.scene.loading import PATHS
from comparisons.scene.physics.tables import TABLES
from comparisons.scene.scene import Scene, SceneError, make_scene
from comparisons.solving.plan import PlanRecord
from comparisons.tasks.shown_loads import NAMES, at_step, stored_steps
from comparisons.tasks.stresses import FROM_PRESSURE

FIELDS_FOLDER = "fields"
MEAN = "mean"
NOBODY = "not computed by any method that was run"
# Quantities whose bars `roughline calibrate` holds against true errors.
SINGLE_CONTACTS = ("force", "penetration", "contact_area", "stiffness")
ROUGH_SURFACES = ("contact_area", "penetration", "mean_gap", "stiffness")
WHERE = (
    "95 % where calibration shows it: force, penetration, contact area, mean gap and stiffness of "
    "frictionless, elastic contacts on uniform half-spaces; elsewhere an estimate by the same rules"
)

P = ParamSpec("P")
T = TypeVar("T")


def once(function: Callable[P, T]) -> Callable[P, T]:
    """Evaluate a function of a record, and of plain values, once per record and values."""

    @wraps(function)
    def kept(*args: P.args, **more: P.kwargs) -> T:
        record, *values = args
        answers = vars(record).setdefault("_answers", {})
        key = (function, *values, *more.items())
        if key not in answers:
            answers[key] = function(*args, **more)
        answer: T = answers[key]
        return answer

    return kept


def _read(files: Any, info: ValidationInfo) -> dict[tuple[str, int], Path]:
    """Return the paths of files; refuse names that lead out: results may come from strangers."""
    root = Path(info.context or "")
    try:
        paths = {(str(m), int(n)): (root / name).resolve() for m, n, name in files}
    except TypeError as error:
        raise ValueError("expected lists of a method, a resolution and a file") from error
    for path in paths.values():
        if not path.is_relative_to(root.resolve()):
            raise ValueError(f"{path.name!r} leads out of {root}")
    return paths


# (method, resolution) -> file; in JSON a list of method, resolution and name.
Files = Annotated[
    dict[tuple[str, int], Path],
    PlainValidator(_read),
    PlainSerializer(
        lambda files: [
            (*setting, f"{FIELDS_FOLDER}/{path.name}") for setting, path in files.items()
        ]
    ),
]


@dataclass(frozen=True)
class Failure:
    """A planned solve that failed."""

    method: str
    resolution: float
    reason: str
    seconds: float
    load: float


@dataclass(frozen=True)
class Cost:
    """The cost of one setting; NaN where it is not known."""

    # Of all solves that the stated error stands on, and of their set-up.
    seconds: float
    setup_seconds: float
    single_seconds: float  # seconds of one surface or line
    surfaces: int  # surfaces or lines solved at this resolution; 1 where the scene is one surface
    solves: str  # those of an ensemble, coarse to fine: "375 + 24 surfaces", or ""

    @property
    def spent(self) -> float:
        """Seconds of the solves at this resolution alone."""
        return self.single_seconds * self.surfaces


@dataclass(frozen=True, eq=False)
class SceneRecord:
    """The results of a study for one scene: the same object after a run and read from a folder.

    It is equal to itself only, and does not change: what is derived is kept with it (`once`).
    """

    __pydantic_config__ = ConfigDict(arbitrary_types_allowed=True)

    name: str
    title: str
    text: str  # the scene as TOML, with every quantity in SI units
    # The prescribed quantity: "penetration", "force", "mean_gap", "tangential_force", "speed" ...
    control: str
    quantities: tuple[str, ...]  # what was compared
    tolerance: Annotated[float, Field(gt=0, lt=1)]  # the relative error asked for
    plan: PlanRecord
    reference: Reference
    verdicts: tuple[Verdict, ...]  # of every setting, at each equal load
    # References that differ by more than their bars and a fifth of the tolerance, in words.
    disagreements: tuple[str, ...]
    # (method, resolution) -> path of the npz with the fields of realisation 0 at the last load.
    fields: Files = field(default_factory=dict)
    # Along what steps are compared, where that is not `control`: "step" of a path, "time".
    axis: str = ""
    # The scene's part of results.csv and of distributions.csv.
    rows: Annotated[Rows, Field(exclude=True)] = NO_ROWS
    distributions: Annotated[Rows, Field(exclude=True)] = NO_ROWS

    def __getstate__(self) -> dict[str, Any]:
        """Leave out what is derived: another process derives it again."""
        return {part.name: vars(self)[part.name] for part in fields(self)}

    @cached_property
    def tables(self) -> dict[str, Any]:
        """What `text` says, however it is laid out; the text itself where it is no TOML."""
        try:
            return tomllib.loads(self.text)
        except tomllib.TOMLDecodeError:
            return {"text": self.text}

    @cached_property
    def scene(self) -> Scene | None:
        """The scene that `text` describes, whoever solved it; None where it is none."""
        compared = dict(self.tables.get("compare", {}))
        compared.pop("methods", None)  # some may not be here
        try:
            return make_scene({**self.tables, "compare": compared}, self.name, Path())
        except SceneError:
            return None

    @property
    def along(self) -> str:
        """The column along which steps are compared."""
        return self.axis or self.control

    @property
    def is_path(self) -> bool:
        """Whether errors and bars are relative to the largest value along the steps."""
        return self.along in PATHS

    @property
    def drawn_along(self) -> str:
        """The column that curves are drawn over: time, or the prescribed load."""
        return "time" if self.along == "time" else self.control

    def compared_along(self, rows: Rows) -> np.ndarray:
        """Return the values of the axis that steps are compared along; steps count from one."""
        values = rows[self.along]
        return values + 1 if self.along == "step" else values

    def load_fields(self, method: str, resolution: int) -> dict[str, np.ndarray]:
        """Return the stored arrays of one solution, or an empty dict where there are none."""
        path = self.fields.get((method, int(resolution)))
        if path is None or not path.exists():
            return {}
        return dict(_checked_fields(path, path.stat().st_mtime_ns))

    # --- methods and settings

    @cached_property
    def methods(self) -> list[str]:
        """The methods that appear in the plan or the rows, in the order of every legend."""
        names = [item.method for item in self.plan.methods] + self.rows["method"].tolist()
        built_in = [name for name in ours() if name in names]
        return built_in + [name for name in dict.fromkeys(names) if name and name not in built_in]

    def title_of(self, method: str) -> str:
        """Return what a method is called here: finite elements have two kinds of meshes."""
        titles = (item.title for item in self.plan.methods if item.method == method)
        return next(filter(None, titles), title_of(method))

    def dimension_of(self, method: str) -> int:
        """Return the dimension of a method, also of one that is not here any more."""
        told = (item.dimension for item in self.plan.methods if item.method == method)
        return next(filter(None, told), METHODS.get(method, Method("")).dimension)

    @cached_property
    def unsupported(self) -> dict[str, str]:
        """The methods that cannot do the scene, each with its reason."""
        refusals = {item.method: item.reason for item in self.plan.methods if not item.supported}
        reasons = dict(zip(self.rows["method"], self.rows["reason"], strict=True))
        return {name: reason or reasons.get(name, "") for name, reason in refusals.items()}

    def not_asked(self, method: str) -> bool:
        """Tell whether a method was left out by the scene."""
        return method not in self.methods or self.unsupported.get(method) == NOT_ASKED

    def is_reference(self, method: str, resolution: float) -> bool:
        """Tell whether a setting is the reference itself."""
        return (method, resolution) == (self.reference.method, self.reference.resolution)

    @once
    def resolutions_run(self, method: str) -> list[float]:
        """Return the resolutions at which a method was run, ascending."""
        level = self.rows["resolution"][self.rows["method"] == method]
        return sorted(set(level[np.isfinite(level)].tolist()))

    @once
    def resolutions_judged(self, method: str) -> list[int]:
        """Return the resolutions at which a method was run, ascending, but for the truth itself."""
        return [
            n for n in map(int, self.resolutions_run(method)) if not self.is_reference(method, n)
        ]

    @once
    def resolutions_solved(self, method: str) -> list[float]:
        """Return the resolutions at which a method solved anything, ascending."""
        return sorted(set(self.solved_rows(method)["resolution"]))

    @once
    def finest(self, method: str) -> int | None:
        """Return the finest resolution, but the truth's, among those that answered most steps."""
        rows = self.rows.where((self.rows["method"] == method) & ~self.rows.lost)
        resolution, step = (rows[key] for key in ("resolution", "step"))
        counts = {n: len(set(step[resolution == n])) for n in self.resolutions_judged(method)}
        most = max(counts.values(), default=0)
        return max((n for n, count in counts.items() if count == most), default=None)

    # --- rows

    @cached_property
    def solved(self) -> Rows:
        """The rows that hold a converged load step."""
        return self.rows.where(self.rows["converged"] & np.isfinite(self.rows["step"]))

    @cached_property
    def steps(self) -> int:
        """How many load steps were planned, whether any method solved them or none."""
        step = self.rows["step"]
        return len(set(step[np.isfinite(step)]))

    @property
    def of_one_load(self) -> bool:
        """Whether one load was planned: nothing is drawn over loads, and no step is named."""
        return self.steps == 1

    @once
    def solved_rows(self, method: str) -> Rows:
        """Return the converged load steps of one method."""
        return self.solved.where(self.solved["method"] == method)

    @once
    def setting_rows(self, method: str, resolution: float) -> Rows:
        """Return all rows of a method at a resolution, solved or lost."""
        rows = self.rows
        return rows.where((rows["method"] == method) & (rows["resolution"] == resolution))

    @once
    def curve(self, method: str, resolution: float | None = None) -> Rows:
        """Return a row per step: means, or the only realisation; finest, of the first options."""
        rows = self.solved_rows(method)
        level = rows["resolution"]
        known = level[np.isfinite(level)]
        finest = max(known, default=np.nan) if resolution is None else resolution
        rows = rows.where(level == finest) if np.isfinite(finest) else rows
        if not len(rows):  # it lost all its steps
            return rows
        options, names = rows["options"], rows["realisation"]
        names[options != options[0]] = None
        chosen = MEAN if MEAN in names else names[0]
        rows = rows.where(names == chosen)
        return rows.where(np.argsort(rows["step"], kind="stable"))

    @once
    def realisations(self, method: str, resolution: float) -> Rows:
        """Return the single realisations of an ensemble (empty where there is one surface only)."""
        rows = self.solved_rows(method)
        single = rows.where((rows["resolution"] == resolution) & (rows["realisation"] != MEAN))
        return single if len(set(single["realisation"])) > 1 else NO_ROWS

    @cached_property
    def failures(self) -> list[Failure]:
        """The planned solves that were lost (methods that cannot do the scene are none)."""
        rows = self.rows.where(self.rows.lost)
        columns = [rows[name] for name in ("method", "resolution", "reason", "seconds")]
        # An ensemble that fails for one reason is one failure, not hundreds.
        lost: dict[tuple[str, ...], Failure] = {}
        for item in map(Failure, *columns, self.compared_along(rows)):
            if item.method not in self.unsupported:
                key = (item.method, str(item.resolution), item.reason, str(item.load))
                lost.setdefault(key, item)
        return list(lost.values())

    # --- costs

    @once
    def cost(self, method: str, resolution: float) -> Cost:
        """Return the cost of a setting, from the rows of results.csv."""

        def first(name: str, missing: float = np.nan, level: float = resolution) -> float:
            """Return the first number in a column of a setting, whose rows share it."""
            values = self.setting_rows(method, level)[name]
            return float(next((value for value in values if np.isfinite(value)), missing))

        surfaces, solves = int(first("surfaces", 1.0)), ""
        total, setup = first("seconds_all"), first("setup_seconds_all")
        if surfaces > 1:  # in words what a mean stands on (`comparisons.judging.levels.Levels`)
            dimension = self.dimension_of(method)
            levels = [n for n in self.resolutions_run(method) if n <= resolution]
            own = sum(first("seconds", level=n) * first("surfaces", 1.0, n) for n in levels)
            beside = ""
            if dimension == 3 and method != GRID and total > 1.001 * own:
                levels, beside = [resolution], f" beside those of {title_of(GRID)}"
            numbers = [count(first("surfaces", 1.0, level)) for level in levels]
            noun = "lines" if dimension == 1 else "surfaces"
            solves = f"{' + '.join(numbers)} {noun}{beside}"
        return Cost(total, setup, first("seconds"), surfaces, solves)

    @property
    def spent(self) -> float:
        """Seconds of all solves of the scene, each counted once."""
        settings = [(m, n) for m in self.methods for n in self.resolutions_run(m)]
        return float(np.nansum([self.cost(*setting).spent for setting in settings]))

    # --- verdicts

    def equal_at(self, name: str) -> str:
        """Return what is equal where a quantity is judged."""
        return LAST_LOAD if name in FIELDS else main_axis(self.along, name)

    @cached_property
    def unanswered(self) -> dict[str, str]:
        """The asked quantities that can be judged for no method at all, each with the reason."""
        reasons = {item.quantity: item.reason for item in self.verdicts if not item.counts}
        return {name: reasons[name] for name in self.quantities if name in reasons}

    @once
    def setting_verdicts(self, method: str, resolution: float) -> tuple[Verdict, ...]:
        """Return the verdict on each asked quantity of one method at one resolution."""
        known = self._judged.get((method, float(resolution)), {})
        unasked = f"the {self.title_of(method)} was not asked for"
        return tuple(
            known.get(name)
            or Verdict(
                method=method,
                quantity=name,
                at=self.equal_at(name),
                tolerance=self.tolerance,
                reason=self.unanswered.get(name, unasked),
                counts=name not in self.unanswered,
            )
            for name in self.quantities
        )

    @cached_property
    def _judged(self) -> dict[tuple[str, float], dict[str, Verdict]]:
        """The verdicts that decide: method and resolution -> quantity -> verdict."""
        settings: dict[tuple[str, float], dict[str, Verdict]] = {}
        for item in self.verdicts:
            if item.at == self.equal_at(item.quantity):
                settings.setdefault((item.method, item.resolution), {})[item.quantity] = item
        return settings

    def verdicts_on(self, method: str = MODEL) -> tuple[Verdict, ...]:
        """Return a verdict per asked quantity: the method's at its finest resolution."""
        return self.setting_verdicts(method, self.finest(method) or 0)

    @property
    def verdicts_at_other_load(self) -> list[Verdict]:
        """What is known of the model at the other load: to be looked up, it decides nothing."""
        level = self.finest(MODEL)
        return [
            item
            for item in self.verdicts
            if item.method == MODEL
            and item.resolution == level
            and item.quantity in self.quantities
            and item.at != self.equal_at(item.quantity)
            and item.word != NO_RESULT
        ]

    @property
    def judged_methods(self) -> list[str]:
        """Whose verdicts a page leads with: the reduced model, and methods of the user's own."""
        # A report is made without the solvers, and some of our methods bring their rows with them.
        brought = [name for name in self.methods if not is_known(name) or METHODS[name].user_made]
        return [*([] if brought and self.not_asked(MODEL) else [MODEL]), *brought]

    @property
    def other_verdicts(self) -> dict[str, tuple[Verdict, ...]]:
        """The verdicts on other methods, at their finest resolutions, that have any result."""
        others = (name for name in self.methods if name not in self.judged_methods)
        known = {name: self.verdicts_on(name) for name in others}
        return {n: v for n, v in known.items() if any(item.word != NO_RESULT for item in v)}

    def by_chance(self, method: str) -> str:
        """Return why a method of lines or statistics holds by chance where it holds; else ""."""
        return self.reference.chance if self.dimension_of(method) < 3 else ""

    @property
    def too_steep(self) -> bool:
        """Whether slopes are so large that agreement says nothing: all methods take them small."""
        return any(doubt.startswith(STEEP) for doubt in self.plan.doubts)

    @property
    def confidence(self) -> str:
        """What the bars of the scene stand for, in words."""
        if self.reference.exact:
            exact = "The reference is exact; u is that of the reduced model's own discretisation"
            read = " and of stresses read off pressures"
            return f"{exact}{read if FROM_PRESSURE & {*self.quantities} else ''}."
        covered = [name for name in self.quantities if is_calibrated(self.tables, name)]
        rest = [quantity(name).label for name in self.quantities if name not in covered]
        if not covered:
            return "u is an estimate from several resolutions; no calibration covers such scenes."
        but = f"; of {', '.join(rest)} an estimate that no calibration covers" if rest else ""
        return f"u is a 95 % half-width, by calibration{but}."


def title_in(scenes: Iterable[SceneRecord], method: str) -> str:
    """Return what a method is called in scenes, by the first that has it."""
    return next((s.title_of(method) for s in scenes if method in s.methods), title_of(method))


def asked_in_vain(records: Iterable[SceneRecord]) -> list[str]:
    """Return a line for each quantity that was asked for and that no method gives."""
    return [
        f"{record.name}: compare.quantities: {name}: {reason}"
        for record in records
        for name, reason in record.unanswered.items()
        if reason.startswith(NOBODY)
    ]


def depends_on_depth(tables: Mapping[str, Any]) -> bool:
    """Tell whether the half-space of a scene has layers, a rigid base, or is graded."""
    half_space = tables.get("half_space")
    return isinstance(half_space, dict) and any(half_space.get(key) for key in DEPTH_KEYS)


def is_calibrated(tables: Mapping[str, Any], name: str) -> bool:
    """Tell whether calibration covers the bar of a quantity of a scene, given by its tables."""
    if depends_on_depth(tables) or "body" in tables or any(key in tables for key in TABLES):
        return False
    return name in (ROUGH_SURFACES if "surface" in tables else SINGLE_CONTACTS)


class StudyRecord(PartHeader):
    """A whole results folder."""

    effort: Literal["quick", "full"]
    interrupted: bool = False
    scenes: tuple[SceneRecord, ...]
    directory: Annotated[Path, Field(exclude=True)] = Path()


# The plots of a scene, drawn one after the other, need the same few files; all would fill memory.
@lru_cache(maxsize=8)
def _checked_fields(path: Path, changed: int) -> Mapping[str, np.ndarray]:
    """Return the arrays of a file as it was at its last change."""
    fields = read_arrays(path)
    problems = field_problems(fields)
    if problems:
        raise ResultsError(f"{path}: damaged results ({'; '.join(problems)})")
    return fields


# Arrays that belong together: of one dimension and one length.
TOGETHER = (
    ("profile_x", "profile_height"),
    ("line_x", "line_height"),
    ("pressure_x", "pressure_y", "pressure", "pressure_weight"),
    ("pressure", "displacement", "gap"),
)
SCALARS = ("penetration", "profile_spacing", "line_penetration", "particle_spacing")
POINTS = ("mesh_points", "mesh_displacement", "particle_places", "particle_displacement")
# Arrays with a row for each particle.
PARTICLES = ("particle_places", "particle_displacement", "particle_von_mises")


def field_problems(fields: dict[str, np.ndarray]) -> list[str]:
    """Return what is wrong with the arrays of one solution, at the last load and before."""
    lists = {name for group in TOGETHER for name in group}
    expected: tuple[tuple[Iterable[str], str, Callable[[np.ndarray], bool]], ...] = (
        ({*lists, *SCALARS, *POINTS}, "numbers", lambda values: values.dtype.kind in "iuf"),
        (SCALARS, "one number", lambda values: values.size == 1),
        (POINTS, "points (n, 3)", lambda values: values.ndim == 2 and values.shape[1] == 3),
    )
    problems = [
        f"{name}: expected {what}"
        for names, what, holds in expected
        for name, values in fields.items()
        if name in names and not holds(values)
    ]
    for group in TOGETHER:
        shapes = {fields[name].shape for name in group if name in fields}
        if len(shapes) > 1 or any(len(shape) != 1 or shape == (0,) for shape in shapes):
            problems.append(f"{', '.join(group)}: expected lists of one length")
    # the arrays that say how others are laid out
    shape = fields.get("pressure_shape")
    if shape is not None and (
        shape.shape != (2,)
        or shape.dtype.kind not in "iu"
        or int(np.prod(shape)) != fields.get("pressure", np.empty(0)).size
    ):
        problems.append("pressure_shape: expected the two numbers of cells of the pressure")
    heights = fields.get("heights")
    if heights is not None:
        size, contact = fields.get("size"), fields.get("contact")
        if heights.ndim != 2 or heights.dtype.kind not in "iuf" or min(heights.shape) < 1:
            problems.append("heights: expected a map of numbers")
        if size is None or size.shape != (2,) or size.dtype.kind not in "iuf":
            problems.append("size: expected two numbers")
        if contact is not None and contact.shape != heights.shape:
            problems.append("contact: expected a map like that of the heights")
    if len({np.shape(fields[name])[:1] for name in PARTICLES if name in fields}) > 1:
        problems.append(f"{', '.join(PARTICLES)}: expected a row for each particle")
    cells, points = fields.get("mesh_cells"), fields.get("mesh_points")
    if cells is not None and (
        cells.ndim != 2
        or cells.dtype.kind not in "iu"
        or points is None
        or not ((cells >= 0) & (cells < len(points))).all()
    ):
        problems.append("mesh_cells: expected numbers of mesh points")
    for step in stored_steps(fields) if not problems else ():
        own = {name: value for name, value in at_step(fields, step).items() if name in NAMES}
        problems += [f"step {step}: {problem}" for problem in field_problems(own)]
    return problems
