"""The methods under comparison, by name. Each is one small file with a fixed contract."""

from __future__ import annotations

from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.methods.bem_dense import BemDense
from comparisons.methods.bem_fft import BemFft
from comparisons.methods.closed_form import ClosedForm
from comparisons.methods.external import registered
from comparisons.methods.fem import Fem
from comparisons.methods.function import method
from comparisons.methods.peer_fem import NgSolve
from comparisons.methods.peers import ContactMechanics, Tamaas
from comparisons.methods.reduced import Reduced

_OWN = (ClosedForm(), Reduced(), BemDense(), BemFft(), Fem())
_PEERS = (Tamaas(), ContactMechanics(), NgSolve())
METHODS: dict[str, Method] = {each.name: each for each in (*_OWN, *_PEERS)}
METHODS |= registered()

__all__ = ["METHODS", "Method", "Solution", "Support", "Task", "method"]
