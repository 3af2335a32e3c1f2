"""Make the tables of docs/rolling.md: creep coefficients, creep curves, grids and their cost.

Run from the repository's root (three minutes on one core); the tables between the markers of the
page are written anew::

    python docs/examples/rolling_tables.py
"""

# %%
import time
from pathlib import Path

import numpy as np

from reduced.friction.roll import matched_modulus
from reduced.friction.roll import roll as roll_springs
from reduced.friction.slide import Friction
from reduced.loads import Load
from reduced.profiles.equivalents import paraboloid
from reduced.springs.line import Springs
from reference import loads as reference_loads
from reference.halfspace.cerruti import Compliance
from reference.halfspace.friction import FrictionalPress
from reference.halfspace.traction import NormalAndTangential
from reference.rolling.coefficients import creep_coefficients
from reference.rolling.contact import Creep, roll
from reference.rolling.theories import EllipticContact, fastsim, kalker, linear
from reports.tables.documents import rewrite

PAGE = Path(__file__).resolve().parents[1] / "rolling.md"
MU, NU = 0.3, 0.28
FORCE = 4 / 3  # a = R = E* = 1
SHEAR = (1 - NU) / 2
CREEPS = (0.002, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3)


def ball(cells: int) -> FrictionalPress:
    """Return the roller on so many cells per contact radius."""
    half = int(np.ceil(1.45 * cells))
    x = (np.arange(-half, half) + 0.5) / cells
    body = NormalAndTangential((x.size,) * 2, (1 / cells,) * 2, Compliance.of(SHEAR, NU))
    return FrictionalPress(body, (x[:, None] ** 2 + x**2) / 2, MU, coupled=False)


def tractions(cells: int, creeps: tuple[float, ...]) -> np.ndarray:
    """Return F_x/(mu F) on a grid."""
    load = reference_loads.Load("force", FORCE)
    steps = roll(ball(cells), load, [Creep(creep) for creep in creeps])
    return np.array([step.tangential_force for step in steps]) / (MU * FORCE)


# %% [markdown]
# Grids: tractions, and processor time of a creep; the limit is a straight line through the finest.


# %%
def grids() -> list[list[str]]:
    """Tractions of three creeps and the time for one."""
    rows = [["cells per radius", "ξ 0.002", "0.06", "0.2", "time of a creep"]]
    creeps, counts, answers = (0.002, 0.06, 0.2), (6, 8, 12, 16, 20, 24), []
    for cells in counts:
        started = time.process_time()
        answers.append(tractions(cells, creeps))
        seconds = (time.process_time() - started) / len(creeps)
        rows.append([str(cells), *(f"{value:.4f}" for value in answers[-1]), f"{seconds:.2f} s"])
    limit = np.polyfit(1 / np.array(counts[2:]), np.array(answers[2:]), 1)[1]
    rows.append(["limit", *(f"{value:.4f}" for value in limit), ""])
    return rows


def coefficients() -> list[list[str]]:
    """C11 and C22 over nu and a/b, beside Kalker's and the line's."""
    rows = [["ν", "a/b", "C11", "C22", "springs", "C11 of springs"]]
    for nu in (0.0, 0.25, 0.5):
        for ratio in (0.5, 1.0, 2.0):
            study, printed = creep_coefficients(nu, ratio), kalker(ratio, nu)
            values = [
                f"{value:.3f} ({known:.2f})"
                for value, known in zip(study.limit, printed, strict=True)
            ]
            line = 4 / (2 - nu)
            error = f"{100 * (line / study.limit[0] - 1):+.0f} %"
            rows.append([f"{nu:g}", f"{ratio:g}", *values, f"{line:.3f}", error])
    return rows


def curve() -> list[list[str]]:
    """Tractions of all methods over the creep, and their errors."""
    rows = [["ξ", "half-space", "springs", "matched", "FASTSIM", "linear"]]
    fine, coarse = tractions(24, CREEPS), tractions(12, CREEPS)
    true = np.minimum(2 * fine - coarse, 1.0)
    contact = EllipticContact((1.0, 1.0), SHEAR, NU, MU * FORCE)
    springs = Springs(paraboloid(1.0), 1.0, per_radius=100)
    plain = Friction(Compliance.of(SHEAR, NU).tangential_modulus, MU)
    matched = Friction(matched_modulus(SHEAR, kalker(1.0, NU)[0]), MU)
    load = Load("force", FORCE)
    stated = [
        roll_springs(springs, friction, load, CREEPS).tangential_force
        for friction in (plain, matched)
    ]
    stated += [
        np.array([theory(contact, creep).tangential_force for creep in CREEPS])
        for theory in (fastsim, linear)
    ]
    for place, creep in enumerate(CREEPS):
        errors = [values[place] / (MU * FORCE) / true[place] - 1 for values in stated]
        texts = [f"{100 * error:+.0f} %" for error in errors]
        rows.append([f"{creep:g}", f"{true[place]:.3f}", *texts])
    return rows


# %%
TABLES = {"grids": grids, "coefficients": coefficients, "curve": curve}

if __name__ == "__main__":
    rewrite(PAGE, TABLES)
