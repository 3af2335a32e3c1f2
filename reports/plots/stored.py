"""The stored fields that plots are made from, and the loads at which a slider shows them."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import dataclass

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import NORMAL, quantity
from comparisons.results.record import SceneRecord
from comparisons.tasks.shown_loads import shown_steps
from reports.plots.style import drawing_order, look

Fields = dict[str, np.ndarray]


@dataclass(frozen=True)
class Stored:
    """The fields of a method at its finest resolution, by name."""

    method: str
    resolution: int
    fields: Fields
    source: str  # whose fields these are, for a caption


def stored_fields(scene: SceneRecord, methods: Iterable[str] = ()) -> Iterator[Stored]:
    """Yield what each method has stored, read when asked for; by default in drawing order."""
    for method in methods or drawing_order(scene.methods):
        levels = [level for name, level in scene.fields if name == method]
        if levels:
            finest = max(levels)
            fields = scene.load_fields(method, finest)
            yield Stored(method, finest, fields, look(method, scene).at(finest))


def finest_fields(scene: SceneRecord, *names: str) -> Stored | None:
    """Return the reference's fields, or another method's, if they hold all names."""
    first = scene.reference.method
    methods = drawing_order(scene.methods)
    candidates = stored_fields(scene, sorted(methods, key=lambda name: name != first))
    return next((item for item in candidates if set(names) <= item.fields.keys()), None)


def at_last_load(scene: SceneRecord) -> str:
    """Return at which load something is drawn, for a caption: nothing where there is only one."""
    return "" if scene.of_one_load else " at the last load"


@dataclass(frozen=True)
class SliderSteps:
    """The load steps of a scene's slider, counted from zero, their labels, and what they are."""

    steps: tuple[int, ...]
    labels: tuple[str, ...]
    name: str = "load"


def slider_steps(scene: SceneRecord) -> SliderSteps:
    """Return the loads of the slider, or creeps; none for a single load, a path, a speed range."""
    rows = scene.solved
    steps = rows["step"]
    known = len(steps) and steps.min() >= 0 and steps.max() <= 10**6
    moved = scene.control in (*NORMAL, "creep", "lateral_creep") and not scene.is_path
    count = int(steps.max()) + 1 if known and moved else 0
    chosen = shown_steps(count)
    if len(chosen) < 2:
        return SliderSteps((), ())
    values = rows[scene.control]
    row = quantity(scene.control)
    step_name = "load" if scene.control in NORMAL else "step"
    labels = []
    for step in chosen:
        loads_of_step = values[(steps == step) & np.isfinite(values)]
        size = fmt.with_unit(loads_of_step[0], row.unit) if len(loads_of_step) else fmt.MISSING
        labels.append(f"{row.label} {size} ({step_name} {step + 1} of {count})")
    return SliderSteps(chosen, tuple(labels), step_name)
