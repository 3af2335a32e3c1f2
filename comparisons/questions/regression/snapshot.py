"""Snapshot of a model and its references: curves, agreement and speed; measured, kept as JSON."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Mapping
from itertools import combinations
from pathlib import Path
from typing import Unpack

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, ValidationError

from comparisons.errors import InputError
from comparisons.facts.methods import GRID, INDEPENDENT, METHODS, MODEL, method_named
from comparisons.facts.quantities import quantity
from comparisons.files import write_named_text
from comparisons.judging.levels import Levels
from comparisons.judging.truth import truths
from comparisons.machine import machine_text
from comparisons.methods.registry import solver_of
from comparisons.methods.runner import run
from comparisons.questions.benchmarks.yardstick import interleaved, measurement
from comparisons.questions.campaign import Campaign, Options, Watch
from comparisons.results.folder import Header
from comparisons.scene.problems import first_problems
from comparisons.scene.scene import SINGLE, Scene, load_scene
from comparisons.solving.inquiries import Inquiry, curves
from comparisons.solving.plan import Plan
from comparisons.solving.planning import plan_scene
from comparisons.tasks.solution import Solved

# Made by `roughline check --update --baseline FILE`; a regression baseline, from our own output.
PACKAGED = Path(__file__).with_name("baseline.json")
LARGEST_FILE = 20_000_000
CHECK_SCENES = (*SINGLE, "rough-periodic")
REALISATIONS = 3
YARDSTICK = "np.argsort of 1e5 numbers"
Curve = list[float | None]


class _Form(BaseModel):
    model_config = ConfigDict(frozen=True, extra="forbid", allow_inf_nan=False)


class Curves(_Form):
    """Quantities of a method over the loads, as means over realisations; None for failed steps."""

    resolution: int
    quantities: dict[str, Curve]

    def array(self, name: str) -> np.ndarray:
        """Return a quantity as an array, NaN for missing values."""
        return np.array([np.nan if v is None else v for v in self.quantities[name]])


class Speed(_Form):
    """Seconds of the model, of the yardstick measured in turns with it, and their ratio."""

    seconds: float = Field(gt=0)
    yardstick_seconds: float = Field(gt=0)
    ratio: float = Field(gt=0)


class SceneSnapshot(_Form):
    """One scene: the judged model, the references by name, and their agreement.

    ``alone`` lists references that differ from all others while those agree among themselves.
    ``scene`` identifies the problem ("" in old baselines).
    """

    scene: str = ""
    loads: list[float]
    model: Curves | None
    references: dict[str, Curves]
    disagreements: list[str]
    alone: list[str]
    speed: Speed | None


class Snapshot(_Form):
    """All scenes of a check, with the machine and versions."""

    format: int = Field(default=1, ge=1, le=1)
    method: str
    created: str
    machine: str
    versions: dict[str, str]
    scenes: dict[str, SceneSnapshot]


class Measurements(Campaign[SceneSnapshot, Snapshot]):
    """Campaign that solves scenes by the judged method and the references, without a folder.

    Parameters
    ----------
    method : str
        Name of a registered method.
    scenes : iterable of str
        Names of built-in scenes or scene files.
    **options
        As in `Campaign`.

    Raises
    ------
    InputError
        If the method or a scene is wrong.
    """

    def __init__(self, method: str, scenes: Iterable[str], **options: Unpack[Options]) -> None:
        super().__init__(**options)
        self.method = method = method_named(method)
        self.plans = [_plan(source, method) for source in scenes]

    def inquiries(self) -> dict[str, Inquiry[SceneSnapshot]]:
        """Return one inquiry per scene."""
        return {plan.scene.name: scene_snapshot(plan, self.method) for plan in self.plans}

    def answer(self, header: Header, answers: Mapping[str, SceneSnapshot]) -> Snapshot:
        """Return the snapshots of the measured scenes."""
        return Snapshot(
            method=self.method,
            created=header.created,
            machine=machine_text(header.machine),
            versions=header.versions,
            scenes={
                plan.scene.name: answers[plan.scene.name]
                for plan in self.plans
                if plan.scene.name in answers
            },
        )


def take_snapshot(
    method: str = MODEL,
    scenes: Iterable[str] = CHECK_SCENES,
    watch: Watch | None = None,
) -> Snapshot:
    """Solve scenes with the judged method and the references in this process.

    Raises
    ------
    InputError
        If the method or a scene is wrong.
    """
    return Measurements(method, scenes, watch=watch).run()


def _plan(source: str, method: str) -> Plan:
    changes: dict[str, object] = {"compare.methods": [*INDEPENDENT, method]}
    scene = load_scene(source, changes)
    if scene.surface is not None:
        # Finite elements would take most of the time, and solve a patch, which is another problem.
        changes["compare.methods"] = [GRID, method]
        changes["surface.realisations"] = REALISATIONS
        scene = load_scene(source, changes)
    return plan_scene(scene)[0]


def scene_snapshot(plan: Plan, method: str) -> Inquiry[SceneSnapshot]:
    """Solve a scene by the judged method and the references, and time the method."""
    solved = yield from curves(plan)
    references = [truth for truth in truths(solved, plan.loads.axis) if truth.method != method]
    disagreements: list[str] = []
    against: dict[str, set[str]] = {truth.method: set() for truth in references}
    for first, second in combinations(references, 2):
        sentences = first.disagrees(second, plan.scene.compare.quantities)
        disagreements += sentences
        if sentences:
            against[first.method].add(second.method)
            against[second.method].add(first.method)
    opponents = len(references) - 1
    alone = [name for name, foes in against.items() if opponents >= 2 and len(foes) == opponents]
    return SceneSnapshot(
        scene=identity(plan.scene),
        loads=[float(value) for value in plan.loads.values],
        model=_curves(solved, method),
        references={
            truth.method: means
            for truth in references
            if (means := _curves(solved, truth.method)) is not None
        },
        disagreements=disagreements,
        alone=alone if len(alone) == 1 else [],  # if all disagree, none stands alone
        speed=_speed(plan, method),
    )


def identity(scene: Scene) -> str:
    """Return the identity of a problem: its scene file without names and methods."""
    tables = scene.model_dump(
        mode="json", exclude_defaults=True, exclude={"name", "title", "compare", "methods"}
    )
    return hashlib.sha256(json.dumps(tables, sort_keys=True).encode()).hexdigest()[:16]


def _curves(solved: Solved, method: str) -> Curves | None:
    levels = Levels.of(solved, method)
    resolution = levels.finest
    if resolution is None:
        return None
    means = levels.curves(resolution)
    return Curves(
        resolution=resolution,
        quantities={
            name: [float(v) if np.isfinite(v) else None for v in values]
            for name, values in means.items()
            if not quantity(name).signed
        },
    )


def _speed(plan: Plan, method: str) -> Speed | None:
    """Time the finest task of the model in turns with the yardstick.

    Methods in separate processes are not timed, because the start of the process would count.
    """
    tasks = [task for task in plan.tasks if task.method == method]
    if not tasks or METHODS[method].isolated:
        return None
    solver = solver_of(tasks[-1])
    numbers = np.random.default_rng(0).random(100_000)
    readings = interleaved(
        {
            "model": lambda: run(solver, tasks[-1]),
            YARDSTICK: lambda: np.argsort(numbers),
        }
    )
    row = measurement(method, readings["model"], YARDSTICK, readings[YARDSTICK])
    assert row.yardstick_seconds is not None
    assert row.ratio is not None
    return Speed(seconds=row.seconds, yardstick_seconds=row.yardstick_seconds, ratio=row.ratio)


def load_baseline(path: Path) -> Snapshot:
    """Read a baseline.

    Raises
    ------
    InputError
        If it is missing or damaged, with the first invalid entries.
    """
    try:
        if path.stat().st_size > LARGEST_FILE:
            raise InputError(f"{path}: expected a baseline, got a file above {LARGEST_FILE} bytes")
        return Snapshot.model_validate_json(path.read_bytes())
    except OSError as error:
        raise InputError(
            f"{path}: no baseline can be read here ({error.strerror}); --update writes one"
        ) from error
    except ValidationError as error:
        places = first_problems(error, "the file")
        raise InputError(f"{path}: not a baseline of roughline: {places}") from error


def save_baseline(path: Path, snapshot: Snapshot) -> None:
    """Write a baseline atomically, one curve per line for readable diffs."""
    write_named_text(path, snapshot.model_dump_json(indent=1) + "\n")
