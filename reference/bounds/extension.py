r"""Functions below a surface that bound the energy of its displacement from above.

The energy of a surface displacement v is (E*/4) times the least of the integrals of |grad phi|^2
over the half-space, taken over all phi that are v on the surface and vanish far away (K^-1 =
(E*/2)|grad|, the Dirichlet-to-Neumann map; Dirichlet's principle). So *every* such phi gives an
upper bound. Here phi is a product of quadratic polynomials, horizontal and vertical, on prisms; the
integrals are exact, the elements conform, and beyond the outermost ones phi falls in proportion:

    phi(rho x) = phi(x)/rho    for x on the outer boundary, rho > 1,

which is zero far away and, on a face at distance h from the origin with the coordinates y from the
foot of that distance, has the energy of

    integral over the face of  h |grad f|^2 + (f + y . grad f)^2/h,     f = phi on the face,

a polynomial again. The far field of a contact falls like that, to the third order.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from reference.bounds.interval import EPSILON
from reference.bounds.lines import Line, numbers
from reference.bounds.sections import Section
from reference.fem.linear_system import LinearSystem
from reference.fem.nested_dissection import Front, Shift, condense, expand

Array = NDArray[np.float64]

# Of an element matrix, relative to the magnitudes in its integrals: sums of at most 32 products of
# about six factors.
_ENTRY = 64 * EPSILON
_NOTHING = np.zeros((0, 0))


class Extension:
    """Finite elements below the surface, condensed onto some of the surface's coefficients.

    Parameters
    ----------
    section : Section
    depths : (m + 1,)
        Depths of the layers, from 0.
    retained : (r,)
        The section's unknowns whose surface coefficients will be given; all others are free.

    Attributes
    ----------
    stiffness : (r, r)
        S with the energy v . S v/2 for E* = 1.
    unknowns : int
    """

    def __init__(self, section: Section, depths: Array, retained: NDArray[np.int64]) -> None:
        levels = 2 * len(depths) - 1
        self.unknowns = section.count * levels
        self.surface = np.arange(section.count) * levels
        self.matrices = 0.5 * _matrices(section, depths)
        horizontal, vertical = section.unknowns, numbers(len(depths) - 1)
        size = horizontal.shape[1] * 3
        self.places = (horizontal[:, None, :, None] * levels + vertical[None, :, None, :]).reshape(
            -1, size
        )
        middle = 0.5 * (depths[:-1] + depths[1:])
        centres = np.concatenate(
            [
                np.repeat(section.centres, len(middle), axis=0),
                np.tile(middle, len(section.centres))[:, None],
            ],
            axis=1,
        )
        self._system = LinearSystem(
            self.matrices, self.places, _NOTHING, self.unknowns, self.surface[retained], centres
        )
        outermost = np.zeros((len(section.unknowns), len(middle)), dtype=bool)
        outermost[section.side.elements] = outermost[:, -1] = True
        self._rounding = section.rounding
        self._inner = ~outermost.ravel()
        self._fronts: list[Front | Shift] = []
        self.stiffness = condense(self._system, _NOTHING, self._fronts)

    def extend(self, coefficients: Array) -> Array:
        """All coefficients for those of the retained unknowns, for the least energy."""
        return expand(self._system, self._fronts, coefficients)

    def on_surface(self, values: Array) -> Array:
        """Return the surface's coefficients out of all."""
        return values[self.surface]

    def energy_above(self, values: Array) -> float:
        """Upper bound of the energy of a function, for E* = 1, with rounding added."""
        local = values[self.places]
        # a constant has no gradient: without it much less cancels
        local[self._inner] -= local[self._inner, :1]
        energy = np.einsum("ei,eij,ej->e", local, self.matrices, local).sum()
        # by Cauchy and Schwarz no entry, nor what was added up to it, exceeds sqrt(a_ii a_jj)
        diagonal = np.sqrt(np.einsum("eii->ei", self.matrices))
        size = ((np.abs(local) * diagonal).sum(axis=1) ** 2).sum()
        terms = local.shape[1] ** 2
        rounding = (_ENTRY + terms * EPSILON) * size
        rounding += (self._rounding + len(local) * EPSILON) * energy
        return float(0.5 * (energy + rounding))


def _matrices(section: Section, depths: Array) -> Array:
    """Integrals of grad phi . grad phi over the prisms and what lies beyond the outermost."""
    line = Line(depths[:-1], depths[1:])
    stiffness = line.form(line.slopes, line.slopes)
    mass = line.form(line.values, line.values)
    matrices = _product(section.stiffness, mass)
    matrices += _product(section.mass, stiffness)
    bottom = depths[-1]
    matrices[:, -1, :, 2, :, 2] += bottom * section.stiffness + section.swelling / bottom
    deepening = line.places[:, None] * line.slopes
    moment = line.form(line.values, deepening)
    square = line.form(deepening, deepening)
    side = section.side
    distance = side.distances[:, None, None, None, None, None]
    mixed = _product(side.moment, moment)
    beyond = (
        distance * (_product(side.stiffness, mass) + _product(side.mass, stiffness))
        + (
            _product(side.swelling, mass)
            + mixed
            + mixed.transpose(0, 1, 4, 5, 2, 3)
            + _product(side.mass, square)
        )
        / distance
    )
    for element, local, block in zip(side.elements, side.local, beyond, strict=True):
        matrices[element][np.ix_(range(len(mass)), local, range(3), local, range(3))] += block
    size = section.unknowns.shape[1] * 3
    return matrices.reshape(-1, size, size)


def _product(horizontal: Array, vertical: Array) -> Array:
    """Kronecker products of the two kinds of element matrices, shape (n, m, i, k, j, l)."""
    return np.einsum("eij,fkl->efikjl", horizontal, vertical)
