"""Signs of errors on logarithmic axes: an arrow above a point, or below it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from reports.plots.figure import Series
from reports.plots.style import Marker

ABOVE, BELOW = Marker("arrow-up", 6), Marker("arrow-down", 7)  # their tips stand where they are put
SHARE = 0.035  # of the height of the axis, from the point to the tip
NOTE = "Arrows at the points: up, too large; down, too small."


def sign_marks(series: Series, errors: np.ndarray, low: float, high: float) -> list[Series]:
    """Return arrows above the points of positive errors, and below those of negative ones."""
    away = (high / low) ** SHARE
    shown = np.isfinite(series.y) & (series.y > low)
    return [
        replace(
            series,
            look=replace(series.look, label="", marker=marker),
            y=np.where(shown & (way * errors > 0), series.y * away**way, np.nan),
            line=False,
            hollow=False,
            hover=None,
            group=series.group or series.look.label,
            size=6,
        )
        for marker, way in ((ABOVE, 1), (BELOW, -1))
        if np.any(shown & (way * errors > 0))
    ]
