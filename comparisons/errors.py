"""The one kind of error that is the user's to mend."""

from __future__ import annotations


class InputError(ValueError):
    """Wrong input: a scene, a map, an option, a folder. The command line exits with code 2."""
