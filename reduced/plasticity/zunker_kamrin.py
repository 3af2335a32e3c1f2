"""Springs of an elastic-perfectly plastic ball by Zunker & Kamrin (2024, J. Mech. Phys. Solids).

Their particle is itself deformable and pressed by rigid flats: a rigid ball in a half-space only
while a << R (Jackson & Kogut 2006).

Until the mean pressure of Hertz's contact reaches p_Y the ball is Hertz's. Beyond, the pressure is
uniform, p_Y, whose springs carry q = 2 p_Y sqrt(a^2 - x^2) per length; the area goes on with the
slope 2 pi R of a rigid-plastic ball; and unloading is elastic, of an ellipse of the depth
2 p_Y a/E*.
"""

from __future__ import annotations

import numpy as np

from reduced.arguments import positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.loads import LoadPath
from reduced.plasticity.caps import Yielded, is_forced
from reduced.profiles.section import bisect

_ROUNDS = 200


class ZunkerKamrin:
    """An elastic-perfectly plastic ball: a sphere, overlap 2 R d - d^2, or a paraboloid, 2 R d."""

    def __init__(
        self, radius: float, effective_modulus: float, yield_stress: float, *, sphere: bool = False
    ) -> None:
        refuse(
            positive_faults(
                radius=radius, effective_modulus=effective_modulus, yield_stress=yield_stress
            )
        )
        self.radius, self.modulus, self.yield_stress = radius, effective_modulus, yield_stress
        self._sphere, self._reach = sphere, radius if sphere else np.inf
        # where the mean pressure of Hertz's contact is p_Y
        self.yields_at = 0.0
        for _ in range(_ROUNDS):
            mean = 3 * np.pi * self.pressure(self.yields_at) / (4 * self.modulus)
            before, self.yields_at = self.yields_at, float(mean**2 * self.radius)
            if abs(self.yields_at - before) <= 1e-14 * self.yields_at:
                break
        else:
            raise ConvergenceError("the mean pressure never reaches that of full yield")

    def pressure(self, deepest: float) -> float:
        """Return p_Y = Y (1.75 exp(-4.4 d_max/R) + 1)."""
        return self.yield_stress * float(1.75 * np.exp(-4.4 * deepest / self.radius) + 1)

    def widest(self, deepest: float) -> float:
        """Return the contact radius at a largest penetration."""
        if self._sphere and deepest > self.radius:
            raise ValueError(
                f"a sphere of radius {self.radius:g} cannot go in deeper than that: {deepest:g}"
            )
        if deepest <= self.yields_at:
            return float(np.sqrt(self.radius * max(deepest, 0.0)))
        square = 2 * deepest * self.radius - self.yields_at * self.radius
        if self._sphere:
            square += self.yields_at**2 - deepest**2
        return float(np.sqrt(square))

    def at(self, penetration: float, deepest: float) -> tuple[float, float, float]:
        """Return force, contact radius, residual depth at a penetration and the largest so far."""
        if deepest <= self.yields_at:
            depth = max(penetration, 0.0)
            force = 4 / 3 * self.modulus * np.sqrt(self.radius * depth) * depth
            return float(force), self.widest(depth), 0.0
        widest = self.widest(deepest)
        height = 2 * self.pressure(deepest) * widest / self.modulus
        share = (deepest - penetration) / height
        if share >= 1:
            return 0.0, 0.0, deepest - height
        rim = np.sqrt((1 - share) * (1 + share))
        springs = rim * share + np.arcsin(rim) - 2 * share * rim
        force = self.modulus * height * widest * springs
        return float(force), float(widest * rim), deepest - height

    def walk(self, path: LoadPath) -> Yielded:
        """Follow a path of penetrations, or of forces, none of them negative."""
        forced, deepest, rows = is_forced(path), 0.0, []
        for load in path.values:
            depth = self._depth(float(load), deepest) if forced else float(load)
            deepest = max(deepest, depth)
            rows.append((depth, *self.at(depth, deepest)))
        return Yielded(*(np.array(column) for column in zip(*rows, strict=True)))

    def _depth(self, force: float, deepest: float) -> float:
        """Return the penetration at a force, which rises with it."""
        low = self.at(deepest, deepest)[2]
        high = max(deepest, min(self.yields_at, self._reach))
        for _ in range(_ROUNDS):
            if self.at(high, max(deepest, high))[0] >= force:
                break
            if high == self._reach:
                raise ValueError(f"a sphere in as deep as its radius carries less than {force:g}")
            high = min(2 * high, self._reach)
        else:
            raise ConvergenceError("the ball never carries this force")
        if force == 0:
            return low
        return bisect(lambda depth: self.at(depth, max(deepest, depth))[0] >= force, low, high)
