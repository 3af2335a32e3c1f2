"""Problem 1 and section 19.7, step 6: rubber that slides, as printed, as corrected, and in 3-D."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from comparisons.judging.uncertainty import combined, ratio_of_means
from comparisons.questions.experiments.experiment import (
    Above,
    Finding,
    OneOf,
    Share,
    experiment,
    share_of,
    worst,
)
from comparisons.questions.experiments.rough_ensemble import compare
from comparisons.questions.single import solve_scene
from comparisons.solving.shared import shared
from reduced.loads import Load, LoadPath
from reduced.memory.materials import kelvin_voigt, standard_solid
from reduced.rough.ensemble import RandomLines
from reduced.rough.line_spectrum import prescribed
from reduced.rough.lines import RoughLines
from reduced.rough.press import press
from reduced.rough.surface_spectrum import SelfAffine
from reduced.rubber.history import slide_in_time
from reduced.rubber.printed import slide_as_printed
from reduced.rubber.steady import slide
from reference import loads as reference_loads
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rubber import paraboloid

# Lines of length 1 with 32 or more points to the shortest of their 16 waves; loads with a tenth in
# contact.
_SHORTEST, _PER_WAVE, _LOAD = 1 / 16, 32.0, 3e-3
_QUANTITIES = ("friction", "work", "start")
_RADIUS, _DEPTH = 1.0, 0.01
_ROUNDING = 1e-9  # relative tolerance of forces is 1e-11


def _rough_lines(count: int, per_wave: float = _PER_WAVE) -> RoughLines:
    points = round(float(per_wave) / _SHORTEST)
    spectrum = prescribed(64, 1.0, SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=_SHORTEST))
    return RandomLines(spectrum, points, count, seed=7).draw()


@experiment("printed-rubber", "explicit relaxation number G dt/eta = dx/(v tau)")
def printed_rubber(
    effort: str,
    *,
    number: Annotated[float, Above(0)] = 1.0,
    quantity: Annotated[str, OneOf(*_QUANTITIES)] = "friction",
    per_wave: Annotated[float, Above(2)] = _PER_WAVE,
    load: Annotated[float, Above(0)] = _LOAD,
) -> Finding | Share:
    """Problem 1 as printed on rough lines against their exact steady state.

    `per_wave`: points to the shortest wave of the lines; `load`: F/(G L), with rms slopes of 0.1.

    ``"friction"``: its friction over that of the exact steady state, mean over the lines.
    ``"work"``: the work of its forces on the moving springs over what is dissipated in the exact
    steady state. ``"start"``: the fraction of lines without contact at its start, 3 rms from the
    zero line.
    """
    rough = _rough_lines(20 if effort == "full" else 6, per_wave)
    points = rough.heights.shape[1]
    if quantity == "start":
        missed = [line.max() < 3 * np.sqrt(np.mean(line**2)) for line in rough.heights]
        return share_of(sum(missed), len(rough), {"lines": float(len(rough))})
    speed, rubber = 1 / (points * number), kelvin_voigt(1.0, 1.0)
    exact = slide(rough, rubber, speed, LoadPath("force", load))
    runs = []  # from static contact on
    for line in (rough[row] for row in range(len(rough))):
        at_rest = press(line, 4.0, Load("force", load), edges="nodal").penetration.item()
        level = float(line.heights.max()) - at_rest
        runs.append(slide_as_printed(line, rubber, speed, load, steps=4 * points, level=level))
    done = [run.outcome == "completed" for run in runs]
    name = "tangential_force" if quantity == "friction" else "conjugate_force"
    forces = [float(getattr(run, name)[-points:].mean()) for run in runs]
    ratios = np.array(forces) / exact.tangential_force[:, 0]
    bar = 2 * float(ratios.std(ddof=1)) / np.sqrt(len(ratios))
    details = {
        "lines": float(len(rough)),
        "lines that ended": float(np.sum(done)),
        "largest error of a line": float(np.abs(ratios - 1).max()),
        "springs in tension": float(np.mean([run.tensile_count[-points:].mean() for run in runs])),
    }
    return Finding(float(ratios.mean()), 1.0, bar, details)


@experiment("corrected-rubber", "explicit relaxation number G dt/eta = dx/(v tau)")
def corrected_rubber(
    effort: str,
    *,
    number: Annotated[float, Above(0)] = 1.0,
    quantity: Literal["work", "friction"] = "work",
) -> Finding:
    """Problem 1 as corrected, step by step, on rough lines: its energy and its steady state.

    At the same `number`, after three periods. ``"work"``: the work of its forces against the
    dissipated energy, over the last period. ``"friction"``: friction in the last period against the
    exact steady state. The worst line counts.
    """
    rough = _rough_lines(20 if effort == "full" else 6)
    points = rough.heights.shape[1]
    speed = 1 / (points * number)
    rubber = kelvin_voigt(1.0, 1.0)
    run = slide_in_time(rough, rubber, speed, _LOAD, steps=3 * points)
    exact = slide(rough, rubber, speed, LoadPath("force", _LOAD))
    if quantity == "work":
        stated, true = 1 + run.energy_error(), np.ones(len(rough))
    else:
        stated, true = run.friction_coefficient(), exact.friction_coefficient[:, 0]
    details = {
        "lines": float(len(rough)),
        "mean": float((stated / true - 1).mean()),
    }
    return Finding(*worst(stated, true), _ROUNDING, details)


@experiment("sliding-paraboloid", "way in a retardation time over contact radius at rest")
def sliding_paraboloid(
    effort: str, *, way: Annotated[float, Above(0)] = 1.0, glassy: float = 0.0
) -> Finding:
    """Friction of a paraboloid that slides over rubber: springs against the half-space.

    At equal force. `way`: retardation time times speed over the radius sqrt(R d) of a static
    contact of equal depth. `glassy`: instantaneous over relaxed modulus of a standard solid; 0 for
    Kelvin-Voigt.
    """
    speed = way * np.sqrt(_RADIUS * _DEPTH)
    if glassy and not glassy > 1:
        raise ValueError(f"glassy must be 0 or above 1, not {glassy!r}")
    if glassy:  # the retardation time is one
        springs = standard_solid(0.25, 0.25 * (glassy - 1), relaxation_time=1 / glassy)
        body = GeneralisedMaxwell.standard(0.25, 0.25 * (glassy - 1), 1 / glassy)
    else:
        springs, body = kelvin_voigt(0.25, 0.25), GeneralisedMaxwell.kelvin_voigt(0.25, 0.25)
    truth = paraboloid(
        _RADIUS,
        body,
        speed,
        reference_loads.Load("penetration", _DEPTH),
        cells=144 if effort == "full" else 48,
    )
    x = np.linspace(-0.3, 0.3, 4001)
    sliding = slide(
        RoughLines(-(x**2) / _RADIUS, x[1] - x[0], periodic=False),
        springs,
        speed,
        LoadPath("force", truth.force.estimate),
    )
    friction = truth.friction_coefficient
    stated = float(sliding.friction_coefficient.item())
    bar = friction.uncertainty / friction.estimate + truth.force.uncertainty / truth.force.estimate
    details = {
        "depth on springs over that on the half-space": sliding.penetration.item() / _DEPTH,
    }
    return Finding(stated, friction.estimate, stated / friction.estimate * bar, details)


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


@experiment("rough-rubber", "speed v / (mm/s)")
def rough_rubber(
    effort: str,
    *,
    speed: Annotated[float, Above(0)] = 10.0,
    force: Annotated[float, Above(0)] = _FORCE,
    statement: Literal["line", "load"] = "line",
) -> Finding:
    """Friction of rough rubber: lines against surfaces, and its change with the load.

    Coefficients of friction at a speed in mm/s and a force in mN. ``"line"``: means over lines
    against means over surfaces; the grid counts with its last change. ``"load"``: surfaces under
    four times the force against the same surfaces under it. The ratio of many surfaces on one grid,
    times what the next finer grid changes of that of a few: grids err alike at both loads. That
    change is the bar of the grid.
    """
    speed, force = float(speed), float(force)
    finest = _GRID if effort == "full" else _GRID // 2
    if statement == "line":
        before, on_grid = (_coefficients("bem_fft", n, speed, force) for n in (finest, 2 * finest))
        change = 1.25 * abs(float(on_grid.mean() / before.mean()) - 1)
        lines = _coefficients("reduced", 2 * _GRID, speed, force, _LINES)
        return compare(lines, on_grid, change, {})

    def pair(grid: int, count: int) -> list[np.ndarray]:
        return [_coefficients("bem_fft", grid, speed, f, count) for f in (_MORE * force, force)]

    more, base = pair(finest, _MANY if effort == "full" else _MANY // 4)
    finer = pair(2 * finest, _FEW)
    ratio, scatter = ratio_of_means(more[:, None], base[:, None], paired=True)
    coarse = float(more[:_FEW].mean() / base[:_FEW].mean())
    change = float(finer[0].mean() / finer[1].mean()) / coarse
    bar = float(combined(float(scatter[0]), 1.25 * abs(change - 1)))
    once = float(base.mean())
    return Finding(float(ratio[0]) * change * once, once, bar, {})
