"""Pointed and smooth bodies of revolution: paraboloid, sphere, cone, power law."""

from __future__ import annotations

import math

import numpy as np
from scipy.special import poch

from reference.closed_form.form import Array, ClosedForm, Formulas, require_positive
from reference.closed_form.numerics import gauss, minus_tanh, solve_increasing


def paraboloid(radius: float, effective_modulus: float) -> ClosedForm:
    """Hertz contact of the paraboloid f(r) = r^2/(2R).

    a = sqrt(R d), F = (4/3) E* a d, p = (2 E*/(pi R)) sqrt(a^2 - r^2), U = (8/15) E* a d^2
    (Hertz 1881; Johnson 1985, section 4.2, equations (4.22)-(4.24)).

    Parameters
    ----------
    radius, effective_modulus : float
        R and E*, positive, in consistent units.

    Examples
    --------
    >>> ball = paraboloid(radius=1.0, effective_modulus=1.0)
    >>> round(float(ball.force(0.01)), 10)
    0.0013333333
    """
    require_positive("paraboloid", radius=radius, effective_modulus=effective_modulus)
    R, E = float(radius), float(effective_modulus)

    def contact_radius(d: Array) -> Array:
        return np.sqrt(R * d)

    def penetration(F: Array) -> Array:
        # d^3 = (3F/(4E*))^2 / R; the division between the factors avoids overflow.
        area = 0.75 * (F / E)
        return np.cbrt(area / R * area)

    return Formulas(
        "paraboloid",
        "Hertz 1881; Johnson 1985, (4.22)-(4.24)",
        force=lambda d: 4 / 3 * E * contact_radius(d) * d,
        penetration=penetration,
        semi_axes=lambda d: (contact_radius(d),) * 2,
        stiffness=lambda d: 2 * E * contact_radius(d),
        energy=lambda d: 8 / 15 * E * contact_radius(d) * d * d,
        pressure=lambda rho, d: (
            2 * E / np.pi * (contact_radius(d) / R) * np.sqrt((1 - rho) * (1 + rho))
        ),
    ).closed_form()


# tanh(14) = 1 - 1.4e-12: beyond this, the contact radius equals R within the accuracy of the
# pressures.
_SPHERE_LIMIT = 14.0


def sphere(radius: float, effective_modulus: float) -> ClosedForm:
    """Contact of the exact spherical profile f(r) = R - sqrt(R^2 - r^2).

    d = (a/2) ln((R+a)/(R-a)),  F = E* [(R^2+a^2)/2 ln((R+a)/(R-a)) - a R]
    (Segedin 1957; Popov, Hess & Willert 2019, chapter 2), within linear elasticity of the
    half-space. With a = R tanh(b) this is d = R b tanh(b) and
    F = E* R^2 [b - tanh(b) + b tanh(b)^2], free of cancellation. The pressure is

    p(r) = (E*/pi) [ (R/w) artanh(v/w) + int_r^a artanh(x/R)/sqrt(x^2 - r^2) dx ]

    with v^2 = a^2 - r^2 and w^2 = R^2 - r^2, the integral by Gauss quadrature after x^2 = r^2 +
    w^2 tanh(t)^2, which removes both the root at r and the logarithm at R (relative accuracy
    1e-13).

    Parameters
    ----------
    radius, effective_modulus : float
        R and E*, positive, in consistent units.

    Raises
    ------
    ValueError
        For invalid parameters, and by the functions if the contact would reach the radius of the
        sphere (d > 14 R, where 1 - a/R is below 2e-12).

    Examples
    --------
    >>> ball = sphere(radius=1.0, effective_modulus=1.0)
    >>> hertz = paraboloid(radius=1.0, effective_modulus=1.0)
    >>> bool(ball.force(0.1) < hertz.force(0.1))
    True
    """
    require_positive("sphere", radius=radius, effective_modulus=effective_modulus)
    R, E = float(radius), float(effective_modulus)

    def depth_law(b: Array) -> tuple[Array, Array]:
        return b * np.tanh(b), np.tanh(b) + b / np.cosh(b) ** 2

    def force_law(b: Array) -> tuple[Array, Array]:
        # dF = 2 E* a dd for every contact.
        return minus_tanh(b) + b * np.tanh(b) ** 2, 2 * np.tanh(b) * depth_law(b)[1]

    def edge(d: Array) -> Array:
        relative = d / R
        return solve_increasing(depth_law, relative, np.sqrt(relative) + relative)

    def penetration(F: Array) -> Array:
        relative = F / E / R / R
        b = solve_increasing(force_law, relative, np.cbrt(0.75 * relative) + 0.5 * relative)
        return R * depth_law(b)[0]

    def energy(d: Array) -> Array:
        # U = E* int_0^a (d - g)^2 dx with the equivalent profile g = x artanh(x/R).
        b = edge(d)
        relative = d / R
        springs = gauss(
            lambda t: ((relative - t * np.tanh(t)) / np.cosh(t)) ** 2, 0 * b, b, nodes=64
        )
        return E * R**3 * springs

    return Formulas(
        "sphere",
        "Segedin 1957; Popov, Hess & Willert 2019, chapter 2",
        force=lambda d: E * R * R * force_law(edge(d))[0],
        penetration=penetration,
        semi_axes=lambda d: (R * np.tanh(edge(d)),) * 2,
        stiffness=lambda d: 2 * E * R * np.tanh(edge(d)),
        energy=energy,
        pressure=lambda rho, d: E / np.pi * _sphere_pressure(rho, edge(d)),
        penetration_limit=R * _SPHERE_LIMIT * math.tanh(_SPHERE_LIMIT),
        limit_reason="the contact would reach the radius of the sphere",
    ).closed_form()


def _sphere_pressure(rho: Array, b: Array) -> Array:
    """Return pi p/E* of the sphere, with a/R = tanh(b) and r = rho a."""
    a = np.tanh(b)
    r = rho * a
    # 1 - r^2 without loss near the edge of a deep contact: sech(b)^2 + a^2 (1 - rho^2).
    inner = (1 - rho) * (1 + rho) * a * a
    w = np.sqrt(inner + 1 / np.cosh(b) ** 2)
    top = np.arcsinh(np.sqrt(inner) * np.cosh(b))  # artanh(v/w), as w^2 - v^2 = sech(b)^2

    def integrand(t: Array) -> Array:
        x = np.hypot(r, w * np.tanh(t))
        # artanh(x) from 1 - x^2 = w^2 sech(t)^2, which remains exact as x tends to 1.
        return np.arcsinh(x * np.cosh(t) / w) / x * w / np.cosh(t) ** 2

    return top / w + gauss(integrand, 0 * top, top, nodes=64)


def cone(slope: float, effective_modulus: float) -> ClosedForm:
    """Contact of the cone f(r) = s r, s the slope of the flank against the surface.

    d = (pi/2) s a,  F = E* a d,  p = (E* s/2) arcosh(a/r),  U = F d/3
    (Love 1939; Sneddon 1965). The pressure is infinite at the tip, logarithmically.

    Parameters
    ----------
    slope, effective_modulus : float
        s and E*, positive.

    Examples
    --------
    >>> tip = cone(slope=0.1, effective_modulus=1.0)
    >>> round(float(tip.contact_radius(0.05 * 3.141592653589793)), 12)
    1.0
    """
    require_positive("cone", slope=slope, effective_modulus=effective_modulus)
    s, E = float(slope), float(effective_modulus)

    def contact_radius(d: Array) -> Array:
        return 2 / np.pi * d / s

    def pressure(rho: Array, d: Array) -> Array:
        # arcosh(1/rho) written so that it is exact both at the edge and at the tip.
        return 0.5 * E * s * np.arcsinh(np.sqrt((1 - rho) * (1 + rho)) / rho)

    return Formulas(
        "cone",
        "Love 1939; Sneddon 1965",
        force=lambda d: E * contact_radius(d) * d,
        penetration=lambda F: np.sqrt(0.5 * np.pi * s * (F / E)),
        semi_axes=lambda d: (contact_radius(d),) * 2,
        stiffness=lambda d: 2 * E * contact_radius(d),
        energy=lambda d: E * contact_radius(d) * d * d / 3,
        pressure=pressure,
        singular_at="centre",
    ).closed_form()


def power_law(exponent: float, coefficient: float, effective_modulus: float) -> ClosedForm:
    """Contact of the body of revolution f(r) = c r^n, for any n > 0.

    d = kappa c a^n, kappa = (sqrt(pi)/2) n Gamma(n/2)/Gamma((n+1)/2),  F = 2 E* n/(n+1) d a
    (Galin 1946; Sneddon 1965), U = n/(2n+1) F d, and

    p(r) = (E*/pi) n (d/a) int_{r/a}^1 y^(n-1)/sqrt(y^2 - (r/a)^2) dy.

    With y = (r/a) cosh(t) the integrand is y^(n-1) dt, positive and analytic: Gauss quadrature over
    the significant part gives 13 digits for all n and r, whereas the equivalent hypergeometric
    function loses digits by cancellation at large n. On the axis the integral is 1/(n-1), infinite
    for n <= 1.

    Parameters
    ----------
    exponent, coefficient, effective_modulus : float
        n, c (length^(1-n)) and E*, positive.

    Examples
    --------
    >>> quartic = power_law(exponent=4, coefficient=1.0, effective_modulus=1.0)
    >>> round(float(quartic.contact_radius(8 / 3)), 12)
    1.0
    """
    require_positive(
        "power_law",
        exponent=exponent,
        coefficient=coefficient,
        effective_modulus=effective_modulus,
    )
    n, c, E = float(exponent), float(coefficient), float(effective_modulus)
    kappa = 0.5 * math.sqrt(math.pi) * n / poch(0.5 * n, 0.5)
    lever = 2 * E * n / (n + 1)
    # Roots are taken of lengths in units of a power of two near the length of the shape, so that
    # the digits are the same for units that differ by powers of two.
    power = math.log2(c) / (1 - n) if n != 1 else 0.0
    power = round(max(-1000.0, min(power, 1000.0)))  # for n close to 1 it exceeds all floats
    unit = 2.0**power
    mantissa, exponent_of_two = math.frexp(c)
    # c unit^(n-1), whose second factor alone may exceed all floats.
    scaled = kappa * mantissa * 2.0 ** (exponent_of_two + power * (n - 1))
    reach = scaled ** (1 / n)  # separate from d, as it may be 1e+-300 for large n

    def contact_radius(d: Array) -> Array:
        return unit * ((d / unit) ** (1 / n) / reach)

    return Formulas(
        "power_law",
        "Galin 1946; Sneddon 1965",
        force=lambda d: lever * contact_radius(d) * d,
        penetration=lambda F: (
            unit * ((F / (lever * unit * unit)) ** (n / (n + 1)) * scaled ** (1 / (n + 1)))
        ),
        semi_axes=lambda d: (contact_radius(d),) * 2,
        stiffness=lambda d: 2 * E * contact_radius(d),
        energy=lambda d: n / (2 * n + 1) * lever * contact_radius(d) * d * d,
        pressure=lambda rho, d: (
            E / np.pi * n * (d / contact_radius(d)) * _power_law_integral(rho, n)
        ),
        singular_at="centre" if n <= 1 else None,
    ).closed_form()


def _power_law_integral(rho: Array, n: float) -> Array:
    """Return int_rho^1 y^(n-1)/sqrt(y^2 - rho^2) dy."""
    on_axis = 1 / (n - 1) if n > 1 else np.inf
    off_axis = rho > 0
    q = np.where(off_axis, rho, 0.5)
    top = np.arcsinh(np.sqrt((1 - q) * (1 + q)) / q)
    # For n > 1 the integrand decreases from 1 at the upper limit; values below 1e-18 are omitted.
    threshold = 10.0 ** (-18 / (n - 1)) if n > 1 else 0.0
    bottom = np.arccosh(np.maximum(1.0, threshold / q))
    integral = gauss(lambda t: (q * np.cosh(t)) ** (n - 1), bottom, top, nodes=64)
    return np.where(off_axis, integral, on_axis)
