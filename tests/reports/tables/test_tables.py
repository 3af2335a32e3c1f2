"""One table, several renderers: each says the same, in its own way."""

import pytest
from rich.console import Console

from reports.pages.page import environment
from reports.tables import cells
from reports.tables.documents import rewrite
from reports.tables.table import table, tone
from reports.tables.terminal import drawn
from reports.tables.written import alignment, frame, in_markdown, latex
from roughline import notebook

HOSTILE = "a|b [bold] <i> $x"


@pytest.fixture
def judged():
    rows = [
        (cells.method("bem_fft"), cells.count(1024), cells.error(0.0123, 0.0004), HOSTILE),
        (cells.method("reduced"), cells.count(40), cells.NOTHING, cells.verdict("within")),
    ]
    return table(("method", "N", "error", "what"), rows, title="Errors", strong=frozenset({1}))


def on_a_terminal(given) -> str:
    console = Console(width=200, emoji=False)
    with console.capture() as said:
        console.print(drawn(given))
    return said.get()


def on_a_page(given) -> str:
    source = '{% import "macros.html.j2" as part with context %}{{ part.data_table(t, "L", "id") }}'
    return environment().from_string(source).render(t=given)


def test_every_renderer_says_the_same_words(judged):
    texts = [on_a_terminal(judged), on_a_page(judged), str(notebook.table(judged))]
    for text in [*texts, latex(judged, "x"), in_markdown(judged)]:
        for word in ("FFT BEM", "reduced model", "1\u202f024", "within"):
            assert word.replace("\u202f", r"\,") in text.replace("\u202f", r"\,")


def test_an_error_has_its_sign_and_bar_in_print_as_on_the_screen(judged):
    assert "+1.23 ± 0.04\u202f%" in on_a_terminal(judged)
    assert "+1.23 ± 0.04\u202f%" in in_markdown(judged)
    assert r"+1.23 $\pm$ 0.04\,\%" in latex(judged, "x")


def test_text_of_strangers_is_text_in_every_renderer(judged):
    assert HOSTILE in on_a_terminal(judged)
    assert "&lt;i&gt;" in on_a_page(judged)
    assert "&lt;i&gt;" in notebook.table(judged)
    assert r"a\|b \[bold\] &lt;i&gt;" in in_markdown(judged)
    assert r"\$x" in latex(judged, "x")


def test_numbers_stand_to_the_right_and_are_numbers_in_a_frame(judged):
    assert alignment(judged) == "lrrl"
    assert frame(judged)["N"].tolist() == [1024, 40]


def test_a_verdict_has_the_colour_of_its_tone(judged):
    assert f'<span class="verdict {tone("within")}">within</span>' in on_a_page(judged)
    assert "#00624a" in notebook.table(judged)


def test_columns_are_chosen_by_their_heads(judged):
    assert [head.text for head in judged.only("N", "method").heads] == ["N", "method"]
    assert [head.text for head in judged.without("N").heads] == ["method", "error", "what"]
    assert len(judged.first(1).rows) == 1


def test_tables_between_markers_are_made_anew_and_others_are_printed(tmp_path, capsys):
    page = tmp_path / "page.md"
    page.write_text(
        "a\n<!-- table: x -->\nold\n<!-- end -->\nb\n<!-- table: y -->\nz\n<!-- end -->\n"
    )
    tables = {name: lambda: [["h"], ["1"]] for name in "xyz"}
    rewrite(page, tables, ["x", "z"])
    text = page.read_text()
    assert "a\n<!-- table: x -->\n| h |\n|---|\n| 1 |\n<!-- end -->\nb\n" in text
    assert "<!-- table: y -->\nz\n" in text
    assert capsys.readouterr().out == "z\n\n| h |\n|---|\n| 1 |\n\n"
