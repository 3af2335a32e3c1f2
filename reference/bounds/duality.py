r"""Energy of a pressed body, between those of an admissible pressure and displacement.

A rigid body with the gap g, pressed by d into an elastic half-space without friction, stores

    U = max { <p, d - g> - <p, K p>/2 : p >= 0 } = min { <v, K^-1 v>/2 : v >= d - g },

K from pressure to displacement, E* = 1 (complementary energy: Kalker & van Randen 1972; Johnson
1985, section 5.3). So *every* pressure p >= 0 bounds U from below and *every* displacement
v >= d - g from above: solvers only look for sharp ones. The best multiple of p gives

    U >= <p, d - g>^2/(2 <p, K p>).

The pressures are uniform on rings, or on the cells of a fan, whose energy has a closed form; the
displacements are those of the surface of `dirichlet.Prisms`.

**Double integrals of 1/r over plane quadrangles, in closed form.**

In the plane the Laplacian of r is 1/r, so by Gauss's theorem, twice,

    int_T int_T' dA dA'/|x - x'| = - sum over sides e of T, e' of T'  (n_e . n_e') J(e, e'),
    J(e, e') = int_e int_e' |x - x'| ds ds'.

With s and t counted from the point in which the lines of two sides meet, the distance is
homogeneous of degree one in (s, t), and Euler's theorem takes the double integral to its border:

    J = 1/3 [s2 D(x(s2), e') - s1 D(x(s1), e') + t2 D(x'(t2), e) - t1 D(x'(t1), e)],

D(x, e) the integral of the distance from the point x along the side e, which is elementary. For
parallel lines at a distance p the double integral is the second difference of
R^3/6 + p^2 (w arsinh(w/p) - R)/2 with R^2 = w^2 + p^2; lines that meet far away, where s and t
would lose digits, take Gauss points for the outer integral.

Cells far apart cancel in that sum. There Gauss points are taken, exact to degree six in the
difference of the places; with 1/|X + y| = sum of |y|^n P_n/|X|^(n+1) (Legendre) what they leave
out is at most twice the terms from n = 7 on, q^7/(1 - q)/|X| for |y| <= q |X|. The same series of
|X + y| itself, with coefficients below one, bounds the rest of the Gauss points along a side.
"""

from __future__ import annotations

from abc import ABC, abstractmethod

import numpy as np
from numba import njit
from numpy.typing import NDArray
from scipy.linalg import cho_factor, cho_solve

from reference.bounds.dirichlet import Prisms
from reference.bounds.interval import EPSILON, complete
from reference.bounds.outlines import Outline
from reference.contact.pivot import compliance, pivot

Array = NDArray[np.float64]

# Steps of the pressures on rings, relative to the largest: differences of such numbers are exact.
_STEP = 2.0**-44
# Of the products around an elliptic integral, and of the integrals of d - g over a disc.
_FORMULA = 32 * EPSILON
# Rounding of a cell's corners, and of the images of these, in parts of the largest coordinate.
_CORNER = 16 * EPSILON


class Pressures(ABC):
    """Pressures uniform on parts of a surface, as sums of given ones times amounts x.

    The energy is that of whole parts (Galerkin's); displacements at their middles times forces
    (collocation) would bound nothing.

    The parts make up the whole by a number of `images`, less the relative rounding of the bound.
    For each <p, K p> is x . matrix . x to |x| . errors . |x|, and the work <p, d - g> is x . work,
    to a share `rounding` of |x| . magnitude, the same of d + g.
    """

    def __init__(self, matrix: Array, errors: Array, rounding: float, images: float) -> None:
        self.matrix, self.errors = matrix, errors
        self.rounding, self.images = rounding, images

    @abstractmethod
    def best(self, work: Array) -> Array:
        """Pressure p >= 0 on every part that nearly has the least complementary energy."""

    def amounts(self, pressure: Array) -> Array:
        """Return x for pressures p >= 0 on the parts: these, if not said otherwise."""
        return pressure


def towards_edge(cells: int, exponent: float) -> Array:
    """Return factors (n + 1,) from 0 to 1, spaced more finely towards 1."""
    return 1 - (1 - np.arange(cells + 1) / cells) ** exponent


def mutual_energies(radii: Array) -> tuple[Array, Array]:
    r"""Integrals of 1/|x - y| over all pairs of concentric discs, and bounds of their errors.

    Over two discs of radii b <= a it is, with k = b/a,

        I(a, b) = (8 pi/3) a b^2 [B(k) + E(k)]
                = (8 pi/3) a b^2 int (2 cos^2 t + (1 - k^2) sin^2 t)/(1 - k^2 sin^2 t)^(1/2) dt,

    t from 0 to pi/2, the integral over the smaller disc of the potential 4 a E(r/a) of the larger
    one (Johnson 1985, (3.29)); B and E are complete elliptic integrals.
    """
    large = np.maximum(radii[:, None], radii[None, :])
    small = np.minimum(radii[:, None], radii[None, :])
    complement = (large - small) / large * ((large + small) / large)  # 1 - k^2
    same = large == small
    complement[same] = 1.0
    lower, upper = complete(complement, 2.0, complement)
    lower[same] = upper[same] = 2.0
    scale = 8 * np.pi / 3 * large * small**2
    return scale * 0.5 * (lower + upper), scale * (0.5 * (upper - lower) + _FORMULA * upper)


class Rings(Pressures):
    """Pressures uniform on concentric rings of these outer radii, increasing.

    They are sums of pressures uniform on discs, the amounts: sums over discs instead of differences
    over rings cancel no digits where the pressure falls outwards.
    """

    def __init__(self, radii: Array) -> None:
        self.radii = radii
        matrix, errors = (part / np.pi for part in mutual_energies(radii))
        self._factor = cho_factor(matrix)
        rounding = 2 * len(radii) * EPSILON
        errors += 2 * rounding * matrix
        super().__init__(matrix, errors, rounding + _FORMULA, 1 - 8 * EPSILON)

    def best(self, work: Array) -> Array:
        """Pressure of least complementary energy, cut at zero."""
        return np.maximum(np.cumsum(cho_solve(self._factor, work)[::-1])[::-1], 0.0)

    def amounts(self, pressure: Array) -> Array:
        """Return the steps of the pressure over its peak.

        Multiples of a power of two: they are differences without rounding, so that the pressure
        they add up to is the one that was tested for its sign.
        """
        steps = np.round(pressure / pressure.max() / _STEP) * _STEP
        steps[:-1] -= steps[1:]
        return steps


class Fan(Pressures):
    """Pressures uniform on the cells between copies of an outline, scaled by growing factors.

    Attributes
    ----------
    cells : (m n, 4, 2)
        Those of one image of the outline; the first factor is 0.
    areas : (m n,)
    """

    def __init__(self, outline: Outline, factors: Array) -> None:
        self.cells = fan_cells(outline.points, factors, closed=outline.closed)
        self.areas = areas(self.cells)
        # relative, of the areas and of the mutual integrals that they are factors of
        width = self.areas / np.hypot(*np.ptp(self.cells, axis=1).T)
        corners = _CORNER * float(np.abs(self.cells).max() / width.min())
        matrix, errors = (part / np.pi for part in mutual_integrals(self.cells, outline.images))
        rounding = (2 * len(matrix) + 64) * EPSILON
        images = len(outline.images) * (1 - rounding - 2 * corners)
        super().__init__(matrix, errors, rounding + corners, images)

    def best(self, work: Array) -> Array:
        """Pressure of least complementary energy."""
        zero = np.zeros(len(work))
        return least_above(self.matrix, work, zero, zero > 0)


def energy_below(
    pressures: Pressures, work: Array, magnitude: Array, pressure: Array | None = None
) -> float:
    """Lower bound of the energy by the best pressure, or a given one, for E* = 1.

    Work and magnitude (n,) are the integrals of d - g and of d + g over what the amounts stand for.
    A pressure that is negative anywhere raises ValueError: it proves nothing.
    """
    if pressure is None:
        pressure = pressures.best(work)
    if not (pressure >= 0).all():
        raise ValueError(
            f"pressure must be at least 0 everywhere, not {float(pressure.min())!r}: "
            "one that pulls proves no bound from below"
        )
    if not pressure.any():
        return 0.0
    x = pressures.amounts(pressure)
    size = np.abs(x)
    done = x @ work - pressures.rounding * (size @ magnitude)
    stored = x @ pressures.matrix @ x + size @ pressures.errors @ size
    if done <= 0:
        return 0.0
    return float(pressures.images * done**2 / (2 * stored))


def energy_above(
    elements: Prisms, floor: Array, touching: NDArray[np.bool_] | None = None
) -> float:
    """Upper bound of the energy by the least displacement above a floor, for E* = 1.

    The floor (n,) is in Bernstein's coefficients: with none below it v is nowhere below d - g. It
    covers the whole surface, -inf where nothing is asked. On the elements' retained coefficients
    the search begins with v = floor where it is touching; if that is not given, v stays there. On
    all others the floor must prove to be met.
    """
    retained = elements.retained
    v = floor[retained]
    if touching is not None:
        v = least_above(elements.stiffness, 0 * v, v, touching)
    values = elements.extend(v)
    if (values[elements.surface] < floor).any():
        raise ArithmeticError("the displacement falls below the body beyond the contact")
    return elements.energy_above(values)


def least_above(stiffness: Array, load: Array, floor: Array, touching: NDArray[np.bool_]) -> Array:
    """Minimise v . S v/2 - f . v over v >= floor, from v = floor where it is touching.

    v - floor and the forces S v - f are complementary, as pressures and clearances are
    (`reference.contact.pivot`).
    """
    # next to needles the matrix is nearly singular; a wrong set only makes a bound less sharp
    force = stiffness @ floor - load
    return floor + pivot(compliance(stiffness), force, ~touching, 0.0, rounding=1e-9).pressures


# Sine of the angle between lines below which they count as parallel; the error of that is added.
_PARALLEL = 1e-10
# Rounding of one term in a sum of four, relative to it: distances, roots and a logarithm.
_TERM = 32 * EPSILON
# Largest extent of two cells, seen from each other, at which Gauss points are taken.
_FAR = 0.1
_POINTS = 4
# Lines that meet more than so many lengths of their sides away; points on parts of a side that
# are, by half their length, at most this share of their distance from the other side.
_DISTANT = 20.0
_LINE_NODES, _LINE_WEIGHTS = np.polynomial.legendre.leggauss(8)
_SHARE = 0.2


def fan_cells(outline: Array, factors: Array, *, closed: bool) -> Array:
    """Quadrangles between copies of an outline scaled about the origin, shape (m n, 4, 2).

    Factors (n + 1,) increase from 0; of the outline's points (m + 1, 2), m in a closed fan, the
    last is then followed by the first. Sides 0 and 2 of every cell lie on rays from the origin;
    cells next to it are triangles. Those of one ray's sector come one after the other, from the
    inside.
    """
    first = outline if closed else outline[:-1]
    last = np.roll(outline, -1, axis=0) if closed else outline[1:]
    inner, outer = factors[None, :-1, None], factors[None, 1:, None]
    first, last = first[:, None], last[:, None]
    corners = [inner * first, outer * first, outer * last, inner * last]
    return np.stack(corners, axis=2).reshape(-1, 4, 2)


def areas(cells: Array) -> Array:
    """Areas of quadrangles."""
    first, second = cells[:, 2] - cells[:, 0], cells[:, 3] - cells[:, 1]
    return 0.5 * (first[:, 0] * second[:, 1] - first[:, 1] * second[:, 0])


def mutual_integrals(cells: Array, images: Array) -> tuple[Array, Array]:
    """Integrals (n, n) of 1/|x - y| over all pairs of a fan's cells, one of them with all images.

    The images (g, 2, 2) are a group of rotations and reflections. With bounds of the errors, of
    rounding and quadrature.
    """
    integrals = np.zeros((len(cells), len(cells)))
    errors = np.zeros_like(integrals)
    middles = cells.mean(axis=1)
    reach = np.sqrt(((cells - middles[:, None]) ** 2).sum(axis=2).max(axis=1))
    points, weights = gauss_points(cells)
    for image in images:
        others, seen = (np.ascontiguousarray(x @ image.T) for x in (cells, points))
        turn = float(round(float(np.linalg.det(image))))
        _add_pairs(cells, points, others, seen, weights, reach, turn, integrals, errors)
    upper = np.triu(integrals), np.triu(errors)
    full = [part + np.triu(part, 1).T for part in upper]
    return full[0], full[1]


def gauss_points(cells: Array) -> tuple[Array, Array]:
    """Points (n, q, 2) and weights (n, q) of products of Gauss points on quadrangles."""
    nodes, weights = np.polynomial.legendre.leggauss(_POINTS)
    u, v = (x.ravel() for x in np.meshgrid(nodes, nodes, indexing="ij"))
    shape = 0.25 * np.stack(
        [(1 - u) * (1 - v), (1 + u) * (1 - v), (1 + u) * (1 + v), (1 - u) * (1 + v)]
    )
    by_u = 0.25 * np.stack([v - 1, 1 - v, 1 + v, -1 - v])
    by_v = 0.25 * np.stack([u - 1, -1 - u, 1 + u, 1 - u])
    du, dv = (np.einsum("nid,iq->nqd", cells, part) for part in (by_u, by_v))
    jacobian = du[..., 0] * dv[..., 1] - du[..., 1] * dv[..., 0]
    return np.einsum("nid,iq->nqd", cells, shape), jacobian * np.outer(weights, weights).ravel()


@njit(cache=True, error_model="numpy")
def _add_pairs(cells, points, others, seen, weights, reach, turn, integrals, errors):
    """Add the integrals over pairs of cells and images of cells, with bounds of their errors.

    `turn` is -1 for images that are mirrored: then their sides run the other way round.
    """
    for k in range(len(cells)):
        for m in range(k, len(cells)):
            first, second = cells[k], others[m]
            dx = dy = 0.0
            for corner in range(4):
                dx += 0.25 * (first[corner, 0] - second[corner, 0])
                dy += 0.25 * (first[corner, 1] - second[corner, 1])
            distance = np.sqrt(dx * dx + dy * dy)
            ratio = reach[k] + reach[m]
            total = error = 0.0
            if ratio < _FAR * distance:
                ratio /= distance
                for i in range(len(weights[k])):
                    x, y, weight = points[k, i, 0], points[k, i, 1], weights[k, i]
                    for j in range(len(weights[m])):
                        wx, wy = x - seen[m, j, 0], y - seen[m, j, 1]
                        total += weight * weights[m, j] / np.sqrt(wx * wx + wy * wy)
                tail = 2 * ratio**7 / (1 - ratio) / (1 - ratio)
                error = total * (tail + _TERM)
            else:
                # the sum of (t_e . t_e') J(e, e') over the sides, but for those of no length
                for a in range(4):
                    b = (a + 1) % 4
                    if first[a, 0] == first[b, 0] and first[a, 1] == first[b, 1]:
                        continue
                    for c in range(4):
                        d = (c + 1) % 4
                        if second[c, 0] == second[d, 0] and second[c, 1] == second[d, 1]:
                            continue
                        rays = a % 2 == 0 and c % 2 == 0
                        value, doubt = _sides(first[a], first[b], second[c], second[d], rays)
                        total += value
                        error += doubt
                total *= -turn
            integrals[k, m] += total
            errors[k, m] += error


@njit(cache=True, error_model="numpy")
def _sides(a, b, c, d, rays):
    """Return (t . t') J of the sides a-b and c-d, and a bound of its rounding.

    Lines of sides on rays meet in the origin, however small their angle.
    """
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    u, v = np.sqrt(ux * ux + uy * uy), np.sqrt(vx * vx + vy * vy)
    ux, uy, vx, vy = ux / u, uy / u, vx / v, vy / v
    cosine, sine = ux * vx + uy * vy, ux * vy - uy * vx
    wx, wy = c[0] - a[0], c[1] - a[1]
    if rays:
        s1, t1 = a[0] * ux + a[1] * uy, c[0] * vx + c[1] * vy
    elif abs(sine) < _PARALLEL:
        # the second side starts at `start` along the first, at the distance `across`
        start, across, way = wx * ux + wy * uy, abs(ux * wy - uy * wx), np.sign(cosine)
        end = start + way * v
        first, second = _second(u - start, across), _second(-end, across)
        third, fourth = _second(u - end, across), _second(-start, across)
        size = abs(first) + abs(second) + abs(third) + abs(fourth)
        reach = abs(start) + across + u + v
        value = way * (first + second - third - fourth)
        return cosine * value, _TERM * size + 2 * abs(sine) * u * v * reach
    else:
        s1, t1 = -(wx * vy - wy * vx) / sine, -(wx * uy - wy * ux) / sine
        # how far the first side is from the second, at least: its middle less half its length
        px, py = 0.5 * (a[0] + b[0]) - c[0], 0.5 * (a[1] + b[1]) - c[1]
        gx, gy = d[0] - c[0], d[1] - c[1]
        along = min(1.0, max(0.0, (px * gx + py * gy) / (gx * gx + gy * gy)))
        px, py = px - along * gx, py - along * gy
        apart = np.sqrt(px * px + py * py) - 0.5 * u
        if abs(s1) + abs(t1) > _DISTANT * (u + v) and apart > 0.05 * u:
            # Gauss points on parts of the first side
            parts = int(np.ceil(0.5 * u / (_SHARE * apart)))
            half = 0.5 * u / parts
            total, point = 0.0, np.empty(2)
            for part in range(parts):
                for k in range(len(_LINE_NODES)):
                    place = (2 * part + 1 + _LINE_NODES[k]) * half
                    point[0], point[1] = a[0] + place * ux, a[1] + place * uy
                    total += _LINE_WEIGHTS[k] * half * _along(point, c, vx, vy, v)
            # at most twice the terms from the sixteenth on, each below q^n times the distance
            tail = 2 * _SHARE**16 / (1 - _SHARE)
            return cosine * total, (tail + _TERM) * (total + u * v * apart)
    first = (s1 + u) * _along(b, c, vx, vy, v)
    second = -s1 * _along(a, c, vx, vy, v)
    third = (t1 + v) * _along(d, a, ux, uy, u)
    fourth = -t1 * _along(c, a, ux, uy, u)
    size = abs(first) + abs(second) + abs(third) + abs(fourth)
    steep = 1.0 if rays else 1 + 1 / abs(sine)
    return cosine * (first + second + third + fourth) / 3, _TERM * steep * size


@njit(cache=True, error_model="numpy")
def _along(point, start, vx, vy, length):
    """Integral of the distance from a point along a side."""
    wx, wy = start[0] - point[0], start[1] - point[1]
    first = wx * vx + wy * vy
    across = abs(wx * vy - wy * vx)
    return _first(first + length, across) - _first(first, across)


@njit(cache=True, error_model="numpy")
def _first(w, p):
    """Antiderivative of sqrt(w^2 + p^2), odd."""
    root = np.sqrt(w * w + p * p)
    slow = p * p * np.arcsinh(w / p) if p > 0 else 0.0
    return 0.5 * (w * root + slow)


@njit(cache=True, error_model="numpy")
def _second(w, p):
    """Second antiderivative of sqrt(w^2 + p^2), even."""
    root = np.sqrt(w * w + p * p)
    slow = p * p * (w * np.arcsinh(w / p) - root) if p > 0 else 0.0
    return root * root * root / 6 + 0.5 * slow
