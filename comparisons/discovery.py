"""Rooms whose files add themselves: whoever drops a file into one has added what is in it."""

from __future__ import annotations

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

T = TypeVar("T")


def files_of(room: ModuleType) -> Iterator[ModuleType]:
    """Yield the modules of a package, in alphabetical order.

    >>> import comparisons.facts as room
    >>> [module.__name__ for module in files_of(room)]
    ['comparisons.facts.methods', 'comparisons.facts.quantities']
    """
    for name in sorted(module.name for module in iter_modules(room.__path__)):
        yield import_module(f"{room.__name__}.{name}")


def classes_of(room: ModuleType, base: type[T]) -> Iterator[type[T]]:
    """Yield the subclasses of a class that the modules of a package define."""
    for file in files_of(room):
        for value in vars(file).values():
            local = isinstance(value, type) and value.__module__ == file.__name__
            if local and issubclass(value, base) and value is not base:
                yield value
