"""Dense and FFT solvers against each other, and what must hold for any contact."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter

from reference.contact.press import CONTROLS, press, sweep
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator, PeriodicOperator, areas
from reference.loads import Load


def smooth_gap(shape: tuple[int, int], seed: int):
    height = gaussian_filter(np.random.default_rng(seed).standard_normal(shape), 1.5, mode="wrap")
    return height.max() - height


@pytest.mark.parametrize("operator_class", [FreeOperator, PeriodicOperator])
@pytest.mark.parametrize("fraction", [0.9, 0.3, 1e-2, 1e-4])
def test_mean_gap_control_gives_the_mean_gap(operator_class, fraction):
    """Down to nearly full contact, where a uniform pressure costs almost no energy (periodic).

    Sixty iterations are plenty with the zero mode of the preconditioner matched to the contact, and
    ten times too few without.
    """
    gap = smooth_gap((48, 48), 3)
    operator = operator_class((48, 48), (1.0, 1.0), 1.0)
    wanted = fraction * gap.mean()
    contact = press(operator, gap, Load("mean_gap", wanted), max_iterations=60)
    clearance = gap - contact.penetration + operator.apply(contact.pressure)
    assert contact.mean_gap == pytest.approx(clearance.mean(), rel=1e-9)
    assert abs(contact.mean_gap - wanted) <= 2e-8 * contact.penetration


@pytest.mark.parametrize(
    ("by", "operator_class"),
    [("pivot", FreeOperator), ("descent", FreeOperator), ("descent", PeriodicOperator)],
)
@pytest.mark.parametrize("control", ["penetration", "force"])
def test_sweeps_equal_single_solves(by, operator_class, control):
    """A warm start changes the way to the solution, not the solution: the energy is convex."""
    operator = operator_class((24, 20), (1.0, 1.2), 1.0)
    gap = smooth_gap((24, 20), 6)
    loads = np.linspace(0.05, 0.9, 7) * (1.0 if control == "force" else gap.mean())
    for load, swept in zip(loads, sweep(operator, gap, Load(control, loads), by=by), strict=True):
        single = press(operator, gap, Load(control, load), by=by)
        assert swept.force == pytest.approx(single.force, rel=1e-6)
        assert swept.penetration == pytest.approx(single.penetration, rel=1e-6)
        np.testing.assert_allclose(
            swept.pressure, single.pressure, atol=1e-5 * single.pressure.max()
        )


@pytest.mark.parametrize("operator_class", [FreeOperator, PeriodicOperator])
def test_a_solution_is_its_own_best_start(operator_class):
    operator = operator_class((40, 40), (1.0, 1.0), 1.0)
    gap = smooth_gap((40, 40), 7)
    first = press(operator, gap, Load("force", 3.0))
    again = press(operator, gap, Load("force", 3.0), start=first)
    assert first.iterations > 5
    assert again.iterations <= 2
    with pytest.raises(ValueError, match=r"start has shape \(40, 40\)"):
        press(operator_class((4, 4), (1.0, 1.0), 1.0), gap[:4, :4], Load("force", 1.0), start=first)


def test_force_control_widens_a_window_that_was_too_small():
    """A small tip on a wide plateau: the depth estimated from the overlap misses the plateau.

    The window has to grow until all cells below the depth found are inside.
    """
    gap = np.full((40, 40), 1.0)
    gap[5, 5] = 0.0
    gap[30:, 30:] = 1e-3
    operator = FreeOperator((40, 40), (1.0, 1.0), 1.0)
    for force in (1e-3, 1e-2, 10.0, 100.0):
        contact = press(operator, gap, Load("force", force), tolerance=1e-11)
        exact = press(operator, gap, Load("force", force), by="pivot")
        assert contact.penetration == pytest.approx(exact.penetration, rel=1e-9)
        assert contact.violation <= 1e-11


def test_force_is_the_derivative_of_the_elastic_energy():
    """dU/dd = F (Castigliano); central difference of U, exact to O(step^2)."""
    operator = FreeOperator((32, 32), (1.0, 1.0), 1.0)
    gap = smooth_gap((32, 32), 10)
    low, middle, high = sweep(operator, gap, Load("penetration", [0.499, 0.5, 0.501]), by="pivot")
    energies = [areas.elastic_energy(operator, contact.pressure) for contact in (low, high)]
    assert (energies[1] - energies[0]) / 0.002 == pytest.approx(middle.force, rel=1e-5)


@pytest.mark.parametrize("operator_class", [FreeOperator, PeriodicOperator])
@pytest.mark.parametrize("offset", [4.5e-3, 1e12])
def test_depths_count_from_the_first_touch_of_a_cell(operator_class, offset):
    """A shape that starts above the surface: the same pressures, forces as small as one likes.

    At 1e12 the gaps themselves are rounded to 1e-4. A force of 1e-300 moves less than the
    round-off of the distance, and is carried nevertheless, by the lowest cell.
    """
    operator = operator_class((16, 16), (1.0, 1.0), 1.0)
    gap = smooth_gap((16, 16), 5) + offset
    at_touch = gap - gap.min()
    for by in CONTROLS if operator_class is FreeOperator else ["descent"]:
        near = press(operator, at_touch, Load("force", 1.0), by=by)
        far = press(operator, gap, Load("force", 1.0), by=by)
        np.testing.assert_array_equal(far.pressure, near.pressure)
        assert far.penetration == pytest.approx(near.penetration + gap.min(), rel=1e-14)
        light = next(sweep(operator, gap, Load("force", [1e-300]), by=by))
        assert light.force == pytest.approx(1e-300, rel=1e-12)
        assert light.mask.sum() == np.sum(at_touch == 0)
        (deep,) = sweep(operator, gap, Load("penetration", [near.penetration + gap.min()]), by=by)
        assert deep.force == pytest.approx(1.0, rel=1e-6 if offset < 1 else 1e-2)


def test_no_cell_within_reach_means_no_force():
    """First touch may lie between grid points: a smaller depth loads nothing."""
    operator = FreeOperator((8, 8), (1.0, 1.0), 1.0)
    for by in CONTROLS:
        contact = press(operator, np.full((8, 8), 0.2), Load("penetration", 0.1), by=by)
        assert contact.force == 0
        assert contact.mean_gap == pytest.approx(0.1)


def test_too_few_iterations_are_an_error_with_their_history():
    operator = FreeOperator((32, 32), (1.0, 1.0), 1.0)
    gap = smooth_gap((32, 32), 11)
    with pytest.raises(ConvergenceError, match="3 iterations") as caught:
        press(operator, gap, Load("force", 5.0), max_iterations=3)
    assert len(caught.value.history) == 3
    with pytest.raises(ConvergenceError) as caught:
        press(operator, gap, Load("force", 5.0), max_iterations=1, by="pivot")
    assert caught.value.history[0] > 0


@pytest.mark.parametrize("operator_class", [FreeOperator, PeriodicOperator])
def test_what_a_sweep_forgot_is_found_again(operator_class):
    """Displacements of earlier loads make room for the next solve; they follow from the pressure.

    To 1e-6 of the largest: the sum of pressures is rounded anew.
    """
    operator = operator_class((24, 20), (1.0, 1.2), 1.0)
    gap = smooth_gap((24, 20), 6)
    seen, contacts = [], []
    for contact in sweep(operator, gap, Load("force", [0.05, 0.2, 0.9])):
        seen.append(contact.displacement.copy())
        contacts.append(contact)
    for contact, displacement in zip(contacts, seen, strict=True):
        np.testing.assert_allclose(
            contact.displacement, displacement, atol=1e-6 * np.abs(displacement).max()
        )


def test_a_sweep_may_start_again_after_a_load_that_failed():
    operator = FreeOperator((32, 32), (1.0, 1.0), 1.0)
    gap = smooth_gap((32, 32), 13)
    with pytest.raises(ConvergenceError):
        list(sweep(operator, gap, Load("force", [1.0, 2.0]), max_iterations=3))
    assert next(sweep(operator, gap, Load("force", [2.0]))).force == pytest.approx(2.0)


def test_the_dense_solver_names_the_right_tool_for_large_and_periodic_contacts(monkeypatch):
    """The limit is on cells in contact; a geometric overlap of twice as many is still solved."""
    for user in ("pivot", "press"):
        monkeypatch.setattr(f"reference.contact.{user}.CELL_LIMIT", 200)
    x = np.arange(24) - 11.6
    operator = FreeOperator((24, 24), (1.0, 1.0), 1.0)
    bowl = (x[:, None] ** 2 + x**2) / 100
    contact = press(operator, bowl, Load("penetration", 1.0), by="pivot")
    assert (bowl < 1.0).sum() > 200 > contact.mask.sum()
    with pytest.raises(ValueError, match=r"576 cells.*descent"):
        press(operator, np.zeros((24, 24)), Load("penetration", 1.0), by="pivot")
    periodic = PeriodicOperator((4, 4), (1.0, 1.0), 1.0)
    with pytest.raises(ValueError, match="descent"):
        press(periodic, np.zeros((4, 4)), Load("force", 1.0), by="pivot")
