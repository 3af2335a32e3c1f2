"""Plots: what they show of the data, the same in both renderers, accepted by plotly itself."""

import base64
import json
from dataclasses import replace

import numpy as np
import pytest

import roughline
from comparisons.facts.methods import BUILT_IN, ours
from comparisons.geometry.prepare import prepare
from comparisons.results.rows import Rows
from comparisons.scene.scene import load_scene
from comparisons.solving.plan import roughness_of
from reports.pages.study import page
from reports.plots import curves, errors, interactive, model, speed
from reports.plots import pressure as pressure_figures
from reports.plots.axes import error_axis, log_ticks, value_axis
from reports.plots.claims import validity_map
from reports.plots.errors import sweeps
from reports.plots.figure import MOST_PIXELS, coarsened
from reports.plots.interactive import spec
from reports.plots.style import LOOKS, look
from reports.plots.surfaces import roughness

TOKENS = {
    "@truth-band": "#888888",
    "@ink-band": "#888888",
    "@ink": "#000000",
    "@muted": "#777777",
    "@peer": "#767676",
}


def all_figures(scene):
    result = [*curves.curves(scene), *errors.errors(scene), *speed.speed(scene)]
    result += pressure_figures.pressures(scene)
    return [*result, model.reduced_picture(scene)]


def traces(figure, name):
    return [trace for trace in spec(figure)["data"] if trace.get("name") == name]


@pytest.mark.parametrize("number", [0, 1])
def test_plotly_accepts_every_figure(study, number):
    """plotly.graph_objects validates each property against plotly.js' own schema."""
    graph_objects = pytest.importorskip("plotly.graph_objects")
    for figure in all_figures(study.scenes[number]):
        text = json.dumps(spec(figure), allow_nan=False)
        for token, colour in TOKENS.items():
            text = text.replace(token, colour)
        assert '"@' not in text, "a colour the page does not know"
        for shown in at_every_load(json.loads(text)):
            graph_objects.Figure(shown)


def at_every_load(spec):
    """Return a figure as the page draws it: as it opens, and with each frame laid over it."""
    frames = [{"data": [{}] * len(spec["data"])}, *spec.pop("frames", [])]
    for frame in frames:
        traces = [trace | new for trace, new in zip(spec["data"], frame["data"], strict=True)]
        for trace in traces:
            if "codes" in (z := trace.get("z", ())):
                trace["z"] = decoded(z).tolist()
        yield {"data": traces, "layout": spec["layout"] | frame.get("layout", {})}


def decoded(coded):
    codes = np.frombuffer(base64.b64decode(coded["codes"]), "<u2").reshape(coded["shape"])
    return np.where(codes > 0, codes * coded["step"] - coded.get("below", 0.0), np.nan)


def test_methods_differ_in_colour_marker_and_dash():
    """Colour alone must not carry the meaning."""
    for part in ("colour", "marker", "dash", "label"):
        values = [getattr(LOOKS[name], part) for name in ours() if name in BUILT_IN]
        assert len(set(values)) == len(values), part
    for renderer in ("plotly", "matplotlib"):
        for part in ("marker", "dash"):
            values = [getattr(getattr(item, part), renderer) for item in LOOKS.values()]
            assert len(set(values)) == len(values), (part, renderer)
    assert len({item.label for item in LOOKS.values()}) == len(LOOKS)
    assert look("reduced").colour == "#D55E00"
    assert look("bem_fft").colour == "#0072B2"
    assert look("tamaas").colour == "@peer"
    own = [look(name, among="abcdefghijkl") for name in "abcdefghijkl"]  # grey, but no two alike
    assert len({(item.marker, item.dash) for item in own}) == len(own)
    # whatever was drawn before
    assert [look(name, among="lkjihgfedcba") for name in "lkjihgfedcba"] == own[::-1]


def test_curves_carry_the_values_in_the_unit_of_the_axis(study):
    scene = study.scenes[0]
    force = curves.curves(scene)[0]
    rows = scene.curve("closed_form")
    (trace,) = traces(force, "closed form")
    assert spec(force)["layout"]["xaxis"]["title"]["text"] == "penetration depth d / µm"
    assert spec(force)["layout"]["yaxis"]["title"]["text"] == "force F / N"
    # six digits are kept in the page
    np.testing.assert_allclose(trace["x"], rows["penetration"] * 1e6, rtol=1e-5)
    np.testing.assert_allclose(trace["y"], rows["force"], rtol=1e-5)


def test_curves_that_coincide_are_shown_as_differences_too(study):
    """A line of 2 px on 300 px hides 1 %. Ticks are 20 ppm or 0.1 %, never 1.000020."""
    scene = study.scenes[0]
    shown = {figure.key: figure for figure in curves.curves(scene)}
    (trace,) = traces(shown["difference-force"], "FFT BEM")
    error = scene.curve("bem_fft")["error_force"]
    np.testing.assert_allclose(trace["y"], 100 * error, rtol=1e-5)  # six digits in the page
    assert shown["difference-force"].y.label == "relative difference ΔF / %"
    assert "differences" in shown["curve-force"].caption

    def within(error):
        rows = Rows.of(scene.rows.frame().assign(error_force=error))
        return {figure.key: figure for figure in curves.curves(replace(scene, rows=rows))}

    (trace,) = traces(within(2e-5)["difference-force"], "FFT BEM")
    assert trace["y"] == [20.0] * len(error)
    assert within(2e-5)["difference-force"].y.scale.unit == "ppm"
    assert "difference-force" not in within(0.2)


def test_axes_become_logarithmic_with_the_span_of_the_loads(study):
    linear, rough = (spec(curves.curves(scene)[0])["layout"] for scene in study.scenes)
    assert linear["xaxis"]["type"] == linear["yaxis"]["type"] == "linear"
    assert rough["xaxis"]["type"] == rough["yaxis"]["type"] == "log"


def test_ensembles_show_the_mean_between_its_bands(study):
    scene = study.scenes[1]
    area = next(item for item in curves.curves(scene) if item.key == "curve-contact_area")
    bands = [trace for trace in spec(area)["data"] if trace.get("fill") == "toself"]
    (mean,) = traces(area, "reduced model")
    # quantiles and standard error for two methods, and the uncertainty of the reference
    assert len(bands) == 5
    assert len(mean["y"]) == 8
    for item in bands[-2:]:
        count = len(item["x"]) // 2
        low, high = item["y"][:count], item["y"][: count - 1 : -1]
        assert all(a <= b <= c for a, b, c in zip(low, mean["y"], high, strict=True))


def test_errors_at_a_prescribed_mean_gap_are_at_equal_gap(study):
    """It has no counterpart: force and depth are compared there, too, and not at each other."""
    figures = errors.errors(replace(study.scenes[1], control="mean_gap"))
    assert [figure.title for figure in figures] == [
        "Error of penetration depth at equal mean gap",
        "Error of contact area at equal mean gap",
    ]


def test_errors_tell_their_sign_on_hover_and_have_one_marker(study):
    """Hollow means "without set-up" or "failed" elsewhere; a legend shows what is drawn."""
    figure = errors.errors(study.scenes[0])[0]
    (fem,), (bem,) = traces(figure, "FEM"), traces(figure, "FFT BEM")
    assert fem["marker"]["symbol"] == "triangle-up"
    assert all("error \u2212" in text for text in fem["text"])  # the fixture's FEM is too soft
    assert all("\u2212" not in text.split("error")[1] for text in bem["text"])


def test_errors_of_all_quantities_share_their_limits(study):
    for scene in study.scenes:
        ranges = [spec(figure)["layout"]["yaxis"]["range"] for figure in errors.errors(scene)]
        assert len(ranges) > 1
        assert all(limits == ranges[0] for limits in ranges)


def test_what_is_below_the_axis_is_an_arrow_at_its_foot(study):
    """Round-off is no value: no point stands on the axis, and the lowest tick says "at most"."""
    scene = study.scenes[0]
    tiny = np.where(scene.rows["method"] == "reduced", 1e-13, scene.rows["error_force"])
    rows = Rows.of(scene.rows.frame().assign(error_force=tiny))
    figure = errors.errors(replace(scene, rows=rows))[0]
    points, arrows = traces(figure, "reduced model")
    layout = spec(figure)["layout"]["yaxis"]
    foot = 10 ** layout["range"][0]
    assert set(points["y"]) == {None}
    assert arrows["y"] == pytest.approx([foot] * len(arrows["y"]))
    assert arrows["marker"]["symbol"] == "arrow-down"
    assert layout["ticktext"][0].startswith("\u2264")
    assert foot >= 1e-5 * scene.tolerance


def test_the_reference_is_not_compared_with_itself(study):
    for figure in errors.errors(study.scenes[0]):
        assert not traces(figure, "closed form")
    for figure in errors.errors(study.scenes[1]):
        (trace,) = traces(figure, "FFT BEM")
        assert all("N = 64" in text for text in trace["text"])


def test_a_lost_solve_is_a_hollow_cross_at_the_upper_edge(study):
    figure = speed.speed(study.scenes[0])[0]
    (cross,) = traces(figure, "dense BEM: failed")
    edge = 10 ** spec(figure)["layout"]["yaxis"]["range"][1]
    assert cross["marker"]["symbol"] == "x-open"
    assert cross["y"] == pytest.approx([edge], rel=0.01)
    assert cross["x"] == pytest.approx([1.024])  # 4 ms growing 16-fold twice
    assert "active set cycled" in cross["text"][0]


def test_setup_is_taken_off_at_the_hollow_marker(study):
    figure = speed.speed(study.scenes[0])[0]
    (full,), (rest,) = traces(figure, "FEM"), traces(figure, "FEM, without set-up")
    assert rest["x"] == pytest.approx([0.3 * value for value in full["x"]], rel=1e-4)
    assert rest["y"] == full["y"]
    assert rest["marker"]["symbol"] == "triangle-up-open"
    assert "Hollow: without the set-up" in figure.caption
    assert not {"Shaded:", "*"} & {*figure.caption.split()}  # Hertz is exact
    whole = Rows.of(study.scenes[0].rows.frame().assign(setup_seconds_all=0.0))
    assert "Hollow" not in speed.speed(replace(study.scenes[0], rows=whole))[0].caption


def test_no_setting_lies_below_the_front(study):
    for scene in study.scenes:
        for figure in speed.speed(scene):
            (front,) = traces(figure, "Pareto front")
            corners = list(zip(front["x"], front["y"], strict=True))
            for trace in spec(figure)["data"]:
                if trace.get("mode") != "lines+markers":
                    continue
                for time, error in zip(trace["x"], trace["y"], strict=True):
                    best = min(y for x, y in corners if x <= time * (1 + 1e-9))
                    assert best <= error * (1 + 1e-9)


def test_the_reference_is_marked_at_its_own_uncertainty(study):
    figure = speed.speed(study.scenes[1])[0]
    (mark,) = traces(figure, "reference (FFT BEM)")
    assert mark["y"] == [0.01]
    assert spec(figure)["layout"]["yaxis"]["range"][0] == -3  # the decade below the bar, no more
    assert {"Shaded:", "*"} < {*figure.caption.split()}


def test_an_error_below_the_bar_of_the_reference_is_no_achievement(study):
    """The reference is known to 1 %: errors of 0.1 % are arrows there, and the legend says so.

    Of points that are all at the bar the first is best in both: there is no front to draw.
    """
    scene = study.scenes[1]
    verdicts = tuple(replace(item, error=1e-3) for item in scene.verdicts)
    figure = speed.speed(replace(scene, verdicts=verdicts))[0]
    (points, arrows) = traces(figure, "reduced model")
    assert points["y"] == [None, None, None]
    assert arrows["y"] == [0.01, 0.01, 0.01]
    assert not traces(figure, "Pareto front")
    (legend,) = traces(figure, "at or below the bar")
    assert legend["marker"]["symbol"] == arrows["marker"]["symbol"]
    assert not traces(speed.speed(scene)[0], "at or below the bar")


def test_the_end_of_the_premise_of_rough_lines_is_marked(study):
    """A = 0.9 A0 (F / 10 uN)^0.95: a tenth of the apparent area at 0.99 uN."""
    scene = study.scenes[1]
    truth = scene.rows["method"] == "bem_fft"
    area = np.where(truth, 0.9e-12 * (scene.rows["force"] / 1e-5) ** 0.95, 1e-14)
    length = np.where(truth, np.nan, 1e-7)
    rows = scene.rows.frame().assign(contact_area=area, contact_length=length)
    for figure in errors.errors(replace(scene, rows=Rows.of(rows))):
        assert [guide.value for guide in figure.guides] == pytest.approx([9.9e-7], rel=1e-3)
        assert "premise of rough lines has ended" in figure.caption
    for figure in errors.errors(scene):  # no lines
        assert not figure.guides


def test_pressure_is_made_dimensionless_by_the_reference(study):
    """Hertz: the peak is 3/2 of the mean pressure and vanishes at r = a."""
    (figure,) = pressure_figures.pressures(study.scenes[0])
    (exact,) = traces(figure, "closed form")
    assert exact["y"][0] == pytest.approx(1.5, rel=1e-5)
    assert all(p == 0 for r, p in zip(exact["x"], exact["y"], strict=True) if r > 1)


def test_rough_contacts_get_a_map_with_gaps_between_contacts(study):
    figure = pressure_figures.pressures(study.scenes[1])[0]
    stored = study.scenes[1].load_fields("bem_fft", 128)
    pressure = stored["pressure"].reshape(64, 64)
    z = decoded(spec(figure)["data"][0]["z"])
    # plotly's first index runs along y
    np.testing.assert_array_equal(np.isfinite(z), pressure.T > 0)
    highest = np.nanmax(z)
    np.testing.assert_allclose(
        z[pressure.T > 0] / highest,
        pressure.T[pressure.T > 0] / pressure.max(),
        atol=1e-4,  # a code is 1/65535 of the highest value
    )
    assert spec(figure)["layout"]["yaxis"]["scaleanchor"] == "x"


def test_the_difference_of_two_pressures_keeps_its_sign_on_the_page():
    """A code is 2/65535 of the largest magnitude; a gap is no zero."""
    values = np.array([[-3.0, np.nan, 0.0], [2.0, 1e-6, -1.0]])
    shown = decoded(interactive.coded_map(values, signed=True))
    np.testing.assert_allclose(shown, values, atol=3.0 * 2 / 65535)
    _, _, small = coarsened(np.arange(200.0), np.arange(2.0), np.outer(np.arange(200), [-1, 0]))
    assert small.min() == -199


@pytest.mark.parametrize("mesh", [False, True])
def test_elements_are_compared_with_the_grid_on_the_same_cells(study, monkeypatch, mesh):
    """Of p = 1 + x the elements have 10 % more: as means of cells, and between points of a mesh."""
    x, y = (np.ravel(axis) for axis in np.meshgrid(*[np.arange(8.0) - 3.5] * 2, indexing="ij"))
    grid = pressure_figures.Field("bem_fft", 8, "BEM", x, y, 10 + x + y, (8, 8), rough=True)
    fine = (np.ravel(a) for a in np.meshgrid(*[np.arange(16) / 2 - 3.75] * 2, indexing="ij"))
    x, y = fine
    if mesh:
        x, y = 1.1 * x, 1.1 * y  # around the outer cells
    shape = (len(x),) if mesh else (16, 16)
    elements = pressure_figures.Field("fem", 16, "FEM", x, y, 1.1 * (10 + x + y), shape, rough=True)
    monkeypatch.setattr(pressure_figures, "pressure_fields", lambda scene: [grid, elements])
    figures = {figure.key: figure for figure in pressure_figures.pressures(study.scenes[1])}
    difference = figures["pressure-difference"].map
    np.testing.assert_allclose(difference.values.ravel(), 0.1 * grid.pressure, atol=1e-9)
    assert difference.signed
    assert spec(figures["pressure-difference"])["data"][0]["zmin"] < 0
    assert figures.keys() >= {"pressure-map-bem_fft", "pressure-map-fem"}


def test_large_maps_and_long_lines_keep_their_peaks():
    rng = np.random.default_rng(3)
    values = rng.random((300, 270))
    side = np.arange(300.0), np.arange(270.0)
    x, y, small = coarsened(*side, values)
    assert max(small.shape) <= MOST_PIXELS
    assert small.shape == (len(x), len(y))
    assert small.max() == values.max()
    x = np.linspace(0, 1, 20000)
    y = np.zeros_like(x)
    y[12345] = 1.0
    short_x, short_y = model.thinned(x, y)
    assert len(short_x) <= model.MOST_LINE_POINTS
    assert short_y.max() == 1.0
    assert np.all(np.diff(short_x) > 0)


def test_ticks_of_logarithmic_axes_stay_few_inside_and_of_one_unit():
    for low, high in [(1e-6, 1e-1), (0.9, 30), (1e-16, 1.0), (0.2, 0.4)]:
        ticks = [value for value, _ in log_ticks((low, high), str)]
        assert 1 <= len(ticks) <= 11
        assert low * 0.99 <= ticks[0]
        assert ticks[-1] <= high * 1.01
    # without ticks of ours plotly numbers 9, 1, 2 ... 9 without their powers of ten
    assert not value_axis("force", np.array([1.2, 1.8]), log=True).log
    assert value_axis("force", np.array([1.2, 18.0]), log=True).ticks
    # an axis of errors has one unit
    assert all(text.endswith("%") for _, text in error_axis(1e-8, 10.0, "error").ticks)


def test_a_setting_without_any_answer_has_no_curve(study):
    """As where the finest grid lost all its steps; the page then ended in an error."""
    assert not len(study.scenes[0].curve("reduced", 10**6))


@pytest.fixture(scope="module")
def stored():
    finer = {"surface.points": 256, "surface.short_cutoff": "10 nm"}
    geometry, _ = prepare(load_scene("rough-periodic", finer))
    return geometry, roughness_of(geometry)


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


ELLIPSOIDS = {
    "name": "ellipsoids",
    "half_space": {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
    "indenter": {"shape": "ellipsoid", "radius_x": "10 mm", "radius_y": "10 mm"},
    "loading": {"force": ["100 N", "200 N"]},
}


@pytest.fixture
def of(tmp_path):
    def solved(sweep):
        tables = ELLIPSOIDS | {"sweep": sweep}
        study = roughline.Study(tables, tmp_path / "out", methods=["closed_form", "reduced"])
        return study.run().record

    return solved


@pytest.mark.slow
def test_the_springs_of_a_round_line_err_more_the_longer_the_ellipse(of):
    """Force at equal depth: (19.17) for an ellipse errs by -1, -5 % at radii of 2, 5 to one."""
    record = of({"indenter.radius_x": ["20 mm", "50 mm", "10 mm"]})
    force = next(figure for figure in sweeps(record.scenes) if figure.quantity == "force")
    assert force.x.ticks == ((0.01, "10 mm"), (0.02, "20 mm"), (0.05, "50 mm"))
    model = next(series for series in force.series if "reduced" in series.look.label)
    np.testing.assert_array_equal(model.x, [0.01, 0.02, 0.05])
    np.testing.assert_allclose(model.y[1:], [0.0099, 0.051], rtol=0.02)
    assert "Along the sweep" in page(record, with_pictures=False)


def test_words_stand_one_after_the_other(of):
    record = of({"methods.reduced.rule": ["mdr", "half_radius"]})
    (first, *_) = sweeps(record.scenes)
    assert first.x.ticks == ((1.0, "mdr"), (2.0, "half_radius"))


def test_every_tolerance_of_a_sweep_has_its_line(of):
    (first, *_) = sweeps(of({"compare.tolerance": [0.05, 0.001]}).scenes)
    assert [level.value for level in first.levels] == [0.001, 0.05]


def test_no_sweep_no_figure(study):
    assert sweeps(study.scenes) == []


def test_the_map_has_a_row_for_each_claim_and_a_point_for_each_scene(study):
    """A paraboloid has the exponent 2 on the row of the transform, which was measured to 6."""
    ball = replace(study.scenes[0], text=load_scene("paraboloid").text)
    figure = validity_map([ball])
    assert figure.y.ticks[0][1] == "force, 0.01\u202f%: n = 1 \N{HORIZONTAL ELLIPSIS} 6"
    place = (2.0 - 1.0) / (6.0 - 1.0)
    np.testing.assert_allclose(figure.series[-1].x, place, atol=1e-12)
    assert validity_map(()) is None


def test_the_row_of_a_ball_ends_where_every_method_takes_large_slopes_as_small(study):
    """From d/a = 0.3 on, d/R = 0.087 of a ball: the points at 0.1, 0.32 and 1 of 9 say nothing."""
    ball = replace(study.scenes[0], text=load_scene("sphere").text)
    figure = validity_map([ball])
    x = {item.look.label: np.unique(item.x[np.isfinite(item.x)]) for item in figure.series}
    assert x["within"] == pytest.approx(np.arange(6) / 8)
    assert x["slopes too large: agreement says nothing"] == pytest.approx(np.arange(6, 9) / 8)


def test_damaged_scenes_and_such_with_files_are_left_out(study):
    """A folder may be a stranger's: no file that it names is opened for a map."""
    ball = study.scenes[0]
    for text in ("[indenter]\nshape = 'teapot'", "surface = {file = '/etc/passwd'}", "not TOML"):
        assert validity_map([replace(ball, text=text)]) is None


def printed(figure):
    pytest.importorskip("matplotlib", reason="the extra `paper` is not installed")
    from reports.paper.figures import single

    (axes,) = single(figure).axes
    return axes


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("build", [curves.curves, errors.errors, speed.speed])
def test_print_and_page_show_the_same_points(study, number, build):
    """To the six digits that the page keeps; hollow markers without set-up are the page's only."""
    for figure in build(study.scenes[number])[:2]:
        lines = {line.get_label(): line for line in printed(figure).get_lines()}
        traces = [t for t in spec(figure)["data"] if t.get("name") and t.get("showlegend", True)]
        assert traces  # of a ratio to the reference there may be one
        for trace in traces:
            if all(y is None for y in trace["y"]):
                continue
            line = lines[trace["name"]]
            np.testing.assert_allclose(line.get_xdata(), np.array(trace["x"], float), rtol=1e-5)
            np.testing.assert_allclose(line.get_ydata(), np.array(trace["y"], float), rtol=1e-5)


def test_print_and_page_have_the_same_limits_and_ticks(study):
    (figure, *_) = errors.errors(study.scenes[0])
    axes, layout = printed(figure), spec(figure)["layout"]
    np.testing.assert_allclose(np.log10(axes.get_ylim()), layout["yaxis"]["range"], rtol=1e-9)
    assert [label.get_text() for label in axes.get_yticklabels()] == layout["yaxis"]["ticktext"]
    assert (
        layout["yaxis"]["title"]["text"] == "relative error |e|"
    )  # the heading names the quantity
    assert axes.get_ylabel() == "relative error of force"


def test_frames_hold_only_what_a_load_changes(study):
    from reports.plots.pressure import pressures

    (figure,) = pressures(study.scenes[0])
    assert figure.earlier
    for frame in spec(figure)["frames"]:
        assert all(set(trace) <= {"x", "y"} for trace in frame["data"])


@pytest.mark.parametrize("number", [3, 7])
def test_long_ticks_end_at_their_place_so_that_the_last_is_not_hidden(study, number):
    figure = curves.curves(study.scenes[0])[0]
    ticks = tuple((float(k + 1), f"crop at {320 * k}, 240") for k in range(number))
    axis = spec(replace(figure, x=replace(figure.x, ticks=ticks)))["layout"]["xaxis"]
    assert max(axis.get("autotickangles", [axis.get("tickangle", 30)])) == 0
