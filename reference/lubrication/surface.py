"""What gives way under a film: the elastic half-space below its equal cells."""

from __future__ import annotations

from copy import copy

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from reference.halfspace.operators import FreeOperator
from reference.lubrication.cells import Cells

Field = NDArray[np.float64]

# How far pressure on a cell bends the surface in `Surface.near`, in cells.
_NEAR = 1


class Surface:
    """The elastic half-space below the equal cells of a film; beyond them a point load bends it.

    Parameters
    ----------
    cells : Cells
    compliance : float
        1/E*; zero for a rigid surface.
    load : float
        What the film carries, which bends the surroundings as u = F/(pi E* r).
    """

    def __init__(self, cells: Cells, compliance: float, load: float) -> None:
        self.cells, self.compliance, self.load = cells, compliance, load
        self.far = np.zeros(cells.shape)
        if not compliance:
            return
        nx, ny = cells.core_shape
        self.body = FreeOperator((nx, ny * cells.copies), cells.spacing, 1 / compliance)
        x, y = cells.centres
        self.far = load * compliance / (np.pi * np.hypot(x, y))
        self.far[cells.core] = 0.0

    def under(self, load: float) -> Surface:
        """Return the same surface under another load."""
        other = copy(self)
        other.load, other.far = load, self.far * (load / self.load)
        return other

    def displacement(self, pressure: Field) -> Field:
        """Return the displacement of all cells under a pressure."""
        return self.far + self.respond(pressure)

    def respond(self, pressure: Field) -> Field:
        """Return the displacement of the equal cells under the pressure on them."""
        result = np.zeros(self.cells.shape)
        if not self.compliance:
            return result
        core = pressure[self.cells.core]
        if not self.cells.mirrored:
            result[self.cells.core] = self.body.apply(core)
            return result
        whole = self.body.apply(np.concatenate([core[:, ::-1], core], axis=1))
        result[self.cells.core] = whole[:, core.shape[1] :]
        return result

    def near(self) -> sparse.csr_matrix:
        """Return the displacement under pressure on the next cells only, as a matrix."""
        size = self.far.size
        if not self.compliance:
            return sparse.csr_matrix((size, size))
        index = np.arange(size).reshape(self.cells.shape)[self.cells.core]
        weights = self.body.coefficients((_NEAR + 1, _NEAR + 1))
        if self.cells.mirrored:
            # rows of images beyond the axis: the pressure of row k lies at -1 - k, too
            index = np.concatenate([index[:, _NEAR - 1 :: -1], index], axis=1)
        first = _NEAR if self.cells.mirrored else 0
        rows, columns, values = [], [], []
        nx, ny = index.shape
        for i in range(-_NEAR, _NEAR + 1):
            for j in range(-_NEAR, _NEAR + 1):
                x, y = np.arange(max(0, -i), nx - max(0, i)), np.arange(first, ny - max(0, j))
                y = y[y + j >= 0]
                rows.append(index[np.ix_(x, y)].ravel())
                columns.append(index[np.ix_(x + i, y + j)].ravel())
                values.append(np.full(rows[-1].size, weights[abs(i), abs(j)]))
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        return sparse.coo_matrix(entries, shape=(size, size)).tocsr()
