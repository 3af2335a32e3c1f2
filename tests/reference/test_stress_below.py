"""Stress below half-spaces and layers: Hertz, waves, equilibrium, continuity."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.elasticity import Material
from reference.halfspace.stress_below import largest_below, stress_below
from reference.layered import Graded, LayeredPeriodic, Stack
from reference.layered.stresses import inside

RATIOS = st.floats(-0.9, 0.5)


def hertz(cells):
    """Return Hertz's pressure, p0 = a = 1, at so many cells along the radius."""
    x = (np.arange(-cells, cells) + 0.5) / cells
    return np.sqrt(np.maximum(1 - x[:, None] ** 2 - x**2, 0.0)), (1 / cells, 1 / cells)


def on_axis(z, nu):
    """Return the largest shear stress on the axis (Johnson 1985, eq. 3.45), p0 = a = 1."""
    radial = -(1 + nu) * (1 - z * np.arctan(1 / z)) + 0.5 / (1 + z * z)
    return 0.5 * (radial + 1 / (1 + z * z))


def test_the_largest_stresses_below_hertz_converge_at_second_order():
    """0.310 p0 at 0.481 a, twice that by von Mises; steps of the pressure err by the cell squared.

    Depths are found to a hundredth, of which the stress feels the square.
    """
    z = np.linspace(0.3, 0.7, 4001)
    shear = on_axis(z, 0.3)
    errors = []
    for cells in (8, 16, 32):
        most = largest_below(*hertz(cells), 0.3)
        assert most.shear_depth == pytest.approx(z[shear.argmax()], rel=0.02)
        assert most.von_mises == pytest.approx(2 * most.shear, rel=2e-3)  # off the axis by a bit
        errors.append(abs(most.shear / shear.max() - 1))
    assert errors[-1] < 4e-4
    assert np.log2(np.divide(errors[:-1], errors[1:])) == pytest.approx([2, 2], abs=0.3)


def test_cells_far_apart_from_their_images_agree_with_waves():
    """Two ways without a common line. Periods of 512 leave the load of the images: (16/512)^2."""
    pressure = np.random.default_rng(0).random((16, 16))
    repeated = np.zeros((512, 512))
    repeated[:16, :16] = pressure
    steel = Stack([], [], Material(1.0, 0.3))
    (field,) = inside(steel, repeated, (1.0, 1.0), [3.0])
    own = stress_below(pressure, (1.0, 1.0), 3.0, 0.3)
    assert np.abs(field.stress[:, :16, :16] - own).max() < 0.01 * np.abs(own).max()


@settings(max_examples=20, deadline=None)
@given(nu=RATIOS, depth=st.floats(0.05, 5.0), seed=st.integers(0, 99))
def test_stresses_turn_with_the_pressure_and_scale_with_lengths(nu, depth, seed):
    """Transposed cells exchange x and y; the same cells in other units have the same stress."""
    pressure = np.random.default_rng(seed).random((5, 4))
    field = stress_below(pressure, (1.0, 0.7), depth, nu)
    turned = stress_below(pressure.T, (0.7, 1.0), depth, nu)
    assert turned.swapaxes(1, 2)[[1, 0, 2, 4, 3, 5]] == pytest.approx(field, abs=1e-12)
    scaled = stress_below(1e9 * pressure, (1e-9, 0.7e-9), depth * 1e-9, nu)
    assert scaled == pytest.approx(1e9 * field, rel=1e-9, abs=1e-3)


@settings(max_examples=20, deadline=None)
@given(nu=RATIOS, depth=st.floats(0.5, 2.0))
def test_what_presses_from_above_is_carried_at_every_depth(nu, depth):
    """The integral of s_zz over a plane is the force; beyond 60 depths a point force leaves less.

    A share of it outside a radius R of the plane is (z/R)^3 of 3 F z^3/(2 pi r^5).
    """
    pressure = np.zeros((121, 121))
    pressure[60, 60] = 1.0
    field = stress_below(pressure, (1.0, 1.0), depth, nu)
    # sums of cells stand for the integral where the field is wide against them
    rel = 2e-3 if depth >= 1 else 0.2
    assert -field[2].sum() == pytest.approx(1.0, rel=rel)


STEEL = Material(1.0, 0.3)
SPACING = (0.2, 0.25)


def pressures(shape=(16, 12)):
    return np.random.default_rng(3).random(shape)


def test_oblique_wave_on_a_half_space_is_the_closed_form():
    """s_zz = -(1 + q z) e, s_xx + s_yy = -(1 + 2 nu - q z) e, e = p exp(-q z) (Johnson, ch. 13)."""
    i, j = np.ix_(np.arange(16), np.arange(12))
    phase = 2 * np.pi * (2 * i / 16 + j / 12)
    q = 2 * np.pi * np.hypot(2 / (16 * 0.2), 1 / (12 * 0.25))
    for field in inside(Stack([], [], STEEL), np.cos(phase), SPACING, [0.05, 0.3, 1.0]):
        decay, s = np.exp(-q * field.depth), q * field.depth
        xx, yy, zz, yz, xz, _ = field.stress
        np.testing.assert_allclose(zz, -(1 + s) * decay * np.cos(phase), atol=1e-13)
        np.testing.assert_allclose(xx + yy, -(1.6 - s) * decay * np.cos(phase), atol=1e-13)
        shear = np.hypot(xz, yz)
        np.testing.assert_allclose(shear, np.abs(s * decay * np.sin(phase)), atol=1e-13)


@pytest.mark.parametrize("nu", [-0.4, 0.3, 0.5])
def test_layers_of_one_material_have_the_stresses_of_the_half_space(nu):
    """Those of the half-space are in closed form; nu differs enough to take the way of layers."""
    material, depths = Material(2.0, nu), [0.01, 0.3, 0.55, 4.0]
    almost = Material(2.0, nu * (1 - 1e-14))
    plain = inside(Stack([], [], material), pressures(), SPACING, depths)
    layered = inside(Stack([0.3, 0.2, 1.0], [almost] * 3, material), pressures(), SPACING, depths)
    for one, other in zip(plain, layered, strict=True):
        np.testing.assert_allclose(one.stress, other.stress, atol=1e-12)
        np.testing.assert_allclose(one.displacement, other.displacement, atol=1e-12)


def test_tractions_and_displacements_pass_an_interface():
    """A nanometre of either side of it; what lies along the interface jumps with the modulus."""
    stack = Stack([0.3], [Material(20.0, 0.1)], STEEL)
    above, under = inside(stack, pressures(), SPACING, [0.3 - 1e-9, 0.3 + 1e-9])
    np.testing.assert_allclose(above.stress[2:5], under.stress[2:5], atol=1e-6)
    np.testing.assert_allclose(above.displacement, under.displacement, atol=1e-6)
    assert np.abs(above.stress[0]).max() > 1.5 * np.abs(under.stress[0]).max()


@pytest.mark.parametrize("base", [STEEL, None])
def test_surface_moves_as_the_compliance_says_and_carries_the_pressure(base):
    stack = Stack([0.3, 0.2], [Material(5.0, 0.5), Material(0.2, 0.2)], base)
    (top,) = inside(stack, pressures(), SPACING, [1e-9])
    surface = LayeredPeriodic((16, 12), SPACING, stack).apply(pressures())
    moved = top.displacement[2]
    np.testing.assert_allclose(moved - moved.mean(), surface - surface.mean(), atol=1e-6)
    np.testing.assert_allclose(top.stress[2], -pressures(), atol=1e-6)


def test_nothing_is_told_of_the_rigid_base():
    layer = Stack([0.5], [STEEL])
    assert [field.depth for field in inside(layer, pressures(), SPACING, [0.2, 0.5, 0.7])] == [
        0.2,
        0.5,
    ]
    with pytest.raises(ValueError, match="finite numbers; depths must be positive and increase"):
        list(inside(layer, np.full((4, 4), np.nan), SPACING, [0.3, 0.1]))


@pytest.mark.parametrize("exponent", [-0.4, 0.4])
def test_slices_of_a_graded_body_give_way_as_it_does(exponent):
    """Slices a quarter thicker from one to the next: 1 % in the displacement of a wave.

    It is the uppermost that errs where E is infinite at the surface, 0.03 % where it is zero.
    """
    graded = Graded(Material(2.0, 0.3), exponent, 1.5)
    ends = np.append(0.0, 0.05 * 1.25 ** np.arange(30.0))
    parts = graded.slices(ends)
    stack = Stack(np.diff(ends)[:-1].tolist(), parts[:-1], parts[-1])
    q = np.array([0.5, 1.0, 2.0])
    assert stack.compliance(q) == pytest.approx(
        graded.compliance(q), rel=0.012 if exponent < 0 else 1e-3
    )


def test_a_part_has_the_fields_of_the_whole_at_any_depth():
    """By rounding of the transforms."""
    stack, depths = Stack([0.2], [Material(3.0, 0.2)], STEEL), [0.05, 4.0, 20.0]
    whole = inside(stack, pressures(), SPACING, depths)
    for one, other in zip(inside(stack, pressures(), SPACING, depths, (5, 7)), whole, strict=True):
        np.testing.assert_allclose(one.stress, other.stress[:, :5, :7], atol=1e-14)
        np.testing.assert_allclose(one.displacement, other.displacement[:, :5, :7], atol=1e-14)
