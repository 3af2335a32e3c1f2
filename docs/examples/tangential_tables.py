"""Make the tables of docs/friction.md: springs and half-space with friction.

Run from the repository's root (two minutes on one core). Tables that the page shows are written
into it, others are printed; all of them, or those that are named::

    python docs/examples/tangential_tables.py NAME
"""

# %%
import sys
import time
from pathlib import Path

import numpy as np

from reduced.friction.slide import Friction, slide, slide_lines
from reduced.loads import Load, LoadPath
from reduced.profiles import equivalents
from reduced.rough.ensemble import RandomLines
from reduced.rough.line_spectrum import prescribed
from reduced.rough.surface_spectrum import SelfAffineLaw
from reduced.springs.line import Springs
from reference import closed_form, surfaces
from reference import loads as reference_loads
from reference.closed_form import PartialSlip, stiffness_ratio
from reference.contact.press import press
from reference.fem import Material, nodal_friction
from reference.fem.nodal_friction import frictional_body
from reference.halfspace import areas
from reference.halfspace.friction import FrictionalPress, FrictionStep, sweep, tangential_stiffness
from reference.halfspace.traction import Compliance, NormalAndTangential
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "friction.md"
MU = 0.3
NUS = (0.0, 0.2, 0.3, 0.4, 0.5)


def mindlin(nu: float) -> float:
    """Return k_x/k_z of a circle, (19.18)."""
    return 2 * (1 - nu) / (2 - nu)


# %% [markdown]
# Springs: rms errors over 60 random a/dx and offsets of F_x at half the sliding displacement.

# %%
SHAPES = {
    "paraboloid": (equivalents.paraboloid(1.0), closed_form.paraboloid(1.0, 1.0), 1.0),
    "cone": (equivalents.cone(0.3), closed_form.cone(0.3, 1.0), 1.0),
    "power law, n = 4": (equivalents.power_law(4, 0.5), closed_form.power_law(4, 0.5, 1.0), 1.0),
    "sphere, a to 0.6 R": (equivalents.sphere(1.0), closed_form.sphere(1.0, 1.0), 0.6),
    "rounded punch, b = 0.4 a": (
        equivalents.rounded_punch(0.4, 3.0),
        closed_form.rounded_punch(0.4, 3.0, 1.0),
        1.0,
    ),
}


def springs() -> list[list[str]]:
    """Errors at 40 springs and orders over 10 to 80, displacement halfway to sliding."""
    rows = [["shape", "edges", "F_x at 40", "order", "stick radius at 40", "order"]]
    rng = np.random.default_rng(0)
    for name, (profile, form, largest) in SHAPES.items():
        for edges in ("sub_cell", "nodal"):
            errors = []
            for count in (10, 20, 40, 80):
                misfits = [
                    _spring_error(profile, form, largest, count, edges, rng) for _ in range(200)
                ]
                errors.append(np.sqrt(np.mean(np.square(misfits), axis=0)))
            row = [name, edges]
            for column in np.array(errors).T:
                order = -np.polyfit(np.log([10, 20, 40, 80]), np.log(column + 1e-300), 1)[0]
                row += [f"{column[2]:.1e}", "exact" if column[2] < 1e-13 else f"{order:.1f}"]
            rows.append(row)
    return rows


def _spring_error(profile, form, largest, count, edges, rng) -> list[float]:
    a = largest * rng.uniform(0.6, 1.0)
    d = float(profile.height(np.array(a)))
    d_inner = d / 2
    path = slide(
        Springs(profile, 1.0, spacing=largest / count, offset=rng.uniform(), edges=edges),
        Friction(0.8, MU),
        Load("penetration", d),
        LoadPath("tangential_displacement", [MU * (d - d_inner) / 0.8]),
    )
    exact = MU * (form.force(d) - form.force(d_inner)), form.contact_radius(d_inner)
    return [path.tangential_force[0] / exact[0] - 1, path.stick_length[0] / 2 / exact[1] - 1]


# %% [markdown]
# Half-space: Cattaneo's force at nu = 0, and what a step costs.


# %%
def paraboloid_body(points: int, nu: float, offset=(0.4, 0.7), width: float = 2.2):
    """Return a paraboloid of radius 1 whose contact at d = 1 fills 2/2.2 of the grid."""
    x, y = ((np.arange(points) - points / 2 + s) * width / points for s in offset)
    body = NormalAndTangential((points,) * 2, (width / points,) * 2, Compliance.of(1.0, nu))
    return body, (x[:, None] ** 2 + y**2) / 2


def grid() -> list[list[str]]:
    """Error of F_x at nu = 0 over 8 offsets; iterations and time of a partial-slip step."""
    rows = [
        [
            "cells per radius",
            "rms error of F_x, nu = 0",
            "order",
            "iterations, nu = 0.3",
            "step, uncoupled",
            "rounds",
            "step, coupled",
        ]
    ]
    rng, before = np.random.default_rng(1), None
    exact = 0.5 * (1 - 0.5**1.5) / 0.5
    for points in (22, 44, 88, 176):
        errors = []
        for _ in range(8):
            body, gap = paraboloid_body(points, 0.0, rng.uniform(size=2))
            (step,) = sweep(
                FrictionalPress(body, gap, MU, coupled=False),
                reference_loads.LoadPath("penetration", 1.0),
                reference_loads.LoadPath("tangential_displacement", [MU / 2]),
            )
            errors.append(step.tangential_force / (MU * 4 / 3 * 2.0) / exact - 1)
        error = float(np.sqrt(np.mean(np.square(errors))))
        order = "" if before is None else f"{np.log2(before / error):.1f}"
        before = error
        body, gap = paraboloid_body(points, 0.3)
        cost = [_timed_step(body, gap, coupled) for coupled in (False, True)]
        (alone, both), spent = zip(*cost, strict=True)
        row = [f"{points / 2.2:.0f}", f"{error:.1e}", order, str(alone.iterations)]
        rows.append([*row, f"{spent[0]:.0f} ms", str(both.rounds), f"{spent[1]:.0f} ms"])
    return rows


def _timed_step(body: NormalAndTangential, gap: np.ndarray, coupled: bool) -> tuple:
    """Second step of a path (the first one warms up) and its processor time."""
    force = 4 / 3 * body.compliance.effective_modulus
    path = sweep(
        FrictionalPress(body, gap, MU, coupled=coupled),
        reference_loads.LoadPath("force", force),
        reference_loads.LoadPath("tangential_force", [0.3 * MU * force, 0.8 * MU * force]),
    )
    next(path)
    start = time.process_time()
    step = next(path)
    return step, 1e3 * (time.process_time() - start)


# %% [markdown]
# What the springs leave out: transverse slip, and the coupling for nu != 1/2.


# %%
def left_out() -> list[list[str]]:
    """Displacement and loss of a cycle against Cattaneo-Mindlin, rigid paraboloid."""
    rows = [
        [
            "nu",
            "u at 0.5 mu F",
            "u at 0.9 mu F",
            "loss of a cycle, 0.9 mu F",
            "largest q_y/q_x",
            "coupled: u at 0.5",
            "u at 0.9",
            "loss",
        ]
    ]
    for nu in NUS:
        row = [f"{nu}"]
        for coupled in (False, True):
            steps = _cycle(nu, coupled)
            body, _ = paraboloid_body(66, nu)
            ratio = body.compliance.tangential_modulus / body.compliance.effective_modulus
            form = closed_form.paraboloid(1.0, body.compliance.effective_modulus)
            exact = PartialSlip(form, 1.0, MU, ratio).along(
                [step.tangential_force for step in steps]
            )
            u = np.array([step.tangential_displacement for step in steps])
            shift = [u[k] / exact.tangential_displacement[k] - 1 for k in (0, 1)]
            scale = 3.6 * exact.contact.limit**2 / body.compliance.tangential_modulus
            bracket = 1 - 0.1 ** (5 / 3) - 0.75 * (1 + 0.1 ** (2 / 3))
            loss = (steps[-1].dissipation - steps[1].dissipation) / (scale * bracket) - 1
            row += [f"{100 * value:+.2f} %" for value in (*shift, loss)]
            if not coupled:
                q = np.abs(steps[1].traction)
                row.append(f"{q[1].max() / q[0].max():.3f}")
        rows.append(row)
    return rows


def _cycle(nu: float, coupled: bool, parts: int = 8) -> list[FrictionStep]:
    """Press in steps, then 0.5, 0.9, -0.9, 0.9 mu F, each stretch in parts; steps at the ends."""
    body, gap = paraboloid_body(66, nu)
    force = 4 / 3 * body.compliance.effective_modulus
    ends = np.array([0.0, 0.5, 0.9, -0.9, 0.9])
    shares = np.interp(np.arange(1, 4 * parts + 1) / parts, np.arange(5), ends)
    pressing = np.geomspace(0.02, 1, 12) if coupled else np.ones(1)
    loads = np.concatenate([pressing, np.ones(shares.size)]) * force
    shares = np.concatenate([np.zeros(pressing.size), shares])
    steps = list(
        sweep(
            FrictionalPress(body, gap, MU, coupled=coupled),
            reference_loads.LoadPath("force", loads),
            reference_loads.LoadPath("tangential_force", shares * MU * force),
        )
    )
    return [steps[pressing.size + (k + 1) * parts - 1] for k in range(4)]


# %% [markdown]
# (19.18) over the Poisson ratio and the shape of the contact.


# %%
def outlines(x: np.ndarray) -> dict[str, np.ndarray]:
    """Contacts of half-width about 1 on a square grid."""
    x, y = np.meshgrid(x, x, indexing="ij")
    return {
        "circle": np.hypot(x, y) < 1,
        "ellipse 2:1": np.hypot(x, 2 * y) < 1,
        "ellipse 4:1": np.hypot(x, 4 * y) < 1,
        "square": np.maximum(np.abs(x), np.abs(y)) < 0.9,
        "triangle": (x > -0.5) & (x + np.sqrt(3) * np.abs(y) < 1),
        "rectangle 8:1": (np.abs(x) < 0.95) & (np.abs(y) < 0.95 / 8),
        "rough contact": _rough_contact(x.shape[0]),
    }


def _rough_contact(points: int) -> np.ndarray:
    """Contact of a rough patch, about 10 % of its area."""
    height = surfaces.self_affine(
        points,
        2.1,
        surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, long_cutoff=1.0, short_cutoff=0.13),
        seed=4,
        realisation=0,
    )
    body = NormalAndTangential((points,) * 2, (2.1 / points,) * 2, Compliance.of(0.5, 0.0))
    contact = press(
        body.normal, height.max() - height, reference_loads.Load("force", 0.05 * 0.1 * 2.1**2)
    )
    return contact.mask


def ratios() -> list[list[str]]:
    """k_x/k_z over 2(1 - nu)/(2 - nu) - 1, along and across the long axis."""
    points = 96
    x = (np.arange(points) - points / 2 + 0.5) * 2.1 / points
    rows = [["contact", "direction", *(f"nu = {nu}" for nu in NUS[1:]), "ellipse, exact, nu = 0.5"]]
    for name, mask in outlines(x).items():
        for axis, direction in (("x", (1.0, 0.0)), ("y", (0.0, 1.0))):
            if axis == "y" and name in ("circle", "square", "triangle"):
                continue
            row = [name, axis]
            for nu in NUS[1:]:
                body = NormalAndTangential(
                    (points,) * 2, (2.1 / points,) * 2, Compliance.of(1.0, nu)
                )
                normal = areas.contact_stiffness(body.normal, mask)
                along, _ = tangential_stiffness(body, mask, direction)
                row.append(f"{100 * (along / normal / mindlin(nu) - 1):+.2f} %")
            aspect = {"circle": 1.0, "ellipse 2:1": 2.0, "ellipse 4:1": 4.0}.get(name)
            exact = "" if aspect is None else _exact_ratio(aspect, axis)
            rows.append([*row, exact])
    return rows


def _exact_ratio(aspect: float, axis: str) -> str:
    axes = (aspect, 1.0) if axis == "x" else (1.0, aspect)
    return f"{100 * (stiffness_ratio(*axes, 0.5) / mindlin(0.5) - 1):+.2f} %"


# %% [markdown]
# Steps of the coupled path: pressing alone, and then a shift.


# %%
def steps() -> list[list[str]]:
    """Stick radius after pressing and displacement at 0.5 mu F over the number of steps."""
    rows = [["steps of pressing", "stick radius / a after pressing", "u at 0.5 mu F / Cattaneo's"]]
    body, gap = paraboloid_body(66, 0.3)
    force = 4 / 3 * body.compliance.effective_modulus
    ratio = body.compliance.tangential_modulus / body.compliance.effective_modulus
    unit = MU / ratio * (1 - 0.5 ** (2 / 3))
    for count in (1, 5, 10, 20, 40):
        loads = np.append(np.geomspace(0.02, 1, count) if count > 1 else [1.0], 1.0) * force
        shifts = np.append(np.zeros(count), 0.5 * MU * force)
        *_, pressed, shifted = sweep(
            FrictionalPress(body, gap, MU),
            reference_loads.LoadPath("force", loads),
            reference_loads.LoadPath("tangential_force", shifts),
        )
        share = np.sqrt(pressed.sticking.sum() / (pressed.pressure > 0).sum())
        rows.append([str(count), f"{share:.3f}", f"{shifted.tangential_displacement / unit:.4f}"])
    return rows


# %% [markdown]
# Finite elements with friction: nothing shared with the half-space but the problem.


# %%
def second_opinion() -> list[list[str]]:
    """Largest differences along a path of penetration and displacement, over F and over mu F."""
    rows = [["nu", "nodes per radius", "F", "F_x", "F_x of the springs"]]
    shift = MU * 0.8 * np.array([0.3, 0.6, 0.9, 0.3, -0.3, -0.9])
    depth = np.concatenate([np.geomspace(0.1, 0.8, 8), np.full(6, 0.8)])
    loads = (
        reference_loads.LoadPath("penetration", depth),
        reference_loads.LoadPath("tangential_displacement", np.append(np.zeros(8), shift)),
    )
    for nu in (0.0, 0.2, 0.45):
        half_space, gap = paraboloid_body(44, nu)
        true = list(sweep(FrictionalPress(half_space, gap, MU), *loads))[8:]
        line = slide(
            Springs(equivalents.paraboloid(1.0), half_space.compliance.effective_modulus),
            Friction(half_space.compliance.tangential_modulus, MU),
            Load("penetration", 0.8),
            LoadPath("tangential_displacement", shift),
        )
        for elements in (2, 4):
            body = frictional_body(1.0, Material(2 * (1 + nu), nu), elements=elements)
            heights = (body.points**2).sum(axis=1) / 2
            pairs = list(
                zip(list(nodal_friction.follow(body, heights, MU, *loads))[8:], true, strict=True)
            )
            normal = max(abs(first.force / second.force - 1) for first, second in pairs)
            along = _apart([first.tangential_force for first, _ in pairs], true)
            springs = _apart(line.tangential_force, true)
            rows.append(
                [
                    f"{nu}",
                    str(2 * elements),
                    *(f"{100 * v:.2f} %" for v in (normal, along, springs)),
                ]
            )
    return rows


def _apart(forces, true: list[FrictionStep]) -> float:
    """Largest difference of tangential forces over mu F."""
    pairs = zip(forces, true, strict=True)
    return max(
        abs(force - second.tangential_force) / (MU * second.force) for force, second in pairs
    )


# %% [markdown]
# Rough surfaces: partial slip of a patch in three dimensions and of lines.


# %%
def rough() -> list[list[str]]:
    """Displacement over mu E* d/G* at three forces: half-space and springs."""
    points, load = 64, 0.02
    options = {"hurst": 0.8, "rms_slope": 0.1, "long_cutoff": 0.5, "short_cutoff": 4 / points}
    spectrum = surfaces.SelfAffine(**options)
    shares = np.array([0.3, 0.6, 0.9])
    displacements: dict[str, list[np.ndarray]] = {}
    for k in range(4):
        height = surfaces.self_affine(points, 1.0, spectrum, seed=2, realisation=k)
        gap, force = height.max() - height, load * 0.1
        for name, nu, coupled in (
            ("3-D, nu = 0, uncoupled", 0.0, False),
            ("3-D, nu = 0.3, uncoupled", 0.3, False),
            ("3-D, nu = 0.5", 0.5, False),
            ("3-D, nu = 0, coupled", 0.0, True),
            ("3-D, nu = 0.3, coupled", 0.3, True),
        ):
            compliance = Compliance.of((1 - nu) / 2, nu)  # E* = 1
            body = NormalAndTangential((points,) * 2, (1 / points,) * 2, compliance)
            normal = np.append(np.geomspace(0.05, 1, 8), np.ones(3)) * force
            path = np.append(np.zeros(8), shares) * MU * force
            steps = list(
                sweep(
                    FrictionalPress(body, gap, MU, coupled=coupled),
                    reference_loads.LoadPath("force", normal),
                    reference_loads.LoadPath("tangential_force", path),
                )
            )
            depth, unit = steps[7].penetration, MU / compliance.tangential_modulus
            u = np.array([step.tangential_displacement for step in steps[8:]])
            displacements.setdefault(name, []).append(
                (u - steps[7].tangential_displacement) / unit / depth
            )
        body = NormalAndTangential((points,) * 2, (1 / points,) * 2, Compliance.of(0.5, 0.0))
        depths = [
            press(body.normal, gap, reference_loads.Load("force", force * s)).penetration
            for s in (1, *(1 - shares))
        ]
        displacements.setdefault("3-D, superposition of normal solutions", []).append(
            1 - np.array(depths[1:]) / depths[0]
        )
    displacements["springs of lines"] = _lines(load, shares, options)
    rows = [["model", *(f"F_x = {s} mu F" for s in shares)]]
    return rows + [
        [name, *(f"{v:.4f}" for v in np.mean(u, axis=0))] for name, u in displacements.items()
    ]


def _lines(load: float, shares: np.ndarray, options: dict) -> list[np.ndarray]:
    """Displacements of 100 lines of the same spectrum, springs 4G/(2 - nu), any nu."""
    drawn = RandomLines(prescribed(64, 1.0, SelfAffineLaw(**options)), 512, 100).draw()
    force = load * 0.1
    path = slide_lines(
        drawn,
        1.0,
        Friction(0.8, MU),
        Load("force", force),
        LoadPath("tangential_force", shares * MU * force),
    )
    return list(path.tangential_displacement * 0.8 / MU / path.penetration[:, None])


# %%
TABLES = {
    "springs": springs,
    "grid": grid,
    "left-out": left_out,
    "ratios": ratios,
    "steps": steps,
    "second-opinion": second_opinion,
    "rough": rough,
}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
