"""Make the tables of docs/rubber-and-impact.md: springs, references, creep, impact, fits, cost.

Run from the repository's root (two minutes on one core). Tables that the page shows are written
into it, others are printed; all of them, or those that are named::

    python docs/examples/viscoelastic_tables.py NAME
"""

# %%
import sys
import time
from itertools import pairwise
from pathlib import Path

import numpy as np

from reduced.loads import LoadPath
from reduced.memory.in_time import graded_times, indent_in_time
from reduced.memory.in_time import impact as impact_on_springs
from reduced.memory.materials import fit, kelvin_voigt, prony, standard_solid
from reduced.memory.row import RelaxingSprings
from reduced.profiles.equivalents import cone, cylinder, paraboloid, power_law
from reference import closed_form
from reference.halfspace import FreeOperator
from reference.loads import History
from reference.viscoelastic import GeneralisedMaxwell, impact, indentation, press_in_time
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "rubber-and-impact.md"
SPRINGS = prony(1.0, [3.0, 2.0], [0.3, 5.0])
SOLID = GeneralisedMaxwell(1.0, [3.0, 2.0], [0.3, 5.0])
DEPTH = 0.01
# Ramp, rest, retreat at two speeds.
HISTORY = np.array([0.0, 1.0, 2.0, 2.4, 2.5])
DEPTHS = np.array([0.0, 1.0, 1.0, 0.65, 0.5]) * DEPTH
# In, rest, half out, rest while the surface comes after, in again.
AGAIN = np.array([0.0, 0.5, 1.0, 1.2, 2.0, 2.3])
AGAIN_DEPTHS = np.array([0.0, 1.0, 1.0, 0.3, 0.3, 0.9]) * DEPTH
BALL = closed_form.paraboloid(1.0, 1.0)


def cells(values: np.ndarray) -> list[str]:
    """Numbers in two digits."""
    return [f"{value:.1e}" for value in values]


# %% [markdown]
# Springs against Ting's integrals through unloading.


# %%
def ting() -> list[list[str]]:
    """Largest error over the kinks of the history: force over the largest force, and radius."""
    shapes = {
        "paraboloid": (paraboloid(1.0), BALL),
        "cone": (cone(0.2), closed_form.cone(0.2, 1.0)),
        "power law, n = 4": (power_law(4, 40.0), closed_form.power_law(4, 40.0, 1.0)),
        "flat punch": (cylinder(0.1), closed_form.cylinder(0.1, 1.0)),
    }
    springs = (10, 20, 40, 80, 160)
    rows = [["shape", "of", *(f"{n} springs" for n in springs), "order"]]
    for name, (profile, form) in shapes.items():
        exact = indentation(form, 1.0, SOLID, History("penetration", HISTORY, DEPTHS), HISTORY[1:])
        errors = []
        for n in springs:
            contact = indent_in_time(
                RelaxingSprings(profile, SPRINGS, per_radius=n),
                HISTORY,
                LoadPath("penetration", DEPTHS),
            )
            force = np.abs(contact.force[1:] - exact.force).max() / exact.force.max()
            radius = np.abs(contact.contact_radius[1:] / exact.contact_radius - 1).max()
            errors.append([force, radius])
        for quantity, column in zip(("force", "radius"), np.array(errors).T, strict=True):
            exactly = column.max() < 1e-12
            order = (
                "exact" if exactly else f"{-np.polyfit(np.log(springs), np.log(column), 1)[0]:.1f}"
            )
            rows.append([name, quantity, *cells(column), order])
    return rows


def steps_in_time() -> list[list[str]]:
    """Difference of the force from that with a thousand steps per piece of the history."""
    counts = (1, 3, 10, 100, 1000)

    def run(count: int) -> np.ndarray:
        pieces = pairwise(HISTORY)
        t = np.concatenate([[0.0], *(np.linspace(*ends, count + 1)[1:] for ends in pieces)])
        depth = np.interp(t, HISTORY, DEPTHS)
        return indent_in_time(
            RelaxingSprings(paraboloid(1.0), SPRINGS), t, LoadPath("penetration", depth)
        ).force[count::count]

    many = run(counts[-1])
    largest = [np.abs(run(count) / many - 1).max() for count in counts[:-1]]
    head = ["steps per piece", *map(str, counts[:-1])]
    return [head, ["largest difference of the force, relative", *cells(np.array(largest))]]


# %% [markdown]
# Creep under a force that jumps on and stays: A(d(t)) = J*(t) F.


# %%
def creep() -> list[list[str]]:
    """Largest error of the depth after a tenth of the time, over the last depth."""
    counts = np.array([10, 20, 40, 80])
    cases = {
        "solid, even steps": (SPRINGS, 1.0, 640),
        "Maxwell, even steps": (prony(0.0, [1.0], [0.7]), 1.0, 640),
        "Kelvin-Voigt, even steps": (kelvin_voigt(1.0, 0.5), 1.0, 40),
        "Kelvin-Voigt, graded T (k/n)^3": (kelvin_voigt(1.0, 0.5), 3.0, 40),
    }
    rows = [["material and steps", *(f"n = {n}" for n in counts), "order"]]
    for name, (material, exponent, springs) in cases.items():
        compliance = material.scaled(4).creep().compliance
        errors = []
        for n in counts:
            t, force = graded_times(2.0, int(n), exponent), np.full(n + 1, 0.02)
            contact = indent_in_time(
                RelaxingSprings(paraboloid(1.0), material, per_radius=springs),
                t,
                LoadPath("force", force),
            )
            exact = (0.75 * 0.02 * compliance(t)) ** (2 / 3)
            errors.append(np.abs(contact.penetration - exact)[t >= 0.2].max() / exact[-1])
        order = -np.polyfit(np.log(counts), np.log(errors), 1)[0]
        rows.append([name, *cells(np.array(errors)), f"{order:.1f}"])
    return rows


# %% [markdown]
# The half-space in time: no symmetry, no springs.


# %%
def ball_force(n: int, steps: int, history: np.ndarray, depths: np.ndarray) -> np.ndarray:
    """Force at the kinks of a history, n x n cells and a number of steps per piece."""
    reach = 0.115
    x = (np.arange(n) - n / 2 + 0.5) * (2 * reach / n)
    operator = FreeOperator((n, n), (2 * reach / n,) * 2, 1.0)
    pieces = pairwise(history)
    t = np.concatenate([[0.0], *(np.linspace(*ends, steps + 1)[1:] for ends in pieces)])
    gap = (x[:, None] ** 2 + x**2) / 2
    instants = press_in_time(
        operator, gap, SOLID, History("penetration", t, np.interp(t, history, depths))
    )
    return np.array([instant.force for instant in instants])[steps::steps]


def half_space() -> list[list[str]]:
    """Errors against Ting over the largest force, and differences from the springs in the other."""
    exact = indentation(
        BALL, 1.0, SOLID, History("penetration", HISTORY, DEPTHS), HISTORY[1:]
    ).force
    springs = indent_in_time(
        RelaxingSprings(paraboloid(1.0), SPRINGS, per_radius=320),
        AGAIN,
        LoadPath("penetration", AGAIN_DEPTHS),
    ).force[1:]
    rows = [["cells, steps per piece", "against Ting: largest error", "last difference", "touched "
             "again: largest difference from 320 springs", "last difference"]]  # fmt: skip
    before: tuple[np.ndarray, np.ndarray] | None = None
    for n, steps in ((16, 8), (32, 16), (64, 32), (128, 64)):
        out = ball_force(n, steps, HISTORY, DEPTHS) / exact.max()
        again = ball_force(n, steps, AGAIN, AGAIN_DEPTHS) / springs.max()
        bars = ["-", "-"]
        if before is not None:
            bars = cells([np.abs(out - before[0]).max(), np.abs(again - before[1]).max()])
        errors = (
            np.abs(out - exact / exact.max()).max(),
            np.abs(again - springs / springs.max()).max(),
        )
        first, second = cells(errors)
        rows.append([f"{n}², {steps}", first, bars[0], second, bars[1]])
        before = out, again
    return rows


# %% [markdown]
# Impact of a ball: springs in time against the initial value problem of Lee-Radok and Ting.


# %%
def impacts() -> list[list[str]]:
    """Restitution and its error over the steps per elastic duration; 160 springs per radius."""
    counts = (25, 50, 100, 200)
    rows = [["material", "restitution", *(f"{n} steps" for n in counts), "order"]]
    cases = {
        "elastic": ((0.25, [], []), 0.0),
        "standard, G₀ = G₁, τ = T/3": ((0.25, [0.25], [0.01]), 0.0),
        "Maxwell, τ = 2 T": ((0.0, [0.25], [0.05]), 0.0),
        "Kelvin-Voigt, η/G = T/15": ((0.25, [], []), 0.0005),
    }
    for name, (arms, viscosity) in cases.items():
        exact = impact(BALL, 1.0, GeneralisedMaxwell(*arms, viscosity), 1e-6, 1e-2)
        material = prony(*arms, viscosity=viscosity)
        errors = np.array(
            [
                impact_on_springs(
                    RelaxingSprings(paraboloid(1.0), material, per_radius=160), 1e-6, 1e-2, steps=n
                ).restitution
                - exact.restitution
                for n in counts
            ]
        )
        order = -np.polyfit(np.log(counts), np.log(np.abs(errors)), 1)[0]
        rows.append([name, f"{exact.restitution:.6f}", *cells(errors), f"{order:.1f}"])
    return rows


# %%
def fits() -> list[list[str]]:
    """Rms relative error of fits to a material that is no Prony series, over arms per decade."""
    w = np.geomspace(1e-2, 1e8, 201)
    # Rubber with a spectrum (Havriliak & Negami 1967): 1 MPa at rest, 1 GPa glassy.
    data = 1e9 - (1e9 - 1e6) / (1 + (1j * w * 1e-3) ** 0.6) ** 0.7
    rows = [["arms per decade", "arms kept", "rms error", "largest error"]]
    for per_decade in (0.5, 1.0, 1.5, 2.0, 3.0):
        fitted = fit(w, data, per_decade=per_decade)
        kept = f"{fitted.material.times.size}"
        rows.append([f"{per_decade}", kept, f"{fitted.rms_error:.2%}", f"{fitted.error.max():.2%}"])
    return rows


def cost() -> list[list[str]]:
    """Time per spring and step over that of one np.exp; medians of seven runs."""
    rows = [["material", "arms", "time per spring and step over one np.exp"]]
    t = np.linspace(0, 3, 3001)
    depth = np.interp(t, HISTORY, DEPTHS)
    numbers = np.linspace(-2, 0, 100_000)

    def median(work) -> float:
        seconds = []
        for _ in range(7):
            start = time.process_time()
            work()
            seconds.append(time.process_time() - start)
        return float(np.median(seconds))

    yardstick = median(lambda: np.exp(numbers)) / numbers.size
    five = prony(1.0, np.full(5, 1.0), np.geomspace(0.01, 10, 5))
    cases = {"standard": standard_solid(1.0, 1.0, relaxation_time=0.5), "Prony": five}
    for name, material in cases.items():

        def work(material=material):
            indent_in_time(
                RelaxingSprings(paraboloid(1.0), material, per_radius=200),
                t,
                LoadPath("penetration", depth),
            )

        work()
        seconds = median(work) / (t.size * 200)
        rows.append([name, f"{material.times.size}", f"{seconds / yardstick:.0f}"])
    return rows


# %%
TABLES = {
    "ting": ting,
    "steps": steps_in_time,
    "creep": creep,
    "half-space": half_space,
    "impacts": impacts,
    "fits": fits,
    "cost": cost,
}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
