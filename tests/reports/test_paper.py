"""Figures and tables for papers: sizes, fonts, colours, the same bytes, hostile results inert."""

import re
import shutil
import xml.etree.ElementTree as ElementTree
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest

pytest.importorskip("matplotlib", reason="the extra `paper` is not installed")

import roughline
from comparisons.errors import InputError
from comparisons.facts.quantities import quantity
from comparisons.judging.truth import NO_REFERENCE
from comparisons.results.finding import deciding
from comparisons.results.recording import explained
from comparisons.results.rows import NO_ROWS
from comparisons.results.store import load_study, save_study
from reports.paper.figures import HIGH, LOW, file_name, overview, panels, sheet, single, verdict_map
from reports.paper.files import write_paper
from reports.tables import cells
from reports.tables.judged import printed_verdicts
from reports.tables.scene import printed_settings, values
from reports.tables.written import frame

pytestmark = pytest.mark.slow

MILLIMETRES_PER_POINT = 25.4 / 72
RADIUS, MODULUS = 0.01, 231e9  # of the ball in conftest.py
# A page wide with all kinds of plots, and a column wide.
FIGURES = ("*-overview", "*-force-penetration")


@pytest.fixture
def ball(study):
    return study.scenes[0]


@pytest.fixture
def rough(study):
    return study.scenes[1]


def page_size(pdf: bytes) -> tuple[float, float]:
    """Return width and height of a PDF's page in mm."""
    box = re.search(rb"/MediaBox \[ ?0 0 ([\d.]+) ([\d.]+)", pdf)
    return tuple(float(group) * MILLIMETRES_PER_POINT for group in box.groups())


def drawn(scene, key):
    (axes,) = single(panels(scene)[key]).axes
    return axes


def test_values_are_those_of_hertz(ball):
    """A = (R d)^(1/2), F = 4/3 E* R^(1/2) d^(3/2), p0 = 3/2 F/A, 0.62 p0 of von Mises (nu 0.3)."""
    printed = frame(values(ball))
    exact = printed[printed["method"] == "closed form"]
    depth = exact["penetration depth d / µm"] * 1e-6
    np.testing.assert_allclose(exact["contact radius a / µm"], np.sqrt(RADIUS * depth) * 1e6)
    force = 4 / 3 * MODULUS * np.sqrt(RADIUS) * depth**1.5
    np.testing.assert_allclose(exact["force F / N"], force)
    mean = force / (np.pi * RADIUS * depth)
    np.testing.assert_allclose(exact["mean pressure F/A / GPa"], mean / 1e9)
    for method in ball.methods:
        if ball.resolutions_solved(method):
            assert cells.method(method, scene=ball).text in set(printed["method"])
    asked = values(replace(ball, quantities=("stiffness",)))
    assert any(head.text.startswith("contact stiffness") for head in asked.heads)


def test_of_one_scene_each_quantity_has_a_row_with_its_error(ball):
    rows = [text for _, text in verdict_map([ball]).y.ticks]
    assert rows == [item.text for item in ball.verdicts_on()]


def test_the_bar_of_the_truth_is_as_wide_as_the_results_say(rough):
    """The reference is uncertain by 1 % in penetration and 2 % in area; area stands upright."""
    axes = drawn(rough, "contact-area-force")
    (band,) = [
        collection
        for collection in axes.collections
        if collection.get_label() == "bar of the reference"
    ]
    corners = band.get_paths()[0].vertices
    edge = corners[np.isclose(corners[:, 0], corners[:, 0].max()), 1]
    width = (edge.max() - edge.min()) / (0.5 * (edge.max() + edge.min()))
    bar = rough.curve("bem_fft", 128)["reference_uncertainty_contact_area"][-1]
    np.testing.assert_allclose(width, 2 * bar, rtol=1e-6)


@pytest.mark.parametrize(
    ("scene", "methods"),
    [
        ("friction-steel", ("closed_form", "reduced", "bem_fft")),
        ("rubber-ball", ("closed_form", "reduced")),
    ],
)
def test_paths_histories_and_speeds_are_drawn_too(scene, methods):
    """Beyond frictionless contact: every quantity along the path, or over time."""
    comparison = roughline.compare(scene, *methods, resolutions=[6, 9])
    assert "data:image/png;base64,iVBOR" in comparison.plot()._repr_html_()
    assert any(key.startswith("error-") for key in comparison.plots)


def test_single_results_are_drawn_too_and_unknown_plots_are_answered_with_the_known(ball):
    solution = roughline.solve("paraboloid", "reduced", 10)
    (axes,) = solution.plot("contact_radius").axes
    np.testing.assert_allclose(axes.get_lines()[0].get_xdata(), solution["penetration"] * 1e6)
    (axes,) = roughline.check_claim("ellipsoid-force").plot().axes
    assert axes.get_xlabel() == "ratio of the radii of curvature R'/R''"
    with pytest.raises(KeyError, match="expected one of penetration"):
        solution.plot("weight")
    with pytest.raises(InputError, match="expected one of force-penetration, contact-area-force"):
        roughline.Comparison(ball).plot("weight")
    with pytest.raises(InputError, match="has no parameter"):
        roughline.check_claim("transform-cone").plot()


@pytest.fixture(scope="module")
def small(study, tmp_path_factory):
    """Return one scene and one quantity of the study, as a folder of its own: fonts take time."""
    scene = replace(study.scenes[0], quantities=("force",), fields={})
    short = study.model_copy(
        update={"directory": tmp_path_factory.mktemp("small"), "scenes": (scene,)}
    )
    save_study(short)
    return short


@pytest.fixture(scope="module")
def folder(small, python, tmp_path_factory):
    """Return a folder that the command wrote, in another process than this one."""
    out = tmp_path_factory.mktemp("paper") / "figures"
    words = ("--out", out, "--format", "pdf,svg", "--figures", ",".join(FIGURES))
    done = python("-m", "roughline", "paper", small.directory, *words, PYTHONHASHSEED="1")
    assert done.returncode == 0, done.stderr
    return out


def test_figures_are_as_wide_as_a_column_or_a_page(folder):
    column = page_size((folder / "steel-ball-force-penetration.pdf").read_bytes())
    page = page_size((folder / "steel-ball-overview.pdf").read_bytes())
    np.testing.assert_allclose([column[0], page[0]], [85.0, 180.0], atol=0.01)


def test_fonts_are_embedded_as_outlines(folder):
    """Publishers refuse Type 3 fonts; in SVG letters are paths, so no font can be missing."""
    pdf = (folder / "steel-ball-force-penetration.pdf").read_bytes()
    assert b"/FontFile2" in pdf
    assert b"/Type3" not in pdf
    svg = ElementTree.fromstring((folder / "steel-ball-overview.svg").read_bytes())
    assert not list(svg.iter("{http://www.w3.org/2000/svg}text"))


def test_the_same_results_give_the_same_bytes(folder, small, tmp_path):
    """No dates, no random names: another process, another hash seed, not a bit differs."""
    again = write_paper(load_study(small.directory), tmp_path, ("pdf", "svg"), figures=FIGURES)
    assert {path.name for path in again} == {path.name for path in folder.iterdir()}
    for path in again:
        assert path.read_bytes() == (folder / path.name).read_bytes(), path.name


def test_tables_are_latex_with_the_rules_of_booktabs(folder):
    for path in (folder / "verdicts.tex", folder / "settings.tex"):
        text = path.read_text(encoding="utf-8")
        assert not re.search(r"\|\w\|(?!\$)|(?<!\w)\w\\_", text)  # symbols are set as such
        (columns,) = re.findall(r"\\begin\{tabular\}\{@\{\}([lr]+)@\{\}\}", text)
        rows = [line for line in text.splitlines() if line.endswith(r" \\")]
        assert len(rows) > 1
        for row in rows:
            assert len(re.findall(r"(?<!\\)&", row)) == len(columns) - 1, row
        for rule in (r"\toprule", r"\midrule", r"\bottomrule"):
            assert text.count(rule) == 1
        plain = re.sub(r"\\[{}$]", "", text)
        assert plain.count("{") == plain.count("}")
        assert plain.count("$") % 2 == 0


def test_few_figures_are_drawn_unless_more_are_asked_for(small, tmp_path):
    """One of all verdicts, one for each scene, and what there is besides is named in the index."""
    told = []

    def each(figures):
        for figure in figures:
            told.append(figure.name)
            yield figure

    written = write_paper(small, tmp_path, each=each)
    drawn_names = {path.stem for path in written if path.suffix == ".pdf"}
    assert drawn_names == {"verdicts", "steel-ball-overview"}
    assert told == ["verdicts", "steel-ball-overview"]
    index = (tmp_path / "index.md").read_text(encoding="utf-8")
    assert "`steel-ball-error-force`" in index
    names = re.findall(r"\]\(([^)]+)\)", index)
    assert set(names) <= {path.name for path in written}
    assert {path.name for path in written} - set(names) == {
        *("index.md", "figures.tex", "verdicts.tex", "values.tex", "settings.tex")
    }


def test_of_one_load_there_are_errors_and_no_curves_and_that_is_said(ball, study, tmp_path):
    """Lone points on axes of 0.01 % showed nothing."""
    rows = ball.rows.where(ball.rows["step"] == 0)
    one = replace(ball, rows=rows, fields={})
    keys = [f"speed-{name}" for name in one.quantities]
    assert list(panels(one)) == [file_name(key) for key in keys]
    labels = [axes.get_ylabel().replace("\n", " ") for axes in overview(one).axes]
    assert labels == ["largest error of contact area", "largest error of force"]
    write_paper(study.model_copy(update={"scenes": (one,)}), tmp_path, ("png",))
    assert "One load: no curves" in (tmp_path / "index.md").read_text(encoding="utf-8")


def test_a_legend_of_many_long_names_stays_inside(ball):
    """Six names in a row were cut off on both sides."""
    figure = panels(ball)["speed-force"]
    (shown, *_) = (series for series in figure.series if series.legend)
    names = [f"finite elements of a counter body, kind {k}" for k in range(7)]
    series = [replace(shown, look=shown.look.labelled(name)) for name in names]
    for paper in (single(replace(figure, series=series)), sheet([replace(figure, series=series)])):
        paper.canvas.draw()
        (legend,) = paper.legends
        box = legend.get_window_extent()
        assert box.x0 >= 0
        assert box.x1 <= paper.bbox.width
        assert box.y0 > paper.axes[0].bbox.y1


def test_the_overview_shows_the_quantity_that_decides(ball):
    """The errors behind the verdict are in the figure, whatever is compared first."""
    decisive = deciding(ball).quantity
    others = tuple(name for name in ball.quantities if name != decisive)
    for order in ((decisive, *others), (*others, decisive)):
        paper = overview(replace(ball, quantities=order))
        labels = [axes.get_ylabel().replace("\n", " ") for axes in paper.axes]
        assert sum(quantity(decisive).label in text for text in labels[2:]) == 2, labels


def test_the_figure_of_verdicts_has_the_numbers_of_the_verdicts(study):
    figure = verdict_map(study.scenes)
    shown = {float(x) for series in figure.series for x in series.x if np.isfinite(x)}
    for scene in study.scenes:
        for item in scene.verdicts_on():
            ratio = abs(item.error) / item.tolerance
            if LOW < ratio < HIGH:
                assert ratio in shown, item.text
        for offered in (True, False):  # what a method does not compute is no cross
            lost = tuple(replace(v, word="no result", offered=offered) for v in scene.verdicts)
            crossed = verdict_map([replace(scene, verdicts=lost)])
            assert offered == bool(crossed and "no result" in crossed.series[-1].look.label)


def test_hostile_titles_are_text_in_every_format(folder):
    for name in ("settings.md", "settings.tex", "index.md", "figures.tex"):
        assert "<script>" not in (folder / name).read_text(encoding="utf-8")
    assert r"\textless{}script\textgreater{}" in (folder / "settings.tex").read_text()


def test_a_table_has_a_row_for_every_setting_and_the_truth_is_named(rough, study):
    settings = printed_settings(rough)
    assert [head.text for head in settings.heads[:4]] == ["method", "N", "unknowns", "time"]
    rows = [tuple(cell.text for cell in row) for row in settings.rows]
    assert ("reference",) * (len(settings.heads) - 4) in {row[4:] for row in rows}
    result = printed_verdicts(study.scenes)
    assert {row[0].text for row in result.rows} == {"steel-ball", "rough-patch", ""}


def test_hostile_results_are_drawn_as_text_and_written_inside_the_folder(small, tmp_path):
    """Names with mathematics that cannot be set, names that lead out of the folder."""
    shutil.copytree(small.directory, tmp_path / "run")
    for path in (tmp_path / "run").glob("*.*"):
        text = path.read_text(encoding="utf-8")
        text = text.replace("steel-ball", "../../evil").replace("bem_dense", "$\\\\frac")
        path.write_text(text, encoding="utf-8")
    for path in (tmp_path / "run").glob("*.csv"):  # the hash is of the scene under its own name
        pd.read_csv(path).drop(columns="scene_hash", errors="ignore").to_csv(path, index=False)
    out = tmp_path / "deep" / "out"
    hostile = load_study(tmp_path / "run")
    for path in write_paper(hostile, out, ("svg",), figures=("*-error-force",)):
        assert path.parent == out
        assert re.fullmatch(r"[a-z0-9-]+\.(svg|tex|md)", path.name)
    assert {item.name for item in tmp_path.iterdir()} == {"run", "deep"}


def test_a_scene_without_errors_has_only_curves(rough):
    bare = replace(rough, verdicts=(), reference=NO_REFERENCE)
    assert all(not key.startswith("speed") for key in roughline.Comparison(bare).plots)
    empty = replace(rough, verdicts=(), rows=NO_ROWS)
    assert overview(empty) is None


def test_a_run_without_results_makes_no_empty_tables(study, tmp_path):
    with pytest.raises(InputError, match="no scene has results"):
        write_paper(study.model_copy(update={"scenes": ()}), tmp_path / "out")
    assert not (tmp_path / "out").exists()


def test_methods_that_lost_every_solve_and_scenes_without_a_truth_leave_tables(study, tmp_path):
    """No curve, no error, no cost: there is nothing to draw, and the tables say so."""
    whole = study.scenes[0]
    lost = whole.rows.where(np.isnan(whole.rows["step"]))
    scene = replace(whole, rows=lost, verdicts=(), reference=NO_REFERENCE)
    scene = replace(scene, verdicts=explained(scene))
    written = write_paper(study.model_copy(update={"scenes": (scene,)}), tmp_path / "out")
    assert not [path for path in written if path.suffix == ".pdf"]
    verdicts = (tmp_path / "out" / "verdicts.md").read_text(encoding="utf-8")
    assert "| contact area | – | – |" in verdicts


def test_a_missing_matplotlib_is_told_with_the_way_to_get_it(study, python, tmp_path):
    code = (
        "import sys; sys.modules['matplotlib'] = None\n"
        "from roughline.commands.app import run_command\n"
        f"sys.exit(run_command(['paper', {str(study.directory)!r}, '--out', {str(tmp_path)!r}]))"
    )
    done = python("-c", code)
    assert done.returncode == 2
    assert done.stderr.strip() == "figures need matplotlib: pip install 'roughline[paper]'"
