"""Scenes with [wear]: what is refused in words, and that methods which share no code agree."""

import tomllib

import numpy as np
import pytest

from comparisons.geometry.prepare import prepare
from comparisons.scene.scene import SceneError, builtin_folder, load_scene, override
from comparisons.solving.execution import execute
from comparisons.tasks.task import Task

SLIDING, FRETTING, ROUGH = "worn-ball", "fretting-ball", "worn-rough"


def changed(name, changes):
    """Return a built-in scene with other keys, by dotted path; None takes a key away."""
    tables = tomllib.loads((builtin_folder() / f"{name}.toml").read_text())
    for path, value in changes.items():
        *folders, last = path.split(".")
        if value is None:
            inside = tables
            for folder in folders:
                inside = inside[folder]
            del inside[last]
        else:
            override(tables, path, value)
    return load_scene(tables)


def solved(scene, method, resolution):
    """Return the curves of a scene's first realisation."""
    geometry, loads = prepare(scene)
    task = Task(scene, geometry, loads, method, resolution, scene.compare.quantities)
    solution = execute(task)
    assert solution.converged.all(), solution.reasons
    return {name: values[0] for name, values in solution.quantities.items()}


@pytest.mark.parametrize(
    ("name", "changes", "words"),
    [
        (SLIDING, {"wear.coefficient": 0}, "expected a positive finite wear coefficient"),
        (SLIDING, {"wear.coefficient": "1 mm"}, "wear.coefficient"),
        (SLIDING, {"wear.amplitude": "1 um"}, "sliding_distance, or amplitude and cycles"),
        (SLIDING, {"wear.sliding_distance": [0.1, 0.05]}, "strictly increasing"),
        (SLIDING, {"friction": {"coefficient": 0.3}}, "all of the contact slips"),
        (SLIDING, {"loading.force": [1.0, 2.0]}, "expected one load with .wear."),
        (SLIDING, {"loading.force": {"from": 1.0, "to": 2.0, "steps": 3}}, "one load .* got 3"),
        (ROUGH, {"loading.force.values": [0.01, 0.02]}, "expected one load with .wear."),
        (SLIDING, {"plasticity": {"yield_stress": 1e9}}, "wear on a half-space that yields"),
        (FRETTING, {"friction.coupling": "full"}, 'friction.coupling: expected "none"'),
        (FRETTING, {"friction": None}, "wear.amplitude: expected .friction."),
        (FRETTING, {"wear.cycles": None}, "sliding_distance, or amplitude and cycles"),
        (FRETTING, {"loading.tangential_force": [1.0]}, "whose motion is in its own table"),
        (FRETTING, {"half_space": {"effective_modulus": 1e9}}, "E or G with nu"),
        ("cone", {"compare.quantities": ["worn_volume"]}, "expected .wear. in the scene"),
    ],
)
def test_what_makes_no_sense_is_refused(name, changes, words):
    with pytest.raises(SceneError, match=words):
        changed(name, changes)


@pytest.mark.parametrize("changes", [{}, {"loading": {"penetration": "1 um"}}])
def test_grids_hold_the_worn_contact(changes):
    """The estimate that sizes grids is above what springs find in the end."""
    scene = changed(SLIDING, changes)
    geometry, _ = prepare(scene)
    curves = solved(scene, "reduced", 10)
    assert curves["penetration"].max() <= geometry.penetration * (1 + 1e-9)
    assert curves["equivalent_radius"].max() < geometry.reach[0]


@pytest.mark.parametrize(
    ("name", "changes"),
    [(SLIDING, {"wear.sliding_distance": [0.01]}), (FRETTING, {"wear.cycles": [5e3]})],
)
def test_springs_agree_with_cells(name, changes):
    """Both are exact in the limit: 20 springs and 6 cells per radius leave 5 %."""
    scene = changed(name, changes)
    springs, cells = solved(scene, "reduced", 20), solved(scene, "bem_fft", 6)
    for quantity in ("penetration", "force", "worn_volume"):
        np.testing.assert_allclose(springs[quantity], cells[quantity], rtol=0.05)


def test_rough_surface_runs_in():
    """Area grows, the highest peaks go first, and cells lose what Archard says."""
    scene = changed(
        ROUGH, {"surface.points": 32, "surface.realisations": 1, "surface.short_cutoff": "0.25 um"}
    )
    cells, lines = solved(scene, "bem_fft", 32), solved(scene, "reduced", 32)
    for curves in (cells, lines):
        assert (np.diff(curves["contact_area"]) > 0).all()
        assert (np.diff(curves["wear_depth"]) > 0).all()
    distance = np.array([1e-3, 5e-3, 20e-3])
    np.testing.assert_allclose(cells["worn_volume"], 1e-14 * cells["force"] * distance, rtol=1e-9)
