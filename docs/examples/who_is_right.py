"""Judge the stored values of other codes' contact tests: the last table of docs/other-codes.md.

The numbers stay where they are: in the folder that `numbers_of_others.py` reads, and a few in
`who_is_right.toml`, beside the provenance of all. Each problem is solved in its own geometry. Run
from the repository's root (half a minute)::

    python docs/examples/who_is_right.py FOLDER
"""

# %%
import csv
import re
import sys
import tomllib
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import skfem
from numpy.typing import NDArray
from scipy.integrate import solve_ivp
from scipy.sparse.linalg import splu

from comparisons.judging.verdicts import judged
from reference.contact.pivot import compliance, pivot
from reference.contact.slide import slide
from reference.elasticity import lame_parameters
from reference.fem.half_space_mesh import graded_lines, growing_lines

Array = NDArray[np.float64]
PROBLEMS = Path(__file__).with_suffix(".toml")
TOLERANCE, LEAST_BAR = 0.005, 0.0005
SIDES = {"axis": (0, 0), "far": (0, -1), "touching": (1, 0), "back": (1, -1)}


class Answer(NamedTuple):
    """Our value; relative: its bar, and how much the answer to another question may differ."""

    value: float
    bar: float
    unsolved: float = 0.0


# %% [markdown]
# Elasticity in a half-section, around an axis or in plane strain, y upwards.


# %%
class Section:
    """Nine-node elements on a grid of lines, which `place` puts into the plane.

    The first coordinate runs along the surface that may touch, the second away from it. `held` says
    which displacements of a side are zero; of the node of a side that lies farthest in a direction,
    `pin`, the vertical one is. Forces are those of the whole circumference, or per length.
    """

    def __init__(
        self,
        lines: tuple[Array, Array],
        place: Callable[[Array, Array], tuple[Array, Array]],
        material: tuple[float, float],
        held: dict[str, str],
        *,
        pin: tuple[str, tuple[float, float]] | None = None,
        around: bool = False,
        large_below: float = np.inf,
    ) -> None:
        self.large_below = large_below
        self.plain, self.lines = skfem.MeshQuad.init_tensor(*lines), lines
        curved = skfem.MeshQuad2.from_mesh(self.plain)
        mesh = skfem.MeshQuad2(np.stack(place(*curved.doflocs)), curved.t)
        self.basis = skfem.Basis(mesh, skfem.ElementVector(skfem.ElementQuad2()), intorder=6)
        self.around, (modulus, poisson) = around, material
        self.lame, self.shear = (modulus * part for part in lame_parameters(poisson))

        def density(u: Any, v: Any, w: Any) -> Any:
            strain = symmetric(self.gradient(u, w))
            return (self.stress(strain) * self.gradient(v, w)).sum(axis=(0, 1)) * self.length(w)

        self.stiffness = skfem.BilinearForm(density).assemble(self.basis)
        zero = [self.side(side, axis) for side, axes in held.items() for axis in axes]
        if pin:
            row = self.side(pin[0], "y")
            zero.append(row[[np.argmax(pin[1] @ self.basis.doflocs[:, row])]])
        self.free = np.setdiff1d(np.arange(self.basis.N), np.concatenate(zero))
        self.inner = splu(self.stiffness[self.free][:, self.free].tocsc())

    def length(self, w: Any) -> Any:
        """Circumference, or 1."""
        return 2 * np.pi * w.x[0] if self.around else 1.0

    def facets(self, side: str) -> Any:
        """Return the facets of a side."""
        axis, end = SIDES[side]
        at, reach = self.lines[axis][end], self.lines[axis][-1]
        return self.plain.facets_satisfying(lambda x: np.abs(x[axis] - at) < 1e-12 * reach)

    def side(self, side: str, axis: str) -> Any:
        """Return the displacements along x or y of a side."""
        return self.basis.get_dofs(self.facets(side)).all(["u^1" if axis == "x" else "u^2"])

    def touchable(self, reach: float) -> tuple[Array, Array, Any]:
        """Return x and y of the surface within a reach, and its displacements along y, then x."""
        rows = []
        for axis in "yx":
            row = self.side("touching", axis)
            row = row[(self.basis.doflocs[:, row] < reach).all(axis=0)]
            rows.append(row[np.argsort(self.basis.doflocs[0, row], kind="stable")])
        return *self.basis.doflocs[:, rows[0]], np.concatenate(rows)

    def solved(self, forces: Array) -> Array:
        """Return the displacements under forces, one case or columns of them."""
        moved = np.zeros_like(forces)
        moved[self.free] = self.inner.solve(forces[self.free])
        return moved

    def under_units(self, rows: Any) -> Array:
        """Return the displacements under a unit force along each of these."""
        forces = np.zeros((self.basis.N, rows.size))
        forces[rows, np.arange(rows.size)] = 1.0
        return self.solved(forces)

    def pushed(self, side: str, stress: tuple[float, float]) -> Array:
        """Return the forces of a uniform traction on a side."""
        basis = skfem.FacetBasis(
            self.basis.mesh, self.basis.elem, facets=self.facets(side), intorder=6
        )
        return skfem.LinearForm(
            lambda v, w: (stress[0] * v[0] + stress[1] * v[1]) * self.length(w)
        ).assemble(basis)

    def gradient(self, field: Any, w: Any) -> Array:
        """Return the three-dimensional gradient of displacements."""
        grad = np.asarray(field.grad)
        full = np.zeros((3, 3, *grad.shape[2:]))
        full[:2, :2] = grad
        if self.around:
            full[2, 2] = field[0] / w.x[0]
        return full

    def stress(self, strain: Array) -> Array:
        """Return Hooke's stress."""
        unit = np.eye(3)[:, :, None, None]
        return self.lame * np.trace(strain) * unit + 2 * self.shear * strain

    def excess(self, moved: Array) -> Array:
        """Return the forces by which linear elasticity exceeds that of large displacements.

        That is St. Venant & Kirchhoff's, Hooke's law between Green's strain and its stress; up to
        the height `large_below` only.
        """

        def density(v: Any, w: Any) -> Any:
            grad = self.gradient(w["u"], w)
            strain = symmetric(grad)
            stress = self.stress(strain + product(grad.swapaxes(0, 1), grad) / 2)
            less = self.stress(strain) - stress - product(grad, stress)
            work = (less * self.gradient(v, w)).sum(axis=(0, 1))
            return work * self.length(w) * (w.x[1] < self.large_below)

        field = self.basis.interpolate(moved)
        return skfem.LinearForm(density).assemble(self.basis, u=field)

    def work_of_strains(self, moved: Array) -> float:
        """Return what finite strains add to the work, to first order: third powers.

        Cauchy's stress is that of logarithmic strains by Hooke's law. With strain e, stress s and
        gradient g the integral of s : (g' g/2 - e e + e tr(e)/3), on proportional ways.
        """

        def density(w: Any) -> Any:
            grad = self.gradient(w["u"], w)
            strain = symmetric(grad)
            extra = product(grad.swapaxes(0, 1), grad) / 2 - product(strain, strain)
            extra += np.trace(strain) * strain / 3
            return (self.stress(strain) * extra).sum(axis=(0, 1)) * self.length(w)

        field = self.basis.interpolate(moved)
        return float(skfem.Functional(density).assemble(self.basis, u=field))


def symmetric(grad: Array) -> Array:
    """Return the symmetric part of tensors (3, 3, ...)."""
    return (grad + grad.swapaxes(0, 1)) / 2


def product(one: Array, other: Array) -> Array:
    """Return products of tensors (3, 3, ...)."""
    return np.einsum("ik...,kj...->ij...", one, other)


class Touching(NamedTuple):
    """Forces on the nodes of a contact, upwards and to the right on the upper body."""

    normal: Array
    tangential: Array

    @property
    def both(self) -> Array:
        """As displacements are numbered."""
        return np.concatenate(self)


class Tangential:
    """A compliance for `slide`, which knows two directions: nothing moves along the second."""

    def __init__(self, matrix: Array) -> None:
        self.matrix, self.own = matrix, float(np.median(np.diag(matrix)))

    def shear(self, traction: Array) -> Array:
        """Return the displacement."""
        return np.stack([self.matrix @ traction[0], self.own * traction[1]])

    def near(self, slip: Array) -> Array:
        """Return a rough inverse."""
        return slip / self.own


def touch(
    matrix: Array, gap: Array, moved: Array, start: Any, *, force: float = 0.0, mu: float = 0.0
) -> Touching:
    """Return the contact of a body whose `gap` loads have `moved`, under a force or at depth 0.

    Pressure and friction in turn, until both stay; friction in one step (monotonic loads).
    """
    count = gap.size
    matrix, moved = matrix.reshape(2, count, 2, count), moved.reshape(2, count)
    friction, active = np.zeros(count), start
    share = {"per_depth": 0.0, "per_pressure": 1.0} if force else {}
    for _ in range(200):
        apart = gap + moved[0] + matrix[0, :, 1] @ friction
        found = pivot(compliance(matrix[0, :, 0]), apart, active, force, **share)
        normal, active = found.pressures, found.active
        if not mu:
            return Touching(normal, friction)
        way = moved[1] + matrix[1, :, 0] @ normal
        body = Tangential(matrix[1, :, 1])
        target = np.stack([way, 0 * way])
        new = -slide(body, mu * normal, target, start=np.stack([-friction, 0 * way])).traction[0]
        change, friction = np.abs(new - friction).max(), new
        if change <= 1e-8 * np.abs(new).max():
            return Touching(normal, friction)
    raise ArithmeticError("pressure and friction did not settle")


def quadratic(local: Array) -> list[Array]:
    """Return the shape functions of three nodes at 0, 1/2 and 1."""
    return [(1 - local) * (1 - 2 * local), 4 * local * (1 - local), local * (2 * local - 1)]


def middle(x: Array, forces: Array, reach: float, around: bool) -> float:
    """Return the pressure at x = 0 by an even polynomial with the forces' moments, below reach."""
    local, weights = (np.polynomial.legendre.leggauss(6)[k] / 2 + (0.5, 0)[k] for k in (0, 1))
    shapes = np.array(quadratic(local))
    powers, moments, areas = np.arange(0, 8, 2), np.zeros((x.size, 4)), np.zeros(x.size)
    for first in range(0, x.size - 2, 2):
        nodes = slice(first, first + 3)
        place = shapes.T @ x[nodes]
        slope = np.stack([4 * local - 3, 4 - 8 * local, 4 * local - 1]).T @ x[nodes]
        area = weights * slope * (2 * np.pi * place if around else 1.0)
        areas[nodes] += shapes @ area
        moments[nodes] += shapes @ (area[:, None] * place[:, None] ** powers)
    inside = np.flatnonzero(x < reach)[:-1]
    scale = np.maximum(areas[inside], 1e-2 * areas[inside].max())
    fitted = np.linalg.lstsq(moments[inside] / scale[:, None], forces[inside] / scale)[0]
    return float(fitted[0])


# %% [markdown]
# The problems on elements: numbers at a resolution, elements per half-width of the contact.

# %%
Values = dict[str, float]


def growth(count: int) -> float:
    """Return the factor from one element to the next."""
    return 1 + 0.45 / np.sqrt(count)


def half_disc(
    count: int,
    radius: float,
    material: tuple[float, float],
    depth: float,
    *,
    around: bool,
    clamped: bool = False,
    at: tuple[float, ...] = (),
) -> Values:
    """Press half a ball or disc onto a rigid plane by the face through its centre.

    The face slides sideways or is `clamped`. The condition of contact, y >= 0 after displacement,
    is that of large displacements, too.
    """
    width = np.sqrt(radius * depth) if around else 0.64 * np.sqrt(radius * depth)
    edge = 1.4 * width / radius
    even = np.linspace(0, edge, int(1.4 * count) + 1)
    size, more = width / radius / count, growth(count)
    angles = np.concatenate([even[:-1], growing_lines(edge, np.pi / 2, size, more)])

    def place(angle: Array, deep: Array) -> tuple[Array, Array]:
        rho = radius * (1 - deep)
        return rho * np.sin(angle), radius - rho * np.cos(angle)

    held = {"axis": "x", "far": "xy" if clamped else "y"}
    body = Section((angles, growing_lines(0, 1, size, more)), place, material, held, around=around)
    x, y, rows = body.touchable(1.4 * width)
    units = body.under_units(rows)

    def pressed(value: float) -> tuple[Touching, Array]:
        found = touch(units[rows], y - value, 0 * rows, y < value / 2)
        return found, units @ found.both

    found, moved = pressed(depth)
    values = {
        "force": float(found.normal.sum() * (1 if around else 2)),
        "pressure": middle(x, found.normal, 0.6 * width, around),
    }
    sideways = moved[rows[x.size :]]
    values |= {f"sideways at {place:g}": float(np.interp(place, x, -sideways)) for place in at}
    if not around:  # the change of the force at a given depth is the slope of that of the work
        change = [body.work_of_strains(pressed(part * depth)[1]) for part in (0.95, 1.05)]
        values["finite strain"] = (change[1] - change[0]) / (0.1 * depth) / found.normal.sum()
    return values


def across(places: Array, x: Array, y: Array) -> tuple[Array, Array]:
    """Return what gives a surface at some places, from its nodes (x, y), and its slope there.

    The nodes are those of quadratic elements: corner, middle, corner, and so on.
    """
    first = 2 * np.clip(np.searchsorted(x[::2], places) - 1, 0, (x.size - 3) // 2)
    nodes, local = first[:, None] + np.arange(3), np.full(places.size, 0.5)
    for _ in range(8):
        shapes = np.stack(quadratic(local), 1)
        slopes = np.stack([4 * local - 3, 4 - 8 * local, 4 * local - 1], 1)
        stretch = (slopes * x[nodes]).sum(1)
        local = local + (places - (shapes * x[nodes]).sum(1)) / stretch
    matrix = np.zeros((places.size, x.size))
    np.put_along_axis(matrix, nodes, shapes, 1)
    return matrix, (slopes * y[nodes]).sum(1) / stretch


def pair(
    upper: Section, lower: Section, reach: float, start: float, load: Array, **loading: float
) -> tuple[Array, Touching, Array]:
    """Return x and the forces of the upper surface, and displacements (y, then x) of the lower one.

    In large displacements: what linear elasticity has in excess, the places of the upper nodes on
    the lower surface and its slope there are those of the last solution, until that stays.
    """
    (x, y, rows), (_, _, below) = upper.touchable(reach), lower.touchable(reach)
    up, down = upper.under_units(rows), lower.under_units(below)
    both, turned = np.eye(rows.size), np.zeros(rows.size)
    more, less, before = 0 * load, np.zeros(lower.basis.N), np.inf
    for _ in range(30):
        raised = upper.solved(load + more) + up @ turned
        sunk = lower.solved(less) - down @ (both.T @ turned)
        matrix = up[rows] + both @ down[below] @ both.T
        found = touch(matrix, y, raised[rows] - both @ sunk[below], x < start, **loading)
        raised, sunk = raised + up @ found.both, sunk - down @ (both.T @ found.both)
        place, (deep, aside) = x + raised[rows[x.size :]], sunk[below].reshape(2, -1)
        if np.abs(sunk - before).max() <= 1e-6 * np.abs(sunk).max():
            return place, found, sunk[below]
        before, more, less = sunk, upper.excess(raised), lower.excess(sunk)
        matrix, slope = across(place, x + aside, deep)
        both = np.kron(np.eye(2), matrix)
        turned = np.concatenate([slope * found.tangential, -slope * found.normal])
    raise ArithmeticError("large displacements did not settle")


def punch(
    count: int,
    friction: float,
    *,
    modulus: float = 210e3,
    stress: float = 100.0,
    block: tuple[float, float] = (100.0, 200.0),
) -> Values:
    """Press a steel punch (R 50, H 100, edge R 10) on aluminium (R 100, H 200), 100 MPa: mm."""
    flat, edge, more = 40.0, 10.0, growth(count)
    inside = graded_lines(0, flat, 4 * count, 0.5)
    size = inside[-1] - inside[-2]
    rounded = flat + edge * growing_lines(0, np.pi / 4, size / edge, more)[1:]
    end = rounded[-1]
    last = (end - rounded[-2]) / edge
    beyond = flat + edge * growing_lines(np.pi / 4, np.pi / 2, last, 1.3)[1:]
    along = np.concatenate([inside, rounded, beyond])

    def outline(t: Array) -> tuple[Array, Array]:
        angle = np.clip((t - flat) / edge, 0, np.pi / 2)
        return np.minimum(t, flat) + edge * np.sin(angle), edge * (1 - np.cos(angle))

    def above(t: Array, s: Array) -> tuple[Array, Array]:
        x, y = outline(t)
        return (1 - s) * x + s * 50 * t / along[-1], (1 - s) * y + s * 100

    def below(t: Array, s: Array) -> tuple[Array, Array]:
        return outline(np.minimum(t, end))[0] + np.maximum(t - end, 0), -block[1] * s

    steel, aluminium, axis = (modulus, 0.3), (70e3, 0.3), (-1.0, 0.0)
    deep = [growing_lines(0, 1, size / height, more) for height in (100, block[1])]
    lines = along, deep[0]
    upper = Section(lines, above, steel, {"axis": "x"}, pin=("back", axis), around=True)
    far = end + block[0] - outline(end)[0]
    wide = np.concatenate([inside, rounded, growing_lines(end, far, edge * last, 1.3)[1:]])
    lower = Section((wide, deep[1]), below, aluminium, {"axis": "x", "back": "xy"}, around=True)
    load = upper.pushed("back", (0.0, -stress))
    total = stress * np.pi * 50**2
    x, found, moved = pair(upper, lower, 44.0, flat, load, force=total, mu=friction)
    return {"displacement": -moved[0], "pressure": middle(x, found.normal, 25.0, True)}


def roller(count: int, friction: float) -> Values:
    """Press a steel cylinder (R 50) on an aluminium block (200 x 200), 35 kN/mm: mm.

    Displacements are small above its centre: strains below the point force have no bound.
    """
    radius, width, more = 50.0, 6.2, growth(count)
    even = np.linspace(0, 1.4 * width / radius, int(1.4 * count) + 1)
    edge, size = even[-1], even[1]
    angles = np.concatenate([even[:-1], growing_lines(edge, np.pi, size, more)])

    def disc(angle: Array, deep: Array) -> tuple[Array, Array]:
        rho = radius * (1 - deep)
        return rho * np.sin(angle), radius - rho * np.cos(angle)

    def block(t: Array, s: Array) -> tuple[Array, Array]:
        return radius * (np.sin(np.minimum(t, edge)) + np.maximum(t - edge, 0)), -200 * s

    far = edge + 100 / radius - np.sin(edge)
    wide = np.concatenate([even[:-1], growing_lines(edge, far, size, more)])
    deep = growing_lines(0, 1, size, more), growing_lines(0, 1, size * radius / 200, more)
    held = {"axis": "x", "far": "x"}
    upper = Section(
        (angles, deep[0]), disc, (210e3, 0.3), held, pin=("far", (0.0, 1.0)), large_below=radius
    )
    lower = Section((wide, deep[1]), block, (70e3, 0.3), {"axis": "x", "back": "xy"})
    reach = radius * np.sin(edge) * (1 + 1e-9)
    nothing = np.zeros(upper.basis.N)
    x, found, moved = pair(upper, lower, reach, width, nothing, force=17500.0, mu=friction)
    return {"displacement": -moved[0], "pressure": middle(x, found.normal, 0.6 * width, False)}


def plate(count: int) -> Values:
    """Push half a plate (40 x 40 mm) along a rigid plane: 150 MPa at its end, 50 MPa on top, mu 1.

    E 130 GPa, nu 0.2; the plane of symmetry lies at x = 40 mm, and the end that is pushed at 0.
    """
    half = growing_lines(0, 20, 5 / count, growth(count))
    line = np.concatenate([half, 40 - half[-2::-1]])
    held, corner = {"far": "x"}, ("touching", (1.0, 0.0))
    body = Section((line, line), lambda x, y: (x, y), (130e3, 0.2), held, pin=corner)
    load = body.pushed("axis", (150.0, 0.0)) + body.pushed("back", (0.0, -50.0))
    x, y, rows = body.touchable(40 * (1 - 1e-9))
    units, moved = body.under_units(rows)[rows], body.solved(load)[rows]
    found = touch(units, y, moved, x > 10, mu=1.0)
    return {"sideways": float((moved + units @ found.both)[x.size])}


# %% [markdown]
# Answers: closed forms, and values of two resolutions, whose bar is the change between them.


# %%
def refined(counts: tuple[int, int], solve: Callable[[int], Values]) -> dict[str, Answer]:
    """Return the values of the finer one, with what changed: small changes may be so by chance."""
    coarse, fine = map(solve, counts)
    return {
        name: Answer(value, max(LEAST_BAR, abs(value - coarse[name]) / abs(value)))
        for name, value in fine.items()
    }


def balls(approach: float) -> dict[str, Answer]:
    """Return two balls, R 50, E 20 GPa (SSNV104), in small displacements as theirs: mm, MPa."""
    ball = (50.0, (20e3, 0.3), approach / 2)
    places = (4.0329, 7.9101)
    return refined((8, 16), lambda count: half_disc(count, *ball, around=True, at=places))


def disc(clamped: bool) -> dict[str, Answer]:
    """Return half a disc on a rigid plane (MOOSE, whose strains are logarithmic)."""
    given = (3.0, (1e6, 0.3), 0.002)
    found = refined((8, 16), lambda count: half_disc(count, *given, around=False, clamped=clamped))
    strain = found["pressure"].value / 1e6
    return {
        "force": found["force"]._replace(unsolved=abs(found["finite strain"].value)),
        "pressure": found["pressure"]._replace(unsolved=strain),
    }


def collision() -> dict[str, Answer]:
    """Return two balls of glass after 1508 and 2508 steps (LAMMPS): F = kn sqrt(R) d^1.5, SI."""
    mass, stiffness, step = 2800 * 4 / 3 * np.pi * 0.01**3, 3.33333e10 * np.sqrt(0.005), 2e-8

    def course(_: float, state: Array) -> list[float]:
        return [state[1], -2 * stiffness * max(state[0], 0.0) ** 1.5 / mass]

    times = np.array([1508, 2508]) * step
    found = [
        solve_ivp(course, (0, times[-1]), [-2e-4, 20.0], "DOP853", times, rtol=rtol, atol=1e-14).y
        for rtol in (1e-8, 1e-11)
    ]
    values = [{"overlap": 1e6 * y[0, 0], "rebound": -y[1, 1] / 2} for y in found]
    return refined((0, 1), lambda k: values[k])


def sphere() -> dict[str, Answer]:
    """Return a hollow ball at radius 5.5 (Lamé): radii 1, 10, 300 MPa inside, E 1e5, nu 0.3."""
    inner, outer, radius, (lame, shear) = 1.0, 10.0, 5.5, lame_parameters(0.3)
    unit = 300 * inner**3 / (outer**3 - inner**3)
    way = radius / (3 * lame + 2 * shear) + outer**3 / (4 * shear * radius**2)
    return {
        "displacement": Answer(1e3 * unit * way / 1e5, 0.0),
        "pressure": Answer(unit * (outer**3 / radius**3 - 1), 0.0),
    }


def rings() -> dict[str, Answer]:
    """Return two rings (Michell): radii 1, 0.6, 0.2, no friction, outside 10 MPa + 0.1 MPa cos 2t.

    Plane strain, E 1 GPa, nu 0.2 of both. Stress functions a r^2 + b ln r, and (a r^2 + b r^4 +
    c/r^2 + d) cos 2t.
    """
    nu, (outer, touch_at, inner) = 0.2, (1.0, 0.6, 0.2)
    plane = nu / (1 - nu)  # and E/(1 - nu^2), which is common to all

    def mean(r: float) -> tuple[list[float], list[float]]:
        """Return radial stress and displacement of the two terms."""
        return [2, r**-2], [2 * (1 - plane) * r, -(1 + plane) / r]

    def wave(r: float) -> tuple[list[float], list[float], list[float]]:
        """Return radial stress, shear and radial displacement of the four terms."""
        along = [-2 * (1 + plane) * r, -4 * plane * r**3, 2 * (1 + plane) / r**3, 4 / r]
        return [-2, 0, -6 / r**4, -4 / r**2], [2, 6 * r**2, -6 / r**4, -2 / r**2], along

    def pressure(load: float, terms: Callable[..., Any], count: int) -> float:
        zero = [0.0] * count
        radial = {r: terms(r) for r in (outer, touch_at, inner)}
        rows = [radial[outer][0] + zero, zero + radial[inner][0]]
        rows.append([*radial[touch_at][0], *(-value for value in radial[touch_at][0])])
        rows.append([*radial[touch_at][-1], *(-value for value in radial[touch_at][-1])])
        if count == 4:  # no shear anywhere
            for r, part in ((outer, 0), (touch_at, 0), (touch_at, 1), (inner, 1)):
                rows.append(zero * part + radial[r][1] + zero * (1 - part))
        found = np.linalg.solve(np.array(rows, float), [-load, *[0.0] * (2 * count - 1)])
        return -1e-6 * float(np.dot(radial[touch_at][0], found[:count]))

    even, swing = pressure(1e7, mean, 2), pressure(1e5, wave, 4)
    return {
        "even": Answer(even, 0.0),
        "most": Answer(even + swing, 0.0),
        "least": Answer(even - swing, 0.0),
    }


@cache
def answers(model: str, *given: float) -> dict[str, Answer]:
    """Return what a model of `who_is_right.toml` answers, all at once."""
    return {
        "balls": balls,
        "disc": disc,
        "punch": lambda mu: refined((4, 8), lambda count: punch(count, mu)),
        "roller": lambda mu: refined((8, 16), lambda count: roller(count, mu)),
        "plate": lambda: refined((8, 16), plate),
        "collision": collision,
        "sphere": sphere,
        "rings": rings,
    }[model](*given)


# %% [markdown]
# The numbers of the others, and who is right.


# %%
class Number(NamedTuple):
    """A stored number: the reference of a test, or the result of a code."""

    kind: str
    value: float
    error: float
    verdict: str


def printed(folder: Path, problem: dict[str, Any]) -> dict[str, list[float]]:
    """Return references and results, as sizes; repeated ones, to five digits, once.

    A test that refers to another one of code_aster refers to a result.
    """
    found: dict[str, list[float]] = {"reference": [], "result": problem.get("results", [])}
    wanted = [abs(value) for value in problem.get("references", [])]
    if "tests" in problem:
        with (folder / "code_aster" / "contact_tests.csv").open(encoding="utf-8") as stream:
            rows = list(csv.DictReader(stream))
        for row in rows:
            name, given = Path(row["file"]).stem, abs(float(row["VALE_REFE"] or 0))
            if (
                re.fullmatch(problem["tests"], name)
                and row["component_or_field"] == problem["component"]
                and row["at"] in problem.get("at", row["at"])
                and (not wanted or any(abs(given / value - 1) < 1e-4 for value in wanted))
            ):
                found["result"].append(abs(float(row["VALE_CALC"])))
                if given:
                    other = row["reference_kind"] == "AUTRE_ASTER"
                    found["result" if other else "reference"].append(given)
    unique = {kind: {f"{value:.5g}": value for value in all_} for kind, all_ in found.items()}
    scale = problem.get("scale", 1.0)
    return {kind: [scale * value for value in values.values()] for kind, values in unique.items()}


def curve(folder: Path, name: str, found: dict[str, Answer]) -> list[float]:
    """Return pressures over those of the ellipse of our force, up to 0.95 of its half-width."""
    x, pressure = np.loadtxt(folder / name).T
    most = found["pressure"].value
    ratio = x / (2 * found["force"].value / (np.pi * most))
    inside = ratio < 0.95
    return list(pressure[inside] / (most * np.sqrt(1 - ratio[inside] ** 2)))


def answered(folder: Path, problem: dict[str, Any]) -> tuple[Answer, list[Number]]:
    """Return our answer to a problem and what is right of the numbers."""
    found = answers(problem["model"], *problem.get("given", []))
    if "curve" in problem:
        answer = found["pressure"]._replace(value=1.0)
        values = {"result": curve(folder, problem["curve"], found)}
    else:
        answer, values = found[problem["quantity"]], printed(folder, problem)
    numbers = []
    for kind, all_ in values.items():
        for value in all_:
            error = value / answer.value - 1
            verdict = judged(error, answer.bar + answer.unsolved, TOLERANCE).word
            numbers.append(Number(kind, value, error, verdict))
    return answer, numbers


WORDS = {"within": "right", "outside": "wrong", "not resolved": "not decided"}


def per_cent(errors: list[float]) -> str:
    """Return the range of some errors, to two digits at least."""
    digits = 1 if max(map(abs, errors)) >= 0.00995 else 2
    ends = [round(100 * error, digits) for error in (min(errors), max(errors))]
    texts = dict.fromkeys(f"{end:+.{digits}f}" if end else f"{0:.{digits}f}" for end in ends)
    return " to ".join(texts).replace("-", "−") + " %"


def side(numbers: list[Number]) -> tuple[str, str]:
    """Return verdicts on numbers of one kind with their counts, and the range of the errors."""
    if not numbers:
        return "", ""
    counts = {word: sum(n.verdict == key for n in numbers) for key, word in WORDS.items()}
    said = [word if len(numbers) == 1 else f"{k} {word}" for word, k in counts.items() if k]
    return ", ".join(said), per_cent([number.error for number in numbers])


def row(problem: dict[str, Any], answer: Answer, numbers: list[Number]) -> str:
    """Return a line of the table."""
    bar = "exact" if answer.bar == 0 else f"{100 * answer.bar:.2g} %"
    parts = [problem["name"], f"{answer.value:.5g} {problem['unit']}".strip()]
    parts.append(bar)
    parts.append(f"{100 * answer.unsolved:.2g} %" if answer.unsolved else "")
    for kind in ("reference", "result"):
        parts += side([number for number in numbers if number.kind == kind])
    return "| " + " | ".join(parts) + " |"


def sentence(problem: dict[str, Any], answer: Answer, numbers: list[Number]) -> str:
    """Return who is right about a problem."""
    said = [f"{problem['name']}: {answer.value:.5g} {problem['unit']}".strip()]
    for kind, many in (("reference", "references"), ("result", "results")):
        ours = [number for number in numbers if number.kind == kind]
        words, errors = side(ours)
        if ours:
            count = f"the {kind}" if len(ours) == 1 else f"of {len(ours)} {many}"
            said.append(f"{count} {'is ' if len(ours) == 1 else ''}{words} ({errors})")
    return "; ".join(said) + "."


def provenance() -> list[str]:
    """Return where the numbers are from."""
    sources = tomllib.loads(PROBLEMS.read_text(encoding="utf-8"))["sources"]
    return [
        f"- **{source['code']}** ({source['licence']}): {source['from']}. Dimensions from "
        f"{source['dimensions']}."
        for source in sources.values()
    ]


def report(folder: Path) -> tuple[list[str], list[str], str]:
    """Return the sentences, the table and the counts."""
    problems = tomllib.loads(PROBLEMS.read_text(encoding="utf-8"))["problems"]
    solved = [(problem, *answered(folder, problem)) for problem in problems if "model" in problem]
    everything = [number for *_, numbers in solved for number in numbers]
    counts = []
    for kind in ("reference", "result"):
        verdicts = [WORDS[number.verdict] for number in everything if number.kind == kind]
        words = ", ".join(f"{verdicts.count(word)} {word}" for word in WORDS.values())
        counts.append(f"{len(verdicts)} {kind}s: {words}")
    left = sum("reason" in problem for problem in problems)
    total = f"{len(solved)} problems solved, {left} not comparable. {counts[0]}. {counts[1]}."
    return [sentence(*one) for one in solved], [row(*one) for one in solved], total


if __name__ == "__main__":
    sentences, table, counts = report(Path(sys.argv[1]))
    print(*sentences, sep="\n")
    titles = ["problem", "ours", "error bar", "not solved", "reference", "off", "results", "off"]
    print("", "| " + " | ".join(titles) + " |", "|---" * len(titles) + "|", *table, sep="\n")
    print("", counts, "", *provenance(), sep="\n")
