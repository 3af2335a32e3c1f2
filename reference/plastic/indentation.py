"""A rigid indenter on an elastic-plastic half-space: loading, unloading and reloading.

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

from reference.arguments import refuse
from reference.errors import ConvergenceError
from reference.plastic.elements import Elements
from reference.plastic.materials import PlasticMaterial, Points, Response, respond

Array = NDArray[np.float64]

# Stiffness of the surface springs, in E* over the length of an element.
_SPRINGS = 100.0
_ROUNDS, _SEARCHES, _HALVINGS = 30, 12, 6
# Forces of an unloading, over the first, whose beginning has the stiffness of the contact.
_UNLOADED = np.arange(0.9, 0.25, -0.1)
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
    """A half-space below a shape.

    Parameters
    ----------
    material : PlasticMaterial
        With E = 1.
    shape : callable
        f(r), or f(x, y) >= 0, the gap at first touch.
    mesh : Elements
        Round or in three dimensions, for that Poisson's ratio.

    Raises
    ------
    ValueError
        If E is another one.
    """

    def __init__(
        self, material: PlasticMaterial, shape: Callable[..., Array], mesh: Elements
    ) -> None:
        if material.elastic.youngs_modulus != 1:
            refuse(["the material must have E = 1"])
        nu = material.elastic.poisson_ratio
        self.material, self.shape, self.mesh = material, shape, mesh
        self.surface = mesh.surface()
        self.gap = np.asarray(shape(*self.surface.place), dtype=float)
        self.springs = _SPRINGS / (1 - nu**2) / self.surface.length[:, None]

    @property
    def virgin(self) -> State:
        """The state before anything."""
        mesh, shape = self.mesh, self.mesh.weight.shape
        points = Points.virgin(shape, mesh.components)
        return State(0.0, 0.0, np.zeros(mesh.size), points, np.zeros((*shape, mesh.components)))

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

    def counted_area(self, state: State) -> float:
        """Return the area within which the surface touches; 0 without contact.

        Raises
        ------
        OutgrownError
            If it reaches the end of what may be touched.
        """
        if state.force == 0:
            return 0.0
        area = self.mesh.contact_area(self.shape, state.penetration, state.unknowns)
        if not np.isfinite(area):
            raise OutgrownError("the contact is larger than its mesh was made for")
        return area

    def contact_area(self, state: State) -> float:
        """Return the area of contact; of one that is not round as it is counted.

        A round one starts to unload with dF/dd = 2 E* a, whatever has yielded (Pharr, Oliver &
        Brotzen 1992). Its edge sticks within elements, which the unloading passes: F^(2/3), linear
        on Hertz's ball, is a parabola of d over it.

        Raises
        ------
        ConvergenceError
            As `push`; `OutgrownError` as `counted_area`.
        """
        area = self.counted_area(state)
        if area == 0 or len(self.mesh.place) == 3:
            return area
        states = [state]
        for share in _UNLOADED:
            states.append(self.push(states[-1], share * state.force))
        risen = np.array([s.penetration - state.penetration for s in states])
        root = np.array([s.force / state.force for s in states]) ** (2 / 3)
        unit = -risen[-1]
        _, slope, start = np.polyfit(risen / unit, root, 2)
        stiffness = 1.5 * np.sqrt(start) * slope * state.force / unit
        return float(np.pi * (stiffness * (1 - self.material.elastic.poisson_ratio**2) / 2) ** 2)

    def residual_depth(self, state: State) -> float:
        """Return the penetration at which an indenter would just touch the surface as it is."""
        return self._touch(state.unknowns)

    def surface_shape(self, state: State) -> tuple[Array, Array]:
        """Return places on the surface (1 or 2, n), and how far it has gone into the body there."""
        place = self.surface.place
        return place.reshape(len(place), -1), self._sunk(state.unknowns).ravel()

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
                    depth = self._touch(unknowns)
                reached = self._reached(state, unknowns, depth, balance)
                rounds = state.iterations + round_
                return replace(reached, iterations=rounds, residual=history[-1])
            step = self._direction(balance, lack, target)
            first = float(balance.residual @ step[0] - lack * step[1])
            unknowns, depth = self._searched(state, (unknowns, depth), step, target, first)
        raise ConvergenceError("an elastic-plastic step does not come to balance", history)

    def _balance(
        self, state: State, unknowns: Array, depth: float, lifted: bool, *, tangent: bool
    ) -> _Balance:
        mesh, surface = self.mesh, self.surface
        response = respond(self.material, mesh.strain(unknowns), state.points, tangent=tangent)
        residual = mesh.forces(response.stress)
        residual[-1] += mesh.exterior * unknowns[-1]
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

    def _touch(self, unknowns: Array) -> float:
        """Return the penetration at which the indenter just touches the surface as it is."""
        return float((self.gap + self._sunk(unknowns)).min())

    def _touching(self, unknowns: Array) -> float:
        """Return a depth at which some points touch, from where a force finds its own."""
        height = np.sort((self.gap + self._sunk(unknowns)).ravel())
        return float(height[min(2 * self.gap.shape[1], height.size - 1)])

    def _direction(self, balance: _Balance, lack: float, target: _Target) -> tuple[Array, float]:
        """Return Newton's step of the unknowns and of the penetration."""
        mesh, surface = self.mesh, self.surface
        assert balance.response.tangent is not None
        local = mesh.stiffness(balance.response.tangent)
        held = self.springs * surface.weight * (balance.overlap > 0)
        down = mesh.into_body
        local[surface.element, down, down] += np.einsum(
            "fpi,fp,fpj->fij", surface.shape, held, surface.shape
        )
        solve = mesh.solver(local)
        change = solve(-balance.residual)
        if target.force is None or target.lifted:
            return change, 0.0
        column = np.zeros(mesh.size)
        np.add.at(column, surface.unknowns, np.einsum("fpi,fp->fi", surface.shape, held))
        by_depth = solve(column)
        stiffness = held.sum() - column @ by_depth
        if not stiffness > 0:
            raise ConvergenceError("a force is prescribed where nothing touches")
        deeper = float((lack + column @ change) / stiffness)
        return change + deeper * by_depth, deeper

    def _searched(
        self,
        state: State,
        start: tuple[Array, float],
        step: tuple[Array, float],
        target: _Target,
        first: float,
    ) -> tuple[Array, float]:
        """Go along a direction until the slope of the potential is half of the first at most."""
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
        weight, response = self.mesh.weight, balance.response
        elastic_strain = self.mesh.strain(unknowns) - response.points.strain
        stored = 0.5 * float((weight * (response.stress * elastic_strain).sum(-1)).sum())
        stored += 0.5 * self.mesh.exterior * unknowns[-1] ** 2
        pressed = 0.5 * self.springs * balance.overlap**2 * self.surface.weight
        more = response.points.amount - state.points.amount
        amounts = state.points.amount, response.points.amount
        resistance = 0.5 * sum(self.material.flow_stress(amount)[0] for amount in amounts)
        yielding = more > 0  # elsewhere the resistance may be infinite
        lost = float((weight * resistance * more)[yielding].sum()) if yielding.any() else 0.0
        way = depth - state.penetration
        elastic = stored + float(pressed.sum())
        if state.peak == 0 and not yielding.any():
            work = elastic - state.elastic  # of a potential, whatever the path
        else:
            work = self._work(state, unknowns, depth, balance.force)
        return replace(
            state,
            penetration=depth,
            force=balance.force,
            peak=max(state.peak, balance.force),
            unknowns=unknowns,
            points=response.points,
            stress=response.stress,
            elastic=elastic,
            dissipated=state.dissipated + lost,
            work=state.work + work,
            rate=(unknowns - state.unknowns) / way if way > 0 else None,
        )

    def _work(self, state: State, unknowns: Array, depth: float, force: float) -> float:
        """Return the work of a step: of a force that goes with a power of the depth as both rise.

        Of a body that nothing has pressed before, with that of a ball on an elastic surface.
        """
        # without a force nothing is done on the way to the touch
        start, end = (
            at if f > 0 or not state.peak else max(at, self._touch(u))
            for at, f, u in (
                (state.penetration, state.force, state.unknowns),
                (depth, force, unknowns),
            )
        )
        if not (0 < start < end and 0 < state.force < force):
            return elastic_work(end - start, (state.force, force))
        power = np.log(force / state.force) / np.log(end / start)
        return float((force * end - state.force * start) / (power + 1))


def elastic_work(way: float, forces: tuple[float, float]) -> float:
    """Return the work of a force whose power 2/3 is linear along a way.

    That is exact for a ball on an elastic surface, which what is dented nearly is.

    Examples
    --------
    >>> round(elastic_work(1.0, (0.0, 1.0)), 12)
    0.4
    """
    before, force = (float(f) ** (2 / 3) for f in forces)
    if before == force:
        return way * forces[0]
    return float(0.4 * way * (force**2.5 - before**2.5) / (force - before))
