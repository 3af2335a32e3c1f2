"""The first screen: it judges anew as Python does, stays short, and leads to the evidence."""

from dataclasses import astuple, replace
from functools import partial

import numpy as np
import pytest

from comparisons.judging.truth import CLINGS
from comparisons.judging.verdicts import NAN, NO_RESULT, OUTSIDE, word_for, worst
from comparisons.reasons import STEEP
from comparisons.results.advice import advise
from comparisons.results.finding import finding
from comparisons.results.recording import explained
from comparisons.results.rows import Rows
from reports.pages.study import write_report

pytestmark = pytest.mark.slow

TOLERANCES = (1e-4, 0.02, 0.5)


def rows_of(page):
    """Return verdict, deciding text and cheapest settings of each scene in the summary."""
    cells = ("verdict", "largest error", "cheapest")
    rows = page.locator("#summary-table tbody tr").all()
    return [
        [row.locator(f"td[data-label='{cell}']").text_content().strip() for cell in cells]
        for row in rows
    ]


def asked_anew(study, tolerance, counted=None):
    for scene in study.scenes:
        names = tuple(n for n in scene.quantities if counted is None or n in counted)
        limit = tolerance or scene.tolerance
        judged = tuple(
            verdict
            if verdict.word in (NO_RESULT, OUTSIDE) and np.isnan(verdict.low)
            else replace(verdict, tolerance=limit, word=word_for(verdict.low, verdict.high, limit))
            for verdict in scene.verdicts
        )
        yield replace(scene, tolerance=limit, quantities=names, verdicts=judged)


def found(page):
    rows = page.locator("table.finding tbody tr").all()
    return [tuple(row.locator("th, td").all_text_contents()) for row in rows]


def expected(study, tolerance, counted=None):
    rows = []
    for asked in asked_anew(study, tolerance, counted):
        decisive, advice = worst(asked.verdicts_on()), advise(asked)
        best = ", ".join(setting.brief for setting in advice.reaching()[:2])
        rows.append((decisive.word, decisive.quantity, best or "no setting within tolerance"))
    return rows


@pytest.mark.parametrize("tolerance", TOLERANCES)
def test_another_tolerance_is_judged_as_python_judges_it(followed, study, tolerance):
    """Verdict, deciding quantity, cheapest settings, finding: one rule, in both languages."""
    page = followed(f"#?tolerance={tolerance:g}".replace("e-05", "e-5")).page
    for row, (word, quantity, best) in zip(rows_of(page), expected(study, tolerance), strict=True):
        assert row[0].startswith(word)
        assert row[1].startswith(quantity.replace("_", " "))
        assert row[2] == best
    said = finding(list(asked_anew(study, tolerance)))
    assert found(page) == [astuple(row) for row in said]
    headings = page.locator("section.scene summary > .verdict:first-of-type").all_text_contents()
    assert headings == [word for word, *_ in expected(study, tolerance)]


def test_solvers_have_rows_of_their_own_on_demand(followed, study):
    """Hidden at first, so that the first screen stays short; judged anew like the model's."""
    page = followed("#").page
    rows = page.locator("#verdict-table tr.solver")
    assert rows.count() > 0
    assert not any(row.is_visible() for row in rows.all())
    page.locator("[name=solvers]").check()
    assert all(row.is_visible() for row in rows.all())
    elements = page.locator("#verdict-table tr.solver", has_text="FEM").first
    words = [
        followed(f"#?solvers=shown&tolerance={tolerance}")
        and elements.locator(".word").all_text_contents()
        for tolerance in ("0.00001", "0.5")
    ]
    assert "outside" in words[0]
    assert set(words[1]) == {"within"}


def slow_lines(scene):
    table = scene.rows.frame()
    lines = table["method"] == "reduced"
    times = {name: table[name].where(~lines, 3600.0) for name in ("seconds", "seconds_all")}
    return replace(scene, rows=Rows.of(table.assign(**times)))


def lucky_lines(scene):
    return replace(scene, reference=replace(scene.reference, chance="3 contacts, fewer than 30"))


def steep_surfaces(scene):
    return replace(scene, plan=replace(scene.plan, notes=(f"{STEEP}: h' = 3",)))


def clinging_lines(scene):
    out = {"word": OUTSIDE, "low": NAN, "high": NAN, "reason": CLINGS}
    lines = (replace(v, **out) if v.method == "reduced" else v for v in scene.verdicts)
    return replace(scene, verdicts=tuple(lines))


def unjudged_gap(scene):
    asked = replace(scene, quantities=(*scene.quantities, "mean_gap"))
    return replace(asked, verdicts=explained(asked))


@pytest.mark.parametrize(
    ("changed", "said"),
    [
        (slow_lines, "no need"),
        (lucky_lines, "not known"),
        (steep_surfaces, "for small slopes only"),
        (clinging_lines, CLINGS),
        (unjudged_gap, "for d, A only"),
    ],
)
def test_lines_are_recommended_only_where_they_cost_less_and_are_known_to_hold(
    visit, study, tmp_path, changed, said
):
    """At 50 % the lines of the rough ensemble are within; both languages say what that is worth."""
    rough = study.scenes[-1]
    alone = study.model_copy(update={"scenes": (study.scenes[0], changed(rough))})
    write_report(alone, tmp_path / "report.html", pictures=False)
    there = partial(visit.func, visit.args[0], tmp_path / "report.html")
    with there(fragment="#?tolerance=0.5") as seen:
        rows = [astuple(row) for row in finding(list(asked_anew(alone, 0.5)))]
        assert found(seen.page) == rows
        assert sum(said in " ".join(row) for row in rows) == 1


def test_without_the_worst_quantity_a_scene_is_judged_by_the_rest(followed, study):
    page = followed().page
    before = rows_of(page)
    page.locator("input[name=counts][value=contact_area]").uncheck()
    shown = expected(study, None, {"force", "penetration"})
    after = rows_of(page)
    assert [row[0].split()[0] for row in after] == [word.split()[0] for word, _, _ in shown]
    assert after != before
    said = finding(list(asked_anew(study, None, {"force", "penetration"})))
    assert found(page) == [astuple(row) for row in said]
    page.locator(".as-asked").click()
    assert rows_of(page) == before


def test_a_cell_leads_to_its_evidence(followed):
    """A click opens the folded scene at the row that explains the verdict."""
    page = followed().page
    assert not page.locator("#scene-2 .plan").is_visible()
    page.locator("#verdict-table tr[data-scene=scene-2] td.cell a").first.click()
    why = page.locator("#scene-2-why-table tr:target")
    place = why.bounding_box()
    assert 0 < place["y"] < 400
    assert "|e|" in why.inner_text()
