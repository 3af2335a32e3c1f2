"""The report of the real quick suite, as `.ci/run` makes it (or made here, which takes minutes)."""

from __future__ import annotations

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
    command = [sys.executable, "-m", "reports", "run", "--out", str(folder)]
    subprocess.run(command, check=True, timeout=1800)
    return folder / "report.html"


def test_the_report_is_light_enough_to_send(report):
    assert 5e6 < report.stat().st_size < LARGEST


def test_the_whole_summary_stands_on_the_first_screen(visit):
    """All scenes of the suite at 1280 x 800; nothing is cut off sideways."""
    with visit(size=DESKTOP) as seen:
        rows = seen.page.locator("#summary-table tbody tr")
        assert rows.count() >= 16
        last = rows.last.bounding_box()
        assert last["y"] + last["height"] <= DESKTOP[1]
        table, box = seen.page.locator("#summary-table"), seen.page.locator("#summary .scroll")
        assert table.bounding_box()["width"] <= box.bounding_box()["width"] + 1


def test_the_summary_is_read_on_a_phone(visit):
    """Word, error and cheapest method of the first five scenes, without scrolling."""
    with visit(size=PHONE) as seen:
        page = seen.page
        assert page.evaluate("document.documentElement.scrollWidth") <= PHONE[0]
        for row in page.locator("#summary-table tbody tr").all()[:5]:
            place = row.bounding_box()
            assert place["y"] + place["height"] <= PHONE[1]
            for cell in ("verdict", "largest error", "cheapest"):
                assert row.locator(f"td[data-label='{cell}']").is_visible()


def test_all_is_drawn_without_request_complaint_or_fault(visit, serious_faults, faults_in_the_dark):
    with visit() as seen:
        page = seen.page
        # Before plots are drawn: their insides are left out, and make each search long.
        assert serious_faults(page) == []
        assert faults_in_the_dark(page) == []
        seen.draw_all()
        canvases = page.locator("[data-figure]:not([data-turn])")
        assert canvases.count() > 100
        assert page.locator("[data-figure] .main-svg").count() >= canvases.count()
        assert seen.requests == []
        assert seen.complaints == []


def test_every_scene_of_normal_loads_has_a_slider_and_a_view(visit):
    with visit() as seen:
        page = seen.page
        scenes = page.locator("section.scene").all()
        assert all(scene.locator(".load-slider").count() for scene in scenes)
        # No picture where no renderer works; views need none.
        assert page.locator("[data-turn]").count() >= len(scenes) - 1


def test_each_state_of_a_scene_is_a_link(visit):
    state = "#scene-1-pressure?load.scene-1=1&sort.summary-table=2d&filter.summary-table=punch"
    with visit(fragment=state) as seen:
        page = seen.page
        shown = page.locator("#summary-table tbody tr:visible")
        assert 2 <= shown.count() < 10
        cells = shown.locator("td[data-label='largest error']")
        errors = cells.evaluate_all("all => all.map(each => Number(each.dataset.key))")
        assert errors == sorted(errors, reverse=True)
        slider = page.locator("#scene-1 .load-slider input").first
        assert slider.input_value() == "1"
