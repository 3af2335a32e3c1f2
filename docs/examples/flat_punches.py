"""The table of docs/half-space.md: stiffness of flat faces against cells, and its bar.

python docs/examples/flat_punches.py
"""

from __future__ import annotations

from pathlib import Path

import numpy as np

from comparisons.judging.truth import choose_truth
from comparisons.scene.scene import parse_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

LEVELS = (16, 32, 64, 128)
CORNERS = {
    "square": [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]],
    "triangle": [[0.0, 0.0], [1.0, 0.0], [0.5, 0.75**0.5]],
    "L-shape": [[0.0, 0.0], [1.0, 0.0], [1.0, 0.5], [0.5, 0.5], [0.5, 1.0], [0.0, 1.0]],
}


def polygon(name: str, degrees: float) -> str:
    """Return the indenter of a scene: a polygon turned against the grid."""
    a = np.radians(degrees)
    turned = np.array(CORNERS[name]) @ [[np.cos(a), np.sin(a)], [-np.sin(a), np.cos(a)]]
    return f'shape = "polygon_punch"\nvertices = {turned.tolist()}'


SHAPES = {
    "disc": 'shape = "cylinder"\nradius = 1.0',
    "ellipse 2:1": 'shape = "elliptic_punch"\nsemi_axes = [1.0, 0.5]',
    **{f"{name}, {d}°": polygon(name, d) for name in CORNERS for d in (0, 17, 45)},
}


def row(name: str, indenter: str) -> str:
    """Return stiffness k/E* at each resolution, and the bar of the finest."""
    scene = f'name = "face"\n[half_space]\neffective_modulus = 1.0\n[indenter]\n{indenter}\n'
    scene += '[loading]\npenetration = [1e-3]\n[compare]\nquantities = ["stiffness"]\n'
    plan = plan_scene(parse_scene(scene, name, Path()))[0]
    solved = {("bem_fft", n): execute(task_of(plan, "bem_fft", n), 1) for n in LEVELS}
    truth = choose_truth(solved, plan.loads.axis, ("stiffness",))
    assert truth is not None
    values = [f"{solution.quantities['stiffness'][0, 0]:.5f}" for solution in solved.values()]
    bar = float(truth.bar("stiffness")[0])
    return f"| {name} | {' | '.join(values)} | {100 * bar:.3f} % |"


def main() -> None:
    """Print the table."""
    print("| face | " + " | ".join(f"N = {n}" for n in LEVELS) + " | bar of the last |")
    print("|---" * (len(LEVELS) + 2) + "|")
    for name, indenter in SHAPES.items():
        print(row(name, indenter))


if __name__ == "__main__":
    main()
