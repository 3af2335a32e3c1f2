"""What claims have measured nearest to a scene: an answer before anything is solved.

A claim that was measured along a parameter (ratio of the radii, exponent, load of a rough surface,
Poisson's ratio, ...) is a row of a validity map; a scene of the same kind is a point on it, or a
stretch where its loads spread. The record of the full runs comes with the package.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.errors import InputError
from comparisons.facts.quantities import quantity
from comparisons.judging.verdicts import NOT_RESOLVED, WITHIN, WORST_FIRST, judged
from comparisons.questions.claims.record import STORED, load_claims_record
from comparisons.results.record import SceneRecord
from comparisons.scene.indenters.punches import EllipticPunch, RightAngledPunch
from comparisons.scene.loading import AbsoluteLoads, loads_of
from comparisons.scene.scene import Scene, make_scene
from reference.closed_form import sphere
from reference.closed_form.adhesive import maugis_parameter

SAME = 1e-3  # relative distance along a parameter that is none
Stretch = tuple[float, float]


@dataclass(frozen=True)
class Measured:
    """What a full run measured of a claim: e and u at each value of its parameter.

    `hurst` is the Hurst exponent of its surfaces.
    """

    claim: str
    parameter: str
    spacing: str
    tolerance: float
    points: tuple[tuple[float, float, float], ...]
    hurst: float | None = None

    @property
    def ends(self) -> Stretch:
        """The range of the parameter that was measured."""
        values = [value for value, _, _ in self.points]
        return min(values), max(values)

    def along(self, value: float) -> float:
        """Return where a value stands along the parameter, in its spacing."""
        return float(np.log(value)) if self.spacing == "log" else value


@dataclass(frozen=True)
class Nearest:
    """The measurement that decides over a quantity of a scene, before it is solved.

    Attributes
    ----------
    quantity : str
    measured : Measured
    here : (float, float)
        Where the scene stands along the parameter: the ends of its loads, or twice a value.
    there : float
        Where it was measured.
    error, uncertainty : float
    word : str
        "within", "outside" or "not resolved" at the tolerance of the scene.
    hurst : float or None
        The Hurst exponent of the scene's surface; None where it states none.
    """

    quantity: str
    measured: Measured
    here: Stretch
    there: float
    error: float
    uncertainty: float
    word: str
    hurst: float | None = None

    @property
    def worst(self) -> float:
        """The largest error that the measurement leaves possible, |e| + u."""
        return abs(self.error) + self.uncertainty

    @property
    def beyond(self) -> bool:
        """Whether the scene lies outside of what was measured."""
        low, high = self.measured.ends
        return self.here[0] < low * (1 - SAME) or self.here[1] > high * (1 + SAME)

    @property
    def place(self) -> str:
        """Where it was measured, and where the scene stands, in words."""
        low, high, there = (
            fmt.without_padding(fmt.number(value)) for value in (*self.here, self.there)
        )
        here = low if low == high else f"{low} to {high}"
        beside = f", here {here}" if here != there else ""
        far = ", beyond all that was measured" if self.beyond else ""
        if (made := self.measured.hurst) is not None:
            own = "not stated" if self.hurst is None else f"{self.hurst:g}"
            far += f", H = {made:g}" + (f", here {own}" if own != f"{made:g}" else "")
        return f"{self.measured.parameter} = {there}{beside}{far} (claim {self.measured.claim})"

    @property
    def document(self) -> dict[str, Any]:
        """It as plain data for JSON."""
        return {
            "quantity": self.quantity,
            "claim": self.measured.claim,
            "parameter": self.measured.parameter,
            "here": list(self.here),
            "measured_at": self.there,
            "error": self.error,
            "uncertainty": self.uncertainty,
            "word": self.word,
            "beyond": self.beyond,
            "hurst_measured": self.measured.hurst,
            "hurst_here": self.hurst,
        }


def nearest(scene: Scene, loads: AbsoluteLoads, unit: float = np.nan) -> list[Nearest]:
    """Return, for each compared quantity that a claim has measured on such scenes, what it found.

    Where several claims have measured a quantity, the one that says worst decides. None was
    measured on layers or by another rule than that of the transform. `unit` is E* A0 h', in N, of
    a rough scene; without it nothing is known of one.
    """
    if not scene.half_space.uniform or scene.methods.reduced.rule != "mdr":
        return []
    answers: dict[str, Nearest] = {}
    here = places(scene, loads, unit)
    for claim in [claim for claim in QUANTITIES if claim in here and claim in measured()]:
        for name in [name for name in QUANTITIES[claim] if name in scene.compare.quantities]:
            record, stretch, tolerance = measured()[claim], here[claim], scene.compare.tolerance
            low, high = (record.along(end) for end in stretch)
            along = np.array([record.along(value) for value, _, _ in record.points])
            slack = SAME * np.ptp(along)
            # the worst of the points that the scene covers; where it covers none, the nearest
            placed = list(zip(record.points, along, strict=True))
            middle = (low + high) / 2
            covered = [point for point, at in placed if low - slack <= at <= high + slack]
            nearest_one, _ = min(placed, key=lambda pair: abs(pair[1] - middle))
            there, error, bar = max(covered or [nearest_one], key=lambda p: abs(p[1]) + p[2])
            word = judged(error, bar, tolerance).word
            answer = Nearest(name, record, stretch, there, error, bar, word)
            # Within is only what the next points on either side are, too: between an exact end, as
            # a ratio of one, and a point that is not, nothing is exact. Beyond all that was
            # measured nothing is known.
            first = along[along <= low + slack].max(initial=along.min())
            last = along[along >= high - slack].min(initial=along.max())
            if first > last:
                first = last = along.min() if high < along.min() else along.max()
            beside = (
                judged(e, u, tolerance).word for (_, e, u), at in placed if first <= at <= last
            )
            if word == WITHIN and (answer.beyond or any(near != WITHIN for near in beside)):
                answer = replace(answer, word=NOT_RESOLVED)
            if name not in answers or answer.worst > answers[name].worst:
                answers[name] = replace(answer, hurst=getattr(scene.surface, "hurst", None))
    return [answers[name] for name in scene.compare.quantities if name in answers]


def nearest_to(record: SceneRecord) -> list[Nearest]:
    """Return the same of a scene that was solved; none of its files is read again."""
    if "body" in record.tables or not record.quantities:
        return []
    try:
        scene, surface = make_scene(dict(record.tables), record.name, Path()), record.plan.roughness
        # A0 and h' as the surface was made; NaN where they are not known
        area, slope = (surface.area or np.nan, surface.rms_slope) if surface else (np.nan, np.nan)
        per_area = scene.effective_modulus * slope
        unit = scene.loading.unit(area, per_area) if np.isfinite(area) else None
        return nearest(scene, loads_of(scene, unit), area * per_area)
    except (InputError, KeyError, TypeError, ValueError):
        return []  # damaged results, or of another version


def in_words(answers: list[Nearest], tolerance: float) -> str:
    """Return what is known before a scene is solved, in one sentence; "" where nothing is."""
    groups: dict[tuple[str, str, str], list[str]] = {}
    for answer in sorted(answers, key=lambda answer: WORST_FIRST.index(answer.word)):
        number = fmt.plus_minus(
            answer.error, answer.uncertainty, signed=not quantity(answer.quantity).norm
        )
        label = quantity(answer.quantity).label
        groups.setdefault((answer.word, number, answer.place), []).append(label)
    parts = [
        f"error of {fmt.listed(labels)} {number} at {place}, "
        f"{word}{' at' if word == NOT_RESOLVED else ''} {fmt.tolerance(tolerance)}"
        for (word, number, place), labels in groups.items()
    ]
    return f"Nearest measured, reduced model: {'; '.join(parts)}." if parts else ""


@cache
def measured() -> Mapping[str, Measured]:
    """Return the measurements that come with the package, by claim."""
    return {
        claim.id: Measured(
            claim.id,
            claim.parameter,
            claim.spacing,
            claim.tolerance,
            tuple(
                (point.parameter, point.error, point.uncertainty)
                for point in claim.points
                if point.parameter is not None
                and point.error is not None
                and point.uncertainty is not None
            ),
            HURST if claim.id.startswith("rough-") else None,
        )
        for claim in load_claims_record(STORED).claims
        if claim.id in QUANTITIES
    }


# Of the surfaces of the claims on roughness (`hurst` of rough_area.toml).
HURST = 0.8
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
    "rough-stiffness": ("stiffness",),
    "partial-slip-rigid": ("tangential_displacement",),
    "adhesion-range": ("pull_off_force",),
}


def places(scene: Scene, loads: AbsoluteLoads, unit: float) -> dict[str, Stretch]:
    """Return where a scene stands along the parameter of each claim that concerns it."""
    found: dict[str, Stretch] = {}
    body, friction, adhesion = scene.indenter, scene.friction, scene.adhesion
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
        fixed = {"cone": 1.0, "paraboloid": 2.0}
        exponent = fixed.get(body.shape, body.parameters.get("exponent"))
        if exponent is not None:
            found["transform-power-law"] = exponent, exponent
        if body.shape == "sphere":
            depths = loads.values / body.parameters["radius"]
            if loads.control == "force":
                ball = sphere(body.parameters["radius"], scene.effective_modulus)
                depths = ball.penetration(loads.values) / body.parameters["radius"]
            found["transform-sphere"] = float(np.min(depths)), float(np.max(depths))
    surface = scene.surface
    rough = surface is not None and not scene.physics and loads.control == "force"
    if surface is not None and rough and np.isfinite(unit):
        free = ("rough-area", "rough-penetration", "rough-mean-gap", "rough-stiffness")
        stretch = float(np.min(loads.values) / unit), float(np.max(loads.values) / unit)
        found |= dict.fromkeys(("rough-area-periodic",) if surface.periodic else free, stretch)
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
    return found


def _ratio(sides: tuple[float, float]) -> Stretch:
    ratio = max(sides) / min(sides)
    return ratio, ratio
