"""What is prescribed to a contact: a path of values, or loads that increase."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reduced.arguments import choice_faults, refuse

EDGES = ("sub_cell", "nodal")
"""Contacts that end inside a cell, and the chapter's sums over whole springs."""


@dataclass(frozen=True, eq=False, init=False)
class LoadPath:
    """Values that one prescribed quantity passes in order, of any sign.

    Parameters
    ----------
    control : str
        What is prescribed: ``"penetration"``, ``"force"``, ``"tangential_displacement"``, ...
    values : array_like, shape (k,)
        Finite; a number is a path of one point.

    Raises
    ------
    ValueError
        If the values are no list of finite numbers.

    Examples
    --------
    >>> LoadPath("force", [1, -2]).values
    array([ 1., -2.])
    """

    control: str
    values: np.ndarray

    def __init__(self, control: str, values: ArrayLike) -> None:
        object.__setattr__(self, "control", control)
        object.__setattr__(self, "values", np.array(values, dtype=float, ndmin=1))
        if self.values.ndim != 1 or self.values.size == 0:
            shape = self.values.shape
            raise ValueError(f"{control} must be a non-empty 1-D list, got shape {shape}")
        if not (np.isfinite(self.values).all() and self._ordered()):
            raise ValueError(f"{control} must be {self._expected}, got {values!r}")

    def one_of(self, *controls: str) -> str:
        """Return what is prescribed, or refuse it if it is none of these."""
        refuse(choice_faults("control", self.control, controls))
        return self.control

    @property
    def _expected(self) -> str:
        return "finite"

    def _ordered(self) -> bool:
        return True


class Load(LoadPath):
    """Loads of a contact that is pressed on: positive, strictly increasing.

    Parameters
    ----------
    control : {"penetration", "force", "mean_gap"}
        What is prescribed; a single contact has no mean gap.
    values : array_like, shape (k,)

    Raises
    ------
    ValueError
        If the values are not finite, positive and strictly increasing.

    Examples
    --------
    >>> Load("force", [1, 2])
    Load(control='force', values=array([1., 2.]))
    """

    def single(self) -> float:
        """Return the value of a load that stays, of which there is one."""
        if self.values.size != 1:
            raise ValueError(f"{self.control} must be one value, got {self.values}")
        return float(self.values[0])

    @property
    def _expected(self) -> str:
        return "finite, positive and strictly increasing"

    def _ordered(self) -> bool:
        return bool(self.values[0] > 0 and np.all(np.diff(self.values) > 0))
