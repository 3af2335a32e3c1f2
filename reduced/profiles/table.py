"""Equivalent profile of a section given as a table: exact on every segment."""

from __future__ import annotations

import numpy as np
from numba import njit
from scipy.interpolate import PchipInterpolator, PPoly
from scipy.special import elliprf

from reduced.errors import choice_faults, refuse
from reduced.profiles.quadrature import double_exponential, gauss_legendre
from reduced.profiles.section import Profile, Section

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
    end, nodes, length = float(r[-1]), r[1:-1], float(r[-1])
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
        inside = np.minimum(x, end)
        return np.where(x <= end, inside * _transform([slope], inside, r)[0], np.inf)

    def profile_slope(x: np.ndarray) -> np.ndarray:
        x = np.minimum(x, end)
        first, second_part = _transform([slope, second], x, r)
        kinks = _per_node(x, nodes, lambda x, b, root: b / root) @ slope_jump
        return first + x * second_part + kinks

    def curvature(x: np.ndarray) -> np.ndarray:
        x = np.minimum(x, end)
        of_second, of_third = _transform([second, third], x, r, power=1)
        kinks = _per_node(x, nodes, lambda x, b, root: b / (x * root)) @ moment_jump
        kinks -= _per_node(x, nodes, lambda x, b, root: b * x / root**3) @ slope_jump
        return 2 * of_second + x * of_third + kinks

    def abel_integral(radii: np.ndarray, a: float) -> np.ndarray:
        return np.array([_pressure_integral(s, a, slope, second, r, slope_jump) for s in radii])

    section = Section(
        "tabulated",
        height=lambda x: np.where(x <= end, curve(np.minimum(x, end)), np.inf),
        slope=lambda x: slope(np.minimum(x, end)),
        curvature=lambda x: second(np.minimum(x, end)),
        length=length,
        breakpoints=tuple(map(float, nodes)),
        edge=end,
    )
    return Profile(
        "tabulated",
        height,
        profile_slope,
        curvature,
        length,
        section.breakpoints,
        end,
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


def _pressure_integral(
    s: float, a: float, slope: PPoly, second: PPoly, r: np.ndarray, slope_jump: np.ndarray
) -> float:
    """Return the integral of g'(x)/sqrt(x^2 - s^2) from s to a, with exchanged integrations.

    g'(x) = int_0^x m(t)/sqrt(x^2 - t^2) dt transforms it to int_0^a m(t) K(t, s) dt with an
    elliptic kernel, logarithmically singular at t = s.
    """
    nodes, weights = double_exponential(4)
    ends = np.unique(np.concatenate([r[r < a], [a], [s] if s > 0 else []]))
    lower, width = ends[:-1, None], np.diff(ends)[:, None]
    t = np.minimum(lower + width * nodes, ends[1:, None])
    segment = np.searchsorted(r, lower[:, 0], side="right") - 1
    offset = t - r[segment][:, None]
    moment = np.zeros_like(t)
    for polynomial, factor in ((slope, 1.0), (second, t)):
        values = np.zeros_like(t)
        for c in polynomial.c:
            values = values * offset + c[segment][:, None]
        moment = moment + factor * values
    # Distance to s from the panel's end, accurate for t close to s.
    apart = np.where(lower >= s, lower - s + width * nodes, s - t)
    total = float((moment * _kernel(t, s, a, apart) * width * weights).sum())
    inner = r[1:-1]
    kinks = (slope_jump != 0) & (inner < a)
    b = inner[kinks]
    if np.any(b == s):
        return np.inf
    return total + float((slope_jump[kinks] * b * _kernel(b, s, a, np.abs(b - s))).sum())


def _kernel(t: np.ndarray, s: float, a: float, apart: np.ndarray) -> np.ndarray:
    """Return int 1/sqrt((x^2 - t^2)(x^2 - s^2)) dx from max(t, s) to a by Carlson's R_F."""
    larger, smaller = np.maximum(t, s), np.minimum(t, s)
    outer = (a - larger) * (a + larger)
    between = np.maximum(apart, 1e-30 * larger) * (t + s)
    far = (a - smaller) * (a + smaller)
    form = elliprf(larger**2 * far, larger**2 * between, a**2 * between)
    return np.where(outer > 0, np.sqrt(np.maximum(outer, 0.0)) * form, 0.0)
