"""Pictures: drawn in another process, whose crash or silence leaves a note and nothing else."""

import sys
import time
from dataclasses import replace

import numpy as np
import pytest

from reports.pictures import pictures, shapes

JOBS = [{"kind": np.array("hill")}, {"kind": np.array("hill")}, {"kind": np.array("hill")}]


def program(code: str) -> list[str]:
    """Return a stand-in for the renderer; sys.argv[1:] are inputs and outputs in turn."""
    return [sys.executable, "-c", f"import os, sys\nfrom pathlib import Path\n{code}"]


def test_a_renderer_that_crashes_leaves_no_picture():
    assert pictures.render(JOBS, program("os.abort()")) == [b"", b"", b""]


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


def test_a_missing_program_is_no_error():
    assert pictures.render(JOBS[:1], ["/nonexistent/renderer"]) == [b""]


def test_without_a_renderer_a_note_stands_in_place(study, tmp_path, monkeypatch):
    monkeypatch.setattr(pictures, "render", lambda jobs: [b""] * len(jobs))
    for picture in pictures.draw(study.scenes, tmp_path):
        assert picture.png == b""
        assert "no working renderer" in picture.note


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


def test_mirrored_bricks_keep_a_positive_volume():
    """The first edge vectors of a VTK hexahedron span a positive volume, mirrored or not."""
    points = np.array(
        [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [1, 1, 1], [0, 1, 1]],
        dtype=float,
    )
    for side in range(3):
        image, cells = shapes.mirrored(points, np.arange(8)[None], side)
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
