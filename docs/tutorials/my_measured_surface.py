"""
My measured surface
===================

You have a height map and want to know its contact force, area and stiffness, and whether the fast
1-D model may be used for it. This tutorial goes from the file to a verdict.
"""

# %%
# A map
# -----
# roughline ships no measurement, so this script makes a stand-in: a self-affine surface with a
# tilt from mounting and two points that the instrument did not see. Your own file goes in its
# place: instrument formats (``.opd``, ``.di``, ``.sur``, ``.x3p`` ...) are read by
# SurfaceTopography and know their size; a table needs ``size`` and ``height_unit``.
import tempfile
from pathlib import Path

import numpy as np

import roughline

points, side = 32, 10e-6
rng = np.random.default_rng(1)
wave = 2 * np.pi * np.fft.fftfreq(points, side / points)
q = np.hypot(*np.meshgrid(wave, wave, indexing="ij"))
spectrum = np.maximum(q, 2 * np.pi / (side / 3)) ** -1.8 * (q > 0) * (q < 0.6 * q.max())
heights = np.fft.ifft2(spectrum * np.fft.fft2(rng.standard_normal((points, points)))).real
heights *= 40 / heights.std()
heights += np.linspace(0, 120, points)[:, None]
heights[5, 7] = heights[20, 11] = np.nan

folder = Path(tempfile.mkdtemp())
np.savetxt(folder / "scan.csv", heights, fmt="%.2f", delimiter=",")

# %%
# The scene
# ---------
# Loads of rough surfaces are best given relative to E* A0 h', with h' the rms slope of the map:
# they then mean the same on every surface. The map is read, levelled and filled *once*; every
# method gets the same heights.
scene = roughline.load_scene(
    {
        "name": "my-surface",
        "half_space": {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3},
        "surface": {
            "kind": "map",
            "file": str(folder / "scan.csv"),
            "size": "10 um",
            "height_unit": "nm",
            "undefined": "interpolate",
        },
        "loading": {"force": {"values": [0.003, 0.01, 0.03], "relative_to": "E* A0 h'"}},
        "compare": {
            "quantities": ["penetration", "contact_area", "mean_gap"],
            "tolerance": 0.1,
            "methods": ["reduced", "bem_fft"],
        },
    }
)

# %%
# Look before you solve: what will be modelled, what was done to the map, and what is left out.
planned = roughline.plan(scene)
for note in planned.plans[0].notes:
    print(note)

# %%
planned

# %%
# The comparison
# --------------
# The FFT half-space solver runs on grids of 32 to 256 points. The finest is the truth, and the
# others say how well it is known; the reduced model presses lines with the map's spectrum.
comparison = roughline.compare(scene)
comparison

# %%
# How to read it: each row has the largest error over the three loads, with the 95 % half-width of
# its bar, and a verdict at the 10 % that the scene asks for.
#
# - *FFT BEM* on 64 points is **within** 10 % for penetration, mean gap and area. The bar of its
#   error is that of the reference: ``full=True``, or a finer grid in ``resolutions``, narrows it.
# - The *reduced model* is **outside** for all three. Its lines know the map's spectrum and nothing
#   else of it. Averages over many surfaces of one spectrum agree with the lines in force and
#   penetration; a single map, whose highest peak decides where contact begins, need not.
# - The *area* is another matter: the lines overestimate it by more than a factor of two, on
#   averages as well, and no refinement of the lines changes that.
table = comparison.table().query("at == 'force'").set_index(["method", "resolution", "quantity"])
print(table.loc["reduced", ["maximum", "uncertainty", "verdict"]].to_string())
assert set(table.loc["reduced", "verdict"]) == {"outside"}
assert table.loc[("bem_fft", 64, "mean_gap"), "verdict"] == "within"
assert table.loc[("bem_fft", 64, "contact_area"), "verdict"] == "within"

# %%
# The curves of both methods, the errors along the loads, and what they cost:
comparison.plot()

# %%
# What to do
# ----------
# For this surface the half-space solver is the method to use: it needs well under a second.
answer = roughline.solve(scene, "bem_fft")
answer

# %%
# With ``"bem_dense"`` among the methods, a map larger than 16 x 16 points gets a second scene, a
# typical patch of it, on which the dense solver checks the FFT solver, too;
# ``comparison.patch`` has it. The same from the command line, with a report:
# ``roughline run my-surface.toml``.
