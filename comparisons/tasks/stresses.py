"""Quantities that follow from the pressure of one load: its peak, the largest stresses inside."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

import numpy as np
from scipy.interpolate import LinearNDInterpolator

from comparisons.scene.scene import Scene
from reference.elasticity import Material
from reference.halfspace.stress_below import largest_below
from reference.layered.stack import Stack
from reference.layered.stresses import inside

FROM_PRESSURE = frozenset(
    {"pressure_peak", "shear_max", "shear_max_depth", "von_mises_max", "von_mises_depth"}
)
# Cells per half-axis on which a pressure known at points is laid: Hertz's stresses to 3e-4.
_CELLS = 32
# Of nodes, those beside the outermost under pressure belong to it: this share of the half-axis.
_BESIDE = 1.3


def pressure_quantities(
    scene: Scene, asked: Iterable[str], fields: Mapping[str, np.ndarray]
) -> dict[str, float]:
    """Return what is asked for of a pressure; nothing where it is not bounded.

    Stresses are those of a half-space under this pressure, whatever method found it (Love's for
    cells, by waves where it is periodic): of elastic bodies that are the same at all depths.
    """
    pressure, names = fields["pressure"], FROM_PRESSURE.intersection(asked)
    indenter = scene.indenter
    unbounded = indenter is not None and (indenter.flat or indenter.sharp_tip)
    if not names or unbounded or not np.isfinite(pressure).all():
        return {}
    values = {"pressure_peak": float(np.max(pressure, initial=0.0))}
    uniform = scene.body is None and scene.half_space.uniform and not scene.physics
    if uniform and values["pressure_peak"] == 0:
        return dict.fromkeys(names, 0.0)
    if uniform and names - {"pressure_peak"}:
        cells, spacing = _on_cells(fields)
        nu, below = scene.poisson_ratio, None
        if scene.surface is not None and scene.surface.periodic:
            body = Stack([], [], Material(1.0, nu))

            def below(depth: float) -> np.ndarray:
                (field,) = inside(body, cells, spacing, [depth])
                return field.stress

        most = largest_below(cells, spacing, nu, below)
        values |= {
            "shear_max": most.shear,
            "shear_max_depth": most.shear_depth,
            "von_mises_max": most.von_mises,
            "von_mises_depth": most.von_mises_depth,
        }
    return {name: value for name, value in values.items() if name in names}


def _on_cells(fields: Mapping[str, np.ndarray]) -> tuple[np.ndarray, tuple[float, float]]:
    """Return a pressure on cells, and their sides."""
    x, y, pressure = (np.asarray(fields[f"pressure{end}"], float) for end in ("_x", "_y", ""))
    if "pressure_shape" in fields:
        x, y, pressure = (a.reshape(fields["pressure_shape"]) for a in (x, y, pressure))
        return pressure, (float(x[1, 0] - x[0, 0]), float(y[0, 1] - y[0, 0]))
    units = (np.arange(-_CELLS, _CELLS) + 0.5) / _CELLS
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
    return cells, (half_x / _CELLS, half_y / _CELLS)
