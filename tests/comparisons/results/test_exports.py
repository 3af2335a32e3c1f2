"""Tables to take away, and fields for ParaView."""

import pickle
from unittest.mock import Mock

import meshio
import numpy as np
import pandas as pd
import pytest

import roughline
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.results.store import MEASURES, TO_TAKE, write_fields
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

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


def test_the_pressure_of_a_grid_is_a_surface_of_quads(rough, tmp_path):
    (plan,) = plan_scene(rough(points=[16, 12], size=["4 um", "3 um"], compare=COMPARABLE))
    fields = execute(task_of(plan, "bem_fft", 16)).fields
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


def test_the_body_of_finite_elements_is_one_of_hexahedra(scene, tmp_path):
    """Its displacement is deepest under the ball, by the penetration, and von Mises positive."""
    (plan,) = plan_scene(scene(compare=COMPARABLE | {"resolutions": [2]}))
    fields = execute(task_of(plan, "fem", 2, with_body=True)).fields
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
