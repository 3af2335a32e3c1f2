"""Make the table of docs/live-codes.md: a ball of 10 mm on steel in codes of others.

Run from the repository's root, all codes or those that are named; their interpreters by
``ROUGHLINE_PYTHON_DRAKE`` and so on::

    python docs/examples/live_codes.py NAME
"""

# %%
import sys

import numpy as np

import roughline
from comparisons.methods.registry import solver_for

# What a code is given: values up to a hundred (slippy: ten) times the first.
LOADS = {
    "drake": ("penetration", np.geomspace(2e-6, 2e-4, 5)),
    "slippy": ("penetration", np.geomspace(1e-6, 1e-5, 3)),
    "mujoco": ("force", np.geomspace(1.0, 100.0, 5)),
}


def row(name: str) -> list[str]:
    """Return a code's version, largest errors with the truth's bars, verdict at 1 %, and time."""
    control, values = LOADS[name]
    ball = roughline.load_scene(
        "paraboloid",
        {
            "loading": {control: values.tolist()},
            "compare.quantities": ["force", "penetration", "contact_area"],
            "compare.methods": ["closed_form", name],
        },
    )
    compared = roughline.compare(ball)
    table, steps = compared.table(), compared.steps()
    table = table[(table["method"] == name) & (table["at"] == control) & (table["maximum"] > 1e-6)]
    errors = [
        f"{at.quantity} {at.error:+.1%} ± {at.uncertainty:.1%} (load {at.step + 1:.0f})"
        for at in table.itertuples()
    ]
    seconds = steps[steps["method"] == name]["seconds"].iloc[0]
    version = solver_for(name, ball).note
    return [version, ", ".join(errors), compared.judged(name).word, f"{seconds:.1g} s"]


if __name__ == "__main__":
    for name in sys.argv[1:] or LOADS:
        print("| " + " | ".join(row(name)) + " |")
