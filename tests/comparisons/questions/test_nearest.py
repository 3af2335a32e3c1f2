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
    _decided,
    claimed,
    claims_on,
    fixed,
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

CONE = {"shape": "cone", "slope": 0.1}
STEEL = {"youngs_modulus": "210 GPa", "poisson_ratio": 0.3}


def prepared(scene):
    geometry, loads = prepare(scene)
    rough = isinstance(geometry, RoughGeometry)
    unit = scene.effective_modulus * geometry.area * geometry.rms_slope if rough else np.nan
    return scene, loads, unit


def known(name, **changes):
    answers = nearest(*prepared(load_scene(name, changes)))
    return {answer.quantity: answer for answer in answers}


def test_every_claim_with_values_of_its_own_has_a_row_and_a_quantity():
    for claim in claimed():
        assert len(measured(claim).row) > 1
        assert measured(claim).quantities


def test_an_ellipsoid_stands_at_its_ratio_of_radii():
    """At 2 it was measured: 0.99 % in force; at 40 no claim was: the end, and beyond it."""
    force = known("ellipsoid-2")["force"]
    assert force.here == pytest.approx((2.0, 2.0))
    assert force.point.place == pytest.approx(2.0, rel=0.01)
    assert (force.word, force.beyond) == (WITHIN, False)
    # at 4.5 the next points are within 5 % and, the nearer one, outside; it errs by -4.5 %
    between = known("ellipsoid-2", **{"indenter.radius_x": 0.045, "compare.tolerance": 0.05})
    assert between["force"].point.word(0.05) == OUTSIDE
    assert between["force"].word == NOT_RESOLVED
    far = known("ellipsoid-2", **{"indenter.radius_x": 0.4})["force"]
    assert far.here[0] == pytest.approx(40.0, rel=0.5)
    assert (far.point.place, far.word, far.beyond) == (20.0, OUTSIDE, True)


def test_between_two_measurements_the_nearest_is_told_and_within_takes_both():
    """Between an exact circle and an ellipse that is not, nothing is exact."""
    points = measured("ellipsoid-force").row
    values = np.array([point.place for point in points])
    for ratio in np.geomspace(1.1, 19.0, 17):
        radii = {"indenter.radius_x": 0.01, "indenter.radius_y": 0.01 / ratio}
        force = known("ellipsoid-2", **radii)["force"]
        assert force.point.place == values[np.argmin(np.abs(np.log(values / ratio)))]
        beside = values[values <= ratio].max(), values[values >= ratio].min()
        both = all(point.worst <= 0.01 for point in points if point.place in beside)
        assert (force.word == WITHIN) == both


def test_a_load_between_two_that_were_measured_is_told_the_nearest_in_logarithms():
    """0.013 lies nearer to 0.01 than to 0.0316; what differs from the claim's surfaces is named."""
    load = {"force": {"values": [0.013], "relative_to": "E* A0 h'"}}
    area = known("rough-free", loading=load)["contact_area"]
    assert area.point.place == pytest.approx(0.01)
    assert area.place == "load F/(E* A0 h') = 0.01, here 0.013, claim rough-area"
    flat = known("rough-free", loading=load, **{"surface.hurst": 0.3})["contact_area"]
    assert ", H = 0.8, here 0.3, claim" in flat.place


STANDING = tuple(name for name in claimed() if fixed(name))


@pytest.mark.parametrize("claim", load_claims(STANDING), ids=STANDING)
def test_what_stood_still_is_what_the_files_of_claims_state(claim):
    """On scenes by the scene; of experiments as stated, or by their defaults."""
    if claim.experiment is None:
        own = own_values(*prepared(scene_of(claim, claim.sides(claim.vary.start)[1])))
    else:
        stated = claim.under(claim.as_stated).parameters
        arguments = EXPERIMENTS[claim.experiment].arguments(claim.vary.start, stated)
        own = {"H": arguments["hurst"], "F/(E* A0 h')": arguments["load"]}
        own |= {"L/lambda_l": arguments["roll_off"], "L1/L": arguments["line_length"]}
        own["L/lambda_s"] = arguments["points"] / arguments["shortest"]
        own["half-space"] = "periodic" if arguments["periodic"] else "free patch"
        own["spectrum of the line"] = {"rings": "ring sums"}[arguments["rule"]]
    for name, made in fixed(claim.id).items():
        assert own[name] == (made if isinstance(made, str) else pytest.approx(made, rel=1e-9))


@pytest.mark.parametrize(
    ("claim", "name", "changes"),
    [
        ("rough-area-smooth", "rough-free", {"surface.short_cutoff": "0.125 um"}),
        ("rolling-curve-springs", "rolling-ball", {"rolling.creep": 5e-5}),
    ],
)
def test_a_claim_stands_where_its_own_scene_does_whatever_its_unit(claim, name, changes):
    """8 spacings of 1/64 um on 1 um are 1/8; 0.005 % of the creep of full slip, 1.066 %."""
    load = {"force": {"value": 0.01, "relative_to": "E* A0 h'"}}
    loading = {"loading": load} if name == "rough-free" else {}
    stands = places(*prepared(load_scene(name, changes | loading)))[claim][0]
    points = [point.place for point in measured(claim).row]
    assert min(np.abs(np.array(points) / stands - 1)) < 1e-9


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
        ({"points": 128}, "rough-area", ["L/lambda_s"]),
        ({"points": 128, "hurst": 0.7}, "rough-area-hurst", ["L/lambda_s"]),
        ({"points": 128, "short_cutoff": "0.03125 um"}, "rough-area", []),
        ({"points": 128, "short_cutoff": "0.1 um"}, "rough-area-smooth", []),
        ({"long_cutoff": "0.1 um"}, "rough-area-plateau", []),
        ({"long_cutoff": "0.1 um", "points": 128}, "rough-area-plateau", ["L/lambda_s"]),
        ({"long_cutoff": "0.1 um", "periodic": True}, "rough-area-periodic", ["L/lambda_l"]),
        ({"hurst": None, "power": 3.4}, "rough-area-hurst", []),
    ],
)
def test_the_range_of_waves_is_compared(surface, claim, differing):
    """By its cut-offs over the side: of twice the points per side the shortest wave is a half."""
    load = {"force": {"value": 0.01, "relative_to": "E* A0 h'"}}
    recipe = load_scene("rough-free").surface.model_dump() | surface
    area = known("rough-free", loading=load, surface=recipe)["contact_area"]
    assert (area.measured.claim, area.differing) == (claim, differing)
    assert area.word == OUTSIDE  # whatever was measured is


def at_load(load, **changes):
    loading = {"force": {"value": load, "relative_to": "E* A0 h'"}}
    return known("rough-free", loading=loading, **{"compare.tolerance": 0.1, **changes})


@pytest.mark.parametrize(
    ("changes", "word", "error"),
    [
        ({"surface.periodic": True}, OUTSIDE, 0.216),
        ({"surface.hurst": 0.7}, WITHIN, 0.009),
        ({"surface.long_cutoff": "0.25 um"}, WITHIN, 0.053),
        # how two of them act together is not known
        ({"surface.hurst": 0.7, "surface.long_cutoff": "0.25 um"}, NOT_RESOLVED, 0.053),
        ({"methods.reduced.line_length": 0.5}, OUTSIDE, -0.430),
        ({"methods.reduced.line_length": 0.6}, OUTSIDE, -0.228),
        # between a length that is within and one that is not
        ({"methods.reduced.line_length": 0.95}, NOT_RESOLVED, 0.009),
        # waves half as short were not measured
        ({"surface.points": 128}, NOT_RESOLVED, 0.009),
    ],
)
def test_what_a_statement_leaves_open_is_looked_up_where_it_was_measured(changes, word, error):
    """Of rough-penetration at F = 0.02154 E* A0 h', where it was measured along each of them."""
    depth = at_load(0.02154434690031882, **changes)["penetration"]
    assert (depth.measured.claim, depth.word) == ("rough-penetration", word)
    assert depth.point.error == pytest.approx(error, abs=0.001)


def test_far_from_the_statement_a_draw_is_nearest():
    """Of 16 draws the first: +490 % on a periodic surface with all else away from its middle."""
    there = {"surface.periodic": True, "surface.hurst": 0.2, "surface.long_cutoff": "0.15 um"}
    depth = at_load(0.09, **there, **{"methods.reduced.line_length": 1.9})["penetration"]
    assert (depth.point.error, depth.word) == (pytest.approx(4.896, abs=0.001), OUTSIDE)


def test_two_values_that_differ_are_known_by_a_validity_map():
    """The stiffness of rough-stiffness-hurst was measured along H at three roll-offs."""
    steep = {"surface.hurst": 0.6, "surface.long_cutoff": "0.2 um"}
    stiffness = at_load(0.01, **steep)["stiffness"]
    assert (stiffness.measured.claim, stiffness.word) == ("rough-stiffness-hurst", WITHIN)
    assert at_load(0.01, **{**steep, "surface.hurst": 0.2})["stiffness"].word == NOT_RESOLVED


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
    assert force.point.error == pytest.approx(-0.263, abs=0.01)
    root = known("paraboloid", **dented, **depth, **{"plasticity.model": "elastic_root"})["force"]
    assert root.measured.claim == "plastic-root-force-10"
    whole = {"compare.quantities": ["force", "residual_depth"]}
    # nothing yields, springs of no model either: elastic balls were measured
    for model in ("stress", "elastic_root", "zunker_kamrin", "none"):
        below = {"loading": {"penetration": [1e-7, 2e-7]}, "plasticity.model": model}
        shallow = known("paraboloid", **dented, **whole, **below)
        assert (shallow["force"].word, list(shallow)) == (WITHIN, ["force"])
        assert shallow["force"].measured.parameter.startswith("exponent")
    # and beyond: of springs that stay elastic there nothing was measured
    assert not known("paraboloid", **dented, **depth, **{"plasticity.model": "none"})
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
    ratios = [*np.geomspace(1.01, 25.0, 6), 2.0085]
    scenes = [
        ("ellipsoid-2", {"indenter.radius_x": 0.01 * ratio, "indenter.radius_y": 0.01})
        for ratio in ratios
    ]
    loads = (0.0005, 0.003, 0.03, 0.1)
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
    assert said.startswith("penetration depth: yes, within 15\N{NARROW NO-BREAK SPACE}% (nearest: ")
    assert said.endswith(", H = 0.8, here 0.3, claim rough-penetration)")
    heights |= {"surface.points": 128, "surface.hurst": 0.7}
    (said,) = plainly([at_load(0.01, **heights)["contact_area"]], 0.01)
    assert said.startswith("contact area: no (nearest: +19")
    assert "F/(E* A0 h') = 0.01" in said
    radii = {"shape": "ellipsoid", "radius_x": "460 mm", "radius_y": "300 mm"}
    wheel = {"indenter": radii, "loading.force": "80 kN", "rolling.creep": "-0.1 %"}
    wheel |= {"half_space.youngs_modulus": "105 GPa"}
    (said,) = plainly([known("rolling-ball", **wheel)["traction"]], 0.01)
    told = "utilised friction: not measured here (nearest: \N{MINUS SIGN}43."
    assert said.startswith(told)
    assert ", R_x/R_y = 1, here 1.533, claim " in said
    same = known("rough-free", **{"compare.tolerance": 0.15})["penetration"]
    assert "penetration depth: yes, within 15" in in_words([same], 0.15)


@pytest.mark.parametrize(
    ("name", "changes", "claim"),
    [
        ("soft-ball-film", {"name": "my-film", "indenter.radius": "3 mm"}, "film-central"),
        ("worn-punch", {"loading.force": "5 N", "half_space": STEEL}, "worn-punch"),
        ("impact-ball", {"indenter": {"shape": "sphere", "radius": "1 m"}}, "impact-ball-springs"),
        ("coated-ball", {"half_space.layers.0.thickness": "1 nm"}, "hard-coating-thin-1"),
        ("coated-ball", {"methods.reduced.layers": "layer"}, "hard-coating-thick-1"),
        ("graded-ball", {"indenter": CONE}, None),
        ("rubber-ball", {}, "viscoelastic-again"),
        ("triangle-punch", {}, "punch-hexagon"),
        ("triangle-punch", {}, "punch-l"),  # in words the same: 6 points
        ("worn-ball", {}, "worn-ball"),
        ("friction-steel", {}, "partial-slip-rigid"),
    ],
)
def test_claims_are_on_scenes_of_a_kind(name, changes, claim):
    """By bodies, physics and choices: numbers, names and how a modulus is written are aside."""
    found = [claim.id for claim in claims_on(load_scene(name, changes))]
    assert (claim in found) if claim else not found
    assert "hard-coating-thin-10" not in found  # the same measurements at another tolerance
    assert "cattaneo-shift" not in found  # is on one printed number
    assert "viscoelastic-loading" not in found  # is on rubber of another model


def test_beyond_all_that_was_measured_nothing_is_within_but_by_a_theorem():
    shallow = known("sphere", loading={"penetration": [1e-10, 2e-10]})["force"]
    assert shallow.beyond
    assert shallow.word == WITHIN
    assert ", by theorem beyond what was measured, claim " in in_words([shallow], 0.01)
    unproved = replace(shallow.measured, proved=False)
    assert _decided(unproved, shallow.here, {}, 0.01)[1] != WITHIN


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
    assert gap.point.error < 0
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
        point.worst
        for point in area.measured.row
        if area.here[0] <= point.place * 1.001 and point.place <= area.here[1] * 1.001
    ]
    assert area.point.worst == max(covered)
    assert area.word == OUTSIDE


def test_maps_half_spaces_of_layers_and_other_rules_are_none_that_was_measured():
    layer = {"thickness": 1e-8, "youngs_modulus": 1e9, "poisson_ratio": 0.3}
    coated = {"youngs_modulus": 1e11, "poisson_ratio": 0.3, "layers": [layer]}
    assert known("rough-patch", half_space=coated) == {}
    for name in ("graded-ball", "coated-ball", "triangle-punch", "measured-map"):
        assert known(name) == {}
    assert known("cone", **{"methods.reduced.rule": "half_radius"}) == {}


def test_the_parameter_of_maugis_is_that_of_the_closed_form():
    """Of R = E* = w = 1: the tension sigma0 = w/range of a parameter, from reference/."""
    for number in (0.3, 1.0, 5.0):
        tension = strength_of(1.0, 1.0, 1.0, number)
        changes = {"half_space": {"effective_modulus": 1.0}, "adhesion.work": 1.0}
        changes |= {"indenter.radius": 1.0, "adhesion.range": 1.0 / tension}
        scene = load_scene("adhesive-ball-range", changes)
        place = places(*prepared(scene))["adhesion-range"]
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
    assert "ellipsoid-force" in document["claims_on_scene"]
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
    assert "reduced model, contact pressure: within 1" in said
    assert "(claim stress-abel-rounded-punch, of such a scene" in said
    assert "no claim" not in said
    assert run_command(["advise", "measured-map", "--known", "--quantities", "contact_area"]) == 0
    said = flat(capsys.readouterr().out)
    assert "no claim that can be matched to it has measured contact area; `roughline" in said
    pressed = ["--set", 'loading={force="1 mN"}']
    assert run_command(["advise", "coated-ball", "--known", *pressed]) == 0
    said = flat(capsys.readouterr().out)
    assert "reduced model, force at equal penetration depth: within 1" in said
    assert in_words([], 0.01) == ""
