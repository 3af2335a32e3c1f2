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
from pathlib import Path

import numpy as np
from scipy.ndimage import map_coordinates, zoom

from comparisons.geometry.estimates import impact_contacts, largest_contact
from comparisons.geometry.topography import MapError, read_map
from comparisons.scene.indenters import Indenter, Profile, RigidPlane, Sphere
from comparisons.scene.physics.absolute_loads import AbsoluteLoads, loads_of
from comparisons.scene.scene import Scene, SceneError
from comparisons.scene.surface import MeasuredMap, SelfAffine
from reduced.loads import Load
from reduced.profiles import equivalents
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reference import surfaces
from reference.closed_form import sphere


@dataclass(frozen=True)
class IndenterGeometry:
    """A rigid indenter, with estimates of the largest contact and of the contact at every load.

    The estimates come from the reduced model within a millisecond and only size grids and meshes.
    NaN marks a missing estimate; `unreached` (load step -> reason) explains it.
    """

    indenter: Indenter
    penetration: float
    contact_radius: float
    penetrations: tuple[float, ...] = ()
    contact_radii: tuple[float, ...] = ()
    unreached: Mapping[int, str] = field(default_factory=dict)

    @cached_property
    def reach(self) -> tuple[float, float]:
        """Half-widths of the geometric overlap at the largest load, with a margin of 5 %."""
        half_x, half_y = self.indenter.reach(1.05 * self.penetration)
        return half_x, half_y

    @property
    def digest(self) -> str:
        """Identifier of the geometry in addition to the scene's text: empty."""
        return ""


# Number of highest points of a measured patch near which the maximum of its splines is sought, and
# the distance in points, beyond which points change a spline by 1e-11 only.
_TOPS, _AROUND = 4, 20


@dataclass(frozen=True)
class RoughGeometry:
    """A rough surface: heights (nx, ny) in metres, peaks towards the half-space."""

    size: tuple[float, float]
    points: tuple[int, int]
    periodic: bool
    rms_slope: float
    rms_height: float
    recipe: SelfAffine | None = None
    measured: np.ndarray | None = field(default=None, repr=False)
    treatment: tuple[str, ...] = ()
    _grids: dict[tuple[int, int], np.ndarray] = field(
        default_factory=dict, repr=False, compare=False
    )
    _tops: dict[int, float] = field(default_factory=dict, repr=False, compare=False)

    def heights(self, realisation: int, resolution: int) -> np.ndarray:
        """Return the surface with `resolution` points along x.

        A multiple of the original number of points interpolates, so that a finer grid resolves the
        same surface better. A fraction takes every second, fourth, ... point.

        - A periodic surface, synthetic or measured, is the band-limited function through its
          points (`surfaces.refine`). The origin of the period is arbitrary, so the points need not
          be centres of the original cells: the finer grid keeps them, including the highest one,
          from which the penetration is measured. The line of the reduced model uses the Fourier
          modes of the same function.
        - A synthetic patch likewise, as its Fourier modes are known.
        - A measured patch is interpolated by cubic splines through its points as cell centres, with
          its mirror image beyond the sides.

        Example: 5(cos x + cos y) nm, 32 x 32 points, 640 nm, E* = 100 GPa, 10 uN. The penetration
        is 1.1946 nm with 512 x 512 points of the exact function, 1.1948 nm with the Fourier grid of
        128 x 128, 1.1914 nm with periodic splines (their cells miss the top), and 1.1914 to 1.2108
        nm with mirrored splines. For a self-affine surface with two (four) points per shortest
        wave, the error is 0.2 % of the rms height (zero), and with splines 2 % (0.08 %). Steep
        walls overshoot: by 14 % of a step beside it (splines 11 %), and by 3 % eight points away
        (splines zero).
        """
        key = (realisation, resolution)
        if key not in self._grids:
            self._grids[key] = self._make(realisation, resolution)
        return self._grids[key]

    def top(self, realisation: int) -> float:
        """Return the highest point of the surface, which penetrations are counted from.

        That of the function through the points, not of a grid: grids miss it by different amounts,
        and penetrations on two of them would differ by that, more than by all else.
        """
        if realisation not in self._tops:
            self._tops[realisation] = self._top(self._native(realisation))
        return self._tops[realisation]

    def _top(self, native: np.ndarray) -> float:
        if self.recipe is not None or self.periodic:
            return surfaces.highest(native)
        around = np.pad(native, _AROUND, mode="symmetric")
        highest = np.column_stack(
            np.unravel_index(np.argsort(native, axis=None)[-_TOPS:], native.shape)
        )
        return max(_top_near(around, (int(i), int(j))) for i, j in highest)

    def forget(self) -> None:
        """Drop the cached heights and tops."""
        self._grids.clear()
        self._tops.clear()

    def _make(self, realisation: int, resolution: int) -> np.ndarray:
        native = self._native(realisation)
        if resolution == self.points[0]:
            return native
        if resolution > self.points[0]:
            factor = resolution // self.points[0]
            if self.recipe is not None or self.periodic:
                return surfaces.refine(native, factor)
            return zoom(native, factor, order=3, mode="reflect", grid_mode=True)
        step = self.points[0] // resolution
        return np.ascontiguousarray(native[: resolution * step : step, ::step])

    def _native(self, realisation: int) -> np.ndarray:
        if self.measured is not None:
            return self.measured
        assert self.recipe is not None
        return surfaces.self_affine(
            self.points,
            self.size,
            _spectrum(self.recipe),
            seed=self.recipe.seed,
            realisation=realisation,
        )

    def spacing(self, heights: np.ndarray) -> tuple[float, float]:
        """Return the cell size of a height map on this surface, in metres."""
        return _spacing(self.size, heights)

    @property
    def area(self) -> float:
        """Apparent area A0."""
        return self.size[0] * self.size[1]

    @cached_property
    def digest(self) -> str:
        """Identifier of the geometry in addition to the scene's text: the map as read."""
        if self.measured is None:
            return ""
        frame = np.array([*self.size, *self.points])
        return hashlib.sha256(frame.tobytes() + self.measured.tobytes()).hexdigest()


Geometry = IndenterGeometry | RoughGeometry


def _top_near(around: np.ndarray, place: tuple[int, int]) -> float:
    """Return the highest value of cubic splines a cell around a point of a padded map."""
    part = around[tuple(slice(k, k + 2 * _AROUND + 1) for k in place)]
    steps = _AROUND + np.linspace(-1, 1, 19)
    places = np.stack(np.meshgrid(steps, steps, indexing="ij"))
    return float(map_coordinates(part, places, order=3, mode="reflect").max())


def _spacing(size: tuple[float, float], heights: np.ndarray) -> tuple[float, float]:
    return size[0] / heights.shape[0], size[1] / heights.shape[1]


def prepare(scene: Scene) -> tuple[Geometry, AbsoluteLoads]:
    """Prepare the geometry of a scene and its absolute loads.

    Raises
    ------
    SceneError
        If the map cannot be used, or the load is beyond the shape (a sphere pressed to its
        equator).
    """
    if scene.surface is None:
        loads = loads_of(scene)
        return indenter_geometry(scene, loads), loads
    surface = scene.surface
    geometry = (
        _synthetic(scene, surface) if isinstance(surface, SelfAffine) else _measured(scene, surface)
    )
    unit = 1.0
    if scene.loading.relative:
        unit = scene.effective_modulus * geometry.area * geometry.rms_slope
    return geometry, loads_of(scene, unit)


def indenter_geometry(scene: Scene, loads: AbsoluteLoads) -> IndenterGeometry:
    """Prepare the geometry of a scene without a rough surface for some of the loads.

    Raises
    ------
    SceneError
        If a load is beyond the shape.
    """
    if scene.indenter is None:  # a [body] under a rigid plane: no half-space for an estimate
        return IndenterGeometry(RigidPlane(), np.nan, np.nan)
    estimate = _largest_estimate if scene.physics else _press_estimate
    return estimate(scene, loads)


def _spectrum(recipe: SelfAffine) -> surfaces.SelfAffine:
    names = ("hurst", "power", "rms_slope", "rms_height", "long_cutoff", "short_cutoff")
    return surfaces.SelfAffine(**{name: getattr(recipe, name) for name in names})


def _synthetic(scene: Scene, surface: SelfAffine) -> RoughGeometry:
    try:
        heights = surfaces.self_affine(
            surface.points, surface.size, _spectrum(surface), seed=0, realisation=0
        )
    except (ValueError, ArithmeticError) as error:
        raise SceneError(scene.name, [f"surface: {error}"]) from error
    slope = surface.rms_slope
    if slope is None:
        slope = surfaces.rms_gradient_spectral(heights, _spacing(surface.size, heights))
    height = float(heights.std())  # equal for all realisations, as only phases are random
    return RoughGeometry(
        surface.size, surface.points, surface.periodic, slope, height, recipe=surface
    )


def _measured(scene: Scene, surface: MeasuredMap) -> RoughGeometry:
    try:
        result = read_map(Path(scene.directory) / surface.file, surface)
    except MapError as error:
        causes = getattr(error, "problems", [str(error)])
        problems = [f"surface.file: {surface.file}: {cause}" for cause in causes]
        raise SceneError(scene.name, problems) from error
    except Exception as error:  # readers of instrument files raise arbitrary exceptions
        cause = f"not a readable map ({type(error).__name__}: {error})"
        problem = f"surface.file: {surface.file}: {cause}"
        raise SceneError(scene.name, [problem]) from error
    # For periodic maps, the gradient of the band-limited function that all methods use.
    gradient = (
        surfaces.rms_gradient_spectral if result.periodic else surfaces.rms_gradient_differences
    )
    return RoughGeometry(
        size=result.size,
        points=result.heights.shape,
        periodic=result.periodic,
        rms_slope=gradient(result.heights, result.spacing),
        rms_height=float(result.heights.std()),
        measured=result.heights,
        treatment=tuple(result.treatment),
    )


def equivalent_profile(indenter: Indenter) -> equivalents.Profile:
    """Return the reduced model's profile of an indenter by the rule of the chapter.

    Exact (MDR) for axisymmetric shapes, the Gaussian radius for ellipsoids, and
    D = (4 A / pi)^(1/2) for flat punches of any outline.

    Raises
    ------
    ValueError
        If `reduced.profiles.equivalents` has no profile for the shape.
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


def _largest_estimate(scene: Scene, loads: AbsoluteLoads) -> IndenterGeometry:
    """Estimate the largest contact of a scene with physics; for impacts, also every step."""
    assert scene.indenter is not None
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


# Estimates from one line of springs are used down to this fraction of its largest contact radius.
COARSEST_SHARE = 1 / 8


def _press_estimate(scene: Scene, loads: AbsoluteLoads) -> IndenterGeometry:
    assert scene.indenter is not None
    estimates = _Estimates.empty(len(loads.values))
    depth, radius = estimates.depth, estimates.radius
    try:
        profile = equivalent_profile(scene.indenter)
        with np.errstate(all="ignore"):
            estimates.fill(profile, scene.effective_modulus, loads)
        if len(estimates.unreached) == len(depth):
            raise ValueError(estimates.unreached[0])
        if isinstance(scene.indenter, Sphere):
            # Springs have no limit; the closed form raises if the contact would reach R.
            closed = sphere(scene.indenter.radius, scene.effective_modulus)
            closed.force(depth[np.isfinite(depth)])
    except (ValueError, RuntimeError, ArithmeticError) as error:
        raise SceneError(scene.name, [f"loading.{loads.control}: {error}"]) from error
    last = np.flatnonzero(np.isfinite(radius))[-1]
    return IndenterGeometry(
        scene.indenter,
        float(depth[last]),
        float(radius[last]),
        tuple(depth.tolist()),
        tuple(radius.tolist()),
        estimates.unreached,
    )


@dataclass(frozen=True)
class _Estimates:
    """Penetration and contact radius at every load (NaN if unknown), with the reasons."""

    depth: np.ndarray
    radius: np.ndarray
    unreached: dict[int, str]

    @classmethod
    def empty(cls, loads: int) -> _Estimates:
        return cls(np.full(loads, np.nan), np.full(loads, np.nan), {})

    def fill(
        self, profile: equivalents.Profile, modulus: float, loads: AbsoluteLoads, first: int = 0
    ) -> None:
        """Fill in the estimates of consecutive loads, beginning at step `first`.

        A line of springs is sized for its largest contact; much smaller contacts get a finer line.
        Loads without an estimate are isolated by bisection, so that the others keep theirs.
        """
        values, reason = loads.values, "beyond the range of double precision"
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
            steps = slice(first + start, first + len(values))
            self.depth[steps], self.radius[steps] = contact.penetration[start:], lengths[start:]
        elif len(values) == 1:
            self.unreached[first] = reason
            return
        cut = start if tail else len(values) // 2
        for low, high in ((0, cut), (cut, start)):
            if low < high:
                part = AbsoluteLoads(loads.control, values[low:high])
                self.fill(profile, modulus, part, first + low)
