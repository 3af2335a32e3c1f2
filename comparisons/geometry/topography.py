"""Reading of measured maps: crop, orientation, trend, undefined points and short waves."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
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
from comparisons.scene.surface import TRENDS, MeasuredMap, subtracted, trend_of

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
