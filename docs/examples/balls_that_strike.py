"""Hold curves of Chung & Ooi (2011) against balls of the suite: the tables of docs/other-codes.md.

The data stay where they are: a folder with ``kratos_chung_ooi``, the curves as Kratos has digitised
them. Run from the repository's root; ``--cases`` prints every point; ``impacts`` solves impacts by
several methods::

    python docs/examples/balls_that_strike.py FOLDER
"""

# %%
import csv
import sys
import tomllib
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import NamedTuple

import numpy as np
from scipy.integrate import cumulative_trapezoid
from threadpoolctl import threadpool_limits

from comparisons.questions.experiments.friction import FRICTION, impact
from reference.elasticity import Material
from reference.fem.nodal_friction import follow, frictional_body
from reference.halfspace.friction import FrictionalPress, sweep
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.loads import LoadPath
from roughline import compare

MORE = Path(__file__).with_suffix(".toml")

# %% [markdown]
# In `impact` m, E*, R and the normal speed are 1.


# %%
class Curve(NamedTuple):
    """Points of a digitised curve, and ours at the same places."""

    name: str
    x: np.ndarray
    theirs: np.ndarray
    ours: np.ndarray

    @property
    def off(self) -> np.ndarray:
        """Differences over the largest value."""
        return (self.theirs - self.ours) / np.abs(self.theirs).max()


BALLS = {  # R, E*, m, v of tests 1 and 2
    1: (0.005, 0.5 * 48e9 / (1 - 0.2**2), 0.5 * 2800 * 4 / 3 * np.pi * 0.01**3, 20.0),
    2: (0.1, 70e9 / (1 - 0.3**2), 2699 * 4 / 3 * np.pi * 0.1**3, 0.2),
}


def normal_impact(folder: Path, test: int) -> Iterator[Curve]:
    """Two balls of glass at 20 m/s (test 1); aluminium on a rigid plane at 0.2 m/s (test 2).

    Hertz's law; the time course is that of springs. The second one does not begin at first touch:
    its centre is put to ours.
    """
    radius, modulus, mass, speed = BALLS[test]
    depth = (15 * mass * speed**2 / (16 * modulus * np.sqrt(radius))) ** 0.4
    way, force = np.loadtxt(folder / f"test{test}_force_kN_vs_displacement_um.dat").T
    hertz = 4e-3 / 3 * modulus * np.sqrt(radius) * (1e-6 * way) ** 1.5
    yield Curve(f"test {test}, force over displacement", way, force, hertz)
    time, force = np.loadtxt(folder / f"test{test}_force_kN_vs_time_us.dat").T
    course, depths, *_ = impact(1.0, 200, 101)
    microseconds = 1e6 * depth / speed * course / depths.max()
    centre = np.trapezoid(time * force, time) / np.trapezoid(force, time)
    shift = 0.0 if test == 1 else centre - microseconds[-1] / 2
    peak = 4e-3 / 3 * modulus * np.sqrt(radius) * depth**1.5
    there = np.interp(time - shift, microseconds, depths, 0.0, 0.0) / depths.max()
    yield Curve(f"test {test}, force over time", time, force, peak * there**1.5)


def spent(slope: np.ndarray, poisson_ratio: float, steps: int = 64) -> np.ndarray:
    """Return the tangential impulse of springs over 2 mu m v_z, by v_x/(mu v_z)."""
    ratio = 2 * (1 - poisson_ratio) / (2 - poisson_ratio)
    ways = [impact(ratio * one, steps, 801, poisson_ratio) for one in slope]
    return np.array([np.trapezoid(force, time) / (2 * FRICTION) for time, _, _, force in ways])


def oblique_impact(folder: Path) -> Iterator[Curve]:
    """Balls of corundum at 3.9 m/s by the angle (test 4), of steel by the slope (test 5).

    Springs conserve energy along the normal, where test 4 has 0.98: 1 % of what friction takes.
    """
    given = np.loadtxt(folder / "test4_oblique_reference.csv", delimiter=",", skiprows=1).T
    friction, radius = 0.092, 0.0025
    for place, name in ((0, "velocity"), (2, "rotation"), (4, "rebound")):
        angle, theirs = np.radians(given[place]), given[place + 1]
        slope, normal = np.tan(angle) / friction, 3.9 * np.cos(angle)
        lost = 2 * friction * normal * spent(slope, 0.23)
        turned = -2.5 * lost / radius
        along = 3.9 * np.sin(angle) - lost
        ours = {
            "velocity": along / (3.9 * np.sin(angle)),
            "rotation": turned,
            "rebound": np.degrees(np.arctan((along + radius * turned) / normal)),
        }[name]
        yield Curve(f"test 4, {name}", given[place], theirs, ours)
    with (folder / "test5_reference_incl_FEM.csv").open(encoding="utf-8") as stream:
        rows = list(csv.DictReader(stream))
    for name in ("Steel", "FEM"):
        x, y = np.array([(float(r["x"]), float(r["y"])) for r in rows if r["series"] == name]).T
        yield Curve(f"test 5, {name}", x, y, -5 * spent(x, 0.3))
    more = tomllib.loads(MORE.read_text(encoding="utf-8"))
    angle, theirs = np.array(more["test 4"]).T
    slope = np.tan(np.radians(angle)) / friction
    yield Curve("test 4, measured velocity", angle, theirs, 1 - 2 * spent(slope, 0.23) / slope)
    x, theirs = np.array(more["test 8"]).T
    yield Curve("test 8, sliding", x, theirs, x - 1)  # by mu times the normal impulse


Forces = Callable[[np.ndarray, np.ndarray], list[float]]
CORUNDUM = 0.23, 0.092  # of test 4: Poisson's ratio, friction


def on_cells(per_radius: int, coupled: bool) -> Forces:
    """Return the tangential forces of the half-space along penetrations and shifts."""
    poisson, friction = CORUNDUM
    count = 2 * int(np.ceil(1.08 * per_radius))
    constants = Compliance.of((1 - poisson) / 2, poisson)
    x = (np.arange(count) - (count - 1) / 2) / per_radius
    body = NormalAndTangential((count, count), (1 / per_radius, 1 / per_radius), constants)
    ball = FrictionalPress(body, (x[:, None] ** 2 + x**2) / 2, friction, coupled)
    return lambda depth, shift: [
        step.tangential_force
        for step in sweep(
            ball, LoadPath("penetration", depth), LoadPath("tangential_displacement", shift)
        )
    ]


def on_elements(per_radius: int) -> Forces:
    """Return those of finite elements."""
    poisson, friction = CORUNDUM
    body = frictional_body(1.0, Material(1 - poisson**2, poisson), elements=per_radius)
    gap = (body.points**2).sum(axis=1) / 2
    return lambda depth, shift: [
        step.tangential_force
        for step in follow(
            body,
            gap,
            friction,
            LoadPath("penetration", depth),
            LoadPath("tangential_displacement", shift),
        )
    ]


def left(angle: float, steps: int, forces: Forces) -> float:
    """Return the share of the tangential velocity that a ball of test 4 keeps.

    From the springs' path on, its own force is integrated again and again, as in `impact`.
    """
    (poisson, friction), slope = CORUNDUM, np.tan(np.radians(angle))
    ratio = 2 * (1 - poisson) / (2 - poisson)
    time, depth, shift, _ = impact(ratio * slope / friction, steps, 801, poisson)
    shift = shift * friction / FRICTION
    scale, touching = depth.max(), depth > 0
    touching[-1] = False
    force = np.zeros_like(time)
    for _ in range(40):
        force[touching] = forces(depth[touching] / scale, shift[touching] / scale)
        force[touching] *= scale**1.5
        speed = slope - 3.5 * cumulative_trapezoid(force, time, initial=0)
        moved = cumulative_trapezoid(speed, time, initial=0)
        change = np.abs(moved - shift).max() / np.abs(moved).max()
        shift = (shift + moved) / 2
        if change < 1e-4:
            return 1 - float(np.trapezoid(force, time)) / slope
    raise ArithmeticError(f"the impact did not converge: {change:.1e} of the way")


def curves(folder: Path) -> list[Curve]:
    """Return all of them."""
    folder = folder / "kratos_chung_ooi"
    return [*normal_impact(folder, 1), *normal_impact(folder, 2), *oblique_impact(folder)]


def struck(folder: Path, test: int) -> str:
    """Return a line of the largest force: read off, and of each method at its finest."""
    radius, modulus, mass, speed = BALLS[test]
    scene = {
        "name": f"test-{test}",
        "half_space": {"effective_modulus": modulus},
        "indenter": {"shape": "paraboloid", "radius": radius},
        "dynamics": {"mass": mass, "velocity": speed},
    }
    read = np.loadtxt(folder / "kratos_chung_ooi" / f"test{test}_force_kN_vs_time_us.dat")
    methods = "reduced", "closed_form", "bem_fft", "fem"
    steps = compare(scene, *methods, quantities=["force"]).steps()
    finest = steps.groupby("method")["force"].last() / 1e3
    texts = [f"| test {test}", f"{read[:, 1].max():.3f}", *(f"{finest[m]:.4f}" for m in methods)]
    return " | ".join([*texts, ""]).strip()


def kept(angle: float) -> str:
    """Return a line of what a ball of test 4 keeps, each with the change from half of all."""
    slope = np.tan(np.radians(angle)) / CORUNDUM[1]
    springs = 1 - 2 * float(spent(np.array([slope]), CORUNDUM[0])[0]) / slope
    texts = [f"| {angle:g}°", f"{springs:.3f}"]
    for half, whole in (
        (on_cells(8, coupled=False), on_cells(16, coupled=False)),
        (on_cells(8, coupled=True), on_cells(16, coupled=True)),
        (on_elements(2), on_elements(4)),
    ):
        coarse, fine = left(angle, 16, half), left(angle, 32, whole)
        texts.append(f"{fine:.3f} ± {abs(fine - coarse):.3f}")
    return " | ".join([*texts, ""]).strip()


if __name__ == "__main__":
    threadpool_limits(limits=1)  # vectors are too short for threads
    source, *words = sys.argv[1:]
    folder, every = Path(source), "--cases" in words
    if "impacts" not in words:
        print("| curve | points | typical difference | largest | at |\n|---|---|---|---|---|")
        for curve in curves(folder):
            worst = np.abs(curve.off).argmax()
            typical, largest = 100 * np.sqrt(np.mean(curve.off**2)), 100 * curve.off[worst]
            place = f"{curve.x[worst]:.3g}"
            print(
                f"| {curve.name} | {curve.x.size} | {typical:.1f} % | {largest:+.1f} % | {place} |"
            )
            for point in zip(curve.x, curve.theirs, curve.ours, strict=True) if every else []:
                print("  {:.4g}: {:.4g}, ours {:.4g}".format(*point))
    else:
        print("| largest force, kN | read off | springs | closed form | half-space | elements |")
        print("|---|---|---|---|---|---|")
        for test in BALLS:
            print(struck(folder, test), flush=True)
        print("\n| angle | springs | half-space, uncoupled | coupled | elements |")
        print("|---|---|---|---|---|")
        for angle in (5.0, 10.0, 20.0):
            print(kept(angle), flush=True)
