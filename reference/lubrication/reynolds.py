r"""Reynolds' equation with mass-conserving cavitation, on cells.

    div(h^3 grad p) = L d/dx[(1 - theta) h],    p >= 0, theta >= 0, p theta = 0,

L = 12 eta U in scaled units, theta the share of the gap that vapour fills (Elrod & Adams 1974;
as a complementarity problem Bertocchi, Dini, Giacopini, Fowell & Baldini, Tribol. Int. 67 (2013)
14). Film that ruptures and forms again needs no condition of its own: mass is conserved in every
cell. One unknown s per cell is both: p = max(s, 0), theta = max(-s, 0).

The flow through a face is h^3 dp/dn at the face's own gap; the film that a surface carries along is
of second order where the gap is full, and what vapour displaces is taken from upstream.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from numpy.typing import NDArray
from scipy import sparse

from reference.lubrication.cells import Cells

Field = NDArray[np.float64]
Gap = Callable[[Field, Field], Field]


@dataclass(frozen=True)
class Faces:
    """Faces between cells along one axis, with a boundary at either end.

    Attributes
    ----------
    gap : ndarray, shape (n + 1, m)
        Of the rigid shape in the middle of the faces.
    conductance : ndarray, same shape
        Area over distance; zero where nothing flows through.
    """

    gap: Field
    conductance: Field


class Film:
    """The film over cells, under a rigid gap that a uniform height and a displacement add to.

    Parameters
    ----------
    cells : Cells
    gap : callable
        Gap of the undeformed bodies at (x, y), zero at first touch.
    inlet : float
        Thickness of the oil that arrives; infinite where the inlet is flooded.
    """

    def __init__(self, cells: Cells, gap: Gap, inlet: float = np.inf) -> None:
        self.cells, self.inlet = cells, inlet
        x, y = cells.centres
        dx, dy = cells.widths
        self.gap = gap(x, y)
        self.along = Faces(gap(cells.x[:, None], y), _inverse_distances(cells.x)[:, None] * dy)
        across = _inverse_distances(cells.y)[None, :] * dx
        if cells.mirrored or cells.closed:
            across[:, 0] = 0.0
        if cells.closed:
            across[:, -1] = 0.0
        self.across = Faces(gap(x, cells.y[None, :]), across)

    def balance(self, s: Field, separation: float, displacement: Field, speed: float) -> Field:
        """Return what flows out of each cell, per time.

        Parameters
        ----------
        s : ndarray
            p where positive, -theta where negative.
        separation : float
            Height that is added to the gap.
        displacement : ndarray
            Displacement of the surface, which is added to the gap.
        speed : float
            L.
        """
        p, vapour = np.maximum(s, 0.0), np.maximum(-s, 0.0)
        hx, hy = self.faces(separation, displacement)
        along = -self.along.conductance * hx**3 * _steps(p, 0)
        across = -self.across.conductance * hy**3 * _steps(p, 1)
        along += speed * self.cells.widths[1] * self.carried(vapour, separation, displacement, hx)
        return np.diff(along, axis=0) + np.diff(across, axis=1)

    def driven(self, p: Field, separation: float, displacement: Field) -> Field:
        """Return how much a pressure in a cell would drive out of it, were there none around."""
        hx, hy = self.faces(separation, displacement)
        along, across = self.along.conductance * hx**3, self.across.conductance * hy**3
        return p * (along[1:] + along[:-1] + across[:, 1:] + across[:, :-1])

    def carried(self, vapour: Field, separation: float, displacement: Field, hx: Field) -> Field:
        """Return the thickness of oil that is carried through the faces along x."""
        oil = hx.copy()
        oil[1:] -= vapour * (self.gap + separation + displacement)
        oil[0] = np.minimum(oil[0], self.inlet)
        return oil

    def faces(self, separation: float, displacement: Field) -> tuple[Field, Field]:
        """Return the gap in the faces along x and y."""
        return self.along.gap + separation + _middles(
            displacement, 0
        ), self.across.gap + separation + _middles(displacement, 1)

    def thickness(self, separation: float, displacement: Field) -> Field:
        """Return the gap in the middle of the cells."""
        return self.gap + separation + displacement

    @cached_property
    def _index(self) -> NDArray[np.intp]:
        return np.arange(self.gap.size).reshape(self.gap.shape)

    def derivatives(
        self, s: Field, separation: float, displacement: Field, speed: float
    ) -> tuple[sparse.csr_matrix, sparse.csr_matrix]:
        """Return the derivatives of the balance by s and by the displacement of each cell.

        That by the separation is the sum of the columns of the second.
        """
        p, vapour = np.maximum(s, 0.0), np.maximum(-s, 0.0)
        hx, hy = self.faces(separation, displacement)
        dy = self.cells.widths[1]
        by_p = self._differences(0, -self.along.conductance * hx**3)
        by_p = by_p + self._differences(1, -self.across.conductance * hy**3)
        slope_x = -3 * self.along.conductance * hx**2 * _steps(p, 0)
        slope_y = -3 * self.across.conductance * hy**2 * _steps(p, 1)
        full = np.ones(hx.shape)
        full[0] = hx[0] < self.inlet
        by_u = self._means(0, slope_x + speed * dy * full) + self._means(1, slope_y)
        upstream = np.zeros(hx.shape)
        upstream[1:] = speed * dy * self.thickness(separation, displacement)
        by_vapour = self._upstream(-upstream)
        upstream[1:] = speed * dy * vapour
        by_u = by_u + self._upstream(-upstream)
        positive = (s > 0).ravel()
        by_s = by_p @ sparse.diags(positive.astype(float)) - by_vapour @ sparse.diags(
            (~positive).astype(float)
        )
        return by_s.tocsr(), by_u.tocsr()

    def _differences(self, axis: int, factor: Field) -> sparse.csr_matrix:
        """Return the matrix of diff(factor * steps(p)) along an axis."""
        return self._flow(axis, -factor, factor)

    def _means(self, axis: int, factor: Field) -> sparse.csr_matrix:
        """Return the matrix of diff(factor * middles(u)) along an axis; ends have the cell's u."""
        before, after = factor / 2, factor / 2
        np.moveaxis(after, axis, 0)[0] *= 2
        np.moveaxis(before, axis, 0)[-1] *= 2
        return self._flow(axis, before, after)

    def _upstream(self, factor: Field) -> sparse.csr_matrix:
        """Return the matrix of diff(factor * value of the cell before) along x."""
        return self._flow(0, factor, np.zeros(factor.shape))

    def _flow(self, axis: int, before: Field, after: Field) -> sparse.csr_matrix:
        """Return the balance of flows before * (cell before) + after * (cell after) per face."""
        index = np.moveaxis(self._index, axis, 0)
        before, after = np.moveaxis(before, axis, 0), np.moveaxis(after, axis, 0)
        rows, columns, values = [], [], []
        # the flow through face k leaves cell k - 1 and enters cell k
        for row, sign, faces in ((index, 1.0, slice(1, None)), (index, -1.0, slice(0, -1))):
            b, a = sign * before[faces], sign * after[faces]
            if sign > 0:
                parts = ((row, index, b), (row[:-1], index[1:], a[:-1]))
            else:
                parts = ((row[1:], index[:-1], b[1:]), (row, index, a))
            for target, source, value in parts:
                rows.append(target.ravel())
                columns.append(source.ravel())
                values.append(value.ravel())
        entries = np.concatenate(values), (np.concatenate(rows), np.concatenate(columns))
        size = self._index.size
        return sparse.coo_matrix(entries, shape=(size, size)).tocsr()


def _inverse_distances(edges: Field) -> Field:
    """Return one over the distance of neighbouring centres; at the ends that to the edge."""
    centres = (edges[1:] + edges[:-1]) / 2
    return 1 / np.diff(np.concatenate([edges[:1], centres, edges[-1:]]))


def _steps(p: Field, axis: int) -> Field:
    """Return differences across the faces, p being zero beyond the ends."""
    width = [(0, 0), (0, 0)]
    width[axis] = (1, 1)
    return np.diff(np.pad(p, width), axis=axis)


def _middles(u: Field, axis: int) -> Field:
    """Return means across the faces; at the ends the value of the cell."""
    width = [(0, 0), (0, 0)]
    width[axis] = (1, 1)
    padded = np.pad(u, width, mode="edge")
    if axis == 0:
        return (padded[1:] + padded[:-1]) / 2
    return (padded[:, 1:] + padded[:, :-1]) / 2
