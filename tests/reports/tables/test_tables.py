"""Tables in several renderers, and the card of a scene."""

import re
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

import roughline
from comparisons import formatting as fmt
from comparisons.judging.verdicts import Verdict
from comparisons.results.advice import advise
from comparisons.results.rows import Rows
from comparisons.scene.fields import PRESSURE, number_and_unit, to_si
from comparisons.scene.scene import builtin_names, load_scene
from comparisons.solving.plan import Roughness
from reports.pages.page import environment
from reports.plots.stored import slider_steps
from reports.tables import cells
from reports.tables.card import _bodies, card, true_value
from reports.tables.cells import table, tone
from reports.tables.judged import (
    TRUE,
    finding_table,
    not_computed,
    others_table,
    prepared_table,
    verdict_table,
)
from reports.tables.scene import load_steps, settings, spots
from reports.tables.written import alignment, drawn, frame, in_markdown, latex, rewrite
from roughline import notebook

HOSTILE = "a|b [bold] <i> $x"


@pytest.fixture
def judged():
    rows = [
        (cells.method("bem_fft"), cells.count(1024), cells.error(0.0123, 0.0004), HOSTILE),
        (cells.method("reduced"), cells.count(40), cells.NOTHING, cells.verdict("within")),
    ]
    return table(("method", "N", "error", "what"), rows, title="Errors", strong=frozenset({1}))


def on_a_terminal(given) -> str:
    console = Console(width=200, emoji=False, markup=False)
    with console.capture() as said:
        console.print(drawn(given))
    return said.get()


def on_a_page(given) -> str:
    source = '{% import "macros.html.j2" as part with context %}{{ part.data_table(t, "L", "id") }}'
    return environment().from_string(source).render(t=given)


def test_every_renderer_says_the_same_words(judged):
    texts = [on_a_terminal(judged), on_a_page(judged), str(notebook.table(judged))]
    for text in [*texts, latex(judged, "x"), in_markdown(judged)]:
        for word in ("FFT BEM", "reduced model", "1\u202f024", "within"):
            assert word.replace("\u202f", r"\,") in text.replace("\u202f", r"\,")


def test_an_error_has_its_sign_and_bar_in_print_as_on_the_screen(judged):
    assert "+1.23 ± 0.04\u202f%" in on_a_terminal(judged)
    assert 'data-key="0.0123" data-bar="0.0004"' in on_a_page(judged)
    assert "+1.23 ± 0.04\u202f%" in in_markdown(judged)
    missing = Verdict(quantity="pressure", at="force", tolerance=0.01, reason="not computed")
    page = on_a_page(table(("error",), [(cells.of_verdict(missing),)]))
    assert 'title="not computed" data-key="nan">–</td>' in page
    assert r"+1.23 $\pm$ 0.04\,\%" in latex(judged, "x")


def test_text_of_strangers_is_text_in_every_renderer(judged):
    assert HOSTILE in on_a_terminal(judged)
    assert "&lt;i&gt;" in on_a_page(judged)
    assert "&lt;i&gt;" in notebook.table(judged)
    assert r"a\|b \[bold\] &lt;i&gt;" in in_markdown(judged)
    assert r"\$x" in latex(judged, "x")


def test_numbers_stand_to_the_right_and_are_numbers_in_a_frame(judged):
    assert alignment(judged) == "lrrl"
    assert frame(judged)["N"].tolist() == [1024, 40]


def test_a_verdict_has_the_colour_of_its_tone(judged):
    assert f'<span class="verdict {tone("within")}">within</span>' in on_a_page(judged)
    assert "#00624a" in notebook.table(judged)


def test_columns_are_chosen_by_their_heads(judged):
    assert [head.text for head in judged.only("N", "method").heads] == ["N", "method"]
    assert [head.text for head in judged.without("N").heads] == ["method", "error", "what"]
    assert len(judged.first(1).rows) == 1


def test_tables_between_markers_are_made_anew_and_others_are_printed(tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text(
        "a\n<!-- table: x -->\nold\n<!-- end -->\nb\n<!-- table: y -->\nz\n<!-- end -->\n"
    )
    tables = {name: lambda: [["h"], ["1"]] for name in "xyz"}
    rewrite(page, tables, ["x", "z"])
    text = page.read_text()
    assert "a\n<!-- table: x -->\n| h |\n|---|\n| 1 |\n<!-- end -->\nb\n" in text
    assert "<!-- table: y -->\nz\n" in text
    assert capsys.readouterr().out == "z\n\n| h |\n|---|\n| 1 |\n\n"


BALL = {
    "name": "ball",
    "half_space": {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
    "indenter": {"shape": "paraboloid", "radius": "10 mm"},
    "loading": {"penetration": ["1 um", "16 um"]},
}


@pytest.fixture
def of(tmp_path):
    """Return the card of a ball under two loads, but for the tables that are given."""

    def solved(*methods, scene=BALL, **tables) -> dict[str, str]:
        given = {name: part for name, part in (scene | tables).items() if part is not None}
        methods = list(methods or ("closed_form", "reduced"))
        study = roughline.Study(given, tmp_path / "out", methods=methods)
        return dict(card(study.run().record.scenes[0]))

    return solved


def test_a_hertzian_contact_tells_its_peak_pressure_and_which_steel_would_yield(of):
    """p0 = 2 E* sqrt(d/R)/pi, mean 2/3 of it, Y = p0/1.61 (Johnson 1985, eq. 4.24 and 6.6)."""
    told = of()
    modulus = 210e9 / (1 - 0.3**2)
    peak = 2 * modulus * np.sqrt(16e-6 / 10e-3) / np.pi
    assert told["half space"] == "Young's modulus 210\u202fGPa, Poisson's ratio 0.3"
    assert told["indenter"] == "rigid paraboloid, radius 10\u202fmm"
    assert told["effective modulus E*"] == fmt.with_unit(modulus, "Pa")
    assert told["penetration depth"] == "1.00\u202fµm to 16.0\u202fµm"
    assert told["mean pressure F/A"].endswith(fmt.with_unit(2 / 3 * peak, "Pa"))
    assert told["highest pressure, last load"] == fmt.with_unit(peak, "Pa")
    # The constant is printed with three digits in the book: 1.60 for the nu of 0.3.
    number, unit = number_and_unit(told["von Mises' stress"].split(",")[0])
    assert (number, unit) == (pytest.approx(peak / 1e9 / 1.61, rel=5e-3), "GPa")


def test_an_impact_tells_the_pressure_and_stress_at_its_deepest_point(of):
    """Energy: d = (15 m v^2/(16 E* sqrt R))^(2/5); then as pressed so deep."""
    told = of(dynamics={"mass": "32.7 g", "velocity": "5 m/s"}, loading=None)
    modulus = 210e9 / (1 - 0.3**2)
    depth = (15 / 16 * 0.0327 * 25 / (modulus * np.sqrt(10e-3))) ** 0.4
    peak = 2 * modulus * np.sqrt(depth / 10e-3) / np.pi
    assert told["highest pressure"] == fmt.with_unit(peak, "Pa")
    number, unit = number_and_unit(told["von Mises' stress"].split(",")[0])
    assert (number, unit) == (pytest.approx(peak / 1e9 / 1.61, rel=5e-3), "GPa")


def test_where_all_loads_agree_to_round_off_the_true_values_are_those_of_all(tmp_path):
    solved = roughline.Study(BALL, tmp_path / "out", methods=["closed_form", "reduced"]).run()
    rows = frame(verdict_table(solved.record.scenes, "reduced")).set_index("quantity")
    assert abs(rows["largest error"]["contact area"]) < fmt.ROUND_OFF
    # pi R d of Hertz, at 1 and 16 um
    assert rows[TRUE]["contact area"] == "0.0314\u202fmm² to 0.503\u202fmm²"


def test_the_area_of_a_flat_face_is_given_and_has_no_bar(of):
    """The force is found, and known as well as its grids are."""
    square = {"shape": "square_punch", "side": "2 mm"}
    told = of("bem_fft", indenter=square, compare={"quantities": ["force"]})
    assert told["contact area"] == "4.00\u202fmm²"
    assert "±" in told["force"]


@pytest.mark.slow
def test_stresses_below_a_sharp_edge_are_known_badly_and_say_so(of):
    """An edge of 5 um leaves no stress to cells of a hundredth of the face; d is exact."""
    punch = {"shape": "rounded_punch", "flat_radius": "3.5 mm", "edge_radius": "0.5 mm"}
    asked = {"quantities": ["penetration", "force", "von_mises_max"]}
    told = of(indenter=punch, compare=asked)
    assert "von Mises' stress" not in told
    assert "±" in told["largest von Mises stress inside"]
    assert "±" not in told["force"]


def test_what_a_method_does_not_compute_is_no_part_of_its_answer(tmp_path):
    """Springs of an ellipsoid have no pressure; those of a paraboloid have."""
    scenes = ["paraboloid", "ellipsoid-2"]
    study = roughline.Study(scenes, tmp_path / "out", methods=["closed_form", "reduced"])
    scenes = study.run().record.scenes
    said = "not computed, so not part of the answer: contact pressure"
    assert said + " (ellipsoid-2)" in finding_table(scenes, "reduced").note
    assert not_computed(scenes[1:], "reduced") == said
    assert not not_computed(scenes[:1], "reduced")


def test_of_one_scene_every_other_method_stands_beside_with_its_time_and_error(tmp_path):
    """Elements that were asked for have an answer; their pressure is one of the last load."""
    methods = ["reduced", "bem_fft", "fem"]
    study = roughline.Study("paraboloid", tmp_path / "out", methods=methods)
    (scene,) = study.run().record.scenes
    rows = [[cell.text for cell in row] for row in others_table(scene).rows]
    assert [row[0] for row in rows] == ["FFT BEM", "FEM"]
    for _, resolution, time, error, word in rows:
        assert int(resolution) > 0
        assert time.split()[-1] in ("ms", "s")
        assert word == "within"
        where = "at last load" if error.startswith("p ") else "at d = "
        assert where in error


def test_settings_and_load_steps_are_what_rows_costs_and_verdicts_say(study):
    """Every setting in its own row: an error of another, or a time for a set-up, would be seen."""
    for scene in study.scenes:
        solved = frame(settings(scene))
        keys = [k for n in scene.methods for k in [(n, v) for v in scene.resolutions_run(n)]]
        assert solved["N"].tolist() == pytest.approx([level for _, level in keys])
        costs = [scene.cost(*key) for key in keys]
        for head, values in (
            ("time / s", [cost.seconds for cost in costs]),
            ("set-up / s", [cost.setup_seconds for cost in costs]),
        ):
            assert solved[head].tolist() == pytest.approx(values, nan_ok=True)
        several = any(cost.surfaces > 1 for cost in costs)
        assert ("surfaces" in solved) == several
        if several:
            single = [cost.single_seconds for cost in costs]
            assert solved["time of one / s"].tolist() == pytest.approx(single, nan_ok=True)
        at = scene.equal_at("contact_area")
        judged = {
            (v.method, v.resolution): v.error
            for v in scene.verdicts
            if (v.quantity, v.at) == ("contact_area", at)
        }
        told = next(name for name in solved if name.startswith("error of contact area"))
        for key, error in zip(keys, solved[told], strict=True):
            if key in judged and not scene.is_reference(*key):
                assert error == pytest.approx(judged[key], nan_ok=True), key

        assert "results.csv, where steps count from 0" in load_steps(scene).note
        steps = frame(load_steps(scene))
        curves = [scene.curve(n, v) for n in scene.methods for v in scene.resolutions_solved(n)]
        for head, name, added in (("step", "step", 1), ("error of force", "error_force", 0)):
            if name == "step" or head in steps:
                values = np.concatenate([np.asarray(curve[name], float) for curve in curves])
                assert steps[head].tolist() == pytest.approx(list(values + added), nan_ok=True)


def test_a_bar_that_differs_from_load_to_load_is_given_by_its_ends(study):
    """57 % at 1 MPa and 6 % at 100 MPa are no 35 %: the truth is known to the worst of them."""
    scene = study.scenes[1]
    bars = [0.57, 0.3, 0.18, 0.1, 0.09, 0.08, 0.062]
    sources = {"contact_area": {"discretisation": bars}}
    wide = replace(scene, reference=replace(scene.reference, sources=sources))
    assert dict(card(wide))["contact area"].endswith(" ± 6.2 to 57\u202f%")
    assert advise(wide).truth_known_to == (0.57, "contact_area")


def test_a_blunt_body_presses_hardest_off_its_axis(of):
    """Of f = c r^4 p ~ (1 + 2 x^2) (1 - x^2)^(1/2), x = r/a, is 2^(1/2) at x^2 = 1/2."""
    told = of(indenter={"shape": "power_law", "exponent": 4, "coefficient": "4e7 m^-3"})
    mean, peak = (
        number_and_unit(told[name].split(" to ")[-1])[0]
        for name in ("mean pressure F/A", "highest pressure, last load")
    )
    # int 2 x (1 + 2 x^2) (1 - x^2)^(1/2) dx = 2/3 + 8/15 = 6/5, of a peak 2^(1/2); three digits
    assert peak / mean == pytest.approx(2**0.5 / 1.2, rel=6e-3)


SURFACE = {"kind": "self_affine", "hurst": 0.8, "size": "1 um", "points": 64}
SURFACE |= {"rms_slope": 0.1, "short_cutoff": "0.1 um"}
ROUGH = {
    "name": "rough",
    "half_space": {"youngs_modulus": "230 GPa", "poisson_ratio": 0},
    "surface": SURFACE,
    "loading": {"force": {"values": [0.03], "relative_to": "E* A0 h'"}},
    "compare": {"quantities": ["contact_area"], "resolutions": [64]},
}
BOTH = ("reduced", "bem_fft")


@pytest.mark.slow
@pytest.mark.parametrize(
    ("slope", "stated", "yields"), [(0.2, "E", True), (0.01, "E", False), (0.2, "E*", False)]
)
def test_rough_contacts_tell_which_steel_yields(of, slope, stated, yields):
    """F/A is near E* h'/2 (Persson 2001: (pi/8)^(1/2) E* h' = 0.63), and the hardness 3 Y.

    A stated E* of 230 GPa may be of two bodies of 460, and of no metal.
    """
    surface = SURFACE | {"periodic": True, "rms_slope": slope}
    body = {"effective_modulus": "230 GPa"} if stated == "E*" else ROUGH["half_space"]
    told = of(*BOTH, scene=ROUGH, surface=surface, half_space=body)
    text = told["yield stress Y"]
    least, mean, highest = (
        to_si(value, PRESSURE)
        for value in (
            re.search(r"= ([\d.]+\s[GM]Pa)", text)[1],
            told["mean pressure F/A"],
            told["highest pressure"],
        )
    )
    assert 0.4 < mean / (230e9 * slope) < 1.0
    assert least == pytest.approx(mean / 3, rel=1e-2)  # printed with three digits
    assert ("a [plasticity] table" in text) == yields
    first = to_si(re.search(r"only above ([\d.]+\s[GM]Pa)", text)[1], PRESSURE)
    assert first == pytest.approx(highest / 1.6, rel=1e-2)
    assert highest > mean
    nominal = to_si(told["nominal pressure F/A₀"], PRESSURE)
    assert nominal == pytest.approx(0.03 * 230e9 * slope, rel=1e-2)


@pytest.mark.slow
@pytest.mark.parametrize(("surfaces", "said"), [(1, True), (2, False)])
def test_true_values_of_one_surface_say_that_its_spectrum_has_others(of, surfaces, said):
    """The bar of a single surface is that of the grid, and surfaces scatter by more."""
    several = SURFACE | {"periodic": True, "realisations": surfaces}
    told = of(*BOTH, scene=ROUGH, surface=several)["true values by"]
    assert ("others of this spectrum" in told) is said


@pytest.mark.slow
@pytest.mark.parametrize(("load", "sinks"), [(3.0, True), (0.003, False)])
def test_the_stiffness_of_a_patch_that_sinks_in_as_a_whole_is_told(of, load, sinks):
    """A square punch is stiffer than a round one of the same area by some 1 %, in cells by 2."""
    loading = {"force": {"values": [load], "relative_to": "E* A0 h'"}}
    asked = {"quantities": ["contact_area", "stiffness"], "resolutions": [64]}
    told = of("bem_fft", scene=ROUGH, loading=loading, compare=asked)
    text = told.get("largest stiffness")
    assert (text is not None) == sinks
    if sinks:
        assert float(text.split()[0]) == pytest.approx(1.01, abs=0.02)
    # all cells are pressed, also those at the edge; the few contacts of the small load are inside
    assert ("singular" in told["highest pressure"]) == sinks


def test_a_force_that_pulls_has_no_mean_pressure(of):
    pulled = {"penetration": ["0 um", "4 um", "-0.1 um"]}
    told = of(loading=pulled, adhesion={"work": "50 mJ/m^2"})
    assert told["adhesion"] == "work 0.05 J/m²"
    assert "mean pressure F/A" not in told


def test_a_sharp_edge_has_no_highest_pressure(of):
    told = of(indenter=BALL["indenter"] | {"shape": "cylinder"})
    assert told["mean pressure F/A"]
    assert "highest pressure, last load" not in told


def test_every_built_in_scene_tells_its_inputs_with_units():
    """No base units where a reader knows a shorter name, and no list without its unit."""
    for name in builtin_names():
        told = dict(_bodies(load_scene(name)))
        assert not re.search(r"kg|\^-| s\^", " ".join(told.values()).replace(" kg", "")), name
    told = dict(_bodies(load_scene("rubber-ball")))
    assert "1\u202fs / 100\u202fms / 10\u202fms" in told["viscoelastic"]
    assert "(thickness 4\u202fµm" in dict(_bodies(load_scene("coated-ball")))["half space"]


def spots_of(rough, folder, *, periodic, shares=False):
    """Return the last table of spots of two Hertz contacts: at (0.3, 0.4) µm, and at the origin.

    Their radii are 0.2 and 0.1 µm, their peaks 2 and 1 GPa.
    """
    fields = rough.load_fields("bem_fft", 128)
    x, y = fields["pressure_x"], fields["pressure_y"]
    pressure = np.zeros_like(x)
    for (x0, y0), radius in (((3e-7, 4e-7), 2e-7), ((0.0, 0.0), 1e-7)):
        away = [(axis - at + 5e-7) % 1e-6 - 5e-7 for axis, at in ((x, x0), (y, y0))]
        pressure += 1e16 * np.sqrt(np.maximum(radius**2 - away[0] ** 2 - away[1] ** 2, 0))
    fields["pressure"] = pressure
    if shares:
        fields["contact"] = 0.5 * (pressure > 0).reshape(64, 64)
    path = folder / "spots.npz"
    np.savez(path, **fields)
    text = rough.text + "periodic = true\n" * periodic
    rows = Rows.of(rough.rows.frame().assign(contact_count=7.0))
    return spots(replace(rough, text=text, rows=rows, fields={("bem_fft", 128): path}))[-1]


def test_spots_have_the_place_the_force_and_the_area_of_two_hertz_contacts(study, tmp_path):
    """F = 2/3 π a² p0: of the periodic pair 8/9 and 1/9; the small one lies across the rims."""
    found = spots_of(study.scenes[1], tmp_path, periodic=True)
    assert [head.text for head in found.heads] == [
        *("area / µm²", "share of the force", "x / nm", "y / nm", "peak pressure / GPa")
    ]
    large, small = [[cell.key for cell in row] for row in found.rows]
    assert large == pytest.approx([0.04 * np.pi, 8 / 9, 300, 400, 2.0], rel=0.03)
    assert small[:2] == pytest.approx([0.01 * np.pi, 1 / 9], rel=0.1)
    assert [(at + 500) % 1000 for at in small[2:4]] == pytest.approx([500, 500], abs=10)
    assert "2 contacts on" in found.note
    assert ", half of their area in 1, " in found.note
    assert "so few that another cut-out or surface may have another area." in found.note


def test_on_a_free_patch_spots_end_at_the_rim(study, tmp_path):
    """Without a period the small contact is four, one in each corner."""
    found = spots_of(study.scenes[1], tmp_path, periodic=False)
    assert len(found.rows) == 5
    assert sum(row[1].key for row in found.rows) == pytest.approx(1.0)
    assert all(min(abs(row[3].key - rim) for rim in (0, 1000)) < 100 for row in found.rows[1:])


def test_spots_of_means_over_blocks_say_so_and_count_the_cells_in_the_blocks(study, tmp_path):
    whole = spots_of(study.scenes[1], tmp_path, periodic=True)
    found = spots_of(study.scenes[1], tmp_path, periodic=True, shares=True)
    assert "means over blocks" in found.note
    assert "count as one (7 by cells)" in found.note
    assert found.heads[-1].text == "largest mean pressure of a block / GPa"
    assert "means over blocks" not in whole.note
    assert found.rows[0][0].key == pytest.approx(0.02 * np.pi, rel=0.05)


def test_spots_are_given_at_every_load_of_the_slider_and_never_of_indenters(study):
    smooth, rough = study.scenes
    assert len(spots(rough)) == len(slider_steps(rough).steps)
    areas = [sum(row[0].key for row in item.rows) for item in spots(rough)]
    assert areas == sorted(areas)
    assert len({item.heads for item in spots(rough)}) == 1  # in the same units
    assert spots(smooth) == []


def test_true_values_of_a_map_stand_beside_each_other_by_its_preparations(study):
    rough = study.scenes[1]
    assert not prepared_table([rough]).rows
    text = f'{rough.text}[sweep]\npreparation = "as given"\n'
    heights = Roughness((1e6,), (1e-30,), 1e-9, 0.1, 1e5, 2.0, area=2e-12)
    map_ = replace(rough, text=text, plan=replace(rough.plan, roughness=heights))
    (row,) = prepared_table([map_]).rows
    largest = np.max(rough.curve("bem_fft")["contact_area"])
    share = row[2].text.split(" to ")[1].split(" ±")[0]
    assert float(share) == pytest.approx(largest / 2e-12, rel=5e-3)
    by_points = replace(map_, text=f'{rough.text}[sweep]\n"surface.points" = 64\n')
    values = prepared_table([by_points])
    assert values.title == "True values along the sweep"
    assert values.rows[0][2].text == true_value(rough, "contact_area")
    # only a run without other preparations is told how to get them
    text = 'name = "map"\n[half_space]\neffective_modulus = 1e9\n[surface]\nkind = "map"\n'
    text += 'file = "a.di"\n[loading]\npressure = 1e6\n'
    plan = replace(rough.plan, roughness=replace(heights, skewness=0.1))
    for swept in ("", '[sweep]\npreparation = "as given"\n'):
        told = dict(card(replace(rough, text=text + swept, plan=plan)))["true values by"]
        assert ("(--sensitivity)" in told) == (not swept)
