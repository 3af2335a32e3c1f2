"""Tables and fields to take away, and the modulus of a measured curve."""

import pickle
from dataclasses import replace
from unittest.mock import Mock

import meshio
import numpy as np
import pandas as pd
import pytest

import roughline
from comparisons.errors import InputError
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.questions.study import solved_in_memory
from comparisons.results.measured import fit_modulus, modulus_fits, modulus_sentence
from comparisons.results.recording import record_scene
from comparisons.results.store import MEASURES, TO_TAKE, measures, write_fields
from comparisons.solving.planning import plan_all
from reports.plots.curves import measured

HERTZ = {
    "name": "ball",
    "half_space": {"effective_modulus": 1e9},
    "indenter": {"shape": "paraboloid", "radius": 1e-3},
    "loading": {"penetration": {"values": [1e-6, 4e-6]}},
}


def test_a_row_is_a_load_and_a_column_a_method_and_quantity_in_si_units(tmp_path):
    """F = (4/3) E* R^(1/2) d^(3/2), A = pi R d."""
    methods = ["reduced", "closed_form"]
    found = roughline.Study(HERTZ, tmp_path / "out", methods=methods).run()
    table = pd.read_csv(tmp_path / "out" / TO_TAKE)
    (comparison,) = found
    pd.testing.assert_frame_equal(table.drop(columns="scene"), comparison.curves())
    assert list(table)[:5] == [
        *("scene", "step", "penetration / m"),
        *("closed_form:force / N", "closed_form:contact_area / m2"),
    ]
    depth = table["penetration / m"].to_numpy()
    assert depth.tolist() == [1e-6, 4e-6]
    # Springs to a radius: 40, of second order; the closed form is exact to round-off.
    for method, tolerance in (("closed_form", 1e-12), ("reduced", 1e-4)):
        force, area = (table[f"{method}:{n}"] for n in ("force / N", "contact_area / m2"))
        np.testing.assert_allclose(force, 4 / 3 * 1e9 * 1e-3**0.5 * depth**1.5, rtol=tolerance)
        np.testing.assert_allclose(area, np.pi * 1e-3 * depth, rtol=tolerance)
    # What was derived does not keep a record from another process.
    again = pickle.loads(pickle.dumps(comparison.record))
    pd.testing.assert_frame_equal(again.rows.frame(), comparison.record.rows.frame())


@pytest.mark.parametrize(("steps", "listed"), [(None, ""), ((), "never"), ((0, 2), "0 2")])
def test_load_steps_outside_the_band_of_single_lines_are_counted_from_0(steps, listed):
    """As all steps in tables; reports count from 1."""
    record = roughline.compare("paraboloid", "closed_form", "reduced").record
    verdicts = tuple(replace(item, outside_band=steps) for item in record.verdicts)
    assert set(measures(replace(record, verdicts=verdicts))["outside_band"]) == {listed}


def test_prescribed_forces_are_written_as_prescribed(tmp_path):
    """Springs and the closed form return 500 N but for rounding."""
    scene = HERTZ | {"loading": {"force": {"values": [1.0, 7.0, 500.0]}}}
    roughline.Study(scene, tmp_path / "out", methods=["reduced", "closed_form"]).run()
    assert pd.read_csv(tmp_path / "out" / TO_TAKE)["force / N"].tolist() == [1.0, 7.0, 500.0]


def test_a_method_without_an_answer_has_its_reason_beside_its_verdict(tmp_path, monkeypatch):
    monkeypatch.setattr(ReducedProfile, "solve", Mock(side_effect=ValueError("no springs")))
    roughline.Study(HERTZ, tmp_path / "out", methods=["reduced", "closed_form"]).run()
    table = pd.read_csv(tmp_path / "out" / MEASURES, keep_default_na=False)
    (reason,) = set(table.loc[table["method"] == "reduced", "reason"])
    assert "no springs" in reason


COMPARABLE = {"quantities": ["force", "pressure"]}


def test_the_pressure_of_a_grid_is_a_surface_of_quads(rough, solved, tmp_path):
    patch = rough(points=[16, 12], size=["4 um", "3 um"], compare=COMPARABLE)
    fields = solved(patch, "bem_fft", 16).fields
    path = tmp_path / "out" / "contact.vtu"
    assert write_fields(path, fields)
    mesh = meshio.read(path)
    np.testing.assert_allclose(mesh.points[:, 0], fields["pressure_x"], rtol=1e-15)
    np.testing.assert_allclose(mesh.points[:, 1], fields["pressure_y"], rtol=1e-15)
    np.testing.assert_array_equal(mesh.points[:, 2], fields["heights"].ravel())
    np.testing.assert_array_equal(mesh.point_data["pressure"], fields["pressure"])
    (block,) = mesh.cells
    assert block.type == "quad"
    assert block.data.shape == (15 * 11, 4)
    # Every quad is one cell of the grid, walked round counter-clockwise.
    x, y = (mesh.points[block.data, axis] for axis in (0, 1))
    area = (x * np.roll(y, -1, axis=1) - y * np.roll(x, -1, axis=1)).sum(axis=1) / 2
    np.testing.assert_allclose(area, 0.25e-6**2, rtol=1e-12)
    assert [p.name for p in path.parent.iterdir()] == ["contact.vtu"]


def test_the_body_of_finite_elements_is_one_of_hexahedra(scene, solved, tmp_path):
    """Its displacement is deepest under the ball, by the penetration, and von Mises positive."""
    fields = solved(scene(compare=COMPARABLE), "fem", 2, with_body=True).fields
    path = tmp_path / "body.vtu"
    assert write_fields(path, fields)
    mesh = meshio.read(path)
    (block,) = mesh.cells
    assert block.type == "hexahedron"
    corners = mesh.points[block.data]
    edges = [corners[:, i] - corners[:, 0] for i in (1, 3, 4)]
    assert (np.einsum("ij,ij->i", np.cross(edges[0], edges[1]), edges[2]) > 0).all()
    displacement = mesh.point_data["displacement"]
    top = np.argmin(np.linalg.norm(mesh.points, axis=1))
    assert np.abs(displacement[top, 2]) == pytest.approx(float(fields["penetration"]), rel=1e-3)
    assert np.abs(displacement[:, 2]).max() <= float(fields["penetration"]) * (1 + 1e-6)
    assert (mesh.point_data["von_mises"] >= 0).all()
    assert mesh.point_data["von_mises"].max() > 0


@pytest.mark.parametrize("fields", [{}, {"line_x": np.zeros(3)}, {"penetration": np.array(1.0)}])
def test_what_has_no_mesh_is_not_written(tmp_path, fields):
    assert not write_fields(tmp_path / "none.vtu", fields)
    assert not list(tmp_path.iterdir())


MODULUS, RADIUS = 1e9, 1e-3


def hertz(depth, modulus=MODULUS):
    return 4 / 3 * modulus * np.sqrt(RADIUS) * np.maximum(depth, 0.0) ** 1.5


COMPUTED = (np.geomspace(5e-7, 1e-5, 8), hertz(np.geomspace(5e-7, 1e-5, 8)))


def test_the_interval_holds_the_modulus_of_noisy_hertz_as_often_as_it_says():
    """Of 100 fits 95 % contain it: 95 +- 2.2, of which five standard deviations are left."""
    depth, held = np.linspace(2e-7, 9e-6, 60), 0
    for seed in range(100):
        noise = np.random.default_rng(seed).normal(0, 0.01 * hertz(9e-6), len(depth))
        force = hertz(depth - 1e-7, 1.3 * MODULUS) + noise
        fit = fit_modulus((depth, force), COMPUTED, MODULUS, fit_zero=True)
        held += abs(fit.modulus - 1.3 * MODULUS) <= fit.half_width
    assert held >= 84


def test_a_fitted_zero_is_the_depth_at_first_touch():
    depth = np.linspace(0.0, 9e-6, 60)
    data = depth, hertz(depth - 4e-7, 2 * MODULUS)
    moved = fit_modulus(data, COMPUTED, MODULUS, fit_zero=True)
    assert moved.modulus == pytest.approx(2 * MODULUS, rel=1e-6)  # the power law is exact
    assert moved.zero == pytest.approx(4e-7, rel=1e-5)
    # a zero that is wrong and held makes the body softer than it is
    assert fit_modulus(data, COMPUTED, MODULUS).modulus < 1.95 * MODULUS


def test_points_beyond_the_computed_depths_are_no_evidence():
    depth = np.linspace(1e-6, 1e-4, 50)
    assert fit_modulus((depth, 0.0 * depth), COMPUTED, MODULUS).used == 5
    assert fit_modulus((depth + 1e-4, depth), COMPUTED, MODULUS) is None


def test_depths_count_from_the_fitted_first_touch():
    """A body that yields beyond the computed loads: moved by a fifth, none of it is fitted."""
    deepest = COMPUTED[0][-1]
    depth = np.linspace(1e-7, 1.4 * deepest, 141)
    force = np.minimum(hertz(depth), hertz(deepest))
    for shift in (-0.2 * deepest, 0.2 * deepest):
        fit = fit_modulus((depth + shift, force), COMPUTED, MODULUS, fit_zero=True)
        # Where the last of them is counted in or out hangs on the last digit.
        assert fit.used == pytest.approx(np.sum(depth <= deepest), abs=1)
        assert fit.modulus == pytest.approx(MODULUS, rel=1e-5)
        assert fit.zero == pytest.approx(shift, rel=1e-4)


SCENE = {
    "name": "indented",
    "half_space": {"effective_modulus": "1 GPa"},
    "indenter": {"shape": "paraboloid", "radius": "1 mm"},
    "loading": {"penetration": {"from": "0.5 um", "to": "10 um", "steps": 5, "spacing": "log"}},
    "compare": {"measured": "curve.csv", "methods": ["closed_form", "reduced"]},
}


def planned(tmp_path, monkeypatch, text, **tables):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "curve.csv").write_text(text, encoding="utf-8")
    return plan_all((SCENE | tables,), {}, "quick")


def test_a_scene_with_a_measured_curve_says_its_modulus(tmp_path, monkeypatch):
    """Decimal commas, semicolons, units in the heads, a third column: as instruments write."""
    depth = np.linspace(1e-6, 9e-6, 12)
    lines = ["t / s; penetration / nm; force / mN"]
    lines += [
        f"0; {d * 1e9:.6f}; {f * 1e3:.9f}" for d, f in zip(depth, hertz(depth, 1.2e9), strict=True)
    ]
    (plan,) = planned(tmp_path, monkeypatch, "\n".join(lines).replace(".", ","))
    record = record_scene(*solved_in_memory(plan, "quick"))
    fits = modulus_fits(record)
    assert set(fits) == {"reduced", "closed_form"}
    assert fits["reduced"].modulus == pytest.approx(1.2e9, rel=1e-6)
    assert "1.200 \N{PLUS-MINUS SIGN}" in modulus_sentence(record)
    figure = measured(record)
    assert [series.look.label for series in figure.series] == [
        *("measured", "closed form, fitted", "reduced model, fitted")
    ]


@pytest.mark.parametrize(
    ("text", "said"),
    [
        ("depth,load\n1,2\n", "expected one column penetration"),
        ("penetration / N,force / N\n1,2\n1,2\n1,2\n", "column penetration: "),
        ("penetration,force\n1,2\n", "expected 3 to 20000 points, got 1"),
        ("penetration,force\n1,2\n2,x\n3,4\n", "expected numbers below the first line"),
        ("penetration,force\n1,-2\n2,-2\n3,-4\n", "expected some positive (compressive) forces"),
        ("", "expected one column force"),
    ],
)
def test_a_file_that_is_no_curve_is_told(tmp_path, monkeypatch, text, said):
    with pytest.raises(InputError, match=r"compare\.measured: curve\.csv: ") as error:
        planned(tmp_path, monkeypatch, text)
    assert said in str(error.value)


def test_a_force_that_is_not_proportional_to_the_modulus_is_refused(tmp_path, monkeypatch):
    with pytest.raises(InputError, match=r"compare\.measured: expected an"):
        planned(tmp_path, monkeypatch, "", adhesion={"work": 0.1})


def test_a_force_that_falls_with_the_depth_has_no_modulus():
    depth = np.linspace(0.1, 0.9, 20) * COMPUTED[0][-1]
    assert fit_modulus((depth, depth[::-1] * 1e3), COMPUTED, MODULUS, fit_zero=True) is None
