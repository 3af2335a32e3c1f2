"""The judgements of a study as data, so that the page can judge anew for another question.

The page gets the ends of what every error may be, |e| - u and |e| + u, and applies the one rule of
`comparisons.judging.verdicts` to another tolerance or to fewer quantities.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM
from comparisons.judging.verdicts import NO_RESULT
from comparisons.results.advice import Advice, Setting
from comparisons.results.decisions import Verdict
from comparisons.results.store import SceneRecord
from reports.plots.style import look

# Tolerances that the slider offers; in the middle of a decade 2 and 5, as on every axis.
STEPS = (*(float(f"{step}e{power}") for power in range(-5, 0) for step in (1, 2, 5)), 1.0)


def slider_labels() -> list[str]:
    """Return the labels of the slider's tolerances."""
    return [fmt.tolerance(step) for step in STEPS]


def judging(scenes: Iterable[tuple[str, SceneRecord, list[Verdict], Advice]]) -> dict[str, Any]:
    """Return what the page needs to judge anew.

    Parameters
    ----------
    scenes : iterable of (str, SceneRecord, list of Verdict, Advice)
        Anchor, record, the verdicts that the page leads with, and the advice.
    """
    return {
        "tolerances": STEPS,
        "labels": slider_labels(),
        "scenes": [
            {
                "anchor": anchor,
                "tolerance": scene.tolerance,
                "verdicts": [_verdict(v) | {"counts": v.counts and v.offered} for v in verdicts],
                "settings": [_setting(setting, advice) for setting in advice.settings],
            }
            for anchor, scene, verdicts, advice in scenes
        ],
    }


def _verdict(verdict: Verdict) -> dict[str, Any]:
    return {
        "quantity": verdict.quantity,
        "low": verdict.low,
        "high": verdict.high,
        "error": abs(verdict.error),
        "missing": verdict.word == NO_RESULT,
        "counts": verdict.counts,
        "text": verdict.text,
        "number": verdict.number,
    }


def _setting(setting: Setting, advice: Advice) -> dict[str, Any]:
    deepest = advice.finest.get(setting.method, -1)
    return {
        "method": setting.method,
        "text": setting.brief,
        "colour": look(setting.method).colour,
        "n": setting.resolution,
        "seconds": setting.seconds,
        "truth": setting.is_truth,
        # Beyond the finest grid that solved the most steps, a grid is no evidence.
        "judged": not setting.is_truth and setting.resolution <= deepest,
        "finest": setting.resolution == deepest,
        "ranked": setting.method != CLOSED_FORM,
        "verdicts": [
            {
                name: item
                for name, item in _verdict(verdict).items()
                if name not in ("text", "number")
            }
            for verdict in setting.verdicts
        ],
    }
