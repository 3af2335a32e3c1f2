"""What a sentence "for t %" promises is there when its settings are run again."""

import numpy as np
import pytest
import tomli_w

from comparisons.facts.quantities import FIELDS
from comparisons.questions.study import solved_in_memory
from comparisons.results import selection
from comparisons.results.advice import advise
from comparisons.results.scene_record import record_scene
from comparisons.scene.scene import SUITES, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from roughline.commands.app import run_command

# Surfaces or lines of an ensemble that are solved again: each is what it was, or none would be.
AGAIN = 3
# Conjugate gradients and sums over other blocks repeat to this; a tolerance is a thousand times it.
SAME = 1e-6


def change_again(plan, record, setting):
    """Solve a setting again; return the largest relative change of each judged quantity."""
    rows = selection.solved_rows(record, setting.method)
    single = (rows["resolution"] == setting.resolution) & (rows["realisation"] != selection.MEAN)
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
    assert f"N = {2 * planned}, the truth itself" in " ".join(said.split())


@pytest.mark.slow
@pytest.mark.parametrize("name", SUITES["quick"])
def test_every_sentence_of_the_quick_suite_passes_when_its_settings_are_run_again(
    quick_suite, name
):
    """Errors and bars, on any machine: times decide nothing here."""
    assert_scene_passes_again(name, {}, quick_suite)
