"""The row of facts about a quantity."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

Curves = Mapping[str, np.ndarray]


class Contact(Protocol):
    """What derived quantities may depend on beside others: a scene."""

    @property
    def effective_modulus(self) -> float:
        """E* in Pa."""


@dataclass(frozen=True)
class Derived:
    """The derivation of a quantity from others, used if a method has not computed it.

    Attributes
    ----------
    of : str or tuple of str
        The quantities it depends on.
    by : callable
        Computes its values from all known curves and the scene.
    round_only : bool
        Valid for circular contacts only.
    """

    of: str | tuple[str, ...]
    by: Callable[[Curves, Contact], np.ndarray]
    round_only: bool = False

    @property
    def needs(self) -> frozenset[str]:
        """The names in `of`."""
        return frozenset({self.of} if isinstance(self.of, str) else self.of)


@dataclass(frozen=True)
class Quantity:
    """Facts about a quantity: a column of results.csv, or a measure of measures.csv.

    Beside a column ``force`` stand ``error_force`` and ``reference_uncertainty_force``, and
    ``stderr_force`` of an ensemble.

    Attributes
    ----------
    name : str
        Of its column.
    label, symbol : str
        What it is called in text, on axes and in tables.
    unit : str
        Base SI: "m", "m2", "N", "N/m", "J", "Pa", "s", "B" or "" for a pure number.
    comparable : bool
        A scene may name it in ``compare.quantities``.
    default : bool
        It is compared where an elastic scene names none.
    physics : tuple of str
        Only scenes with one of these tables have it; every scene, where there is none.
    load : {"", "normal", "tangential"}
        It may be prescribed, as such a load.
    counterpart : str
        Where it is prescribed itself: at which other load it is compared, and all else once more.
    field : bool
        It is compared as a field at the last load, not as a curve.
    signed : bool
        It passes zero, so that relative changes of it mean nothing.
    derived : Derived or None
    """

    name: str
    label: str
    symbol: str = ""
    unit: str = ""
    comparable: bool = False
    default: bool = False
    physics: tuple[str, ...] = ()
    load: Literal["", "normal", "tangential"] = ""
    counterpart: str = ""
    field: bool = False
    signed: bool = False
    derived: Derived | None = None

    def title(self, unit: str) -> str:
        """Return "label symbol / unit" for an axis.

        >>> Quantity("penetration", "penetration depth", "d", "m").title("µm")
        'penetration depth d / µm'
        """
        text = f"{self.label} {self.symbol}".strip()
        return f"{text} / {unit}" if unit else text
