"""Equivalent profile of any axisymmetric body, by the MDR (Abel) transform of its section.

With r = x sin(t) the transform and its derivatives have no singular kernel:

    g(x)   = x int_0^(pi/2) f'(r) dt
    g'(x)  =   int_0^(pi/2) m(r) dt + sum_b [f']_b b / sqrt(x^2 - b^2),   m = (r f')' = f' + r f''
    g''(x) =   int_0^(pi/2) m'(r) sin(t) dt + sum_b { [m]_b b / (x sqrt(x^2 - b^2))
                                                     - [f']_b b x / (x^2 - b^2)^(3/2) }

where [.]_b is a jump at the breakpoint b < x (Popov & Hess 2015, ch. 3). Integrals are taken
between the breakpoints, so kinks cause no loss of accuracy. For graded half-spaces
(`springs.layers`) all of them have a weight cos(t)^k, and jumps have (sqrt(x^2 - b^2)/x)^k.
"""

import numpy as np
from scipy.special import beta

from reduced.errors import refuse
from reduced.profiles.quadrature import integrate_panels
from reduced.profiles.section import Curve, Profile, Section

_STENCIL = np.array([672.0, -168.0, 32.0, -3.0]) / 840.0  # eighth-order first derivative
_STENCIL_STEP = 0.02  # fraction of the distance to the nearest breakpoint: truncation near 1e-11


def from_function(
    f_prime: Curve,
    length: float,
    breakpoints: tuple[float, ...] = (),
    *,
    f_second: Curve | None = None,
    edge: float = np.inf,
) -> Profile:
    """Equivalent profile of the section with slope f'(r), by quadrature to 1e-12.

    f'(r) >= 0 on arrays may jump at the breakpoints, all r > 0 at which a derivative of f jumps
    (ConvergenceError if one is missing), and be singular, integrably, there or at 0. f''(r) is by
    default an eighth-order difference of f' (about 1e-11 relative), with a stencil of 8 % of the
    distance to the nearest breakpoint or edge. `length` is a typical radius of the body, `edge`
    that at which it ends in a sharp edge.

    >>> cubic = from_function(lambda r: 3 * r**2, length=1.0)
    >>> bool(abs(cubic.height(np.array([1.0]))[0] - 0.75 * np.pi) < 1e-12)
    True
    """
    marks = tuple(sorted(float(b) for b in breakpoints))
    wrong = [
        f"{k} must be positive, got {v!r}"
        for k, v in (("length", length), ("edge", edge), ("breakpoints", min(marks, default=1.0)))
        if not v > 0
    ]
    refuse(wrong)
    return _profile("function", f_prime, f_second, float(length), marks, float(edge), 0.0)


def weighted(section: Section, power: float) -> Profile:
    """Return the profile of a section by the transform with the weight cos(t)^power, power > -1."""
    marks = tuple(b for b in section.breakpoints if b < section.edge)
    slopes = section.slope, section.curvature
    return _profile(section.name, *slopes, section.length, marks, section.edge, power)


def _profile(
    name: str,
    first: Curve,
    second: Curve | None,
    length: float,
    marks: tuple[float, ...],
    edge: float,
    power: float,
) -> Profile:
    """Return the profile of f' and f'' (None: unknown), a typical length, the kinks, the edge."""
    nodes = np.array([0.0, *marks, edge])
    bend = second or _relative_difference(first, nodes)
    jumps = []
    for b in marks:  # from the adjacent numbers; for smooth functions the difference is rounding
        before, after = np.asarray(first(np.array([b * (1 - 1e-15), b * (1 + 1e-15)])), dtype=float)
        kinked = abs(after - before) > 1e-13 * max(abs(before), abs(after))
        jumps.append((b, after - before if kinked else 0.0))
    whole = float(beta((1 + power) / 2, 0.5) / 2)  # int_0^(pi/2) cos(t)^power dt

    def transform(function: Curve, x: np.ndarray) -> np.ndarray:
        return _transform(function, np.ravel(x), np.array(marks), power).reshape(np.shape(x))

    def height(x: np.ndarray) -> np.ndarray:
        x = np.asarray(x, dtype=float)
        inside = np.minimum(x, edge)
        regular = np.where(x > 0, inside * transform(first, inside), 0.0)
        return np.where(x <= edge, regular, np.inf)

    def kink(x: np.ndarray, b: float) -> np.ndarray:
        # b/sqrt(x^2 - b^2) (sqrt(x^2 - b^2)/x)^power beyond the kink at b, else 0
        square = np.maximum(x - b, 0.0) * (x + b)
        root = np.sqrt(np.where(square > 0, square, 1.0))
        return np.where(square > 0, b / root * (root / np.maximum(x, b)) ** power, 0.0)

    def slope(x: np.ndarray) -> np.ndarray:
        x = np.minimum(np.asarray(x, dtype=float), edge)
        regular = transform(lambda r: first(r) + r * bend(r), x)
        regular = np.where(x > 0, regular, whole * first(np.zeros(1)))
        return regular + sum(kink(x, b) * jump for b, jump in jumps)

    curvature = _relative_difference(slope, nodes)
    return Profile(name, height, slope, curvature, length, marks, edge)


def inverse_transform(profile: Profile, r: np.ndarray) -> np.ndarray:
    """Return the cross-section f(r) of the axisymmetric body with a given equivalent profile.

    f(r) = (2/pi) int_0^r g(x)/sqrt(r^2 - x^2) dx = (2/pi) int_0^(pi/2) g(r sin t) dt

    to about 1e-12 (Popov & Hess 2015, ch. 3; the Abel inversion of the transform); inf beyond the
    profile's sharp edge. It needs only g, so it also applies to profiles from other rules, such as
    half the radius or the Gaussian radius.

    >>> from reduced.profiles.equivalents import cone, half_radius
    >>> f = inverse_transform(half_radius(cone(0.5).section), np.array([1.0]))
    >>> bool(abs(f[0] - 2 / np.pi) < 1e-12)  # the chapter's rule stands for a cone 4/pi as steep
    True
    """
    r = np.asarray(r, dtype=float)
    if not (np.all(np.isfinite(r)) and np.all(r >= 0)):
        raise ValueError(f"r must be finite and >= 0, got {r}")
    inside = r.ravel() <= profile.edge
    f = np.full(r.size, np.inf)
    radii = np.minimum(r.ravel()[inside], profile.edge)
    f[inside] = 2 / np.pi * _transform(profile.height, radii, np.array(profile.breakpoints))
    return f.reshape(r.shape)


def _transform(function: Curve, x: np.ndarray, marks: np.ndarray, power: float = 0.0) -> np.ndarray:
    """Return int_0^(pi/2) function(x sin t) cos(t)^power dt between breakpoints; 0 at x = 0."""
    safe = np.where(x > 0, x, 1.0)
    inner = np.arcsin(np.minimum(marks / safe[:, None], 1.0))
    ends = np.column_stack([np.zeros(x.size), inner, np.full(x.size, np.pi / 2)])

    def integrand(t: np.ndarray, row: np.ndarray) -> np.ndarray:
        value = function(safe[row] * np.sin(t))
        return value * np.cos(t) ** power if power else value

    return np.where(x > 0, integrate_panels(integrand, ends[:, :-1], ends[:, 1:]), 0.0)


def _relative_difference(function: Curve, nodes: np.ndarray) -> Curve:
    """Return the derivative by central differences with steps relative to the breakpoints."""

    def derivative(x: np.ndarray) -> np.ndarray:
        x = np.asarray(x, dtype=float)
        after = np.clip(np.searchsorted(nodes, x, side="right"), 1, nodes.size - 1)
        distance = np.minimum(x - nodes[after - 1], np.abs(nodes[after] - x))
        step = _STENCIL_STEP * np.where(
            distance > 0, distance, nodes[1] if nodes[1] < np.inf else 1
        )
        total = np.zeros_like(x)
        for k, weight in enumerate(_STENCIL, start=1):
            total += weight * (function(x + k * step) - function(np.abs(x - k * step)))
        return np.where(distance > 0, total / step, 0.0)

    return derivative
