"""Sliding friction of rubber on a line, Problem 1: steady state, time loop, and the print."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from numpy.testing import assert_allclose

from reduced.errors import ConvergenceError
from reduced.loads import Load, LoadPath
from reduced.memory.materials import kelvin_voigt, prony, standard_solid
from reduced.rough.ensemble import RandomLines
from reduced.rough.line_spectrum import prescribed
from reduced.rough.press import RoughLines, press
from reduced.rough.surface_spectrum import SelfAffineLaw
from reduced.rubber.history import slide_as_printed, slide_in_time
from reduced.rubber.steady import slide

KELVIN = kelvin_voigt(1.0, 1.0)
MATERIALS = {
    "Kelvin-Voigt": KELVIN,
    "standard": standard_solid(1.0, 100.0, relaxation_time=0.01),
    "three arms": prony(1.0, [3.0, 10.0, 5.0], [1.0, 0.1, 0.01]),
    "three arms and a dashpot": prony(1.0, [3.0, 10.0, 5.0], [1.0, 0.1, 0.01], viscosity=0.02),
}


def rough(points=512, count=1, slope=0.1):
    """Band-limited lines: 16 waves at most."""
    spectrum = prescribed(64, 1.0, SelfAffineLaw(hurst=0.8, rms_slope=slope, short_cutoff=1 / 16))
    return RandomLines(spectrum, points, count, seed=3).draw().heights


def steady(lines, material, speed, force):
    return slide(RoughLines(lines, 1 / lines.shape[-1]), material, speed, LoadPath("force", force))


def in_time(lines, speed, load, material=KELVIN, **steps):
    """Slide lines of unit length step by step."""
    return slide_in_time(RoughLines(lines, 1 / lines.shape[-1]), material, speed, load, **steps)


def printed(line, speed, steps=2048, **more):
    """Slide a line of 512 points under 1e-2 as printed."""
    return slide_as_printed(RoughLines(line, 1 / 512), KELVIN, speed, 1e-2, steps=steps, **more)


def parabola(depth, length, radius=1.0):
    """Force and friction of h = -x^2/R under Kelvin-Voigt springs of G = 1.

    In contact from -sqrt(R d) to where f = 4 (w + l dh/dx) ends, -l + sqrt(l^2 + R d); the 1-D
    equivalent of a paraboloid of radius R.
    """
    begin = -np.sqrt(radius * depth)
    end = radius * depth / (length + np.sqrt(length**2 + radius * depth))

    def force(x):
        return depth * x - x**3 / (3 * radius) - length * x**2 / radius

    def friction(x):
        moment = depth * x**2 / 2 - x**4 / (4 * radius) - 2 * length * x**3 / (3 * radius)
        return -2 / radius * moment

    return 4 * (force(end) - force(begin)), 4 * (friction(end) - friction(begin))


@pytest.mark.parametrize("length", [1e-6, 1e-3, 0.1, 1.0, 100.0])
def test_parabola_on_kelvin_voigt_springs_as_in_closed_form(length):
    """Order 2 in dx: only the line between its points is approximated."""
    force, drag = parabola(0.01, length)
    errors = []
    for points in (201, 401, 801):
        x = np.linspace(-0.1537, 0.1483, points)
        sliding = slide(
            RoughLines(-(x**2), x[1] - x[0], periodic=False),
            KELVIN,
            length,
            LoadPath("force", force),
        )
        errors.append(
            max(
                abs(sliding.tangential_force.item() / drag - 1),
                abs(sliding.penetration.item() / 0.01 - 1),
            )
        )
    assert errors[-1] < 2e-5
    assert errors[0] / errors[-1] > 16 * 0.5


@pytest.mark.parametrize("name", MATERIALS)
@pytest.mark.parametrize("speed", [1e-3, 0.1, 10.0])
def test_full_contact_with_a_sine_follows_the_complex_modulus(name, speed):
    """F_x/L = 4 G''(q v) q D^2/2 and F/L = 4 G_inf <w>, the arms carry nothing in the mean."""
    material, amplitude, q, points = MATERIALS[name], 0.01, 2 * np.pi, 2000
    line = amplitude * np.cos(q * np.arange(points) / points)
    # deep enough for full contact at any phase of the force
    force = 4 * amplitude * 2 * abs(material.complex_modulus(q * speed))
    sliding = steady(line, material, speed, force)
    loss = material.complex_modulus(q * speed).imag
    assert_allclose(sliding.contact_length, 1.0, rtol=1e-12)
    # the polygon's sine is (q dx)^2/12 = 1e-6 too small, its slope twice
    assert_allclose(sliding.tangential_force, 2 * loss * q * amplitude**2, rtol=4e-6)
    assert_allclose(sliding.force, force, rtol=1e-11)


def drawn_in_small_steps(line, spacing, material, speed, depth, factor):
    """Force and friction of one spring per cell, backward Euler in small steps: an independent way.

    Strains and arms at the end of each step; the spring is free where its force would pull.
    """
    n = line.size
    fine = np.interp(np.arange(n * factor + 1) / factor, np.arange(n + 1), np.append(line, line[0]))
    g = fine - line.max() + depth
    dt = spacing / factor / speed
    keep = 1 / (1 + dt / material.times)
    glassy = material.long_term + (material.moduli * keep).sum() + material.viscosity / dt
    w, q = 0.0, np.zeros(material.times.size)
    for _ in range(8):
        total = drag = 0.0
        for i in range(g.size - 1):
            pull = (material.moduli * keep) @ q + material.viscosity / dt * w
            new = max(g[i + 1], pull / glassy)
            f = 4 * (glassy * new - pull) if new == g[i + 1] else 0.0
            total += f * spacing / factor
            drag += f * (g[i + 1] - g[i])
            q, w = keep * q + (1 - keep) * new, new
    return total, drag


@pytest.mark.parametrize("name", MATERIALS)
def test_steady_state_is_that_of_a_spring_in_small_steps(name):
    """Backward Euler errs by O(dt): halving the step halves the difference."""
    material, line, speed = MATERIALS[name], rough(96)[0], 0.3
    depth = 0.4 * np.ptp(line)
    differences = []
    for factor in (10, 20):
        force, drag = drawn_in_small_steps(line, 1 / 96, material, speed, depth, factor)
        sliding = steady(line, material, speed, force)
        differences.append(abs(sliding.penetration.item() / depth - 1))
        assert_allclose(sliding.friction_coefficient, drag / force, rtol=0.6 / factor)
    assert differences[0] < 0.02
    assert 1.6 < differences[0] / differences[1] < 2.5


@settings(max_examples=12, deadline=None)
@given(
    speed=st.floats(-6, 3).map(lambda x: 10.0**x),
    load=st.floats(-4, -1).map(lambda x: 10.0**x),
    name=st.sampled_from(sorted(MATERIALS)),
    seed=st.integers(0, 50),
)
def test_friction_does_the_work_that_is_dissipated(speed, load, name, seed):
    """Over a period, to 1e-8 (the issue asks for 1e-6); and the force is met."""
    line = 0.01 * np.random.default_rng(seed).normal(size=64)
    sliding = steady(line, MATERIALS[name], speed, load)
    assert abs(sliding.energy_error.item()) < 1e-8
    assert_allclose(sliding.force, load, rtol=1e-9)
    assert sliding.friction_coefficient.item() > 0


def test_a_line_pressed_at_rest_is_the_limit_of_slow_sliding():
    line, force = rough(), [1e-2]
    still = press(RoughLines(line, 1 / 512), 4.0, Load("force", force))
    slow = steady(line, KELVIN, 1e-9, force)
    assert_allclose(slow.penetration, still.penetration, rtol=1e-6)
    assert_allclose(slow.contact_area, still.contact_area, rtol=1e-5)
    assert_allclose(slow.contact_count, still.contact_count)


@pytest.mark.parametrize("relaxation", [1e-3, 0.1, 3.0, 30.0])
def test_the_time_loop_ends_in_the_steady_state(relaxation):
    """From v tau = dx/1000 (slow sliding) to 30 dx; the force is met in every step."""
    heights, points, load = rough(256, 3), 256, 1e-2
    speed = relaxation / points
    history = in_time(heights, speed, load, steps=3 * points)
    end = steady(heights, KELVIN, speed, load)
    assert_allclose(history.force, load, rtol=1e-11)
    assert_allclose(history.friction_coefficient(), end.friction_coefficient[:, 0], rtol=2e-8)
    assert_allclose(heights.max(axis=1) - history.level[:, -1], end.penetration[:, 0], rtol=1e-9)
    assert np.abs(history.energy_error()).max() < 1e-6


@pytest.mark.parametrize("cells", [0.37, 2.6])
def test_steps_of_any_length_tend_to_the_same_friction(cells):
    """Within a cell the level follows few springs; the difference goes down with dx."""
    differences = []
    for points in (128, 512):
        heights, speed = rough(points, 2), 0.01
        steps = {"steps": int(3 * points / cells), "step_length": cells / points}
        history = in_time(heights, speed, 1e-2, **steps)
        exact = steady(heights, KELVIN, speed, 1e-2).friction_coefficient[:, 0]
        differences.append(np.abs(history.friction_coefficient() / exact - 1).max())
        assert_allclose(history.force, 1e-2, rtol=1e-11)
    assert differences[1] < 0.02
    assert differences[1] < max(differences[0] / 2, 1e-4)


def test_the_force_is_met_where_the_springs_lose_the_line():
    """Fast and light: a crest rushes away from springs that have not relaxed yet.

    The contact is 1e-12 of a cell long, so places rounded to 1e-16 leave 1e-4 of the force.
    """
    line = np.zeros(64)
    line[10] = 1.0
    history = in_time(line, 50.0, 1e-7, kelvin_voigt(1.0, 100.0), steps=256)
    assert_allclose(history.force, 1e-7, rtol=1e-3)
    assert history.contact_count.min() == 0  # no spring in contact at the end of some steps


def test_an_energy_balance_needs_a_whole_period():
    history = in_time(rough(64), 1.0, 1e-2, steps=200, step_length=0.3 / 64)
    with pytest.raises(ValueError, match="whole cells"):
        history.energy_error()


def at_rest(line, load):
    """Level of the relaxed springs under the load, to begin a printed run in contact."""
    contact = press(RoughLines(line, 1 / line.size), 4.0, Load("force", [load]), edges="nodal")
    return line.max() - contact.penetration.item()


def test_printed_start_touches_nothing_on_a_line_below_three_rms():
    line = rough()[0]
    assert line.max() < 3 * line.std()
    sliding = printed(line, 0.1, steps=10)
    assert sliding.outcome == "no contact"
    assert sliding.level.size == 0
    with pytest.raises(ConvergenceError, match="no contact"):
        sliding.friction_coefficient()


def test_printed_scheme_is_slow_slidings_worst():
    """Far below its limit it diverges, and says so in place of a number."""
    line = rough()[0]
    run = printed(line, 1 / (512 * 1000), level=at_rest(line, 1e-2))
    assert run.outcome == "diverged"
    assert np.all(np.isfinite(run.tangential_force))
