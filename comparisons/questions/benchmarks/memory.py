"""Memory that the plan expects of a solve against what it takes: rows of ``roughline bench``."""

from __future__ import annotations

from pathlib import Path
from typing import Any, NamedTuple

from comparisons.isolation import parent
from comparisons.methods.registry import solver_of
from comparisons.questions.benchmarks.yardstick import Measurement
from comparisons.scene.scene import parse_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

# Largest ratio of plan and measured memory, either way.
WITHIN = 1.2
_SECONDS = 3600.0
_DEPTHS = "loading = { penetration = [1e-3, 1e-2] }"
_ROUGH = """
surface = { kind = "self_affine", hurst = 0.8, rms_slope = 0.1, size = 1.0, points = 8 }
loading = { force = { values = [0.02], relative_to = "E* A0 h'" } }
"""


def _large(loads: str, *, periodic: bool) -> str:
    """Return a patch whose shortest wave has 16 cells, 22 to 24 % of which is in contact."""
    waves = f"points = 2048, short_cutoff = {16 / 2048}, periodic = {str(periodic).lower()}"
    return f"""
surface = {{ kind = "self_affine", hurst = 0.8, rms_slope = 0.1, size = 1.0, {waves} }}
loading = {{ force = {{ values = {loads}, relative_to = "E* A0 h'" }} }}
"""


def _pressed(shape: str, loading: str = _DEPTHS) -> str:
    return f"indenter = {{ {shape} }}\n{loading}\n"


_BALL, _FORCE = 'shape = "paraboloid", radius = 1.0', "loading = { force = 1e-3 }"
_CYLINDER = 'shape = "cylinder", radius = 1.0'


class Case(NamedTuple):
    """A way through a method at several resolutions."""

    title: str  # the scene has a half-space of E = 1 and nu = 0.3
    method: str
    scene: str
    resolutions: tuple[int, ...]
    options: str = ""  # of the method, as in a scene
    quantities: str = ""  # by default those of the scene

    def text(self, resolution: int) -> str:
        """Return the scene at one resolution."""
        quantities = f", quantities = {self.quantities}" if self.quantities else ""
        return f"""name = "memory"
half_space = {{ youngs_modulus = 1.0, poisson_ratio = 0.3 }}
{self.scene}
compare = {{ methods = ["{self.method}"], resolutions = [{resolution}]{quantities} }}
methods.{self.method} = {{ {self.options} }}
"""


_TWO = "[0.05, 0.1125]"
_ITERATED = 'solver = "conjugate_gradients"'
_PAIR = "counter_body = { youngs_modulus = 1.0, poisson_ratio = 0.3 }\n" + _pressed(_BALL)
_LONG = 'shape = "ellipsoid", radius_x = 10.0, radius_y = 1.0'
CASES = {
    "fem": (
        Case("fem, paraboloid", "fem", _pressed(_BALL), (4, 6, 8)),
        Case("fem, cylinder", "fem", _pressed(_CYLINDER), (4, 6, 8)),
        Case("fem, ellipsoid", "fem", _pressed(_LONG), (3, 4, 6)),
        Case("fem, square", "fem", _pressed('shape = "square_punch", side = 1.0'), (3, 5, 8)),
        Case("fem, two bodies", "fem", _PAIR, (3, 4, 6)),
        Case("fem, block below a patch", "fem", _ROUGH, (16, 24, 32), 'mesh = "block"'),
        Case("fem by iteration, paraboloid", "fem", _pressed(_BALL), (6, 10, 16), _ITERATED),
        Case("fem by iteration, ellipsoid", "fem", _pressed(_LONG), (4, 6, 10), _ITERATED),
    ),
    "bem": (
        Case("bem_dense, two depths", "bem_dense", _pressed(_BALL), (15, 20, 27)),
        Case("bem_dense, one force", "bem_dense", _pressed(_BALL, _FORCE), (18, 22, 27)),
        Case("bem_dense, cylinder", "bem_dense", _pressed(_CYLINDER), (20, 25, 30)),
        Case("bem_dense, patch", "bem_dense", _ROUGH, (64, 96, 128)),
        Case("bem_fft, periodic, a load", "bem_fft", _large("[0.1125]", periodic=True), (2048,)),
        Case("bem_fft, periodic, two loads", "bem_fft", _large(_TWO, periodic=True), (2048,)),
        Case(
            "bem_fft, periodic, stiffness",
            "bem_fft",
            _large(_TWO, periodic=True),
            (2048,),
            "",
            '["stiffness"]',
        ),
        Case("bem_fft, free, two loads", "bem_fft", _large(_TWO, periodic=False), (2048,)),
    ),
}


def rows(cases: tuple[Case, ...]) -> list[Measurement]:
    """Return a row for each case and resolution, each case measured in a process of its own."""
    yardstick, measured = "the plan, either way (ratio of both)", []
    for case in cases:
        work = f"{__name__}:{expected_and_taken.__name__}"
        outcome = parent.run(work, *case, seconds=_SECONDS)
        if not outcome.ok:
            text = f"memory of {case.title}: {outcome.reason}"
            measured.append(Measurement(text, float("nan"), yardstick, target=WITHIN))
            continue
        found = zip(case.resolutions, outcome.answer["memory"], strict=True)
        for resolution, (plan, taken, spent) in found:
            text = f"memory of {case.title}, {resolution}: {taken / 1e6:.0f} MB, "
            text += f"{plan / 1e6:.0f} MB by the plan"
            ratio = float(max(plan / taken, taken / plan))
            measured.append(Measurement(text, spent, yardstick, None, ratio, WITHIN))
    return measured


def expected_and_taken(*case: Any) -> dict[str, list[list[float]]]:
    """Return bytes by the plan, those of a second solve (the first compiles) and its seconds."""
    described, measured = Case(*case), []
    for resolution in described.resolutions:
        scene = parse_scene(described.text(resolution), "memory", Path())
        (plan, *_) = plan_scene(scene, "full")
        task = task_of(plan, described.method, resolution)
        _, solution = execute(task, 1), execute(task, 1)
        if not solution.converged.all():
            raise RuntimeError(f"{described.title}, {resolution}: no answer")
        measured.append([solver_of(task).memory(task), solution.memory, solution.seconds])
    return {"memory": measured}
