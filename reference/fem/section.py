"""A finite body under a flat punch, in a half-section: axisymmetric, or in plane strain.

The punch of half-width a is pressed by d into the flat side of a half-ball (half-cylinder) of
radius R. The mesh is confocal with the edges of the punch: x = a cosh(m) cos(n), z = a sinh(m)
sin(n), with the punch at m = 0, the free surface at n = 0 and the axis at n = pi/2. This removes
the square-root singularity of the edge, and only the logarithm of R matters: bodies of R = 1e6 a
are as cheap as small ones.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy.sparse.linalg import splu
from skfem.helpers import ddot, div, dot, sym_grad

from reference.arguments import choice_faults, count_faults, refuse
from reference.elasticity import LARGEST_POISSON_RATIO

Kind = Literal["axisymmetric", "plane"]
Support = Literal["fixed", "inertia"]

# Beyond this coordinate m the mesh lines are circles.
_CIRCLES = 1.0
SMALLEST_CIRCLE = float(np.cosh(_CIRCLES))


@dataclass(frozen=True)
class SectionContact:
    """A flat punch pressed into a finite body by d, relative to its size and modulus.

    Attributes
    ----------
    radius : float
        R/a.
    stiffness : float
        F/(E* a d) of the axisymmetric body, F/(E* d) per length in plane strain.
    radii : ndarray, shape (m,)
        Radii rho/a around the centre of the punch, the last one R/a.
    energy : ndarray, shape (m,)
        Fraction of the elastic energy F d/2 within these radii.
    mean_displacement : ndarray, shape (m,)
        Mean of u_z/d over the part of the body within these radii; u is zero at the round side
        ("fixed"), or has zero mean over the body ("inertia").
    mean_square_displacement : ndarray, shape (m,)
        Mean of |u|^2/d^2 over the same parts.
    """

    radius: float
    stiffness: float
    radii: NDArray[np.float64]
    energy: NDArray[np.float64]
    mean_displacement: NDArray[np.float64]
    mean_square_displacement: NDArray[np.float64]


def press_section(
    radius: float,
    poisson_ratio: float,
    *,
    kind: Kind = "axisymmetric",
    support: Support = "fixed",
    radii: Sequence[float] = (),
    elements: int = 8,
) -> SectionContact:
    """Return the contact of a flat frictionless punch with a finite body.

    Parameters
    ----------
    radius : float
        R/a, at least 4.
    poisson_ratio : float
        ``-1 < nu <= 0.4999``.
    kind : {"axisymmetric", "plane"}
        A half-ball, or a half-cylinder in plane strain.
    support : {"fixed", "inertia"}
        Either the round side is fixed (u = 0), so that d is the approach of punch and round side,
        or it is free, with the punch force balanced by the inertia of the uniformly accelerated
        body, so that d is the approach of punch and centre of mass.
    radii : sequence of float
        Additional radii rho/a of averages in [1.55, R/a], which are mesh lines.
    elements : int
        Elements from the axis to the free surface.

    Returns
    -------
    SectionContact
        Errors decrease as the fourth power of the element size: 4e-4 of the stiffness for 8
        elements, 2e-5 for 16.
    """
    faults = choice_faults("kind", kind, ("axisymmetric", "plane"))
    faults += choice_faults("support", support, ("fixed", "inertia"))
    faults += count_faults(2, elements=elements)
    if not -1.0 < poisson_ratio <= LARGEST_POISSON_RATIO:
        largest = LARGEST_POISSON_RATIO
        faults.append(f"poisson_ratio must lie in (-1, {largest}], not {poisson_ratio!r}")
    if not (np.isfinite(radius) and radius >= 4):
        faults.append(f"radius must be finite and at least 4 half-widths, not {radius!r}")
    if any(not SMALLEST_CIRCLE < rho <= radius for rho in radii):
        faults.append(f"radii must lie between {SMALLEST_CIRCLE:.3f} and {radius!r}, not {radii!r}")
    refuse(faults)
    arguments = np.array([*radii, radius], dtype=float)
    plain, mesh = _meshes(_lines(arguments, elements), elements)
    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad2()), intorder=6)
    density = _energy_density(poisson_ratio, kind)
    stiffness = skfem.BilinearForm(density).assemble(basis)
    mass = skfem.BilinearForm(lambda u, v, w: dot(u, v) * _measure(w.x, kind)).assemble(basis)
    field, force = _solve(basis, plain, stiffness, mass, support)
    outer = plain.p[0][plain.t].max(axis=0)
    inside = [outer <= np.arccosh(rho) * (1 + 1e-9) for rho in arguments]

    def within(integrand: Callable[[Any], Any]) -> NDArray[np.float64]:
        parts = skfem.Functional(integrand).elemental(basis, u=field)
        return np.array([parts[elements].sum() for elements in inside])

    energy = within(lambda w: density(w["u"], w["u"], w))
    volume = within(lambda w: _measure(w.x, kind) + 0 * w.x[0])
    # force and form lack the angle around the axis, or the other half of the section
    return SectionContact(
        radius=float(radius),
        stiffness=(2 * np.pi if kind == "axisymmetric" else 2.0) * force,
        radii=arguments,
        energy=energy / energy[-1],
        mean_displacement=within(lambda w: w["u"][1] * _measure(w.x, kind)) / volume,
        mean_square_displacement=within(lambda w: dot(w["u"], w["u"]) * _measure(w.x, kind))
        / volume,
    )


def _lines(arguments: NDArray[np.float64], elements: int) -> NDArray[np.float64]:
    """Return mesh lines in m: graded to the first circle, then even between the requested radii."""
    marks = np.unique([_CIRCLES, *np.arccosh(arguments)])
    step = np.pi / 2 / elements
    parts = [
        np.linspace(start, end, max(1, round((end - start) / step)) + 1)[1:]
        for start, end in pairwise(marks)
    ]
    return np.concatenate([_CIRCLES * _graded(elements), *parts])


def _graded(elements: int) -> NDArray[np.float64]:
    """Return lines from 0 to 1, refined quadratically towards 0, the edge of the punch.

    At the edge the displacement is w f(arg w), w = m + i n, which is not polynomial; the error
    decreases as the square of the smallest element, the fourth power of `elements`.
    """
    return np.linspace(0, 1, elements + 1) ** 2


def _meshes(lines: NDArray[np.float64], elements: int) -> tuple[skfem.MeshQuad, skfem.MeshQuad2]:
    """Return the mesh in (m, n), and the same mesh with curved quadratic elements in (x, z)."""
    plain = skfem.MeshQuad.init_tensor(lines, np.pi / 2 * _graded(elements))
    curved = skfem.MeshQuad2.from_mesh(plain)
    m, n = curved.doflocs
    # the transition from ellipses to circles has a continuous slope on both sides
    share = np.minimum(m / _CIRCLES, 1.0) ** 2
    share *= 3 - 2 * np.minimum(m / _CIRCLES, 1.0)
    z = (np.sinh(m) + share * np.exp(-m)) * np.sin(n)  # cosh - sinh = exp(-m)
    x = np.cosh(m) * np.cos(n)
    x[np.abs(n - np.pi / 2) < 1e-12] = 0.0
    return plain, skfem.MeshQuad2(np.stack([x, z]), curved.t)


def _measure(x: NDArray[np.float64], kind: Kind) -> NDArray[np.float64] | float:
    return x[0] if kind == "axisymmetric" else 1.0


def _energy_density(poisson_ratio: float, kind: Kind) -> Callable[..., Any]:
    """Return twice the strain energy density for E* = 1, times the circumference over 2 pi."""
    shear = (1 - poisson_ratio) / 2
    lame = 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio)

    def density(u: Any, v: Any, w: Any) -> Any:
        eps_u, eps_v = sym_grad(u), sym_grad(v)
        hoop_u, hoop_v = (
            (displacement[0] / w.x[0] if kind == "axisymmetric" else 0 * displacement[0])
            for displacement in (u, v)
        )
        trace = (div(u) + hoop_u) * (div(v) + hoop_v)
        return (lame * trace + 2 * shear * (ddot(eps_u, eps_v) + hoop_u * hoop_v)) * _measure(
            w.x, kind
        )

    return density


def _vertical(basis: skfem.Basis) -> NDArray[np.float64]:
    """Return the rigid displacement u_z = 1."""
    unit_displacement = basis.zeros()
    unit_displacement[basis.split_indices()[1]] = 1.0
    return unit_displacement


def _solve(
    basis: skfem.Basis, plain: skfem.MeshQuad, stiffness: Any, mass: Any, support: Support
) -> tuple[NDArray[np.float64], float]:
    """Return displacements for d = 1, support or centre of mass at rest, and the punch force."""
    lines = plain.p[0].min(), plain.p[0].max()
    face, round_side = (
        basis.get_dofs(plain.facets_satisfying(lambda x, at=at: np.isclose(x[0], at)))
        for at in lines
    )
    axis = basis.get_dofs(plain.facets_satisfying(lambda x: np.isclose(x[1], np.pi / 2)))
    pushed = face.all(["u^2"])
    constrained = [axis.all(["u^1"]), pushed]
    if support == "fixed":
        constrained.append(round_side.all())
    free = np.setdiff1d(np.arange(basis.N), np.concatenate(constrained))
    field, load = basis.zeros(), basis.zeros()
    if support == "fixed":
        field[pushed] = 1.0
    else:
        load = -(mass @ _vertical(basis))
    inner = stiffness[free][:, free].tocsc()
    field[free] = splu(inner).solve((load - stiffness @ field)[free])
    force = float((stiffness @ field - load)[pushed].sum())
    if support == "inertia":
        unit_displacement = _vertical(basis)
        centre = unit_displacement @ mass @ field / (unit_displacement @ mass @ unit_displacement)
        field, force = (field - centre * unit_displacement) / -centre, force / -centre
    return field, force
