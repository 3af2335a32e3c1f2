"""What a hard case is: a scene, its truth, and what each method is expected to do with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np

if TYPE_CHECKING:
    from comparisons.planning import Plan


Kind = Literal["accurate", "degraded", "refused", "not for"]
Curves = dict[str, np.ndarray]


@dataclass(frozen=True)
class Expected:
    """What one method does with one case, as the tests assert it.

    Attributes
    ----------
    kind : str
        ``accurate`` and ``degraded`` give numbers, bounded by `error` and `area`; ``refused`` gives
        none, with a reason that contains `text`; ``not for`` says that the method was never meant
        for such a scene, for the reason `text`.
    error, area : float
        Largest relative error over the load steps of the main quantity (the force at equal
        penetration, the penetration at equal force; the first one compared where the scene's
        physics has another axis) and of the contact area, each together with
        the bar of the truth. NaN: not bounded, because there is no truth for it.
    text : str
        Part of the reason of a refusal, or of every step in `lost`.
    lost : tuple of int
        Load steps without an answer; all others have one.
    why : str
        Why a method degrades.
    """

    kind: Kind
    error: float = float("nan")
    area: float = float("nan")
    text: str = ""
    lost: tuple[int, ...] = ()
    why: str = ""


def accurate(
    error: float, area: float = float("nan"), *, lost: tuple[int, ...] = (), text: str = ""
) -> Expected:
    """Expect errors below these bounds, which are what the method has on an easy scene."""
    return Expected("accurate", error, area, text, lost)


def degraded(error: float, area: float = float("nan"), *, why: str) -> Expected:
    """Expect a larger error than usual, at most this one, for a reason that is known."""
    return Expected("degraded", error, area, why=why)


def refused(text: str) -> Expected:
    """Expect no number but an error that contains `text`."""
    return Expected("refused", text=text)


def not_for(text: str) -> Expected:
    """Expect the method to say that this is no scene for it, because of `text`."""
    return Expected("not for", text=text)


@dataclass(frozen=True)
class Trusted:
    """A truth that has to be computed: one method, its bar from the differences of resolutions.

    With `tables`, on a twin of the scene that has these tables instead of its own.
    """

    method: str
    resolutions: tuple[int, ...]
    tables: Mapping[str, Any] = field(default_factory=dict)


@dataclass(frozen=True)
class Known:
    """A truth that is a formula of the planned scene, exact but for round-off."""

    curves: Callable[[Plan], Curves]
    source: str


# The finite-element solver takes seconds where the others take milliseconds.
ONLY_FULL = frozenset({"fem"})


@dataclass(frozen=True)
class HardCase:
    """One entry of the catalogue.

    Attributes
    ----------
    id, title : str
    hard : str
        What is hard about it, in one sentence.
    scene : mapping
        Tables of the scene; the name is the id.
    expected : mapping
        Method -> Expected, for every built-in method (or for those in `only`).
    resolutions : mapping
        Method -> resolution; by default what ``roughline solve`` takes.
    truth : Trusted, Known or None
        None: the scene's closed form.
    files : callable, optional
        Writes the maps that the scene names into a folder.
    only : str
        Why methods without an expectation are not run; "" if all are.
    slow : frozenset of str
        Methods that only ``--full`` runs.
    """

    id: str
    title: str
    hard: str
    scene: Mapping[str, Any]
    expected: Mapping[str, Expected]
    resolutions: Mapping[str, int] = field(default_factory=dict)
    truth: Trusted | Known | None = None
    files: Callable[[Path], None] | None = None
    only: str = ""
    slow: frozenset[str] = ONLY_FULL
