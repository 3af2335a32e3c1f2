"""Films: closed forms of rigid bodies, conservation of mass, Hamrock & Dowson, rough balls."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.sparse.linalg import spsolve

from reference.errors import ConvergenceError
from reference.lubrication import formulas
from reference.lubrication.loaded import BentSurface, LoadedFilm
from reference.lubrication.point import Ball, approach, entrain, self_affine, waviness
from reference.lubrication.reynolds import (
    Film,
    FilmCells,
    FilmState,
    Transport,
    around_point,
    rigid_cylinder,
    rigid_film_at,
    stretched,
)

SOFT = Ball(radius=0.01, effective_modulus=1e6, viscosity=1.0, load=0.2)


def bowl(x, y):
    return x**2 + 0.7 * y**2


def random_state(cells, seed=0):
    """Full and empty cells at random, on a surface that is displacement at random."""
    rng = np.random.default_rng(seed)
    s = np.where(rng.random(cells.shape) < 0.5, rng.random(cells.shape), -rng.random(cells.shape))
    return FilmState(s, 0.5, rng.random(cells.shape))


@pytest.mark.parametrize("kind", ["entrained", "squeezed"])
def test_derivatives_are_those_of_the_balance(kind):
    """Newton's method: every derivative against a central difference."""
    cells = around_point(4, (-2.5, 1.5), 2.0, 8.0)
    film = Film(cells, bowl)
    state = random_state(cells)
    flow = Transport(0.8)
    if kind == "squeezed":
        past = tuple(FilmState(state.s, at, state.displacement) for at in (0.8, 1.3))
        flow = Transport(0.0, 0.8, past)
    slopes = flow.slopes(film, state)
    rng = np.random.default_rng(1)
    # small beside |s|, so that no cell ruptures
    ds, du, dl = 1e-6 * state.s, 1e-6 * rng.random(cells.shape), 1e-6
    for change, slope in (
        ((ds, 0.0, 0.0), slopes.s @ ds.ravel()),
        ((0.0, 0.0, du), slopes.displacement @ du.ravel()),
        ((0.0, dl, 0.0), slopes.separation * dl),
    ):
        sides = [
            FilmState(
                state.s + k * change[0],
                state.separation + k * change[1],
                state.displacement + k * change[2],
            )
            for k in (1, -1)
        ]
        by_difference = (flow.balance(film, sides[0]) - flow.balance(film, sides[1])) / 2
        # differences of 1e-6 lose half of the digits
        assert slope == pytest.approx(by_difference.ravel(), abs=1e-6 * np.abs(slope).max())


def test_next_cells_bend_as_on_the_half_space():
    """The preconditioner's surface: a pressure on one cell, with its image beyond the axis."""
    cells = around_point(3, (-2.0, 2.0), 2.0, 8.0)
    surface = BentSurface(cells, 1.3)
    rows, _ = cells.core
    for column in (0, 1, 3):
        p = np.zeros(cells.shape)
        p[rows.start + 4, column] = 1.0
        near = (surface.near @ p.ravel()).reshape(cells.shape)
        image = surface.respond(p)
        window = slice(rows.start + 3, rows.start + 6), slice(max(0, column - 1), column + 2)
        assert np.count_nonzero(near) == near[window].size
        exact = image[window]
        if column == 0:
            assert near[window][:, 0] == pytest.approx(exact[:, 0])  # with its image next to it
        else:
            assert (near[window] < exact).all()  # it is farther away, and left out


def test_rigid_cylinder_carries_and_ruptures_as_in_closed_form():
    """W = 4.895 eta U R/h0, ruptured at 0.475 sqrt(2 R h0), of second order in the cells."""
    films = {n: rigid_cylinder(n) for n in (16, 32, 64)}
    errors = [abs(film.load / formulas.CYLINDER - 1) for film in films.values()]
    assert errors[-1] < 1e-4
    assert errors[0] / errors[-1] > 8  # 16 by order two; where the film ruptures, cells jump
    # known to a part of a cell
    assert films[64].rupture == pytest.approx(0.4751299200930561, abs=0.3 / 64)


def test_half_of_sommerfelds_pressure_below_a_rigid_sphere():
    """W = 10.66 eta U R^1.5/h0^0.5: the half x < 0 alone, p = 0 at x = 0."""
    n, reach = 16, 4e3
    growth = 1.12
    x = stretched(-2.0, 0.0, 2 * n, (-reach, 0.0), growth)
    y = stretched(0.0, 2.0, 2 * n, (0.0, reach), growth)
    cells = FilmCells(x, y, (slice(0, x.size - 1), slice(0, y.size - 1)))
    film = Film(cells, lambda x, y: x**2 + y**2)
    full = FilmState(np.ones(cells.shape), 1.0, np.zeros(cells.shape))
    flow = Transport(1.0)
    # nothing ruptures: the equations are linear
    pressure = 1 - spsolve(flow.slopes(film, full).s.tocsc(), flow.balance(film, full).ravel())
    load = float(pressure @ cells.area.ravel()) * 12 / 0.5**1.5
    # the half-plane ends at 4000 sqrt(2 R h0), beyond which 3e-4 of the force lie
    assert load == pytest.approx(formulas.HALF_SOMMERFELD, rel=1e-3)


def test_a_rigid_ball_is_squeezed_as_in_closed_form():
    """The film is 6 pi eta R^2 V/F, the step by step march through lighter loads included."""
    film = approach(Ball(0.01, np.inf, 1.0, 0.1), 1e-5, 24)
    rigid = formulas.squeezed_film(0.01, 1.0, 1e-5, 0.1)
    assert film.film_minimum == pytest.approx(rigid, rel=1e-3)
    assert film.load == pytest.approx(0.1, rel=1e-9)
    assert not film.vapour.any()


def test_oil_from_a_meniscus_on_is_sheared_there_alone():
    """The friction of a large, starved ball is positive and less than of a flooded one."""
    flooded, starved = (
        entrain(Ball(1.0, 1e16, 1e-6, 1.0, meniscus=far), 10.0, 8) for far in (np.inf, 1e-3)
    )
    assert 0 < starved.shear < flooded.shear


@pytest.mark.slow
def test_a_soft_ball_rides_on_the_film_of_hamrock_and_dowson():
    """At the fastest speed of the fit, within what fits of computed films scatter."""
    fit = formulas.SoftFit(0.01, 1e6, 1.0, 0.2)
    fast = entrain(SOFT, 1e-3, 16)
    assert fit.covers(1e-3)
    # a power law through films on coarse grids of 1978: within a tenth, not to its exponents
    assert fast.film_central == pytest.approx(fit.central(1e-3), rel=0.1)
    assert fast.film_minimum == pytest.approx(fit.minimum(1e-3), rel=0.1)
    assert fast.load == pytest.approx(SOFT.load, rel=1e-9)
    assert fast.error < 1e-10
    # the constriction lies at the rear and the sides, the cavity behind
    x, y = fast.x / SOFT.hertz_radius, fast.y / SOFT.hertz_radius
    along, across = y.size // 2, np.abs(x).argmin()
    assert x[fast.thickness[:, along].argmin()] == pytest.approx(1, abs=0.1)
    assert abs(y[fast.thickness[across].argmin()]) == pytest.approx(1, abs=0.1)
    assert fast.vapour[x > 1.5, along].all()
    assert not fast.vapour[np.abs(x) < 0.9, along].any()


@pytest.mark.slow
def test_soft_films_go_as_the_three_fifths_power_of_speed():
    """From 10 to 1 mm/s: the exponent of the similarity theory, not Hamrock & Dowson's 0.64."""
    films = [entrain(SOFT, speed, 12).film_central for speed in (1e-2, 1e-3)]
    limits = [formulas.soft_limit(0.01, 1e6, 1.0, speed, 0.2) for speed in (1e-2, 1e-3)]
    assert np.log10(limits[0] / limits[1]) == pytest.approx(0.6)
    # twelve cells: 1 % at 10 mm/s, 3 % at 1 mm/s
    assert np.log10(films[0] / films[1]) == pytest.approx(0.6, abs=0.02)
    # oil that leaks sideways: below the film of a long cylinder
    assert all(0.88 < film / limit < 1 for film, limit in zip(films, limits, strict=True))


def cylinder_inlet(drawn, edges, p, separation):
    """Film in the middle of a long cylinder, R = E* = a = 1, by Newton's method on all pressures.

    Shares nothing with the cells of the suite: dense logarithmic kernel, complementarity p >= 0.
    """
    x, dx = (edges[1:] + edges[:-1]) / 2, np.diff(edges)
    n = x.size

    def part(z):
        return z * np.log(np.abs(z)) - z

    bend = -2 / np.pi * (part(x[:, None] - edges[:-1]) - part(x[:, None] - edges[1:]))
    inverse = 1 / np.diff(np.concatenate([edges[:1], x, edges[-1:]]))
    mean = (np.eye(n + 1, n) + np.eye(n + 1, n, -1)) / 2
    mean[0, 0] = mean[-1, -1] = 1
    step = np.eye(n + 1, n) - np.eye(n + 1, n, -1)
    for _ in range(40):
        h = mean @ (separation + x**2 / 2 + bend @ p)
        slope = drawn - 3 * h**2 * inverse * (step @ p)
        leaves = np.diff(drawn * h - h**3 * inverse * (step @ p))
        by_p = np.diff(slope[:, None] * (mean @ bend) - (h**3 * inverse)[:, None] * step, axis=0)
        size = np.abs(np.diag(by_p))
        empty = p <= leaves / size
        matrix = np.zeros((n + 1, n + 1))
        matrix[:n, :n] = np.where(empty[:, None], np.eye(n), by_p / size[:, None])
        matrix[:n, n] = np.where(empty, 0, np.diff(slope) / size)
        matrix[n, :n] = dx
        right = np.append(-np.where(empty, p, leaves / size), np.pi / 4 - dx @ p)
        change, share = np.linalg.solve(matrix, right), 1.0
        before = separation + x**2 / 2 + bend @ p
        while ((before + share * (change[n] + bend @ change[:n])) < 0.3 * before).any():
            share /= 2
        p, separation = p + share * change[:n], separation + share * change[n]
        if np.abs(change[:n]).max() < 1e-10 * p.max():
            break
    return p, separation, float(np.interp(0.0, x, separation + x**2 / 2 + bend @ p))


@pytest.mark.slow
def test_the_inlet_of_a_long_cylinder_has_the_film_of_the_soft_limit():
    """0.5122 (12 eta U)^0.6 E*^0.2 A^-0.8: the rest is of first order in the inlet's length."""
    rise = np.sqrt(0.5)  # of p = sqrt(1 - x^2)/2
    factors, inlets, before = [], [], None
    for drawn in 10.0 ** -np.arange(2, 6.1, 0.5):
        inlet = (drawn / rise**3) ** 0.4
        steps = [0.1 * min(inlet, 0.3)]
        while sum(steps) < 12:
            steps.append(steps[-1] * 1.04)
        far = np.cumsum(steps)
        near = np.append(0, far[far < 1] / far[far < 1][-1])
        edges = np.concatenate([-1 - far[::-1], near - 1, 1 - near[-2::-1], 1 + far])
        x = (edges[1:] + edges[:-1]) / 2
        film = drawn**0.6 * rise**-0.8
        if before is None:
            before = x, np.sqrt(np.maximum(0, 1 - x**2)) / 2, 0.5
        p = np.interp(x, *before[:2])
        p, separation, centre = cylinder_inlet(drawn, edges, p, before[2] + film)
        before = x, p, separation
        factors.append(centre / film)
        inlets.append(inlet)
    slope = (factors[-3] - factors[-1]) / (inlets[-3] - inlets[-1])
    assert factors[-1] - slope * inlets[-1] == pytest.approx(formulas.INLET, abs=2e-4)


def test_cells_that_rupture_or_heal_halt_at_zero_in_a_step():
    """A slope of p says nothing of theta: s = 1e5 from a cell that heals would be its pressure."""
    cells = around_point(4, (-2.5, 1.5), 2.0, 8.0)
    loaded = LoadedFilm(Film(cells, bowl), BentSurface(cells, 0.01))
    start = FilmState(np.full(cells.shape, -0.5), 1.0, np.zeros(cells.shape))
    start.s[:2] = 0.5
    wild = np.full(cells.shape, 1e5)
    wild[:2] = -3.0
    after = loaded._moved(Transport(1.0), start, wild, 0.0)
    assert np.abs(after.s).max() < 1e-300
    assert ((after.s > 0) != (start.s > 0)).all()


@pytest.mark.slow
def test_soft_film_is_of_second_order():
    """Differences between cells of h, h/2, h/4 fall by four."""
    films = [entrain(SOFT, 1e-2, n).film_central for n in (6, 12, 24)]
    assert (films[0] - films[1]) / (films[1] - films[2]) == pytest.approx(4, abs=1.5)


def test_a_stiff_ball_is_the_rigid_one():
    """Elastic and rigid half-space far above the speeds at which the contact is displacement."""
    stiff, rigid = (entrain(Ball(0.01, modulus, 1e-3, 0.1), 1.0, 8) for modulus in (1e16, np.inf))
    assert stiff.film_minimum == pytest.approx(rigid.film_minimum, rel=1e-3)
    # cavitation as it is carries a little more than half of Sommerfeld's pressure
    half = formulas.sphere_film(0.01, 1e-3, 1.0, 0.1)
    assert half < rigid.film_minimum < 1.3 * half


@pytest.mark.slow
def test_a_starved_ball_rides_lower():
    """The nearer the oil begins, the less film; far away it is a bath."""
    full = entrain(SOFT, 1e-2, 8).film_central
    distances = [1.2, 2.0, 5.0]
    films = [
        entrain(Ball(0.01, 1e6, 1.0, 0.2, meniscus=far * SOFT.hertz_radius), 1e-2, 8).film_central
        for far in distances
    ]
    assert films[0] < films[1] < films[2]
    assert films[0] < 0.9 * full
    assert films[2] == pytest.approx(full, rel=0.02)


def test_every_cell_keeps_its_oil_below_a_soft_ball():
    """Out of a cell flows 1e-10 of what surfaces carry through it, pressure's flow left out."""
    cells = around_point(8, (-2.5, 1.5), 2.0, 20.0)
    loaded = LoadedFilm(Film(cells, bowl), BentSurface(cells, 0.01))
    start = rigid_film_at(loaded.film, 1.0)
    flow = Transport(1 / float((start.pressure * cells.area).sum()))
    state = loaded.solve(flow, start)
    balance = flow.balance(loaded.film, state)
    assert (state.vapour > 0).any()
    assert np.abs(balance / flow.carried(loaded.film, state)).max() < 1e-10


def test_stagnation_is_not_called_a_thin_film():
    """Asked for more than round-off allows, Newton's method says so."""
    cells = around_point(4, (-2.5, 1.5), 2.0, 8.0)
    loaded = LoadedFilm(Film(cells, bowl), BentSurface(cells, 0.01))
    start = rigid_film_at(loaded.film, 1.0)
    carried = float((start.pressure * cells.area).sum())
    with pytest.raises(ConvergenceError, match="stagnates at round-off"):
        loaded.solve(Transport(1 / carried), start, tolerance=0.0)


def test_a_solver_that_starts_beside_itself_gives_up():
    """Negative films: an error with a finite reason, never NaN."""
    cells = around_point(4, (-2.5, 1.5), 2.0, 8.0)
    loaded = LoadedFilm(Film(cells, bowl), BentSurface(cells, 1.0))
    wild = FilmState(np.ones(cells.shape), -100.0, np.zeros(cells.shape))
    with pytest.raises(ConvergenceError) as caught:
        loaded.solve(Transport(1.0), wild)
    assert caught.value.history


LONG = 1e-3


@pytest.mark.slow
def test_the_film_of_a_ball_hardly_rough_is_the_smooth_one_and_keeps_its_mass():
    """Of second order in the waves but for the middle itself; mass in every cell to 1e-10."""
    smooth = entrain(SOFT, 1e-2, 10)
    for rms in (1e-12, 2e-7):
        waves = self_affine(rms, 0.8, 2e-3, 1e-3, seed=1)
        film = entrain(replace(SOFT, waves=waves), 1e-2, 10)
        assert film.error < 1e-10
        assert film.load == pytest.approx(SOFT.load, rel=1e-9)
        assert film.film_central == pytest.approx(smooth.film_central, abs=3 * rms + 1e-12)
        assert film.film_minimum == pytest.approx(smooth.film_minimum, abs=3 * rms + 1e-12)


@pytest.mark.slow
def test_half_of_an_even_film_is_the_whole():
    """A wave along the flow is even in y; the same cells without the mirror give the same film."""
    even = waviness(5e-7, LONG, "along")
    odd = replace(even, along=np.array([1e-9 / LONG]))
    films = [entrain(replace(SOFT, waves=waves), 1e-2, 8) for waves in (even, odd)]
    assert even.even
    assert not odd.even
    assert films[0].film_minimum == pytest.approx(films[1].film_minimum, rel=1e-6)
    assert films[0].thickness.shape == films[1].thickness.shape


def test_heights_have_the_rms_that_is_asked_for_and_waves_need_cells():
    """The mean square of many points; six cells per wave."""
    waves = self_affine(3e-7, 0.8, 2e-3, 2.5e-4, seed=2)
    x = np.linspace(0, 2e-3, 64, endpoint=False)
    assert np.sqrt((waves.at(x, x) ** 2).mean()) == pytest.approx(3e-7, rel=1e-9)
    with pytest.raises(ValueError, match="need 6 cells"):
        entrain(replace(SOFT, waves=waves), 1e-2, 16)


def test_the_shortest_wave_is_there_in_every_unit():
    """75e-6 over 25e-6 is 2.9999999999999996."""
    one = self_affine(1.0, 0.8, 75.0, 25.0, seed=1)
    other = self_affine(1e-6, 0.8, 75e-6, 25e-6, seed=1)
    assert other.shortest == pytest.approx(25e-6)
    np.testing.assert_allclose(other.heights / 1e-6, one.heights, rtol=1e-12)


def test_crests_higher_than_any_film_are_a_lost_film_never_nan():
    high = replace(SOFT, waves=waviness(1e-3, LONG))
    with pytest.raises(ConvergenceError, match="too thin for its cells") as caught:
        entrain(high, 1e-2, 8)
    assert np.isfinite(caught.value.history).all()
