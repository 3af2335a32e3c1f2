"""Shapes on the half-space, a row each: bodies of revolution, the ellipsoid and flat punches.

Radii, slopes and the effective modulus E* are positive and in consistent units; others are refused.
"""

import math

import numpy as np
from scipy.optimize import brentq
from scipy.special import elliprd, elliprf, poch

from reference.arrays import Array
from reference.closed_form.form import ByRadius, ClosedForm, require_positive
from reference.closed_form.numerics import gauss, minus_arctan, minus_tanh, solve_increasing


def paraboloid(radius: float, effective_modulus: float) -> ClosedForm:
    """Hertz contact of the paraboloid f(r) = r^2/(2R).

    a = sqrt(R d), F = (4/3) E* a d, p = (2 E*/(pi R)) sqrt(a^2 - r^2), U = (8/15) E* a d^2
    (Hertz 1881; Johnson 1985, section 4.2, equations (4.22)-(4.24)).

    >>> ball = paraboloid(radius=1.0, effective_modulus=1.0)
    >>> round(float(ball.force(0.01)), 10)
    0.0013333333
    """
    R, E = require_positive("paraboloid", radius=radius, effective_modulus=effective_modulus)

    def contact_radius(d: Array) -> Array:
        return np.sqrt(R * d)

    def penetration(F: Array) -> Array:
        # d^3 = (3F/(4E*))^2 / R; the division between the factors avoids overflow.
        area = 0.75 * (F / E)
        return np.cbrt(area / R * area)

    def pressure(rho: Array, d: Array) -> Array:
        return 2 * E / np.pi * (contact_radius(d) / R) * np.sqrt((1 - rho) * (1 + rho))

    return ClosedForm(
        "paraboloid",
        "Hertz 1881; Johnson 1985, (4.22)-(4.24)",
        E,
        force_of=lambda d: 4 / 3 * E * contact_radius(d) * d,
        depth_of=penetration,
        energy_of=lambda d: 8 / 15 * E * contact_radius(d) * d * d,
        pressure_of=pressure,
        radius_of=contact_radius,
        by_radius=_power_by_radius("Johnson, Kendall & Roberts 1971", 2.0, 0.5 / R, E),
    )


def cone(slope: float, effective_modulus: float) -> ClosedForm:
    """Contact of the cone f(r) = s r, s the slope of the flank against the surface.

    d = (pi/2) s a,  F = E* a d,  p = (E* s/2) arcosh(a/r),  U = F d/3
    (Love 1939; Sneddon 1965). The pressure is infinite at the tip, logarithmically.

    >>> round(float(cone(slope=0.1, effective_modulus=1.0).contact_radius(0.05 * math.pi)), 12)
    1.0
    """
    s, E = require_positive("cone", slope=slope, effective_modulus=effective_modulus)

    def contact_radius(d: Array) -> Array:
        return 2 / np.pi * d / s

    def pressure(rho: Array, d: Array) -> Array:
        # arcosh(1/rho) written so that it is exact both at the edge and at the tip.
        return 0.5 * E * s * np.arcsinh(np.sqrt((1 - rho) * (1 + rho)) / rho)

    return ClosedForm(
        "cone",
        "Love 1939; Sneddon 1965",
        E,
        force_of=lambda d: E * contact_radius(d) * d,
        depth_of=lambda F: np.sqrt(0.5 * np.pi * s * (F / E)),
        energy_of=lambda d: E * contact_radius(d) * d * d / 3,
        pressure_of=pressure,
        radius_of=contact_radius,
        by_radius=_power_by_radius("Maugis & Barquins 1981", 1.0, s, E),
        singular_at="centre",
    )


def power_law(exponent: float, coefficient: float, effective_modulus: float) -> ClosedForm:
    """Contact of the body of revolution f(r) = c r^n, for any n > 0; c in length^(1-n).

    d = kappa c a^n, kappa = (sqrt(pi)/2) n Gamma(n/2)/Gamma((n+1)/2),  F = 2 E* n/(n+1) d a
    (Galin 1946; Sneddon 1965), U = n/(2n+1) F d, and

    p(r) = (E*/pi) n (d/a) int_{r/a}^1 y^(n-1)/sqrt(y^2 - (r/a)^2) dy.

    With y = (r/a) cosh(t) the integrand is y^(n-1) dt, positive and analytic: Gauss quadrature over
    the significant part gives 13 digits for all n and r, whereas the equivalent hypergeometric
    function loses digits by cancellation at large n. On the axis the integral is 1/(n-1), infinite
    for n <= 1. Adhesion holds the tip from n = 1/2 on (Zheng & Yu, Langmuir 23 (2007) 6075).

    >>> quartic = power_law(exponent=4, coefficient=1.0, effective_modulus=1.0)
    >>> round(float(quartic.contact_radius(8 / 3)), 12)
    1.0
    """
    n, c, E = require_positive(
        "power_law", exponent=exponent, coefficient=coefficient, effective_modulus=effective_modulus
    )
    lever = 2 * E * n / (n + 1)
    # Roots are taken of lengths in units of a power of two near the length of the shape, so that
    # the digits are the same for units that differ by powers of two.
    power = math.log2(c) / (1 - n) if n != 1 else 0.0
    power = round(max(-1000.0, min(power, 1000.0)))  # for n close to 1 it exceeds all floats
    unit = 2.0**power
    mantissa, exponent_of_two = math.frexp(c)
    # kappa c unit^(n-1), whose last factor alone may exceed all floats.
    scaled = _kappa(n) * mantissa * 2.0 ** (exponent_of_two + power * (n - 1))
    reach = scaled ** (1 / n)  # separate from d, as it may be 1e+-300 for large n

    def contact_radius(d: Array) -> Array:
        return unit * ((d / unit) ** (1 / n) / reach)

    def penetration(F: Array) -> Array:
        return unit * ((F / (lever * unit * unit)) ** (n / (n + 1)) * scaled ** (1 / (n + 1)))

    def pressure(rho: Array, d: Array) -> Array:
        on_axis = 1 / (n - 1) if n > 1 else np.inf
        off_axis = rho > 0
        q = np.where(off_axis, rho, 0.5)
        top = np.arcsinh(np.sqrt((1 - q) * (1 + q)) / q)
        # For n > 1 the integrand decreases from 1 at the upper limit; values below 1e-18 are left.
        threshold = 10.0 ** (-18 / (n - 1)) if n > 1 else 0.0
        bottom = np.arccosh(np.maximum(1.0, threshold / q))
        integral = gauss(lambda t: (q * np.cosh(t)) ** (n - 1), bottom, top, nodes=64)
        return E / np.pi * n * (d / contact_radius(d)) * np.where(off_axis, integral, on_axis)

    return ClosedForm(
        "power_law",
        "Galin 1946; Sneddon 1965",
        E,
        force_of=lambda d: lever * contact_radius(d) * d,
        depth_of=penetration,
        energy_of=lambda d: n / (2 * n + 1) * lever * contact_radius(d) * d * d,
        pressure_of=pressure,
        radius_of=contact_radius,
        by_radius=_power_by_radius("Zheng & Yu 2007", exponent, coefficient, E),
        singular_at="centre" if n <= 1 else None,
    )


def _kappa(n: float) -> float:
    """Return d/(c a^n) of f = c r^n."""
    return 0.5 * math.sqrt(math.pi) * n / poch(0.5 * n, 0.5)


def _power_by_radius(source: str, n: float, c: float, E: float) -> ByRadius:
    """d0 = kappa c a^n, F0 = 2 E* n/(n+1) kappa c a^(n+1)."""
    factor = _kappa(n) * c
    # at n = 1/2 and below, d(a) increases from a = 0 on
    refused = "" if n > 0.5 else f"exponent must be above 1/2, not {n!r}"
    return ByRadius(
        source,
        depth=lambda a: factor * a**n,
        load=lambda a: 2 * E * n / (n + 1) * factor * a ** (n + 1),
        rate=lambda a: n * factor * a ** (n - 1),
        scale=lambda ratio: (math.sqrt(ratio) / factor) ** (1 / (n - 0.5)),
        refused=refused,
    )


# tanh(14) = 1 - 1.4e-12: beyond this, the contact radius equals R within the accuracy of the
# pressures.
_SPHERE_LIMIT = 14.0


def sphere(radius: float, effective_modulus: float) -> ClosedForm:
    """Contact of the exact spherical profile f(r) = R - sqrt(R^2 - r^2), to d = 14 R.

    d = (a/2) ln((R+a)/(R-a)),  F = E* [(R^2+a^2)/2 ln((R+a)/(R-a)) - a R]
    (Segedin 1957; Popov, Hess & Willert 2019, chapter 2), within linear elasticity of the
    half-space. With a = R tanh(b) this is d = R b tanh(b) and
    F = E* R^2 [b - tanh(b) + b tanh(b)^2], free of cancellation. The pressure is

    p(r) = (E*/pi) [ (R/w) artanh(v/w) + int_r^a artanh(x/R)/sqrt(x^2 - r^2) dx ]

    with v^2 = a^2 - r^2 and w^2 = R^2 - r^2, the integral by Gauss quadrature after x^2 = r^2 +
    w^2 tanh(t)^2, which removes both the root at r and the logarithm at R (relative accuracy
    1e-13). Deeper than 14 R, where 1 - a/R is below 2e-12, loads are refused.
    """
    R, E = require_positive("sphere", radius=radius, effective_modulus=effective_modulus)

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

    def pressure(rho: Array, d: Array) -> Array:
        b = edge(d)
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

        return E / np.pi * (top / w + gauss(integrand, 0 * top, top, nodes=64))

    return ClosedForm(
        "sphere",
        "Segedin 1957; Popov, Hess & Willert 2019, chapter 2",
        E,
        force_of=lambda d: E * R * R * force_law(edge(d))[0],
        depth_of=penetration,
        energy_of=energy,
        pressure_of=pressure,
        radius_of=lambda d: R * np.tanh(edge(d)),
        by_radius=ByRadius(
            "Maugis 1995",  # Langmuir 11, 679
            depth=lambda a: a * np.arctanh(a / R),
            load=lambda a: E * ((R * R + a * a) * np.arctanh(a / R) - a * R),
            rate=lambda a: np.arctanh(a / R) + a * R / ((R - a) * (R + a)),
            scale=lambda ratio: min(0.5 * R, float(np.cbrt(R * R * ratio))),
            largest=R,
        ),
        limit=R * _SPHERE_LIMIT * math.tanh(_SPHERE_LIMIT),
        limit_reason="14 radii, where the contact would reach the radius of the sphere",
    )


def cylinder(radius: float, effective_modulus: float) -> ClosedForm:
    """Flat-ended circular punch of radius a.

    F = 2 E* a d,  p = F/(2 pi a sqrt(a^2 - r^2)),  U = E* a d^2
    (Boussinesq 1885; Johnson 1985, section 3.4). The pressure is infinite at the edge; the
    contact area is pi a^2 from the first touch on.

    >>> float(cylinder(radius=1.0, effective_modulus=1.0).force(0.25))
    0.5
    """
    a, E = require_positive("cylinder", radius=radius, effective_modulus=effective_modulus)
    zero = np.zeros_like
    return ClosedForm(
        "cylinder",
        "Boussinesq 1885; Johnson 1985, section 3.4",
        E,
        force_of=lambda d: 2 * E * a * d,
        depth_of=lambda F: F / (2 * E * a),
        energy_of=lambda d: E * a * d * d,
        pressure_of=lambda rho, d: E / np.pi * (d / a) / np.sqrt((1 - rho) * (1 + rho)),
        radius_of=lambda d: np.full_like(d, a)[()],
        by_radius=ByRadius("Kendall 1971", zero, zero, zero, lambda _: a, smallest=a, largest=a),
        singular_at="edge",
    )


def rounded_punch(flat_radius: float, edge_radius: float, effective_modulus: float) -> ClosedForm:
    """Flat circular punch with a parabolic edge: f = 0 to r = b, then (r - b)^2/(2R).

    With t = sqrt(a^2 - b^2)/b and s(x) = sqrt(x^2 - b^2),

    d = (b^2/R) sqrt(1+t^2) (t - arctan t),  F = (E* b^3/R) [t^3/3 + (1+t^2)(t - arctan t)],
    p(r) = (E*/(pi R)) int_max(b,r)^a (2 s - b arctan(s/b))/sqrt(x^2 - r^2) dx

    (Schubert 1942; Ejike 1981; Popov, Hess & Willert 2019, chapter 2, there in the angle
    phi = arctan t, whose terms cancel while d << b^2/R; here all terms are positive). The pressure
    integral is evaluated by Gauss quadrature in a logarithmic variable that removes the
    near-singularity at r = b (relative accuracy 1e-12).
    """
    b, R, E = require_positive(
        "rounded_punch",
        flat_radius=flat_radius,
        edge_radius=edge_radius,
        effective_modulus=effective_modulus,
    )
    depth = b / R * b

    def depth_law(t: Array) -> tuple[Array, Array]:
        # d R/b^2 and its derivative
        a, lag = np.hypot(1.0, t), minus_arctan(t)
        return a * lag, t * (lag + t) / a

    def force_law(t: Array) -> tuple[Array, Array]:
        # F R/(E* b^3) and its derivative
        lag = minus_arctan(t)
        return t**3 / 3 + (1 + t * t) * lag, 2 * t * (lag + t)

    def edge(d: Array) -> Array:
        relative = d / depth
        guess = np.minimum(np.cbrt(3 * relative), np.sqrt(relative) + 1)
        return solve_increasing(depth_law, relative, guess)

    def penetration(F: Array) -> Array:
        relative = F / E / depth / b
        return depth * depth_law(solve_increasing(force_law, relative, np.cbrt(relative)))[0]

    def energy(d: Array) -> Array:
        # U = E* int_0^a (d - g)^2 dx, with x = b cosh(q) beyond the flat.
        t, relative = edge(d), d / depth
        outer = gauss(
            lambda q: (relative - depth_law(np.sinh(q))[0]) ** 2 * np.sinh(q),
            0 * t,
            np.arcsinh(t),
            panels=4,
        )
        return E * b * depth * depth * (relative**2 + outer)

    def pressure(rho: Array, d: Array) -> Array:
        # Lengths in units of b. In q, with s = e sinh(q) inside the flat and e cosh(q) outside,
        # e^2 = |r^2 - 1|, both the root at x = r and the one at x = b vanish and the integrand is
        # (2 s - arctan s) s/x dq.
        t = edge(d)
        a = np.hypot(1.0, t)
        r = rho * a
        flat = r < 1
        # Below s = s0 is less than 1e-17 of the integral; e below a thousandth of s0 counts as 0.
        s0 = 3e-9 * np.sqrt(t * np.minimum(t, 1.0))
        e = np.maximum(np.sqrt(np.abs(1 - r) * (1 + r)), 1e-3 * s0)
        reach = np.where(flat, t, np.sqrt((1 - rho) * (1 + rho)) * a)
        top = np.arcsinh(reach / e)
        bottom = np.where(flat, np.arcsinh(s0 / e), np.arccosh(np.maximum(1.0, s0 / e)))

        def integrand(q: Array) -> Array:
            s = e * np.where(flat, np.sinh(q), np.cosh(q))
            return (2 * s - np.arctan(s)) * s / np.hypot(1.0, s)

        return E / np.pi * (b / R) * gauss(integrand, np.minimum(bottom, top), top, panels=4)

    def outer(a: Array) -> Array:
        return np.sqrt(np.maximum(a - b, 0.0) * (a + b)) / b

    return ClosedForm(
        "rounded_punch",
        "Schubert 1942; Ejike 1981; Popov, Hess & Willert 2019, chapter 2",
        E,
        force_of=lambda d: E * depth * b * force_law(edge(d))[0],
        depth_of=penetration,
        energy_of=energy,
        pressure_of=pressure,
        radius_of=lambda d: b * np.hypot(1.0, edge(d)),
        by_radius=ByRadius(
            "Popov, Hess & Willert 2019, chapter 3",
            depth=lambda a: a * b / R * minus_arctan(outer(a)),
            load=lambda a: E * b**3 / R * force_law(outer(a))[0],
            rate=lambda a: b / R * (outer(a) + minus_arctan(outer(a))),
            scale=lambda _: b,
            smallest=b,
        ),
    )


def ellipsoid(radius_x: float, radius_y: float, effective_modulus: float) -> ClosedForm:
    """Hertz contact of f = x^2/(2 Rx) + y^2/(2 Ry), exact, for radii up to 1e15 apart.

    The contact is an ellipse, p = p0 sqrt(1 - x^2/a^2 - y^2/b^2), F = (2/3) pi a b p0. With a the
    longer semi-axis (along the larger radius R1, R2 the other) and k = b/a,

    R1/R2 = R_D(0,1,k^2)/R_D(0,k^2,1),  d = (p0/E*) b R_F(0,k^2,1),
    a^2 = (2/3) R1 d R_D(0,k^2,1)/R_F(0,k^2,1)

    (Hertz 1881; Johnson 1985, section 4.2, whose K - E and (a/b)^2 E - K are
    written here as Carlson's integrals, DLMF 19.25.1: no cancellation near the circle, or for
    slender ellipses).

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
    ratio = longer / shorter

    def mismatch(log_q: float) -> float:
        q = math.exp(log_q)
        return math.log(elliprd(0.0, 1.0, q) / elliprd(0.0, q, 1.0) / ratio)

    squared_ratio = 1.0
    if ratio != 1.0:
        # b/a lies between R2/R1 (slender limit, up to a logarithm) and 1.
        low = -2 * math.log(ratio) - 1
        squared_ratio = math.exp(brentq(mismatch, low, 0.0, xtol=1e-16, rtol=1e-15))
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

    def pressure(rho: Array, d: Array) -> Array:
        return E / K * (d / (slenderness * major(d))) * np.sqrt((1 - rho) * (1 + rho))

    return ClosedForm(
        "ellipsoid",
        "Hertz 1881; Johnson 1985, section 4.2",
        E,
        force_of=lambda d: lever * np.sqrt(longer * d) * d,
        depth_of=penetration,
        energy_of=lambda d: 0.4 * lever * np.sqrt(longer * d) * d * d,
        pressure_of=pressure,
        axes_of=semi_axes,
        stiffness_of=lambda d: 1.5 * lever * np.sqrt(longer * d),
    )


def elliptic_punch(semi_axis_x: float, semi_axis_y: float, effective_modulus: float) -> ClosedForm:
    """Flat punch with an elliptic outline; either semi-axis may be the longer.

    With a >= b and m = 1 - b^2/a^2:  F = pi E* a d/K(m),
    p = F/(2 pi a b sqrt(1 - x^2/a^2 - y^2/b^2)),  U = F d/2
    (Green & Sneddon 1950; Johnson 1985, section 3.5). The punch is stiffer than the circle of equal
    area by the factor pi sqrt(a/b)/(2 K(m)).

    >>> round(float(elliptic_punch(1.0, 1.0, 1.0).force(0.25)), 12)
    0.5
    """
    half_x, half_y, E = require_positive(
        "elliptic_punch",
        semi_axis_x=semi_axis_x,
        semi_axis_y=semi_axis_y,
        effective_modulus=effective_modulus,
    )
    a, b = max(half_x, half_y), min(half_x, half_y)
    K = float(elliprf(0.0, (b / a) ** 2, 1.0))
    stiffness = math.pi * E * a / K
    return ClosedForm(
        "elliptic_punch",
        "Green & Sneddon 1950; Johnson 1985, section 3.5",
        E,
        force_of=lambda d: stiffness * d,
        depth_of=lambda F: F / stiffness,
        energy_of=lambda d: 0.5 * stiffness * d * d,
        pressure_of=lambda rho, d: 0.5 * E / K * (d / b) / np.sqrt((1 - rho) * (1 + rho)),
        axes_of=lambda d: (np.full_like(d, half_x)[()], np.full_like(d, half_y)[()]),
        stiffness_of=lambda d: np.full_like(d, stiffness)[()],
        singular_at="edge",
    )
