"""The methods under comparison, by name. Each is one small file with a fixed contract."""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.methods.bem_dense import BemDense
from comparisons.methods.bem_fft import BemFft
from comparisons.methods.closed_form import ClosedForm
from comparisons.methods.fem import Fem
from comparisons.methods.peer_fem import NgSolve
from comparisons.methods.peers import ContactMechanics, Tamaas
from comparisons.methods.reduced import Reduced
from comparisons.methods.user.external import registered
from comparisons.methods.user.function import method
from comparisons.scene.scene import Scene

_OWN = (ClosedForm(), Reduced(), BemDense(), BemFft(), Fem())
_PEERS = (Tamaas(), ContactMechanics(), NgSolve())
METHODS: dict[str, Method] = {each.name: each for each in (*_OWN, *_PEERS)}
METHODS |= registered()
# How our methods do scenes with physics: each covers exactly the tables of its `physics`.
WIRINGS: tuple[Method, ...] = tuple(
    wiring
    for name in sorted(module.name for module in iter_modules(__path__) if not module.ispkg)
    for wiring in getattr(import_module(f"{__name__}.{name}"), "WIRINGS", ())
)

__all__ = [
    "METHODS",
    "WIRINGS",
    "Method",
    "Solution",
    "Support",
    "Task",
    "covers",
    "method",
    "method_for",
]


def method_for(name: str, scene: Scene) -> Method:
    """Return what solves a scene under the name of a method: itself, or its wiring of the physics.

    Whether it can do the scene is asked with `covers` and then `Method.supports`.
    """
    if scene.physics:
        wanted = set(scene.physics)
        for wiring in WIRINGS:
            if wiring.name == name and wiring.physics == wanted:
                return wiring
    return METHODS[name]


def covers(name: str, scene: Scene) -> Support:
    """Say whether a method has all the physics of a scene, with what it lacks where not."""
    own = method_for(name, scene).physics
    missing = [f"[{each}]" for each in scene.physics if each not in own]
    if not missing:
        return Support(True)
    reason = f"does not model {' and '.join(missing)}"
    alone = {each for w in WIRINGS if w.name == name for each in w.physics} >= set(scene.physics)
    return Support(False, f"{reason} in one scene" if alone else reason)
