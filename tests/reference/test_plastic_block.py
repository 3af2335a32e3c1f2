"""Elastic-plastic half-spaces in three dimensions: Hertz's ellipse, round contacts, first yield."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reference.closed_form import ellipsoid
from reference.elasticity import Material
from reference.loads import LoadPath
from reference.plastic import PlasticMaterial, Walk, yield_pressure
from reference.plastic.dent_formulas import elliptic_yield_pressure
from reference.plastic.elements import CoredSystem, Elements
from reference.plastic.indentation import first_yield
from reference.plastic.j2 import Points, respond

NU, Y = 0.3, 1 / 500  # E = 1
MODULUS = 1 / (1 - NU**2)
STEEL = PlasticMaterial(Material(1.0, NU), Y)
FIRST = (np.pi * 1.6 * Y / (2 * MODULUS)) ** 2  # of a ball of R = 1
OVAL = ellipsoid(2.0, 0.5, MODULUS)


def oval(x, y):
    """Return the gap of an ellipsoid whose radii have a geometric mean of one."""
    return x**2 / 4 + y**2


def half_widths(depth: float) -> tuple[float, float]:
    """Return Hertz's semi-axes."""
    long, short = OVAL.semi_axes(depth)
    return float(long), float(short)


def test_radial_return_in_the_plane_and_in_space_are_one():
    law = PlasticMaterial(Material(1.0, NU), Y, 0.2, "power")
    round_ = np.array([[0.01, -0.02, 0.003, 0.01]])
    spatial = np.array([[0.01, -0.02, 0.003, 0.0, 0.0, 0.01]])
    flat_stress, _, flat = respond(law, round_, Points.virgin((1,)), tangent=True)
    space_stress, _, space = respond(law, spatial, Points.virgin((1,), 6), tangent=True)
    keep = [0, 1, 2, 5]
    assert_allclose(space_stress[:, keep], flat_stress, rtol=1e-13)
    assert_allclose(space[0][np.ix_(keep, keep)], flat[0], rtol=1e-12, atol=1e-15)
    # without a shear of their own the other two only feel the secant modulus
    assert_allclose(space[0][3, 3], space[0][4, 4], rtol=1e-13)


def test_a_core_that_changes_and_grows_solves_the_whole_system():
    rng = np.random.default_rng(0)
    centres = np.stack([np.arange(8.0), np.zeros(8), np.zeros(8)], axis=1)
    unknowns = np.arange(8)[:, None] * 2 + np.arange(4)
    matrices = np.array([m @ m.T + np.eye(4) for m in rng.normal(size=(8, 4, 4))])
    system, loads = CoredSystem(unknowns, centres, 2.0), rng.normal(size=18)
    for changed in ([], [1], [5], [0, 5]):
        matrices[changed] *= 1.5
        whole = np.zeros((18, 18))
        for at, matrix in zip(unknowns, matrices, strict=True):
            whole[np.ix_(at, at)] += matrix
        answer = system.factorised(matrices.copy(), 0.0)(loads)
        assert_allclose(answer, np.linalg.solve(whole, loads), rtol=1e-10)


def test_ellipses_first_yield_as_circles_and_cylinders_at_their_ends():
    for nu in (0.0, 0.3):
        assert_allclose(elliptic_yield_pressure(nu, 1.0), yield_pressure(nu), rtol=1e-5)
    # a cylinder (Johnson 1985, 4.2): s_x, s_z = -p0 [(1 + 2 t^2)/root - 2 t], -p0/root,
    # root^2 = 1 + t^2
    t = np.linspace(0, 2, 2001)
    root = np.sqrt(1 + t**2)
    x, z = (1 + 2 * t**2) / root - 2 * t, 1 / root
    for nu in (0.1, 0.3):
        y = nu * (x + z)
        mises = np.sqrt(0.5 * ((x - y) ** 2 + (y - z) ** 2 + (z - x) ** 2))
        assert_allclose(1 / elliptic_yield_pressure(nu, 1e-3), mises.max(), rtol=2e-3)
    with pytest.raises(ValueError, match="slenderness"):
        elliptic_yield_pressure(0.3, 1.1)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("far", "within"), [(3.0, 0.02), pytest.param(10.0, 5e-3, marks=pytest.mark.slow)]
)
def test_elastic_limit_is_hertz_of_an_ellipse(monkeypatch, far, within):
    monkeypatch.setattr("reference.plastic.elements._BLOCK_OUTER", far)
    depth = 1.0
    elastic = PlasticMaterial(Material(1.0, NU), np.inf)
    walk = Walk(elastic, oval, half_widths(depth), per_radius=2)
    state = walk.indentation.press(walk.indentation.virgin, depth / walk.length)
    # two elements on a half-width: 2e-3 measured, of a circle 3e-3; a mesh of three half-widths
    # leaves what falls with their cube
    assert_allclose(state.force * walk.length**2, float(OVAL.force(depth)), rtol=within)
    area = walk.indentation.contact_area(state) * walk.length**2
    # the place of the edge, within a quarter of an element
    assert_allclose(area, float(OVAL.contact_area(depth)), rtol=0.1)


def test_a_contact_reaches_the_edge_of_the_net_on_either_side():
    """Berkovich's pyramid: its corner at -x is twice as far as its face at +x."""
    block = Elements.block((1.0, 1.0), 2, NU, (False, True))

    def gap(x, y):
        return np.maximum(x, np.abs(y) * np.sqrt(0.75) - x / 2)

    flat, area = np.zeros(block.size), 3 * np.sqrt(3)
    assert_allclose(block.contact_area(gap, 0.6, flat), area * 0.6**2, rtol=0.03)
    # the corner is at 1.7, the net ends at 1.48, and on the other sides it holds the contact
    assert block.contact_area(gap, 0.85, flat) == np.inf
    assert block.contact_area(lambda x, y: gap(-x, y), 0.85, flat) == np.inf


@pytest.mark.slow
def test_a_ball_dents_the_block_as_it_dents_the_section():
    depth = 10 * FIRST
    radius = float(np.sqrt(1.25 * depth))
    answers = []
    for shape, size, count in (
        (lambda r: r**2 / 2, radius, 6),
        (lambda x, y: (x**2 + y**2) / 2, (radius, radius), 3),
    ):
        walk = Walk(STEEL, shape, size, per_radius=count)
        (moment,) = walk.along(LoadPath("penetration", depth))
        assert moment.residual < 1e-8
        assert_allclose(moment.elastic + moment.dissipated, moment.work, rtol=1e-2)
        answers.append((moment.force, moment.counted_area, walk.residual_depth(moment)))
    # three elements on a radius, and their steps
    assert_allclose(answers[1], answers[0], rtol=0.03)


@pytest.mark.slow
def test_elements_first_yield_below_an_ellipse_where_the_closed_form_does():
    found = first_yield(STEEL, oval, half_widths, FIRST, per_radius=3)
    long, short = half_widths(found)
    largest = 1.5 * float(OVAL.force(found)) / (np.pi * long * short)
    # the largest stress lies between Gauss points
    assert_allclose(largest / Y, elliptic_yield_pressure(NU, short / long), rtol=0.02)
