"""User-supplied methods from a Python file or an entry point, each in a separate process.

Their code is never imported here. Results are untrusted: names, shapes and numbers are checked, and
every error becomes the reason for the method's own failed rows. A user-supplied method never serves
as the reference, nor does it count in disagreements of references.
"""

from __future__ import annotations

import hashlib
import json
import math
import os
import re
from collections.abc import Sequence
from dataclasses import asdict, dataclass
from importlib import metadata
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from comparisons.errors import InputError
from comparisons.facts.methods import GROUP, METHODS, Method
from comparisons.facts.quantities import COMPARABLE
from comparisons.geometry.prepare import Geometry
from comparisons.isolation import parent
from comparisons.isolation.parent import Limits
from comparisons.methods import Refused, Scene, Solver, Task, registry
from comparisons.reasons import in_kind, one_line
from comparisons.scene.physics.tables import TABLES
from comparisons.tasks.solution import FLAGS, Solution, curve_of, solution_of

WORK = "comparisons.solving.external_work"
# Known to every process of a run: workers start with the methods of the command line.
VARIABLE = "ROUGHLINE_METHODS"
NAME = re.compile(r"[a-z][a-z0-9_]{0,39}")
PLAN_SECONDS = 60.0
LIMITS = Limits(seconds=120.0, memory=2e9)  # of one task
# A method that passes its limits so often in a row would do so on every scene of a catalogue.
MOST_STUCK = 4
LONGEST_TEXT = 300
MOST_RESOLUTIONS = 10
FIELDS = ("pressure_x", "pressure_y", "pressure", "pressure_weight")
MOST_FIELD_POINTS = 4_000_000


@dataclass(frozen=True)
class Origin:
    """Where a method comes from (``file:PATH`` or ``entry:NAME``), and what it calls itself."""

    source: str
    name: str
    title: str
    dimension: int
    digest: str
    seconds: float
    memory: float
    physics: tuple[str, ...] = ()


class UserSolver(Solver[Geometry]):
    """What a method from outside would do with a scene, asked in a process of its own, and checked.

    A subclass is one method.
    """

    span = math.inf  # cut in the method's own process, where the next load costs no start
    origin: ClassVar[Origin]
    _stuck: ClassVar[int]
    _plans: ClassVar[dict[str, dict[str, Any]]]

    def __init__(self, scene: Scene) -> None:
        plan = self.plan(scene)
        if not plan["ok"]:
            # Of an installed package that nobody asked for it is a refusal.
            from_file = self.origin.source.startswith("file:")
            raise Refused(plan["reason"], broken=from_file and plan.get("broken", False))
        super().__init__(scene)
        self.note = plan["reason"]

    @classmethod
    def planned(cls, scene: Scene) -> UserSolver:
        solver = cls.__new__(cls)
        Solver.__init__(solver, scene)
        return solver

    @classmethod
    def plan(cls, scene: Scene) -> dict[str, Any]:
        """Ask the method; one that hangs, raises or answers nonsense does not do the scene."""
        key = f"{scene.directory}\n{scene.text}"
        if key not in cls._plans:
            seconds = min(PLAN_SECONDS, cls.origin.seconds)
            outcome = cls.ask("plan", scene, seconds=seconds)
            answer = outcome.answer if outcome.ok else {}
            levels: Any = answer.get("resolutions")
            whole = isinstance(levels, list) and 1 <= len(levels) <= MOST_RESOLUTIONS
            plan: dict[str, Any] = {"ok": False}
            if not outcome.ok:
                plan |= {"reason": f"planning {_failure(outcome)}", "broken": True}
            elif answer.get("ok") is not True:
                plan["reason"] = _text(answer.get("reason") or "refused without a reason")
            elif not (whole and all(type(n) is int and 1 <= n <= 2**20 for n in levels)):
                reason = f"malformed answer: resolutions are {_text(levels)}"
                plan |= {"reason": reason, "broken": True}
            else:
                texts = {part: _text(answer.get(part, "")) for part in ("reason", "model")}
                plan = {"ok": True, "resolutions": levels, **texts}
            cls._plans[key] = plan
        return cls._plans[key]

    @classmethod
    def ask(cls, question: str, *arguments: Any, seconds: float) -> parent.Outcome:
        """Put a question to the method, in a process of its own."""
        if cls._stuck >= MOST_STUCK:
            reason = f"not asked again: {MOST_STUCK} times in a row it hung or ran out of memory"
            return parent.Outcome("raised", reason=reason)
        outcome = parent.run(
            f"{WORK}:{question}",
            cls.origin.source,
            cls.origin.name,
            *arguments,
            seconds=seconds,
            memory=cls.origin.memory,
            finite=False,
            reuse=f"{cls.origin.source} {cls.origin.digest}",
        )
        stuck = outcome.ended in (parent.HUNG, parent.OUT_OF_MEMORY)
        cls._stuck = cls._stuck + 1 if stuck else 0
        return outcome

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        return tuple(self.plan(self.scene)["resolutions"])

    def model(self, geometry: Geometry) -> str:
        text: str = self.plan(self.scene)["model"]
        return text

    def solve(self, task: Task) -> Solution:
        """Solve in the method's own process, and check what comes back."""
        outcome = self.ask("solve", task, seconds=self.origin.seconds)
        if not outcome.ok:
            return Solution.lost(task, _failure(outcome))
        try:
            given = {
                name: value
                for name, value in outcome.answer.items()
                if isinstance(value, np.ndarray)
            }
            solution = solution_of(given)
            shape = (len(task.realisations), len(task.loads.values))
            # known quantities in arrays of the right shape
            for name, values in solution.quantities.items():
                if name not in COMPARABLE:
                    raise ValueError(f"unknown quantity {_text(name)!r}")
                solution.quantities[name] = curve_of(name, values, shape)
            for name, kinds in (
                *((flag, "b") for flag in FLAGS),
                ("iterations", "iu"),
                ("violation", "f"),
            ):
                values = getattr(solution, name)
                if values.shape != shape or values.dtype.kind not in kinds:
                    raise ValueError(
                        f"{name}: expected an array of shape {shape}, got {in_kind(values)}"
                    )
            if solution.converged.any() and not solution.quantities:
                raise ValueError("no quantity at all")
            solution.reasons = {
                (int(row), int(step)): _text(reason)
                for (row, step), reason in solution.reasons.items()
                if 0 <= int(row) < shape[0] and 0 <= int(step) < shape[1]
            }
            for row, step in np.argwhere(~solution.converged):
                solution.reasons.setdefault((int(row), int(step)), "no answer, and no reason given")
            # a pressure field whose parts fit together is kept; anything else is not shown
            arrays = {
                name: np.ravel(solution.fields[name]) for name in FIELDS if name in solution.fields
            }
            sizes = {values.size for values in arrays.values()}
            whole = (
                len(arrays) == len(FIELDS) and len(sizes) == 1 and max(sizes) <= MOST_FIELD_POINTS
            )
            numeric = all(values.dtype.kind in "iuf" for values in arrays.values())
            solution.fields = arrays if whole and numeric else {}
            solution.unknowns = max(0, int(solution.unknowns))
            solution.path = task.loads.is_path
            return solution
        except (KeyError, TypeError, ValueError, OverflowError) as error:
            return Solution.lost(task, f"malformed answer: {_text(error)}")


def add_methods(files: Sequence[str | Path] = (), limits: Limits = LIMITS) -> list[str]:
    """Register the methods of files and of installed packages; return notices for the user.

    InputError lists every file that is no method. An installed package that is none is left out,
    with a notice: it must not stop a command that does not use it.
    """
    problems: list[str] = []
    notices: list[str] = []
    for point in metadata.entry_points(group=GROUP):
        _add(f"entry:{point.name}", limits, notices)
    for file in files:
        path = Path(file)
        if path.is_file():
            _add(f"file:{path.resolve()}", limits, problems)
        else:
            problems.append(f"--method-file: {file}: no such file")
    if problems:
        raise InputError("\n".join(problems))
    return notices


def names_in(file: str | Path) -> list[str]:
    """Return the names of the registered methods of a file."""
    source = f"file:{Path(file).resolve()}"
    return [method.name for method in user_methods() if method.origin.source == source]


def announced() -> str:
    """Return what a worker needs to know of the methods of this process, for `adopt`."""
    return os.environ.get(VARIABLE, "[]")


def adopt(methods: str) -> None:
    """Take over the methods of the process that hands out the work.

    A pool's processes outlive a study: they were perhaps started before it had these methods.
    """
    if methods != announced():
        os.environ[VARIABLE] = methods
        add_announced()


def digests() -> dict[str, str]:
    """Return what tells the versions of the methods of this process, as found here, by name.

    A machine that does not have the file or package of a method says so in place of its digest.
    """
    versions = {}
    for origin in _announced_origins():
        try:
            versions[f"method {origin.name}"] = _digest(origin.source)[:12]
        except (OSError, ValueError):
            versions[f"method {origin.name}"] = f"no {origin.source}"
    return versions


def add_announced() -> None:
    """Register the methods that this process was started with."""
    for origin in _announced_origins():
        register(origin)


def user_methods() -> list[type[UserSolver]]:
    """Return the registered methods of files and packages."""
    makers = (maker for makers in registry.SOLVERS.values() for maker in makers)
    return [maker for maker in makers if issubclass(maker, UserSolver)]


def brought() -> list[str]:
    """Return the methods from outside that were given by hand: no installed package offers them."""
    offered = {m.name for m in user_methods() if m.origin.source.startswith("entry:")}
    return [name for name, row in METHODS.items() if row.user_made and name not in offered]


def _announced_origins() -> list[Origin]:
    try:
        return [Origin(**origin) for origin in json.loads(announced())]
    except (TypeError, ValueError):
        return []


def user_method(origin: Origin) -> type[UserSolver]:
    """Return the solver of a method from outside."""
    names = {"name": origin.name, "physics": frozenset(origin.physics)}
    return type(origin.name, (UserSolver,), {**names, "origin": origin, "_stuck": 0, "_plans": {}})


def register(origin: Origin) -> None:
    """Make a method from outside known, and what is known of it without asking it."""
    named = origin.title, origin.dimension
    facts = Method(*named, origin="outside", isolated=True, identity=origin.digest)
    registry.add(user_method(origin), facts)


def _add(source: str, limits: Limits, problems: list[str]) -> None:
    kind, _, where = source.partition(":")
    label = f"--method-file: {where}" if kind == "file" else f"the installed method {where!r}"
    try:
        digest = _digest(source)
    except (ValueError, OSError) as error:
        problems.append(f"{label}: {_text(error)}")
        return
    outcome = parent.run(
        f"{WORK}:describe",
        source,
        seconds=PLAN_SECONDS,
        memory=limits.memory,
        finite=False,
        reuse=f"{source} {digest}",
    )
    if not outcome.ok:
        problems.append(f"{label}: {_failure(outcome)}")
        return
    try:
        documents = json.loads(outcome.answer["methods"])
        origins = []
        for document in documents:
            # what a method calls itself: a name that no method of ours has
            name, title, dimension = (document[key] for key in ("name", "title", "dimension"))
            physics = document.get("physics", [])
            if not isinstance(name, str) or not NAME.fullmatch(name):
                raise ValueError(
                    f"name: expected a-z, 0-9 and _, at most 40 characters, got {name!r:.60}"
                )
            if name in METHODS and not METHODS[name].user_made:
                raise ValueError(f"name: {name!r} is a method of roughline's own")
            if dimension not in (1, 3):
                raise ValueError(f"dimension: expected 1 or 3, got {dimension!r:.60}")
            if not isinstance(physics, list) or any(table not in TABLES for table in physics):
                names = ", ".join(TABLES)
                raise ValueError(f"physics: expected tables among {names}, got {physics!r:.60}")
            title, known = _text(title)[:60] or name, tuple(physics)
            origins.append(
                Origin(source, name, title, dimension, digest, **asdict(limits), physics=known)
            )
    except (KeyError, TypeError, ValueError) as error:
        problems.append(f"{label}: {_text(error)}")
        return
    sources = {method.name: method.origin.source for method in user_methods()}
    for origin in origins:
        if sources.get(origin.name, source) != source:
            problems.append(f"{label}: another method is called {origin.name!r} already")
            continue
        register(origin)
    os.environ[VARIABLE] = json.dumps([asdict(method.origin) for method in user_methods()])


def _digest(source: str) -> str:
    """Return what tells one version of a source from another."""
    kind, _, where = source.partition(":")
    if kind == "file":
        return hashlib.sha256(Path(where).read_bytes()).hexdigest()
    (point,) = metadata.entry_points(group=GROUP, name=where)
    return f"{point.value} {point.dist.version if point.dist else ''}"


def _failure(outcome: parent.Outcome) -> str:
    return f"{outcome.ended}: {_text(outcome.reason)}"


def _text(value: object) -> str:
    """Return text from outside as one short printable line."""
    line = one_line(str(value))
    return "".join(c if c.isprintable() else "?" for c in line)[:LONGEST_TEXT]
