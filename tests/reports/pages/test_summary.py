"""The first screen and the tables under it: verdicts, cheapest methods, times, stability."""

import json

import pytest

from comparisons.questions.claims.record import RECORD, ClaimRecord, ClaimsRecord, PointRecord
from comparisons.results.advice import advise
from comparisons.results.record import SceneRecord
from reports.pages import study as html
from reports.pages.study import (
    claims_beside,
    compared_methods,
    in_words,
    scene_view,
    times_to_errors,
)
from reports.tables import scene as tables


def cells(table):
    heads = [head.text for head in table.heads]
    return [dict(zip(heads, row, strict=True)) for row in table.rows]


def test_the_worst_quantity_stands_for_a_scene(study):
    """Contact area is outside, penetration within: the scene's line says outside, and which."""
    scene = study.scenes[1]
    told = scene_view(scene, "")
    (decisive,) = told.decided.values()
    assert (decisive.quantity, decisive.word) == ("contact_area", "outside")
    assert in_words(scene, decisive).endswith("% at F = 100\u202fnN")  # no number of a step
    assert told.truth.startswith("FFT BEM ±")
    exact = scene_view(study.scenes[0], "")
    assert exact.fastest == advise(study.scenes[0]).reaching()[:2]
    assert exact.truth == "closed form"


def test_times_to_an_error_are_those_of_settings_that_were_run(study):
    """The table says what the advice does; what no setting reaches is not told."""
    advice = advise(study.scenes[0])
    assert advice.cheapest_for(1e-9)["fem"] is None
    table = {row["method"].text: row for row in cells(times_to_errors(study.scenes[0]))}
    for error, head in ((0.01, "time to 1\u202f%"), (0.001, "time to 0.1\u202f%")):
        best = advice.cheapest_for(error)["reduced"]
        assert table["reduced model"][head].key == best.seconds
        run = {(setting.method, setting.resolution, setting.seconds) for setting in advice.settings}
        assert ("reduced", best.resolution, best.seconds) in run


def test_stability_counts_loads_iterations_and_reasons(study):
    table = cells(tables.stability(study.scenes[0]))
    lost = next(row for row in table if row["method"].text == "dense BEM" and row["N"].key == 20)
    assert lost["loads solved"].text == "0"
    assert "active set cycled" in lost["failures"].text
    good = next(row for row in table if row["method"].text == "FEM" and row["N"].key == 16)
    assert (good["loads solved"].text, good["of"].text) == ("6", "6")
    assert (good["iterations, min"].key, good["iterations, max"].key) == (12, 17)
    assert good["largest violation"].key == pytest.approx(1e-9)
    assert good["failures"].text == "none"


def test_an_ensemble_counts_every_realisation_once(study):
    """Five surfaces under eight loads; the row of means is no solve."""
    table = cells(tables.stability(study.scenes[1]))
    assert {row["of"].text for row in table} == {"40"}


def test_what_was_compared_names_methods_that_solved_and_are_not_judged(study, monkeypatch):
    named = compared_methods(study.scenes)
    assert named[:2] == ["closed form", "dense BEM"]
    assert "reduced model" not in named
    assert "ContactMechanics" not in named
    # a method of the user's own is never called a reference
    monkeypatch.setattr(SceneRecord, "judged_methods", ["reduced", "bem_dense"])
    named = compared_methods(study.scenes)
    assert "closed form" in named
    assert "dense BEM" not in named


def test_the_summary_of_several_scenes_has_a_badge_for_each_judged_method(study, monkeypatch):
    monkeypatch.setattr(SceneRecord, "judged_methods", ["reduced", "bem_dense"])
    whole = html.page(study, with_pictures=False)
    row = whole.split('id="summary-table"')[1].split("<tr")[2]
    assert row.count('class="verdict ') == 2
    assert row.index(">reduced model<") < row.index(">dense BEM<")
    assert 'class="note doubt"></p>' not in whole
    assert 'aria-label="Where to use the dense BEM"' in whole


def claim(word: str) -> ClaimRecord:
    point = {"uncertainty": 0.001, "word": "within", "details": {}, "seconds": 0.1}
    points = [PointRecord(parameter=x, error=0.001 * x, **point) for x in (1.0, 2.0)]
    return ClaimRecord(
        id="hertz", text="Force is exact <b>", equation="(19.1)", reading="printed", corrects=None,
        what="force", method="reduced", quantity=["force"], measure="largest", parameter="d/R",
        spacing="linear", tolerance=0.01, refuted_by="an error above 1 %.", expected=None,
        verdict=word, sentence="It holds.", points=points, ranges=[], disagreements=[],
        command="roughline claims hertz", seconds=1.0, effort="quick",
    )  # fmt: skip


def test_claims_beside_a_study_are_taken_up_with_their_evidence(study, tmp_path):
    folder = tmp_path / "claims"
    folder.mkdir()
    record = ClaimsRecord(
        created="2026-01-31T12:00", command="roughline claims", effort="quick", seconds=1.0,
        machine={}, versions={}, interrupted=False, claims=[claim("holds")],
    )  # fmt: skip
    record.write(folder / RECORD)
    (folder / "report.html").write_text("page")
    beside = claims_beside(tmp_path / "quick")
    assert beside.page == "../claims/report.html"
    page = html.page(
        study.model_copy(update={"directory": tmp_path / "quick"}), with_pictures=False
    )
    assert "It holds." in page
    assert "Force is exact &lt;b&gt;" in page
    spec = page.split('id="data-claim-1-evidence">')[1].split("</script>")[0]
    assert json.loads(spec)["data"]


def test_without_or_with_damaged_claims_the_report_says_so(study, tmp_path):
    assert claims_beside(tmp_path / "quick") is None
    (tmp_path / "claims").mkdir()
    (tmp_path / "claims" / "claims.json").write_text("{")
    assert claims_beside(tmp_path / "quick") is None
    page = html.page(
        study.model_copy(update={"directory": tmp_path / "quick"}), with_pictures=False
    )
    assert "No claims have been tested next to this study" in page


@pytest.mark.slow
def test_fits_of_our_own_have_no_row_of_verdicts_in_a_report_that_loads_no_solvers(python):
    """`roughline report` took fits, whose files bring their own rows, for a user's methods."""
    told = python(
        "-c",
        "from comparisons.results.record import SceneRecord\n"
        "SceneRecord.methods = ['reduced', 'kogut_etsion']\n"
        "print(object.__new__(SceneRecord).judged_methods)",
    )
    assert told.stdout.strip() == "['reduced']"
