"""Tamaas and ContactMechanics on our problems: independent codes as oracles of the FFT solver.

What is measured of their answers is tested without them; the rest is skipped where they, or the
measured map, are absent.
"""

from pathlib import Path

import numpy as np
import pytest

from comparisons.isolation import parent
from comparisons.isolation.parent import Limits
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal
from comparisons.peers import client
from comparisons.peers.client import Problem
from comparisons.questions.study import Study
from comparisons.scene.scene import load_scene
from comparisons.solving.planning import plan_scene
from reference import surfaces
from reference.contact import press as unilateral
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.loads import Load

PEERS = tuple(client.PACKAGES)
MAP = Path(__file__).resolve().parents[5] / "shared" / "data" / "di-6.di"
WANTED = 1e-8
MODULUS = 3e9


def peer_or_skip(peer: str) -> str:
    if not client.installed(peer):
        pytest.skip(f"{peer} is not installed: pip install 'roughline[peers]'")
    return peer


def rough_problem(periodic: bool, control: str, points=(48, 40)) -> Problem:
    """Two rough surfaces of 1 um on rectangular cells; about 5 and 15 % of them in contact."""
    size = (1e-6, 0.7e-6)
    spacing = (size[0] / points[0], size[1] / points[1])
    kind = PeriodicOperator if periodic else FreeOperator
    gaps = []
    for k in range(2):
        heights = surfaces.self_affine(
            points,
            size,
            surfaces.SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=size[0] / 6),
            seed=3,
            realisation=k,
        )
        gaps.append(heights.max() - heights)
    operator = kind(points, spacing, MODULUS)
    mean = float(min(gap.mean() for gap in gaps))
    forces = MODULUS * size[0] * size[1] * 0.1 * np.array([0.02, 0.06])
    loads = {
        "force": forces,
        "penetration": mean * np.array([0.4, 0.7]),
        "mean_gap": mean * np.array([0.3, 0.6]),
    }
    return Problem(operator, np.array(gaps), control, loads[control])


CASES = [(periodic, control) for periodic in (True, False) for control in ("force", "penetration")]
CASES.append((True, "mean_gap"))


@pytest.mark.parametrize("peer", PEERS)
@pytest.mark.parametrize(("periodic", "control"), CASES)
def test_pressures_of_two_codes_agree_to_their_violation(peer, periodic, control):
    """Pressures are gaps times stiffnesses up to E*/dx: 1e-8 of the penetration is some 1e-7."""
    problem = rough_problem(periodic, control)
    result = client.press(peer_or_skip(peer), problem, WANTED, repeats=1, limits=Limits(120, 4e9))
    assert not result.reasons
    assert result.worst <= WANTED
    for (row, step), contact in result.contacts.items():
        gap, load = problem.gaps[row], Load(control, problem.loads[step])
        ours = unilateral.press(problem.operator, gap, load, tolerance=WANTED)
        difference = np.linalg.norm(contact.pressure - ours.pressure)
        assert difference < 30 * WANTED * np.linalg.norm(ours.pressure)
        # The load that is prescribed, and the one that follows from it.
        assert contact.force == pytest.approx(ours.force, rel=10 * WANTED)
        assert contact.penetration == pytest.approx(ours.penetration, rel=10 * WANTED)
    assert result.seconds
    assert 0 <= result.setup_seconds <= result.seconds[0]
    assert result.compile_seconds > 0


@pytest.mark.parametrize("peer", PEERS)
def test_a_peer_keeps_off_cells_without_material(peer):
    """A paraboloid that ends at r = 0.3, pressed until its edge bites: infinite gaps around it."""
    x = (np.arange(40) - 19.5) / 40
    r = np.hypot(x[:, None], x)
    gap = np.where(r < 0.3, r**2 / 2, np.inf)
    operator = FreeOperator(gap.shape, (1 / 40, 1 / 40), 1.0)
    problem = Problem(operator, gap[None], "force", np.array([0.02, 0.1]))
    result = client.press(peer_or_skip(peer), problem, WANTED, repeats=1, limits=Limits(120, 4e9))
    assert not result.reasons
    ours = unilateral.press(operator, gap, Load("force", 0.1), tolerance=WANTED)
    pressure = result.contacts[0, 1].pressure
    assert np.linalg.norm(pressure - ours.pressure) < 30 * WANTED * np.linalg.norm(ours.pressure)


@pytest.mark.parametrize("peer", PEERS)
def test_loosening_finds_equal_work(peer):
    """A benchmark compares equal violations: not above the wanted one, and not far below."""
    problem = rough_problem(True, "force")
    result = client.press(
        peer_or_skip(peer), problem, 1e-6, repeats=1, limits=Limits(120, 4e9), loosen=True
    )
    assert not result.reasons
    assert 1e-8 < result.worst <= 1e-6


@pytest.mark.parametrize("peer", PEERS)
def test_a_time_limit_is_a_reason_for_every_step(peer):
    problem = rough_problem(False, "force")
    result = client.press(peer_or_skip(peer), problem, WANTED, limits=Limits(0.05, 4e9))
    assert set(result.reasons) == set(np.ndindex(2, 2))
    assert set(result.reasons.values()) == {"hung: no answer within 0.05 s"}


@pytest.mark.parametrize("peer", PEERS)
def test_the_study_shows_that_the_pressure_fields_agree_on_the_measured_map(peer, tmp_path):
    """di-6, 256 x 256 points, periodic: the row of the report that compares on the same grid."""
    peer_or_skip(peer)
    pytest.importorskip("SurfaceTopography")
    if not MAP.exists():
        pytest.skip(f"{MAP} is not here")
    scene = tmp_path / "scene.toml"
    scene.write_text(
        'name = "di-6"\n[half_space]\nyoungs_modulus = "70 GPa"\npoisson_ratio = 0.3\n'
        f'[surface]\nkind = "map"\nfile = "{MAP}"\ncrop = [128, 128, 256, 256]\nperiodic = true\n'
        '[loading]\nforce = { values = [0.02, 0.1], relative_to = "E* A0 h\'" }\n'
        f'[compare]\nquantities = ["force", "pressure"]\nmethods = ["bem_fft", "{peer}"]\n'
        "resolutions = [256]\n"
    )
    record = Study(plan_scene(load_scene(str(scene))), tmp_path / "out").run()
    same = (peer, "pressure_same_grid")
    (own,) = [v for v in record.scenes[0].verdicts if (v.method, v.quantity) == same]
    assert own.error < 30 * WANTED
    assert record.scenes[0].disagreements == ()


def test_what_is_not_installed_says_how_to_install_it(monkeypatch):
    monkeypatch.setattr(client.util, "find_spec", lambda name: None)
    for peer in PEERS:
        refused = solver_for(peer, load_scene("paraboloid"))
        assert refused == Refusal("not installed: pip install 'roughline[peers]'", missing=True)


def test_what_a_peer_cannot_do_has_its_reason(monkeypatch):
    """Also where it is not installed: installing it would not help."""
    monkeypatch.setattr(client, "installed", lambda peer: False)
    load = {"loading": {"mean_gap": [1e-9]}}
    for peer in PEERS:
        assert "sharp edges" in solver_for(peer, load_scene("cylinder")).reason
        assert "mean-gap" in solver_for(peer, load_scene("rough-free", load)).reason


def answering(monkeypatch, change):
    """Let a peer answer with our own solution, changed, and look what the check says."""

    def run(work, stated, peer, **limits):
        assert limits["seconds"] == 9
        problem = rough_problem(True, "force")
        step = [
            [
                unilateral.press(problem.operator, g, Load("force", f)).pressure
                for f in problem.loads
            ]
            for g in problem.gaps
        ]
        # As the process sees it: E* = 1, lengths in units of powers of two.
        operator = PeriodicOperator(stated["gaps"].shape[1:], stated["spacing"], 1.0)
        scale = stated["loads"][0] / (step[0][0].sum() * operator.cell_area)
        pressure = change(scale * np.array(step))
        count = np.ones(pressure.shape[:2], dtype=int)
        answer = {"pressure": pressure, "iterations": count, "reasons": []}
        times = {
            "seconds": [1.0],
            "processor_seconds": [1.0],
            "setup_seconds": 0.0,
            "compile_seconds": 0.0,
            "memory": 1.0,
        }
        return parent.Outcome("answered", answer | times)

    monkeypatch.setattr(parent, "run", run)
    return client.press("tamaas", rough_problem(True, "force"), 1e-7, limits=Limits(9, 4e9))


def test_a_right_answer_passes_the_check(monkeypatch):
    result = answering(monkeypatch, lambda p: p)
    assert not result.reasons
    assert result.worst <= 1e-7


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda p: p * (1 + 1e-5), "by 1.0e-05, more than 1.0e-07"),  # misses the force
        (lambda p: np.where(p > 0, p, -1e-3 * p.max()), "violates"),  # tension
        (lambda p: np.roll(p, 1, axis=2), "violates"),  # one cell beside
        (lambda p: np.zeros_like(p), "no cell carries pressure"),
    ],
)
def test_a_wrong_answer_does_not(monkeypatch, change, words):
    result = answering(monkeypatch, change)
    assert set(result.reasons) == set(np.ndindex(2, 2))
    assert not result.contacts
    assert all(words in reason for reason in result.reasons.values()), result.reasons


def test_the_problem_a_peer_sees_has_no_units():
    """Powers of two of the lengths and of E* change no digit of it."""
    first = rough_problem(False, "force")
    spacing = tuple(2.0**-20 * step for step in first.operator.spacing)
    operator = FreeOperator(first.operator.shape, spacing, 2.0**30 * MODULUS)
    loads = first.loads * 2.0 ** (30 - 20 + 5)
    second = Problem(operator, 2.0**5 * first.gaps, "force", loads)
    tolerance = np.full((2, 2), WANTED)
    here, there = (client._dimensionless(part, tolerance)[0] for part in (first, second))
    for name in ("gaps", "starts", "loads", "depth"):
        np.testing.assert_allclose(here[name], there[name], rtol=1e-15, atol=0)
    assert here["spacing"] == there["spacing"]
    assert 0.3 < here["depth"].max() < 3
