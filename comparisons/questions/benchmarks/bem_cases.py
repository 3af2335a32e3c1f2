"""The contact problems of the half-space benchmark: rough surfaces and Hertz, E* = 1."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from comparisons.peers.client import Problem
from reference import surfaces
from reference.contact import press as unilateral
from reference.contact.body import ElasticBody
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.loads import Load

HURST, SLOPE = 0.8, 0.1
# Target contact fractions of loads, and the accepted deviation.
MEDIUM, LIGHT = 0.225, 0.04
_BESIDE = 0.1


@dataclass(frozen=True)
class Case:
    """A problem that is set up again for every reading, because set-up is part of the cost.

    `target` is the largest acceptable fraction of the peer's time.
    """

    name: str
    gaps: np.ndarray
    spacing: tuple[float, float]
    periodic: bool
    control: str
    loads: np.ndarray
    target: float | None = None

    def operator(self) -> ElasticBody:
        """Return a new operator."""
        kind = PeriodicOperator if self.periodic else FreeOperator
        return kind(self.gaps.shape[1:], self.spacing, 1.0)

    def problem(self) -> Problem:
        """Return the problem for a peer."""
        return Problem(self.operator(), self.gaps, self.control, self.loads)

    def solve(self, tolerance: float) -> np.ndarray:
        """Solve all surfaces and loads with our own solver; return the violations (m, k)."""
        operator = self.operator()
        violations = []
        for gap in self.gaps:
            steps = unilateral.sweep(
                operator, gap, Load(self.control, self.loads), tolerance=tolerance
            )
            violations.append([contact.violation for contact in steps])
        return np.array(violations)


def rough(points: int, cutoff: int, fraction: float, target: float | None) -> Case:
    """Return a periodic self-affine surface at a load with the given contact fraction."""
    gap = surface(points, cutoff)
    force, reached = _force_at(gap, fraction)
    name = f"periodic {points}^2, cutoff {cutoff} cells, {reached:.1%} contact"
    return Case(name, gap[None], _spacing(points), True, "force", np.array([force]), target)


def sweep(points: int, cutoff: int, steps: int, target: float | None) -> Case:
    """Return the same surface under increasing forces up to the default contact fraction."""
    gap = surface(points, cutoff)
    force, reached = _force_at(gap, MEDIUM)
    name = f"periodic {points}^2, cutoff {cutoff} cells, {steps} loads to {reached:.1%} contact"
    loads = force * np.linspace(1 / steps, 1, steps)
    return Case(name, gap[None], _spacing(points), True, "force", loads, target)


def hertz(points: int, radius: int, target: float | None, *, cropped: bool) -> Case:
    """Return a paraboloid on a large free grid, with the contact radius given in cells.

    If cropped, the grid is the box of the geometric overlap (sqrt(2) contact radii), which contains
    the contact.
    """
    side = 2 * int(np.ceil(np.sqrt(2) * radius)) if cropped else points
    # Off-centre, because real surfaces lack the symmetry of the grid.
    x = np.arange(side) - side / 2 + 0.3
    gap = (x[:, None] ** 2 + x**2) / 2 / points
    force = 4 / 3 * (radius**3 / points)
    where = f"cropped to {side}^2" if cropped else f"{points}^2"
    name = f"free Hertz, {where}, contact radius {radius} cells"
    return Case(name, gap[None], (1.0, 1.0), False, "force", np.array([force]), target)


def ensemble(count: int, points: int, loads: int, target: float | None) -> Case:
    """Return free patches with all resolved waves, and forces up to half of E* A0 h'."""
    gaps = np.array([surface(points, 2, k) for k in range(count)])
    forces = SLOPE * np.geomspace(1e-3, 0.1, loads)
    name = f"{count} free {points}^2 patches x {loads} loads"
    return Case(name, gaps, _spacing(points), False, "force", forces, target)


def _spacing(points: int) -> tuple[float, float]:
    return (1 / points, 1 / points)


def surface(points: int, cutoff: int, realisation: int = 0) -> np.ndarray:
    """Return the gap of a periodic self-affine surface, in which `cutoff` cells are a wave."""
    heights = surfaces.self_affine(
        (points, points),
        (1.0, 1.0),
        surfaces.SelfAffine(hurst=HURST, rms_slope=SLOPE, short_cutoff=cutoff / points),
        seed=1,
        realisation=realisation,
    )
    return np.subtract(heights.max(), heights, out=heights)


def _force_at(gap: np.ndarray, fraction: float) -> tuple[float, float]:
    """Return a force with about the given fraction of cells in contact, and the actual fraction."""
    operator = PeriodicOperator(gap.shape, _spacing(len(gap)), 1.0)
    force = fraction * SLOPE / 2  # A/A0 = 2 F/(E* A0 h')
    while True:
        contact = unilateral.press(operator, gap, Load("force", force), tolerance=1e-3)
        reached = float(np.mean(contact.pressure > 0))
        if abs(reached / fraction - 1) < _BESIDE:
            return force, reached
        force *= fraction / reached
