"""Experiments and scenes judged by proved bounds."""

import csv
import math
from pathlib import Path

import pytest

from comparisons.geometry.prepare import prepare
from comparisons.methods.normal.proved import proof_of
from comparisons.methods.solver import Refused
from comparisons.questions.experiments import EXPERIMENTS
from comparisons.questions.experiments.proved import (
    _CELLS,
    EQUAL_AREA,
    punch_stiffness,
    pyramid_bounds,
)
from comparisons.scene.scene import Scene
from reference import closed_form
from reference.bounds.flat_faces import equal_area_stiffness
from reference.bounds.interval import Interval


def scene(**tables):
    return Scene.model_validate(
        {
            "name": "bounded",
            "half_space": {"youngs_modulus": "1 GPa", "poisson_ratio": 0.0},
            "loading": {"penetration": ["1 um"]},
            **tables,
        }
    )


@pytest.mark.slow
def test_circles_of_equal_area_are_too_soft(monkeypatch):
    # coarse bounds, 2 % wide, decide it already: 2 % for the square, 6 % for the triangle
    monkeypatch.setitem(_CELLS, "quick", (4, 4))
    for sides, most in ((3, 0.07), (4, 0.03)):
        measured = EXPERIMENTS["face-rule"].measure(sides, "quick", rule=EQUAL_AREA)
        assert measured.error + measured.uncertainty < 0
        assert abs(measured.error) < most


def proved(**tables):
    made = scene(**tables)
    return proof_of(made, prepare(made)[0])


def test_force_of_a_ball_is_enclosed_in_si_units():
    proof = proved(indenter={"shape": "paraboloid", "radius": "1 mm"})
    hertz = closed_form.paraboloid(1e-3, 1e9)
    assert float(hertz.force(1e-6)) in proof.force(1e-6)
    at = Interval(1e-6, 1e-6), proof.force(1e-6)
    assert float(hertz.energy(1e-6)) in proof.energy(*at)
    assert float(hertz.stiffness(1e-6)) in proof.stiffness(*at)
    assert proof.force(1e-6).width < 1e-4


def test_a_cylinder_has_one_stiffness():
    proof = proved(indenter={"shape": "cylinder", "radius": "2 mm"})
    one, other = (proof.stiffness(Interval(d, d), proof.force(d)) for d in (1e-6, 2e-6))
    assert 2 * 1e9 * 2e-3 in one
    assert one == other


@pytest.mark.parametrize(
    ("tables", "reason"),
    [
        ({"indenter": {"shape": "power_law", "exponent": 0.5, "coefficient": 1.0}}, "convex"),
        (
            {
                "indenter": {"shape": "paraboloid", "radius": "1 mm"},
                "adhesion": {"work": "0.05 J/m^2"},
            },
            "without friction, adhesion",
        ),
        ({"indenter": {"shape": "profile", "r": [0, 1e-3], "f": [0, 1e-4]}}, "no bound"),
    ],
)
def test_what_no_theorem_covers_says_why(tables, reason):
    with pytest.raises(Refused, match=reason):
        proved(**tables)


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
