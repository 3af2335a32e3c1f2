"""All methods end to end, from a scene to numbers: Hertz, each other, other units, any load."""

import json
import math
import warnings
from dataclasses import replace
from functools import cache
from typing import get_args

import numpy as np
import pytest

from comparisons.facts.quantities import quantity
from comparisons.geometry.prepare import prepare
from comparisons.methods import runner
from comparisons.methods.normal import grid as blocks
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.registry import SOLVERS, planned_solver, solver_for
from comparisons.questions.single import solve_scene
from comparisons.scene.fields import NUMBER, SceneTable, WithUnit, dimension_of
from comparisons.scene.loading import LoadRange
from comparisons.scene.scene import SceneError, builtin_names, load_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference.errors import ConvergenceError
from roughline.commands.app import run_command

# Coarse enough to be quick: these tests compare a method with itself.
LEVELS = {"closed_form": 1, "reduced": 20, "bem_dense": 6, "bem_fft": 6, "fem": 2}
EVERYTHING = ["force", "penetration", "contact_area", "contact_radius", "stiffness", "energy"]
# Bounds that theorems prove would take ten times as long as the solves.
SINGLE = {"compare.quantities": [*EVERYTHING, "pressure"], "compare.proved": False}


@cache
def usual(source, method, resolution=None):
    """Return a built-in scene solved with all quantities, once for all tests that look at it."""
    result = solve_scene(source, method, resolution, SINGLE)
    assert result.converged, result.reasons
    return result


def curves(source, method, resolution=None):
    return usual(source, method, resolution).columns()


@pytest.mark.parametrize(
    ("method", "tolerance"),
    [
        ("closed_form", 1e-9),
        ("reduced", 1e-3),
        ("bem_dense", 3e-3),
        ("bem_fft", 3e-3),
        ("fem", 1e-2),
    ],
)
def test_the_built_in_paraboloid_is_hertz_in_every_method(capsys, method, tolerance):
    """F = (4/3) E* R^(1/2) d^(3/2), A = pi R d, dF/dd = 2 E* a (Johnson 1985, 4.22-4.24).

    The tolerances are those that the project promises for the force at default settings, at every
    load. Area and stiffness on grids converge more slowly, with the cell at the contact's edge:
    3 % on some 16 cells per radius, and ten times the force's tolerance elsewhere.
    """
    assert run_command(["solve", "paraboloid", "--method", method, "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    depth = np.array(document["penetration"])
    np.testing.assert_allclose(depth[[0, -1]], [1e-6, 2e-5], rtol=1e-12)
    assert len(depth) == 7
    modulus, radius = 210e9 / (1 - 0.3**2), 0.01
    np.testing.assert_allclose(
        document["force"], 4 / 3 * modulus * np.sqrt(radius) * depth**1.5, rtol=tolerance
    )
    slower = 3e-2 if method.startswith("bem") else 10 * tolerance
    np.testing.assert_allclose(document["contact_area"], np.pi * radius * depth, rtol=slower)
    np.testing.assert_allclose(
        document["stiffness"], 2 * modulus * np.sqrt(radius * depth), rtol=slower
    )


@pytest.mark.parametrize(
    ("method", "tolerance"),
    [
        ("closed_form", 1e-12),
        ("reduced", 1e-9),
        ("bem_dense", 3e-2),
        ("bem_fft", 1e-2),
        ("fem", 5e-2),
    ],
)
def test_every_method_has_the_pressure_of_hertz(method, tolerance):
    """Where r < a, p = p0 sqrt(1 - r^2/a^2), p0 = 2 E* a/(pi R); L2 over the contact, in p0.

    Cells that the contact's edge cuts dominate on grids; nodal pressures of a FEM mesh with four
    elements along the radius are good to some per cent. Exact points elsewhere: round-off.
    """
    fields = usual("paraboloid", method).solution.fields
    modulus, radius, depth = 210e9 / 0.91, 0.01, 2e-5
    a = np.sqrt(radius * depth)
    r = np.hypot(fields["pressure_x"], fields["pressure_y"]) / a
    exact = 2 * modulus * a / (np.pi * radius) * np.sqrt(np.maximum(1 - r**2, 0))
    weight = fields["pressure_weight"]
    error = np.sum(weight * (fields["pressure"] - exact) ** 2) / np.sum(weight * exact**2)
    assert np.sqrt(error) < tolerance
    # Together they carry the force; the quadrature of nodes is that of the mesh.
    force = 4 / 3 * modulus * np.sqrt(radius) * depth**1.5
    assert np.sum(weight * fields["pressure"]) == pytest.approx(force, rel=max(tolerance, 1e-9))


@pytest.mark.parametrize("method", ["closed_form", "reduced", "bem_dense", "bem_fft", "fem"])
def test_under_force_control_the_penetration_comes_back(scene, curves, method):
    """Pressing by the force of a penetration gives that penetration: both controls are one law.

    To the residual of iterative solvers (1e-8 of the force, two thirds of it in d), and for FEM,
    whose mesh follows the contact, to a tenth of what it promises against Hertz.
    """
    forces = curves(scene(), method, LEVELS[method])["force"]
    back = curves(scene(loading={"force": forces.tolist()}), method, LEVELS[method])
    np.testing.assert_allclose(back["force"], forces, rtol=1e-12)
    # Force control sizes its grid by the reduced model's penetration, the same to 1e-3.
    tolerance = {"closed_form": 1e-12, "reduced": 1e-10}.get(method, 2e-3)
    np.testing.assert_allclose(back["penetration"], [1e-6, 2e-6, 4e-6], rtol=tolerance)


AXISYMMETRIC = ["paraboloid", "sphere", "cone", "power-law-3", "power-law-4"]
AXISYMMETRIC += ["cylinder", "rounded-punch"]


@pytest.mark.parametrize("source", AXISYMMETRIC)
def test_the_reduced_model_equals_the_closed_form_at_its_default(source):
    """The promise is 1e-3 in force; the reduced model keeps it in every quantity."""
    exact, result = curves(source, "closed_form"), curves(source, "reduced")
    for name in ("force", "contact_radius", "contact_area", "stiffness", "energy"):
        np.testing.assert_allclose(result[name], exact[name], rtol=1e-3, err_msg=name)


# Here all methods are tried by default, elsewhere only those without a grid. Two have no others.
WHOLE = {"paraboloid", "cone", "square-punch", "rough-patch", "impact-course", "pushed-ball"}
UNITS = 2.0**-20, 2.0**-24, 2.0**-8  # of kilogram, metre and second
OTHERS = {"measured-map", "impact-rubber", "plastic-ellipsoid"}  # a file, and half a minute each
SCENES = sorted({*builtin_names()} - OTHERS)
CLOSED = {"closed_form", "reduced", "persson", "persson_xu"}


def size_of(dimension):
    return np.prod(np.float_power(UNITS, dimension))


def dimension_in(field):
    """Return the dimension of what the validator of a field reads."""
    waiting = [*field.metadata, field.annotation]
    while waiting:
        part = waiting.pop()
        if isinstance(part, WithUnit):
            return part.dimension
        waiting += [*getattr(part, "__metadata__", ()), *get_args(part)]
    return NUMBER


def in_other_units(part, size=1.0):
    """Return the tables of a scene with every quantity times the size of its dimension."""
    if isinstance(part, SceneTable):
        fields = type(part).model_fields
        if isinstance(part, LoadRange):
            return {"values": in_other_units(part.values, size)} if not part.relative_to else part
        tables = {
            name: in_other_units(getattr(part, name), size_of(dimension_in(fields[name])))
            for name in part.model_fields_set - {"directory", "sweep"}
            if getattr(part, name) is not None
        }
        if tables.get("shape") == "power_law":  # f = c r^n
            tables["coefficient"] *= UNITS[1] ** (1 - part.exponent)
        return tables
    if isinstance(part, tuple):
        return [in_other_units(item, size) for item in part]
    return part * size if isinstance(part, float) else part


@pytest.mark.parametrize(
    ("source", "quick"),
    [(source, True) for source in SCENES]
    + [pytest.param(name, False, marks=pytest.mark.slow) for name in SCENES if name not in WHOLE],
)
def test_in_other_units_there_is_the_same_answer(source, quick):
    """By powers of two, so not one digit changes; layers, impacts, rubber round a little."""
    few = {"surface.points": 32, "surface.realisations": 2}
    scene = load_scene(source, few if load_scene(source).surface else {})
    (here, *_), (there, *_) = map(plan_scene, (scene, load_scene(in_other_units(scene))))
    exact = scene.half_space.uniform and not scene.dynamics and not scene.viscoelastic
    own_levels = scene.surface or scene.lubrication  # films need their cells
    compared = [
        planned
        for planned in here.methods
        if planned.supported and quick == (planned.method in CLOSED or source in WHOLE)
    ]
    assert compared
    for planned in compared:
        method = planned.method
        level = planned.resolutions[0] if own_levels else LEVELS.get(method, 1)
        tasks = (task_of(plan, method, level) for plan in (here, there))
        one, other = (
            execute(replace(task, quantities=(*task.quantities, "pressure")), 1) for task in tasks
        )
        for solution in (one, other):
            assert solution.answered.all(), (method, solution.reasons)
        for name in {"pressure"} & one.fields.keys():
            one.quantities[name], other.quantities[name] = one.fields[name], other.fields[name]
        for name, values in one.quantities.items():
            unit = size_of(dimension_of(quantity(name).unit or "%"))
            rtol = 0.0 if exact else 1e-9
            np.testing.assert_allclose(
                other.quantities[name] / unit, values, rtol, err_msg=f"{method}: {name}"
            )


@pytest.fixture
def solved_rough(curves, rough):
    def solve(method, **surface):
        asked = ["penetration", "penetration_mean_plane", "mean_gap", "contact_count"]
        asked += ["contact_length", "contact_area_raw", "stiffness", "contact_length_stiffness"]
        scene = rough(compare={"quantities": asked}, **surface)
        return prepare(scene)[0], curves(scene, method, 16)

    return solve


@pytest.mark.parametrize("theory", ["persson", "persson_xu"])
def test_a_theory_of_spreading_pressure_finds_the_load_of_a_mean_gap(theory):
    by_force = solve_scene("rough-theories", theory).columns()
    loading = {"mean_gap": sorted(by_force["mean_gap"].tolist())}
    by_gap = solve_scene("rough-theories", theory, None, {"loading": loading}).columns()
    np.testing.assert_allclose(by_gap["contact_area"][::-1], by_force["contact_area"], rtol=1e-9)


def test_penetration_of_a_periodic_surface_counts_from_the_mean_plane(solved_rough):
    """As the mean displacement is zero, d = max(h - <h>) - mean gap; 1e-7: the FFT's residual."""
    geometry, solution = solved_rough("bem_fft", periodic=True)
    peak = geometry.top(0) - geometry.heights(0, 16).mean()
    np.testing.assert_allclose(solution["penetration"] + solution["mean_gap"], peak, rtol=1e-7)
    np.testing.assert_allclose(solution["penetration_mean_plane"], -solution["mean_gap"], rtol=1e-6)


@pytest.mark.parametrize("method", ["bem_dense", "bem_fft", "fem"])
def test_penetration_from_the_mean_plane_differs_by_the_height_of_the_peak(solved_rough, method):
    geometry, solution = solved_rough(method)
    peak = geometry.top(0) - geometry.heights(0, 16).mean()
    difference = solution["penetration"] - solution["penetration_mean_plane"]
    np.testing.assert_allclose(difference, peak, rtol=1e-9)


def test_contacts_are_counted_and_their_lengths_are_those_of_equal_circles(rough, solved_rough):
    """One contact at a tiny load: l = sqrt(4 A/pi), n = 1; k/E* is the length by stiffness."""
    tiny = {"force": {"values": [1e-5], "relative_to": "E* A0 h'"}}
    _, solution = solved_rough("bem_fft", loading=tiny)
    assert solution["contact_count"].tolist() == [1]
    # Patches are of counted cells, the best estimate of the area is corrected for its perimeter.
    length = np.sqrt(4 * solution["contact_area_raw"] / np.pi)
    assert solution["contact_length"] == pytest.approx(length, rel=0.3)
    modulus = rough().effective_modulus
    np.testing.assert_allclose(
        solution["contact_length_stiffness"], solution["stiffness"] / modulus, rtol=1e-12
    )


@pytest.mark.parametrize("length", [1.0, 4.0])
def test_quantities_of_a_line_are_per_side_of_the_surface(rough, length):
    """A line of length L1 stands for a patch of that side: F = p L1^2, all quoted per L^2."""
    made = rough(realisations=3, methods={"reduced": {"line_length": length}})
    (plan,) = plan_scene(made)
    solution = execute(task_of(plan, "reduced", 64, (0, 1, 2)), 1)
    result = solution.quantities
    for force in result["force"]:
        np.testing.assert_allclose(force, plan.loads.values, rtol=1e-9)
    np.testing.assert_allclose(result["contact_length_stiffness"], result["contact_length"])
    line = solution.fields["line_height"]
    assert len(line) == 128 * length
    assert solution.fields["line_x"][1] == pytest.approx(1e-6 / 128)
    difference = result["penetration"][0] - result["penetration_mean_plane"][0]
    np.testing.assert_allclose(difference, line.max() - line.mean(), rtol=1e-12)
    # F = E* int (h - z)_+ dx over the line; the plain sum over points lacks the contacts' edges.
    overlap = np.maximum(line - line.max() + result["penetration"][0, -1], 0).sum()
    force = made.effective_modulus * overlap * solution.fields["line_x"][1] / length**2
    assert force == pytest.approx(plan.loads.values[-1], rel=0.05)


@pytest.mark.parametrize("body", ["half_space", "counter_body"])
@pytest.mark.parametrize(("poisson_ratio", "iterated"), [(0.499, True), (0.4991, False)])
def test_large_meshes_are_iterated_unless_nearly_incompressible(
    body, poisson_ratio, iterated, monkeypatch
):
    """Above nu = 0.499 steps come near their limit; the plan has the memory of what is chosen.

    Of two bodies the softer has its say.
    """
    soft = {"youngs_modulus": "1 kPa", "poisson_ratio": poisson_ratio}
    plan = plan_scene(load_scene("paraboloid", {body: soft}))[0]
    task = task_of(plan, "fem", 4)
    eliminated = planned_solver(task).memory(task)
    monkeypatch.setattr("comparisons.methods.fem.indenter.Fem.most_factorised", 0)
    assert (planned_solver(task).memory(task) != eliminated) == iterated


@pytest.mark.parametrize(
    ("changes", "told"),
    [
        ({"methods.fem.solver": "conjugate_gradients"}, "solved by conjugate gradients"),
        ({}, "nested dissection (above 300 000 unknowns solved by conjugate gradients)"),
        ({"half_space.poisson_ratio": 0.4999}, "nested dissection (nu above 0.499"),
    ],
)
def test_the_plan_names_the_solver_of_the_finite_elements(changes, told):
    (plan, *_) = plan_scene(load_scene("paraboloid", changes))
    assert told in solver_for("fem", plan.scene).model(plan.geometry)


def test_a_large_pressure_is_stored_in_blocks_that_carry_its_force(rough, solved, monkeypatch):
    """48 x 40 cells in blocks of 5, the last ones of 3 and 5; quantities are of all cells."""
    scene = rough(
        points=[48, 40],
        short_cutoff=2e-7,
        periodic=True,
        loading={"force": {"values": [0.1], "relative_to": "E* A0 h'"}},
        compare={"quantities": ["force", "contact_area", "pressure"]},
    )
    whole = solved(scene, "bem_fft", 48)
    monkeypatch.setattr(blocks, "MOST_POINTS", 48 * 40 - 1)
    monkeypatch.setattr(blocks, "SIDE", 10)
    stored = solved(scene, "bem_fft", 48)
    assert stored.quantities["contact_area"] == whole.quantities["contact_area"]
    small, large = stored.fields, whole.fields
    assert tuple(small["pressure_shape"]) == (10, 8)
    assert small["heights"].shape == small["contact"].shape == (10, 8)
    touching = small["contact"].ravel() @ small["pressure_weight"]
    assert touching == pytest.approx(stored.quantities["contact_area_raw"][0, -1])
    carried = small["pressure"] @ small["pressure_weight"]
    assert carried == pytest.approx(large["pressure"] @ large["pressure_weight"], rel=1e-12)
    assert small["pressure_x"].max() == pytest.approx(large["pressure_x"][-120:].mean())
    gap = large["gap"].reshape(48, 40)[:5, 5:10].mean()
    assert small["gap"][1] == pytest.approx(gap, rel=1e-9)


def test_a_field_of_a_screen_is_stored_as_it_is():
    values = np.arange(6.0).reshape(2, 3)
    assert blocks.block_means(values, blocks.blocks_of(values.shape)) is values


@pytest.mark.parametrize("control", ["penetration", "force"])
@pytest.mark.parametrize("method", ["closed_form", "reduced", "bem_fft", "fem"])
def test_an_absurd_load_costs_its_own_step_only(scene, solved, method, control):
    """The other two steps are those of a scene without it, and nothing is warned of.

    Under force the iterative solvers stop at a tolerance of 1e-8 or 1e-9.
    """
    resolution = {"closed_form": 1, "reduced": 20, "bem_fft": 16, "fem": 2}[method]
    loads = [1e-6, 2e-6] if control == "penetration" else [1.0, 2.0]
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        usual = solved(scene(loading={control: loads}), method, resolution)
        absurd = scene(loading={control: [*loads, 1e300]})
        solution = solved(absurd, method, resolution, lost=True)
    for name, values in usual.quantities.items():
        np.testing.assert_allclose(solution.quantities[name][0, :2], values[0], rtol=1e-7)
    assert solution.converged[0, :2].all()
    if (method, control) == ("bem_fft", "force"):
        # It forms no energy, and d = (9 F^2 / (16 R E*^2))^(1/3) = 4e196 m it can represent.
        exact = (3 * 1e300 / 4 / absurd.effective_modulus) ** (2 / 3) / 10e-3 ** (1 / 3)
        np.testing.assert_allclose(solution.quantities["penetration"][0, 2], exact, rtol=1e-3)
        return
    assert set(solution.reasons) == {(0, 2)}
    assert all(math.isnan(values[0, 2]) for values in solution.quantities.values())


def test_a_method_that_raises_at_deep_loads_keeps_the_others(scene, solved, monkeypatch):
    class Shallow(ReducedProfile):
        def solve(self, task):
            if task.loads.values[-1] > 5e-6:
                raise ValueError("too deep for me")
            return super().solve(task)

    monkeypatch.setitem(SOLVERS, "reduced", (Shallow,))
    deeper = scene(loading={"penetration": [1e-6, 2e-6, 3e-6, 4e-6, 5e-6, 6e-6]})
    solution = solved(deeper, "reduced", 10, lost=True)
    assert solution.converged.tolist() == [[True] * 5 + [False]]
    assert "too deep for me" in solution.reasons[0, 5]


def test_a_derived_quantity_that_raises_is_named_with_its_function(scene, solved, monkeypatch):
    """Solves say themselves why they have no answer; what is derived from one has no such words."""

    def derived(*_, **__):
        raise ConvergenceError("not reached")

    monkeypatch.setattr(runner, "derived", derived)
    (reason,) = set(solved(scene(), "reduced", 20, lost=True).reasons.values())
    assert "ConvergenceError: not reached (in derived)" in reason


def test_a_method_that_always_raises_is_not_asked_for_every_load(scene, solved, monkeypatch):
    """Halves of halves down to the smallest load: log2 of the number of loads, not their number."""
    calls = []

    class Broken(ReducedProfile):
        def solve(self, task):
            calls.append(len(task.loads.values))
            raise ValueError("broken")

    monkeypatch.setitem(SOLVERS, "reduced", (Broken,))
    loads = {"from": 1e-6, "to": 2e-6, "steps": 64}
    solution = solved(scene(loading={"penetration": loads}), "reduced", 10, lost=True)
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
