"""Faces of rough bodies, synthetic or measured.

Between two rough faces only the sum of their heights matters: without friction, and for small
slopes, the gap is all that a contact knows of its surfaces (Johnson 1985, section 4.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache, reduce
from math import hypot
from pathlib import Path

import numpy as np
import scipy

from comparisons.geometry.reading import FileError
from comparisons.geometry.topography import read_map
from comparisons.scene.scene import Scene, SceneError
from comparisons.scene.surface import SelfAffine
from reference import surfaces

# Sides of two maps that differ by less are the same; files round them.
SAME_SIDE = 1e-6
# First number of the key of random streams of surfaces. Lines have the key (1, k); the second of
# two faces with the same seed has its own, or it would be a copy of the first.
STREAM, COPY = 0, 2
# Number of highest points of a measured patch near which the maximum of its splines is sought, and
# the distance in points, beyond which points change a spline by 1e-11 only.
_TOPS, _AROUND = 4, 20
# Searches for that maximum, each on a grid nine times finer than the one before.
_ZOOMS = 5


@dataclass(frozen=True)
class SyntheticFace:
    """A face with random phases: another for every realisation."""

    recipe: SelfAffine
    stream: int
    random = True

    @property
    def size(self) -> tuple[float, float]:
        """Sides in metres."""
        return self.recipe.size

    @property
    def points(self) -> tuple[int, int]:
        """Points per side."""
        return self.recipe.points

    @property
    def band_limited(self) -> bool:
        """Whether the Fourier modes of the face are known."""
        return True

    def native(self, realisation: int) -> np.ndarray:
        """Return the heights on the face's own points."""
        recipe = self.recipe
        return surfaces.self_affine(
            recipe.points,
            recipe.size,
            surfaces.SelfAffine(**recipe.law),
            seed=recipe.seed,
            realisation=realisation,
            stream=self.stream,
        )

    def finer(self, realisation: int, factor: int) -> np.ndarray:
        """Return the heights on a grid with that many points for each one."""
        return surfaces.subdivide(self.native(realisation), factor)

    @cached_property
    def rms_height(self) -> float:
        """Rms height, equal for all realisations, as only phases are random."""
        return float(self.native(0).std())

    @cached_property
    def rms_slope(self) -> float:
        """Rms slope of all realisations, as prescribed or from the modes."""
        if self.recipe.rms_slope is not None:
            return self.recipe.rms_slope
        return surfaces.rms_gradient_spectral(self.native(0), _spacing(self))


@dataclass(frozen=True)
class MeasuredFace:
    """A face that was measured: one for all realisations."""

    heights: np.ndarray = field(repr=False)
    size: tuple[float, float]
    band_limited: bool
    random = False

    @property
    def points(self) -> tuple[int, int]:
        """Points per side."""
        return self.heights.shape

    def native(self, realisation: int) -> np.ndarray:
        """Return the heights as measured."""
        return self.heights

    def finer(self, realisation: int, factor: int) -> np.ndarray:
        """Return the heights on a finer grid: by Fourier modes, of free patches by splines."""
        if self.band_limited:
            return surfaces.subdivide(self.heights, factor)
        return scipy.ndimage.zoom(self.heights, factor, order=3, mode="reflect", grid_mode=True)

    @property
    def rms_height(self) -> float:
        """Rms height."""
        return float(self.heights.std())

    @property
    def rms_slope(self) -> float:
        """Rms slope; of a periodic map that of the band-limited function that all methods use."""
        if self.band_limited:
            return surfaces.rms_gradient_spectral(self.heights, _spacing(self))
        return surfaces.rms_gradient_differences(self.heights, _spacing(self))


Face = SyntheticFace | MeasuredFace


def _spacing(face: Face) -> tuple[float, float]:
    (length, width), (nx, ny) = face.size, face.points
    return length / nx, width / ny


def faces_of(scene: Scene) -> tuple[tuple[Face, ...], tuple[str, ...]]:
    """Return the faces of a rough scene, of the same size and points, and how they were treated."""
    made: list[Face] = []
    treatment: list[str] = []
    problems: list[str] = []
    for key, table in zip(("surface", "surface2"), scene.surfaces, strict=False):
        stream = COPY if made and table.seed == scene.surfaces[0].seed else STREAM
        if isinstance(table, SelfAffine):
            made.append(SyntheticFace(table, stream))
            try:
                made[-1].native(0)
            except (ValueError, ArithmeticError) as error:
                problems.append(f"{key}: {error}")
            continue
        try:
            measured = read_map(Path(scene.directory) / table.file, table)
        except FileError as error:
            problems += [f"{key}.file: {table.file}: {cause}" for cause in error.problems]
            continue
        made.append(MeasuredFace(measured.heights, measured.size, table.periodic))
        where = f"{key}: " if scene.surface2 is not None else ""
        treatment += [where + note for note in measured.treatment]
    if not problems:
        first, *others = made
        for face in others:
            if face.points != first.points:
                problems.append(
                    f"surface2: expected as many points as [surface], {first.points[0]} x "
                    f"{first.points[1]}, got {face.points[0]} x {face.points[1]}"
                )
            if any(
                abs(side - known) > SAME_SIDE * known
                for side, known in zip(face.size, first.size, strict=True)
            ):
                problems.append(
                    f"surface2: expected the sides of [surface], {first.size[0]:g} m x "
                    f"{first.size[1]:g} m, got {face.size[0]:g} m x {face.size[1]:g} m"
                )
    if problems:
        raise SceneError(scene.name, problems)
    if len(made) > 1:
        if combined(made)[0] == 0:
            raise SceneError(scene.name, ["surface2: fills [surface] everywhere: no gap is rough"])
        treatment.append("two rough faces: their heights add up to those of one")
    return tuple(made), tuple(treatment)


def together(faces: Sequence[Face], realisation: int, factor: int = 1) -> np.ndarray:
    """Return the sum of the heights on a grid of the faces' own points, or on a finer one."""
    if factor == 1:
        return reduce(np.add, (face.native(realisation) for face in faces))
    if all(face.band_limited for face in faces):
        return surfaces.subdivide(together(faces, realisation), factor)
    return reduce(np.add, (face.finer(realisation, factor) for face in faces))


def combined(faces: Sequence[Face]) -> tuple[float, float]:
    """Return rms slope and rms height of the sum: squares add where a phase is random."""
    measured = [face for face in faces if isinstance(face, MeasuredFace)]
    parts: list[Face] = [face for face in faces if face.random]
    if measured:
        total, first = together(measured, 0), measured[0]
        limited = all(face.band_limited for face in measured)
        parts.append(MeasuredFace(total, first.size, limited))
    slopes, heights = ([part.rms_slope for part in parts], [part.rms_height for part in parts])
    return hypot(*slopes), hypot(*heights)


@lru_cache(maxsize=4096)  # solves at many loads and on many grids have the same surfaces
def _random_top(faces: tuple[Face, ...], realisation: int) -> float:
    return surfaces.highest(together(faces, realisation))


def top(faces: Sequence[Face], realisation: int) -> float:
    """Return the highest value of the function through the points, of all faces together."""
    if all(face.random for face in faces):
        return _random_top(tuple(faces), realisation)
    native = together(faces, realisation)
    if all(face.band_limited for face in faces):
        return surfaces.highest(native)
    around = np.pad(native, _AROUND, mode="symmetric")
    summits = []
    for place in np.column_stack(
        np.unravel_index(np.argsort(native, axis=None)[-_TOPS:], native.shape)
    ):
        # the highest value of cubic splines a cell around the point; finer grids would find what a
        # coarse search misses, and depths on them have another datum
        part = around[tuple(slice(k, k + 2 * _AROUND + 1) for k in place)]
        highest, reach = np.full(2, float(_AROUND)), 1.0
        for _ in range(_ZOOMS):
            axes = highest[:, None] + reach * np.linspace(-1, 1, 19)
            points = np.stack(np.meshgrid(*axes, indexing="ij"))
            values = scipy.ndimage.map_coordinates(part, points, order=3, mode="reflect")
            highest, reach = points.reshape(2, -1)[:, values.argmax()], reach / 9
        summits.append(float(values.max()))
    return max(summits)
