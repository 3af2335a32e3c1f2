"""Draw docs/particle-wear.png: one asperity dragged over another, by stress, and its forces.

Run from the repository's root (a minute on one core)::

    python docs/examples/particle_wear.py
"""

# %%
from pathlib import Path

import matplotlib as mpl

mpl.use("Agg")
import matplotlib.pyplot as plt
import numpy as np

from comparisons.questions.experiments.asperities import Asperities
from reference.elasticity import von_mises

PICTURE = Path(__file__).resolve().parents[1] / "particle-wear.png"
SEEDS = 6
# Time steps over which forces are averaged.
SMOOTHED = 40


# %%
def main() -> None:
    """Write the picture, and print the means over seeds."""
    passes = [Asperities().drag(seed) for seed in range(SEEDS)]
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 3.6), layout="constrained")
    first = passes[0]
    cut = np.abs(first.stressed[:, 1]) < 1.5
    x, _, z = first.stressed[cut].T
    stress = von_mises(first.stress)[cut]
    marks = left.scatter(
        x, z, s=42, c=stress, vmax=np.quantile(stress, 0.98), edgecolors="k", lw=0.2
    )
    left.set(aspect="equal", xlabel="x / spacing", ylabel="z / spacing")
    left.set_title("von Mises stress at the largest force")
    figure.colorbar(marks, ax=left, label="stress / (k / spacing)")
    window = np.ones(SMOOTHED) / SMOOTHED
    for drag in passes:
        smooth = np.convolve(drag.force, window, "same")
        right.plot(drag.way, smooth, lw=0.8, color="tab:blue", alpha=0.5)
    mean = np.convolve(np.mean([drag.force for drag in passes], axis=0), window, "same")
    load = np.convolve(np.mean([drag.load for drag in passes], axis=0), window, "same")
    right.plot(first.way, mean, color="tab:blue", label="along (mean, and seeds)")
    right.plot(first.way, load, color="tab:orange", label="apart (mean)")
    right.axhline(0, color="k", lw=0.5)
    right.set(xlabel="way / spacing", ylabel="force / (k spacing)")
    right.legend(frameon=False)
    figure.savefig(PICTURE, dpi=110)
    for name in ("friction", "broken", "healed", "worn", "loose", "imbalance"):
        values = [getattr(drag, name) for drag in passes]
        print(f"{name}: {np.mean(values):.4g} +- {np.std(values, ddof=1) / len(values) ** 0.5:.2g}")
    print(f"spent on bonds: {np.mean([drag.spent / drag.work for drag in passes]):.2f} of the work")


if __name__ == "__main__":
    main()
