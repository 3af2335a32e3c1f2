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
from reference.plastic.j2 import PlasticMaterial, Points, respond

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
class PlasticState:
    """An indentation at one load.

    `unknowns` are displacements and the amplitude of the exterior, `stress` is (elements, points,
    components), `peak` the largest force so far. `elastic` is the energy with that of the exterior
    and of the springs; dissipation and the work of the force are integrated along the steps.
    `iterations` counts Newton's steps so far; `residual` is the unbalanced forces over the force.
    The next step starts from `rate`, the change of the unknowns per penetration in the last one.
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


class Indentation:
    """A half-space of E = 1 below a shape: f(r), or f(x, y) >= 0, the gap at first touch."""

    def __init__(
        self, material: PlasticMaterial, shape: Callable[..., Array], mesh: Elements
    ) -> None:
        if material.elastic.youngs_modulus != 1:
            refuse(["the material must have E = 1"])
        nu = material.elastic.poisson_ratio
        self.material, self.shape, self.mesh = material, shape, mesh
        self.gap = np.asarray(shape(*mesh.surface.place), dtype=float)
        self.springs = _SPRINGS / (1 - nu**2) / mesh.surface.length[:, None]

    @property
    def virgin(self) -> PlasticState:
        """The state before anything."""
        mesh, shape = self.mesh, self.mesh.weight.shape
        points = Points.virgin(shape, mesh.components)
        stress = np.zeros((*shape, mesh.components))
        return PlasticState(0.0, 0.0, np.zeros(mesh.size), points, stress)

    def press(self, state: PlasticState, penetration: float) -> PlasticState:
        """Return the state at another penetration."""
        return self._reach(state, penetration, None)

    def push(self, state: PlasticState, force: float) -> PlasticState:
        """Return the state under another force; 0 lifts the indenter off, in one step.

        That is elastic but for some points: three steps in place of one leave a dent that differs
        by 4e-7 of its depth.
        """
        return self._reach(state, None, force)

    def counted_area(self, state: PlasticState) -> float:
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

    def contact_area(self, state: PlasticState) -> float:
        """Return the area of contact; of one that is not round as it is counted.

        A round one starts to unload with dF/dd = 2 E* a, whatever has yielded (Pharr, Oliver &
        Brotzen 1992). Its edge sticks within elements, which the unloading passes: F^(2/3), linear
        on Hertz's ball, is a parabola of d over it.
        """
        area = self.counted_area(state)
        if area == 0 or not self.mesh.hoop:
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

    def residual_depth(self, unknowns: Array) -> float:
        """Return the penetration at which an indenter would just touch the surface as it is."""
        return float((self.gap + self.mesh.surface.sunk(unknowns)).min())

    def _reach(
        self, state: PlasticState, depth: float | None, force: float | None, halvings: int = 0
    ) -> PlasticState:
        """Take one step to a depth, or to a force, or two halves of it where it fails."""
        try:
            return self._newton(state, depth, force)
        except ConvergenceError:
            if halvings == _HALVINGS or (force == 0 and state.force == 0):
                raise
        half_depth = None if depth is None else (state.penetration + depth) / 2
        half_force = None if force is None else (state.force + force) / 2
        half_way = self._reach(state, half_depth, half_force, halvings + 1)
        return self._reach(half_way, depth, force, halvings + 1)

    def _newton(
        self, state: PlasticState, target: float | None, force: float | None
    ) -> PlasticState:
        """Find the balance at a depth, or under a force, by Newton's method with a line search.

        Under a force the depth is an unknown, too; without any (0) the indenter is gone.
        """
        mesh, surface, lifted = self.mesh, self.mesh.surface, force == 0
        forced = force is not None and not lifted
        depth = state.penetration if target is None else target
        unknowns, history = state.unknowns, []
        if state.rate is not None and depth > state.penetration:
            unknowns = unknowns + (depth - state.penetration) * state.rate
        if forced and not (depth - self.gap - surface.sunk(unknowns) > 0).any():
            # from where some points touch a force finds its depth
            height = np.sort((self.gap + surface.sunk(unknowns)).ravel())
            depth = float(height[min(2 * self.gap.shape[1], height.size - 1)])
        for rounds in range(_ROUNDS):
            # what is out of balance: forces on the unknowns, and the prescribed one
            residual, overlap, carried, (stress, points, tangent) = self._balance(
                state, unknowns, depth, lifted=lifted, tangent=True
            )
            lack = force - carried if forced and force is not None else 0.0
            scale = max(carried, force or 0.0, 1e-3 * state.peak)
            size = float(np.hypot(np.linalg.norm(residual), lack))
            history.append(size / scale if scale > 0 else size)
            if history[-1] <= TOLERANCE:
                if lifted:
                    depth = self.residual_depth(unknowns)
                return replace(
                    self._balanced(state, unknowns, depth, carried, overlap, stress, points),
                    iterations=state.iterations + rounds,
                    residual=history[-1],
                )
            # Newton's direction, of the unknowns and of the depth
            assert tangent is not None
            held = self.springs * surface.weight * (overlap > 0)
            solve = mesh.factorised(tangent, held)
            change, deeper = solve(-residual), 0.0
            if forced:
                column = np.zeros(mesh.size)
                np.add.at(column, surface.unknowns, np.einsum("fpi,fp->fi", surface.shape, held))
                by_depth = solve(column)
                stiffness = held.sum() - column @ by_depth
                if not stiffness > 0:
                    raise ConvergenceError("a force is prescribed where nothing touches")
                deeper = float((lack + column @ change) / stiffness)
                change = change + deeper * by_depth
            # line search: until the slope of the potential is half of the first at most
            first = float(residual @ change - lack * deeper)
            share, low, high = 1.0, (0.0, first), None
            for _ in range(_SEARCHES):
                residual, _, carried, _ = self._balance(
                    state,
                    unknowns + share * change,
                    depth + share * deeper,
                    lifted=lifted,
                    tangent=False,
                )
                lack = 0.0 if force is None else force - carried
                slope = float(residual @ change - lack * deeper)
                if abs(slope) <= 0.5 * abs(first):
                    break
                if slope < 0:
                    low = share, slope
                else:
                    high = share, slope
                if high is None:
                    share *= 2
                    continue
                # regula falsi, a tenth of the bracket away from its ends
                width = high[0] - low[0]
                share = low[0] - low[1] * width / (high[1] - low[1])
                share = float(np.clip(share, low[0] + 0.1 * width, high[0] - 0.1 * width))
            unknowns, depth = unknowns + share * change, depth + share * deeper
        raise ConvergenceError("an elastic-plastic step does not come to balance", history)

    def _balance(
        self, state: PlasticState, unknowns: Array, depth: float, *, lifted: bool, tangent: bool
    ) -> tuple[Array, Array, float, tuple[Array, Points, Array | None]]:
        """Return unbalanced forces, overlaps with the indenter, its force, and the response."""
        mesh, surface = self.mesh, self.mesh.surface
        response = respond(self.material, mesh.strain(unknowns), state.points, tangent=tangent)
        residual = mesh.forces(response[0])
        residual[-1] += mesh.exterior * unknowns[-1]
        overlap = np.zeros(self.gap.shape)
        if not lifted:
            overlap = np.maximum(depth - self.gap - surface.sunk(unknowns), 0.0)
        force = self.springs * overlap * surface.weight
        local = np.einsum("fpk,fp->fk", surface.shape, force)
        residual -= np.bincount(
            surface.unknowns.ravel(), weights=local.ravel(), minlength=residual.size
        )
        return residual, overlap, float(force.sum()), response

    def _balanced(
        self,
        state: PlasticState,
        unknowns: Array,
        depth: float,
        force: float,
        overlap: Array,
        stress: Array,
        points: Points,
    ) -> PlasticState:
        """Return the next state, with its energies."""
        weight, surface = self.mesh.weight, self.mesh.surface
        elastic_strain = self.mesh.strain(unknowns) - points.strain
        stored = 0.5 * float((weight * (stress * elastic_strain).sum(-1)).sum())
        stored += 0.5 * self.mesh.exterior * unknowns[-1] ** 2
        elastic = stored + float((0.5 * self.springs * overlap**2 * surface.weight).sum())
        more = points.amount - state.points.amount
        yielding = more > 0  # elsewhere the resistance may be infinite
        lost = 0.0
        if yielding.any():
            before, after = (self.material.flow_stress(p.amount)[0] for p in (state.points, points))
            lost = float((weight * (0.5 * (before + after)) * more)[yielding].sum())
        if state.peak == 0 and not yielding.any():
            work = elastic - state.elastic  # of a potential, whatever the path
        else:
            # without a force no work is done on the way to the touch
            start, end = state.penetration, depth
            if state.peak and not state.force > 0:
                start = max(start, self.residual_depth(state.unknowns))
            if state.peak and not force > 0:
                end = max(end, self.residual_depth(unknowns))
            if 0 < start < end and 0 < state.force < force:
                # as both rise the force goes with a power of the depth
                power = np.log(force / state.force) / np.log(end / start)
                work = float((force * end - state.force * start) / (power + 1))
            else:
                work = elastic_work(end - start, (state.force, force))
        way = depth - state.penetration
        return replace(
            state,
            penetration=depth,
            force=force,
            peak=max(state.peak, force),
            unknowns=unknowns,
            points=points,
            stress=stress,
            elastic=elastic,
            dissipated=state.dissipated + lost,
            work=state.work + work,
            rate=(unknowns - state.unknowns) / way if way > 0 else None,
        )


def elastic_work(way: float, forces: tuple[float, float]) -> float:
    """Return the work of a force whose power 2/3 is linear along a way.

    That is exact for a ball on an elastic surface, and nearly so on a dented one.

    Examples
    --------
    >>> round(elastic_work(1.0, (0.0, 1.0)), 12)
    0.4
    """
    before, force = (float(f) ** (2 / 3) for f in forces)
    if before == force:
        return way * forces[0]
    return float(0.4 * way * (force**2.5 - before**2.5) / (force - before))
