"""A rigid cylinder on a rigid lubricated plane: what the cells are judged by, in closed form."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np
from numpy.typing import NDArray

from reference.arguments import count_faults, positive_faults, refuse
from reference.lubrication import formulas
from reference.lubrication.cells import around_line
from reference.lubrication.loaded import rigid_film_at
from reference.lubrication.reynolds import Film

Field = NDArray[np.float64]


@dataclass(frozen=True)
class LineFilm:
    """The film below a rigid cylinder.

    Attributes
    ----------
    load : float
        W h0/(eta U R), per length.
    rupture : float
        Where the film ruptures, over sqrt(2 R h0): p = 0 by the line through the last two cells of
        sqrt p, which falls linearly there.
    x : ndarray
        Centres of the cells, over sqrt(2 R h0).
    pressure : ndarray
        Over 12 eta U sqrt(2 R h0)/h0^2.
    flow : ndarray
        Oil that flows through the faces between cells, over U h0.
    """

    load: float
    rupture: float
    x: Field = field(repr=False)
    pressure: Field = field(repr=False)
    flow: Field = field(repr=False)


def rigid_cylinder(resolution: int, *, inlet: float = np.inf, reach: float = 1e3) -> LineFilm:
    """Return the film below a rigid cylinder, at its least thickness h0.

    Parameters
    ----------
    resolution : int
        Cells per sqrt(2 R h0).
    inlet : float
        Thickness of the arriving layer over h0, from 1 to 1.226: what fits through a gap that is
        full as far as one can see. Infinite where flooded.
    reach : float
        Half-width of the cells over sqrt(2 R h0).

    Examples
    --------
    >>> film = rigid_cylinder(32)
    >>> round(film.load, 2), round(film.rupture, 2)
    (4.9, 0.47)
    """
    faults = count_faults(2, resolution=resolution) + positive_faults(reach=reach)
    fits = 1 + formulas.RUPTURE**2
    if not (1 < inlet < fits or inlet == np.inf):
        faults.append(f"inlet must lie between 1 and {fits:.3f}, what fits through, not {inlet!r}")
    refuse(faults)
    cells = around_line(resolution, reach)
    film = Film(cells, lambda x, y: x**2 + 0 * y, inlet)
    state = rigid_film_at(film, 1.0, 1.0)
    x, pressure = cells.centres[0].ravel(), state.pressure.ravel()
    last = int(np.flatnonzero(pressure)[-1])
    before, root = np.sqrt(pressure[last - 1]), np.sqrt(pressure[last])
    oil = film.carried(
        state.vapour, 1.0, state.displacement, film.faces(1.0, state.displacement)[0]
    ).ravel()
    driven = (film.along.conductance * film.faces(1.0, state.displacement)[0] ** 3).ravel()
    return LineFilm(
        load=24 * float(pressure @ cells.area.ravel()),
        rupture=float(x[last] + (x[last] - x[last - 1]) * root / (before - root)),
        x=x,
        pressure=pressure,
        flow=oil - driven * np.diff(np.concatenate([[0.0], pressure, [0.0]])),
    )
