"""Curves, settings, failures and costs from the rows of a scene.

The cost is that of the stated error: the error of a mean over random surfaces belongs to the time
of all solves that the mean stands on, the time of one surface, or line, to the errors of single
ones.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial

import numpy as np

from comparisons.facts.methods import GRID, METHODS, ours, title_of
from comparisons.formatting import count
from comparisons.results.rows import Rows
from comparisons.results.store import SceneRecord, once

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
    """The cost of one setting; NaN where it is not known.

    Attributes
    ----------
    seconds, setup_seconds : float
        Of all solves that the stated error stands on, and of their set-up.
    single_seconds : float
        Seconds of one surface or line.
    surfaces : int
        Surfaces or lines solved at this resolution; 1 where the scene is one surface.
    solves : str
        Those of an ensemble, coarse to fine: "375 + 24 surfaces", or "".
    """

    seconds: float
    setup_seconds: float
    single_seconds: float
    surfaces: int
    solves: str

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
