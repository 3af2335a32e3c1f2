"""Partial slip of a frictional contact from its normal solution, for any loading path.

Cattaneo (1938) and Mindlin (1949) for spheres, Jaeger (1995, 1998) and Ciavarella (1998) for every
body of revolution: under a constant normal force the tangential tractions are mu times the
difference of two normal pressures of the same body,

    q(r) = mu [p(r; d) - p(r; d_c)],   G* u = mu E* (d - d_c),   F_x = mu [F(d) - F(d_c)],

and the stick area is the contact area at d_c. Along a path with reversals the tractions are a sum
of such terms, one per turning point still remembered, with twice the friction after the first: a
reversal must first undo the slip (Mindlin & Deresiewicz 1953).

Exact within two assumptions: no coupling of normal and tangential displacement (elastically similar
bodies, or nu = 1/2 on a rigid one), and friction that acts along x only; the true slip has a
component along y for nu > 0. For nu = 0 without coupling the second is exact, and the superposition
holds for every shape, also rough ones, because both operators are equal.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.special import ellipe, ellipk

from reference.arguments import poisson_faults, refuse
from reference.closed_form.form import Array, ClosedForm, require_positive

# A reversal smaller than the friction by this factor is below the rounding of the forces.
_ROUNDING = 16 * np.finfo(float).eps


def stiffness_ratio(half_x: float, half_y: float, poisson_ratio: float) -> float:
    """Return k_x/k_z of a sticking elliptic contact without coupling (Mindlin 1949).

    A traction ~ 1/sqrt(1 - (x/a)^2 - (y/b)^2) displaces the ellipse uniformly. At its centre, in
    polar coordinates, pressure and traction differ by the factor (1 - nu + nu cos^2)/(1 - nu) only,
    so

        k_x/k_z = (1 - nu)/(1 - nu + nu s),   s = <cos^2> = [K(m) - E(m)]/(m K(m)),

    m = 1 - b^2/a^2 for a >= b; for a < b, s is one minus the value of the exchanged axes. A circle
    has s = 1/2: (19.18).

    Parameters
    ----------
    half_x, half_y : float
        Semi-axes a along the tangential force and b transverse to it.
    poisson_ratio : float
        -1 < nu <= 1/2.

    Examples
    --------
    >>> round(stiffness_ratio(1.0, 1.0, 0.5), 12)  # 2 (1 - nu)/(2 - nu)
    0.666666666667
    """
    require_positive("stiffness ratio", half_x=half_x, half_y=half_y)
    refuse(poisson_faults(poisson_ratio))
    short, long = sorted((half_x, half_y))
    m = (1 - short / long) * (1 + short / long)
    # series for small m, where K - E loses digits
    share = (ellipk(m) - ellipe(m)) / (m * ellipk(m)) if m > 1e-5 else 0.5 + m / 16
    along = float(share if half_x >= half_y else 1 - share)
    return (1 - poisson_ratio) / (1 - poisson_ratio + poisson_ratio * along)


@dataclass(frozen=True)
class Layer:
    """One term of the superposition: sign * mu * factor * [p(d) - p(d_c)]."""

    sign: float
    factor: float
    inner_force: float


class PartialSlip:
    """A contact under constant normal force and any tangential path.

    Parameters
    ----------
    form : ClosedForm
        The normal contact; the result is exact for axisymmetric ones only.
    penetration : float
        d, positive.
    friction : float
        mu.
    modulus_ratio : float
        G*/E*, 2 (1 - nu)/(2 - nu) for one elastic body on a rigid one.

    Raises
    ------
    ValueError
        If an argument is not positive and finite.

    Examples
    --------
    Cattaneo-Mindlin: c = a (1 - F_x/(mu F))^(1/3).

    >>> from reference.closed_form import paraboloid
    >>> slip = PartialSlip(paraboloid(1.0, 1.0), penetration=1.0, friction=0.5, modulus_ratio=0.8)
    >>> round(float(slip.along([7 / 12]).stick_radius[0]), 12)
    0.5
    """

    def __init__(
        self, form: ClosedForm, penetration: float, friction: float, modulus_ratio: float
    ) -> None:
        require_positive(
            "partial slip", penetration=penetration, friction=friction, modulus_ratio=modulus_ratio
        )
        self.form, self.penetration = form, float(penetration)
        self.friction, self.modulus_ratio = float(friction), float(modulus_ratio)
        self.force = float(form.force(penetration))

    @property
    def limit(self) -> float:
        """Tangential force mu F of full sliding."""
        return self.friction * self.force

    @property
    def sliding_displacement(self) -> float:
        """Displacement mu d E*/G* at which full sliding begins in first loading."""
        return self.friction * self.penetration / self.modulus_ratio

    def along(self, tangential_force: ArrayLike) -> PartialSlipPath:
        """Return the response along a path of tangential forces.

        Parameters
        ----------
        tangential_force : array_like, shape (k,)
            Values in order, at most mu F; the force is monotone between them.

        Raises
        ------
        ValueError
            If a force is not finite or above mu F.
        """
        path = np.atleast_1d(np.asarray(tangential_force, dtype=float))
        if not (np.abs(path) <= self.limit * (1 + _ROUNDING)).all():
            raise ValueError(
                f"tangential forces must be finite and at most mu F = {self.limit!r}, "
                f"not {tangential_force!r}"
            )
        states: list[tuple[Layer, ...]] = []
        layers: tuple[Layer, ...] = ()
        at = 0.0
        for goal in np.clip(path, -self.limit, self.limit):
            layers = self._loaded(layers, at, float(goal))
            states.append(layers)
            at = float(goal)
        return PartialSlipPath(self, path, tuple(states))

    def _loaded(self, layers: tuple[Layer, ...], at: float, goal: float) -> tuple[Layer, ...]:
        """Return the terms after a monotone change of the force from `at` to `goal`.

        The new slip zone grows into the stick zone from its rim: older terms inside the new slip
        zone are forgotten.
        """
        if abs(goal - at) <= _ROUNDING * self.limit:
            return layers
        sign = 1.0 if goal > at else -1.0
        remaining = list(layers)
        if remaining and remaining[-1].sign == sign:
            remaining.pop()
        while True:
            factor = 1.0 if not remaining else 2.0
            missing = sign * (goal - sum(self._carried(layer) for layer in remaining))
            inner = max(self.force - missing / (factor * self.friction), 0.0)
            if not remaining or inner > remaining[-1].inner_force:
                return (*remaining, Layer(sign, factor, inner))
            # extends further in than the last term: that one and the one before are forgotten
            remaining.pop()
            if remaining and remaining[-1].sign == sign:
                remaining.pop()

    def _carried(self, layer: Layer) -> float:
        return layer.sign * layer.factor * self.friction * (self.force - layer.inner_force)


@dataclass(frozen=True)
class PartialSlipPath:
    """Exact response along a path of tangential forces; arrays have shape (k,).

    Attributes
    ----------
    contact : PartialSlip
    tangential_force : ndarray
    layers : tuple of tuples of Layer
        Terms of the tractions at the points.
    """

    contact: PartialSlip
    tangential_force: Array
    layers: tuple[tuple[Layer, ...], ...]

    @property
    def tangential_displacement(self) -> Array:
        """u, relative to the undeformed half-space."""
        contact = self.contact
        scale = contact.friction / contact.modulus_ratio
        return np.array(
            [
                scale
                * sum(
                    layer.sign * layer.factor * (contact.penetration - self._inner(layer))
                    for layer in layers
                )
                for layers in self.layers
            ]
        )

    @property
    def stick_radius(self) -> Array:
        """Radius of the stick area on arrival at the points."""
        form = self.contact.form
        if form.contact_radius is None:
            raise ValueError(f"{form.name}: the stick area is no circle")
        inner = [self._inner(layers[-1]) if layers else None for layers in self.layers]
        depth = self.contact.penetration
        return np.array([float(form.contact_radius(depth if d is None else d)) for d in inner])

    def traction(self, x: ArrayLike, y: ArrayLike, point: int = -1) -> Array:
        """Traction q along x at points, after the point of the path with this index."""
        form, depth = self.contact.form, self.contact.penetration
        pressure = form.pressure(x, y, depth)
        total = np.zeros(np.shape(pressure))
        for layer in self.layers[point]:
            inner = form.pressure(x, y, self._inner(layer))
            total += layer.sign * layer.factor * self.contact.friction * (pressure - inner)
        return total

    def _inner(self, layer: Layer) -> float:
        """Return the penetration d_c whose contact area is the stick area of a term."""
        return float(self.contact.form.penetration(layer.inner_force))
