"""One criterion: every place that speaks of a scene says the same word, number and time."""

import re
from dataclasses import replace
from html import unescape

import numpy as np
import pytest

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.judging.verdicts import NO_RESULT, judged, worst
from comparisons.questions.study import solved_in_memory
from comparisons.results.advice import advise
from comparisons.results.finding import finding
from comparisons.results.record import StudyRecord
from comparisons.results.recording import explained, record_scene
from comparisons.scene.scene import builtin_names, load_scene
from comparisons.solving.planning import plan_scene
from reports.pages import study as html
from reports.pages.study import scene_view
from reports.tables.judged import printed_verdicts
from reports.tables.scene import printed_settings, values
from roughline.commands import terminal
from roughline.comparing import Comparison

FEW = {"compare.methods": ["closed_form", "reduced", "bem_fft"]}
COARSE = FEW | {"compare.resolutions": [8, 16, 32]}
TWO = {"compare.methods": ["closed_form", "reduced"]}
LONG = {"impact-rubber", "rolling-rubber"}  # of two physics, each of which has a scene of its own
# A scene that is outside at the other load only, and one whose truth is a grid.
CHEAP = {
    "ellipsoid-2": {"compare.quantities": ["force", "penetration", "contact_area"]},
    "square-punch": {},
}


@pytest.fixture(autouse=True)
def _unfolded(monkeypatch):
    """Print a cell of a table on one line, however long its words, so that it can be searched."""
    monkeypatch.setenv("COLUMNS", "400")


def words(text: str) -> str:
    return " ".join(text.split())


def solved(name, overrides):
    (plan, *_) = plan_scene(load_scene(name, overrides))
    return record_scene(*solved_in_memory(plan, "quick"))


@pytest.fixture(scope="module", params=CHEAP)
def scene(request):
    return solved(request.param, COARSE | CHEAP[request.param])


def study_of(scene, folder):
    when = {"created": "2026-01-31T12:00:00", "command": "", "effort": "quick", "seconds": 1.0}
    return StudyRecord(**when, machine={}, versions={}, scenes=(scene,), directory=folder)


def rows_of(table):
    return [tuple(cell.text for cell in row) for row in table.rows]


def assert_one_voice(scene, folder, capsys):
    """Read page, terminal, advice, paper tables and notebook; compare with the verdicts."""
    study, advice, told = study_of(scene, folder), advise(scene), scene.verdicts_on()
    terminal.print_study(study, [], verbose=True)
    run = words(capsys.readouterr().out)
    terminal.print_advice([(scene.name, advice)])
    advised = words(capsys.readouterr().out)
    page = html.page(study, with_pictures=False)
    page = words(unescape(re.sub(r"<(script|style).*?</\1>|<[^>]*>", " ", page, flags=re.DOTALL)))
    paper, notebook = rows_of(printed_verdicts([scene])), Comparison(scene)
    for text in (run, advised, page, words(notebook.answer)):
        assert words(advice.sentence) in text
    assert notebook.verdict == worst(told).word
    for item, row in zip(told, paper, strict=True):
        if item.word == "no result":
            assert row[3] == ("no result" if item.offered and item.counts else fmt.MISSING)
            continue
        asked = fmt.tolerance(scene.tolerance)
        what = quantity(item.quantity).label
        assert words(f"{what} {item.number} {item.when} {item.word} {asked}") in run
        assert words(f"{item.word} {item.number}") in page
        assert row[1:4] == (what, item.number, f"{item.word} {asked}{item.lacking}")
        # The setting that is judged: of one that lost its steps there is nothing to say.
        setting = ("reduced model", fmt.count(item.resolution))
        (own,) = (row for row in rows_of(printed_settings(scene)) if row[:2] == setting)
        assert item.number in own
    assert_times_were_measured(scene, advice)
    # Who is within and computes all that was asked is advised, and who is advised is within.
    reached = {part.method for part in advice.reaching()}
    sure = not scene.by_chance("reduced")
    whole = all(item.offered or not item.counts for item in told)
    assert ("reduced" in reached) == (whole and sure and worst(told).word == "within")
    if advice.cheapest is not None:
        assert paper[0][-1] == advice.cheapest.text == notebook.cheapest.text
        assert words(advice.cheapest.text) in page


def assert_times_were_measured(scene, advice):
    """Every time in the sentence is that of all solves of the setting whose N stands beside it."""
    rows = scene.rows.where(np.isfinite(scene.rows["resolution"]))
    times = map(fmt.duration, rows["seconds_all"])
    run = set(zip(times, rows["resolution"].astype(int).tolist(), strict=True))
    said = re.findall(r"(\d[\d.]*\u202f[mµn]?s) \(N = (\d+)", advice.sentence)
    assert {(time, int(level)) for time, level in said} <= run
    assert len(said) == len(advice.reaching())


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.nightly] if name in LONG else [])
        for name in sorted(builtin_names())
    ],
)
def test_every_place_says_the_same_of_every_built_in_scene(quick_suite, name, tmp_path, capsys):
    """Coarse grids do where nothing is solved yet: it is about words, not how good they are."""
    scene = quick_suite.get(name)
    assert_one_voice(
        scene or solved(name, FEW | {"compare.resolutions": [8, 16]}), tmp_path, capsys
    )


def test_the_prescribed_load_decides(scene):
    """The word of each setting follows from results.csv, at the prescribed load, step by step."""
    advice = advise(scene)
    for setting in advice.settings:
        if setting.is_truth or setting.method == "reduced":  # the line's own bars come on top
            continue
        rows = scene.curve(setting.method, setting.resolution)
        for item in setting.counted:
            if item.quantity == "pressure":
                continue
            error = rows[f"error_{item.quantity}"]
            bar = rows[f"reference_uncertainty_{item.quantity}"]
            assert item.word == judged(error, bar, scene.tolerance).word
            reach = np.abs(error) + bar
            assert reach[item.step] == pytest.approx(np.max(reach), rel=1e-8)
            assert item.at == scene.equal_at(item.quantity)


@pytest.mark.slow
def test_the_finding_answers_what_to_use_for_a_ball_and_what_for_an_ellipsoid():
    """May I use it, for what was that shown, what instead, at what cost: without reading on."""
    asked = COARSE | {"compare.quantities": ["force"]}
    ball, oblong = solved("paraboloid", asked), solved("ellipsoid-5", asked)
    best = advise(ball).cheapest
    (form,) = (item for item in advise(oblong).settings if item.method == "closed_form")
    good, bad = finding((ball, oblong))
    assert (good.scenes, good.use) == ("axisymmetric bodies: paraboloid", "yes")
    (steep,) = finding((solved("sphere", asked),))  # a/R = 0.59
    assert steep.use == "for small slopes only"
    assert good.cost.startswith(f"{fmt.duration(best.seconds)} (N = {best.resolution}), ")
    assert (bad.scenes, bad.use, bad.cost) == ("ellipsoids: ellipsoid-5", "no", "–")
    assert bad.error == f"F {worst(oblong.verdicts_on()).number} at d = 1.00\u202fµm"
    assert bad.error.startswith("F \u22125.")  # the sign: the model is too soft
    assert bad.instead == f"closed form (exact) {fmt.duration(form.seconds)}"


def test_of_a_single_load_there_is_a_table_in_place_of_curves():
    """A curve of one point is an empty plot; each value has its error beside it, Hertz's too.

    Nothing names the load step: there is no other.
    """
    one = {"loading": {"penetration": ["1 um"]}}
    scene = solved("paraboloid", COARSE | one)
    view = scene_view(scene, "scene-1")
    assert not view.figures["curves"]
    assert not view.figures["errors"]
    shown = values(scene)
    heads = [head.text.partition(" / ")[0] for head in shown.heads]
    assert heads[:4] == ["method", "force F", "error", "penetration depth d"]
    assert heads[heads.index("penetration depth d") + 1] != "error"  # prescribed
    place = heads.index("force F")
    rows = {row[0].text: row for row in shown.rows}
    assert rows["closed form"][place + 1].text == "reference"
    assert tuple(view.others["FFT BEM"].values()) == scene.verdicts_on("bem_fft")
    assert not view.judged.keys() & view.others.keys()
    verdict = view.others["FFT BEM"]["force"]
    assert rows["FFT BEM"][place + 1].text == verdict.number
    assert verdict.text == f"force {verdict.number}"
    captions = [figure.caption for group in view.figures.values() for figure in group]
    said = " ".join([verdict.where, *(head.text for head in shown.heads), *captions])
    assert "step 1" not in said
    assert "last load" not in said


@pytest.mark.parametrize("asked", [["force", "penetration"], ["force"]])
def test_what_a_single_load_prescribes_is_judged_only_if_nothing_else_is_asked(asked):
    """It was "no result" in every table; without a verdict of another, it says why."""
    scene = solved("paraboloid", TWO | {"loading": {"force": ["1 N"]}, "compare.quantities": asked})
    known = {item.quantity: (item.word, item.reason) for item in scene.verdicts_on()}
    assert values(scene).rows
    if len(asked) > 1:
        assert known == {"penetration": ("within", "")}
    else:
        assert known == {"force": (NO_RESULT, "prescribed, the same for all")}


def test_pressure_alone_is_a_question_like_any_other(tmp_path, capsys):
    """It used to end in an IndexError after solving."""
    scene = solved("ellipsoid-2", COARSE | {"compare.quantities": ["pressure"]})
    assert advise(scene).sentence.startswith("For 1\u202f% in contact pressure: FFT BEM")
    assert_one_voice(scene, tmp_path, capsys)


def test_a_truth_that_alone_gives_a_quantity_answers_for_it():
    """One grid and the reduced model: no other pressure was compared, the truth has one."""
    few = {"compare.methods": ["reduced", "bem_fft"], "compare.resolutions": [32]}
    scene = solved("square-punch", few | {"compare.quantities": ["force", "pressure"]})
    assert scene.unanswered == {}
    unknown = replace(scene, reference=replace(scene.reference, bars={}))
    unknown = replace(unknown, verdicts=explained(unknown))
    assert "pressure" in unknown.unanswered


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "changes", "quantity", "reason"),
    [
        (
            "plastic-ball",
            {"plasticity.yield_stress": "500 GPa", "loading": {"penetration": ["1 um", "0 um"]}},
            "residual_depth",
            "zero in every answer: nothing yields",
        ),
        (  # it parts at -2.96 um
            "adhesive-ball",
            {"loading": {"penetration": ["-20 um", "-10 um"]}},
            "force",
            "zero in every answer: nothing touches at any load",
        ),
    ],
)
def test_what_is_zero_everywhere_is_no_verdict_and_says_why(name, changes, quantity, reason):
    """A ball that stays elastic leaves no dent; one that is only pulled at never touches."""
    scene = solved(name, changes | {"compare.methods": ["reduced"]})
    (zero,) = (item for item in scene.verdicts_on() if item.quantity == quantity)
    assert (zero.reason, zero.counts) == (reason, False)


def test_a_ball_that_is_pulled_beyond_its_pull_off_has_no_result_and_says_why():
    """No contact bears more than 3/2 pi w R, 2.356 mN here: no zero stands for an answer."""
    pulled = {"loading": {"force": ["-5 mN", "-10 mN"]}, "compare.methods": ["reduced"]}
    known = {item.quantity: item for item in solved("adhesive-ball", pulled).verdicts_on()}
    assert known["contact_area"].word == NO_RESULT
    assert known["contact_area"].reason.startswith("no equilibrium: ")
