"""Loading and planning of scenes and suites, with all problems reported at once."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from comparisons.errors import InputError
from comparisons.scene.scene import Scene, SceneError, load_scene
from comparisons.scene.suites import SUITES
from comparisons.solving.planning import Effort, Plan, plan_scene

Source = str | Path | Mapping[str, Any] | Scene


def plan_all(
    sources: Iterable[Source],
    overrides: Mapping[str, Any],
    effort: Effort,
    origin: str = "--methods, --option",
) -> list[Plan]:
    """Load and plan all scenes and suites.

    Parameters
    ----------
    sources : iterable of str, Path, mapping or Scene
        Anything that `load_scene` takes, and names of suites.
    overrides : mapping
        Dotted keys put into every scene.
    effort : {"quick", "full"}
    origin : str
        Where the overrides come from, for messages about them.

    Raises
    ------
    InputError
        Listing every problem of all scenes, or the scenes that no method can do.
    """
    try:
        # On a scene that is right, only what is added can be wrong: told once.
        load_scene("paraboloid", overrides)
    except SceneError as error:
        raise SceneError(origin, error.problems) from error
    plans: list[Plan] = []
    problems: list[str] = []
    for source in _members(sources):
        try:
            plans += plan_scene(load_scene(source, overrides), effort)
        except InputError as error:
            problems.append(str(error))
    if not plans and not problems:
        problems.append("expected at least one scene")
    names = [plan.scene.name for plan in plans]
    problems += [
        f"{name}: expected different names, two scenes have this one"
        for name in sorted({n for n in names if names.count(n) > 1})
    ]
    problems += _unsolvable(plans)
    if problems:
        raise InputError("\n".join(problems))
    return plans


def refuse_unsolvable(plans: Sequence[Plan]) -> None:
    """Raise InputError for scenes that no method can do, with the reason of every method."""
    if problems := _unsolvable(plans):
        raise InputError("\n".join(problems))


def _unsolvable(plans: Sequence[Plan]) -> list[str]:
    """Name the scenes for which no method plans anything: there is nothing to compare.

    Where [compare] methods or --methods leave a scene none, that is told only if they leave every
    scene none: of a suite they may pick what they can do.
    """
    empty = [plan for plan in plans if not any(method.supported for method in plan.methods)]
    return [
        f"{plan.scene.name}: {_why_none(plan)}"
        for plan in empty
        if plan.scene.compare.methods is None or len(empty) == len(plans)
    ]


def _why_none(plan: Plan) -> str:
    """Return why no method does a scene, methods with the same reason together."""
    methods = plan.scene.compare.methods
    reasons: dict[str, list[str]] = {}
    for method in plan.methods:
        if methods is None or method.method in methods:
            reasons.setdefault(method.reason, []).append(method.method)
    refusals = "".join(f"\n  {', '.join(names)}: {reason}" for reason, names in reasons.items())
    return f"no method{'' if methods is None else ' asked for'} can solve this scene{refusals}"


def _members(sources: Iterable[Source]) -> list[Source]:
    """Return the scenes, with suites replaced by theirs."""
    scenes: list[Source] = []
    for source in sources:
        scenes += SUITES.get(source, (source,)) if isinstance(source, str) else (source,)
    return scenes
