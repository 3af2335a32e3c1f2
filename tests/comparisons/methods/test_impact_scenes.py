"""An impact as a scene, from the file to the report: springs against the closed form."""

import json

import pytest

from comparisons.scene.scene import SceneError, load_scene
from comparisons.solving.planning import plan_scene

HIT = """name = "hit"
[half_space]
youngs_modulus = "210 GPa"
poisson_ratio = 0.3
[indenter]
shape = "{shape}"
{size}
[dynamics]
mass = "10 g"
velocity = {{ from = "1 cm/s", to = "1 m/s", steps = 5, spacing = "log" }}
"""


@pytest.fixture
def hit(tmp_path):
    """Return a maker of scene files with an impact."""

    def make(shape="paraboloid", size='radius = "10 mm"', more=""):
        path = tmp_path / "hit.toml"
        path.write_text(HIT.format(shape=shape, size=size) + more)
        return str(path)

    return make


def test_an_impact_whose_energy_underflows_is_refused(hit):
    """A femtometre per second of 1e-290 kg: the square of the speed alone is 1e-30."""
    scene = load_scene(hit(), {"dynamics.mass": 1e-290, "dynamics.velocity.from": 1e-20})
    with pytest.raises(SceneError, match="kinetic energy"):
        plan_scene(scene)


@pytest.mark.slow
def test_the_command_line_solves_runs_and_reports_it(hit, python, tmp_path):
    """Every command of the contract on one scene with physics, as a user types them."""

    def roughline(*words):
        done = python("-m", "roughline", *words)
        assert done.returncode == 0, done.stderr
        return done.stdout

    source, out = hit(), tmp_path / "out"
    document = json.loads(roughline("solve", source, "--method", "reduced", "--json"))
    assert len(document["restitution"]) == len(document["velocity"]) == 5
    assert "switched on: inertia" in roughline("run", source, "--plan")
    roughline("run", source, "--out", str(out))
    page = (out / "report.html").read_text(encoding="utf-8")
    assert "Duration of contact against velocity of impact" in page
    assert "velocity" in (out / "results.csv").read_text().splitlines()[0].split(",")
