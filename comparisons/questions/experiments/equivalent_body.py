"""Which body a one-dimensional profile stands for: the transform of Popov and Hess, inverted."""

from __future__ import annotations

import numpy as np

from comparisons.questions.experiments.running import Finding, above, experiment, one_of
from reduced.profiles import equivalents

RULES = ("half_radius", "transform")
_RADII = np.linspace(0.05, 1.0, 20)
_QUADRATURE = 1e-11  # of the transform there and back, each to 1e-12


def _body(effort: str, *, exponent: float = 2.0, rule: str = "half_radius") -> Finding:
    """Section of the body that the profile made from f = r^n stands for, over f, less one.

    The largest over the radii up to one. ``"half_radius"``: the chapter's profile;
    ``"transform"``: that of the general transform, by quadrature from the slope f' alone.
    """
    one_of("rule", rule, *RULES)
    above("exponent", exponent, 0)
    if rule == "half_radius":
        section = equivalents.power_law(exponent, 1.0).section
        assert section is not None  # every shape has one, but for tables
        profile = equivalents.half_radius(section)
    else:
        profile = equivalents.from_function(lambda r: exponent * r ** (exponent - 1), length=1.0)
    errors = equivalents.inverse_transform(profile, _RADII) / _RADII**exponent - 1
    worst = float(errors[np.argmax(np.abs(errors))])
    return Finding(worst, _QUADRATURE, {"spread over the radii": float(np.ptp(errors))})


EXPERIMENTS = (
    experiment(
        "equivalent-body",
        "Body of revolution that a profile stands for, against the one that it was made from",
        "exponent n of f = c r^n",
        "exponent",
        _body,
    ),
)
