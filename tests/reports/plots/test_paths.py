"""Curves along a path say which way it is walked."""

from dataclasses import replace

from reports.plots import curves
from reports.plots.interactive import spec


def arrows(scene):
    """Return the traces of arrows of all curves of a scene."""
    traces = [trace for figure in curves.curves(scene) for trace in spec(figure)["data"]]
    return [trace for trace in traces if trace.get("marker", {}).get("symbol") == "arrow"]


def test_hysteresis_has_arrows_and_a_load_curve_has_none(study):
    """On a path there and back two branches look alike; arrows turn with the point before."""
    scene = study.scenes[0]
    assert arrows(scene) == []
    path = replace(scene, axis="step")
    drawn = arrows(path)
    assert len(drawn) == len(curves.curves(path))
    assert all(trace["marker"]["angleref"] == "previous" for trace in drawn)
    assert all(trace["showlegend"] is False for trace in drawn)
