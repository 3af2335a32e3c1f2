"""Tables of docs/lubrication.md: films of a soft ball on 16, 32 and 64 cells, and what they cost.

Run from the repository's root (some minutes), or the costs alone::

    python docs/examples/film_tables.py
    python docs/examples/film_tables.py cost

or the flow through rough planes::

    python docs/examples/film_tables.py plane
"""

import sys
import time
from collections.abc import Callable
from typing import TypeVar

import numpy as np

from comparisons.questions.experiments import EXPERIMENTS
from reference.contact.press import press
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator
from reference.loads import Load
from reference.lubrication.formulas import SoftFit, soft_limit
from reference.lubrication.point import Ball, entrain

Solved = TypeVar("Solved")
BALL = {"radius": 0.01, "effective_modulus": 1e6, "viscosity": 1.0, "load": 0.2}


def central(speed: float, resolution: int) -> float:
    """Return the central film in um, or NaN where the cells lose it."""
    try:
        return 1e6 * entrain(Ball(**BALL), speed, resolution).film_central
    except ConvergenceError:
        return float("nan")


def timed(work: Callable[[], Solved]) -> tuple[Solved, float]:
    """Return a result and its seconds of processor time."""
    started = time.process_time()
    result = work()
    return result, time.process_time() - started


def dry(resolution: int) -> float:
    """Return the force of the dry ball on the equal cells of a film, at Hertz' penetration."""
    ball = Ball(**BALL)
    cells, contact = 4 * resolution, ball.hertz_radius
    # l is a tenth longer than the contact radius at 1 mm/s
    spacing = 1.1 * contact / resolution
    x = (np.arange(cells) - cells / 2 + 0.5) * spacing
    gap = (x[:, None] ** 2 + x**2) / (2 * ball.radius)
    half_space = FreeOperator((cells, cells), (spacing, spacing), ball.effective_modulus)
    load = Load("penetration", contact**2 / ball.radius)
    return press(half_space, gap, load).force


def costs() -> None:
    """Print seconds of processor time, beside those of a dry contact on the same cells."""
    entrain(Ball(**BALL), 1e-2, 8)
    dry(8)
    print("mm/s   equal cells  film/um     imbalance  seconds  dry contact  film over dry")
    for speed in (1e-2, 1e-3, 3e-4, 1e-4):
        for resolution in (16, 32, 64):
            _, contact = timed(lambda n=resolution: dry(n))
            label = f"{1e3 * speed:4g}   {4 * resolution:4d} ^ 2"
            try:
                film, seconds = timed(lambda u=speed, n=resolution: entrain(Ball(**BALL), u, n))
            except ConvergenceError:
                print(f"{label}    lost")
                continue
            print(
                f"{label}    {1e6 * film.film_central:.13g}  {film.error:.0e}  {seconds:7.2f}  "
                f"{contact:7.3f}  {seconds / contact:7.0f}",
                flush=True,
            )


def planes() -> None:
    """Print what flows through pressed rough planes, and by how much theories miss it."""
    measure = EXPERIMENTS["film-plane-pressed"].measure
    print("load   contact area  mean gap/h_rms  factor   Patir & Cheng    medium           line")
    for load in (0.005, 0.02, 0.05, 0.1):
        measured = [
            measure(load, "quick", statement=statement, **more)
            for statement, more in (
                ("patir_cheng", {}),
                ("effective_medium", {}),
                ("line", {"quantity": "flow"}),
            )
        ]
        details = measured[0].details
        errors = "  ".join(f"{m.error:+6.1%} +- {m.uncertainty:.1%}" for m in measured)
        print(
            f"{load:5g}  {details['contact area']:12.2%}  {details['mean gap/h_rms']:14.3f}  "
            f"{details['true']:6.3f}  {errors}",
            flush=True,
        )


def films() -> None:
    """Print a row for each speed."""
    print("mm/s     16      32      64      extrapolated   ratio  fit      limit")
    for speed in (1e-2, 3e-3, 1e-3, 3e-4, 1e-4):
        coarse, middle, fine = (central(speed, n) for n in (16, 32, 64))
        film, bar = fine - (middle - fine) / 3, abs(middle - fine) / 3
        ratio = (coarse - middle) / (middle - fine)
        fit = film / (1e6 * SoftFit(**BALL).central(speed)) - 1
        limit = film / (1e6 * soft_limit(speed=speed, **BALL)) - 1
        print(
            f"{1e3 * speed:4g}  {coarse:.3f}  {middle:.3f}  {fine:.3f}  {film:.3f} +- {bar:.3f}  "
            f"{ratio:4.1f}  {fit:+.1%}  {limit:+.1%}"
        )


if __name__ == "__main__":
    {"cost": costs, "plane": planes}.get(" ".join(sys.argv[1:]), films)()
