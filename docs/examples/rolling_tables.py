"""Make the tables of rolling: docs/friction.md, and on rubber docs/rubber-and-impact.md.

Run from the repository's root (three minutes on one core). Tables that the page shows are written
into it, others are printed; all of them, or those that are named::

    python docs/examples/rolling_tables.py NAME
"""

# %%
import sys
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path

import numpy as np

from comparisons.judging.uncertainty import grid_uncertainty
from comparisons.methods.rolling import SPIN_DOUBT
from comparisons.questions.experiments.rolling import creep_coefficients
from comparisons.questions.experiments.rolling_cylinders import (
    Carter,
    PlaneElements,
    PlaneSurface,
    RubberCylinder,
    hertz,
    moving_compliance,
)
from reduced.friction.roll import roll as roll_springs
from reduced.friction.slide import Friction
from reduced.loads import Load
from reduced.profiles.equivalents import paraboloid
from reduced.springs.line import Springs
from reference import loads as reference_loads
from reference.fem import Material
from reference.fem.columns import ELEMENTS, Element
from reference.fem.grid_body import ShearBody
from reference.halfspace.friction import FrictionalPress
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.rolling.creep_theories import EllipticContact, fastsim, kalker, linear, on_grid
from reference.rolling.roll import Creep, TangentialSurface, Upstream, rigid_slip, roll, steady
from reference.viscoelastic.materials import GeneralisedMaxwell
from reference.viscoelastic.rubber import slide_on_rubber
from reference.viscoelastic.travelling import TravellingPlane
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "friction.md"
MU, NU = 0.3, 0.28
FORCE = 4 / 3  # a = R = E* = 1
SHEAR = (1 - NU) / 2
CREEPS = (0.002, 0.03, 0.06, 0.1, 0.15, 0.2, 0.3)


def ball(cells: int) -> FrictionalPress:
    """Return the roller on so many cells per contact radius."""
    half = int(np.ceil(1.45 * cells))
    x = (np.arange(-half, half) + 0.5) / cells
    body = NormalAndTangential((x.size,) * 2, (1 / cells,) * 2, Compliance.of(SHEAR, NU))
    return FrictionalPress(body, (x[:, None] ** 2 + x**2) / 2, MU, coupled=False)


def tractions(cells: int, creeps: tuple[float, ...]) -> np.ndarray:
    """Return F_x/(mu F) on a grid."""
    load = reference_loads.Load("force", FORCE)
    steps = roll(ball(cells), load, [Creep(creep) for creep in creeps])
    return np.array([step.tangential_force for step in steps]) / (MU * FORCE)


# %% [markdown]
# Grids: tractions, and processor time of a creep; the limit is a straight line through the finest.


# %%
def grids() -> list[list[str]]:
    """Tractions of three creeps and the time for one."""
    rows = [["cells per radius", "ξ 0.002", "0.06", "0.2", "time of a creep"]]
    creeps, counts, answers = (0.002, 0.06, 0.2), (6, 8, 12, 16, 20, 24), []
    for cells in counts:
        started = time.process_time()
        answers.append(tractions(cells, creeps))
        seconds = (time.process_time() - started) / len(creeps)
        rows.append([str(cells), *(f"{value:.4f}" for value in answers[-1]), f"{seconds:.2f} s"])
    limit = np.polyfit(1 / np.array(counts[2:]), np.array(answers[2:]), 1)[1]
    rows.append(["limit", *(f"{value:.4f}" for value in limit), ""])
    return rows


def rubber() -> list[list[str]]:
    """Return the rolling resistance of a cylinder by Hunter, and errors on cells."""
    heads = [f"error, {count} cells" for count in (12, 24, 48)]
    rows = [["l/h", "middle/h", "F/F at rest", "µ R/l", *heads, "µ R/l, Kelvin-Voigt"]]
    for way in (0.1, 0.3, 1.0, 3.0, 10.0, 100.0):
        exact = RubberCylinder(1.0, 100.0, way, 0.25, 11.0)
        kelvin = RubberCylinder(1.0, 100.0, way, 0.25, np.inf)
        errors = [hunter_error(exact, count) for count in (12, 24, 48)]
        row = [f"{way:g}", f"{exact.middle:.3f}", f"{exact.force * 400 / np.pi:.3f}"]
        row += [f"{exact.resistance * 100 / way:.4f}", *(f"{100 * e:+.3f} %" for e in errors)]
        rows.append([*row, f"{kelvin.resistance * 100 / way:.4f}"])
    return rows


def hunter_error(exact: RubberCylinder, count: int) -> float:
    """Return the error of the resistance on cells of a standard solid."""
    x = exact.middle + (np.arange(3 * count)[:, None] + 0.5) / count - 1.5
    solid = GeneralisedMaxwell.standard(0.25, 2.5, 1 / 11)
    strips = TravellingPlane(3 * count, 1 / count, solid, exact.way)
    force = reference_loads.Load("force", exact.force)
    contact = slide_on_rubber(strips, x**2 / 200, force, slope=x / 100)
    return contact.friction_coefficient / exact.resistance - 1


def coefficients() -> list[list[str]]:
    """Creep coefficients over nu and a/b, beside Kalker's and the line's."""
    rows = [["ν", "a/b", "C11", "C22", "C23", "C33", "springs", "C11 of springs"]]
    for nu in (0.0, 0.25, 0.5):
        for ratio in (0.2, 0.5, 1.0, 2.0, 5.0):
            study, printed = creep_coefficients(nu, ratio), kalker(ratio, nu)
            values = [
                f"{value:.3f} ({known:.3g})"
                for value, known in zip(study.limit, printed, strict=True)
            ]
            line = 4 / (2 - nu)
            error = f"{100 * (line / study.limit[0] - 1):+.0f} %"
            rows.append([f"{nu:g}", f"{ratio:g}", *values, f"{line:.3f}", error])
    return rows


def elements() -> list[list[str]]:
    """C11 and C22 of finite elements against cells of the half-space of the same size."""
    rows = [["ν", "element", *(f"{c}, N = {n}" for n in (6, 8, 11) for c in ("C11", "C22"))]]
    for nu in (0.0, 0.25, 0.5):
        for element in ELEMENTS:
            row = [f"{nu:g}", element]
            for count in (6, 8, 11):
                cells, mesh = (
                    on_grid(body, 1.0, count)
                    for body in (
                        partial(half_space, nu=nu),
                        partial(finite_elements, nu=nu, element=element),
                    )
                )
                row += [f"{100 * error:+.2f} %" for error in (mesh / cells - 1)[:2]]
            rows.append(row)
    return rows


def inertia() -> list[list[str]]:
    """C11 and C22 of a circle over rho V^2/G at nu = 1/4, against those at rest."""
    rows = [["ρV²/G", "C11", "C22", "steel, G = 80 GPa", "rubber, G = 1 MPa"]]
    material, values = Material(2.5, 0.25), (0.0, 0.01, 0.1, 0.3, 0.5)

    def coefficients_at(share: float) -> np.ndarray:
        return on_grid(lambda s, h: ShearBody(s, (h, h), material, inertia=share), 1.0, 8)

    still = coefficients_at(0.0)
    for value in values[1:]:
        errors = coefficients_at(value) / still - 1
        speeds = [np.sqrt(value * g / density) for g, density in ((80e9, 7850), (1e6, 1000))]
        row = [f"{value:g}", *(f"{100 * error:+.1f} %" for error in errors[:2])]
        rows.append(row + [f"{speed:.2g} m/s" for speed in speeds])
    return rows


def cylinder() -> list[list[str]]:
    """Traction of a cylinder against Carter's: cells, elements of plane strain, with inertia."""
    rows = [["cells per half width", "half-space", "elements", "ρV²/G = 0.1", "0.5"]]
    for count in (10, 20, 40, 80):
        row = [str(count)]
        for share in (None, 0.0, 0.1, 0.5):
            errors = [carter_error(count, traction, share) for traction in (0.2, 0.5, 0.9)]
            row.append(f"{100 * max(errors, key=abs):+.2f} %")
        rows.append(row)
    return rows


def carter_error(count: int, traction: float, share: float | None, nu: float = 0.25) -> float:
    """Return the relative error of F_x/(mu F) on cells, or on elements of some inertia."""
    contact, compliance = Carter(1.0, 100.0, MU), Compliance.of(1.0, nu)
    x = (np.arange(-count, count + 1) + 0.5) / count
    bound = MU * hertz(x, 1.0, np.pi * compliance.effective_modulus / 400)[:, None]
    creep = np.zeros((2, x.size, 1))
    creep[0] = contact.creep(traction) * moving_compliance(nu, share or 0.0)
    surface = PlaneSurface(x.size, 1 / count, compliance)
    if share is not None:
        surface = PlaneElements(x.size, 1 / count, compliance, nu, inertia=share)
    answer = steady(Upstream(surface, bound.shape), bound, creep).traction
    return float(answer[0].sum() / bound.sum()) / traction - 1


def curve() -> list[list[str]]:
    """Tractions of all methods over the creep, and their errors."""
    rows = [["ξ", "half-space", "springs", "matched", "FASTSIM", "linear"]]
    fine, coarse = tractions(24, CREEPS), tractions(12, CREEPS)
    true = np.minimum(2 * fine - coarse, 1.0)
    contact = EllipticContact((1.0, 1.0), SHEAR, NU, MU * FORCE)
    springs = Springs(paraboloid(1.0), 1.0, per_radius=100)
    plain = Friction(Compliance.of(SHEAR, NU).tangential_modulus, MU)
    matched = Friction(SHEAR * kalker(1.0, NU)[0], MU)
    load = Load("force", FORCE)
    stated = [
        roll_springs(springs, friction, load, CREEPS).tangential_force
        for friction in (plain, matched)
    ]
    stated += [
        np.array([theory(contact, creep).tangential_force for creep in CREEPS])
        for theory in (fastsim, linear)
    ]
    for place, creep in enumerate(CREEPS):
        errors = [values[place] / (MU * FORCE) / true[place] - 1 for values in stated]
        texts = [f"{100 * error:+.0f} %" for error in errors]
        rows.append([f"{creep:g}", f"{true[place]:.3f}", *texts])
    return rows


# %% [markdown]
# Other shapes and other creeps: a b = 1, G = 1, creeps by which the linear theory has 0.8 mu F.

# %%
DRIVES = {
    "along": (0.8, 0.0, 0.0),
    "across": (0.0, 0.8, 0.0),
    "along and across": (0.57, 0.57, 0.0),
    "spin": (0.0, 0.0, 0.8),
    "along and spin": (0.57, 0.0, 0.57),
    "across against spin": (0.0, -0.8, 1.6),
}


def others() -> list[list[str]]:
    """Return forces of other contacts, errors and bars of grids, and errors of FASTSIM."""
    heads = ["F/(µF_z)", "error, N = 16", "its bar", "elements, N = 8", "FASTSIM"]
    rows = [["a/b", "creep", *heads]]
    counts = (4, 8, 12, 16, 20)
    for ratio in (0.2, 1.0, 5.0):
        known = kalker(ratio, NU)
        slips = [
            Creep(*(share / (2 * c) for share, c in zip(shares, known, strict=False)))
            for shares in DRIVES.values()
        ]
        forces = np.array([on_ellipse(ratio, count, slips) for count in counts])
        true = np.polyfit(1 / np.array(counts[2:]), forces[2:], 1)[1]
        three = forces[[0, 1, 3]]
        meshed = on_ellipse(ratio, 8, slips, finite_elements)
        contact = EllipticContact((np.sqrt(ratio), 1 / np.sqrt(ratio)), 1.0, NU, 1.0)
        for place, name in enumerate(DRIVES):
            simple = fastsim(contact, *slips[place])
            size = np.hypot(simple.tangential_force, simple.lateral_force)
            (bar,) = grid_uncertainty(np.array([4, 8, 16]), three[:, place : place + 1])
            bar += SPIN_DOUBT / (16 * np.sqrt(ratio)) if slips[place].spin else 0.0
            errors = forces[3][place] / true[place] - 1, bar
            others = meshed[place] / forces[1][place] - 1, size / true[place] - 1
            texts = [f"{100 * errors[0]:+.1f} %", f"{100 * errors[1]:.1f} %"]
            texts += [f"{100 * error:+.1f} %" for error in others]
            rows.append([f"{ratio:g}", name, f"{true[place]:.3f}", *texts])
    return rows


def contact_example() -> list[list[str]]:
    """Return the lateral force of CONTACT's example of spin, on finer and finer cells.

    G = 82 GPa of both bodies, semi-axes 8 and 4 mm, mu F = 24.6 kN, lateral creep -6.25e-4, spin
    6.25e-4 /mm; here in units of the root of a b, and of mu F.
    """
    rows = [["cells on √(ab)", "half-space", "FASTSIM"]]
    axes, limit = np.array([8.0, 4.0]), 0.3 * 82e3
    unit = np.sqrt(axes.prod())
    creep = 6.25e-4 * 41000.0 * unit**2 / limit
    drive, counts = Creep(0.0, -creep, creep * unit), (8, 12, 16, 20)
    contact = EllipticContact(tuple(axes / unit), 1.0, NU, 1.0)
    forces = [float(on_ellipse(2.0, count, [drive])[0]) for count in counts]
    simple = [
        fastsim(contact, drive.along, drive.across, drive.spin, cells=count).lateral_force
        for count in (*counts, 400)
    ]
    for count, *values in zip(counts, forces, simple[:-1], strict=True):
        rows.append([str(count), *(f"{value:.3f}" for value in values)])
    limiting = np.polyfit(1 / np.array(counts[1:]), forces[1:], 1)[1]
    return [*rows, ["limit", f"{limiting:.3f}", f"{simple[-1]:.3f}"]]


def on_ellipse(
    ratio: float,
    cells: int,
    creeps: list[Creep],
    surface: Callable[..., TangentialSurface] | None = None,
) -> np.ndarray:
    """Return F/(mu F_z) below Hertz's pressure, so many cells on the root of a b."""
    side, axes = 1.0 / cells, np.array([np.sqrt(ratio), 1 / np.sqrt(ratio)])
    half = np.ceil(axes / side).astype(int) + 1
    x, y = ((np.arange(-n, n) + 0.5) * side for n in half)
    bound = np.sqrt(np.maximum(1 - (x[:, None] / axes[0]) ** 2 - (y / axes[1]) ** 2, 0))
    bound /= bound.sum() * side**2
    below = (surface or half_space)(bound.shape, side)
    flow = Upstream(below, bound.shape)
    slips = [rigid_slip(creep, bound.shape, (side, side)) for creep in creeps]
    sums = [steady(flow, bound, slip).traction.sum(axis=(1, 2)) for slip in slips]
    return np.hypot(*np.array(sums).T) * side**2


def half_space(shape: tuple[int, int], side: float, nu: float = NU) -> NormalAndTangential:
    """Return the half-space of G = 1."""
    return NormalAndTangential(shape, (side, side), Compliance.of(1.0, nu))


def finite_elements(
    shape: tuple[int, int], side: float, nu: float = NU, element: Element = "splines"
) -> ShearBody:
    """Return elements of G = 1."""
    return ShearBody(shape, (side, side), Material(2 * (1 + nu), nu), element=element)


# %%
TABLES = {
    "grids": grids,
    "cylinder": cylinder,
    "elements": elements,
    "inertia": inertia,
    "coefficients": coefficients,
    "rubber": rubber,
    "curve": curve,
    "others": others,
    "contact": contact_example,
}

if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
