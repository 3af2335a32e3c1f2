"""The steps of ``roughline advise``: what is known nearest to a scene, then what is measured."""

from __future__ import annotations

import json
import math
from typing import Any

from rich.console import Console
from rich.markup import escape

from comparisons.errors import InputError
from comparisons.facts.quantities import quantity
from comparisons.formatting import listed
from comparisons.geometry.prepare import RoughGeometry
from comparisons.questions.claims.nearest import Nearest, claims_on, in_words, nearest, plainly
from comparisons.questions.study import solved_in_memory
from comparisons.results.advice import advise
from comparisons.results.record import asked_in_vain
from comparisons.results.recording import record_scene
from comparisons.scene.scene import Scene
from comparisons.solving.plan import Effort, Plan
from comparisons.tasks.solution import Solved
from roughline.commands import printable, say, terminal, typed
from roughline.commands.arguments import FINE

ALIKE = "of such a scene; its numbers may be others"
NOTHING = "no claim that can be matched to it has measured"
ROUND = (
    "force, penetration, contact area and stiffness of a body of revolution whose profile rises "
    "outwards are exact by theorem"  # others are no scenes
)
CHOICE = (
    "`roughline claims --stored` writes the page of all, and the documentation's page on methods "
    "tells what fits which contact"
)


def known_of(plan: Plan) -> list[Nearest]:
    """Return what claims have measured nearest to the scene of a plan."""
    rough = plan.geometry if isinstance(plan.geometry, RoughGeometry) else None
    unit = plan.scene.effective_modulus * rough.area * rough.rms_slope if rough else math.nan
    return nearest(plan.scene, plan.loads, unit)


def print_known(plans: list[Plan], as_json: bool) -> int:
    """Say what is known of each plan without solving anything, and which command does."""
    if as_json:
        print(json.dumps([*map(_document, plans)], indent=1))
        return FINE
    console = terminal.Terminal()
    for plan in plans:
        name, tolerance = plan.scene.name, plan.scene.compare.tolerance
        for note in plan.doubts:
            console.print(f"{name}: {note}")
        known = known_of(plan)
        for answer in plainly(known, tolerance):
            console.print(f"{name}: reduced model, {answer}")
        control, told = plan.loads.control, {answer.quantity for answer in known}
        asked = [n for n in plan.scene.compare.quantities if n not in told]
        for claim in claims_on(plan.scene):
            if names := [n for n in claim.quantity if n in asked]:
                equal = (
                    f" at equal {quantity(quantity(control).counterpart).label}"
                    if control in names
                    else ""
                )
                said = claim.sentence[0].lower() + claim.sentence[1:].rstrip(".")
                text = f"{listed([quantity(n).label for n in names])}{equal}: {said}"
                console.print(f"{name}: reduced model, {text} (claim {claim.id}, {ALIKE})")
                told |= set(names)
        # of what is prescribed nothing is asked
        if left := [quantity(n).label for n in asked if n not in told | {control}]:
            theorem = "" if known or not _transformed(plan.scene) else f"; {ROUND}"
            console.print(f"{name}: {NOTHING} {listed(left)}{theorem}; {CHOICE}")
    say(f"To be sure: {typed(without='--known')}")
    return FINE


def advise_all(plans: list[Plan], effort: Effort, as_json: bool) -> int:
    """Say what is known, solve every plan with all methods, and advise.

    Where nothing that was run is sure of the tolerance, the truth is refined: its bar decides.
    InputError if a quantity is asked for that no method gives.
    """
    console = terminal.Terminal()
    for plan in () if as_json else plans:
        if text := in_words(known_of(plan), plan.scene.compare.tolerance):
            console.print(f"{plan.scene.name}: {text} Measuring to be sure.\n")
    records = []
    screen = Console(stderr=True)
    for plan in plans:
        with screen.status(escape(printable(f"solving {plan.scene.name} with every method"))):
            records.append(record_scene(*solved_in_memory(plan, effort, _settled)))
    if vain := asked_in_vain(records):
        raise InputError("\n".join(vain))
    if as_json:
        documents = [
            advise(record).document | _document(plan)
            for plan, record in zip(plans, records, strict=True)
        ]
        print(json.dumps(documents, indent=1))
    else:
        terminal.print_advice([(record.name, advise(record)) for record in records])
    return FINE


def _settled(plan: Plan, solved: Solved) -> bool:
    """Whether some setting is sure of the tolerance, or nothing asked for can be judged."""
    advice = advise(record_scene(plan, solved))
    return advice.cheapest is not None or not advice.quantities


def _transformed(scene: Scene) -> bool:
    """Whether the theorem of the transform is on such scenes: round bodies, merely pressed."""
    body = scene.indenter
    plain = scene.half_space.uniform and not (scene.physics or scene.body)
    return body is not None and body.axisymmetric and plain and scene.methods.reduced.rule == "mdr"


def _document(plan: Plan) -> dict[str, Any]:
    return {
        "scene": plan.scene.name,
        "nearest": [answer.document for answer in known_of(plan)],
        "claims_on_scene": {claim.id: claim.verdict for claim in claims_on(plan.scene)},
        "notes": plan.doubts,
    }
