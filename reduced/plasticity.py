"""Springs that yield, under a path of loads: below a profile, along rough lines, of a soft ball.

**Caps.** Chapter 19 (19.37, and 19.6) computes a stress at each spring from its force f and
deflection delta, sigma = f sqrt(2)/(pi dx sqrt(delta R1)), R1 = 1/g'' the radius of curvature of
the profile there, and says to "use sigma_i for the yield criterion". It does not say which
deflection counts once a spring has yielded:

- "elastic_root": the elastic part f/(E* dx). Then f <= E* dx delta_y with
  delta_y = pi^2 H^2 R1/(2 E*^2), a constant.
- "stress": all of it. Then f <= H pi dx sqrt(delta R1/2): under a paraboloid in full yield the
  uniform pressure (pi/4) H.

A spring that has yielded stays shorter by what it has lost: it unloads with E* dx and lets go
before the surface returns.

**Rough lines** need a radius R1 at each spring, and have none that is always defined
(`rough.regions.line_stress`):

- "own_curvature": -1/h'' at the point; where the line is straight or concave there is no stress by
  (19.37), and the spring stays elastic.
- "one_radius": that of the parabola of the connected contact's length and depth, l^2/(8 delta_max),
  with "stress" only. A contact in full yield then has the mean pressure (pi/4) H on its area
  (19.29). With "elastic_root" the forces would fall as contacts deepen.

The line less what its springs have lost is a rough line in elastic contact: its force and its area
are those of that line. Along it the springs unload, and yield again beyond the deepest penetration.
"""

from dataclasses import dataclass, fields, replace
from typing import Literal

import numpy as np
from scipy.optimize import brentq

from reduced.errors import ConvergenceError, choice_faults, positive_faults, refuse
from reduced.loads import Load, LoadPath
from reduced.profiles.section import Profile, bisect
from reduced.rough.press import LineContact, RoughLines, press
from reduced.rough.regions import RULES, curvature, regions

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
            # half the length in contact; springs let go from the rim inwards
            over, edge = depth - self.gap - lost, 0.0
            touching = int(np.count_nonzero(over > 0))
            if touching == over.size:
                # the last spring stands half a spacing inside; further on the gap goes on as before
                slope = (over[-2] - over[-1]) / self.spacing if touching > 1 else np.inf
                further = min(over[-1] / slope, self.spacing / 2) if slope > 0 else self.spacing / 2
                edge = float(self.spacing * (touching - 0.5) + further)
            elif touching:
                inner, outer = over[touching - 1], over[touching]
                edge = float(self.spacing * (touching - 0.5 + inner / (inner - outer)))
            rows.append((depth, force, edge, self._left(lost)))
        return Yielded(*(np.array(column) for column in zip(*rows, strict=True)))

    def _left(self, lost: np.ndarray) -> float:
        """Return the penetration at which the contact is lost: on virgin springs that of touch."""
        return float((self.gap + lost).min()) if lost.any() else 0.0

    def _depth(self, force: float, lost: np.ndarray) -> float:
        """Return the penetration at a force, which rises with it."""
        low = self._left(lost)
        if force == 0:
            return low
        first = low + float(self.gap[-1])
        return bisect(lambda depth: self.force(depth, lost) >= force, low, first)


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


class ZunkerKamrin:
    """An elastic-perfectly plastic ball by Zunker & Kamrin (2024, J. Mech. Phys. Solids).

    A sphere or a paraboloid. Their particle is itself deformable and pressed by rigid flats: a
    rigid ball in a half-space only while a << R (Jackson & Kogut 2006). Until the mean pressure of
    Hertz's contact reaches p_Y the ball is Hertz's. Beyond, the pressure is uniform, p_Y, whose
    springs carry q = 2 p_Y sqrt(a^2 - x^2) per length; the area goes on with the slope 2 pi R of a
    rigid-plastic ball; and unloading is elastic, of an ellipse of the depth 2 p_Y a/E*.
    """

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
        for _ in range(200):
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
        if force == 0:
            return low
        if self._sphere and self.at(self.radius, self.radius)[0] < force:
            raise ValueError(f"a sphere in as deep as its radius carries less than {force:g}")

        def carries(depth: float) -> bool:
            return depth >= self._reach or self.at(depth, max(deepest, depth))[0] >= force

        return bisect(carries, low, max(deepest, self.yields_at))


# Penetrations and deflections that agree so well are the same.
_SAME = 1e-6


@dataclass(frozen=True)
class YieldedLines:
    """Contact of m lines at k loads of a path; every array has shape (m, k).

    `contact` is the elastic contact of the lines less what they have lost; its penetrations count
    from the first touch of the lines as they were. `residual_depth` is where contact would be lost
    if it were unloaded from here, `plastic_share` the share of the points in contact whose springs
    carry all they can.
    """

    contact: LineContact
    residual_depth: np.ndarray
    plastic_share: np.ndarray


@dataclass(frozen=True)
class Yielding:
    """How springs yield: reading of the yield criterion, rule for the radius of curvature."""

    effective_modulus: float
    hardness: float
    reading: Reading = "stress"
    rule: str = "one_radius"
    edges: str = "sub_cell"

    def __post_init__(self) -> None:
        faults = positive_faults(
            effective_modulus=self.effective_modulus, hardness=self.hardness
        ) + choice_faults("reading", self.reading, READINGS)
        faults += choice_faults("rule", self.rule, RULES)
        if self.reading == "elastic_root" and self.rule == "one_radius":
            faults.append("one_radius is for the reading 'stress' only")
        refuse(faults)


def walk(lines: RoughLines, springs: Yielding, path: LoadPath) -> YieldedLines:
    """Follow a path of penetrations or forces on every line.

    A parabola in full yield has the mean pressure (pi/4) H:

    >>> x = np.arange(-200, 200) / 100
    >>> ball = RoughLines(-x * x / 2, 0.01, periodic=False)
    >>> soft = Yielding(1.0, 1e-4)
    >>> pressed = walk(ball, soft, LoadPath("penetration", 0.5)).contact
    >>> round(float(pressed.force[0, 0] / pressed.contact_area[0, 0]) / 1e-4, 3)
    0.785
    """
    control = "force" if is_forced(path, "line") else "penetration"
    steps = []
    for row in range(len(lines)):
        line = _YieldingLine(lines[row], springs)
        steps += [line.step(control, float(load)) for load in path.values]
    contacts, left, share = zip(*steps, strict=True)
    shape = len(lines), len(path.values)
    columns = (
        np.concatenate([getattr(c, f.name) for c in contacts]).reshape(shape)
        for f in fields(LineContact)
    )
    contact = LineContact(*columns)
    return YieldedLines(contact, np.reshape(left, shape), np.reshape(share, shape))


class _YieldingLine:
    """A single line with the memory of its springs."""

    def __init__(self, line: RoughLines, springs: Yielding) -> None:
        self.line, self.springs = line, springs
        self.gap = line.single().max() - line.single()
        self.bend = curvature(line)
        self.lost, self.deepest = np.zeros(self.gap.shape), 0.0

    def step(self, control: str, load: float) -> tuple[LineContact, float, float]:
        """Go to the next load; return the contact, what would remain, and the share that yields."""
        depth = load
        if control == "force":
            depth = float(self._pressed(self.lost, "force", load).penetration[0, 0])
        if control == "force" and (self._shortened(depth)[0] > self.lost).any():
            depth = self._depth(load, depth)
        lost, full = self._shortened(depth)
        touching = int(np.count_nonzero(depth - self.gap > lost))
        self.lost, self.deepest = lost, max(self.deepest, depth)
        value = load if control == "force" else depth - self._left(lost)
        share = np.count_nonzero(full) / touching if touching else 0.0
        return self._pressed(lost, control, value), self._left(lost), share

    def _left(self, lost: np.ndarray) -> float:
        return float((self.gap + lost).min())

    def _shortened(self, depth: float) -> tuple[np.ndarray, np.ndarray]:
        """Return what the springs will have lost at a penetration, and which are at their cap."""
        if depth < self.deepest * (1 - _SAME) or depth <= 0:
            return self.lost, np.zeros(self.gap.shape, dtype=bool)
        total = depth - self.gap
        springs, bend = self.springs, self.bend
        if springs.rule == "one_radius":
            contacts = regions(self.line, depth, edges=springs.edges)
            deepest = np.zeros(contacts.lengths.size)
            np.maximum.at(deepest, contacts.region, contacts.deflection)
            bend = np.zeros(self.gap.shape)
            bend[contacts.points] = (8 * deepest / contacts.lengths**2)[contacts.region]
        radius = np.divide(1.0, bend, out=np.full(bend.shape, np.inf), where=bend > 0)
        root = np.pi * springs.hardness / springs.effective_modulus * np.sqrt(radius / 2)
        limit = elastic_limit(springs.reading, root, total)
        lost = np.maximum(self.lost, total - limit)
        return lost, (lost > 0) & (total > lost) & (total - lost >= limit * (1 - _SAME))

    def _pressed(self, lost: np.ndarray, control: str, load: float) -> LineContact:
        """Return the elastic contact of the line less what it has lost, under a load above that."""
        line = RoughLines(self.line.heights - lost, self.line.spacing, self.line.periodic)
        left, springs = self._left(lost), self.springs
        if load > 0:
            load_of = Load(control, load)
            contact = press(line, springs.effective_modulus, load_of, edges=springs.edges)
            return replace(contact, penetration=contact.penetration + left)
        nothing = {f.name: np.zeros((1, 1)) for f in fields(LineContact)}
        depth = left + (load if control == "penetration" else 0.0)
        nothing["penetration"] = np.array([[depth]])
        nothing["mean_gap"] = np.array([[float((self.gap + lost).mean()) - depth]])
        return LineContact(**nothing)

    def _depth(self, force: float, least: float) -> float:
        """Return the penetration at a force that some springs yield under."""

        def excess(depth: float) -> float:
            lost, _ = self._shortened(depth)
            pressed = self._pressed(lost, "penetration", depth - self._left(lost))
            return float(pressed.force[0, 0]) - force

        high = least
        for _ in range(60):
            high *= 2
            if excess(high) >= 0:
                return float(brentq(excess, least * (1 - 1e-9), high, xtol=1e-12 * high))
        raise ConvergenceError("the springs never carry this force")
