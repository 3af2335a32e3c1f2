"""Surface pressure from spring forces: the exact Abel inversion and the chapter's local rule."""

import numpy as np

from reduced.errors import positive_faults, refuse
from reduced.profiles.quadrature import integrate_panels
from reduced.profiles.section import Profile


def abel(
    profile: Profile, effective_modulus: float, penetration: float, r: np.ndarray
) -> np.ndarray:
    """Return the pressure at radii r under an axisymmetric body, exact for every profile.

    p(r) = (E*/pi) [ int_r^a g'(x)/sqrt(x^2 - r^2) dx + (d - g(a))/sqrt(a^2 - r^2) ]

    (Sneddon 1965; Popov, Hess & Willert 2019, ch. 2); the second term is that of a sharp edge.
    Paraboloid, cone and cylinder use closed forms, tables elliptic kernels per segment, all others
    the substitution x^2 = r^2 + w^2 and double-exponential panels (1e-12).

    >>> from reduced.profiles.equivalents import paraboloid
    >>> p = abel(paraboloid(1.0), 1.0, 0.01, np.array([0.0, 0.1]))
    >>> bool(abs(p[0] - 2 * 0.1 / np.pi) < 1e-15), float(p[1])  # p0 = 2 E* a/(pi R)
    (True, 0.0)
    """
    r, a = _check(profile, effective_modulus, penetration, r)
    inside = r < a
    pressure = np.zeros(r.shape)
    radii = r[inside]
    if not ((radii > 0) | (profile.slope(np.zeros(radii.shape)) == 0)).all():  # g'(0) = 0
        raise ValueError("the pressure is unbounded at r = 0 (a sharp tip): ask beside it")
    if profile.abel_integral is not None:
        integral = profile.abel_integral(radii, a)
    else:
        # int g'(sqrt(r^2 + w^2))/sqrt(r^2 + w^2) dw between the breakpoints
        marks = np.array([0.0, *(b for b in profile.breakpoints if b < a), a])
        ends = np.sqrt(np.maximum(marks - radii[:, None], 0.0) * (marks + radii[:, None]))

        def integrand(w: np.ndarray, row: np.ndarray) -> np.ndarray:
            # Rounding must not move x beyond a, where the profile may end, and w = 0 at r = 0 must
            # not divide.
            x = np.clip(np.hypot(radii[row], w), np.finfo(float).tiny * a, a)
            return profile.slope(x) / x

        integral = integrate_panels(integrand, ends[:, :-1], ends[:, 1:])
    integral = np.array(integral, dtype=float)
    if np.isfinite(profile.edge) and a == profile.edge:
        fall = penetration - float(profile.height(np.array(a)))
        integral += fall / np.sqrt((a - radii) * (a + radii))
    if not np.all(np.isfinite(integral)):
        at = radii[~np.isfinite(integral)]
        raise ValueError(f"the pressure is unbounded at r = {at} (a kink): ask beside it")
    pressure[inside] = effective_modulus / np.pi * integral
    return pressure


def local_rule(
    profile: Profile,
    effective_modulus: float,
    penetration: float,
    r: np.ndarray,
    spacing: float = 1.0,
) -> tuple[np.ndarray, np.ndarray]:
    """Return the pressure by the local rule (19.37), sigma = f sqrt(2)/(pi dx sqrt(delta R1)).

    f = E* dx delta is the spring force, delta = d - g(r) its deflection and R1 = 1/g''(r); dx
    cancels, and is included to show the rule as printed. Exact for the paraboloid only; for f ~ r^4
    it gives 0.18 of the pressure at r = 0.05 a and 1.7 times it at 0.9 a. Returns also where it is
    defined: not where the profile is straight or concave or its curvature is unknown (pressure 0).
    """
    r, a = _check(profile, effective_modulus, penetration, r)
    refuse(positive_faults(spacing=spacing))
    inside = r < a
    deflection = np.where(inside, penetration - profile.height(np.where(inside, r, 0.0)), 0.0)
    curvature = np.zeros(r.shape)
    if profile.curvature is not None:
        curvature[inside] = profile.curvature(r[inside])
    defined = inside & (curvature > 0) & np.isfinite(curvature) & (deflection > 0)
    radius = 1 / np.where(defined, curvature, 1.0)
    spring_force = effective_modulus * spacing * deflection
    root = np.sqrt(np.where(defined, deflection, 1.0) * radius)
    pressure = np.where(defined, spring_force * np.sqrt(2) / (np.pi * spacing * root), 0.0)
    return pressure, defined | ~inside


def one_radius_rule(
    profile: Profile, effective_modulus: float, penetration: float, r: np.ndarray
) -> np.ndarray:
    """Return the pressure by (19.37) with one radius for the whole contact, R1 = a^2/(2 d).

    R1 is that of the parabola with the contact radius and the depth of this contact ((19.15)
    inverted). The rule then has a real value everywhere in the contact, is exact for the
    paraboloid, and for the flat punch gives the uniform mean pressure 2 E* d/(pi a); the chapter
    does not say which radius applies if the curvature varies.
    """
    r, a = _check(profile, effective_modulus, penetration, r)
    inside = r < a
    depth = np.where(inside, penetration - profile.height(np.where(inside, r, 0.0)), 0.0)
    radius = a * (a / (2 * penetration))
    return effective_modulus / np.pi * np.sqrt(2 * np.maximum(depth, 0.0) / radius)


def _check(
    profile: Profile, effective_modulus: float, penetration: float, r: np.ndarray
) -> tuple[np.ndarray, float]:
    """Return radii and contact radius, or raise one ValueError with all invalid arguments."""
    r = np.asarray(r, dtype=float)
    wrong = positive_faults(effective_modulus=effective_modulus, penetration=penetration)
    if not (np.all(np.isfinite(r)) and np.all(r >= 0)):
        wrong.append(f"r must be finite and >= 0, got {r}")
    refuse(wrong)
    return r, float(profile.contact_radius(penetration))
