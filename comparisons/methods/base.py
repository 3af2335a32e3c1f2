"""The contract between a study and a method: task in, solution out.

A method is one small class. It says whether it supports a scene, which resolutions it would
use, how much memory a task needs, and solves a task. It never raises for physics: a load step
that fails is a NaN row with its reason.
"""

from __future__ import annotations

import hashlib
import json
import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.machine import source_digest, versions
from comparisons.reasons import one_line
from comparisons.scene.options import Options
from comparisons.scene.physics.loads import Loads
from comparisons.scene.scene import Scene
from comparisons.tasks.shown_loads import shown_steps


@dataclass(frozen=True)
class Support:
    """Whether a method can do a scene, and why (not).

    A method from outside may be `broken`: it raised, hung or answered nonsense when it was asked.
    That is no refusal.
    """

    ok: bool
    reason: str = ""
    broken: bool = False


@dataclass(frozen=True)
class Task:
    """One independent solve: a method, a resolution, all loads, a block of realisations.

    Tasks are picklable and know their own key, which is what makes resuming, workers and
    clusters simple. `with_body` asks for displacement and stress in the body at the last load
    (pictures, VTU); they are computed outside the clock.
    """

    scene: Scene
    geometry: Geometry
    loads: Loads
    method: str
    resolution: int
    options: Options
    quantities: tuple[str, ...]
    realisations: tuple[int, ...] = (0,)
    with_body: bool = False

    @property
    def wants_pressure(self) -> bool:
        """Whether pressure fields are asked for."""
        return "pressure" in self.quantities

    @cached_property
    def key(self) -> str:
        """A name that is the same exactly when the task, the code and its packages are the same."""
        from comparisons.methods import METHODS

        identity = {
            "source": source_digest() + METHODS[self.method].identity,
            "versions": versions(),
            "scene": self.scene.model_dump(mode="json", exclude={"title", "compare", "methods"}),
            "geometry": self.geometry.digest,
            "loads": [float(v).hex() for v in self.loads.values],
            "options": self.options.model_dump(mode="json"),
            "quantities": sorted(self.quantities),
            "with_body": self.with_body,
            "realisations": list(self.realisations),
        }
        text = json.dumps(identity, sort_keys=True)
        digest = hashlib.sha256(text.encode()).hexdigest()[:12]
        first = self.realisations[0]
        return f"{self.scene.name}-{self.method}-{self.resolution}-{first}-{digest}"


@dataclass
class Solution:
    """What a method found, per realisation (axis 0) and load step (axis 1).

    Attributes
    ----------
    quantities : dict
        Name -> array (realisations, steps); NaN where a step failed. Names absent were not asked
        for or are not defined for the method.
    converged : ndarray of bool
    reasons : dict
        (realisation index, step) -> why it failed.
    iterations, violation : ndarray
        Solver iterations, and the largest relative overlap or tension (NaN for direct methods).
    fields : dict
        Arrays of realisation 0 at the last load: ``pressure``, ``pressure_x``, ...
    truncation : float
        Relative 95 % half-width of what a bounded domain leaves out, or of the place of an edge
        inside a cell (0: nothing of the kind).
    exact : tuple of str
        Quantities that no grid and no truncation touches: the area of a flat face.
    path : bool
        Steps follow each other along a path or in time: errors and bars are then relative to the
        largest value along it, because single values pass zero.
    step_fields : dict
        Load step -> function that returns the pressure of realisation 0 at it, for the steps of
        `shown_loads.shown_steps`; not part of the solve.
    body_fields : callable or None
        Computes the fields in the body, where a task asks for them; not part of the solve.
    unknowns : int
    machine : str
        Where it was found, in one short text; " + " between the machines of several blocks.
    seconds, setup_seconds, compile_seconds, memory : float
        Everything done for the task on warm code; the part another list of loads could reuse;
        compilation (apart); peak memory in bytes (NaN where it cannot be measured).
    """

    quantities: dict[str, np.ndarray]
    converged: np.ndarray
    iterations: np.ndarray
    violation: np.ndarray
    unknowns: int
    reasons: dict[tuple[int, int], str] = field(default_factory=dict)
    fields: dict[str, np.ndarray] = field(default_factory=dict)
    truncation: float = 0.0
    exact: tuple[str, ...] = ()
    path: bool = False
    step_fields: dict[int, Callable[[], dict[str, np.ndarray]]] = field(default_factory=dict)
    body_fields: Callable[[], dict[str, np.ndarray]] | None = None
    seconds: float = float("nan")
    setup_seconds: float = 0.0
    compile_seconds: float = 0.0
    memory: float = float("nan")
    machine: str = ""

    @classmethod
    def empty(cls, task: Task, unknowns: int = 0) -> Solution:
        """Return a solution to be filled step by step: nothing converged yet."""
        shape = (len(task.realisations), len(task.loads.values))
        return cls(
            quantities={},
            converged=np.zeros(shape, dtype=bool),
            iterations=np.zeros(shape, dtype=int),
            violation=np.full(shape, np.nan),
            unknowns=unknowns,
            path=task.loads.is_path,
        )

    def put(self, index: tuple[int, int], values: dict[str, float]) -> None:
        """Store the quantities of one converged step."""
        for name, value in values.items():
            if name not in self.quantities:
                self.quantities[name] = np.full(self.converged.shape, np.nan)
            self.quantities[name][index] = value
        self.converged[index] = True

    def keep(self, index: tuple[int, int], build: Callable[[], dict[str, np.ndarray]]) -> None:
        """Remember how to make the pressure of a load step, if it is one that is shown."""
        row, step = index
        if row == 0 and step in shown_steps(self.converged.shape[1]):
            self.step_fields[step] = build

    def fail(self, index: tuple[int, int], reason: str) -> None:
        """Record that one step has no answer, and why in one line."""
        self.reasons[index] = one_line(reason)

    @contextmanager
    def setup(self) -> Iterator[None]:
        """Count the time inside as set-up: the part that another list of loads would reuse."""
        start = time.perf_counter()
        try:
            yield
        finally:
            self.setup_seconds += time.perf_counter() - start


class Method:
    """Base of all methods; a new one overrides ``supports``, ``resolutions`` and ``solve``.

    ``dimension`` is 3 for a candidate of the truth, 1 for a model under test. ``physics`` names the
    tables that it covers all together, such as {"viscoelastic", "sliding"}; none of them by
    default. A class with the name of another method and some physics is that method's wiring of
    these scenes (`comparisons.methods.WIRINGS`). ``span`` is the
    largest ratio of the contact radii of an indenter's loads that one ``solve`` is given: loads
    over more decades come in several calls, each with a geometry sized for its own contacts.
    """

    name = ""
    title = ""
    dimension = 3
    physics: frozenset[str] = frozenset()
    span = 8.0
    # Cells of all realisations of a task up to which sharing a set-up among them is worth while:
    # beyond, smaller tasks lose less when they are killed, and spread better.
    shared_cells = math.inf
    # Runs its work in a process of its own, and says itself how long it took.
    isolated = False
    # Other people's code: it checks the reference, and is never the reference itself.
    peer = False
    # A user's code, untrusted: it is judged, and takes no part in what the truth is.
    external = False
    # Given by name for this command: where it breaks, that is an error and no reason to go on.
    given = False
    # What tells one version of such code from another.
    identity = ""

    def supports(self, scene: Scene) -> Support:
        """Say whether the method can do the scene, with the reason where not."""
        raise NotImplementedError

    def supports_body(self, geometry: BodyGeometry) -> Support:
        """Say whether the method can do a finite body with supports, too."""
        return Support(False, "models a half-space, and the [body] is finite")

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Return the resolutions that the scene's tolerance asks for, coarse to fine."""
        raise NotImplementedError

    def usual(self, planned: tuple[int, ...], geometry: Geometry) -> int:
        """Return the one resolution that a single solve uses: a synthetic surface's own points.

        Else the finest planned, which is the one that aims at the tolerance.
        """
        synthetic = isinstance(geometry, RoughGeometry) and geometry.recipe is not None
        return planned[0] if synthetic else planned[-1]

    def refused(self, task: Task) -> str:
        """Return why this resolution is out of reach ("" where it is not)."""
        return ""

    def memory(self, task: Task) -> float:
        """Estimate the peak memory of a task in bytes, before any is taken."""
        return 0.0

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Say in one sentence what is modelled."""
        raise NotImplementedError

    def warm_up(self, task: Task) -> None:
        """Compile whatever the task will need, so that no timing contains a compiler."""

    def solve(self, task: Task) -> Solution:
        """Solve all loads and realisations of a task."""
        raise NotImplementedError
