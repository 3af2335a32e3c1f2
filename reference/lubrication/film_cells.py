"""Rectangular cells for a lubricating film: equal where bodies deform, wider and wider around it.

The film reaches much farther than the contact: of the force of a rigid ball that is entrained, the
part beyond r falls only as 1/r. Wide cells far out cost little; pressure there bends nothing.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray

from reference.arguments import refuse

Field = NDArray[np.float64]

# Each cell of the surroundings is wider than the one before by this share over the number of cells
# per unit of length: the surroundings are refined with the core, down to the least share.
SHARE = 3.0
LEAST = 0.12


@dataclass(frozen=True)
class FilmCells:
    """A tensor grid of cells with increasing edges x and y.

    The elastic body gives way below the `core` of equal cells. If `mirrored`, the cells are one
    half (y > 0) of a film that is even in y: nothing flows through the edge of smallest y. If
    `closed`, nothing flows through the edges across y at all: a film of infinite width. At all
    other edges p = 0.
    """

    x: Field
    y: Field
    core: tuple[slice, slice]
    mirrored: bool = True
    closed: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """Number of cells along x and y."""
        return self.x.size - 1, self.y.size - 1

    @property
    def copies(self) -> int:
        """How many mirror images the film consists of."""
        return 2 if self.mirrored else 1

    @property
    def core_shape(self) -> tuple[int, int]:
        """Number of equal cells along x and y."""
        rows, columns = self.core
        return rows.stop - rows.start, columns.stop - columns.start

    @cached_property
    def centres(self) -> tuple[Field, Field]:
        """The centres along x and y, as an open mesh."""
        x, y = (self.x[1:] + self.x[:-1]) / 2, (self.y[1:] + self.y[:-1]) / 2
        return x[:, None], y[None, :]

    @cached_property
    def widths(self) -> tuple[Field, Field]:
        """Sides of the cells, as an open mesh."""
        return np.diff(self.x)[:, None], np.diff(self.y)[None, :]

    @cached_property
    def area(self) -> Field:
        """Area of the cells, mirror images included."""
        across, along = self.widths
        return self.copies * across * along

    def whole(self, values: Field, *, odd: bool = False) -> Field:
        """Return values with those of the mirror images, of opposite sign where odd."""
        if not self.mirrored:
            return values
        return np.concatenate([(-1 if odd else 1) * values[:, ::-1], values], axis=1)

    @property
    def whole_core(self) -> tuple[slice, slice]:
        """The equal cells, mirror images included, where `whole` has them."""
        rows, columns = self.core
        if not self.mirrored:
            return rows, columns
        size = self.shape[1]
        return rows, slice(size - columns.stop, size + columns.stop)

    @property
    def spacing(self) -> tuple[float, float]:
        """Sides of the equal cells."""
        rows, columns = self.core
        return (
            float(self.x[rows.start + 1] - self.x[rows.start]),
            float(self.y[columns.start + 1] - self.y[columns.start]),
        )


def stretched(
    start: float, stop: float, steps: int, ends: tuple[float, float], growth: float
) -> Field:
    """Return edges: `steps` equal ones from start to stop, growing ones on to the ends."""
    inner = np.linspace(start, stop, steps + 1)
    step = inner[1] - inner[0]
    growing = []
    for length in (start - ends[0], ends[1] - stop):
        count = 0
        if length > 0:
            ratio = np.log1p(length / step * (growth - 1)) / np.log(growth)
            count = max(1, int(np.ceil(ratio)) - 1)
        edges = step * np.cumsum(growth ** np.arange(1, count + 1))
        growing.append(edges * (length / edges[-1]) if count else np.empty(0))
    return np.concatenate([(start - growing[0])[::-1], inner, stop + growing[1]])


def around_point(
    per_unit: int,
    along: tuple[float, float],
    across: float,
    reach: float,
    begins: float = np.inf,
    mirrored: bool = True,
) -> FilmCells:
    """Return the cells around a point contact, or one half of them.

    `per_unit` equal cells per unit of length lie `along` x from a beginning to an end, and `across`
    in y to either side; the whole grid has the half-width `reach`, and `begins` no farther than
    that distance along x.
    """
    refuse([] if per_unit >= 2 else [f"per_unit must be at least 2, not {per_unit!r}"])
    first, last = max(along[0], -begins), along[1]
    nx, ny = round(per_unit * (last - first)), round(per_unit * across)
    reach = max(reach, 1.01 * max(-along[0], along[1], across))
    growth = 1 + max(SHARE / per_unit, LEAST)
    x = stretched(first, last, nx, (-min(reach, begins), reach), growth)
    y = stretched(0.0, across, ny, (0.0, reach), growth)
    before = int(np.searchsorted(x, first - 0.5 / per_unit))
    rows = slice(before, before + nx)
    if mirrored:
        return FilmCells(x, y, (rows, slice(0, ny)))
    margin = y.size - 1 - ny
    whole = np.concatenate([-y[:0:-1], y])
    return FilmCells(x, whole, (rows, slice(margin, margin + 2 * ny)), mirrored=False)


def around_line(count: int, reach: float) -> FilmCells:
    """Return cells across a line contact, `count` of them in each unit of length next to it."""
    x = stretched(-2.0, 2.0, 4 * count, (-reach, reach), 1 + SHARE / 2 / count)
    everywhere = slice(0, x.size - 1)
    return FilmCells(
        x, np.array([0.0, 1.0]), (everywhere, slice(0, 1)), mirrored=False, closed=True
    )
