"""Oil films between rigid bodies (19.8): what cells and formulas say of them."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import numpy as np

from comparisons.questions.experiments.experiment import Above, Effort, Finding, experiment
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


@experiment(
    "film-cylinder",
    "Film below a rigid cylinder on cells against Reynolds' closed form",
    "cells",
    "cells per sqrt(2 R h0)",
)
def film_cylinder(
    effort: Effort,
    *,
    cells: Annotated[float, Above(4)] = 64.0,
    quantity: Literal["load", "rupture"] = "load",
) -> Finding:
    """Compare load or place of rupture with Reynolds' closed form; coarser cells give the bar."""
    fine, coarse = (rigid_cylinder(int(n)) for n in (cells, cells / 2))
    exact = {"load": CYLINDER, "rupture": RUPTURE}[quantity]
    value, other = (float(getattr(film, quantity)) for film in (fine, coarse))
    uneven = float(np.ptp(fine.flow[np.abs(np.append(fine.x, np.inf)) < 30])) / float(fine.flow[1])
    return Finding(value, exact, abs(value - other) / exact, {"oil lost": uneven})


@experiment(
    "film-sphere",
    "Film of a rigid sphere by half of Sommerfeld's pressure and with mass conserved",
    "cells",
    "cells per sqrt(2 R h0)",
)
def film_sphere(effort: Effort, *, cells: float = 0.0) -> Finding:
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


@experiment(
    "film-soft",
    "Central film of a ball on rubber by a fit, and by the limit of soft contacts",
    "speed",
    "speed in mm/s",
)
def film_soft(
    effort: Effort, *, speed: Annotated[float, Above(0)] = 1.0, by: Literal["fit", "limit"] = "fit"
) -> Finding:
    """Compare formulas with the central film of a ball on rubber at a speed in mm/s.

    Cells are of second order; the bar is the whole last change.
    """
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


@experiment(
    "film-wave",
    "Small wave across the flow under the film of a soft ball: its amplitude by linear theory",
    "wavelength",
    "wavelength in mm",
)
def film_wave(effort: Effort, *, wavelength: Annotated[float, Above(0)] = 0.5) -> Finding:
    """Compare the linear amplitude of a small wave (in mm) under a film with that on cells."""
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
