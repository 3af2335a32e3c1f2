"""Make tables of two pages: the law (19.1), docs/friction.md; impacts, docs/rubber-and-impact.md.

Run from the repository's root (about a minute on one core). Tables that the page shows are written
into it, others are printed; all of them, or those that are named::

    python docs/examples/friction_and_impact_tables.py NAME
"""

# %%
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np
from scipy.integrate import solve_ivp

from comparisons.questions.experiments import coulomb, vibrations
from comparisons.questions.experiments.coulomb import follow, march, stick_slip
from reduced.motion import blocks as law
from reduced.motion.blocks import Blocks, integrate
from reduced.motion.course import Mass, Push, Stepping, move
from reduced.motion.elastic_impact import SpringContact, impact_depth, strike
from reduced.profiles.equivalents import (
    cone,
    cylinder,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
)
from reduced.springs.line import Springs
from reference import closed_form
from reference.dynamics import collision
from reports.tables.written import rewrite

PAGES = Path(__file__).resolve().parents[1]


def seconds(task: Callable[[], object], repeats: int = 3) -> float:
    """Processor time of a task on warm code: the least of some runs."""
    readings = []
    for _ in range(repeats + 1):
        start = time.process_time()
        task()
        readings.append(time.process_time() - start)
    return min(readings[1:])


# %% [markdown]
# A block on a slope: mass 1, friction limit 1, pulled by F. Coulomb: rest. (19.1): creep.


# %%
def slope() -> list[list[str]]:
    """Creep speed over v0, by formula and as stepped, and the force that the law settles at."""
    rows = [["F/(mu F_N)", "creep/v0, formula", "stepped", "friction/F - 1", "Moreau-Jean"]]
    for load in (0.1, 0.5, 0.9, 0.99, 0.999):
        v0 = 1e-3
        run = integrate(Blocks(1.0, 1.0, load=load), v0, Stepping(1.0, 20_000))
        speed = (run.position[-1, 0] - run.position[-2, 0]) / v0
        force = float(law.friction(run.velocity[-1, 0], 1.0, v0))
        still = march(coulomb.Blocks(1.0, 1.0, load=load), step=1.0, steps=20_000)
        formula = float(law.creep_speed(load, 1.0, v0)) / v0
        cells = [f"{load}", f"{formula:.4f}", f"{speed:.4f}", f"{force / load - 1:.0e}"]
        rows.append([*cells, f"{still.position[-1, 0]:.0f}"])
    return rows


def stopping() -> list[list[str]]:
    """Way to rest of a sled from the speed V over that of Coulomb's law, less 1."""
    rows = [["v0/V", "way to rest - 1", "4/pi v0/V", "kinetic friction - 1 at V"]]
    for v0 in (1e-1, 1e-2, 1e-3, 1e-4):
        u, weights = np.polynomial.legendre.leggauss(200)
        v = ((u + 1) / 2) ** 3  # dense where the law bends
        measure = weights / 2 * 3 * ((u + 1) / 2) ** 2
        way = float((v / law.friction(v, 1.0, v0)) @ measure)
        lack = float(law.missing_friction(1.0, v0))
        rows.append([f"{v0:g}", f"{2 * way - 1:.3e}", f"{4 / math.pi * v0:.3e}", f"{-lack:.3e}"])
    return rows


# %% [markdown]
# The largest stable step, found by bisection, over that of theory.


# %%
def grows(scheme: str, load: float, step: float) -> bool:
    """Whether a small deviation from the creep grows."""
    v0 = 1e-3
    creep = float(law.creep_speed(load, 1.0, v0))
    system = Blocks(1.0, 1.0, load=load)
    start = creep + 1e-6 * v0
    run = integrate(system, v0, Stepping(step, 4000), scheme=scheme, velocity=start)
    return bool(abs(run.velocity[-1, 0] - creep) > abs(start - creep))


def stability() -> list[list[str]]:
    """Measured over theory, for three explicit schemes and loads."""
    loads = (0.0, 0.5, 0.9)
    rows = [["scheme", *(f"F = {load} mu F_N" for load in loads), "h mu F_N/(m v0) at rest"]]
    for scheme in ("explicit_euler", "semi_implicit_euler", "runge_kutta_4"):
        cells = [scheme]
        for load in loads:
            theory = law.stable_step(1.0, 1.0, 1e-3, load, scheme)
            low, high = 0.5 * theory, 2 * theory
            for _ in range(14):
                middle = 0.5 * (low + high)
                low, high = (low, middle) if grows(scheme, load, middle) else (middle, high)
            cells.append(f"{low / theory:.4f}")
        at_rest = law.stable_step(1.0, 1.0, 1e-3, 0.0, scheme) / 1e-3
        rows.append([*cells, f"{at_rest:.4f}"])
    return rows


# %% [markdown]
# A stick-slip oscillator with one coefficient of friction: m = k = 1, P = 1, W = 0.4, mu F_N = 0.9;
# it stops twice per period. Largest error of the position over t = 60, over the largest position.

# %%
FORCED = {"stiffness": 1.0, "amplitude": 1.0, "frequency": 0.4}
LIMIT, END = 0.9, 60.0
SAMPLES = np.linspace(0, END, 2001)


def exact() -> np.ndarray:
    """Positions by events."""
    return follow(coulomb.Blocks(1.0, LIMIT, **FORCED), END).at(SAMPLES)[0][:, 0]


def law_error(v0: float) -> float:
    """Error of the law itself: solved by Radau's method to 1e-9."""

    def rates(t: float, y: np.ndarray) -> list[float]:
        push = math.cos(FORCED["frequency"] * t) - y[0]
        return [y[1], push - 2 / math.pi * LIMIT * math.atan(y[1] / v0)]

    run = solve_ivp(rates, (0, END), [0, 0], method="Radau", rtol=1e-9, atol=1e-12, t_eval=SAMPLES)
    truth = exact()
    return float(np.abs(run.y[0] - truth).max() / np.abs(truth).max())


def oscillator_law() -> list[list[str]]:
    """Error of the law against v0, and the order in v0 between the rows."""
    rows = [["v0 w/P k", "error of the law", "order in v0"]]
    last = None
    for v0 in 10.0 ** np.arange(-1, -7, -1):
        error = law_error(v0)
        order = "" if last is None else f"{math.log10(last / error):.2f}"
        rows.append([f"{v0:.0e}", f"{error:.1e}", order])
        last = error
    return rows


def oscillator_cost() -> list[list[str]]:
    """Error against cost of every way to step."""
    rows = [["method", "v0", "steps", "law evaluations", "seconds", "error"]]
    truth = exact()
    system, set_valued = Blocks(1.0, LIMIT, **FORCED), coulomb.Blocks(1.0, LIMIT, **FORCED)

    def add(name: str, speed: str, steps: int, run: Callable[[], object]) -> None:
        solution = run()
        at = np.interp(SAMPLES, solution.time, solution.position[:, 0])
        error = np.abs(at - truth).max() / np.abs(truth).max()
        cells = [name, speed, f"{steps}", f"{solution.evaluations}"]
        rows.append([*cells, f"{seconds(run):.1e}", f"{error:.1e}"])

    for scheme in ("explicit_euler", "runge_kutta_4"):
        for v0 in (1e-2, 1e-3, 1e-4):
            step = 0.9 * law.stable_step(1.0, LIMIT, v0, 0.0, scheme)
            steps = math.ceil(END / step)
            add(scheme, f"{v0:g}", steps, stepping(system, v0, steps, scheme))
    for scheme, v0 in (("implicit_euler", 1e-6), ("implicit_midpoint", 1e-6)):
        for steps in (1000, 10_000, 100_000):
            add(scheme, f"{v0:g}", steps, stepping(system, v0, steps, scheme))
    for steps in (1000, 10_000, 100_000):
        run = marching(set_valued, steps)
        add("Moreau-Jean", "none", steps, run)
    phases = len(follow(set_valued, END).phases)
    cost = seconds(lambda: follow(set_valued, END), 1)
    rows.append(["events", "none", f"{phases} phases", "", f"{cost:.1e}", "round-off"])
    return rows


def stepping(system, v0: float, steps: int, scheme: str) -> Callable[[], object]:
    """Return a run of the regularised law."""
    return lambda: integrate(system, v0, Stepping(END / steps, steps), scheme=scheme)


def marching(system, steps: int) -> Callable[[], object]:
    """Return a run of the set-valued law in steps."""
    return lambda: march(system, step=END / steps, steps=steps)


# %% [markdown]
# A mass on a belt, m = k = V = 1, kinetic friction 1: static friction 1.3 times that, or the same.


# %%
def belt() -> list[list[str]]:
    """Half the swing of the position in the tenth period, and the period."""
    rows = [["mu_s/mu_k", "law", "swing", "swing after 10 cycles", "sticking, share of the cycle"]]
    for ratio in (1.3, 1.0):
        cycle = stick_slip(1.0, 1.0, 1.0, ratio, 1.0)
        half = 0.5 * (cycle.largest - cycle.smallest)
        system = coulomb.Blocks(1.0, 1.0, static=ratio, stiffness=1.0, belt=1.0)
        end = 12 * cycle.period
        start = {"position": 1.0, "velocity": 1.0}
        run = march(system, step=end / 120_000, steps=120_000, **start)
        late = run.position[100_000:, 0]
        stick = float(np.mean(run.velocity[100_000:, 0] == 1.0))
        swing = 0.5 * (late.max() - late.min())
        rows.append([f"{ratio}", "Coulomb", f"{half:.4f}", f"{swing:.4f}", f"{stick:.3f}"])
    soft = Blocks(1.0, 1.0, stiffness=1.0, belt=1.0)
    for v0 in (1e-2, 1e-4):
        run = integrate(
            soft, v0, Stepping(end / 120_000, 120_000), scheme="implicit_midpoint", **start
        )
        swing = 0.5 * np.ptp(run.position[100_000:, 0])
        rows.append(["1.0", f"(19.1), v0 = {v0:g} V", f"{half:.4f}", f"{swing:.4f}", "0"])
    return rows


# %% [markdown]
# Impact of a rigid mass: the springs by energy against closed forms and quadrature.

# %%
IMPACTS = {
    "paraboloid": (paraboloid(1.0), closed_form.paraboloid(1.0, 1.0)),
    "cone": (cone(0.3), closed_form.cone(0.3, 1.0)),
    "flat punch": (cylinder(0.1), closed_form.cylinder(0.1, 1.0)),
    "power law, n = 4": (power_law(4, 0.5), closed_form.power_law(4, 0.5, 1.0)),
    "power law, n = 1.5": (power_law(1.5, 0.5), closed_form.power_law(1.5, 0.5, 1.0)),
    "sphere, a to 0.5 R": (sphere(1.0), closed_form.sphere(1.0, 1.0)),
    "rounded punch, b = 0.4 a": (rounded_punch(0.1, 1.0), closed_form.rounded_punch(0.1, 1.0, 1.0)),
}
SPEEDS = {"sphere, a to 0.5 R": 0.2, "rounded punch, b = 0.4 a": 0.02}


def impacts() -> list[list[str]]:
    """Duration and largest force: relative errors with 10 and 40 springs per radius."""
    rows = [["shape", "T v/x_m", "edges", "T at 10", "T at 40", "force at 10", "force at 40"]]
    for name, (profile, form) in IMPACTS.items():
        speed = SPEEDS.get(name, 0.01)
        true = collision.collide(form, 1.0, speed)
        for edges in ("sub_cell", "nodal"):
            collisions = [
                strike(Springs(profile, 1.0, per_radius=n, edges=edges), 1.0, [speed])
                for n in (10, 40)
            ]
            times = [f"{f.duration[0] / true.duration - 1:+.0e}" for f in collisions]
            forces = [f"{f.force[0] / true.force - 1:+.0e}" for f in collisions]
            number = true.duration * speed / true.penetration
            rows.append([name, f"{number:.5f}", edges, *times, *forces])
    return rows


def impact_steps() -> list[list[str]]:
    """Paraboloid in steps of time: errors of duration and restitution, cost, order."""
    rows = [["scheme", "steps", "duration", "order", "restitution - 1", "law evaluations", "us"]]
    profile, speed = paraboloid(1.0), 0.01
    true = collision.power_law_collision(2, 0.5, 1.0, 1.0, speed).duration
    contact = SpringContact(Springs(profile, 1.0), impact_depth(profile, 1.0, 0.5 * speed**2))
    for scheme in ("verlet", "yoshida", "energy"):
        last = None
        for steps in (10, 40, 160, 640, 2560):
            step = true / (steps - 0.37)

            def run(scheme: str = scheme, step: float = step, steps: int = steps) -> object:
                return move(
                    contact, Mass(1.0, velocity=speed), Stepping(step, steps + 2), scheme=scheme
                )

            impact = run()
            duration, parting = impact.release()
            error = abs(duration / true - 1)
            order = "" if last is None else f"{math.log(last / error, 4):.1f}"
            back = f"{-parting / speed - 1:+.0e}"
            cost = f"{1e6 * seconds(run):.0f}"
            rows.append(
                [scheme, f"{steps}", f"{error:.1e}", order, back, f"{impact.evaluations}", cost]
            )
            last = error
    cost = seconds(lambda: strike(Springs(profile, 1.0), 1.0, [speed]))
    error = strike(Springs(profile, 1.0), 1.0, [speed]).duration[0] / true - 1
    rows.append(["by energy", "none", f"{abs(error):.0e}", "", "0", "", f"{1e6 * cost:.0f}"])
    return rows


# %% [markdown]
# A ball pressed by F0 with m = k = 1 (R = E* = 1, F0 = 1/6, d0 = 1/4).

# %%
BALL = closed_form.paraboloid(1.0, 1.0)
LOAD, DEPTH = 1 / 6, 0.25


def backbone() -> list[list[str]]:
    """Frequency of free vibrations over that of small ones, against the largest penetration."""
    rows = [["deepest/d0", "flight", "springs in steps", "by energy", "1 - (A/d0)^2/24"]]
    limit = vibrations.deepest_without_flight(BALL, LOAD) / DEPTH
    for deepest in (1.01, 1.1, 1.5, limit, 2.0, 3.0):
        period = vibrations.free_period(BALL, 1.0, LOAD, deepest * DEPTH)
        contact = SpringContact(Springs(paraboloid(1.0), 1.0), deepest * DEPTH)
        steps = 4000
        run = move(
            contact,
            Mass(1.0, position=deepest * DEPTH),
            Stepping(1.5 * period / steps, steps),
            Push(load=LOAD),
        )
        v, h = run.velocity, 1.5 * period / steps
        k = np.flatnonzero((v[1:-1] > 0) & (v[2:] <= 0))[0] + 1
        stepped = run.time[k] + h * v[k] / (v[k] - v[k + 1])
        amplitude = 0.5 * (deepest - run.position.min() / DEPTH)
        series = vibrations.power_backbone(2, amplitude)
        cells = [f"{deepest:.4g}", "yes" if deepest > limit else "no"]
        numbers = [f"{2 * math.pi / t:.6f}" for t in (stepped, period)]
        rows.append([*cells, *numbers, f"{series:.6f}" if deepest <= limit else "-"])
    return rows


def forced() -> list[list[str]]:
    """Amplitude over d0 at W = w0 with 5 % of critical damping, steady: springs, truth, linear."""
    rows = [
        ["P/F0", "springs in steps", "Runge-Kutta", "linear", "share in flight", "seconds, both"]
    ]
    contact = SpringContact(Springs(paraboloid(1.0), 1.0), 4 * DEPTH)
    per, damping = 1000, 0.1
    step = 2 * math.pi / per
    for share in (0.001, 0.03, 0.1, 0.15, 0.2, 0.3):
        start = time.process_time()
        true = vibrations.forced_vibration(
            *(BALL, 1.0, damping, LOAD, share * LOAD, 1.0), periods=80, tolerance=1e-9
        )
        middle = time.process_time()
        run = move(
            contact,
            Mass(1.0, damping, position=DEPTH),
            Stepping(step, 80 * per),
            Push(LOAD, amplitude=share * LOAD, frequency=1.0),
            scheme="verlet",
        )
        spent = f"{time.process_time() - middle:.2f}, {middle - start:.2f}"
        linear = vibrations.linear_amplitude(1.0, 1.0, 0.1, share * LOAD, 1.0)
        stepped = 0.5 * np.ptp(run.position[-per:])
        sizes = [f"{a / DEPTH:.5f}" for a in (stepped, true.amplitude, linear)]
        rows.append([f"{share}", *sizes, f"{true.flight:.3f}", spent])
    return rows


# %%
LAW = {
    "slope": slope,
    "stopping": stopping,
    "stability": stability,
    "oscillator-law": oscillator_law,
    "oscillator-cost": oscillator_cost,
    "belt": belt,
}
IMPACTS = {"impacts": impacts, "impact-steps": impact_steps, "backbone": backbone, "forced": forced}
TABLES = LAW | IMPACTS


# %%
if __name__ == "__main__":
    rewrite(PAGES / "friction.md", LAW, sys.argv[1:])
    rewrite(PAGES / "rubber-and-impact.md", IMPACTS, sys.argv[1:])
