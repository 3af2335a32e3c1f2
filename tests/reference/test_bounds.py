"""Proved bounds: closed forms lie inside, both sides converge, what proves nothing is refused."""

import math

import numpy as np
import pytest

from reference import closed_form
from reference.bounds import flat_faces, homogeneous, outlines, revolution
from reference.bounds.dirichlet import Prisms, fan, rings
from reference.bounds.duality import Rings, energy_above, energy_below
from reference.bounds.ellipses import elliptic_stiffness
from reference.bounds.quadrangles import areas, fan_cells, mutual_integrals
from reference.bounds.revolution import (
    best_circle,
    cone,
    minorant,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
)
from reference.fem.half_space_mesh import power_lines


def _pressed_to(radius):
    """Penetration of a rounded punch of radii 1 and 1: a (s - acos(1/a)), s^2 = a^2 - 1."""
    return radius * (math.sqrt(radius**2 - 1) - math.acos(1 / radius))


# A body, its closed form for E* = 1, and a penetration.
ROUND = {
    "paraboloid": (paraboloid(2.0), closed_form.paraboloid(2.0, 1.0), 0.1),
    "cone": (cone(0.3), closed_form.cone(0.3, 1.0), 0.1),
    "power_1.5": (power_law(1.5, 0.7), closed_form.power_law(1.5, 0.7, 1.0), 0.1),
    "power_3": (power_law(3.0, 0.7), closed_form.power_law(3.0, 0.7, 1.0), 0.1),
    "power_6": (power_law(6.0, 0.7), closed_form.power_law(6.0, 0.7, 1.0), 0.1),
    "shallow_sphere": (sphere(1.0), closed_form.sphere(1.0, 1.0), 1e-4),
    "sphere_to_half": (sphere(1.0), closed_form.sphere(1.0, 1.0), 0.5 * math.atanh(0.5)),
    "rounded_punch": (rounded_punch(1.0, 10.0), closed_form.rounded_punch(1.0, 10.0, 1.0), 0.1),
    "hardly_rounded": (
        rounded_punch(1.0, 1.0),
        closed_form.rounded_punch(1.0, 1.0, 1.0),
        _pressed_to(1.05),
    ),
}


def _energy(name):
    profile, form, depth = ROUND[name]
    # an array without dimension is a number, too
    return revolution.energy(profile, np.array(depth), 1.0, cells=16), form.energy(depth)


def _stiffness(name):
    profile, form, depth = ROUND[name]
    return revolution.stiffness(profile, depth, 2.0), 2 * form.stiffness(depth)


def _hardly_rounded(ratio):
    depth = _pressed_to(ratio)
    exact = closed_form.rounded_punch(1.0, 1.0, 1.0).force(depth)
    return revolution.force(rounded_punch(1.0, 1.0), depth, 1.0), exact


def _barely_pressed(depth):
    punch, form = rounded_punch(1.0, 10.0), closed_form.rounded_punch(1.0, 10.0, 1.0)
    return revolution.energy(punch, depth, 1.0, cells=16), form.energy(depth)


def _ellipsoid(slender):
    pressed = homogeneous.force(homogeneous.paraboloid(1.0, slender), 0.01, 1.0, cells=(5, 6))
    return pressed, closed_form.ellipsoid(1.0, slender, 1.0).force(0.01)


def _square(cut):
    corners = [(1, 1 - cut), (1 - cut, 1), (-1, 1), (-1, -1), (1, -1)]
    return flat_faces.bounded(corners if cut else SQUARE, (4, 5) if cut else (5, 6)), 2 * 1.15229


@pytest.mark.parametrize(
    ("enclose", "of", "width"),
    [
        # third order: 32 cells reach 1e-5 (slow test), 16 are eight times as wide
        *((_energy, name, 2e-4) for name in ROUND),
        # sums from the left and the right of 65536 parts: of first order
        *((_stiffness, name, 4e-5) for name in ROUND),
        # a step of penetration that suits the bend of the force, and elements for a sharp corner
        *((_hardly_rounded, ratio, 1e-4) for ratio in (1.001, 1.05, 3.0)),
        # flat part and contact end within a millionth of each other: an element each
        *((_barely_pressed, depth, 5e-3) for depth in (1e-12, 1e-8, 1e-5)),
        *((_ellipsoid, slender, 1e-3) for slender in (1.0, 10.0)),
        (lambda radius: (revolution.disc_stiffness(radius, 2.0), 4 * radius), 3.0, 1e-4),
        # of side 2; corners a ten-millionth of it apart, next to a mirror line, but not on it
        *((_square, cut, width) for cut, width in ((0, 5e-3), (1e-7, 0.05))),
    ],
)
def test_closed_form_lies_within_the_bounds(enclose, of, width):
    bounds, exact = enclose(of)
    assert float(exact) in bounds
    assert bounds.width < width


def test_a_ball_is_enclosed_as_tightly_where_it_nearly_ends():
    # the slope of the gap is infinite at the radius, which is reached at a/R = 0.83
    form, ball = closed_form.sphere(1.0, 1.0), sphere(1.0)
    for depth in (0.3, 0.9, 0.94):
        enclosed = revolution.force(ball, depth, 1.0, cells=16)
        assert float(form.force(depth)) in enclosed
        assert enclosed.width < 4e-4
    # the step of penetration that bounds the force goes no deeper than the radius
    assert float(form.force(0.99)) in revolution.force(ball, 0.99, 1.0, cells=16)
    assert 0.9 in revolution.penetration(ball, float(form.force(0.9)), 1.0, cells=16)


@pytest.mark.parametrize("unit", [1e-9, 1e9])
@pytest.mark.parametrize("name", ["paraboloid", "sphere", "rounded_punch"])
def test_bounds_keep_their_digits_in_any_units(name, unit):
    radii = 2 if name == "rounded_punch" else 1
    form = getattr(closed_form, name)(*[unit] * radii, 2e11)
    body, scaled = (getattr(revolution, name)(*[length] * radii) for length in (1.0, unit))
    tiny = revolution.force(scaled, 0.01 * unit, 2e11, cells=12)
    assert float(form.force(0.01 * unit)) in tiny
    assert tiny.width == pytest.approx(revolution.force(body, 0.01, 1.0, cells=12).width, rel=1e-6)
    stiff, one = (
        revolution.stiffness(*of) for of in ((scaled, 0.01 * unit, 1.0), (body, 0.01, 1.0))
    )
    assert (stiff.lower / unit, stiff.upper / unit) == pytest.approx(
        (one.lower, one.upper), rel=1e-9
    )


def test_best_circle_is_exact_for_a_body_of_revolution():
    # the contact is a circle, so that Barber's bound is the force, less the excess of 4000 chords
    for profile, form, depth in ROUND.values():
        force = float(form.force(depth))
        assert 0 <= 1 - best_circle(profile, depth).force / force < 1e-7


def test_both_sides_converge_with_third_order():
    exact = float(closed_form.paraboloid(1.0, 1.0).energy(1.0))
    coarse, fine = (revolution.energy(paraboloid(1.0), 1.0, 1.0, cells=n) for n in (8, 16))
    for one, two in ((coarse.lower, fine.lower), (coarse.upper, fine.upper)):
        assert math.log2(abs(one - exact) / abs(two - exact)) > 2.6


def test_minorant_stays_below_the_gap_everywhere():
    t = np.linspace(0, 1, 41)
    weights = np.stack([(1 - t) ** 2, 2 * t * (1 - t), t**2])
    for profile, _, depth in ROUND.values():
        radii = np.linspace(0.0, profile.reach(depth), 9)
        radii = np.sort(np.concatenate([radii, profile.corners]))
        bends = minorant(profile, radii)
        for k in range(len(radii) - 1):
            places = radii[k] + t * (radii[k + 1] - radii[k])
            below = bends[2 * k : 2 * k + 3] @ weights
            # places are rounded as well
            rounding = 1e-15 * (depth + places * profile.slope(places))
            assert (below <= profile.gap(places) + rounding).all()


def _hertz(outer: float, count: int = 24) -> tuple[Rings, np.ndarray, np.ndarray]:
    """Rings up to a radius, with the work on them at penetration 1 of a ball of radius 1."""
    pressures = Rings(outer * np.arange(1, count + 1) / count)
    base, missing = np.pi * pressures.radii**2, 0.25 * np.pi * pressures.radii**4
    return pressures, base - missing, base + missing


def test_a_pressure_that_pulls_anywhere_is_no_lower_bound():
    # on a disc 1.5 times as large as the contact the unrestricted pressure pulls at the edge and
    # stores more than the contact does: as a lower bound it would be wrong by 18 %
    pressures, work, magnitude = _hertz(1.5)
    steps = np.linalg.solve(pressures.matrix, work)
    pressure = np.cumsum(steps[::-1])[::-1]
    assert 0.5 * steps @ work > 1.1 * 8 / 15
    with pytest.raises(ValueError, match="pressure must be at least 0"):
        energy_below(pressures, work, magnitude, pressure)
    assert energy_below(pressures, work, magnitude) < 8 / 15


def test_a_displacement_that_is_below_the_body_where_it_was_left_free_is_refused():
    # one on the disc of radius 1, and less than one beyond: a body that is as deep there is not met
    radii, depths = np.array([0.0, 0.5, 1.0, 2.0, 4.0]), np.array([0.0, 1.0, 3.0])
    elements = Prisms(rings(radii), depths, np.arange(5))
    floor = np.where(np.arange(9) < 5, 1.0, -np.inf)
    assert 1.0 < energy_above(elements, floor) < 2.0
    floor[5:7] = 1.0
    with pytest.raises(ArithmeticError, match="below the body"):
        energy_above(elements, floor)


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: power_law(0.7, 1.0),
        lambda: sphere(-1.0),
        lambda: homogeneous.pyramid(2, 1.0),
        lambda: homogeneous.pyramid(3.5, 1.0),
        lambda: homogeneous.paraboloid(1.0, math.inf),
        lambda: revolution.energy(paraboloid(1.0), 1.0, 1.0, cells=4.5),
        lambda: revolution.penetration(sphere(1.0), 50.0, 1.0),
        lambda: homogeneous.force(homogeneous.paraboloid(1.0, 1.0), 1.0, 1.0, cells=(0, 4)),
        lambda: flat_faces.bounded(SQUARE, (4, 0)),
        lambda: outlines.polygon([], 2, 1.0),
        # a pentagram sees all its sides from the middle, but goes round it twice
        lambda: outlines.polygon([_on_circle(4 * math.pi * k / 5) for k in range(5)], 2, 1.0),
        lambda: revolution.energy(paraboloid(1.0), 0.0, 1.0),
        lambda: revolution.force(sphere(1.0), 1.0, 1.0),
        lambda: homogeneous.force(homogeneous.pyramid(4, 1.0), -1.0, 1.0),
        lambda: outlines.polygon([(2, 0), (3, 0), (3, 1)], 2, 1.0),
    ],
)
def test_what_no_theorem_covers_is_refused(wrong):
    with pytest.raises(ValueError, match=r"\w+ \w+"):
        wrong()


def test_self_energy_of_the_square_adds_up_from_graded_cells():
    # over the unit square the double integral of 1/r is 4 [ln(1 + sqrt 2) + (1 - sqrt 2)/3]
    exact = 4 * (math.log(1 + math.sqrt(2)) + (1 - math.sqrt(2)) / 3)
    square = regular(4, 3, 2.0).stretched(0.5, 0.5)
    factors = np.array([0.0, 0.5, 0.9, 0.99, 1.0])
    cells = fan_cells(square.points, factors, closed=False)
    integrals, errors = mutual_integrals(cells, square.images)
    assert len(square.images) * areas(cells).sum() == pytest.approx(1.0, rel=1e-14)
    # far cells are taken by Gauss points whose error is below 2e-7 of each
    assert abs(len(square.images) * integrals.sum() / exact - 1) < 1e-9
    assert errors.sum() < 1e-7 * integrals.sum()


def test_nearly_parallel_sides_of_a_hexagon_keep_their_digits():
    # rays next to the corners meet the sides of other images far away
    hexagon = regular(6, 3, 4.0)
    cells = fan_cells(hexagon.points, np.array([0.0, 0.6, 0.99, 1.0]), closed=False)
    integrals, errors = mutual_integrals(cells, hexagon.images)
    coarse = regular(6, 1, 1.0)
    whole, _ = mutual_integrals(
        fan_cells(coarse.points, np.array([0.0, 1.0]), closed=False), coarse.images
    )
    assert integrals.sum() == pytest.approx(whole.sum(), rel=1e-9)
    assert errors.sum() < 1e-6 * integrals.sum()


def regular(sides, cells, exponent):
    """Outline of a regular polygon of apothem 1."""
    angles = (2 * np.arange(sides) + 1) * math.pi / sides
    radius = 1 / math.cos(math.pi / sides)
    corners = [(radius * math.cos(a), radius * math.sin(a)) for a in angles]
    return outlines.polygon(corners, cells, exponent)


SQUARE = ((1, -1), (1, 1), (-1, 1), (-1, -1))


def _on_circle(angle):
    return math.cos(angle), math.sin(angle)


def test_no_face_is_softer_than_the_disc_of_its_area():
    assert flat_faces.equal_area_stiffness(4.0) < _square(0)[0].lower


@pytest.mark.parametrize(
    ("corners", "images"),
    [
        (SQUARE, 8),
        (((2, -1), (2, 1), (-2, 1), (-2, -1)), 4),
        (((1, -1), (1, 1), (-1, 0)), 2),
        (((1, -1), (1, 1), (-1, 0.3)), 1),
    ],
)
def test_polygons_are_cut_down_by_their_mirror_lines(corners, images):
    outline = outlines.polygon(corners, 2, 2.0)
    assert len(outline.images) == images
    cells = fan_cells(outline.points, np.array([0.0, 1.0]), closed=outline.closed)
    x, y = np.array(corners, dtype=float).T
    area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    assert images * areas(cells).sum() == pytest.approx(area, rel=1e-12)


@pytest.mark.parametrize(
    "corners",
    [
        # longest along no axis, and hollow: confocal copies of these cross
        ((1.0, 0.8), (0.8, 1.0), (-1.0, -0.7), (-0.8, -1.0)),
        ((1.0, 1.0), (0.1, 0.2), (-1.0, 0.5), (-0.2, -0.1), (-0.3, -0.4), (0.2, -0.1)),
    ],
)
def test_shells_of_any_outline_lie_inside_each_other(corners):
    outline = outlines.polygon(corners, 3, 2.0)
    shells = outline.shells(np.array([0.5, 1.0]), power_lines(4, 3.0, 20.0)[1:])
    assert outlines.nested(shells, closed=outline.closed)
    stiffness = flat_faces.bounded(corners, (4, 5))
    x, y = np.array(corners).T
    area = 0.5 * (x * np.roll(y, -1) - y * np.roll(x, -1)).sum()
    assert flat_faces.equal_area_stiffness(area) < stiffness.upper
    assert stiffness.width < 0.2


def test_elements_on_shells_that_cross_are_refused():
    # what they would carry is no function of the place, and its energy no bound
    diamond = np.array([(1.0, 0.9), (-0.05, 0.05), (-1.0, -0.9), (0.05, -0.05)])
    with pytest.raises(ValueError, match="inside each other"):
        fan(np.stack([diamond, diamond * [1.1, 3.0]]), closed=True)


@pytest.mark.slow
def test_pyramid_is_enclosed_above_the_best_circle():
    vickers = homogeneous.pyramid(4, 1 / math.tan(math.radians(68)))
    pressed = homogeneous.force(vickers, 2.0, 3.0, cells=(5, 6))
    assert pressed.width < 4e-3
    # the best circle carries E* d^2/(s sqrt 2), 4 % less than the true area, drawn out along edges
    circle = 3 * 4 / math.sqrt(2) * math.tan(math.radians(68))
    assert 0.94 < circle / pressed.middle < 0.97


@pytest.mark.parametrize("ratio", [1e-3, 1e-6, 1e-9])
def test_slender_punches_keep_their_digits(ratio):
    """K(m) = ln(4 a/b) + ((ln(4 a/b) - 1)/4) (b/a)^2 + ... (DLMF 19.12.1), to 1e-11 at 1 : 1000."""
    logarithm = np.log(4 / ratio)
    integral = logarithm + (logarithm - 1) / 4 * ratio**2
    assert elliptic_stiffness(ratio, 1.0).middle == pytest.approx(np.pi / integral, rel=2e-11)
