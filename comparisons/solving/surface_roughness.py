"""Roughness of a surface: its radial spectrum, and statistics from the moments of it."""

from __future__ import annotations

import numpy as np

from comparisons.geometry.prepare import RoughGeometry
from comparisons.methods.normal.reduced_lines import whole_spectrum
from comparisons.solving.plan_record import Roughness

MOST_RINGS = 100


def roughness_of(geometry: RoughGeometry) -> Roughness:
    """Return spectrum and statistics of a surface.

    The isotropic spectrum C2D(q) is the mean over circles (19.23), thinned to equal steps in log q.
    Nayak's parameter is m0 m4/m2^2 = (3/2) <h^2> <(lap h)^2>/<|grad h|^2>^2, at least 1.5. Skewness
    and kurtosis are of the heights of a map; a Gaussian surface has 0 and 3. The spectrum of a free
    map is taken under a Hann window, because its opposite sides do not match.
    """
    spectrum = whole_spectrum(geometry)
    rings = spectrum.radial_average()
    ends = np.unique(np.geomspace(1, len(rings.count) + 1, MOST_RINGS).astype(int)) - 1
    weight = np.add.reduceat(rings.count, ends[:-1])
    wavenumber, density = (
        np.add.reduceat(values * rings.count, ends[:-1]) / np.maximum(weight, 0.5)
        for values in (rings.wavenumber, rings.density)
    )
    held = density > 0
    height, slope, curvature = spectrum.rms_height, spectrum.rms_slope, spectrum.rms_curvature
    heights = geometry.measured
    scaled = None if heights is None else (heights - heights.mean()) / heights.std()
    return Roughness(
        tuple(wavenumber[held].tolist()),
        tuple(density[held].tolist()),
        float(geometry.rms_height),
        float(geometry.rms_slope),
        float(curvature),
        float(1.5 * (height * curvature / slope**2) ** 2),
        *(() if scaled is None else (float(np.mean(scaled**power)) for power in (3, 4))),
    )
