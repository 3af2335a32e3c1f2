"""Equivalent one-dimensional profiles of axisymmetric and nearly axisymmetric bodies.

The rule that is exact for every axisymmetric section f(r) with a circular contact is the MDR (Abel)
transform g(x) = x int_0^x f'(r)/sqrt(x^2 - r^2) dr (Popov & Hess 2015; Galin 1946, Sneddon 1965).
The chapter's "half the radius of curvature" (19.17) is its special case for the parabola and the
cylinder; applied to other shapes, as the sentence after (19.17) suggests, it is `half_radius` and
is wrong by a factor measured by this suite (pi/4 for the cone).
"""

from dataclasses import replace

import numpy as np
from numba import njit
from scipy.interpolate import PchipInterpolator, PPoly
from scipy.special import elliprf, poch

from reduced.errors import choice_faults, positive_faults, refuse
from reduced.profiles.quadrature import double_exponential, gauss_legendre
from reduced.profiles.section import Profile, Section


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
        **vars(curve), inverse=lambda d: unit * (d / unit / scaled) ** (1 / n), section=section
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
    kappa_n, so the cone's d at equal a is 4/pi times too large.

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


# Gauss rules for cubics in sin(t), exact to rounding over a quarter turn and over a narrow segment.
_WIDE, _NARROW = gauss_legendre(10), gauss_legendre(5)
_NARROW_TURN = 0.15  # radians: the fifth rule's error is (0.15/2)^10/10!, and some
_SAMPLES = 12  # samples per segment in the check for monotonicity


def tabulated(r: np.ndarray, f: np.ndarray, interpolation: str = "pchip") -> Profile:
    """Return the equivalent profile of a tabulated axisymmetric body, with a sharp edge at its end.

    The table starts at r = 0, f = 0, increases strictly in r, and does not decrease in f. Segments
    are polynomials, monotone cubics ("pchip", continuous slope) or straight ("linear"); with
    r = x sin(t) their Abel integrals are trigonometric polynomials, which a Gauss rule per segment
    integrates to rounding, without the cancellation of primitives.

    >>> wedge = tabulated([0.0, 1.0, 2.0], [0.0, 1.0, 2.0], "linear")
    >>> round(float(wedge.height(np.array(2.0))), 12)
    3.14159265359
    """
    r, f = np.asarray(r, dtype=float), np.asarray(f, dtype=float)
    wrong = choice_faults("interpolation", interpolation, ("pchip", "linear"))
    if r.ndim != 1 or f.shape != r.shape or r.size < 2:
        wrong.append(f"r and f must be 1-D of equal length >= 2, got {r.shape} and {f.shape}")
    elif not (np.all(np.isfinite(r)) and np.all(np.isfinite(f))):
        wrong.append("r and f must be finite")
    else:
        if r[0] != 0 or f[0] != 0:
            wrong.append(f"the table must start at r = 0, f = 0, got r = {r[0]}, f = {f[0]}")
        if np.any(np.diff(r) <= 0):
            at = int(np.argmax(np.diff(r) <= 0))
            wrong.append(f"r must increase strictly, got {r[at]}, {r[at + 1]}")
        if np.any(np.diff(f) < 0):
            at = int(np.argmax(np.diff(f) < 0))
            wrong.append(
                f"f must not decrease (hollow behind r = {r[at]}: {f[at]} then {f[at + 1]}); "
                "the reduced model holds for compact contacts only"
            )
    refuse(wrong)
    smooth = interpolation == "pchip" and r.size > 2
    segments = np.array([np.diff(f) / np.diff(r), f[:-1]])
    profile = _profile(PchipInterpolator(r, f) if smooth else PPoly(segments, r), r)
    # g must not fall anywhere, on samples that cluster behind the nodes
    inside = (np.arange(1, _SAMPLES + 1) / _SAMPLES) ** 3
    x = (r[:-1, None] + np.diff(r)[:, None] * inside).ravel()
    g = np.concatenate([[0.0], profile.height(x)])
    falls = np.diff(g) < -1e-12 * g[-1]
    if falls.any():
        fall = float(x[int(np.argmax(falls))])
        raise ValueError(
            f"the equivalent profile falls at x = {fall:.6g}: the flank flattens out so quickly "
            "(or kinks inwards) that the contact would be a ring, and the reduced model holds for "
            "compact contacts only; a smooth table or interpolation = 'pchip' may help"
        )
    return profile


def _profile(curve: PPoly, r: np.ndarray) -> Profile:
    """Return the profile of f, with m = (r f')' and the jumps of f' and m at the nodes."""
    slope, second, third = curve.derivative(), curve.derivative(2), curve.derivative(3)
    length, nodes = float(r[-1]), r[1:-1]
    # jumps of f' and of m = f' + r f'' at the inner nodes
    slope_jump = moment_jump = nodes
    if nodes.size:
        inner = np.nextafter(nodes, 0)
        left, bend = (PPoly(p.c[:, :-1], p.x[:-1])(inner) for p in (slope, second))
        slope_jump = slope(nodes) - left
        # slopes of pchip are continuous by construction; differences are rounding, not kinks
        slope_jump[np.abs(slope_jump) <= 1e-12 * np.abs(slope(nodes))] = 0.0
        moment_jump = slope_jump + nodes * (second(nodes) - bend)

    def height(x: np.ndarray) -> np.ndarray:
        inside = np.minimum(x, length)
        return np.where(x <= length, inside * _transform([slope], inside, r)[0], np.inf)

    def profile_slope(x: np.ndarray) -> np.ndarray:
        x = np.minimum(x, length)
        first, second_part = _transform([slope, second], x, r)
        kinks = _per_node(x, nodes, lambda x, b, root: b / root) @ slope_jump
        return first + x * second_part + kinks

    def curvature(x: np.ndarray) -> np.ndarray:
        x = np.minimum(x, length)
        of_second, of_third = _transform([second, third], x, r, power=1)
        kinks = _per_node(x, nodes, lambda x, b, root: b / (x * root)) @ moment_jump
        kinks -= _per_node(x, nodes, lambda x, b, root: b * x / root**3) @ slope_jump
        return 2 * of_second + x * of_third + kinks

    def pressure_integral(s: float, a: float) -> float:
        # Of g'(x)/sqrt(x^2 - s^2) from s to a, with exchanged integrations: g'(x) = int_0^x
        # m(t)/sqrt(x^2 - t^2) dt transforms it to int_0^a m(t) K(t, s) dt with an elliptic kernel,
        # logarithmically singular at t = s.
        unit, weights = double_exponential(4)
        ends = np.unique(np.concatenate([r[r < a], [a], [s] if s > 0 else []]))
        lower, width = ends[:-1, None], np.diff(ends)[:, None]
        t = np.minimum(lower + width * unit, ends[1:, None])
        segment = np.searchsorted(r, lower[:, 0], side="right") - 1
        offset = t - r[segment][:, None]
        moment = np.zeros_like(t)
        for polynomial, factor in ((slope, 1.0), (second, t)):
            values = np.zeros_like(t)
            for c in polynomial.c:
                values = values * offset + c[segment][:, None]
            moment = moment + factor * values
        # Distance to s from the panel's end, accurate for t close to s.
        apart = np.where(lower >= s, lower - s + width * unit, s - t)
        total = float((moment * _kernel(t, s, a, apart) * width * weights).sum())
        kinks = (slope_jump != 0) & (nodes < a)
        b = nodes[kinks]
        if np.any(b == s):
            return np.inf
        return total + float((slope_jump[kinks] * b * _kernel(b, s, a, np.abs(b - s))).sum())

    def abel_integral(radii: np.ndarray, a: float) -> np.ndarray:
        return np.array([pressure_integral(s, a) for s in radii])

    section = Section(
        "tabulated",
        height=lambda x: np.where(x <= length, curve(np.minimum(x, length)), np.inf),
        slope=lambda x: slope(np.minimum(x, length)),
        curvature=lambda x: second(np.minimum(x, length)),
        length=length,
        breakpoints=tuple(map(float, nodes)),
        edge=length,
    )
    return Profile(
        "tabulated",
        height,
        profile_slope,
        curvature,
        length,
        section.breakpoints,
        length,
        abel_integral=abel_integral,
        section=section,
    )


def _transform(functions: list[PPoly], x: np.ndarray, r: np.ndarray, power: int = 0) -> np.ndarray:
    """Return integrals of function(x sin t) sin(t)^power over a quarter turn, one per function.

    The power increases by one from function to function, as the slope of the section, its second
    derivative times r and its third times r^2 enter the derivatives of the transform.
    """
    degree = max(len(function.c) for function in functions)
    coefficients = np.zeros((len(functions), r.size - 1, degree))
    for coefficient, function in zip(coefficients, functions, strict=True):
        coefficient[:, degree - len(function.c) :] = function.c.T
    flat = np.ravel(np.asarray(x, dtype=float))
    totals = np.zeros((len(functions), flat.size))
    _quarter_turns(flat, r, coefficients, power, (_WIDE, _NARROW), totals)
    return totals.reshape(len(functions), *np.shape(x))


@njit(cache=True, error_model="numpy")
def _quarter_turns(x, r, coefficients, power, rules, totals):
    """Return the integrals, summed over segments by a rule that is exact to rounding."""
    count, segments, degree = coefficients.shape
    wide, narrow = rules
    for i in range(x.size):
        begin = 0.0
        for j in range(segments):
            # The angle at which x sin(t) leaves the segment, accurate near the node.
            end = np.pi / 2
            if r[j + 1] < x[i]:
                end = np.arctan2(r[j + 1], np.sqrt((x[i] - r[j + 1]) * (x[i] + r[j + 1])))
            width = end - begin
            nodes, weights = wide if width > _NARROW_TURN else narrow
            for k in range(nodes.size):
                sine = np.sin(begin + width * nodes[k])
                offset = max(x[i] * sine - r[j], 0.0)
                factor = weights[k] * width * sine**power
                for n in range(count):
                    value = 0.0
                    for c in range(degree):
                        value = value * offset + coefficients[n, j, c]
                    totals[n, i] += factor * value
                    factor *= sine
            if r[j + 1] >= x[i]:
                break
            begin = end


def _per_node(x: np.ndarray, nodes: np.ndarray, function) -> np.ndarray:
    """Return function(x, b, sqrt(x^2 - b^2)) for every x and node b < x, 0 for other nodes."""
    x = np.asarray(x, dtype=float)[..., None]
    square = np.maximum(x - nodes, 0.0) * (x + nodes)
    root = np.sqrt(np.where(square > 0, square, 1.0))
    return np.where(square > 0, function(np.where(x > 0, x, 1.0), nodes, root), 0.0)


def _kernel(t: np.ndarray, s: float, a: float, apart: np.ndarray) -> np.ndarray:
    """Return int 1/sqrt((x^2 - t^2)(x^2 - s^2)) dx from max(t, s) to a by Carlson's R_F."""
    larger, smaller = np.maximum(t, s), np.minimum(t, s)
    outer = (a - larger) * (a + larger)
    between = np.maximum(apart, 1e-30 * larger) * (t + s)
    far = (a - smaller) * (a + smaller)
    form = elliprf(larger**2 * far, larger**2 * between, a**2 * between)
    return np.where(outer > 0, np.sqrt(np.maximum(outer, 0.0)) * form, 0.0)
