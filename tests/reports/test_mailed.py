"""The page for mail: no script, small, the same words as the report."""

from dataclasses import replace

import pytest
from markupsafe import escape

import roughline
from reports.paper.files import write_mailed

pytestmark = pytest.mark.slow  # a second for each figure of a scene
MEGABYTE = 1_000_000


def test_the_page_for_mail_runs_nothing_and_is_small(study, tmp_path):
    page = write_mailed(study, tmp_path).read_text(encoding="utf-8")
    assert "<script" not in page
    assert "script-src &#39;none&#39;" in page
    for scene in study.scenes:
        assert escape(scene.title) in page
        assert f"Verdicts on {scene.name}" in page
    assert page.count("data:image/png") == len(study.scenes)
    assert len(page) < MEGABYTE


def test_many_scenes_share_the_room(study, tmp_path):
    """As many as the largest suite has."""
    scenes = tuple(
        replace(study.scenes[k % 2], name=f"{study.scenes[k % 2].name}-{k}") for k in range(30)
    )
    page = write_mailed(study.model_copy(update={"scenes": scenes}), tmp_path).read_text(
        encoding="utf-8"
    )
    assert len(page) < MEGABYTE


def test_a_sweep_has_its_figure(tmp_path):
    tables = {
        "name": "ball",
        "half_space": {"effective_modulus": "1 GPa"},
        "indenter": {"shape": "paraboloid", "radius": "1 mm"},
        "loading": {"force": ["1 N", "2 N"]},
        "sweep": {"methods.reduced.rule": ["mdr", "half_radius"]},
    }
    study = roughline.Study(tables, tmp_path, methods=["closed_form", "reduced"]).run()
    page = write_mailed(study.record, tmp_path).read_text(encoding="utf-8")
    assert page.count("data:image/png") == len(study.record.scenes) + 1
