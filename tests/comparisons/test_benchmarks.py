"""Benchmarks: what they measure, how readings become ratios, and the command's file."""

from __future__ import annotations

import json
import time
from itertools import pairwise

import numpy as np
import pytest

from comparisons import benchmarks
from comparisons.benchmarks import reduced
from comparisons.benchmarks.yardstick import interleaved, measurement, vector_features
from reduced.rough_line import press
from reports.cli import run_command

KEYS = {"name", "seconds", "yardstick", "yardstick_seconds", "ratio", "target", "met"}


def test_readings_take_turns_and_the_first_call_is_not_measured():
    """A task whose first call sleeps (compilation): its readings do not show it."""
    calls = []

    def slow_at_first():
        time.sleep(0.0 if calls.count("a") else 0.05)
        calls.append("a")

    times = interleaved({"a": slow_at_first, "b": lambda: calls.append("b")}, repeats=3)
    assert all(len(readings) == 3 for readings in times.values())
    # The sleep of 50 ms is three orders above what appending to a list costs.
    assert max(times["a"]) < 0.01
    switches = sum(one != two for one, two in pairwise(calls))
    assert switches >= 5


def test_ratio_is_the_median_of_neighbouring_readings():
    """One disturbed reading out of three moves neither the times nor the ratio."""
    row = measurement("x", [1.0, 9.0, 1.0], "y", [2.0, 2.0, 2.0], 0.5)
    assert (row.seconds, row.yardstick_seconds, row.ratio, row.met) == (1.0, 2.0, 0.5, True)
    assert measurement("x", [2.0], "y", [2.0], 0.5).met is False
    assert measurement("x", [2.0], "y", [2.0]).met is None


def test_growth_is_the_exponent_of_the_fit():
    """Cost ~ N^1.5 has exponent 1.5, above N log N; cost ~ N has 1.0, below it."""
    sizes = reduced.SIZES
    fast = reduced._growth({n: 1e-8 * n for n in sizes})
    slow = reduced._growth({n: 1e-8 * n**1.5 for n in sizes})
    assert fast.name.endswith("1.00")
    assert slow.name.endswith("1.50")
    assert (fast.met, slow.met) == (True, False)


def test_the_lines_of_the_benchmark_are_rough_lines_in_partial_contact():
    """Rms height 1, and three decades of force that stay short of full contact."""
    lines = reduced.rough_lines(3, 64)
    assert np.std(lines, axis=1) == pytest.approx(1.0, rel=1e-12)
    loads = reduced.load_lists(lines, 15)
    contact = press(lines, 1.0, 1.0, force=loads["force"])
    assert 0.3 * 64 < contact.contact_length[:, -1].mean() < 0.9 * 64
    assert contact.contact_length.max() < 64
    assert contact.force.max() / contact.force.min() == pytest.approx(1e3)


def test_command_prints_the_table_and_writes_the_rows(monkeypatch, tmp_path, capsys):
    """Exit code 0 although a target is missed; the file has the keys of the contract."""
    rows = [measurement("a", [1.0], "np.argsort", [1.0], 0.5), measurement("b", [1.0], "y", [1.0])]
    monkeypatch.setitem(benchmarks.BENCHMARKS, "reduced", lambda: rows)
    path = tmp_path / "bench.json"
    assert run_command(["bench", "reduced", "--json", str(path)]) == 0
    written = json.loads(path.read_text(encoding="utf-8"))
    assert [set(row) for row in written] == [KEYS, KEYS]
    assert [row["met"] for row in written] == [False, None]
    printed = capsys.readouterr().out
    assert "not met" in printed
    assert vector_features() in printed.replace("\n", " ")


def test_an_unknown_benchmark_is_wrong_input(capsys):
    assert run_command(["bench", "nothing"]) == 2
    assert "expected one of reduced" in capsys.readouterr().err


@pytest.mark.slow
def test_the_whole_benchmark_runs_and_long_lines_cost_less_than_ordering_them():
    """H = 0.8, a million springs, a hundred forces: below 1.5 np.argsort."""
    found = reduced.measure()
    rows = {row.name: row for row in found}
    assert len(rows) == len(found)
    assert all(row.seconds > 0 and np.isfinite(row.ratio) for row in rows.values())
    assert rows["1e6 springs x 100 loads, H = 0.8, force, nodal"].met
    assert rows["1e6 springs x 100 loads, H = 0.8, force, sub_cell"].ratio < 1.5
