"""The power spectrum of a rough surface, with its roughness statistics in the caption."""

from __future__ import annotations

import numpy as np

from comparisons import formatting as fmt
from comparisons.results.store import SceneRecord
from reports.plots.axes import log_axis, log_ticks, padded
from reports.plots.figure import Axis, Figure, Series
from reports.plots.style import INK, Look

SPECTRUM = Look("C2D", INK, size=5)


def roughness(scene: SceneRecord) -> list[Figure]:
    """Return the radial spectrum of the surface; nothing for indenters."""
    stored = scene.plan.get("roughness")
    if not stored or len(stored["wavenumber"]) < 2:
        return []
    wavenumber, density = (np.array(stored[name]) for name in ("wavenumber", "density"))
    longest, shortest = (fmt.with_unit(2 * np.pi / wavenumber[end], "m") for end in (0, -1))
    scale = fmt.Scale(1e-6, "1/µm")
    limits = padded(wavenumber, 0.05, 0.2)
    return [
        Figure(
            "roughness-spectrum",
            "Power spectrum of the surface",
            f"Mean of C2D over circles (19.23), waves from {longest} to {shortest}. "
            f"{_in_words(stored['statistics'])}",
            Axis(
                "wavenumber",
                "q",
                scale=scale,
                log=True,
                limits=limits,
                ticks=log_ticks(limits, lambda v: fmt.number(v, 1), factor=scale.factor),
            ),
            log_axis(
                "spectrum C2D / m⁴", padded(density, 0.05, 0.2), lambda v: fmt.number(v, 1), 6
            ),
            (Series(SPECTRUM, wavenumber, density, hover=SPECTRUM.label, width=1.0),),
            legend=False,
        )
    ]


def _in_words(statistics: dict[str, float]) -> str:
    """Return the statistics of a surface in a sentence."""
    curvature = fmt.prefix_for(1 / statistics["rms_curvature"], "m")
    radius = fmt.number(curvature.factor / statistics["rms_curvature"])
    text = (
        f"Rms height {fmt.with_unit(statistics['rms_height'], 'm')}, "
        f"rms slope h' = {fmt.number(statistics['rms_slope'])}, rms curvature 1/({radius} "
        f"{curvature.unit}), Nayak's parameter {fmt.number(statistics['nayak'])}"
    )
    if "skewness" not in statistics:
        return f"{text}."
    return (
        f"{text}; heights with skewness {fmt.number(statistics['skewness'], 2)} and kurtosis "
        f"{fmt.number(statistics['kurtosis'], 2)} (Gaussian: 0 and 3)."
    )
