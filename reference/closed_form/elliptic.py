"""Contacts with an elliptic outline: the ellipsoid and the flat elliptic punch."""

from __future__ import annotations

import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf

from reference.closed_form.form import Array, ClosedForm, Formulas, require_positive


def ellipsoid(radius_x: float, radius_y: float, effective_modulus: float) -> ClosedForm:
    """Hertz contact of f = x^2/(2 Rx) + y^2/(2 Ry), exact.

    The contact is an ellipse, p = p0 sqrt(1 - x^2/a^2 - y^2/b^2), F = (2/3) pi a b p0. With a the
    longer semi-axis (along the larger radius R1, R2 the other) and k = b/a,

    R1/R2 = R_D(0,1,k^2)/R_D(0,k^2,1),  d = (p0/E*) b R_F(0,k^2,1),
    a^2 = (2/3) R1 d R_D(0,k^2,1)/R_F(0,k^2,1)

    (Hertz 1881; Johnson 1985, section 4.2, whose K - E and (a/b)^2 E - K are
    written here as Carlson's integrals, DLMF 19.25.1: no cancellation near the circle, or for
    slender ellipses).

    Parameters
    ----------
    radius_x, radius_y, effective_modulus : float
        Radii of curvature along x and y, and E*; positive, in consistent units. Ratios of the
        radii up to 1e15 either way.

    Raises
    ------
    ValueError
        For parameters that are not finite and positive, or radii more than 1e15 apart.

    Examples
    --------
    >>> roller = ellipsoid(radius_x=2.0, radius_y=1.0, effective_modulus=1.0)
    >>> half_x, half_y = roller.semi_axes(0.01)
    >>> round(float(half_y / half_x), 2)  # close to, not equal to (1/2)^(2/3) = 0.63
    0.63
    """
    require_positive(
        "ellipsoid", radius_x=radius_x, radius_y=radius_y, effective_modulus=effective_modulus
    )
    longer, shorter = float(max(radius_x, radius_y)), float(min(radius_x, radius_y))
    if longer > 1e15 * shorter:
        raise ValueError(
            f"ellipsoid: radius_x {radius_x!r} and radius_y {radius_y!r} differ by more than 1e15"
        )
    E = float(effective_modulus)
    squared_ratio = _squared_axis_ratio(longer / shorter)
    K = float(elliprf(0.0, squared_ratio, 1.0))
    curvature = 2 / 3 * float(elliprd(0.0, squared_ratio, 1.0)) / K
    slenderness = math.sqrt(squared_ratio)
    # F = lever * sqrt(R1 d) * d
    lever = 2 * math.pi / 3 * E * math.sqrt(curvature) / K

    def major(d: Array) -> Array:
        return math.sqrt(curvature) * np.sqrt(longer * d)

    def semi_axes(d: Array) -> tuple[Array, Array]:
        a = major(d)
        return (a, slenderness * a) if radius_x >= radius_y else (slenderness * a, a)

    def penetration(F: Array) -> Array:
        area = F / lever
        return np.cbrt(area / longer * area)

    return Formulas(
        "ellipsoid",
        "Hertz 1881; Johnson 1985, section 4.2",
        force=lambda d: lever * np.sqrt(longer * d) * d,
        penetration=penetration,
        semi_axes=semi_axes,
        stiffness=lambda d: 1.5 * lever * np.sqrt(longer * d),
        energy=lambda d: 0.4 * lever * np.sqrt(longer * d) * d * d,
        pressure=lambda rho, d: (
            E / K * (d / (slenderness * major(d))) * np.sqrt((1 - rho) * (1 + rho))
        ),
        axisymmetric=False,
    ).closed_form()


def _squared_axis_ratio(radius_ratio: float) -> float:
    """Return (b/a)^2 of the contact ellipse of two radii of curvature, R1/R2 >= 1."""
    if radius_ratio == 1.0:
        return 1.0

    def mismatch(log_q: float) -> float:
        q = math.exp(log_q)
        return math.log(elliprd(0.0, 1.0, q) / elliprd(0.0, q, 1.0) / radius_ratio)

    # b/a lies between R2/R1 (slender limit, up to a logarithm) and 1.
    log_q = brentq(mismatch, -2 * math.log(radius_ratio) - 1, 0.0, xtol=1e-16, rtol=1e-15)
    return math.exp(log_q)


def elliptic_punch(semi_axis_x: float, semi_axis_y: float, effective_modulus: float) -> ClosedForm:
    """Flat punch with an elliptic outline.

    With a >= b and m = 1 - b^2/a^2:  F = pi E* a d/K(m),
    p = F/(2 pi a b sqrt(1 - x^2/a^2 - y^2/b^2)),  U = F d/2
    (Green & Sneddon 1950; Johnson 1985, section 3.5). The punch is stiffer than the circle of equal
    area by the factor pi sqrt(a/b)/(2 K(m)).

    Parameters
    ----------
    semi_axis_x, semi_axis_y, effective_modulus : float
        Half-lengths along x and y (either may be the longer), and E*; positive.

    Examples
    --------
    >>> round(float(elliptic_punch(1.0, 1.0, 1.0).force(0.25)), 12)
    0.5
    """
    require_positive(
        "elliptic_punch",
        semi_axis_x=semi_axis_x,
        semi_axis_y=semi_axis_y,
        effective_modulus=effective_modulus,
    )
    half_x, half_y, E = float(semi_axis_x), float(semi_axis_y), float(effective_modulus)
    a, b = max(half_x, half_y), min(half_x, half_y)
    K = float(elliprf(0.0, (b / a) ** 2, 1.0))
    stiffness = math.pi * E * a / K
    return Formulas(
        "elliptic_punch",
        "Green & Sneddon 1950; Johnson 1985, section 3.5",
        force=lambda d: stiffness * d,
        penetration=lambda F: F / stiffness,
        semi_axes=lambda d: (np.full_like(d, half_x)[()], np.full_like(d, half_y)[()]),
        stiffness=lambda d: np.full_like(d, stiffness)[()],
        energy=lambda d: 0.5 * stiffness * d * d,
        pressure=lambda rho, d: 0.5 * E / K * (d / b) / np.sqrt((1 - rho) * (1 + rho)),
        axisymmetric=False,
        singular_at="edge",
        singular_edge=(half_x, half_y),
    ).closed_form()
