"""Prepared geometry, the common input of all methods, computed once per scene.

A smooth scene becomes an `IndenterGeometry` (the shape, and estimates of the contact size); a
rough one a `RoughGeometry` (the heights of any realisation at any number of points). Loads relative
to the roughness are converted to absolute loads here, so that all methods apply the same force.

The estimates are not results. Those with physics use independent springs with the lowest modulus of
the material (in an impact with that of its duration), and take a millisecond.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from comparisons.formatting import told_apart, with_unit
from comparisons.geometry.faces import Face, MeasuredFace, combined, faces_of, together, top
from comparisons.scene.indenters.axisymmetric import Profile, Sphere
from comparisons.scene.indenters.indenter import Indenter, RigidPlane
from comparisons.scene.loading import AbsoluteLoads, loads_of
from comparisons.scene.scene import Scene, SceneError
from reduced.loads import Load
from reduced.motion.elastic_impact import impact_depth
from reduced.profiles import equivalents
from reduced.springs.indent import indent
from reduced.springs.layers import Grading
from reduced.springs.line import Springs
from reference.closed_form import sphere
from reference.elasticity import Material
from reference.layered import Graded, RoundContact, Stack


@dataclass(frozen=True)
class IndenterGeometry:
    """A rigid indenter, with estimates of the largest contact and of the contact at every load.

    The estimates come from the reduced model within a millisecond and only size grids and meshes.
    NaN marks a missing estimate; `unreached` (load step -> reason) explains it. `rim_gap` is the
    gap of the shape at the rim of the largest contact, where that may be more than the penetration:
    rubber on a rigid base rises beside a contact.
    """

    indenter: Indenter
    penetration: float
    contact_radius: float
    penetrations: tuple[float, ...] = ()
    contact_radii: tuple[float, ...] = ()
    unreached: Mapping[int, str] = field(default_factory=dict)
    rim_gap: float = 0.0
    periodic: ClassVar[bool] = False
    random: ClassVar[bool] = False

    @cached_property
    def reach(self) -> tuple[float, float]:
        """Half-widths of the geometric overlap at the largest load, with a margin of 5 %."""
        half_x, half_y = self.indenter.reach(1.05 * max(self.penetration, self.rim_gap))
        return half_x, half_y

    @property
    def digest(self) -> str:
        """Identifier of the geometry in addition to the scene's text: empty."""
        return ""


@dataclass(frozen=True)
class RoughGeometry:
    """A rough surface: heights (nx, ny) in metres, peaks towards the half-space.

    Of two rough bodies the sum of their faces.
    """

    size: tuple[float, float]
    points: tuple[int, int]
    periodic: bool
    rms_slope: float
    rms_height: float
    faces: tuple[Face, ...] = ()
    treatment: tuple[str, ...] = ()
    _grids: dict[tuple[int, int], np.ndarray] = field(
        default_factory=dict, repr=False, compare=False
    )
    _tops: dict[int, float] = field(default_factory=dict, repr=False, compare=False)

    def heights(self, realisation: int, resolution: int) -> np.ndarray:
        """Return the surface with `resolution` points along x.

        A multiple of the original number of points interpolates, so that a finer grid resolves the
        same surface better. A fraction takes every second, fourth, ... point. The points are
        centres of cells, and a finer grid divides these cells: it covers the same area, and the
        pressures on two grids are those of the same places.

        - A periodic surface, synthetic or measured, is the band-limited function through its
          points (`surfaces.subdivide`); the line of the reduced model uses its Fourier modes.
        - A synthetic patch likewise, as its Fourier modes are known.
        - A measured patch is interpolated by cubic splines through its points, with its mirror
          image beyond the sides.

        Example: 5(cos x + cos y) nm, 32 x 32 points, 640 nm, E* = 100 GPa, 10 uN. The penetration
        is 1.1946 nm with 512 x 512 points of the exact function, 1.1944 nm with the Fourier grid of
        128 x 128, and 1.1914 to 1.2108 nm with mirrored splines. For a self-affine surface with
        two (four) points per shortest wave, the error is 0.2 % of the rms height (zero), and with
        splines 2 % (0.08 %). Steep walls overshoot: by 14 % of a step beside it (splines 11 %),
        and by 3 % eight points away (splines zero).
        """
        key = (realisation, resolution)
        if key not in self._grids:
            finer = max(1, resolution // self.points[0])
            heights = together(self.faces, realisation, finer)
            if resolution < self.points[0]:
                step = self.points[0] // resolution
                heights = np.ascontiguousarray(heights[: resolution * step : step, ::step])
            self._grids[key] = heights
        return self._grids[key]

    def top(self, realisation: int) -> float:
        """Return the highest point of the surface, which penetrations are counted from.

        That of the function through the points, not of a grid: grids miss it by different amounts,
        and penetrations on two of them would differ by that, more than by all else.
        """
        if realisation not in self._tops:
            self._tops[realisation] = top(self.faces, realisation)
        return self._tops[realisation]

    def forget(self) -> None:
        """Drop the cached heights and tops."""
        self._grids.clear()
        self._tops.clear()

    @property
    def random(self) -> bool:
        """Whether every realisation has a surface of its own."""
        return any(face.random for face in self.faces)

    @property
    def measured(self) -> np.ndarray | None:
        """The map as read and treated, if it is all that there is."""
        only = self.faces[0] if len(self.faces) == 1 else None
        return only.heights if isinstance(only, MeasuredFace) else None

    def spacing(self, heights: np.ndarray) -> tuple[float, float]:
        """Return the cell size of a height map on this surface, in metres."""
        return self.size[0] / heights.shape[0], self.size[1] / heights.shape[1]

    @property
    def area(self) -> float:
        """Apparent area A0."""
        return self.size[0] * self.size[1]

    @cached_property
    def digest(self) -> str:
        """Identifier of the geometry in addition to the scene's text: the maps as read."""
        maps = [face.heights for face in self.faces if isinstance(face, MeasuredFace)]
        if not maps:
            return ""
        frame = np.array([*self.size, *self.points])
        read = b"".join(heights.tobytes() for heights in maps)
        return hashlib.sha256(frame.tobytes() + read).hexdigest()


Geometry = IndenterGeometry | RoughGeometry


def prepare(scene: Scene) -> tuple[Geometry, AbsoluteLoads]:
    """Prepare the geometry of a scene and its absolute loads.

    SceneError where a map cannot be used, or a load is beyond the shape (a sphere pressed to its
    equator).
    """
    if scene.surface is None:
        loads = loads_of(scene)
        return indenter_geometry(scene, loads), loads
    faces, treatment = faces_of(scene)
    slope, height = combined(faces)
    periodic, (first, *_) = scene.surface.periodic, faces
    geometry = RoughGeometry(first.size, first.points, periodic, slope, height, faces, treatment)
    unit = scene.loading.unit(geometry.area, scene.effective_modulus * geometry.rms_slope)
    return geometry, loads_of(scene, unit)


def indenter_geometry(scene: Scene, loads: AbsoluteLoads) -> IndenterGeometry:
    """Prepare the geometry of a scene without a rough surface for some of the loads."""
    if scene.indenter is None:  # a [body] under a rigid plane: no half-space for an estimate
        return IndenterGeometry(RigidPlane(), np.nan, np.nan)
    if not scene.half_space.uniform:
        try:
            profile = equivalent_profile(scene.indenter)
            deep, wide = contacts(scene, profile, loads)
        except (ValueError, RuntimeError, ArithmeticError) as error:
            raise SceneError(scene.name, [f"loading.{loads.control}: {error}"]) from error
        section, largest = profile.section, float(wide[-1])
        inside = section is not None and largest < section.edge
        rim = float(section.height(np.array([largest]))[0]) if section and inside else 0.0
        return IndenterGeometry(
            scene.indenter,
            float(deep[-1]),
            largest,
            tuple(deep.tolist()),
            tuple(wide.tolist()),
            rim_gap=rim,
        )
    if not scene.physics:
        return _press_estimate(scene, loads)
    # the largest contact; of impacts also every step
    try:
        profile = equivalent_profile(scene.indenter)
        depth, radius = largest_contact(scene, profile, loads)
        if not 0 < radius < np.inf:
            raise ValueError("no contact at any of the loads")
        oil = scene.lubrication
        if oil is not None and oil.meniscus is not None and oil.meniscus <= radius:
            dry, given = told_apart(radius, oil.meniscus, unit="m")
            raise ValueError(
                f"expected a contact inside the meniscus, {given}, got a radius of {dry}"
            )
        if loads.control != "velocity":
            return IndenterGeometry(scene.indenter, depth, radius)
        # some velocities are estimated; between them, power laws interpolate
        speeds, few = loads.values, np.linspace(0, loads.values.size - 1, IMPACTS).round()
        chosen = speeds[np.unique(few.astype(int))]
        struck = [_struck(scene, profile, speed) for speed in chosen]
        depths = np.exp(np.interp(np.log(speeds), np.log(chosen), np.log(struck)))
        radii = np.asarray(profile.contact_radius(depths))
    except (ValueError, RuntimeError, ArithmeticError) as error:
        raise SceneError(scene.name, [f"loading: {error}"]) from error
    return IndenterGeometry(
        scene.indenter, depth, radius, tuple(depths.tolist()), tuple(radii.tolist())
    )


def equivalent_profile(indenter: Indenter) -> equivalents.Profile:
    """Return the reduced model's profile of an indenter by the rule of the chapter.

    Exact (MDR) for axisymmetric shapes, the Gaussian radius for ellipsoids, and
    D = (4 A / pi)^(1/2) for flat punches of any outline.
    """
    if isinstance(indenter, Profile):
        r, f = np.array(indenter.r), np.array(indenter.f)
        return equivalents.tabulated(r, f, interpolation=indenter.interpolation)
    profile = indenter.made_by(equivalents)
    if profile is None and indenter.face_area is not None:
        profile = equivalents.equivalent_punch(indenter.face_area)
    if profile is None:
        raise ValueError(f"no equivalent profile is known for a {indenter.in_words}")
    return profile


# Estimates from one line of springs are used down to this fraction of its largest contact radius.
COARSEST_SHARE = 1 / 8


def _press_estimate(scene: Scene, loads: AbsoluteLoads) -> IndenterGeometry:
    assert scene.indenter is not None
    depth, radius = np.full((2, len(loads.values)), np.nan)
    unreached: dict[int, str] = {}

    def estimate(first: int, end: int) -> None:
        """Estimate the contacts of consecutive loads.

        A line of springs is sized for its largest contact; much smaller contacts get a finer line.
        Loads without an estimate are isolated by bisection, so that the others keep theirs.
        """
        values, reason = loads.values[first:end], "beyond the range of double precision"
        try:
            contact = indent(Springs(profile, modulus), Load(loads.control, values))
            lengths = contact.contact_radius
            fits = (lengths >= COARSEST_SHARE * lengths[-1]) & np.isfinite(contact.penetration)
            tail = int(np.argmin(fits[::-1])) if not fits.all() else len(values)
        except (ValueError, RuntimeError, ArithmeticError) as error:
            tail = 0
            if isinstance(error, (ValueError, RuntimeError)) and "NaN" not in str(error):
                reason = str(error)
        start = len(values) - tail
        if tail:
            steps = slice(first + start, end)
            depth[steps], radius[steps] = contact.penetration[start:], lengths[start:]
        elif len(values) == 1:
            unreached[first] = reason
            return
        cut = start if tail else len(values) // 2
        for low, high in ((0, cut), (cut, start)):
            if low < high:
                estimate(first + low, first + high)

    try:
        profile, modulus = equivalent_profile(scene.indenter), scene.effective_modulus
        with np.errstate(all="ignore"):
            estimate(0, len(depth))
        if len(unreached) == len(depth):
            raise ValueError(unreached[0])
        if isinstance(scene.indenter, Sphere):
            # Springs have no limit.
            closed = sphere(scene.indenter.radius, scene.effective_modulus)
            if (deepest := float(np.nanmax(depth))) > closed.limit:
                most, why = with_unit(closed.limit, "m"), closed.limit_reason
                raise ValueError(f"penetration {with_unit(deepest, 'm')} is above {most}: {why}")
    except (ValueError, RuntimeError, ArithmeticError) as error:
        raise SceneError(scene.name, [f"loading.{loads.control}: {error}"]) from error
    last = np.flatnonzero(np.isfinite(radius))[-1]
    return IndenterGeometry(
        scene.indenter,
        float(depth[last]),
        float(radius[last]),
        tuple(depth.tolist()),
        tuple(radius.tolist()),
        unreached,
    )


# Contact radii and penetrations are sought between these fractions and the characteristic length of
# a shape.
SMALLEST, LARGEST = 1e-9, 1e6
# Number of impacts in a list that are estimated individually.
IMPACTS = 12
# Loads that are estimated one by one; between them power laws interpolate.
_SINGLE = 6
# Of the contact radius.
_TOLERANCE = 1e-3
_HALVINGS = 10
# Contacts on layers take a second; plans that differ in what is compared have the same ones.
_known: dict[tuple[str, str, bytes], tuple[np.ndarray, np.ndarray]] = {}
_MOST = 256


def largest_contact(
    scene: Scene, profile: equivalents.Profile, loads: AbsoluteLoads
) -> tuple[float, float]:
    """Return the penetration and contact radius of the largest contact in a scene."""
    if scene.dynamics is not None and loads.control != "force":
        depth = _struck(scene, profile, max(scene.dynamics.velocity.values))
        return depth, float(profile.contact_radius(depth))
    if scene.adhesion is not None:
        # JKR: d = g(a) - l(a), l = pull sqrt(a) (Hess); F = 2 E* (a d - int_0^a g dx)
        modulus, by_depth = scene.effective_modulus, loads.control == "penetration"
        pull = np.sqrt(2 * np.pi * scene.adhesion.work / modulus)
        radii = profile.length * np.geomspace(SMALLEST, LARGEST, 4000)
        radii = np.append(radii[radii < profile.edge], min(profile.edge, radii[-1]))
        load = float(loads.values.max())
        with np.errstate(invalid="ignore"):  # beyond the edge of a shape its height is infinite
            height = np.asarray(profile.height(radii), dtype=float)
            trapezia = 0.5 * (height[1:] + height[:-1]) * np.diff(radii)
            below = np.concatenate([[0.0], np.cumsum(trapezia)])
            depths = height - pull * np.sqrt(radii)
            forces = 2 * modulus * (radii * depths - below)
            within = np.flatnonzero((depths if by_depth else forces) <= load)
        # Of several equilibria the widest counts. If every contact carries more, the load is beyond
        # pull-off, and the smallest one does.
        widest = within[-1] if len(within) else 0
        a = float(radii[widest])
        depth = load if by_depth else 0.5 * load / (modulus * a) + float(below[widest]) / a
        return depth, a
    normal = loads if loads.normal is None else loads.normal
    modulus = scene.effective_modulus
    if scene.viscoelastic is not None and loads.times is not None:
        softest = scene.viscoelastic.softest_modulus(float(loads.times[-1] - loads.times[0]))
        modulus = 2.0 * softest / (1.0 - scene.poisson_ratio)
    largest = float(normal.values.max())
    if largest <= 0:
        raise ValueError("expected at least one positive load")
    contact = indent(Springs(profile, modulus), Load(normal.control, largest))
    depth, radius = float(contact.penetration[0]), float(contact.contact_radius[0])
    if scene.wear is not None and normal.control == "force":
        # It goes deeper by less than a rigid plane would have to cut the worn volume k F s off it;
        # in fretting also by less than the force presses its stick circle alone.
        table, body = scene.wear, profile.section or profile
        slip = 1.0 if table.amplitude is None else 4 * table.amplitude
        goal, first = table.coefficient * largest * slip * float(loads.values[-1]), radius
        while _cut(body, radius)[1] < goal and radius < profile.edge:
            radius = min(1.02 * radius, profile.edge)
        cut, volume = _cut(body, radius)
        cut += max(goal - volume, 0.0) / (np.pi * radius**2)
        if scene.friction is not None and table.amplitude is not None:
            modulus = scene.effective_modulus
            ratio = scene.tangential_modulus / (scene.friction.coefficient * modulus)
            stuck = depth - ratio * table.amplitude
            if stuck > 0:
                circle = float(profile.contact_radius(stuck))
                cut = min(cut, 0.5 * largest / (modulus * circle))
                radius = first
        depth += cut
    return depth, radius


def _struck(scene: Scene, profile: equivalents.Profile, speed: float) -> float:
    """Return the penetration of an impact; rubber has the modulus of a strain that grows as fast.

    That modulus falls slower than 1/d as the depth d grows, and the depth rises with at most
    the root of the softness: each round halves the error.
    """
    assert scene.dynamics is not None
    energy = 0.5 * scene.dynamics.mass * speed**2
    depth = impact_depth(profile, scene.effective_modulus, energy)
    if scene.viscoelastic is not None:
        for _ in range(_HALVINGS):
            modulus = 2 * scene.viscoelastic.ramp_modulus(depth / speed) / (1 - scene.poisson_ratio)
            depth = impact_depth(profile, modulus, energy)
    return depth


def _cut(body: equivalents.Section, radius: float) -> tuple[float, float]:
    """Return height and volume of what a plane cuts off a body of revolution at a radius."""
    r = radius * np.linspace(0.0, 1.0, 200)
    height = np.asarray(body.height(r), dtype=float)
    volume = np.trapezoid(2 * np.pi * r * (height[-1] - height), r)
    return float(height[-1]), float(volume)


def elastic_body(scene: Scene) -> Stack | Graded:
    """Return the layers or the grading of a scene; a half-space is a stack without layers."""
    table = scene.half_space
    material = Material(*table.elastic_constants)
    if table.grading is not None:
        return Graded(material, table.grading.exponent, table.grading.depth)
    thicknesses = [layer.thickness for layer in table.layers]
    materials = [Material(layer.youngs_modulus, layer.poisson_ratio) for layer in table.layers]
    if table.thickness is None:
        return Stack(thicknesses, materials, material)
    return Stack([*thicknesses, table.thickness], [*materials, material])


def grading_of(scene: Scene) -> Grading:
    """Return the reduced model's grading of a scene that has one."""
    table = scene.half_space.grading
    assert table is not None
    return Grading(scene.effective_modulus, scene.poisson_ratio, table.exponent, table.depth)


def contacts(
    scene: Scene, profile: equivalents.Profile, loads: AbsoluteLoads
) -> tuple[np.ndarray, np.ndarray]:
    """Return penetrations and contact radii at every load."""
    body = elastic_body(scene)
    if isinstance(body, Stack):
        text = scene.model_dump_json(exclude={"name", "title", "compare", "methods"})
        key = text, loads.control, loads.values.tobytes()
        if key not in _known:
            if len(_known) == _MOST:
                _known.clear()
            plain = Springs(profile, scene.effective_modulus)
            hertz = indent(plain, Load(loads.control, loads.values)).contact_radius
            # some loads one by one, between them power laws
            chosen = np.unique(np.linspace(0, len(hertz) - 1, _SINGLE).round().astype(int))
            contact = RoundContact(body, profile.height, profile.edge)
            steps = [
                contact.at(loads.control, float(value), float(guess), _TOLERANCE)
                for value, guess in zip(loads.values[chosen], hertz[chosen], strict=True)
            ]
            at, few = np.log(loads.values), np.log(loads.values[chosen])
            depth, radius = (
                np.exp(np.interp(at, few, np.log([getattr(step, name) for step in steps])))
                for name in ("penetration", "contact_radius")
            )
            _known[key] = depth, radius
        return _known[key]
    if profile.section is None:
        raise ValueError("on a graded half-space expected a body of revolution")
    grading = grading_of(scene)
    springs = Springs(grading.profile(profile.section), grading.spring_modulus)
    pressed = indent(springs, Load(loads.control, loads.values))
    return pressed.penetration, grading.place(pressed.contact_radius)
