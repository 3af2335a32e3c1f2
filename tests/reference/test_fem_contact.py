"""Contact of rigid shapes with the finite-element half-space, against closed forms."""

from functools import cache

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.special import ellipk

from reference.errors import ConvergenceError
from reference.fem import (
    Enforcement,
    Material,
    RingMesh,
    TensorMesh,
    contact_radius,
    half_space_body,
    indent,
    press,
)
from reference.loads import Load, LoadPath


@cache
def default_body(nu=0.3):
    return half_space_body(RingMesh(1.0), Material(1.0, nu))


@cache
def fitted_body(nu=0.3, elements=4, sharp=False, aspect=1.0):
    root = float(np.sqrt(aspect))
    return half_space_body(
        RingMesh(1.0, edge=1.0, elements=elements, sharp=sharp, stretch=(root, 1.0 / root)),
        Material(1.0, nu),
    )


def paraboloid(body):
    return 0.5 * (body.points**2).sum(axis=1)


def indented(body, gap, depth):
    return next(indent(body, gap, Load("penetration", depth)))


def hertz_error(body, step):
    """Relative error against F = 4/3 E* sqrt(R) d^1.5 (Johnson 1985, eq. 4.23), R = 1."""
    return step.force / (4.0 / 3.0 * body.effective_modulus * step.penetration**1.5) - 1.0


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.4999])
def test_hertz_on_a_fitted_mesh_at_any_depth(nu):
    """Measured 2e-5 (nu = 0.3) to 1e-4 in force with 7000 unknowns; the contract is 2e-4."""
    body = fitted_body(nu)
    for depth, (fitted, step) in zip(
        (1e-6, 0.2, 7.0),
        indent(body, lambda x, y: 0.5 * (x**2 + y**2), Load("penetration", [1e-6, 0.2, 7.0])),
        strict=True,
    ):
        assert abs(hertz_error(fitted, step)) < 2e-4
        assert step.contact_area == pytest.approx(np.pi * depth, rel=4e-4)
        assert step.stiffness == pytest.approx(
            2 * body.effective_modulus * np.sqrt(depth), rel=4e-4
        )
        # U = 2/5 F d for a paraboloid
        assert step.energy == pytest.approx(0.4 * step.force * depth, rel=4e-4)


@pytest.mark.slow
@pytest.mark.parametrize(("aspect", "bound"), [(2, 1.3e-3), (5, 2e-3)])
def test_flat_elliptic_punch_stiffness(aspect, bound):
    """``pi E* a/K(1 - b^2/a^2)`` (Johnson 1985, sec. 3.8), from above: nodes touch, a Ritz method.

    Rings crowd towards the singular edge.
    """
    body = fitted_body(sharp=True, aspect=aspect)
    gap = np.where(body.scaled_radii <= 1.0 + 1e-9, 0.0, np.inf)
    (step,) = press(body, gap, Load("penetration", 0.01))
    exact = np.pi * body.effective_modulus * np.sqrt(aspect) / ellipk(1.0 - aspect**-2)
    assert 0.0 < step.stiffness / exact - 1.0 < bound
    assert step.force == pytest.approx(step.stiffness * 0.01, rel=1e-12)
    assert step.contact_area == pytest.approx(np.pi, rel=1e-12)


@pytest.mark.parametrize("radius", [1.01, 1.1, 3.0])
def test_rounded_punch_with_its_kink_anywhere_inside_the_mesh(radius):
    """Flat to 1, then (r - 1)^2/2: F by the method of dimensionality reduction (Popov & Hess 2015).

    No mesh line follows the kink; the crowded rings of a sharp edge resolve the pressure next to
    it. Measured up to 4.3e-4 in force and 3e-3 in area.
    """

    def profile(x):
        return x * (np.sqrt(x * x - 1.0) - np.arccos(1.0 / x)) if x > 1.0 else 0.0

    body = fitted_body(sharp=True)
    depth = profile(radius)
    exact = depth * radius - quad(profile, 1.0, radius)[0]
    _, step = indented(
        body, lambda x, y: 0.5 * np.clip(np.hypot(x, y) - 1.0, 0.0, None) ** 2, depth
    )
    assert step.force == pytest.approx(2.0 * body.effective_modulus * exact, rel=6e-4)
    assert step.contact_area == pytest.approx(np.pi * radius**2, rel=4e-3)


@pytest.mark.slow
def test_pressure_peak_and_radius_are_those_of_hertz():
    """At 24 000 unknowns: peak 1e-3, L2 5e-3, contact radius 5e-4 (measured 7e-5, 5e-4, 1e-6)."""
    fitted, step = indented(fitted_body(0.3, 6), lambda x, y: 0.5 * (x**2 + y**2), 1.0)
    radius = np.hypot(*fitted.points.T)
    peak = 2.0 * fitted.effective_modulus / np.pi
    exact = peak * np.sqrt(np.clip(1.0 - radius**2, 0.0, None))
    error = fitted.weights @ (step.pressure - exact) ** 2 / (fitted.weights @ exact**2)
    assert np.sqrt(error) < 5e-3
    assert step.pressure.max() == pytest.approx(peak, rel=1e-3)
    assert np.sqrt(step.contact_area / np.pi) == pytest.approx(1.0, rel=5e-4)


def test_contact_radius_from_moments_beats_counting():
    """Measured rms 0.7 % against 3 % for the counted nodes."""
    body = default_body()
    fitted, counted = [], []
    for step in press(body, paraboloid(body), Load("penetration", np.linspace(0.4, 0.95, 12))):
        exact = np.sqrt(step.penetration)
        fitted.append(contact_radius(body, step.reactions, step.active) / exact - 1.0)
        counted.append(np.sqrt(step.contact_area_raw / np.pi) / exact - 1.0)
    assert np.std(fitted) < 0.015
    assert np.linalg.norm(fitted) < 0.5 * np.linalg.norm(counted)


def test_nearly_incompressible_elements_do_not_lock():
    """At nu = 0.499; with as many Gauss points for the volume, forces are a quarter too large."""
    lines = np.linspace(0.0, 1.2, 7)
    body = half_space_body(TensorMesh(lines, lines, symmetry="quarter"), Material(1.0, 0.499))
    (step,) = press(body, paraboloid(body), Load("penetration", 0.9))
    assert abs(hertz_error(body, step)) < 0.03


@pytest.mark.slow
def test_half_and_full_models_agree():
    """A shape that is even in one direction only: half of the mesh, the same forces (1e-9)."""

    def gap(x, y):
        return 0.5 * (x - 0.2) ** 2 + 0.4 * np.abs(y)

    lines = np.linspace(-1.0, 1.0, 9)
    pairs = [
        [
            half_space_body(RingMesh(1.0, elements=2, symmetry=name), Material(1.0, 0.3))
            for name in ("none", "half_y")
        ],
        [
            half_space_body(TensorMesh(lines, lines), Material(1.0, 0.3)),
            half_space_body(TensorMesh(lines, lines[4:], symmetry="half_y"), Material(1.0, 0.3)),
        ],
    ]
    for pair in pairs:
        full, half = (next(press(body, gap(*body.points.T), Load("force", 0.3))) for body in pair)
        assert half.penetration == pytest.approx(full.penetration, rel=1e-9)
        assert half.stiffness == pytest.approx(full.stiffness, rel=1e-9)
        assert half.energy == pytest.approx(full.energy, rel=1e-9)
    turned = half_space_body(TensorMesh(lines[4:], lines, symmetry="half_x"), Material(1.0, 0.3))
    (step,) = press(turned, gap(*turned.points.T[::-1]), Load("force", 0.3))
    assert step.penetration == pytest.approx(full.penetration, rel=1e-9)


def test_depths_count_from_first_touch():
    """A gap far from zero costs no digits of the overlap, forces may be as small as one likes.

    1e12 contact radii away, positions are known to 1e-4, and so is the penetration; the force is
    the one asked for.
    """
    body = small_body()
    gap = paraboloid(body)
    (near,) = press(body, gap, Load("force", 1e-3))
    (far,) = press(body, gap + 1e12, Load("force", 1e-3))
    assert far.penetration == pytest.approx(1e12 + near.penetration, abs=2e-4)
    assert 4.0 * far.reactions.sum() == pytest.approx(1e-3, rel=1e-8)
    (light,) = press(body, gap + 1.0, Load("force", 1e-30))
    assert light.active.sum() == 1
    assert light.violation < 1e-12
    (nothing,) = press(body, gap + 1.0, Load("penetration", 0.5))
    assert nothing.force == 0.0


@cache
def small_body():
    return half_space_body(RingMesh(1.0, elements=3), Material(1.0, 0.3))


@settings(max_examples=25, deadline=None)
@given(seed=st.integers(0, 2**32 - 1))
def test_contact_laws_hold_on_random_gaps(seed):
    """No overlap, no tension, force rises with penetration, stiffness is the slope, balance.

    From any start: a random contact set has tension and overlap all over.
    """
    body = default_body()
    rng = np.random.default_rng(seed)
    gap = rng.uniform(0.0, 1.0, len(body.weights)) ** 2
    gap[rng.random(len(gap)) < 0.1] = np.inf
    start = rng.random(len(gap)) < rng.random()
    steps = list(press(body, gap, Load("penetration", [0.1, 0.2, 0.4]), start=start))
    for step in steps:
        assert step.violation < 1e-10
        assert np.all(step.pressure >= 0.0)
        overlap = step.penetration - gap - step.displacement
        assert np.all(overlap < 1e-10)
        np.testing.assert_allclose(overlap[step.active], 0.0, atol=1e-10)
        assert step.force == pytest.approx(4.0 * step.reactions.sum(), rel=1e-12)
        assert 0.0 < step.energy < 0.5 * step.force * step.penetration * (1 + 1e-9)
    forces = [step.force for step in steps]
    assert forces == sorted(forces)
    near = steps[1].penetration * (1 + 1e-9)
    (moved,) = press(body, gap, Load("penetration", near))
    slope = (moved.force - steps[1].force) / (near - steps[1].penetration)
    assert slope == pytest.approx(steps[1].stiffness, rel=1e-4)


def test_warm_and_cold_starts_agree():
    body = default_body()
    depths = np.linspace(0.05, 1.0, 8)
    warm = [step.force for step in press(body, paraboloid(body), Load("penetration", depths))]
    cold = [
        next(press(body, paraboloid(body), Load("penetration", depth))).force for depth in depths
    ]
    np.testing.assert_allclose(warm, cold, rtol=1e-12)
    down = [
        step.force for step in press(body, paraboloid(body), LoadPath("penetration", depths[::-1]))
    ]
    np.testing.assert_allclose(down[::-1], cold, rtol=1e-12)


def test_augmented_lagrangian_ends_at_the_active_set():
    body = default_body()
    for load in (Load("penetration", 0.7), Load("force", 0.8)):
        (exact,) = press(body, paraboloid(body), load)
        (step,) = press(
            body, paraboloid(body), load, Enforcement("augmented_lagrangian", penalty=100.0)
        )
        assert step.force == pytest.approx(exact.force, rel=1e-8)
        assert step.penetration == pytest.approx(exact.penetration, rel=1e-8)
        assert step.stiffness == pytest.approx(exact.stiffness, rel=1e-8)


def test_fixed_meshes_refuse_and_report():
    body = default_body()
    gap = paraboloid(body)
    with pytest.raises(ConvergenceError, match="contact set not found") as caught:
        next(press(body, gap, Load("penetration", 1.0), Enforcement(max_iterations=1)))
    assert caught.value.history
    soft = Enforcement("augmented_lagrangian", penalty=1e-2, max_iterations=20)
    with pytest.raises(ConvergenceError, match="overlap did not vanish"):
        list(press(body, gap, Load("penetration", 1.0), soft))


# Largest error of the force at four and six elements per radius, and the least order from two
# elements on: a third of a decade above what is measured, for powers of the radius at most the
# contract of 2e-4 at four (the fourth: 1.8e-4). Powers of the radius change the sign of their error
# below nu = 0.3, where an order would be an accident (0: not asked).
BOUNDS = {
    "cone": (2e-4, 6e-5, 0.0),
    "paraboloid": (2e-4, 3e-5, 3.5),
    "third power": (2e-4, 6e-5, 3.0),
    "fourth power": (2e-4, 1e-4, 2.5),
    "flat cylinder (stiffness)": (3e-3, 6e-4, 3.0),
    "rounded punch": (8e-4, 4e-4, 2.8),
    "ellipsoid, R'/R'' = 4": (3e-4, 5e-5, 3.5),
    "ellipsoid, R'/R'' = 25": (7e-4, 1.3e-4, 3.4),
}


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49, 0.4999])
@pytest.mark.parametrize("shape", BOUNDS)
def test_errors_and_orders_of_every_shape(script, shape, nu):
    shapes = script("finite_element_tables").SHAPES
    errors = np.abs([shapes[shape](n, nu) for n in (2, 4, 6)])
    coarse, fine, order = BOUNDS[shape]
    assert errors[1] < coarse
    assert errors[2] < fine
    # where both parts of the error have one sign; sharp edges have it at every ratio
    one_sign = nu >= 0.49 or "power" not in shape
    if order and one_sign and (nu >= 0.3 or shape != "paraboloid"):
        assert -np.polyfit(np.log([2, 4, 6]), np.log(errors), 1)[0] > order
