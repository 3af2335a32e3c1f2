"""How our methods do scenes with physics: one module per topic, found by itself.

A module holds ``WIRINGS``, a tuple of methods. Each has the name of one of our methods, and covers
exactly the tables in its `physics`; docs/adding-a-method.md tells how to write one.
"""

from __future__ import annotations

from importlib import import_module
from pkgutil import iter_modules

from comparisons.methods.base import Method


def wirings() -> tuple[Method, ...]:
    """Return the wirings of all modules here."""
    names = sorted(module.name for module in iter_modules(__path__))
    return tuple(each for name in names for each in import_module(f"{__name__}.{name}").WIRINGS)
