"""Errors that a user meets: what is theirs to mend, and work that was taken away."""

from __future__ import annotations


class InputError(ValueError):
    """Wrong input: a scene, a map, an option, a folder. The command line exits with code 2."""


class NotInstalledError(InputError):
    """An optional part is missing: what needs it is not run, and nothing else is the worse."""


class ProblemsError(InputError):
    """Files of claims or hard cases are wrong: `problems` lists all, an entry per file and key."""

    @property
    def problems(self) -> list[str]:
        """A line per problem."""
        return list(self.args)

    def __str__(self) -> str:
        return "\n".join(self.args)


class ResultsError(InputError):
    """A results folder cannot be read or written as asked."""


class LostWorkError(RuntimeError):
    """Work was ended from outside: a cluster went away, a process was killed again and again.

    What is done is kept, as after an interrupt: the command line exits with code 3.
    """


def is_interrupt(error: BaseException) -> bool:
    """Tell whether an error is a ctrl-C, or what a class body (`__set_name__`) made of one."""
    return any(isinstance(each, KeyboardInterrupt) for each in (error, error.__cause__))
