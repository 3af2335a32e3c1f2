"""A finite body under a flat punch, in a half-section: axisymmetric, or in plane strain.

The punch of half-width a is pressed by d into the flat side of a half-ball (half-cylinder) of
radius R. The mesh is confocal with the edges of the punch: x = a cosh(m) cos(n), z = a sinh(m)
sin(n), with the punch at m = 0, the free surface at n = 0 and the axis at n = pi/2. This removes
the square-root singularity of the edge, and only the logarithm of R matters: bodies of R = 1e6 a
are as cheap as small ones.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, Literal

import numpy as np
import skfem
from scipy.sparse.linalg import splu
from skfem.helpers import ddot, div, dot, sym_grad

from reference.arrays import Array
from reference.elasticity import LARGEST_POISSON_RATIO
from reference.errors import choice_faults, count_faults, refuse
from reference.fem.half_space_mesh import graded_lines

Symmetry = Literal["axisymmetric", "plane"]
Support = Literal["fixed", "inertia"]

# Beyond this coordinate m the mesh lines are circles.
_CIRCLES = 1.0
SMALLEST_CIRCLE = float(np.cosh(_CIRCLES))


@dataclass(frozen=True)
class SectionContact:
    """A flat punch pressed into a finite body by d, relative to its size and modulus.

    Displacements are zero at the round side ("fixed"), or in the mean over the body ("inertia").
    """

    radius: float  # R/a
    stiffness: float  # F/(E* a d) of the axisymmetric body, F/(E* d) per length in plane strain
    radii: Array  # (m,), rho/a around the centre of the punch, the last one R/a
    energy: Array  # fraction of the elastic energy F d/2 within these radii
    mean_displacement: Array  # of u_z/d over the part within these radii
    mean_square_displacement: Array  # of |u|^2/d^2 over the same parts


def press_section(
    radius: float,
    poisson_ratio: float,
    *,
    kind: Symmetry = "axisymmetric",
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
    # Mesh lines in m are graded to the first circle, then even between the requested radii. At the
    # edge of the punch the displacement is w f(arg w), w = m + i n, which is not polynomial; the
    # error decreases as the square of the smallest element, the fourth power of `elements`.
    arguments = np.array([*radii, radius], dtype=float)
    graded = graded_lines(1.0, 0.0, elements, 0.5)[::-1]
    step = np.pi / 2 / elements
    even = [
        np.linspace(start, end, max(1, round((end - start) / step)) + 1)[1:]
        for start, end in pairwise(np.unique([_CIRCLES, *np.arccosh(arguments)]))
    ]
    lines = np.concatenate([_CIRCLES * graded, *even])
    # the mesh in (m, n), and with curved quadratic elements in (x, z); the transition from ellipses
    # to circles has a continuous slope on both sides
    plain = skfem.MeshQuad.init_tensor(lines, np.pi / 2 * graded)
    curved = skfem.MeshQuad2.from_mesh(plain)
    m, n = curved.doflocs
    share = np.minimum(m / _CIRCLES, 1.0) ** 2 * (3 - 2 * np.minimum(m / _CIRCLES, 1.0))
    x = np.cosh(m) * np.cos(n)
    x[np.abs(n - np.pi / 2) < 1e-12] = 0.0
    z = (np.sinh(m) + share * np.exp(-m)) * np.sin(n)  # cosh - sinh = exp(-m)
    mesh = skfem.MeshQuad2(np.stack([x, z]), curved.t)

    def around(w: Any) -> Any:
        """Circumference over 2 pi."""
        return w.x[0] if kind == "axisymmetric" else 1.0

    def density(u: Any, v: Any, w: Any) -> Any:
        """Twice the strain energy density for E* = 1, times `around`."""
        shear = (1 - poisson_ratio) / 2
        lame = 2 * shear * poisson_ratio / (1 - 2 * poisson_ratio)
        hoop_u, hoop_v = (f[0] / w.x[0] if kind == "axisymmetric" else 0 * f[0] for f in (u, v))
        trace = (div(u) + hoop_u) * (div(v) + hoop_v)
        strains = ddot(sym_grad(u), sym_grad(v)) + hoop_u * hoop_v
        return (lame * trace + 2 * shear * strains) * around(w)

    basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad2()), intorder=6)
    stiffness = skfem.BilinearForm(density).assemble(basis)
    mass = skfem.BilinearForm(lambda u, v, w: dot(u, v) * around(w)).assemble(basis)
    # d = 1, against a fixed round side, or with inertia forces and the centre of mass at rest
    face, round_side, axis = (
        basis.get_dofs(plain.facets_satisfying(lambda x, i=i, at=at: np.isclose(x[i], at)))
        for i, at in ((0, plain.p[0].min()), (0, plain.p[0].max()), (1, np.pi / 2))
    )
    pushed = face.all(["u^2"])
    held = [axis.all(["u^1"]), pushed]
    field, load, lift = basis.zeros(), basis.zeros(), basis.zeros()
    lift[basis.split_indices()[1]] = 1.0  # the rigid displacement u_z = 1
    if support == "fixed":
        held.append(round_side.all())
        field[pushed] = 1.0
    else:
        load = -(mass @ lift)
    free = np.setdiff1d(np.arange(basis.N), np.concatenate(held))
    inner = splu(stiffness[free][:, free].tocsc())
    field[free] = inner.solve((load - stiffness @ field)[free])
    force = float((stiffness @ field - load)[pushed].sum())
    if support == "inertia":
        centre = lift @ mass @ field / (lift @ mass @ lift)
        field, force = (field - centre * lift) / -centre, force / -centre
    # averages within the radii
    outer = plain.p[0][plain.t].max(axis=0)
    inside = [outer <= np.arccosh(rho) * (1 + 1e-9) for rho in arguments]

    def within(integrand: Callable[[Any], Any]) -> Array:
        parts = skfem.Functional(integrand).elemental(basis, u=field)
        return np.array([parts[chosen].sum() for chosen in inside])

    energy = within(lambda w: density(w["u"], w["u"], w))
    volume = within(lambda w: around(w) + 0 * w.x[0])
    squares = within(lambda w: dot(w["u"], w["u"]) * around(w))
    # force and form lack the angle around the axis, or the other half of the section
    return SectionContact(
        radius=float(radius),
        stiffness=(2 * np.pi if kind == "axisymmetric" else 2.0) * force,
        radii=arguments,
        energy=energy / energy[-1],
        mean_displacement=within(lambda w: w["u"][1] * around(w)) / volume,
        mean_square_displacement=squares / volume,
    )
