"""`roughline claims`: the table, the page, the files, the exit codes."""

import json
import re
from collections import Counter

import pytest

from comparisons.questions.claims.record import IN_A_RANGE, STORED, load_claims_record
from reports.pages.claims import claims_page
from reports.plots.claims import evidence
from reports.plots.interactive import spec
from roughline.commands.app import run_command

CLAIMS = """
quantity = "force"
true = { method = "closed_form" }
equation = "(5.13)"
text = "An ellipsoid is a ball of the Gaussian radius <script>alert(1)</script>."
[claims.wide]
scene = "ellipsoid-2"
vary = { path = "indenter.radius_x", from = 1, to = 20, steps = 6, spacing = "log", unit = "10 mm" }
tolerance = 0.01
[claims.narrow]
scene = "ellipsoid-5"
tolerance = 0.005
expected = "holds"
"""


@pytest.fixture(scope="module")
def judged(tmp_path_factory):
    """One claim that holds in a range, and one that does not hold as expected."""
    root = tmp_path_factory.mktemp("claims")
    (root / "own.toml").write_text(CLAIMS)
    words = ["claims", str(root / "own.toml"), "--full", "--workers", "1"]
    code = run_command([*words, "--out", str(root / "out"), "--json", str(root / "copy.json")])
    return code, root


def test_a_verdict_that_differs_from_the_expected_one_is_exit_code_1(judged):
    """At radii of 5:1 the force errs by -5.1 %: 0.5 % is not kept, as the file expects."""
    code, root = judged
    assert code == 1
    record = load_claims_record(root / "out")
    assert [claim.verdict for claim in record.claims] == [IN_A_RANGE, "fails"]
    assert [claim.differs for claim in record.claims] == [False, True]
    assert record == load_claims_record(root / "copy.json")


def test_the_page_shows_words_numbers_pictures_and_commands(judged):
    _, root = judged
    page = (root / "out" / "report.html").read_text(encoding="utf-8")
    record = load_claims_record(root / "out")
    for claim in record.claims:
        assert claim.command in page
        assert f'href="#claim-{claim.id}"' in page
    assert 'class="verdict outside">fails' in page
    assert 'class="verdict partly">holds in a range' in page
    assert "<script>alert" not in page
    # The small scales of the errors are drawn; their attributes are no text of the page.
    assert 'class="scale" data-beyond=' in page
    assert "--e:" not in re.sub(r"<[^>]*>", "", page)
    figure = json.loads(re.search(r'id="data-claim-wide-evidence">(.*?)</script>', page, re.S)[1])
    assert {trace["name"] for trace in figure["data"]} == {"within", "outside"}


def test_the_shaded_stretch_is_the_range_found_and_four_points_carry_it(judged):
    _, root = judged
    claim = load_claims_record(root / "out").claims[0]
    assert sum(point.word == "within" for point in claim.points) == 4
    fewer = claim.model_copy(update={"points": claim.points[1:]})
    assert not evidence(fewer).stretches
    shaded = spec(evidence(claim))["layout"]["shapes"][0]
    (stretch,) = claim.ranges
    # Values, although the axis is logarithmic: annotations alone take logarithms.
    assert claim.spacing == "log"
    assert [shaded["x0"], shaded["x1"]] == [stretch.low, stretch.high]


def test_disagreeing_references_stand_at_the_top(judged):
    _, root = judged
    record = load_claims_record(root / "out")
    text = "FEM and closed form differ in force by 2 %"
    odd = record.claims[0].model_copy(update={"disagreements": [text]})
    page = claims_page(record.model_copy(update={"claims": [odd]}))
    assert page.index("References disagree") < page.index(text) < page.index('<h2 id="verdicts"')


@pytest.mark.slow
def test_many_claims_are_folded_by_whose_they_are_and_few_are_not(judged):
    """The page of all claims was 130 000 pixels long on a phone."""
    few = load_claims_record(judged[1] / "out")
    assert 'class="group"' not in claims_page(few)
    every = load_claims_record(STORED)
    page = claims_page(every)
    voices = Counter(claim.voice for claim in every.claims)
    heads = re.findall(r'<h2 id="group-\d-title">(.*?): (\d+) claims?</h2>', page)
    assert {title.lower(): int(count) for title, count in heads} == dict(voices)
    counted = re.search(r'</h2> <span class="tally">(.*?)</summary>', page, re.S)[1]
    first = heads[0][0].lower()
    verdicts = Counter(claim.verdict for claim in every.claims if claim.voice == first)
    assert dict(re.findall(r">(\d+) ([a-z ]+)<", counted)) == {
        str(count): word for word, count in verdicts.items()
    }
    for claim in every.claims:
        assert page.count(f'<section class="scene" id="claim-{claim.id}"') == 1


def test_the_report_can_be_written_anew(judged, capsys):
    _, root = judged
    report = root / "out" / "report.html"
    before = report.read_text(encoding="utf-8")
    report.unlink()
    assert run_command(["report", str(root / "out")]) == 0
    assert report.read_text(encoding="utf-8") == before
    assert "report.html" in capsys.readouterr().out
