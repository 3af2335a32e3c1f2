"""Prepared geometry, the common input of all methods, computed once per scene.

A smooth scene becomes an `IndenterGeometry` (the shape, and estimates of the contact size); a
rough one a `RoughGeometry` (the heights of any realisation at any number of points). Loads relative
to the roughness are converted to absolute loads here, so that all methods apply the same force.
"""

from __future__ import annotations

import hashlib
from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import ClassVar

import numpy as np

from comparisons.formatting import with_unit
from comparisons.geometry.estimates import contacts, impact_contacts, largest_contact
from comparisons.geometry.faces import Face, MeasuredFace, combined, faces_of, together, top
from comparisons.scene.indenters.axisymmetric import Profile, Sphere
from comparisons.scene.indenters.indenter import Indenter, RigidPlane
from comparisons.scene.loading import AbsoluteLoads, loads_of
from comparisons.scene.scene import Scene, SceneError
from reduced.loads import Load
from reduced.profiles import equivalents
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference.closed_form import sphere


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
        if loads.control != "velocity":
            return IndenterGeometry(scene.indenter, depth, radius)
        depths, radii = impact_contacts(scene, profile, loads.values)
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
