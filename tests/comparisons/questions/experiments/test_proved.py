"""Experiments and scenes judged by proved bounds."""

import csv
import math
from pathlib import Path

from comparisons.questions.experiments.proved import punch_stiffness, pyramid_bounds
from reference.bounds.flat_faces import equal_area_stiffness


def test_the_problem_sheet_lies_within_coarser_intervals():
    # two enclosures of one number overlap; those of a few cells hold the sheet's
    file = Path(__file__).parents[4] / "docs" / "problem-sheet.csv"
    with file.open(newline="", encoding="utf-8") as lines:
        sheet = {row["problem"]: row for row in csv.DictReader(lines)}
    circle = equal_area_stiffness(4.0)
    coarse = {
        "square": punch_stiffness("polygon", 4, 1.0, "quick") * (1 / circle),
        "Vickers": pyramid_bounds(4, "quick") * math.tan(math.radians(68)),
    }
    for name, interval in coarse.items():
        sides = [float(sheet[name][side]) for side in ("not below", "not above")]
        assert interval.lower < sides[0] < sides[1] < interval.upper
        assert sides[1] / sides[0] - 1 < 2e-4
