"""Faces of rough bodies, synthetic or measured.

Between two rough faces only the sum of their heights matters: without friction, and for small
slopes, the gap is all that a contact knows of its surfaces (Johnson 1985, section 4.1).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache, reduce
from math import hypot
from pathlib import Path

import numpy as np
import scipy
from numpy.typing import NDArray
from scipy import fft
from scipy.sparse import coo_array
from scipy.sparse.linalg import splu

from comparisons.formatting import with_unit
from comparisons.geometry.map_files.heights import (
    PLAIN_FORMATS,
    UNITS_PER_METRE,
    Heights,
    read_heights,
    stated_problems,
)
from comparisons.geometry.reading import FileError
from comparisons.scene.scene import Scene, SceneError
from comparisons.scene.surface import TRENDS, MeasuredMap, SelfAffine, subtracted, trend_of
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


Array = NDArray[np.float64]

# Largest and, inverted, smallest range of heights in metres: their squares are numbers.
_LARGEST = 1e100
# Default: undefined points are interpolated below this fraction.
_INTERPOLATED_SHARE = 0.05
# Largest step across the sides of a periodic map, relative to the largest step inside.
_WIDEST_SEAM = 2.0


def read_map(path: Path, surface: MeasuredMap) -> Heights:
    """Read a measured map as stated in the scene: crop, invert, detrend, fill.

    Detrending and interpolation fit and use the defined points only. Inversion comes before the
    filling, so that "lowest" means the points that touch last.

    Undefined points are filled by harmonic interpolation (which cannot exceed the surrounding
    heights), by the lowest defined height, or are refused; by default they are interpolated
    below 5 %, and refused above and, because a NaN may be a mistake there, in .npy, .csv and .txt.

    With a `short_cutoff` a Gaussian filter takes away what is shorter, half of a wave of that
    length (ISO 16610-61, the S-filter of ISO 25178-3); of a patch with its mirror image beyond the
    sides.

    >>> import tempfile
    >>> table = {"kind": "map", "file": "ridge.csv", "size": "3 um", "height_unit": "nm"}
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     file = Path(folder) / "ridge.csv"
    ...     np.savetxt(file, [[0, 0], [1, 1], [0, 0]], delimiter=",")
    ...     ridge = read_map(file, MeasuredMap(**table, detrend="none"))
    >>> ridge.heights[:, 0]  # first index along x
    array([0.e+00, 1.e-09, 0.e+00])
    """
    problems = []
    if not path.is_file():
        problems.append("is a folder" if path.is_dir() else "no such file")
    plain = path.suffix.lower() in PLAIN_FORMATS
    if plain:
        problems += stated_problems(surface, "a plain table")
    for key in ("height_unit", "lateral_unit"):
        unit = getattr(surface, key)
        if unit is not None and unit not in UNITS_PER_METRE:
            problems.append(f"{key} must be m, cm, mm, um, nm, pm or Å, not {unit!r}")
    if surface.channel is not None and plain:
        problems.append(f"channel {surface.channel!r} was given, but a plain table has no channels")
    if problems:
        raise FileError(*problems)
    file, periodic = read_heights(path, surface), surface.periodic
    heights, treatment, origin = file.heights, [*file.treatment], (0, 0)
    if surface.crop:
        x0, y0, nx, ny = surface.crop
        origin = x0, y0
        treatment.append(f"cropped to {nx} x {ny} points from ({x0}, {y0})")
    fate = _fate_of_holes(heights, origin, file.holes_marked, surface.undefined)
    if surface.invert:
        heights = -heights
        treatment.append("inverted: valleys became peaks")
    holes = np.isnan(heights)
    trend = trend_of(surface.detrend, periodic)
    magnitude = float(np.max(np.abs(heights), where=~holes, initial=0.0))
    heights = subtracted(heights, ~holes, trend)
    left = np.ptp(heights[~holes])
    # Subtraction of a trend leaves rounding errors of the original heights.
    if left <= 64 * np.finfo(float).eps * magnitude:
        raise FileError(f"the map is flat: no height differs from another (detrend = {trend!r})")
    if not 1 / _LARGEST < left < _LARGEST:
        raise FileError(f"heights over a range of {left:.3g} m: check height_unit")
    treatment.append(TRENDS[trend].done)
    if holes.any():
        lowest, highest = heights[~holes].min(), heights[~holes].max()
        if fate == "lowest":
            done, heights[holes] = "set to the lowest defined height", lowest
        else:
            filling = _harmonic_fill(heights, holes, file.cell, periodic)
            done = "interpolated from their neighbours"
            heights[holes] = np.clip(filling, lowest, highest)
        treatment.append(
            f"{holes.sum()} of {holes.size} points ({100 * holes.mean():.2f} %) undefined: {done}"
        )
    if (cutoff := surface.short_cutoff) is not None:
        least, most = 2 * max(file.cell), min(file.size)
        if not least * (1 - 1e-9) <= cutoff <= most * (1 + 1e-9):
            raise FileError(
                f"short_cutoff: expected 2 cells = {with_unit(least, 'm')} to the side "
                f"{with_unit(most, 'm')}, got {with_unit(cutoff, 'm')}"
            )
        # by waves of the period, or of a patch with its mirror image: 2^-(cut-off/length)^2
        waves = [
            fft.fftfreq(n, cell) if periodic else np.arange(n) / (2 * n * cell)
            for n, cell in zip(holes.shape, file.cell, strict=True)
        ]
        left = np.exp2(-((cutoff * waves[0][:, None]) ** 2) - (cutoff * waves[1]) ** 2)
        there, back = (fft.fft2, fft.ifft2) if periodic else (fft.dctn, fft.idctn)
        heights = np.ascontiguousarray(np.real(back(left * there(heights))))
        treatment.append(f"waves below {with_unit(cutoff, 'm')} filtered out (Gaussian)")
    for axis, name in enumerate("xy" if periodic else ""):
        # The step across two sides that should match (rms over the side) is compared with the
        # largest step between neighbouring lines inside, so that a groove may end at the border.
        steps = np.diff(heights, axis=axis, append=heights.take([0], axis))
        *inside, across = np.sqrt(np.mean(steps**2, axis=1 - axis))
        if across > _WIDEST_SEAM * max(inside):
            treatment.append(
                f"declared periodic, but along {name} the last line and the first differ by "
                f"{across:.2g} m (rms), neighbours inside by at most {max(inside):.2g} m"
            )
    heights.setflags(write=False)
    return replace(file, heights=heights, treatment=tuple(treatment))


def _fate_of_holes(
    heights: Array, origin: tuple[int, int], holes_marked: bool, undefined: str | None
) -> str:
    """Return the treatment of undefined points; raise FileError if they are not permitted."""

    def first(mask: NDArray[np.bool_]) -> str:
        i, j = np.argwhere(mask)[0] + origin
        return f"({i}, {j})"

    problems = []
    infinite, holes = np.isinf(heights), np.isnan(heights)
    count, share = int(holes.sum()), float(holes.mean())
    if infinite.any():
        problems.append(f"{infinite.sum()} infinite heights, the first at index {first(infinite)}")
    fate = undefined or ("interpolate" if share < _INTERPOLATED_SHARE else "refuse")
    remedy = 'say undefined = "interpolate" or "lowest"'
    if count == heights.size:
        problems.append("no point of the map is defined")
    elif count and undefined is None and not holes_marked:
        problems.append(
            f"{count} NaN in the map, the first at index {first(holes)}; {remedy} "
            "if they mark undefined points"
        )
    elif count and fate == "refuse":
        limit = "" if undefined else f", {100 * _INTERPOLATED_SHARE:.0f} % or more"
        problems.append(
            f"{count} of {heights.size} points ({100 * share:.2f} %{limit}) are undefined, "
            f"the first at index {first(holes)}; {remedy} to use the map anyway"
        )
    if problems:
        raise FileError(*problems)
    return fate


def _harmonic_fill(
    heights: Array, holes: NDArray[np.bool_], cells: tuple[float, float], periodic: bool
) -> Array:
    """Return the heights of the holes that solve Laplace's equation between their rims.

    The five-point scheme keeps the maximum principle: no filled point is higher than the highest,
    or lower than the lowest point of the rim, so that no spurious contact arises. At the border of
    a periodic map the outer neighbour is the point on the opposite side; other maps have no outer
    neighbour (zero normal slope).
    """
    number = np.full(holes.shape, -1)
    number[holes] = np.arange(holes.sum())
    diagonal, right = np.zeros(holes.sum()), np.zeros(holes.sum())
    rows, columns, entries = [], [], []
    for axis, cell in enumerate(cells):
        conductance = (cells[0] / cell) ** 2
        for step in (-1, 1):
            neighbour = np.roll(number, step, axis), np.roll(heights, step, axis)
            beside = np.ones(holes.shape, bool)
            if not periodic:
                np.moveaxis(beside, axis, 0)[min(step, 0)] = False
            pair = holes & beside
            row, column, height = number[pair], neighbour[0][pair], neighbour[1][pair]
            rim = column < 0
            diagonal += np.bincount(row, minlength=diagonal.size) * conductance
            np.add.at(right, row[rim], conductance * height[rim])
            rows.append(row[~rim])
            columns.append(column[~rim])
            entries.append(np.full(row[~rim].size, -conductance))
    index = np.arange(diagonal.size)
    matrix = coo_array(
        (
            np.concatenate([*entries, diagonal]),
            (np.concatenate([*rows, index]), np.concatenate([*columns, index])),
        )
    ).tocsc()
    return splu(matrix, permc_spec="MMD_AT_PLUS_A", options={"SymmetricMode": True}).solve(right)
