"""One figure, two renderers: plotly and matplotlib show the same numbers, names and limits."""

import numpy as np
import pytest

from reports.plots import curves, errors, speed
from reports.plots.interactive import spec


def printed(figure):
    """Return the axes on which matplotlib has drawn a figure."""
    pytest.importorskip("matplotlib", reason="the extra `paper` is not installed")
    from reports.paper.figures import single

    (axes,) = single(figure).axes
    return axes


@pytest.mark.parametrize("number", [0, 1])
@pytest.mark.parametrize("build", [curves.curves, errors.errors, speed.speed])
def test_print_and_page_show_the_same_points(study, number, build):
    """To the six digits that the page keeps; hollow markers without set-up are the page's only."""
    for figure in build(study.scenes[number])[:2]:
        lines = {line.get_label(): line for line in printed(figure).get_lines()}
        traces = [t for t in spec(figure)["data"] if t.get("name") and t.get("showlegend", True)]
        assert traces  # of a ratio to the reference there may be one
        for trace in traces:
            if all(y is None for y in trace["y"]):
                continue
            line = lines[trace["name"]]
            np.testing.assert_allclose(line.get_xdata(), np.array(trace["x"], float), rtol=1e-5)
            np.testing.assert_allclose(line.get_ydata(), np.array(trace["y"], float), rtol=1e-5)


def test_print_and_page_have_the_same_limits_and_ticks(study):
    (figure, *_) = errors.errors(study.scenes[0])
    axes, layout = printed(figure), spec(figure)["layout"]
    np.testing.assert_allclose(np.log10(axes.get_ylim()), layout["yaxis"]["range"], rtol=1e-9)
    assert [label.get_text() for label in axes.get_yticklabels()] == layout["yaxis"]["ticktext"]
    assert (
        layout["yaxis"]["title"]["text"] == "relative error |e|"
    )  # the heading names the quantity
    assert axes.get_ylabel() == "relative error of force"


def test_a_lost_solve_is_a_cross_in_print_too(study):
    figure = speed.speed(study.scenes[0])[0]
    (cross,) = [e for e in printed(figure).get_lines() if e.get_label() == "dense BEM: failed"]
    assert cross.get_marker() == "x"


def test_frames_hold_only_what_a_load_changes(study):
    from reports.plots.pressure import pressures

    (figure,) = pressures(study.scenes[0])
    assert figure.moves
    for frame in spec(figure)["frames"]:
        assert all(set(trace) <= {"x", "y"} for trace in frame["data"])
