"""Experiments: the form they share, and what each finds against independent closed forms."""

import math
from types import SimpleNamespace

import numpy as np
import pytest

from comparisons.errors import InputError
from comparisons.questions.claims.claim import load_claims
from comparisons.questions.experiments import EXPERIMENTS, films, finite_elements, rough_contact
from comparisons.questions.experiments.experiment import Experiment, Finding


def measure(name, value=None, effort="quick", **parameters):
    return EXPERIMENTS[name].measure(value, effort, **parameters)


FITTED = {"statement": "patir_cheng"}


@pytest.mark.parametrize(
    ("name", "value", "given", "message"),
    [
        ("rough-contact", 0.01, {"hurts": 0.8}, "hurts: unknown key; did you mean hurst"),
        ("rough-contact", 0.01, {"hurst": "rough"}, "hurst: expected a valid number, got 'rough'"),
        ("rough-contact", 0.01, {"periodic": 1}, "periodic: expected true or false, got 1"),
        ("rough-contact", 0.01, {"load": 0.1}, "load is varied and given"),
        ("rough-contact", 0.01, {"points": 1e9}, "points: expected less than or equal to 2048"),
        ("rough-contact", 0.01, {"points": 32.5}, "points: expected a whole number"),
        ("best-reading", 0.01, {"realisations": 1e12}, "realisations: expected less than"),
        ("active-set", 0.3, {"points": 2000}, "is too large"),
        ("second-truth", None, {"quantity": "force"}, "quantity: expected one of contact_area, "),
        ("far-field", 2.0, {"effort": "slow"}, "'quick' or 'full'"),
        ("far-field", 0.1, {}, "distance: expected greater than 0.5"),
        ("rough-adhesion", 0.1, {"periodic": False}, "periodic: expected True, got False"),
        ("kinetic-energy", 0.1, {"kind": "plane"}, "nothing is far"),
        ("first-yield", 1.5, {}, "infinite"),
        ("harmonic-contact", 1.5, {}, "amplitude"),
        (
            "rough-contact",
            0.03,
            {"statement": "bush", "quantity": "mean_gap"},
            "speaks of contact_",
        ),
        ("pyramid-stiffness", 6, {"rule": "king"}, "no number for 6 faces"),
        ("face-rule", 5, {"rule": "king"}, "no number for 5 sides"),
        ("set-valued-steps", 1, {}, "steps: expected greater than 2, got 1"),
        (
            "set-valued-steps",
            1.5,
            {"along": "load", "quantity": "rest"},
            "load: expected less than 1",
        ),
        ("regularised-amplitude", 0.0, {}, "speed_ratio: expected greater than 0"),
        ("free-vibration", 1.0, {}, "deepest: expected greater than 1"),
        ("corrected-rubber", 1.0, {"quantity": "start"}, "quantity: expected 'work' or 'friction'"),
        ("relaxation-series", math.nan, {}, "per_decade: expected a finite number"),
        ("regularised-block", -1.0, {}, "speed_ratio: expected greater than 0"),
        ("regularised-block", 10.0, {"load": 1.0}, "load: expected less than 1"),
        ("regularised-block", 10.0, {"quantity": "speed"}, "quantity: expected 'rest', 'force'"),
        ("regularised-belt", 0.5, {}, "static: expected greater than 0.999999"),
        ("explicit-friction-step", 1.5, {}, "load must be below the limit 1.0, got 1.5"),
        ("equivalent-body", 0.0, {}, "exponent: expected greater than 0"),
        ("equivalent-body", 2.0, {"rule": "quarter"}, "expected 'half_radius' or 'transform'"),
        ("rough-slip", 1.0, {}, "share: expected less than 1"),
        ("changing-load", 0.0, {}, "final: expected greater than 0"),
        ("ridges", 1.0, {}, "load: expected less than 1"),
        ("procedure", 0.1, {"variant": "mine"}, "variant: expected 'literal' or 'corrected'"),
        ("adhesive-range", 5.0, {"law": "exponential"}, "from 0.3 to 1.0 on grids, not 5.0"),
        ("film-plane-open", 0.1, FITTED | {"quantity": "shear"}, "pressure, not of shear"),
        ("film-plane-pressed", 0.1, FITTED | {"quantity": "flow"}, "the factor, not of the flow"),
    ],
)
def test_wrong_parameters_are_named_with_what_was_expected(name, value, given, message):
    with pytest.raises(InputError, match=message):
        measure(name, value, **given)


def test_another_parameter_can_be_varied():
    by_points = measure("line-moments", 32, quantity="slope")
    by_hurst = measure("line-moments", 0.8, along="hurst", points=32, quantity="slope")
    assert by_points.error == by_hurst.error
    assert by_hurst.parameter == 0.8


def test_a_result_that_is_no_number_is_no_result():
    broken = Experiment("broken", "", "", lambda effort, *, x=1.0: Finding(math.nan, 1.0, 0.0, {}))
    with pytest.raises(ArithmeticError, match="nan"):
        broken.measure(1.0)


def test_of_an_impact_the_share_that_is_lost_is_judged():
    lost, force = (measure("quasi-static-impact", 1e-2, quantity=q) for q in ("energy", "force"))
    assert lost.error == pytest.approx(1 - lost.details["restitution"] ** 2, rel=1e-12)
    assert (lost.noun, force.noun) == ("share", "error")


def test_the_best_reading_is_the_best_of_all_and_judged_on_other_surfaces(monkeypatch):
    """A scan of few surfaces on a coarse grid; the judgement is that of the reading alone."""
    few = [reading for reading in rough_contact.READINGS if reading[0] in (0.3, 2.0)]
    monkeypatch.setattr(rough_contact, "READINGS", few)
    monkeypatch.setattr(rough_contact, "_COUNTS", (2, 40))
    rough_contact.scan.cache_clear()
    tried = rough_contact.scan(32)
    worst = {reading: np.abs(np.log1p(errors)).max() for reading, errors in tried.items()}
    best = rough_contact.best_reading(32)
    assert worst[best] == min(worst.values())
    assert rough_contact.best_reading(32, steepest=1)[0] == 0.3
    counted = {"quantity": "contact_area_raw", "grid": "native", "points": 32}
    alone = measure("rough-contact", 0.01, **counted, **rough_contact.parameters_of(best))
    assert measure("best-reading", 0.01, points=32).error == alone.error
    rough_contact.scan.cache_clear()


def test_every_reading_is_one_that_the_text_of_the_chapter_leaves_open():
    """All combinations, as many as the claims say, and each choice with the sentence behind it."""
    assert len(rough_contact.READINGS) == 768
    scans = [claim for claim in load_claims() if claim.experiment == "best-reading"]
    assert all("768" in claim.text for claim in scans)
    assert all(choice.sentence and choice.unsaid for choice in rough_contact.CHOICES)


def test_a_one_sided_spectrum_doubles_the_mean_square_height():
    """At a small load the depth grows with the heights, between sqrt 2 times and not at all."""
    deep = {"grid": "native", "quantity": "penetration", "points": 32, "edges": "nodal"}
    two, one = (measure("rough-contact", 0.03, sided=sided, **deep) for sided in (2.0, 1.0))
    assert 1 < one.details["stated"] / two.details["stated"] < 2**0.5


def test_the_bar_of_the_grid_covers_the_change_to_finer_grids():
    native = measure("rough-contact", 0.01, quantity="contact_area_raw", grid="native")
    refined = measure("rough-contact", 0.01, quantity="contact_area_raw")
    assert refined.error > native.error
    assert refined.uncertainty > native.uncertainty


@pytest.mark.slow
def test_first_yield_of_other_shapes():
    """Self-similar shapes: forces go as the stresses to the power -(n + 1)/(n - 1)."""
    for rule in ("own_curvature", "one_radius"):
        measured = measure("first-yield", 4, rule=rule)
        ratio = measured.details["largest stress at true yield, stated over true"]
        assert measured.error == pytest.approx(ratio ** (-5 / 3) - 1, rel=1e-5)
    assert abs(measure("first-yield", 4, rule="abel").error) < 1e-6


def test_cost_at_equal_error_follows_the_laws_of_cost_and_error(monkeypatch):
    """Planted laws: seconds 1e-3 N^3 against 1e-6 N^2, errors 2 N^-2 against N^-1.

    At an error of 0.02 finite elements need N = 10 and a second, the other N = 50 and 2.5 ms.
    """
    n = np.array([8.0, 16.0, 32.0])
    planted = {
        "fem": finite_elements.Series(n, 1e-3 * n**3, 1e6 * n**3, 2 / n**2),
        "bem_fft": finite_elements.Series(n, 1e-6 * n**2, 1e6 * n**2, 1 / n),
        "reduced": finite_elements.Series(n, 1e-9 * n, 1e6 * n, 1 / n),
    }
    monkeypatch.setattr(
        finite_elements, "measure_series", lambda method, effort, mesh: planted[method]
    )
    equal = measure("finite-element-cost", 0.02)
    assert equal.error == pytest.approx(2.5e-3, rel=1e-9)
    assert equal.details["exponent of time, finite elements"] == pytest.approx(3, rel=1e-12)
    line = measure("finite-element-cost", points=64, against="reduced")
    assert line.error == pytest.approx(1e-6 / 64**2, rel=1e-9)
    memory = measure("finite-element-cost", points=10, resource="memory")
    assert memory.error == pytest.approx(0.1, rel=1e-9)
    # Where all grids are accurate enough, the scatter of their errors is no part of the bar.
    planted["bem_fft"] = finite_elements.Series(n, 1e-6 * n**2, n, np.array([0.1, 0.02, 0.04]))
    coarsest = measure("finite-element-cost", 0.2)
    assert coarsest.error == pytest.approx(1e-6 * 8**2 / (1e-3 * 8**3), rel=1e-9)
    assert coarsest.uncertainty < 1e-9 * coarsest.error


def test_a_method_is_measured_on_ever_finer_grids(monkeypatch):
    """Every grid is solved anew: lines of the model stay far from the surface's own truth."""
    monkeypatch.setitem(finite_elements._GRIDS["quick"], "reduced", (8, 16))
    monkeypatch.setattr(finite_elements, "_TRUTH", 32)
    series = finite_elements.measure_series.__wrapped__("reduced", "quick", "block")
    assert series.points.tolist() == [8, 16]
    assert (series.seconds > 0).all()
    assert (series.errors > 0.1).all()


def test_two_formulas_of_one_film_solve_it_once(monkeypatch):
    """Two claims judge a fit and a limit by the same two grids."""
    speeds = []

    def entrain(ball, speed, cells):
        speeds.append((speed, cells))
        return SimpleNamespace(film_central=1e-6 * (1 + cells**-2))

    monkeypatch.setattr(films, "entrain", entrain)
    films._on_rubber.cache_clear()
    for by in ("fit", "limit"):
        measure("film-soft", 7.0, by=by)
    films._on_rubber.cache_clear()
    assert len(speeds) == 2


JUDGED = [claim for claim in load_claims() if claim.experiment]


@pytest.mark.parametrize("claim", JUDGED, ids=lambda claim: claim.id)
def test_every_claim_gives_its_experiment_what_it_knows(claim):
    """At the ends of its ranges, without measuring: a wrong one would cost the claim its result."""
    check = EXPERIMENTS[claim.experiment].checked
    for value in (None,) if claim.vary is None else (claim.vary.start, claim.vary.end):
        check(value, **claim.parameters)
    for nuisance in claim.nuisance:
        for number in nuisance.numbers():
            check(None, **claim.under({**claim.as_stated, nuisance.key: number}).parameters)
    assert claim.expected is not None


def test_the_readings_of_the_script_are_those_that_the_experiment_knows(script, monkeypatch):
    tables = script("experiment_tables")
    monkeypatch.setattr(tables, "LOADS", (0.01,))
    rows = tables.readings(realisations=3, effort="quick")
    assert len(rows) == 1 + len(tables.READINGS)
