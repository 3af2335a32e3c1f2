"""What a bounded mesh leaves out: measured by doubling its extent, and declared by the method."""

import numpy as np
import pytest

from comparisons.judging.truth import TRUNCATION, truths
from comparisons.methods.fem import indenter as adapter
from comparisons.scene.scene import load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference import fem
from reference.loads import Load


def hertz_force(elements, extent):
    body = fem.half_space_body(
        fem.RingMesh(1.0, elements=elements, edge=1.0, extent=extent), fem.Material(1.0, 0.3)
    )
    ((_, contact),) = fem.indent(
        body, lambda x, y: (x**2 + y**2) / 2, Load("penetration", np.array([1.0]))
    )
    return contact.force


def square_force(order, quarter, extent):
    nodes = np.linspace(0, 1, 6) if quarter else np.linspace(-1, 1, 9)
    lines = 1 - (1 - nodes) ** 2 if quarter else nodes
    how = {"symmetry": "quarter" if quarter else "none", "order": order}
    body = fem.half_space_body(
        fem.TensorMesh(lines, lines, extent=extent, **how), fem.Material(1.0, 0.3)
    )
    gap = np.where(np.abs(body.points).max(axis=1) <= 1 + 1e-9, 0.0, np.inf)
    (contact,) = fem.press(body, gap, Load("penetration", np.array([1.0])))
    return contact.force


@pytest.mark.parametrize("elements", [2, pytest.param(4, marks=pytest.mark.slow)])
def test_a_fitted_mesh_of_twice_the_extent_differs_by_less_than_declared(elements):
    change = hertz_force(elements, 2.5) / hertz_force(elements, 5.0) - 1
    assert abs(change) < adapter.TRUNCATION_SMOOTH / elements**3


@pytest.mark.slow
@pytest.mark.parametrize(
    ("order", "quarter", "declared"),
    [(2, True, adapter.TRUNCATION_SQUARE), (1, False, adapter.TRUNCATION_GRID)],
)
def test_a_straight_mesh_of_twice_the_extent_differs_by_less_than_declared(
    order, quarter, declared
):
    change = square_force(order, quarter, 3.0) / square_force(order, quarter, 6.0) - 1
    assert abs(change) < declared


def test_the_truncation_is_a_source_of_the_bar():
    """Finite elements only: the half-space solvers' kernels reach to infinity."""
    overrides = {"compare.methods": ["fem", "bem_fft"], "loading": {"penetration": [1e-6, 2e-6]}}
    (plan, *_) = plan_scene(load_scene("paraboloid", overrides))
    levels = (("fem", 2), ("bem_fft", 8))
    known = truths(
        {key: execute(task_of(plan, *key), repeats=1) for key in levels}, plan.loads.axis
    )
    parts = {part.method: part.sources["force"][TRUNCATION] for part in known}
    assert parts["fem"] == pytest.approx(adapter.TRUNCATION_SMOOTH / 2**3)
    assert not parts["bem_fft"].any()
