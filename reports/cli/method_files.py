"""Options of every command that runs methods: user-supplied method files and their limits."""

from __future__ import annotations

import sys
from dataclasses import dataclass
from pathlib import Path

from cyclopts import Parameter

from reports.printable import say


@Parameter(name="*")
@dataclass(frozen=True)
class MethodFiles:
    """User-supplied methods.

    Parameters
    ----------
    method_file
        A Python file with your own method (docs/adding-a-method.md), which then runs, also
        where others are named; may be repeated.
    method_seconds
        Time limit for one solve of your method, including the start of its process; default: 120.
    method_gigabytes
        Memory limit for the process of your method; default: 2.
    """

    method_file: tuple[Path, ...] = ()
    method_seconds: float = 120.0
    method_gigabytes: float = 2.0

    def load(self) -> list[str]:
        """Register the methods of the files, and of installed packages; return the files' names.

        Raises
        ------
        InputError
            Listing every invalid file and limit.
        """
        from importlib import metadata

        from comparisons.errors import InputError
        from comparisons.facts.methods import GROUP

        limits = {"seconds": self.method_seconds, "gigabytes": self.method_gigabytes}
        wrong = [
            f"--method-{name}: expected a positive number, got {value:g}"
            for name, value in limits.items()
            if not 0 < value < float("inf")
        ]
        if wrong:
            raise InputError("\n".join(wrong))
        if not (self.method_file or metadata.entry_points(group=GROUP)):
            return []
        from comparisons.isolation.parent import Limits
        from comparisons.methods.user.external import add_methods, names_in

        bounds = Limits(self.method_seconds, 1e9 * self.method_gigabytes)
        for notice in add_methods(self.method_file, bounds):
            say(f"left out: {notice}", sys.stderr)
        return [name for file in self.method_file for name in names_in(file)]


NO_METHOD_FILES = MethodFiles()
