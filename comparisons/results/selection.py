"""Selection of curves, settings and failures from the rows of a scene.

Columns of results.csv may be missing, empty or read back as another type; this module handles
that, so that plots and tables need not.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import pandas as pd

from comparisons.facts.methods import ours, title_of
from comparisons.results.store import SceneRecord, once

MEAN = "mean"


@dataclass(frozen=True)
class Failure:
    """A planned solve that failed."""

    method: str
    resolution: float
    reason: str
    load: float
    seconds: float


def column(rows: pd.DataFrame, name: str) -> np.ndarray:
    """Return a column as floats, NaN where it is missing or not a number."""
    if name not in rows:
        return np.full(len(rows), np.nan)
    stored = rows[name]
    if stored.dtype != float:  # a page asks thousands of times, and nearly all are numbers already
        stored = pd.to_numeric(stored, errors="coerce")
    values = stored.to_numpy(dtype=float)
    return np.where(np.isfinite(values), values, np.nan)


def drawn_along(scene: SceneRecord) -> str:
    """Return the column that curves are drawn over: time, or the prescribed load."""
    return "time" if scene.along == "time" else scene.control


def compared_along(scene: SceneRecord, rows: pd.DataFrame) -> np.ndarray:
    """Return the values of the axis that steps are compared along; steps count from one."""
    values = column(rows, scene.along)
    return values + 1 if scene.along == "step" else values


def texts(rows: pd.DataFrame, name: str) -> list[str]:
    """Return a column as text, empty where it is missing."""
    if name not in rows:
        return [""] * len(rows)
    # A plain array: walking through a column of pandas costs ten times as much.
    values = rows[name].to_numpy(dtype=object)
    absent = pd.isna(values)
    return ["" if no else str(value) for value, no in zip(values, absent, strict=True)]


def _is_true(value: object) -> bool:
    return str(value).strip().lower() in {"true", "1", "1.0"}


def converged(rows: pd.DataFrame) -> np.ndarray:
    """Return which rows converged (the column may come back as text)."""
    if "converged" not in rows:
        return np.ones(len(rows), dtype=bool)
    if rows["converged"].dtype == bool:
        return rows["converged"].to_numpy()
    return np.array([_is_true(value) for value in rows["converged"]], dtype=bool)


@once
def methods(scene: SceneRecord) -> list[str]:
    """Return the methods that appear in the plan or the rows, in the order of every legend."""
    names = [str(item.get("method", "")) for item in scene.plan.get("methods", [])]
    names += texts(scene.rows, "method")
    built_in = [name for name in ours() if name in names]
    return built_in + [name for name in dict.fromkeys(names) if name and name not in built_in]


def title(scene: SceneRecord, method: str) -> str:
    """Return what a method is called on a scene: finite elements have two kinds of meshes."""
    return scene.called(method) or title_of(method)


@once
def unsupported(scene: SceneRecord) -> dict[str, str]:
    """Return the methods that cannot do the scene, each with its reason."""
    refusals = {
        str(item.get("method", "")): str(item.get("reason", ""))
        for item in scene.plan.get("methods", [])
        if not item.get("supported", True)
    }
    reasons = dict(zip(texts(scene.rows, "method"), texts(scene.rows, "reason"), strict=True))
    return {name: reason or reasons.get(name, "") for name, reason in refusals.items()}


@once
def solved(scene: SceneRecord) -> pd.DataFrame:
    """Return the rows that hold a converged load step."""
    keep = converged(scene.rows) & np.isfinite(column(scene.rows, "step"))
    return scene.rows[keep]


def solved_rows(scene: SceneRecord, method: str) -> pd.DataFrame:
    """Return the converged load steps of one method."""
    by_method = _solved_by_method(scene)
    return by_method[method] if method in by_method else solved(scene).iloc[:0]


@once
def _solved_by_method(scene: SceneRecord) -> dict[str, pd.DataFrame]:
    rows = solved(scene)
    names = np.array(texts(rows, "method"), dtype=object)
    return {name: rows[names == name] for name in dict.fromkeys(names)}


@once
def resolutions(scene: SceneRecord, method: str) -> list[float]:
    """Return the resolutions at which a method solved anything, ascending."""
    return sorted(set(column(solved_rows(scene, method), "resolution")))


def setting_rows(scene: SceneRecord, method: str, resolution: float) -> pd.DataFrame:
    """Return all rows of a method at a resolution, solved or lost."""
    by_setting = _by_setting(scene)
    key = (method, float(resolution))
    return by_setting[key] if key in by_setting else scene.rows.iloc[:0]


def run_at(scene: SceneRecord, method: str) -> list[float]:
    """Return the resolutions at which a method was run, ascending."""
    return sorted(level for name, level in _by_setting(scene) if name == method)


@once
def _by_setting(scene: SceneRecord) -> dict[tuple[str, float], pd.DataFrame]:
    names = np.array(texts(scene.rows, "method"), dtype=object)
    level = column(scene.rows, "resolution")
    settings = dict.fromkeys(zip(names, level.tolist(), strict=True))
    return {
        (name, n): scene.rows[(names == name) & (level == n)]
        for name, n in settings
        if np.isfinite(n)
    }


@once
def curve(scene: SceneRecord, method: str, resolution: float | None = None) -> pd.DataFrame:
    """Return one row per load step: ensemble means, or the only realisation; finest by default.

    Where a method ran with several options, the first set is taken.
    """
    rows = solved_rows(scene, method)
    if rows.empty:
        return rows
    level = column(rows, "resolution")
    finest = np.nanmax(level) if resolution is None else resolution
    rows = rows[level == finest] if np.isfinite(finest) else rows
    if rows.empty:  # it lost all its steps
        return rows
    options, names = (
        np.array(texts(rows, name), dtype=object) for name in ("options", "realisation")
    )
    names[options != options[0]] = None
    chosen = MEAN if MEAN in names else names[0]
    return rows[names == chosen].sort_values("step")


@once
def realisations(scene: SceneRecord, method: str, resolution: float) -> pd.DataFrame:
    """Return the single realisations of an ensemble (empty where there is one surface only)."""
    rows = solved_rows(scene, method)
    rows = rows[column(rows, "resolution") == resolution]
    single = rows[[name != MEAN for name in texts(rows, "realisation")]]
    return single if len(set(texts(single, "realisation"))) > 1 else single.iloc[:0]


@once
def failures(scene: SceneRecord) -> list[Failure]:
    """Return the planned solves that were lost (methods that cannot do the scene are none)."""
    rows = scene.rows[~converged(scene.rows)]
    lost = pd.DataFrame(
        {
            "method": texts(rows, "method"),
            "resolution": column(rows, "resolution"),
            "reason": texts(rows, "reason"),
            "load": compared_along(scene, rows),
            "seconds": column(rows, "seconds"),
        }
    )
    lost = lost[~lost["method"].isin(list(unsupported(scene)))]
    # An ensemble that fails for one reason is one failure, not hundreds.
    lost = lost.drop_duplicates(["method", "resolution", "reason", "load"])
    return [Failure(*row) for row in lost.itertuples(index=False)]


def reference(scene: SceneRecord) -> tuple[str, float]:
    """Return method and resolution of the reference ("" and NaN where there is none)."""
    method = str(scene.reference.get("method") or "")
    value = pd.to_numeric(scene.reference.get("resolution"), errors="coerce")
    return method, float(value) if value is not None and np.isfinite(value) else float("nan")


def is_reference(scene: SceneRecord, method: str, resolution: float) -> bool:
    """Tell whether a setting is the reference itself."""
    name, level = reference(scene)
    return method == name and (not np.isfinite(level) or level == resolution)


def compared_measures(
    scene: SceneRecord, method: str | None = None, *, details: bool = False
) -> pd.DataFrame:
    """Return the measures of the quantities that were asked for, of one method or of all.

    With `details`, a comparison of pressures brings its peak and its integral with it.
    """
    table = scene.measures
    if "quantity" not in table or table.empty:
        return pd.DataFrame(columns=["method", "resolution", "quantity", "at"])
    keep = table["quantity"].isin(scene.quantities)
    if details and "pressure" in scene.quantities:
        keep |= table["quantity"].astype(str).str.startswith("pressure_")
    if method is not None:
        keep &= table["method"] == method
    return table[keep]
