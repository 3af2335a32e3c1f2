"""The spectrum of a rough surface in the report."""

from dataclasses import replace

import numpy as np
import pytest

from comparisons.geometry.prepare import prepare
from comparisons.scene.scene import load_scene
from comparisons.solving.plan import roughness_of
from reports.plots.surfaces import roughness


@pytest.fixture(scope="module")
def stored():
    finer = {"surface.points": 256, "surface.short_cutoff": "10 nm"}
    geometry, _ = prepare(load_scene("rough-periodic", finer))
    return geometry, roughness_of(geometry)


def test_the_spectrum_has_the_exponent_of_the_recipe(stored):
    """C2D ~ q^(-2(1 + H)), H = 0.8, on whole rings: 1 % is left to modes beside a ring's middle."""
    _, document = stored
    q, density = np.log(document.wavenumber), np.log(document.density)
    middle = slice(len(q) // 2, 3 * len(q) // 4)
    slope = np.polyfit(q[middle], density[middle], 1)[0]
    assert slope == pytest.approx(-3.6, rel=0.01)


def test_statistics_are_those_of_the_plan_and_of_gaussian_theory(stored):
    geometry, document = stored
    assert document.rms_slope == geometry.rms_slope
    assert document.nayak > 1.5
    assert document.skewness is None  # every realisation has its own


def test_the_figure_states_them_and_an_indenter_has_none(study, stored):
    scene = study.scenes[1]
    (figure,) = roughness(replace(scene, plan=replace(scene.plan, roughness=stored[1])))
    assert "Nayak's parameter" in figure.caption
    assert figure.x.ticks
    assert figure.y.ticks
    assert roughness(study.scenes[0]) == []
