"""Section 19.7, step 6: rough rubber friction of lines against that of surfaces."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from comparisons.judging.uncertainty import combined, ratio_of_means
from comparisons.questions.experiments.rough_ensemble import compare
from comparisons.questions.experiments.running import Finding, above, experiment, one_of
from comparisons.questions.single import solve_scene

_SCENE, _GRID, _LINES = "sliding-rough", 48, 300
_FORCE = 20.0  # mN, of the scene


@lru_cache(maxsize=256)
def _coefficients(method: str, grid: int, speed: float, force: float) -> np.ndarray:
    """Return the coefficients of friction of the scene's surfaces, or of many lines."""
    changes: dict[str, object] = {
        "sliding.speed": [f"{speed!r} mm/s"],
        "loading.force": [f"{force!r} mN"],
    }
    if method == "reduced":
        changes["surface.realisations"] = _LINES
    solved = solve_scene(_SCENE, method, grid, changes).solution
    return np.asarray(solved.quantities["friction_coefficient"][:, 0])


def _rubber(
    effort: str, *, speed: float = 10.0, force: float = _FORCE, statement: str = "line"
) -> Finding:
    """Compare coefficients of friction at a speed in mm/s and a force in mN.

    ``"line"``: means over lines against means over surfaces. ``"load"``: surfaces under this force
    against the same surfaces under 20 mN. The bar of the grid is its last change, first order.
    """
    above("speed", speed, 0)
    above("force", force, 0)
    one_of("statement", statement, "line", "load")
    finest = 2 * _GRID if effort == "full" else _GRID
    coarse, fine = (
        _coefficients("bem_fft", n, float(speed), float(force)) for n in (finest // 2, finest)
    )
    change = 1.25 * abs(float(fine.mean() / coarse.mean()) - 1)
    if statement == "line":
        lines = _coefficients("reduced", 2 * _GRID, float(speed), float(force))
        error, bar = compare(lines, fine, change)
        return Finding(error, bar, {"lines": float(lines.mean()), "surfaces": float(fine.mean())})
    base = _coefficients("bem_fft", finest, float(speed), _FORCE)
    ratio, scatter = ratio_of_means(fine[:, None], base[:, None], paired=True)
    bar = float(combined(float(scatter[0]), change))
    details: dict[str, float | str] = {"there": float(fine.mean()), "at 20 mN": float(base.mean())}
    return Finding(float(ratio[0]) - 1, bar, details)


EXPERIMENTS = (
    experiment(
        "rough-rubber",
        "Friction of rough rubber: lines against surfaces, and its change with the load",
        "speed v / (mm/s)",
        "speed",
        _rubber,
    ),
)
