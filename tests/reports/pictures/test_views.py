"""Views that turn: closed surfaces of the cut body, to scale, light enough to embed."""

import base64

import numpy as np
import pytest

from reports.pictures import pictures, turning
from reports.pictures.shapes import Piece, deformed_piece, opened_surface

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
    points, triangles, stress = opened_surface(cube(n))
    edges = np.sort(np.vstack([triangles[:, [0, 1]], triangles[:, [1, 2]], triangles[:, [2, 0]]]))
    _, count = np.unique(edges, axis=0, return_counts=True)
    assert (count % 2 == 0).all()
    assert enclosed(points, triangles) == pytest.approx(3.0)
    np.testing.assert_allclose(stress, points[:, 2])


def test_mirror_images_are_sewn_together(study):
    """A quarter of a block, completed: without inner walls its volume is that of the box."""
    job = pictures.picture_job(study.scenes[0]).arrays
    flat = job | {"mesh_displacement": 0 * job["mesh_displacement"]}
    points, triangles, _ = opened_surface(deformed_piece(flat, clipped=True))
    assert np.abs(points).max() <= 1.0 + 1e-12
    assert enclosed(points, triangles) == pytest.approx(0.75 * 2 * 2 * 1, rel=1e-6)


def test_every_scene_of_the_study_has_a_view(study):
    body, rough = (turning.view(pictures.picture_job(scene).arrays) for scene in study.scenes)
    (trace,) = rough["data"]
    rows, columns = trace["grid"]
    assert len(unpacked(trace["x"])) == rows * columns
    assert len(unpacked(trace["intensity"])) == 2 * (rows - 1) * (columns - 1)
    assert trace["intensitymode"] == "cell"
    # Contacts, and nothing else, have the last shade.
    touching = pictures.picture_job(study.scenes[1]).arrays["touching"]
    assert (unpacked(trace["intensity"]) == 255).sum() == 2 * touching[:-1, :-1].sum()
    (mesh,) = body["data"]
    count = len(unpacked(mesh["x"]))
    assert all(unpacked(mesh[name]).max() < count for name in "ijk")
    for view in (body, rough):
        ratio = view["layout"]["scene"]["aspectratio"]
        assert 1 < max(ratio.values()) < 3


def test_views_need_no_renderer(study, tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "render", lambda jobs: [b""] * len(jobs))
    assert all(picture.view for picture in pictures.draw(study.scenes, tmp_path))
