"""What claims have measured nearest to a scene, said before it is solved."""

import json
import sys

import numpy as np
import pytest

from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.judging.verdicts import OUTSIDE, WITHIN
from comparisons.questions.claims.nearest import (
    HURST,
    QUANTITIES,
    in_words,
    measured,
    nearest,
    places,
    plainly,
)
from comparisons.questions.claims.record import STORED, load_claims_record
from comparisons.scene.scene import load_scene
from reference.closed_form.adhesive import strength_of
from roughline.commands.app import run_command


def known(name, **changes):
    scene = load_scene(name, changes)
    geometry, loads = prepare(scene)
    rough = isinstance(geometry, RoughGeometry)
    unit = scene.effective_modulus * geometry.area * geometry.rms_slope if rough else np.nan
    return {answer.quantity: answer for answer in nearest(scene, loads, unit)}


def test_every_place_has_a_measurement():
    assert measured().keys() == QUANTITIES.keys()


def test_an_ellipsoid_stands_at_its_ratio_of_radii():
    """At 2 it was measured: 0.99 % in force; at 40 no claim was: the end, and beyond it."""
    force = known("ellipsoid-2")["force"]
    assert force.here == pytest.approx((2.0, 2.0))
    assert force.there == pytest.approx(2.0, rel=0.01)
    assert (force.word, force.beyond) == (WITHIN, False)
    far = known("ellipsoid-2", **{"indenter.radius_x": 0.4})["force"]
    assert far.here[0] == pytest.approx(40.0, rel=0.5)
    assert (far.there, far.word, far.beyond) == (20.0, OUTSIDE, True)


def test_between_two_measurements_the_nearest_is_told_and_within_takes_both():
    """Between an exact circle and an ellipse that is not, nothing is exact."""
    points = measured()["ellipsoid-force"].points
    values = np.array([value for value, _, _ in points])
    for ratio in np.geomspace(1.1, 19.0, 17):
        radii = {"indenter.radius_x": 0.01, "indenter.radius_y": 0.01 / ratio}
        force = known("ellipsoid-2", **radii)["force"]
        assert force.there == values[np.argmin(np.abs(np.log(values / ratio)))]
        beside = values[values <= ratio].max(), values[values >= ratio].min()
        both = all(abs(e) + u <= 0.01 for value, e, u in points if value in beside)
        assert (force.word == WITHIN) == both


def test_a_load_between_two_that_were_measured_is_told_the_nearest_in_logarithms():
    """0.013 lies nearer to 0.01 than to 0.0316; surfaces of claims have H = 0.8."""
    load = {"force": {"values": [0.013], "relative_to": "E* A0 h'"}}
    area = known("rough-free", loading=load)["contact_area"]
    assert area.there == pytest.approx(0.01)
    assert area.place == "load F/(E* A0 h') = 0.01, here 0.013, H = 0.8 (claim rough-area)"
    flat = known("rough-free", loading=load, **{"surface.hurst": 0.3})["contact_area"]
    assert ", H = 0.8, here 0.3 (" in flat.place


def test_the_hurst_exponent_is_that_of_the_claims():
    for claim in load_claims_record(STORED).claims:
        if claim.id in QUANTITIES:
            stated = [n.stated for n in claim.nuisances if n.name.startswith("Hurst")]
            assert all(value == HURST for value in stated)
    assert load_scene("rough-free").surface.hurst == HURST


def test_a_claim_along_the_scenes_own_parameter_decides():
    """H = 0.7 at F = 0.01 E* A0 h' was measured; at other loads, and at H = 0.8, loads were."""
    for load, hurst, claim in ((0.01, 0.7, "-hurst"), (0.01, 0.8, ""), (0.0316, 0.7, "")):
        loading = {"force": {"value": load, "relative_to": "E* A0 h'"}}
        area = known("rough-free", loading=loading, **{"surface.hurst": hurst})["contact_area"]
        assert area.measured.claim == f"rough-area{claim}"
    said = plainly(list(known("rough-free", loading=loading).values()), 0.01)
    assert "penetration depth: not known to 1\N{NARROW NO-BREAK SPACE}%, within 10" in said
    assert "contact area: no (+250" in said


def test_the_creep_of_a_ball_stands_over_that_of_full_slip():
    """Under 8 times the load the contact is twice as wide, and slips at twice the creep."""
    one = known("rolling-ball")["traction"]
    heavy = known("rolling-ball", loading={"force": 800.0})["traction"]
    np.testing.assert_allclose(one.here, (0.002, 0.2), rtol=1e-4)
    np.testing.assert_allclose(heavy.here, (0.001, 0.1), rtol=1e-4)
    assert (one.measured.claim, one.agrees, one.word) == ("rolling-curve-springs", True, OUTSIDE)
    assert "traction" not in known("rolling-ball", **{"rolling.lateral_creep": 0.001})


def test_beyond_all_that_was_measured_nothing_is_within():
    shallow = known("sphere", loading={"penetration": [1e-10, 2e-10]})["force"]
    assert shallow.beyond
    assert shallow.word != WITHIN


def test_a_ball_under_a_force_stands_where_hertz_sinks_it():
    """To lowest order F = 4/3 E* sqrt(R) d^(3/2)."""
    scene = load_scene("sphere")
    radius, modulus = scene.indenter.radius, scene.effective_modulus
    depth = 1e-4 * radius
    pressed = known("sphere", loading={"force": 4 / 3 * modulus * np.sqrt(radius) * depth**1.5})
    np.testing.assert_allclose(pressed["force"].here, 1e-4, rtol=1e-4)


def test_areas_at_equal_force_say_nothing_of_a_prescribed_penetration():
    assert "contact_area" not in known("ellipsoid-2")
    force = {"loading": {"force": [1.0, 10.0]}}
    assert known("ellipsoid-2", **force)["contact_area"].measured.claim == "ellipsoid-area"


def test_what_is_known_beforehand_has_the_sign_of_what_a_run_finds():
    gap = known("rough-free")["mean_gap"]
    assert gap.error < 0
    assert "mean gap \N{MINUS SIGN}99" in in_words([gap], 0.05)


def test_where_loads_spread_the_worst_of_what_they_cover_decides():
    area = known("rough-patch")["contact_area"]
    covered = [
        abs(error) + bar
        for value, error, bar in area.measured.points
        if area.here[0] <= value * 1.001 and value <= area.here[1] * 1.001
    ]
    assert area.worst == max(covered)
    assert area.word == OUTSIDE


def test_half_spaces_of_layers_and_other_rules_are_none_that_was_measured():
    layer = {"thickness": 1e-8, "youngs_modulus": 1e9, "poisson_ratio": 0.3}
    coated = {"youngs_modulus": 1e11, "poisson_ratio": 0.3, "layers": [layer]}
    assert known("rough-patch", half_space=coated) == {}
    assert known("graded-ball") == known("coated-ball") == known("triangle-punch") == {}
    assert known("cone", **{"methods.reduced.rule": "half_radius"}) == {}


def test_the_parameter_of_maugis_is_that_of_the_closed_form():
    """Of R = E* = w = 1: the tension sigma0 = w/range of a parameter, from reference/."""
    for number in (0.3, 1.0, 5.0):
        tension = strength_of(1.0, 1.0, 1.0, number)
        changes = {"half_space": {"effective_modulus": 1.0}, "adhesion.work": 1.0}
        changes |= {"indenter.radius": 1.0, "adhesion.range": 1.0 / tension}
        scene = load_scene("adhesive-ball-range", changes)
        place = places(scene, None, np.nan)["adhesion-range"]
        np.testing.assert_allclose(place, number, rtol=1e-9)


def flat(text):
    return " ".join(text.split())


def test_advise_says_it_first_and_can_end_there(capsys, monkeypatch):
    words = ["advise", "ellipsoid-5", "--tolerance", "2%", "--known"]
    monkeypatch.setattr(sys, "argv", ["roughline", *words])
    assert run_command(words) == 0
    said = capsys.readouterr().out
    assert said.startswith("ellipsoid-5: Reduced model, force: ")
    assert "Nearest measured, reduced model: error of force" in said
    assert "claim ellipsoid-force" in said
    assert said.endswith("To be sure: roughline advise ellipsoid-5 --tolerance 2%\n")
    assert run_command(["advise", "ellipsoid-5", "--known", "--json"]) == 0
    (document,) = json.loads(capsys.readouterr().out)
    assert document["nearest"][0]["word"] == OUTSIDE
    assert run_command(["advise", "sphere", "--known"]) == 0
    assert "small slopes and strains" in " ".join(capsys.readouterr().out.split())  # a/R = 0.45
    assert run_command(["advise", "sphere", "--known", "--json"]) == 0
    (document,) = json.loads(capsys.readouterr().out)
    assert "small slopes and strains" in " ".join(document["notes"])
    assert run_command(["advise", "triangle-punch", "--known"]) == 0
    assert "no claim has measured such a scene" in capsys.readouterr().out
    assert run_command(["advise", "soft-ball-film", "--known"]) == 0
    assert "built-in scene soft-ball-film: film-central (" in flat(capsys.readouterr().out)
    assert in_words([], 0.01) == plainly([], 0.01) == ""
