"""Scenes with [friction], [rolling], [sliding], [wear], [lubrication]: methods meet, and refuse."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

import roughline
from comparisons.facts.quantities.rows import HALF_AXES
from comparisons.geometry.prepare import prepare
from comparisons.methods.registry import concerned
from comparisons.scene.scene import Scene, load_scene
from roughline.commands.app import run_command

RUBBER = {"youngs_modulus": "3 MPa", "poisson_ratio": 0.5}
STEEL = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}
PULL = {"force": "1 N", "tangential_force": ["0.2 N", "-0.2 N"], "substeps": 2}


def friction(scene, **tables) -> Scene:
    """Return a ball on rubber under a tangential path, but for what is given."""
    ball = {"half_space": RUBBER, "loading": PULL, "friction": {"coefficient": 0.3}}
    asked = {"quantities": ["tangential_displacement", "tangential_stiffness", "stiffness"]}
    return scene(**ball | {"compare": asked} | tables)


@pytest.mark.parametrize(
    ("kind", "half_space", "coupling"),
    [
        ("tangential_force", RUBBER, "full"),
        ("tangential_displacement", RUBBER, "full"),
        ("tangential_force", {"youngs_modulus": "3 MPa", "poisson_ratio": 0.3}, "none"),
    ],
)
def test_a_flat_circle_without_coupling_has_a_closed_form(
    solved, scene, kind, half_space, coupling
):
    """Linear up to mu F, and the same springs: rounding. Beyond mu F there is no force to hold."""
    unit = "N" if kind == "tangential_force" else "um"
    loading = {"force": "1 N", kind: [f"0.2 {unit}", f"-0.1 {unit}", f"90 {unit}"]}
    punch = friction(
        scene,
        indenter={"shape": "cylinder", "radius": "1 mm"},
        loading=loading,
        half_space=half_space,
        friction={"coefficient": 0.3, "coupling": coupling},
    )
    one, other = (solved(punch, *how) for how in (("reduced", 10), ("closed_form", 1)))
    held = 2 if kind == "tangential_force" else 3
    assert (
        one.converged[0].tolist()
        == other.converged[0].tolist()
        == [True] * held + [False] * (3 - held)
    )
    for name in ("tangential_force", "tangential_displacement", "stick_area"):
        u, v = (s.quantities[name][0, :held] for s in (one, other))
        assert u == pytest.approx(v, rel=1e-12), name
    assert held == 3 or "full sliding" in one.reasons[0, 2]


def test_nothing_slips_across_the_load_at_nu_zero_without_coupling(solved, scene):
    """Cerruti's cross term is nu x y/r^3: Mindlin & Deresiewicz's cycle is exact, as are springs.

    The half-space on 16 cells a radius has it within 0.1 % of the largest displacement.
    """
    ball = friction(
        scene,
        half_space={"youngs_modulus": "3 MPa", "poisson_ratio": 0},
        friction={"coefficient": 0.3, "coupling": "none"},
        loading={"force": "1 N", "tangential_force": ["0.2 N", "-0.25 N", "0.1 N", "0.31 N"]},
    )
    exact = solved(ball, "closed_form", 1)
    assert exact.converged[0].tolist() == [True] * 3 + [False]
    assert exact.no_equilibrium[0, 3]
    for name, resolution, bound in (("reduced", 20, 1e-12), ("bem_fft", 16, 1e-3)):
        u, v = (
            s.quantities["tangential_displacement"][0, :3]
            for s in (exact, solved(ball, name, resolution))
        )
        assert np.abs(u - v).max() < bound * np.abs(u).max(), name
    # 2 (1 - nu)/(2 - nu) = 1, (19.18)
    across, normal = (exact.quantities[n][0, 0] for n in ("tangential_stiffness", "stiffness"))
    assert across == pytest.approx(normal, rel=1e-12)


@pytest.mark.parametrize(
    ("name", "resolution", "body", "coupling"),
    [
        ("closed_form", 1, {"youngs_modulus": "3 MPa", "poisson_ratio": 0}, "none"),
        ("reduced", 8, RUBBER, "full"),
        ("bem_fft", 8, RUBBER, "full"),
        ("fem", 2, STEEL, "full"),
    ],
)
def test_what_slides_as_a_whole_has_no_equilibrium_from_there_on(
    solved, scene, name, resolution, body, coupling
):
    """At mu F itself nothing sticks, so that any displacement will do; F is known to round-off."""
    loading = {"force": "10 N", "tangential_force": ["2 N", "3 N", "1 N"]}
    law = {"coefficient": 0.3, "coupling": coupling}
    pushed = friction(scene, half_space=body, loading=loading, friction=law)
    solution = solved(pushed, name, resolution)
    assert solution.converged[0].tolist() == [True, False, False]
    assert solution.reasons[0, 2].startswith("no equilibrium: ")


def test_full_sliding_is_an_answer_of_solve_and_nothing_lost_of_a_run(tmp_path, scene, capsys):
    loading = {"force": "1 N", "tangential_force": ["0.2 N", "0.4 N"]}
    punch = {"shape": "cylinder", "radius": "1 mm"}
    slides = friction(scene, indenter=punch, loading=loading, compare={"tolerance": 0.01})
    file = tmp_path / "slides.toml"
    file.write_text(slides.text)
    for method in ("reduced", "closed_form"):
        assert run_command(["solve", str(file), "--method", method]) == 0
        assert "no equilibrium: the tangential force" in capsys.readouterr().err
    methods = ["reduced", "closed_form"]
    for _ in ("solved", "reread"):
        study = roughline.Study(file, tmp_path / "out", methods=methods, resume=True)
        (comparison,) = study.run()
        assert comparison.verdict == "within"
        assert study._study.lost() == []


def test_lines_stand_for_patches(solved, scene):
    """A line twice as long at the same pressure: forces per patch are the same kind of numbers."""
    surface = {
        "kind": "self_affine", "hurst": 0.8, "size": "1 mm", "points": 32, "rms_slope": 0.1,
        "realisations": 4, "long_cutoff": "0.5 mm",
    }  # fmt: skip
    loading = {"force": "8 mN", "tangential_force": ["1 mN", "2 mN"]}
    for length in (1.0, 2.0):
        rough = friction(
            scene, surface=surface, loading=loading,
            methods={"reduced": {"line_length": length}},
        )  # fmt: skip
        solution = solved(rough, "reduced", 32)
        assert solution.converged.all()
        assert solution.quantities["tangential_force"][0] == pytest.approx([1e-3, 2e-3], rel=1e-12)
        assert solution.quantities["force"][0] == pytest.approx(8e-3, rel=1e-12)


ROLLS = {"creep": [-0.002, 0.0, 0.001, 0.01]}


def rolling(scene, **tables) -> Scene:
    ball = {"half_space": RUBBER, "loading": {"force": "10 mN"}, "friction": {"coefficient": 0.3}}
    return scene(**ball | {"rolling": ROLLS} | tables)


@pytest.mark.parametrize(
    ("name", "resolution", "within"),
    [("fem", 8, 0.03), ("fastsim", 40, 0.08), ("reduced", 40, 0.55), ("kalker", 1, 0.7)],
)
def test_methods_stay_within_what_they_leave_out_of_the_half_space(
    solved, scene, name, resolution, within
):
    ball = rolling(scene)
    ours, truth = solved(ball, name, resolution), solved(ball, "bem_fft", 8)
    theirs = truth.quantities["traction"][0]
    assert_allclose(ours.quantities["traction"][0][:3], theirs[:3], rtol=within, atol=1e-12)
    assert theirs[1] == 0.0
    assert not {*HALF_AXES} & {*ours.quantities}  # those of an ellipsoid only


@pytest.mark.slow
def test_lateral_creep_drives_aside(solved, scene):
    aside = rolling(scene, rolling={"creep": 0.0, "lateral_creep": [-0.001, 0.001]})
    for name in ("reduced", "bem_fft", "fem", "fastsim", "kalker"):
        answer = solved(aside, name, {"kalker": 1}.get(name, 6), "lateral_force")
        force = answer.quantities["lateral_force"][0]
        assert_allclose(force[0], -force[1], rtol=1e-6)
        assert force[1] > 0
        assert_allclose(answer.quantities["tangential_force"][0], 0, atol=1e-6 * force[1])


def test_spin_drives_aside(solved, scene):
    spins = rolling(scene, rolling={"creep": 0.0, "spin": "0.02 m^-1"})
    forces = {
        name: solved(spins, name, resolution, "lateral_force").quantities["lateral_force"][0, 0]
        for name, resolution in {"bem_fft": 8, "fem": 6, "fastsim": 40, "kalker": 1}.items()
    }
    # six elements and eight cells per radius, of first order
    assert_allclose(list(forces.values()), forces["kalker"], rtol=0.13)
    assert forces["kalker"] > 0


def test_fields_tell_stick_from_slip_at_every_creep(solved, scene):
    ball = rolling(scene)
    fields = solved(ball, "bem_fft", 6, "pressure").fields
    assert np.nanmax(fields["friction_used"]) <= 1 + 1e-8
    assert np.nanmin(fields["friction_used"]) > 0.9  # the last creep: all slips
    still = fields["step.1.friction_used"]
    assert np.nanmax(still) == 0.0


def test_theories_of_rolling_are_no_part_of_other_plans(scene):
    pushed = scene(friction={"coefficient": 0.3}, loading={"force": 1.0, "tangential_force": 0.1})
    assert "fastsim" not in concerned(scene())
    assert "kalker" not in concerned(pushed)
    assert "kalker" in concerned(rolling(scene))
    assert "fastsim" in concerned(scene(compare={"methods": ["fastsim"]}))


SLIDING, ROUGH = "worn-ball", "worn-rough"


@pytest.mark.parametrize("changes", [{}, {"loading": {"penetration": "1 um"}}])
def test_grids_hold_the_worn_contact(curves, changes):
    """The estimate that sizes grids is above what springs find in the end."""
    scene = load_scene(SLIDING, changes)
    geometry, _ = prepare(scene)
    worn = curves(scene, "reduced", 10)
    assert worn["penetration"].max() <= geometry.penetration * (1 + 1e-9)
    assert worn["equivalent_radius"].max() < geometry.reach[0]


def test_rough_surface_runs_in(curves):
    """Area grows, the highest peaks go first, and cells lose what Archard says."""
    scene = load_scene(
        ROUGH, {"surface.points": 32, "surface.realisations": 1, "surface.short_cutoff": "0.25 um"}
    )
    cells, lines = curves(scene, "bem_fft", 32), curves(scene, "reduced", 32)
    for solved in (cells, lines):
        assert (np.diff(solved["contact_area"]) > 0).all()
        assert (np.diff(solved["wear_depth"]) > 0).all()
    distance = np.array([1e-3, 5e-3, 20e-3])
    np.testing.assert_allclose(cells["worn_volume"], 1e-14 * cells["force"] * distance, rtol=1e-9)


SOFT = {
    "name": "film",
    "half_space": {"effective_modulus": 1e6},
    "indenter": {"shape": "paraboloid", "radius": 0.01},
    "lubrication": {"viscosity": 1.0, "speed": [1e-3, 1e-2]},
    "loading": {"force": 0.2},
    "compare": {
        "quantities": ["film_central", "film_minimum", "lubrication_force", "friction_force"]
    },
}


@pytest.mark.slow
def test_the_line_sees_the_section_of_a_wavy_ball(curves):
    """Long waves are pressed flat: the middle changes by less than the crest."""
    films = {}
    for amplitude in (1e-12, 1e-6):
        waves = {"amplitude": amplitude, "wavelength": 1e-3}
        scene = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2, "waviness": waves}}
        films[amplitude] = [
            curves(scene, method, n)["film_central"][0]
            for method, n in (("bem_fft", 10), ("reduced", 32))
        ]
    smooth = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2}}
    for i, (method, n) in enumerate((("bem_fft", 10), ("reduced", 32))):
        assert films[1e-12][i] == pytest.approx(curves(smooth, method, n)["film_central"][0], 1e-6)
        assert 1e-9 < abs(films[1e-12][i] - films[1e-6][i]) < 1e-6


def test_line_and_half_space_carry_the_load(curves):
    """The force of the film is the load; the line's central film is within a third of the truth."""
    scene = SOFT | {"lubrication": {"viscosity": 1.0, "speed": 1e-2}}
    truth, line = (curves(scene, method, n) for method, n in (("bem_fft", 8), ("reduced", 64)))
    for film in (truth, line):
        assert film["lubrication_force"] == pytest.approx([0.2], rel=1e-8)
        assert 0 < film["film_minimum"][0] < film["film_central"][0]
    assert line["film_central"][0] == pytest.approx(truth["film_central"][0], rel=0.3)
    assert line["friction_force"][0] < truth["friction_force"][0]
