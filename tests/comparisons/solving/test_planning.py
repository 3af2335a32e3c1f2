"""Plans: what each method will do, in which resolutions, and the reason for what is left out."""

from functools import partial
from types import SimpleNamespace

import numpy as np
import psutil
import pytest

from comparisons import formatting as fmt
from comparisons.errors import InputError
from comparisons.formatting import with_unit
from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.methods.registry import concerned, planned_solver, solver_for
from comparisons.scene.scene import SceneError, load_scene
from comparisons.solving.map_scenes import PATCH_POINTS, prepared_otherwise, typical_window
from comparisons.solving.plan import QUICK_REALISATIONS, task_of
from comparisons.solving.planning import plan_all, plan_scene


def planned(scene, method, effort="quick"):
    (plan, *_) = plan_scene(scene, effort)
    return next(item for item in plan.methods if item.method == method)


@pytest.fixture
def map_scene(mapped):
    """Return a maker of scenes over a 40 x 32 map whose highest point is near a corner."""
    x, y = np.meshgrid(np.arange(40.0), np.arange(32.0), indexing="ij")
    heights = 1e-9 * (np.cos(x) + np.cos(0.7 * y))
    heights[37, 5] = 9e-9
    load = {"force": {"values": [0.1], "relative_to": "E* A0 h'"}}
    return partial(mapped, heights, loading=load, size=["40 nm", "32 nm"])


def test_every_method_is_planned_or_refused_with_a_reason(scene, rough):
    for item in (scene(), rough(), rough(periodic=True), rough(loading={"mean_gap": ["1 nm"]})):
        (plan, *_) = plan_scene(item)
        assert [m.method for m in plan.methods] == concerned(item)
        for method in plan.methods:
            assert bool(method.resolutions) == method.supported
            assert method.supported or len(method.reason) > 10
            assert not method.supported or len(method.modelled) > 10


def test_at_least_three_resolutions_by_default_coarse_to_fine(scene):
    for method in ("reduced", "bem_dense", "bem_fft", "fem"):
        levels = planned(scene(), method).resolutions
        assert len(levels) >= 3
        assert list(levels) == sorted(set(levels))
    assert planned(scene(), "closed_form").resolutions == (1,)


def test_a_stricter_tolerance_plans_finer_grids(scene):
    for method in ("reduced", "bem_fft", "fem"):
        finest = [
            planned(scene(compare={"tolerance": wanted}), method).resolutions[-1]
            for wanted in (1e-2, 1e-3, 1e-4, 1e-5)
        ]
        assert finest[0] < finest[1]
    assert finest == [4, 6, 8, 10]  # of elements, at every decade


def test_resolutions_of_the_scene_go_before_the_plan(scene, rough):
    own = scene(compare={"resolutions": [7, 3]})
    for method in ("reduced", "bem_dense", "bem_fft", "fem"):
        assert planned(own, method).resolutions == (3, 7)
    assert planned(own, "closed_form").resolutions == (1,)
    # Also where the plan would have only one.
    large = rough(points=[40, 16], compare={"resolutions": [20]})
    assert planned(large, "fem").resolutions == (20,)


def test_only_the_methods_asked_for_and_the_closed_form_as_their_truth(scene):
    asked = scene(compare={"methods": ["reduced", "fem"]})
    (plan,) = plan_scene(asked)
    assert [m.method for m in plan.methods if m.supported] == ["closed_form", "reduced", "fem"]
    assert planned(asked, "closed_form").modelled.endswith("not asked for: it is the reference")
    assert planned(asked, "bem_fft").reason == "not asked for"
    square = {"shape": "square_punch", "side": 1e-3}
    without = scene(indenter=square, compare={"methods": ["reduced"]})
    assert planned(without, "closed_form").reason == "not asked for"


def test_a_resolution_that_is_no_multiple_of_the_points_is_left_out_with_its_reason(rough):
    plan = planned(rough(compare={"resolutions": [8, 11, 32]}), "bem_fft")
    assert plan.resolutions == (8, 32)
    assert "11: neither a multiple nor a divisor of the surface's own 16 points" in plan.reason
    # Along y, 4 of 16 would need every fourth of 18 points.
    plan = planned(rough(points=[16, 18], compare={"resolutions": [4, 8]}), "bem_fft")
    assert plan.resolutions == (8,)


def test_what_needs_too_much_memory_is_left_out_before_any_is_taken(scene, rough, monkeypatch):
    """The same scene on a machine with 10 MB free; then one whose own arrays do not fit."""
    fine = scene(compare={"resolutions": [10, 1000]})
    assert 1000 in planned(fine, "bem_fft").resolutions
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(available=1e7))
    plan = planned(fine, "bem_fft")
    assert plan.resolutions == (10,)
    assert "1000: needs about" in plan.reason
    with pytest.raises(SceneError, match=r"surface.points: expected arrays that fit into 80%"):
        plan_scene(rough(points=4096))


def test_memory_is_that_of_a_whole_block_of_realisations(rough, monkeypatch):
    """7 lines of 2^17 points are held at once: one would fit where the block does not."""
    lines = rough(compare={"resolutions": [2**16]})
    task = task_of(plan_scene(lines)[0], "reduced", 2**16, tuple(range(7)))
    need = planned_solver(task).memory(task)
    monkeypatch.setattr(psutil, "virtual_memory", lambda: SimpleNamespace(available=need))
    plan = planned(lines, "reduced", "full")
    assert not plan.supported
    assert "needs about" in plan.reason


def test_a_fallback_that_would_not_fit_is_told(rough, monkeypatch):
    """Double precision takes between a third and two thirds more than what is planned with."""
    fine = rough(points=1024, compare={"resolutions": [1024]})
    task = task_of(plan_scene(fine)[0], "bem_fft", 1024, (0,))
    for room, told in ((1.3, True), (1.7, False)):
        available = room * planned_solver(task).memory(task) / 0.8
        monkeypatch.setattr(
            psutil, "virtual_memory", lambda free=available: SimpleNamespace(available=free)
        )
        plan = planned(fine, "bem_fft")
        assert plan.resolutions == (1024,)
        assert ("should single precision stall" in plan.modelled) == told


def test_more_rows_than_anyone_can_read_are_refused(rough):
    steps = {"from": 0.01, "to": 0.1, "steps": 30, "relative_to": "E* A0 h'"}
    with pytest.raises(SceneError, match="at most 20 million realisations times load steps"):
        plan_scene(rough(realisations=1_000_000, loading={"force": steps}))


def left_out(scene) -> dict[str, str]:
    return dict(plan_scene(scene)[0].left_out)


def test_what_is_not_asked_for_is_left_out_and_said(scene, rough):
    plain = left_out(scene())
    assert 'add "pressure" to compare.quantities' in plain["comparison of pressures"]
    assert "contact stiffness, in the half-space methods" in plain
    assert "the surface beyond the geometric overlap" in plain
    assert "three quarters of the finite-element mesh" in plain
    assert not {"memory of the material", "inertia"} & set(plain)  # never in question
    asked = left_out(scene(compare={"quantities": ["pressure", "stiffness"]}))
    assert "comparison of pressures" not in asked
    assert "contact stiffness, in the half-space methods" not in asked
    assert "the surface beyond the geometric overlap" not in left_out(rough())
    polygon = {"shape": "polygon_punch", "vertices": [[0, 0], [1e-3, 0], [0, 2e-3]]}
    assert "three quarters of the finite-element mesh" not in left_out(scene(indenter=polygon))


@pytest.mark.parametrize(
    ("speed", "nu", "told"),
    [
        (7, 0.3, "about 4.9"),
        (70e-3, 0.3, "about 0.31"),
        (500, 0.3, "a large part"),
        (7, -0.2, "it has no mass: right while"),  # Johnson's number is not given below zero
    ],
)
def test_waves_that_an_impact_leaves_out_are_told_by_what_they_would_take(scene, speed, nu, told):
    """A steel ball on steel; `wave_impact`, which keeps all orders, has 4.8 % and 0.31 %."""
    changes = {"dynamics.mass": "32.7 g", "dynamics.velocity": speed}
    changes["half_space.poisson_ratio"] = nu
    ball = load_scene("impact-ball", changes)
    (plan,) = plan_scene(ball)
    assert told in dict(plan.left_out)["waves in the half-space"]


def test_what_friction_leaves_out_depends_on_its_coupling_and_poissons_ratio(scene):
    def left_out(nu, coupling):
        sheared = scene(
            half_space={"youngs_modulus": 1e9, "poisson_ratio": nu},
            friction={"coefficient": 0.3, "coupling": coupling},
            loading={"force": 1.0, "tangential_force": [0.1]},
        )
        (plan,) = plan_scene(sheared)
        effects = dict(plan.left_out)
        return [key for key in effects if "tangential" in key], " ".join(effects.values())

    pressed, across = "tangential displacements due to pressure", "slip across the tangential load"
    model = ", in the reduced model"
    for (nu, coupling), expected in {
        (0.3, "full"): [pressed + model, across + model],
        (0.5, "full"): [across + model],
        (0.3, "none"): [pressed, across + model],
        (0.0, "none"): [pressed],
    }.items():
        effects, reasons = left_out(nu, coupling)
        assert effects == expected
        assert ("exact only at" in reasons) == (pressed + model in expected)


def test_means_at_equal_gap_are_said_to_be_that(rough):
    """The force at the mean gap of an ensemble hangs on its highest peaks: a third off on lines."""
    (plan, *_) = plan_scene(rough(loading={"mean_gap": ["1 nm", "5 nm"]}))
    assert any("at equal mean gap" in note for note in plan.notes)
    (plan, *_) = plan_scene(rough())
    assert not any("at equal mean gap" in note for note in plan.notes)


@pytest.mark.parametrize("method", ["closed_form", "reduced", "bem_dense", "bem_fft"])
def test_pressures_are_computed_only_if_asked_for(scene, solved, method):
    for quantities, present in ((["force"], False), (["force", "pressure"], True)):
        made = scene(compare={"quantities": quantities})
        assert ("pressure" in solved(made, method, 4).fields) == present


def test_notes_on_the_half_space_and_on_realisations(rough):
    sliding = load_scene("friction-rough")
    (quick, *_), (full, *_) = plan_scene(sliding), plan_scene(sliding, "full")
    assert quick.realisations == QUICK_REALISATIONS
    assert full.realisations == sliding.surface.realisations
    assert any("--full" in note for note in quick.notes)
    assert not any("--full" in note for note in full.notes)
    only_modulus = load_scene("rough-free")
    named = load_scene("rough-free", {"compare.methods": ["reduced", "fem"]})
    for told in (only_modulus, named):
        (plan, *_) = plan_scene(told)
        runs = any(part.method == "fem" and part.supported for part in plan.methods)
        assert any("fem takes nu = 0.3" in note for note in plan.notes) == runs


@pytest.mark.parametrize(("edge_radius", "told"), [("10 mm", False), ("2 um", True)])
def test_a_rounded_edge_narrower_than_four_cells_is_told(edge_radius, told):
    """At N = 64 cells are 16 um beside a flat of 1 mm; by sqrt(2 R d) 9 um touch, and 0.6 mm."""
    narrow = {"indenter.edge_radius": edge_radius}
    for changes in (narrow, narrow | {"compare.resolutions": [2304]}):  # what the note asks for
        (plan,) = plan_scene(load_scene("rounded-punch", changes))
        notes = [note for note in plan.notes if note.startswith("rounded edge: ")]
        assert bool(notes) == (told and changes is narrow)
        assert all("compare.resolutions" in note for note in notes)


def test_first_surfaces_are_whole_tasks_that_cover_them_once(rough):
    """Fifty at the surface's own points, fewer on finer grids; never more than the scene allows."""
    (plan, *_) = plan_scene(rough(realisations=1000))
    (grid,) = (method for method in plan.methods if method.method == "bem_fft")
    assert grid.numbers == (50, 25, 25)
    bodies = [task.with_body for task in plan.tasks_at("bem_fft", 16, with_body=True)]
    assert bodies == [True, False]  # of the first surface alone
    for resolution, number in zip(grid.resolutions, grid.numbers, strict=True):
        blocks = [task.realisations for task in plan.tasks_at("bem_fft", resolution)]
        assert [k for block in blocks for k in block] == list(range(number))
        assert {len(block) for block in blocks} == {25}
    (few, *_) = plan_scene(rough(realisations=30))
    tasks = few.tasks_at("bem_fft", grid.resolutions[0])
    assert [len(task.realisations) for task in tasks] == [25, 5]


def test_lines_are_as_many_as_one_task_holds_whatever_the_surfaces(rough, map_scene):
    for scene in (rough(realisations=1), rough(realisations=1000), map_scene(realisations=30)):
        (plan, *_) = plan_scene(scene)
        (lines,) = (method for method in plan.methods if method.method == "reduced")
        assert set(lines.numbers) == {1000}
    (task,) = plan.tasks_at("bem_fft", plan.geometry.points[0])
    assert task.realisations == (0,)


def test_keys_tell_different_tasks_apart_and_equal_ones_not(scene, rough):
    def key(made, method="bem_fft", resolution=8, realisations=(0,)):
        return task_of(plan_scene(made)[0], method, resolution, realisations).key

    same = key(scene())
    assert key(scene()) == same
    assert key(scene(title="another title", compare={"tolerance": 0.2})) == same
    others = [
        key(scene(), resolution=9),
        key(scene(), method="fem"),
        key(scene(name="other")),
        key(scene(loading={"penetration": [1e-6, 2e-6, np.nextafter(4e-6, 1)]})),
        key(scene(indenter={"shape": "paraboloid", "radius": 0.02})),
        key(scene(half_space={"effective_modulus": 1e9})),
        key(scene(methods={"bem_fft": {"tolerance": 1e-9}})),
        key(scene(compare={"quantities": ["force", "pressure"]})),
        key(rough()),
        key(rough(seed=4)),
        key(rough(), realisations=(0, 1)),
    ]
    assert len({same, *others}) == len(others) + 1
    # An option of another method does not touch this one.
    assert key(scene(methods={"fem": {"contact": "penalty"}})) == same


def test_a_changed_map_is_another_task(map_scene, tmp_path):
    """The scene's text and its absolute loads are the same; only a height differs."""
    made = map_scene(loading={"penetration": ["1 nm"]})
    before = [task.key for task in plan_scene(made)[0].tasks]
    heights = np.load(tmp_path / "map.npy")
    heights[3, 3] -= 1e-12
    np.save(tmp_path / "map.npy", heights)
    after = [task.key for task in plan_scene(made)[0].tasks]
    assert len(after) == len(before)
    assert not set(after) & set(before)


def test_length_and_points_of_a_line_are_what_the_options_say(rough, solved):
    """Points of the line, not per side; without them, two for each of the surface's points."""
    line = {"line_length": 3.0, "line_points": 900}
    made = rough(methods={"reduced": line})
    assert planned(made, "reduced").resolutions == (150,)
    assert solved(made, "reduced", 150).unknowns == 900
    assert solved(rough(methods={"reduced": {"line_length": 3.0}}), "reduced", 64).unknowns == 384


def test_a_nominal_pressure_is_a_force_on_the_apparent_area(rough, scene):
    """On a rough surface, a map and a flat face; a ball has no such area."""
    (plan, *_) = plan_scene(rough(loading={"pressure": ["1 MPa", "2 MPa"]}))
    area, stiff = plan.geometry.area, plan.scene.effective_modulus * plan.geometry.rms_slope
    np.testing.assert_allclose(plan.loads.values, [1e6 * area, 2e6 * area], rtol=1e-15)
    assert (plan.loads.control, plan.scene.loading.control) == ("force", "force")
    (said,) = (note for note in plan.notes if note.startswith("loads: "))
    assert "F/A0 = 1.00\u202fMPa to 2.00\u202fMPa" in said
    assert f"F/(E* A0 h') = {fmt.number(1e6 / stiff)} to {fmt.number(2e6 / stiff)}" in said
    punch = {"shape": "square_punch", "side": 1e-3}
    (plan,) = plan_scene(scene(indenter=punch, loading={"pressure": "3 MPa"}))
    np.testing.assert_allclose(plan.loads.values, [3.0], rtol=1e-15)
    with pytest.raises(SceneError, match=r"pressure: expected a \[surface\] or a flat face"):
        plan_scene(scene(loading={"pressure": "3 MPa"}))


def with_dense(map_scene, **options):
    """Plan a map with the dense solver, for which it is too large."""
    named = {"methods": ["reduced", "bem_dense", "bem_fft", "fem"]}
    return plan_scene(map_scene(tables={"compare": named}, **options))


def test_a_large_map_gets_a_typical_patch_away_from_its_rim(map_scene):
    """The outlier at (37, 5), close to a corner, attracts no patch."""
    whole, patch = with_dense(map_scene)
    x0, y0, nx, ny = patch.scene.surface.crop
    assert (nx, ny) == (PATCH_POINTS, PATCH_POINTS)
    assert PATCH_POINTS // 2 <= x0 <= 40 - nx - PATCH_POINTS // 2
    assert PATCH_POINTS // 2 <= y0 <= 32 - ny - PATCH_POINTS // 2
    assert patch.geometry.measured.max() < whole.geometry.measured[37, 5] / 4
    np.testing.assert_array_equal(
        patch.geometry.measured, whole.geometry.measured[x0 : x0 + nx, y0 : y0 + ny]
    )
    # Cells keep their size, and the relative load is relative to the patch.
    assert patch.geometry.size == pytest.approx((nx * 1e-9, ny * 1e-9))
    share = patch.loads.values / (
        patch.scene.effective_modulus * patch.geometry.area * patch.geometry.rms_slope
    )
    assert share == pytest.approx([0.1])


def test_half_of_the_patches_are_steeper_than_the_typical_one():
    """Roughness that grows from side to side: the window in the middle; units do not matter."""
    random = np.random.default_rng(2)
    heights = np.linspace(0, 1, 112)[:, None] * random.standard_normal((112, 40))
    x0, y0, nx, ny = typical_window(heights, (1.0, 2.0))
    assert x0 == 48
    assert typical_window(1e-9 * heights, (1e-6, 2e-6)) == (x0, y0, nx, ny)

    def steepness(i: int, j: int) -> float:
        part = heights[i : i + nx, j : j + ny]
        rises = (np.diff(part, axis=0) ** 2).mean(), (np.diff(part, axis=1) ** 2).mean() / 4
        return sum(rises)

    windows = [steepness(i, j) for i in range(8, 89, 8) for j in (8, 16)]
    assert steepness(x0, y0) == pytest.approx(sorted(windows)[(len(windows) - 1) // 2], rel=0.01)


def test_patches_that_are_equal_but_for_rounding_are_one_choice():
    """The rows of a wave repeat: noise of the last digits does not move the patch."""
    wave = np.cos(np.arange(64) * np.pi / 4)[:, None] + np.zeros(48)
    random = np.random.default_rng(4)
    places = {
        typical_window(wave * (1 + 1e-13 * random.standard_normal(wave.shape)), (1.0, 1.0))
        for _ in range(10)
    }
    assert len(places) == 1


def test_the_patch_is_named_repeatable_and_where_all_methods_meet(map_scene):
    whole, patch = with_dense(map_scene)
    assert patch.scene.name == "test-patch"
    assert any("test-patch" in note and "crop" in note for note in whole.notes)
    assert {m.method for m in patch.methods if m.supported} >= {"bem_dense", "bem_fft", "fem"}
    (again,) = plan_scene(patch.scene)
    assert [t.key for t in again.tasks] == [t.key for t in patch.tasks]


def test_a_patch_of_a_crop_is_cut_from_the_same_file(map_scene):
    """Within a crop that starts at (10, 2), indices of the patch still count from the file."""
    whole, patch = with_dense(map_scene, crop=[10, 2, 30, 28])
    x0, y0, nx, ny = patch.scene.surface.crop
    inside = whole.geometry.measured[x0 - 10 : x0 - 10 + nx, y0 - 2 : y0 - 2 + ny]
    np.testing.assert_array_equal(patch.geometry.measured, inside)


def test_an_absolute_force_is_shared_by_area(map_scene):
    _, patch = with_dense(map_scene, loading={"force": [1e-6, 2e-6]})
    share = PATCH_POINTS**2 / (40 * 32)
    np.testing.assert_allclose(patch.loads.values, [1e-6 * share, 2e-6 * share], rtol=1e-14)
    _, patch = with_dense(map_scene, loading={"penetration": ["1 nm"]})
    assert patch.loads.values.tolist() == [1e-9]


def test_no_patch_where_none_is_needed(map_scene):
    assert len(plan_scene(map_scene())) == 1
    assert len(with_dense(map_scene, crop=[0, 0, PATCH_POINTS, PATCH_POINTS])) == 1
    assert len(with_dense(map_scene, periodic=True)) == 1


def test_a_small_single_surface_is_solved_on_finer_grids(rough):
    """Its few spots are one sample; an ensemble's are many, and costly on fine grids."""
    fine, small = (64, 128, 256), (16, 32, 64, 128, 256)
    plans = (*plan_scene(load_scene("measured-map")), *plan_scene(rough(points=16)))
    for plan, expected in zip(plans, (fine, small), strict=True):
        (grid,) = (method for method in plan.methods if method.method == "bem_fft")
        assert grid.resolutions == expected
    ensemble = rough(points=16, realisations=3)
    assert planned(ensemble, "bem_fft").resolutions == (16, 32, 64)
    assert planned(ensemble, "fem").resolutions == (16, 32)
    assert planned(rough(points=256), "bem_fft").resolutions == (256, 512, 1024)
    assert planned(rough(points=256), "fem").resolutions == (256, 512)
    dented = load_scene("plastic-rough", {"surface.points": 256, "surface.realisations": 1})
    assert planned(dented, "bem_fft").resolutions == (256, 512)
    assert planned(rough(points=256, realisations=3), "bem_fft").resolutions == (256, 512)


@pytest.mark.parametrize(
    ("points", "grids"),
    [
        ((512, 512), (512, 1024, 2048)),
        ((768, 768), (768, 1536)),
        ((2048, 2048), (1024, 2048)),
        ((2049, 1500), (683, 2049)),
        ((2053, 2053), (2053,)),
    ],
)
def test_a_map_of_any_size_has_a_second_grid_for_its_bar(scene, points, grids):
    """Finer where that is affordable, else coarser; of a prime number of points there is none."""
    geometry = RoughGeometry((1.0, 1.0), points, periodic=False, rms_slope=0.1, rms_height=1.0)
    assert solver_for("bem_fft", scene()).resolutions(geometry) == grids


@pytest.fixture
def measured(mapped):
    heights = 1e-6 * np.random.default_rng(0).random((40, 36))

    def make(force=4.0, **surface):
        return mapped(heights, {"force": force}, size="1 mm", detrend=None, **surface)

    return make


def words_of(scenes):
    return [scene.sweep["preparation"] for scene in scenes]


CUTOFFS = [f"cut-off {with_unit(n * 1e-3 / 36, 'm')}" for n in (4, 8)]  # of the larger cells
QUARTERS = ["crop at 0, 0", "crop at 0, 18", "crop at 20, 0", "crop at 20, 18"]


def test_a_free_patch_is_solved_with_other_trends_and_cut_offs_and_by_quarters(measured):
    scenes = prepared_otherwise(measured())
    trends = ["as given", "detrend mean", "detrend curvature"]
    assert words_of(scenes) == trends + CUTOFFS + QUARTERS
    assert len({scene.name for scene in scenes}) == len(scenes)
    whole, quarter = (prepare(scene)[0] for scene in (scenes[0], scenes[-1]))
    # the same nominal pressure: a quarter of the area, a quarter of the force
    assert quarter.area / whole.area == pytest.approx(0.25)
    assert scenes[-1].loading.force.values == (1.0,)


def test_a_relative_load_is_that_of_the_map_as_given(measured):
    """A filter takes slopes away, and F/(E* A0 h') would be another force."""
    scenes = prepared_otherwise(measured({"value": 0.01, "relative_to": "E* A0 h'"}))
    forces = np.array([prepare(scene)[1].values[0] for scene in scenes])
    slopes = [prepare(scene)[0].rms_slope for scene in scenes]
    assert forces[:-4] == pytest.approx(forces[0])
    assert forces[-4:] == pytest.approx(forces[0] / 4)
    assert slopes[4] < slopes[3] < 0.6 * slopes[0]  # white noise lives in its shortest waves


def test_a_quarter_of_a_crop_lies_in_the_crop(measured):
    crops = [scene.surface.crop for scene in prepared_otherwise(measured(crop=[4, 2, 32, 32]))]
    assert crops[-4:] == [(4, 2, 16, 16), (4, 18, 16, 16), (20, 2, 16, 16), (20, 18, 16, 16)]


def test_a_periodic_map_has_no_quarters_and_no_plane(measured):
    assert words_of(prepared_otherwise(measured(periodic=True))) == ["as given", *CUTOFFS]


def test_what_is_no_map_is_told():
    with pytest.raises(InputError, match="paraboloid: --sensitivity"):
        plan_all(["paraboloid"], {}, "quick", sensitivity=True)


def test_a_plan_of_a_map_has_all_of_them(measured):
    plans = plan_all([measured()], {}, "quick", sensitivity=True)
    assert len(plans) == 9
