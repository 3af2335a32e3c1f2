"""Hard maps: holes, outliers, ties, symmetry broken by round-off, single precision."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from comparisons.hard_cases.case import (
    Curves,
    HardCase,
    Known,
    Trusted,
    accurate,
    degraded,
    refused,
)
from comparisons.hard_cases.rough import LINE, SAME_GRID, rough_expected
from comparisons.hard_cases.usual import NO_FORM_FLAT, STEEL, all_methods

if TYPE_CHECKING:
    from comparisons.planning import Plan

Maker = Callable[[], np.ndarray]
_SIDE, _POINTS, _TIP = 16e-6, 16, 10e-6
_TABLE = {
    "kind": "map",
    "file": "map.npy",
    "size": "16 um",
    "height_unit": "m",
    "detrend": "none",
    "realisations": 5,
}
_TWIN = Trusted("bem_dense", (_POINTS,), {"surface": _TABLE | {"file": "twin.npy"}})


def _case(
    name: str,
    title: str,
    hard: str,
    expected: Any,
    make: Maker,
    twin: Maker | None = None,
    **more: Any,
) -> HardCase:
    loading = more.pop("loading", {"penetration": ["20 nm", "60 nm"]})
    truth = more.pop("truth", SAME_GRID if twin is None else _TWIN)

    def write(folder: Path) -> None:
        np.save(folder / "map.npy", make())
        if twin is not None:
            np.save(folder / "twin.npy", twin())

    return HardCase(
        id=f"map-{name}",
        title=title,
        hard=hard,
        scene={"half_space": STEEL, "surface": _TABLE | more, "loading": loading},
        expected=expected,
        resolutions=dict.fromkeys(("reduced", "bem_dense", "bem_fft", "fem"), _POINTS),
        truth=truth,
        files=write,
    )


def _ground() -> np.ndarray:
    from reference.surfaces import self_affine

    sides = (_SIDE, _SIDE)
    return self_affine((_POINTS, _POINTS), sides, hurst=0.8, rms_slope=0.05, seed=1, realisation=0)


def _bump(radius: float = 100e-6) -> np.ndarray:
    x = (np.arange(_POINTS) - (_POINTS - 1) / 2) * _SIDE / _POINTS
    return -(x[:, None] ** 2 + x**2) / (2 * radius)


def _shaken(heights: np.ndarray, relative: float) -> np.ndarray:
    noise = np.random.default_rng(1).normal(size=heights.shape)
    return heights * (1 + relative * noise)


def _with_holes(share: float, value: float = np.nan) -> np.ndarray:
    heights = _ground().copy()
    heights[np.random.default_rng(3).random(heights.shape) < share] = value
    return heights


def _with_one(value: float) -> np.ndarray:
    heights = _ground().copy()
    heights[5, 7] = value
    return heights


def _checkerboard() -> np.ndarray:
    return 1e-8 * (-1.0) ** np.add.outer(np.arange(_POINTS), np.arange(_POINTS))


def _hertz(plan: Plan) -> Curves:
    """Hertz, F = 4/3 E* sqrt(R) d^1.5: the tip of radius R that the map samples."""
    depth = plan.loads.values
    force = 4 / 3 * plan.scene.effective_modulus * np.sqrt(_TIP) * depth**1.5
    return {"force": force, "contact_area": np.pi * _TIP * depth}


_FRACTION = "the contact is smaller than a cell, and one cell or node carries it"

CASES = (
    _case(
        "fraction-of-a-cell",
        "A tip whose contact is a tenth of a cell",
        "a = 0.03 and 0.1 cells: four cells touch at once or none",
        {
            "closed_form": NO_FORM_FLAT,
            "reduced": degraded(2.0, 2.0, why=LINE),
            "bem_dense": degraded(100.0, 5000.0, why=_FRACTION),
            "bem_fft": degraded(100.0, 5000.0, why=_FRACTION),
            "fem": degraded(100.0, 5000.0, why=_FRACTION),
        },
        lambda: _bump(_TIP),
        loading={"penetration": ["0.1 nm", "1 nm"]},
        truth=Known(_hertz, "Hertz"),
    ),
    _case(
        "round-off",
        "A symmetric tip shaken by round-off",
        "ties between symmetric cells are broken at random: the contact set may chatter",
        rough_expected(0.9, 4.0, 0.4, 2.0),
        lambda: _shaken(_bump(), 1e-15),
        twin=_bump,
    ),
    _case(
        "single-precision",
        "A map in single precision",
        "heights to seven digits, read as double precision",
        rough_expected(
            0.9, 4.0, 0.4, 2.0, bem_dense=accurate(1e-5, 1e-6), bem_fft=accurate(1e-5, 1e-6)
        ),
        lambda: _ground().astype(np.float32),
        twin=_ground,
    ),
    _case(
        "half-precision",
        "A map in half precision",
        "heights to three digits",
        rough_expected(
            0.9,
            4.0,
            0.4,
            2.0,
            bem_dense=degraded(0.03, 0.1, why="heights to 0.05 %"),
            bem_fft=degraded(0.03, 0.1, why="heights to 0.05 %"),
        ),
        lambda: (_ground() * 1e9).astype(np.float16),
        twin=lambda: _ground() * 1e9,
        height_unit="nm",
        truth=Trusted(
            "bem_dense", (_POINTS,), {"surface": _TABLE | {"file": "twin.npy", "height_unit": "nm"}}
        ),
    ),
    _case(
        "flat-tops",
        "Heights in steps of 40 nm",
        "many points at exactly the same height: all touch at once",
        rough_expected(0.95, 4.0, 0.6, 2.0),
        lambda: np.round(_ground() / 40e-9) * 40e-9,
    ),
    _case(
        "plateau",
        "A ground-off surface",
        "half of the surface is one plateau",
        rough_expected(0.95, 4.0, 0.4, 2.0),
        lambda: np.minimum(_ground(), 0.0),
    ),
    _case(
        "checkerboard",
        "A checkerboard",
        "all peaks tie, each is one cell, and the Nyquist wave has no phase: sets may cycle",
        rough_expected(1.0, 4.0, 0.6, 2.0),
        _checkerboard,
        loading={"penetration": ["1 nm", "10 nm", "18 nm"]},
    ),
    _case(
        "cycling",
        "A checkerboard shaken by round-off, under small steps of force",
        "neighbours take the load from each other: an active set could cycle",
        rough_expected(5e3, 4.0, 0.6, 2.0),
        lambda: _shaken(_checkerboard(), 1e-15),
        loading={"force": {"from": 1e-6, "to": 1e-1, "steps": 12, "spacing": "log"}},
    ),
    _case(
        "holes",
        "3 % undefined points, interpolated",
        "the filled points must not become the highest",
        rough_expected(0.9, 4.0, 0.4, 2.0),
        lambda: _with_holes(0.03),
        undefined="interpolate",
    ),
    _case(
        "holes-lowest",
        "3 % undefined points, set lowest",
        "pits of one cell beside peaks",
        rough_expected(0.9, 4.0, 0.6, 2.0),
        lambda: _with_holes(0.03),
        undefined="lowest",
    ),
    _case(
        "mostly-holes",
        "60 % undefined points, interpolated",
        "more is invented than measured; the user has insisted",
        rough_expected(0.9, 4.0, 0.6, 3.0),
        lambda: _with_holes(0.6),
        undefined="interpolate",
    ),
    _case(
        "holes-unsaid",
        "NaN in a plain table",
        "a hole, or a mistake of the program that wrote it",
        all_methods(refused('say undefined = "interpolate" or "lowest"')),
        lambda: _with_holes(0.03),
    ),
    _case(
        "all-holes",
        "No defined point",
        "nothing to interpolate from",
        all_methods(refused("no point of the map is defined")),
        lambda: np.full((_POINTS, _POINTS), np.nan),
        undefined="interpolate",
    ),
    _case(
        "infinite",
        "An infinite height",
        "it would be the only peak",
        all_methods(refused("infinite heights, the first at index (5, 7)")),
        lambda: _with_one(np.inf),
    ),
    _case(
        "flat",
        "A map without roughness",
        "no peak touches first",
        all_methods(refused("the map is flat")),
        lambda: np.zeros((_POINTS, _POINTS)),
    ),
    _case(
        "outlier",
        "One spike of 10 um",
        "dust on the sensor: one point carries everything",
        rough_expected(0.999, 4.0, 0.4, 2.0),
        lambda: _with_one(1e-5),
    ),
)
