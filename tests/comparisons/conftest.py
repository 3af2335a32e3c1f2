"""Scenes in one line, for tests that need one."""

from concurrent.futures import ProcessPoolExecutor
from dataclasses import replace
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import pytest

from comparisons.scene.scene import Scene, load_scene, make_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

STEEL = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
BALL = {"shape": "paraboloid", "radius": "10 mm"}
ROUGH = {
    "kind": "self_affine",
    "hurst": 0.8,
    "size": "1 um",
    "points": 16,
    "rms_slope": 0.1,
    "seed": 3,
}
FORCE = {"force": {"values": [0.01, 0.05], "relative_to": "E* A0 h'"}}


@pytest.fixture(scope="session")
def scene():
    """Return a maker of scenes: a steel half-space under a ball, and what is said otherwise."""

    def make(directory: Path = Path(), **tables) -> Scene:
        data = {"name": "test", "half_space": STEEL, "loading": {"penetration": [1e-6, 2e-6, 4e-6]}}
        if "surface" not in tables:
            data["indenter"] = BALL
        return make_scene(data | tables, "test.toml", directory)

    return make


@pytest.fixture(scope="session")
def rough(scene):
    def make(name="test", loading=None, compare=None, methods=None, **surface) -> Scene:
        tables = {"compare": compare} if compare else {}
        tables |= {"methods": methods} if methods else {}
        return scene(
            surface={k: v for k, v in (ROUGH | surface).items() if v is not None},
            name=name,
            loading=loading or FORCE,
            **tables,
        )

    return make


@pytest.fixture
def mapped(scene, tmp_path):
    """Return a maker of scenes over a map on disk, of 1 um x 1 um and taken as it is."""
    usual = {
        "kind": "map",
        "file": "map.npy",
        "height_unit": "m",
        "size": "1 um",
        "detrend": "none",
    }

    def make(heights, loading=None, tables=None, **surface) -> Scene:
        np.save(tmp_path / "map.npy", heights)
        surface = {k: v for k, v in (usual | surface).items() if v is not None}
        return scene(tmp_path, surface=surface, loading=loading or FORCE, **tables or {})

    return make


@pytest.fixture(scope="session")
def planned():
    """Return a function from a scene to what its first plan says of each method, by name."""

    def methods(scene, effort="quick"):
        (plan, *_) = plan_scene(scene, effort)
        return {method.method: method for method in plan.methods}

    return methods


@pytest.fixture(scope="session")
def run_apart():
    """Run a study in a process of its own, started afresh.

    Tests before may have compiled in this one, and a process that has compiled differs in the last
    digits from those that read the cache (docs/cluster.md).
    """

    def run(study):
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as pool:
            pool.submit(study.run).result()

    return run


@pytest.fixture(scope="session")
def solved():
    """Solve a scene with one method, for these quantities too; there is an answer at every load."""

    def solve(scene, method, resolution=1, *quantities, lost=False, **how):
        (plan, *_) = plan_scene(load_scene(scene))
        task = task_of(plan, method, resolution, **how)
        solution = execute(replace(task, quantities=(*task.quantities, *quantities)))
        assert lost or solution.answered.all(), solution.reasons
        return solution

    return solve


@pytest.fixture(scope="session")
def curves(solved):
    def solve(*asked, **how):
        return {name: values[0] for name, values in solved(*asked, **how).quantities.items()}

    return solve
