"""The edge-stretch rule knows no range of attraction: how short it must be, by Maugis' solution."""

from __future__ import annotations

import math

from comparisons.questions.experiments.running import Finding, above, experiment
from reduced.adhesion.adhere import pull_off
from reduced.profiles.shapes import paraboloid
from reference.closed_form.maugis import MaugisForm, strength_of

# R = E* = w = 1: in Maugis' units one number is left. His equations are solved to 1e-12, and their
# solution is minimised to 1e-9 of the radius: far less in the force, which is flat there.
_EXACT = 1e-10


def _pull_off(effort: str, *, parameter: float = 1.0) -> Finding:
    """Pull-off force of the rule over that of a constant tension out to a fixed gap, less one."""
    above("parameter", parameter, 0)
    form = MaugisForm(1.0, 1.0, 1.0, strength_of(1.0, 1.0, 1.0, parameter))
    true = float(form.force(form.pull_off()))
    rule = pull_off(paraboloid(1.0), 1.0, 1.0).before.force
    details: dict[str, float | str] = {"pull-off force over pi w R, by Maugis": -true / math.pi}
    return Finding(rule / true - 1, _EXACT, details)


EXPERIMENTS = (
    experiment(
        "adhesive-range",
        "Pull-off force of a ball against a constant tension of finite range (Maugis 1992)",
        "Maugis' parameter lambda",
        "parameter",
        _pull_off,
    ),
)
