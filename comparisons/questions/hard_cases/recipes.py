"""Recipes of the maps in hard cases, which replace files with hundreds of heights."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Annotated, Literal

import numpy as np
from pydantic import Field, model_validator

from comparisons.scene.fields import Length, Positive, SceneTable, fail

Seed = Annotated[int, Field(strict=True, ge=0)]
MAKERS = ("self_affine", "paraboloid", "checkerboard", "level")


class SelfAffine(SceneTable):
    """A rough surface as in scenes: the first realisation of `reference.surfaces.self_affine`."""

    hurst: Annotated[Positive, Field(le=1)]
    rms_slope: Positive
    seed: Seed


class Point(SceneTable):
    """A replaced height at one point, in metres."""

    index: tuple[Seed, Seed]
    height: float


class Recipe(SceneTable, populate_by_name=True):
    """Recipe of a square map: made by one of the first five keys, then modified in this order.

    from: another map of the case, which has no `from` itself; else points and side of the map and
    self_affine: a rough surface;
    paraboloid: radius of a tip in the middle, symmetric to the last digit;
    checkerboard: amplitude of alternating heights;
    level: height of all points, in metres.
    factor: factor of the heights.
    noise: relative standard deviation of normal errors, drawn with the seed.
    undefined: approximate fraction of points without height (NaN), drawn with the seed.
    point: a height to be replaced.
    step: quantisation of the heights.
    cut: upper limit of heights, in metres.
    precision: data type of the stored heights.
    """

    start: Annotated[str, Field(alias="from")] = ""
    points: Annotated[int, Field(strict=True, ge=2, le=4096)] = 0
    side: Length = 0.0
    self_affine: SelfAffine | None = None
    paraboloid: Length | None = None
    checkerboard: Length | None = None
    level: float | None = None
    factor: Positive | None = None
    seed: Seed = 0
    noise: Positive | None = None
    undefined: Annotated[Positive, Field(le=1)] | None = None
    point: Point | None = None
    step: Length | None = None
    cut: float | None = None
    precision: Literal["float64", "float32", "float16"] = "float64"

    @model_validator(mode="after")
    def _one_start(self) -> Recipe:
        makers = [key for key in MAKERS if getattr(self, key) is not None]
        came = makers + ["from"] * bool(self.start)
        if len(came) != 1:
            got = " and ".join(came) or "none"
            raise fail(f"expected exactly one of from, {', '.join(MAKERS)}, got {got}")
        if makers and not (self.points and self.side):
            raise fail(f"expected points and side beside {makers[0]}")
        return self

    def save(self, file: Path, maps: Mapping[str, Recipe]) -> None:
        """Write the map; `maps` contains the maps of the case by name."""
        np.save(file, self._heights(maps))

    def _heights(self, maps: Mapping[str, Recipe]) -> np.ndarray:
        heights = maps[self.start]._heights(maps) if self.start else self._generated()
        random = np.random.default_rng(self.seed)
        if self.factor is not None:
            heights = heights * self.factor
        if self.noise is not None:
            heights = heights * (1 + self.noise * random.normal(size=heights.shape))
        if self.undefined is not None:
            heights[random.random(heights.shape) < self.undefined] = np.nan
        if self.point is not None:
            heights[self.point.index] = self.point.height
        if self.step is not None:
            heights = np.round(heights / self.step) * self.step
        if self.cut is not None:
            heights = np.minimum(heights, self.cut)
        return heights.astype(self.precision)

    def _generated(self) -> np.ndarray:
        from reference.surfaces import SelfAffine as Spectrum
        from reference.surfaces import self_affine

        grid = (self.points, self.points)
        if self.self_affine is not None:
            sides = (self.side, self.side)
            rough = self.self_affine
            spectrum = Spectrum(hurst=rough.hurst, rms_slope=rough.rms_slope)
            return self_affine(grid, sides, spectrum, seed=rough.seed, realisation=0).copy()
        if self.paraboloid is not None:
            x = (np.arange(self.points) - (self.points - 1) / 2) * self.side / self.points
            return -(x[:, None] ** 2 + x**2) / (2 * self.paraboloid)
        if self.checkerboard is not None:
            places = np.arange(self.points)
            return self.checkerboard * (-1.0) ** np.add.outer(places, places)
        return np.full(grid, self.level)
