"""The load slider: its load steps, or creeps, and their labels."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import NORMAL, quantity
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from comparisons.tasks.shown_loads import shown_steps


@dataclass(frozen=True)
class SliderSteps:
    """The load steps of a scene's slider, counted from zero, their labels, and what they are."""

    steps: tuple[int, ...]
    labels: tuple[str, ...]
    name: str = "load"


NO_STEPS = SliderSteps((), ())


def slider_steps(scene: SceneRecord) -> SliderSteps:
    """Return the loads of the slider, or creeps; none for a single load, a path, a speed range."""
    if scene.control not in (*NORMAL, "creep", "lateral_creep") or scene.is_path:
        return NO_STEPS
    rows = selection.solved(scene)
    steps = selection.column(rows, "step")
    if not len(steps) or steps.min() < 0 or steps.max() > 10**6:
        return NO_STEPS
    count = int(steps.max()) + 1
    chosen = shown_steps(count)
    if len(chosen) < 2:
        return NO_STEPS
    values = selection.column(rows, scene.control)
    row = quantity(scene.control)
    step_name = "load" if scene.control in NORMAL else "step"
    labels = []
    for step in chosen:
        loads_of_step = values[(steps == step) & np.isfinite(values)]
        size = fmt.with_unit(loads_of_step[0], row.unit) if len(loads_of_step) else fmt.MISSING
        labels.append(f"{row.label} {size} ({step_name} {step + 1} of {count})")
    return SliderSteps(chosen, tuple(labels), step_name)
