"""Pictures from another process, whose crash leaves a note, and views that turn."""

import base64
import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from reports.pictures import pictures, rendering, turning
from reports.pictures.rendering import Piece, Shape, opened_surface

JOBS = [{"kind": np.array("hill")}, {"kind": np.array("hill")}, {"kind": np.array("hill")}]


def program(code: str) -> list[str]:
    """Return a stand-in for the renderer; sys.argv[1:] are inputs and outputs in turn."""
    return [sys.executable, "-c", f"import os, sys\nfrom pathlib import Path\n{code}"]


def test_a_renderer_that_crashes_or_is_missing_leaves_no_picture():
    assert pictures.render(JOBS, program("os.abort()")) == [b"", b"", b""]
    assert pictures.render(JOBS[:1], ["/nonexistent/renderer"]) == [b""]


def test_a_crash_costs_only_the_picture_at_work():
    code = (
        "for i, o in zip(sys.argv[1::2], sys.argv[2::2]):\n"
        "    if i.endswith('1.npz'): os.abort()\n"
        "    Path(o).write_bytes(b'png')"
    )
    assert pictures.render(JOBS, program(code)) == [b"png", b"", b"png"]


def test_a_renderer_that_hangs_is_ended(monkeypatch):
    monkeypatch.setattr(pictures, "STARTUP_SECONDS", 0.2)
    monkeypatch.setattr(pictures, "PICTURE_SECONDS", 0.1)
    began = time.monotonic()
    assert pictures.render(JOBS, program("import time; time.sleep(60)")) == [b"", b"", b""]
    assert time.monotonic() - began < 10


def test_a_picture_is_drawn_anew_only_where_its_data_changed(tmp_path, monkeypatch):
    """Pictures that are no longer shown go; a link, which could lead anywhere, is no picture."""
    drawn = []

    def render(jobs):
        drawn.append([float(job["x"]) for job in jobs])
        return [b"\x89PNG %f" % job["x"] for job in jobs]

    def images(*values):
        jobs = [{"x": np.array(x)} for x in values]
        return pictures.stored_or_rendered(jobs, tmp_path / "pictures")

    monkeypatch.setattr(pictures, "render", render)

    first = images(1.0, 2.0)
    assert images(1.0, 3.0)[0] == first[0]
    assert len(list((tmp_path / "pictures").iterdir())) == 2
    for path in list((tmp_path / "pictures").iterdir()):
        path.rename(tmp_path / path.name)
        path.symlink_to(tmp_path / path.name)
    assert images(1.0, 3.0)[0] == first[0]
    assert drawn == [[1.0, 2.0], [3.0], [1.0, 3.0]]


def test_without_a_renderer_a_note_and_a_view_stand_in_place(study, tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "render", lambda jobs: [b""] * len(jobs))
    for picture in pictures.draw(study.scenes, tmp_path):
        assert picture.png == b""
        assert "no working renderer" in picture.note
        assert picture.view  # needs none


def test_a_scene_without_fields_says_so(study, tmp_path):
    (picture,) = pictures.draw([replace(study.scenes[0], fields={})], tmp_path)
    assert picture.note.startswith("No picture")


def test_captions_name_method_load_and_exaggeration(study):
    body, rough = (pictures.picture_job(scene) for scene in study.scenes)
    assert "FEM, N = 16" in body.caption
    assert "exaggerated 9 times" in body.caption
    assert body.bar.label == "von Mises stress / GPa"
    assert "FFT BEM, N = 128" in rough.caption
    assert rough.bar.label == "height h / nm"


def test_a_hill_of_pressure_is_cut_off_at_sharp_edges_only_and_says_so():
    """Hertz's pressure amid an oil film of a thousandth of it keeps its summit."""
    x, y = np.meshgrid(*2 * [np.linspace(-4, 4, 81)], indexing="ij")

    def hill(pressure):
        fields = {"pressure_x": x, "pressure_y": y, "pressure": pressure}
        return pictures._hill_job("FFT BEM", {**fields, "pressure_shape": np.array(x.shape)})

    round_one = hill(np.sqrt(np.maximum(1 - x**2 - y**2, 1e-6)))
    assert round_one.bar.high == "1.00"
    assert "cut off" not in round_one.caption
    sharp = hill(np.where((x == 0) & (y == 0), 100.0, x**2 + y**2 < 1))
    assert sharp.bar.high == "4.00"
    assert np.nanmax(sharp.shape.shade) == 1.0
    assert "are cut off" in sharp.caption


def test_mirrored_bricks_keep_a_positive_volume():
    """The first edge vectors of a VTK hexahedron span a positive volume, mirrored or not."""
    points = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
        dtype=float,
    )
    for side in range(3):
        image, cells = rendering.mirrored(points, np.arange(8)[None], side)
        corner = image[cells[0]]
        edges = corner[[1, 3, 4]] - corner[0]
        assert np.linalg.det(edges) > 0


@pytest.mark.slow
def test_pictures_are_drawn_here(study, tmp_path):
    """A PNG with more than one colour; skipped where the machine has no renderer at all."""
    result = pictures.draw(study.scenes, tmp_path)
    if not any(picture.png for picture in result):
        pytest.skip("no renderer")
    for picture in result:
        assert picture.png.startswith(b"\x89PNG")
        assert 5_000 < len(picture.png) < 600_000


@pytest.mark.slow
def test_the_renderer_uses_nothing_that_pyvista_gives_up(study):
    jobs = [Shape(np.eye(3), np.ones(3), "viridis", 0.0, 1.0, ball=0.1).arrays]
    jobs += [pictures.picture_job(scene).shape.arrays for scene in study.scenes]
    plain = [sys.executable, "-m", "reports.pictures.rendering"]
    if not any(pictures.render(jobs, plain)):
        pytest.skip("no renderer")
    given_up = "from pyvista.core.errors import PyVistaDeprecationWarning as W"
    strict = f"import runpy, warnings; {given_up}; warnings.simplefilter('error', W); "
    strict += "runpy.run_module('reports.pictures.rendering', run_name='__main__')"
    assert all(pictures.render(jobs, [sys.executable, "-c", strict]))


DTYPES = {"f4": "<f4", "u1": "u1", "u2": "<u2", "u4": "<u4"}


def unpacked(packed):
    return np.frombuffer(base64.b64decode(packed["bdata"]), DTYPES[packed["dtype"]])


def cube(n: int) -> Piece:
    """Return a block [-1, 1]² x [-1, 0] of n x n x n bricks (n even)."""
    side, depth = np.linspace(-1, 1, n + 1), np.linspace(-1, 0, n + 1)
    x, y, z = np.meshgrid(side, side, depth, indexing="ij")
    number = np.arange(x.size).reshape(x.shape)
    corners = [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]
    corners += [(i, j, 1) for i, j, _ in corners]
    cells = np.stack([number[i : n + i, j : n + j, k : n + k].ravel() for i, j, k in corners], 1)
    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    return Piece(points, cells, points[:, 2], np.zeros(len(points)))


def enclosed(points: np.ndarray, triangles: np.ndarray) -> float:
    """Volume inside a closed surface, by the divergence theorem."""
    a, b, c = (points[triangles[:, k]] for k in range(3))
    return float(np.einsum("ij,ij->i", a, np.cross(b, c)).sum() / 6)


@pytest.mark.parametrize("n", [2, 4])
def test_the_cut_block_is_closed_and_three_quarters_of_it(n):
    """Every edge belongs to two triangles, and 3/4 of 2 x 2 x 1 is enclosed: 3."""
    surface = opened_surface(cube(n))
    points, triangles = surface.points, surface.cells
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]))
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert (count % 2 == 0).all()
    assert enclosed(points, triangles) == pytest.approx(3.0)
    np.testing.assert_allclose(surface.stress, points[:, 2])


def test_mirror_images_are_sewn_together(study):
    """A quarter of a block, completed: without inner walls its volume is that of the box."""
    fields = study.scenes[0].load_fields("fem", 16)
    fields["mesh_displacement"] *= 0
    flat = pictures._body_job("FEM", fields).shape
    assert np.abs(flat.points).max() <= 1.0 + 1e-12
    assert enclosed(flat.points, flat.triangles) == pytest.approx(0.75 * 2 * 2 * 1, rel=1e-6)


def test_every_scene_of_the_study_has_a_view(study):
    body, rough = (turning.view(pictures.picture_job(scene).shape) for scene in study.scenes)
    (trace,) = rough["data"]
    rows, columns = trace["grid"]
    assert len(unpacked(trace["x"])) == rows * columns
    assert len(unpacked(trace["intensity"])) == 2 * (rows - 1) * (columns - 1)
    assert trace["intensitymode"] == "cell"
    # Contacts, and nothing else, have the last shade.
    touching = np.isnan(pictures.picture_job(study.scenes[1]).shape.shade).reshape(rows, columns)
    assert (unpacked(trace["intensity"]) == 255).sum() == 2 * touching[:-1, :-1].sum()
    (mesh,) = body["data"]
    count = len(unpacked(mesh["x"]))
    assert all(unpacked(mesh[name]).max() < count for name in "ijk")
    for view in (body, rough):
        ratio = view["layout"]["scene"]["aspectratio"]
        assert 1 < max(ratio.values()) < 3


def test_arrays_that_make_no_shape_are_passed_over(study, monkeypatch):
    """Those of a user's method, say: the next method's are drawn."""
    scene = study.scenes[1]
    whole = list(pictures.stored_fields(scene))
    broken = [replace(item, fields=item.fields | {"size": np.ones(3)}) for item in whole]
    drawn = pictures.picture_job(scene)
    monkeypatch.setattr(pictures, "stored_fields", lambda *_: [*broken, *whole])
    assert pictures.picture_job(scene).caption == drawn.caption
