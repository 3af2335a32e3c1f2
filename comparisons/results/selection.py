"""What the page, the terminal, advice, tables and notebooks read from the results of a scene.

Curves, settings, failures and costs. The cost is that of the stated error: the error of a mean over
random surfaces belongs to the time of all solves that the mean stands on, the time of one surface,
or line, to the errors of single ones.

Verdicts that decide, on each quantity of a setting, a method or a scene. Every quantity is judged
once, at equal prescribed load (the prescribed one, force or penetration, at an equal value of the
other), by the step that `comparisons.judging.verdicts.judged` selects. Errors at the other load are
listed (`second_rows`) but never affect a verdict. A bar is one of 95 % where calibration shows it,
else an estimate by the same rules (`confidence`).
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np

from comparisons.facts.methods import GRID, METHODS, MODEL, NOT_ASKED, is_known, ours, title_of
from comparisons.facts.quantities import FIELDS, main_axis, quantity
from comparisons.formatting import count
from comparisons.judging.verdicts import LAST_LOAD, NO_RESULT, Verdict
from comparisons.results.rows import Rows
from comparisons.results.store import SceneRecord, once
from comparisons.scene.half_space import DEPTH_KEYS
from comparisons.scene.physics.tables import TABLES
from comparisons.tasks.stresses import FROM_PRESSURE

MEAN = "mean"
NONE = np.empty(0, dtype=int)  # places of no rows


@dataclass(frozen=True)
class Failure:
    """A planned solve that failed."""

    method: str
    resolution: float
    reason: str
    seconds: float
    load: float


def drawn_along(scene: SceneRecord) -> str:
    """Return the column that curves are drawn over: time, or the prescribed load."""
    return "time" if scene.along == "time" else scene.control


def compared_along(scene: SceneRecord, rows: Rows) -> np.ndarray:
    """Return the values of the axis that steps are compared along; steps count from one."""
    values = rows[scene.along]
    return values + 1 if scene.along == "step" else values


@once
def methods(scene: SceneRecord) -> list[str]:
    """Return the methods that appear in the plan or the rows, in the order of every legend."""
    names = [item.method for item in scene.plan.methods] + scene.rows["method"].tolist()
    built_in = [name for name in ours() if name in names]
    return built_in + [name for name in dict.fromkeys(names) if name and name not in built_in]


def title(scene: SceneRecord, method: str) -> str:
    """Return what a method is called on a scene: finite elements have two kinds of meshes."""
    return scene.called(method) or title_of(method)


@once
def unsupported(scene: SceneRecord) -> dict[str, str]:
    """Return the methods that cannot do the scene, each with its reason."""
    refusals = {item.method: item.reason for item in scene.plan.methods if not item.supported}
    reasons = dict(zip(scene.rows["method"], scene.rows["reason"], strict=True))
    return {name: reason or reasons.get(name, "") for name, reason in refusals.items()}


@once
def solved(scene: SceneRecord) -> Rows:
    """Return the rows that hold a converged load step."""
    return scene.rows.where(scene.rows["converged"] & np.isfinite(scene.rows["step"]))


def solved_rows(scene: SceneRecord, method: str) -> Rows:
    """Return the converged load steps of one method."""
    by_method = _solved_by_method(scene)
    return by_method[method] if method in by_method else scene.rows.where(NONE)


@once
def _solved_by_method(scene: SceneRecord) -> dict[str, Rows]:
    rows = solved(scene)
    names = rows["method"]
    return {name: rows.where(names == name) for name in dict.fromkeys(names)}


@once
def resolutions(scene: SceneRecord, method: str) -> list[float]:
    """Return the resolutions at which a method solved anything, ascending."""
    return sorted(set(solved_rows(scene, method)["resolution"]))


def setting_rows(scene: SceneRecord, method: str, resolution: float) -> Rows:
    """Return all rows of a method at a resolution, solved or lost."""
    by_setting = _by_setting(scene)
    key = (method, float(resolution))
    return by_setting[key] if key in by_setting else scene.rows.where(NONE)


def run_at(scene: SceneRecord, method: str) -> list[float]:
    """Return the resolutions at which a method was run, ascending."""
    return sorted(level for name, level in _by_setting(scene) if name == method)


@once
def _by_setting(scene: SceneRecord) -> dict[tuple[str, float], Rows]:
    names, level = scene.rows["method"], scene.rows["resolution"]
    settings = dict.fromkeys(zip(names, level.tolist(), strict=True))
    return {
        (name, n): scene.rows.where((names == name) & (level == n))
        for name, n in settings
        if np.isfinite(n)
    }


@once
def curve(scene: SceneRecord, method: str, resolution: float | None = None) -> Rows:
    """Return one row per load step: ensemble means, or the only realisation; finest by default.

    Where a method ran with several options, the first set is taken.
    """
    rows = solved_rows(scene, method)
    level = rows["resolution"]
    finest = max(level[np.isfinite(level)], default=np.nan) if resolution is None else resolution
    rows = rows.where(level == finest) if np.isfinite(finest) else rows
    if not len(rows):  # it lost all its steps
        return rows
    options, names = rows["options"], rows["realisation"]
    names[options != options[0]] = None
    chosen = MEAN if MEAN in names else names[0]
    rows = rows.where(names == chosen)
    return rows.where(np.argsort(rows["step"], kind="stable"))


@once
def realisations(scene: SceneRecord, method: str, resolution: float) -> Rows:
    """Return the single realisations of an ensemble (empty where there is one surface only)."""
    rows = solved_rows(scene, method)
    single = rows.where((rows["resolution"] == resolution) & (rows["realisation"] != MEAN))
    return single if len(set(single["realisation"])) > 1 else rows.where(NONE)


@once
def failures(scene: SceneRecord) -> list[Failure]:
    """Return the planned solves that were lost (methods that cannot do the scene are none)."""
    rows = scene.rows.where(~scene.rows["converged"])
    columns = [rows[name] for name in ("method", "resolution", "reason", "seconds")]
    several = map(Failure, *columns, compared_along(scene, rows))
    # An ensemble that fails for one reason is one failure, not hundreds.
    lost: dict[tuple[str, ...], Failure] = {}
    for item in several:
        if item.method not in unsupported(scene):
            key = (item.method, str(item.resolution), item.reason, str(item.load))
            lost.setdefault(key, item)
    return list(lost.values())


def is_reference(scene: SceneRecord, method: str, resolution: float) -> bool:
    """Tell whether a setting is the reference itself."""
    return (method, resolution) == (scene.reference.method, scene.reference.resolution)


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


@once
def cost(record: SceneRecord, method: str, resolution: float) -> Cost:
    """Return the cost of a setting, from the rows of results.csv."""
    first = partial(_first, record, method, resolution)
    surfaces, solves = int(first("surfaces", 1.0)), ""
    if surfaces > 1:  # in words what a mean stands on (`comparisons.judging.levels.Levels`)
        row = METHODS.get(method)
        levels = [n for n in run_at(record, method) if n <= resolution]
        beside = ""
        three = row is None or row.dimension == 3
        if three and method != GRID and run_at(record, GRID):
            levels, beside = [resolution], f" beside those of {title_of(GRID)}"
        numbers = [count(_first(record, method, n, "surfaces", 1.0)) for n in levels]
        noun = "lines" if row is not None and row.dimension == 1 else "surfaces"
        solves = f"{' + '.join(numbers)} {noun}{beside}"
    return Cost(
        seconds=first("seconds_all"),
        setup_seconds=first("setup_seconds_all"),
        single_seconds=first("seconds"),
        surfaces=surfaces,
        solves=solves,
    )


def spent(record: SceneRecord) -> float:
    """Return the seconds of all solves of a scene, each counted once."""
    settings = [(m, n) for m in methods(record) for n in run_at(record, m)]
    return float(np.nansum([cost(record, *setting).spent for setting in settings]))


def _first(
    record: SceneRecord, method: str, resolution: float, name: str, missing: float = np.nan
) -> float:
    """Return the first number in a column of a setting, whose rows share it."""
    values = setting_rows(record, method, resolution)[name]
    return float(next((value for value in values if np.isfinite(value)), missing))


NOBODY = "not computed by any method that was run"


def equal_at(record: SceneRecord, name: str) -> str:
    """Return what is equal where a quantity is judged."""
    return LAST_LOAD if name in FIELDS else main_axis(record.along, name)


@once
def unanswered(record: SceneRecord) -> dict[str, str]:
    """Return the asked quantities that can be judged for no method at all, each with the reason."""
    reasons = {item.quantity: item.reason for item in record.verdicts if not item.counts}
    return {name: reasons[name] for name in record.quantities if name in reasons}


def asked_in_vain(records: Iterable[SceneRecord]) -> list[str]:
    """Return a line for each quantity that was asked for and that no method gives."""
    return [
        f"{record.name}: compare.quantities: {name}: {reason}"
        for record in records
        for name, reason in unanswered(record).items()
        if reason.startswith(NOBODY)
    ]


@once
def levels(record: SceneRecord, method: str) -> list[int]:
    """Return the resolutions at which a method was run, ascending, but for the truth itself."""
    run = map(int, run_at(record, method))
    return [n for n in run if not is_reference(record, method, n)]


@once
def finest(record: SceneRecord, method: str) -> int | None:
    """Return the finest resolution, but the truth's, among those that solved the most steps."""
    rows = solved_rows(record, method)
    resolution, step = (rows[key] for key in ("resolution", "step"))
    counts = {n: len(set(step[resolution == n])) for n in levels(record, method)}
    most = max(counts.values(), default=0)
    return max((n for n, count in counts.items() if count == most), default=None)


@once
def setting_verdicts(record: SceneRecord, method: str, resolution: float) -> tuple[Verdict, ...]:
    """Return the verdict on each asked quantity of one method at one resolution."""
    known = _judged(record).get((method, float(resolution)), {})
    nothing = unanswered(record)
    unasked = f"the {title(record, method)} was not asked for"
    return tuple(
        known.get(name)
        or Verdict(
            method=method,
            quantity=name,
            at=equal_at(record, name),
            tolerance=record.tolerance,
            reason=nothing.get(name, unasked),
            counts=name not in nothing,
        )
        for name in record.quantities
    )


@once
def _judged(record: SceneRecord) -> dict[tuple[str, float], dict[str, Verdict]]:
    """Return the verdicts that decide: method and resolution -> quantity -> verdict."""
    settings: dict[tuple[str, float], dict[str, Verdict]] = {}
    for item in record.verdicts:
        if item.at == equal_at(record, item.quantity):
            settings.setdefault((item.method, item.resolution), {})[item.quantity] = item
    return settings


def by_chance(record: SceneRecord, method: str) -> str:
    """Return why a method of lines or statistics holds by chance where it holds; else ""."""
    row = METHODS.get(method)
    return record.reference.chance if row is not None and row.dimension < 3 else ""


def verdicts(record: SceneRecord, method: str = MODEL) -> tuple[Verdict, ...]:
    """Return a verdict per asked quantity: the method's at its finest resolution."""
    return setting_verdicts(record, method, finest(record, method) or 0)


def second_rows(record: SceneRecord) -> list[Verdict]:
    """Return what is known of the model at the other load: to be looked up, it decides nothing."""
    level = finest(record, MODEL)
    return [
        item
        for item in record.verdicts
        if item.method == MODEL
        and item.resolution == level
        and item.quantity in record.quantities
        and item.at != equal_at(record, item.quantity)
        and item.word != NO_RESULT
    ]


def judged_methods(record: SceneRecord) -> list[str]:
    """Return whose verdicts a page leads with: the reduced model, and methods of the user's own."""
    # A report is made without the solvers, and some of our methods bring their rows with them.
    user_methods = [
        name for name in methods(record) if not is_known(name) or METHODS[name].user_made
    ]
    return [*([] if user_methods and not_asked(record, MODEL) else [MODEL]), *user_methods]


def not_asked(record: SceneRecord, method: str) -> bool:
    """Tell whether a method was left out by the scene."""
    refused = unsupported(record)
    return method not in methods(record) or refused.get(method) == NOT_ASKED


# Quantities whose bars `roughline calibrate` holds against true errors.
SINGLE_CONTACTS = ("force", "penetration", "contact_area", "stiffness")
ROUGH_SURFACES = ("contact_area", "penetration", "mean_gap", "stiffness")
WHERE = (
    "95 % where calibration shows it: force, penetration, contact area, mean gap and stiffness of "
    "frictionless, elastic contacts on uniform half-spaces; elsewhere an estimate by the same rules"
)


def depends_on_depth(tables: Mapping[str, Any]) -> bool:
    """Tell whether the half-space of a scene has layers, a rigid base, or is graded."""
    half_space = tables.get("half_space")
    return isinstance(half_space, dict) and any(half_space.get(key) for key in DEPTH_KEYS)


def is_calibrated(tables: Mapping[str, Any], name: str) -> bool:
    """Tell whether calibration covers the bar of a quantity of a scene, given by its tables."""
    if depends_on_depth(tables) or "body" in tables or any(key in tables for key in TABLES):
        return False
    return name in (ROUGH_SURFACES if "surface" in tables else SINGLE_CONTACTS)


def confidence(record: SceneRecord) -> str:
    """Say what the bars of a scene stand for, in words."""
    if record.reference.exact:
        cells = (
            " and of stresses read off pressures" if FROM_PRESSURE & {*record.quantities} else ""
        )
        return f"The truth is exact; u is that of the reduced model's own discretisation{cells}."
    covered = [name for name in record.quantities if is_calibrated(record.tables, name)]
    rest = [quantity(name).label for name in record.quantities if name not in covered]
    if not covered:
        return "u is an estimate from several resolutions; no calibration covers such scenes."
    but = f"; of {', '.join(rest)} an estimate that no calibration covers" if rest else ""
    return f"u is a 95 % half-width, by calibration{but}."
