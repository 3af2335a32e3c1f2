"""The row of facts about a quantity."""

from __future__ import annotations

import math
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

    of: the quantities it depends on.
    by: computes its values from all known curves and the scene.
    round_only: valid for circular contacts only.
    """

    of: str | tuple[str, ...]
    by: Callable[[Curves, Contact], np.ndarray]
    round_only: bool = False

    @property
    def needs(self) -> frozenset[str]:
        """The names in `of`."""
        return frozenset({self.of} if isinstance(self.of, str) else self.of)


@dataclass(frozen=True)
class Bins:
    """The bins of a distribution: equal steps of the logarithm of a value over its scale.

    They are the same for all methods on a scene, and histograms over many surfaces add up.

    scale: E* h', the rms height, the nominal area A0.
    low, high: ends, in units of the scale; what lies beyond counts to the outer bins.
    """

    scale: Literal["pressure", "height", "area"]
    low: float
    high: float

    @property
    def edges(self) -> np.ndarray:
        """Edges in units of the scale, 16 steps per decade."""
        decades = round(math.log10(self.high / self.low))
        return np.geomspace(self.low, self.high, 16 * decades + 1)


@dataclass(frozen=True)
class Quantity:
    """Facts about a quantity: a column of results.csv, or a measure of measures.csv.

    Beside a column ``force`` stand ``error_force`` and ``reference_uncertainty_force``, and
    ``stderr_force`` of an ensemble.

    name: of its column.
    label, symbol: what it is called in text, on axes and in tables.
    unit: base SI: "m", "m2", "N", "N/m", "J", "Pa", "s", "B" or "" for a pure number.
    comparable: a scene may name it in ``compare.quantities``.
    default: it is compared where an elastic scene names none.
    physics: only scenes with one of these tables have it; every scene, where there is none.
    load: it may be prescribed, as such a load.
    counterpart: where it is prescribed itself: at which other load it is compared, and all else
    once more.
    field: it is compared as a field at the last load, not as a curve.
    norm: its error is the distance of two fields, which has no sign.
    single: it is one value of a whole scene, the same at every step.
    signed: it passes zero, so that relative changes of it mean nothing.
    only: why who asks for it may ask in vain.
    bins: it is a distribution over the surface, in these bins; of rough surfaces only.
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
    norm: bool = False
    single: bool = False
    signed: bool = False
    only: str = ""
    derived: Derived | None = None
    bins: Bins | None = None

    def title(self, unit: str) -> str:
        """Return "label symbol / unit" for an axis.

        >>> Quantity("penetration", "penetration depth", "d", "m").title("µm")
        'penetration depth d / µm'
        """
        text = f"{self.label} {self.symbol}".strip()
        return f"{text} / {unit}" if unit else text
