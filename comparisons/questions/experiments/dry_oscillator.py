"""Coulomb's law and (19.1): set-valued time stepping, Den Hartog's oscillator."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np

from comparisons.questions.experiments.experiment import Above, Finding, Share, experiment
from reduced.motion.blocks import Blocks, integrate
from reduced.motion.stepping import Stepping
from reference.dynamics import coulomb
from reference.dynamics.coulomb import dry_oscillator_amplitude
from reference.dynamics.event_driven import follow
from reference.dynamics.moreau_jean import march

EXACT = 1e-12  # rounding of formulas, and of the event-driven motion
# The oscillator m = k = P = 1 of `regularised-stick-slip`, which stops twice per period.
_STOPPING = {"stiffness": 1.0, "amplitude": 1.0, "frequency": 0.4}
_PERIODS, _LIMIT = 4, 0.9
# An oscillator that never stops, and periods until its amplitude is steady.
_SLIDING, _RATIO, _SETTLING = 0.6, 1.2, 100


@experiment(
    "set-valued-steps",
    "Coulomb's law as a set in fixed steps (Moreau and Jean), against its motion by events",
    "steps",
    "steps per period of the force",
)
def set_valued_steps(
    effort: str,
    *,
    steps: Annotated[float, Above(2)] = 100.0,
    load: float = 0.5,
    quantity: Literal["oscillator", "rest"] = "oscillator",
) -> Share:
    """Measure the set-valued law in steps of Moreau and Jean, `steps` per period of the force.

    ``"oscillator"``: largest error of the position over four periods, over the largest position.
    ``"rest"``: the path of a block pulled by `load` < 1 against friction 1 in as many steps of unit
    length, over its path without friction.
    """
    count = int(steps)
    if quantity == "rest":
        if not 0 < load < 1:
            raise ValueError(f"load must be between 0 and 1, not {load!r}")
        motion = march(coulomb.Blocks(1.0, 1.0, load=load), step=1.0, steps=count)
        way = float(motion.position[-1, 0]) / (0.5 * load * count**2)
        return Share(way, EXACT, {"law evaluations": float(motion.evaluations)})
    end = _PERIODS * 2 * np.pi / _STOPPING["frequency"]
    system = coulomb.Blocks(1.0, _LIMIT, **_STOPPING)
    exact = follow(system, end)
    stepped = march(system, step=end / (_PERIODS * count), steps=_PERIODS * count)
    position = exact.at(np.minimum(stepped.time, end))[0][:, 0]
    deviation = np.abs(stepped.position[:, 0] - position).max()
    largest = np.abs(exact.at(np.linspace(0, end, 2001))[0]).max()
    details: dict[str, float | str] = {
        "law evaluations": float(stepped.evaluations),
        "share of the time at rest": exact.time_sticking() / end,
    }
    return Share(float(deviation / largest), EXACT, details, "deviation")


@experiment(
    "regularised-amplitude",
    "Amplitude of a dry oscillator under (19.1) against Den Hartog's closed form",
    "speed_ratio",
    "largest sliding speed over characteristic speed V/v0",
)
def regularised_amplitude(
    effort: str,
    *,
    speed_ratio: Annotated[float, Above(0)] = 100.0,
    friction: float = _SLIDING,
    ratio: float = _RATIO,
) -> Finding:
    """Measure the amplitude under (19.1) over Den Hartog's for m = k = P = 1 without stops.

    `ratio`: frequency of the force over the natural frequency; V is the largest speed of a sinusoid
    of the true amplitude. Sources of the bar: twice as many steps, and the change over the last
    periods.
    """
    true = dry_oscillator_amplitude(1.0, friction, 1.0, ratio)
    v0 = true * ratio / speed_ratio
    system = Blocks(1.0, friction, stiffness=1.0, amplitude=1.0, frequency=ratio)
    swings = []
    for steps in (800, 1600) if effort == "quick" else (3200, 6400):
        run = integrate(
            *(system, v0),
            Stepping(2 * np.pi / ratio / steps, _SETTLING * steps),
            scheme="implicit_midpoint",
        )
        last = run.position[-2 * steps :, 0].reshape(2, steps)
        swings.append(0.5 * np.ptp(last, axis=1))
    (coarse, fine), before = (swing[1] for swing in swings), swings[1][0]
    bar = abs(fine - coarse) + abs(fine - before)
    details: dict[str, float | str] = {"amplitude, Den Hartog": true, "by the law": float(fine)}
    return Finding(float(fine), true, float(bar / true) + EXACT, details)
