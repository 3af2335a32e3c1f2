"""One contact at any load on one condensed body: the mesh is scaled with the contact.

A half-space has no length scale, so a mesh scaled by s has its compliance divided by s, and the
mesh circle can be placed on the contact edge at every load without a new condensation. The contact
area is that with the largest force at a given penetration (Barber 1974, *Int. J. Eng. Sci.* 12,
813), which gives s; the active set on the scaled body then confirms or corrects it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize_scalar

from reference.arguments import choice_faults, refuse
from reference.errors import ConvergenceError
from reference.fem.body import CondensedBody
from reference.fem.contact import CONTROLS, EXACT, Contact, Enforcement, press
from reference.fem.contact_area import fitted_area
from reference.fem.quadrature_contact import at_quadrature_points
from reference.fem.surface_pressure import RingPressure
from reference.loads import LoadPath

Shape = Callable[[NDArray[np.float64], NDArray[np.float64]], NDArray[np.float64]]


def indent(
    body: CondensedBody,
    shape: Shape,
    load: LoadPath,
    enforcement: Enforcement = EXACT,
    *,
    points: str = "nodes",
) -> Iterator[tuple[CondensedBody, Contact]]:
    """Solve a single convex contact, with the mesh fitted to the contact at every load.

    Parameters
    ----------
    body : CondensedBody
        From a `RingMesh`, best with ``edge=contact_radius``; its size is arbitrary, but its
        `stretch` determines the aspect ratio of the contact.
    shape : callable
        Initial gap ``g(x, y)`` of arrays; +inf outside a sharp edge. Even in x and y for a quarter.
    load : LoadPath
        ``"penetration"`` or ``"force"``, positive.
    enforcement : Enforcement
        As in `press`.
    points : {"nodes", "quadrature"}
        Points of the contact conditions; "quadrature" (`at_quadrature_points`) needs the method
        "penalty".

    Yields
    ------
    (CondensedBody, Contact)
        The body scaled to this load, with its `points` for nodal values.
        ``contact_area`` is that of the ellipse with the stiffness of the contact set; if that is
        the mesh circle, ``pressure`` is a weighted projection (`RingPressure`).

    Raises
    ------
    ValueError
        For invalid loads, a body without rings, or a shape without the symmetry of the mesh.
    ConvergenceError
        If no size of the mesh carries the load, or every size does because the gap does not
        increase.

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
    return _steps(_Ring(body, shape), pressed, load, enforcement)


def _steps(
    ring: _Ring, body: CondensedBody, load: LoadPath, enforcement: Enforcement
) -> Iterator[tuple[CondensedBody, Contact]]:
    sized = ring.size_for_force if load.control == "force" else ring.size_for_penetration
    for value in load.values:
        size = sized(value)
        fitted = body.scaled(size)
        gap = ring.gap(size, fitted.points)
        start = fitted.inside_ring & np.isfinite(gap)
        step = next(press(fitted, gap, LoadPath(load.control, value), enforcement, start=start))
        if np.isfinite(gap).all():
            area = fitted_area(fitted.nodal or fitted, step.stiffness)
            step = replace(step, contact_area=area)
            if fitted.nodal is None and np.array_equal(step.active, fitted.inside_ring):
                pressure = ring.projection.pressure(fitted, step.reactions)
                step = replace(step, pressure=pressure)
        yield fitted, step


class _Ring:
    """Force and penetration for contact within the mesh circle, as functions of the mesh size."""

    def __init__(self, body: CondensedBody, shape: Shape) -> None:
        inside = body.inside_ring
        unit = np.ones((int(inside.sum()), 1))
        forces, _ = body.flexibility.respond(np.flatnonzero(inside), unit, 0.0 * unit[:, 0])
        self.body = body
        self.shape = shape
        self.points = body.points[inside]
        self._check_symmetry()
        self.forces = forces[:, 0] * body.symmetry
        self.modulus = body.youngs_modulus * body.length

    def _check_symmetry(self) -> None:
        """Raise an error for gaps without the symmetry of the mesh."""
        gap = self.gap(1.0)
        noise = 1e-9 * np.abs(gap[np.isfinite(gap)]).max(initial=0.0)
        for axis in np.flatnonzero(self.body.grid.planes):
            mirror = np.where(np.arange(2) == axis, -1.0, 1.0)
            mirrored = self.gap(1.0, self.points * mirror)
            if not np.allclose(gap, mirrored, rtol=0.0, atol=noise, equal_nan=True):
                raise ValueError(
                    f"the gap must be even in {'xy'[axis]}, of which only the positive side is "
                    "meshed; centre the shape, or build the body with symmetry = 'none'"
                )

    @cached_property
    def projection(self) -> RingPressure:
        """Projection from nodal forces to pressure, for any size of the mesh."""
        return RingPressure(self.body, float(self.forces.sum()) * self.modulus)

    def gap(self, size: float, points: NDArray[np.float64] | None = None) -> NDArray[np.float64]:
        x, y = (self.points * size if points is None else points).T
        with np.errstate(over="ignore", invalid="ignore"):  # gaps may overflow at large distances
            gaps = np.asarray(self.shape(x, y), dtype=float)
        if gaps.shape != x.shape:
            raise ValueError(f"shape must return one gap per point {x.shape}, got {gaps.shape}")
        return gaps

    def size_for_penetration(self, penetration: float) -> float:
        """Maximise ``F(s) = E s (d sum v - v . g(s x))``."""

        def loss(size: float) -> float:
            return -size * float(self.forces @ (penetration - self.gap(size)))

        return self._minimum(loss)

    def size_for_force(self, force: float) -> float:
        """Minimise ``d(s) = (F/(E s) + v . g(s x)) / sum v``."""

        def loss(size: float) -> float:
            return force / (self.modulus * size) + float(self.forces @ self.gap(size))

        return self._minimum(loss)

    def _minimum(self, loss: Callable[[float], float]) -> float:
        low, high = self._bracket(loss)
        edge = self._largest_finite(low, high)
        minimum = minimize_scalar(
            lambda power: loss(2.0**power),
            bounds=(np.log2(low), np.log2(edge)),
            method="bounded",
            options={"xatol": 1e-9},
        )
        return min((2.0**minimum.x, edge), key=loss)

    def _bracket(self, loss: Callable[[float], float]) -> tuple[float, float]:
        """Return a bracket of the minimum by factors of two, from a size with a finite gap."""
        powers = (p for k in range(200) for p in (k, -k) if self._finite(2.0**p))
        power = next(powers, None)
        if power is None:
            raise ConvergenceError("the gap is infinite at every size of the contact")
        value = loss(2.0**power)
        for step in (1, -1):
            for _ in range(400):
                trial = power + step
                if not self._finite(2.0**trial) or (new := loss(2.0**trial)) >= value:
                    break
                power, value = trial, new
            else:
                raise ConvergenceError("the contact grows without end: the shape does not rise")
        return 2.0 ** (power - 1), 2.0 ** (power + 1)

    def _finite(self, size: float) -> bool:
        return bool(np.isfinite(self.gap(size)).all())

    def _largest_finite(self, low: float, high: float) -> float:
        """Return the largest size at which no point inside the circle is beyond a sharp edge."""
        if self._finite(high):
            return high
        while low < (middle := 0.5 * (low + high)) < high:
            low, high = (middle, high) if self._finite(middle) else (low, middle)
        return low
