"""Plots of what physics stores, of paths, histories and speeds, and of why an area fails."""

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pandas as pd
import pytest

from comparisons.judging.truth import Reference
from comparisons.judging.verdicts import Verdict
from comparisons.results.record import SceneRecord
from comparisons.results.rows import Rows
from comparisons.solving.plan import PlanRecord
from reports.plots import curves, errors, interactive, physics, speed
from reports.plots.interactive import spec
from reports.plots.model import failure_view
from reports.plots.pressure import pressure_fields
from reports.plots.stored import SliderSteps, Stored, slider_steps
from reports.plots.style import look
from reports.tables import scene as tables

SCENE = SimpleNamespace(control="sliding_distance", of_one_load=False)


@pytest.fixture
def stores(monkeypatch):
    def store(method: str, level: int, fields: dict[str, np.ndarray]):
        def finest(scene, *names):
            stored = Stored(method, level, fields, look(method).at(level))
            return stored if set(names) <= fields.keys() else None

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
    monkeypatch.setattr(SCENE, "curve", lambda *setting: rows, raising=False)
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
    assert "where the body first yields" in profile.caption
    assert section.map.highest == pytest.approx(1e9)
    assert section.map.y[-1] == 0.0  # the surface at the top
    row = int(np.argmin(np.abs(section.map.y + 2e-3)))
    # down is cut in 119 parts of 3 mm: a point lies within 0.013 mm of the largest stress
    assert section.map.values[3, row] == pytest.approx(1e9, rel=0.02)
    assert "1.00 GPa, 2.00 mm below the surface" in " ".join(profile.caption.split())
    (line,) = profile.series
    assert line.x[line.y.argmax()] == pytest.approx(2e-3)
    # of a part of the surface: another spot may yield first
    stores("fem", 7, stresses() | {"stressed_cells": np.array([256, 128])})
    for figure in physics.stresses_below(SCENE):
        assert "Computed below 256 × 128 cells" in figure.caption
        assert "first yields" not in figure.caption


def record(control: str, axis: str, columns: dict, bar: float = 0.0) -> SceneRecord:
    """Return a scene with a truth and a reduced model that is 1 % off along `columns`."""
    frames = []
    name = next(iter(columns))
    for method, factor, level in (("closed_form", 1.0, 1), ("reduced", 1.01, 40)):
        values = np.asarray(columns[name])
        scale = np.abs(values).max()
        frame = pd.DataFrame(columns | {name: factor * values})
        frame = frame.assign(scene="s", method=method, options="", resolution=level)
        frame = frame.assign(realisation="0", converged=True, reason="", step=range(len(values)))
        frame[f"error_{name}"] = (factor - 1) * values / scale if level > 1 else np.nan
        frame[f"reference_uncertainty_{name}"] = bar
        frames.append(frame.assign(seconds=1e-3, seconds_all=1e-3, setup_seconds=0.0))
    error = {"error": 0.01, "rms": 0.005, "uncertainty": bar, "low": 0.01 - bar, "high": 0.01 + bar}
    setting = {"method": "reduced", "resolution": 40, "quantity": name, "at": axis}
    verdict = Verdict(word="within", tolerance=0.05, signed=False, **setting, **error)
    return SceneRecord(
        *("s", "S", "", control, (name,), 0.05, PlanRecord()),
        Reference("closed_form", 1, "", {name: {"read off": [bar]}}),
        *((verdict,), "", ()),
        rows=Rows.of(pd.concat(frames, ignore_index=True)),
        axis=axis,
    )


LOAD = np.array([1.0, 2.0, 1.0, 0.0, -1.0, -2.0, 0.0, 2.0])
LOOP = {
    "tangential_displacement": 1e-6 * np.array([1, 3, 2.5, 1.5, 0, -3, -1.5, 3]),
    "tangential_force": LOAD,
}


@pytest.fixture
def loop() -> SceneRecord:
    return record("tangential_force", "step", LOOP, bar=0.1)


def trace(figure, name):
    return next(part for part in spec(figure)["data"] if part.get("name") == name)


def test_a_loop_is_drawn_in_the_order_of_the_path(loop):
    (figure,) = curves.curves(loop)
    assert figure.title == "Tangential displacement against tangential force"
    assert trace(figure, "closed form")["x"] == LOAD.tolist()
    assert "order of the path" in figure.caption


def test_the_band_of_a_path_has_one_width_even_where_the_value_is_zero(loop):
    """A bar of 10 % of the largest value: 0.3 um to both sides of every step."""
    (figure,) = curves.curves(loop)
    ribbon = np.array(spec(figure)["data"][0]["y"], dtype=float)  # along one edge, and back
    width = np.abs(ribbon[:8] - ribbon[:7:-1])
    assert width == pytest.approx(np.full(8, 0.6), rel=1e-12)


def test_errors_of_a_path_stand_over_its_steps(loop):
    (figure,) = errors.errors(loop)
    assert figure.title == "Error of tangential displacement at equal step of the path"
    assert trace(figure, "reduced model")["x"] == list(range(1, 9))
    assert spec(figure)["layout"]["xaxis"].get("type") != "log"
    assert "largest value of the path" in figure.caption


def test_a_history_is_drawn_over_time():
    times = np.array([0.0, 1e-3, 2e-3])
    force = {"force": [0.0, 2.0, 1.0], "time": times, "penetration": [0, 1e-6, 1e-6]}
    history = record("penetration", "time", force)
    depth, figure, *_ = curves.curves(history)
    assert depth.title == "Penetration depth against time"  # what is prescribed is seen first
    assert figure.title == "Force against time"
    assert trace(figure, "reduced model")["x"] == pytest.approx([0.0, 1.0, 2.0])
    headers = [head.text for head in tables.load_steps(history).heads]
    assert headers[3:5] == ["time t / ms", "penetration depth d / µm"]


def test_speeds_over_decades_take_a_logarithmic_axis():
    speeds = {"friction_coefficient": [0.1, 0.4, 0.2], "speed": [1e-3, 1e-1, 10.0]}
    figure, _ = curves.curves(record("speed", "speed", speeds))
    assert spec(figure)["layout"]["xaxis"]["type"] == "log"
    assert spec(figure)["layout"]["yaxis"].get("type") != "log"  # 0.1 to 0.4 is no spread
    assert figure.title == "Coefficient of friction against speed"


def test_a_lost_step_of_a_path_is_told_at_its_step(loop):
    rows = loop.rows.frame()
    rows.loc[(rows["method"] == "reduced") & (rows["step"] == 4), "converged"] = False
    rows.loc[~rows["converged"], "reason"] = "it slides away"
    (failure,) = replace(loop, rows=Rows.of(rows)).failures
    assert (failure.load, failure.reason) == (5.0, "it slides away")


def test_errors_against_time_are_those_at_equal_step(loop):
    (figure,) = speed.speed(loop)
    assert figure.title == "Error of tangential displacement at equal step of the path"
    json.dumps(spec(figure), allow_nan=False)


def test_one_value_of_a_whole_path_is_a_point_for_each_method():
    """A pull-off force over the depth would be a level line: a curve of nothing."""
    force = np.full(3, 2e-3)
    columns = {"pull_off_force": force, "penetration": np.array([1e-6, 0.0, -1e-7])}
    (figure,) = curves.curves(record("penetration", "step", columns))
    assert [point.y.tolist() for point in figure.series] == [[2e-3], [pytest.approx(2.02e-3)]]
    assert all(not point.line and point.marks for point in figure.series)
    assert [name for _, name in figure.x.ticks] == ["closed form", "reduced model"]
    assert curves.printed_curves(record("penetration", "step", columns))[0].x.ticks


def test_one_model_beside_its_truth_has_a_difference_where_both_coincide():
    """The caption sends a reader there: 1 % apart, and no third method."""
    columns = {"force": np.array([1.0, 2.0]), "speed": np.array([1.0, 3.0])}
    curve, difference = curves.curves(record("speed", "speed", columns))
    assert "see their differences from the reference" in curve.caption
    (model,) = difference.series
    assert model.y == pytest.approx([0.005, 0.01])  # of the largest, as the record has it


def test_a_path_has_arrows_and_a_load_curve_has_none(study):
    """On a path there and back two branches look alike; arrows turn with the point before."""

    def arrows(scene):
        drawn = [part for figure in curves.curves(scene) for part in spec(figure)["data"]]
        return [part for part in drawn if part.get("marker", {}).get("symbol") == "arrow"]

    scene = study.scenes[0]
    assert arrows(scene) == []
    path = replace(scene, axis="step")
    drawn = arrows(path)
    assert len(drawn) == len(curves.curves(path))
    assert all(part["marker"]["angleref"] == "previous" for part in drawn)
    assert all(part["showlegend"] is False for part in drawn)


@pytest.fixture
def rough(study):
    return study.scenes[1]


def test_surface_line_and_shares_move_with_one_slider(rough):
    figures = failure_view(rough)
    assert [figure.key for figure in figures] == [
        *("failure-surface", "reduced-line", "failure-fractions")
    ]
    for figure in figures:
        assert len(figure.earlier) == len(slider_steps(rough).steps) - 1


def test_the_map_has_a_contact_where_there_is_pressure_and_heights_elsewhere(rough):
    surface = failure_view(rough)[0]
    (item,) = [field for field in pressure_fields(rough) if field.rough]
    pressure = item.pressure.reshape(item.shape)
    values = surface.map.values
    assert values.shape == pressure.shape  # small: nothing is merged
    np.testing.assert_array_equal(values == 1.0, pressure > 0)
    heights = rough.load_fields(item.method, item.resolution)["heights"][pressure <= 0]
    order = np.argsort(heights)
    assert (np.diff(values[pressure <= 0][order]) >= 0).all()


@pytest.mark.parametrize("stored", [False, True])
def test_a_mark_of_many_cells_is_as_pale_as_little_of_it_touches(
    rough, monkeypatch, tmp_path, stored
):
    """The shades add up to the contact: where the page merges cells, and where a field did."""
    for module in ("model", "figure"):
        monkeypatch.setattr(f"reports.plots.{module}.MOST_PIXELS", 30)
    fields = rough.load_fields("bem_fft", 128)
    touching = (fields["pressure"] > 0).reshape(64, 64) * (0.25 if stored else 1.0)
    if stored:
        path = tmp_path / "blocks.npz"
        np.savez(path, **fields, contact=touching)
        rough = replace(rough, fields=rough.fields | {("bem_fft", 128): path})
    surface = failure_view(rough)[0]
    values = surface.map.values
    assert values.shape == (22, 22)  # blocks of 3, and of 1 at the end
    share = np.where(values >= 0.9, (values - 0.9) / 0.1, 0.0)
    sides = np.array([3.0] * 21 + [1.0])
    assert np.sum(share * np.outer(sides, sides)) == pytest.approx(touching.sum())
    assert "the paler the less of it touches" in surface.caption


def test_shares_are_areas_over_the_nominal_one_and_the_ring_stands_at_the_load(rough):
    """A/A0 with A0 the side squared: cells from the centre of the first to that of the last."""
    shares = failure_view(rough)[2]
    x = np.unique(pressure_fields(rough)[-1].x)
    side = np.ptp(x) * len(x) / (len(x) - 1)
    areas = rough.curve("reduced")["contact_area"]
    (model,) = [line for line in shares.series if line.look.label == "area, reduced model"]
    np.testing.assert_allclose(model.y, areas / side**2, rtol=1e-9)
    for step, figure in zip(slider_steps(rough).steps, (*shares.earlier, shares), strict=True):
        assert model.y[step] in figure.series[-1].y


def test_scenes_without_a_rough_surface_or_its_line_have_no_such_view(study, rough):
    assert failure_view(study.scenes[0]) == []
    alone = {key: path for key, path in rough.fields.items() if key[0] != "reduced"}
    assert failure_view(replace(rough, fields=alone)) == []
