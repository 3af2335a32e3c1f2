"""The report of the real quick suite, as `.ci/run` makes it (or made here, which takes minutes)."""

import os
import subprocess
import sys
from pathlib import Path

import pytest

pytestmark = pytest.mark.slow
DESKTOP, PHONE = (1280, 800), (390, 844)
LARGEST = 15e6  # bytes: what still passes as the attachment of a letter


@pytest.fixture(scope="module")
def report(tmp_path_factory) -> Path:
    """Return the report of the folder that ROUGHLINE_QUICK names, or of a run made now."""
    made = os.environ.get("ROUGHLINE_QUICK")
    if made:
        return (Path(made) / "report.html").resolve()
    folder = tmp_path_factory.mktemp("quick") / "quick"
    command = [sys.executable, "-m", "roughline", "run", "--out", str(folder)]
    subprocess.run(command, check=True, timeout=1800)
    return folder / "report.html"


def test_the_report_is_light_enough_to_send(report):
    assert 5e6 < report.stat().st_size < LARGEST


def test_the_page_is_short_and_the_finding_and_the_heat_map_stand_on_the_first_screen(visit):
    """At most 6000 pixels and 300 stops of the Tab key, before a reader asks for more.

    All scenes of the suite are below the table of findings; nothing is cut off sideways.
    """
    with visit(size=DESKTOP) as seen:
        page = seen.page
        assert page.evaluate("document.documentElement.scrollHeight") <= 6000
        assert seen.tab_stops() <= 300
        # It answers before the plots' data and library, most of the file, have been read.
        program = "performance.getEntriesByName('interactive')[0].startTime"
        assert page.evaluate(
            f"{program} < performance.timing.domInteractive - performance.timing.navigationStart"
        )
        for width, height in ((1440, 1000), DESKTOP):
            page.set_viewport_size({"width": width, "height": height})
            rows = page.locator("#verdict-table tr[data-scene]:not(.solver)")
            assert rows.count() >= 16
            last = rows.last.bounding_box()
            assert last["y"] + last["height"] <= 1000
            table, box = page.locator("#verdict-table"), page.locator(".map .scroll")
            assert table.bounding_box()["width"] <= box.bounding_box()["width"] + 1
            heading = page.get_by_role("heading", name="Summary", exact=True).bounding_box()
            search = page.locator("#summary > .table-tools label").bounding_box()
            assert search["y"] >= heading["y"] + heading["height"]
        scenes = page.locator("section.scene").all()
        assert all(scene.locator(".load-slider").count() for scene in scenes)
        # No picture where no renderer works; views need none.
        assert page.locator("[data-turn]").count() >= len(scenes) - 1


def test_the_finding_is_read_on_a_phone(visit):
    """The sentence stands on the first screen, nothing sticks out sideways."""
    with visit(size=PHONE) as seen:
        page = seen.page
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
        place = page.locator(".finding").bounding_box()
        assert place["y"] + place["height"] <= PHONE[1]


@pytest.mark.parametrize("every", [pytest.param(1, marks=pytest.mark.nightly), 5])
def test_all_is_drawn_without_request_complaint_or_fault(visit, serious_faults, every):
    """Every fifth scene: a ball, an edge, a square, a measured map."""
    with visit() as seen:
        page = seen.page
        page.locator("section.scene").evaluate_all(
            "(all, every) => all.forEach((one, place) => { if (place % every) one.remove(); })",
            every,
        )
        page.locator("details").evaluate_all("all => all.forEach(one => { one.open = true; })")
        # Before plots are drawn: their insides are left out, and make each search long.
        assert serious_faults(page) == []
        assert serious_faults(page, dark=True) == []
        seen.draw_all()
        canvases = page.locator("[data-figure]:not([data-turn])")
        assert canvases.count() > 200 / every
        assert page.locator("[data-figure] .main-svg").count() >= canvases.count()
        assert seen.requests == []
        assert seen.complaints == []
