"""Equivalent one-dimensional profiles of axisymmetric and nearly axisymmetric bodies.

The rule that is exact for every axisymmetric section f(r) with a circular contact is the MDR (Abel)
transform g(x) = x int_0^x f'(r)/sqrt(x^2 - r^2) dr (Popov & Hess 2015; Galin 1946, Sneddon 1965).
The chapter's "half the radius of curvature" (19.17) is its special case for the parabola and the
cylinder; applied to other shapes, as the sentence after (19.17) suggests, it is `half_radius` and
is wrong by a factor measured by this suite (pi/4 for the cone).
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.special import poch

from reduced.errors import positive_faults, refuse
from reduced.profiles.section import Profile, Section
from reduced.profiles.table import tabulated
from reduced.profiles.transform import from_function, inverse_transform

__all__ = [
    "Profile",
    "Section",
    "cone",
    "cylinder",
    "ellipsoid",
    "equivalent_punch",
    "from_function",
    "half_radius",
    "inverse_transform",
    "paraboloid",
    "power_law",
    "pyramid",
    "rounded_punch",
    "sphere",
    "tabulated",
]


def paraboloid(radius: float) -> Profile:
    """Paraboloid f = r^2/(2 R): g = x^2/R, the parabola of half the radius (19.17).

    >>> float(paraboloid(4.0).contact_radius(1.0))  # Hertz: a = sqrt(R d)
    2.0
    """
    refuse(positive_faults(radius=radius))
    section = _power_section("paraboloid", 2.0, 0.5 / radius, radius)
    return Profile(
        "paraboloid",
        height=lambda x: x * x / radius,
        slope=lambda x: 2 * x / radius,
        curvature=lambda x: np.full(np.shape(x), 2 / radius),
        length=radius,
        inverse=lambda d: np.sqrt(radius * d),
        abel_integral=lambda r, a: 2 / radius * np.sqrt((a - r) * (a + r)),
        section=section,
    )


def sphere(radius: float) -> Profile:
    """Sphere f = R - sqrt(R^2 - r^2): g = (x/2) ln((R + x)/(R - x)) (Segedin 1957).

    The height is infinite from x = R on, so the contact radius is always below R. The underlying
    linear theory requires a << R.
    """
    refuse(positive_faults(radius=radius))

    def height(x: np.ndarray) -> np.ndarray:
        return _below(x, radius, lambda t: radius * t * np.arctanh(t))

    def slope(x: np.ndarray) -> np.ndarray:
        return _below(x, radius, lambda t: np.arctanh(t) + t / ((1 - t) * (1 + t)))

    def curvature(x: np.ndarray) -> np.ndarray:
        return _below(x, radius, lambda t: 2 / (radius * ((1 - t) * (1 + t)) ** 2))

    section = Section(
        "sphere",
        height=lambda r: r * r / (radius + np.sqrt(np.maximum(radius - r, 0) * (radius + r))),
        slope=lambda r: _below(r, radius, lambda t: t / np.sqrt((1 - t) * (1 + t))),
        curvature=lambda r: _below(r, radius, lambda t: ((1 - t) * (1 + t)) ** -1.5 / radius),
        length=radius,
        edge=radius,
    )
    return Profile("sphere", height, slope, curvature, length=radius, section=section)


def cone(slope: float) -> Profile:
    """Cone f = r tan(theta), tan(theta) its slope: g = (pi/2) tan(theta) x (Sneddon 1965).

    >>> float(cone(2 / np.pi).contact_radius(3.0))
    3.0
    """
    refuse(positive_faults(slope=slope))
    factor = np.pi / 2 * slope
    return Profile(
        "cone",
        height=lambda x: factor * x,
        slope=lambda x: np.full(np.shape(x), factor),
        curvature=lambda x: np.zeros(np.shape(x)),
        length=1.0,
        inverse=lambda d: d / factor,
        # arcosh(a/r), accurate for r close to a; large, not inf, at r = 0
        abel_integral=lambda r, a: (
            factor
            * np.arcsinh(np.sqrt((a - r) * (a + r)) / np.maximum(r, np.finfo(float).tiny * a))
        ),
        section=_power_section("cone", 1.0, slope, 1.0),
    )


def power_law(exponent: float, coefficient: float) -> Profile:
    """Power law f = c r^n, n > 0: g = kappa_n c x^n (Popov & Hess 2015; Galin 1946).

    kappa_n = (sqrt(pi)/2) n Gamma(n/2)/Gamma((n+1)/2): pi/2, 2, 3 pi/4, 8/3 for n = 1 ... 4. Below
    n = 1 the tip is a cusp and the springs converge only as dx^(1+n).
    """
    refuse(positive_faults(exponent=exponent, coefficient=coefficient))
    n = float(exponent)
    kappa = np.sqrt(np.pi) / 2 * n / poch(n / 2, 0.5)
    # the length at which c r^n has height r, the only length scale (the cone has none)
    logarithm = 0.0 if n == 1 else np.log(coefficient) / (1 - n)
    length = float(np.exp(np.clip(logarithm, -200, 200)))
    section = _power_section("power_law", n, coefficient, length)
    curve = _power_section("power_law", n, kappa * coefficient, section.length)
    # The root is taken of a length scaled by a power of two, independent of units.
    unit = 2.0 ** round(np.log2(section.length))
    scaled = kappa * (coefficient * unit ** (n - 1))

    return Profile(
        **vars(curve),
        inverse=lambda d: unit * (d / unit / scaled) ** (1 / n),
        section=section,
    )


def cylinder(radius: float) -> Profile:
    """Flat circular punch: g = 0 up to the sharp edge at x = radius (19.13)."""
    refuse(positive_faults(radius=radius))
    flat = Section(
        "cylinder",
        height=lambda x: np.where(np.asarray(x) <= radius, 0.0, np.inf),
        slope=lambda x: np.zeros(np.shape(x)),
        curvature=lambda x: np.zeros(np.shape(x)),
        length=radius,
        edge=radius,
    )
    return Profile(
        **vars(flat),
        inverse=lambda d: np.full(np.shape(d), radius),
        abel_integral=lambda r, a: np.zeros(np.shape(r)),
        section=flat,
    )


def rounded_punch(flat_radius: float, edge_radius: float) -> Profile:
    """Punch flat to b, then f = (r - b)^2/(2 R) (Schubert 1942; Ciavarella et al. 1999).

    g = (x/R) [sqrt(x^2 - b^2) - b arccos(b/x)] for x > b, else 0.
    """
    refuse(positive_faults(flat_radius=flat_radius, edge_radius=edge_radius))
    b, radius = float(flat_radius), float(edge_radius)

    def height(x: np.ndarray) -> np.ndarray:
        # t - arctan(t), by its series where the difference cancels
        t = _beyond(x, b) / b
        small = np.minimum(t, 0.5) ** 2
        series = np.zeros_like(small)
        for k in range(26, 0, -1):
            series = small * ((-1) ** (k + 1) / (2 * k + 1) + series)
        return x * b / radius * np.where(t < 0.5, t * series, t - np.arctan(t))

    def slope(x: np.ndarray) -> np.ndarray:
        w = _beyond(x, b)
        return (2 * w - b * np.arctan(w / b)) / radius

    def curvature(x: np.ndarray) -> np.ndarray:
        w = _beyond(x, b)
        safe = np.where(w > 0, w, 1.0)
        return np.where(w > 0, (2 * x / safe - b / np.maximum(x, b) * b / safe) / radius, 0.0)

    section = Section(
        "rounded_punch",
        height=lambda r: np.maximum(r - b, 0.0) ** 2 / (2 * radius),
        slope=lambda r: np.maximum(r - b, 0.0) / radius,
        curvature=lambda r: np.where(np.asarray(r) > b, 1 / radius, 0.0),
        length=b,
        breakpoints=(b,),
    )
    return Profile("rounded_punch", height, slope, curvature, b, (b,), section=section)


def ellipsoid(radius_x: float, radius_y: float) -> Profile:
    """Paraboloid with two radii of curvature, replaced by their Gaussian mean sqrt(Rx Ry).

    An approximation, 1 % low in force at equal penetration for Rx/Ry = 2 (the chapter's rule after
    (19.17), Johnson 1985 sec. 4.2).
    """
    refuse(positive_faults(radius_x=radius_x, radius_y=radius_y))
    return replace(paraboloid(float(np.sqrt(radius_x) * np.sqrt(radius_y))), name="ellipsoid")


def pyramid(slope: float, sides: int = 4) -> Profile:
    """Regular pyramid, replaced by the cone of equal sectional areas.

    An approximation: the section at height h is n tan(pi/n) (h/slope)^2.
    """
    refuse(positive_faults(slope=slope))
    like = slope * float(np.sqrt(np.pi / (sides * np.tan(np.pi / sides))))
    return replace(cone(like), name="pyramid")


def equivalent_punch(area: float) -> Profile:
    """Circular punch of the same area for any flat punch: D = (4 A/pi)^(1/2).

    The chapter claims a stiffness within 3 % for squares and triangles; the square is stiffer than
    this punch by a factor of 1.0212.
    """
    refuse(positive_faults(area=area))
    return replace(cylinder(float(np.sqrt(area / np.pi))), name="equivalent_punch")


def half_radius(section: Section) -> Profile:
    """Return the profile by the chapter's rule: the section with half its radius of curvature.

    g(x) = 2 f(x), since halving the radius of curvature doubles f''. Exact for the paraboloid and
    the cylinder only ((19.17) and the sentence after it); for the power law n the exact factor is
    kappa_n, so the cone's d at equal a is 4/pi times too large. A separate function, so that the
    rule can be tested as printed.

    >>> chapter = half_radius(cone(0.5).section)
    >>> float(chapter.height(np.array(3.0)))
    3.0
    """
    curvature = section.curvature
    return Profile(
        section.name,
        height=lambda x: 2 * section.height(x),
        slope=lambda x: 2 * section.slope(x),
        curvature=None if curvature is None else lambda x: 2 * curvature(x),
        length=section.length,
        breakpoints=section.breakpoints,
        edge=section.edge,
        section=section,
    )


def _power_section(name: str, n: float, c: float, length: float) -> Section:
    """Return the cross-section c r^n with its derivatives, which may be infinite at the tip."""

    def scaled_power(r: np.ndarray, factor: float, exponent: float) -> np.ndarray:
        if factor == 0 or exponent == 0:
            return np.full(np.shape(r), factor)
        with np.errstate(divide="ignore"):
            return factor * np.asarray(r, dtype=float) ** exponent

    return Section(
        name,
        height=lambda r: scaled_power(r, c, n),
        slope=lambda r: scaled_power(r, n * c, n - 1),
        curvature=lambda r: scaled_power(r, n * (n - 1) * c, n - 2),
        length=length,
    )


def _below(x: np.ndarray, radius: float, function) -> np.ndarray:
    """Return function(x/radius) for x < radius, inf beyond."""
    t = np.asarray(x, dtype=float) / radius
    return np.where(t < 1, function(np.where(t < 1, t, 0.0)), np.inf)


def _beyond(x: np.ndarray, b: float) -> np.ndarray:
    """Return sqrt(x^2 - b^2) without cancellation, 0 for x <= b."""
    return np.sqrt(np.maximum(np.asarray(x, dtype=float) - b, 0.0) * (x + b))
