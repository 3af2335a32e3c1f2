"""Rooms whose files add themselves: whoever drops a file into one has added what is in it."""

from __future__ import annotations

from collections.abc import Collection, Iterator
from importlib import import_module
from pkgutil import iter_modules
from types import ModuleType
from typing import TypeVar

T = TypeVar("T")


def files_of(package: ModuleType, leave_out: Collection[str] = ()) -> Iterator[ModuleType]:
    """Yield the modules of a package and of its packages, in alphabetical order, but some by name.

    >>> import comparisons.isolation as package
    >>> [module.__name__.removeprefix(f"{package.__name__}.") for module in files_of(package)]
    ['child', 'parent']
    """
    for name, is_package in sorted((m.name, m.ispkg) for m in iter_modules(package.__path__)):
        if name in leave_out:
            continue
        module = import_module(f"{package.__name__}.{name}")
        yield module
        if is_package:
            yield from files_of(module)


def classes_of(package: ModuleType, base: type[T]) -> Iterator[type[T]]:
    """Yield the subclasses of a class that the modules of a package define."""
    for file in files_of(package):
        yield from classes_in(file, base)


def classes_in(file: ModuleType, base: type[T]) -> Iterator[type[T]]:
    """Yield the subclasses of a class that a module defines."""
    for value in vars(file).values():
        local = isinstance(value, type) and value.__module__ == file.__name__
        if local and issubclass(value, base) and value is not base:
            yield value
