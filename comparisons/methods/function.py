"""A method from a single function: the shortest way to test a model."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from typing import Any, ClassVar

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.solver import Refused, Solver
from comparisons.reasons import in_kind
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import MalformedError, Solution, curve_of
from comparisons.tasks.task import Task

LoadStep = Callable[[Task, float, int], Mapping[str, float]]


class FunctionSolver(Solver[Geometry]):
    """A function of one load step, called for every realisation and load."""

    step: ClassVar[LoadStep]
    levels: ClassVar[tuple[int, ...]]
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
