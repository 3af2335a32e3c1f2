"""Make the tables of docs/reduced-model.md: convergence, spectra, stress rules, rough stiffness.

Run from the repository's root (two minutes on one core). Tables that the page shows are written
into it, others are printed; all of them, or those that are named::

    python docs/examples/reduced_tables.py NAME
"""

# %%
import sys
from pathlib import Path

import numpy as np

from reduced.loads import Load
from reduced.profiles.equivalents import (
    cone,
    cylinder,
    paraboloid,
    power_law,
    rounded_punch,
    sphere,
)
from reduced.rough.ensemble import RandomLines, press_ensemble
from reduced.rough.line_spectrum import LineSpectrum, line_of, prescribed, sum_rules
from reduced.rough.press import RoughLines, press
from reduced.rough.surface_spectrum import SelfAffineLaw, self_affine
from reduced.springs.indent import indent
from reduced.springs.line import Springs
from reduced.springs.stress import abel, local_rule, one_radius_rule
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "reduced-model.md"
DRAWS = 2000
SPRINGS = np.array([10, 20, 40, 80])


# %% [markdown]
# Single contacts: rms relative errors over random a/dx and random offsets, and fitted orders.


# %%
def rounded_force(a: float, b: float = 0.4, radius: float = 3.0) -> float:
    """F = 2 E* int x g' dx of the rounded punch with x dx = w dw, which is smooth (Gauss)."""
    nodes, weights = np.polynomial.legendre.leggauss(60)
    end = np.sqrt(a**2 - b**2)
    w = end * (nodes + 1) / 2
    slope = (2 * w - b * np.arctan(w / b)) / radius
    return float(2 * np.sum(weights / 2 * w * slope) * end)


SHAPES = {
    "paraboloid": (paraboloid(1.0), lambda a: 4 / 3 * a**3, 1.0),
    "cone": (cone(0.3), lambda a: np.pi / 2 * 0.3 * a**2, 1.0),
    "power law, n = 4": (power_law(4, 0.5), lambda a: 8 / 5 * (8 / 3 * 0.5) * a**5, 1.0),
    "sphere, a to 0.6 R": (sphere(1.0), lambda a: (1 + a**2) * np.arctanh(a) - a, 0.6),
    "rounded punch, b = 0.4 a": (rounded_punch(0.4, 3.0), rounded_force, 1.0),
}


def contact_error(shape: str, springs: int, edges: str, rng: np.random.Generator) -> list[float]:
    """Relative errors of F and a at one random alignment."""
    profile, exact, largest = SHAPES[shape]
    a = largest * rng.uniform(0.6, 1.0)
    depth = float(profile.height(np.array(a)))
    row = Springs(*(profile, 1.0), spacing=largest / springs, edges=edges, offset=rng.uniform())
    contact = indent(row, Load("penetration", depth))
    return [contact.force[0] / exact(a) - 1, contact.contact_radius[0] / a - 1]


def punch_error(springs: int, edges: str, rng: np.random.Generator) -> list[float]:
    """Take the flat punch of random radius."""
    b = rng.uniform(0.6, 1.0)
    row = Springs(*(cylinder(b), 1.0), spacing=1 / springs, edges=edges, offset=rng.uniform())
    contact = indent(row, Load("penetration", 0.1))
    return [contact.force[0] / (0.2 * b) - 1, contact.contact_radius[0] / b - 1]


def line_error(springs: int, edges: str, rng: np.random.Generator) -> list[float]:
    """Press a paraboloid as a rough line, straight between its points."""
    a, shift = rng.uniform(0.6, 1.0), rng.uniform()
    x = (np.arange(-springs - 3, springs + 4) + shift) / springs
    depth = a**2 - np.min(x**2)
    contact = press(
        RoughLines(-(x**2), 1 / springs, periodic=False),
        1.0,
        Load("penetration", [depth]),
        edges=edges,
    )
    radius = np.sqrt(contact.contact_area[0, 0] / np.pi)
    return [contact.force[0, 0] / (4 / 3 * a**3) - 1, radius / a - 1]


def convergence(draws: int = DRAWS) -> list[list[str]]:
    """Rms errors at 40 springs per radius and orders in dx, over `draws` random alignments each."""
    rows = [["shape", "edges", "force at 40", "order", "radius at 40", "order"]]
    for edges in ("sub_cell", "nodal"):
        cases = {name: lambda n, e, r, name=name: contact_error(name, n, e, r) for name in SHAPES}
        cases |= {"cylinder": punch_error, "paraboloid as a sampled line": line_error}
        for name, error in cases.items():
            rng = np.random.default_rng(1)
            repeats = draws // SPRINGS.size
            errors = np.array([[error(n, edges, rng) for _ in range(repeats)] for n in SPRINGS])
            rms = np.sqrt(np.mean(errors**2, axis=1))
            cells = [name, edges]
            for column in rms.T:
                exact = column.max() < 1e-12
                order = -np.polyfit(np.log(SPRINGS), np.log(np.maximum(column, 1e-300)), 1)[0]
                cells += [f"{column[2]:.1e}", "exact" if exact else f"{order:.1f}"]
            rows.append(cells)
    return rows


# %% [markdown]
# Spectra: what the printed rule does to the rms height, and all rules to the three sum rules.


# %%
HURST = (0.1, 0.3, 0.5, 0.7, 0.8, 0.9, 1.0)
MODES = (32, 64, 128, 256, 512)


def printed_height() -> list[list[str]]:
    """Deviation of the line's rms height in per cent: (19.26) sampled / averaged over rings."""
    rows = [["H", *(f"{n} x {n} points" for n in MODES)]]
    for hurst in HURST:
        cells = [f"{hurst}"]
        for n in MODES:
            sampled = prescribed(
                n, 1.0, SelfAffineLaw(hurst=hurst, rms_height=1.0), rule="printed"
            ).rms_height
            surface = self_affine(n, 1.0, SelfAffineLaw(hurst=hurst, rms_height=1.0))
            averaged = line_of(surface, "printed").rms_height
            cells.append(f"{100 * (sampled - 1):+.1f} / {100 * (averaged - 1):+.1f}")
        rows.append(cells)
    return rows


def rules() -> list[list[str]]:
    """Line over surface, H = 0.8: rms height, slope, curvature."""
    rows = [["points", "roll-off", "rule", "height - 1", "slope - 1", "curvature - 1"]]
    for n in (64, 512):
        for roll_off in (None, 1 / 8):
            surface = self_affine(
                n, 1.0, SelfAffineLaw(hurst=0.8, rms_height=1.0, long_cutoff=roll_off)
            )
            for rule in ("rings", "split", "printed"):
                ratio = sum_rules(surface, line_of(surface, rule)).ratio - 1
                cells = [f"{x:+.1e}" for x in ratio]
                rows.append([str(n), "L/8" if roll_off else "none", rule, *cells])
    return rows


# %% [markdown]
# Stress: the two readings of the local rule (19.37) against the exact pressure.


# %%
def stress_rules() -> list[list[str]]:
    """Relative L2 error over the disc r < 0.99 a, and where the rule has a real value."""
    bodies = {name: profile for name, (profile, _, _) in SHAPES.items()}
    bodies |= {"power law, n = 1.5": power_law(1.5, 0.3), "cylinder": cylinder(1.0)}
    rows = [["shape", "own curvature: L2 error", "undefined area", "one radius: L2 error", "force"]]
    s = (np.arange(4000) + 0.5) / 4000 * 0.99
    for name, profile in bodies.items():
        depth = float(profile.height(np.array(0.6))) or 0.1
        a = float(profile.contact_radius(depth))
        exact = abel(profile, 1.0, depth, a * s)
        local, valid = local_rule(profile, 1.0, depth, a * s)
        one_radius = one_radius_rule(profile, 1.0, depth, a * s)
        scale = np.sum(s * exact**2)
        errors = [
            np.sqrt(np.sum(s * (stress - exact) ** 2) / scale) for stress in (local, one_radius)
        ]
        share = np.sum(s * ~valid) / np.sum(s)
        everywhere = (np.arange(4000) + 0.5) / 4000
        carried = one_radius_rule(profile, 1.0, depth, a * everywhere)
        force = 2 * np.pi * a**2 * np.sum(everywhere * carried) / 4000
        ratio = force / indent(Springs(profile, 1.0), Load("penetration", [depth])).force[0] - 1
        first = "no value" if share == 1 else f"{errors[0]:.1e}"
        cells = [name, first, f"{100 * share:.0f} %", f"{errors[1]:.1e}", f"{100 * ratio:+.1f} %"]
        rows.append(cells)
    return rows


# %% [markdown]
# Rough lines: the exponent of the contact stiffness, k ~ F^(1/(1+H)) (Pohrt & Popov 2012).


# %%
def stiffness_exponents(points: int = 2**15, realisations: int = 400) -> list[list[str]]:
    """Slope of log k against log F, line by line, while so much of the line is in contact."""
    shortest = (30, 100)
    head = ["H", "1/(1 + H)"]
    for least in shortest:
        head += [f"{least} dx to 3 % of L", "standard error"]
    rows = [head]
    mode = np.arange(1, points // 2)
    for hurst in (0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0):
        power = mode ** (-1 - 2 * hurst)
        line = LineSpectrum(2 * np.pi * mode, power / (2 * power.sum()), 1.0)
        lines = press_ensemble(
            *(RandomLines(line, points, realisations, seed=2), 1.0),
            Load("force", np.geomspace(1e-9, 1e-1, 120)),
            quantities=["contact_length", "force"],
        ).samples
        cells = [f"{hurst}", f"{1 / (1 + hurst):.3f}"]
        for least in shortest:
            slopes = []
            for length, force in zip(lines["contact_length"], lines["force"], strict=True):
                inner = (length > least / points) & (length < 0.03)
                slopes.append(np.polyfit(np.log(force[inner]), np.log(length[inner]), 1)[0])
            error = np.std(slopes, ddof=1) / np.sqrt(realisations)
            cells += [f"{np.mean(slopes):.3f}", f"{error:.3f}"]
        rows.append(cells)
    return rows


# %%
TABLES = {
    "convergence": convergence,
    "printed-height": printed_height,
    "sum-rules": rules,
    "stress-rules": stress_rules,
    "stiffness-exponents": stiffness_exponents,
}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
