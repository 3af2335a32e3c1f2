"""A method from one function: the shortest way to have a model judged."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from comparisons.geometry.prepare import Geometry, RoughGeometry
from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.scene.scene import Scene

LoadStep = Callable[[Task, float, int], Mapping[str, float]]


class FunctionMethod(Method):
    """A function of one load step, called for every realisation and load."""

    def __init__(
        self,
        step: LoadStep,
        name: str,
        title: str,
        resolutions: tuple[int, ...],
        refuses: Callable[[Scene], str],
        physics: frozenset[str],
    ) -> None:
        self.name = name
        self.title = title or name.replace("_", " ")
        self.physics = physics
        self._step = step
        self._resolutions = resolutions
        self._refuses = refuses

    def supports(self, scene: Scene) -> Support:
        """Everything that the method does not refuse."""
        reason = self._refuses(scene)
        return Support(not reason, reason)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Return the surface's own points on rough scenes, else what the function was given."""
        return geometry.points[:1] if isinstance(geometry, RoughGeometry) else self._resolutions

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Return the first line of the function's docstring."""
        return (self._step.__doc__ or self.title).strip().splitlines()[0]

    def solve(self, task: Task) -> Solution:
        """Call the function; what it raises is the reason why a step has no answer."""
        solution = Solution.empty(task)
        for row, realisation in enumerate(task.realisations):
            for step, load in enumerate(task.loads.values):
                try:
                    values = dict(self._step(task, float(load), realisation))
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
) -> Callable[[LoadStep], FunctionMethod]:
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
    >>> twice.name, twice.model(None, None)
    ('twice', 'A flat punch of twice the true stiffness.')
    """

    def wrap(step: LoadStep) -> FunctionMethod:
        return FunctionMethod(step, name, title, resolutions, refuses, frozenset(physics))

    return wrap
