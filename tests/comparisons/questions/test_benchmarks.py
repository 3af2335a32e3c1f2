"""Benchmarks: what they measure, how readings become ratios, and the command's file."""

import json
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest

from comparisons.questions import benchmarks
from comparisons.questions.benchmarks import bem, memory, reduced, yardstick
from comparisons.questions.benchmarks import fem as fem_benchmark
from comparisons.questions.benchmarks.yardstick import interleaved, measurement, vector_features
from reduced.rough.press import press
from reference.contact import press as unilateral
from reference.loads import Load
from roughline.commands.app import run_command

KEYS = {"name", "seconds", "yardstick", "yardstick_seconds", "ratio", "target", "met"}


def test_readings_take_turns_and_the_first_call_is_not_measured():
    """A task whose first call takes 100 s (compilation), the others 1 s, by a clock of our own."""
    calls, clock = [], [0.0]

    def slow_at_first():
        clock[0] += 1.0 if "a" in calls else 100.0
        calls.append("a")

    tasks = {"a": slow_at_first, "b": lambda: calls.append("b")}
    times = interleaved(tasks, repeats=3, clock=lambda: clock[0])
    assert times["a"] == pytest.approx([1.0] * 3)
    assert sum(one != two for one, two in pairwise(calls)) >= 5


def test_ratio_is_the_median_of_neighbouring_readings():
    """One disturbed reading out of three moves neither the times nor the ratio."""
    row = measurement("x", [1.0, 9.0, 1.0], "y", [2.0, 2.0, 2.0], 0.5)
    assert (row.seconds, row.yardstick_seconds, row.ratio, row.met) == (1.0, 2.0, 0.5, True)
    assert measurement("x", [2.0], "y", [2.0], 0.5).met is False
    assert measurement("x", [2.0], "y", [2.0]).met is None


def test_a_ratio_of_measured_errors_is_written_as_json():
    """`met` of NumPy's numbers was no JSON: the command lost its file after all measurements."""
    row = replace(measurement("x", [1.0], "y", [2.0], 1.0), ratio=np.float64(0.5))
    assert json.loads(json.dumps(row.row()))["met"] is True


def test_the_lines_of_the_benchmark_are_rough_lines_in_partial_contact():
    """Rms height 1, and three decades of force that stay short of full contact."""
    lines = reduced.rough_lines(3, 64)
    assert np.std(lines.heights, axis=1) == pytest.approx(1.0, rel=1e-12)
    contact = press(lines, 1.0, reduced.load_lists(lines, 15)[0])
    assert 0.3 * 64 < contact.contact_length[:, -1].mean() < 0.9 * 64
    assert contact.contact_length.max() < 64
    assert contact.force.max() / contact.force.min() == pytest.approx(1e3)


def test_command_prints_the_table_and_writes_the_rows(monkeypatch, tmp_path, capsys):
    """Exit code 0 although a target is missed; the file has the keys of the contract.

    Nobody reads it on a terminal here, so no line is folded, however much the processor can.
    """
    monkeypatch.delenv("COLUMNS", raising=False)
    rows = [measurement("a", [1.0], "np.argsort", [1.0], 0.5), measurement("b", [1.0], "y", [1.0])]
    monkeypatch.setitem(benchmarks.BENCHMARKS, "reduced", lambda: rows)
    path = tmp_path / "bench.json"
    assert run_command(["bench", "reduced", "--json", str(path)]) == 0
    written = json.loads(path.read_text(encoding="utf-8"))
    assert [set(row) for row in written] == [KEYS, KEYS]
    assert [row["met"] for row in written] == [False, None]
    printed = capsys.readouterr().out
    assert "not met" in printed
    assert f"vector units: {vector_features()}" in printed.splitlines()


@pytest.mark.slow
def test_the_whole_benchmark_runs_and_names_each_row_once(monkeypatch):
    """Times are for people to read: none is asserted, so one reading of each does."""
    monkeypatch.setattr(yardstick, "interleaved", lambda tasks, repeats: interleaved(tasks, 1))
    measured = reduced.measure()
    rows = {row.name: row for row in measured}
    assert len(rows) == len(measured)
    assert all(row.seconds > 0 and np.isfinite(row.ratio) for row in rows.values())


def tiny(target=0.125):
    return bem.rough(32, 8, bem.MEDIUM, target)


def test_the_surfaces_of_the_half_space_benchmark_are_in_the_contact_they_promise():
    """20 to 25 % and 3 to 5 % of the cells, at a cutoff of 8 cells."""
    for fraction, low, high in ((bem.MEDIUM, 0.2, 0.25), (bem.LIGHT, 0.03, 0.05)):
        case = bem.rough(64, 8, fraction, None)
        body, gap, load = case.operator(), case.gaps[0], Load("force", float(case.loads[0]))
        contact = unilateral.press(body, gap, load)
        assert low <= contact.mask.mean() <= high
        assert f"{contact.mask.mean():.0%}"[:1] in case.name


@pytest.mark.parametrize("cropped", [False, True])
def test_the_paraboloid_of_the_benchmark_touches_over_the_radius_it_promises(cropped):
    """Hertz: a cell count errs by less than its rim; cropping changes nothing but the grid."""
    case = bem.hertz(64, 12, None, cropped=cropped)
    assert case.gaps.shape[1] == (34 if cropped else 64)
    contact = unilateral.press(case.operator(), case.gaps[0], Load("force", float(case.loads[0])))
    assert np.sqrt(contact.mask.sum() / np.pi) == pytest.approx(12, abs=0.5)


@pytest.mark.slow
def test_rows_without_a_peer_say_so_and_still_have_our_time(monkeypatch):
    monkeypatch.setattr(bem.client, "installed", lambda peer: False)
    row = bem.against_peers(tiny())
    assert row.seconds > 0
    assert row.yardstick == "no peer installed: pip install 'roughline[peers]'"
    assert (row.yardstick_seconds, row.ratio, row.target, row.met) == (None, None, 0.125, None)
    assert json.loads(json.dumps(row.row(), allow_nan=False))["met"] is None
    row = fem_benchmark.against_peer("nobody")
    assert (row.ratio, row.met) == (None, None)
    assert "no such method" in row.yardstick
    (row,) = memory.rows((memory.Case("nothing", {}, (1,), "nobody"),))
    assert row.met is None
    assert "nothing" in row.name


@pytest.mark.slow
def test_the_faster_peer_is_the_yardstick_and_a_missed_target_is_said(monkeypatch):
    """Two peers of 1 ms and 1 us beside a solve of milliseconds."""
    monkeypatch.setattr(bem.client, "installed", lambda peer: True)
    times = {"tamaas": 1e-3, "contactmechanics": 1e-6}

    def answer(peer, *_, **__):
        return bem.client.PeerResult(processor_seconds=[times[peer]] * 3)

    monkeypatch.setattr(bem.client, "press", answer)
    monkeypatch.setattr(bem.client, "attempt", answer)
    row = bem.against_peers(tiny())
    assert row.yardstick.startswith("ContactMechanics")
    assert row.yardstick_seconds == 1e-6
    assert row.met is False


@pytest.mark.slow
@pytest.mark.parametrize("peer", tuple(bem.client.PACKAGES))
def test_a_real_peer_becomes_a_yardstick_at_the_same_violation(peer, monkeypatch):
    if not bem.client.installed(peer):
        pytest.skip(f"{peer} is not installed")
    monkeypatch.setattr(bem.client, "installed", lambda part: part == peer)
    row = bem.against_peers(tiny())
    assert row.yardstick.startswith(bem.client.PACKAGES[peer][0])
    ours, theirs = (float(text.rpartition(" ")[2]) for text in (row.name, row.yardstick))
    assert ours / 20 < theirs <= 1.1 * ours  # both printed with one digit
    assert row.ratio == pytest.approx(row.seconds / row.yardstick_seconds)


def test_the_finite_element_job_is_hertz_at_thirty_depths():
    """Three elements per radius hold 2e-4 at every depth; each part of the work has its time."""
    job = fem_benchmark.run(3)
    assert job.errors.shape == (30,)
    assert np.abs(job.errors).max() < 2e-4
    assert set(job.body.seconds) == {"mesh", "assembly", "condensation"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "title", "resolutions"),
    [
        ("fem", "fem, paraboloid", (4, 5, 6)),
        ("fem", "fem by iteration, paraboloid", (8, 10, 12)),
        ("bem", "bem_dense, one force", (16, 18, 20)),
        ("bem", "bem_dense, cylinder", (18, 21, 24)),
    ],
)
def test_the_plan_knows_the_memory_of_a_solve(kind, title, resolutions):
    """Peak of a fresh process, to a fifth (measured: 12 %); the C library rounds and keeps some."""
    (case,) = (case for case in memory.CASES[kind] if case.title == title)
    rows = memory.rows((case._replace(resolutions=resolutions),))
    assert len(rows) == 3
    assert [row.name for row in rows if not row.met] == []


def test_a_peer_is_timed_on_its_coarsest_mesh_with_the_error_asked_for():
    """The FFT solver stands in for a finite-element code: any method will do."""
    seconds, error, unknowns = fem_benchmark._peer_seconds("bem_fft", 5e-3)
    assert seconds > 0
    assert error <= 5e-3
    assert unknowns > 100
    assert "best error" in fem_benchmark._peer_seconds("bem_fft", 1e-9)
