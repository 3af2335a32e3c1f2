"""Values as JSON knows them."""

from __future__ import annotations

import math
from typing import Any

import numpy as np


def plain(value: Any) -> Any:
    """Return JSON's types; NaN and infinities, which JSON does not know, become None.

    Examples
    --------
    >>> plain({"a": np.array([1.0, np.nan]), "b": (np.float64(2.0), "c")})
    {'a': [1.0, None], 'b': [2.0, 'c']}
    """
    if isinstance(value, dict):
        return {key: plain(each) for key, each in value.items()}
    if isinstance(value, (list, tuple)):
        return [plain(each) for each in value]
    if isinstance(value, (np.ndarray, np.generic)):
        return plain(value.tolist())
    if isinstance(value, float) and not math.isfinite(value):
        return None
    return value
