"""The interface of a method: a solver is created for a scene, or refuses it with a reason.

A solver states its resolutions and the memory of a task, and solves the task. A failed load step
raises no exception: it is NaN, with its reason.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass
from functools import partial
from typing import Any, ClassVar, Generic, TypeVar

import numpy as np

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.reasons import in_kind
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import MalformedError, Solution, curve_of
from comparisons.tasks.steps import Row, Step, solve_rows
from comparisons.tasks.task import Task

G = TypeVar("G", bound=Geometry)
T = TypeVar("T")
# The resolution of what has no discretisation: nothing can refine it.
NO_GRID = (1,)


class Refused(Exception):  # noqa: N818 - no error: a method may decline a scene
    """Raised by the constructor of a solver, and by what that calls: it cannot do this scene.

    A method of a user's file may be `broken`: it raised, hung or answered nonsense when it was
    asked. That is no refusal, but an error of who gave the file. An optional part may be `missing`.
    """

    def __init__(self, reason: str, *, broken: bool = False, missing: bool = False) -> None:
        super().__init__(reason)
        self.refusal = Refusal(reason, broken, missing)


@dataclass(frozen=True)
class Refusal:
    """Why a method does not solve a scene; whether it is broken, or to be installed first."""

    reason: str
    broken: bool = False
    missing: bool = False


def needed(value: T | None, reason: str) -> T:
    """Return a part of the scene; refuse a scene that does not have it."""
    if value is None:
        raise Refused(reason)
    return value


ONLY_INDENTERS = "for single indenters on a plane"


def ball_radius(scene: Scene) -> float:
    """Return the radius of the ball that presses; refuse a scene without one."""
    indenter = needed(scene.indenter, ONLY_INDENTERS)
    if indenter.shape not in ("sphere", "paraboloid"):
        raise Refused("for spheres and paraboloids only")
    return float(indenter.parameters["radius"])


class Solver(Generic[G]):
    """A method on one scene.

    The constructor takes the scene and keeps what the solver needs of it, its options included:
    one that is first read later counts as idle, and a scene that changes it is refused
    (`comparisons.methods.registry.solver_for`). Where the scene is none for the method it raises
    `Refused`. A subclass with a `name` is a method, or one method's solver of the scenes with just
    the tables of its `physics`. It has `levels` or overrides `resolutions`, unless it has no grid,
    and one of `solve` (all loads at once), `steps` (load after load) and `rows` (the same, with a
    set-up).

    name, title, dimension: what the method is called, and whether it solves the contact itself (3),
    is a model under test (1) or a theory of the statistics of surfaces (2). Our own methods have
    the last two in `comparisons.facts.methods`.
    physics: the tables that it covers all together, such as {"viscoelastic", "sliding"}.
    bodies: whether it takes a finite [body] with supports, too.
    rough: whether its scenes have rough surfaces, or indenters; None: either.
    named_only: whether only scenes that name it in `compare.methods` have it in their plans.
    depths: whether it takes layers and grading of the [half_space].
    levels: its resolutions, where no tolerance changes them.
    note: why or by what rule the scene can be done, for the plan; "" where there is nothing to say.
    Solvers may set their own.
    span: largest ratio of the contact radii of an indenter's loads that one `solve` is given: loads
    over more decades come in several calls, each with a geometry sized for its own contacts.
    shared_cells: cells of all realisations of a task up to which sharing a set-up among them is
    worth while: beyond, smaller tasks lose less when they are killed, and spread better.
    """

    name: ClassVar[str] = ""
    title: ClassVar[str] = ""
    dimension: ClassVar[int] = 3
    physics: ClassVar[frozenset[str]] = frozenset()
    bodies: ClassVar[bool] = False
    rough: ClassVar[bool | None] = None
    named_only: ClassVar[bool] = False
    depths: ClassVar[bool] = False
    levels: ClassVar[tuple[int, ...]] = NO_GRID
    note: str = ""
    span: ClassVar[float] = 8.0
    shared_cells: ClassVar[float] = math.inf

    def __init__(self, scene: Scene) -> None:
        if scene.body is not None and not self.bodies:
            raise Refused("models a half-space, and the [body] is finite")
        if not (scene.half_space.uniform or self.depths):
            raise Refused("models a half-space that is the same at all depths")
        self.scene = scene

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Whether this one of several solvers of a method is the one for such scenes."""
        return cls.rough in (None, scene.rough)

    @classmethod
    def planned(cls, scene: Scene) -> Solver[G]:
        """Return the solver of a planned scene; a method from outside is not asked again."""
        return cls(scene)

    def resolutions(self, geometry: G) -> tuple[int, ...]:
        """Return the resolutions that the scene's tolerance asks for, coarse to fine."""
        return self.levels

    def series(self, usual: int, least: int, most: int, multiple: int = 1) -> tuple[int, int, int]:
        """Return three resolutions, each twice the last, of a method of second order.

        The finest is `usual` at a tolerance of 1 %, and grows as the root of it falls.
        """
        finest = int(np.clip(usual * np.sqrt(0.01 / self.scene.compare.tolerance), least, most))
        finest -= finest % multiple
        return finest // 4, finest // 2, finest

    def block(self, resolution: int) -> int:
        """Return how many surfaces are one task: few enough to resume, and to bound memory."""
        return int(max(1, min(25, self.shared_cells / resolution**2)))

    def refusal(self, task: Task[G]) -> str:
        """Return why this resolution is out of reach ("" where it is not)."""
        return ""

    def memory(self, task: Task[G]) -> float:
        """Estimate the peak memory of a task in bytes, before any is taken."""
        return 0.0

    def most_memory(self, task: Task[G]) -> float:
        """Estimate the same where the solver falls back on a dearer way; by default it has none."""
        return self.memory(task)

    def model(self, geometry: G) -> str:
        """Say in one sentence what is modelled; by default the first line of the docstring."""
        return (type(self).__doc__ or self.title).strip().splitlines()[0]

    def warm_up(self, task: Task[G]) -> None:
        """Compile whatever the task will need, so that no timing contains a compiler."""

    def rows(self, task: Task[G]) -> Iterable[Row]:
        """Yield each realisation, set up, with a function that yields its load steps."""
        for _ in task.realisations:
            yield Row(partial(self.steps, task))

    def steps(self, task: Task[G], loads: np.ndarray) -> Iterable[Step]:
        """Yield the steps of the loads still to do, where nothing is set up before."""
        raise NotImplementedError

    def solve(self, task: Task[G]) -> Solution:
        """Solve all loads and realisations of a task; a ConvergenceError loses all of them."""
        return solve_rows(task, self.rows(task))


LoadStep = Callable[[Task, float, int], Mapping[str, float]]


class FunctionSolver(Solver[Geometry]):
    """A function of one load step, called for every realisation and load."""

    step: ClassVar[LoadStep]
    refuses: ClassVar[Callable[[Scene], str]]

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        reason = type(self).refuses(scene)
        if reason:
            raise Refused(reason)

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return the surface's own points on rough scenes, else what the function was given."""
        return geometry.points[:1] if isinstance(geometry, RoughGeometry) else self.levels

    def solve(self, task: Task) -> Solution:
        """Call the function; what it raises is the reason why a step has no answer."""
        solution = Solution.empty(task)
        for row, realisation in enumerate(task.realisations):
            for step, load in enumerate(task.loads.values):
                try:
                    found: Any = type(self).step(task, float(load), realisation)
                    if not isinstance(found, Mapping) or not found:
                        raise MalformedError(f"expected numbers by quantity, got {in_kind(found)}")
                    values = {name: float(curve_of(name, n, ())) for name, n in found.items()}
                    for name, column in task.loads.columns.items():
                        far = abs(values.get(name, column[step]) - column[step])
                        if far > task.scene.compare.tolerance * abs(column).max():
                            raise MalformedError(
                                f"{name} = {values[name]:.3g} returned where {column[step]:.3g} is "
                                f"prescribed: the load given is the {task.loads.control}; return "
                                "what follows from it, or refuse such scenes"
                            )
                except MalformedError as error:
                    solution.fail((row, step), str(error))
                    continue
                except (ValueError, ArithmeticError, RuntimeError) as error:
                    solution.fail((row, step), f"{type(error).__name__}: {error}")
                    continue
                for name, column in task.loads.columns.items():
                    values.setdefault(name, float(column[step]))
                solution.put((row, step), values)
        return solution


def method(
    name: str,
    *,
    title: str = "",
    resolutions: tuple[int, ...] = (10, 20, 40),
    refuses: Callable[[Scene], str] = lambda scene: "",
    physics: Iterable[str] = (),
) -> Callable[[LoadStep], type[FunctionSolver]]:
    """Make a method of a function ``f(task, load, realisation) -> {quantity: value}``.

    Parameters
    ----------
    name, title : str
        The name on the command line, and the words in reports.
    resolutions : tuple of int
        Resolutions on indenters, coarse to fine; rough surfaces come with their own points.
    refuses : callable
        Returns why a scene cannot be done, "" where it can.
    physics : iterable of str
        Tables of a scene that the function knows of: "friction", "adhesion" ...; scenes with
        others are refused without asking.

    Examples
    --------
    >>> @method("twice", title="Twice as stiff", resolutions=(1,))
    ... def twice(task, load, realisation):
    ...     '''A flat punch of twice the true stiffness.'''
    ...     radius = task.geometry.contact_radius
    ...     return {"force": 4 * task.scene.effective_modulus * radius * load}
    >>> twice.name, twice.__doc__
    ('twice', 'A flat punch of twice the true stiffness.')
    """

    def wrap(step: LoadStep) -> type[FunctionSolver]:
        label = title or name.replace("_", " ")
        body = {
            "name": name,
            "title": label,
            "physics": frozenset(physics),
            "step": staticmethod(step),
            "levels": resolutions,
            "refuses": staticmethod(refuses),
            "__doc__": step.__doc__ or label,
            "__module__": step.__module__,
        }
        return type(name, (FunctionSolver,), body)

    return wrap
