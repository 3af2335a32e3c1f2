"""Claim files: all that is wrong at once, what is right reaches the scene, verdicts grow old."""

from pathlib import Path

import pytest

from comparisons.errors import ProblemsError
from comparisons.files import read_toml
from comparisons.methods.peers import live
from comparisons.questions.claims import runner as subject
from comparisons.questions.claims.claim import load_claims, make_claim, scene_of
from comparisons.questions.claims.families import HERE, SHARED, read_family
from comparisons.questions.claims.record import STORED, load_claims_record
from comparisons.questions.claims.runner import digest_of, imported, stale
from comparisons.questions.experiments import EXPERIMENTS, Experiment
from roughline.commands.app import run_command

RIGHT = {
    "id": "wide-ellipsoid",
    "text": "An ellipsoid is a sphere of the Gaussian radius.",
    "equation": "19.3",
    "scene": "ellipsoid-2",
    "vary": {"path": "indenter.radius_x", "from": 1, "to": 8, "steps": 4, "unit": "10 mm"},
    "quantity": "force",
    "tolerance": 0.01,
    "refuted_by": "An error beyond 1 %.",
}
FAMILY = """
scene = "ellipsoid-2"
quantity = "force"
equation = "19.3"
[baselines.wide]
changes = { "half_space.poisson_ratio" = 0.3 }
refuted_by = "A force off by {tolerance}."
[nuisances.radius]
path = "indenter.radius_x"
name = "radius"
stated = 2
from = 1
to = 9
unit = "10 mm"
reason = "Any."
[claims.flat]
like = "wide"
text = "Within {tolerance}."
changes = { "indenter.radius_y" = "20 mm" }
tolerance = [0.05, 0.1]
expected = ["fails", "holds"]
[claims.deep]
text = "It holds."
tolerance = 0.01
changes = { "half_space.poisson_ratio" = 0.4 }
nuisance = [{ like = "radius", stated = 3 }]
"""


def problems(**changes):
    data = {key: value for key, value in (RIGHT | changes).items() if value is not None}
    with pytest.raises(ProblemsError) as caught:
        make_claim(data, "a.toml", Path())
    return caught.value.problems


def test_a_misspelt_place_of_a_claim_is_told():
    assert problems(nearest={"alon": "n"}) == [
        "a.toml: nearest.alon: unknown key; did you mean along?"
    ]


def test_every_built_in_claim_is_valid_and_no_name_or_nuisance_stands_twice():
    assert len(load_claims()) == sum(len(read_family(path)) for path in HERE.glob("*.toml"))
    shared = read_toml(SHARED)["nuisances"].keys()
    for path in set(HERE.glob("*.toml")) - {SHARED}:
        assert not shared & read_toml(path).get("nuisances", {}).keys()


def test_a_file_says_once_what_its_claims_share(tmp_path):
    """Keys of the file, of a baseline and of the claim in this order; a verdict per tolerance."""
    file = tmp_path / "family.toml"
    file.write_text(FAMILY)
    five, ten, other = load_claims((str(file),))
    assert (five.id, ten.id, other.id) == ("flat-5", "flat-10", "deep")
    assert (five.text, five.refuted_by) == ("Within 5 %.", "A force off by 5 %.")
    assert (five.tolerance, five.expected, ten.expected) == (0.05, "fails", "holds")
    assert five.changes == {"half_space.poisson_ratio": 0.3, "indenter.radius_y": "20 mm"}
    assert other.changes == {"half_space.poisson_ratio": 0.4}
    assert (other.refuted_by, five.nuisance) == ("An error beyond 1\u202f%.", ())
    (scale,) = other.nuisance
    assert (scale.stated, scale.end, scale.reason) == (3, 9, "Any.")


@pytest.mark.parametrize(
    ("change", "fault"),
    [
        (('like = "wide"', 'like = "wild"'), "flat: expected one of wide, got 'wild'"),
        (('like = "radius"', 'like = "r"'), "deep: nuisance: expected one of hurst, "),
        (("[0.05, 0.1]", "[0.05]"), "expected numbers as tolerances, and a verdict for each"),
        (("[claims.deep]", "[[claims.deep]]"), "claims: expected tables [claims.NAME]"),
        ((FAMILY, 'id = "old"\ntext = "x"'), "expected a table [claims.ID] for each claim"),
    ],
)
def test_tables_that_do_not_go_together_are_refused(tmp_path, change, fault):
    file = tmp_path / "family.toml"
    file.write_text(FAMILY.replace(*change))
    with pytest.raises(ProblemsError) as caught:
        load_claims((str(file),))
    assert fault in str(caught.value)


def test_all_problems_of_a_file_are_listed_at_once():
    faults = problems(
        id="A b",
        equation=None,
        tolerance=-1,
        quantity="forc",
        experiment="far-field",
        colour=1,
        vary={"path": "indenter.radius_x", "from": 2, "to": 1, "steps": 1},
    )
    text = "\n".join(faults)
    for part in ("id:", "equation:", "tolerance:", "quantity:", "colour: unknown key"):
        assert part in text
    assert "vary.steps" in text
    assert "exactly one of scene and experiment, got scene and experiment" in text


LAW = {"scene": None, "experiment": "no-such"}
SEVENTH = {"path": "indenter.vertices.7.0", "from": 1, "to": 2, "steps": 2}
IN_TIME = {
    "scene": "impact-ball",
    "quantity": "contact_duration",
    "at": "force",
    "vary": {"path": "dynamics.mass", "from": 1, "to": 8, "steps": 4, "unit": "1 g"},
}
NUMBER = {"number": 3.5, "unit": "kN", "source": "a book"}


@pytest.mark.parametrize(
    ("changes", "fault"),
    [
        ({"true": {"number": 3.5, "unit": "kN"}}, "true: expected a number other than zero, and"),
        ({"true": NUMBER | {"number": 0}}, "true: expected a number other than zero, and"),
        ({"true": {"unit": "kN"}}, "true: expected a number beside unit, uncertainty and source"),
        ({"true": NUMBER | {"scene": "cone"}}, "true: expected either a number or a scene"),
        ({"true": NUMBER | {"unit": "mm"}}, "expected a unit of the quantity"),
        ({"true": {"scene": "no-such"}}, "scene: no-such"),
        ({"true": {"changes": {"compare.methods": []}}}, "the claim's own key `method` sets it"),
        ({"true": {"colour": 1}}, "true.colour: unknown key"),
        ({"stated": {"method": "fem"}}, "stated.method: expected none"),
        ({"true": NUMBER, "at": "force"}, "at: expected nothing where the sides are apart"),
        ({"true": NUMBER, "scene": None}, "expected exactly one of scene and experiment, got none"),
        (
            {"true": NUMBER, "scene": None, "experiment": "far-field", "vary": None},
            "true: only with a scene",
        ),
        ({"vary": RIGHT["vary"] | {"from": 9}}, "expected from < to"),
        # a wrong claim, not a failed measurement
        ({"vary": RIGHT["vary"] | {"from": -1}}, "indenter.radius_x: expected a positive finite"),
        # a list index beyond the end would be varied without any effect
        ({"scene": "triangle-punch", "vary": SEVENTH}, "changes nothing"),
        (IN_TIME, "at: expected nothing, steps of this scene are no loads to interpolate at"),
        # the runner chose the references itself, and `compare.methods` was lost without a word
        ({"changes": {"compare.methods": ["closed_form"]}, "vary": None}, "compare.methods: "),
        ({"changes": {"compare.tolerance": 0.1}, "vary": None}, "compare.tolerance: "),
        (LAW | {"changes": {"a": 1}}, "changes: only with a scene"),
        (LAW, "no-such"),
        ({"scene": None, "experiment": {"name": "kernel"}}, "experiment: expected a text"),
        ({"vary": {"from": 1, "to": 2, "steps": 2}}, "vary.path"),
        ({"quantity": None}, "quantity"),
        ({"parameters": {"a": 1}}, "parameters: only with an experiment"),
    ],
)
def test_what_is_wrong_with_a_claim_is_told_with_its_key(changes, fault):
    assert fault in "\n".join(problems(**changes))


def test_missing_files_and_files_that_are_not_toml_are_told_together(tmp_path):
    broken = tmp_path / "broken.toml"
    broken.write_text("id = ")
    with pytest.raises(ProblemsError) as caught:
        load_claims((str(broken), "no-such-claim"))
    assert len(caught.value.problems) == 2


def test_the_parameter_stands_in_the_scene_with_its_unit():
    claim = make_claim(RIGHT, "a.toml", Path())
    scene = scene_of(claim, claim.sides(3.0)[0])
    assert scene.indenter.radius_x == 0.03
    assert scene.compare.quantities == ("force",)
    assert scene.compare.tolerance == claim.tolerance
    corner = {"path": "indenter.vertices.2.1", "from": 1, "to": 3, "steps": 2, "unit": "1 mm"}
    claim = make_claim(RIGHT | {"scene": "triangle-punch", "vary": corner}, "a.toml", Path())
    assert scene_of(claim, claim.sides(2.0)[0]).indenter.vertices[2] == (0.001, 0.002)


def test_a_list_that_claims_share_is_not_changed_by_what_varies_in_it(tmp_path):
    """A load of one claim was that of all others of its baseline."""
    file = tmp_path / "family.toml"
    file.write_text(
        """
scene = "ellipsoid-2"
quantity = "force"
equation = "19.3"
text = "It holds."
tolerance = 0.01
changes = { "loading.penetration" = ["2 um"] }
[claims.deeper]
vary = { path = "loading.penetration.0", from = 1, to = 9, steps = 2, unit = "1 um" }
[claims.same]
"""
    )
    for claim in load_claims((str(file),)):
        assert claim.changes == {"loading.penetration": ["2 um"]}


def test_an_experiment_names_its_own_parameter(monkeypatch):
    nothing = Experiment("nothing", "Nothing.", "x/y", run=None)
    monkeypatch.setitem(EXPERIMENTS, "nothing", nothing)
    data = {k: RIGHT[k] for k in ("id", "text", "equation", "tolerance", "refuted_by")}
    claim = make_claim(
        data | {"experiment": "nothing", "vary": {"from": 0, "to": 1, "steps": 2}}, "a.toml", Path()
    )
    assert claim.parameter == "x/y"


IDS = ("kernel-printed", "punch-square")


@pytest.fixture
def stored(monkeypatch):
    """Return the two claims, with a stored record of this very code."""
    claims = load_claims(IDS)
    digests = {claim.id: digest_of(claim) for claim in claims}
    record = load_claims_record(STORED)
    told = [r.model_copy(update={"digest": digests.get(r.id, "")}) for r in record.claims]
    record = record.model_copy(update={"claims": told})
    monkeypatch.setattr(subject, "load_claims_record", lambda path: record)
    return claims


def test_a_verdict_hangs_on_the_code_of_its_method_where_that_is_not_installed_too(monkeypatch):
    """Else verdicts of LAMMPS would be old wherever it is missing."""
    starts = []
    monkeypatch.setattr(subject, "imported", lambda names: starts.extend(names) or set())
    monkeypatch.setattr(live, "versions_in", lambda python, names: dict.fromkeys(names, ""))
    digest_of(*load_claims(("lammps-jkr-pull-off",)))
    assert live.__name__ in starts


def test_a_verdict_hangs_on_the_data_and_the_scenes_that_its_experiment_reads():
    experiments = "comparisons.questions.experiments"
    read = {
        path.name
        for name in ("rough_contact", "finite_elements", "yielding")
        for path in subject._code(f"{experiments}.{name}")[2]
    }
    assert read == {"readings.toml", "rough-patch.toml", "plastic-rough.toml"}


@pytest.mark.slow
def test_a_verdict_is_old_when_its_keys_or_its_code_have_changed(stored, monkeypatch):
    kernel, _ = stored
    assert stale(stored) == []
    assert stale([kernel.model_copy(update={"text": "In other words."})]) == []
    assert stale([kernel.model_copy(update={"tolerance": 0.3})]) == ["kernel-printed"]
    code = subject._code
    changed = "reference.halfspace.kernels"
    monkeypatch.setattr(
        subject, "_code", lambda module: ("new", (), ()) if module == changed else code(module)
    )
    assert changed in imported(["comparisons.questions.experiments.boundary_elements"])
    assert stale(stored) == ["kernel-printed", "punch-square"]


def test_comments_and_docstrings_make_nothing_older(monkeypatch, tmp_path):
    def digest(text):
        (tmp_path / "reduced").mkdir(exist_ok=True)
        (tmp_path / "reduced" / "made_up.py").write_text(text)
        monkeypatch.setattr(subject, "_HOME", tmp_path)
        return subject._code.__wrapped__("reduced.made_up")[0]

    first = digest('"""One."""\ndef f():\n    """Two."""\n    return 1\n')
    assert digest("def f():\n    return 1  # three\n") == first
    assert digest("def f():\n    return 2\n") != first


@pytest.mark.slow
def test_the_command_lists_what_is_old(stored, capsys):
    assert run_command(["claims", *IDS, "--stale"]) == 0
    assert "No stored verdict is older" in capsys.readouterr().out
    assert run_command(["claims", *IDS, "punch-l", "--stale"]) == 1
    assert capsys.readouterr().out == "punch-l\n"


def test_the_page_of_stored_verdicts_is_written_without_a_run(tmp_path, monkeypatch):
    """Of the claims that are named, and no other."""
    monkeypatch.chdir(tmp_path)
    assert run_command(["claims", "kernel-printed", "--stored"]) == 0
    page = (tmp_path / "roughline-results/claims-stored/report.html").read_text(encoding="utf-8")
    assert 'id="claim-kernel-printed"' in page
    assert 'id="claim-punch-square"' not in page
