"""Stress below a half-space under pressures on cells: Hertz, waves, equilibrium."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.elasticity import Material
from reference.halfspace.stress_below import largest_below, stress_below
from reference.layered.stack import Stack
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


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        (([[np.nan]], (1.0, 1.0), 1.0, 0.3), "finite"),
        (([1.0], (1.0, 1.0), 1.0, 0.3), "grid"),
        (([[1.0]], (1.0, 0.0), -1.0, 0.3), "(?s)spacing.*depth"),
        (([[1.0]], (1.0, 1.0), 1.0, 0.7), "poisson_ratio"),
    ],
)
def test_wrong_arguments_are_named_all_at_once(arguments, message):
    with pytest.raises(ValueError, match=message):
        stress_below(*arguments)
