"""The sentence of a scene, its verdict and facts; what it promises is there in a second run."""

import json
from dataclasses import replace

import numpy as np
import pandas as pd
import pytest
import tomli_w

from comparisons.facts.methods import METHODS
from comparisons.facts.quantities import FIELDS
from comparisons.judging.truth import NO_REFERENCE, Bar, Reference
from comparisons.judging.verdicts import Verdict, worst
from comparisons.questions.study import solved_in_memory
from comparisons.results.advice import advise, wide_truth
from comparisons.results.finding import finding
from comparisons.results.record import MEAN, SceneRecord, asked_in_vain
from comparisons.results.recording import explained, record_scene
from comparisons.results.rows import Rows
from comparisons.scene.scene import SUITES, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import PlanRecord, task_of
from comparisons.solving.planning import plan_scene
from roughline.commands.app import run_command


def record(rows, method="closed_form", bar=0.0, quantities=("force",), tolerance=0.01):
    """Make a record as a study would, from (method, N, |e|, seconds) of each quantity; u = 0."""
    rows = [(*row, "force")[:5] for row in rows]
    common = {"at": "penetration", "tolerance": tolerance, "step": 2, "signed": False}
    verdicts = tuple(
        Verdict(
            word="within" if e <= tolerance else "outside",
            **common | {"method": name, "resolution": n, "quantity": quantity, "uncertainty": 0.0},
            **dict.fromkeys(("error", "low", "high", "rms"), e),
        )
        for name, n, e, _, quantity in rows
    )
    truth = (method, 64, None, 2.0)
    solved = [
        {"method": name, "resolution": n, "seconds": seconds, "seconds_all": seconds}
        for name, n, _, seconds, *_ in dict.fromkeys(row[:4] for row in (*rows, truth))
    ]
    table = pd.DataFrame(solved).assign(step=0, converged=True, force=1.0)
    table.loc[table["resolution"] == 64, "force"] = np.nan
    made = SceneRecord(
        name="scene",
        title="Scene",
        text="",
        control="penetration",
        quantities=quantities,
        tolerance=tolerance,
        plan=PlanRecord(),
        reference=Reference(
            *(method, 64, "The truth."),
            sources={name: {"discretisation": [bar]} for name in quantities},
            bars={name: Bar(bar, 1) for name in quantities},
        ),
        verdicts=verdicts,
        disagreements=(),
        rows=Rows.of(table),
    )
    return recorded(made)


def recorded(made, **changes):
    made = replace(made, **changes)
    return replace(made, verdicts=explained(made))


def test_a_step_is_named_where_several_loads_were_planned_and_one_was_solved():
    one = record([("reduced", 8, 0.001, 1.0)], bar=0.02)
    names = ("method", "resolution", "seconds", "seconds_all", "step", "converged", "force")
    table = pd.DataFrame({name: one.rows[name] for name in names})
    five = pd.concat([table.assign(step=k, converged=k == 1) for k in range(5)])
    several = replace(one, rows=Rows.of(five))
    assert (one.of_one_load, several.of_one_load) == (True, False)
    told = [
        setting.verdicts[0].when
        for item in (one, several)
        for setting in advise(item).settings
        if setting.is_truth
    ]
    assert told == ["", "load step 2"]


def test_the_sentence_names_the_cheapest_setting_of_each_method_fastest_first():
    rows = [
        ("fem", 4, 0.02, 1.0),
        ("fem", 8, 0.005, 8.0),
        ("reduced", 10, 0.001, 1e-3),
        ("bem_fft", 8, 0.04, 0.01),
    ]
    advice = advise(record(rows))
    said = advice.sentence
    model, fem, fft = (METHODS[name].title for name in ("reduced", "fem", "bem_fft"))
    assert said.startswith(f"For 1\u202f% in force: {model} 1.0\u202fms (N = 10), {fem} ")
    assert f"outside: {fft} (force 4.0\u202f% at load step 3, N = 8)" in said
    assert said.endswith("reference: closed form.")
    assert (advice.cheapest.method, advice.cheapest.resolution) == ("reduced", 10)
    assert [setting.seconds for setting in advice.settings] == [1e-3, 0.01, 1.0, 2.0, 8.0]


def test_a_time_is_that_of_the_setting_it_is_labelled_with():
    """Between N = 4 (2 %, 1 s) and N = 8 (0.5 %, 8 s) nothing was run: 1 % costs 8 s."""
    advice = advise(record([("fem", 4, 0.02, 1.0), ("fem", 8, 0.005, 8.0)]))
    assert "FEM 8.0\u202fs (N = 8)" in advice.sentence
    measured = {(setting.resolution, setting.seconds) for setting in advice.settings}
    for wanted in (0.05, 0.02, 0.01, 0.005):
        chosen = advice.cheapest_for(wanted)["fem"]
        assert (chosen.resolution, chosen.seconds) in measured
    assert advice.cheapest_for(0.004)["fem"] is None


def test_times_closer_than_they_repeat_are_not_ranked():
    rows = [("fem", 4, 0.001, 1.2), ("bem_fft", 8, 0.001, 1.0), ("bem_dense", 8, 0.001, 9.0)]
    said = advise(record(rows)).sentence
    assert "FFT BEM 1.0\u202fs (N = 8) or FEM 1.2\u202fs (N = 4) (too close to rank), dense" in said


def test_a_coarse_grid_that_is_right_by_chance_is_no_way_to_get_there():
    """|e| falls below the tolerance at N = 8 and rises again: the method is outside."""
    rows = [("fem", 4, 0.03, 1.0), ("fem", 8, 0.004, 2.0), ("fem", 16, 0.02, 9.0)]
    advice = advise(record(rows))
    assert advice.cheapest is None
    assert "N = 16; within by chance at N = 8)" in advice.sentence


def test_the_sentence_admits_what_is_not_known():
    unknown = advise(record([("reduced", 10, 0.2, 1e-3)], "bem_fft", np.nan))
    assert "no setting that was run is within tolerance" in unknown.sentence
    assert "its error is not known" in unknown.sentence
    assert unknown.cheapest is None
    assert "Nothing else was run" in advise(record([])).sentence
    nothing = recorded(record([]), reference=NO_REFERENCE)
    assert "so no reference is available" in advise(nothing).sentence


def test_the_sentence_says_how_many_surfaces_were_solved_on_which_grid():
    many = record([("reduced", 10, 0.001, 1e-3)], "bem_fft", 0.02)
    numbers = {16: 50, 32: 25, 64: 10}
    table = many.rows.frame()
    means = pd.concat([table[table["method"] == "bem_fft"]] * 3, ignore_index=True)
    means = means.assign(resolution=[*numbers], surfaces=[*numbers.values()], realisation="mean")
    said = advise(recorded(many, rows=Rows.of(pd.concat([table, means])))).sentence
    assert "(N = 64, mean over 50 + 25 + 10 surfaces), known to 2.0\u202f% in force" in said


def test_a_setting_whose_bar_is_wider_than_the_question_is_not_called_good_enough():
    rows = record([("fem", 4, 0.004, 1.0), ("bem_fft", 8, 0.02, 0.1)])
    wide = {"word": "not resolved", "uncertainty": 0.05, "low": -0.02, "high": 0.06}
    verdicts = tuple(replace(verdict, **wide) for verdict in rows.verdicts)
    advice = advise(replace(rows, verdicts=verdicts))
    assert "no setting that was run is within tolerance" in advice.sentence
    assert "not resolved: " in advice.sentence
    assert "FEM (force 0.4 ± 5.0\u202f% at load step 3, N = 4)" in advice.sentence
    assert advice.cheapest is None


BOTH = ("force", "contact_area")


def test_a_setting_has_to_be_good_in_every_quantity_that_is_asked():
    rows = [
        ("reduced", 10, 0.001, 1e-3, "force"),
        ("reduced", 10, 0.2, 1e-3, "contact_area"),
        ("fem", 4, 0.002, 1.0, "force"),
        ("fem", 4, 0.003, 1.0, "contact_area"),
        ("bem_fft", 8, 0.001, 0.1, "force"),
    ]
    advice = advise(record(rows, quantities=BOTH))
    assert advice.cheapest.method == "fem"
    assert "in force and contact area" in advice.sentence
    assert (
        "outside: reduced model (contact area 20\u202f% at load step 3, N = 10)" in advice.sentence
    )
    assert "no result: FFT BEM (contact area: not computed by the method)" in advice.sentence


def test_what_one_method_does_not_give_is_a_dash_and_what_none_gives_is_said():
    """Within in force is the verdict on what it computes, and no answer to force and area."""
    rows = record([("reduced", 10, 0.001, 1e-3), ("fem", 4, 0.002, 1.0)], quantities=BOTH)
    advice = advise(rows)
    assert advice.cheapest is None
    assert worst(rows.verdicts_on()).word == "within"
    nobody = recorded(rows, reference=replace(rows.reference, bars={"force": Bar(0.0, 0)}))
    advice = advise(nobody)
    assert advice.cheapest.method == "reduced"
    assert worst(nobody.verdicts_on()).word == "within"
    assert "not judged: contact area (not computed by any method that was run)" in advice.sentence
    assert asked_in_vain([nobody])
    assert not asked_in_vain([rows])


def test_a_truth_that_is_known_well_enough_is_an_answer_itself():
    rows = [("reduced", 10, 0.2, 1e-3)]
    good = advise(record(rows, "bem_fft", 0.004))
    assert "FFT BEM 2.0\u202fs (N = 64, the reference itself)" in good.sentence
    assert good.cheapest.is_truth
    wide = record(rows, "bem_fft", 0.04)
    assert advise(wide).cheapest is None
    told = "reference: FFT BEM, known to 4.0\u202f% in force, wider than the tolerance of 1\u202f%"
    assert wide_truth(wide, "quick") == f"{told}: --full refines it"
    assert wide_truth(record(rows, "bem_fft", 0.004), "quick") == ""
    # a closed form has no grid to refine
    assert wide_truth(record(rows, bar=0.04), "quick") == told.replace("FFT BEM", "closed form")


@pytest.mark.slow
def test_a_user_gets_advice_for_a_tolerance_and_quantities(capsys):
    """A cylinder's force is exact in the reduced model: nothing cheaper can be advised."""
    asked = ["advise", "cylinder", "--tolerance", "2 %", "--quantities", "force", "--json"]
    assert run_command(asked) == 0
    (document,) = json.loads(capsys.readouterr().out)
    assert document["tolerance"] == 0.02
    assert document["cheapest"]["method"] == "reduced"
    assert document["sentence"].startswith("For 2\u202f% in force: reduced model")


def physics(table, *rows, low=None):
    """Make a scene of a family by its table, from (quantity, |e|) of the reduced model."""
    made = record([("reduced", 10, e, 1e-3, q) for q, e in rows], quantities=("force", "stiffness"))
    changed = {} if low is None else {"low": low, "word": "not resolved"}
    verdicts = tuple(replace(v, **changed) if v.word != "no result" else v for v in made.verdicts)
    return replace(made, name=f"{table}-{rows[0][1]}", text=f"[{table}]\n", verdicts=verdicts)


def test_a_family_is_answered_only_as_far_as_was_shown():
    """Within in some quantities is no "no", a bar beyond the tolerance is no "no" either."""
    shown = [
        physics("wear", ("force", 0.001), ("stiffness", 0.002)),
        physics("friction", ("force", 0.003), ("stiffness", 0.5)),
        physics("rolling", ("force", 0.04), ("stiffness", 0.5)),
        physics("adhesion", ("force", 0.06), low=0.0),
        physics("adhesion", ("force", 0.004), ("stiffness", 0.002)),
    ]
    rows = finding(shown)
    assert [row.use for row in rows] == ["yes", "for F only", "no", "not known", "yes"]
    # One scene is one scene: no sentence on all of its kind.
    assert rows[0].scenes == "contacts that wear: wear-0.001"
    assert rows[-1].scenes == "adhesive contacts: adhesion-0.004"
    assert rows[2].error.startswith("k 50\u202f%")
    assert rows[2].instead == "closed form (exact) 2.0\u202fs"
    unsure = record([("reduced", 10, 0.06, 1e-3)], "bem_fft", 0.04)
    (row,) = finding([shown[2], replace(unsure, name="slow", text="[rolling]\n")])
    assert row.instead == "closed form (exact) 2.0\u202fs; none is within in 1 scene"


def test_a_finding_has_eight_rows_at_most():
    """Families are joined, those first that hold; their scenes stay counted."""
    tables = ("wear", "friction", "rolling", "adhesion", "plasticity", "lubrication", "sliding")
    good = [physics(name, ("force", 0.001)) for name in tables]
    bad = [physics(name, ("force", 0.02)) for name in tables]
    rows = finding(good + bad[:7])
    assert len(rows) == 8
    assert rows[0].scenes == (
        "contacts that wear, contacts with friction, rolling contacts and 4 more (7 scenes)"
    )
    several = [*bad, physics("dynamics", ("force", 0.02))]
    assert [(row.use, row.scenes[-10:]) for row in finding(good + several)] == [
        ("yes", "(7 scenes)"),
        ("no", "(8 scenes)"),
    ]


# Surfaces or lines of an ensemble that are solved again: each is what it was, or none would be.
AGAIN = 3
# Conjugate gradients and sums over other blocks repeat to this; a tolerance is a thousand times it.
SAME = 1e-6


def change_again(plan, record, setting):
    """Solve a setting again; return the largest relative change of each judged quantity."""
    rows = record.solved_rows(setting.method)
    single = (rows["resolution"] == setting.resolution) & (rows["realisation"] != MEAN)
    rows = rows.where(single)
    surfaces = sorted(set(rows["realisation"].astype(int)))[:AGAIN]
    solution = execute(task_of(plan, setting.method, setting.resolution, tuple(surfaces)), 1)
    changes = {}
    for name in {verdict.quantity for verdict in setting.counted} - set(FIELDS):
        for row, surface in enumerate(surfaces):
            values = rows[name][rows["realisation"] == str(surface)]
            change = np.abs(solution.quantities[name][row] / values - 1)
            changes[name] = max(changes.get(name, 0.0), float(np.max(change)))
    return changes


def assert_passes_again(plan, record):
    for setting in advise(record).reaching():
        assert setting.holds(record.tolerance), setting.text
        if setting.is_truth:
            continue
        changes = change_again(plan, record, setting)
        for verdict in setting.counted:
            change = changes.get(verdict.quantity, 0.0)
            assert change <= SAME, (setting.text, verdict.quantity)
            assert verdict.high + 2 * change <= record.tolerance + SAME, setting.text


LONG = {"rough-free", "rough-periodic", "measured-map"}  # of the rough ones `.ci/run` has a patch


def assert_scene_passes_again(name, changes, known):
    for plan in plan_scene(load_scene(name, changes)):
        record = known.get(plan.scene.name)
        if record is None:
            plan, solved = solved_in_memory(plan, "quick")
            record = record_scene(plan, solved)
        assert_passes_again(plan, record)


def test_the_settings_of_a_sentence_pass_when_they_are_run_again():
    few = {"compare.methods": ["closed_form", "reduced", "bem_fft"]}
    assert_scene_passes_again("paraboloid", few | {"compare.resolutions": [8, 16, 32]}, {})


@pytest.mark.slow
def test_the_truth_is_refined_until_some_setting_is_sure_of_the_tolerance(tmp_path, capsys):
    """Bumps of eight points a wave: on the grids planned the area is not known to 0.3 %."""
    x = np.arange(16) * 2 * np.pi / 8
    np.savetxt(tmp_path / "bumps.txt", 1e-8 * np.cos(x[:, None]) * np.cos(x) * (1 + 0.02 * x))
    surface = {"kind": "map", "file": str(tmp_path / "bumps.txt"), "size": ["1 um", "1 um"]}
    surface["height_unit"] = "m"
    scene = {
        "name": "bumps",
        "half_space": {"effective_modulus": "100 GPa"},
        "surface": surface,
        "loading": {"force": {"values": [0.01], "relative_to": "E* A0 h'"}},
        "compare": {"methods": ["bem_dense", "bem_fft"], "tolerance": 0.003},
    }
    (tmp_path / "bumps.toml").write_text(tomli_w.dumps(scene), encoding="utf-8")
    (plan,) = plan_scene(load_scene(tmp_path / "bumps.toml", {}))
    planned = max(n for method, n in plan.settings if method == "bem_fft")
    assert advise(record_scene(*solved_in_memory(plan, "quick"))).cheapest is None
    assert run_command(["advise", str(tmp_path / "bumps.toml")]) == 0
    said = capsys.readouterr().out
    assert f"N = {2 * planned}, the reference itself" in " ".join(said.split())


@pytest.mark.slow
@pytest.mark.parametrize(
    "name",
    [
        pytest.param(name, marks=[pytest.mark.nightly] if name in LONG else [])
        for name in SUITES["quick"]
    ],
)
def test_every_sentence_of_the_quick_suite_passes_when_its_settings_are_run_again(
    quick_suite, name
):
    """Errors and bars, on any machine: times decide nothing here."""
    assert_scene_passes_again(name, {}, quick_suite)
