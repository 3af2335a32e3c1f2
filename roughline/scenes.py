"""Scenes and plans: inspection of a study before it is solved."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from comparisons.methods.user.external import brought
from comparisons.scene.scene import Scene, parse_scene
from comparisons.scene.scene import load_scene as _load_scene
from comparisons.solving.plan import Plan as ScenePlan
from comparisons.solving.planning import Source, plan_scene, with_brought
from reports.tables.lists import scenes
from reports.tables.runs import plan as plan_table
from reports.tables.written import frame
from roughline import notebook


def load_scene(source: Source, changes: Mapping[str, Any] | None = None) -> Scene:
    """Return a validated scene.

    InputError lists all errors with their place in the scene.

    Parameters
    ----------
    source : str, Path, mapping or Scene
        The name of a built-in scene (`list_scenes`), the path of a TOML file, TOML text of several
        lines, its tables as a dict, or a scene to be modified.
    changes : mapping, optional
        Dotted key -> value: ``{"indenter.radius": "5 mm", "compare.tolerance": 0.05}``.

    Returns
    -------
    Scene
        All quantities in SI units; ``scene.text`` is the scene as TOML.

    Examples
    --------
    >>> scene = load_scene("paraboloid", {"indenter.radius": "5 mm"})
    >>> scene.indenter.radius
    0.005
    >>> punch = load_scene({
    ...     "name": "my-punch",
    ...     "half_space": {"youngs_modulus": "3 GPa", "poisson_ratio": 0.4},
    ...     "indenter": {"shape": "cylinder", "radius": "1 mm"},
    ...     "loading": {"penetration": ["1 um", "2 um"]},
    ... })
    >>> round(punch.effective_modulus / 1e9, 3)
    3.571
    """
    if isinstance(source, str) and "\n" in source:
        return parse_scene(source, "the scene's text", Path.cwd(), changes)
    return _load_scene(source, changes)


def list_scenes() -> pd.DataFrame:
    """Return the built-in scenes with their titles and suites.

    Examples
    --------
    >>> "paraboloid" in list_scenes().index
    True
    """
    return frame(scenes()).set_index("name")


@dataclass(frozen=True, repr=False)
class Plan:
    """The plan of a scene: model and resolutions of each method, and everything left out.

    Attributes
    ----------
    plans : list of comparisons.solving.plan.Plan
        One, or two with "bem_dense" on a map too large for it: the second is a patch.
    """

    plans: list[ScenePlan]

    @property
    def left_out(self) -> dict[str, str]:
        """Effects that are not modelled, with the reasons."""
        return {effect: reason for plan in self.plans for effect, reason in plan.left_out}

    @property
    def notes(self) -> list[str]:
        """Notes on choices and properties, such as the size and roughness of a surface."""
        return list(dict.fromkeys(note for plan in self.plans for note in plan.notes))

    def table(self) -> pd.DataFrame:
        """Return one row per scene and method: supported, resolutions, and the plan or reason."""
        rows = [
            {
                "scene": plan.scene.name,
                "method": method.method,
                "supported": method.supported,
                "resolutions": method.resolutions,
                "plan": method.modelled if method.supported else method.reason,
            }
            for plan in self.plans
            for method in plan.methods
        ]
        return pd.DataFrame(rows)

    def __repr__(self) -> str:
        return "\n".join([self.table().to_string(index=False), *self.notes])

    def _repr_html_(self) -> str:
        left = [
            f"Left out: {effect} \N{EN DASH} {reason}." for effect, reason in self.left_out.items()
        ]
        planned = [plan_table(plan) for plan in self.plans]
        heading = ", ".join(table.title for table in planned)
        return notebook.block(heading, *map(notebook.table, planned), *left, *self.notes)


def plan(scene: Source, *methods: str, full: bool = False) -> Plan:
    """Return what a comparison would model and leave out, without solving.

    InputError if the scene is invalid or does not fit into memory.

    Parameters
    ----------
    scene : Source
        Anything that `load_scene` takes.
    *methods : str
        Only these; default: all that can solve the scene.
    full : bool
        As many surfaces and grids as `roughline run --full` begins with.

    Examples
    --------
    >>> plan("paraboloid", "closed_form", "reduced").table().query("supported").method.tolist()
    ['closed_form', 'reduced']
    """
    return Plan(plan_scene(scene_of(scene, methods), "full" if full else "quick"))


def scene_of(source: Source, methods: tuple[str, ...], **compare: Any) -> Scene:
    """Load a scene with the methods and [compare] keys of a call."""
    changes = {f"compare.{key}": value for key, value in compare.items() if value is not None}
    if methods:
        changes["compare.methods"] = list(methods)
    scene = load_scene(source, changes)
    return scene if methods else with_brought(scene, brought())
