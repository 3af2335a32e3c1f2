"""Where a method may be used: a row for each family of scenes, at most `MOST`.

The rows stand on the verdicts and settings that the cells of the report show; the page makes the
same rows (`findingOf` in judging.js) for another tolerance or fewer quantities.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM, MODEL, title_of
from comparisons.facts.quantities import in_order, quantity
from comparisons.judging.verdicts import LAST_LOAD, NO_RESULT, OUTSIDE, WITHIN, Verdict, worst
from comparisons.reasons import UNJUDGED
from comparisons.results.advice import Setting, advise
from comparisons.results.record import SceneRecord, depends_on_depth, once

MOST = 8  # rows: a reader has ten seconds
NAMED = 3  # families of a row that are named; more are counted
YES, IN_PART, NO, NOT_KNOWN = "yes", "in part", "no", "not known"
SMALL_SLOPES = "for small slopes only"
NOTHING = "none that was run is within"

# What of a flat face is its size.
AREAS = ("contact_area", "contact_area_raw", "contact_radius", "equivalent_radius")
# Families of scenes: what a reader asks about.
ROUND, FLAT, OTHER = "axisymmetric bodies", "flat punches that are not round", "other bodies"
LAYERED = "layered and graded half-spaces"
ELLIPSOIDS, ROUGH, FILES = "ellipsoids", "rough surfaces", "bodies from files"
# Physics first: what a scene adds to pressing says more of it than its shape does.
_BY_TABLE = {
    "dynamics": "impacts and pushes",
    "adhesion": "adhesive contacts",
    "sliding": "sliding over rubber",
    "rolling": "rolling contacts",
    "plasticity": "elastic-plastic contacts",
    "lubrication": "lubricated contacts",
    "wear": "contacts that wear",
    "friction": "contacts with friction",
    "viscoelastic": "rubber in time",
    "surface": ROUGH,
    "body": FILES,
}


@once
def family(record: SceneRecord) -> str:
    """Return the family of a scene, in the plural; rough ones under other physics apart."""
    named = [label for table, label in _BY_TABLE.items() if table in record.tables]
    deep = depends_on_depth(record.tables)
    if not named and not deep:
        indenter = record.scene.indenter if record.scene else None
        if indenter is None:
            return OTHER
        if indenter.axisymmetric:
            return ROUND
        return FLAT if indenter.flat else ELLIPSOIDS if indenter.shape == "ellipsoid" else OTHER
    name = named[0] if named else "bodies"
    if "surface" in record.tables and name != ROUGH:
        name = f"{name} on {ROUGH}"
    return f"{name} on {LAYERED}" if deep else name


@dataclass(frozen=True)
class FamilyRow:
    """One row."""

    scenes: str  # a family with its scenes, or several families
    use: str  # "yes", "for F, d only", "for small slopes only" (which no scene has), "no" ...
    error: str  # the largest error with its bar, quantity and load
    # Time of its cheapest setting within the tolerance, and how many times that is taken by the
    # fastest 3-D setting.
    cost: str
    # The closed form, if it is exact, else the fastest other setting within the tolerance.
    instead: str


@dataclass(frozen=True)
class _Standing:
    """What is found of a method on one scene, and settings that serve there; None without one."""

    scene: SceneRecord
    use: str
    kind: str  # the use, where it is one of few words
    decisive: Verdict | None
    own: Setting | None  # of the method itself
    instead: Setting | None  # the closed form, else the fastest of anything else
    solver: Setting | None  # the fastest 3-D solver


def deciding(record: SceneRecord) -> Verdict | None:
    """Return the verdict that decides over a scene: that of the method that its page leads with."""
    judgements = record.verdicts_on(record.judged_methods[0])
    return worst(judgements) if judgements else None


def methods_of(records: Sequence[SceneRecord]) -> list[str]:
    """Return the methods that a finding is made for: the model first, and those of the user."""
    named = dict.fromkeys(name for record in records for name in record.judged_methods)
    return sorted(named, key=lambda name: name != MODEL)


def finding(records: Sequence[SceneRecord], method: str = MODEL) -> list[FamilyRow]:
    """Return where a method holds, where not, and what to use there."""
    judged = [record for record in records if method in record.judged_methods]
    standings = [_standing(record, method) for record in judged]
    families = [family(item.scene) for item in standings]
    # the scenes of each row, families joined as far as they must be
    joined: tuple[Callable[[_Standing], tuple[str, str]], ...] = (
        lambda item: (family(item.scene), item.use),
        lambda item: ("" if item.use == YES else family(item.scene), item.use),
        lambda item: (family(item.scene) if item.kind == IN_PART else "", item.use),
        lambda item: ("", item.kind),
    )
    groups: dict[tuple[str, str], list[_Standing]] = {}
    for key in joined:
        groups = {}
        for item in standings:
            groups.setdefault(key(item), []).append(item)
        if len(groups) <= MOST:
            break
    rows = []
    for group in groups.values():
        uses = list(dict.fromkeys(item.use for item in group))
        # the error that decides over the scenes, with its quantity, scene and load
        largest = fmt.MISSING
        verdicts = [(item.decisive, item.scene) for item in group if item.decisive]
        if verdicts:
            decisive = worst(verdict for verdict, _ in verdicts)
            scene = next(scene for verdict, scene in verdicts if verdict is decisive)
            largest = largest_error(scene, decisive) + (f", {scene.name}" if group[1:] else "")
        instead = NOTHING
        chosen = [item.instead for item in group if item.instead]
        if chosen:
            exact = f"{title_of(CLOSED_FORM)} (exact)"
            titles = dict.fromkeys(
                exact if item.is_truth and item.method == CLOSED_FORM else item.starred
                for item in chosen
            )
            left = len(group) - len(chosen)
            instead = f"{' or '.join(titles)} {_range(chosen)}"
            instead += f"; none is within in {left} scene{'s' * (left > 1)}" if left else ""
        use = uses[0] if len(uses) == 1 else IN_PART
        if use not in (NO, NOT_KNOWN) and all(item.scene.too_steep for item in group):
            use = SMALL_SLOPES
        rows.append(FamilyRow(_named(group, families), use, largest, _cost(group), instead))
    return rows


def is_found(record: SceneRecord, verdict: Verdict) -> bool:
    """Tell whether a verdict is on what was found, not on a given area or worn volume."""
    given = AREAS if family(record) == FLAT else ()
    loading, wear = (record.tables.get(table, {}) for table in ("loading", "wear"))
    if "sliding_distance" in wear and not {"force", "pressure"}.isdisjoint(loading):
        given = (*given, "worn_volume")
    return verdict.counts and verdict.offered and verdict.quantity not in given


def unjudged(record: SceneRecord) -> list[str]:
    """Return the quantities that are compared, and that the reference does not compute."""
    missing = {item.quantity for item in record.verdicts if item.reason.startswith(UNJUDGED)}
    return [name for name in record.quantities if name in missing]


def _standing(record: SceneRecord, method: str) -> _Standing:
    known = [item for item in record.verdicts_on(method) if is_found(record, item)]
    held = in_order(item.quantity for item in known if item.word == WITHIN)
    within = list(map(symbol, held))
    if not within or record.by_chance(method):
        use = NO if any(item.word == OUTSIDE for item in known) else NOT_KNOWN
    else:
        whole = len(within) == len(known) and not unjudged(record)
        use = YES if whole else f"for {', '.join(within)} only"
    advice = advise(record)
    exact = (item for item in advice.settings if item.is_truth and item.method == CLOSED_FORM)
    others = [item for item in advice.reaching() if item.method != method]
    own = advice.cheapest_for(record.tolerance).get(method)
    kind = use if use in (YES, NO, NOT_KNOWN) else IN_PART
    if kind == IN_PART:  # the fastest that is within in all that it may be used for
        able = [
            setting
            for setting in advice.settings
            if setting.method == method
            and all(item.word == WITHIN for item in setting.verdicts if item.quantity in held)
        ]
        own = min(able, key=lambda setting: setting.seconds, default=None)
    if use == YES and own is None:  # it does not compute all that was asked
        level = record.finest(method)
        own = next(
            (s for s in advice.settings if (s.method, s.resolution) == (method, level)), None
        )
    decisive = worst(known) if known else None
    instead = next(exact, None) or next(iter(others), None)
    solver = next((item for item in others if item.solves_in_3d), None)
    return _Standing(record, use, kind, decisive, own, instead, solver)


def symbol(name: str) -> str:
    """Return the symbol of a quantity, or its name in words."""
    return quantity(name).symbol or quantity(name).label


def _named(group: list[_Standing], families: list[str]) -> str:
    """Return "ellipsoids: ellipsoid-2", "rough surfaces (3 of 4 scenes)", or several families."""
    names = list(dict.fromkeys(family(item.scene) for item in group))
    count = len(group)
    if count == 1:
        return f"{names[0]}: {group[0].scene.name}"
    if len(names) == 1:
        whole = families.count(names[0])
        return f"{names[0]} ({count}{'' if count == whole else f' of {whole}'} scenes)"
    more = f" and {len(names) - NAMED} more" if len(names) > NAMED else ""
    return f"{', '.join(names[:NAMED])}{more} ({count} scenes)"


def largest_error(scene: SceneRecord, verdict: Verdict, name: Callable[[str], str] = symbol) -> str:
    """Return an error with its bar, quantity and load: "A −2.1 ± 0.1 % at d = 1.00 µm"."""
    if verdict.word == NO_RESULT:
        return f"{name(verdict.quantity)}: {verdict.reason}"
    along, text = scene.along, f"{name(verdict.quantity)} {verdict.number}"
    placed = verdict.has_step and verdict.at != LAST_LOAD  # of which it counts one step, 0
    if placed and quantity(along).load and fmt.finite(verdict.resolution):
        rows = scene.rows
        own = (rows["step"] == verdict.step) & (rows["resolution"] == verdict.resolution)
        loads = rows[along][own]
        if len(loads) and fmt.finite(loads[0]):
            text += f" at {symbol(along)} = {fmt.with_unit(loads[0], quantity(along).unit)}"
            return text + verdict.lacking
    return (f"{text} at {verdict.when}" if verdict.when else text) + verdict.lacking


def _cost(group: list[_Standing]) -> str:
    own = [item.own for item in group if item.own]
    pairs = [
        (item.own, item.solver)
        for item in group
        if item.own and item.solver and item.own.seconds > 0 and fmt.finite(item.solver.seconds)
    ]
    ratios = [other.seconds / model.seconds for model, other in pairs]
    if not ratios:
        return _range(own)
    if max(ratios) < 1:
        solver = _range([other for _, other in pairs])
        return f"no need: the 3-D solver is cheaper ({solver} against {_range(own)})"
    # One digit: times of milliseconds repeat to some tens of per cent.
    ends = dict.fromkeys(fmt.number(ratio, 1) for ratio in (min(ratios), max(ratios)))
    return f"{_range(own)}, 3-D takes ≈ {' to '.join(ends)}\u00a0×"


def _range(settings: Sequence[Setting]) -> str:
    """Return the smallest and the largest time, with N if it is one; a dash without any."""
    ordered = sorted(settings, key=lambda setting: setting.seconds)
    if not ordered:
        return fmt.MISSING
    ends = [fmt.duration(setting.seconds) for setting in (ordered[0], ordered[-1])]
    levels = {setting.resolution for setting in ordered if setting.method != CLOSED_FORM}
    at = f" (N = {levels.pop()})" if len(levels) == 1 else ""
    return " to ".join(dict.fromkeys(ends)) + at
