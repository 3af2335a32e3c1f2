"""Loads over many decades, and absurd ones: each contact has its own grid, each loss its step."""

import math
import warnings

import numpy as np
import pytest

from comparisons.methods import runner
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.registry import SOLVERS
from comparisons.scene.scene import SceneError
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference.errors import ConvergenceError


@pytest.fixture
def solve(scene):
    """Return a solver of the ball on steel under other loads, or of another shape."""

    def run(method, resolution, loading, **indenter):
        tables = {"indenter": indenter} if indenter else {}
        made = scene(loading=loading, **tables)
        plan = plan_scene(made)[0]
        return plan, execute(task_of(plan, method, resolution))

    return run


@pytest.mark.parametrize("control", ["penetration", "force"])
@pytest.mark.parametrize("method", ["closed_form", "reduced", "bem_fft", "fem"])
def test_an_absurd_load_costs_its_own_step_only(solve, method, control):
    """The other two steps are those of a scene without it, and nothing is warned of.

    Under force the iterative solvers stop at a tolerance of 1e-8 or 1e-9.
    """
    resolution = {"closed_form": 1, "reduced": 20, "bem_fft": 16, "fem": 2}[method]
    loads = [1e-6, 2e-6] if control == "penetration" else [1.0, 2.0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        plan, usual = solve(method, resolution, {control: loads})
        _, solution = solve(method, resolution, {control: [*loads, 1e300]})
    for name, values in usual.quantities.items():
        np.testing.assert_allclose(solution.quantities[name][0, :2], values[0], rtol=1e-7)
    assert solution.converged[0, :2].all()
    if (method, control) == ("bem_fft", "force"):
        # It forms no energy, and d = (9 F^2 / (16 R E*^2))^(1/3) = 4e196 m it can represent.
        exact = (3 * 1e300 / 4 / plan.scene.effective_modulus) ** (2 / 3) / 10e-3 ** (1 / 3)
        np.testing.assert_allclose(solution.quantities["penetration"][0, 2], exact, rtol=1e-3)
        return
    assert set(solution.reasons) == {(0, 2)}
    assert all(math.isnan(values[0, 2]) for values in solution.quantities.values())


def test_a_method_that_raises_at_deep_loads_keeps_the_others(solve, monkeypatch):
    class Shallow(ReducedProfile):
        def solve(self, task):
            if task.loads.values[-1] > 5e-6:
                raise ValueError("too deep for me")
            return super().solve(task)

    monkeypatch.setitem(SOLVERS, "reduced", (Shallow,))
    _, solution = solve("reduced", 10, {"penetration": [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6]})
    assert solution.converged.tolist() == [[True] * 5 + [False]]
    assert "too deep for me" in solution.reasons[0, 5]


def test_a_derived_quantity_that_raises_is_named_with_its_function(solve, monkeypatch):
    """Solves say themselves why they have no answer; what is derived from one has no such words."""

    def derived(*_, **__):
        raise ConvergenceError("not reached")

    monkeypatch.setattr(runner, "derived", derived)
    _, solution = solve("reduced", 20, {"penetration": [1e-6]})
    (reason,) = solution.reasons.values()
    assert "ConvergenceError: not reached (in derived)" in reason


def test_a_method_that_always_raises_is_not_asked_for_every_load(solve, monkeypatch):
    """Halves of halves down to the smallest load: log2 of the number of loads, not their number."""
    calls = []

    class Broken(ReducedProfile):
        def solve(self, task):
            calls.append(len(task.loads.values))
            raise ValueError("broken")

    monkeypatch.setitem(SOLVERS, "reduced", (Broken,))
    loads = {"from": 1e-6, "to": 2e-6, "steps": 64}
    _, solution = solve("reduced", 10, {"penetration": loads})
    assert not solution.converged.any()
    assert calls == [64, 32, 16, 8, 4, 2, 1]


@pytest.mark.parametrize(("radius", "depth"), [(1e300, 1e296), (1e-300, 1e-303)])
def test_lengths_beyond_double_precision_are_refused_in_words(scene, radius, depth):
    """R d over- or underflows: no method is asked, and no NaN is shown."""
    with pytest.raises(SceneError, match="beyond the range of double precision"):
        plan_scene(
            scene(
                indenter={"shape": "paraboloid", "radius": radius}, loading={"penetration": [depth]}
            )
        )
