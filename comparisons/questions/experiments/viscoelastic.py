"""(19.30): contact stiffness under oscillation; rubber as a sum of springs and dashpots."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import Above, Share, experiment
from reduced.memory.in_time import harmonic_stiffness
from reduced.memory.materials import fit, standard_solid
from reference.halfspace import FreeOperator
from reference.loads import History
from reference.viscoelastic import GeneralisedMaxwell, press_in_time

# Cells across the grid and steps per period, coarse and fine: their difference is the bar.
_GRIDS = {"quick": ((32, 16), (64, 32)), "full": ((64, 32), (128, 64))}
_PERIODS = 3
_DEPTH = 0.01  # over the radius of the ball; forces are scaled, so the value is arbitrary
_TO_REST = 60.0  # relaxation times before the oscillation begins


@experiment("harmonic-contact", "amplitude over mean depth")
def harmonic_contact(
    effort: str,
    *,
    amplitude: float = 0.01,
    frequency: Annotated[float, Above(0)] = 1.0,
    stiffening: Annotated[float, Above(0)] = 3.0,
) -> Share:
    """The stiffness 2 a E*(w) of a ball on rubber against the 3-D half-space in time.

    Measure a ball on a standard solid, first at rest, then oscillating with w tau = `frequency`.
    `amplitude` is relative to the mean depth, `stiffening` is G_1/G_0. The reference is the
    in-phase and out-of-phase force on the 3-D half-space over the last of three periods (with a
    fitted transient exp(-t/tau)). The distance of the complex stiffnesses over the true one's size.
    """
    if not 0 < amplitude < 1:
        raise ValueError(f"amplitude must lie between 0 and 1, not {amplitude!r}")
    coarse, fine = (_stiffness(amplitude, frequency, stiffening, *grid) for grid in _GRIDS[effort])
    material = standard_solid(1.0, stiffening, relaxation_time=1.0)
    stated = complex(harmonic_stiffness(material, np.sqrt(_DEPTH), frequency))
    details = {
        "storage stiffness over the stated": fine.real / stated.real,
        "loss stiffness over the stated": fine.imag / stated.imag,
        "stated loss over storage": stated.imag / stated.real,
    }
    return Share(abs(stated / fine - 1), abs(coarse / fine - 1), details, "deviation")


def _stiffness(
    amplitude: float, frequency: float, stiffening: float, cells: int, steps: int
) -> complex:
    """Return the fundamental of the force over that of the depth on the 3-D half-space."""
    # Largest contact radius, sqrt(R d) as for the springs.
    reach = np.sqrt(_DEPTH * (1 + amplitude))
    x = (np.arange(cells) - cells / 2 + 0.5) * (2.1 * reach / cells)
    operator = FreeOperator((cells, cells), (2.1 * reach / cells,) * 2, 1.0)
    hold = np.concatenate([[0.0], np.geomspace(0.01, _TO_REST, 16)])
    later = np.arange(1, steps * _PERIODS + 1) * (2 * np.pi / (frequency * steps))
    depth = np.append(np.ones(hold.size), 1 + amplitude * np.sin(frequency * later)) * _DEPTH
    instants = press_in_time(
        operator,
        (x[:, None] ** 2 + x**2) / 2,
        GeneralisedMaxwell.standard(1.0, stiffening, 1.0),
        History("penetration", np.append(hold, _TO_REST + later), depth),
    )
    force = np.array([instant.force for instant in instants])[-steps:]
    t = later[-steps:]
    basis = np.column_stack(
        [np.ones(steps), np.exp(t[0] - t), np.sin(frequency * t), np.cos(frequency * t)]
    )
    _, _, real, imaginary = np.linalg.lstsq(basis, force)[0] / (amplitude * _DEPTH)
    return complex(real, imaginary)


# Havriliak & Negami (1967): from 1 MPa at rest to 1 GPa as glass, over ten decades of frequency.
_RELAXED, _GLASSY, _TIME, _FIRST, _SECOND = 1e6, 1e9, 1e-3, 0.6, 0.7
_FREQUENCIES = np.geomspace(1e-2, 1e8, 201)
_EXACT = 1e-12


@experiment("relaxation-series", "relaxation times per decade")
def relaxation_series(effort: str, *, per_decade: Annotated[float, Above(0)] = 2.0) -> Share:
    """Modulus of a rubber with a continuous spectrum by a series of relaxation times.

    The largest relative error of G(w).
    """
    turns = (1j * _FREQUENCIES * _TIME) ** _FIRST
    true = _GLASSY - (_GLASSY - _RELAXED) / (1 + turns) ** _SECOND
    series = fit(_FREQUENCIES, true, per_decade=per_decade)
    details = {
        "relaxation times": float(series.material.times.size),
        "rms error": series.rms_error,
    }
    return Share(float(series.error.max()), _EXACT, details, "deviation")
