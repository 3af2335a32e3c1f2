"""Hard impacts: velocities over many decades, too hard, too soft, without a closed form."""

from __future__ import annotations

from typing import Any

from comparisons.hard_cases.case import (
    ONLY_FULL,
    Expected,
    HardCase,
    Trusted,
    accurate,
    not_for,
    refused,
)
from comparisons.hard_cases.usual import BALL, RESOLUTIONS, STEEL, all_methods

COMPARED = {"quantities": ["contact_duration", "penetration", "force"]}
# Duration of Hertz' impact at the resolutions of a quick answer, with a margin of two.
STRUCK = {
    "closed_form": accurate(1e-11),
    "reduced": accurate(1e-10),
    "bem_dense": accurate(3e-3),
    "bem_fft": accurate(3e-4),
    "fem": accurate(2e-4),
}
NO_COURSE = not_for("gives impacts, not their course in time")
ONLY_IMPACTS = {"bem_dense": NO_COURSE, "bem_fft": NO_COURSE, "fem": NO_COURSE}


def _scene(velocity: Any, **tables: Any) -> dict[str, Any]:
    """Return the tables of a steel ball of 10 g, but for what is given."""
    own = {"half_space": STEEL, "indenter": BALL, "compare": COMPARED}
    return own | {"dynamics": {"mass": "10 g", "velocity": velocity}} | tables


def _impact(name: str, title: str, hard: str, scene: Any, expected: Any, **more: Any) -> HardCase:
    return HardCase(
        id=f"impact-{name}",
        title=title,
        hard=hard,
        scene=scene,
        expected=expected,
        resolutions=RESOLUTIONS,
        slow=ONLY_FULL | {"bem_dense"},
        **more,
    )


def _struck(**changes: Expected) -> dict[str, Expected]:
    return STRUCK | changes


CASES = (
    _impact(
        "decades",
        "A sphere at velocities over ten decades",
        "the contact radius goes as v^(2/5): 1e4 times smaller at the slowest",
        _scene(
            {"from": 1e-10, "to": 1, "steps": 6, "spacing": "log"},
            indenter={"shape": "sphere", "radius": "10 mm"},
        ),
        _struck(reduced=accurate(1e-8)),
    ),
    _impact(
        "tiny",
        "A tip of 10 nm and a picogram",
        "lengths of nanometres, times of nanoseconds, energies of 1e-17 J",
        _scene(
            ["1 mm/s", "10 cm/s"],
            indenter={"shape": "paraboloid", "radius": "10 nm"},
            dynamics={"mass": "1e-15 kg", "velocity": ["1 mm/s", "10 cm/s"]},
        ),
        _struck(),
    ),
    _impact(
        "twins",
        "Two velocities that differ in the last digit",
        "the ladder of depths between them has no length",
        _scene([1.0, 1.0000000000000002]),
        _struck(),
    ),
    _impact(
        "punch",
        "A flat punch",
        "the stiffness jumps to its full value at first touch",
        _scene([0.1, 1.0], indenter={"shape": "cylinder", "radius": "1 mm"}),
        _struck(bem_dense=accurate(2e-4), bem_fft=accurate(2e-4), fem=accurate(2e-3)),
    ),
    _impact(
        "table",
        "A tabulated tip without a closed form",
        "the truth strikes along a computed load curve",
        _scene(
            [0.1, 1.0],
            indenter={
                "shape": "profile",
                "r": ["0 mm", "1 mm", "2 mm"],
                "f": [0, "50 um", "0.3 mm"],
            },
        ),
        _struck(
            closed_form=not_for("no closed form is known for a profile"),
            reduced=accurate(6e-4),
            bem_dense=accurate(1e-2),
            bem_fft=accurate(1e-3),
            fem=accurate(6e-4),
        ),
        truth=Trusted("bem_fft", (16, 32, 64)),
    ),
    _impact(
        "beyond-the-sphere",
        "A sphere of one gram at 1000 km/s",
        "the slower impact is deep, the faster would drive the contact to the equator",
        _scene(
            ["10 m/s", "1e6 m/s"],
            indenter={"shape": "sphere", "radius": "1 mm"},
            half_space={"effective_modulus": "1 GPa"},
            dynamics={"mass": "1 g", "velocity": ["10 m/s", "1e6 m/s"]},
        ),
        _struck(
            closed_form=accurate(1e-11, lost=(1,), text="does not stop the mass"),
            reduced=accurate(1e-7),
            bem_dense=accurate(1e-2, lost=(1,)),
            bem_fft=accurate(1e-3, lost=(1,)),
            fem=accurate(4e-4, lost=(1,)),
        ),
    ),
    _impact(
        "rest",
        "A mass at rest that nothing pushes",
        "it never moves",
        _scene(0),
        all_methods(refused("expected above zero, or a loading.force with its times")),
    ),
    _impact(
        "thousand-bounces",
        "A soft push of a hundred contact times: the ball bounces",
        "each touch begins with a force that no smooth step follows",
        _scene(
            0,
            dynamics={"mass": "10 g", "velocity": 0},
            loading={"time": [0, "1 ms", "2 ms"], "force": ["1 N", "20 N", "1 N"], "substeps": 20},
            compare={"quantities": ["penetration"]},
        ),
        ONLY_IMPACTS | {"closed_form": accurate(1e-11), "reduced": accurate(1e-2)},
    ),
)
