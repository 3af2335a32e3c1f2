"""The load slider: which load steps it has, and a plot's frame at each of them.

A frame holds what changes of each trace, in the order of the traces, and of the layout; the page
puts it over the figure when the slider moves. The last frame is the figure as it opens.
"""

from __future__ import annotations

import base64
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from comparisons import formatting as fmt
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from comparisons.scene.loading import NORMAL
from comparisons.tasks.shown_loads import shown_steps

_LARGEST_CODE = 2**16 - 1


@dataclass(frozen=True)
class Loads:
    """The load steps of a scene's slider, counted from zero, and what each is called."""

    steps: tuple[int, ...]
    labels: tuple[str, ...]


NO_LOADS = Loads((), ())


def loads_of(scene: SceneRecord) -> Loads:
    """Return the loads of the slider; none for a single load, a path, or over speeds."""
    if scene.control not in (*NORMAL, "mean_gap") or scene.is_path:
        return NO_LOADS
    rows = selection.solved(scene)
    steps = selection.column(rows, "step")
    if not len(steps) or steps.min() < 0 or steps.max() > 10**6:
        return NO_LOADS
    count = int(steps.max()) + 1
    chosen = shown_steps(count)
    if len(chosen) < 2:
        return NO_LOADS
    values = selection.column(rows, scene.control)
    known = fmt.quantity(scene.control)
    labels = []
    for step in chosen:
        here = values[(steps == step) & np.isfinite(values)]
        size = fmt.with_unit(here[0], known.unit) if len(here) else fmt.MISSING
        labels.append(f"{known.words} {size} (load {step + 1} of {count})")
    return Loads(chosen, tuple(labels))


def with_frames(spec: dict[str, Any], frames: Sequence[dict[str, Any]]) -> dict[str, Any]:
    """Return a figure with its frames; its own data are those of the last one."""
    return spec | {"frames": list(frames)}


def coded_map(values: np.ndarray, highest: float) -> dict[str, Any]:
    """Return a map of positive values (NaN: a gap) in 16-bit codes, a third of its JSON.

    One code is `highest`/65535; what is positive but smaller than half of it keeps code 1.
    """
    known = np.nan_to_num(values, nan=0.0)
    step = highest / _LARGEST_CODE if highest > 0 else 1.0
    codes = np.clip(np.round(known / step), np.where(known > 0, 1, 0), _LARGEST_CODE)
    text = base64.b64encode(codes.astype("<u2").tobytes()).decode()
    return {"codes": text, "shape": list(values.shape), "step": float(f"{step:.6g}")}
