"""Problem sheets, and entries that are judged by them without running anything."""

import json
import math

import numpy as np
import pytest

from comparisons.errors import InputError
from comparisons.geometry.prepare import prepare
from comparisons.judging.verdicts import NO_RESULT, OUTSIDE, WITHIN
from comparisons.questions import problem_sheets
from comparisons.questions.problem_sheets import (
    LARGEST_FILE,
    Entry,
    Known,
    builtin_sheets,
    read_entry,
    seal,
    sheet_of,
)
from roughline.commands.shared import blank_entry

SHEETS = builtin_sheets()
HERTZ = SHEETS["RL-001"]
GRIDS = {"RL-003", "RL-005"}  # the others are closed forms


def stated(**changes):
    values = {name: list(known.values) for name, known in HERTZ.reference.items()}
    entry = {"problem": "RL-001", "version": 1, "solver": "exact", "seconds": 1.0}
    return entry | {"values": values} | changes


def written(tmp_path, document, name="entry.json"):
    path = tmp_path / name
    path.write_text(document if isinstance(document, str) else json.dumps(document))
    return path


def test_half_of_the_sheets_are_sealed_and_the_others_state_all_they_know():
    sealed = [sheet for sheet in SHEETS.values() if sheet.sealed]
    assert len(sealed) == len(SHEETS) // 2
    for sheet in SHEETS.values():
        assert bool(sheet.reference) == (sheet.sealed is None)
        _, loads = prepare(sheet.scene)
        for known in sheet.reference.values():
            assert len(known.values) == len(known.bars) == len(loads.values)


def test_the_published_force_is_hertz_and_lies_between_its_bounds():
    """F = 4/3 E* sqrt(R) d^(3/2)."""
    _, loads = prepare(HERTZ.scene)
    force = 4 / 3 * HERTZ.scene.effective_modulus * np.sqrt(0.01) * loads.values**1.5
    known = HERTZ.reference["force"]
    np.testing.assert_allclose(known.values, force, rtol=1e-9)
    assert np.all(np.array(known.lower) <= force)
    assert np.all(force <= np.array(known.upper))


@pytest.mark.parametrize("name", sorted({*SHEETS} - GRIDS))
def test_references_of_closed_forms_come_out_again(name):
    sheet = SHEETS[name]
    known = problem_sheets.computed(sheet)
    if sheet.sealed:
        assert seal(known, sheet.sealed.digits) == sheet.sealed
    for quantity, published in sheet.reference.items():
        np.testing.assert_allclose(known[quantity].values, published.values, rtol=1e-9)


@pytest.mark.slow
@pytest.mark.parametrize("name", sorted(GRIDS))
def test_references_of_grids_come_out_again_within_their_bars(name):
    """To a hundredth of the bar: the same grids, other processors."""
    known = problem_sheets.computed(SHEETS[name])
    for quantity, published in SHEETS[name].reference.items():
        error = np.abs(np.array(known[quantity].values) / np.array(published.values) - 1)
        assert np.all(error < 0.01 * np.array(published.bars))


def known(*values, bar=1e-3):
    return Known(values=values, bars=(bar,) * len(values))


def test_a_seal_is_broken_by_a_change_of_the_last_digit_or_of_a_bar():
    """A wider bar would let everything pass as not resolved: it is sealed, too."""
    assert seal({"a": known(1.0, 2.0)}, 6) != seal({"a": known(1.0, 2.00001)}, 6)
    assert seal({"a": known(1.0)}, 6) != seal({"a": known(1.0, bar=1.1e-3)}, 6)
    one, other = known(1.0), known(2.0)
    assert seal({"a": one, "b": other}, 6) == seal({"b": other, "a": one}, 6)


def test_a_broken_seal_judges_nothing():
    wrong = sheet_of("rl-002").model_copy(update={"sealed": seal({"a": known(1.0)}, 6)})
    with pytest.raises(InputError, match="not the sealed one"):
        problem_sheets.reference_of(wrong)


def test_a_blank_entry_is_refused_until_it_is_filled_in(tmp_path):
    """As `roughline problems RL-001 --out DIR` writes it; a number and a name make it an entry."""
    blank = blank_entry(HERTZ, 4)
    with pytest.raises(InputError) as caught:
        read_entry(written(tmp_path, blank))
    assert "solver: expected the name of a solver" in str(caught.value)
    assert "values: expected a number for at least one load" in str(caught.value)
    blank["solver"], blank["values"]["force"][0] = "mine 1.0", 30.8
    assert read_entry(written(tmp_path, blank)).values["force"] == (30.8, None, None, None)


def test_an_exact_entry_is_within_and_a_missing_quantity_is_no_result():
    exact = problem_sheets.judge_entry(Entry.model_validate(stated()), HERTZ, HERTZ.reference)
    assert {verdict.word for verdict in exact.verdicts.values()} == {WITHIN}
    assert exact.beyond == ()
    partial = stated()
    del partial["values"]["stiffness"]
    partial["values"]["force"][2] = None
    lacking = problem_sheets.judge_entry(Entry.model_validate(partial), HERTZ, HERTZ.reference)
    assert lacking.verdicts["stiffness"].word == NO_RESULT
    assert lacking.verdicts["force"].word == "not resolved"
    assert math.isnan(lacking.error)
    assert not lacking.placed


def test_two_per_cent_are_outside_one_and_beyond_what_is_proved():
    off = stated()
    off["values"]["force"][1] *= 1.02
    judged = problem_sheets.judge_entry(Entry.model_validate(off), HERTZ, HERTZ.reference)
    assert (judged.worst, judged.verdicts["force"].word) == ("force", OUTSIDE)
    assert judged.error == pytest.approx(0.02, rel=1e-6)
    assert judged.beyond == ("force",)


def test_the_front_has_whoever_none_beats_in_both():
    def entry(solver, seconds, error):
        off = stated(solver=solver, seconds=seconds)
        off["values"]["force"][0] *= 1 + error
        return Entry.model_validate(off)

    entries = [entry("d", 10.0, 0.2), entry("good", 9.0, 1e-4), entry("untimed", None, 1e-6)]
    board = problem_sheets.board_of(HERTZ, [*entries, entry("fast", 0.1, 0.1)])
    assert [judged.entry.solver for judged in board.front] == ["fast", "good"]


def test_the_same_statement_is_one_entry_whatever_its_form(tmp_path):
    one = read_entry(written(tmp_path, stated()))
    other = read_entry(written(tmp_path, json.dumps(stated(), indent=7, sort_keys=True)))
    assert one.digest == other.digest


@pytest.mark.parametrize(
    ("document", "told"),
    [
        ("", "not valid JSON"),
        ("[" * 100_000, "not valid JSON"),
        ("{}", "problem"),
        ("null", "\n  expected a table, got None"),
        ('{"problem": NaN}', "NaN is no number of JSON"),
        ('{"seconds": 9, "a": {"b": 1, "b": 2}}', "the key 'b' is given more than once"),
        ('{"seconds": 9, "a": {}, "seconds": 1}', "the key 'seconds' is given more than once"),
        (stated(problem="RL-999"), "problem: expected one of RL-001"),
        (stated(version=7), "version: expected 1, got 7"),
        (stated(values={"moon": [1.0]}), "values.moon: expected one of force"),
        (stated(values={"force": [1.0]}), "values.force: expected 4 numbers"),
        (stated(values={"force": ["1"] * 4}), "values.force.0"),
        (stated(solver="a\x1b[31mb"), "without invisible characters"),
        (stated(solver="exact\u200b"), "without invisible characters"),
        (stated(solver="   "), "expected the name of a solver, got"),
        (stated(seconds=-1), "seconds"),
        (stated(seconds=1e-300), "seconds: expected greater than or equal to 0.000000001"),
        (stated(code="import os"), "code: unknown key"),
        ('{"problem": "RL-001", "values": {"force": [1e999, 1, 1, 1]}}', "expected finite"),
        ("x" * (LARGEST_FILE + 1), "at most"),
    ],
)
def test_a_damaged_hostile_or_enormous_file_gets_one_clear_error(tmp_path, document, told):
    with pytest.raises(InputError) as caught:
        read_entry(written(tmp_path, document))
    assert told in str(caught.value)


def test_a_folder_in_place_of_a_file_is_not_said_to_be_missing(tmp_path):
    with pytest.raises(InputError, match="not a file"):
        read_entry(tmp_path)
    with pytest.raises(InputError, match="no such file"):
        read_entry(tmp_path / "nowhere.json")


def test_files_that_are_no_entries_any_more_are_listed_and_cost_no_other_its_place(tmp_path):
    entries = tmp_path / problem_sheets.ENTRIES
    entries.mkdir()
    written(entries, "{", "a.json")
    written(entries, stated(version=2), "b.json")
    written(entries, stated(), "c.json")
    ranked, refused = problem_sheets.boards_of(tmp_path)
    assert [len(board.entries) for board in ranked] == [1]
    damaged, outdated = refused
    assert "a.json: not valid JSON" in damaged
    assert "version: expected 1, got 2" in outdated
    with pytest.raises(InputError, match="no entries"):
        problem_sheets.boards_of(tmp_path / "empty")
