"""Springs whose force is capped where the stress of the local rule reaches a hardness.

Chapter 19 (19.37, and 19.6) computes a stress at each spring from its force f and deflection delta,
sigma = f sqrt(2)/(pi dx sqrt(delta R1)), R1 = 1/g'' the radius of curvature of the profile there,
and says to "use sigma_i for the yield criterion". It does not say which deflection counts once a
spring has yielded:

- "elastic_root": the elastic part f/(E* dx). Then f <= E* dx delta_y with
  delta_y = pi^2 H^2 R1/(2 E*^2), a constant.
- "stress": all of it. Then f <= H pi dx sqrt(delta R1/2): under a paraboloid in full yield the
  uniform pressure (pi/4) H.

A spring that has yielded stays shorter by what it has lost: it unloads with E* dx and lets go
before the surface returns.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

import numpy as np

from reduced.arguments import positive_faults, refuse
from reduced.errors import ConvergenceError
from reduced.loads import LoadPath
from reduced.profiles.section import Profile, bisect

Reading = Literal["stress", "elastic_root", "none"]
READINGS: tuple[Reading, ...] = ("stress", "elastic_root", "none")


@dataclass(frozen=True)
class Yielded:
    """A line of springs along a path of loads; arrays of shape (k,).

    The radius is half the length of the springs that carry a force; the residual depth is the
    penetration at which the contact would be lost if it were unloaded from here.
    """

    penetration: np.ndarray
    force: np.ndarray
    contact_radius: np.ndarray
    residual_depth: np.ndarray


class YieldingSprings:
    """Half of a symmetric line of springs under a profile.

    There are `springs` of them at the penetration `reach`. The profile is curved wherever it
    touches, unless the reading of the yield criterion is "none", which leaves the springs elastic.
    """

    def __init__(
        self,
        profile: Profile,
        effective_modulus: float,
        hardness: float,
        reading: Reading,
        *,
        reach: float,
        springs: int,
    ) -> None:
        faults = positive_faults(
            effective_modulus=effective_modulus, hardness=hardness, reach=reach, springs=springs
        )
        if reading not in READINGS:
            faults.append(f"reading must be one of {', '.join(READINGS)}, not {reading!r}")
        refuse(faults)
        self.modulus, self.reading = effective_modulus, reading
        self.spacing = float(profile.contact_radius(reach)) / springs
        x = (np.arange(springs) + 0.5) * self.spacing
        self.gap = np.asarray(profile.height(x), dtype=float)
        self.root = np.zeros(springs)
        if reading != "none":
            # sqrt(delta_y), and with it the cap of either reading.
            self.root = np.pi * hardness / effective_modulus * np.sqrt(_radius(profile, x) / 2)

    def elastic(self, penetration: float, lost: np.ndarray) -> np.ndarray:
        """Return the elastic deflections at a penetration."""
        total = penetration - self.gap
        return np.clip(total - lost, 0.0, elastic_limit(self.reading, self.root, total))

    def force(self, penetration: float, lost: np.ndarray) -> float:
        """Return the force of both halves."""
        return float(2 * self.modulus * self.spacing * self.elastic(penetration, lost).sum())

    def walk(self, path: LoadPath) -> Yielded:
        """Follow a path of penetrations, or of forces, none of them negative."""
        forced = is_forced(path)
        lost, rows = np.zeros(self.gap.shape), []
        for load in path.values:
            depth = self._depth(float(load), lost) if forced else float(load)
            elastic = self.elastic(depth, lost)
            lost = np.where(elastic > 0, np.maximum(lost, depth - self.gap - elastic), lost)
            force = float(2 * self.modulus * self.spacing * elastic.sum())
            rows.append((depth, force, self._edge(depth, lost), self._left(lost)))
        return Yielded(*(np.array(column) for column in zip(*rows, strict=True)))

    def _left(self, lost: np.ndarray) -> float:
        """Return the penetration at which the contact is lost: on virgin springs that of touch."""
        return float((self.gap + lost).min()) if lost.any() else 0.0

    def _edge(self, depth: float, lost: np.ndarray) -> float:
        """Return half the length in contact; springs let go from the rim inwards."""
        over = depth - self.gap - lost
        touching = int(np.count_nonzero(over > 0))
        if touching == 0:
            return 0.0
        if touching == over.size:
            # The last spring stands half a spacing inside; further on the gap goes on as before.
            slope = (over[-2] - over[-1]) / self.spacing if over.size > 1 else np.inf
            return float(self.spacing * (touching - 0.5) + min(over[-1] / slope, self.spacing / 2))
        inner, outer = over[touching - 1], over[touching]
        return float(self.spacing * (touching - 0.5 + inner / (inner - outer)))

    def _depth(self, force: float, lost: np.ndarray) -> float:
        """Return the penetration at a force, which rises with it."""
        low, high = self._left(lost), float(self.gap[-1])
        if force == 0:
            return low
        step = max(high - low, float(self.gap[-1]))
        while self.force(high, lost) < force:
            high += step
            step *= 2
            if not np.isfinite(high):
                raise ConvergenceError("the springs never carry this force")
        return bisect(lambda depth: self.force(depth, lost) >= force, low, high)


def is_forced(path: LoadPath, body: str = "indenter") -> bool:
    """Return whether a path prescribes forces; raise an error if any of them is negative."""
    forced = path.one_of("penetration", "force") == "force"
    if forced and (path.values < 0).any():
        raise ValueError(f"force must not be negative: nothing holds the {body}")
    return forced


def elastic_limit(reading: Reading, root: np.ndarray, deflection: np.ndarray) -> np.ndarray:
    """Return the largest elastic deflection of springs, f/(E* dx), at a total one.

    `root` is that of delta_y, (pi H/E*) sqrt(R1/2); infinite where there is no radius.
    """
    if reading == "none":
        return np.full(deflection.shape, np.inf)
    if reading == "elastic_root":
        return np.broadcast_to(root**2, deflection.shape)
    return root * np.sqrt(np.maximum(deflection, np.finfo(float).tiny))


def first_yield(profile: Profile, effective_modulus: float, pressure: float) -> float:
    """Return the penetration at which the local rule first reaches a pressure.

    d_y = pi^2 p^2 R1/(2 E*^2), R1 = 1/g''(0): exact for the paraboloid, where the rule is.
    """
    refuse(positive_faults(effective_modulus=effective_modulus, pressure=pressure))
    tip = float(_radius(profile, np.zeros(1))[0])
    return (np.pi * pressure / effective_modulus) ** 2 * tip / 2


def _radius(profile: Profile, x: np.ndarray) -> np.ndarray:
    """Return R1 = 1/g''(x)."""
    curvature = np.zeros(x.shape) if profile.curvature is None else profile.curvature(x)
    if not (np.isfinite(curvature) & (curvature > 0)).all():
        raise ValueError("the local stress rule needs a profile that is curved everywhere")
    return 1 / np.asarray(curvature, dtype=float)
