"""Methods of this session: objects that a user's program or notebook made, known by name."""

from __future__ import annotations

from comparisons.errors import InputError
from comparisons.methods.base import Method
from comparisons.scene.method_names import METHOD_NAMES, register_method


def add_to_session(method: Method) -> str:
    """Make a method object known by its name for the rest of the session; return the name.

    One of the same name that was added before is replaced. Like every method from outside it is
    judged and never becomes the truth. Worker processes do not know it: with several workers the
    method belongs into a file (`comparisons.methods.user.external.add_methods`).

    Raises
    ------
    InputError
        If the name is that of a method of roughline's own.
    """
    from comparisons.methods import METHODS

    if method.name in METHOD_NAMES:
        raise InputError(f"{method.name!r} is a method of roughline's own: choose another name")
    method.external = True
    METHODS[method.name] = method
    register_method(method.name, method.title, method.dimension)
    return method.name
