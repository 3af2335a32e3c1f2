"""What claims have measured nearest to a scene: an answer before anything is solved.

A claim that was measured along a parameter (ratio of the radii, exponent, load of a rough surface,
Poisson's ratio, ...) is a row of a validity map; a scene of the same kind is a point on it, or a
stretch where its loads spread. The record of the full runs comes with the package.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cache
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.errors import InputError
from comparisons.facts.methods import MODEL
from comparisons.facts.quantities import counterpart, quantity
from comparisons.geometry.plausibility import STEEPEST
from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN, WORST_FIRST, judged
from comparisons.questions.claims.record import HOLDS, STORED, load_claims_record
from comparisons.results.record import SceneRecord
from comparisons.scene.indenters.punches import EllipticPunch, RightAngledPunch
from comparisons.scene.loading import AbsoluteLoads, loads_of
from comparisons.scene.scene import Scene, builtin_names, load_scene
from comparisons.scene.surface import SelfAffine
from reference.closed_form import sphere
from reference.closed_form.adhesive import maugis_parameter

BEYOND = ", beyond all that was measured"
SAME = 1e-3  # relative distance along a parameter that is none
Stretch = tuple[float, float]
Point = tuple[float, float, float]  # value of the parameter, e, u


@dataclass(frozen=True)
class Measured:
    """What a full run measured of a claim: e and u at each value of its parameter.

    `fixed` is what stood still meanwhile and a scene may have otherwise: its value, by its symbol.
    A claim that holds and is `proved` holds beyond what was measured, too. Beyond `until` slopes
    are too large for every method, so that their agreement says nothing.
    """

    claim: str
    parameter: str
    spacing: str
    tolerance: float
    points: tuple[Point, ...]
    fixed: Mapping[str, float] = field(default_factory=dict)
    proved: bool = False
    until: float = np.inf

    @property
    def ends(self) -> Stretch:
        """The range of the parameter that was measured."""
        values = [value for value, _, _ in self.points]
        return min(values), max(values)

    def along(self, value: float) -> float:
        """Return where a value stands along the parameter, in its spacing."""
        return float(np.log(value)) if self.spacing == "log" else value

    def exceeded_by(self, stretch: Stretch) -> bool:
        """Whether a stretch of the parameter reaches beyond what was measured."""
        low, high = self.ends
        return stretch[0] < low * (1 - SAME) or stretch[1] > high * (1 + SAME)


@dataclass(frozen=True)
class Nearest:
    """The measurement that decides over a quantity of a scene, before it is solved."""

    quantity: str
    at: str  # of what is prescribed: the other load, at which it is compared; else ""
    measured: Measured
    # Where the scene stands along the parameter: the ends of its loads, or twice a value.
    here: Stretch
    there: float  # where it was measured
    error: float
    uncertainty: float
    # "within", "outside" or "not resolved" at the tolerance of the scene: the last, too, where
    # something that stood still is another here.
    word: str
    word_of_claim: str  # the same at the tolerance of the claim
    own: Mapping[str, float]  # the scene's values of what stood still while the claim was measured

    @property
    def differing(self) -> list[str]:
        """The symbols of what stood still while the claim was measured, and is another here."""
        return [
            name
            for name, made in self.measured.fixed.items()
            if not np.isclose(self.own[name], made, rtol=SAME)
        ]

    @property
    def steep(self) -> bool:
        """Whether slopes are too large for every method at some load: agreement says nothing."""
        return self.here[1] > self.measured.until

    @property
    def worst(self) -> float:
        """The largest error that the measurement leaves possible, |e| + u."""
        return abs(self.error) + self.uncertainty

    @property
    def beyond(self) -> bool:
        """Whether the scene lies outside of what was measured."""
        return self.measured.exceeded_by(self.here)

    @property
    def far(self) -> str:
        """That it does, in words; else ""."""
        if not self.beyond:
            return ""
        return ", by theorem beyond what was measured" if self.measured.proved else BEYOND

    @property
    def place(self) -> str:
        """Where it was measured, and where the scene stands, in words."""
        low, high, there = (
            fmt.without_padding(fmt.number(value)) for value in (*self.here, self.there)
        )
        here = low if low == high else f"{low} to {high}"
        beside = f", here {here}" if here != there else ""
        differing = self.differing
        fixed = "".join(
            f", {name} = {made:.4g}{f', here {self.own[name]:.4g}' if name in differing else ''}"
            for name, made in self.measured.fixed.items()
            if name in (LOAD, *differing)  # a rough surface's error hangs on the load most
        )
        claim = self.measured.claim
        return f"{self.measured.parameter} = {there}{beside}{self.far}{fixed}, claim {claim}"

    @property
    def document(self) -> dict[str, Any]:
        """It as plain data for JSON."""
        return {
            "quantity": self.quantity,
            "at": self.at,
            "claim": self.measured.claim,
            "parameter": self.measured.parameter,
            "here": list(self.here),
            "measured_at": self.there,
            "error": self.error,
            "uncertainty": self.uncertainty,
            "word": self.word,
            "beyond": self.beyond,
            "fixed": dict(self.measured.fixed),
            "own": {name: self.own[name] for name in self.measured.fixed},
            "agrees": not self.differing,
            "hurst_measured": self.measured.fixed.get("H"),
            "hurst_here": self.own.get("H"),
        }


def nearest(scene: Scene, loads: AbsoluteLoads, unit: float = np.nan) -> list[Nearest]:
    """Return, for each compared quantity that a claim has measured on such scenes, what it found.

    Where several claims have measured a quantity, one decides whose measurement differs from the
    scene in the fewest parameters, and of such the one that says worst. None was measured on layers
    or by another rule than that of the transform. `unit` is E* A0 h', in N, of a rough scene;
    without it nothing is known of one.
    """
    if not scene.half_space.uniform or scene.methods.reduced.rule != "mdr":
        return []
    answers: dict[str, Nearest] = {}
    here, own = places(scene, loads, unit), own_values(scene, loads, unit)
    for claim in [claim for claim in QUANTITIES if claim in here and claim in measured()]:
        for name in [name for name in QUANTITIES[claim] if name in scene.compare.quantities]:
            record, stretch = measured()[claim], here[claim]
            point, word = _decided(record, stretch, scene.compare.tolerance)
            _, word_of_claim = _decided(record, stretch, record.tolerance)
            at = counterpart(name) if name == loads.control else ""
            answer = Nearest(name, at, record, stretch, *point, word, word_of_claim, own)
            if answer.differing or answer.steep:
                answer = replace(answer, word=NOT_RESOLVED)
            answers[name] = max(
                (answers.get(name, answer), answer),
                key=lambda other: (-len(other.differing) - other.beyond, other.worst),
            )
    return [answers[name] for name in scene.compare.quantities if name in answers]


def _decided(record: Measured, stretch: Stretch, tolerance: float) -> tuple[Point, str]:
    """Return the point that decides over a stretch of the parameter, and the word there.

    It is the worst of the points that the stretch covers; where it covers none, the nearest.
    """
    low, high = (record.along(end) for end in stretch)
    along = np.array([record.along(value) for value, _, _ in record.points])
    slack = SAME * np.ptp(along)
    placed = list(zip(record.points, along, strict=True))
    middle = (low + high) / 2
    covered = [point for point, at in placed if low - slack <= at <= high + slack]
    nearest_one, _ = min(placed, key=lambda pair: abs(pair[1] - middle))
    decisive = max(covered or [nearest_one], key=lambda point: abs(point[1]) + point[2])
    _, error, bar = decisive
    word = judged(error, bar, tolerance).word
    # Within is only what the next points on either side are, too: between an exact end, as a ratio
    # of one, and a point that is not, nothing is exact. Beyond all that was measured nothing is
    # known, but by a theorem.
    first = along[along <= low + slack].max(initial=along.min())
    last = along[along >= high - slack].min(initial=along.max())
    if first > last:
        first = last = along.min() if high < along.min() else along.max()
    beside = (judged(e, u, tolerance).word for (_, e, u), at in placed if first <= at <= last)
    unknown = record.exceeded_by(stretch) and not record.proved
    if word == WITHIN and (unknown or any(near != WITHIN for near in beside)):
        word = NOT_RESOLVED
    return decisive, word


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

    Quantities with the same answer share one. Where what stood still in a claim is another here,
    or slopes are too large, the measurement is no answer: that is said.
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
        if answer.differing:
            said = "not measured here"
        if answer.steep:
            said = "not known, as slopes are too large for every method"
        near = "nearest: " if answer.differing else ""
        error = fmt.plus_minus(answer.error, answer.uncertainty, signed=not row.norm)
        equal = f" at equal {quantity(answer.at).label}" if answer.at else ""
        text = f"{said} ({near}{error} at {answer.place})"
        groups.setdefault(text, []).append(f"{row.label}{equal}")
    return [f"{fmt.listed(labels)}: {told}" for told, labels in groups.items()]


def in_words(answers: list[Nearest], tolerance: float) -> str:
    """Return the same in one sentence; "" where nothing is known."""
    known = "; ".join(plainly(answers, tolerance))
    return known and f"Nearest measured, reduced model, {known}."


def claims_on(scene: Scene) -> dict[str, str]:
    """Return the verdicts on the reduced model of claims on a built-in scene, by claim.

    A scene is that one if it differs at most in what is compared, and how well.
    """
    name = scene.name
    if name not in builtin_names():
        return {}
    built_in = load_scene(name)
    aside = {"compare": built_in.compare, "directory": built_in.directory}
    if scene.model_copy(update=aside) != built_in:
        return {}
    return {
        claim.id: claim.verdict
        for claim in load_claims_record(STORED).claims
        # with another indenter it is another scene
        if claim.method == MODEL
        and f"on the scene {name}," in f"{claim.what},"
        and ", indenter" not in claim.what
    }


@cache
def measured() -> Mapping[str, Measured]:
    """Return the measurements that come with the package, by claim.

    A creep is over that of full slip, the shortest wave over the side, not over their spacing.
    """
    creep = 100 * full_slip_of_claims(), "creep over that of full slip"
    units = dict.fromkeys(ROLLING.values(), creep)
    units["rough-area-smooth"] = 2 * SURFACE[SHORT], "shortest wave over side lambda_s/L"
    found = {}
    for claim in [claim for claim in load_claims_record(STORED).claims if claim.id in QUANTITIES]:
        unit, parameter = units.get(claim.id, (1.0, claim.parameter))
        points = tuple(
            (point.parameter / unit, point.error, point.uncertainty)
            for point in claim.points
            if point.parameter is not None
            and point.error is not None
            and point.uncertainty is not None
        )
        found[claim.id] = Measured(
            claim.id,
            parameter,
            claim.spacing,
            claim.tolerance,
            points,
            FIXED.get(claim.id, {}),
            claim.verdict == HOLDS and bool(claim.theorem),
            UNTIL.get(claim.id, np.inf),
        )
    return found


# Of the surfaces of claims on roughness along the load (rough_area.toml), 64 x 64 points without a
# plateau of long waves; the load of claims along another parameter.
LONG, SHORT = "side/long_cutoff", "side/short_cutoff"
SURFACE = {"H": 0.8, LONG: 1.0, SHORT: 32.0, "line_length": 1.0}
LOAD, AT_LOAD = "F/(E* A0 h')", 0.01
ALONG = {
    "rough-area-hurst": "H",
    "rough-stiffness-hurst": "H",
    "rough-area-plateau": LONG,
    "rough-area-smooth": SHORT,
}
# Where slopes are too large for every method: d/a = `STEEPEST`, of a ball d = a artanh(a/R).
UNTIL = {"transform-sphere": STEEPEST * float(np.tanh(STEEPEST))}
# What stood still while a claim was measured, by its symbol.
FIXED: dict[str, dict[str, float]] = {
    "rough-area": SURFACE,
    "rough-area-periodic": SURFACE,
    "rough-penetration": SURFACE,
    "rough-mean-gap": SURFACE,
    "rough-stiffness": SURFACE,
    "rolling-curve-springs": {"nu": 0.28, "R_x/R_y": 1.0},
    "rolling-curve-matched": {"nu": 0.28, "R_x/R_y": 1.0},
}
for claim, along in ALONG.items():
    FIXED[claim] = {
        name: made for name, made in (SURFACE | {LOAD: AT_LOAD}).items() if name != along
    }
# The claims along the creep in % of a ball, by the stiffness of the reduced model's springs.
ROLLING = {"springs": "rolling-curve-springs", "matched": "rolling-curve-matched"}
# The claims along d/d_y of a ball that dents, by how springs read the criterion of yield.
YIELDING = {"stress": "total", "elastic_root": "root", "zunker_kamrin": "zunker-kamrin"}
DENTS = {"force-10": "force", "area-10": "contact_area", "residual-20": "residual_depth"}
DENTED = {f"plastic-{way}-{d}": (n,) for way in YIELDING.values() for d, n in DENTS.items()}
del DENTED["plastic-root-area-10"]  # no claim
FIXED |= {claim: {"nu": 0.3} for claim in DENTED}
# The quantities whose error a claim measures. Force and stiffness of a flat face err alike.
QUANTITIES: dict[str, tuple[str, ...]] = {
    "ellipsoid-force": ("force",),
    "ellipsoid-area": ("contact_area",),
    "punch-ellipse": ("force", "stiffness"),
    "punch-rectangle": ("force", "stiffness"),
    "transform-power-law": ("force", "contact_area", "stiffness"),
    "transform-sphere": ("force", "contact_area", "stiffness"),
    "rough-area": ("contact_area",),
    "rough-area-periodic": ("contact_area",),
    "rough-penetration": ("penetration",),
    "rough-mean-gap": ("mean_gap",),
    "rough-area-hurst": ("contact_area",),
    "rough-area-plateau": ("contact_area",),
    "rough-area-smooth": ("contact_area",),
    "rough-stiffness": ("stiffness",),
    "rough-stiffness-hurst": ("stiffness",),
    "rolling-curve-springs": ("traction", "tangential_force"),
    "rolling-curve-matched": ("traction", "tangential_force"),
    "partial-slip-rigid": ("tangential_displacement",),
    "adhesion-range": ("pull_off_force",),
    "viscoelastic-loading": ("force", "contact_area"),
    "viscoelastic-unloading": ("force", "contact_area"),
    "viscoelastic-shape": ("force", "contact_area"),
    **DENTED,
}


def places(scene: Scene, loads: AbsoluteLoads, unit: float) -> dict[str, Stretch]:
    """Return where a scene stands along the parameter of each claim that concerns it."""
    found: dict[str, Stretch] = {}
    body, friction, adhesion = scene.indenter, scene.friction, scene.adhesion
    fixed = {"cone": 1.0, "paraboloid": 2.0}
    exponent = fixed.get(body.shape, body.parameters.get("exponent")) if body else None
    if body is not None and not (scene.physics or scene.rough):
        if body.shape == "ellipsoid":
            radii = _ratio((body.parameters["radius_x"], body.parameters["radius_y"]))
            found["ellipsoid-force"] = radii
            # areas were compared at equal force: that says nothing of them at equal penetration
            if loads.control == "force":
                found["ellipsoid-area"] = radii
        if isinstance(body, EllipticPunch):
            found["punch-ellipse"] = _ratio(body.semi_axes)
        if isinstance(body, RightAngledPunch):
            found["punch-rectangle"] = _ratio(body.lengths)
        if exponent is not None:
            found["transform-power-law"] = exponent, exponent
        if body.shape == "sphere":
            depths = loads.values / body.parameters["radius"]
            if loads.control == "force":
                ball = sphere(body.parameters["radius"], scene.effective_modulus)
                depths = ball.penetration(loads.values) / body.parameters["radius"]
            found["transform-sphere"] = float(np.min(depths)), float(np.max(depths))
    surface = scene.surface
    rough = isinstance(surface, SelfAffine) and not scene.physics and loads.control == "force"
    if isinstance(surface, SelfAffine) and rough and np.isfinite(unit):
        free = ("rough-area", "rough-penetration", "rough-mean-gap", "rough-stiffness")
        stretch = float(np.min(loads.values) / unit), float(np.max(loads.values) / unit)
        found |= dict.fromkeys(("rough-area-periodic",) if surface.periodic else free, stretch)
        if np.allclose(stretch, AT_LOAD, rtol=SAME) and not surface.periodic:
            own = own_values(scene, loads, unit)
            for claim, name in ALONG.items():
                if not np.isclose(own[name], SURFACE[name], rtol=SAME):
                    place = own[name] if name == "H" else 1 / own[name]
                    found[claim] = place, place
    rubber, alone = scene.viscoelastic, set(scene.physics) == {"viscoelastic"}
    if rubber and alone and exponent is not None and loads.control == "penetration":
        times, steps, top = loads.times, np.sign(np.diff(loads.values)), np.argmax(loads.values)
        relaxing = [time for _, time in rubber.branches]
        if times is not None and relaxing and np.all(np.diff(steps) <= 0):  # pressed in once
            pressing = times[top] - times[0]
            if exponent == 2 and pressing:
                way = "unloading" if np.any(steps < 0) else "loading"
                found[f"viscoelastic-{way}"] = min(relaxing) / pressing, max(relaxing) / pressing
            else:
                found["viscoelastic-shape"] = exponent, exponent
    plastic, alone = scene.plasticity, set(scene.physics) == {"plasticity"} and not scene.rough
    if plastic and alone and body is not None and exponent == 2 and plastic.model in YIELDING:
        deeper = loads.control == "penetration" and np.all(np.diff(loads.values, prepend=0.0) > 0)
        if deeper and not (plastic.hardening or plastic.hardening_exponent):
            from reference.plastic import yield_depth, yield_pressure  # with finite elements

            pressure = yield_pressure(scene.poisson_ratio) * plastic.yield_stress
            first = yield_depth(body.parameters["radius"], scene.effective_modulus, pressure)
            low, high = float(loads.values[0] / first), float(loads.values[-1] / first)
            # dents were measured from 2 on; below 1 nothing yields
            dents = [dent for dent in DENTS if dent != "residual-20" or low >= 2]
            claims = [f"plastic-{YIELDING[plastic.model]}-{dent}" for dent in dents]
            if high > 1:
                found |= dict.fromkeys(claims, (max(low, 1.0), high))
            else:
                found["transform-power-law"] = exponent, exponent
    coupled = friction is not None and friction.coupling == "full"
    alone = set(scene.physics) == {"friction"} and not scene.rough
    if coupled and alone and body is not None and body.axisymmetric:
        found["partial-slip-rigid"] = scene.poisson_ratio, scene.poisson_ratio
    long_range = adhesion is not None and not adhesion.short_range
    if adhesion is not None and long_range and body is not None and body.shape == "paraboloid":
        # lambda = (w/range) (9 R/(2 pi w E*^2))^(1/3) of a ball (Maugis 1992)
        tension = adhesion.work / adhesion.range
        radius = body.parameters["radius"]
        place = float(maugis_parameter(radius, scene.effective_modulus, adhesion.work, tension))
        found["adhesion-range"] = place, place
    rolling = scene.rolling
    if rolling is not None and friction is not None and not coupled:
        plain = set(scene.physics) == {"rolling", "friction"} and not rolling.spin
        curved, normal = curvature_radii(scene), loads.normal
        if plain and curved and normal is not None and not any(rolling.lateral_creep.values):
            # creep of zero has no place on a scale of logarithms, nor an error
            full = full_slip(scene, normal)
            creeps = [abs(creep) / full for creep in rolling.creep.values if creep]
            if creeps:
                found[ROLLING[scene.methods.reduced.rolling]] = min(creeps), max(creeps)
    return found


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


@cache
def full_slip_of_claims() -> float:
    """Return the same of the scene of the claims on the creep curve."""
    scene = load_scene("rolling-ball")
    normal = loads_of(scene).normal
    assert normal is not None
    return full_slip(scene, normal)


def own_values(scene: Scene, loads: AbsoluteLoads, unit: float) -> dict[str, float]:
    """Return what a scene has of the values that stand still in `FIXED`, by their symbols."""
    own = {"nu": scene.poisson_ratio}
    if isinstance(surface := scene.surface, SelfAffine):
        side, spacing = min(surface.size), max(np.divide(surface.size, surface.points))
        own["H"] = (surface.power or 0) / 2 - 1 if surface.hurst is None else surface.hurst
        own[LONG] = side / (surface.long_cutoff or side)
        own[SHORT] = side / (surface.short_cutoff or 2 * spacing)
        own["line_length"] = scene.methods.reduced.line_length
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


def _ratio(sides: tuple[float, float]) -> Stretch:
    ratio = max(sides) / min(sides)
    return ratio, ratio
