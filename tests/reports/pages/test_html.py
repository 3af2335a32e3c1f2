"""The page as a whole: offline, inert against hostile text, complete, and right in its verdicts."""

import base64
import hashlib
import json
import math
import re
import shutil
import subprocess
import zlib
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pandas as pd
import pytest
from threadpoolctl import threadpool_info, threadpool_limits

import reports.pages
from comparisons.formatting import number
from comparisons.judging.truth import NO_REFERENCE
from comparisons.judging.verdicts import worst
from comparisons.results.advice import advise
from comparisons.results.recording import explained
from comparisons.results.rows import NO_ROWS, Rows
from comparisons.solving.plan import PlanRecord
from reports.pages import study as html
from reports.pages.page import embedded_json, told_once
from reports.plots.errors import errors
from reports.tables import scene as tables

SECTIONS = ("picture", "plan", "curves", "errors", "pressure", "speed", "table", "repeat")


class Page(HTMLParser):
    """Tags with their attributes, the text outside scripts, and the scripts."""

    def __init__(self, text: str) -> None:
        super().__init__(convert_charrefs=True)
        self.tags: list[tuple[str, dict]] = []
        self.scripts: list[tuple[dict, str]] = []
        self.text = ""
        self._open: str | None = None
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attrs):
        self.tags.append((tag, dict(attrs)))
        self.text += "\n" if tag in {"td", "th", "p", "dt", "dd", "h2", "h3"} else ""
        self._open = tag if tag in {"script", "style"} else None
        if tag == "script":
            self.scripts.append((dict(attrs), ""))

    def handle_endtag(self, tag):
        self._open = None

    def handle_data(self, data):
        if self._open == "script":
            attributes, before = self.scripts[-1]
            self.scripts[-1] = (attributes, before + data)
        elif self._open is None:
            self.text += data

    @property
    def ids(self) -> list[str]:
        return [attributes["id"] for _, attributes in self.tags if "id" in attributes]

    @property
    def figures(self) -> dict[str, dict]:
        return {
            attributes["id"]: json.loads(text)
            for attributes, text in self.scripts
            if attributes.get("id", "").startswith("data-")
        }


@pytest.fixture(scope="module")
def source(study):
    return html.page(study, with_pictures=False)


@pytest.fixture(scope="module")
def parsed(source):
    return Page(source)


def test_nothing_is_fetched_from_anywhere(parsed):
    """No attribute that loads leads out of the file; the policy forbids what might be missed."""
    for tag, attributes in parsed.tags:
        for name in ("src", "href", "srcset", "data", "action", "poster"):
            target = attributes.get(name, "")
            assert target == "" or target.startswith(("#", "data:image/png")), (tag, target)
        assert tag not in {"link", "iframe", "object", "embed", "base"}
    policy = next(a["content"] for t, a in parsed.tags if t == "meta" and "http-equiv" in a)
    assert policy.startswith("default-src 'none'")
    assert "http" not in policy


@pytest.fixture(scope="module")
def programs(parsed):
    """Return the page's own program, and plotly.js as that unpacks it."""
    plain = [text for attributes, text in parsed.scripts if "type" not in attributes]
    packed = [text for attributes, text in parsed.scripts if attributes.get("id") == "library"]
    return [*plain, *(zlib.decompress(base64.b64decode(text)).decode() for text in packed)]


def test_plotly_is_embedded_once_and_the_policy_names_the_hash_of_every_program(source, programs):
    """A browser would refuse a script whose hash is wrong; compute it as the standard says."""
    assert sum("plotly.js v" in text[:500] for text in programs) == 1
    assert sum(text.count("Copyright 2012") for text in programs) == 1
    assert "Copyright 2012" not in source  # only compressed
    assert len(programs) == 2

    policy = source.replace("&#39;", "'").replace("&#43;", "+")
    for text in programs:
        digest = base64.b64encode(hashlib.sha256(text.encode()).digest()).decode()
        assert f"'sha256-{digest}'" in policy
    assert policy.count("'sha256-") == len(programs)


def test_hostile_text_stays_text(source, parsed):
    """The title, a failure's reason and the scene's TOML carry markup; all of it must be shown."""
    assert "<script>alert" not in source
    assert "Ball <script>alert(1)</script> & 'quotes' on a half-space" in parsed.text
    assert "[<b>residual</b> 1e-3]" in parsed.text
    assert "</script><b>&" in parsed.text
    assert not any(tag == "b" and not attributes for tag, attributes in parsed.tags)
    for attributes, text in parsed.scripts:
        if attributes.get("type") == "application/json":
            assert "<" not in text


def test_text_in_plots_carries_no_markup_of_strangers(parsed):
    """Plotly reads a little HTML in hovers: reasons must come to it escaped."""
    crosses = [
        trace
        for figure in parsed.figures.values()
        for trace in figure["data"]
        if trace.get("marker", {}).get("symbol") == "x-open"
    ]
    assert crosses
    assert all("<b>" not in text for trace in crosses for text in trace["text"])
    assert "&lt;b&gt;" in crosses[0]["text"][0]


def test_what_captions_share_is_said_once_above_their_plots(study, parsed):
    captions = ("Each line (eq. 4.22). A band.", "A band. Another * line.", "Alone.")
    (figure, *_) = errors(study.scenes[0])
    said = told_once([replace(figure, caption=caption) for caption in captions])
    assert said == ("A band.", ["Each line (eq. 4.22).", "Another * line.", "Alone."])
    assert parsed.text.count("lower left is better.") == len(study.scenes)


def test_what_is_not_a_number_is_a_gap_in_the_embedded_data():
    assert embedded_json({"x": [math.nan, math.inf, 1.0]}) == '{"x":[null,null,1.0]}'


def test_every_scene_has_every_section_in_the_same_order(study, parsed):
    for k in range(1, len(study.scenes) + 1):
        places = [parsed.ids.index(f"scene-{k}-{name}") for name in SECTIONS]
        assert places == sorted(places)


def test_ids_are_unique_and_links_inside_the_page_arrive(parsed):
    assert len(parsed.ids) == len(set(parsed.ids))
    links = {a["href"][1:] for t, a in parsed.tags if t == "a" and "href" in a}
    assert links <= set(parsed.ids)


def test_every_plot_has_its_data_and_something_to_draw(parsed):
    wanted = {f"data-{a['data-figure']}" for _, a in parsed.tags if "data-figure" in a}
    assert wanted == set(parsed.figures)
    for key, figure in parsed.figures.items():
        drawn = [v for t in figure["data"] for v in t.get("y", []) if v is not None]
        assert drawn, key


def test_no_number_has_more_digits_than_a_reader_wants(parsed):
    """Sixteen-digit floats are the mark of a value that was printed without thought."""
    assert not re.search(r"\d\.\d{6,}", parsed.text.replace("0.1.0", ""))
    assert "nan" not in re.findall(r"[a-z]+", parsed.text)


def test_the_bar_of_the_truth_is_listed_by_source_at_the_load_that_decided(study):
    scene = study.scenes[1]
    bars = [0.57, 0.3, 0.18, 0.1, 0.09, 0.08, 0.062]
    sources = {"contact_area": {"discretisation": bars, "realisations": [0.012] * 7}}
    verdicts = tuple(replace(item, step=6) for item in scene.verdicts)
    reference = replace(scene.reference, sources=sources)
    scene = replace(scene, reference=reference, verdicts=verdicts)
    text = Page(html.page(study.model_copy(update={"scenes": (scene,)}), with_pictures=False)).text
    assert "discretisation 6.2\u202f%, realisations 1.2\u202f%" in text
    assert "discretisation 57" not in text


def test_reasons_answers_and_disagreements_stand_on_the_page(study, parsed):
    for scene in study.scenes:
        assert advise(scene).sentence in parsed.text
        assert all(text in parsed.text for text in scene.disagreements)
    assert "ContactMechanics takes rough maps only" in parsed.text
    assert "active set cycled after 30 rounds" in parsed.text
    disagreement = parsed.text.index("References disagree")
    assert disagreement < parsed.text.index("Verdicts")


def test_a_doubt_about_the_scene_stands_before_its_errors(study):
    doubt = "check the slopes: d/a = 0.678"
    scene = study.scenes[0]
    doubted = replace(scene, plan=replace(scene.plan, notes=(doubt,)))
    text = Page(
        html.page(study.model_copy(update={"scenes": (doubted,)}), with_pictures=False)
    ).text
    assert text.index(doubt) < text.index("Largest error of the reduced model")


def test_verdicts_use_the_finest_resolution_of_the_reduced_model(study):
    said = study.scenes[1].verdicts_on()
    assert [(item.quantity, item.word, item.resolution) for item in said] == [
        ("penetration", "within", 128.0),
        ("contact_area", "outside", 128.0),
    ]


def test_a_reduced_model_without_a_result_says_why(study):
    scene = study.scenes[0]
    lost = tuple(item for item in scene.verdicts if item.method != "reduced")
    lost = recorded(scene, verdicts=lost)
    assert {item.word for item in lost.verdicts_on()} == {"no result"}
    assert "no value of the reduced model" in lost.verdicts_on()[0].reason
    silent = recorded(lost, rows=lost.rows.where(lost.rows["method"] != "reduced"))
    assert "not computed by the method" in silent.verdicts_on()[0].reason


def recorded(scene, **changes):
    other = replace(scene, **changes)
    return replace(other, verdicts=explained(other))


def bare(study, **changes):
    """Return a study of one scene of which nothing is known but its name."""
    empty = {"rows": NO_ROWS, "verdicts": (), "fields": {}}
    empty |= {"plan": PlanRecord(), "reference": NO_REFERENCE}
    scene = recorded(study.scenes[0], **(empty | changes))
    return study.model_copy(update={"scenes": (scene,), "machine": {}, "interrupted": True})


def test_a_scene_without_results_and_one_that_lost_all_still_make_a_page(study):
    page = Page(html.page(bare(study)))
    assert "no result" in page.text
    assert "Interrupted" in page.text
    assert page.figures == {}
    lost = study.scenes[0].rows.where(np.isnan(study.scenes[0].rows["step"]))
    page = Page(html.page(bare(study, rows=lost, plan=study.scenes[0].plan), with_pictures=False))
    assert "active set cycled" in page.text


def test_unknown_methods_are_drawn_in_grey(study):
    scene = study.scenes[0]
    table = scene.rows.frame()
    rows = Rows.of(table.assign(method=table["method"].replace({"bem_fft": "tamaas <2>"})))
    verdicts = tuple(
        replace(v, method="tamaas <2>") if v.method == "bem_fft" else v for v in scene.verdicts
    )
    renamed = recorded(scene, rows=rows, verdicts=verdicts)
    page = Page(html.page(study.model_copy(update={"scenes": (renamed,)}), with_pictures=False))
    traces = [t for figure in page.figures.values() for t in figure["data"]]
    peers = [t for t in traces if t.get("name") == "tamaas &lt;2&gt;"]
    assert peers
    assert {t.get("line", t["marker"])["color"] for t in peers} == {"@peer"}


def test_a_report_is_made_on_one_thread_of_linear_algebra(tmp_path, monkeypatch):
    """Threads that share matrices of two rows wait for each other: three quarters of the time."""
    threads = []

    def page(*_, **__):
        threads.extend(pool["num_threads"] for pool in threadpool_info())
        return ""

    monkeypatch.setattr(html, "page", page)
    with threadpool_limits(limits=2):
        html.write_report(None, tmp_path / "report.html")
    assert set(threads) == {1}


def test_the_prescribed_load_decides_and_the_other_is_a_row_to_look_up(study):
    """Contact area at equal penetration is within; at equal force it would be outside."""
    scene = study.scenes[0]
    far = {"at": "force", "error": 0.5, "low": 0.5, "high": 0.5, "word": "outside"}
    area = [item for item in scene.verdicts if item.quantity == "contact_area"]
    other = tuple(replace(item, **far) for item in area if item.word != "no result")
    both = replace(scene, verdicts=scene.verdicts + other)
    (area,) = [item for item in both.verdicts_on() if item.quantity == "contact_area"]
    assert (area.at, area.word) == ("penetration", "within")
    assert worst(both.verdicts_on()).word == "within"
    assert advise(both).cheapest.method == "reduced"
    assert [(item.at, item.word) for item in both.verdicts_at_other_load] == [("force", "outside")]
    page = html.page(study.model_copy(update={"scenes": (both,)}), with_pictures=False)
    assert "not used for the verdict" in page


def test_lost_solves_are_listed_once_with_their_steps(study):
    scene = study.scenes[0]
    table = scene.rows.frame()
    lost = table[table["step"].isna() & (table["method"] == "bem_dense")]
    steps = pd.concat([lost.assign(step=n, penetration=1e-6 * n) for n in (1, 2, 3)])
    rows = pd.concat([table.drop(index=lost.index), steps])
    (line,) = tables.lost_solves(replace(scene, rows=Rows.of(rows)))
    assert line.startswith("dense BEM, N = 20, 3 load steps: active set cycled")


SCRIPT = Path(reports.pages.__file__).parent / "templates" / "judging.js"
RATIOS = [1e-7, 1.2e-4, 9.6e-4, 0.0012, 0.012, 0.3, 0.96, 1, 4.6, 95, 1234, 5.1e5, 999999, 3e21]


@pytest.mark.skipif(shutil.which("node") is None, reason="needs node")
def test_ratios_of_times_are_written_as_python_does():
    script = SCRIPT.read_text(encoding="utf-8")
    start = script.index("const oneDigit")
    function = script[start : script.index("\nconst ends", start)]
    asked = f"{function}; console.log(JSON.stringify({RATIOS}.map(oneDigit)))"
    told = subprocess.run(["node", "-e", asked], capture_output=True, check=True).stdout
    assert json.loads(told) == [number(ratio, 1) for ratio in RATIOS]
