"""Make the tables of docs/plasticity.md: finite elements, and what springs and fits err by.

Run from the repository's root (ten minutes on one core); the tables between the markers of the
page are written anew::

    python docs/examples/plasticity_tables.py
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
    springs,
)
from reference.elasticity import Material
from reference.loads import LoadPath
from reference.plastic import PlasticMaterial, Walk
from reference.plastic.fits import Ball, jackson_green, kogut_etsion
from reports.tables.documents import rewrite

PAGE = Path(__file__).resolve().parents[1] / "plasticity.md"
DEPTH = (np.pi * 1.6 * YIELD_STRESS / (2 * MODULUS)) ** 2
FORCE = 4 / 3 * MODULUS * DEPTH**1.5
SHARES = (2, 5, 10, 60, 200, 1000)
GRIDS = (4, 8, 12)
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
        fit = make(Ball(1.0, MODULUS, NU, YIELD_STRESS))
        depth = share * DEPTH
        w = np.array(depth / fit.yields_at)
        left = np.nan if fit.residual is None else float(fit.residual(w)) * fit.yields_at / depth
        area = float(fit.area(w)) * fit.area_unit / (np.pi * depth)
        values = float(fit.force(w)) * fit.force_unit / FORCE, area, left
        answers[make.__name__] = values if w <= fit.largest else (np.nan,) * 3
    return answers


def balances() -> list[list[str]]:
    """Return by how much stored and dissipated energies exceed the work."""
    shares = (5, 20, 60)
    heads = [f"d/d_y = {s}: F/F_y, energies − work" for s in shares]
    rows = [["N", *heads, "Newton steps"]]
    for n in (3, 6, 9):
        row, rounds = [str(n)], 0
        for share in shares:
            depth = share * DEPTH
            radius = float(np.sqrt(depth * min(2.0, 1 + 0.25 * np.log10(share) ** 1.2)))
            steel = PlasticMaterial(Material(1.0, NU), YIELD_STRESS)
            walk = Walk(steel, lambda r: r**2 / 2, radius, per_radius=n)
            (moment,) = walk.along(LoadPath("penetration", depth))
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


NAMES = (*READINGS, "kogut_etsion", "jackson_green")


def against_elements(place: int, symbol: str) -> list[list[str]]:
    """Return errors of the force (0), or of the area (1)."""
    rows = [["d/d_y", symbol, *NAMES]]
    for share in SHARES:
        true = on_elements(share, GRIDS[-1])[0][place]
        errors = [f"{100 * (c[place] / true - 1):+.0f} %" for c in others(share)]
        rows.append([str(share), f"{true:.4g}", *(_known(e) for e in errors)])
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
    "energy": balances,
    "elements": on_grids,
    "force": partial(against_elements, 0, "F/F_y"),
    "area": partial(against_elements, 1, "A/(πRd)"),
    "residual": remaining,
}

if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
