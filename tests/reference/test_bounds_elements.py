"""Energy of the upper bounds' finite elements against the integral of the function itself."""

import numpy as np
import pytest

from reference.bounds import outlines
from reference.bounds.dirichlet import Prisms, fan

NODES, WEIGHTS = np.polynomial.legendre.leggauss(4)
NODES, WEIGHTS = 0.5 * (NODES + 1), 0.5 * WEIGHTS
DEPTHS = np.array([0.0, 0.7, 1.5])


def _in_plane(corners, place):
    """Bernstein's quadratic polynomials on a triangle, and their gradients."""
    inverse = np.linalg.inv(np.vstack([corners.T, np.ones(3)]))
    a, b, c = inverse @ [*place, 1.0]
    da, db, dc = inverse[:, :2]
    values = [a * a, b * b, c * c, 2 * a * b, 2 * b * c, 2 * a * c]
    slopes = [a * da, b * db, c * dc, a * db + b * da, b * dc + c * db, a * dc + c * da]
    return np.array(values), 2 * np.array(slopes)


def _in_depth(layer, z):
    """Quadratic polynomials that are one at the ends or the middle of a layer, and their slopes."""
    top, bottom = DEPTHS[layer : layer + 2]
    t = (z - top) / (bottom - top)
    s = 1 - t
    slopes = np.array([4 * t - 3, 4 * (s - t), 4 * t - 1]) / (bottom - top)
    return np.array([s * (s - t), 4 * t * s, t * (t - s)]), slopes


def test_energy_is_the_integral_of_the_squared_gradient_also_beyond_the_elements():
    """Random coefficients; beyond the outermost faces phi(rho x) = phi(x)/rho.

    There the gradient at a face is that along it, and -phi/|x| along x; the integral over rho is
    one, times the distance of the face's plane. Gauss points are exact for the polynomials.
    """
    corners = [(1.0, -0.6), (1.2, 0.5), (-0.7, 0.9), (-0.9, -0.8)]
    outline = outlines.polygon(corners, 1, 1.0)
    shells = np.array([0.4, 1.9])[:, None, None] * outline.points
    section, _ = fan(shells, closed=outline.closed)
    body = Prisms(section, DEPTHS, np.arange(len(section.points)))
    values = np.random.default_rng(1).standard_normal(body.unknowns)
    levels = 2 * len(DEPTHS) - 1

    def value_and_gradient(element, layer, place):
        unknowns = section.unknowns[element]
        flat, slopes = _in_plane(section.points[unknowns[:3]], place[:2])
        deep, deepening = _in_depth(layer, place[2])
        local = values[unknowns[:, None] * levels + 2 * layer + np.arange(3)]
        return flat @ local @ deep, np.append(slopes.T @ local @ deep, flat @ local @ deepening)

    def beyond(element, layer, place, along, across):
        value, gradient = value_and_gradient(element, layer, place)
        full = np.linalg.solve(
            [along, across, place], [gradient @ along, gradient @ across, -value]
        )
        return full @ full

    total = 0.0
    for element, unknowns in enumerate(section.unknowns):
        first, second, third = section.points[unknowns[:3]]
        (ax, ay), (bx, by) = second - first, third - first
        for (a, wa), (b, wb) in ((m, n) for m in _points() for n in _points()):
            place = first + a * (second - first) + a * b * (third - second)
            weight = wa * wb * a * abs(ax * by - ay * bx)
            bottom = np.append(place, DEPTHS[-1])
            total += weight * DEPTHS[-1] * beyond(element, 1, bottom, [1, 0, 0], [0, 1, 0])
            for layer, thickness in enumerate(np.diff(DEPTHS)):
                for c, wc in _points():
                    inside = np.append(place, DEPTHS[layer] + c * thickness)
                    gradient = value_and_gradient(element, layer, inside)[1]
                    total += weight * wc * thickness * (gradient @ gradient)
    for element, local, distance in zip(
        section.side.elements, section.side.local, section.side.distances, strict=True
    ):
        start, end = section.points[section.unknowns[element][local[[0, 2]]]]
        along = np.append(end - start, 0.0)
        for (a, wa), (c, wc) in ((m, n) for m in _points() for n in _points()):
            for layer, thickness in enumerate(np.diff(DEPTHS)):
                place = np.append(start + a * (end - start), DEPTHS[layer] + c * thickness)
                weight = wa * wc * thickness * np.linalg.norm(along) * distance
                total += weight * beyond(element, layer, place, along, [0, 0, 1])
    # rounding is added on top
    assert body.energy_above(values) == pytest.approx(0.25 * total, rel=1e-11)
    assert body.energy_above(values) > 0.25 * total * (1 - 1e-13)


def _points():
    return list(zip(NODES, WEIGHTS, strict=True))
