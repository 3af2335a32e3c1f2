"""The finding of a study in one sentence, made from its verdicts.

It says where the reduced model may be used and what that costs and saves, where not, and for each
family of scenes what to use there instead: a closed form where it is the truth itself, else the
fastest method. Words and numbers are those of `comparisons.results.decisions` and of the advice.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Sequence

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM, MODEL, title_of
from comparisons.facts.quantities import quantity
from comparisons.judging.verdicts import NO_RESULT, OUTSIDE, WITHIN
from comparisons.results.advice import Setting, advise
from comparisons.results.decisions import Verdict, judged_methods, verdicts, worst
from comparisons.results.families import family
from comparisons.results.store import SceneRecord

OWN = (MODEL, CLOSED_FORM)
EXACT = f"the {title_of(CLOSED_FORM)} (exact)"
NAMED = 3  # scenes of a family that are named; the others are counted


def deciding(record: SceneRecord) -> Verdict | None:
    """Return the verdict that decides over a scene: that of the method that its page leads with."""
    judgements = verdicts(record, judged_methods(record)[0])
    return worst(judgements) if judgements else None


def finding(records: tuple[SceneRecord, ...]) -> str:
    """Return where the leading method holds, where not, and what to use there, in a sentence."""
    return " ".join(lines(records))


def lines(records: tuple[SceneRecord, ...]) -> list[str]:
    """Return the finding, a line for each family of scenes: where the method holds, where not."""
    methods = {judged_methods(record)[0] for record in records}
    if len(methods) != 1:
        return []
    title = title_of(methods.pop())
    stated: dict[str, list[str]] = {"holds": [], "in part": [], "fails": [], "open": []}
    within: list[SceneRecord] = []
    for name in dict.fromkeys(map(family, records)):
        scenes = [record for record in records if family(record) == name]
        judged = {scene: item for scene in scenes if (item := deciding(scene))}
        stated[_kind(scenes, judged)].append(_in_words(name, scenes, judged))
        within += [scene for scene in scenes if _is_within(judged.get(scene))]
    heads = {
        "holds": (f"Use the {title} for ", f": within {_tolerances(within)}{_cost(within)}"),
        "in part": ("in part for " if stated["holds"] else f"Use the {title} in part for ", ""),
        "fails": ("not for " if within else f"Do not use the {title} for ", ""),
        "open": ("not shown for ", ""),
    }
    clauses = [_clause(*heads[kind], names) for kind, names in stated.items() if names]
    if not clauses:
        return []
    clauses[0][0] = clauses[0][0][0].upper() + clauses[0][0][1:]
    for clause in clauses:
        clause[-1] += "." if clause is clauses[-1] else ";"
    return [line for clause in clauses for line in clause]


def _clause(head: str, tail: str, names: Sequence[str]) -> list[str]:
    """Return a clause about several families, a line for each.

    >>> _clause("not for ", "", ["a", "b", "c"])
    ['not for a,', 'b and', 'c']
    """
    ends = [","] * (len(names) - 2) + [" and"] * (len(names) > 1) + [tail]
    own = [f"{name}{end}" for name, end in zip(names, ends, strict=True)]
    return [head + own[0], *own[1:]]


def _kind(scenes: Sequence[SceneRecord], judged: dict[SceneRecord, Verdict]) -> str:
    judgements = [item.word for item in judged.values()]
    if len(judgements) == len(scenes) and set(judgements) == {WITHIN}:
        return "holds"
    if WITHIN in judgements:
        return "in part"
    return "fails" if OUTSIDE in judgements else "open"


def _is_within(item: Verdict | None) -> bool:
    return item is not None and item.word == WITHIN


def _in_words(name: str, scenes: Sequence[SceneRecord], judged: dict[SceneRecord, Verdict]) -> str:
    """Return a family with its scenes, or with what decided in the worst and what to use there."""
    undecided = [item for item in judged.values() if item.word != WITHIN]
    if not undecided:
        exact = f"; the {title_of(CLOSED_FORM)} is exact" if all(map(_exact, scenes)) else ""
        return f"{name} ({_examples(scenes)}{exact})"
    wrong = [item for item in undecided if item.word == OUTSIDE]
    if wrong:
        last = max(wrong, key=lambda item: item.low / item.tolerance)
        upto = "up to " if len(wrong) > 1 else ""
        share = f" in {len(wrong)} of {len(judged)}" if len(wrong) < len(judged) else ""
        reason = f"{quantity(last.quantity).label} off by {upto}{last.number}{share}"
    else:
        last = worst(undecided)
        cause = last.reason if last.word == NO_RESULT else last.number
        reason = f"{quantity(last.quantity).label}: {cause}"
    others = [scene for scene in scenes if not _is_within(judged.get(scene))]
    return f"{name} ({reason}; {_instead(others)})"


def _examples(scenes: Sequence[SceneRecord]) -> str:
    """Return what a family consists of here: nothing else was looked at."""
    names = [scene.name for scene in scenes]
    left = len(names) - NAMED
    return fmt.listed(names if left < 2 else [*names[:NAMED], f"{left} more"])


def _cost(scenes: list[SceneRecord]) -> str:
    """Return time, and how many times faster than the fastest 3-D method at equal tolerance."""
    ratios, times = [], []
    for scene in scenes:
        reached = advise(scene).reaching()
        times += [item.seconds for item in reached if item.method == MODEL][:1]
        own = [item.seconds for item in reached if item.method in OWN]
        other = [item.seconds for item in reached if item.method not in OWN]
        if own and other and fmt.finite(own[0]) and fmt.finite(other[0]) and own[0] > 0:
            ratios.append(other[0] / own[0])
    cost = f" in {_ends(times, fmt.duration)}" if times else ""
    if not ratios:
        return cost
    gain = _ends(ratios, lambda ratio: fmt.number(ratio, 2))
    return f"{cost}, {gain} times as fast as the fastest 3-D method"


def _ends(values: Sequence[float], form: Callable[[float], str]) -> str:
    """Return the smallest and the largest value, or the one that both are."""
    return " to ".join(dict.fromkeys(form(value) for value in (min(values), max(values))))


def _instead(scenes: list[SceneRecord]) -> str:
    """Return closed forms, or the fastest methods with their times, of scenes the model fails."""
    exact = [form for scene in scenes if (form := _exact(scene))]
    best = [advise(scene).cheapest for scene in scenes if not _exact(scene)]
    chosen = [item for item in best if item is not None]
    titles = Counter(item.title for item in chosen).most_common()
    named = [_timed(EXACT, exact)] if exact else []
    named += [
        _timed(title, [item for item in chosen if item.title == title]) for title, _ in titles
    ]
    if not named:
        return "no setting that was run is within the tolerance"
    left = len(best) - len(chosen)
    none = f", nothing that was run in {left} of {len(scenes)}" if left else ""
    which = ", depending on the scene" if len(named) > 1 else ""
    return f"instead {' or '.join(named)}{which}{none}"


def _exact(scene: SceneRecord) -> Setting | None:
    """Return the closed form of a scene, if it is the truth."""
    settings = advise(scene).settings
    return next((item for item in settings if item.is_truth and item.method == CLOSED_FORM), None)


def _timed(title: str, settings: list[Setting]) -> str:
    return f"{title} in {_ends([item.seconds for item in settings], fmt.duration)}"


def _tolerances(scenes: list[SceneRecord]) -> str:
    tolerances = sorted({scene.tolerance for scene in scenes})
    return " or ".join(fmt.tolerance(value) for value in tolerances)
