"""The validity map: claims along their parameters, scenes as points."""

from dataclasses import replace

import numpy as np

from comparisons.scene.scene import load_scene
from reports.plots.claims import validity_map


def test_the_map_has_a_row_for_each_claim_and_a_point_for_each_scene(study):
    """A paraboloid has the exponent 2 on the row of the transform, which was measured to 6."""
    ball = replace(study.scenes[0], text=load_scene("paraboloid").text)
    figure = validity_map([ball])
    assert figure.y.ticks[0][1] == "force (transform-power-law)"
    place = (2.0 - 1.0) / (6.0 - 1.0)
    np.testing.assert_allclose(figure.series[-1].x, place, atol=1e-12)
    assert validity_map(()) is None


def test_damaged_scenes_and_such_with_files_are_left_out(study):
    """A folder may be a stranger's: no file that it names is opened for a map."""
    ball = study.scenes[0]
    for text in ("[indenter]\nshape = 'teapot'", "surface = {file = '/etc/passwd'}", "not TOML"):
        assert validity_map([replace(ball, text=text)]) is None
