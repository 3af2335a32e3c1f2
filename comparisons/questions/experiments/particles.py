"""19.1.4: particles whose interactions are to give the behaviour of the material."""

from __future__ import annotations

from collections.abc import Iterator
from itertools import islice
from typing import Annotated

import numpy as np
from numpy.typing import ArrayLike
from pydantic import Field

from comparisons.questions.experiments.asperities import Asperities
from comparisons.questions.experiments.experiment import (
    Details,
    Effort,
    Finding,
    Share,
    experiment,
    worst,
)
from reference.arrays import Array
from reference.closed_form import paraboloid
from reference.elasticity import Material, lame_parameters
from reference.errors import positive_faults, refuse
from reference.loads import Load, LoadPath
from reference.particles import Automata, Domain, ParticleHalfSpace, periodic_packing
from reference.particles.automata import MASSES, wave_stiffness
from reference.particles.yielding import PlasticHalfSpace
from reference.plastic import PlasticMaterial, yield_pressure

ROUND_OFF = 1e-12
DIRECTIONS = 200
_FIT = 0.02  # relative error of Kogut and Etsion's fit
# Steps in a period of the wave, and periods marched.
STEPS, PERIODS = 200, {"quick": 1, "full": 10}


@experiment("particle-waves", "wavelength in spacings")
def particle_waves(
    effort: str, *, wavelength: Annotated[float, Field(gt=2)] = 10.0, poisson_ratio: float = 0.3
) -> Finding:
    """Speeds of waves in a packing of automata, against those of the elastic solid.

    The largest error of the three speeds over many directions, from the dispersion relation. A
    longitudinal wave along x is marched in time, too, for its speed and the conserved energy.
    """
    lame, shear = lame_parameters(poisson_ratio)
    exact = np.sqrt([shear, shear, lame + 2 * shear])
    vectors = np.random.default_rng(1).normal(size=(DIRECTIONS, 3))
    vectors *= 2 * np.pi / wavelength / np.linalg.norm(vectors, axis=1)[:, None]
    speeds = np.array([wave_speeds(poisson_ratio, wave) for wave in vectors])
    errors = speeds / exact - 1
    spacings = round(wavelength)
    packing = periodic_packing((spacings, 2, 2))
    wave = 2 * np.pi / spacings
    mode = np.zeros((packing.free, 6))
    mode[:, 0] = np.cos(wave * packing.places[:, 0])
    step = spacings / STEPS / float(wave_speeds(poisson_ratio, [wave, 0.0, 0.0])[2])
    moved, automata = mode.copy(), Automata(packing, poisson_ratio)
    motion = leapfrog(automata, moved, np.zeros_like(mode), step)
    energies, amplitudes = [], []
    for energy in islice(motion, PERIODS[effort] * STEPS + 2):
        energies.append(energy)
        amplitudes.append(np.vdot(moved, mode))
    # leapfrog: the sum of the neighbours in time is 2 - (omega dt)^2 times the middle one
    before, middle, after = amplitudes[-3:]
    frequency = np.sqrt(2 - (before + after) / middle) / step
    details: Details = {
        "longitudinal, largest": float(np.abs(errors[:, 2]).max()),
        "transverse, largest": float(np.abs(errors[:, :2]).max()),
        "marched along x: speed over the continuum's - 1": float(frequency / wave / exact[2]) - 1,
        "marched: largest change of energy": float(np.ptp(energies) / energies[0]),
    }
    return Finding(*worst(speeds, np.broadcast_to(exact, speeds.shape)), ROUND_OFF, details)


@experiment("particle-yield", "Poisson's ratio nu")
def particle_yield(effort: str, *, poisson_ratio: float = 0.3) -> Finding:
    """Pressure at which a ball first brings automata to their yield stress, against Hertz.

    The pressure is p0/Y. The largest von Mises stress on the axis, between layers by a parabola.
    Layers do not lie alike with another number of automata: the bar is the largest difference of
    three numbers.
    """
    numbers = (2, 3, 4) if effort == "quick" else (3, 4, 5)
    exact = yield_pressure(poisson_ratio)
    onsets = []
    for number in numbers:
        # automata under a ball of ten contact radii
        body = ParticleHalfSpace(Domain((1.5 * number,) * 2, 2.5 * number), [(1.0, poisson_ratio)])
        gap = (body.points**2).sum(axis=1) / (20 * number)
        (contact,) = body.press(gap, Load("penetration", 0.1 * number))
        peak = 2 * body.effective_modulus * 0.1 / np.pi  # p0 = 2 E* a/(pi R), R = 10 a
        onsets.append(peak / body.largest_stress(contact))
    details = {"automata per contact radius": float(numbers[-1])}
    return Finding(onsets[-1], exact, float(np.ptp(onsets)) / exact, details)


@experiment("particle-plastic", "penetration over that of first yield")
def particle_plastic(
    effort: Effort, *, depth: Annotated[float, Field(gt=1, le=110)] = 5.0
) -> Finding:
    """Force on a ball whose automata flow, against finite elements.

    `depth`, up to the 110 of the fit, in units of that of first yield, where Hertz has p0 = 1.60 Y;
    the fit of L. Kogut & I. Etsion (J. Appl. Mech. 69 (2002) 657) to their elements, whose own
    error of some two per cent is in the bar.
    """
    numbers = (2, 3) if effort == "quick" else (4, 5)
    exact = 1.03 * depth**1.425 if depth <= 6 else 1.40 * depth**1.263
    forces = []  # F/F_y
    nu = 0.3
    effective = 1 / (1 - nu**2)
    for number in numbers:
        radius, first = 10.0 * number, 0.1 * number / depth
        peak = 2 * effective / np.pi * np.sqrt(first / radius)
        limit = peak / yield_pressure(nu)
        material = PlasticMaterial(Material(1.0, nu), limit)
        body = PlasticHalfSpace(Domain((1.7 * number,) * 2, 2.5 * number), material)
        gap = (body.points**2).sum(axis=1) / (2 * radius)
        (contact,) = body.walk(gap, LoadPath("penetration", [0.1 * number]))
        forces.append(contact.force / float(paraboloid(radius, effective).force(first)))
    elastic = depth**1.5
    details = {
        "automata per radius of the elastic contact": float(numbers[-1]),
        "without yielding": elastic,
    }
    bar = float(np.hypot(abs(forces[-1] - forces[0]), _FIT * forces[-1])) / exact
    return Finding(forces[-1], exact, bar, details)


@experiment("particle-wear", "overlap of the tips in spacings")
def particle_wear(effort: Effort, *, overlap: float = 1.5) -> Share:
    """An asperity dragged over another with bonds that break and heal: where its work goes.

    The finding is the part of the work that is neither stored, damped nor spent on bonds. Friction
    and wear are means over seeds: of them no truth is known. Lengths in spacings, energies in k
    r0^2 of a bond.
    """
    asperities = Asperities(overlap=overlap, energy=0.005, healing=0.02, speed=0.05)
    passes = [asperities.drag(seed) for seed in range(2 if effort == "quick" else 6)]
    friction = np.array([drag.friction for drag in passes])
    details = {
        "passes": float(len(passes)),
        "mean force over mean load": float(friction.mean()),
        "its standard error": float(friction.std(ddof=1) / np.sqrt(len(passes))),
        "share of the work spent on bonds": float(
            np.mean([drag.spent / drag.work for drag in passes])
        ),
        "bonds broken": float(np.mean([drag.broken for drag in passes])),
        "bonds healed": float(np.mean([drag.healed for drag in passes])),
        "wear particles": float(np.mean([drag.worn for drag in passes])),
        "loose ones of them": float(np.mean([drag.loose for drag in passes])),
    }
    errors = np.array([drag.imbalance for drag in passes])
    return Share(float(errors[np.argmax(np.abs(errors))]), float(np.ptp(errors)), details)


def leapfrog(automata: Automata, moved: Array, velocities: Array, step: float) -> Iterator[float]:
    """March automata, none of them held; yield the conserved energy of each step.

    Displacements and rotations (n, 6), and their rates half a step before, are overwritten; the
    time step is stable below 2 over the highest frequency. Leapfrog steps of a linear system
    conserve 1/2 v+ M v- + 1/2 x K x with the velocities half a step before and after, up to
    round-off and at any stable step (E. Hairer et al., Acta Numerica 12 (2003) 399): a change in it
    is an error of the forces.
    """
    faults = positive_faults(step=step)
    if automata.packing.free < len(automata.packing.places):
        faults.append("automata must all be free: those of a half-space's shell are held")
    refuse(faults)
    traces, pulls = np.zeros(len(moved)), np.empty_like(moved)
    while True:
        pull = automata.forces(moved, traces, pulls)
        stored = -0.5 * np.vdot(moved, pull)
        after = velocities + step * pull / MASSES
        yield 0.5 * np.vdot(velocities, MASSES * after) + stored
        velocities[:] = after
        moved += step * after


def wave_speeds(poisson_ratio: float, wave: ArrayLike) -> Array:
    """Return the speeds of the plane waves of a wave vector (in 1/r0), ascending.

    Three of displacement; those of rotation are cut off at high frequencies and left out. From the
    stiffness of the packing under u exp(i q x), theta exp(i q x).

    Long waves have the speeds of the continuum, sqrt(G/rho) twice and sqrt((lambda + 2 G)/rho):

    >>> speeds = wave_speeds(0.25, [1e-3, 0.0, 0.0])
    >>> (speeds**2).round(5).tolist()
    [0.4, 0.4, 1.2]
    """
    wave = np.asarray(wave, dtype=float)
    stiffness = wave_stiffness(poisson_ratio, wave) / np.sqrt(np.outer(MASSES, MASSES))
    frequencies = np.sqrt(np.maximum(np.linalg.eigvalsh(stiffness)[:3], 0.0))
    return frequencies / np.linalg.norm(wave)
