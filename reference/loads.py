"""Prescribed loads of a contact: a path of values, a history in time, or increasing loads."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array, Mask

_ROUND_OFF = 1e-12  # of the sum that a normal force is, relative to it


def slides(tangential: ArrayLike, limit: float) -> Mask:
    """Tell where a prescribed tangential force reaches the limit mu F: nothing holds it there.

    >>> slides([0.2, 0.3, -0.4], 0.1 * 3).tolist()
    [False, True, True]
    """
    return np.logical_not(np.abs(tangential) < limit * (1 - _ROUND_OFF))


@dataclass(frozen=True, eq=False, init=False)
class LoadPath:
    """Successive values of one prescribed quantity, of any sign."""

    # the prescribed quantity: "penetration", "force", "tangential_force", ...
    control: str
    values: Array  # (k,): finite values; a number is a path of one point

    def __init__(self, control: str, values: ArrayLike) -> None:
        object.__setattr__(self, "control", control)
        object.__setattr__(self, "values", np.array(values, dtype=float, ndmin=1))
        fault = self._fault(values)
        if fault:
            raise ValueError(f"{control} must be {fault}")

    def one_of(self, *controls: str) -> str:
        """Return the control, or raise an error if it is not among these."""
        if self.control not in controls:
            raise ValueError(f"control must be one of {', '.join(controls)}, not {self.control!r}")
        return self.control

    def single(self) -> float:
        """Return the value of a single load; raise an error if there are several."""
        if self.values.size != 1:
            raise ValueError(f"{self.control} must be one number; use sweep for a list")
        return float(self.values[0])

    def positive(self) -> Array:
        """Return the values, or raise an error if one is not positive."""
        if not (self.values > 0).all():
            raise ValueError(f"{self.control} must be positive, not {self.values}")
        return self.values

    def _fault(self, prescribed: ArrayLike) -> str:
        if self.values.ndim != 1 or self.values.size == 0:
            return f"a number or a non-empty list, not shape {self.values.shape}"
        return "" if np.isfinite(self.values).all() else f"finite, not {prescribed!r}"


class Load(LoadPath):
    """Increasing loads of a contact: positive, strictly increasing.

    A zero mean gap is full contact, which does not determine the force, and is refused like any
    zero.

    Parameters
    ----------
    control : {"penetration", "force", "mean_gap"}
        What is prescribed.
    values : array_like, shape (k,)

    Examples
    --------
    >>> Load("force", [1, 2])
    Load(control='force', values=array([1., 2.]))
    """

    def _fault(self, prescribed: ArrayLike) -> str:
        fault = super()._fault(prescribed)
        if fault:
            return fault.replace("finite, not", "positive and finite, not")
        if not (self.values > 0).all():
            return f"positive and finite, not {prescribed!r}"
        increasing = bool((np.diff(self.values) > 0).all())
        return "" if increasing else f"strictly increasing, not {prescribed!r}"


class History(LoadPath):
    """Values of one prescribed quantity at increasing times, linear in between.

    Parameters
    ----------
    control : {"penetration", "force"}
    time, values : array_like, shape (k,)
        Finite, of equal length, with increasing times.
    """

    time: Array

    def __init__(self, control: str, time: ArrayLike, values: ArrayLike) -> None:
        object.__setattr__(self, "time", np.array(time, dtype=float, ndmin=1))
        super().__init__(control, values)

    def _fault(self, prescribed: ArrayLike) -> str:
        faults = [super()._fault(prescribed)]
        if self.time.shape != self.values.shape:
            faults.append(f"as long as its times, of which there are {self.time.size}")
        elif not (np.isfinite(self.time).all() and (np.diff(self.time) > 0).all()):
            faults.append(f"given at finite, increasing times, not {self.time!r}")
        return " and ".join(fault for fault in faults if fault)
