"""The finding of a study in one sentence, made from its verdicts.

It says where the reduced model may be used and what that saves, where not and what to use there
instead. Words and numbers are those of `comparisons.results.decisions` and of the advice.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Sequence

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM, MODEL, title_of
from comparisons.facts.quantities import quantity
from comparisons.judging.verdicts import NO_RESULT, OUTSIDE, WITHIN
from comparisons.results.advice import Setting, advise
from comparisons.results.decisions import Verdict, judged_methods, verdicts, worst
from comparisons.results.families import family
from comparisons.results.store import SceneRecord

OWN = (MODEL, CLOSED_FORM)


def deciding(record: SceneRecord) -> Verdict | None:
    """Return the verdict that decides over a scene: that of the method that its page leads with."""
    judgements = verdicts(record, judged_methods(record)[0])
    return worst(judgements) if judgements else None


def finding(records: tuple[SceneRecord, ...]) -> str:
    """Return where the leading method holds, where not, and what to use there, in a sentence."""
    methods = {judged_methods(record)[0] for record in records}
    if len(methods) != 1:
        return ""
    title = title_of(methods.pop())
    stated: dict[str, list[str]] = {"holds": [], "in part": [], "fails": [], "open": []}
    within: list[SceneRecord] = []
    others: list[SceneRecord] = []
    for name in dict.fromkeys(map(family, records)):
        scenes = [record for record in records if family(record) == name]
        judged = {scene: item for scene in scenes if (item := deciding(scene))}
        stated[_kind(scenes, judged)].append(_in_words(name, judged))
        good = [scene for scene, item in judged.items() if item.word == WITHIN]
        within += good
        others += [scene for scene in scenes if scene not in good]
    heads = {
        "holds": f"Use the {title} for {{}}: within {_tolerances(within)}{_gain(within)}",
        "in part": "in part for {}" if stated["holds"] else f"Use the {title} in part for {{}}",
        "fails": "not for {}" if within else f"Do not use the {title} for {{}}",
        "open": "not shown for {}",
    }
    parts = [heads[kind].format(_listed(names)) for kind, names in stated.items() if names]
    if not parts:
        return ""
    text = "; ".join(filter(None, [*parts, _instead(others)])) + "."
    return text[0].upper() + text[1:]


def _kind(scenes: Sequence[SceneRecord], judged: dict[SceneRecord, Verdict]) -> str:
    judgements = [item.word for item in judged.values()]
    if len(judgements) == len(scenes) and set(judgements) == {WITHIN}:
        return "holds"
    if WITHIN in judgements:
        return "in part"
    return "fails" if OUTSIDE in judgements else "open"


def _in_words(name: str, judged: dict[SceneRecord, Verdict]) -> str:
    """Return a family with the error or the reason that decided, the worst of its scenes."""
    undecided = [item for item in judged.values() if item.word != WITHIN]
    if not undecided:
        return name
    wrong = [item for item in undecided if item.word == OUTSIDE]
    if not wrong:
        last = worst(undecided)
        reason = last.reason if last.word == NO_RESULT else last.number
        return f"{name} ({quantity(last.quantity).label}: {reason})"
    last = max(wrong, key=lambda item: item.low / item.tolerance)
    upto = "up to " if len(wrong) > 1 else ""
    share = f" in {len(wrong)} of {len(judged)}" if len(wrong) < len(judged) else ""
    return f"{name} ({quantity(last.quantity).label} off by {upto}{last.number}{share})"


def _gain(scenes: list[SceneRecord]) -> str:
    """Return how many times faster than the fastest 3-D method, at the same tolerance."""
    ratios = []
    for scene in scenes:
        reached = advise(scene).reaching()
        own = [item.seconds for item in reached if item.method in OWN]
        other = [item.seconds for item in reached if item.method not in OWN]
        if own and other and fmt.finite(own[0]) and fmt.finite(other[0]) and own[0] > 0:
            ratios.append(other[0] / own[0])
    if not ratios:
        return ""
    ends = list(dict.fromkeys(fmt.number(ratio, 2) for ratio in (min(ratios), max(ratios))))
    return f", {' to '.join(ends)} times as fast as the fastest 3-D method"


def _instead(scenes: list[SceneRecord]) -> str:
    """Return the fastest methods of scenes that the model is not sure of, with their times."""
    best = [advise(scene).cheapest for scene in scenes]
    chosen = [item for item in best if item is not None]
    if not chosen:
        return "no setting that was run is within the tolerance there" if scenes else ""
    titles = Counter(item.title for item in chosen).most_common()
    named = [_timed(title, [item for item in chosen if item.title == title]) for title, _ in titles]
    left = len(scenes) - len(chosen)
    none = f" (nothing that was run will do in {left} of {len(scenes)} scenes)" if left else ""
    return f"use {_listed(named)} instead{none}"


def _timed(title: str, settings: list[Setting]) -> str:
    seconds = sorted(item.seconds for item in settings)
    ends = list(dict.fromkeys(fmt.duration(value) for value in (seconds[0], seconds[-1])))
    return f"{title} ({' to '.join(ends)})"


def _tolerances(scenes: list[SceneRecord]) -> str:
    tolerances = sorted({scene.tolerance for scene in scenes})
    return " or ".join(fmt.tolerance(value) for value in tolerances)


def _listed(names: Sequence[str]) -> str:
    """Return "a, b and c"; names that hold commas themselves are parted by semicolons.

    >>> _listed(["a", "b", "c"]), _listed(["a"])
    ('a, b and c', 'a')
    """
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} and {names[-1]}"
