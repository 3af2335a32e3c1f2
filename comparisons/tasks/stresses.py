"""Quantities that follow from the pressure of one load: its peak, the largest stresses inside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from typing import NamedTuple

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from comparisons.scene.scene import Scene
from reference.elasticity import Material
from reference.halfspace.stress_below import DEPTH_DIGITS, largest_below
from reference.layered.stack import Stack
from reference.layered.stresses import inside

_STRESSES = ("shear_max", "shear_max_depth", "von_mises_max", "von_mises_depth")
FROM_PRESSURE = frozenset({"pressure_peak", *_STRESSES})
# Cells per half-axis on which a pressure known at points is laid.
_CELLS = 32
# What that leaves: twice the change from half as many cells, and of a stress and its depth these
# shares of (cell/depth)^2, nearer than half a cell as there. Against 160 cells the errors below 15
# shapes at five Poisson's ratios are at most 0.9 of it, below balls and ellipsoids 0.2.
_CHANGES, _OF_STRESS, _OF_DEPTH = 2.0, 0.1, 1.0
# And what rings leave of a peak: its change with every other one, for tips like r^1.1 and blunter.
_OF_PEAK = 6.0
# Of nodes, those beside the outermost under pressure belong to it: this share of the half-axis.
_BESIDE = 1.3


class Known(NamedTuple):
    """A value, and the relative half-width of its error; 0: the pressure's own error is all."""

    value: float
    bar: float = 0.0


def pressure_quantities(
    scene: Scene, asked: Iterable[str], fields: Mapping[str, np.ndarray]
) -> dict[str, Known]:
    """Return what is asked for of a pressure; nothing where it is not bounded.

    Stresses are those of a half-space under this pressure, whatever method found it (Love's for
    cells, by waves where it is periodic): of elastic bodies that are the same at all depths. A
    pressure known at points errs by the cells on which it is laid: that is their bar.
    """
    pressure, names = fields["pressure"], FROM_PRESSURE.intersection(asked)
    indenter = scene.indenter
    unbounded = indenter is not None and (indenter.flat or indenter.sharp_tip)
    if not names or unbounded or not np.isfinite(pressure).all():
        return {}
    peak = float(np.max(pressure, initial=0.0))
    uniform = scene.body is None and scene.half_space.uniform and scene.only_pressed
    if uniform and peak == 0:
        return dict.fromkeys(names, Known(0.0))
    at_points = "pressure_shape" not in fields
    bar = 0.0
    if at_points and not np.any(fields["pressure_y"]):  # a ring at the centre is exact there
        fewer = pressure[int(fields["pressure_x"][0] > 0) :: 2]
        bar = _OF_PEAK * (1 - float(fewer.max()) / peak)
    values = {"pressure_peak": Known(peak, bar)}
    if uniform and names - {"pressure_peak"}:
        if at_points:
            # each with what the cells leave
            coarse, fine = (_on_cells(fields, number) for number in (_CELLS // 2, _CELLS))
            before, found = (largest_below(*laid, scene.poisson_ratio) for laid in (coarse, fine))
            most, cell = np.array(found), min(fine[1])
            deep = np.repeat([found.shear_depth, found.von_mises_depth], 2)
            steep = (cell / np.maximum(deep, cell / 2)) ** 2
            left = np.array([_OF_STRESS, _OF_DEPTH] * 2) * steep
            left += [0, DEPTH_DIGITS, 0, DEPTH_DIGITS]
            # of a depth at the surface the change has no scale: its bar is not known
            ratio = np.divide(np.array(before), most, out=np.full(4, np.nan), where=most > 0)
            bars = (_CHANGES * np.abs(ratio - 1) + left).tolist()
        else:
            x, y, cells = (
                np.reshape(fields[f"pressure{end}"], fields["pressure_shape"])
                for end in ("_x", "_y", "")
            )
            spacing = float(x[1, 0] - x[0, 0]), float(y[0, 1] - y[0, 0])
            stress = None
            if scene.surface is not None and scene.surface.periodic:
                body = Stack([], [], Material(1.0, scene.poisson_ratio))

                def stress(depth: float) -> np.ndarray:
                    (field,) = inside(body, cells, spacing, [depth])
                    return field.stress

            found, bars = largest_below(cells, spacing, scene.poisson_ratio, stress), [0.0] * 4
        values |= dict(zip(_STRESSES, map(Known, found, bars), strict=True))
    return {name: value for name, value in values.items() if name in names}


def _on_cells(
    fields: Mapping[str, np.ndarray], number: int
) -> tuple[np.ndarray, tuple[float, float]]:
    """Return a pressure at points on so many cells per half-axis, and their sides."""
    x, y, pressure = (np.asarray(fields[f"pressure{end}"], float) for end in ("_x", "_y", ""))
    units = (np.arange(-number, number) + 0.5) / number
    if not y.any():  # along the x axis of an ellipse, at rings of which each has its area
        half_x = float(x[-1])
        half_y = float(np.sum(fields["pressure_weight"])) / (np.pi * half_x)
        rho = np.hypot(units[:, None], units)
        cells = np.interp(rho, x / half_x, pressure, right=0.0)
    else:
        pressed = pressure > 0
        half_x, half_y = (_BESIDE * float(np.abs(axis[pressed]).max()) for axis in (x, y))
        at_x, at_y = (  # of symmetric bodies one part is meshed
            half * (np.abs(units) if axis.min() > -1e-9 * half else units)
            for axis, half in ((x, half_x), (y, half_y))
        )
        between = LinearNDInterpolator(np.column_stack([x, y]), pressure, fill_value=0.0)
        cells = between(*np.meshgrid(at_x, at_y, indexing="ij"))
    return cells, (half_x / number, half_y / number)
