"""A headless browser that watches: requests, complaints, downloads."""

import shutil
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import partial
from itertools import count
from pathlib import Path

import pytest

from reports.pages.study import write_report
from reports.pictures import pictures

FLAGS = ["--no-sandbox", "--disable-gpu", "--disable-background-networking", "--no-first-run"]
FLAGS += ["--enable-unsafe-swiftshader"]  # WebGL in software
PATIENCE = 180.0  # seconds; a loaded machine is slow
NAMES = ("chromium", "chromium-browser", "google-chrome")
DESKTOP, PHONE = (1280, 800), (390, 844)
COLOUR_RULES = ["color-contrast", "link-in-text-block"]  # of axe-core: all that a scheme can change
# The rows after the third of a table, which are as these, and most of a long page.
ROWS_AWAY = """() => {
  const rows = [...document.querySelectorAll("table.data tbody tr:nth-child(n+4)")];
  window.rowsAway = rows.map(row => [row, row.parentNode]);
  for (const row of rows) row.remove();
}"""
ROWS_BACK = "() => { for (const [row, body] of window.rowsAway) body.append(row); }"


@pytest.fixture(scope="session")
def browser() -> Iterator:
    """Start the machine's own Chromium, once for all tests; skip them where there is none."""
    api = pytest.importorskip("playwright.sync_api", reason="playwright is not installed")
    program = next(filter(None, map(shutil.which, NAMES)), None)
    if program is None:
        pytest.skip("no Chromium on this machine")
    with api.sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=program, args=FLAGS)
        yield browser
        browser.close()


@dataclass
class Visit:
    """A page in a window, with all that it asked for and complained of."""

    page: object
    requests: list[str] = field(default_factory=list)
    complaints: list[str] = field(default_factory=list)
    links: Iterator[int] = field(default_factory=count)

    def wait(self, condition: str) -> None:
        """Wait until an expression is true (the page's policy forbids playwright's own way)."""
        end = time.monotonic() + PATIENCE
        while not self.page.evaluate(condition):
            assert time.monotonic() < end, f"never came true: {condition}"
            time.sleep(0.02)

    def follow(self, fragment: str) -> None:
        """Follow a link to the same page: what was chosen before is forgotten."""
        self.requests.clear()
        self.complaints.clear()
        fragment += ("&" if "?" in fragment else "?") + f"link={next(self.links)}"
        self.page.evaluate("scrollTo({ top: 0, behavior: 'instant' })")
        self.page.evaluate(
            "fragment => new Promise(followed => {"
            " addEventListener('hashchange', () => followed(), { once: true });"
            " location.hash = fragment; })",
            fragment,
        )
        self.settled()

    def settled(self) -> None:
        """Wait until all that is in sight is drawn."""
        self.wait(
            "[...document.querySelectorAll('[data-figure]:not([data-turn])')].filter(canvas => {"
            " const box = canvas.getBoundingClientRect();"
            " return canvas.checkVisibility() && box.height"
            " && box.bottom > 0 && box.top < innerHeight; })"
            ".every(canvas => canvas.querySelector('.main-svg'))"
        )

    def draw_all(self) -> None:
        """Bring every plot into sight once: the first that is not drawn, with what is beside it."""
        further = (
            "(() => {"
            " const waits = canvas => canvas.checkVisibility()"
            "  && canvas.getBoundingClientRect().height && !canvas.querySelector('.main-svg');"
            " const canvases = document.querySelectorAll('[data-figure]:not([data-turn])');"
            " const next = [...canvases].find(waits);"
            " next?.scrollIntoView({ behavior: 'instant' });"
            " return Boolean(next); })()"
        )
        while self.page.evaluate(further):
            self.settled()

    def unfold(self) -> None:
        """Open every section: what is folded is not drawn."""
        self.page.evaluate("for (const part of document.querySelectorAll('details')) part.open = 1")
        self.settled()

    def tab_stops(self) -> int:
        """Count what the Tab key stops at."""
        return self.page.evaluate(
            "[...document.querySelectorAll("
            " \"a[href], button, input, select, summary, [tabindex='0']\")].filter(one =>"
            " one.checkVisibility({ visibilityProperty: true }) && !one.disabled).length"
        )

    def save(self, selector: str, folder: Path) -> Path:
        """Press a button that downloads, and return the file."""
        with self.page.expect_download() as waiting:
            self.page.locator(selector).first.click()
        path = folder / waiting.value.suggested_filename
        waiting.value.save_as(path)
        return path


@contextmanager
def visited(
    browser, path: Path, size=DESKTOP, scheme: str = "light", fragment: str = ""
) -> Iterator[Visit]:
    """Open a page; every request but that for the page itself is recorded and refused."""
    width, height = size
    context = browser.new_context(
        viewport={"width": width, "height": height},
        color_scheme=scheme,
        reduced_motion="reduce",
        has_touch=size == PHONE,
        is_mobile=size == PHONE,
    )
    context.set_default_timeout(1000 * PATIENCE)
    page = context.new_page()
    visit = Visit(page)

    def watch(route):
        if route.request.url.split("#")[0] == path.as_uri():
            return route.continue_()
        visit.requests.append(route.request.url)
        return route.abort()

    context.route("**/*", watch)
    page.on("console", lambda part: visit.complaints.append(f"{part.type}: {part.text}"))
    page.on("pageerror", lambda error: visit.complaints.append(f"error: {error}"))
    page.goto(path.as_uri() + fragment)
    visit.settled()
    yield visit
    context.close()


@pytest.fixture(scope="session")
def report(study, tmp_path_factory):
    """Write the synthetic study's report, its views that turn included, its pictures left out."""
    path = tmp_path_factory.mktemp("browser") / "report.html"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(pictures, "render", lambda jobs: [b""] * len(jobs))
        write_report(study, path)
    return path


@pytest.fixture
def visit(browser, report):
    """Open the `report`: size, scheme and fragment may be given."""
    return partial(visited, browser, report)


@pytest.fixture(scope="session")
def window(browser, report):
    """Open the synthetic study's `report` once: a page takes seconds until its program runs."""
    with visited(browser, report) as seen:
        yield seen


@pytest.fixture
def followed(window):
    """Follow a link in that window; take `visit` for what a newcomer sees."""

    def follow(fragment: str = "") -> Visit:
        window.follow(fragment)
        return window

    return follow


@pytest.fixture
def serious_faults():
    """Return what axe-core finds at least serious on a page, a line for each place and rule.

    In dark colours what does not hang on colours is not looked at again.
    """

    def faults(page, dark: bool = False) -> list[str]:
        axe = pytest.importorskip("axe_playwright_python.sync_playwright")
        # What is drawn inside a plot is one image to a reader of the screen.
        context = {"exclude": [[".svg-container"]]}
        options = {"resultTypes": ["violations"]}
        if dark:
            page.emulate_media(color_scheme="dark")
            options["runOnly"] = {"type": "rule", "values": COLOUR_RULES}
        page.evaluate(ROWS_AWAY)
        result = axe.Axe().run(page, context=context, options=options).response["violations"]
        page.evaluate(ROWS_BACK)
        return [
            f"{part['id']} ({part['impact']}): {node['html'][:160]}"
            for part in result
            if part["impact"] in ("serious", "critical")
            for node in part["nodes"]
        ]

    return faults
