"""Make the height map of the built-in scene `measured-map`: a stand-in, not a measurement.

Ground metal has grooves along the grinding direction, a fine random texture, a slight tilt from
mounting, and points where the instrument saw nothing. roughline ships no measured surface, so
this file imitates one; it is read and treated exactly like a real map.

Run from the repository's root to write the file anew::

    python docs/examples/stand_in_map.py comparisons/scene/built_in/measured-map.csv
"""

# %%
import sys

import numpy as np

POINTS = 64
SIDE = 10e-6


def ground_surface(points: int = POINTS, side: float = SIDE, seed: int = 7) -> np.ndarray:
    """Return heights in nanometres, shape (points, points), NaN where nothing was measured."""
    rng = np.random.default_rng(seed)
    qx, qy = np.meshgrid(*[2 * np.pi * np.fft.fftfreq(points, side / points)] * 2, indexing="ij")
    # Grooves along y: waves across them are longer-lived than waves along them.
    q = np.hypot(qx, 3 * qy)
    roll_off = 2 * np.pi / (side / 4)
    # The optics blur what is shorter than four pixels.
    blur = np.exp(-((np.hypot(qx, qy) * 4 * side / points / (2 * np.pi)) ** 2))
    spectrum = blur * np.maximum(q, roll_off) ** -1.8 * (q > 0)
    heights = np.fft.ifft2(spectrum * np.fft.fft2(rng.standard_normal((points, points)))).real
    heights *= 40 / heights.std()
    tilt = np.linspace(0, 120, points)
    heights = heights + tilt[:, None]
    holes = rng.random((points, points)) < 0.004
    return np.where(holes, np.nan, np.round(heights, 2))


# %%
if __name__ == "__main__":
    np.savetxt(sys.argv[1], ground_surface(), fmt="%.2f", delimiter=",")
