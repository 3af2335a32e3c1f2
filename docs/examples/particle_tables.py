"""Print the tables that docs/methods.md names: accuracy of cellular automata.

Run from the repository's root (ten minutes on one core), all or those that are named::

    python docs/examples/particle_tables.py hertz shapes bodies plastic first waves rough
"""

# %%
import sys
import time
from pathlib import Path

import numpy as np

from comparisons.questions.experiments.particles import wave_speeds
from comparisons.scene.scene import make_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference.elasticity import lame_parameters
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "methods.md"
NUMBERS = (2, 3, 4, 5, 6)
EXACT = ("closed_form", "bem_fft")
COUNTS = (3, 4, 5)
RATIOS = (-0.5, 0.0, 0.3, 0.45, 0.49)


# %%
def scene(indenter: dict[str, object], nu: float = 0.3) -> dict[str, object]:
    """Return the keys of a scene pressed 2 um deep."""
    return {
        "name": "particles",
        "half_space": {"youngs_modulus": "210 GPa", "poisson_ratio": nu},
        "indenter": indenter,
        "loading": {"penetration": [2e-6]},
        "compare": {"methods": [*EXACT, "mca"], "quantities": ["force", "contact_area"]},
    }


def errors(keys: dict[str, object], number: int) -> tuple[float, float, int, int, float]:
    """Return errors of force and radius, automata, steps and processor seconds."""
    (plan, *_) = plan_scene(make_scene(keys, "particles.toml", None))
    known = any(m.method == "closed_form" and m.supported for m in plan.methods)
    exact = execute(task_of(plan, *(("closed_form", 1) if known else ("bem_fft", 192)))).quantities
    start = time.process_time()
    solution = execute(task_of(plan, "mca", number))
    spent = time.process_time() - start
    force, area = (
        float(solution.quantities[q][0, 0] / exact[q][0, 0]) for q in ("force", "contact_area")
    )
    steps = int(solution.iterations[0, 0])
    return force - 1, float(np.sqrt(area)) - 1, solution.unknowns // 6, steps, spent


def per_cent(error: float) -> str:
    """Return a signed error in per cent."""
    return f"{100 * error:+.2f}"


def hertz() -> list[list[str]]:
    """Return the errors of the force on a ball over nu, and the cost at 0.3."""
    ball = {"shape": "paraboloid", "radius": "10 mm"}
    heads = [f"force, ν = {nu:g}" for nu in RATIOS]
    rows = [["N", *heads, "radius, ν = 0.3", "automata", "steps", "time"]]
    for number in NUMBERS:
        runs = {nu: errors(scene(ball, nu), number) for nu in RATIOS}
        _, radius, automata, steps, spent = runs[0.3]
        forces = [per_cent(run[0]) for run in runs.values()]
        cost = [str(automata), str(steps), f"{spent:.1f} s"]
        rows.append([str(number), *forces, per_cent(radius), *cost])
    return rows


SHAPES = {
    "cone": {"shape": "cone", "slope": 0.1},
    "f = c r⁴": {"shape": "power_law", "exponent": 4, "coefficient": 1e6},
    "rounded punch": {"shape": "rounded_punch", "flat_radius": "0.2 mm", "edge_radius": "10 mm"},
    "flat cylinder": {"shape": "cylinder", "radius": "1 mm"},
    "ellipsoid, radii 5 : 2": {"shape": "ellipsoid", "radius_x": "10 mm", "radius_y": "4 mm"},
    "elliptic punch 2 : 1": {"shape": "elliptic_punch", "semi_axes": ["1 mm", "0.5 mm"]},
    "square punch": {"shape": "square_punch", "side": "1 mm"},
    "rectangular punch 2 : 1": {"shape": "rectangle_punch", "sides": ["2 mm", "1 mm"]},
    "triangular punch": {
        "shape": "polygon_punch",
        "vertices": [["0 mm", "0 mm"], ["1 mm", "0 mm"], ["0.5 mm", "0.866 mm"]],
    },
}
SOFT = {"youngs_modulus": "30 GPa", "poisson_ratio": -0.2}


def shapes() -> list[list[str]]:
    """Return errors of force and radius of other shapes."""
    rows = [["shape", "force, N = 3", "N = 5", "radius, N = 3", "N = 5"]]
    for name, indenter in SHAPES.items():
        coarse, fine = (errors(scene(indenter), number) for number in (3, 5))
        rows.append([name, *map(per_cent, (coarse[0], fine[0], coarse[1], fine[1]))])
    return rows


def bodies() -> list[list[str]]:
    """Return errors of steel under a soft ball: one half-space of E*, and two of automata."""
    ball = scene({"shape": "paraboloid", "radius": "10 mm"}) | {"counter_body": SOFT}
    both = ball | {"methods": {"mca": {"coupling": "automata"}}}
    rows = [
        ["N", "force, E*", "both bodies", "radius, E*", "both bodies", "time, E*", "both bodies"]
    ]
    for number in NUMBERS[:-1]:
        single, pair = (errors(keys, number) for keys in (ball, both))
        parts = [per_cent(run[k]) for k in (0, 1) for run in (single, pair)]
        rows.append([str(number), *parts, *(f"{run[4]:.1f} s" for run in (single, pair))])
    return rows


def waves() -> list[list[str]]:
    """Return the largest errors of wave speeds over 1000 directions."""
    lame, shear = lame_parameters(0.3)
    exact = np.sqrt([shear, shear, lame + 2 * shear])
    vectors = np.random.default_rng(0).normal(size=(1000, 3))
    vectors /= np.linalg.norm(vectors, axis=1)[:, None]
    rows = [["wavelength in spacings", "transverse", "longitudinal"]]
    for length in (4, 8, 16, 32):
        off = [wave_speeds(0.3, 2 * np.pi / length * vector) / exact - 1 for vector in vectors]
        worst = [part.flat[np.argmax(np.abs(part))] for part in np.split(np.array(off), [2], 1)]
        rows.append([str(length), *(per_cent(float(error)) for error in worst)])
    return rows


def dent(depth: float, method: str, number: int, quantity: str) -> dict[str, float]:
    """Return force, dent and processor seconds of steel at a depth in units of 0.2126 um.

    That is d_y of p0 = 1.60 Y, Y = 420 MPa; the force in units of Hertz's there.
    """
    keys = scene({"shape": "paraboloid", "radius": "10 mm"})
    first, quantities = 0.2126e-6, ["force", "residual_depth"]
    keys |= {"plasticity": {"yield_stress": "420 MPa"}, "loading": {"penetration": [first * depth]}}
    wanted = [*quantities, "first_yield"] if quantity == "first_yield" else quantities
    keys["compare"] = {"methods": ["fem", "mca", "closed_form"], "quantities": wanted}
    (plan, *_) = plan_scene(make_scene(keys, "particles.toml", None))
    start = time.process_time()
    answer = execute(task_of(plan, method, number)).quantities
    spent = time.process_time() - start
    unit = 4 / 3 * 210e9 / 0.91 * np.sqrt(0.01) * first**1.5
    values = {q: float(answer[q][0, 0]) for q in wanted}
    return values | {"force": values["force"] / unit, "seconds": spent}


def plastic() -> list[list[str]]:
    """Return force and dent of automata that flow against finite elements, load by load."""
    heads = [f"N = {n}" for n in COUNTS]
    rows = [["d/d_y", "F/F_y", *heads, "d_res/d", *heads, "time", "elements"]]
    for depth in (2.0, 10.0, 60.0):
        truth = dent(depth, "fem", 8, "force")
        ours = [dent(depth, "mca", n, "force") for n in COUNTS]
        forces, left = (
            [per_cent(dented[name] / truth[name] - 1) for dented in ours]
            for name in ("force", "residual_depth")
        )
        share = truth["residual_depth"] / (0.2126e-6 * depth)
        times = [f"{dented['seconds']:.1f} s" for dented in (ours[-1], truth)]
        rows.append([f"{depth:g}", f"{truth['force']:.4g}", *forces, f"{share:.3f}", *left, *times])
    return rows


def first() -> list[list[str]]:
    """Return the penetration of first yield of automata and of elements against Hertz's field."""
    exact = dent(0.5, "closed_form", 1, "first_yield")["first_yield"]
    rows = [["N", "automata", "elements"]]
    for number in COUNTS:
        both = [dent(0.5, name, number, "first_yield")["first_yield"] for name in ("mca", "fem")]
        rows.append([str(number), *(per_cent(value / exact - 1) for value in both)])
    return rows


def rough() -> list[list[str]]:
    """Return a rough patch by automata against the half-space, both on the same points."""
    surface = {"kind": "self_affine", "hurst": 0.8, "size": "1 um", "points": 16}
    keys = scene({}) | {
        "surface": surface | {"rms_slope": 0.05, "periodic": False, "short_cutoff": "0.25 um"},
        "loading": {"penetration": [2e-9, 10e-9]},
        "compare": {"methods": ["bem_fft", "mca"], "quantities": ["force", "contact_area"]},
    }
    del keys["indenter"]
    (plan, *_) = plan_scene(make_scene(keys, "particles.toml", None))
    truth = execute(task_of(plan, "bem_fft", 128)).quantities
    rows = [["points", "force, 2 nm", "10 nm", "area, 2 nm", "10 nm", "automata", "time"]]
    for number in (16, 32):
        start = time.process_time()
        solution = execute(task_of(plan, "mca", number))
        spent = time.process_time() - start
        ratios = [solution.quantities[q][0] / truth[q][0] - 1 for q in ("force", "contact_area")]
        row = [per_cent(float(error)) for error in np.concatenate(ratios)]
        rows.append([str(number), *row, str(solution.unknowns // 6), f"{spent:.1f} s"])
    return rows


# %%
TABLES = {
    "hertz": hertz,
    "shapes": shapes,
    "bodies": bodies,
    "plastic": plastic,
    "first": first,
    "waves": waves,
    "rough": rough,
}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
