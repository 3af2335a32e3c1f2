"""Displacement and stress below a contact on a grid, for pictures and files."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.elastic_body import elastic_body
from comparisons.methods.normal.grid import Grid
from comparisons.scene.scene import Scene
from reference.elasticity import Material
from reference.halfspace import Contact
from reference.layered import Graded, Stack
from reference.layered.layered_grid import Body
from reference.layered.stresses import Inside, inside

# Empty cells around a free patch, in its sides: images of it change the largest stress by 1 %.
_PADDED = 4
# Depths: the first in cells, each over the one above, and the last in the patch's shorter side.
_FIRST, _RATIO, _DEEPEST = 0.25, 1.25, 0.5
# How far below them a graded body has slices, over the last depth.
_BELOW = 8.0
# Nearly the surface, where the picture has it.
_SURFACE = 1e-6
# Points a side of what is shown.
_SHOWN = 64


def below(scene: Scene, contact: Contact, grid: Grid) -> dict[str, np.ndarray]:
    """Return a mesh of the part of the body where the stress of von Mises is highest.

    The fields are those of waves in the continuum under the pressure of the cells.
    """
    body: Body = elastic_body(scene)
    if scene.half_space.uniform:
        body = Stack([], [], Material(*scene.elastic_constants))
    shape, spacing = contact.pressure.shape, grid.spacing
    depths = _depths(body, shape, spacing)
    if isinstance(body, Graded):
        # a graded body in slices between the depths that are shown, and some below
        last = depths[-1] * _RATIO ** np.arange(1.0, np.ceil(np.log(_BELOW) / np.log(_RATIO)) + 1)
        ends = np.concatenate([[0.0], depths[1:], last])
        materials = body.slices(ends)
        body = Stack(np.diff(ends)[:-1].tolist(), materials[:-1], materials[-1])
    pressure = contact.pressure
    if not contact.operator.periodic:
        pressure = np.zeros([_PADDED * n for n in shape])
        pressure[: shape[0], : shape[1]] = contact.pressure
    fields = [field.cut(*shape) for field in inside(body, pressure, spacing, depths)]
    stresses = [field.von_mises for field in fields]
    highest = max(stresses, key=np.max)
    peak = np.unravel_index(int(highest.argmax()), shape)
    kept = [_kept(n, int(at), scene.rough) for n, at in zip(shape, peak, strict=True)]
    return _mesh(fields, stresses, kept, grid) | {
        "von_mises_depth": np.array([field.depth for field in fields]),
        "von_mises_highest": np.array([stress.max() for stress in stresses]),
    }


def _depths(body: Body, shape: tuple[int, ...], spacing: tuple[float, float]) -> np.ndarray:
    side = min(spacing)
    last = _DEEPEST * min(n * step for n, step in zip(shape, spacing, strict=True))
    if isinstance(body, Stack) and body.base is None:
        last = min(last, body.total)
    number = max(2, int(np.ceil(np.log(last / (_FIRST * side)) / np.log(_RATIO))))
    growing = last * _RATIO ** -np.arange(number, -1.0, -1.0)
    return np.append(_SURFACE * min(side, last), growing)


def _kept(size: int, peak: int, rough: bool) -> np.ndarray:
    """Return the cells of one side that are shown: all thinned out, or a window about the peak."""
    if size <= _SHOWN:
        return np.arange(size)
    if not rough:
        return np.arange(0, size, -(-size // _SHOWN))
    first = int(np.clip(peak - _SHOWN // 2, 0, size - _SHOWN))
    return np.arange(first, first + _SHOWN)


def _mesh(
    fields: list[Inside], stresses: list[np.ndarray], kept: list[np.ndarray], grid: Grid
) -> dict[str, np.ndarray]:
    """Return hexahedra between the centres of cells and the depths; z points into the body."""
    x, y = (
        start + (cells + 0.5) * step
        for start, cells, step in zip(grid.origin, kept, grid.spacing, strict=True)
    )
    z = np.array([field.depth for field in fields])
    z[0] = 0.0
    where = np.ix_(*kept)
    points = np.stack(np.meshgrid(z, x, y, indexing="ij"), axis=-1)[..., [1, 2, 0]]
    number = np.arange(z.size * x.size * y.size).reshape(z.size, x.size, y.size)
    corners = [
        number[k : z.size - 1 + k, i : x.size - 1 + i, j : y.size - 1 + j]
        for k in (0, 1)
        for i, j in ((0, 0), (1, 0), (1, 1), (0, 1))
    ]
    moved = [np.stack([part[where] for part in f.displacement], axis=-1) for f in fields]
    return {
        "mesh_points": points.reshape(-1, 3),
        "mesh_cells": np.stack([corner.ravel() for corner in corners], axis=-1),
        "mesh_displacement": np.array(moved).reshape(-1, 3),
        "mesh_von_mises": np.array([stress[where] for stress in stresses]).ravel(),
    }
