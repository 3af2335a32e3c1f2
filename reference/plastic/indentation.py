"""A rigid round indenter on an elastic-plastic half-space: loading, unloading and reloading.

The surface is held off the indenter by stiff springs at quadrature points; the sum of their forces
is the force, exactly. Each step minimises one convex potential (incremental plasticity, exterior,
springs): Newton's method with a line search on its slope converges from anywhere. Units: E = 1,
lengths in the contact radius that the mesh is made for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray
from scipy.sparse.linalg import splu

from reference.arguments import count_faults, refuse
from reference.errors import ConvergenceError
from reference.plastic.materials import PlasticMaterial, Points, Response, respond
from reference.plastic.section import Section

Array = NDArray[np.float64]

# Stiffness of the surface springs, in E* over the length of an element.
_SPRINGS = 100.0
_ROUNDS, _SEARCHES, _HALVINGS = 30, 12, 6
# Radii of the largest contact within which the surface may be touched.
_TOUCHABLE = 1.25
# Unbalanced forces, relative to the force on the indenter.
TOLERANCE = 1e-8


class OutgrownError(ConvergenceError):
    """A contact is larger than its mesh was made for: a wider one may hold it."""


@dataclass(frozen=True)
class State:
    """What an indentation has come to.

    Attributes
    ----------
    penetration, force : float
    peak : float
        Largest force so far.
    unknowns : ndarray
        Displacements, and the amplitude of the exterior.
    points : Points
        Plastic strains.
    stress : ndarray, shape (elements, points, 4)
    elastic, dissipated, work : float
        Elastic energy with that of the exterior and of the springs, dissipation, and the work of
        the force; each integrated along the steps.
    iterations : int
        Newton steps so far.
    residual : float
        Unbalanced forces over the force.
    rate : ndarray or None
        Change of the unknowns per penetration in the last step: where the next one starts from.
    """

    penetration: float
    force: float
    unknowns: Array
    points: Points
    stress: Array
    peak: float = 0.0
    elastic: float = 0.0
    dissipated: float = 0.0
    work: float = 0.0
    iterations: int = 0
    residual: float = 0.0
    rate: Array | None = None


@dataclass(frozen=True)
class _Balance:
    """Forces at some displacements: what is out of balance, and what it comes from."""

    residual: Array
    response: Response
    overlap: Array
    force: float


@dataclass(frozen=True)
class _Target:
    """What a step shall reach: a penetration, or a force (0: no contact at all)."""

    depth: float | None = None
    force: float | None = None

    @property
    def lifted(self) -> bool:
        """Whether the indenter is gone."""
        return self.force == 0.0


class Indentation:
    """A half-space below a round shape.

    Parameters
    ----------
    material : PlasticMaterial
        With E = 1.
    shape : callable
        f(r) >= 0, the gap at first touch.
    per_radius : int
        Elements per contact radius.
    smallest : float
        Smallest contact radius that the mesh shall resolve; the largest is 1.

    Raises
    ------
    ValueError
        Lists all invalid arguments.
    """

    def __init__(
        self,
        material: PlasticMaterial,
        shape: Callable[[Array], Array],
        *,
        per_radius: int = 12,
        smallest: float = 1.0,
    ) -> None:
        faults = count_faults(2, per_radius=per_radius)
        if not 0 < smallest <= 1:
            faults.append(f"smallest must lie in (0, 1], not {smallest!r}")
        if material.elastic.youngs_modulus != 1:
            faults.append("the material must have E = 1")
        refuse(faults)
        nu = material.elastic.poisson_ratio
        self.material, self.shape = material, shape
        self.section = Section(smallest, 1.0, per_radius, nu)
        self.surface = self.section.surface(_TOUCHABLE)
        self.gap = np.asarray(shape(self.surface.radius), dtype=float)
        element = np.ptp(self.surface.radius, axis=1)[:, None]
        self.springs = _SPRINGS / (1 - nu**2) / element

    @property
    def virgin(self) -> State:
        """The state before anything."""
        shape = self.section.weight.shape
        nothing = np.zeros(self.section.size)
        return State(0.0, 0.0, nothing, Points.virgin(shape), np.zeros((*shape, 4)))

    def press(self, state: State, penetration: float) -> State:
        """Return the state at another penetration.

        Raises
        ------
        ConvergenceError
            If Newton's method fails on the smallest of steps.
        """
        return self._reach(state, _Target(depth=penetration))

    def push(self, state: State, force: float) -> State:
        """Return the state under another force; 0 lifts the indenter off, in one step.

        That is elastic but for some points: three steps in place of one leave a dent that differs
        by 4e-7 of its depth.

        Raises
        ------
        ConvergenceError
            If Newton's method fails on the smallest of steps.
        """
        return self._reach(state, _Target(force=force))

    def contact_radius(self, state: State) -> float:
        """Return the radius at which the surface parts from the indenter; 0 without contact."""
        radius, over = self.surface.radius.ravel(), self._over(state)
        touching = np.flatnonzero(over > 0)
        if state.force == 0 or touching.size == 0:
            return 0.0
        last = int(touching[-1])
        if last + 1 == radius.size:
            raise OutgrownError("the contact is larger than its mesh was made for")
        share = over[last] / (over[last] - over[last + 1])
        return float(radius[last] + share * (radius[last + 1] - radius[last]))

    def residual_depth(self, state: State) -> float:
        """Return the penetration at which an indenter would just touch the surface as it is."""
        return float((self.gap + self._sunk(state.unknowns)).min())

    def surface_shape(self, state: State) -> tuple[Array, Array]:
        """Return radii, and how far the surface there has gone into the body."""
        return self.surface.radius.ravel(), self._sunk(state.unknowns).ravel()

    def _over(self, state: State) -> Array:
        return (state.penetration - self.gap - self._sunk(state.unknowns)).ravel()

    def _reach(self, state: State, target: _Target, depth: int = 0) -> State:
        """Take one step, or two halves of it where it fails."""
        try:
            return self._step(state, target)
        except ConvergenceError:
            if depth == _HALVINGS or (target.lifted and state.force == 0):
                raise
        if target.depth is not None:
            middle = _Target(depth=(state.penetration + target.depth) / 2)
        else:
            assert target.force is not None
            middle = _Target(force=(state.force + target.force) / 2)
        return self._reach(self._reach(state, middle, depth + 1), target, depth + 1)

    def _step(self, state: State, target: _Target) -> State:
        """Find the balance at a target by Newton's method."""
        depth = state.penetration if target.depth is None else target.depth
        unknowns, history = state.unknowns, []
        if state.rate is not None and depth > state.penetration:
            unknowns = unknowns + (depth - state.penetration) * state.rate
        if target.force and not (depth - self.gap - self._sunk(unknowns) > 0).any():
            depth = self._touching(unknowns)
        for round_ in range(_ROUNDS):
            balance = self._balance(state, unknowns, depth, target.lifted, tangent=True)
            scale = max(balance.force, target.force or 0.0, 1e-3 * state.peak)
            lack = 0.0 if target.force is None else target.force - balance.force
            lack = 0.0 if target.lifted else lack
            size = float(np.hypot(np.linalg.norm(balance.residual), lack))
            history.append(size / scale if scale > 0 else size)
            if history[-1] <= TOLERANCE:
                if target.lifted:
                    depth = float((self.gap + self._sunk(unknowns)).min())
                reached = self._reached(state, unknowns, depth, balance)
                rounds = state.iterations + round_
                return replace(reached, iterations=rounds, residual=history[-1])
            step = self._direction(balance, lack, target)
            unknowns, depth = self._searched(state, (unknowns, depth), step, target)
        raise ConvergenceError("an elastic-plastic step does not come to balance", history)

    def _balance(
        self, state: State, unknowns: Array, depth: float, lifted: bool, *, tangent: bool
    ) -> _Balance:
        section, surface = self.section, self.surface
        response = respond(self.material, section.strain(unknowns), state.points, tangent=tangent)
        residual = section.forces(response.stress)
        residual[-1] += section.exterior * unknowns[-1]
        overlap = np.zeros(self.gap.shape)
        if not lifted:
            overlap = np.maximum(depth - self.gap - self._sunk(unknowns), 0.0)
        force = self.springs * overlap * surface.weight
        local = np.einsum("fpk,fp->fk", surface.shape, force)
        residual -= np.bincount(
            surface.unknowns.ravel(), weights=local.ravel(), minlength=residual.size
        )
        return _Balance(residual, response, overlap, float(force.sum()))

    def _sunk(self, unknowns: Array) -> Array:
        """Return how far the surface points have gone into the body."""
        return np.asarray((self.surface.shape @ unknowns[self.surface.unknowns][..., None])[..., 0])

    def _touching(self, unknowns: Array) -> float:
        """Return a depth at which some points touch, from where a force finds its own."""
        height = np.sort((self.gap + self._sunk(unknowns)).ravel())
        return float(height[min(2 * self.gap.shape[1], height.size - 1)])

    def _direction(self, balance: _Balance, lack: float, target: _Target) -> tuple[Array, float]:
        """Return Newton's step of the unknowns and of the penetration."""
        section, surface = self.section, self.surface
        assert balance.response.tangent is not None
        local = section.stiffness(balance.response.tangent)
        held = self.springs * surface.weight * (balance.overlap > 0)
        local[surface.element, 9:, 9:] += np.einsum(
            "fpi,fp,fpj->fij", surface.shape, held, surface.shape
        )
        factor = splu(
            section.matrix(local),
            permc_spec="MMD_AT_PLUS_A",
            diag_pivot_thresh=0.0,
            options={"SymmetricMode": True},
        )
        change = factor.solve(-balance.residual)
        if target.force is None or target.lifted:
            return change, 0.0
        column = np.zeros(section.size)
        np.add.at(column, surface.unknowns, np.einsum("fpi,fp->fi", surface.shape, held))
        by_depth = factor.solve(column)
        stiffness = held.sum() - column @ by_depth
        if not stiffness > 0:
            raise ConvergenceError("a force is prescribed where nothing touches")
        deeper = float((lack + column @ change) / stiffness)
        return change + deeper * by_depth, deeper

    def _searched(
        self, state: State, start: tuple[Array, float], step: tuple[Array, float], target: _Target
    ) -> tuple[Array, float]:
        """Go along a direction until the slope of the potential is a small part of the first."""
        (unknowns, depth), (change, deeper) = start, step

        def slope(share: float) -> float:
            there = self._balance(
                state,
                unknowns + share * change,
                depth + share * deeper,
                target.lifted,
                tangent=False,
            )
            lack = 0.0 if target.force is None else target.force - there.force
            return float(there.residual @ change - lack * deeper)

        first = slope(0.0)
        share, low, high = 1.0, (0.0, first), None
        for _ in range(_SEARCHES):
            value = slope(share)
            if abs(value) <= 0.5 * abs(first):
                break
            if value < 0:
                low = share, value
            else:
                high = share, value
            if high is None:
                share *= 2
            else:
                share = low[0] - low[1] * (high[0] - low[0]) / (high[1] - low[1])
                share = float(
                    np.clip(
                        share, low[0] + 0.1 * (high[0] - low[0]), high[0] - 0.1 * (high[0] - low[0])
                    )
                )
        return unknowns + share * change, depth + share * deeper

    def _reached(self, state: State, unknowns: Array, depth: float, balance: _Balance) -> State:
        """Return the state at a balance, with its energies."""
        weight, response = self.section.weight, balance.response
        elastic_strain = self.section.strain(unknowns) - response.points.strain
        stored = 0.5 * float((weight * (response.stress * elastic_strain).sum(-1)).sum())
        stored += 0.5 * self.section.exterior * unknowns[-1] ** 2
        pressed = 0.5 * self.springs * balance.overlap**2 * self.surface.weight
        more = response.points.amount - state.points.amount
        amounts = state.points.amount, response.points.amount
        resistance = 0.5 * sum(self.material.flow_stress(amount)[0] for amount in amounts)
        yielding = more > 0  # elsewhere the resistance may be infinite
        lost = float((weight * resistance * more)[yielding].sum()) if yielding.any() else 0.0
        way = depth - state.penetration
        return replace(
            state,
            penetration=depth,
            force=balance.force,
            peak=max(state.peak, balance.force),
            unknowns=unknowns,
            points=response.points,
            stress=response.stress,
            elastic=stored + float(pressed.sum()),
            dissipated=state.dissipated + lost,
            work=state.work + _work(state, depth, balance.force),
            rate=(unknowns - state.unknowns) / way if way > 0 else None,
        )


def _work(before: State, depth: float, force: float) -> float:
    """Return the work of a step: of a force that goes with a power of the depth while both rise."""
    way = depth - before.penetration
    if way <= 0 or before.penetration <= 0 or not 0 < before.force < force:
        return 0.5 * (before.force + force) * way
    power = np.log(force / before.force) / np.log(depth / before.penetration)
    risen = force * depth - before.force * before.penetration
    return float(risen / (power + 1))
