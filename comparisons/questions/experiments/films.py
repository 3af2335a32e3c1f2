"""Oil films between rigid bodies and along rough planes (19.8), by cells, formulas and the line."""

from __future__ import annotations

from dataclasses import replace
from typing import Annotated, Literal

import numpy as np
from pydantic import Field

from comparisons.judging.uncertainty import combined, ratio_of_means
from comparisons.questions.experiments.experiment import (
    Count,
    Effort,
    Finding,
    Positive,
    experiment,
    number_of,
)
from comparisons.questions.experiments.plane_flow import (
    effective_medium_factor,
    patir_cheng_factor,
    plane_flow,
    second_order_factors,
)
from comparisons.questions.experiments.rough_ensemble import (
    PeriodicSurface,
    Surface,
    compare,
    press,
    truth,
)
from comparisons.solving.shared import shared
from reduced.loads import Load
from reduced.rough.press import press as press_line
from reference.lubrication.formulas import (
    CYLINDER,
    SoftFit,
    soft_limit,
    sphere_film,
    wave_amplitude,
)
from reference.lubrication.point import Ball, entrain, waviness
from reference.lubrication.reynolds import rigid_cylinder

_RUBBER = Ball(radius=0.01, effective_modulus=1e6, viscosity=1.0, load=0.2)


@experiment("film-cylinder", "cells per sqrt(2 R h0)")
def film_cylinder(effort: Effort, *, cells: Annotated[float, Field(gt=4)] = 64.0) -> Finding:
    """Load of the film below a rigid cylinder on cells against Reynolds' closed form.

    Coarser cells give the bar.
    """
    fine, coarse = (rigid_cylinder(int(n)) for n in (cells, cells / 2))
    uneven = float(np.ptp(fine.flow[np.abs(np.append(fine.x, np.inf)) < 30])) / float(fine.flow[1])
    bar = abs(fine.load - coarse.load) / CYLINDER
    return Finding(fine.load, CYLINDER, bar, {"oil lost": uneven})


@experiment("film-sphere", "cells per sqrt(2 R h0)")
def film_sphere(effort: Effort, *, cells: float = 0.0) -> Finding:
    """Film of a rigid sphere by half of Sommerfeld's pressure and with mass conserved.

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


@experiment("film-soft", "speed in mm/s")
def film_soft(
    effort: Effort, *, speed: Positive = 1.0, by: Literal["fit", "limit"] = "fit"
) -> Finding:
    """Central film of a ball on rubber by a fit, and by the limit of soft contacts.

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


@experiment("film-wave", "wavelength in mm")
def film_wave(effort: Effort, *, wavelength: Positive = 0.5) -> Finding:
    """Small wave across the flow under the film of a soft ball: its amplitude by linear theory."""
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
    return Finding(linear, fine, abs(linear / fine - linear / coarse), {})


# Surfaces, and lines for each: in groups, whose gaps are pooled.
_QUICK, _GROUP, _GROUPS = 12, 30, 12
# Points of a line for one of its surface.
_FINER = 4
Samples = dict[str, np.ndarray]


@experiment("film-plane-open", "rms height over mean gap")
def film_plane_open(
    effort: Effort,
    *,
    roughness: Positive = 0.2,
    statement: Literal["second_order", "patir_cheng"] = "second_order",
    quantity: Literal["pressure", "shear"] = "pressure",
    surface: Surface = PeriodicSurface(roll_off=2.0, shortest=8.0),
    realisations: Count = 48,
) -> Finding:
    """Flow of oil along rough planes that hardly touch: formulas against the flow on cells.

    The planes are rigid. `roughness` is rms height over mean gap; of a second order what roughness
    changes is judged, of a fit the factor itself. Where heights exceed the gap, it is closed, as
    Patir & Cheng have it.
    """
    if statement == "patir_cheng" and quantity == "shear":
        raise ValueError("the fit is of pressure, not of shear")
    count = number_of(realisations, effort, _QUICK)
    change = statement == "second_order"

    def sample(factor: int, number: int) -> np.ndarray:
        values = _rigid(surface, roughness, factor, number)[quantity]
        return 1 - values if change else values

    if change:
        stated = 1 - second_order_factors(roughness)[("pressure", "shear").index(quantity)]
    else:
        stated = patir_cheng_factor(roughness)
    true, bar = truth(sample, count, effort)
    return compare([stated], true, bar, {"bar of the grid": bar})


@shared(maxsize=64)
def _rigid(surface: Surface, roughness: float, factor: int, count: int) -> Samples:
    """Return the flow factors of surfaces, each the mean of the surface's and its negative's.

    What is of odd order in the heights cancels.
    """
    rows = []
    for number in range(count):
        heights = surface.heights(number, factor)
        heights = heights * (roughness / heights.std())
        sides = [plane_flow(np.maximum(1 + sign * heights, 0.0)) for sign in (1, -1)]
        rows.append(
            (
                np.mean([side.pressure_factor for side in sides]),
                np.mean([side.shear_factor for side in sides]),
            )
        )
    pressure, shear = np.array(rows).T
    return {"pressure": pressure, "shear": shear}


@experiment("film-plane-pressed", "load F/(E* A0 h')")
def film_plane_pressed(
    effort: Effort,
    *,
    load: Positive = 0.02,
    statement: Literal["effective_medium", "patir_cheng", "line"] = "effective_medium",
    quantity: Literal["factor", "flow"] = "factor",
    surface: Surface = PeriodicSurface(128, roll_off=4.0, shortest=8.0),
    realisations: Count = 48,
) -> Finding:
    """Flow of oil around the spots of contact of rough planes: theories, and the line.

    The gap is that of the periodic half-space; `quantity` is the pressure factor, or the "flow"
    itself, the factor times the cube of the mean gap over the rms height.
    """
    if statement != "line" and quantity == "flow":
        raise ValueError(f"{statement} speaks of the factor, not of the flow")
    count = number_of(realisations, effort, _QUICK)

    true, bar = truth(lambda f, n: _flows(surface, load, f, n)[quantity], count, effort)
    native = _flows(surface, load, 1, count)
    details = {
        "contact area": float(native["area"].mean()),
        "mean gap/h_rms": float(native["gap"].mean()),
        "closed": float((native["factor"] == 0).mean()),
        "bar of the grid": bar,
    }
    if statement == "line":
        return compare(_lines(surface, load)[quantity], true, bar, details)
    stated, grid = truth(lambda f, n: _flows(surface, load, f, n)[statement], count, effort)
    # of the same surfaces, whose flows differ more than these ratios
    ratio, scatter = ratio_of_means(stated[:, None], true[:, None], paired=True)
    uncertainty = float(ratio[0] * combined(scatter[0], bar, grid))
    return Finding(float(stated.mean()), float(true.mean()), uncertainty, details)


@shared(maxsize=64)
def _flows(surface: Surface, load: float, factor: int, count: int) -> Samples:
    """Return what flows through the gaps of pressed surfaces, and what theories say of them."""
    operator = surface.operator(factor)
    rows: list[dict[str, float]] = []
    for number in range(count):
        heights = surface.heights(number, factor)
        contact, quantities = press(operator, heights, load)
        gap = np.where(contact.mask, 0.0, np.maximum(contact.gap, 0.0)) / heights.std()
        through = plane_flow(gap)
        rows.append(
            {
                "factor": through.pressure_factor,
                "flow": through.pressure_factor * float(gap.mean()) ** 3,
                "gap": float(gap.mean()),
                "area": quantities["contact_area"],
                "effective_medium": effective_medium_factor(gap),
                "patir_cheng": patir_cheng_factor(1 / float(gap.mean())),
            }
        )
    return {name: np.array([row[name] for row in rows]) for name in rows[0]}


def _lines(surface: Surface, load: float) -> Samples:
    """Return the flow through the gaps of pressed lines, beside each other at random.

    One after the other they let nothing through from the first touch on.
    """
    drawn = surface.lines(_GROUP * _GROUPS, _FINER).draw()
    contact = press_line(drawn, 1.0, Load("force", [load]))
    heights = drawn.heights
    gaps = heights.max(axis=1, keepdims=True) - heights - contact.penetration
    rms = surface.heights(0).std()
    pooled = np.maximum(gaps, 0.0).reshape(_GROUPS, -1) / rms
    factors = np.array([effective_medium_factor(group) for group in pooled])
    return {"factor": factors, "flow": factors * pooled.mean(axis=1) ** 3}
