"""Section 19.3 (b) and (c): independent contacts, what is local in that of a finite body; profiles.

A flat round punch of diameter D = 2a on a half-space, on a half-ball of radius R, or (in two
dimensions) a strip of width D on a half-cylinder in plane strain; two punches and arrays of them;
the same half-space as a conductor, and of other materials.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache
from typing import Annotated, Literal

import numpy as np
from pydantic import Field
from scipy.linalg import cho_factor, cho_solve

from comparisons.judging.uncertainty import grid_uncertainty
from comparisons.questions.experiments.experiment import (
    Finding,
    Fraction,
    Positive,
    Share,
    experiment,
    worst,
)
from comparisons.questions.experiments.punched_section import (
    SectionContact,
    Support,
    Symmetry,
    press_section,
)
from reduced.loads import Load
from reduced.profiles import equivalents
from reduced.profiles.transform import from_function, inverse_transform
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference.closed_form import boussinesq, boussinesq_energy, cylinder
from reference.errors import finite_faults, positive_faults, refuse
from reference.halfspace.kernels import love

# Radius in units of a for which the half-ball equals a half-space to 1e-6: k/(2 E* a) = 1 + 1.09
# a/R.
_HALF_SPACE, _NU = 1e6, 0.3


@experiment("far-field", "distance r/D")
def far_field(
    effort: str,
    *,
    distance: Annotated[float, Field(gt=0.5)] = 10.0,
    reading: Literal["letter", "corrected"] = "letter",
) -> Finding:
    """Displacement of the surface at a distance from a flat punch (19.9).

    Compare (19.9) with u = (2 d/pi) arcsin(a/r) (Sneddon 1965; Johnson 1985, (3.38)) at r/D.
    ``"letter"``: u = D d/r; ``"corrected"``: Boussinesq's u for a point force equal to that of the
    punch, D d/(pi r), with the pi that the chapter omits. D = d = E* = 1.
    """
    true = 2 / np.pi * np.arcsin(0.5 / distance)
    if reading == "letter":
        stated = 1 / distance
    else:
        stated = float(boussinesq(float(cylinder(0.5, 1.0).force(1.0)), distance, 1.0))
    # the closed form is exact up to rounding; both are u/d
    return Finding(stated, true, 1e-14, {})


@lru_cache(maxsize=64)
def _pair(
    effort: str,
    radius: float,
    poisson_ratio: float,
    kind: Symmetry,
    support: Support,
    radii: tuple[float, ...] = (),
) -> tuple[SectionContact, SectionContact]:
    """Return the body on two meshes, the finer one last.

    The error decreases as the fourth power, so the difference far exceeds the remaining error.
    """
    finest = 16 if effort == "full" else 8
    coarse, fine = (
        press_section(radius, poisson_ratio, kind=kind, support=support, radii=radii, elements=n)
        for n in (finest // 2, finest)
    )
    return coarse, fine


@experiment("energy-share", "distance r/D")
def energy_share(
    effort: str,
    *,
    distance: Annotated[float, Field(gt=0.78)] = 1.0,
    reading: Literal["local", "letter", "corrected"] = "local",
) -> Finding | Share:
    """Share of the elastic energy that lies far from the contact (19.10).

    Statements: ``"local"``, it lies "in a volume with linear dimensions on the order of D", the
    fraction itself; ``"letter"``, the integral (19.10) as printed, pi G D^2 d^2/r; ``"corrected"``,
    the integral of Boussinesq's field.
    """
    rho = 2 * float(distance)
    pair = _pair(effort, _HALF_SPACE, _NU, "axisymmetric", "fixed", (rho,))
    coarse, fine = (float(1 - body.energy[0]) for body in pair)
    bar = abs(fine - coarse) + 1 / _HALF_SPACE
    # with a = d = E* = 1 the force is 2 and the total energy is 1
    stated = {
        "letter": np.pi * (1 - _NU) / 2 * 4 / rho,
        "corrected": float(boussinesq_energy(2.0, rho, 1.0, _NU)),
    }
    beyond = fine * pair[1].stiffness / 2
    details = {
        "share within": 1 - fine,
        "share beyond times r/D": fine * distance,
        "(19.10) over the energy beyond": stated["letter"] / beyond,
    }
    if reading == "local":
        return Share(fine, bar, details)
    return Finding(stated[reading], beyond, bar / fine * stated[reading] / beyond, details)


@experiment("body-size", "size of the body R/D")
def body_size(
    effort: str, *, size: Annotated[float, Field(gt=1.99)] = 10.0, kind: Symmetry = "axisymmetric"
) -> Finding:
    """Change of the contact stiffness with the size of the body.

    Compare the stiffness (and energy at equal depth) of a body R = size D with that of 10 R. "The
    size and form of the macroscopic body is unimportant" in three dimensions, but not in two.
    """
    body, tenfold = (
        [mesh.stiffness for mesh in _pair(effort, 2 * radius, _NU, kind, "fixed")]
        for radius in (size, 10 * size)
    )
    (coarse, fine), (coarse_tenfold, true) = body, tenfold
    bar = abs(fine / true - coarse / coarse_tenfold)
    unit = "F/(E* D d)" if kind == "axisymmetric" else "F/(E* d) per length"
    scale = 0.5 if kind == "axisymmetric" else 1.0
    details = {
        f"{unit}, R": scale * fine,
        f"{unit}, 10 R": scale * true,
        "error times R/D": (fine / true - 1) * size,
    }
    return Finding(fine, true, bar, details)


@experiment("plane-logarithm", "size of the body R/D")
def plane_logarithm(effort: str, *, size: Annotated[float, Field(gt=1.99)] = 10.0) -> Finding:
    """Growth of the compliance in plane strain with the logarithm of the body.

    In plane strain d E*/F grows by (2/pi) ln 10 for tenfold R (Johnson 1985, 2.8).
    """
    pairs = [_pair(effort, factor * 2 * size, _NU, "plane", "fixed") for factor in (1.0, 10.0)]
    stated = 2 / np.pi * np.log(10)
    coarse, fine = (1 / pairs[1][mesh].stiffness - 1 / pairs[0][mesh].stiffness for mesh in (0, 1))
    return Finding(stated, fine, abs(stated / fine - stated / coarse), {})


@experiment("kinetic-energy", "diameter of the contact over the body's radius D/R")
def kinetic_energy(
    effort: str,
    *,
    ratio: Annotated[float, Field(gt=0, le=0.5)] = 0.1,
    frame: Literal["far", "held", "centre"] = "far",
    reading: Literal["rigid", "printed", "linear"] = "rigid",
    quantity: Literal["energy", "reduction"] = "energy",
    kind: Symmetry = "axisymmetric",
) -> Finding:
    """Kinetic energy of a body that is pressed at v0 (19.11)-(19.12).

    Measure the kinetic energy of a body at v0 with its surface held by a punch, D/R = ratio. The
    field is quasi-static, v = v0 - v0 u/d, with u of the half-space (frame ``"far"``, the
    chapter's: v0 is the velocity far away), of a half-ball whose round side moves at v0
    (``"held"``), or of a free half-ball whose centre of mass moves at v0 (``"centre"``).
    Statements: ``"rigid"`` K = m v0^2/2, ``"printed"`` times 1 - D/R (19.12), ``"linear"`` with the
    exact coefficient (7 - 6 nu)/(2 pi (1 - nu)) of the half-space in place of one. Quantities: the
    ``"energy"``, or the ``"reduction"`` 1 - 2 K/(m v0^2) of (19.12), an estimate.
    """
    if frame == "far" and kind == "plane":
        raise ValueError("in plane strain nothing is far: the field grows with the body")
    radius = 2 / float(ratio)
    support: Support = "inertia" if frame == "centre" else "fixed"
    if frame == "far":
        half_space = _HALF_SPACE * radius
        pair = _pair(effort, half_space, _NU, kind, support, (radius,))
    else:
        pair = _pair(effort, radius, _NU, kind, support)
    coarse, true = (
        1 - 2 * body.mean_displacement[0] + body.mean_square_displacement[0] for body in pair
    )
    exact = (7 - 6 * _NU) / (2 * np.pi * (1 - _NU))
    stated = {"rigid": 1.0, "printed": 1 - ratio, "linear": 1 - exact * ratio}[reading]
    bar = abs(true - coarse) + (2 * ratio / _HALF_SPACE if frame == "far" else 0.0)
    details = {
        "K/(m v0^2/2)": float(true),
        "linear coefficient 2 <u>/d R/D": float(2 * pair[1].mean_displacement[0] / ratio),
        "of the half-space": exact,
    }
    if quantity == "reduction":
        stated, true = 1 - stated, 1 - float(true)
        return Finding(stated, true, abs(stated / true) * float(bar / abs(true)), details)
    return Finding(stated, float(true), float(stated / true * bar / true), details)


@experiment("independent-contacts", "distance over diameter s/D")
def independent_contacts(
    effort: str,
    *,
    distance: Annotated[float, Field(gt=1)] = 10.0,
    per_side: Annotated[int, Field(strict=False, ge=0, le=1000)] = 0,
) -> Finding:
    """Forces of flat punches side by side against those of single ones.

    At equal penetration, for two punches (exact) or a square array of per_side^2. The bar of arrays
    is the error of point forces, measured for the pair.
    """
    resolutions = np.array([4, 8, 16] if effort == "quick" else [5, 10, 20])
    forces = np.array([pair_force(2 * distance, int(n)) for n in resolutions])
    interaction = 1 / forces - 1
    grid = float(grid_uncertainty(resolutions, interaction[:, None])[0])
    points = 1 / (np.pi * distance)  # 2a/(pi s)
    details = {"pair: sum over true - 1": float(interaction[-1]), "pair, as point forces": points}
    if not per_side:
        return Finding(1.0, float(forces[-1]), float(interaction[-1]) * grid, details)
    true = array_force(2 * distance, per_side)
    left_out = abs(points / interaction[-1] - 1) + grid
    details["punches"] = float(per_side**2)
    details["share of the area"] = float(np.pi / 4 / distance**2)
    return Finding(1.0, true, (1 / true - 1) * left_out, details)


_ROUNDING = 1e-9


@experiment("transverse-isotropy", "stiffness along the axis over across c33/c11")
def transverse_isotropy(
    effort: str, *, ratio: Positive = 2.0, shear: float = 0.4, cross: float = 0.3
) -> Finding:
    """Elliott's modulus of transversely isotropic half-spaces against the answer to a wave.

    The answer to a wave of pressure is solved from equilibrium. ratio : c33/c11, along the axis
    over across; shear : c44/c11; cross : c13/sqrt(c11 c33).
    """
    body = TransverselyIsotropic(1.0, cross * math.sqrt(ratio), ratio, shear)
    stated, true = body.effective_modulus, body.modulus_of_a_wave()
    return Finding(stated, true, _ROUNDING, {})


@experiment("conductance", "distance over diameter s/D")
def conductance(effort: str, *, distance: Annotated[float, Field(gt=1)] = 2.0) -> Finding:
    """Greenwood's conductance of two spots against the stiffness of two punches.

    Greenwood (Brit. J. Appl. Phys. 17 (1966) 1621), n like spots: 1/C = 1/(4 k n a) + sum 1/s_ij/
    (2 pi k n^2). By Barber's analogy (Proc. R. Soc. A 459 (2003) 53) C = 2 k/E* times the contact
    stiffness, which is known for two punches by FFT BEM.
    """
    counts = (8, 16) if effort == "quick" else (10, 20)
    coarse, fine = (pair_force(2 * distance, n) for n in counts)
    stated = 1 / (1 + 1 / (math.pi * distance))
    bar = 1.25 * abs(fine / coarse - 1)
    return Finding(stated, fine, bar, {})


Slope = Callable[[np.ndarray], np.ndarray]


def blunt(shape: str, b: float) -> tuple[Slope, float, float]:
    """Return slope f'(r), depth and force F/E* of a shape at the contact radius 1."""
    s = math.sqrt(1 - b * b)
    if shape == "truncated_cone":
        phi = math.acos(b)
        return (lambda r: np.where(r > b, 1.0, 0.0)), phi, phi + b * s
    if shape == "truncated_paraboloid":
        return (lambda r: np.where(r > b, r, 0.0)), s, 2 / 3 * (2 + b * b) * s
    f = math.asin(b)
    depth = (1 - math.cos(f)) / math.sin(f) + math.pi / 2 - f

    def share(x: np.ndarray) -> np.ndarray:
        """Depth g(x) of the same body at the contact radius x."""
        inner = np.arcsin(np.minimum(b / np.maximum(x, b), 1.0))
        outer = x * ((1 - np.cos(inner)) / np.sin(inner) + np.pi / 2 - inner)
        return np.where(x > b, outer, x * x / b)

    x, weights = np.polynomial.legendre.leggauss(200)
    parts = [(0.0, b), (b, 1.0)]
    area = sum(
        0.5 * (high - low) * float(weights @ share(0.5 * (low + high) + 0.5 * (high - low) * x))
        for low, high in parts
    )
    return (lambda r: np.minimum(r / b, 1.0)), depth, 2 * (depth - area)


@experiment("blunt-body", "flat or round radius over contact radius b/a")
def blunt_body(
    effort: str,
    *,
    flat: Fraction = 0.5,
    shape: Literal["truncated_cone", "truncated_paraboloid", "round_cone"] = "truncated_cone",
) -> Finding:
    """Springs under blunt bodies against their closed forms.

    Forces at equal depth, a = 1, E* = 1. Shapes (Popov, Hess & Willert 2019, 2.5):
    ``"truncated_cone"`` of slope 1 and ``"truncated_paraboloid"`` of radius 1, both flat to b =
    `flat`; ``"round_cone"``, of slope 1 with a round tip to b.
    """
    slope, depth, true = blunt(shape, flat)
    profile = from_function(slope, length=1.0, breakpoints=(flat,))
    coarse, fine = (
        float(indent(Springs(profile, 1.0, count), Load("penetration", depth)).force[0])
        for count in (400, 800)
    )
    return Finding(fine, true, abs(fine - coarse) / true + _ROUNDING, {"depth": depth})


_RADII = np.linspace(0.05, 1.0, 20)
_QUADRATURE = 1e-11  # of the transform and its inverse, both to 1e-12


@experiment("equivalent-body", "exponent n of f = c r^n")
def equivalent_body(
    effort: str,
    *,
    exponent: Positive = 2.0,
    rule: Literal["half_radius", "transform"] = "half_radius",
) -> Finding:
    """Body of revolution that a profile stands for, against the one that it was made from.

    The largest error over radii up to one. ``"half_radius"``: the chapter's profile;
    ``"transform"``: the profile of the general transform, by quadrature of the slope f'.
    """
    if rule == "half_radius":
        section = equivalents.power_law(exponent, 1.0).section
        assert section is not None  # all shapes except for tables have one
        profile = equivalents.half_radius(section)
    else:
        profile = from_function(lambda r: exponent * r ** (exponent - 1), length=1.0)
    body, true = inverse_transform(profile, _RADII), _RADII**exponent
    details = {"spread over the radii": float(np.ptp(body / true))}
    return Finding(*worst(body, true), _QUADRATURE, details)


@dataclass(frozen=True)
class TransverselyIsotropic:
    """A half-space of moduli c11, c13, c33, c44 whose axis of isotropy is the surface's normal.

    H. A. Elliott (Proc. Camb. Phil. Soc. 44 (1948) 522; 45 (1949) 621): frictionless contact is
    that of an isotropic half-space with one modulus, as every wave of pressure p cos(q x) sinks in
    by 2 p/(E* q). Moduli with c13^2 >= c11 c33 are refused.

    >>> steel = TransverselyIsotropic(1.4, 0.6, 1.4, 0.4)  # isotropic: (c11 - c13)/2 = c44
    >>> round(steel.effective_modulus, 12) == round(4 * 0.4 * (1.4 - 0.4) / 1.4, 12)
    True
    """

    c11: float
    c13: float
    c33: float
    c44: float

    def __post_init__(self) -> None:
        wrong = positive_faults(c11=self.c11, c33=self.c33, c44=self.c44)
        wrong += finite_faults(c13=self.c13)
        if not wrong and self.c13**2 >= self.c11 * self.c33:
            wrong.append("c13^2 must be below c11 c33")
        refuse(wrong)

    @property
    def effective_modulus(self) -> float:
        """E* = 2 sqrt((c11 c33 - c13^2)/c11 / (1/c44 + 2/(c13 + sqrt(c11 c33))))."""
        stiff = (self.c11 * self.c33 - self.c13**2) / self.c11
        soft = 1 / self.c44 + 2 / (self.c13 + math.sqrt(self.c11 * self.c33))
        return 2 * math.sqrt(stiff / soft)

    def modulus_of_a_wave(self) -> float:
        """Return 2 p/(q u_z) of a wave of pressure, by equilibrium, from the two fields that decay.

        u_x = i U exp(i x - l z), u_z = W exp(i x - l z), q = 1; no shear traction. Where the two
        rates l coincide, as in isotropic bodies, there are no two fields.
        """
        c11, c13, c33, c44 = self.c11, self.c13, self.c33, self.c44
        squares = [c33 * c44, (c13 + c44) ** 2 - c11 * c33 - c44**2, c11 * c44]
        rates = np.sqrt(np.roots(squares).astype(complex))
        rates = np.where(rates.real < 0, -rates, rates)
        along, across = 1j * (c13 + c44) * rates, c44 * rates**2 - c11
        shear = c44 * (1j * across - rates * along)
        normal = 1j * c13 * along - c33 * rates * across
        share = np.linalg.solve(np.array([shear, normal]), [0, -1])
        return float((2 / (share @ across)).real)


def pair_force(distance: float, cells: int) -> float:
    """Return the force on one of two equal flat round punches over that of a single one.

    At equal depth the pressures are mirror images, so one disc of square cells is solved, with the
    coefficients (19.3) of its cells plus those of the other disc. Far apart the ratio is 1/(1 +
    2a/(pi s)), with the other punch as a point force 2 E* a d. The radius follows from the
    stiffness of the disc of cells, 2 E* a, not from its outline, so the staircase of the edge only
    affects the shape of the pressure.

    `distance` is s/a, centre distance over radius, more than 2; `cells` those per radius.

    >>> round(pair_force(20.0, 8), 3), round(1 / (1 + 2 / (np.pi * 20)), 3)
    (0.969, 0.969)
    """
    if not (np.isfinite(distance) and distance > 2):
        raise ValueError(f"distance must be finite and more than two radii, got {distance!r}")
    if int(cells) != cells or cells < 2:
        raise ValueError(f"cells must be an integer of at least 2 per radius, got {cells!r}")
    axis = (np.arange(-cells, cells) + 0.5) / cells
    x, y = (coordinate.ravel() for coordinate in np.meshgrid(axis, axis, indexing="ij"))
    inside = np.hypot(x, y) < 1
    x, y = x[inside] * cells, y[inside] * cells
    spacing = (1 / cells, 1 / cells)
    self_response = love(x[:, None] - x, y[:, None] - y, spacing, 1.0)
    alone = cho_solve(cho_factor(self_response), np.ones(x.size)).sum()
    apart = distance * cells * (alone / cells**2 / 2)
    cross_response = love(apart - x[:, None] - x, y[:, None] - y, spacing, 1.0)
    beside = cho_solve(cho_factor(self_response + cross_response), np.ones(x.size)).sum()
    return float(beside / alone)


def array_force(distance: float, per_side: int) -> float:
    """Return the force on a square array of flat round punches over that of isolated ones.

    The per_side^2 punches of radius a at distances s have equal depth. A punch is a spring of
    stiffness 2 E* a, and a point force for the others: d = F_i/(2 E* a) + sum_j F_j/(pi E* r_ij),
    which neglects terms of relative order (a/s)^2 of the interaction.

    `distance` is s/a, at least 3; at most 80 punches lie along a side of the array.

    >>> array_force(20.0, 1)
    1.0
    """
    faults = []
    if not (np.isfinite(distance) and distance >= 3):
        faults.append(f"distance must be finite and at least three radii, got {distance!r}")
    if int(per_side) != per_side or not 1 <= per_side <= 80:
        faults.append(f"per_side must be an integer from 1 to 80, got {per_side!r}")
    refuse(faults)
    place = np.indices((per_side, per_side)).reshape(2, -1)
    apart = np.hypot(*(place[:, :, None] - place[:, None, :])) * distance
    np.fill_diagonal(apart, 2 / np.pi)  # so that 2/(pi r) is the compliance of the spring
    forces = cho_solve(cho_factor(2 / np.pi / apart), np.ones(per_side**2))
    return float(forces.mean())
