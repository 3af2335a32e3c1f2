"""Tables of verdicts: one method on many scenes, or all methods on one scene."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import astuple, replace

from comparisons import formatting as fmt
from comparisons.facts.methods import MODEL, NOT_ASKED
from comparisons.facts.quantities import in_order, quantity
from comparisons.judging.verdicts import NO_RESULT, worst
from comparisons.results.advice import ITSELF, Advice, advise
from comparisons.results.finding import finding, largest_error, symbol
from comparisons.results.record import WHERE, SceneRecord, title_in
from comparisons.scene.scene import PREPARATION
from reports.tables import cells
from reports.tables.card import not_known_here, true_value
from reports.tables.cells import Cell, Table, table

TRUE = "true values ± bar"  # of all loads, and the rms of their bars


def verdict_table(scenes: Sequence[SceneRecord], method: str, *, reasons: bool = True) -> Table:
    """Return the verdict of a method on every quantity, and the cheapest setting of each scene.

    With `reasons`, missing results are explained. Missing answers are told in any case.
    """
    rows = []
    for scene in scenes:
        cheapest = advise(scene).cheapest
        name, best = scene.name, "" if cheapest is None else cheapest.text
        for judgement in scene.verdicts_on(method):
            label = quantity(judgement.quantity).label
            if judgement.word == NO_RESULT:
                asked = judgement.counts and judgement.offered
                text = NO_RESULT if asked else fmt.MISSING
                because = f": {judgement.reason}"
            else:
                text = f"{judgement.word} {fmt.tolerance(judgement.tolerance)}{judgement.lacking}"
                because = f", {judgement.band}" if judgement.band else ""
            judged = cells.verdict(judgement.word, text=text + because if reasons else text)
            error = cells.of_verdict(judgement)
            true = true_value(scene, judgement.quantity)
            rows.append((name, label, error, judgement.when, judged, true, best))
            name = best = ""  # of a scene only its first row has them
    heads = ("scene", "quantity", "largest error", "at", "verdict", TRUE, "cheapest")
    found = table(heads, rows, title=fmt.capitalised(title_in(scenes, method)))
    return found if any(row[3] for row in rows) else found.without("at")


def prepared_table(scenes: Iterable[SceneRecord]) -> Table:
    """Return the true values along a sweep, of a map by its preparations; no rows without any."""
    swept = [item for item in scenes if item.tables.get("sweep")]
    by_cut = any(PREPARATION in item.tables["sweep"] for item in swept)
    shared = {"contact_area": "A/A₀", "force": "F/A₀"} if by_cut else {}
    asked = {name for item in swept for name in item.quantities}
    names = in_order(asked | {"contact_area"} if by_cut else asked)
    rows = []
    for scene in swept:
        area = scene.plan.roughness.area if scene.plan.roughness else None
        values = (
            true_value(scene, name, nominal=area if name in shared else None) for name in names
        )
        rows.append((scene.name, *values))
    heads = ("scene", *(shared.get(name, quantity(name).label) for name in names))
    note = "The A/A₀ of quarters compares with that of the whole, their stiffness does not."
    title = f"True values {'by preparation' if by_cut else 'along the sweep'}"
    return table(heads, rows, title=title, note=note if by_cut else "")


def finding_table(scenes: Sequence[SceneRecord], method: str) -> Table:
    """Return where a method may be used, at most eight rows; the note explains its symbols."""
    found = finding(scenes, method)
    rows = [
        (
            Cell(row.scenes, row.scenes, "text wrap"),
            *(cells.verdict(row.use), row.error, row.cost),
            Cell(row.instead, row.instead, "text wrap"),
        )
        for row in found
    ]
    heads = ("scenes", "use it?", "largest error", "its time", "instead")
    words = " ".join(" ".join(astuple(row)) for row in found).replace(",", " ").split()
    names = {item.quantity for scene in scenes for item in scene.verdicts_on(method)}
    note = _explained(name for name in names if symbol(name) in words)
    starred = ITSELF if any("*" in row.instead for row in found) else ""
    note = "; ".join(filter(None, [note, starred, not_computed(scenes, method)]))
    if method == MODEL:
        told = (f"{item.name}: {said}" for item in scenes if (said := not_known_here(item)))
        note = "\n".join(filter(None, [note, *told]))
    return table(heads, rows, title=fmt.capitalised(title_in(scenes, method)), note=note)


def not_computed(scenes: Sequence[SceneRecord], method: str) -> str:
    """Return which asked quantities a method does not compute; its verdicts say nothing of them."""
    lacking: dict[str, list[str]] = {}
    for scene in scenes:
        for item in scene.verdicts_on(method):
            if item.counts and not item.offered:
                lacking.setdefault(quantity(item.quantity).label, []).append(scene.name)
    of = {label: of[0] if len(of) == 1 else f"{len(of)} scenes" for label, of in lacking.items()}
    named = (label if len(scenes) == 1 else f"{label} ({of[label]})" for label in of)
    return f"not computed, so not part of the answer: {', '.join(named)}" if of else ""


def _explained(names: Iterable[str]) -> str:
    """Return the meaning of the symbols of some quantities, in standard order."""
    rows = [quantity(name) for name in in_order(names)]
    return ", ".join(f"{row.symbol} {row.label}" for row in rows if row.symbol)


def summary_lines(scenes: Sequence[SceneRecord]) -> Table:
    """Return a line per scene and judged method: verdict, worst quantity, cheapest setting.

    Quantities are symbols, so that a line has room in 80 columns; the note explains them.
    """
    rows: list[tuple[Cell | str, ...]] = []
    told_of: set[str] = set()
    starred = ""
    for scene in scenes:
        cheapest = advise(scene).cheapest
        best: list[Cell | str] = [cells.method("", "none"), "", ""]
        if cheapest is not None:
            starred = ITSELF if cheapest.judges_itself else starred
            level = cells.count(cheapest.resolution)
            star = f"{cheapest.title}{ITSELF[0] * cheapest.judges_itself}"
            best = [cells.method(cheapest.method, star), cells.duration(cheapest.seconds), level]
        for method in scene.judged_methods:
            decisive = worst(scene.verdicts_on(method))
            told_of.add(decisive.quantity)
            name = scene.name if method == MODEL else f"{scene.name}, {scene.title_of(method)}"
            error = cells.of_verdict(decisive)
            error = replace(error, text=error.text + decisive.lacking)
            rows.append(
                (name, cells.verdict(decisive.word), symbol(decisive.quantity), error, *best)
            )
    levels = fmt.listed([*map(fmt.tolerance, sorted({scene.tolerance for scene in scenes}))])
    told = f"worst: {_explained(told_of)}", f"verdicts at {levels}", starred
    heads = ("scene", "verdict", "worst", "error", "cheapest", "time", "N")
    return table(heads, rows, note="; ".join(filter(None, told)))


def printed_verdicts(scenes: Sequence[SceneRecord]) -> Table:
    """Return the verdicts on the reduced model for papers, with a self-contained caption."""
    caption = (
        "Largest relative error of the reduced model over all load steps at equal prescribed load "
        "(the prescribed one, force or penetration, at an equal value of the other), with the "
        f"half-width of its bar ({WHERE}); verdict at the requested tolerance; cheapest setting "
        "within the tolerance, error bar included, among those that were run, with its measured "
        "time."
    )
    return replace(verdict_table(scenes, MODEL, reasons=False).without("at", TRUE), title=caption)


def methods_table(scene: SceneRecord) -> Table:
    """Return the verdicts on each method at its finest resolution, and refusals with reasons.

    One row per quantity, with the deciding load and step.
    """
    rows: list[tuple[Cell | str, ...]] = []
    refused = scene.unsupported
    for method in scene.methods:
        label = cells.method(method, scene=scene)
        if method in refused:
            if refused[method] != NOT_ASKED:
                rows.append((label, "", "", "", refused[method], cells.verdict("not run")))
            continue
        judged = [item for item in scene.verdicts_on(method) if item.word != NO_RESULT]
        if not judged:
            word = "reference" if method == scene.reference.method else NO_RESULT
            rows.append((label, "", "", "", "", cells.verdict(word)))
            continue
        time = cells.duration(scene.cost(method, judged[0].resolution).seconds)
        for index, item in enumerate(judged):
            setting = (label, cells.count(item.resolution), time) if index == 0 else ("", "", "")
            place = f"{quantity(item.quantity).label} ({item.where})"
            rows.append((*setting, place, cells.of_verdict(item), cells.verdict(item.word)))
    return table(("method", "N", "time", "quantity", "largest error", "verdict"), rows)


def others_table(scene: SceneRecord) -> Table:
    """Return what decides over each method that the page does not lead with; none of the truth."""
    rows, names = [], []
    for method, verdicts in scene.other_verdicts.items():
        decisive = worst(verdicts)
        time = cells.duration(scene.cost(method, decisive.resolution).seconds)
        setting = cells.method(method, scene=scene), cells.count(decisive.resolution), time
        rows.append((*setting, largest_error(scene, decisive), cells.verdict(decisive.word)))
        names.append(decisive.quantity)
    heads = ("method", "N", "time", "largest error", "verdict")
    title = "Other methods, on their finest grids"
    return table(heads, rows, title=title, note=_explained(names))


def measured_settings(advice: Advice) -> Table:
    """Return every setting measured for the advice, fastest first."""
    rows = (
        (
            cells.method(setting.method, ", ".join(filter(None, (setting.title, setting.bias)))),
            cells.number(str(setting.resolution), setting.resolution),
            cells.duration(setting.seconds),
            cells.verdict(setting.verdict),
            setting.deciding.text,
            cells.count(setting.cost.surfaces),
            cells.duration(setting.cost.single_seconds),
            setting.deciding.single,
        )
        for setting in advice.settings
    )
    chosen = (place for place, setting in enumerate(advice.settings) if setting is advice.cheapest)
    single = ("surfaces", "time of one", "of one, 5 to 95 %")
    heads = ("method", "N", "time", "verdict", "decided by", *single)
    title = "Measured settings, fastest first"
    whole = table(heads, rows, title=title, strong=frozenset(chosen))
    ensemble = any(setting.cost.surfaces > 1 for setting in advice.settings)
    return whole if ensemble else whole.without(*single)
