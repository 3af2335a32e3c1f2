"""Rubber: stiffness under oscillation (19.30), series of springs and dashpots, sliding (19.7)."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from comparisons.judging.uncertainty import combined, ratio_of_means
from comparisons.questions.experiments.experiment import (
    Finding,
    Fraction,
    Positive,
    Share,
    experiment,
    one_of,
    share_of,
    worst,
)
from comparisons.questions.single import solve_scene
from comparisons.solving.shared import shared
from reduced.loads import Load, LoadPath
from reduced.memory.in_time import harmonic_stiffness
from reduced.memory.materials import fit, kelvin_voigt, standard_solid
from reduced.rough.ensemble import RandomLines
from reduced.rough.line_spectrum import prescribed
from reduced.rough.press import RoughLines, press
from reduced.rough.surface_spectrum import SelfAffineLaw
from reduced.rubber.history import slide_as_printed, slide_in_time
from reduced.rubber.steady import slide
from reference.halfspace import FreeOperator
from reference.loads import History
from reference.viscoelastic import GeneralisedMaxwell, press_in_time

# Cells across the grid and steps per period, coarse and fine: their difference is the bar.
_GRIDS = {"quick": ((32, 16), (64, 32)), "full": ((64, 32), (128, 64))}
_PERIODS, _STIFFENING = 3, 3.0
_DEPTH = 0.01  # over the radius of the ball; forces are scaled, so the value is arbitrary
_TO_REST = 60.0  # relaxation times before the oscillation begins


@experiment("harmonic-contact", "amplitude over mean depth")
def harmonic_contact(
    effort: str, *, amplitude: Fraction = 0.01, frequency: Positive = 1.0
) -> Share:
    """The stiffness 2 a E*(w) of a ball on rubber against the 3-D half-space in time.

    Measure a ball on a standard solid, first at rest, then oscillating with w tau = `frequency`.
    `amplitude` is relative to the mean depth, G_1/G_0 = 3. The reference is the
    in-phase and out-of-phase force on the 3-D half-space over the last of three periods (with a
    fitted transient exp(-t/tau)). The distance of the complex stiffnesses over the true one's size.
    """
    stiffness = []  # the fundamental of the force over that of the depth on the 3-D half-space
    for cells, steps in _GRIDS[effort]:
        # Largest contact radius, sqrt(R d) as for the springs.
        reach = np.sqrt(_DEPTH * (1 + amplitude))
        x = (np.arange(cells) - cells / 2 + 0.5) * (2.1 * reach / cells)
        hold = np.concatenate([[0.0], np.geomspace(0.01, _TO_REST, 16)])
        later = np.arange(1, steps * _PERIODS + 1) * (2 * np.pi / (frequency * steps))
        depth = np.append(np.ones(hold.size), 1 + amplitude * np.sin(frequency * later)) * _DEPTH
        instants = press_in_time(
            FreeOperator((cells, cells), (2.1 * reach / cells,) * 2, 1.0),
            (x[:, None] ** 2 + x**2) / 2,
            GeneralisedMaxwell.standard(1.0, _STIFFENING, 1.0),
            History("penetration", np.append(hold, _TO_REST + later), depth),
        )
        force = np.array([instant.force for instant in instants])[-steps:]
        t = later[-steps:]
        basis = np.column_stack(
            [np.ones(steps), np.exp(t[0] - t), np.sin(frequency * t), np.cos(frequency * t)]
        )
        _, _, real, imaginary = np.linalg.lstsq(basis, force)[0] / (amplitude * _DEPTH)
        stiffness.append(complex(real, imaginary))
    coarse, fine = stiffness
    material = standard_solid(1.0, _STIFFENING, relaxation_time=1.0)
    stated = complex(harmonic_stiffness(material, np.sqrt(_DEPTH), frequency))
    details = {
        "storage stiffness over the stated": fine.real / stated.real,
        "loss stiffness over the stated": fine.imag / stated.imag,
        "stated loss over storage": stated.imag / stated.real,
    }
    return Share(abs(stated / fine - 1), abs(coarse / fine - 1), details, "deviation")


# Havriliak & Negami (1967): from 1 MPa at rest to 1 GPa as glass, over ten decades of frequency.
_RELAXED, _GLASSY, _TIME, _FIRST, _SECOND = 1e6, 1e9, 1e-3, 0.6, 0.7
_FREQUENCIES = np.geomspace(1e-2, 1e8, 201)
_EXACT = 1e-12


@experiment("relaxation-series", "relaxation times per decade")
def relaxation_series(effort: str, *, per_decade: Positive = 2.0) -> Share:
    """Modulus of a rubber with a continuous spectrum by a series of relaxation times.

    The largest relative error of G(w).
    """
    turns = (1j * _FREQUENCIES * _TIME) ** _FIRST
    true = _GLASSY - (_GLASSY - _RELAXED) / (1 + turns) ** _SECOND
    series = fit(_FREQUENCIES, true, per_decade=per_decade)
    details = {"relaxation times": float(series.material.times.size), "rms error": series.rms_error}
    return Share(float(series.error.max()), _EXACT, details, "deviation")


# Lines of length 1 with 32 or more points to the shortest of their 16 waves; loads with a tenth in
# contact.
_SHORTEST, _PER_WAVE, _LOAD = 1 / 16, 32.0, 3e-3
_QUANTITIES = ("friction", "work", "start")
_ROUNDING = 1e-9  # relative tolerance of forces is 1e-11


def _rough_lines(count: int, per_wave: float = _PER_WAVE) -> RoughLines:
    points = round(float(per_wave) / _SHORTEST)
    spectrum = prescribed(64, 1.0, SelfAffineLaw(hurst=0.8, rms_slope=0.1, short_cutoff=_SHORTEST))
    return RandomLines(spectrum, points, count, seed=7).draw()


@experiment("printed-rubber", "explicit relaxation number G dt/eta = dx/(v tau)")
def printed_rubber(
    effort: str,
    *,
    number: Positive = 1.0,
    quantity: Annotated[str, one_of(*_QUANTITIES)] = "friction",
    per_wave: Annotated[float, Field(gt=2)] = _PER_WAVE,
    load: Positive = _LOAD,
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
    effort: str, *, number: Positive = 1.0, quantity: Literal["work", "friction"] = "work"
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
    details = {"lines": float(len(rough)), "mean": float((stated / true - 1).mean())}
    return Finding(*worst(stated, true), _ROUNDING, details)


# Four times the force, on many surfaces; what a finer grid changes, on a few of them.
_MORE, _MANY, _FEW = 4.0, 64, 4


@shared(maxsize=256)
def _coefficients(grid: int, speed: float, force: float, count: int) -> np.ndarray:
    """Return the coefficients of friction of so many surfaces."""
    changes = {
        "sliding.speed": [f"{speed!r} mm/s"],
        "loading.force": [f"{force!r} mN"],
        "surface.realisations": count,
    }
    solved = solve_scene("sliding-rough", "bem_fft", grid, changes).solution
    return np.asarray(solved.quantities["friction_coefficient"][:, 0])


@experiment("rough-rubber", "force / mN")
def rough_rubber(effort: str, *, force: Positive = 20.0, speed: Positive = 10.0) -> Finding:
    """Friction of rough rubber under four times the force against that under it.

    Coefficients of friction of the same surfaces, at a speed in mm/s. The ratio of many surfaces on
    one grid, times what the next finer grid changes of that of a few: grids err alike at both
    loads. That change is the bar of the grid.
    """
    speed, force = float(speed), float(force)
    full = effort == "full"

    def pair(grid: int, count: int) -> list[np.ndarray]:
        return [_coefficients(grid, speed, f, count) for f in (_MORE * force, force)]

    grid = 48 if full else 24
    more, base = pair(grid, _MANY if full else _MANY // 4)
    finer = pair(2 * grid, _FEW)
    ratio, scatter = ratio_of_means(more[:, None], base[:, None], paired=True)
    coarse = float(more[:_FEW].mean() / base[:_FEW].mean())
    change = float(finer[0].mean() / finer[1].mean()) / coarse
    bar = float(combined(float(scatter[0]), 1.25 * abs(change - 1)))
    once = float(base.mean())
    return Finding(float(ratio[0]) * change * once, once, bar, {})
