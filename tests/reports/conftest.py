"""A synthetic study: numbers of the right size from Hertz, so that reports can be tested alone.

One axisymmetric scene (five methods, three resolutions, six loads, one lost solve, one method
that cannot do it, a hostile title) and one rough ensemble (five realisations and their means).
"""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pandas as pd
import pytest

from comparisons.files import write_arrays
from comparisons.judging.truth import Reference
from comparisons.judging.verdicts import Verdict, judged
from comparisons.results.record import SceneRecord, StudyRecord
from comparisons.results.recording import explained
from comparisons.results.rows import Rows
from comparisons.results.store import save_study
from comparisons.solving.plan import MethodPlan, PlanRecord

RADIUS, MODULUS = 0.01, 231e9
DEPTHS = np.array([1e-6, 2e-6, 3e-6, 5e-6, 7e-6, 1e-5])
# (resolutions, seconds at the coarsest, growth of time, error at the coarsest, rate)
SPHERE_METHODS = {
    "closed_form": ((1,), 2e-6, 1.0, 0.0, 0.0),
    "reduced": ((10, 20, 40), 2e-6, 1.4, 2e-4, 2.0),
    "bem_dense": ((5, 10, 20), 4e-3, 16.0, 1.2e-2, 1.2),
    "bem_fft": ((16, 32, 64), 8e-3, 4.5, 6e-3, 1.2),
    "fem": ((4, 8, 16), 0.9, 6.0, 2.5e-2, 1.1),
}
ROUGH_ONLY = "the surface is smooth: ContactMechanics takes rough maps only"
HOSTILE = "Ball <script>alert(1)</script> & 'quotes' on a half-space"


def hertz(depth: np.ndarray) -> dict[str, np.ndarray]:
    """Hertz' solution for a paraboloid (Johnson 1985, eq. 4.22-4.24)."""
    a = np.sqrt(RADIUS * depth)
    return {
        "force": 4 / 3 * MODULUS * np.sqrt(RADIUS) * depth**1.5,
        "contact_radius": a,
        "contact_area": np.pi * a**2,
        "stiffness": 2 * MODULUS * a,
    }


def settings(scene: str, methods: dict, setup: float):
    """Yield each setting: place from the coarsest, size of its error, columns of all its rows."""
    for method, (resolutions, seconds, growth, error, rate) in methods.items():
        for level, resolution in enumerate(resolutions):
            took = seconds * growth**level
            common = {"scene": scene, "method": method, "options": "", "resolution": resolution}
            common |= {"realisation": "0", "converged": True}
            # All solves that an error stands on are the one that is timed.
            common |= dict.fromkeys(("seconds", "seconds_all"), took)
            common |= dict.fromkeys(("setup_seconds", "setup_seconds_all"), setup * took)
            common["unknowns"] = resolution ** (1 if method == "reduced" else 2)
            yield level, error / 2 ** (rate * level), common


def sphere_rows(rng: np.random.Generator) -> pd.DataFrame:
    exact, parts = hertz(DEPTHS), []
    for level, error, common in settings("steel-ball", SPHERE_METHODS, 0.7):
        method = common["method"]
        common |= {"compile_seconds": 0.4, "threads": 1, "reference": "closed_form"}
        common["memory"] = 1e6 * SPHERE_METHODS[method][2] ** level
        if method == "closed_form":
            common |= {"setup_seconds": 0.0, "setup_seconds_all": 0.0}
        if method == "fem":
            common["options"], error = "contact=penalty", -error
        if method == "bem_dense" and level == 2:
            reason = "active set cycled after 30 rounds: [<b>residual</b> 1e-3]"
            parts.append(pd.DataFrame([common | {"converged": False, "reason": reason}]))
            continue
        e_force = error * (1 + 0.3 * rng.standard_normal(len(DEPTHS)))
        e_area = 3 * e_force[::-1]
        solved = {
            "step": np.arange(len(DEPTHS)),
            "penetration": DEPTHS,
            "force": exact["force"] * (1 + e_force),
            "contact_area": exact["contact_area"] * (1 + e_area),
            "contact_area_raw": exact["contact_area"] * (1 + 2 * e_area),
            "contact_radius": exact["contact_radius"],
            "stiffness": exact["stiffness"],
            "error_force": e_force,
            "error_contact_area": e_area,
            "reference_uncertainty": 0.0,
            "reference_uncertainty_force": 0.0,
            "reference_uncertainty_contact_area": 0.0,
            "iterations": 12 + np.arange(len(DEPTHS)),
            "violation": 1e-9,
        }
        parts.append(pd.DataFrame(common | solved))
    refused = {"scene": "steel-ball", "method": "contactmechanics", "converged": False}
    parts.append(pd.DataFrame([refused | {"reason": ROUGH_ONLY}]))
    return pd.concat(parts, ignore_index=True)


def verdicts_of(
    rows: pd.DataFrame, quantities: dict[str, str], tolerance: float
) -> tuple[Verdict, ...]:
    kept = rows[rows["step"].notna() & ~rows["realisation"].isin(["0", "1", "2", "3", "4"])]
    if kept.empty:
        kept = rows[rows["step"].notna()]
    verdicts = []
    for (method, resolution), group in kept.groupby(["method", "resolution"], sort=False):
        for name, at in quantities.items():
            error = group[f"error_{name}"].to_numpy()
            bar = group[f"reference_uncertainty_{name}"].to_numpy()
            setting = {"method": method, "resolution": resolution, "quantity": name, "at": at}
            rms = np.sqrt(np.mean(error**2))
            verdicts.append(judged(error, bar, tolerance, rms=rms, **setting))
    return tuple(verdicts)


def hertz_pressure(x: np.ndarray, y: np.ndarray, depth: float = DEPTHS[-1]) -> np.ndarray:
    a = np.sqrt(RADIUS * depth)
    peak = 2 * MODULUS * a / (np.pi * RADIUS)
    return peak * np.sqrt(np.maximum(1 - (x**2 + y**2) / a**2, 0.0))


def quarter_block(divisions: int = 8) -> dict[str, np.ndarray]:
    """Return a graded quarter block of hexahedra in VTK order, surface at z = 0, body below."""
    a = np.sqrt(RADIUS * DEPTHS[-1])
    side = 6 * a * np.linspace(0, 1, divisions + 1) ** 1.5
    x, y, z = np.meshgrid(side, side, -side[::-1], indexing="ij")
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    index = np.arange(points.shape[0]).reshape(x.shape)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corners += [(i, j, 1) for i, j, _ in corners]
    n = divisions
    cells = np.stack([index[i : n + i, j : n + j, k : n + k].ravel() for i, j, k in corners], 1)
    distance = np.hypot(np.hypot(points[:, 0], points[:, 1]), points[:, 2] + 0.48 * a)
    displacement = np.zeros_like(points)
    displacement[:, 2] = -DEPTHS[-1] / (1 + (distance / a) ** 2)
    on_top = points[:, 2] == 0
    return {
        "mesh_points": points,
        "mesh_cells": cells,
        "mesh_displacement": displacement,
        "mesh_von_mises": 0.62 * hertz_pressure(0, 0) / (1 + (distance / a) ** 2),
        "pressure_x": points[on_top, 0],
        "pressure_y": points[on_top, 1],
        "pressure": hertz_pressure(points[on_top, 0], points[on_top, 1]),
    }


def sphere_fields(folder: Path) -> dict[tuple[str, int], Path]:
    a = np.sqrt(RADIUS * DEPTHS[-1])
    r = np.linspace(0, 1.4 * a, 60)
    line = {"pressure_x": r, "pressure_y": 0 * r, "pressure": hertz_pressure(r, 0 * r)}
    side = (np.arange(64) + 0.5) / 64 * 2.6 * a - 1.3 * a
    x, y = (axis.ravel() for axis in np.meshgrid(side, side, indexing="ij"))
    grid = {"pressure_x": x, "pressure_y": y, "pressure": 0.99 * hertz_pressure(x, y)}
    earlier = {
        f"step.{step}.pressure": 0.99 * hertz_pressure(x, y, depth)
        for step, depth in enumerate(DEPTHS[:-1])
    }
    shorter = {
        f"step.{step}.pressure": hertz_pressure(r, 0 * r, depth)
        for step, depth in enumerate(DEPTHS[:-1])
    }
    profile_x = np.linspace(0, 1.5 * a, 80)
    profile = {"profile_x": profile_x, "profile_height": profile_x**2 / RADIUS}
    arrays = {
        ("closed_form", 1): line | shorter,
        ("reduced", 40): line | profile,
        ("bem_fft", 64): grid | earlier | {"pressure_shape": np.array([64, 64])},
        ("fem", 16): quarter_block(),
    }
    return written(folder, "ball", arrays)


def written(folder: Path, stem: str, arrays: dict) -> dict[tuple[str, int], Path]:
    paths = {}
    for (method, resolution), content in arrays.items():
        path = folder / "fields" / f"{stem}-{method}-{resolution}.npz"
        write_arrays(path, content | {"penetration": np.float64(DEPTHS[-1])})
        paths[method, resolution] = path
    return paths


def sphere_scene(folder: Path, rng: np.random.Generator) -> SceneRecord:
    rows = sphere_rows(rng)
    verdicts = verdicts_of(rows, {"force": "penetration", "contact_area": "penetration"}, 0.01)
    modelled = {
        "closed_form": "Hertz' paraboloid on an elastic half-space",
        "reduced": "a row of independent springs under the profile g(x) = x²/R",
        "fem": "a quarter of a block, eight-node bricks, penalty contact",
    }
    cells = "an elastic half-space with uniform pressure on square cells"
    methods = [
        MethodPlan(name, True, "", spec[0], modelled.get(name, cells))
        for name, spec in SPHERE_METHODS.items()
    ]
    methods.append(MethodPlan("contactmechanics", False, ROUGH_ONLY))
    return whole(
        SceneRecord(
            name="steel-ball",
            title=HOSTILE,
            text='name = "steel-ball"\n[half_space]\neffective_modulus = 231e9 # </script><b>&\n',
            control="penetration",
            quantities=("force", "contact_area"),
            tolerance=0.01,
            plan=PlanRecord(
                methods=tuple(methods),
                left_out=(("friction", "identical materials: no slip in normal contact"),),
                notes=("The block is 12 contact radii wide; its far field is matched.",),
            ),
            reference=Reference(
                "closed_form",
                1,
                "Hertz (Johnson 1985, eq. 4.22-4.24), exact.",
                {name: {"arithmetic": [0.0] * len(DEPTHS)} for name in ("force", "contact_area")},
            ),
            disagreements=(),
            rows=Rows.of(rows),
            verdicts=tuple(verdict for verdict in verdicts if verdict.method != "closed_form"),
            fields=sphere_fields(folder),
        )
    )


def whole(scene: SceneRecord) -> SceneRecord:
    """Return a scene with all its verdicts, as a study records them."""
    return replace(scene, verdicts=explained(scene))


ROUGH_METHODS = {
    "reduced": ((32, 64, 128), 4e-4, 2.1, 0.09, 0.1),
    "bem_fft": ((32, 64, 128), 0.2, 4.4, 0.05, 1.0),
}


def rough_rows(rng: np.random.Generator) -> pd.DataFrame:
    forces, parts = np.geomspace(1e-7, 1e-5, 8), []
    gap = 3e-8 * np.log(5e-5 / forces)
    for _, error, common in settings("rough-patch", ROUGH_METHODS, 0.2):
        scatter = 1 + 0.15 * rng.standard_normal((5, 1))
        area = 9e-9 * (forces / 1e-5) ** 0.95 * scatter * (1 + error) * 1e-4
        depth = (2e-7 - gap) * scatter * (1 + 0.5 * error)
        is_truth = (common["method"], common["resolution"]) == ("bem_fft", 128)
        mean = {
            "stderr_penetration": 0.03 * gap,
            "stderr_contact_area": 0.06 * area.mean(axis=0),
            "error_penetration": np.nan if is_truth else 0.5 * error,
            "error_contact_area": np.nan if is_truth else error,
        }
        for realisation in [*range(5), "mean"]:
            pick = slice(None) if realisation == "mean" else [realisation]
            solved = {
                "realisation": str(realisation),
                "step": range(len(forces)),
                "force": forces,
                "penetration": depth[pick].mean(axis=0),
                "contact_area": area[pick].mean(axis=0),
                "mean_gap": gap,
                **(mean if realisation == "mean" else dict.fromkeys(mean, np.nan)),
                "reference": "bem_fft 128",
                "reference_uncertainty": 0.02,
                "reference_uncertainty_penetration": 0.01,
                "reference_uncertainty_contact_area": 0.02,
                "iterations": 40,
                "violation": 1e-10,
            }
            parts.append(pd.DataFrame(common | solved))
    return pd.concat(parts, ignore_index=True)


def rough_fields(folder: Path, rng: np.random.Generator) -> dict[tuple[str, int], Path]:
    points, size = 64, 1e-6
    wave = np.fft.fftfreq(points, 1 / points)
    q = np.hypot(*np.meshgrid(wave, wave, indexing="ij"))
    power = np.where((q > 1) & (q < 24), np.maximum(q, 1.0) ** -1.8, 0.0)
    noise = np.fft.fft2(rng.standard_normal((points, points)))
    heights = np.fft.ifft2(noise * power).real
    heights *= 1e-8 / heights.std()
    line = heights[:, 5]
    side = (np.arange(points) + 0.5) * size / points
    x, y = (axis.ravel() for axis in np.meshgrid(side, side, indexing="ij"))
    overlap = np.maximum(heights - np.quantile(heights, 0.93), 0.0)
    surface = {
        "heights": heights,
        "size": np.array([size, size]),
        "pressure_x": x,
        "pressure_y": y,
        "pressure": 3e17 * overlap.ravel(),
        "pressure_shape": np.array([points, points]),
    }
    surface |= {
        f"step.{step}.pressure": 3e17 * np.maximum(overlap.ravel() - (7 - step) * 1e-9, 0.0)
        for step in range(1, 7)
    }
    reduced = {
        "line_x": side,
        "line_height": line,
        "line_penetration": np.float64(0.35 * np.ptp(line)),
        "heights": heights,
        "size": np.array([size, size]),
    }
    return written(folder, "rough", {("bem_fft", 128): surface, ("reduced", 128): reduced})


def rough_scene(folder: Path, rng: np.random.Generator) -> SceneRecord:
    rows = rough_rows(rng)
    kept = verdicts_of(rows, {"penetration": "force", "contact_area": "force"}, 0.05)
    levels = (32, 64, 128)
    methods = [MethodPlan(name, True, "", levels, "five realisations") for name in ROUGH_METHODS]
    reason = "a rough patch of 64 x 64 points needs 10⁸ unknowns"
    methods.append(MethodPlan("fem", False, reason))
    return whole(
        SceneRecord(
            name="rough-patch",
            title="Self-affine patch, H = 0.8, five realisations",
            text='name = "rough-patch"\n[surface]\nkind = "self_affine"\nseed = 1\n',
            control="force",
            quantities=("penetration", "contact_area"),
            tolerance=0.05,
            plan=PlanRecord(methods=tuple(methods)),
            reference=Reference(
                "bem_fft",
                128,
                "BEM (FFT) on 128 x 128 points, five surfaces.",
                {
                    "penetration": {"discretisation": [0.01] * 7},
                    "contact_area": {"discretisation": [0.016] * 7, "realisations": [0.012] * 7},
                },
            ),
            disagreements=(
                "Contact area at the lowest load: bem_fft 64 and 128 differ by 4.1 %, bars 2 %.",
            ),
            rows=Rows.of(rows),
            verdicts=tuple(v for v in kept if (v.method, v.resolution) != ("bem_fft", 128)),
            fields=rough_fields(folder, rng),
        )
    )


@pytest.fixture(scope="session")
def study(tmp_path_factory) -> StudyRecord:
    """Write the synthetic study that several tests render."""
    folder, rng = tmp_path_factory.mktemp("study"), np.random.default_rng(7)
    record = StudyRecord(
        directory=folder,
        created="2026-01-31T12:00:00+00:00",
        command="roughline run steel-ball.toml rough-patch.toml --quick",
        effort="quick",
        seconds=93.0,
        machine={
            "system": "Linux 6.1",
            "processor": "AMD EPYC",
            "cores": 2,
            "memory": 8_000_000_000,
            "threads": 2,
        },
        versions={"roughline": "0.1.0", "numpy": "2.1.0", "scipy": "1.14.1"},
        scenes=(sphere_scene(folder, rng), rough_scene(folder, rng)),
    )
    save_study(record)
    return record
