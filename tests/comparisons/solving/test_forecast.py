"""Remaining time comes from what like tasks have cost, and says when that is not all."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from comparisons.facts.methods import METHODS, Method
from comparisons.solving.forecast import Forecast
from comparisons.solving.planning import plan_scene, task_of


@pytest.fixture
def task(rough):
    plan = plan_scene(rough(realisations=60, compare={"resolutions": [64]}), "full")[0]
    return task_of(plan, "bem_fft", 64, tuple(range(25)))


def test_a_like_task_costs_the_same_for_each_realisation(task):
    forecast = Forecast()
    forecast.learn(task, 50.0)
    assert forecast.cost(task) == 50.0
    assert forecast.cost(replace(task, realisations=(50, 51))) == 4.0


@pytest.mark.parametrize(("method", "growth"), [("bem_fft", 6.0), ("fem", METHODS["fem"].growth)])
def test_a_finer_task_costs_more_by_the_growth_of_its_method(task, method, growth):
    forecast = Forecast()
    forecast.learn(replace(task, method=method), 1.0)
    finer = replace(task, method=method, resolution=256)
    assert math.isclose(forecast.cost(finer), growth**2)


def test_the_nearest_resolution_counts_and_another_scene_only_if_its_own_is_new(task):
    forecast = Forecast()
    forecast.learn(replace(task, resolution=16), 1.0)
    forecast.learn(replace(task, resolution=128), 100.0)
    assert math.isclose(forecast.cost(replace(task, resolution=256)), 100 * Method.growth)
    other = replace(task, scene=task.scene.model_copy(update={"name": "other"}))
    assert math.isclose(forecast.cost(other), 50.5)  # the mean of all that the method has solved


def test_an_unknown_method_makes_the_sum_a_lower_bound(task):
    forecast = Forecast()
    assert not forecast.remaining([task], 1).complete
    forecast.learn(task, 10.0)
    both = [task, replace(task, method="fem")]
    assert forecast.remaining(both, 1).seconds == 10.0
    assert not forecast.remaining(both, 1).complete


def test_workers_share_the_work_but_not_a_task(task):
    forecast = Forecast()
    forecast.learn(task, 10.0)
    assert forecast.remaining([task] * 6, 3).seconds == 20.0
    assert forecast.remaining([task], 3).seconds == 10.0
    assert forecast.remaining([], 3) == replace(forecast.remaining([task], 3), seconds=0.0)


def test_what_was_lost_teaches_nothing(task):
    forecast = Forecast()
    forecast.learn(task, float("nan"))
    assert forecast.cost(task) is None
