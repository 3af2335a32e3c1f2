r"""Functions below a surface that bound the energy of its displacement from above.

The energy of a surface displacement v is (E*/4) times the least of the integrals of |grad phi|^2
over the half-space, taken over all phi that are v on the surface and vanish far away (K^-1 =
(E*/2)|grad|, the Dirichlet-to-Neumann map; Dirichlet's principle). So *every* such phi gives an
upper bound. Here phi is a product of quadratic polynomials on prisms: horizontal ones, on rings or
triangles, and vertical ones. The integrals are exact, the elements conform, and beyond the
outermost ones phi falls in proportion:

    phi(rho x) = phi(x)/rho    for x on the outer boundary, rho > 1,

which is zero far away and, on a face at distance h from the origin with the coordinates y from the
foot of that distance, has the energy of

    integral over the face of  h |grad f|^2 + (f + y . grad f)^2/h,     f = phi on the face,

a polynomial again. The far field of a contact falls like that, to the third order.
"""

from dataclasses import dataclass

import numpy as np
from skfem import Basis, BilinearForm, ElementTriP2, MeshTri
from skfem.helpers import dot, grad

from reference.arrays import Array, Integers
from reference.bounds.interval import EPSILON
from reference.bounds.outlines import Outline, nested
from reference.fem.condensation import Front, LinearSystem, Shift, condense, expand
from reference.fem.half_space_mesh import power_lines

# Gauss points of an interval: four integrate polynomials of degree 7; the forms reach degree 6.
_POINTS = 4
# Of an element matrix, relative to the magnitudes in its integrals: sums of at most 32 products of
# about six factors.
_ENTRY = 64 * EPSILON
# Radius and depth of the elements about an outline, in half its length.
_OUTSKIRTS = 6.0
# Local edges of a triangle in scikit-fem, in the order of their unknowns after the vertices.
_EDGES = ((0, 1), (1, 2), (0, 2))
# Values at vertices and middles of edges for coefficients of Bernstein's polynomials.
_NODAL = np.eye(6)
for _edge, _pair in enumerate(_EDGES):
    _NODAL[3 + _edge] = 0
    _NODAL[3 + _edge, [*_pair, 3 + _edge]] = 0.25, 0.25, 0.5


def shells_about(outline: Outline, cells: int, exponent: float) -> tuple[Array, Array]:
    """Shells for `fan` and depths of layers, graded towards an outline from either side."""
    t = np.arange(cells + 1) / cells
    outwards = power_lines(cells, exponent, _OUTSKIRTS * max(outline.extents) / outline.size)
    shells = outline.shells(1 - t[-2::-1] ** exponent, outwards[1:])
    return shells, outline.size * outwards


class _Quadratics:
    """Three quadratic functions per interval: values and slopes (n, 3, q) at its Gauss points."""

    def __init__(self, starts: Array, ends: Array, *, bernstein: bool = False) -> None:
        nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
        t = 0.5 * (nodes + 1)
        s = 1 - t
        if bernstein:  # the smallest coefficient is below the sum everywhere
            values = np.stack([s**2, 2 * t * s, t**2])
            slopes = np.stack([-2 * s, 2 * (s - t), 2 * t])
        else:  # 1 at one of the ends or the middle
            values = np.stack([s * (s - t), 4 * t * s, t * (t - s)])
            slopes = np.stack([4 * t - 3, 4 * (s - t), 4 * t - 1])
        length = (ends - starts)[:, None]
        self.places = starts[:, None] + length * t
        self.weights = length * (0.5 * weights)
        self.values = np.broadcast_to(values, (len(starts), *values.shape))
        self.slopes = slopes / length[:, :, None]
        # what a function that falls as 1/scale loses outwards
        self.deepening = self.places[:, None] * self.slopes
        self.swelling = self.values + self.deepening

    def form(self, left: Array, right: Array, weight: Array | float = 1.0) -> Array:
        """Element matrices (n, 3, 3) of the integral of two of the above."""
        return np.einsum("eq,eiq,ejq->eij", self.weights * weight, left, right)


def _unknowns(count: int) -> Integers:
    """Unknowns of consecutive intervals: ends even, middles odd."""
    return 2 * np.arange(count)[:, None] + np.arange(3)


@dataclass(frozen=True, eq=False)
class Side:
    """Outer edges of a section, each in a vertical plane at a distance h from the origin.

    With s along the edge from the foot of that distance, and f_s the derivative along it:
    stiffness, mass, swelling and moment are the integrals of f_s f_s, f f, (f + s f_s)^2 and
    (f + s f_s) f.
    """

    elements: Integers  # (s,), of the section
    local: Integers  # (s, k), which of the element's functions live on the edge
    distances: Array  # (s,)
    stiffness: Array  # (s, k, k)
    mass: Array
    swelling: Array
    moment: Array


@dataclass(frozen=True, eq=False)
class Section:
    """Horizontal elements of a layer, star-shaped about the origin.

    The coefficients are those of Bernstein's polynomials, so that a function is nowhere below a
    level that none of its coefficients is below. Stiffness, mass and swelling are the integrals of
    grad f . grad f, f f and (f + x . grad f)^2 over the elements.
    """

    stiffness: Array  # (n, k, k)
    mass: Array
    swelling: Array
    unknowns: Integers  # (n, k)
    points: Array  # (count, 2), of each unknown's function: a vertex, or the middle between two
    ends: Integers  # (count, 2), the unknowns of these two vertices; a vertex twice itself
    rounding: float  # relative, of the elements' sizes
    side: Side

    def bernstein(self, values: Array) -> Array:
        """Coefficients of the function with given values at the points, quadratic on elements.

        On the side between two vertices f(middle) = (f_1 + 2 b + f_2)/4.
        """
        middle = self.ends[:, 0] != self.ends[:, 1]
        outer = values[self.ends].mean(axis=1)
        return np.where(middle, 2 * values - outer, values)


def rings(radii: Array) -> Section:
    """Return the section of a body of revolution, whole, from the radii of its rings (0 first)."""
    line = _Quadratics(radii[:-1], radii[1:], bernstein=True)
    around = 2 * np.pi * line.places
    rim = np.full((1, 1, 1), 2 * np.pi * radii[-1])
    count = len(radii) - 1
    places = np.zeros((2 * count + 1, 2))
    places[::2, 0], places[1::2, 0] = radii, 0.5 * (radii[:-1] + radii[1:])
    number = np.arange(2 * count + 1)
    return Section(
        stiffness=line.form(line.slopes, line.slopes, around),
        mass=line.form(line.values, line.values, around),
        swelling=line.form(line.swelling, line.swelling, around),
        unknowns=_unknowns(count),
        points=places,
        ends=np.stack([number - number % 2, number + number % 2], axis=1),
        rounding=8 * EPSILON,
        # the rim is round: nothing changes along it, which leaves f + s f_s = f
        side=Side(
            elements=np.array([count - 1]),
            local=np.array([[2]]),
            distances=radii[-1:],
            stiffness=np.zeros((1, 1, 1)),
            mass=rim,
            swelling=rim,
            moment=rim,
        ),
    )


def fan(shells: Array, *, closed: bool) -> tuple[Section, Integers]:
    """Triangles between shells (n, m + 1, 2) about the origin, from the innermost outwards.

    The points of a shell are in the order of their angle, with straight lines between them. A
    closed fan goes on from the last to the first; of an open one these lie in planes of symmetry.
    Shells that cross raise ValueError: what is put together on them is no function. Returned, too,
    is the number of the shell, from 1, that just contains the place of each unknown's function.
    """
    if not nested(shells, closed=closed):
        raise ValueError("shells about the origin must lie inside each other, and these cross")
    layers, count = shells.shape[:2]
    vertices = np.concatenate([np.zeros((1, 2)), shells.reshape(-1, 2)])
    # number of the vertex on shell j at point k: 1 + j count + k
    near = np.arange(count if closed else count - 1)
    far = (near + 1) % count
    core = np.stack([0 * near, 1 + near, 1 + far])
    first = 1 + count * np.arange(layers - 1)[:, None]
    inner, beside = (first + near).ravel(), (first + far).ravel()
    quads = [
        np.stack([inner, inner + count, beside + count]),
        np.stack([inner, beside + count, beside]),
    ]
    mesh = MeshTri(vertices.T, np.concatenate([core, *quads], axis=1))
    basis = Basis(mesh, ElementTriP2(), intorder=4)

    # an unknown stands at each vertex, with the vertex's number, and at the middle of each edge
    ends = np.empty((basis.N, 2), dtype=np.int64)
    ends[basis.nodal_dofs[0]] = np.arange(len(vertices))[:, None]
    ends[basis.facet_dofs[0]] = mesh.facets.T
    shell = np.concatenate([[0], np.repeat(np.arange(1, layers + 1), count)])[ends].max(axis=1)
    sides = np.diff(mesh.p[:, mesh.t[[0, 1, 2, 0]]], axis=1)
    doubled = np.abs(sides[0, 0] * sides[1, 1] - sides[1, 0] * sides[0, 1])
    slender = ((sides**2).sum(axis=0).max(axis=0) / doubled).max()

    def swelling(u, w):
        return u + w.x[0] * u.grad[0] + w.x[1] * u.grad[1]

    stiffness, mass, swollen = (
        np.einsum("ai,eab,bj->eij", _NODAL, BilinearForm(form).elemental(basis).tolocal(), _NODAL)
        for form in (
            lambda u, v, w: dot(grad(u), grad(v)),
            lambda u, v, w: u * v,
            lambda u, v, w: swelling(u, w) * swelling(v, w),
        )
    )

    # the outermost edges: the triangle of each, and which of its functions live there
    outer = np.flatnonzero((mesh.facets > count * (layers - 1)).all(axis=0))
    owner = mesh.f2t[0, outer]
    first, last = mesh.facets[:, outer]
    on_edge = np.stack([first, basis.facet_dofs[0, outer], last], axis=1)
    local = (basis.element_dofs[:, owner].T[:, None] == on_edge[:, :, None]).argmax(axis=2)
    start, end = mesh.p[:, first], mesh.p[:, last]
    along = (end - start) / np.hypot(*(end - start))
    line = _Quadratics((start * along).sum(0), (end * along).sum(0), bernstein=True)
    section = Section(
        stiffness=stiffness,
        mass=mass,
        swelling=swollen,
        unknowns=basis.element_dofs.T.astype(np.int64),
        points=basis.doflocs.T,
        ends=ends,
        rounding=8 * EPSILON * float(slender),
        side=Side(
            elements=owner,
            local=local,
            distances=np.abs(start[0] * along[1] - start[1] * along[0]),
            stiffness=line.form(line.slopes, line.slopes),
            mass=line.form(line.values, line.values),
            swelling=line.form(line.swelling, line.swelling),
            moment=line.form(line.swelling, line.values),
        ),
    )
    return section, shell


class Prisms:
    """Finite elements below the surface, condensed onto some of the surface's coefficients.

    Below a section layers reach from 0 to the last of the depths (m + 1,). The coefficients on the
    surface of its `retained` unknowns (r,) will be given, all others are free: the energy for
    E* = 1 is v . S v/2, S the `stiffness` (r, r).
    """

    def __init__(self, section: Section, depths: Array, retained: Integers) -> None:
        levels = 2 * len(depths) - 1
        self.unknowns = len(section.points) * levels
        self.surface = np.arange(len(section.points)) * levels
        self.retained = retained
        self._rounding = section.rounding
        size = section.unknowns.shape[1] * 3

        # integrals of grad phi . grad phi over the prisms
        line, side, bottom = _Quadratics(depths[:-1], depths[1:]), section.side, depths[-1]
        stiffness = line.form(line.slopes, line.slopes)
        mass = line.form(line.values, line.values)
        matrices = _product(section.stiffness, mass)
        matrices += _product(section.mass, stiffness)
        # below the lowest ones, h = bottom, and beside the outermost ones
        matrices[:, -1, :, 2, :, 2] += bottom * section.stiffness + section.swelling / bottom
        moment = line.form(line.values, line.deepening)
        square = line.form(line.deepening, line.deepening)
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
        self.matrices = 0.5 * matrices.reshape(-1, size, size)

        vertical = _unknowns(len(depths) - 1)
        self.places = (
            section.unknowns[:, None, :, None] * levels + vertical[None, :, None, :]
        ).reshape(-1, size)
        outermost = np.zeros((len(section.unknowns), len(vertical)), dtype=bool)
        outermost[side.elements] = outermost[:, -1] = True
        self._inner = ~outermost.ravel()

        # condensed; where the elements are, roughly, tells how to bisect them
        across = np.repeat(section.points[section.unknowns].mean(axis=1), len(vertical), axis=0)
        downwards = np.tile(0.5 * (depths[:-1] + depths[1:]), len(section.unknowns))
        self._system = LinearSystem(
            matrices=self.matrices,
            unknowns=self.places,
            first=self.unknowns,
            retained=self.surface[retained],
            centres=np.column_stack([across, downwards]),
        )
        self._fronts: list[Front | Shift] = []
        self.stiffness = condense(self._system, self._fronts)

    def extend(self, coefficients: Array) -> Array:
        """All coefficients for those of the retained unknowns, for the least energy."""
        return expand(self._system, self._fronts, coefficients)

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


def _product(horizontal: Array, vertical: Array) -> Array:
    """Kronecker products of the two kinds of element matrices, shape (n, m, i, k, j, l)."""
    return np.einsum("eij,fkl->efikjl", horizontal, vertical)
