"""Plots of what physics stores: films, slip, what yields, wear, stress below a contact."""

from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from reports.plots import interactive, physics
from reports.plots.stored import SliderSteps, Stored

SCENE = SimpleNamespace(control="sliding_distance")


@pytest.fixture
def stores(monkeypatch):
    """Return what gives a scene its only fields."""

    def store(method: str, level: int, fields: dict[str, np.ndarray]):
        def finest(scene, *names):
            return Stored(method, level, fields, method) if set(names) <= fields.keys() else None

        monkeypatch.setattr(physics, "finest_fields", finest)
        return fields

    return store


DRAWN = (
    *(physics.films, physics.slips, physics.dents, physics.worn_profiles),
    physics.stresses_below,
)


@pytest.mark.parametrize("draw", DRAWN)
def test_without_fields_there_is_no_picture(stores, draw):
    stores("fem", 4, {})
    assert draw(SCENE) == []


@pytest.fixture
def film(stores):
    """Return a parabolic film with a cavity behind the middle, as the only field of a scene."""
    x, y = np.meshgrid(np.linspace(-1, 1, 21), np.linspace(-1, 1, 11), indexing="ij")
    grid = {
        "pressure_x": x.ravel(),
        "pressure_y": y.ravel(),
        "pressure": np.clip(1 - x**2 - y**2, 0, None).ravel(),
        "film": (1e-6 * (1 + 8 * (x**2 + y**2))).ravel(),
        "vapour": np.where(x > 0.5, 0.75, 0.0).ravel(),
        "pressure_shape": np.array(x.shape),
    }
    return stores("bem_fft", 16, grid)


def test_the_cavity_is_empty_on_the_map_and_holds_less_oil_in_the_section(film):
    on_map, section = physics.films(SCENE)
    assert np.array_equal(np.isnan(on_map.map.values), np.reshape(film["vapour"] > 0, (21, 11)))
    assert on_map.map.highest == pytest.approx(5e-6)
    thickness, oil, pressure = (series.y for series in section.series)
    assert thickness.max() < 5
    assert np.allclose(oil / thickness, np.where(section.series[0].x > 0.5, 0.25, 1.0))
    assert pressure.max() == 1


def test_films_of_another_shape_are_not_drawn(film):
    film["pressure_shape"] = np.array([20, 11])
    assert physics.films(SCENE) == []


@pytest.fixture
def creeps(stores, monkeypatch):
    """Return the fields of a contact of 2 x 3 cells on a grid of 4 x 5, at two creeps."""
    x, y = np.meshgrid(np.arange(4.0) * 1e-3, np.arange(5.0) * 1e-3, indexing="ij")
    inside = np.zeros((4, 5))
    inside[1:3, 1:4] = 1.0
    fields = {
        "pressure_x": x.ravel(),
        "pressure_y": y.ravel(),
        "pressure": inside.ravel(),
        "pressure_shape": np.array(inside.shape),
        "friction_used": np.where(inside > 0, 1.0, np.nan).ravel(),
        "traction_x": 0.3 * inside.ravel(),
        "traction_y": 0.0 * inside.ravel(),
        "step.0.friction_used": np.where(inside > 0, 0.5, np.nan).ravel(),
        "step.0.traction_x": 0.1 * inside.ravel(),
    }
    monkeypatch.setattr(physics, "slider_steps", lambda scene: SliderSteps((0, 1), ("a", "b")))
    return stores("bem_fft", 4, fields)


def test_a_frame_for_every_creep_on_one_scale(creeps):
    used, traction = physics.slips(SCENE)
    assert (used.key, traction.key) == ("slip-map", "traction-x")
    (before,) = used.earlier
    assert before.map.values.shape == used.map.values.shape == (2, 3)
    assert (before.map.values == 0.5).all()
    assert (used.map.values == 1.0).all()
    assert before.map.highest == used.map.highest == 1.0
    assert "1 where it slips" in used.caption
    heads = [interactive.spec(f)["data"][0]["colorbar"]["title"]["text"] for f in (used, traction)]
    assert [str(head) for head in heads] == ["|q|/(µp)", "q / mPa"]


def test_tractions_follow_the_slider(creeps):
    _, traction = physics.slips(SCENE)
    assert (traction.earlier[0].map.values == 0.1).all()
    assert traction.map.highest == 0.3


def yielded() -> dict[str, np.ndarray]:
    """Return a body that has yielded to a depth of 1 mm, and sunk by 1 um at most."""
    r, z = (axis.ravel() for axis in np.meshgrid(*2 * [np.linspace(0, 4e-3, 41)], indexing="ij"))
    distance, surface = np.hypot(r, z), np.linspace(0, 1e-2, 21)
    return {
        "section_r": r,
        "section_z": z,
        "section_plastic_strain": np.maximum(0.0, 0.01 * (1 - distance / 1e-3)),
        "section_von_mises": 1e8 / (1 + distance / 1e-3),
        "surface_r": surface,
        "surface_depth": 1e-6 * np.exp(-surface / 1e-3),
    }


def test_a_section_has_the_surface_at_the_top_and_the_axis_on_the_left(stores):
    stores("fem", 4, yielded())
    zone, stress, surface = physics.dents(SCENE)
    for figure, highest in ((zone, 0.01), (stress, 1e8)):
        drawn = figure.map
        assert drawn.values[0, -1] == pytest.approx(highest)  # at r = z = 0
        assert drawn.y[-1] == 0.0
        assert drawn.y[0] < 0
        assert np.isfinite(drawn.values).all()
    assert (zone.map.values >= 0).all()
    (line,) = surface.series
    assert line.y.min() == pytest.approx(-1e-6)


def test_dents_of_a_rough_surface_are_a_map_over_it(stores):
    depth = np.zeros((4, 6))
    depth[1, 2] = 3e-9
    stores("bem_fft", 4, {"dent": depth, "size": np.array([4e-6, 6e-6])})
    (figure,) = physics.dents(SCENE)
    assert figure.map.values.shape == (4, 6)
    assert figure.map.highest == 3e-9
    np.testing.assert_allclose(figure.map.x, (np.arange(4) + 0.5) * 1e-6)


def test_what_has_not_yielded_has_no_picture(stores):
    elastic = yielded()
    elastic["section_plastic_strain"] *= 0
    stores("fem", 4, elastic)
    assert physics.dents(SCENE) == []


@pytest.fixture
def shapes(stores, monkeypatch):
    """Return a parabola that is cut flat twice, as the only field of a scene."""
    x = np.linspace(-1e-3, 1e-3, 41)
    unworn = x**2 / 2e-2
    fields = {
        "worn_r": x,
        "worn_shapes": np.array([unworn, np.maximum(unworn, 1e-6), np.maximum(unworn, 4e-6)]),
    }
    rows = pd.DataFrame({"sliding_distance": [1e-3, 2e-3]})
    monkeypatch.setattr(physics.selection, "curve", lambda *setting: rows)
    return stores("bem_fft", 16, fields)


def test_every_step_has_its_curve_near_the_contact(shapes):
    (figure,) = physics.worn_profiles(SCENE)
    labels = [series.look.label.replace("\u202f", " ") for series in figure.series]
    assert labels == ["unworn", "1.00 mm", "2.00 mm"]
    before, _, last = figure.series
    assert last.y.min() == 4e-6
    assert before.y.max() <= 1.5 * 4e-6
    assert before.x.size < shapes["worn_r"].size
    assert "N = 16" in figure.caption


def test_what_is_broken_or_not_worn_is_not_drawn(shapes):
    shapes["worn_shapes"] = shapes["worn_shapes"][:1]
    assert physics.worn_profiles(SCENE) == []
    shapes["worn_shapes"] = np.array([np.ones(3), np.ones(3)])
    assert physics.worn_profiles(SCENE) == []


def stresses() -> dict[str, np.ndarray]:
    """Return a stress that is largest 2 mm below the place (3, 1) mm, on a mesh."""
    x, y, depth = np.arange(7) * 1e-3, np.arange(4) * 1e-3, np.array([0.0, 0.5, 1, 2, 4]) * 1e-3
    z, *across = np.meshgrid(depth, x, y, indexing="ij")
    points = np.stack([*across, z], axis=-1)
    away = np.linalg.norm(points - np.array([3e-3, 1e-3, 2e-3]), axis=-1)
    stress = 1e9 / (1 + away / 1e-3)
    return {
        "mesh_points": points.reshape(-1, 3),
        "mesh_von_mises": stress.ravel(),
        "von_mises_depth": depth,
        "von_mises_highest": stress.max(axis=(1, 2)),
    }


def test_the_section_goes_through_the_largest_stress_and_the_depth_is_told(stores):
    stores("fem", 7, stresses())
    section, profile = physics.stresses_below(SCENE)
    assert section.map.highest == pytest.approx(1e9)
    assert section.map.y[-1] == 0.0  # the surface at the top
    row = int(np.argmin(np.abs(section.map.y + 2e-3)))
    # down is cut in 119 parts of 3 mm: a point lies within 0.013 mm of the largest stress
    assert section.map.values[3, row] == pytest.approx(1e9, rel=0.02)
    assert "1.00 GPa, 2.00 mm below the surface" in " ".join(profile.caption.split())
    (line,) = profile.series
    assert line.x[line.y.argmax()] == pytest.approx(2e-3)
