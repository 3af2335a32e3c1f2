"""Draw docs/stress-below.png: von Mises stress below a rough contact, in a section and by depth.

Run from the repository's root (seconds; needs the extra `paper`)::

    python docs/examples/stress_below_figure.py
"""

# %%
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from comparisons.questions.experiments.rough_ensemble import Surface, press
from reference.elasticity import Material
from reference.layered import Stack
from reference.layered.stresses import inside

PICTURE = Path(__file__).resolve().parents[1] / "stress-below.png"
LOAD, FACTOR = 0.03, 8

# %%
surface = Surface(32, shortest=4.0, periodic=True)
operator = surface.operator(FACTOR)
contact, _ = press(operator, surface.heights(0, FACTOR), LOAD)
wave = surface.shortest / surface.points
depths = np.append(1e-6, np.linspace(0.02, 1.5, 75)) * wave
body = Stack([], [], Material(1 - 0.3**2, 0.3))
stress = np.array(
    [field.von_mises for field in inside(body, contact.pressure, operator.spacing, depths)]
)
_, row, _ = np.unravel_index(int(stress.argmax()), stress.shape)

# %%
figure, (section, profile) = plt.subplots(
    1, 2, figsize=(7.0, 2.4), width_ratios=(3, 1), sharey=True, layout="constrained"
)
x = (np.arange(stress.shape[2]) + 0.5) / stress.shape[2] / wave
shown = section.pcolormesh(x, depths / wave, stress[:, row], cmap="viridis", rasterized=True)
section.set(xlabel="x over the shortest wave", ylabel="depth over the shortest wave")
section.invert_yaxis()
figure.colorbar(shown, ax=section, label="von Mises over E* h'")
profile.plot(stress.max(axis=(1, 2)), depths / wave)
profile.set(xlabel="largest over E* h'", xlim=(0, None))
figure.savefig(PICTURE, dpi=130)
