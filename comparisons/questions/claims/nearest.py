"""What claims have measured nearest to a scene: an answer before anything is solved.

A claim that was measured along a parameter (ratio of the radii, exponent, load of a rough surface,
Poisson's ratio, ...) is a row of a validity map; a scene of the same kind is a point on it, or a
stretch where its loads spread. What a claim measured away from its row, along what its statement
leaves open or drawn over it, are points like others. The record of the full runs comes with the
package; the file of a claim says `along` which number of scenes it was measured (`nearest`), and
what stood still (`fixed`).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.errors import InputError
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import quantity
from comparisons.geometry.plausibility import STEEPEST
from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN, WORST_FIRST, judged
from comparisons.questions.claims.families import HERE, Keys, builtin_claims
from comparisons.questions.claims.parameters import Place
from comparisons.questions.claims.record import HOLDS, ClaimRecord, PointRecord, stored
from comparisons.results.record import SceneRecord
from comparisons.scene.indenters.not_round import EllipticPunch, RightAngledPunch
from comparisons.scene.loading import AbsoluteLoads, loads_of
from comparisons.scene.scene import Scene, load_scene
from comparisons.scene.surface import SelfAffine
from reference.closed_form import sphere
from reference.closed_form.adhesive import maugis_parameter

BEYOND = ", beyond all that was measured"
SAME = 1e-3  # relative distance along a parameter that is none
Stretch = tuple[float, float]
Values = Mapping[str, Any]  # numbers and choices, by their symbols


@dataclass(frozen=True)
class Point:
    """A measurement of a claim: where it stands along its parameter, and what it had else."""

    place: float
    error: float
    uncertainty: float
    values: Values

    @property
    def worst(self) -> float:
        """The largest error that the measurement leaves possible, |e| + u."""
        return abs(self.error) + self.uncertainty

    def word(self, tolerance: float) -> str:
        """Return the verdict at a tolerance."""
        return judged(self.error, self.uncertainty, tolerance).word

    def apart(self, own: Values) -> dict[str, float]:
        """Return the relative differences of its numbers from those of a scene, where they are."""
        numbers = [(n, made, own[n]) for n, made in self.values.items() if type(made) is not str]
        return {
            name: (made - here) / (abs(made) + abs(here))
            for name, made, here in numbers
            if not np.isclose(here, made, rtol=SAME)
        }


@dataclass(frozen=True)
class Measured:
    """What a full run measured of a claim: first along its parameter, as stated, then elsewhere.

    A claim that holds and is `proved` holds beyond what was measured, too. Beyond `until` slopes
    are too large for every method, so that their agreement says nothing.
    """

    claim: str
    quantities: tuple[str, ...]
    parameter: str
    spacing: str
    tolerance: float
    points: tuple[Point, ...]
    proved: bool = False
    until: float = np.inf

    @property
    def row(self) -> list[Point]:
        """What was measured along the parameter, as stated."""
        return [point for point in self.points if point.values == self.points[0].values]

    @property
    def ends(self) -> Stretch:
        """The range of the parameter that was measured."""
        places = [point.place for point in self.row]
        return min(places), max(places)

    def share(self, value: float) -> float:
        """Return where a value stands along the row in its spacing, 0 and 1 at the ends."""
        scale = np.log if self.spacing == "log" else float
        low, high, here = map(scale, (*self.ends, value))
        return float((here - low) / (high - low))

    def like(self, own: Values) -> list[Point]:
        """Return the points with the choices of a scene."""
        return [
            point
            for point in self.points
            if all(own[name] == made for name, made in point.values.items() if type(made) is str)
        ]


@dataclass(frozen=True)
class Nearest:
    """The measurement that decides over a quantity of a scene, before it is solved."""

    quantity: str
    at: str  # of what is prescribed: the other load, at which it is compared; else ""
    measured: Measured
    # Where the scene stands along the parameter: the ends of its loads, or twice a value.
    here: Stretch
    point: Point
    word: str  # "within", "outside" or "not resolved" at the tolerance of the scene
    own: Values  # what the scene has of the values of points

    @property
    def word_of_claim(self) -> str:
        """The same at the tolerance of the claim."""
        return _decided(self.measured, self.here, self.own, self.measured.tolerance)[1]

    @property
    def differing(self) -> list[str]:
        """The symbols of what the point had beside its parameter, and is another here."""
        return list(self.point.apart(self.own))

    @property
    def distance(self) -> tuple[int, float]:
        """How far the point is, to choose between claims."""
        low, high, at = map(self.measured.share, (*self.here, self.point.place))
        return len(self.differing) + self.beyond, max(low - at, at - high, SAME)

    @property
    def steep(self) -> bool:
        """Whether slopes are too large for every method at some load: agreement says nothing."""
        return self.here[1] > self.measured.until

    @property
    def beyond(self) -> bool:
        """Whether the scene lies outside of what was measured."""
        low, high = map(self.measured.share, self.here)
        return low < -SAME or high > 1 + SAME

    @property
    def place(self) -> str:
        """Where it was measured, and where the scene stands, in words."""
        low, high, there = (
            fmt.without_padding(fmt.number(value)) for value in (*self.here, self.point.place)
        )
        here = low if low == high else f"{low} to {high}"
        beside = f", here {here}" if here != there else ""
        if self.beyond:
            beside += ", by theorem beyond what was measured" if self.measured.proved else BEYOND
        differing = self.differing
        fixed = "".join(
            f", {name} = {made:.4g}{f', here {self.own[name]:.4g}' if name in differing else ''}"
            for name, made in self.point.values.items()
            if name in (LOAD, *differing)  # a rough surface's error hangs on the load most
        )
        claim = self.measured.claim
        return f"{self.measured.parameter} = {there}{beside}{fixed}, claim {claim}"

    @property
    def document(self) -> dict[str, Any]:
        """It as plain data for JSON."""
        return {
            "quantity": self.quantity,
            "at": self.at,
            "claim": self.measured.claim,
            "parameter": self.measured.parameter,
            "here": list(self.here),
            "measured_at": self.point.place,
            "error": self.point.error,
            "uncertainty": self.point.uncertainty,
            "word": self.word,
            "beyond": self.beyond,
            "fixed": dict(self.point.values),
            "own": {name: self.own[name] for name in self.point.values},
            "agrees": not self.differing,
        }


def nearest(scene: Scene, loads: AbsoluteLoads, unit: float = np.nan) -> list[Nearest]:
    """Return, for each compared quantity that a claim has measured on such scenes, what it found.

    Where several claims have measured a quantity, the nearest point decides, which differs from the
    scene in the fewest values, and of such the one that says worst. None was measured on layers or
    by another rule than that of the transform. `unit` is E* A0 h', in N, of a rough scene; without
    it nothing is known of one.
    """
    if not scene.half_space.uniform or scene.methods.reduced.rule != "mdr":
        return []
    answers: dict[str, Nearest] = {}
    own = own_values(scene, loads, unit)
    for claim, stretch in places(scene, loads, unit).items():
        record = measured(claim)
        names = [name for name in record.quantities if name in scene.compare.quantities]
        for name in names if record.like(own) else ():
            point, word = _decided(record, stretch, own, scene.compare.tolerance)
            at = quantity(name).counterpart if name == loads.control else ""
            answer = Nearest(name, at, record, stretch, point, word, own)
            if answer.steep:
                answer = replace(answer, word=NOT_RESOLVED)
            answers[name] = min(
                (answers.get(name, answer), answer),
                key=lambda other: (*other.distance, -other.point.worst),
            )
    return [answers[name] for name in scene.compare.quantities if name in answers]


def _decided(
    record: Measured, stretch: Stretch, own: Values, tolerance: float
) -> tuple[Point, str]:
    """Return the point that decides over a stretch of the parameter, and the word there.

    Of those that differ from the scene in the fewest values the nearest, or the worst that it
    covers.
    """
    alike = [(point, point.apart(own)) for point in record.like(own)]
    fewest = min(len(differing) for _, differing in alike)
    near, off_by = zip(*(pair for pair in alike if len(pair[1]) == fewest), strict=True)
    names = sorted(set().union(*off_by))
    at = np.array([record.share(point.place) for point in near])
    apart = np.array([[differing.get(name, 0.0) for name in names] for differing in off_by])
    low, high = map(record.share, stretch)
    off = np.max([low - at, at - high, np.full(at.shape, SAME)], axis=0)  # none within SAME
    worst = [point.worst for point in near]
    first = np.lexsort((np.negative(worst), off, np.abs(apart).sum(axis=1)))[0]
    decisive = near[first]
    # Within is only what the next points on either side are, too: between an exact end, as a ratio
    # of one, and a point that is not, nothing is exact. A point is next if no other lies between it
    # and the scene, in the parameter and in all values that differ.
    beside, enclosed = (low + SAME < at) & (at < high - SAME), True
    for end in (low, high):
        steps = np.column_stack([np.where(np.abs(at - end) <= SAME, 0.0, at - end), apart])
        enclosed &= bool(np.all((steps.min(axis=0) <= 0) & (steps.max(axis=0) >= 0)))
        size, other = np.abs(steps), np.abs(steps)[:, None]
        nearer = np.all((steps[:, None] * steps >= 0) & (other <= size), axis=2)
        beside |= ~np.any(nearer & np.any(other < size, axis=2), axis=0)
    word = decisive.word(tolerance)
    words = {point.word(tolerance) for point, is_next in zip(near, beside, strict=True) if is_next}
    # Beyond all that was measured nothing is known but by a theorem, or where nothing was within.
    # How two values that differ act together is not known either.
    if word == WITHIN and (words != {WITHIN} or fewest > 1 or not (enclosed or record.proved)):
        return decisive, NOT_RESOLVED
    # Nor is outside what lies between a point that is and one that is within.
    around = words if enclosed else words | {point.word(tolerance) for point, _ in alike}
    between = (off[first] > SAME and WITHIN in words) or (fewest and WITHIN in around)
    return decisive, NOT_RESOLVED if word == OUTSIDE and between else word


def nearest_to(record: SceneRecord) -> list[Nearest]:
    """Return the same of a scene that was solved; none of its files is read again."""
    scene, surface = record.scene, record.plan.roughness
    if scene is None or scene.body is not None or not record.quantities:
        return []
    try:
        # A0 and h' as the surface was made; NaN where they are not known
        area, slope = (surface.area or np.nan, surface.rms_slope) if surface else (np.nan, np.nan)
        per_area = scene.effective_modulus * slope
        unit = scene.loading.unit(area, per_area) if np.isfinite(area) else None
        return nearest(scene, loads_of(scene, unit), area * per_area)
    except (InputError, KeyError, TypeError, ValueError):
        return []  # damaged results, or of another version


def plainly(answers: list[Nearest], tolerance: float) -> list[str]:
    """Return whether the reduced model is within a tolerance, and the measurement that tells it.

    Quantities with the same answer share one. Where a measurement is no answer that is said.
    """
    asked, groups = fmt.tolerance(tolerance), dict[str, list[str]]()
    for answer in sorted(answers, key=lambda answer: WORST_FIRST.index(answer.word)):
        row, limit = quantity(answer.quantity), fmt.tolerance(answer.measured.tolerance)
        wider = tolerance < answer.measured.tolerance and answer.word_of_claim == WITHIN
        said = {
            WITHIN: f"yes, within {asked}",
            OUTSIDE: f"no{f', but within {limit}' if wider else ''}",
            NOT_RESOLVED: f"{f'within {limit}, ' if wider else ''}not known whether within {asked}",
        }[answer.word]
        if answer.differing and answer.word == NOT_RESOLVED:
            said = "not measured here"
        if answer.steep:
            said = "not known, as slopes are too large for every method"
        near = "nearest: " if answer.differing else ""
        error = fmt.plus_minus(answer.point.error, answer.point.uncertainty, signed=not row.norm)
        equal = f" at equal {quantity(answer.at).label}" if answer.at else ""
        text = f"{said} ({near}{error} at {answer.place})"
        groups.setdefault(text, []).append(f"{row.label}{equal}")
    return [f"{fmt.listed(labels)}: {told}" for told, labels in groups.items()]


def in_words(answers: list[Nearest], tolerance: float) -> str:
    """Return the same in one sentence; "" where nothing is known."""
    known = "; ".join(plainly(answers, tolerance))
    return known and f"Nearest measured, reduced model, {known}."


@cache
def claimed() -> Mapping[str, tuple[str, Place, Keys]]:
    """Return along what the claims with a `nearest` were measured, their places and keys.

    Of those that share their measurements the one with its `tolerance`.
    """
    found = {}
    for name, keys in builtin_claims().items():
        place = Place.model_validate(keys.get("nearest", {}))
        if place.along is not None and place.tolerance in (None, keys["tolerance"]):
            found[name] = place.along, place, keys
    return found


def fixed(name: str) -> Values:
    """Return what stood still while a claim was measured, by its symbol."""
    along, _, keys = claimed()[name]
    return {k: v for k, v in keys.get("fixed", {}).items() if k != along}


@cache
def measured(name: str) -> Measured:
    """Return what was measured of a claim that comes with the package, in the units of `places`."""
    claim, (along, place, keys) = stored()[name], claimed()[name]
    names = place.quantity or keys["quantity"]
    made: list[tuple[PointRecord, float | None, Values]]
    made = [(point, point.parameter, {}) for point in claim.points]
    made += [
        (point, nuisance.at, {nuisance.name: point.parameter})
        for nuisance in claim.nuisances
        for point in nuisance.points
        if point.parameter != nuisance.stated
    ]
    if drawn := claim.map:
        made += [(p, p.parameter, {drawn.up: row.number}) for row in drawn.rows for p in row.points]
    made += [(point, point.parameter, point.setting) for point in claim.draws]
    choices = {nuisance.name: nuisance.choices for nuisance in claim.nuisances}
    points = []
    for point, at, setting in made:
        if at is None or point.error is None or point.uncertainty is None:
            continue
        values = dict(fixed(name))
        for key, value in setting.items():
            if not choices[key]:
                values[key.split()[-1]] = float(value)  # its symbol
            else:
                values[key] = value if type(value) is str else choices[key][int(value)]
        points.append(Point(at / place.unit, point.error, point.uncertainty, values))
    return Measured(
        name,
        (names,) if isinstance(names, str) else tuple(names),
        place.parameter or claim.parameter,
        claim.spacing,
        claim.tolerance,
        tuple(points),
        claim.verdict == HOLDS and bool(claim.theorem),
        UNTIL.get(along, np.inf),
    )


# The symbols of rough surfaces' values; the load of claims along another one.
LONG, SHORT, LENGTH = "L/lambda_l", "L/lambda_s", "L1/L"
AROUND, LINE = "half-space", "spectrum of the line"
LOAD, AT_LOAD = "F/(E* A0 h')", 0.01
# Where slopes are too large for every method: d/a = `STEEPEST`, of a ball d = a artanh(a/R).
UNTIL = {"d/R": STEEPEST * float(np.tanh(STEEPEST))}


def places(scene: Scene, loads: AbsoluteLoads, unit: float) -> dict[str, Stretch]:
    """Return where a scene stands along the parameter of each claim that concerns it."""
    found: dict[str, Any] = {}  # the scene's numbers, by what claims were measured along
    body, friction, adhesion = scene.indenter, scene.friction, scene.adhesion
    physics, values = set(scene.physics), loads.values
    shapes = {"cone": 1.0, "paraboloid": 2.0}
    exponent = shapes.get(body.shape, body.parameters.get("exponent")) if body else None
    if body is not None and not (physics or scene.rough):
        if body.shape == "ellipsoid":
            both = body.parameters["radius_x"], body.parameters["radius_y"]
            found["R'/R''"] = max(both) / min(both)
            # areas were compared at equal force: that says nothing of them at equal penetration
            if loads.control == "force":
                found["R'/R'' under a force"] = found["R'/R''"]
        if isinstance(body, EllipticPunch):
            found["a/b"] = max(body.semi_axes) / min(body.semi_axes)
        if isinstance(body, RightAngledPunch):
            found["L1/L2"] = max(body.lengths) / min(body.lengths)
        if exponent is not None:
            found["n"] = exponent
        if body.shape == "sphere":
            radius = body.parameters["radius"]
            form = sphere(radius, scene.effective_modulus)
            depth = form.penetration(values) if loads.control == "force" else values
            found["d/R"] = depth / radius
    rough = isinstance(scene.surface, SelfAffine) and np.isfinite(unit)
    if rough and not physics and loads.control == "force":
        own = own_values(scene, loads, unit)
        found[LOAD] = values / unit
        if np.allclose(values / unit, AT_LOAD, rtol=SAME):
            found |= {"H": own["H"], LONG: 1 / own[LONG], SHORT: 1 / own[SHORT]}
    rubber, alone = scene.viscoelastic, physics == {"viscoelastic"}
    if rubber and alone and exponent is not None and loads.control == "penetration":
        times, steps, top = loads.times, np.sign(np.diff(values)), np.argmax(values)
        relaxing = np.array([time for _, time in rubber.branches])
        if times is not None and relaxing.size and np.all(np.diff(steps) <= 0):  # pressed in once
            pressing = times[top] - times[0]
            if exponent == 2 and pressing:
                way = "unloading" if np.any(steps < 0) else "loading"
                found[f"tau/t, {way}"] = relaxing / pressing
            else:
                found["n on rubber"] = exponent
    plastic, alone = scene.plasticity, physics == {"plasticity"} and not scene.rough
    if plastic and alone and body is not None and exponent == 2:
        deeper = loads.control == "penetration" and np.all(np.diff(values, prepend=0.0) > 0)
        if deeper and not (plastic.hardening or plastic.hardening_exponent):
            from reference.plastic import yield_depth, yield_pressure  # with finite elements

            pressure = yield_pressure(scene.poisson_ratio) * plastic.yield_stress
            first = yield_depth(body.parameters["radius"], scene.effective_modulus, pressure)
            low, high = values[0] / first, values[-1] / first
            if high <= 1:  # nothing yields
                found["n"] = exponent
            else:
                found[f"d/d_y, {plastic.model}"] = max(low, 1.0), high
            if high > 1 and low >= 2:
                found[f"d/d_y from 2 on, {plastic.model}"] = low, high
    coupled = friction is not None and friction.coupling == "full"
    if physics == {"friction"} and not scene.rough and body is not None and body.axisymmetric:
        found["nu, coupled" if coupled else "nu, apart"] = scene.poisson_ratio
    long_range = adhesion is not None and not adhesion.short_range
    if adhesion is not None and long_range and body is not None and body.shape == "paraboloid":
        # lambda = (w/range) (9 R/(2 pi w E*^2))^(1/3) of a ball (Maugis 1992)
        size = body.parameters["radius"], scene.effective_modulus
        found["lambda"] = maugis_parameter(*size, adhesion.work, adhesion.work / adhesion.range)
    rolling, normal = scene.rolling, loads.normal
    if rolling is not None and friction is not None and not coupled and normal is not None:
        plain = physics == {"rolling", "friction"} and not rolling.spin and curvature_radii(scene)
        # creep of zero has no place on a scale of logarithms, nor an error
        creeps = np.abs([creep for creep in rolling.creep.values if creep])
        if plain and creeps.size and not any(rolling.lateral_creep.values):
            found[f"creep, {scene.methods.reduced.rolling}"] = creeps / full_slip(scene, normal)
    return {
        name: (float(np.min(found[along])), float(np.max(found[along])))
        for name, (along, _, _) in claimed().items()
        if along in found
    }


def full_slip(scene: Scene, normal: AbsoluteLoads) -> float:
    """Return the creep at which the springs of a ball slip all over, 2 mu (E*/G*) a/R.

    F_x/(mu F) of a ball is a function of the creep over it; of an ellipsoid the ball with the mean
    of its radii stands near.
    """
    radii = curvature_radii(scene)
    assert radii is not None
    assert scene.friction is not None
    radius, modulus = float(np.sqrt(radii[0] * radii[1])), scene.effective_modulus
    load = float(normal.values[-1])
    cubed = 0.75 * load * radius / modulus
    a = cubed ** (1 / 3) if normal.control == "force" else np.sqrt(radius * load)
    stiffer = modulus / scene.tangential_modulus
    return float(2 * scene.friction.coefficient * stiffer * a / radius)


def own_values(scene: Scene, loads: AbsoluteLoads, unit: float) -> dict[str, Any]:
    """Return what a scene has of the values of points, by their symbols."""
    own: dict[str, Any] = {"nu": scene.poisson_ratio}
    if isinstance(surface := scene.surface, SelfAffine):
        side, spacing = min(surface.size), max(np.divide(surface.size, surface.points))
        own["H"] = (surface.power or 0) / 2 - 1 if surface.hurst is None else surface.hurst
        own[LONG] = side / (surface.long_cutoff or side)
        own[SHORT] = side / (surface.short_cutoff or 2 * spacing)
        own[LENGTH] = scene.methods.reduced.line_length
        own[AROUND] = "periodic" if surface.periodic else "free patch"
        own[LINE] = "ring sums" if scene.methods.reduced.spectrum == "rings" else "other"
        own[LOAD] = float(np.mean(loads.values) / unit)
    if radii := curvature_radii(scene):
        own["R_x/R_y"] = radii[0] / radii[1]
    return own


def curvature_radii(scene: Scene) -> tuple[float, float] | None:
    """Return the radii of curvature along x and y at the tip of a ball or an ellipsoid."""
    body = scene.indenter
    if body is None or body.shape not in ("paraboloid", "sphere", "ellipsoid"):
        return None
    sides = body.parameters
    both = ("radius", "radius") if "radius" in sides else ("radius_x", "radius_y")
    return sides[both[0]], sides[both[1]]


# One modulus is written in several ways.
MODULI = {"youngs_modulus", "shear_modulus", "effective_modulus", "poisson_ratio"}


def claims_on(scene: Scene) -> list[ClaimRecord]:
    """Return the claims on the reduced model of such a scene, whose numbers may be others.

    Of claims that differ in their tolerance alone the nearest one; none against a printed number.
    """
    found, own = [], _kind(scene)
    for name, keys in builtin_claims().items():
        side = keys | keys.get("stated", {})
        general = "number" not in keys.get("true", {}) and keys.get("method", MODEL) == MODEL
        if "scene" in side and general and name in stored():
            beside = HERE / side["scene"]
            changes = keys.get("changes", {}) | side.get("changes", {})
            claimed = load_scene(beside if beside.is_file() else side["scene"], changes)
            if _kind(claimed) == own:
                claim = stored()[name]
                found.append((f"{claim.what}, {claim.parameter}, {changes}", claim))
    found.sort(key=lambda pair: -abs(np.log(pair[1].tolerance / scene.compare.tolerance)))
    return list(dict(found).values())


def _kind(scene: Scene) -> Any:
    """Return what a scene is but for its numbers, the unit of its moduli and how it is loaded."""

    def kind(value: Any) -> Any:
        if isinstance(value, dict):
            return {key: kind(item) for key, item in value.items() if key not in MODULI}
        if isinstance(value, (list, tuple)):
            members = [kind(item) for item in value]
            return 0 if members and not any(members) else members
        return 0 if type(value) in (int, float) else value

    document = scene.model_dump(exclude={"name", "title", "loading", "compare", "methods", "sweep"})
    paths = scene.loading.model_dump(exclude_none=True).keys() & {"time", "tangential_force"}
    if scene.indenter is not None and scene.indenter.shape == "sphere":
        document["indenter"]["shape"] = "paraboloid"  # which stands for one
    return kind(document), paths, kind(scene.methods.reduced.model_dump())
