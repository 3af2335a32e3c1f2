"""Make the tables of docs/error-bars.md: enclosures, their width, their cost.

Run from the repository's root (half an hour on one core, most of it the rough contacts). Tables
that the page shows are written into it, and docs/problem-sheet.csv; others are printed::

    python docs/examples/bounds_tables.py               # or only some: round order two-radii
"""

# %%
import csv
import math
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

from comparisons.questions.experiments import proved
from comparisons.scene.indenters.not_round import PolygonPunch
from reference import closed_form, surfaces
from reference.bounds import flat_faces, homogeneous, outlines, revolution
from reference.bounds.dirichlet import Prisms
from reference.bounds.ellipses import ConvexGap, Ellipse, Face, best_ellipse, force_of_ellipse
from reference.bounds.interval import Interval
from reference.bounds.patches import Patch
from reference.bounds.periodic import PeriodicSurface
from reference.bounds.revolution import cone, paraboloid, power_law, rounded_punch, sphere
from reference.contact.press import press
from reference.halfspace import FreeOperator
from reference.loads import Load
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "error-bars.md"
# The problem sheet as data: one row per problem and quantity, its interval rounded outwards.
SHEET_FILE = PAGE.with_name("problem-sheet.csv")
COLUMNS = ("problem", "definition", "quantity", "not below", "not above", "seconds")
Row = dict[str, str]


def table(rows: list[Row]) -> list[list[str]]:
    """Return rows that have the same keys with these as their head."""
    return [list(rows[0]), *(list(row.values()) for row in rows)]


def seconds_of(work: Callable[[], Any]) -> tuple[Any, float]:
    """Return a result and the processor time that it took."""
    started = time.process_time()
    result = work()
    return result, time.process_time() - started


def costed(work: Callable[[], Interval]) -> tuple[Interval, int, float]:
    """Return an interval, the unknowns of its largest mesh, and the processor time."""
    unknowns = [0]
    make = Prisms.__init__

    def noted(body: Prisms, *of: Any) -> None:
        make(body, *of)
        unknowns.append(body.unknowns)

    with mock.patch.object(Prisms, "__init__", noted):
        bounds, seconds = seconds_of(work)
    return bounds, max(unknowns), seconds


def solve_seconds(gap: Callable[[np.ndarray, np.ndarray], np.ndarray], depth: float) -> float:
    """Return the time of the half-space solver on 128 x 128 cells, 2.56 to a side."""
    x = (np.arange(128) - 63.5) / 50
    # where there is no body, one that nothing reaches
    heights = np.minimum(gap(x[:, None], x[None, :]), 1e3 * depth)
    body, load = FreeOperator((128, 128), (1 / 50, 1 / 50), 1.0), Load("penetration", depth)
    press(body, heights, load)
    return seconds_of(lambda: press(body, heights, load))[1]


def cost(unknowns: int, seconds: float, solve: float) -> Row:
    """Return the cells of what a bound took, and of the solve that it judges."""
    return {
        "unknowns": str(unknowns),
        "s": f"{seconds:.1f}",
        "solve, s": f"{solve:.3f}",
        "ratio": f"{seconds / solve:.0f}",
    }


def sides(bounds: Interval, exact: float) -> list[str]:
    """Return how far both sides are from a number, relative."""
    return [f"{side / exact - 1:.1e}" for side in (bounds.lower, bounds.upper)]


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


# %% [markdown]
# Bodies of revolution: the closed form lies inside.


def pressed_to(radius: float) -> float:
    """Return the penetration of a rounded punch of radii 1 and 1 to a contact radius."""
    return radius * (math.sqrt(radius**2 - 1) - math.acos(1 / radius))


ROUNDED = (rounded_punch(1.0, 1.0), closed_form.rounded_punch(1.0, 1.0, 1.0))
BALL = (sphere(1.0), closed_form.sphere(1.0, 1.0))
ROUND: dict[str, tuple[Any, Any, float]] = {
    "paraboloid": (paraboloid(1.0), closed_form.paraboloid(1.0, 1.0), 1.0),
    "cone": (cone(1.0), closed_form.cone(1.0, 1.0), 1.0),
    **{
        f"r^{n:g}": (power_law(n, 1.0), closed_form.power_law(n, 1.0, 1.0), 1.0)
        for n in (1.5, 3.0, 4.0, 6.0)
    },
    **{f"sphere, a/R = {s:g}": (*BALL, s * math.atanh(s)) for s in (0.1, 0.5)},
    **{f"rounded punch, a/b = {q:g}": (*ROUNDED, pressed_to(q)) for q in (1.01, 1.05, 1.2, 3.0)},
}


def round_bodies() -> list[list[str]]:
    """Energy and force of bodies of revolution."""
    rows, widths, costs = [], [], []
    for name, (profile, form, depth) in ROUND.items():
        stored = revolution.energy(profile, depth, 1.0, cells=40)
        pressed, unknowns, seconds = costed(
            lambda p=profile, d=depth: revolution.force(p, d, 1.0, cells=40)
        )
        energy, force = float(form.energy(depth)), float(form.force(depth))
        assert energy in stored
        assert force in pressed
        size = profile.reach(depth)
        solve = solve_seconds(lambda x, y, p=profile, r=size: p.gap(r * np.hypot(x, y) / 2), depth)
        rows.append(_round_row(name, sides(stored, energy), sides(pressed, force), pressed))
        rows[-1] |= cost(unknowns, seconds, solve)
        widths.append(pressed.width)
        costs.append((unknowns, seconds, solve))
    disc, unknowns, seconds = costed(lambda: revolution.disc_stiffness(1.0, 1.0, cells=40))
    assert 2.0 in disc
    solve = solve_seconds(lambda x, y: np.where(np.hypot(x, y) < 1, 0.0, np.inf), 0.1)
    rows.append(_round_row("cylinder", sides(disc, 2.0), sides(disc, 2.0), disc))
    rows[-1] |= cost(unknowns, seconds, solve)
    unknowns, seconds, solve = np.median([*costs, (unknowns, seconds, solve)], axis=0)
    middle = Interval(1.0, 1.0 + float(np.median([*widths, disc.width])))
    rows.append(_round_row("median", ["", ""], ["", ""], middle))
    rows[-1] |= cost(int(unknowns), seconds, solve)
    return table(rows)


def _round_row(name: str, energy: list[str], force: list[str], pressed: Interval) -> Row:
    return {
        "body": name,
        "energy, below": energy[0],
        "energy, above": energy[1],
        "force, below": force[0],
        "force, above": force[1],
        "width of the force": f"{pressed.width:.1e}",
    }


# %% [markdown]
# Convergence of both sides.


def order() -> list[list[str]]:
    """Errors of both sides of the energy against cells, and their orders."""
    rows: list[Row] = []
    profile, form = ROUNDED
    kinds: dict[str, tuple[Callable[[int], Interval], float]] = {
        "paraboloid": (
            lambda n: revolution.energy(paraboloid(1.0), 1.0, 1.0, cells=n),
            float(closed_form.paraboloid(1.0, 1.0).energy(1.0)),
        ),
        "rounded punch, a/b = 1.05": (
            lambda n: revolution.energy(profile, pressed_to(1.05), 1.0, cells=n),
            float(form.energy(pressed_to(1.05))),
        ),
        "cylinder": (lambda n: revolution.disc_stiffness(1.0, 1.0, cells=n), 2.0),
    }
    for name, (bounded, exact) in kinds.items():
        before: tuple[float, float] | None = None
        for cells in (8, 16, 32, 64):
            bounds = bounded(cells)
            now = 1 - bounds.lower / exact, bounds.upper / exact - 1
            orders = ["", ""]
            if before is not None:
                orders = [f"{math.log2(b / a):.1f}" for a, b in zip(now, before, strict=True)]
            below, above = sides(bounds, exact)
            row = {"body": name, "cells": str(cells), "below": below, "above": above}
            rows.append(row | {"order, below": orders[0], "order, above": orders[1]})
            before = now
    return table(rows)


# %% [markdown]
# Two radii, and pyramids.


def two_radii() -> list[list[str]]:
    """Force of paraboloids with two radii."""
    rows = []
    for ratio in (1.0, 2.0, 5.0, 10.0, 70.0):
        form, body = closed_form.ellipsoid(1.0, ratio, 1.0), homogeneous.paraboloid(1.0, ratio)
        pressed, unknowns, seconds = costed(
            lambda b=body: homogeneous.force(b, 1.0, 1.0, cells=(8, 12))
        )
        exact = float(form.force(1.0))
        assert exact in pressed
        x, y = (float(axis) for axis in form.semi_axes(1.0))
        # lengths of order one for the grid
        solve = solve_seconds(lambda u, v, x=x, y=y: 0.5 * ((u * x) ** 2 + (v * y) ** 2), 0.3)
        below, above = sides(pressed, exact)
        row = {"R_y : R_x": f"{ratio:g}", "a : b": f"{y / x:.2f}", "below": below, "above": above}
        row["width"] = f"{pressed.width:.1e}"
        rows.append(row | cost(unknowns, seconds, solve))
    return table(rows)


INDENTERS = {
    "Vickers": (4, 1 / math.tan(math.radians(68.0))),
    "Berkovich": (3, 1 / math.tan(math.radians(65.27))),
}


def pyramids() -> list[list[str]]:
    """Force of the pyramids of hardness tests."""
    rows = []
    for name, (faces, slope) in INDENTERS.items():
        body = homogeneous.pyramid(faces, slope)
        pressed, unknowns, seconds = costed(
            lambda b=body: homogeneous.force(b, 1.0, 1.0, cells=(12, 18))
        )
        angle = math.degrees(math.atan(1 / slope))
        shape = f"regular pyramid, rigid, no friction: {faces} faces at {angle:.2f} deg to the axis"
        keep(name, shape, "F/(E* d^2)", pressed, seconds)
        cone_force = 2 / math.pi * math.sqrt(faces * math.tan(math.pi / faces) / math.pi) / slope
        plain = homogeneous.pyramid(faces, 1.0).gap_anywhere
        starts = [Ellipse(0.0, 0.0, 0.8, 0.6, turn) for turn in (0.0, 0.8)]
        best, _ = best_ellipse(ConvexGap(plain), 1.0, starts)
        # rings and arcs of a mean gap that is stated: it exceeds the mean by 1e-4
        below_it = force_of_ellipse(ConvexGap(plain, 256, 192), best, 1.0) / slope
        lower, upper = outwards(pressed, 4)
        row = {
            "indenter": name,
            "F/(E* d^2) not below": lower,
            "not above": upper,
            "width": f"{pressed.width:.1e}",
            "cone of equal area": f"{100 * (cone_force / pressed.middle - 1):+.2f} %",
            "best ellipse": f"{100 * (below_it / pressed.middle - 1):+.2f} %",
        }
        rows.append(row | cost(unknowns, seconds, solve_seconds(body.gap_anywhere, 0.3)))
    return table(rows)


# %% [markdown]
# The problem sheet: stiffness of flat flat_faces.

SHEET: dict[str, tuple[tuple[float, float], ...]] = {
    "disc": (),
    "square": proved.corners_of("polygon", 4, 1.0),
    "equilateral triangle": proved.corners_of("polygon", 3, 1.0),
    "hexagon": proved.corners_of("polygon", 6, 1.0),
    "rectangle 2 : 1": proved.corners_of("rectangle", 4, 2.0),
    "rectangle 4 : 1": proved.corners_of("rectangle", 4, 4.0),
    # from points that see the whole outline: for the triangle the centre of its inscribed circle
    "L of three squares": (
        (1.5, -0.5),
        (1.5, 0.5),
        (0.5, 0.5),
        (0.5, 1.5),
        (-0.5, 1.5),
        (-0.5, -0.5),
    ),
    "right isosceles triangle": tuple(
        (x + math.sqrt(2) - 2, y) for x, y in ((1.0, -1.0), (1.0, 1.0), (0.0, 0.0))
    ),
}
# Elements of the upper bound and cells of the lower one from the middle to the edge.
SHEET_CELLS = 14, 18
STIFFNESS, FLAT = "k/(2 E* (A/pi)^(1/2))", "rigid flat punch without friction, area A"


def sheet() -> list[list[str]]:
    """Stiffness of flat punches over that of the circle of equal area."""
    rows = []
    for name, corners in SHEET.items():
        if not corners:
            area, ellipse = math.pi, 2.0
            gap = lambda x, y: np.where(np.hypot(x, y) < 1, 0.0, np.inf)  # noqa: E731
            work = lambda: revolution.disc_stiffness(1.0, 1.0, cells=28)  # noqa: E731
        else:
            face = PolygonPunch(shape="polygon_punch", vertices=corners)
            area, gap = face.face_area, face.gap
            work = lambda c=corners: flat_faces.bounded(c, SHEET_CELLS)  # noqa: E731
            outline = Face(corners)
            ellipse = best_ellipse(outline, 1.0, outline.starts())[1]
        bounds, unknowns, seconds = costed(work)
        factor = bounds * (1 / flat_faces.equal_area_stiffness(area))
        keep(name, FLAT, STIFFNESS, factor, seconds)
        lower, upper = outwards(factor, 5)
        row = {
            "face": name,
            "k/(2 E* (A/π)^½) not below": lower,
            "not above": upper,
            "width": f"{bounds.width:.1e}",
            "best ellipse": f"{100 * (ellipse / bounds.middle - 1):+.1f} %",
        }
        rows.append(row | cost(unknowns, seconds, solve_seconds(gap, 0.1)))
    return table(rows)


def finest() -> list[list[str]]:
    """Square and triangle as sharply as patience allows."""
    rows: list[Row] = []
    for name, count in (("square", 4), ("equilateral triangle", 3)):
        corners = proved.corners_of("polygon", count, 1.0)
        circle = flat_faces.equal_area_stiffness(count * math.tan(math.pi / count))

        def lower(cells: int, c: Any = corners) -> float:
            fine = outlines.polygon(c, cells, flat_faces.PRESSURE_EXPONENT)
            return flat_faces.stiffness_below(fine, cells)

        def upper(cells: int, c: Any = corners) -> float:
            coarse = outlines.polygon(c, cells // 2, flat_faces.DISPLACEMENT_AROUND)
            return flat_faces.stiffness_above(coarse, cells)

        last: dict[str, tuple[float, float]] = {}
        for side, bound, steps in (("below", lower, (16, 24, 32)), ("above", upper, (12, 16, 24))):
            for cells in steps:
                value, seconds = seconds_of(lambda b=bound, n=cells, k=circle: b(n) / k)
                shown = outwards(Interval(value, value), 6)[side == "above"]
                row = {"face": name, "side": side, "cells": str(cells), "k/(2 E* (A/π)^½)": shown}
                rows.append(row | {"s": f"{seconds:.0f}"})
                last[side] = value, seconds
        (low, before), (high, after) = last["below"], last["above"]
        keep(name, FLAT, STIFFNESS, Interval(low, high), before + after)
    return table(rows)


# %% [markdown]
# Rough contacts.


def heights() -> np.ndarray:
    """One surface of 64 x 64 points, H = 0.8, rms gradient 0.1, side 1."""
    spectrum = surfaces.SelfAffine(hurst=0.8, rms_slope=0.1)
    return surfaces.self_affine(64, 1.0, spectrum, seed=1, realisation=0)


def ellipses() -> list[list[str]]:
    """Ellipses on the summits of a free patch, against the grid's force and cells' bounds."""
    rows = []
    for share, finer in ((0.1, 32), (0.3, 16), (1.0, 4), (2.0, 4)):
        depth = share * float(heights().std())
        patch = Patch(heights(), 1.0, finer)
        patch.on_grid(depth)  # compiled, if nothing was before
        grid, solve = seconds_of(lambda p=patch, d=depth: p.on_grid(d))
        bound, seconds = seconds_of(lambda p=patch, d=depth: p.by_ellipses(d, 1.0))
        row = {"penetration": f"{share:g} h_rms", "ellipses": f"{100 * (bound / grid - 1):+.1f} %"}
        rows.append(row | {"s": f"{seconds:.1f}", "solve, s": f"{solve:.2f}"})
    return table(rows)


def patches() -> list[list[str]]:
    """Force of a free patch against the grid's, by penetration and cells."""
    rows = []
    for share, all_finer in ((0.3, (8, 16, 32)), (1.0, (2, 4, 8)), (2.0, (2, 4, 8))):
        depth = share * float(heights().std())
        for finer in all_finer:
            patch = Patch(heights(), 1.0, finer)
            pressed, seconds = seconds_of(lambda p=patch, d=depth: p.force(d, 1.0))
            grid, solve = seconds_of(lambda p=patch, d=depth: p.on_grid(d))
            below, above = (
                f"{100 * (x / grid - 1):+.1f} %" for x in (pressed.lower, pressed.upper)
            )
            taken = patch.block(depth).shape
            row = {
                "penetration": f"{share:g} h_rms",
                "cells": f"{patch.grid[0]}²",
                "of them taken": f"{taken[0]} x {taken[1]}",
                "below": below,
                "above": above,
                "width": f"{100 * pressed.width:.1f} %",
            }
            rows.append(row | _long(seconds, solve))
    return table(rows)


def periods() -> list[list[str]]:
    """Energy and penetration of a periodic contact, by cells and load."""
    rows = []
    for finer in (4, 8, 16):
        surface = PeriodicSurface(heights(), (1.0, 1.0), finer)
        for mean in (0.001, 0.003, 0.01):
            stored = surface.energy(mean, 1.0)
            depth, seconds = seconds_of(lambda s=surface, p=mean: s.penetration(p, 1.0))
            _, solve = seconds_of(lambda s=surface, p=mean: s.on_grid(p))
            row = {
                "F/(E* A0 h')": f"{10 * mean:g}",
                "cells": f"{surface.grid[0]}²",
                "energy, width": f"{stored.width:.1e}",
                "penetration, width": f"{100 * depth.width:.1f} %",
            }
            rows.append(row | _long(seconds, solve))
    return table(rows)


def _long(seconds: float, solve: float) -> Row:
    return {"s": f"{seconds:.0f}", "solve, s": f"{solve:.2f}", "ratio": f"{seconds / solve:.0f}"}


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
            "ellipses": ellipses,
            "patches": patches,
            "periods": periods,
        },
        sys.argv[1:],
    )
