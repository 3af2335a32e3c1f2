"""Files of hard cases: one table adds a case, and everything that is wrong is told at once."""

import pickle

import numpy as np
import pytest

from comparisons.errors import ProblemsError
from comparisons.facts.methods import BUILT_IN, METHODS
from comparisons.files import read_toml
from comparisons.questions.hard_cases import case as files
from comparisons.questions.hard_cases.case import (
    JUDGED,
    HardCase,
    builtin_files,
    catalogue,
    load_cases,
    read_cases,
)

DEEP = """
[cases.deep]
title = "A ball pressed by a micrometre"
hard = "nothing"
like = "easy"
scene."loading.penetration" = "1 um"
"""


@pytest.fixture
def cases(tmp_path):
    """Return a reader of files with these texts, beside the built-in ones."""

    def read(*texts):
        paths = [tmp_path / f"{'abc'[place]}.toml" for place in range(len(texts))]
        for path, text in zip(paths, texts, strict=True):
            path.write_text(text, encoding="utf-8")
        return {case.id: case for case in read_cases(paths, builtin_files())}

    return read


@pytest.fixture
def problems(cases, tmp_path):
    """Return a reader that gives the problems of files instead, without their folder."""

    def read(*texts):
        with pytest.raises(ProblemsError) as caught:
            cases(*texts)
        return [text.replace(f"{tmp_path}/", "") for text in caught.value.problems]

    return read


def test_something_is_expected_of_all_built_in_methods():
    assert [name for name in BUILT_IN if not METHODS[name].peer] == list(JUDGED)


def test_every_baseline_is_what_a_case_is_like():
    """Directly, or by another baseline: no table of the catalogue is without effect."""
    tables = [read_toml(file) for file in builtin_files()]
    entries = [
        e for t in tables for e in [t, *t["baselines"].values(), *t.get("cases", {}).values()]
    ]
    liked = {entry.get("like") for entry in entries}
    assert {name for table in tables for name in table["baselines"]} == liked - {None}


def test_one_table_adds_a_case(cases):
    """It has the scene, the resolutions and the expectations of an easy one, but for its depth."""
    easy, deep = catalogue()["load-one"], cases(DEEP)["deep"]
    assert deep.model_copy(update={"id": easy.id, "title": easy.title, "hard": easy.hard}) == easy


def test_cases_travel_by_value():
    """To workers and clusters: a case is data, its maps and formulas are recipes."""
    for case in catalogue().values():
        copy = pickle.loads(pickle.dumps(case))
        assert copy.slow == case.slow
        # A scene may have a NaN, which equals nothing, and a set has no order.
        assert repr(copy.model_copy(update={"slow": ()})) == repr(
            case.model_copy(update={"slow": ()})
        )


def test_what_is_expected_is_completed_unless_it_is_another_outcome(cases):
    text = DEEP + (
        "expected.reduced = { lost = [0], text = 'gone' }\n"
        "expected.bem_fft = { accurate = 1e-3 }\n"
        "expected.bem_dense = { refused = 'too many' }\n"
    )
    expected = cases(text)["deep"].expected
    assert (expected["reduced"].error, expected["reduced"].lost) == (1e-11, (0,))
    assert expected["bem_fft"].accurate == (1e-3,)
    assert (expected["bem_dense"].kind, expected["bem_dense"].accurate) == ("refused", ())
    assert expected["fem"] == catalogue()["load-one"].expected["fem"]


def test_one_expectation_of_all_methods(cases):
    deep = cases(DEEP + "expected.all = { refused = 'no' }\nexpected.fem = { not_for = 'why' }\n")
    kinds = {name: one.kind for name, one in deep["deep"].expected.items()}
    assert kinds == dict.fromkeys(JUDGED, "refused") | {"fem": "not for"}


def test_all_problems_of_all_files_are_listed_at_once(problems):
    told = problems(
        "colour = 1\n",
        """
[cases.one]
hard = ""
colour = "red"
like = "easy"
resolutions = { reduced = 0, tamaas = 3 }
maps."map.npy" = { points = 16, paraboloid = "1 m" }
expected.fem = { degraded = 0.5 }
expected.reduced = { accurate = 0.5 }
expected.bem_fft = { accurate = 0.001, lost = [-1] }
expected.bem_dense = { refused = "", accurate = 0.001, degraded = 0.1, why = "cells" }
truth = { method = "fem", formula = { constant = { force = 1.0 } } }
slow = ["abacus"]

[cases.two]
title = "Two"
hard = "all"
like = "nobody"
scene = { indentor = 3 }
""",
        "cases = 3 = 4\n",
    )
    text = "\n".join(told)
    for part in (
        "a.toml: colour: unknown key",
        "b.toml: one: title: expected, but missing",
        "b.toml: one: hard: expected a non-empty text",
        "b.toml: one: colour: unknown key",
        "b.toml: one: resolutions.reduced: expected greater than or equal to 1",
        "b.toml: one: resolutions.tamaas.[key]: expected 'closed_form'",
        "b.toml: one: maps.map.npy: expected points and side beside paraboloid",
        "b.toml: one: expected.fem: expected why beside degraded",
        "b.toml: one: expected.bem_dense: expected exactly one of accurate, degraded, refused, not",
        "b.toml: one: expected.reduced: expected accurate to at most 0.01",
        "b.toml: one: expected.bem_fft.lost.0: expected greater than or equal to 0",
        "b.toml: one: truth: expected a formula or a method that solves, got method",
        "b.toml: one: slow.0: expected 'closed_form'",
        "b.toml: two: like: expected one of adhesive-ball",
        "b.toml: two: expected: expected, but missing",
        "c.toml: not valid TOML",
    ):
        assert part in text, (part, text)


def test_ids_and_names_are_taken_once(problems):
    told = problems(DEEP, DEEP, "[cases.load-one]\nlike = 'easy'\n[baselines.easy]\n")
    assert {line for line in told if "taken" in line} == {
        "a.toml: deep: expected an id that is not taken",
        "b.toml: deep: expected an id that is not taken",
        "c.toml: load-one: expected an id that is not taken",
        "c.toml: baselines.easy: expected a name that is not taken",
    }


def on_map(maps):
    surface = "{ kind = 'map', file = 'map.npy', size = '1 mm', height_unit = 'm' }"
    head = "[cases.deep]\ntitle = 'A'\nhard = 'b'\nlike = 'rough'\n"
    return f"{head}scene.surface = {surface}\n{maps}"


MINE = DEEP.replace("easy", "mine")
HOLLOW = DEEP + "scene.indenter = { shape = 'profile', r = [0, 1, 2], f = [0, -1, 2] }\n"


@pytest.mark.parametrize(
    ("text", "told"),
    [
        (
            DEEP.replace("easy", "ball-on-steel") + "expected.fem = { accurate = 0.01 }\n",
            "got nothing of closed_form, reduced, bem_dense, bem_fft",
        ),
        # of a baseline once, and there
        (
            "[baselines.mine]\nlike = 'easy'\nexpected.fem = { accurate = -1 }\n"
            + MINE
            + MINE.replace(".deep", ".other"),
            "a.toml: baselines.mine: expected.fem.accurate.0: expected a positive",
        ),
        (
            "[baselines.one]\nlike = 'two'\n[baselines.two]\nlike = 'one'\n"
            + DEEP.replace("easy", "one"),
            "a.toml: baselines.two: like: expected no circle, one is like this one",
        ),
        (
            DEEP + "scene.'indenter.radius' = '-1 mm'\n",
            "a.toml: deep: scene: indenter.radius: expected a pos",
        ),
        (DEEP + "scene.colour = 3\n", "a.toml: deep: scene: colour: unknown key"),
        (
            HOLLOW + "expected.all = { refused = 'steep' }\n",
            "hollow profiles have no reduced model",
        ),
        (
            DEEP + "truth = { scene = { 'indenter.radius' = 0 } }\n",
            "a.toml: deep: truth.scene: indenter.radius: expected a positive",
        ),
        *(
            (
                DEEP + "truth = { formula = { creeping = true }, source = 'slow' }\n",
                f"a.toml: deep: truth.formula: expected {key} in the scene, which has none",
            )
            for key in ("viscoelastic", "sliding")
        ),
        (
            on_map("maps.'a.npy' = { from = 'b.npy' }"),
            "a.npy: expected from = a map that is made from",
        ),
        (
            on_map(
                "maps.'a.npy' = { points = 4, side = 1, level = 0, "
                "point = { index = [4, 0], height = 1 } }"
            ),
            "a.npy.point.index: expected places below 4",
        ),
        (on_map("maps.'../a.npy' = { points = 4, side = 1, level = 0 }"), "expected a file name"),
        (on_map(""), "scene: surface.file: expected a file, or one of maps, got 'map.npy'"),
        ("cases = 3", "a.toml: cases: expected"),
        ("cases.a = 3", "a.toml: cases.a: expected"),
        ("[[cases]]", "a.toml: cases: expected"),
        ("baselines = [1]", "a.toml: baselines: expected"),
        ("like = 3", "a.toml: like: expected"),
    ],
)
def test_what_is_wrong_is_told_once_before_anything_runs(problems, text, told):
    assert "\n".join(problems(text)).count(told) == 1


def test_a_wrong_scene_that_is_refused_as_expected_is_a_hard_case(cases):
    """A refusal at the door is a subject of the catalogue; one for another reason is a mistake."""
    assert cases(HOLLOW + "expected.all = { refused = 'hollow' }\n")


@pytest.mark.parametrize("key", ["scene", "expected", "maps", "truth", "slow", "resolutions"])
@pytest.mark.parametrize("value", ["3", "'text'", "[1]", "nan"])
def test_values_of_the_wrong_kind_are_told(problems, key, value):
    text = DEEP.replace('scene."loading.penetration" = "1 um"', "") + f"{key} = {value}\n"
    assert any(line.startswith(f"a.toml: deep: {key}") for line in problems(text))


def test_unknown_names_and_wrong_files_are_told_together(tmp_path):
    (tmp_path / "bad.toml").write_text("colour = 3")
    with pytest.raises(ProblemsError) as caught:
        load_cases(["moon", "cusp", str(tmp_path / "bad.toml")])
    first, second = caught.value.problems
    assert "no such case or file: 'moon'" in first
    assert second.endswith("bad.toml: colour: unknown key")


def test_cases_of_a_file_are_chosen_beside_built_in_ones(tmp_path):
    (tmp_path / "own.toml").write_text(DEEP)
    chosen = load_cases(["cusp", str(tmp_path / "own.toml"), "cusp"])
    assert [case.id for case in chosen] == ["cusp", "deep"]


ROUGH = {
    "points": 64,
    "side": 64e-6,
    "self_affine": {"hurst": 0.8, "rms_slope": 0.1, "seed": 1},
    "seed": 3,
}


@pytest.fixture
def heights(tmp_path):
    def make(**recipe):
        table = {
            "id": "map",
            "title": "Map",
            "hard": "map",
            "scene": {"surface": {}},
            "expected": {name: {"refused": "no"} for name in JUDGED},
            "maps": {"rough.npy": ROUGH, "map.npy": recipe},
        }
        HardCase.model_validate(table).write_maps(tmp_path)
        return np.load(tmp_path / "map.npy"), np.load(tmp_path / "rough.npy")

    return make


def test_a_map_from_another_is_changed_and_leaves_it_alone(heights):
    changed, rough = heights(**{"from": "rough.npy", "point": {"index": [5, 7], "height": np.inf}})
    assert [tuple(index) for index in np.argwhere(changed != rough)] == [(5, 7)]
    assert np.isfinite(rough).all()


def test_points_without_a_height_are_about_the_share_that_is_said(heights):
    """4096 draws of 10 %: their share is off by less than 2 % in all but 1 of 5000 seeds."""
    holes, rough = heights(**{"from": "rough.npy", "undefined": 0.1, "seed": 3})
    assert np.isnan(holes).mean() == pytest.approx(0.1, abs=0.02)
    assert (holes == rough)[~np.isnan(holes)].all()


def test_heights_are_ground_off_rounded_shaken_and_stored_as_said(heights):
    cut, rough = heights(**{"from": "rough.npy", "cut": 0.0})
    assert cut.max() == 0.0
    stepped, _ = heights(**{"from": "rough.npy", "step": "40 nm"})
    np.testing.assert_allclose(stepped / 40e-9, np.round(stepped / 40e-9), rtol=1e-12)
    assert np.abs(stepped - rough).max() <= 20.001e-9
    shaken, _ = heights(**{"from": "rough.npy", "noise": 1e-3, "seed": 1})
    assert np.std(shaken / rough - 1) == pytest.approx(1e-3, rel=0.05)
    single, _ = heights(**{"from": "rough.npy", "precision": "float32"})
    assert single.dtype == np.float32


def test_a_tip_has_the_radius_that_is_said(heights):
    """Of z = -r^2/(2R): second differences of a paraboloid are -(spacing^2)/R everywhere."""
    tip, _ = heights(points=16, side="16 um", paraboloid="10 um")
    np.testing.assert_allclose(np.diff(tip, 2, axis=0), -(1e-6**2) / 10e-6, rtol=1e-9)
    np.testing.assert_array_equal(tip, tip[::-1, ::-1].T)


def test_one_file_more_is_one_family_more(tmp_path, monkeypatch):
    """A built-in case is a table beside the others: nothing else names it."""
    for file in builtin_files():
        (tmp_path / file.name).write_bytes(file.read_bytes())
    (tmp_path / "mine.toml").write_text(DEEP)
    monkeypatch.setattr(files, "FOLDER", tmp_path)
    assert list(catalogue.__wrapped__()) == [*catalogue(), "deep"]
