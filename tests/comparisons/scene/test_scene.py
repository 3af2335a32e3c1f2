"""Scene files: everything the contract allows is read, everything else is named, all at once."""

import math
import pickle
import tomllib
from pathlib import Path

import numpy as np
import pytest

from comparisons.errors import InputError, LostWorkError, ResultsError
from comparisons.geometry.reading import FileError
from comparisons.scene.scene import (
    SceneError,
    builtin_names,
    load_scene,
    load_scenes,
    make_scene,
    parse_scene,
)
from comparisons.scene.surface import MeasuredMap

MODULUS = {"effective_modulus": 1e9}
BALL = {"shape": "paraboloid", "radius": 1.0}
DEPTHS = {"penetration": [1e-3]}
PATCH = {"kind": "self_affine", "hurst": 0.8, "size": "1 um", "points": 64, "rms_slope": 0.1}
GOOD = {"name": "x", "half_space": MODULUS, "indenter": BALL, "loading": DEPTHS}


def given(table):
    return {key: value for key, value in table.items() if value is not None}


def made(**changes):
    """Return the good scene with changed tables; a table that is None is left out."""
    return make_scene(given(GOOD | changes), "x.toml", Path())


def problems(**changes) -> list[str]:
    with pytest.raises(SceneError) as caught:
        made(**changes)
    return caught.value.problems


def rough(**changes):
    return {"indenter": None, "surface": given(PATCH | changes)}


def test_lengths_with_units_are_si_inside():
    """Exactly the float of the SI number, so that both files are the same scene."""
    scene = made(
        half_space={"youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
        indenter={"shape": "rounded_punch", "flat_radius": "3.3 um", "edge_radius": "10 nm"},
        loading={"force": ["1 mN", "2 mN"]},
    )
    same = made(
        half_space={"youngs_modulus": 210e9, "poisson_ratio": 0.3},
        indenter={"shape": "rounded_punch", "flat_radius": 3.3e-6, "edge_radius": 1e-8},
        loading={"force": [1e-3, 2e-3]},
    )
    assert scene == same
    assert scene.text == same.text


@pytest.mark.parametrize(
    ("half_space", "effective", "constants"),
    [
        ({"youngs_modulus": 210e9, "poisson_ratio": 0.3}, 210e9 / (1 - 0.3**2), (210e9, 0.3)),
        ({"youngs_modulus": 1e9, "poisson_ratio": 0}, 1e9, (1e9, 0.0)),
        ({"shear_modulus": "1 MPa", "poisson_ratio": 0.5}, 4e6, (3e6, 0.5)),
        ({"shear_modulus": 3e6, "poisson_ratio": -0.5}, 4e6, (3e6, -0.5)),
        ({"effective_modulus": "1 GPa"}, 1e9, (0.91e9, 0.3)),  # E* alone stands for nu = 0.3
    ],
)
def test_elastic_constants_and_the_effective_modulus(half_space, effective, constants):
    """E = 2 G (1 + nu), E* = E/(1 - nu^2) (Johnson 1985, eq. 4.18 for a rigid indenter)."""
    scene = made(half_space=half_space)
    assert scene.effective_modulus == pytest.approx(effective, rel=1e-15)
    assert scene.half_space.elastic_constants == pytest.approx(constants, rel=1e-14)


def test_surfaces_of_the_contract_are_read():
    recipe = rough(points=[64, 32], size=["2 um", "1 um"], power=4, hurst=None)
    synthetic = made(**recipe).surface
    assert (synthetic.points, synthetic.size) == ((64, 32), (2e-6, 1e-6))
    assert (synthetic.realisations, synthetic.seed, synthetic.periodic) == (1, 0, False)
    scan = made(**measured(size="1 um", crop=[1, 2, 30, 40])).surface
    assert scan.size == (1e-6, 1e-6)
    assert scan.detrend is None  # the plane, or the mean of a periodic map
    assert scan.realisations == 100


def test_resolutions_are_sorted_and_tolerances_may_be_per_cent():
    scene = made(compare={"resolutions": [20, 5, 10], "tolerance": "5%"})
    assert scene.compare.resolutions == (5, 10, 20)
    assert scene.compare.tolerance == 0.05


@pytest.mark.parametrize("shape", ["paraboloid", "ball"])
def test_every_unknown_key_comes_with_what_was_meant(shape):
    """Also where the shape is unknown, too: of the keys then, those of any shape are known."""
    faults = problems(
        half_space={"youngs_modulus": "1 GPa", "poissons_ratio": 0.3},
        indenter={"shape": shape, "diameter": "1 mm"},
        titel="x",
    )
    assert "half_space.poissons_ratio: unknown key; did you mean poisson_ratio?" in faults
    assert "indenter.diameter: unknown key; did you mean radius, half of it?" in faults
    assert "titel: unknown key; did you mean title?" in faults
    (fault,) = problems(indenter={"shape": "paraboloid", "radius": 1, "hurst": 0.7})
    assert fault == "indenter.hurst: unknown key; did you mean [surface] or [surface2]?"
    assert any(fault.endswith("did you mean sphere or paraboloid?") for fault in faults) == (
        shape == "ball"
    )


def test_names_of_scenes_and_methods_are_found_in_capitals_and_suggested():
    assert load_scene("Paraboloid", {"compare.methods": ["FEM"]}).compare.methods == ("fem",)
    with pytest.raises(SceneError, match=r"did you mean paraboloid\?"):
        load_scene("parabolid")
    with pytest.raises(SceneError, match=r"got 'bem'; did you mean bem_"):
        load_scene("paraboloid", {"compare.methods": ["bem"]})


def test_all_problems_of_a_file_come_at_once():
    """Each with its path in the file, what was expected and what came."""
    faults = problems(
        name="Not A Slug",
        half_space={"youngs_modulus": "1 mm", "poisson_ratio": 0.6, "density": 1},
        indenter={"shape": "paraboloid", "radius": "-1 mm", "colour": "red"},
        loading={"force": [2, 1]},
        compare={"tolerance": 0, "quantities": ["temperature"]},
        methods={"fem": {"contact": "glue"}, "magic": {}},
        extra={"key": 1},
    )
    text = "\n".join(faults)
    for expected in (
        "name: expected a slug of a-z, 0-9 and -, at most 100 characters, got 'Not A Slug'",
        "half_space.youngs_modulus: expected a unit of Pa, got one of m, got '1 mm'",
        "half_space.poisson_ratio: expected a number with -1 < nu <= 0.5, got 0.6",
        "half_space.density: unknown key",
        "indenter.radius: expected a positive finite length, got '-1 mm'",
        "indenter.colour: unknown key",
        "loading.force: expected strictly increasing values, got [2.0, 1.0]",
        "compare.tolerance: expected a positive finite number, got 0",
        "compare.quantities.0: expected 'force',",
        "methods.fem.contact: expected 'active_set', 'penalty' or 'augmented_lagrangian', got ",
        "methods.magic: unknown key",
        "extra: unknown key",
    ):
        assert expected in text
    assert len(faults) == 12


def shape(name, **keys):
    return {"indenter": {"shape": name} | keys}


def measured(**changes):
    return {"indenter": None, "surface": given({"kind": "map", "file": "a.npy"} | changes)}


WRONG = [
    ({"name": None}, "name: expected, but missing"),
    ({"name": "x" * 101}, "name: expected a slug"),
    ({"name": "../x"}, "name: expected a slug"),
    ({"half_space": None}, "half_space: expected, but missing"),
    ({"half_space": 3}, "half_space: expected a table, got 3"),
    ({"loading": None}, "loading: expected, but missing"),
    ({"loading": {}}, "exactly one of penetration, force, pressure and mean_gap, got none"),
    ({"loading": {"penetration": 1e-3, "force": 1}}, "mean_gap, got force and penetration"),
    ({"loading": {"mean_gap": 1e-3}}, "loading.mean_gap: expected a [surface]"),
    (
        {"loading": {"force": {"values": [1], "relative_to": "E* A0 h'"}}},
        "loading.force.relative_to: expected a [surface]",
    ),
    ({"indenter": None}, "expected exactly one of [indenter] and [surface], got none"),
    ({"surface": PATCH}, "[indenter] and [surface], got [indenter] and [surface]"),
    ({"indenter": {"radius": 1}}, "indenter.shape: expected one of paraboloid, sphere,"),
    ({"directory": "/"}, "directory: unknown key"),
    ({"compare": {"resolutions": [10, 10]}}, "compare.resolutions: expected a non-empty list"),
    ({"compare": {"resolutions": [1]}}, "compare.resolutions.0: expected greater than or"),
    ({"compare": {"quantities": []}}, "compare.quantities: expected a non-empty list"),
    ({"compare": {"tolerance": 1.0}}, "expected a relative tolerance below 1, got 1.0"),
    ({"methods": {"fem": {"penalty": 0}}}, "methods.fem.penalty: expected a positive"),
    (shape("cone"), "indenter.slope: expected, but missing"),
    (shape("cone", slope=1, radius=1), "radius: unknown key; only paraboloid, sphere and cylin"),
    (shape("cone", slope="1 mm"), "indenter.slope: expected a unit of a plain number"),
    (shape("sphere", radius=0), "indenter.radius: expected a positive finite length"),
    (shape("sphere", radius=1e-320), "radius: expected a length of at least 2.2e-308"),
    (shape("power_law", exponent=3, coefficient=1e-320), "coefficient: expected a"),
    (shape("power_law", exponent=0, coefficient=1), "indenter.exponent: expected"),
    (shape("power_law", exponent=101, coefficient=1), "from 0.1 to 100, got 101"),
    (shape("power_law", exponent=3, coefficient="1 m^-3"), "positive number in m^(1 - exponent)"),
    (shape("power_law", exponent=2, coefficient=10**400), "coefficient: expected a positive numb"),
    (shape("elliptic_punch", semi_axes=[1]), "indenter.semi_axes.1: expected, but"),
    (shape("elliptic_punch", semi_axes=[1, 2, 3]), "indenter.semi_axes: expected a sh"),
    (shape("profile", r=3, f=[0, 1]), "indenter.r: expected a list, got 3"),
    (shape("profile", r=[0, 1], f=[0, 1, 2]), "r and f of the same length"),
    (shape("profile", r=[], f=[]), "at least 2, got 0, 0"),
    (shape("profile", r=[0, 2, 1], f=[0, 1, 2]), "r strictly increasing from 0"),
    (shape("profile", r=[0, 1], f=[1, 2]), "f = 0 at r = 0"),
    (shape("profile", r=[0, 1, 2], f=[0, 2, 1]), "hollow profiles have no reduced model (f decr"),
    (shape("polygon_punch", vertices=[[0, 0], [1, 0]]), "at least 3 vertices, got 2"),
    (rough(kind="fractal"), "surface.kind: expected one of self_affine, map, got 'fractal'"),
    (rough(kind=None), "surface.kind: expected one of self_affine, map, got nothing"),
    (rough(points=2), "surface.points.0: expected greater than or equal to 4, got 2"),
    (rough(points=64.5), "surface.points.0: expected a whole number, got 64.5"),
    (rough(points=2**21), "surface.points.0: expected less than or equal to 1048576"),
    (rough(hurst=3), "surface.hurst: expected less than or equal to 1, got 3"),
    (rough(power=4), "surface: expected exactly one of hurst and power"),
    (rough(rms_height="1 nm"), "surface: expected exactly one of rms_slope and rms_height"),
    (rough(rms_slope=None), "surface: expected exactly one of rms_slope and rms_height"),
    (rough(short_cutoff="31.2 nm"), "for which points = 65 are enough"),
    (rough(long_cutoff="2 um"), "long_cutoff: expected from short_cutoff"),
    (rough(periodic=1), "surface.periodic: expected true or false, got 1"),
    (measured(file=None), "surface.file: expected, but missing"),
    (measured(file=""), "surface.file: expected a non-empty text"),
    (measured(size=[1, 2, 3]), "surface.size: expected"),
    (measured(crop=[0, 0, 1, 8]), "surface.crop.2: expected greater than or equal to 2, got 1"),
    (measured(crop=[-1, 0, 8, 8]), "surface.crop.0: expected greater than or equal to 0, got -1"),
    (measured(detrend="wiggle"), "detrend: expected 'none', 'mean', 'tilt' or 'curvature'"),
    (measured(detrend="tilt", periodic=True), "'mean' (the default) or 'none' with periodic"),
    (measured(undefined="zero"), "undefined: expected 'interpolate', 'lowest' or 'refuse'"),
    (measured(hurst=0.8), "surface.hurst: unknown key; only self_affine has it"),
]


@pytest.mark.parametrize(("changes", "expected"), WRONG)
def test_what_is_wrong_is_named(changes, expected):
    assert expected in "\n".join(problems(**changes))


@pytest.mark.parametrize("nu", [0.6, -1, -1.5, math.nan, math.inf, True, "0.3", None, [0.3]])
def test_poisson_ratio_outside_its_range(nu):
    faults = problems(half_space={"youngs_modulus": 1e9, "poisson_ratio": nu})
    assert faults[0].startswith("half_space.poisson_ratio: expected a number with -1 < nu <= 0.5")


@pytest.mark.parametrize(
    "half_space",
    [
        {},
        {"youngs_modulus": 1e9},
        {"poisson_ratio": 0.3},
        {"youngs_modulus": 1e9, "shear_modulus": 1e9, "poisson_ratio": 0.3},
        {"effective_modulus": 1e9, "poisson_ratio": 0.3},
    ],
)
def test_elastic_constants_come_in_one_of_three_ways(half_space):
    (faults,) = problems(half_space=half_space)
    assert "youngs_modulus and poisson_ratio, or shear_modulus and poisson_ratio" in faults
    assert (", ".join(sorted(half_space)) or "nothing") in faults


def refusal(source) -> str:
    with pytest.raises(SceneError) as caught:
        load_scene(source)
    return str(caught.value)


def test_files_that_are_no_scene(tmp_path):
    text, binary, huge = (tmp_path / name for name in ("a.toml", "b.toml", "c.toml"))
    text.write_text("this is = = not TOML")
    binary.write_bytes(b"\x80\x81\xff\x00")
    huge.write_bytes(b"#" * 10_000_001)
    assert "not valid TOML" in refusal(text)
    assert "not a readable text file" in refusal(binary)
    assert "expected at most 10000000 bytes" in refusal(huge)
    assert "a folder, not a scene file" in refusal(tmp_path)
    assert refusal(tmp_path / "nothere.toml").endswith("  no such file")  # "sphere" is not near
    assert "see `roughline list scenes`" in refusal("no-such-scene")
    deep = tmp_path / "deep.toml"
    deep.write_text("x = " + "[" * 50_000)
    assert "not valid TOML" in refusal(deep)


def test_a_map_in_place_of_a_scene_is_told_where_it_belongs(tmp_path):
    for name, content in (("scan.npy", b"\x93NUMPY"), ("scan.csv", b"1;2\n3;4\n")):
        (tmp_path / name).write_bytes(content)
        said = f'a scene names its map of heights: [surface] kind = "map", file = "{name}"'
        assert said in refusal(tmp_path / name)


@pytest.mark.parametrize("kind", [FileError, InputError, LostWorkError, ResultsError, SceneError])
def test_workers_send_their_errors_home_by_pickle(kind):
    error = kind("map: with a colon", ["one", "two"]) if kind is SceneError else kind("map: 5 %")
    again = pickle.loads(pickle.dumps(error))
    assert (type(again), str(again)) == (kind, str(error))
    assert getattr(again, "problems", ()) == getattr(error, "problems", ())
    assert isinstance(InputError(""), ValueError)


TEXT = made().text


def test_overrides_are_validated_with_the_file():
    changes = {"methods.fem.contact": "penalty", "methods.fem.penalty": 10, "compare.methods": None}
    changes["compare.methods"] = ["fem", "reduced"]
    scene = parse_scene(TEXT, "x.toml", Path(), changes)
    assert scene.methods.fem.contact == "penalty"
    assert scene.methods.fem.penalty == 10
    assert scene.compare.methods == ("fem", "reduced")
    with pytest.raises(SceneError) as caught:
        parse_scene(TEXT, "x.toml", Path(), {"methods.fem.glue": 1, "compare.methods": ["mem"]})
    assert any("compare.methods.0: expected" in problem for problem in caught.value.problems)
    assert "methods.fem.glue: unknown key" in caught.value.problems


def test_an_override_below_something_that_is_no_table():
    with pytest.raises(SceneError) as caught:
        parse_scene("methods = 3\n" + TEXT, "x.toml", Path(), {"methods.fem.contact": "penalty"})
    assert caught.value.problems == ["methods: expected a table, got 3"]


def test_a_channel_is_named_by_its_name_or_number():
    assert MeasuredMap(kind="map", file="a.npy", channel=1).channel == "1"


@pytest.mark.parametrize(("key", "values"), [("seed", [1, 2]), ("periodic", [True, False])])
def test_a_sweep_goes_over_numbers_of_surfaces_and_switches(key, values):
    """A whole number is no 1.0, and a switch no 1: the scene that is validated anew is the same."""
    tables = {"name": "a", "half_space": {"effective_modulus": 1e9}, "surface": PATCH}
    tables |= {"loading": {"force": 1.0}, "sweep": {f"surface.{key}": values}}
    assert [getattr(scene.surface, key) for scene in load_scenes(tables)] == values


SWEEP = {"indenter.radius": ["1 mm", "2 mm"]}


def test_a_sweep_is_one_scene_for_each_value():
    """Each is a scene of its own: its text is read back, alone; other changes are in all."""
    tables = made().model_dump(exclude_none=True, exclude_defaults=True) | {"sweep": SWEEP}
    scenes = load_scenes(tables, {"compare.tolerance": 0.05})
    assert [scene.name for scene in scenes] == [f"{made().name}-1-mm", f"{made().name}-2-mm"]
    assert [scene.indenter.radius for scene in scenes] == [1e-3, 2e-3]
    assert [scene.compare.tolerance for scene in scenes] == [0.05, 0.05]
    assert "radius 2 mm" in scenes[1].heading
    assert parse_scene(scenes[1].text, "x.toml", Path.cwd()) == scenes[1]
    assert load_scenes(scenes[1]) == [scenes[1]]
    unquoted = tables | {"sweep": {"indenter": {"radius": SWEEP["indenter.radius"]}}}
    assert load_scenes(unquoted, {"compare.tolerance": 0.05}) == scenes
    with pytest.raises(SceneError, match="roughline run"):
        load_scene(tables)
    # one of them, changed in the key that was swept, is a scene like others
    other = load_scene(scenes[1], {"indenter.radius": "3 mm"})
    assert (other.indenter.radius, other.sweep) == (3e-3, {})
    with pytest.raises(SceneError, match="swept here, and set by an option"):
        load_scenes(tables, {"indenter.radius": "3 mm"})


@pytest.mark.parametrize(
    ("sweep", "expected"),
    [
        ({"indenter.radius": ["1 mm"]}, "one key with a list of 2 to 100 different values"),
        ({"indenter.radius": ["1 mm", "1 mm"]}, "one key with a list"),
        (SWEEP | {"compare.tolerance": [0.1, 0.2]}, "one key with a list"),
        ({"indenter.radius": [1e-3, "2 Pa"]}, "2 Pa:\n  indenter.radius: expected a unit of m"),
        ({"indenter.width": [1e-3, 2e-3]}, "indenter.width: unknown key"),
        ({"indenter.radius": "3 mm"}, "radius: expected a list of values, got '3 mm'"),
        ({"indenter": {"width": 1.0}}, "sweep.indenter.width: expected a list of values, got 1.0"),
        ({"name": ["a", "b"]}, "sweep.name: expected a key that changes the scene"),
    ],
)
def test_a_sweep_that_cannot_be_is_named(sweep, expected):
    tables = made().model_dump(exclude_none=True, exclude_defaults=True) | {"sweep": sweep}
    with pytest.raises(SceneError) as caught:
        load_scenes(tables)
    assert expected in str(caught.value)


@pytest.mark.parametrize("name", builtin_names())
def test_the_text_of_every_built_in_scene_is_the_same_scene(name):
    scene = load_scene(name)
    assert scene.name == name
    again = parse_scene(scene.text, name, Path(scene.directory))
    assert again == scene
    assert again.text == scene.text


@pytest.mark.parametrize(
    "title", ["\U0001f600", '"; [x]\n', "\\u0000", "\x7f\x00\x85\u2028", "'''"]
)
def test_hostile_titles_stay_titles(title):
    data = tomllib.loads(made(title=title).text)
    assert data["title"] == title
    assert set(data) == {"name", "title", "half_space", "indenter", "loading"}


@pytest.mark.parametrize(
    ("file", "told"), [("nowhere.npy", "no such file"), (".", "a folder, not a file")]
)
def test_a_missing_map_is_told_together_with_everything_else(tmp_path, file, told):
    text = 'name = "a"\n[half_space]\nyoungs_modulus = 1\npoisson_ratio = 0.9\n[surface]\n'
    text += 'kind = "map"\nfile = "FILE"\n[loading]\npenetration = -1\n'
    with pytest.raises(SceneError) as caught:
        parse_scene(text.replace("FILE", file), "x.toml", tmp_path)
    said = "\n".join(caught.value.problems)
    assert "half_space.poisson_ratio" in said
    assert "loading.penetration" in said
    assert f"surface.file: {file}: {told}" in said


def test_faces_are_equal_whatever_they_remember():
    """Two polygons with one outline, which both keep as an array."""
    first, second = (load_scene("triangle-punch").indenter for _ in range(2))
    np.testing.assert_array_equal(first.outline, second.outline)
    assert first == second
    assert hash(first) == hash(second)
