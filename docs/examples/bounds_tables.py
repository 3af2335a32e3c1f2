"""Make the tables of docs/bounds.md: enclosures, their width, their cost.

Run from the repository's root (half an hour on one core, most of it the rough contacts); the tables
between the markers of the page are written anew, and docs/problem-sheet.csv::

    python docs/examples/bounds_tables.py               # or only some: round order punches
"""

# %%
import csv
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple
from unittest import mock

import numpy as np

from comparisons.questions.experiments import proved
from reference import closed_form, surfaces
from reference.bounds import axisymmetric, bodies, homogeneous, outlines, punches
from reference.bounds.extension import Extension
from reference.bounds.interval import Interval
from reference.bounds.patches import Patch
from reference.bounds.periodic import PeriodicSurface
from reference.bounds.profiles import PowerLaw, RoundedPunch, Sphere, cone, paraboloid
from reference.halfspace import FreeOperator, fft
from reference.halfspace.solution import Press
from reference.loads import Load
from reports.tables.documents import rewrite

PAGE = Path(__file__).resolve().parents[1] / "bounds.md"
# The problem sheet as data: one row per problem and quantity, its interval rounded outwards.
SHEET_FILE = PAGE.with_name("problem-sheet.csv")
COLUMNS = ("problem", "definition", "quantity", "not below", "not above", "seconds")


class Cost(NamedTuple):
    """What a bound took: processor time, and unknowns of the largest mesh of finite elements."""

    seconds: float
    unknowns: int


def timed(work: Callable[[], Interval]) -> tuple[Interval, Cost]:
    """Return an interval and what it took."""
    meshes = [0]
    make = Extension.__init__

    def counted(self: Extension, *of: Any) -> None:
        make(self, *of)
        meshes.append(self.unknowns)

    with mock.patch.object(Extension, "__init__", counted):
        started = time.process_time()
        bounds = work()
        return bounds, Cost(time.process_time() - started, max(meshes))


def below(value: float) -> str:
    """Write a relative distance."""
    return f"{value:.1e}"


def outwards(bounds: Interval, digits: int) -> tuple[str, str]:
    """Write an interval with so many digits, never narrower than it is."""
    unit = 10.0**-digits
    lower, upper = math.floor(bounds.lower / unit) * unit, math.ceil(bounds.upper / unit) * unit
    return f"{lower:.{digits}f}", f"{upper:.{digits}f}"


def keep(problem: str, definition: str, quantity: str, bounds: Interval, seconds: float) -> None:
    """Write an interval of the problem sheet to its file, in place of one that is wider."""
    rows = {}
    if SHEET_FILE.exists():
        with SHEET_FILE.open(newline="", encoding="utf-8") as file:
            rows = {(row["problem"], row["quantity"]): row for row in csv.DictReader(file)}
    cells = (problem, definition, quantity, *outwards(bounds, 6), f"{seconds:.0f}")
    row = dict(zip(COLUMNS, cells, strict=True))
    before = rows.get((problem, quantity), row)
    if bounds.upper - bounds.lower <= float(before["not above"]) - float(before["not below"]):
        rows[problem, quantity] = row
    with SHEET_FILE.open("w", newline="", encoding="utf-8") as file:
        writer = csv.DictWriter(file, COLUMNS, lineterminator="\n")
        writer.writeheader()
        writer.writerows(rows.values())


def grid_seconds(gap: Callable[[np.ndarray, np.ndarray], np.ndarray], depth: float) -> float:
    """Seconds of the half-space solver on 128 x 128 cells about a contact of radius one."""
    x = (np.arange(128) - 63.5) / 50
    press = Press(FreeOperator((128, 128), (1 / 50, 1 / 50), 1.0), gap(x[:, None], x[None, :]))
    fft.solve(press, Load("penetration", depth))
    started = time.process_time()
    fft.solve(press, Load("penetration", depth))
    return time.process_time() - started


# %% [markdown]
# Bodies of revolution: the closed form lies inside.

ROUND = {
    "paraboloid": (paraboloid(1.0), closed_form.paraboloid(1.0, 1.0), 1.0),
    "cone": (cone(1.0), closed_form.cone(1.0, 1.0), 1.0),
    **{
        f"r^{n:g}": (PowerLaw(n, 1.0), closed_form.power_law(n, 1.0, 1.0), 1.0)
        for n in (1.5, 3.0, 4.0, 6.0)
    },
    "sphere, a/R = 0.1": (
        Sphere(1.0),
        closed_form.sphere(1.0, 1.0),
        0.1 * math.atanh(0.1),
    ),
    "sphere, a/R = 0.5": (
        Sphere(1.0),
        closed_form.sphere(1.0, 1.0),
        0.5 * math.atanh(0.5),
    ),
    "rounded punch, a/b = 1.2": (
        RoundedPunch(1.0, 1.0),
        closed_form.rounded_punch(1.0, 1.0, 1.0),
        0.1,
    ),
}


def round_bodies() -> list[list[str]]:
    """Energy and force of bodies of revolution."""
    rows = [
        [
            "body",
            "energy, below",
            "energy, above",
            "force, below",
            "force, above",
            "width of the force",
            "unknowns",
            "s",
        ]
    ]
    widths, costs = [], []
    for name, (profile, form, depth) in ROUND.items():
        stored = axisymmetric.energy(profile, depth, 1.0, cells=40)
        pressed, cost = timed(lambda p=profile, d=depth: axisymmetric.force(p, d, 1.0, cells=40))
        energy, force = float(form.energy(depth)), float(form.force(depth))
        assert energy in stored
        assert force in pressed
        widths.append(pressed.width)
        sides = [*_sides(stored, energy), *_sides(pressed, force)]
        rows.append([name, *sides, below(pressed.width), *_cost(cost)])
        costs.append(cost)
    disc, cost = timed(lambda: axisymmetric.disc_stiffness(1.0, 1.0, cells=40))
    assert 2.0 in disc
    rows.append(
        ["cylinder", *_sides(disc, 2.0), *_sides(disc, 2.0), below(disc.width), *_cost(cost)]
    )
    medians = np.median([*costs, cost], axis=0)
    width = below(float(np.median([*widths, disc.width])))
    rows.append(["median", *[""] * 4, width, *_cost(Cost(medians[0], int(medians[1])))])
    return rows


def _cost(cost: Cost) -> list[str]:
    return [str(cost.unknowns), f"{cost.seconds:.1f}"]


def _sides(bounds: Interval, exact: float) -> list[str]:
    return [below(bounds.lower / exact - 1), below(bounds.upper / exact - 1)]


# %% [markdown]
# Convergence of both sides.


def order() -> list[list[str]]:
    """Errors of both sides of the energy against cells, and their orders."""
    rows = [["body", "cells", "below", "above", "order, below", "order, above"]]
    exact = float(closed_form.paraboloid(1.0, 1.0).energy(1.0))
    kinds: dict[str, Callable[[int], tuple[float, float]]] = {
        "paraboloid": lambda n: _errors(
            axisymmetric.energy(paraboloid(1.0), 1.0, 1.0, cells=n), exact
        ),
        "cylinder": lambda n: _errors(axisymmetric.disc_stiffness(1.0, 1.0, cells=n), 2.0),
    }
    for name, errors in kinds.items():
        before: tuple[float, float] | None = None
        for cells in (8, 16, 32):
            now = errors(cells)
            orders = ["", ""]
            if before is not None:
                orders = [f"{math.log2(b / a):.1f}" for a, b in zip(now, before, strict=True)]
            rows.append([name, str(cells), below(-now[0]), below(now[1]), *orders])
            before = now
    return rows


def _errors(bounds: Interval, exact: float) -> tuple[float, float]:
    return 1 - bounds.lower / exact, bounds.upper / exact - 1


# %% [markdown]
# Two radii, and pyramids.


def two_radii() -> list[list[str]]:
    """Force of paraboloids with two radii."""
    head = ["R_y : R_x", "a : b", "below", "above", "width", "unknowns", "s"]
    rows = [[*head, "boundary elements, s"]]
    for ratio in (1.0, 2.0, 5.0, 10.0, 70.0):
        form = closed_form.ellipsoid(1.0, ratio, 1.0)
        body = bodies.Paraboloid(1.0, ratio)
        pressed, cost = timed(lambda b=body: homogeneous.force(b, 1.0, 1.0, cells=(8, 12)))
        exact = float(form.force(1.0))
        assert exact in pressed
        x, y = (float(axis) for axis in form.semi_axes(1.0))
        # lengths of order one for the grid
        grid = grid_seconds(lambda u, v, x=x, y=y: 0.5 * ((u * x) ** 2 + (v * y) ** 2), 0.3)
        rows.append(
            [
                f"{ratio:g}",
                f"{y / x:.2f}",
                *_sides(pressed, exact),
                below(pressed.width),
                *_cost(cost),
                f"{grid:.3f}",
            ]
        )
    return rows


INDENTERS = {
    "Vickers": (4, 1 / math.tan(math.radians(68.0))),
    "Berkovich": (3, 1 / math.tan(math.radians(65.27))),
}


def pyramids() -> list[list[str]]:
    """Force of the pyramids of hardness tests."""
    rows = [
        [
            "indenter",
            "F/(E* d^2) not below",
            "not above",
            "width",
            "cone of equal area",
            "circle",
            "unknowns",
            "s",
        ]
    ]
    for name, (faces, slope) in INDENTERS.items():
        body = bodies.Pyramid(faces, slope)
        homogeneous.force.__globals__["_coarse_outline"].cache_clear()
        pressed, cost = timed(lambda b=body: homogeneous.force(b, 1.0, 1.0, cells=(12, 18)))
        angle = math.degrees(math.atan(1 / slope))
        shape = f"regular pyramid, rigid, no friction: {faces} faces at {angle:.2f} deg to the axis"
        keep(name, shape, "F/(E* d^2)", pressed, cost.seconds)
        cone_force = 2 / math.pi * math.sqrt(faces * math.tan(math.pi / faces) / math.pi) / slope
        rows.append(
            [
                name,
                *outwards(pressed, 4),
                below(pressed.width),
                f"{100 * (cone_force / pressed.middle - 1):+.2f} %",
                f"{100 * (body.punch_force() / pressed.middle - 1):+.2f} %",
                *_cost(cost),
            ]
        )
    return rows


# %% [markdown]
# The problem sheet: stiffness of flat punches.

SHEET = {
    "disc": ("disc", 0, 1.0),
    "square": ("polygon", 4, 1.0),
    "equilateral triangle": ("polygon", 3, 1.0),
    "hexagon": ("polygon", 6, 1.0),
    "rectangle 2 : 1": ("rectangle", 0, 2.0),
    "rectangle 4 : 1": ("rectangle", 0, 4.0),
    "L of three squares": ("l_shape", 0, 1.0),
    "right isosceles triangle": ("right_isosceles", 0, 1.0),
}
STIFFNESS, FLAT = "k/(2 E* (A/pi)^(1/2))", "rigid flat punch without friction, area A"


def sheet() -> list[list[str]]:
    """Stiffness of flat punches over that of the circle of equal area."""
    rows = [["face", "k/(2 E* (A/π)^½) not below", "not above", "width", "unknowns", "s"]]
    for name, (shape, sides, aspect) in SHEET.items():
        bounds, cost = timed(
            lambda s=shape, n=sides, a=aspect: proved.punch_stiffness.__wrapped__(s, n, a, "full")
        )
        circle = punches.equal_area_stiffness(proved._area(shape, sides, aspect))
        factor = bounds * (1 / circle)
        keep(name, FLAT, STIFFNESS, factor, cost.seconds)
        rows.append(
            [
                name,
                *outwards(factor, 5),
                below(bounds.width),
                *_cost(cost),
            ]
        )
    return rows


def finest() -> list[list[str]]:
    """Square and triangle as sharply as patience allows."""
    rows = [["face", "side", "cells", "k/(2 E* (A/π)^½)", "s"]]
    for name, sides in (("square", 4), ("equilateral triangle", 3)):
        corners = proved.corners_of("polygon", sides, 1.0)
        circle = punches.equal_area_stiffness(sides * math.tan(math.pi / sides))
        lower = upper = last = 0.0
        for cells in (16, 24, 32):
            fine = outlines.polygon(corners, cells, punches.PRESSURE_EXPONENT)
            started = time.process_time()
            lower = punches.stiffness_below(fine, cells)
            seconds = time.process_time() - started
            last = seconds
            shown, _ = outwards(Interval(lower / circle, lower / circle), 6)
            rows.append([name, "below", str(cells), shown, f"{seconds:.0f}"])
        for cells in (12, 16, 24):
            coarse = outlines.polygon(corners, cells // 2, punches.DISPLACEMENT_AROUND)
            started = time.process_time()
            upper = punches.stiffness_above(coarse, cells)
            seconds = time.process_time() - started
            _, shown = outwards(Interval(upper / circle, upper / circle), 6)
            rows.append([name, "above", str(cells), shown, f"{seconds:.0f}"])
        keep(name, FLAT, STIFFNESS, Interval(lower / circle, upper / circle), last + seconds)
    return rows


# %% [markdown]
# Rough contacts.


def heights() -> np.ndarray:
    """One surface of 64 x 64 points, H = 0.8, rms gradient 0.1, side 1."""
    spectrum = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1)
    return surfaces.self_affine(64, 1.0, spectrum, seed=1, realisation=0)


def patches() -> list[list[str]]:
    """Force of a free patch against the grid's, by penetration and cells."""
    head = ["penetration", "cells", "of them taken", "below", "above", "width"]
    rows = [[*head, "bounds, s", "grid, s"]]
    for share, all_finer in ((0.3, (8, 16, 32)), (1.0, (2, 4, 8)), (2.0, (2, 4, 8))):
        depth = share * float(heights().std())
        for finer in all_finer:
            patch = Patch(heights(), 1.0, finer)
            pressed, (seconds, _) = timed(lambda p=patch, d=depth: p.force(d, 1.0))
            started = time.process_time()
            grid = patch.on_grid(depth)
            alone = time.process_time() - started
            sides = [f"{100 * (x / grid - 1):+.1f} %" for x in (pressed.lower, pressed.upper)]
            taken = patch.block(depth).shape
            rows.append(
                [
                    f"{share:g} h_rms",
                    f"{patch.grid[0]}²",
                    f"{taken[0]} x {taken[1]}",
                    *sides,
                    f"{100 * pressed.width:.1f} %",
                    f"{seconds:.0f}",
                    f"{alone:.2f}",
                ]
            )
    return rows


def periods() -> list[list[str]]:
    """Energy and penetration of a periodic contact, by cells and load."""
    rows = [
        ["F/(E* A0 h')", "cells", "energy, width", "penetration, width", "bounds, s", "grid, s"]
    ]
    for finer in (4, 8, 16):
        surface = PeriodicSurface(heights(), (1.0, 1.0), finer)
        for mean in (0.001, 0.003, 0.01):
            stored = surface.energy(mean, 1.0)
            depth, (seconds, _) = timed(lambda s=surface, p=mean: s.penetration(p, 1.0))
            started = time.process_time()
            surface.on_grid(mean)
            alone = time.process_time() - started
            rows.append(
                [
                    f"{10 * mean:g}",
                    f"{surface.grid[0]}²",
                    below(stored.width),
                    f"{100 * depth.width:.1f} %",
                    f"{seconds:.0f}",
                    f"{alone:.1f}",
                ]
            )
    return rows


if __name__ == "__main__":
    rewrite(
        PAGE,
        {
            "round": round_bodies,
            "order": order,
            "two-radii": two_radii,
            "pyramids": pyramids,
            "sheet": sheet,
            "finest": finest,
            "patches": patches,
            "periods": periods,
        },
        sys.argv[1:],
    )
