"""Proved bounds of rough contacts: nothing is sampled, and closed forms lie inside."""

import mpmath
import numpy as np
import pytest

from reference import closed_form, surfaces
from reference.bounds.interval import Interval
from reference.bounds.patches import Patch, force_below
from reference.bounds.periodic import PeriodicSurface
from reference.bounds.potentials import _LOVE, GridPotential, _antiderivative
from reference.bounds.trigonometric import Waves, least_on_cells
from reference.halfspace.kernels import cell_energies, love, periodic


def _heights(points, realisation=0):
    spectrum = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1)
    return surfaces.self_affine(points, 1.0, spectrum, seed=1, realisation=realisation)


def _displacement(pressure, x, y, spacing):
    """Displacement at the cells' middles moved by (x, y) cells, summed cell by cell."""
    n, m = pressure.shape
    i, j = np.arange(n), np.arange(m)
    rows, columns = i[:, None] - i[None, :] + x, j[:, None] - j[None, :] + y
    kernel = love(rows[:, None, :, None], columns[None, :, None, :], (spacing, spacing), 1.0)
    return np.einsum("ijkl,kl->ij", kernel, pressure)


@pytest.mark.slow
def test_displacement_is_bounded_between_the_middles_of_cells():
    rng = np.random.default_rng(3)
    pressure = rng.random((6, 6))
    grid = GridPotential((6, 6), 0.25, 2)
    for (x, y), u in zip(grid.places, grid.expansions(pressure), strict=True):
        for dx, dy in rng.uniform(-0.249, 0.249, (5, 2)):
            linear = u.value + 0.25 * (dx * u.slope_x + dy * u.slope_y)
            exact = _displacement(pressure, x + dx, y + dy, 0.25)
            assert (exact <= linear + u.over).all()
            assert (exact >= linear - u.under).all()


def test_the_rounding_of_loves_formula_is_bounded():
    """Against 40 digits on both sides of 16 cells, and near the corners of a cell."""
    worst = 0.0
    for i, j in ((0.125, 0.125), (0.625, 0.375), (1.125, 7.375), (15.875, 15.875), (16.125, 0.125)):
        with mpmath.workdps(40):
            a, b, c, d = (mpmath.mpf(x) for x in (i + 0.5, i - 0.5, j + 0.5, j - 0.5))

            def corner(x, y):
                return x * mpmath.asinh(y / abs(x)) + y * mpmath.asinh(x / abs(y))

            exact = (corner(a, c) - corner(b, c) - corner(a, d) + corner(b, d)) / mpmath.pi
            worst = max(worst, abs(float(love(i, j, (1.0, 1.0), 1.0) / exact - 1)))
    assert worst < _LOVE < 1e-12
    offsets = np.linspace(-6.5, 6.5, 53)
    assert max(abs(_antiderivative(x, y)) for x in offsets for y in offsets) < 12


def test_waves_pass_through_the_points_and_their_curvature_is_bounded():
    heights = _heights(8)
    waves = Waves(heights, (1.0, 1.0))
    assert np.allclose(waves.at((8, 8), (0, 0)), heights, atol=1e-15)
    assert np.allclose(waves.at((24, 24), (0, 0)), surfaces.refine(heights, 3), atol=1e-15)
    bounds = waves.curvatures(4)
    rng = np.random.default_rng(0)
    for order, bound in zip(((2, 0), (1, 1), (0, 2)), bounds, strict=True):
        samples = [np.abs(waves.at((16, 16), shift, order)).max() for shift in rng.random((9, 2))]
        assert max(samples) <= bound
    sampled, highest = waves.highest(4)
    assert sampled <= surfaces.refine(heights, 64).max() <= highest


@pytest.mark.slow
def test_force_of_a_rough_patch_is_enclosed():
    heights = _heights(8)
    depth = 0.6 * np.ptp(heights)
    coarse, fine = (Patch(heights, 1.0, finer).force(depth, 3.0) for finer in (1, 2))
    # finer cells can do what coarse ones do: nested; the width is of first order at least
    assert coarse.lower < fine.lower < fine.upper < coarse.upper
    assert fine.width < 0.5 * coarse.width
    assert 3.0 * Patch(heights, 1.0, 4).on_grid(depth) in fine


@pytest.mark.slow
def test_energy_and_stiffness_of_a_rough_patch_are_enclosed():
    """A cell solver on four times as many cells lies inside, and so does what theorems relate.

    The energy is the integral of the force: between its sums from the left and from the right.
    """
    heights = _heights(8)
    patch, depth = Patch(heights, 1.0, 2), 0.6 * np.ptp(heights)
    exact = Interval(depth, depth)
    stored = patch.energy(exact, 3.0)
    assert stored.width < 0.6
    forces = [3.0 * patch.on_grid(share * depth) for share in (0.25, 0.5, 0.75, 1.0)]
    assert stored.lower < 0.25 * depth * sum(forces)
    assert stored.upper > 0.25 * depth * sum(forces[:3])
    pressed = patch.force(depth, 3.0)
    stiffness = patch.stiffness(exact, pressed, 3.0)
    rise = 3.0 * (patch.on_grid(1.01 * depth) - patch.on_grid(0.99 * depth)) / (0.02 * depth)
    assert rise in stiffness
    assert stiffness.width < 1
    # at a penetration that is only enclosed both are wider, and hold these
    about = Interval(0.97 * depth, 1.03 * depth)
    assert patch.energy(about, 3.0).lower < stored.lower < stored.upper
    given = Interval(pressed.middle, pressed.middle)
    assert patch.stiffness(about, given, 3.0).upper > stiffness.lower


def test_cells_where_nothing_can_touch_are_left_out():
    # d - g is positive on half a percent of a light touch's area: 4 cells per point suffice there
    heights = _heights(64)
    depth = 0.3 * heights.std()
    patch = Patch(heights, 1.0, 4)
    block = patch.block(depth)
    assert np.prod(block.shape) < 0.03 * np.prod(patch.grid)
    # the cells are those of a grid solver
    near = patch.top - surfaces.subdivide(heights, 4) < depth
    assert near.sum() == (block.centres < depth).sum()
    whole = np.sort(patch.top - surfaces.subdivide(heights, 4)[near])
    np.testing.assert_allclose(np.sort(block.centres[block.centres < depth]), whole, rtol=1e-9)


def test_a_flat_patch_is_a_square_punch():
    # k/(E* a) = 2 x 1.1523 for the half side a (the problem sheet), whatever the heights' level
    for level in (0.0, -3.0):
        pressed = Patch(np.full((4, 4), level), 2.0, 4).force(1e-3, 1.0)
        assert 2 * 1.1523e-3 in pressed
        assert pressed.width < 0.2


def test_less_than_a_cell_touches():
    # no cell proves a force from below, but an ellipse on the highest sample does; the force is
    # that of Hertz's theory with the surface's curvatures there, more or less
    heights = _heights(8)
    depth = 1e-5 * np.ptp(heights)
    patch = Patch(heights, 1.0, 1)
    block = patch.block(depth)
    assert force_below(block, depth) == 0.0
    pressed = patch.force(depth, 1.0)
    xx, _, yy = patch._waves.curvatures()
    # between its samples the surface may be higher than all of them, which is more than the depth
    most = 2 * (depth + block.above_samples)
    assert 4 / 3 * depth**1.5 / np.sqrt(max(xx, yy)) < pressed.lower < pressed.upper < most


@pytest.mark.slow
def test_a_touch_beneath_all_samples_has_an_upper_bound_above_the_lower_one():
    """The top is a sample, and the surface rises above it: it touches already at no depth."""
    pressed = Patch(_heights(8), 1.0, 4).force(1e-12, 1.0)
    assert 0 <= pressed.lower <= pressed.upper


def test_energies_of_cells_add_all_aliases():
    # at long waves they tend to the half-space's own 2/(E*|q|), and they exceed the displacement
    # in the cells' middles times the pressure at short ones
    transfer, remainder = cell_energies((64, 64), (1.0, 1.0), 2.0)
    smooth = periodic((64, 64), (1.0, 1.0), 2.0)
    assert transfer[1, 0] == pytest.approx(smooth[1, 0], rel=1e-3)
    assert (remainder <= 2e-4 * transfer.max()).all()
    # one cell alone against its potential's mean: the self-energy of the unit square, less that of
    # the images, is what all modes together store
    own = transfer[:, 1:-1].sum() * 2 + transfer[:, [0, -1]].sum()
    exact = 4 * (np.log(1 + np.sqrt(2)) + (1 - np.sqrt(2)) / 3) / (2 * np.pi)
    # images: Madelung's sum for the square lattice with a uniform background, 3.9 / L
    assert own / 64**2 == pytest.approx(exact - 3.900264920001956 / 64 / (2 * np.pi), rel=1e-4)


def _wave(points):
    """Heights of amplitude 0.01 along x."""
    return 0.01 * np.cos(2 * np.pi * np.arange(points) / points)[:, None] * np.ones(4)


@pytest.mark.slow
@pytest.mark.parametrize("share", [0.2, 0.7])
def test_westergaards_wave_is_enclosed(share):
    # Pi = p* D s^2 (3/4 - ln(s)/2), the integral of D s (1 - ln s) over the pressure
    wave = closed_form.Westergaard(0.01, 1.0, 1.0)
    mean = share * wave.full_contact_pressure
    surface = PeriodicSurface(_wave(8), (1.0, 0.5), 8)
    exact = wave.full_contact_pressure * 0.01 * share**2 * (0.75 - 0.5 * np.log(share))
    stored = surface.energy(mean, 1.0)
    assert exact in stored
    assert stored.width < 2e-2
    depth = surface.penetration(mean, 1.0)
    exact_depth = float(wave.penetration(mean))
    assert exact_depth in depth
    # U = P d - Pi, and dP/dd from d = D s (1 - ln s)
    given = Interval(mean, mean)
    elastic = mean * exact_depth - exact
    assert elastic in surface.stored(given, depth, 1.0)
    pressed = Interval(exact_depth, exact_depth)
    assert elastic in surface.stored(surface.mean_pressure(exact_depth, 1.0), pressed, 1.0)
    rise = wave.full_contact_pressure / (0.01 * -np.log(share))
    stiffness = surface.stiffness(given, 1.0)
    assert rise in stiffness
    assert stiffness.width < 0.8


def _sine_waves(points, rng):
    """Modes of a random trigonometric polynomial, none at half the sampling frequency."""
    modes = np.fft.rfft2(rng.standard_normal((points, points)), norm="forward")
    modes[points // 2] = modes[:, points // 2] = 0.0
    return modes


def test_a_trigonometric_polynomial_is_nowhere_below_the_bounds_of_its_cells():
    # waves down to two cells, the hardest there are: sampled 16 times finer none goes below
    rng = np.random.default_rng(5)
    points, finer = 12, 16
    modes = _sine_waves(points, rng)
    padded = np.zeros((finer * points, finer * points // 2 + 1), dtype=complex)
    padded[: points // 2, : points // 2 + 1] = modes[: points // 2]
    padded[-points // 2 :, : points // 2 + 1] = modes[points // 2 :]
    fine = np.fft.irfft2(padded, norm="forward")
    # cells lie about the points: roll half a cell so that their samples are neighbours
    moved = np.roll(fine, (finer // 2, finer // 2), axis=(0, 1))
    sampled = moved.reshape(points, finer, points, finer).min(axis=(1, 3))
    size = np.abs(fine).max()
    for ceiling in (-np.inf, np.inf):
        bound = least_on_cells(modes, (0.3, 0.3), (points, points), ceiling)
        assert (bound <= sampled).all()
    # the sharp one is close to the least sample, although a cell is half of the shortest wave
    assert (bound > sampled - 0.15 * size).all()


def test_bounds_of_the_energy_converge_with_the_cells():
    coarse, fine = (PeriodicSurface(_heights(8), (1.0, 1.0), n).energy(0.01, 1.0) for n in (4, 8))
    assert coarse.lower < fine.lower < fine.upper < coarse.upper
    assert fine.width < 0.5 * coarse.width


def test_a_pressure_that_pulls_stores_no_upper_bound():
    surface = PeriodicSurface(_heights(8), (1.0, 1.0), 2)
    pressure = np.full(surface.grid, 0.01)
    pressure[0, 0] = -1e-9
    with pytest.raises(ValueError, match="pressure must be at least 0"):
        surface.energy_of(pressure)


def test_the_deepest_place_of_a_cell_is_not_a_sampled_one():
    """One loaded cell sinks in most in its middle, between the middles of its sixteen squares."""
    patch = Patch(np.zeros((4, 4)), 1.0, 1)
    block = patch.block(1.0)
    pressure = np.zeros(block.shape)
    pressure[1, 2] = 1.0
    middle = float(_displacement(pressure, 0.0, 0.0, patch.spacing)[1, 2])
    squares = [float(u.value[1, 2]) for u in block.potential.expansions(pressure)]
    assert max(squares) < 0.995 * middle
    deepest, stored = block.deepest(pressure)
    assert deepest[1, 2] >= middle
    # nothing acts elsewhere, and nothing is asked there
    assert np.count_nonzero(deepest) == 1
    # <p, K p> of a square, in closed form: its sides to the third times that of the unit square
    exact = 4 * (np.log(1 + np.sqrt(2)) + (1 - np.sqrt(2)) / 3) / np.pi * patch.spacing**3
    assert exact < stored < 1.05 * exact


@pytest.mark.parametrize(
    "wrong",
    [
        lambda: Patch(np.zeros((4, 6)), 1.0),
        lambda: Patch(np.full((4, 4), np.nan), 1.0),
        lambda: Patch(_heights(8), -1.0),
        lambda: Patch(_heights(8), 1.0, 0),
        lambda: Patch(_heights(8), 1.0, 1).force(-1.0, 1.0),
        lambda: PeriodicSurface(_heights(8), (1.0, 1.0), 1).energy(0.0, 1.0),
        lambda: PeriodicSurface(np.full((4, 4), np.nan), (1.0, 1.0)),
        lambda: PeriodicSurface(np.zeros(4), (1.0, 1.0)),
        lambda: PeriodicSurface(_heights(8), (1.0, -1.0)),
        lambda: PeriodicSurface(_heights(8), (1.0, 1.0), 0),
    ],
)
def test_bad_input_is_refused(wrong):
    with pytest.raises(ValueError, match=r"\w+ \w+"):
        wrong()


def test_no_stiffness_is_proved_where_no_pressure_is():
    """As at a penetration of less than what the bounds resolve: its pressure is from 0 on."""
    surface = PeriodicSurface(_heights(8), (1.0, 1.0), 2)
    with pytest.raises(ArithmeticError, match="no stiffness is proved"):
        surface.stiffness(Interval(0.0, 1e-3), 1.0)
