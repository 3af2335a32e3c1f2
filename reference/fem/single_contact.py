"""One contact at any load on one condensed body: the mesh is scaled with the contact.

A half-space has no length scale, so a mesh scaled by s has its compliance divided by s, and the
mesh circle can be placed on the contact edge at every load without a new condensation. The contact
area is that with the largest force at a given penetration (Barber 1974, *J. Strain Anal.* 9,
230), which gives s; the active set on the scaled body then confirms or corrects it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize_scalar
from skfem.element import ElementQuad1, ElementQuad2

from reference.errors import ConvergenceError, choice_faults, refuse
from reference.fem.condensed_body import CondensedBody
from reference.fem.contact import (
    CONTROLS,
    EXACT,
    Enforcement,
    NodalContact,
    at_quadrature_points,
    fitted_area,
    press,
)
from reference.fem.element_stiffness import facet_quadrature, gauss_square
from reference.loads import LoadPath

Array = NDArray[np.float64]
Shape = Callable[[Array, Array], Array]

GAUSS_POINTS = 6  # per direction; error by the root at the rim 1e-5 of its force


def indent(
    body: CondensedBody,
    shape: Shape,
    load: LoadPath,
    enforcement: Enforcement = EXACT,
    *,
    points: str = "nodes",
) -> Iterator[tuple[CondensedBody, NodalContact]]:
    """Solve a single convex contact, with the mesh fitted to the contact at every load.

    Parameters
    ----------
    body : CondensedBody
        From a `RingMesh`, best with ``edge=contact_radius``; its size is arbitrary, but its
        `stretch` determines the aspect ratio of the contact.
    shape : callable
        Initial gap ``g(x, y)`` of arrays; +inf outside a sharp edge. Even in x and y for a quarter.
    load : LoadPath
        Positive penetrations or forces.
    points : {"nodes", "quadrature"}
        Points of the contact conditions; "quadrature" (`at_quadrature_points`) needs the method
        "penalty".

    Yields
    ------
    (CondensedBody, NodalContact)
        The body scaled to this load, with its `points` for nodal values.
        ``contact_area`` is that of the ellipse with the stiffness of the contact set; if that is
        the mesh circle, ``pressure`` is a weighted projection (`RingPressure`).

    Raises ConvergenceError if no size of the mesh carries the load, or every size does because the
    gap does not increase.

    Examples
    --------
    >>> from reference.fem import Material, RingMesh, half_space_body
    >>> body = half_space_body(RingMesh(1.0, edge=1.0), Material(1.0, 0.3))
    >>> ball = indent(body, lambda x, y: 0.5 * (x**2 + y**2), LoadPath("penetration", 1e-6))
    >>> _, step = next(ball)
    >>> hertz = 4.0 / 3.0 * body.effective_modulus * 1e-9
    >>> bool(abs(step.force / hertz - 1.0) < 5e-4)
    True
    """
    faults = choice_faults("points", points, ("nodes", "quadrature"))
    if body.ring is None:
        faults.append("indent needs a body from a RingMesh: a TensorMesh has no mesh circle")
    refuse(faults)
    load.one_of(*CONTROLS)
    load.positive()
    pressed = body if points == "nodes" else at_quadrature_points(body)

    def gap_at(places: Array) -> Array:
        x, y = places.T
        with np.errstate(over="ignore", invalid="ignore"):  # gaps may overflow at large distances
            gaps = np.asarray(shape(x, y), dtype=float)
        if gaps.shape != x.shape:
            raise ValueError(f"shape must return one gap per point {x.shape}, got {gaps.shape}")
        return gaps

    # v: forces on the circle at unit penetration, E s times which is the stiffness at the size s
    circle = body.inside_ring
    disc = body.points[circle]
    ones, rigid = np.ones((len(disc), 1)), np.zeros(len(disc))
    columns, _ = body.flexibility.respond(np.flatnonzero(circle), ones, rigid)
    forces, modulus = columns[:, 0] * body.symmetry, body.youngs_modulus * body.length

    gaps = gap_at(disc)
    noise = 1e-9 * np.abs(gaps[np.isfinite(gaps)]).max(initial=0.0)
    for axis in np.flatnonzero(body.grid.planes):
        mirrored = gap_at(disc * np.where(np.arange(2) == axis, -1.0, 1.0))
        if not np.allclose(gaps, mirrored, rtol=0.0, atol=noise, equal_nan=True):
            raise ValueError(
                f"the gap must be even in {'xy'[axis]}, of which only the positive side is "
                "meshed; centre the shape, or build the body with symmetry = 'none'"
            )

    def steps() -> Iterator[tuple[CondensedBody, NodalContact]]:
        projection = None
        for value in load.values:

            def loss(size: float, value: float = value) -> float:
                gaps = gap_at(disc * size)
                if load.control == "force":  # the penetration (F/(E s) + v . g(s x)) / sum v
                    return value / (modulus * size) + float(forces @ gaps)
                return -size * float(forces @ (value - gaps))  # minus the force over E

            size = _best_size(loss, lambda size: bool(np.isfinite(gap_at(disc * size)).all()))
            fitted = pressed.scaled(size)
            gap = gap_at(fitted.points)
            start = fitted.inside_ring & np.isfinite(gap)
            step = next(press(fitted, gap, LoadPath(load.control, value), enforcement, start=start))
            if np.isfinite(gap).all():
                area = fitted_area(fitted.nodal or fitted, step.stiffness)
                step = replace(step, contact_area=area)
                if fitted.nodal is None and np.array_equal(step.active, fitted.inside_ring):
                    projection = projection or RingPressure(body, float(forces.sum()) * modulus)
                    step = replace(step, pressure=projection.pressure(fitted, step.reactions))
            yield fitted, step

    return steps()


def _best_size(loss: Callable[[float], float], finite: Callable[[float], bool]) -> float:
    """Return the size of the mesh with the least loss, at which its gaps are finite."""
    # a bracket of the minimum by factors of two, from a size with a finite gap
    power = next((p for k in range(200) for p in (k, -k) if finite(2.0**p)), None)
    if power is None:
        raise ConvergenceError("the gap is infinite at every size of the contact")
    value = loss(2.0**power)
    for step in (1, -1):
        for _ in range(400):
            trial = power + step
            if not finite(2.0**trial) or (new := loss(2.0**trial)) >= value:
                break
            power, value = trial, new
        else:
            raise ConvergenceError("the contact grows without end: the shape does not rise")
    low, high = 2.0 ** (power - 1), 2.0 ** (power + 1)
    # the largest size at which no point inside the circle is beyond a sharp edge
    edge = high
    if not finite(high):
        edge, beyond = low, high
        while edge < (middle := 0.5 * (edge + beyond)) < beyond:
            edge, beyond = (middle, beyond) if finite(middle) else (edge, middle)
    minimum = minimize_scalar(
        lambda power: loss(2.0**power),
        bounds=(np.log2(low), np.log2(edge)),
        method="bounded",
        options={"xatol": 1e-9},
    )
    return min((2.0**minimum.x, edge), key=loss)


class RingPressure:
    """Weighted projection of nodal forces onto ``p = q sqrt(1 - rho^2)``.

    Nodal forces are the moments ``R_i = int N_i p dA`` of the pressure. Force over tributary area
    mixes values over an element, and with nodal contact conditions on quadratic elements
    neighbouring forces alternate by some per cent. Solving ``int M_i M_j sqrt(1 - rho^2) dA q_j =
    sum_k M_i(x_k) R_k`` for a q that is bilinear between the corners of the elements (shape
    functions M) averages over patches of elements, conserves force and first moments, and separates
    the known root at the edge from the interpolation: for Hertz q is constant. Rho is the radius
    over that of the contact, which is slightly larger than the mesh circle: that of a punch of the
    `stiffness` dF/dd. The size of the body does not matter.
    """

    def __init__(self, body: CondensedBody, stiffness: float) -> None:
        mesh = body.grid.mesh
        area = fitted_area(body, stiffness) / (body.length * body.length)
        reach = np.sqrt(area / (np.pi * np.prod(body.stretch)))

        def root(points: Array) -> Array:
            x, y = (points[..., axis] / body.stretch[axis] / reach for axis in (0, 1))
            return np.asarray(np.sqrt(np.clip(1.0 - x**2 - y**2, 0.0, None)))

        def bilinear(points: Array) -> Array:
            return np.array([ElementQuad1().lbasis(points, i)[0] for i in range(4)])

        self.inside = body.inside_ring
        self.root = root(body.scaled_points[self.inside])
        place = np.full(mesh.p.shape[1], -1)
        place[body.nodes[self.inside]] = np.arange(int(self.inside.sum()))
        nodes, _, points, areas = facet_quadrature(mesh, body.grid.surface, GAUSS_POINTS)
        covered = (place[nodes] >= 0).all(axis=1)
        nodes = place[nodes[covered]]
        weight = np.abs(areas[covered, :, 2]) * root(points[covered, :, :2])
        used, corners = np.unique(nodes[:, :4], return_inverse=True)
        corners = corners.reshape(-1, 4)
        shapes = bilinear(gauss_square(GAUSS_POINTS)[0])
        matrix = np.zeros((len(used), len(used)))
        blocks = np.einsum("nq,fq,mq->fnm", shapes, weight, shapes, optimize=True)
        np.add.at(matrix, (corners[:, :, None], corners[:, None, :]), blocks)
        self.factor = cho_factor(matrix, overwrite_a=True)
        self.interpolation = np.zeros((len(self.root), len(used)))
        at_nodes = bilinear(ElementQuad2().doflocs.T)
        self.interpolation[nodes[:, None, :], corners[:, :, None]] = at_nodes

    def pressure(self, body: CondensedBody, reactions: Array) -> Array:
        """Return the pressure at the candidates (n,) of the (scaled) body; zero outside."""
        result = np.zeros_like(reactions)
        moments = self.interpolation.T @ reactions[self.inside]
        smooth = self.interpolation @ cho_solve(self.factor, moments)
        result[self.inside] = smooth * self.root / (body.length * body.length)
        return result
