"""The page of all claims: short until a link, a filter or the printer opens what is folded."""

from pathlib import Path

import pytest

from comparisons.questions.claims.record import STORED, load_claims_record
from reports.pages.claims import claims_page

PHONE = (390, 844)


@pytest.fixture(scope="module")
def report(tmp_path_factory) -> Path:
    path = tmp_path_factory.mktemp("claims") / "report.html"
    path.write_text(claims_page(load_claims_record(STORED)), encoding="utf-8")
    return path


@pytest.mark.slow
def test_what_is_folded_is_reached_by_link_filter_and_printer(visit):
    """Three screens of a phone; it was 130 000 pixels long."""
    with visit(size=PHONE) as seen:
        page = seen.page
        table, claim = page.locator("#verdict-table"), page.locator("#claim-punch-triangle")
        assert page.evaluate("document.documentElement.scrollHeight") < 3 * PHONE[1]
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
        page.evaluate("dispatchEvent(new Event('beforeprint'))")
        assert table.is_visible()
        page.evaluate("dispatchEvent(new Event('afterprint'))")
        assert not table.is_visible()
        seen.follow("claim-punch-triangle")
        assert claim.locator(".lead").is_visible()
        seen.follow("verdicts?filter.verdict-table=punch-triangle")
        assert table.locator("tbody tr:visible").count() == 2  # stiffness and area
        assert seen.complaints == []
