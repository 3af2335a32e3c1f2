"""One row per method: what it is called, what it solves, and how far it may lead.

Light: scenes are read and methods listed without any solver. Methods from outside add their rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from importlib import import_module
from typing import Literal


@dataclass(frozen=True)
class Method:
    """What is known of a method without asking it.

    Attributes
    ----------
    title : str
        The words in reports.
    dimension : int
        3 for a candidate of the truth, 1 for a model under test.
    preference : float
        Among candidates of equal or unknown bars the least one is the truth.
    exact : bool
        A closed form: nothing is discretised.
    grid : bool
        A half-space on a grid of cells: two of them have the same error on the same grid.
    growth : float
        Factor of the work when the resolution doubles: grids go with N^2 log N and more
        iterations, meshes with N^5, dense matrices with N^6.
    origin : {"own", "peer", "outside"}
        Other people's code (peer) checks the reference, and is never the reference itself. A
        user's (outside) is untrusted: it is judged, and takes no part in what the truth is.
    isolated : bool
        It works in a process of its own, and says itself how long it took.
    identity : str
        What tells one version of code from outside from another.
    """

    title: str
    dimension: int = 3
    preference: float = math.inf
    exact: bool = False
    grid: bool = False
    growth: float = 6.0
    origin: Literal["own", "peer", "outside"] = "own"
    isolated: bool = False
    identity: str = ""

    @property
    def peer(self) -> bool:
        """Whether it is other people's code, to check ours."""
        return self.origin == "peer"

    @property
    def user_made(self) -> bool:
        """Whether it is a user's."""
        return self.origin == "outside"


BUILT_IN: dict[str, Method] = {
    "closed_form": Method("closed form", preference=0, exact=True),
    "reduced": Method("reduced model", dimension=1),
    "bem_dense": Method("dense BEM", preference=3, grid=True, growth=64.0),
    "bem_fft": Method("FFT BEM", preference=1, grid=True),
    "fem": Method("FEM", preference=2, growth=40.0),
    "tamaas": Method("Tamaas", origin="peer", isolated=True),
    "contactmechanics": Method("ContactMechanics", origin="peer", isolated=True),
    "ngsolve": Method("NGSolve", origin="peer", isolated=True),
}
# Entry points under which installed packages offer methods of their own.
GROUP = "roughline.methods"
# The list of solvers; heavy, so that it is not imported to list what has a row.
SOLVERS = "comparisons.methods.registry"
# All methods of this process: our own, and those from outside.
METHODS: dict[str, Method] = dict(BUILT_IN)
# The model under test, in whose place nothing else is judged where nobody says what to judge.
MODEL = next(name for name, row in BUILT_IN.items() if row.dimension == 1)
CLOSED_FORM = next(name for name, row in BUILT_IN.items() if row.exact)


def leading(names: Iterable[str]) -> list[str]:
    """Return the candidates of the truth among the names, the preferred first.

    >>> leading(["reduced", "fem", "bem_fft", "tamaas"])
    ['bem_fft', 'fem', 'tamaas']
    """
    ranked = [name for name in METHODS if name in set(names)]
    able = [name for name in ranked if METHODS[name].dimension == 3 and not METHODS[name].user_made]
    return sorted(able, key=lambda name: METHODS[name].preference)


def ours() -> list[str]:
    """Return the methods of roughline itself, in the order of every legend and table.

    >>> ours()
    ['closed_form', 'reduced', 'bem_dense', 'bem_fft', 'fem']
    """
    return [name for name, row in METHODS.items() if row.origin == "own"]


def references() -> list[str]:
    """Return our own candidates of the truth that discretise, the preferred first.

    >>> references()
    ['bem_fft', 'fem', 'bem_dense']
    """
    return [name for name in leading(ours()) if not METHODS[name].exact]


# The half-space on a grid that leads: others on the same grid are compared with it cell by cell.
GRID = next(name for name in references() if METHODS[name].grid)
# Candidates that share no code: of several grids, whose kernels are the same, the first one only.
INDEPENDENT = (CLOSED_FORM, *(n for n in references() if n == GRID or not METHODS[n].grid))


def is_known(name: str) -> bool:
    """Tell whether a method has this name.

    One of our own whose file brings no row to `BUILT_IN` is known when the solvers are loaded:
    that is done for a name that nobody knows, before it is called wrong.
    """
    if name not in METHODS:
        import_module(SOLVERS)
    return name in METHODS


def growth(name: str) -> float:
    """Return the factor of a method's work when its resolution doubles."""
    return METHODS[name].growth if name in METHODS else Method.growth


def title_of(name: str) -> str:
    """Return the words for a method, or the name of one that is not known here."""
    return METHODS[name].title if name in METHODS else name
