"""What the methods are called; light, so that scenes can be read and listed without any solver."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Annotated

from pydantic import AfterValidator

from comparisons.scene.fields import fail


@dataclass(frozen=True)
class MethodName:
    """The words for a method, and the dimension of what it solves."""

    title: str
    dimension: int = 3


METHOD_NAMES = {
    "closed_form": MethodName("closed form"),
    "reduced": MethodName("reduced model", dimension=1),
    "bem_dense": MethodName("dense BEM"),
    "bem_fft": MethodName("FFT BEM"),
    "fem": MethodName("FEM"),
    "tamaas": MethodName("Tamaas"),
    "contactmechanics": MethodName("ContactMechanics"),
    "ngsolve": MethodName("NGSolve"),
}
# Entry points under which installed packages offer methods of their own.
GROUP = "roughline.methods"
_from_outside: dict[str, MethodName] = {}


def register_method(name: str, title: str, dimension: int) -> None:
    """Make the name of a method from outside one that scenes and commands may say."""
    _from_outside[name] = MethodName(title, dimension)


def known_methods() -> dict[str, MethodName]:
    """Return all methods: our own, and those from outside."""
    return METHOD_NAMES | _from_outside


def _known(name: str) -> str:
    if name not in known_methods():
        raise fail(f"expected one of {', '.join(known_methods())}", name)
    return name


KnownMethod = Annotated[str, AfterValidator(_known)]
