"""Make the tables of docs/plasticity.md: finite elements, and what springs and fits err by.

Run from the repository's root (ten minutes on one core). Tables that the page shows are written
into it, others are printed; all of them, or those that are named::

    python docs/examples/plasticity_tables.py NAME
"""

# %%
import sys
from functools import partial
from pathlib import Path

import numpy as np

from comparisons.questions.experiments.yielding import (
    MODULUS,
    NU,
    READINGS,
    YIELD_STRESS,
    Dented,
    elements,
    known_to,
    springs,
)
from reference.elasticity import Material
from reference.halfspace import FreeOperator
from reference.loads import LoadPath
from reference.plastic import PlasticMaterial, Walk
from reference.plastic.capped import along
from reference.plastic.dent_formulas import FlattenedBall, jackson_green, kogut_etsion
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "plasticity.md"
DEPTH = (np.pi * 1.6 * YIELD_STRESS / (2 * MODULUS)) ** 2
FORCE = 4 / 3 * MODULUS * DEPTH**1.5
SHARES = (2, 5, 10, 60, 200, 1000)
GRIDS = (3, 6, 9)
# Loads that follow a force while the edge passes several elements, from half of the depth on.
MESHES, LOADS = (3, 4, 6, 9), 24
HARDNESSES = (2.84, 3.0)
Contact = tuple[float, float, float]


def relative(dented: Dented, depth: float) -> Contact:
    """Return force, area and what remains, in F_y, pi R d and d."""
    return dented.force / FORCE, dented.area / (np.pi * depth), dented.residual_depth / depth


def on_elements(share: float, per_radius: int) -> tuple[Contact, int]:
    """Return them of finite elements; and the number of unknowns."""
    dented = elements(share * DEPTH, per_radius)
    return relative(dented, share * DEPTH), dented.unknowns


def fits(share: float) -> dict[str, Contact]:
    """Return the same of the fits, NaN beyond their range."""
    answers = {}
    for make in (kogut_etsion, jackson_green):
        fit = make(FlattenedBall(1.0, MODULUS, NU, YIELD_STRESS))
        depth = share * DEPTH
        w = np.array(depth / fit.yields_at)
        left = np.nan if fit.residual is None else float(fit.residual(w)) * fit.yields_at / depth
        area = float(fit.area(w)) * fit.area_unit / (np.pi * depth)
        values = float(fit.force(w)) * fit.force_unit / FORCE, area, left
        answers[make.__name__] = values if w <= fit.largest else (np.nan,) * 3
    return answers


def indented(share: float, per_radius: int) -> Walk:
    """Return the ball on a mesh for a depth."""
    radius = float(np.sqrt(share * DEPTH * min(2.0, 1 + 0.25 * np.log10(share) ** 1.2)))
    steel = PlasticMaterial(Material(1.0, NU), YIELD_STRESS)
    return Walk(steel, lambda r: r**2 / 2, radius, per_radius=per_radius)


def followed(share: float, per_radius: int) -> tuple[float, float]:
    """Return by how much the force swings (rms about a parabola of logarithms), and the work."""
    logs = np.linspace(-np.log(2), 0, LOADS)
    walk = indented(share, per_radius)
    moments = list(walk.along(LoadPath("penetration", share * DEPTH * np.exp(logs))))
    forces = np.log([m.force for m in moments])
    rest = forces - np.polyval(np.polyfit(logs, forces, 2), logs)
    return float(rest.std()), moments[-1].work / (FORCE * share * DEPTH)


def orders() -> list[list[str]]:
    """Return swings of the force and the work on several meshes, with the orders of both."""
    rows = [["d/d_y", "", *(f"N = {n}" for n in MESHES), "order"]]
    logs = np.log(MESHES)
    for share in (2, 5, 20, 60):
        swing, work = np.array([followed(share, n) for n in MESHES]).T
        (slope, _), cov = np.polyfit(logs, np.log(swing), 1, cov=True)
        order = f"{-slope:.1f} ± {np.sqrt(cov[0, 0]):.1f}"
        rows.append([str(share), "swing of F", *(f"{100 * s:.3f} %" for s in swing), order])
        rows.append(["", "W/(F_y d)", *(f"{w:.4f}" for w in work), f"{_order(work):.1f}"])
    return rows


def _order(values: np.ndarray) -> float:
    """Return the power p whose limit + c N^-p fits values best."""

    def misfit(power: float) -> float:
        basis = np.stack([np.ones(len(MESHES)), np.array(MESHES, dtype=float) ** -power], axis=1)
        return float(np.linalg.norm(basis @ np.linalg.lstsq(basis, values, rcond=None)[0] - values))

    powers = np.arange(0.5, 6.0, 0.05)
    return float(powers[np.argmin([misfit(power) for power in powers])])


def balances() -> list[list[str]]:
    """Return by how much stored and dissipated energies exceed the work."""
    shares = (5, 20, 60)
    heads = [f"d/d_y = {s}: F/F_y, energies − work" for s in shares]
    rows = [["N", *heads, "Newton steps"]]
    for n in (3, 6, 9):
        row, rounds = [str(n)], 0
        for share in shares:
            depth = share * DEPTH
            (moment,) = indented(share, n).along(LoadPath("penetration", depth))
            more = (moment.elastic + moment.dissipated) / moment.work - 1
            row.append(f"{moment.force / FORCE:.4g}, {1e6 * more:+.0f} ppm")
            rounds += moment.iterations
        rows.append([*row, str(rounds)])
    return rows


def on_grids() -> list[list[str]]:
    """Return forces on several grids."""
    rows = [["N", *(f"d/d_y = {share}" for share in SHARES), "unknowns"]]
    for n in GRIDS:
        solved = [on_elements(share, n) for share in SHARES]
        rows.append([str(n), *(f"{c[0]:.4g}" for c, _ in solved), str(solved[0][1])])
    return rows


CELLS = 128


def capped(share: float, hardness: float) -> tuple[float, float]:
    """Return force and area of the half-space whose pressure is capped at so many Y."""
    depth = share * DEPTH
    side = 2.7 * np.sqrt(2 * depth)
    at = ((np.arange(CELLS) + 0.5) / CELLS - 0.5) * side
    body = FreeOperator((CELLS, CELLS), (side / CELLS, side / CELLS), MODULUS)
    gap = (at[:, None] ** 2 + at**2) / 2
    (dent,) = along(body, gap, hardness * YIELD_STRESS, LoadPath("penetration", depth))
    area = dent.contact.mask.mean() * side**2
    return dent.contact.force / FORCE, float(area / (np.pi * depth))


def caps() -> list[list[str]]:
    """Return what the cap errs by in force and area on one asperity, against elements."""
    heads = [f"{q}, {h} Y" for h in HARDNESSES for q in ("force", "area")]
    rows = [["d/d_y", "F/(A Y) of elements", *heads]]
    for share in SHARES:
        force, area, _ = on_elements(share, GRIDS[-1])[0]
        pressure = force * FORCE / (area * np.pi * share * DEPTH * YIELD_STRESS)
        row = [str(share), f"{pressure:.2f}"]
        for hardness in HARDNESSES:
            errors = zip(capped(share, hardness), (force, area), strict=True)
            row += [f"{100 * (stated / true - 1):+.0f} %" for stated, true in errors]
        rows.append(row)
    return rows


# Four asperities at (+-c, +-c): c and the half-width of the mesh in contact radii at the last.
DEPTHS, APART, PATCH, BLOCKS = (5, 10, 20), 1.5, 2.5, (4, 6)


def four() -> list[list[str]]:
    """Return forces of four asperities on elements in three dimensions, and under the cap."""
    last = np.sqrt(1.35 * DEPTHS[-1] * DEPTH)
    depths, apart = DEPTH * np.array(DEPTHS), APART * last
    steel = PlasticMaterial(Material(1.0, NU), YIELD_STRESS)

    def shape(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.asarray(((np.abs(x) - apart) ** 2 + (np.abs(y) - apart) ** 2) / 2)

    forces = []
    for n in BLOCKS:
        walk = Walk(steel, shape, (PATCH * last, PATCH * last), per_radius=n)
        walk.step *= 2
        forces.append([m.force / (4 * FORCE) for m in walk.along(LoadPath("penetration", depths))])
    side = 2 * (apart + 1.35 * np.sqrt(2 * depths[-1]))
    at = ((np.arange(CELLS) + 0.5) / CELLS - 0.5) * side
    body = FreeOperator((CELLS, CELLS), (side / CELLS, side / CELLS), MODULUS)
    gap, path = shape(at[:, None], at), LoadPath("penetration", depths)
    dents = along(body, gap, HARDNESSES[0] * YIELD_STRESS, path)
    heads = [f"F/(4 F_y), N = {n}" for n in BLOCKS]
    rows = [["d/d_y", *heads, f"cap {HARDNESSES[0]} Y", "cap − elements"]]
    for share, *solved, dent in zip(DEPTHS, *forces, dents, strict=True):
        stated = dent.contact.force / (4 * FORCE)
        error = f"{100 * (stated / solved[-1] - 1):+.0f} %"
        rows.append([str(share), *(f"{f:.4g}" for f in solved), f"{stated:.4g}", error])
    return rows


NAMES = (*READINGS, "kogut_etsion", "jackson_green")


def against_elements(place: int, symbol: str) -> list[list[str]]:
    """Return errors of the force (0), or of the area (1), which are known to a bar."""
    rows = [["d/d_y", symbol, *NAMES]]
    for share in SHARES:
        coarse, true = (on_elements(share, n)[0][place] for n in GRIDS[1:])
        bar = known_to(("force", "area")[place], GRIDS[1:], (coarse, true)) / true
        errors = [f"{100 * (c[place] / true - 1):+.0f} %" for c in others(share)]
        rows.append(
            [str(share), f"{true:.{4 - place}g} ± {100 * bar:.1f} %", *(_known(e) for e in errors)]
        )
    return rows


def remaining() -> list[list[str]]:
    """Return what remains of the depth."""
    rows = [["d/d_y", "elements", *NAMES]]
    for share in SHARES:
        left = [on_elements(share, GRIDS[-1])[0][2], *(c[2] for c in others(share))]
        rows.append([str(share), *(_known(f"{value:.3f}") for value in left)])
    return rows


def others(share: float) -> list[Contact]:
    """Return force, area and what remains of all others."""
    fitted = fits(share)
    return [
        *(relative(springs(share * DEPTH, n), share * DEPTH) for n in READINGS),
        *(fitted[n] for n in NAMES[-2:]),
    ]


def _known(text: str) -> str:
    return "–" if "nan" in text else text


# %%
TABLES = {
    "orders": orders,
    "energy": balances,
    "elements": on_grids,
    "force": partial(against_elements, 0, "F/F_y"),
    "area": partial(against_elements, 1, "A/(πRd)"),
    "residual": remaining,
    "cap": caps,
    "four": four,
}

if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
