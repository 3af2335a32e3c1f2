"""Make the Gmsh file of the body example: a finite steel block, graded towards one corner.

A quarter of a block of 4 mm x 4 mm x 2 mm: the indenter's axis is the edge x = y = 0, the symmetry
planes are rollers. ``python docs/examples/block_mesh.py FOLDER`` writes ``block.msh``, which
``block.toml`` beside this script names. With Gmsh itself, give the same surfaces physical names.
"""

from __future__ import annotations

import sys
from pathlib import Path

import meshio
import numpy as np

NAMES = ("top", "bottom", "x0", "y0", "block")
SIDE, HEIGHT = 2.0, 2.0  # mm
CELLS = 8


def lines(length: float) -> np.ndarray:
    """Return cell edges that crowd towards 0, where the contact is."""
    return length * np.linspace(0.0, 1.0, CELLS + 1) ** 1.8


def block() -> meshio.Mesh:
    """Return hexahedra, and the named quadrilaterals on four of their sides; z points up."""
    plane, depth = lines(SIDE), -lines(HEIGHT)
    points = np.stack(np.meshgrid(plane, plane, depth, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape(len(plane), len(plane), len(depth))
    low, high = slice(None, -1), slice(1, None)
    # the lower layer first, counter-clockwise seen from above, then the upper one
    corners = [
        number[x, y, z].ravel()
        for z in (high, low)
        for x, y in ((low, low), (high, low), (high, high), (low, high))
    ]
    sides = (number[:, :, 0], number[:, :, -1], number[0], number[:, 0])
    quads, tags = [], []
    for tag, side in enumerate(sides, 1):
        cells = (side[:-1, :-1], side[1:, :-1], side[1:, 1:], side[:-1, 1:])
        quads.append(np.stack([corners.ravel() for corners in cells], axis=-1))
        tags.append(np.full(len(quads[-1]), tag))
    hexahedra = np.stack(corners, axis=-1)
    tagged = [np.concatenate(tags), np.full(len(hexahedra), 5)]
    return meshio.Mesh(
        points,
        [("quad", np.concatenate(quads)), ("hexahedron", hexahedra)],
        cell_data={"gmsh:physical": tagged, "gmsh:geometrical": tagged},
        field_data={name: np.array([k, 2 + (k == 5)]) for k, name in enumerate(NAMES, 1)},
    )


def main(folder: str) -> None:
    """Write block.msh."""
    meshio.write(Path(folder) / "block.msh", block(), file_format="gmsh22", binary=False)


if __name__ == "__main__":
    main(sys.argv[1] if len(sys.argv) > 1 else ".")
