"""One row per method: title, dimension, and rank as a reference.

Importing it loads no solver, so scenes are read and methods listed quickly. User-supplied methods
add their own rows.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Literal

from comparisons.errors import InputError
from comparisons.reasons import near

# What is pressed: one body, a rough surface, or what sticks until its cells let go one by one.
# Under other physics, on layers and for bodies from files nobody knows what is usual.
Sort = Literal["single", "rough", "adhesive", "other"]


@dataclass(frozen=True)
class Usual:
    """The time of a usual solve, measured on an idle machine: half of it grows with the grid."""

    seconds: float = 1.0
    resolution: int = 1
    growth: float = 6.0  # when the resolution doubles

    def at(self, resolution: int) -> float:
        """Return the seconds at a resolution."""
        doublings = math.log2(resolution / self.resolution)
        return self.seconds * (1.0 + self.growth**doublings) / 2.0


@dataclass(frozen=True)
class Method:
    """Facts about a method."""

    title: str  # name in reports
    # 3 for a candidate reference, 1 for a model under test, 2 for a theory of the statistics of a
    # surface, which needs no realisation.
    dimension: int = 3
    # Among candidates of equal or unknown bars, the one with the lowest value is the reference.
    preference: float = math.inf
    exact: bool = False  # a closed form, without discretisation
    # A half-space on a grid of cells; two such methods have the same error on the same grid.
    grid: bool = False
    # Factor of the work when the resolution doubles: N^2 log N and more iterations for grids, N^5
    # for meshes, N^6 for dense matrices.
    growth: float = 6.0
    usual: Mapping[Sort, Usual] = field(default_factory=dict)
    # Other people's code (peer) checks the reference, and is never the reference itself. A user's
    # (outside) is untrusted: it is judged, and takes no part in what the truth is.
    origin: Literal["own", "peer", "outside"] = "own"
    isolated: bool = False  # it runs in a separate process and measures its own time
    on_request: bool = False  # a load takes seconds: it runs only where a scene names it
    identity: str = ""  # distinguishes versions of user-supplied code

    @property
    def peer(self) -> bool:
        """Whether it is third-party code that checks ours."""
        return self.origin == "peer"

    @property
    def user_made(self) -> bool:
        """Whether it is supplied by the user."""
        return self.origin == "outside"


BUILT_IN: dict[str, Method] = {
    "closed_form": Method(
        "closed form", preference=0, exact=True, usual={"single": Usual(0.0005, growth=1.0)}
    ),
    "reduced": Method(
        "reduced model",
        dimension=1,
        usual={"single": Usual(0.0005, 20, 2.0), "rough": Usual(2.5e-5, 64, 2.0)},
    ),
    "bem_dense": Method(
        "dense BEM",
        preference=3,
        grid=True,
        growth=64.0,
        usual={"single": Usual(0.01, 8, 16.0), "rough": Usual(0.4, 64, 16.0)},
    ),
    "bem_fft": Method(
        "FFT BEM",
        preference=1,
        grid=True,
        growth=4.7,
        usual={
            "single": Usual(0.045, 32, 4.7),
            "rough": Usual(0.045, 64, 4.0),
            "adhesive": Usual(3.0, 12, 16.0),
        },
    ),
    "fem": Method(
        "FEM",
        preference=2,
        growth=40.0,
        usual={"single": Usual(0.036, 2, 16.0), "rough": Usual(0.1, 64, 4.0)},
    ),
    "mca": Method("cellular automata", preference=4, growth=16.0, on_request=True),
    "tamaas": Method("Tamaas", origin="peer", isolated=True),
    "contactmechanics": Method("ContactMechanics", origin="peer", isolated=True),
    "ngsolve": Method("NGSolve", origin="peer", isolated=True, on_request=True),
}
# Theories, which take no options and run where a scene is theirs or names them.
THEORIES: dict[str, Method] = {
    "fastsim": Method("FASTSIM", dimension=1),
    "kalker": Method("Kalker's linear theory", dimension=1),
    "hamrock_dowson": Method("Hamrock-Dowson", dimension=1),
    "kogut_etsion": Method("Kogut & Etsion", dimension=1),
    "jackson_green": Method("Jackson & Green", dimension=1),
    "persson": Method("Persson's theory", dimension=2),
    "persson_xu": Method("Persson's theory after Xu", dimension=2),
    "greenwood_williamson": Method("Greenwood & Williamson's theory", dimension=2),
    "bush_gibson_thomas": Method("Bush, Gibson & Thomas' theory", dimension=2),
}
# Contacts of other people's codes, models under test without options.
LAWS: dict[str, Method] = {
    name: Method(title, dimension=1, origin="peer", isolated=True, on_request=True)
    for name, title in {
        "lammps_hertz": "LAMMPS hertz",
        "lammps_jkr": "LAMMPS jkr",
        "lammps_mdr": "LAMMPS mdr",
        "drake": "Drake",
        "mujoco": "MuJoCo",
        "slippy": "slippy",
    }.items()
}
# Entry points under which installed packages offer methods of their own.
GROUP = "roughline.methods"
# The list of solvers; heavy, so that it is not imported to list what has a row.
SOLVERS = "comparisons.methods.registry"
# All methods of this process: our own, and those from outside.
METHODS: dict[str, Method] = BUILT_IN | THEORIES | LAWS
# The model under test, in whose place nothing else is judged where nobody says what to judge.
MODEL = next(name for name, row in BUILT_IN.items() if row.dimension == 1)
CLOSED_FORM = next(name for name, row in BUILT_IN.items() if row.exact)
# Why a method that could do a scene is not in its plan; another run may have it.
NOT_ASKED = "not asked for"


def leading(names: Iterable[str]) -> list[str]:
    """Return the candidate references among the names, the preferred first.

    >>> leading(["reduced", "fem", "bem_fft", "tamaas"])
    ['bem_fft', 'fem', 'tamaas']
    """
    ranked = [name for name in METHODS if name in set(names)]
    able = [name for name in ranked if METHODS[name].dimension == 3 and not METHODS[name].user_made]
    return sorted(able, key=lambda name: METHODS[name].preference)


def ours() -> list[str]:
    """Return the methods of roughline itself, in the order of every legend and table.

    Those of `BUILT_IN` first; what packages bring without a row follows when solvers are loaded.

    >>> ours()[:6]
    ['closed_form', 'reduced', 'bem_dense', 'bem_fft', 'fem', 'mca']
    """
    return [name for name, row in METHODS.items() if row.origin == "own"]


def references() -> list[str]:
    """Return our own discretised candidate references, the preferred first.

    >>> references()
    ['bem_fft', 'fem', 'bem_dense', 'mca']
    """
    return [name for name in leading(ours()) if not METHODS[name].exact]


# The half-space on a grid that leads: others on the same grid are compared with it cell by cell.
GRID = next(name for name in references() if METHODS[name].grid)
# The leading finite elements; their title where the mesh repeats from cell to cell, and each wave
# is a problem of one column: as fast as boundary elements, which no other mesh is.
ELEMENTS, REPEATING_ELEMENTS = "fem", "FFT FEM"
# Candidates that share no code and run unasked: of several grids, whose kernels are the same, the
# first one only.
INDEPENDENT = (
    CLOSED_FORM,
    *(n for n in references() if n == GRID or not (METHODS[n].grid or METHODS[n].on_request)),
)


def method_named(name: str, where: str = "--method: ") -> str:
    """Return the name of a method, in capitals or not; InputError names those that there are."""
    if is_known(name.lower()):
        return name.lower()
    hint = near(name, METHODS)
    raise InputError(f"{where}expected one of {', '.join(METHODS)}, got {name!r:.60}{hint}")


def is_known(name: str) -> bool:
    """Tell whether a method has this name, of ours or, when solvers are loaded, of other files."""
    if name not in METHODS:
        import_module(SOLVERS).load()
    return name in METHODS


def title_of(name: str) -> str:
    """Return the title of a method, or its name if it is unknown."""
    return METHODS[name].title if is_known(name) else name
