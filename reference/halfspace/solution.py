"""A shape over a body in one argument."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from reference.contact.body import ElasticBody
from reference.contact.press import check_gap


@dataclass(frozen=True, eq=False)
class Press:
    """A rigid shape over a body: arguments of `reference.contact.press.press`."""

    operator: ElasticBody
    gap: NDArray[np.float64]
    hardness: float = np.inf

    def __post_init__(self) -> None:
        object.__setattr__(self, "gap", check_gap(self.operator, self.gap))
        if not self.hardness > 0:
            raise ValueError(f"hardness must be positive, not {self.hardness!r}")

    @property
    def lowest(self) -> float:
        """Gap at the point of first touch."""
        return float(self.gap.min())
