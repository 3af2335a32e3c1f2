r"""Double integrals of 1/r over plane quadrangles, in closed form.

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

import numpy as np
from numba import njit

from reference.arrays import Array
from reference.bounds.interval import EPSILON

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
    """Add the integrals over pairs of cells and images of cells, with bounds of their errors."""
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
                total *= -turn  # -1 of mirrored images, whose sides run the other way round
            integrals[k, m] += total
            errors[k, m] += error


@njit(cache=True, error_model="numpy")
def _sides(a, b, c, d, rays):
    """Return (t . t') J of the sides a-b and c-d, and a bound of its rounding."""
    ux, uy, vx, vy = b[0] - a[0], b[1] - a[1], d[0] - c[0], d[1] - c[1]
    u, v = np.sqrt(ux * ux + uy * uy), np.sqrt(vx * vx + vy * vy)
    ux, uy, vx, vy = ux / u, uy / u, vx / v, vy / v
    cosine, sine = ux * vx + uy * vy, ux * vy - uy * vx
    wx, wy = c[0] - a[0], c[1] - a[1]
    if rays:  # they meet in the origin, however small their angle
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
