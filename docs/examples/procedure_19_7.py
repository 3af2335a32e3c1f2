"""The calculation procedure of section 19.7, step by step: the text as printed beside a correction.

Run from the repository's root::

    python docs/examples/procedure_19_7.py
"""

# %% [markdown]
# Step 1: a measured map. The built-in stand-in (64 x 64 points, 10 um) is levelled and its few
# undefined points filled, as every method of a scene would see it.

# %%
from pathlib import Path

import numpy as np

from comparisons.scene.scene import builtin_folder
from reduced.rough.procedure import Procedure, side_by_side
from reduced.rough.surface_spectrum import measured

SIDE, MODULUS = 10e-6, 100e9


def prepared_map(path: Path | None = None) -> np.ndarray:
    """Return heights in metres: mean plane removed, undefined points at their neighbours' mean."""
    file = path or builtin_folder() / "measured-map.csv"
    h = 1e-9 * np.genfromtxt(file, delimiter=",")
    while np.isnan(h).any():
        around = np.stack([np.roll(h, step, axis) for axis in (0, 1) for step in (-1, 1)])
        defined = np.isfinite(around)
        mean = np.where(defined, around, 0).sum(axis=0) / np.maximum(defined.sum(axis=0), 1)
        h = np.where(np.isnan(h) & defined.any(axis=0), mean, h)
    x, y = np.meshgrid(*(np.arange(n) for n in h.shape), indexing="ij")
    plane = np.stack([np.ones(h.size), x.ravel(), y.ravel()], axis=1)
    return h - (plane @ np.linalg.lstsq(plane, h.ravel(), rcond=None)[0]).reshape(h.shape)


# %% [markdown]
# Loads: fractions of E* A0 h', h' the rms of the full gradient by forward differences.

# %%
height = prepared_map()
cell = SIDE / height.shape[0]
gradient = np.sqrt(sum(np.mean(np.diff(height, axis=axis) ** 2) for axis in (0, 1))) / cell
LOADS = np.geomspace(1e-3, 1e-1, 5)
force = LOADS * MODULUS * SIDE**2 * gradient

# %% [markdown]
# Steps 2 to 5 and 7: power spectrum, one-dimensional spectrum by (19.26), rough lines, springs, and
# what follows from pressing them. Step 6 (sliding) is not part of this.

# %%
literal, corrected = side_by_side(measured(height, SIDE), MODULUS, force, realisations=50, seed=1)


# %%
def table(procedure: Procedure) -> str:
    """Results by load as lines of text."""
    area, length = procedure.ensemble["contact_area"], procedure.ensemble["contact_length"]
    ratios = ", ".join(f"{ratio:.3f}" for ratio in procedure.sums.ratio)
    lines = [
        f"{procedure.variant.name}: line/surface height, slope, curvature {ratios}",
        "F/(E* A0 h')  A/A0 (standard error)  length/L  contact size: median, 95 %"
        "  F/(A E*h')  stress/(E*h'): median, 95 %  no value",
    ]
    scale = MODULUS * gradient
    for step, load in enumerate(LOADS):
        share, error = area.mean[step] / SIDE**2, area.standard_error[step] / SIDE**2
        sizes = np.quantile(procedure.contact_sizes[step], [0.5, 0.95]) / SIDE
        pressure = np.quantile(procedure.pressures[step], [0.5, 0.95]) / scale
        lines.append(
            f"{load:12.2e}  {share:9.4f} ({error:.4f})  {length.mean[step] / SIDE:19.3f}"
            f"  {sizes[0]:20.4f} L {sizes[1]:.4f} L  {procedure.mean_pressure[step] / scale:9.3f}"
            f"  {pressure[0]:15.3f} {pressure[1]:7.3f}"
            f"  {100 * procedure.undefined_share[step]:8.0f} %"
        )
    return "\n".join(lines)


if __name__ == "__main__":
    print(table(literal), table(corrected), sep="\n\n")
