"""Rough lines on springs: a naive oracle, exact inversion, invariants."""

from fractions import Fraction
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reduced.loads import Load
from reduced.rough.press import RoughLines, press

EDGES = ["sub_cell", "nodal"]


MODULUS = 2.0


def naive(line, spacing, d, edges, periodic):
    """F/E*, contact lengths, mean gap and energy/E* of one line at one load, by plain sums.

    Sub-cell: every cell between neighbours is cut where the straight line meets the surface; a free
    line has half a flat cell at each end. Nodal: whole springs.
    """
    z = line.max() - d
    n = line.size
    pairs = [(i, (i + 1) % n) for i in range(n if periodic else n - 1)]
    force = energy = 0.0
    pieces = []  # (start, end) of contact, in cells; point i at position i + 1/2
    if edges == "nodal":
        inside = line > z
        force = np.sum((line - z)[inside])
        energy = np.sum((line - z)[inside] ** 2) / 2
        pieces = [(float(i), i + 1.0) for i in np.flatnonzero(inside)]
    else:
        for i, j in pairs:
            p, q = line[i] - z, line[j] - z
            start, end = 0.0, 1.0
            if p <= 0 and q <= 0:
                continue
            if p <= 0:
                start, p = -p / (q - p), 0.0
            elif q <= 0:
                end, q = p / (p - q), 0.0
            force += (p + q) / 2 * (end - start)
            energy += (p * p + p * q + q * q) / 6 * (end - start)
            pieces.append((i + 0.5 + start, i + 0.5 + end))
        if not periodic:
            for point, piece in ((line[0], (0.0, 0.5)), (line[-1], (n - 0.5, n))):
                if point > z:
                    force += (point - z) / 2
                    energy += (point - z) ** 2 / 4
                    pieces.append(piece)
    lengths = joined(sorted(pieces), n, periodic)
    gap = z - line.mean() + force / n
    return force * spacing, np.array(lengths) * spacing, gap, energy * spacing


def joined(pieces, n, periodic):
    """Lengths of the unions of touching pieces, across the seam of a periodic line too."""
    runs = []
    for start, end in pieces:
        if runs and abs(runs[-1][1] - start) < 1e-9:
            runs[-1][1] = end
        else:
            runs.append([start, end])
    if periodic and len(runs) > 1 and abs(runs[-1][1] - n - runs[0][0]) < 1e-9:
        runs[0][0] = runs.pop()[0] - n
    return [end - start for start, end in runs]


def pressed(line, spacing, load, edges, periodic):
    return press(RoughLines(line, spacing, periodic=periodic), 1.0, load, edges=edges)


def assert_naive_sums(contact, row, line, spacing, edges, periodic):
    modulus = MODULUS
    for k, d in enumerate(contact.penetration[row]):
        force, lengths, gap, energy = naive(line, spacing, d, edges, periodic)
        scale = np.ptp(line) + d
        tolerance = {"rtol": 1e-11, "atol": 1e-13 * scale * spacing * line.size * modulus}
        np.testing.assert_allclose(contact.force[row, k], modulus * force, **tolerance)
        np.testing.assert_allclose(contact.contact_length[row, k], lengths.sum(), rtol=1e-11)
        area = np.pi / 4 * np.sum(lengths**2)
        np.testing.assert_allclose(contact.contact_area[row, k], area, rtol=1e-11)
        assert contact.contact_count[row, k] == lengths.size
        np.testing.assert_allclose(contact.mean_gap[row, k], gap, rtol=1e-10, atol=1e-13 * scale)
        energy_scale = 1e-13 * scale**2 * spacing * line.size * modulus
        np.testing.assert_allclose(
            contact.energy[row, k], modulus * energy, rtol=1e-10, atol=energy_scale
        )
        np.testing.assert_allclose(contact.stiffness[row, k], modulus * lengths.sum(), rtol=1e-11)


LINES = st.lists(st.integers(-40, 40), min_size=2, max_size=40).filter(lambda v: len(set(v)) > 1)


@pytest.mark.slow
@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("periodic", [True, False])
@settings(max_examples=80, deadline=None)
@given(values=LINES, seed=st.integers(0, 1000))
def test_all_loads_equal_the_naive_sums(edges, periodic, values, seed):
    """Lines with many equal heights (flats, ties) and loads up to full contact.

    Levels are kept off the heights themselves, where a merely touching point may or may not join
    two contacts.
    """
    line = np.array(values, dtype=float)
    rng = np.random.default_rng(seed)
    d = np.unique(rng.integers(0, int(np.ptp(line)) + 3, 9)) + rng.uniform(0.1, 0.9)
    contact = press(
        RoughLines(line, 0.3, periodic=periodic), MODULUS, Load("penetration", d), edges=edges
    )
    assert_naive_sums(contact, 0, line, 0.3, edges, periodic)


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("control", ["force", "mean_gap"])
@settings(max_examples=25, deadline=None)
@given(values=LINES, seed=st.integers(0, 1000))
def test_force_and_gap_control_invert_the_discrete_law(control, edges, periodic, values, seed):
    """Loads come back from the naive sums at the penetrations found."""
    rng = np.random.default_rng(seed)
    line = np.array(values, dtype=float) + rng.uniform(0, 0.9, len(values))
    depth = line.max() - line.mean()
    top = 3 * np.ptp(line) * line.size if control == "force" else 0.999 * depth
    loads = np.sort(top * rng.uniform(0, 1, 6) ** 3 + 1e-6 * top)
    contact = pressed(line, 1.0, Load(control, loads), edges, periodic)
    for k, d in enumerate(contact.penetration[0]):
        force, _, gap, _ = naive(line, 1.0, d, edges, periodic)
        result, scale = (force, depth * line.size) if control == "force" else (gap, depth)
        assert result == pytest.approx(loads[k], rel=1e-11, abs=1e-13 * scale)
    np.testing.assert_array_equal(getattr(contact, control)[0], loads)


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("points", [30, 1500])
def test_mean_gaps_keep_their_digits_up_to_full_contact(edges, periodic, points):
    """Gaps down to 1e-12 of the line's depth: what is open is the force of the line turned over.

    The distance from full contact is a difference of two lengths near 1, so known to 1e-16; it is
    1e-6 at the smallest gap, which grows as its square: nine digits.
    """
    line = np.random.default_rng(8).normal(size=points)
    goals = (line.max() - line.mean()) * np.geomspace(1e-12, 1e-1, 12)
    d = pressed(line, 1.0, Load("mean_gap", goals), edges, periodic).penetration[0]
    turned, depth = RoughLines(-line, 1.0, periodic), Load("penetration", np.ptp(line) - d)
    # Nodal gaps are those of one spring at last, linear in that distance.
    rounding = np.spacing(np.ptp(line))
    result = press(turned, 1.0, depth, edges=edges).force[0] / points
    np.testing.assert_allclose(result, goals, rtol=1e-9, atol=rounding)


@pytest.mark.parametrize("periodic", [True, False])
def test_slopes_apart_by_orders_of_magnitude_lose_no_digits(periodic):
    """Heights spread over sixteen decades and pairs that nearly agree: exact rational sums."""
    rng = np.random.default_rng(9)
    for line in (rng.lognormal(0, 6, 40), 1 + 1e-12 * rng.normal(size=40), rng.normal(size=40)):
        line[10:20:2] = line[11:21:2] * (1 + 1e-13)
        goals = np.ptp(line) * np.geomspace(1e-9, 40, 12)
        d = press(RoughLines(line, 1.0, periodic), 1.0, Load("force", goals)).penetration[0]
        exact = [rational_force(line, part, periodic) for part in d]
        np.testing.assert_allclose([float(f) for f in exact], goals, rtol=2e-14)


def rational_force(line, d, periodic):
    """F/E* of straight lines between the points, in exact arithmetic on the depths as stored."""
    y = [Fraction(part) for part in (line.max() - line)]
    d, total = Fraction(float(d)), Fraction(0)
    cells = list(pairwise(y)) + ([(y[-1], y[0])] if periodic else [])
    for low, high in map(sorted, cells):
        if high < d:
            total += d - (low + high) / 2
        elif low < d:
            total += (d - low) ** 2 / (2 * (high - low))
    ends = [] if periodic else [y[0], y[-1]]
    return total + sum(max(d - part, Fraction(0)) / 2 for part in ends)


def rough(n, rng, lines=1):
    """Self-affine lines with amplitudes falling as k^-1.3."""
    k = np.arange(1, n // 4)
    spectrum = np.zeros((lines, n // 2 + 1), dtype=complex)
    spectrum[:, k] = k**-1.3 * np.exp(2j * np.pi * rng.uniform(size=(lines, k.size)))
    return np.fft.irfft(spectrum, n=n, axis=-1, norm="forward")


@pytest.mark.parametrize("edges", EDGES)
@pytest.mark.parametrize("periodic", [True, False])
@pytest.mark.parametrize("points", [512, 1500])
def test_ensemble_equals_line_by_line(points, periodic, edges):
    """Ordered heights up to 1024 points, a ladder of levels beyond."""
    lines = rough(points, np.random.default_rng(1), 3)
    force = np.geomspace(1e-3, 10, 20)
    together, *alone = (
        press(RoughLines(part, 0.1, periodic=periodic), MODULUS, Load("force", force), edges=edges)
        for part in (lines, *lines)
    )
    assert together.contact_area.shape == (3, 20)
    for row, line in enumerate(lines):
        np.testing.assert_array_equal(alone[row].contact_area[0], together.contact_area[row])
        assert_naive_sums(together, row, line, 0.1, edges, periodic)


@pytest.mark.parametrize("control", ["force", "penetration", "mean_gap"])
def test_threads_change_no_bit(control):
    """Lines are independent; blocks of 2^15 points, here 5, are shared by up to 4 threads."""
    lines = rough(256, np.random.default_rng(3), 600)
    loads = np.geomspace(1e-2, 0.5, 6)
    one, many = (
        press(RoughLines(lines, 1.0), 1.0, Load(control, loads), threads=t) for t in (1, 4)
    )
    for name in vars(one):
        np.testing.assert_array_equal(getattr(one, name), getattr(many, name))


@pytest.mark.parametrize("edges", EDGES)
def test_a_flat_line_is_a_punch(edges):
    """Equal heights: F = E* L d, one contact, at every load."""
    for periodic in (True, False):
        c = press(
            RoughLines(np.full(9, 4.0), 0.5, periodic=periodic),
            3.0,
            Load("force", [0.1, 2.0]),
            edges=edges,
        )
        np.testing.assert_allclose(c.penetration[0], np.array([0.1, 2.0]) / (3.0 * 4.5), rtol=1e-14)
        np.testing.assert_array_equal(c.contact_length[0], 4.5)
        np.testing.assert_array_equal(c.contact_count[0], 1)


def test_a_gap_wider_than_at_first_touch_is_no_contact():
    line = np.array([0.0, 1.0, 0.0, -1.0])
    c = press(RoughLines(line, 1.0), 1.0, Load("mean_gap", [0.5, 1.5]))
    assert c.force[0, 0] > 0
    assert c.penetration[0, 1] == pytest.approx(-0.5)
    assert (c.force[0, 1], c.contact_area[0, 1], c.contact_count[0, 1]) == (0.0, 0.0, 0)


def test_a_load_beyond_floating_point_leaves_the_others_alone():
    """An energy of 1e400 is inf; the loads before it are those of a list without it."""
    line = rough(128, np.random.default_rng(5))[0]
    usual = press(RoughLines(line, 1.0), 1.0, Load("force", [0.1, 1.0]))
    absurd = press(RoughLines(line, 1.0), 1.0, Load("force", [0.1, 1.0, 1e200]))
    assert absurd.energy[0, 2] == np.inf
    for name, values in vars(usual).items():
        np.testing.assert_allclose(getattr(absurd, name)[:, :2], values, rtol=1e-12, err_msg=name)
