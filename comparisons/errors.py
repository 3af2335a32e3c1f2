"""Errors that a user meets: what is theirs to mend, and a cluster that went away."""

from __future__ import annotations


class InputError(ValueError):
    """Wrong input: a scene, a map, an option, a folder. The command line exits with code 2."""


class LostSchedulerError(RuntimeError):
    """A cluster's scheduler went away in mid-run: what is done is kept (exit code 3)."""
