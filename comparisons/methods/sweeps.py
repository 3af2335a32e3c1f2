"""A load sweep that survives a load which fails."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

Step = TypeVar("Step")
Failure = TypeVar("Failure", bound=Exception)


def outcomes(
    sweep: Callable[[np.ndarray], Iterator[Step]], loads: np.ndarray, failure: type[Failure]
) -> Iterator[Step | Failure]:
    """Yield one outcome per load: the step, or the `failure` that took its place.

    A solver's sweep ends at the first load that fails; a new one starts at the next load.
    """
    done = 0
    while done < len(loads):
        try:
            for contact in sweep(loads[done:]):
                done += 1
                yield contact
        except failure as error:
            done += 1
            yield error
