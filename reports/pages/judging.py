"""The judgements of a study as data, so that the page can judge anew for another question.

The page gets the ends of what every error may be, |e| - u and |e| + u, and applies the one rule of
`comparisons.judging.verdicts` to another tolerance or to fewer quantities.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM, title_of
from comparisons.facts.quantities import in_order
from comparisons.judging.verdicts import NO_RESULT, Verdict
from comparisons.results import selection
from comparisons.results.advice import Advice, Setting
from comparisons.results.decisions import finest, judged_methods, verdicts
from comparisons.results.finding import answers, family, largest_error, symbol
from comparisons.results.store import SceneRecord
from reports.plots.style import look

# Tolerances that the slider offers; in the middle of a decade 2 and 5, as on every axis.
STEPS = (*(float(f"{step}e{power}") for power in range(-5, 0) for step in (1, 2, 5)), 1.0)


def judging(scenes: Sequence[tuple[str, SceneRecord, Advice]]) -> dict[str, Any]:
    """Return what the page needs to judge scenes (anchor, record, advice) anew.

    Of the judged methods the page leads with the first.
    """
    return {
        "tolerances": STEPS,
        "labels": [fmt.tolerance(step) for step in STEPS],
        "exact": f"{title_of(CLOSED_FORM)} (exact)",
        "scenes": [
            {
                "anchor": anchor,
                "name": scene.name,
                "family": family(scene),
                "order": in_order(scene.quantities),
                "tolerance": scene.tolerance,
                "judged": {
                    method: [_verdict(scene, verdict) for verdict in verdicts(scene, method)]
                    for method in judged_methods(scene)
                },
                "others": [
                    [_ends(verdict) for verdict in known.values()]
                    for known in others(scene).values()
                ],
                "lucky": sorted(advice.lucky),
                "settings": [_setting(setting, advice) for setting in advice.settings],
            }
            for anchor, scene, advice in scenes
        ],
    }


def others(scene: SceneRecord) -> dict[str, dict[str, Verdict]]:
    """Return the verdicts on the solvers that are not judged themselves, by their labels."""
    names = [name for name in selection.methods(scene) if name not in judged_methods(scene)]
    known = {name: verdicts(scene, name) for name in names if finest(scene, name) is not None}
    return {
        look(name, scene).label: {verdict.quantity: verdict for verdict in several}
        for name, several in known.items()
        if any(verdict.word != NO_RESULT for verdict in several)
    }


def _verdict(scene: SceneRecord, verdict: Verdict) -> dict[str, Any]:
    return _ends(verdict) | {
        "counts": answers(scene, verdict),
        "symbol": symbol(verdict.quantity),
        "text": verdict.text,
        "largest": largest_error(scene, verdict),
    }


def _ends(verdict: Verdict) -> dict[str, Any]:
    return {
        "quantity": verdict.quantity,
        "low": verdict.low,
        "high": verdict.high,
        "error": abs(verdict.error),
        "missing": verdict.word == NO_RESULT,
        "counts": verdict.counts,
    }


def _setting(setting: Setting, advice: Advice) -> dict[str, Any]:
    deepest = advice.finest.get(setting.method, -1)
    return {
        "method": setting.method,
        "title": setting.starred,
        "text": setting.brief,
        "time": fmt.duration(setting.seconds),
        "colour": look(setting.method).colour,
        "n": setting.resolution,
        "seconds": setting.seconds,
        "truth": setting.is_truth,
        # Beyond the finest grid that solved the most steps, a grid is no evidence.
        "judged": not setting.is_truth
        and setting.resolution <= deepest
        and setting.method not in advice.lucky,
        "finest": setting.resolution == deepest,
        "ranked": setting.method != CLOSED_FORM,
        "verdicts": [_ends(verdict) for verdict in setting.verdicts],
    }
