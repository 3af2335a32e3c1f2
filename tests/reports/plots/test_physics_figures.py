"""Plots of paths, histories and speeds: loops stay loops, and errors stand over the steps."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

from comparisons.judging.reference import Reference
from comparisons.judging.verdicts import Verdict
from comparisons.results import selection
from comparisons.results.rows import Rows
from comparisons.results.store import SceneRecord
from comparisons.solving.plan_record import PlanRecord
from reports.plots import curves, errors, speed
from reports.plots.interactive import spec
from reports.tables import scene as tables


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
        Reference("closed_form", 1, "", {name: bar}),
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
    assert "largest value along the path" in figure.caption


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
    (failure,) = selection.failures(replace(loop, rows=Rows.of(rows)))
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


def test_one_model_beside_its_truth_has_a_ratio_where_both_coincide():
    """The caption sends a reader there: 1 % apart, and no third method."""
    columns = {"force": np.array([1.0, 2.0]), "speed": np.array([1.0, 3.0])}
    curve, ratio = curves.curves(record("speed", "speed", columns))
    assert "see their ratios to the reference" in curve.caption
    (model,) = ratio.series
    assert model.y == pytest.approx([1.005, 1.01])  # of the largest, as the record has it


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
