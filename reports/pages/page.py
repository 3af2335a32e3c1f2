"""Rendering of all pages: one self-contained file that runs only its own scripts.

plotly.js (compressed, as `library.js` unpacks it), pictures, styles and data are embedded. All text
from scenes or results is escaped, and a content security policy allows only the page's own scripts,
by their hashes.
"""

from __future__ import annotations

import base64
import hashlib
import json
import math
import os
import re
import zlib
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from contextlib import suppress
from functools import cache, partial
from pathlib import Path
from typing import Any

from jinja2 import Environment, FileSystemLoader, StrictUndefined, select_autoescape
from jinja2.bccache import Bucket, FileSystemBytecodeCache
from markupsafe import Markup, escape
from plotly.offline import get_plotlyjs, get_plotlyjs_version

from comparisons import code_cache
from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.files import parse_toml, plain, write_text
from comparisons.results.record import WHERE
from reports.plots.figure import Figure
from reports.plots.interactive import spec
from reports.plots.style import look
from reports.tables.cells import size, tone

TEMPLATES = Path(__file__).with_name("templates")
# One program in the page, in this order: later parts use the names of earlier ones.
SCRIPTS = (
    "state.js",
    "library.js",
    "plots.js",
    "downloads.js",
    "tables.js",
    "sliders.js",
    "reading.js",
    "judging.js",
    "turning.js",
    "start.js",
)
# The small scale in the heat map: error over tolerance, the tolerance in its middle.
STRIP_DECADES = (-3.0, 3.0)
_SUBSCRIPT = re.compile(r"(?<!\w)([^\W\d_]{1,2})_(\w{1,3})(?!\w)")
_SENTENCE_END = re.compile(r"(?<=\.) (?=[A-Z*])")


def render(
    template: str,
    drawn: Mapping[str, Figure | dict[str, Any]],
    *,
    data: Mapping[str, Any] | None = None,
    static: bool = False,
    **values: Any,
) -> str:
    """Return a page as text, of a template with its variables.

    `drawn` are figures (or plotly data and layout) by the key of their canvas, `data` what the
    page's program reads, by name; a static page is without any script.
    """
    script, library = ("", "") if static else (page_script(), get_plotlyjs())
    return (
        environment()
        .get_template(template)
        .render(
            policy=content_policy(list(filter(None, [library, script]))),
            style=Markup((TEMPLATES / "report.css").read_text(encoding="utf-8")),  # noqa: S704
            static=static,
            script=Markup(script),  # noqa: S704  our own files
            library="" if static else packed_library(),
            figure_data={
                key: embedded_json(spec(graph) if isinstance(graph, Figure) else graph)
                for key, graph in drawn.items()
            },
            page_data={key: embedded_json(value) for key, value in (data or {}).items()},
            **values,
        )
    )


def tally(words: Iterable[str], order: Iterable[str]) -> list[tuple[str, int]]:
    """Return how often each word stands there, of those that do."""
    counts = Counter(words)
    return [(word, counts[word]) for word in order if counts[word]]


@cache
def page_script() -> str:
    """Return the script of the pages: all parts in one scope, in strict mode."""
    parts = [(TEMPLATES / name).read_text(encoding="utf-8") for name in SCRIPTS]
    return "\n".join(['"use strict";', "(() => {", *parts, "})();"])


@cache
def packed_library() -> str:
    """Return plotly.js compressed, in base64, which is two fifths of it; kept for later pages."""
    name = f"plotly-{get_plotlyjs_version()}.packed"
    with suppress(KeyError, OSError):
        return Path(os.environ[code_cache.VARIABLE], name).read_text()
    packed = base64.b64encode(zlib.compress(get_plotlyjs().encode())).decode()
    with suppress(KeyError, OSError):
        write_text(Path(os.environ[code_cache.VARIABLE], name), packed)
    return packed


def embedded_json(value: Any) -> Markup:
    r"""Return JSON that is safe inside <script>: without '<', no tag can open or close.

    NaN and infinities, which JSON does not allow, become null, a gap in a curve.

    >>> print(embedded_json({"a": "</script>"}))
    {"a":"\u003c/script>"}
    """
    dumps = partial(json.dumps, allow_nan=False, separators=(",", ":"), ensure_ascii=False)
    try:
        text = dumps(value)  # figures nearly always are plain already
    except (TypeError, ValueError):
        text = dumps(plain(value))
    for character in "<&\u2028\u2029":
        text = text.replace(character, f"\\u{ord(character):04x}")
    return Markup(text)  # noqa: S704


def content_policy(scripts: list[str]) -> str:
    """Return the content security policy: our scripts by hash, no external content."""
    hashes = (base64.b64encode(hashlib.sha256(s.encode()).digest()).decode() for s in scripts)
    allowed = " ".join(f"'sha256-{digest}'" for digest in hashes) or "'none'"
    return (
        f"default-src 'none'; script-src {allowed}; style-src 'unsafe-inline'; "
        "img-src data: blob:; base-uri 'none'; form-action 'none'"
    )


class _CompiledTemplates(FileSystemBytecodeCache):
    """Templates as Python's code, which takes longer to make than a page."""

    def dump_bytecode(self, bucket: Bucket) -> None:
        """Keep one; without room for it the next page compiles it again."""
        with suppress(OSError):
            super().dump_bytecode(bucket)


@cache
def environment() -> Environment:
    """Return the template environment with its shared functions."""
    # Jinja knows its own version and the template's text; the settings below are this file's.
    settings = hashlib.sha256(Path(__file__).read_bytes()).hexdigest()[:16]
    folder = os.environ.get(code_cache.VARIABLE)
    templates = Environment(
        bytecode_cache=_CompiledTemplates(folder, f"page-{settings}-%s.cache") if folder else None,
        loader=FileSystemLoader(TEMPLATES),
        autoescape=select_autoescape(default=True, default_for_string=True),
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    templates.filters.update(tolerance=fmt.tolerance, symbols=_symbols)
    templates.globals |= {
        "static": False,  # a page says otherwise
        "fmt": fmt,
        "quantity": quantity,
        "look": look,
        "tone": tone,
        "size": size,
        "term": _term,
        "glossary": glossary,
        "strip": _strip,
        "told_once": told_once,
        "finite": fmt.finite,
        # the value by which a cell is sorted and exported
        "raw": lambda value: value if isinstance(value, str) else f"{value:.8g}",
        "data_uri": lambda png: "data:image/png;base64," + base64.b64encode(png).decode(),
    }
    return templates


def _symbols(text: str) -> Markup:
    """Return prose of a claim with Greek letters and subscripts.

    >>> _symbols("roll-off L/lambda_l < 2")
    Markup('roll-off L/λ<sub>l</sub> &lt; 2')
    """
    return Markup(_SUBSCRIPT.sub(r"\1<sub>\2</sub>", str(escape(fmt.greek(text)))))  # noqa: S704


@cache
def glossary() -> dict[str, Any]:
    """Return the terms and the measures that the report explains."""
    text = (TEMPLATES / "glossary.toml").read_text(encoding="utf-8")
    return parse_toml(text.replace("{where}", WHERE))


def _term(key: str, text: str | None = None) -> Markup:
    """Return a term linked to the glossary, with its explanation on hover."""
    term = glossary()["terms"][key]
    return Markup('<a class="term" href="#term-{}"><abbr title="{}">{}</abbr></a>').format(
        key, term["meaning"], text or term["name"]
    )


def told_once(figures: Sequence[Figure]) -> tuple[str, list[str]]:
    """Return the sentences that captions of a group share, and what is left of each caption."""
    captions = [_SENTENCE_END.split(figure.caption) for figure in figures]
    counts = Counter(sentence for caption in captions for sentence in caption)
    shared = [sentence for sentence, count in counts.items() if count > 1]
    own = [" ".join(part for part in caption if part not in shared) for caption in captions]
    return " ".join(shared), own


def _strip(error: float, uncertainty: float, tolerance: float) -> Markup:
    """Return the attributes of a cell of the heat map: places in per cent of its small scale.

    Error over tolerance and the ends of its bar, on a logarithmic scale; what lies beyond an
    end of the scale is an arrow there.
    """
    low, high = STRIP_DECADES
    error, bar = abs(error), uncertainty if fmt.finite(uncertainty) else 0.0
    places = []
    for value in (error, error - bar, error + bar):
        power = math.log10(value / tolerance) if value > 0 else -math.inf
        places.append(round(100 * (min(max(power, low), high) - low) / (high - low), 1))
    beyond = "under" if places[0] <= 0 else "over" if places[0] >= 100 else ""
    return Markup('data-beyond="{}" style="--e:{};--a:{};--b:{}"').format(beyond, *places)
