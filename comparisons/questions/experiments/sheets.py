"""Judges from outside: engineering sheets, a public contact code's cases, textbook shapes."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Annotated, Literal

import numpy as np
from scipy.optimize import brentq

from comparisons.questions.experiments.experiment import Between, Finding, OneOf, experiment
from reduced.friction.slide import Friction, slide, tangential_modulus
from reduced.loads import Load, LoadPath
from reduced.profiles.equivalents import from_function, paraboloid
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference import closed_form

_ROUNDING = 1e-9


@experiment(
    "sheet",
    "A number of an engineering sheet against the exact solution of its problem",
    "quantity",
)
def sheet(
    effort: str,
    *,
    quantity: Literal["nafems_radius", "nafems_pressure", "code_aster"] = "nafems_radius",
) -> Finding:
    """Compare a number of an engineering sheet with the exact half-space solution of its problem.

    ``"nafems_radius"``, ``"nafems_pressure"``: an aluminium block and a steel cylinder of radius 50
    mm, 35 kN/mm, plane strain (NAFEMS, Advanced finite element contact benchmarks, 2006): 6.21 mm,
    3585.37 MPa. ``"code_aster"``: two spheres of 50 mm, E = 20 GPa, nu = 0.3, 4 mm (SSNV104):
    p0 = 2798.3 MPa, Hertz's, at a/R = 0.2; exact is here the sphere, not its paraboloid.
    """
    if quantity == "code_aster":
        modulus = 20e3 / (2 * (1 - 0.3**2))
        # the gap is twice that of one sphere, and so are depth and pressure
        true = 2 * float(closed_form.sphere(50.0, modulus).pressure(0.0, 0.0, 2.0))
        stated = 2798.3
    else:
        modulus = 1 / ((1 - 0.3**2) * (1 / 210e3 + 1 / 70e3))
        line, radius = 35e3, 50.0
        true, stated = {
            "nafems_radius": (math.sqrt(4 * line * radius / (math.pi * modulus)), 6.21),
            "nafems_pressure": (math.sqrt(line * modulus / (math.pi * radius)), 3585.37),
        }[quantity]
    return Finding(stated, true, _ROUNDING, {})


@experiment(
    "deep-ball",
    "Hertz's paraboloid against the sphere that it stands for",
    "size",
    "contact radius over radius a/R",
)
def deep_ball(
    effort: str,
    *,
    size: Annotated[float, Between(0, 1)] = 0.2,
    quantity: Literal["force", "area", "pressure"] = "force",
) -> Finding:
    """Compare Hertz's paraboloid with the sphere it stands for, at the contact radius a/R = size.

    At equal depth: ``"force"``, ``"area"``, or ``"pressure"`` at the centre. Both rigid on an
    elastic half-space: the error of the parabola alone.
    """
    exact, hertz = closed_form.sphere(1.0, 1.0), closed_form.paraboloid(1.0, 1.0)

    def radius(depth: float) -> float:
        return float(exact.semi_axes(depth)[0])

    depth = brentq(lambda d: radius(d) - size, 0.3 * size**2, 3 * size**2, xtol=1e-15)
    values = {
        "force": lambda form: float(form.force(depth)),
        "area": lambda form: math.pi * float(form.semi_axes(depth)[0]) ** 2,
        "pressure": lambda form: float(form.pressure(0.0, 0.0, depth)),
    }
    stated, true = (values[quantity](form) for form in (hertz, exact))
    return Finding(stated, true, _ROUNDING, {"depth over radius": depth})


@experiment("printed-cattaneo", "Springs against the printed Cattaneo case of CONTACT", "quantity")
def printed_cattaneo(
    effort: str, *, quantity: Literal["force", "pressure", "shift"] = "shift"
) -> Finding:
    """Compare the springs with the printed Cattaneo case of CONTACT (Vollebregt & Kalker).

    Two like balls, R = 50 mm, G = 200 N/mm^2, nu = 0.42, a = 1 mm, mu = 0.4, F_x = 7/8 mu F:
    ``"force"`` 9.1954 N, ``"pressure"`` 4.393 N/mm^2, ``"shift"`` 8.155e-3 mm, on 15 x 15 cells.
    The bar is the last printed digit.
    """
    shear, nu, friction, radius = 200.0, 0.42, 0.4, 50.0
    modulus = shear / (1 - nu)  # two like bodies: half of E/(1 - nu^2)
    springs = Springs(paraboloid(radius), modulus)
    depth = 1.0 / radius
    force = float(indent(springs, Load("penetration", depth)).force[0])
    path = slide(
        springs,
        Friction(tangential_modulus(shear, nu) / 2, friction),
        Load("penetration", depth),
        LoadPath("tangential_force", 7 / 8 * friction * force),
    )
    stated = {
        "force": force,
        "pressure": 1.5 * force / math.pi,
        "shift": float(path.tangential_displacement[0]),
    }[quantity]
    printed, digit = {
        "force": (9.1954, 5e-5),
        "pressure": (4.393, 5e-4),
        "shift": (8.155e-3, 5e-7),
    }[quantity]
    return Finding(stated, printed, digit / printed, {})


@experiment(
    "blunt-body",
    "Springs under blunt bodies against their closed forms",
    "flat",
    "flat or round radius over contact radius b/a",
)
def blunt_body(
    effort: str,
    *,
    shape: Annotated[str, OneOf(*_BLUNT)] = "truncated_cone",
    flat: Annotated[float, Between(0, 1)] = 0.5,
) -> Finding:
    """Compare springs with the closed form of a blunt body: force at equal depth, a = 1, E* = 1.

    Shapes (Popov, Hess & Willert 2019, 2.5): ``"truncated_cone"`` of slope 1 and
    ``"truncated_paraboloid"`` of radius 1, both flat to b = `flat`; ``"round_cone"``, of slope 1
    with a round tip to b.
    """
    slope, depth, true = _BLUNT[shape](flat)
    profile = from_function(slope, length=1.0, breakpoints=(flat,))
    coarse, fine = (
        float(indent(Springs(profile, 1.0, count), Load("penetration", depth)).force[0])
        for count in (400, 800)
    )
    return Finding(fine, true, abs(fine - coarse) / true + _ROUNDING, {"depth": depth})


Slope = Callable[[np.ndarray], np.ndarray]
# Slope f'(r), depth and force F/E* at the contact radius 1.
Blunt = tuple[Slope, float, float]


def _truncated_cone(b: float) -> Blunt:
    phi = math.acos(b)
    return (lambda r: np.where(r > b, 1.0, 0.0)), phi, phi + b * math.sqrt(1 - b * b)


def _truncated_paraboloid(b: float) -> Blunt:
    s = math.sqrt(1 - b * b)
    return (lambda r: np.where(r > b, r, 0.0)), s, 2 / 3 * (2 + b * b) * s


def _round_cone(b: float) -> Blunt:
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


_BLUNT = {
    "truncated_cone": _truncated_cone,
    "truncated_paraboloid": _truncated_paraboloid,
    "round_cone": _round_cone,
}
