"""Flat circular punches with a sharp and with a rounded edge."""

from __future__ import annotations

import numpy as np

from reference.closed_form.form import Array, ClosedForm, Formulas, require_positive
from reference.closed_form.numerics import gauss, minus_arctan, solve_increasing


def cylinder(radius: float, effective_modulus: float) -> ClosedForm:
    """Flat-ended circular punch of radius a.

    F = 2 E* a d,  p = F/(2 pi a sqrt(a^2 - r^2)),  U = E* a d^2
    (Boussinesq 1885; Johnson 1985, section 3.4). The pressure is infinite at the edge; the
    contact area is pi a^2 from the first touch on.

    Parameters
    ----------
    radius, effective_modulus : float
        a and E*, positive, in consistent units.

    Examples
    --------
    >>> float(cylinder(radius=1.0, effective_modulus=1.0).force(0.25))
    0.5
    """
    require_positive("cylinder", radius=radius, effective_modulus=effective_modulus)
    a, E = float(radius), float(effective_modulus)
    return Formulas(
        "cylinder",
        "Boussinesq 1885; Johnson 1985, section 3.4",
        force=lambda d: 2 * E * a * d,
        penetration=lambda F: F / (2 * E * a),
        semi_axes=lambda d: (np.full_like(d, a)[()],) * 2,
        stiffness=lambda d: np.full_like(d, 2 * E * a)[()],
        energy=lambda d: E * a * d * d,
        pressure=lambda rho, d: E / np.pi * (d / a) / np.sqrt((1 - rho) * (1 + rho)),
        singular_at="edge",
        singular_edge=(a, a),
    ).closed_form()


def rounded_punch(flat_radius: float, edge_radius: float, effective_modulus: float) -> ClosedForm:
    """Flat circular punch with a parabolic edge: f = 0 to r = b, then (r - b)^2/(2R).

    With t = sqrt(a^2 - b^2)/b and s(x) = sqrt(x^2 - b^2),

    d = (b^2/R) sqrt(1+t^2) (t - arctan t),  F = (E* b^3/R) [t^3/3 + (1+t^2)(t - arctan t)],
    p(r) = (E*/(pi R)) int_max(b,r)^a (2 s - b arctan(s/b))/sqrt(x^2 - r^2) dx

    (Schubert 1942; Ejike 1981; Popov, Hess & Willert 2019, chapter 2, there in the angle
    phi = arctan t, whose terms cancel while d << b^2/R; here all terms are positive). The pressure
    integral is evaluated by Gauss quadrature in a logarithmic variable that removes the
    near-singularity at r = b (relative accuracy 1e-12).

    Parameters
    ----------
    flat_radius, edge_radius, effective_modulus : float
        b, R and E*, positive, in consistent units.

    Examples
    --------
    >>> punch = rounded_punch(flat_radius=1.0, edge_radius=1.0, effective_modulus=1.0)
    >>> bool(punch.contact_radius(0.01) > 1.0)
    True
    """
    require_positive(
        "rounded_punch",
        flat_radius=flat_radius,
        edge_radius=edge_radius,
        effective_modulus=effective_modulus,
    )
    b, R, E = float(flat_radius), float(edge_radius), float(effective_modulus)
    depth = b / R * b

    def edge(d: Array) -> Array:
        relative = d / depth
        guess = np.minimum(np.cbrt(3 * relative), np.sqrt(relative) + 1)
        return solve_increasing(_rounded_depth, relative, guess)

    def contact_radius(d: Array) -> Array:
        return b * np.hypot(1.0, edge(d))

    def penetration(F: Array) -> Array:
        relative = F / E / depth / b
        t = solve_increasing(_rounded_force, relative, np.cbrt(relative))
        return depth * _rounded_depth(t)[0]

    def energy(d: Array) -> Array:
        # U = E* int_0^a (d - g)^2 dx, with x = b cosh(q) beyond the flat.
        t, relative = edge(d), d / depth
        outer = gauss(
            lambda q: (relative - _rounded_depth(np.sinh(q))[0]) ** 2 * np.sinh(q),
            0 * t,
            np.arcsinh(t),
            panels=4,
        )
        return E * b * depth * depth * (relative**2 + outer)

    return Formulas(
        "rounded_punch",
        "Schubert 1942; Ejike 1981; Popov, Hess & Willert 2019, chapter 2",
        force=lambda d: E * depth * b * _rounded_force(edge(d))[0],
        penetration=penetration,
        semi_axes=lambda d: (contact_radius(d),) * 2,
        stiffness=lambda d: 2 * E * contact_radius(d),
        energy=energy,
        pressure=lambda rho, d: E / np.pi * (b / R) * _rounded_integral(rho, edge(d)),
    ).closed_form()


def _rounded_depth(t: Array) -> tuple[Array, Array]:
    """Return d R/b^2 and its derivative, as functions of t = sqrt(a^2 - b^2)/b."""
    a = np.hypot(1.0, t)
    lag = minus_arctan(t)
    return a * lag, t * (lag + t) / a


def _rounded_force(t: Array) -> tuple[Array, Array]:
    """Return F R/(E* b^3) and its derivative, as functions of t."""
    lag = minus_arctan(t)
    return t**3 / 3 + (1 + t * t) * lag, 2 * t * (lag + t)


def _rounded_integral(rho: Array, t: Array) -> Array:
    """Return pi p R/(E* b) at r = rho a, lengths in units of b.

    In q, with s = e sinh(q) inside the flat and e cosh(q) outside, e^2 = |r^2 - 1|, both the root
    at x = r and the one at x = b vanish and the integrand is (2 s - arctan s) s/x dq.
    """
    a = np.hypot(1.0, t)
    r = rho * a
    flat = r < 1
    # Below s = s0 is less than 1e-17 of the integral; e below a thousandth of s0 counts as zero.
    s0 = 3e-9 * np.sqrt(t * np.minimum(t, 1.0))
    e = np.maximum(np.sqrt(np.abs(1 - r) * (1 + r)), 1e-3 * s0)
    reach = np.where(flat, t, np.sqrt((1 - rho) * (1 + rho)) * a)
    top = np.arcsinh(reach / e)
    bottom = np.where(flat, np.arcsinh(s0 / e), np.arccosh(np.maximum(1.0, s0 / e)))

    def integrand(q: Array) -> Array:
        s = e * np.where(flat, np.sinh(q), np.cosh(q))
        return (2 * s - np.arctan(s)) * s / np.hypot(1.0, s)

    return gauss(integrand, np.minimum(bottom, top), top, panels=4)
