"""All solvers by method name, and the choice of the solver for a scene.

Our own are discovered: the files and packages beside this one hold the solvers, and adding a file
adds its solvers. One that is named after a table of physics is imported for scenes with that table
(`load`). Methods from outside are put beside them by `add`.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import comparisons.methods as package
from comparisons.discovery import classes_in, files_of
from comparisons.errors import InputError
from comparisons.facts.methods import METHODS, Method
from comparisons.methods.solver import Refusal, Refused, Solver
from comparisons.scene.options import recorded
from comparisons.scene.physics.tables import TABLES
from comparisons.scene.scene import Scene
from comparisons.tasks.task import Task

SOLVERS: dict[str, tuple[type[Solver[Any]], ...]] = dict.fromkeys(METHODS, ())
_loaded: set[str] = set()


def load(tables: Iterable[str] = TABLES) -> None:
    """Import the solvers of frictionless contact, and of some tables of physics or of all."""
    wanted = ["", *tables]
    if _loaded.issuperset(wanted):
        return
    for file in files_of(package, leave_out=set(TABLES) - set(wanted)):
        for solver in classes_in(file, Solver):
            if solver.name and solver not in SOLVERS.get(solver.name, ()):
                # One without a row says itself what it is called, and is the truth where no other
                # is.
                row = Method(solver.title or solver.name, solver.dimension)
                METHODS.setdefault(solver.name, row)
                SOLVERS[solver.name] = (*SOLVERS.get(solver.name, ()), solver)
    _loaded.update(wanted)


def add(solver: type[Solver[Any]], facts: Method) -> None:
    """Make a method from outside known by its name, in place of one of the same name."""
    SOLVERS[solver.name] = (solver,)
    METHODS[solver.name] = facts


def add_class(solver: type[Solver[Any]]) -> str:
    """Make a user's class known by its name for the rest of this process; return the name.

    One of the same name that was added before is replaced. Like every method from outside it is
    judged and never becomes the truth. Worker processes do not know it: with several workers the
    method belongs into a file (`comparisons.methods.user.external.add_methods`). InputError if it
    is no class of a solver with a name, or the name is that of a method of roughline's own.
    """
    if not (isinstance(solver, type) and issubclass(solver, Solver) and solver.name):
        raise InputError(
            "expected a function under @method(name), or a class derived from Solver that has a "
            f"name (the class, not an object of it), got {solver!r:.60}"
        )
    if solver.name in METHODS and not METHODS[solver.name].user_made:
        raise InputError(f"{solver.name!r} is a method of roughline's own: choose another name")
    add(solver, Method(solver.title or solver.name, solver.dimension, origin="outside"))
    return solver.name


def solver_for(name: str, scene: Scene) -> Solver[Any] | Refusal:
    """Return the solver of a scene by a method, or why there is none.

    Of our own methods each solver has just the tables of physics of its scenes; one from outside
    takes scenes with any of those that it knows. Nothing is solved with options that would do
    nothing and yet stand beside the results: a solver reads its options in its constructor, and a
    scene that changes another is refused.
    """
    load(scene.physics)
    options = scene.methods.of(name)
    try:
        with recorded() as all_read:
            solver = _maker(name, scene)(scene)
    except Refused as refused:
        return refused.refusal
    read = {key for owner, key in all_read if owner is type(options)}
    idle = sorted(set(options.changes) - read)
    if not idle:
        return solver
    keys = " and ".join(f"methods.{name}.{key}" for key in idle)
    does = "does" if len(idle) == 1 else "do"
    taken = ", ".join(sorted(read)) or "no option"
    return Refusal(f"{keys} {does} nothing here: on this scene {name} reads {taken}")


def concerned(scene: Scene) -> list[str]:
    """Return the methods that a scene names, and those that know its physics.

    Methods of our own that are for one physics only, as theories of rolling, are no part of plans
    without it; nor are those that run only where they are named.
    """
    load(scene.physics)
    named, tables = scene.compare.methods or (), set(scene.physics)
    return [
        name
        for name, row in METHODS.items()
        if row.user_made
        or name in named
        or any(maker.physics <= tables and not maker.named_only for maker in SOLVERS[name])
    ]


def planned_solver(task: Task) -> Solver[Any]:
    """Return the solver of a task that was planned."""
    load(task.scene.physics)
    return _maker(task.method, task.scene).planned(task.scene)


def _maker(name: str, scene: Scene) -> type[Solver[Any]]:
    tables = set(scene.physics)
    if not SOLVERS[name]:  # for physics that the scene has not
        load()
    able = sorted((m for m in SOLVERS[name] if m.physics >= tables), key=lambda m: len(m.physics))
    if not able:  # which tables it does not model, or not together
        load()
        physics = [maker.physics for maker in SOLVERS[name]]
        fewest, all_of_them = min(physics, key=len), frozenset[str]().union(*physics)
        missing = " and ".join(f"[{table}]" for table in scene.physics if table not in fewest)
        raise Refused(
            f"does not model {missing}" + (" in one scene" if all_of_them >= tables else "")
        )
    return next((m for m in able if m.physics == tables and m.takes(scene)), able[0])
