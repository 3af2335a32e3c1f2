"""Fields of large grids at the resolution of a screen: means over blocks of cells.

Quantities are of all cells; only what is stored for pictures is coarser.
"""

from __future__ import annotations

import numpy as np

from comparisons.tasks.shown_loads import MOST_POINTS

# Blocks a side of a stored field; fields of up to MOST_POINTS cells are stored as they are.
SIDE = 512

Blocks = tuple[np.ndarray, np.ndarray]


def blocks_of(shape: tuple[int, ...]) -> Blocks | None:
    """Return the first rows and columns of the blocks of a field; None if it is small enough.

    The last blocks may be smaller than the others.

    >>> blocks_of((4, 4)) is None
    True
    >>> [len(starts) for starts in blocks_of((4096, 1100))]
    [512, 138]
    """
    if shape[0] * shape[1] <= MOST_POINTS:
        return None
    step = -(-max(shape) // SIDE)
    return np.arange(0, shape[0], step), np.arange(0, shape[1], step)


def block_means(field: np.ndarray, blocks: Blocks | None) -> np.ndarray:
    """Return the means over the blocks, or the field itself; forces are kept."""
    if blocks is None:
        return field
    rows, columns = blocks
    sums = np.add.reduceat(np.add.reduceat(field, columns, axis=1, dtype=float), rows, axis=0)
    sides = [np.diff([*starts, n]) for starts, n in zip(blocks, field.shape, strict=True)]
    return np.asarray(sums / np.outer(*sides))
