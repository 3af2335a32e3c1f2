"""Section 19.7, step 6: rough rubber friction of lines against that of surfaces."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from comparisons.judging.uncertainty import combined, ratio_of_means
from comparisons.questions.experiments.experiment import Above, Finding, experiment
from comparisons.questions.experiments.rough_ensemble import compare
from comparisons.questions.single import solve_scene
from comparisons.solving.shared import shared

_SCENE, _GRID, _LINES = "sliding-rough", 48, 300
_FORCE = 20.0  # mN, of the scene
# Four times the force, on many surfaces; what a finer grid changes, on a few of them.
_MORE, _MANY, _FEW = 4.0, 64, 4


@shared(maxsize=256)
def _coefficients(method: str, grid: int, speed: float, force: float, count: int = 0) -> np.ndarray:
    """Return the coefficients of friction of `count` surfaces (0: the scene's), or lines."""
    changes: dict[str, object] = {
        "sliding.speed": [f"{speed!r} mm/s"],
        "loading.force": [f"{force!r} mN"],
    }
    if count:
        changes["surface.realisations"] = count
    solved = solve_scene(_SCENE, method, grid, changes).solution
    return np.asarray(solved.quantities["friction_coefficient"][:, 0])


def _line(effort: str, speed: float, force: float) -> Finding:
    """Compare means over lines with means over surfaces; the grid counts with its last change."""
    finest = 2 * _GRID if effort == "full" else _GRID
    coarse, fine = (_coefficients("bem_fft", n, speed, force) for n in (finest // 2, finest))
    change = 1.25 * abs(float(fine.mean() / coarse.mean()) - 1)
    lines = _coefficients("reduced", 2 * _GRID, speed, force, _LINES)
    return compare(lines, fine, change, {})


def _load(effort: str, speed: float, force: float) -> Finding:
    """Compare surfaces under four times the force with themselves.

    The ratio of many surfaces on one grid, times what the next finer grid changes of that of a few:
    grids err alike at both loads. That change is the bar of the grid.
    """
    many, grid = (_MANY, _GRID) if effort == "full" else (_MANY // 4, _GRID // 2)

    def pair(grid: int, count: int) -> list[np.ndarray]:
        return [_coefficients("bem_fft", grid, speed, f, count) for f in (_MORE * force, force)]

    (more, base), finer = pair(grid, many), pair(2 * grid, _FEW)
    ratio, scatter = ratio_of_means(more[:, None], base[:, None], paired=True)
    coarse = float(more[:_FEW].mean() / base[:_FEW].mean())
    change = float(finer[0].mean() / finer[1].mean()) / coarse
    bar = float(combined(float(scatter[0]), 1.25 * abs(change - 1)))
    once = float(base.mean())
    return Finding(float(ratio[0]) * change * once, once, bar, {})


@experiment(
    "rough-rubber",
    "Friction of rough rubber: lines against surfaces, and its change with the load",
    "speed",
    "speed v / (mm/s)",
)
def rough_rubber(
    effort: str,
    *,
    speed: Annotated[float, Above(0)] = 10.0,
    force: Annotated[float, Above(0)] = _FORCE,
    statement: Literal["line", "load"] = "line",
) -> Finding:
    """Compare coefficients of friction at a speed in mm/s and a force in mN.

    ``"line"``: means over lines against means over surfaces. ``"load"``: surfaces under four times
    the force against the same surfaces under it.
    """
    compared = {"line": _line, "load": _load}
    return compared[statement](effort, float(speed), float(force))
