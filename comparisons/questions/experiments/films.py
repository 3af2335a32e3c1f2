"""Oil films between rigid bodies (19.8): what cells and formulas say of them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons.questions.experiments.base import Effort
from comparisons.questions.experiments.running import Finding, above, experiment, one_of
from comparisons.solving.shared import shared
from reference.lubrication.formulas import (
    CYLINDER,
    RUPTURE,
    SoftFit,
    soft_limit,
    sphere_film,
    wave_amplitude,
)
from reference.lubrication.point import Ball, entrain, waviness
from reference.lubrication.reynolds import rigid_cylinder

_RUBBER = Ball(radius=0.01, effective_modulus=1e6, viscosity=1.0, load=0.2)


def _cylinder(effort: Effort, *, cells: float = 64.0, quantity: str = "load") -> Finding:
    """Compare load or place of rupture with Reynolds' closed form; coarser cells give the bar."""
    one_of("quantity", quantity, "load", "rupture")
    above("cells", cells, 4)
    fine, coarse = (rigid_cylinder(int(n)) for n in (cells, cells / 2))
    exact = {"load": CYLINDER, "rupture": RUPTURE}[quantity]
    value, other = (float(getattr(film, quantity)) for film in (fine, coarse))
    uneven = float(np.ptp(fine.flow[np.abs(np.append(fine.x, np.inf)) < 30])) / float(fine.flow[1])
    return Finding(value, exact, abs(value - other) / exact, {"oil lost": uneven})


def _sphere(effort: Effort, *, cells: float = 0.0) -> Finding:
    """Compare the film of half of Sommerfeld's pressure with that of film that ruptures by itself.

    `cells` per reach of the pressure; zero: by the effort.
    """
    finest = int(cells) or (12 if effort == "quick" else 24)
    ball = Ball(radius=1.0, effective_modulus=np.inf, viscosity=1e-6, load=1.0)
    fine, coarse = (entrain(ball, 1e3, n).film_minimum for n in (finest, finest // 2))
    half = sphere_film(ball.radius, ball.viscosity, 1e3, ball.load)
    return Finding(half, fine, abs(half / fine - half / coarse), {})


@shared(maxsize=64)
def _on_rubber(speed: float, cells: int) -> float:
    """Return the central film at a speed in mm/s, which several claims judge."""
    return float(entrain(_RUBBER, 1e-3 * speed, cells).film_central)


def _soft(effort: Effort, *, speed: float = 1.0, by: str = "fit") -> Finding:
    """Compare formulas with the central film of a ball on rubber at a speed in mm/s.

    Cells are of second order; the bar is the whole last change.
    """
    one_of("by", by, "fit", "limit")
    above("speed", speed, 0)
    ball = _RUBBER
    cells = (16, 24) if effort == "quick" else (32, 48)
    coarse, fine = (_on_rubber(float(speed), n) for n in cells)
    film = fine - (coarse - fine) / (1.5**2 - 1)
    bodies = (ball.radius, ball.effective_modulus, ball.viscosity)
    if by == "fit":
        formula = SoftFit(*bodies, ball.load).central(1e-3 * speed)
    else:
        formula = soft_limit(*bodies, 1e-3 * speed, ball.load)
    bar = abs(fine - coarse) / film * formula / film
    return Finding(formula, film, bar, {})


def _wave(effort: Effort, *, wavelength: float = 0.5) -> Finding:
    """Compare the linear amplitude of a small wave (in mm) under a film with that on cells."""
    above("wavelength", wavelength, 0)
    ball = _RUBBER
    amplitude, length = 1e-8, 1e-3 * wavelength
    wave, linear, changes = waviness(amplitude, length), 0.0, []
    for n in (16, 20) if effort == "quick" else (24, 32):
        sides = [
            entrain(replace(ball, waves=replace(wave, phases=np.array([phase]))), 1e-2, n)
            for phase in (0.0, np.pi)
        ]
        changes.append((sides[1].film_central - sides[0].film_central) / (2 * amplitude))
        film = (sides[0].film_central + sides[1].film_central) / 2
        linear = wave_amplitude(2 * np.pi / length, 1e6, 1.0, 1e-2, film).real
    coarse, fine = changes
    return Finding(linear, fine, abs(fine - coarse) / abs(fine), {})


EXPERIMENTS = (
    experiment(
        "film-cylinder",
        "Film below a rigid cylinder on cells against Reynolds' closed form",
        "cells per sqrt(2 R h0)",
        "cells",
        _cylinder,
    ),
    experiment(
        "film-sphere",
        "Film of a rigid sphere by half of Sommerfeld's pressure and with mass conserved",
        "cells per sqrt(2 R h0)",
        "cells",
        _sphere,
    ),
    experiment(
        "film-soft",
        "Central film of a ball on rubber by a fit, and by the limit of soft contacts",
        "speed in mm/s",
        "speed",
        _soft,
    ),
    experiment(
        "film-wave",
        "Small wave across the flow under the film of a soft ball: its amplitude by linear theory",
        "wavelength in mm",
        "wavelength",
        _wave,
    ),
)
