"""Make the tables of docs/adhesion.md: springs against closed forms, range, punches, grids.

Run from the repository's root (some three minutes on one core). Tables that the page shows are
written into it, others are printed; all of them, or those that are named::

    python docs/examples/adhesion_tables.py NAME
"""

# %%
import sys
from pathlib import Path

import numpy as np

from reduced.adhesion import adhere, pull_off
from reduced.loads import LoadPath
from reduced.profiles import equivalents
from reduced.springs.line import Springs
from reference import closed_form
from reference.closed_form.adhesive import AdhesiveForm, MaugisForm, strength_of
from reference.errors import ConvergenceError
from reference.halfspace import FreeOperator
from reference.halfspace.cohesive import (
    CohesiveLaw,
    CohesivePath,
    CohesiveProblem,
    dugdale,
    exponential,
    trace,
)
from reference.halfspace.detachment import Peeling, peel
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "adhesion.md"
WORK = 0.01

SHAPES = {
    "paraboloid": (
        equivalents.paraboloid(1.0),
        AdhesiveForm(closed_form.paraboloid(1.0, 1.0), WORK),
    ),
    "cone": (equivalents.cone(0.3), AdhesiveForm(closed_form.cone(0.3, 1.0), WORK)),
    "sphere": (equivalents.sphere(1.0), AdhesiveForm(closed_form.sphere(1.0, 1.0), WORK)),
    "r^4": (equivalents.power_law(4, 0.3), AdhesiveForm(closed_form.power_law(4, 0.3, 1.0), WORK)),
    "r^0.7": (
        equivalents.power_law(0.7, 0.3),
        AdhesiveForm(closed_form.power_law(0.7, 0.3, 1.0), WORK),
    ),
    "rounded punch": (
        equivalents.rounded_punch(1.0, 2.0),
        AdhesiveForm(closed_form.rounded_punch(1.0, 2.0, 1.0), WORK),
    ),
}


def percent(error: float) -> str:
    """Signed, two figures after the point."""
    return f"{100 * error:+.2f} %"


# %% [markdown]
# Springs against the closed forms: rms error of the pull-off force over random alignments.


# %%
def springs() -> list[list[str]]:
    """Pull-off force under both controls by springs per radius at zero load."""
    counts = (10, 20, 40, 80)
    rows = [["shape", "control", *map(str, counts), "order"]]
    offsets = np.random.default_rng(1).random(12)
    for name, (profile, form) in SHAPES.items():
        for control in ("force", "penetration"):
            exact = float(form.force(form.pull_off(control)))
            errors = []
            for count in counts:
                rows_of_springs = [Springs(profile, 1.0, count, offset=o) for o in offsets]
                pull_offs = [pull_off(row, WORK, control).before.force for row in rows_of_springs]
                errors.append(np.sqrt(np.mean((np.array(pull_offs) / exact - 1) ** 2)))
            slope = np.polyfit(np.log(counts), np.log(errors), 1)[0]
            order = f"{-slope:.1f}" if errors[0] > 1e-12 else "exact"
            rows.append([name, control, *(f"{e:.0e}" for e in errors), order])
    return rows


def cycles() -> list[list[str]]:
    """Energy lost in the two jumps of a cycle, in units of pi w a^2 at pull-off."""
    rows = [["shape", "control", "lost at first touch", "lost at pull-off"]]
    for name, (profile, form) in SHAPES.items():
        for control in ("force", "penetration"):
            top = 0.5 if control == "force" else 0.1
            contact = adhere(Springs(profile, 1.0), WORK, LoadPath(control, [0.0, top, -10.0]))
            unit = np.pi * WORK * form.pull_off(control) ** 2
            lost = [f"{event.dissipated / unit:.3f}" for event in contact.events]
            rows.append([name, control, *lost])
    return rows


# %% [markdown]
# The range of adhesion: a paraboloid in Maugis' units, K = 1, R = 1, pi w = 1.


# %%
def ball_path(law: CohesiveLaw, points: int, side: float, steps: int = 40) -> CohesivePath:
    """Equilibrium path of the paraboloid on a grid."""
    operator, r = grid(points, side, 0.75)
    return trace(CohesiveProblem(operator, r**2 / 2, law), 0.3, -2.5, steps=steps)


def grid(points: int, side: float, modulus: float) -> tuple[FreeOperator, np.ndarray]:
    """Return an operator and distances from an axis off the grid."""
    step = side / points
    x = (np.arange(points) - (points - 1) / 2 + 0.13) * step
    y = (np.arange(points) - (points - 1) / 2 - 0.21) * step
    return FreeOperator((points, points), (step, step), modulus), np.hypot(x[:, None], y)


def ranges() -> list[list[str]]:
    """Pull-off by Maugis parameter, over the rule's."""
    rows = [
        [
            "lambda",
            "Maugis: force",
            "grid, constant tension",
            "grid, exponential",
            "Maugis: depth",
            "grid, constant tension",
            "grid, exponential",
        ]
    ]
    jkr_depth = 0.75 * np.pi ** (2 / 3) * (4 / 3) ** (2 / 3) / np.pi ** (2 / 3)
    for parameter in (0.1, 0.3, 0.5, 1.0, 1.5, 2.0, 3.0, 5.0, 20.0):
        work = 1 / np.pi
        strength = strength_of(1.0, 0.75, work, parameter)
        form = MaugisForm(1.0, 0.75, work, strength)
        force = float(form.force(form.pull_off())) / -1.5
        fold = form.pull_off("penetration")
        depth = f"{-float(form.penetration(fold)) / jkr_depth:.4f}" if fold > 0 else "no fold"
        laws = dugdale(work, strength), exponential(work, work / strength)
        entries = [ball_entries(law, parameter, jkr_depth) for law in laws]
        rows.append(
            [
                str(parameter),
                f"{force:.4f}",
                entries[0][0],
                entries[1][0],
                depth,
                entries[0][1],
                entries[1][1],
            ]
        )
    return rows


def ball_entries(law: CohesiveLaw, parameter: float, jkr_depth: float) -> tuple[str, str]:
    """Pull-off force and depth of the grid over the rule's, or why not."""
    if not 0.3 <= parameter <= 2.0:
        return "-", "-"
    # out to where nothing pulls: the ramp's end, or exp(-8), of the surface drawn up by one unit
    reach = law.reach * (8.0 if law.name == "exponential" else 1.2)
    try:
        path = ball_path(law, 96, 2 * np.sqrt(2 * (reach + 1.2)))
    except ConvergenceError:
        return "lost", "lost"
    force, depth = path.pull_off(), path.pull_off("penetration")
    return (f"{force[1] / -1.5:.4f}", f"{-depth[0] / jkr_depth:.4f}" if depth else "no fold")


# %% [markdown]
# The detachment rule against closed forms, by cells per radius.


# %%
def detachment() -> list[list[str]]:
    """Errors of the pull-off force of disc and paraboloid, by the two calibrations."""
    rows = [
        ["cells across", "disc, printed", "disc, edge", "paraboloid, printed", "paraboloid, edge"]
    ]
    ball = AdhesiveForm(closed_form.paraboloid(1.0, 1.0), WORK)
    exact = -np.sqrt(8 * np.pi * WORK), float(ball.force(ball.pull_off()))
    for cells in (16, 32, 48):
        row = [str(cells)]
        for case, radius in enumerate((1.0, 0.55)):
            operator, r = grid(cells + 4, (cells + 4) * 2 * radius / cells, 1.0)
            gap = r**2 / 2 if case else np.zeros(r.shape)
            for rule in ("printed", "edge"):
                way = peel(operator, gap, r < radius, WORK, rule=rule, until=0.3, tolerance=1e-6)
                row.append(percent(way.force[way.pull_off()] / exact[case] - 1))
        rows.append(row)
    return rows


# %% [markdown]
# Punches that are no discs, and ellipsoids: equal area, Gaussian radius, and the grid.


# %%
def punch_way(inside: np.ndarray, operator: FreeOperator, gap: np.ndarray) -> Peeling:
    """Peel a contact under the printed calibration."""
    return peel(operator, gap, inside, WORK, until=0.15, tolerance=1e-6)


def plane(cells: int, half: float) -> tuple[FreeOperator, np.ndarray, np.ndarray]:
    """Square cells over [-half, half]^2 and two cells more, coordinates off the grid, turned."""
    step = 2 * half / cells
    n = cells + 4
    x = (np.arange(n) - (n - 1) / 2 + 0.13) * step
    y = (np.arange(n) - (n - 1) / 2 - 0.21) * step
    return FreeOperator((n, n), (step, step), 1.0), x[:, None], y[None, :]


def turned(x: np.ndarray, y: np.ndarray, angle: float) -> tuple[np.ndarray, np.ndarray]:
    """Coordinates along axes turned by an angle."""
    c, s = np.cos(angle), np.sin(angle)
    return c * x + s * y, c * y - s * x


def punches() -> list[list[str]]:
    """Flat punches of the area of a unit disc: loads over those of the rule for that disc."""
    rows = [["punch", "turned", "first cell, force", "pull-off force", "pull-off penetration"]]
    disc = -np.sqrt(8 * np.pi * WORK)
    for name, outline in {
        "disc": lambda x, y: np.hypot(x, y) < 1,
        "ellipse 2:1": lambda x, y: np.hypot(x / 2**0.5, y * 2**0.5) < 1,
        "ellipse 4:1": lambda x, y: np.hypot(x / 2, y * 2) < 1,
        "square": lambda x, y: np.maximum(np.abs(x), np.abs(y)) < np.sqrt(np.pi) / 2,
    }.items():
        for angle in (0, 30) if name != "disc" else (0,):
            operator, x, y = plane(56, 2.05 if name == "ellipse 4:1" else 1.45)
            inside = outline(*turned(x, y, np.radians(angle)))
            way = punch_way(inside, operator, np.zeros(inside.shape))
            loads = (
                way.force[0] / disc,
                way.force[way.pull_off()] / disc,
                way.penetration[way.pull_off("penetration")] / (disc / 2),
            )
            rows.append([name, f"{angle} degrees", *(f"{value:.3f}" for value in loads)])
    return rows


def ellipsoids() -> list[list[str]]:
    """Pull-off of ellipsoids over that of the paraboloid of the Gaussian radius, same grid."""
    rows = [["radii", "pull-off force", "pull-off penetration"]]
    plain: tuple[float, float] | None = None
    for ratio in (1, 2, 4):
        operator, x, y = plane(40, 0.55 * ratio**0.35)
        gap = x**2 / (2 * ratio**0.5) + y**2 * ratio**0.5 / 2
        way = punch_way(gap < 0.55**2 / 2, operator, gap)
        loads = (
            float(way.force[way.pull_off()]),
            float(way.penetration[way.pull_off("penetration")]),
        )
        plain = loads if plain is None else plain
        rows.append([f"{ratio}:1", *(f"{a / b:.3f}" for a, b in zip(loads, plain, strict=True))])
    return rows


# %%
TABLES = {
    "springs": springs,
    "cycles": cycles,
    "ranges": ranges,
    "detachment": detachment,
    "punches": punches,
    "ellipsoids": ellipsoids,
}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
