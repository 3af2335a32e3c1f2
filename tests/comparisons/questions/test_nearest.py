"""What claims have measured nearest to a scene, said before it is solved."""

import json
import sys
from dataclasses import replace

import numpy as np
import pytest

from comparisons import formatting as fmt
from comparisons.geometry.prepare import RoughGeometry, prepare
from comparisons.judging.verdicts import NOT_RESOLVED, OUTSIDE, WITHIN
from comparisons.questions.claims.claim import load_claims, scene_of
from comparisons.questions.claims.nearest import (
    FIXED,
    QUANTITIES,
    _decided,
    claims_on,
    in_words,
    measured,
    nearest,
    own_values,
    places,
    plainly,
)
from comparisons.questions.experiments import EXPERIMENTS
from comparisons.scene.scene import load_scene
from reference.closed_form.adhesive import strength_of
from roughline.commands.app import run_command


def prepared(scene):
    geometry, loads = prepare(scene)
    rough = isinstance(geometry, RoughGeometry)
    unit = scene.effective_modulus * geometry.area * geometry.rms_slope if rough else np.nan
    return scene, loads, unit


def known(name, **changes):
    answers = nearest(*prepared(load_scene(name, changes)))
    return {answer.quantity: answer for answer in answers}


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
    """0.013 lies nearer to 0.01 than to 0.0316; what differs from the claim's surfaces is named."""
    load = {"force": {"values": [0.013], "relative_to": "E* A0 h'"}}
    area = known("rough-free", loading=load)["contact_area"]
    assert area.there == pytest.approx(0.01)
    assert area.place == "load F/(E* A0 h') = 0.01, here 0.013, claim rough-area"
    flat = known("rough-free", loading=load, **{"surface.hurst": 0.3})["contact_area"]
    assert ", H = 0.8, here 0.3, claim" in flat.place


@pytest.mark.parametrize("claim", load_claims(tuple(FIXED)), ids=list(FIXED))
def test_what_stood_still_is_what_the_files_of_claims_state(claim):
    """On scenes by the scene; of experiments as stated, or by their defaults."""
    if claim.experiment is None:
        own = own_values(*prepared(scene_of(claim, claim.sides(claim.vary.start)[1])))
    else:
        stated = claim.under(claim.as_stated).parameters
        arguments = EXPERIMENTS[claim.experiment].arguments(claim.vary.start, stated)
        own = {"H": arguments["hurst"], "F/(E* A0 h')": arguments["load"]}
        own |= {"side/long_cutoff": arguments["roll_off"], "line_length": arguments["line_length"]}
        own["side/short_cutoff"] = arguments["points"] / arguments["shortest"]
    for name, made in FIXED[claim.id].items():
        assert own[name] == pytest.approx(made, rel=1e-9)


def test_a_claim_along_the_scenes_own_parameter_decides():
    """H = 0.7 at F = 0.01 E* A0 h' was measured; at other loads, and at H = 0.8, loads were."""
    for load, hurst, claim in ((0.01, 0.7, "-hurst"), (0.01, 0.8, ""), (0.0316, 0.7, "")):
        loading = {"force": {"value": load, "relative_to": "E* A0 h'"}}
        area = known("rough-free", loading=loading, **{"surface.hurst": hurst})["contact_area"]
        assert area.measured.claim == f"rough-area{claim}"
    said = in_words(list(known("rough-free", loading=loading).values()), 0.01)
    percent = "\N{NARROW NO-BREAK SPACE}%"
    assert f"depth: within 10{percent}, not known whether within 1{percent} (" in said
    assert "contact area: no (+250" in said


@pytest.mark.parametrize(
    ("surface", "claim", "differing"),
    [
        ({}, "rough-area", []),
        ({"points": 128}, "rough-area", ["side/short_cutoff"]),
        ({"points": 128, "hurst": 0.7}, "rough-area-hurst", ["side/short_cutoff"]),
        ({"points": 128, "short_cutoff": "0.03125 um"}, "rough-area", []),
        ({"points": 128, "short_cutoff": "0.1 um"}, "rough-area-smooth", []),
        ({"long_cutoff": "0.1 um"}, "rough-area-plateau", []),
        ({"long_cutoff": "0.1 um", "points": 128}, "rough-area-plateau", ["side/short_cutoff"]),
        ({"long_cutoff": "0.1 um", "periodic": True}, "rough-area-periodic", ["side/long_cutoff"]),
        ({"hurst": None, "power": 3.4}, "rough-area-hurst", []),
    ],
)
def test_the_range_of_waves_is_compared(surface, claim, differing):
    """By its cut-offs over the side: of twice the points per side the shortest wave is a half."""
    load = {"force": {"value": 0.01, "relative_to": "E* A0 h'"}}
    recipe = load_scene("rough-free").surface.model_dump() | surface
    area = known("rough-free", loading=load, surface=recipe)["contact_area"]
    assert (area.measured.claim, area.differing) == (claim, differing)
    assert (area.word == NOT_RESOLVED) == bool(differing)


def test_a_map_and_a_line_of_another_length_were_not_measured():
    assert known("measured-map") == {}
    depth = known("rough-free", **{"methods.reduced.line_length": 0.5})["penetration"]
    assert depth.differing == ["line_length"]


def test_a_ball_that_dents_stands_at_its_depth_over_that_of_first_yield():
    """Springs lose a quarter of the force at 13 d_y; which criterion they read is another claim."""
    dented = {"plasticity": {"yield_stress": "420 MPa"}, "half_space.poisson_ratio": 0.3}
    dented |= {"half_space.youngs_modulus": "210 GPa", "indenter.radius": "10 mm"}
    depth = {"loading": {"penetration": [13.335 * 0.21258945e-6]}}
    force = known("paraboloid", **dented, **depth)["force"]
    assert (force.measured.claim, force.word, force.beyond) == (
        "plastic-total-force-10",
        OUTSIDE,
        False,
    )
    assert force.error == pytest.approx(-0.263, abs=0.01)
    root = known("paraboloid", **dented, **depth, **{"plasticity.model": "elastic_root"})["force"]
    assert root.measured.claim == "plastic-root-force-10"
    whole = {"compare.quantities": ["force", "residual_depth"]}
    shallow = known("paraboloid", **dented, **whole, loading={"penetration": [1e-7, 2e-7]})
    assert (shallow["force"].word, list(shallow)) == (WITHIN, ["force"])  # nothing yields
    over = known("paraboloid", **dented, **whole, loading={"penetration": [1e-7, 1e-6]})["force"]
    assert (over.here[0], over.word) == (1.0, NOT_RESOLVED)
    hardening = {"plasticity.hardening": "1 GPa"}
    assert not known("paraboloid", **dented, **depth, **hardening)
    drawn_out = {"loading": {"penetration": [2.8e-6, 1e-6]}}
    assert not known("paraboloid", **dented, **drawn_out)


def test_rubber_pressed_in_and_drawn_out_was_measured():
    """Along relaxation time over time of pressing in: 0.1 s in rubber-ball, arms of 0.01 to 1 s."""
    there = known("rubber-ball")["force"]
    assert (there.measured.claim, there.word) == ("viscoelastic-unloading", WITHIN)
    np.testing.assert_allclose(there.here, (0.1, 10))
    held = {"time": [0, 0.2, 1.0], "penetration": [0, 1e-4, 1e-4]}
    pressed = known("rubber-ball", loading=held)["contact_area"]
    assert pressed.word == WITHIN
    place = places(*prepared(load_scene("rubber-ball", {"loading": held})))
    np.testing.assert_allclose(place["viscoelastic-loading"], (0.05, 5))
    slow = known("rubber-ball", **{"viscoelastic.relaxation_times": ["1 s", "0.1 s", "1 us"]})
    assert (slow["force"].beyond, slow["force"].word) == (True, NOT_RESOLVED)
    sudden = {"time": [0, 1.0], "penetration": [1e-4, 1e-4]}
    assert known("rubber-ball", loading=sudden)["force"].measured.claim == "viscoelastic-shape"
    assert known("rubber-creep") == known("rubber-again") == {}


def test_the_creep_of_a_ball_stands_over_that_of_full_slip():
    """Under 8 times the load the contact is twice as wide, and slips at twice the creep."""
    one = known("rolling-ball")["traction"]
    heavy = known("rolling-ball", loading={"force": 800.0})["traction"]
    # 2 mu (E*/G*) a/R with E*/G* = (2 - nu)/(2 (1 - nu)) and a^3 = 3 F R/(4 E*)
    mu, nu, ratio = 0.3, 0.28, np.cbrt(0.75 * 100.0 * 0.01 / (210e9 / (1 - 0.28**2))) / 0.01
    full = 100 * mu * (2 - nu) / (1 - nu) * ratio  # in per cent
    np.testing.assert_allclose(one.here, (0.002 / full, 0.2 / full), rtol=1e-4)
    np.testing.assert_allclose(heavy.here, (0.001 / full, 0.1 / full), rtol=1e-4)
    assert one.place.startswith("creep over that of full slip = ")
    assert one.measured.ends == pytest.approx((0.005 / full, 2 / full))
    assert (one.measured.claim, one.differing, one.word) == ("rolling-curve-springs", [], OUTSIDE)
    assert "traction" not in known("rolling-ball", **{"rolling.lateral_creep": 0.001})


def test_no_creep_at_all_has_no_place_on_the_creep_curve():
    """0 has no logarithm; what creeps beside it stands where it stands alone."""
    around = known("rolling-ball", **{"rolling.creep": [-0.001, 0.0, 0.001]})["traction"]
    alone = known("rolling-ball", **{"rolling.creep": 0.001})["traction"]
    assert around == alone
    np.testing.assert_allclose(around.here, 0.1 / 1.066, rtol=1e-3)
    assert not around.beyond
    assert "traction" not in known("rolling-ball", **{"rolling.creep": 0.0})


def test_at_two_tolerances_one_scene_has_one_answer():
    """What is said to be within the claim's own tolerance is so when asked for that tolerance."""
    ratios = [*np.geomspace(1.01, 25.0, 40), 2.0085]
    scenes = [
        ("ellipsoid-2", {"indenter.radius_x": 0.01 * ratio, "indenter.radius_y": 0.01})
        for ratio in ratios
    ]
    loads = (0.0005, 0.001, 0.003, 0.01, 0.03, 0.05, 0.1, 0.2)
    scenes += [
        ("rough-free", {"loading": {"force": {"value": load, "relative_to": "E* A0 h'"}}})
        for load in loads
    ]
    tails = set()
    for name, changes in scenes:
        for quantity, asked in known(name, **changes, **{"compare.tolerance": 0.001}).items():
            tolerance = asked.measured.tolerance
            same = known(name, **changes, **{"compare.tolerance": tolerance})[quantity]
            limit = f"within {fmt.tolerance(tolerance)}"
            tail = limit in in_words([asked], 0.001)
            assert tail == (f"yes, {limit}" in in_words([same], tolerance)), (name, changes)
            tails.add((name, tail))
    assert len(tails) == 4  # both answers, on ellipsoids and on rough surfaces


def test_of_another_surface_or_body_nothing_was_measured():
    """The error is said once, with the values it was measured at, the load and the scene's."""
    heights = {"surface.hurst": 0.3, "compare.tolerance": 0.15}
    (depth,) = known("rough-free", **heights, **{"compare.quantities": ["penetration"]}).values()
    (said,) = plainly([depth], 0.15)
    assert said.startswith("penetration depth: not measured here (nearest: \N{MINUS SIGN}3.0 ")
    assert said.endswith(", H = 0.8, here 0.3, claim rough-penetration)")
    assert depth.word == NOT_RESOLVED
    heights |= {"surface.points": 128, "surface.hurst": 0.7}
    at_load = {"loading": {"force": {"value": 0.01, "relative_to": "E* A0 h'"}}}
    (said,) = plainly([known("rough-free", **heights, **at_load)["contact_area"]], 0.15)
    assert "F/(E* A0 h') = 0.01" in said
    radii = {"shape": "ellipsoid", "radius_x": "460 mm", "radius_y": "300 mm"}
    wheel = {"indenter": radii, "loading.force": "80 kN", "rolling.creep": "-0.1 %"}
    wheel |= {"half_space.youngs_modulus": "105 GPa"}
    (said,) = plainly([known("rolling-ball", **wheel)["traction"]], 0.01)
    told = "traction coefficient: not measured here (nearest: \N{MINUS SIGN}43.9 "
    assert said.startswith(told)
    assert ", R_x/R_y = 1, here 1.533, claim " in said
    same = known("rough-free", **{"compare.tolerance": 0.15})["penetration"]
    assert "penetration depth: yes, within 15" in in_words([same], 0.15)


def test_claims_on_a_built_in_scene_are_none_on_another_of_its_name():
    film = claims_on(load_scene("soft-ball-film"))
    assert "film-central" in film
    assert claims_on(load_scene("soft-ball-film", {"compare.tolerance": 0.2})) == film
    assert claims_on(load_scene("soft-ball-film", {"indenter.radius": "3 mm"})) == {}
    assert claims_on(load_scene("soft-ball-film", {"name": "my-film"})) == {}


def test_beyond_all_that_was_measured_nothing_is_within_but_by_a_theorem():
    shallow = known("sphere", loading={"penetration": [1e-10, 2e-10]})["force"]
    assert shallow.beyond
    assert shallow.word == WITHIN
    assert ", by theorem beyond what was measured, claim " in in_words([shallow], 0.01)
    unproved = replace(shallow.measured, proved=False)
    assert _decided(unproved, shallow.here, 0.01)[1] != WITHIN
    assert [claim for claim, row in measured().items() if row.proved] == [
        "transform-power-law",
        "transform-sphere",
    ]


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
    assert "mean gap: no (\N{MINUS SIGN}99" in in_words([gap], 0.05)


def test_the_error_of_a_prescribed_force_is_that_at_equal_penetration():
    few = {"compare.quantities": ["force"]}
    by_depth = known("ellipsoid-5", **few)
    by_force = known("ellipsoid-5", loading={"force": [100.0]}, **few)
    depth, force = (in_words([*answers.values()], 0.2) for answers in (by_depth, by_force))
    assert "model, force: no (" in depth
    assert "model, force at equal penetration depth: no (" in force


def test_where_loads_spread_the_worst_of_what_they_cover_decides():
    area = known("rough-free")["contact_area"]
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
    assert said.startswith("ellipsoid-5: reduced model, force: no (")
    assert "claim ellipsoid-force" in said
    assert said.endswith("To be sure: roughline advise ellipsoid-5 --tolerance 2%\n")
    assert run_command(["advise", "ellipsoid-5", "--known", "--json"]) == 0
    (document,) = json.loads(capsys.readouterr().out)
    assert document["nearest"][0]["word"] == OUTSIDE
    assert document["claims_on_scene"] == {}
    assert run_command(["advise", "rolling-ball", "--known", "--json"]) == 0
    (document,) = json.loads(capsys.readouterr().out)
    (traction, _) = document["nearest"]
    assert traction["fixed"] == traction["own"] == {"nu": 0.28, "R_x/R_y": 1.0}
    assert traction["agrees"]
    assert "rolling-curve-springs" in document["claims_on_scene"]
    assert run_command(["advise", "sphere", "--known", "--quantities", "force,penetration"]) == 0
    said = flat(capsys.readouterr().out)
    assert said.startswith("sphere: check the slopes: d/a = 0.678")
    assert "force: not known, as slopes are too large for every method" in said
    assert "no claim" not in said  # of the penetration, which is prescribed
    assert run_command(["advise", "sphere", "--known", "--json"]) == 0
    (document,) = json.loads(capsys.readouterr().out)
    assert document["notes"][0].startswith("check the slopes: d/a = 0.678")
    assert run_command(["advise", "rounded-punch", "--known"]) == 0
    said = flat(capsys.readouterr().out)
    assert "no claim has measured such a scene; force, penetration" in said
    assert "profile rises outwards are exact by theorem; the documentation's page on" in said
    assert run_command(["advise", "measured-map", "--known"]) == 0
    said = flat(capsys.readouterr().out)
    assert "no claim has measured such a scene; the documentation's page on methods" in said
    assert run_command(["advise", "soft-ball-film", "--known"]) == 0
    said = flat(capsys.readouterr().out)
    assert "soft-ball-film: claims on this built-in scene: film-central (" in said
    assert "no claim" not in said
    assert in_words([], 0.01) == ""
