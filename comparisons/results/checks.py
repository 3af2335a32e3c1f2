"""Validation of the fields read from a results folder.

A folder may be untrusted or edited by hand, so every deviation from roughline's format is reported
before the data are used.
"""

from __future__ import annotations

import numpy as np

from comparisons.tasks.shown_loads import NAMES, at_step, stored_steps

# Arrays that belong together: of one dimension and one length.
TOGETHER = (
    ("profile_x", "profile_height"),
    ("line_x", "line_height"),
    ("pressure_x", "pressure_y", "pressure", "pressure_weight"),
    ("pressure", "displacement", "gap"),
)
SCALARS = ("penetration", "profile_spacing", "line_penetration", "particle_spacing")
POINTS = ("mesh_points", "mesh_displacement", "particle_places", "particle_displacement")
# Arrays with a row for each particle.
PARTICLES = ("particle_places", "particle_displacement", "particle_von_mises")


def field_problems(fields: dict[str, np.ndarray]) -> list[str]:
    """Return what is wrong with the arrays of one solution, at the last load and before."""
    problems = _problems_at_one_load(fields)
    for step in stored_steps(fields) if not problems else ():
        own = {name: value for name, value in at_step(fields, step).items() if name in NAMES}
        earlier = _problems_at_one_load(own)
        problems += [f"step {step}: {problem}" for problem in earlier]
    return problems


def _problems_at_one_load(fields: dict[str, np.ndarray]) -> list[str]:
    names = {name for group in TOGETHER for name in group} | {*SCALARS, *POINTS}
    arrays = {name: value for name, value in fields.items() if name in names}
    problems = [
        f"{name}: expected numbers"
        for name, value in arrays.items()
        if value.dtype.kind not in "iuf"
    ]
    problems += [
        f"{name}: expected one number"
        for name in SCALARS
        if name in arrays and arrays[name].size != 1
    ]
    problems += [
        f"{name}: expected points (n, 3)"
        for name in POINTS
        if name in arrays and (arrays[name].ndim != 2 or arrays[name].shape[1] != 3)
    ]
    for group in TOGETHER:
        shapes = {arrays[name].shape for name in group if name in arrays}
        if len(shapes) > 1 or any(len(shape) != 1 or shape == (0,) for shape in shapes):
            problems.append(f"{', '.join(group)}: expected lists of one length")
    # the arrays that say how others are laid out
    shape = fields.get("pressure_shape")
    if shape is not None and (
        shape.shape != (2,)
        or shape.dtype.kind not in "iu"
        or int(np.prod(shape)) != fields.get("pressure", np.empty(0)).size
    ):
        problems.append("pressure_shape: expected the two numbers of cells of the pressure")
    heights = fields.get("heights")
    if heights is not None:
        size, contact = fields.get("size"), fields.get("contact")
        if heights.ndim != 2 or heights.dtype.kind not in "iuf" or min(heights.shape) < 1:
            problems.append("heights: expected a map of numbers")
        if size is None or size.shape != (2,) or size.dtype.kind not in "iuf":
            problems.append("size: expected two numbers")
        if contact is not None and contact.shape != heights.shape:
            problems.append("contact: expected a map like that of the heights")
    if len({np.shape(fields[name])[:1] for name in PARTICLES if name in fields}) > 1:
        problems.append(f"{', '.join(PARTICLES)}: expected a row for each particle")
    cells, points = fields.get("mesh_cells"), fields.get("mesh_points")
    if cells is not None and (
        cells.ndim != 2
        or cells.dtype.kind not in "iu"
        or points is None
        or not ((cells >= 0) & (cells < len(points))).all()
    ):
        problems.append("mesh_cells: expected numbers of mesh points")
    return problems
