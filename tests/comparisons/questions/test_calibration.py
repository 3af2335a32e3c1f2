"""The bars on the truth against true errors: coverage, width, and how the estimator was fixed.

Those of single contacts against closed forms, of rough surfaces against a grid eight times finer.
"""

import json
from dataclasses import replace

import numpy as np
import pytest

from comparisons.judging.uncertainty import SHARES, grid_uncertainty, share_uncertainty
from comparisons.questions import calibration
from comparisons.questions.calibration import (
    LEVELS,
    SHAPES,
    SURFACES,
    TRUTH,
    Calibration,
    shape_cases,
    sides_of,
)
from comparisons.questions.calibration_cases import (
    NO_QUANTITY,
    NOT_SHOWN,
    ROUGH,
    SINGLE,
    Case,
    fitted_shares,
    held,
    held_against,
    summary,
)
from comparisons.results.record import ROUGH_SURFACES
from comparisons.solving.inquiries import answer_of
from comparisons.solving.jobs import executor_for
from reports.pages.calibration import calibration_page
from roughline.commands.app import run_command
from roughline.commands.validation import COVERAGE, REFUTED, WIDTH


def case(order: float, constant: float, half: str = "reported", shape: str = "a") -> Case:
    """Return a series with f = 1 + c n^-p, whose error is known."""
    n = np.array([8, 16, 32])
    curves = 1 + constant * n[:, None] ** -order * np.ones(3)
    errors = np.abs(curves[-1] - 1)
    facts = (half, shape, "bem_fft", "penetration", "force", "cells")
    return Case(*facts, (8, 16, 32), errors, curves, 0 * errors)


def test_the_halves_share_no_shape():
    names = [name for half in SHAPES.values() for name in half]
    tables = [str(table) for half in SHAPES.values() for table in half.values()]
    assert len(set(tables)) == len(set(names)) == len(tables) == len(names)


def test_a_bar_that_misses_what_is_proved_at_one_load_is_counted():
    """The rms over the loads would hide it."""
    known = case(1.0, 0.1)
    bar = known.bars[0]
    series = replace(known, beyond=np.array([0.0, 1.2 * bar, 0.0]))
    assert series.missed == 1
    counted = held([series, known])
    assert (counted.bars, counted.missed, counted.without) == (3, 1, {NO_QUANTITY: 3})
    assert series.excess == pytest.approx(0.2)
    assert not series.refuted  # 1.2/sqrt(3) of the bar
    assert replace(known, beyond=1.2 * known.bars).refuted


def test_bars_without_an_interval_are_counted_with_their_reason():
    """A load at which nothing is proved, a quantity, a surface that no theorem is for."""
    known = case(1.0, 0.1)
    sides = {"force_lower": np.array([np.nan, 1.0, 2.0]), "force_upper": np.array([np.nan, 2, 3])}
    area = replace(known, quantity="contact_area")
    cases = [held_against(*of) for of in ((sides, known), (sides, area), ("a measured map", known))]
    counted = held(cases)
    assert (counted.bars, counted.missed) == (2, 1)
    assert counted.without == {NOT_SHOWN: 1, NO_QUANTITY: 3, "a measured map": 3}
    assert "1 do not reach it. Without one: 1 at loads" in str(counted)
    # the rms over the loads and the worst of them pass over a load without an interval
    assert cases[0].refuted
    assert 5 < cases[0].excess < np.inf


def test_a_bar_on_cells_is_no_narrower_at_a_lighter_load():
    """Where the change from grid to grid is small by chance at the lightest load."""
    series = np.array([[1.0, 1.2, 1.1], [1.0, 1.1, 1.05], [1.0, 1.05, 1.025]])
    energy = replace(case(1.0, 0.1), quantity="energy", curves=series)
    light, middle, heavy = energy.bars
    assert light == middle > heavy > 0
    light, middle, heavy = replace(energy, quantity="force", areas=np.array([1.0, 2, 3])).bars
    assert light > middle > heavy > 0


@pytest.mark.parametrize("quantity", ["force", "penetration", "contact_area", "stiffness"])
def test_a_contact_twice_as_wide_is_as_well_known_as_on_a_grid_twice_as_fine(quantity):
    """Errors depend on the cells across a contact alone, c (a n)^-p, and so do bars.

    Errors of two grids that are as if by chance of opposite signs differ by their sum, which is
    one to sqrt(2) times the root of the sum of their squares that a bar counts.
    """
    order, constant = SHARES[quantity, "cells"].order, 1e-5
    n, radii = np.array([8, 16, 32]), np.array([1.0, 2.0, 4.0])
    errors = constant * (n[:, None] * radii) ** -order
    values = radii**2 if quantity == "contact_area" else np.ones(3)
    curves = values * (1 + np.array([[1], [-1], [1]]) * errors)
    facts = ("reported", "a", "bem_fft", "force", quantity, "cells", (8, 16, 32))
    bars = Case(*facts, errors[-1], curves, np.zeros(3), areas=radii**2).bars
    # changes are relative to values that are not quite one
    np.testing.assert_allclose(bars * radii**order, bars[0], rtol=1e-4)
    expected = SHARES[quantity, "cells"].factor * errors[-1]
    assert np.all((bars > expected) & (bars < 2**0.5 * expected))


def test_coverage_and_width_of_bars_that_are_known():
    """Errors of 2, 0.5 and 1/8 of the bar: two of three are covered, the median width is 2."""
    base = case(1.0, 0.1)
    made = [replace(base, errors=base.bars / k) for k in (0.5, 2.0, 8.0)]
    rows = summary(made)
    assert rows.coverage == pytest.approx(2 / 3)
    assert rows.width == pytest.approx(2)
    assert rows.count == 3
    assert summary(made, at_loads=True) == replace(
        rows, count=9
    )  # all loads have the same error and bar


def test_an_error_at_one_load_may_be_beyond_its_bar_while_that_over_all_loads_is_not():
    base = case(1.0, 0.1)
    made = [replace(base, errors=base.bars * [1.2, 0.5, 0.5])]
    assert summary(made).coverage == 1
    assert summary(made, at_loads=True).coverage == pytest.approx(2 / 3)


def share(order: float, assumed: float) -> float:
    """Return bar over error of f = 1 + c n^-order on 8, 16, 32 for a factor of one.

    The changes are (2^o - 1) and 2^o (2^o - 1) times the error. Each counts divided by
    sqrt(n^-2p + N^-2p) over that of the finest, and the mean of their squares is taken.
    """
    counted = (1 + 4 ** (order - assumed)) / 2 / (4**assumed + 1)
    return (2**order - 1) * counted**0.5


@pytest.mark.parametrize("order", [1.0, 2.0])
def test_the_bar_on_cells_is_a_share_of_the_last_two_changes(order):
    known = "force", "cells"
    result = case(order, 0.01)
    expected = SHARES[known].factor * share(order, SHARES[known].order)
    # relative changes are of values that are not quite one
    assert result.bar / result.error == pytest.approx(expected, rel=1e-2)
    coarser = np.vstack([[7.0] * 3, result.curves])  # and of no more than two
    wide = replace(result, resolutions=(4, *result.resolutions), curves=coarser)
    np.testing.assert_array_equal(wide.bars, result.bars)


def test_a_change_that_is_small_by_chance_is_not_believed():
    """At one load the finest grids agree, or all grids: the other load speaks for it."""
    base = case(2.0, 0.1)
    lucky = base.curves.copy()
    lucky[:, 2] = lucky[-1, 2]
    bars = replace(base, curves=lucky).bars
    assert bars[2] == pytest.approx(base.bars[2] * (2 / 3) ** 0.5, rel=1e-2)
    lucky = base.curves.copy()
    lucky[1] = lucky[2]
    assert replace(base, curves=lucky).bar > base.error


@pytest.mark.parametrize("kind", ["cells", "elements"])
def test_two_grids_have_a_wider_bar(kind):
    """Their change may be small by chance; of second order it is three times the error left."""
    base = replace(case(2.0, 0.01), kind=kind)
    two = replace(base, resolutions=(16, 32), curves=base.curves[1:])
    order, factor = SHARES["force", kind].order, SHARES["force", kind].factor
    left = 3 / (4**order + 1) ** 0.5
    expected = SHARES["force", kind].two * factor * left
    assert two.bar / two.error == pytest.approx(expected, rel=1e-2)


def test_errors_of_areas_are_alike_at_all_loads_in_cells():
    """A contact four times larger has a quarter of the bar; a radius changes by half.

    The area need not be told beside them: it follows from either.
    """
    sizes = np.array([1.0, 2.0, 4.0])
    areas = sizes + np.array([[0.1], [0.02], [0.0]]) * [1.0, -1.0, 1.0]
    area = replace(case(1.0, 0.1), quantity="contact_area", curves=areas).bars
    np.testing.assert_allclose(area * sizes, area[0], rtol=1e-9)
    radius = replace(case(1.0, 0.1), quantity="equivalent_radius", curves=areas**0.5).bars
    np.testing.assert_allclose(radius, area / 2, rtol=0.05)  # to first order in the changes


def test_a_load_that_a_coarser_grid_lost_has_the_bar_of_the_others():
    base = case(2.0, 0.1)
    lost = base.curves.copy()
    lost[:2, 0] = np.nan
    np.testing.assert_allclose(replace(base, curves=lost).bars, base.bars, rtol=1e-9)
    lost = base.curves.copy()
    lost[2, 0] = np.nan
    assert np.isfinite(replace(base, curves=lost).bars).tolist() == [False, True, True]


def test_the_fit_takes_the_smallest_share_that_covers():
    """Second order leaves less of its changes than first order does: all must be covered."""
    known = "force", "cells"
    margin, assumed = SINGLE[known][1], SHARES[known].order
    # FINE_FACTORS go in steps of half a per cent; changes are relative as above
    second = [case(2.0, c, "fitting", s) for c in (0.1, -0.2) for s in ("a", "b")]
    assert fitted_shares(second)[known].factor == pytest.approx(
        margin / share(2, assumed), rel=0.02
    )
    first = [case(1.0, 0.001, "fitting", "tip")]
    fitted = fitted_shares([*second, *first])[known].factor
    assert fitted == pytest.approx(margin / share(1, assumed), rel=0.02)
    assert fitted_shares([case(1.0, 0.1)]) == SHARES  # the reported half has no say


def test_what_was_not_measured_keeps_the_grid_convergence_index():
    base = case(2.0, 0.01)
    index = grid_uncertainty(np.array(base.resolutions), base.curves)
    for other in (replace(base, quantity="energy"), replace(base, kind=None)):
        np.testing.assert_array_equal(other.bars, index)
    assert not np.array_equal(replace(base, kind="elements").bars, index)
    force = replace(base, kind="elements").bars
    np.testing.assert_array_equal(
        replace(base, kind="elements", quantity="penetration").bars, force
    )


def test_one_shape_at_coarse_grids_is_covered():
    """The cylinder, solved: a staircase on a grid converges in jumps, and its bars cover them."""
    cylinder = SHAPES["reported"]["cylinder"]
    asked = shape_cases("reported", "cylinder", cylinder, {"bem_fft": ((8, 11, 16),)})
    result = answer_of(asked)
    assert {part.quantity for part in result} == {"force", "stiffness", "penetration"}
    assert summary(result).coverage == 1


@pytest.mark.parametrize(("times", "beyond", "code"), [(0.5, 0, 0), (2.0, 0, 1), (0.5, 1.2, 1)])
def test_the_command_tells_the_rule_and_ends_with_1_where_bars_are_too_narrow(
    times, beyond, code, tmp_path, monkeypatch, capsys
):
    """Errors of half the bar, of twice the bar, and half of a bar that misses what is proved.

    Lines fit a terminal of 80 columns.
    """
    monkeypatch.setenv("COLUMNS", "80")
    made = [case(2.0, c, half) for c in (0.1, 0.2) for half in ("fitting", "reported")]
    made = [replace(part, errors=times * part.bars, beyond=beyond * part.bars) for part in made]

    def inquiry():
        yield []
        return made

    monkeypatch.setattr(Calibration, "inquiries", lambda self: {"made": inquiry()})
    assert run_command(["calibrate", "--workers", "1", "--out", str(tmp_path)]) == code
    said = capsys.readouterr().out
    missed = 12 if beyond else 0
    proved = json.loads((tmp_path / "proved.json").read_text())
    assert (proved["bars"], proved["missed"]) == (12, missed)
    assert said.count("defect: ") == missed / 3  # a case has three loads
    assert len((tmp_path / "calibration.csv").read_text().splitlines()) == 1 + len(made)
    page = (tmp_path / "report.html").read_text(encoding="utf-8")
    assert page.count(f"covers the true error in {100.0 if times < 1 else 0.0} % of 2 cases") == 2
    assert f"{missed} do not reach" in page
    assert max(map(len, said.replace(str(tmp_path), "").splitlines())) <= 80
    (row,) = [line.split() for line in said.splitlines() if line.startswith("force, FFT BEM")]
    reached = ["100.0", "%", "2.0"] if times < 1 else ["0.0", "%", "0.50"]
    assert row[3:] == ["2", *reached, *reached]
    assert "force, cells" in said
    assert "1.2 times as wide" in said
    assert "12 bars stand beside an interval" in said


@pytest.mark.slow
def test_the_bars_cover_95_percent_of_the_reported_half_and_are_not_far_too_wide(
    tmp_path, monkeypatch
):
    """At least 200 cases that had no part in fixing the rule; the fitting half still bears it.

    Solvers that improve after the rule was fixed may allow a narrower one (`fitted` names it). Of
    rough surfaces, whose truths take minutes each, two kinds: `roughline calibrate` has all. Of
    their intervals nothing is asked here: tests/comparisons/judging/test_proofs.py is about them.
    """
    for half, surfaces in SURFACES.items():
        monkeypatch.setitem(SURFACES, half, dict(list(surfaces.items())[:2]))
    monkeypatch.setattr(
        calibration,
        "sides_of",
        lambda plan: "not asked for" if plan.scene.rough else sides_of(plan),
    )
    result = Calibration(tmp_path, executor=executor_for(2)).run().cases
    single = [part for part in result if not part.rough]
    reported = [part for part in single if part.half == "reported"]
    assert len(reported) >= 200
    for reached in (summary(reported), summary(reported, at_loads=True)):
        assert reached.coverage >= COVERAGE
        assert reached.width <= WIDTH
    # bars at a load are at 95 %, and not at any price: 98.4 % on the processor of the fit
    assert summary(reported, at_loads=True).coverage <= 0.995
    fitted = fitted_shares(single)
    for quantity in SINGLE:  # another processor, other jumps
        assert fitted[quantity].factor == pytest.approx(SHARES[quantity].factor, rel=0.1)
    refuted = held(single)
    assert refuted.bars > 2000
    assert refuted.missed <= REFUTED * refuted.bars
    assert [part.in_words for part in single if part.refuted] == []
    assert max(part.excess for part in single) < 0.6  # no bar is far too narrow at any load
    assert summary(part for part in result if part.rough).coverage >= 0.9


def rough_case(name: str, error: float, half: str = "fitting", levels=LEVELS, kind="free") -> Case:
    """Return a case whose last change is 10 % of the finer value, at one load."""
    curves = np.array([[1.2], [1.1], [1.0]])[-len(levels) :]
    errors, beside = np.array([error]), np.zeros(1)
    return Case(half, "a", "bem_fft", "force", name, kind, levels, errors, curves, beside)


def test_the_truth_is_eight_times_finer_and_the_halves_share_no_surface():
    assert 8 * LEVELS[-1] == TRUTH
    fitting, reported = (
        {(s.get("hurst"), str(s.get("crop"))) for s in half.values()} for half in SURFACES.values()
    )
    assert not fitting & reported


@pytest.mark.parametrize("kind", ["free", "periodic"])
def test_the_bar_pools_what_the_changes_of_all_loads_leave(kind):
    """Errors of c s n^-p, independent on all grids: the bar is Student's t times that error.

    With s of powers of contact area and open share.
    """
    grids, areas = np.array(LEVELS), np.array([0.01, 0.1, 0.4])
    known = {"areas": areas, "apparent": 1.0}
    for name in ("penetration", "mean_gap", "stiffness"):
        share = SHARES[name, kind]
        order, factor = share.order, share.factor
        size = 1e-5 * areas**-share.area * (1 - areas) ** -share.gap
        errors = size * (grids[:, None] / LEVELS[-1]) ** -order
        # changes as large as those of independent errors, of one sign
        steps = np.sqrt(errors[1:] ** 2 + errors[:-1] ** 2)
        curves = np.cumprod(np.vstack([np.ones(3), 1 + steps]), axis=0)
        bars = share_uncertainty(grids, curves, (name, kind), **known)
        # two changes at three loads: six degrees of freedom
        assert bars == pytest.approx(2.447 * factor * errors[-1], rel=0.01)
        curves[-1, 0] = curves[-2, 0]  # small by chance: the others speak for it
        assert share_uncertainty(grids, curves, (name, kind), **known)[0] > 0.4 * bars[0]


def test_gaps_narrower_than_any_that_were_measured_count_as_these():
    """A tenth open at the least: with the open share itself the bar would be 1 000 at 0.999."""
    grids, changes = np.array(LEVELS[1:]), np.array([[1.0] * 3, [1.1] * 3])
    known = {"areas": np.array([0.95, 0.99, 0.999]), "apparent": 1.0}
    bars = share_uncertainty(grids, changes, ("mean_gap", "free"), **known)
    assert bars == pytest.approx(bars[0])
    assert bars[0] < 1.0


def test_few_changes_have_a_wider_bar_for_all_may_be_small_by_chance():
    """One change (two grids, one load) has Student's t of one degree of freedom: 12.7."""
    grids, quantity = np.array(LEVELS[1:]), ("mean_gap", "free")
    share = SHARES[quantity]
    power = -2 * share.order
    left = np.sqrt(4.0**power / (2.0**power + 4.0**power))
    for loads, t in ((1, 12.71), (5, 2.571)):
        curves = np.array([[1.0] * loads, [1.1] * loads])
        bars = share_uncertainty(grids, curves, quantity)
        assert bars == pytest.approx(t * share.factor * left * 0.1 / 1.1, rel=1e-3)


def test_an_area_is_known_no_better_than_the_cells_at_its_contact_line():
    """Changes of 10 and 9 % and, beside them, cells 6 % too many: 0.5 of 0.06^1.5.

    And on 64 cells a side a strip of 0.175 cells where there is a rim.
    """
    area = rough_case("contact_area", 0.0, kind="periodic")
    line = 0.5 * 0.06**1.5
    counted = replace(area, counted=np.array([1.06]))
    assert counted.bar == pytest.approx(np.hypot(area.bar, line))
    close = replace(counted, curves=np.ones((3, 1)))
    assert close.bar == pytest.approx(line)
    assert replace(close, kind="free").bar == pytest.approx(line + 2 * 0.17465 / 64)


def test_other_widths_are_those_of_all_bars_whatever_their_rule():
    made = [rough_case(name, 0.05) for name in ROUGH_SURFACES]
    made.append(replace(rough_case("contact_area", 0.05), counted=np.array([1.06])))
    for before, after in zip(made, (replace(case, widened=1.2) for case in made), strict=True):
        assert after.bar == pytest.approx(1.2 * before.bar)


def test_one_grid_leaves_the_bar_unknown():
    bar = share_uncertainty(np.array([32]), np.ones((1, 2)), ("stiffness", "free"))
    assert np.isnan(bar).all()


def test_the_fit_takes_the_smallest_factor_that_covers():
    """Errors just within the bar of a factor twice as large ask for that; the reported half not.

    Raised by its margin; with two grids for as much more than Student's t.
    """
    factor = SHARES["stiffness", "free"].factor
    times = 2 * rough_case("stiffness", 0.0).bar
    three = [
        rough_case("stiffness", times),
        rough_case("stiffness", 0.01),
        rough_case("stiffness", 9.0, "reported"),
    ]
    wide = (
        3
        * 2
        * rough_case("stiffness", 0.0, levels=LEVELS[1:]).bar
        / SHARES["stiffness", "free"].two
    )
    rule = fitted_shares([*three, rough_case("stiffness", wide, levels=LEVELS[1:])])
    assert rule["stiffness", "free"].factor == pytest.approx(ROUGH[1] * 2 * factor, rel=0.01)
    assert rule["stiffness", "free"].two == pytest.approx(3, rel=0.01)
    assert replace(three[0], shares=rule).bar == pytest.approx(ROUGH[1] * times, rel=0.01)
    for name in ROUGH_SURFACES:  # of what there are no cases, or none that is covered
        other = (name, "periodic")
        assert rule[other].factor == pytest.approx(SHARES[other].factor, abs=0.01)
    assert fitted_shares([rough_case("mean_gap", 1e9)]) == SHARES


def test_the_page_tells_rough_surfaces_apart():
    made = [
        rough_case(name, 0.05, half) for name in ROUGH_SURFACES for half in ("reported", "fitting")
    ]
    single = [replace(part, kind="cells") for part in made]
    page = calibration_page([*single, *made], "roughline calibrate")
    assert "Rough surfaces, reported half: the bar covers the true error in 100.0 % of 4" in page
    assert "Single contacts, reported half: the bar" in page
