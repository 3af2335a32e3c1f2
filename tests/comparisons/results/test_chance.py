"""Where a line agrees with a rough surface by chance: few contacts, or hardly any load."""

from dataclasses import replace

import pytest

from comparisons import formatting as fmt
from comparisons.questions.study import solved_in_memory
from comparisons.results.advice import advise
from comparisons.results.decisions import verdicts
from comparisons.results.finding import NOT_KNOWN, YES, finding
from comparisons.results.rows import Rows
from comparisons.results.scene_record import record_scene
from comparisons.scene.scene import load_scene
from comparisons.solving.planning import plan_scene
from reports.tables.card import not_known_here

ASKED = {
    "compare.methods": ["reduced", "bem_fft"],
    "compare.resolutions": [16, 32, 64],
    "compare.quantities": ["penetration"],
    "compare.tolerance": 0.9,  # whatever the line says is within
}


def solved(load, **changes):
    force = {"values": [load], "relative_to": "E* A0 h'"}
    scene = load_scene("rough-patch", ASKED | {"loading": {"force": force}} | changes)
    (plan, *_) = plan_scene(scene)
    return record_scene(*solved_in_memory(plan, "quick"))


@pytest.mark.parametrize(
    ("load", "reasons"),
    [
        (2e-5, ["F/(E* A₀ h') = 2.00×10⁻⁵, below 0.001", "contacts, fewer than 30"]),
        (0.01, ["contacts, fewer than 30"]),  # a patch of four waves a side has 16 summits
    ],
)
def test_within_by_chance_is_no_recommendation(load, reasons):
    """Of one surface that touches at few summits; each reason is said, with what claims know."""
    record = solved(load)
    assert [item.word for item in verdicts(record)] == ["within"]
    (row,) = finding([record])
    assert (row.use, row.cost) == (NOT_KNOWN, "–")
    assert "reduced" not in {setting.method for setting in advise(record).reaching()}
    assert "reduced model (within by chance" in advise(record).sentence
    said = not_known_here(record)
    assert all(reason in said for reason in reasons)
    assert "claim rough-penetration" in said


def test_a_model_that_takes_longer_than_a_solver_is_not_needed():
    """Lines that take a microsecond are worth it, lines that take an hour are not."""
    record = solved(0.3)
    table = record.rows.frame()
    lines = table["method"] == "reduced"

    def cost(seconds):
        times = table["seconds_all"].where(~lines, seconds)
        (row,) = finding([replace(record, rows=Rows.of(table.assign(seconds_all=times)))])
        return row.cost

    (grid,) = (item for item in advise(record).reaching() if item.method == "bem_fft")
    solver = f"{fmt.duration(grid.seconds)} (N = {grid.resolution})"
    assert cost(3600.0).startswith(f"no need: the 3-D solver is cheaper ({solver} against ")
    assert cost(1e-6).endswith("×")


def test_merged_contacts_are_few_and_no_chance():
    """At F = 0.3 E* A0 h' more than a third of the patch touches, in one piece or two."""
    record = solved(0.3)
    assert (record.reference.chance, finding([record])[0].use) == ("", YES)
    assert not_known_here(record) == ""
