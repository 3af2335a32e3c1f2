"""The report in a real browser: read, filtered, sorted, slid, saved, linked, heard and printed."""

import csv
import io
import re
import struct
import xml.etree.ElementTree as ElementTree

import pytest

DESKTOP, PHONE = (1280, 800), (390, 844)


def box_of(page, selector):
    return page.locator(selector).first.bounding_box()


def stands_on_the_first_screen(page, size):
    """Assert that finding, counts of verdicts and first cells are seen without scrolling."""
    for selector in ("h1", ".finding", ".tally .verdict", "#verdict-table td.cell"):
        place = box_of(page, selector)
        assert place["y"] + place["height"] < size[1], selector
        assert place["x"] >= 0, selector
        assert place["x"] + place["width"] <= size[0] + 1, selector


@pytest.mark.slow
def test_a_newcomer_sees_the_summary_and_a_short_page(visit):
    """Two scenes: few tab stops, few pixels, and nothing of a folded scene is drawn."""
    with visit() as seen:
        page = seen.page
        stands_on_the_first_screen(page, DESKTOP)
        # Disagreements of references come first of all.
        assert box_of(page, "#disagreements")["y"] < box_of(page, "#summary-title")["y"]
        # Verdicts are words, and colours beside.
        badge = page.locator("#summary-table .verdict").first
        assert badge.inner_text() in {"within", "outside", "not resolved"}
        colour = badge.evaluate("e => getComputedStyle(e).backgroundColor")
        assert colour != "rgba(0, 0, 0, 0)"
        assert page.evaluate("document.documentElement.scrollHeight") < 3000
        assert seen.tab_stops() < 80
        assert page.locator(".main-svg").count() <= 3  # layers of one plot
        page.keyboard.press("Tab")
        assert page.evaluate("document.activeElement.textContent") == "Skip to the content"


@pytest.mark.parametrize(
    "fault",
    [
        "delete window.DecompressionStream",
        "window.atob = () => 'not compressed'",
        "document.addEventListener('DOMContentLoaded', () => {"
        " for (const data of document.querySelectorAll('[id^=data-]')) data.remove(); })",
        "Object.defineProperty(window, 'Plotly', { get: () => undefined, set: () => {} })",
    ],
)
def test_a_browser_that_cannot_unpack_the_plots_says_so(browser, report, fault):
    """It offers nothing that needs them, and all else works: tables, choices, the printer."""
    context = browser.new_context()
    page = context.new_page()
    complaints = []
    page.on("console", lambda part: complaints.append(part.text))
    page.on("pageerror", lambda error: complaints.append(str(error)))
    page.add_init_script(fault)
    page.goto(f"{report.as_uri()}#scene-1?load.scene-1=0")
    assert page.locator("#main > .alert").first.inner_text().startswith("The plots need a newer")
    page.evaluate("dispatchEvent(new Event('beforeprint'))")
    page.evaluate("dispatchEvent(new Event('afterprint'))")
    page.emulate_media(color_scheme="dark")
    assert page.locator("#scene-1-settings").is_visible()
    assert page.locator(".main-svg, .figure-tools").count() == 0
    assert complaints == []
    context.close()


def test_a_page_is_complete_when_its_plots_can_be_drawn(browser, report):
    """`chromium --headless --print-to-pdf` prints at that moment; Safari 16.4 draws, too."""
    page = browser.new_page()
    faults = []
    page.on("pageerror", lambda error: faults.append(str(error)))
    page.add_init_script("delete Element.prototype.checkVisibility")
    page.add_init_script(
        "addEventListener('load', () => {"
        " dispatchEvent(new Event('beforeprint'));"
        " window.plots = document.querySelectorAll('.main-svg').length; })"
    )
    page.goto(report.as_uri())
    assert page.evaluate("window.plots") > 0
    assert faults == []
    page.close()


def test_the_summary_stands_on_the_first_screen_of_a_phone(followed):
    page = followed().page
    page.set_viewport_size({"width": PHONE[0], "height": PHONE[1]})
    stands_on_the_first_screen(page, PHONE)
    # Titles whole, so that no two look alike; nothing of the summary is cut off at the side.
    assert page.locator("#summary-table").evaluate(
        "table => [table, ...table.querySelectorAll('th, td')]"
        ".every(part => part.scrollWidth <= part.clientWidth + 1)"
    )
    page.set_viewport_size({"width": DESKTOP[0], "height": DESKTOP[1]})


def column(page, table, number):
    cells = page.locator(f"#{table} tbody tr:visible").all()
    return [row.locator("td, th").nth(number).inner_text().strip() for row in cells]


@pytest.mark.slow
def test_tables_are_filtered_and_sorted_and_the_link_keeps_it(followed, visit):
    """State round trip: what one reader chose, another who comes anew sees through the address."""
    table = "scene-1-settings"
    seen = followed("#scene-1")
    page = seen.page
    tools = page.locator(".table-tools", has=page.get_by_label("Filter rows: Cost and errors"))
    box = tools.first.locator("input")
    box.fill("bem")
    assert set(column(page, table, 0)) == {"dense BEM", "FFT BEM"}
    assert tools.first.locator(".count").inner_text() == "6 of 13 rows"
    page.locator(f"#{table} thead button", has_text="N").first.click()
    levels = [int(text) for text in column(page, table, 1)]
    assert levels == sorted(levels)
    page.locator(f"#{table} thead button", has_text="N").first.click()
    levels = [int(text) for text in column(page, table, 1)]
    assert levels == sorted(levels, reverse=True)
    fragment = page.evaluate("location.hash")
    before = column(page, table, 0), column(page, table, 1)
    with visit(fragment=f"{fragment}&load.scene-1=1") as seen:
        page = seen.page
        assert (column(page, table, 0), column(page, table, 1)) == before
        assert page.locator("#scene-1 .load-slider input").first.input_value() == "1"
        head = page.locator(f"#{table} th[aria-sort]")
        assert head.get_attribute("aria-sort") == "descending"
        # The link leads to the scene that it was made in.
        assert abs(box_of(page, "#scene-1")["y"]) < 60


def test_scene_and_quantity_are_chosen_and_linked(followed):
    page = followed().page
    page.locator("select[name=scene]").select_option("scene-2")
    page.locator("select[name=quantity]").select_option("contact_area")
    assert not page.locator("#scene-1").is_visible()
    fragment = page.evaluate("location.hash")
    assert "scene=scene-2" in fragment
    followed()
    assert page.locator("#scene-1").is_visible()
    followed(fragment)
    assert page.locator("select[name=scene]").input_value() == "scene-2"
    shown = page.locator("figure[data-quantity]:visible")
    assert shown.count() > 1
    names = shown.evaluate_all("all => all.map(each => each.dataset.quantity)")
    assert set(names) == {"contact_area"}


def test_a_hostile_address_changes_nothing(followed):
    """Unknown names, wrong numbers and markup in the address are ignored."""
    fragment = "#<script>alert(1)</script>?sort.scene-1-settings=99z&load.scene-1=-7"
    fragment += "&scene=nowhere&filter.x=%00"
    seen = followed(fragment)
    assert seen.page.locator("#scene-1").is_visible()
    assert seen.complaints == []


def sum_of_y(page, key):
    return page.evaluate(
        "key => document.querySelector(`[data-figure='${key}']`).data[0].y"
        ".reduce((a, b) => a + (b ?? 0), 0)",
        key,
    )


def test_the_slider_moves_pressure_and_model_by_arrow_keys(followed):
    """Hertz: the pressure's integral along r goes with a p0, with the depth d: d1/d6 = 1/10."""
    seen = followed("#scene-1-pressure")
    page = seen.page
    slider = page.locator("#scene-1 .figure-group .load-slider input").first
    last = sum_of_y(page, "scene-1-pressure-radial")
    slider.focus()
    for _ in range(5):
        page.keyboard.press("ArrowLeft")
    seen.settled()
    assert slider.input_value() == "0"
    assert slider.get_attribute("aria-valuetext") == (
        "penetration depth 1.00\u202fµm (load 1 of 6)"
    )
    first = sum_of_y(page, "scene-1-pressure-radial")
    assert first / last == pytest.approx(0.1, rel=0.1)
    # A step keeps the room of names and numbers, another width searches it anew.
    kept = "document.querySelector('[data-figure=scene-1-pressure-radial]').layout.margin"
    seen.wait(f"{kept}?.autoexpand === false")
    page.set_viewport_size({"width": PHONE[0], "height": PHONE[1]})
    seen.wait(f"{kept}?.autoexpand !== false")
    page.set_viewport_size({"width": DESKTOP[0], "height": DESKTOP[1]})
    # The slider above the model's picture moves along: one load for the whole scene.
    twin = page.locator("#scene-1 .picture-group .load-slider input").first
    assert twin.input_value() == "0"
    fragment = page.evaluate("location.hash")
    assert "load.scene-1=0" in fragment
    followed("#scene-1-pressure")
    assert sum_of_y(page, "scene-1-pressure-radial") == pytest.approx(last)
    followed(fragment)
    page.locator("[data-figure=scene-1-pressure-radial]").scroll_into_view_if_needed()
    seen.settled()
    assert sum_of_y(page, "scene-1-pressure-radial") == pytest.approx(first)


def test_the_slider_moves_the_table_of_spots(followed):
    """One table at a time, of the load beside the slider."""
    for place in (3, 7):
        page = followed(f"#scene-2-spots?load.scene-2={place}").page
        (shown,) = page.locator("#scene-2 [data-spots]").filter(visible=True).all_inner_texts()
        assert f"(load {place + 1} of 8)" in shown


def test_plots_are_saved_as_svg_and_png(followed, tmp_path):
    seen = followed("#scene-1-curves")
    drawing = seen.save("#scene-1 .figure-tools button:has-text('SVG')", tmp_path)
    picture = seen.save("#scene-1 .figure-tools button:has-text('PNG')", tmp_path)
    assert seen.complaints == []
    root = ElementTree.fromstring(drawing.read_text(encoding="utf-8"))
    assert root.tag == "{http://www.w3.org/2000/svg}svg"
    text = " ".join(root.itertext())
    assert "Reduced model" in text
    assert drawing.name == "steel-ball-reduced-model.svg"
    content = picture.read_bytes()
    assert content.startswith(b"\x89PNG")
    assert struct.unpack(">II", content[16:24]) == (1440, 960)


def test_tables_are_saved_as_they_are_shown_with_every_digit(followed, study, tmp_path):
    """Filtered and sorted rows, numbers as stored, bars in columns of their own."""
    seen = followed("#scene-1?filter.scene-1-settings=reduced&sort.scene-1-settings=1d")
    name = "CSV of: Cost and errors of every setting"
    path = seen.save(f"#scene-1 .table-tools button[aria-label='{name}']", tmp_path)
    rows = list(csv.DictReader(io.StringIO(path.read_text(encoding="utf-8-sig"))))
    assert [row["N"] for row in rows] == ["40", "20", "10"]
    scene = study.scenes[0]
    own = [v for v in scene.verdicts if (v.method, v.quantity) == ("reduced", "force")]
    own.sort(key=lambda verdict: -verdict.resolution)
    assert [float(row["error of force"]) for row in rows] == pytest.approx(
        [verdict.error for verdict in own], rel=1e-7
    )
    assert [float(row["time / s"]) for row in rows] == pytest.approx([3.92e-6, 2.8e-6, 2e-6])
    assert "uncertainty of error of force" in rows[0]


def test_a_typed_load_is_read_off_every_curve(followed):
    """Between two loads curves of power laws are read exactly: Hertz at 4 um of a ball of 10 mm."""
    seen = followed()
    page = seen.page
    box = page.locator("#scene-1 .figure-group input[type=number]").first
    page.locator("#scene-1 .scene-body").first.evaluate("one => { one.open = true; }")
    box.fill("4")
    rows = page.locator("#scene-1 .figure-group tbody tr").filter(has_text="closed form").first
    force = 4 / 3 * 231e9 * 0.01**0.5 * 4e-6**1.5
    assert float(rows.locator("td").first.inner_text()) == pytest.approx(force, rel=1e-3)
    assert "at.scene-1=4" in page.url
    box.fill("99")
    assert "Computed from" in page.locator("#scene-1 .figure-group .scroll .note").inner_text()


def test_text_of_strangers_is_no_formula_in_a_spreadsheet(followed, tmp_path):
    seen = followed()
    page = seen.page
    page.evaluate("document.querySelector('#scene-1-plan-table tbody td').textContent = '=1+1'")
    path = seen.save("#scene-1 button[aria-label='CSV of: Plan']", tmp_path)
    assert "'=1+1" in path.read_text(encoding="utf-8-sig")


@pytest.mark.slow
def test_a_view_turns_by_its_keys_and_only_one_is_live(followed):
    seen = followed("#scene-1-picture")
    seen.unfold()  # the other scene's picture, too
    page = seen.page
    toggles = page.get_by_role("button", name="Rotate")
    if not toggles.count():
        pytest.skip("this browser has no WebGL")
    assert toggles.count() == 2
    toggles.first.click()
    canvas = page.locator("[data-figure=scene-1-picture-view]")
    live = "document.querySelector('[data-figure=scene-1-picture-view]')._fullLayout"
    seen.wait(f"Boolean({live}?.scene?._scene)")
    eye = f"{live}.scene._scene.getCamera().eye.x"
    before = page.evaluate(eye)
    canvas.press("ArrowRight")
    seen.wait(f"Math.abs({eye} - {before}) > 0.05")
    page.get_by_role("button", name="Rotate").last.click()
    assert not canvas.is_visible()
    assert page.locator("[data-figure=scene-2-picture-view]").is_visible()
    # Drawing in software makes Chromium warn of slow reading; errors it must not report.
    assert [text for text in seen.complaints if text.startswith("error")] == []


def test_the_keyboard_reaches_every_control(followed):
    """By Tab alone: filter, CSV, headers, choices, slider, downloads, in the order of the page."""
    page = followed().page
    page.locator(".scene-body").evaluate_all("all => all.forEach(one => { one.open = true; })")
    page.locator("h1").click()  # from where Tab goes on
    reached = []
    for _ in range(300):
        page.keyboard.press("Tab")
        reached.append(
            page.evaluate(
                "(e => e.getAttribute('aria-label') || e.name || e.textContent)"
                "(document.activeElement)"
            )
        )
        if "SVG of: Reduced" in reached[-1]:
            break
    text = "\n".join(reached)
    order = ["tolerance", "CSV of: Verdicts", "SVG of: All", "CSV of: Summary", "\nscene\n"]
    order += ["\nquantity\n", "SVG of: Reduced"]
    places = [text.index(part) for part in order]
    assert places == sorted(places)
    slider = page.locator("#scene-1 .load-slider input").first
    assert slider.evaluate("e => e.tabIndex") == 0


@pytest.mark.slow
def test_paper_gets_light_plots_and_no_controls(followed, tmp_path):
    seen = followed()
    page = seen.page  # what is open is printed
    page.emulate_media(color_scheme="dark")
    page.locator("details").evaluate_all(
        "all => all.forEach(one => { one.open = Boolean(one.closest('#scene-1')); })"
    )
    path = tmp_path / "report.pdf"
    page.pdf(path=path, prefer_css_page_size=True)
    page.emulate_media(media="print")
    for selector in (".table-tools", ".figure-tools", ".load-slider", ".choices", "nav"):
        assert not page.locator(selector).first.is_visible()
    assert page.evaluate("getComputedStyle(document.body).backgroundColor") == "rgb(255, 255, 255)"
    assert seen.complaints == []
    page.emulate_media(media="screen", color_scheme="light")
    content = path.read_bytes()
    assert content.startswith(b"%PDF")
    pages = max(int(match) for match in re.findall(rb"/Count (\d+)", content))
    assert 4 <= pages <= 30


def test_without_javascript_tables_and_verdicts_stand(browser, report):
    context = browser.new_context(java_script_enabled=False)
    page = context.new_page()
    page.goto(report.as_uri())
    assert page.locator("#summary-table .verdict").first.is_visible()
    # Chromium shows <noscript> here, but playwright does not see into it.
    assert page.locator("noscript").count() == 1
    assert page.locator(".load-slider").first.is_visible() is False
    context.close()
