"""Rooms with a door: whatever the numerics offer, a scene, a claim or an experiment uses.

A function of `reduced` or `reference` that only its own tests call has a cost and says nothing
about the chapter. What is reached is found in the source: from everything in `comparisons`, by
names, along the bodies of what is reached.
"""

import ast
from collections.abc import Iterable, Iterator
from pathlib import Path

import pytest

from comparisons.scene.indenters import SHAPES

ROOT = Path(__file__).parents[1]
NUMERICS = ("reduced", "reference")
ADVICE = (
    "Nothing in comparisons/ reaches these. Give each a door (an option of a scene's method, a "
    "claim, an experiment, a benchmark, a hard case), or delete it with its tests and pages:"
)
FUNCTIONS = (ast.FunctionDef, ast.AsyncFunctionDef)


class House:
    """What modules define, and which definitions use which.

    A definition has a dotted name: ``module.function``, ``module.CONSTANT``, ``module.Class``,
    ``module.Class.method``. All of a class but its methods belongs to the class itself, and so
    do ``__init__`` and its like.

    An approximation: an attribute of an object (``line.press``) may belong to any class, so it
    reaches every method of that name. A method that is reported is used by nobody; one that shares
    its name with a used one is never reported.
    """

    def __init__(self, modules: dict[str, str]) -> None:
        """Read modules, source text by dotted name."""
        self.names: dict[str, dict[str, str]] = {}  # module: local name: dotted name
        self.parts: dict[str, list[ast.AST]] = {}  # definition: what it consists of
        self.homes: dict[str, str] = {}  # definition: its module
        self.public: set[str] = set()  # functions, classes and methods without an underscore
        self.methods: dict[str, list[str]] = {}  # a method's bare name: definitions
        self.packages = {module.partition(".")[0] for module in modules}
        for module, text in modules.items():
            tree = ast.parse(text)
            known = self.names[module] = dict(_imports(tree))
            for node in tree.body:
                for name in _defined(node):
                    known[name] = f"{module}.{name}"
                    self._enter(module, known[name], node)

    def _enter(self, module: str, name: str, node: ast.AST) -> None:
        self.homes[name] = module
        if isinstance(node, (*FUNCTIONS, ast.ClassDef)) and "._" not in name:
            self.public.add(name)
        parts = self.parts.setdefault(name, [])
        if not isinstance(node, ast.ClassDef):
            parts.append(node)
            return
        parts += [*node.bases, *node.decorator_list]
        for part in node.body:
            if isinstance(part, FUNCTIONS) and not part.name.startswith("__"):
                self._enter(module, f"{name}.{part.name}", part)
                self.methods.setdefault(part.name, []).append(f"{name}.{part.name}")
            else:
                parts.append(part)

    def reached(self, start: Iterable[str]) -> set[str]:
        """Return what some definitions use, themselves included."""
        reached: set[str] = set()
        todo = list(start)
        while todo:
            name = todo.pop()
            if name not in reached:
                reached.add(name)
                todo += [used for part in self.parts[name] for used in self._used(name, part)]
        return reached

    def _used(self, name: str, tree: ast.AST) -> Iterator[str]:
        """Yield the definitions that a piece of the definition `name` mentions."""
        known = self.names[self.homes[name]]
        local = _local(tree) if isinstance(tree, FUNCTIONS) else set()
        for node in ast.walk(tree):
            if isinstance(node, ast.Name) and node.id not in local:
                yield from self._definition(known.get(node.id, ""))
            elif isinstance(node, ast.Attribute):
                first, _, rest = _dotted(node.value).partition(".")
                owner = (
                    f"{known[first]}.{rest}".rstrip(".") if first in known.keys() - local else ""
                )
                if owner in self.names:
                    yield from self._definition(f"{owner}.{node.attr}")
                elif not owner or owner.partition(".")[0] in self.packages:
                    yield from self.methods.get(node.attr, ())
            elif isinstance(node, ast.Call) and _dotted(node.func).endswith(".made_by"):
                # `Indenter.made_by(room)` calls what is named after a shape.
                room = known.get(_dotted(node.args[0]), "")
                for shape in SHAPES:
                    yield from self._definition(f"{room}.{shape}")

    def _definition(self, dotted: str) -> Iterator[str]:
        """Follow a name through re-exports; nothing for modules and other people's names."""
        while dotted and dotted not in self.parts:
            module, _, name = dotted.rpartition(".")
            further = self.names.get(module, {}).get(name, "")
            dotted = further if further != dotted else ""
        if dotted:
            yield dotted


def _imports(tree: ast.AST) -> Iterator[tuple[str, str]]:
    """Yield local and dotted name of what is imported, wherever in the module."""
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom):
            yield from ((a.asname or a.name, f"{node.module}.{a.name}") for a in node.names)
        elif isinstance(node, ast.Import):
            for a in node.names:
                yield (a.asname, a.name) if a.asname else (a.name.partition(".")[0],) * 2


def _defined(node: ast.AST) -> Iterator[str]:
    """Yield the names that a statement of a module defines."""
    if isinstance(node, (*FUNCTIONS, ast.ClassDef)):
        yield node.name
    elif not isinstance(node, (ast.Import, ast.ImportFrom)):
        yield from _stored(node)


def _stored(tree: ast.AST) -> set[str]:
    return {
        node.id
        for node in ast.walk(tree)
        if isinstance(node, ast.Name) and isinstance(node.ctx, ast.Store)
    }


def _local(function: ast.AST) -> set[str]:
    """Return parameters and variables of a function, which hide what the module calls so."""
    return _stored(function) | {
        node.arg for node in ast.walk(function) if isinstance(node, ast.arg)
    }


def _dotted(node: ast.AST) -> str:
    """Return "a.b.c" of such an expression, "" of any other."""
    if isinstance(node, ast.Attribute):
        owner = _dotted(node.value)
        return owner and f"{owner}.{node.attr}"
    return node.id if isinstance(node, ast.Name) else ""


def modules(*packages: str) -> dict[str, str]:
    """Return the source of all modules of some packages of this repository."""
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): (
            path.read_text(encoding="utf-8")
        )
        for package in packages
        for path in sorted((ROOT / package).rglob("*.py"))
    }


def without_a_door(house: House, *rooms: str) -> list[str]:
    """Return the public functions, classes and methods of `rooms` that no other room reaches."""
    outside = {name for name, module in house.homes.items() if module.split(".")[0] not in rooms}
    return sorted(house.public - outside - house.reached(outside))


TOY = {
    "tool": "from tool.press import Press, press",
    "tool.press": """
class Press:
    springs: int = 1
    def used(self): return self._inner()
    def _inner(self): return helper()
    def orphan_method(self): return 0
def press(): return Press()
def helper(): return table["a"]()
def in_table(): pass
table = {"a": in_table}
def only_another_orphan_uses_it(): pass
def orphan(): return only_another_orphan_uses_it()
def hidden(): pass
def _private(): pass
""",
    "scene": """
from tool import press
import tool.press as room
def solve(hidden):
    return press().used() + hidden + room.helper()
""",
}


def test_a_name_reaches_along_imports_calls_tables_and_attributes():
    """Re-exports, a module's alias, a table; a parameter hides what a module calls so."""
    assert without_a_door(House(TOY), "tool") == [
        "tool.press.Press.orphan_method",
        "tool.press.hidden",
        "tool.press.only_another_orphan_uses_it",
        "tool.press.orphan",
    ]


@pytest.mark.slow
def test_whatever_the_numerics_offer_has_a_door():
    """See the head of this file, and `House` for what the search takes for a use."""
    shut = without_a_door(House(modules(*NUMERICS, "comparisons")), *NUMERICS)
    assert not shut, "\n  ".join([ADVICE, *shut])
