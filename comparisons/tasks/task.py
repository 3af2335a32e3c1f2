"""One independent solve: what a method is given."""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from functools import cached_property
from typing import Generic, TypeVar

from comparisons.facts.methods import METHODS
from comparisons.geometry.prepare import Geometry
from comparisons.machine import source_digest, versions
from comparisons.scene.loading import AbsoluteLoads
from comparisons.scene.options import Options
from comparisons.scene.scene import Scene
from comparisons.tasks.stresses import FROM_PRESSURE

G = TypeVar("G", bound=Geometry, covariant=True)


@dataclass(frozen=True)
class Task(Generic[G]):
    """A method, a resolution, all loads, a block of realisations.

    Tasks are picklable and know their own key, which is what makes resuming, workers and
    clusters simple. `with_body` asks for displacement and stress in the body at the last load
    (pictures, VTU); they are computed outside the clock.
    """

    scene: Scene
    geometry: G
    loads: AbsoluteLoads
    method: str
    resolution: int
    quantities: tuple[str, ...]
    realisations: tuple[int, ...] = (0,)
    with_body: bool = False

    @property
    def shape(self) -> tuple[int, int]:
        """Numbers of realisations and of load steps."""
        return len(self.realisations), len(self.loads.values)

    @property
    def options(self) -> Options:
        """What the scene says to the method."""
        return self.scene.methods.of(self.method)

    @property
    def wants_pressure(self) -> bool:
        """Whether pressure fields are asked for: for a quantity, or for the picture."""
        return self.with_body or not FROM_PRESSURE.union({"pressure"}).isdisjoint(self.quantities)

    @cached_property
    def key(self) -> str:
        """A name that is the same exactly when the task, the code and its packages are the same."""
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
