"""Rigid shapes: the gap of each against its formula, and how far a contact can reach."""

import math
import warnings

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import TypeAdapter, ValidationError

from comparisons.scene.indenters import AnyIndenter

SHAPE = TypeAdapter(AnyIndenter)


def shape(name, **keys):
    return SHAPE.validate_python({"shape": name} | keys)


def refusal(name, **keys) -> str:
    with pytest.raises(ValidationError) as caught:
        shape(name, **keys)
    return str(caught.value)


FORMULAS = {
    "paraboloid": ({"radius": "2 m"}, lambda x, y: (x * x + y * y) / 4),
    "sphere": ({"radius": "5000 mm"}, lambda x, y: 5 - math.sqrt(25 - x * x - y * y)),
    "cone": ({"slope": "30 %"}, lambda x, y: 0.3 * math.sqrt(x * x + y * y)),
    "power_law": (
        {"exponent": 3.5, "coefficient": 0.7},
        lambda x, y: 0.7 * math.sqrt(x * x + y * y) ** 3.5,
    ),
    "rounded_punch": (
        {"flat_radius": "40 cm", "edge_radius": "3 m"},
        lambda x, y: max(math.sqrt(x * x + y * y) - 0.4, 0) ** 2 / 6,
    ),
    "ellipsoid": ({"radius_x": "2 m", "radius_y": "7 m"}, lambda x, y: x * x / 4 + y * y / 14),
    "pyramid": ({"slope": 0.4}, lambda x, y: 0.4 * max(abs(x), abs(y))),
    "cylinder": ({"radius": "1 m"}, lambda x, y: 0 if x * x + y * y <= 1 else math.inf),
    "elliptic_punch": (
        {"semi_axes": ["2 m", "1 m"]},
        lambda x, y: 0 if x * x / 4 + y * y <= 1 else math.inf,
    ),
    "square_punch": ({"side": "2 m"}, lambda x, y: 0 if max(abs(x), abs(y)) <= 1 else math.inf),
}


@pytest.mark.parametrize("name", FORMULAS)
def test_gap_is_that_of_the_contract(name):
    """Against the formula of the contract, point by point, whatever the unit of a length.

    1e-12 and not round-off: the plain formula of the sphere loses digits near its apex.
    """
    keys, formula = FORMULAS[name]
    x, y = np.meshgrid(np.linspace(-2.3, 2.1, 23), np.linspace(-1.9, 2.2, 21), indexing="ij")
    expected = np.vectorize(formula, otypes=[float])(x, y)
    gap = shape(name, **keys).gap(x, y)
    assert gap.shape == x.shape
    np.testing.assert_allclose(gap, expected, rtol=1e-12, atol=1e-14)


@pytest.mark.parametrize(
    ("name", "keys", "sharp"),
    [
        *((name, keys, name in ("cone", "pyramid")) for name, (keys, _) in FORMULAS.items()),
        ("power_law", {"exponent": 1.0, "coefficient": 0.2}, True),
        ("power_law", {"exponent": 0.5, "coefficient": 0.2}, True),
        ("power_law", {"exponent": 1.5, "coefficient": 0.2}, False),
    ],
)
def test_a_sharp_tip_is_one_whose_gap_has_a_slope_there(name, keys, sharp):
    """Gap over distance: 1e-12 from the tip it has vanished to 1e-6 for every exponent >= 1.5."""
    indenter = shape(name, **keys)
    slope = float(indenter.gap(np.array([1e-12]), np.zeros(1))[0]) / 1e-12
    assert indenter.sharp_tip == sharp == (slope > 1e-5)


def test_sphere_keeps_its_digits_and_ends_at_the_equator():
    """Near the apex f = r^2/(2R) (1 + r^2/(4R^2) + ...), where R - sqrt(R^2 - r^2) has no digit."""
    sphere = shape("sphere", radius=1.0)
    r = np.array([1e-9, 1e-7, 1e-5])
    np.testing.assert_allclose(sphere.radial_gap(r), r**2 / 2 * (1 + r**2 / 4), rtol=1e-15)
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sphere.radial_gap(np.array([1.0, 1.0 + 1e-9, 3.0])).tolist() == [1.0, np.inf, np.inf]


@pytest.mark.parametrize("interpolation", ["pchip", "linear"])
def test_a_profile_passes_through_its_table_rises_between_and_ends_sharply(interpolation):
    r, f = [0, 1e-3, 2e-3, 4e-3], [0, 1e-6, 1e-6, 9e-6]
    profile = shape("profile", r=r, f=f, interpolation=interpolation)
    np.testing.assert_allclose(profile.radial_gap(np.array(r)), f, rtol=1e-14, atol=0)
    fine = profile.radial_gap(np.linspace(0, 4e-3, 1000))
    assert np.all(np.diff(fine) >= 0)
    assert np.isinf(profile.gap(np.array([3e-3]), np.array([3e-3])))[0]
    if interpolation == "linear":
        middle = profile.radial_gap(np.array([3e-3]))
        np.testing.assert_allclose(middle, [5e-6], rtol=1e-14)


def test_kinds_of_shapes():
    """What planning asks of them: flat faces, axes and planes of symmetry."""
    assert shape("cylinder", radius=1).flat
    assert shape("profile", r=[0, 1], f=[0, 0]).flat
    assert not shape("profile", r=[0, 1], f=[0, 1]).flat
    assert shape("ellipsoid", radius_x=2, radius_y=2).axisymmetric
    assert not shape("ellipsoid", radius_x=2, radius_y=3).axisymmetric
    assert shape("elliptic_punch", semi_axes=[2, 2]).axisymmetric
    assert not shape("square_punch", side=1).axisymmetric
    assert shape("pyramid", slope=0.4).even == (True, True)
    assert shape("pyramid", slope=0.4, sides=3).even == (False, True)
    assert shape("square_punch", side=1).quarter_symmetric
    assert not shape("polygon_punch", vertices=[[0, 0], [1, 0], [0, 1]]).quarter_symmetric


def test_areas_of_faces():
    assert shape("cylinder", radius=2).face_area == pytest.approx(4 * math.pi, rel=1e-15)
    assert shape("elliptic_punch", semi_axes=[2, 3]).face_area == pytest.approx(
        6 * math.pi, rel=1e-15
    )
    assert shape("square_punch", side=3).face_area == 9
    assert shape("profile", r=[0, 2], f=[0, 0]).face_area == pytest.approx(4 * math.pi, rel=1e-15)


length = st.floats(1e-9, 1e3)
anything = st.one_of(
    st.builds(lambda r: shape("paraboloid", radius=r), length),
    st.builds(lambda r: shape("sphere", radius=r), length),
    st.builds(lambda s: shape("cone", slope=s), st.floats(1e-3, 10)),
    st.builds(
        lambda n, c: shape("power_law", exponent=n, coefficient=c), st.floats(0.5, 8), length
    ),
    st.builds(lambda r: shape("cylinder", radius=r), length),
    st.builds(lambda b, r: shape("rounded_punch", flat_radius=b, edge_radius=r), length, length),
    st.builds(lambda a, b: shape("ellipsoid", radius_x=a, radius_y=b), length, length),
    st.builds(lambda a, b: shape("elliptic_punch", semi_axes=[a, b]), length, length),
    st.builds(
        lambda s, n: shape("pyramid", slope=s, sides=n), st.floats(1e-3, 10), st.integers(3, 9)
    ),
    st.builds(lambda a: shape("square_punch", side=a), length),
    st.builds(
        lambda a, b, c: shape("polygon_punch", vertices=[[0, 0], [a, 0], [c, b]]),
        *(st.floats(1e-2, 1e2),) * 3,
    ),
    st.builds(
        lambda steps, kind: shape(
            "profile",
            r=np.cumsum([0.0, *(s for s, _ in steps)]).tolist(),
            f=np.cumsum([0.0, *(h for _, h in steps)]).tolist(),
            interpolation=kind,
        ),
        st.lists(
            st.tuples(st.floats(1e-3, 1), st.just(0.0) | st.floats(1e-6, 1)), min_size=1, max_size=6
        ),
        st.sampled_from(["pchip", "linear"]),
    ),
)


@settings(max_examples=200)
@given(indenter=anything, depth=st.floats(1e-9, 1.0), u=st.floats(0.05, 0.95))
def test_no_point_beyond_the_reach_is_nearer_than_the_penetration(indenter, depth, u):
    """Outside the box of the half-widths the gap is at least the depth: no contact is lost."""
    half_x, half_y = indenter.reach(depth)
    beyond = 1 + 1e-9
    x = half_x * np.array([beyond, -beyond, 2, u, -u, u])
    y = half_y * np.array([u, -u, u, beyond, -beyond, 3])
    assert np.all(indenter.gap(x, y) >= depth * (1 - 1e-6))


@pytest.mark.parametrize("name", ["paraboloid", "sphere", "cone", "power_law", "rounded_punch"])
def test_the_reach_is_no_larger_than_the_overlap(name):
    """At the end of the half-width the gap is the depth: not one cell is wasted."""
    indenter = shape(name, **FORMULAS[name][0])
    for depth in (1e-6, 1e-3, 0.5):
        half, _ = indenter.reach(depth)
        assert indenter.gap(np.array(half), np.array(0.0)) == pytest.approx(depth, rel=1e-6)


TRIANGLE = [[0, 0], ["3 m", 0], [0, "600 cm"]]


@pytest.mark.parametrize("vertices", [TRIANGLE, TRIANGLE[::-1]])
def test_a_polygon_turns_about_its_centroid_whichever_way_it_runs(vertices):
    """The centroid of a triangle is the mean of its corners: (1, 2)."""
    punch = shape("polygon_punch", vertices=vertices)
    assert punch.face_area == 9
    corners = {tuple(np.round(corner, 12)) for corner in punch.corners}
    assert corners == {(-1, -2), (2, -2), (-1, 4)}
    x, y = punch.corners.T
    assert np.sum(x * np.roll(y, -1) - y * np.roll(x, -1)) > 0  # counter-clockwise
    assert punch.reach(1.0) == pytest.approx((2, 4))
    x, y = np.array([[0.0, -0.9, 1.9, 1.0], [0.0, 3.5, -1.9, 1.0]])
    assert punch.gap(x, y).tolist() == [0, 0, 0, np.inf]


def test_the_centroid_of_an_l_is_not_the_mean_of_its_corners():
    """Two squares of side 1 and a 2 x 1 bar: area 3, centroid (5/6, 5/6) by composition."""
    corners = [[0, 0], [2, 0], [2, 1], [1, 1], [1, 2], [0, 2]]
    punch = shape("polygon_punch", vertices=corners)
    assert punch.face_area == pytest.approx(3)
    np.testing.assert_allclose(punch.corners[0], [-5 / 6, -5 / 6], rtol=1e-14)
    # The notch holds no material, although the outline's box does.
    centre = np.array([1.5 - 5 / 6])
    assert np.isinf(punch.gap(centre, centre))[0]
    assert punch.gap(np.zeros(1), np.zeros(1))[0] == 0


@settings(max_examples=50)
@given(
    angles=st.lists(st.floats(0, 2 * math.pi), min_size=3, max_size=12, unique=True),
    x=st.floats(-1.2, 1.2),
    y=st.floats(-1.2, 1.2),
)
def test_inside_a_convex_polygon_is_left_of_every_side(angles, x, y):
    """Even-odd rule against the half-plane test, which holds for convex outlines."""
    angles = np.sort(angles)
    vertices = np.stack([np.cos(angles), np.sin(angles)], axis=-1)
    try:
        punch = shape("polygon_punch", vertices=vertices.tolist())
    except ValidationError:
        return  # too thin to be a polygon
    start, end = punch.corners, np.roll(punch.corners, -1, axis=0)
    edge = end - start
    side = edge[:, 0] * (y - start[:, 1]) - edge[:, 1] * (x - start[:, 0])
    if np.abs(side).min() < 1e-9:
        return  # on the outline, either answer is right
    assert np.isfinite(punch.gap(np.array(x), np.array(y))) == bool(np.all(side > 0))


@pytest.mark.parametrize(
    ("vertices", "expected"),
    [
        ([[0, 0], [2, 2], [2, 0], [0, 1]], "sides touch or cross"),  # a bow tie
        ([[0, 0], [2, 0], [1, 0], [1, 1]], "sides touch or cross"),  # a spike
        ([[0, 0], [1, 0], [1, 0], [0, 1]], "sides touch or cross"),  # a corner twice
        ([[0, 0], [4, 0], [4, 4], [2, 0], [0, 4]], "sides touch or cross"),  # a corner on a side
        ([[0, 0], [1, 1], [2, 2]], "a polygon with non-zero area"),
        ([[0, 0], [0, 0], [0, 0]], "a polygon with non-zero area"),
        ([[0, 0], [2, 2], [2, 0], [0, 2]], "a polygon with non-zero area"),  # lobes that cancel
        ([[math.cos(t), math.sin(t)] for t in np.linspace(0, 6, 1001)], "at most 1000 vertices"),
    ],
)
def test_outlines_that_are_no_simple_polygon(vertices, expected):
    assert expected in refusal("polygon_punch", vertices=vertices)
