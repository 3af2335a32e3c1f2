"""Remaining time comes from what like tasks have cost, and says when that is not all."""

import math
from dataclasses import replace
from itertools import pairwise

import pytest

from comparisons.facts.methods import METHODS
from comparisons.scene.scene import load_scene
from comparisons.solving.jobs import REPEAT_SECONDS, Forecast, JobKind, Remaining
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene


@pytest.fixture
def kind(rough):
    """Surfaces that are solved once; those of the first block are timed."""
    plan = plan_scene(rough(realisations=60, compare={"resolutions": [64]}), "full")[0]
    return JobKind.of(task_of(plan, "bem_fft", 64, tuple(range(25, 50))))


def test_a_like_task_costs_the_same_for_each_realisation(kind):
    forecast = Forecast()
    forecast.learn(kind, 50.0)
    assert math.isclose(forecast.cost(kind), 50.0)
    assert math.isclose(forecast.cost(replace(kind, realisations=2)), 4.0)


def test_a_finer_task_costs_more_by_the_growth_of_its_method(kind):
    """In the limit by its law; on coarse grids less, where half of the time is that of any grid."""
    for sort, growth in (("rough", 4), ("single", METHODS["bem_fft"].growth)):
        costs = [
            replace(kind, sort=sort, resolution=n).usual_seconds for n in (8, 16, 2**20, 2**21)
        ]
        assert math.isclose(costs[3] / costs[2], growth, rel_tol=1e-6)
        assert costs[1] / costs[0] < growth / 2


def test_nobody_knows_what_other_physics_takes_until_a_job_of_the_scene_is_done():
    """Elements of a lubricated contact were told to take 16 hours, as if they were of a ball."""
    kinds = []
    for name, method in (("soft-ball-film", "bem_fft"), ("friction-steel", "bem_fft")):
        plan = plan_scene(load_scene(name), "quick")[0]
        kinds.append(JobKind.of(task_of(plan, method, 64)))
    film, ball = kinds
    forecast = Forecast()
    assert forecast.cost(film) is None
    forecast.learn(film, 3.0)
    assert forecast.cost(film) == pytest.approx(3.0)
    assert forecast.cost(ball) is None


# Measured: seconds of a solve of the scene `cone`, by elements or cells in a radius of contact, and
# of a surface of `rough-free`, by points a side.
LEVELS = {
    "bem_dense": [(5, 0.03), (10, 0.17), (20, 2.3)],
    "bem_fft": [(16, 0.08), (32, 0.17), (64, 0.96), (128, 4.7), (256, 8.2)],
    "fem": [(2, 0.07), (3, 0.24), (4, 0.50), (6, 2.7), (8, 8.1)],
}
SURFACES = {"bem_fft": [(64, 0.186), (128, 0.50), (256, 1.04)]}


@pytest.mark.parametrize(
    ("levels", "realisations"), [(LEVELS, 1), (SURFACES, 25)], ids=["contact", "rough"]
)
def test_the_next_level_costs_as_much_as_it_did(kind, levels, realisations):
    """Within a factor of 3: the law of dense matrices, N^6, made ten minutes of two seconds."""
    for method, measured in levels.items():
        for (coarse, seconds), (fine, expected) in pairwise(measured):
            forecast = Forecast()
            job = replace(kind, method=method, resolution=coarse, realisations=realisations)
            job = replace(job, sort="rough" if levels is SURFACES else "single")
            forecast.learn(job, realisations * seconds)
            told = forecast.cost(replace(job, resolution=fine)) / realisations
            least, most = sorted((told, expected))
            assert most < 3 * least, (method, coarse, fine)


def test_what_a_job_takes_beside_its_solve_does_not_grow_with_the_grid(kind):
    """Seconds around solves of a millisecond became minutes on a grid four times finer."""
    forecast = Forecast()
    forecast.learn(kind, 10.0, solving=0.001)
    finer = forecast.cost(replace(kind, resolution=256))
    assert math.isclose(finer, 10.0, rel_tol=1e-3)


def test_a_job_takes_what_it_usually_does_at_the_pace_of_those_most_like_it(kind):
    """Of the scene, else of the method with such contacts, else of all; from outside unknown."""
    forecast, ball = Forecast(), replace(kind, scene="ball", realisations=1, sort="single")
    cone, fem = replace(ball, scene="cone"), replace(ball, method="fem")
    for job, pace in ((ball, 2.0), (cone, 6.0)):
        forecast.learn(job, pace * job.usual_seconds)
    other = replace(ball, scene="other", resolution=16)
    for job, pace in ((replace(cone, resolution=256), 6.0), (other, 4.0)):
        assert math.isclose(forecast.cost(job), pace * job.usual_seconds)
    forecast.learn(replace(ball, resolution=2048), 4 * replace(ball, resolution=2048).usual_seconds)
    for job in (kind, fem):
        assert math.isclose(forecast.cost(job), 4 * job.usual_seconds, rel_tol=0.05)
    own = replace(ball, method="winkler")
    assert forecast.cost(own) is None
    forecast.learn(own, 4.0)
    assert forecast.cost(replace(own, scene="other")) == 4.0


def test_tiny_jobs_say_little_of_the_pace(kind):
    """A line that took 0.05 s, not 0.05 ms, does not make a host a thousand times slower."""
    forecast = Forecast()
    forecast.learn(replace(kind, method="reduced", realisations=1), 0.05)
    assert kind.usual_seconds < forecast.cost(kind) < 2 * kind.usual_seconds


@pytest.mark.parametrize(
    ("solving", "timed"), [(0.01, 3 * 0.01), (0.05, REPEAT_SECONDS), (2.0, 2.0)]
)
def test_short_solves_are_repeated_for_their_time_only_on_the_first_surfaces(kind, solving, timed):
    first, forecast = replace(kind, timed=True), Forecast()
    forecast.learn(first, 1.0 + timed, solving)
    assert math.isclose(forecast.cost(first), 1.0 + timed)
    assert math.isclose(forecast.cost(kind), 1.0 + solving)


def test_before_any_job_one_of_our_methods_costs_at_least_what_it_once_did(kind):
    expected = Forecast().remaining([kind, kind], 1)
    assert expected == Remaining(2 * kind.usual_seconds, complete=False)


def test_a_contact_taken_apart_cell_by_cell_takes_minutes():
    """It took 2, 13 and 204 s on a busy host, by half of them idle; seven were told for all."""
    (plan,) = plan_scene(load_scene("adhesive-ball"))
    coarse, middle, fine = (JobKind.of(task_of(plan, "bem_fft", n)) for n in (6, 12, 24))
    forecast = Forecast()
    assert forecast.remaining([coarse, middle, fine], 1).seconds > 30
    forecast.learn(middle, 12.9)
    assert 204 / 2 < forecast.cost(fine) < 2 * 204
    assert JobKind.of(task_of(plan, "reduced", 40)).usual_seconds < 1


def test_balls_make_a_rough_scene_a_lower_bound(kind):
    """A map of 4096 points a side is not done in the time of a ball."""
    forecast = Forecast()
    ball = replace(kind, scene="ball", sort="single")
    forecast.learn(ball, 10.0)
    assert forecast.remaining([replace(ball, scene="other")], 1).complete
    assert not forecast.remaining([kind], 1).complete
    forecast.learn(kind, 10.0)
    large = forecast.remaining([replace(kind, scene="large", resolution=4096)], 1)
    assert large.complete
    assert large.seconds > 64**2


def test_an_unknown_method_makes_the_sum_a_lower_bound(kind):
    forecast = Forecast()
    forecast.learn(kind, 10.0)
    both = [kind, replace(kind, method="winkler")]
    assert math.isclose(forecast.remaining(both, 1).seconds, 10.0)
    assert not forecast.remaining(both, 1).complete


def test_workers_share_the_work_but_not_a_task(kind):
    forecast = Forecast()
    forecast.learn(kind, 10.0)
    assert math.isclose(forecast.remaining([kind] * 6, 3).seconds, 20.0)
    assert math.isclose(forecast.remaining([kind], 3).seconds, 10.0)
    assert forecast.remaining([], 3) == replace(forecast.remaining([kind], 3), seconds=0.0)


def test_what_was_lost_teaches_nothing(kind):
    forecast = Forecast()
    forecast.learn(kind, float("nan"))
    assert forecast.cost(kind) == kind.usual_seconds
