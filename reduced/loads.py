"""Prescribed loads of a contact: a path of values, or increasing loads."""

from dataclasses import dataclass
from typing import ClassVar

import numpy as np
from numpy.typing import ArrayLike

from reduced.errors import choice_faults, list_faults, refuse

EDGES = ("sub_cell", "nodal")
"""Contacts that end inside a cell, and the chapter's sums over whole springs."""


@dataclass(frozen=True, eq=False, init=False)
class LoadPath:
    """Successive finite values of one prescribed quantity, of any sign; a number is one point.

    >>> LoadPath("force", [1, -2]).values
    array([ 1., -2.])
    """

    increasing: ClassVar[bool] = False
    control: str
    values: np.ndarray

    def __init__(self, control: str, values: ArrayLike) -> None:
        object.__setattr__(self, "control", control)
        object.__setattr__(self, "values", np.array(values, dtype=float, ndmin=1))
        refuse(list_faults(increasing=self.increasing, **{control: values}))

    def one_of(self, *controls: str) -> str:
        """Return the control, or raise an error if it is not among these."""
        refuse(choice_faults("control", self.control, controls))
        return self.control


class Load(LoadPath):
    """Increasing loads of a contact: positive, strictly increasing.

    The control is "penetration", "force", or, of lines, "mean_gap".

    >>> Load("force", [1, 2])
    Load(control='force', values=array([1., 2.]))
    """

    increasing = True

    def single(self) -> float:
        """Return the value of a constant load; raise an error if there are several."""
        if self.values.size != 1:
            raise ValueError(f"{self.control} must be one value, got {self.values}")
        return float(self.values[0])
