"""The body represented by a one-dimensional profile: inverse of the transform of Popov and Hess."""

from __future__ import annotations

import numpy as np

from comparisons.questions.experiments.running import Finding, above, experiment, one_of, worst
from reduced.profiles import equivalents

RULES = ("half_radius", "transform")
_RADII = np.linspace(0.05, 1.0, 20)
_QUADRATURE = 1e-11  # of the transform and its inverse, both to 1e-12


def _body(effort: str, *, exponent: float = 2.0, rule: str = "half_radius") -> Finding:
    """Measure the relative error of the body represented by the profile made from f = r^n.

    The largest error over radii up to one. ``"half_radius"``: the chapter's profile;
    ``"transform"``: the profile of the general transform, by quadrature of the slope f'.
    """
    one_of("rule", rule, *RULES)
    above("exponent", exponent, 0)
    if rule == "half_radius":
        section = equivalents.power_law(exponent, 1.0).section
        assert section is not None  # all shapes except for tables have one
        profile = equivalents.half_radius(section)
    else:
        profile = equivalents.from_function(lambda r: exponent * r ** (exponent - 1), length=1.0)
    body, true = equivalents.inverse_transform(profile, _RADII), _RADII**exponent
    details: dict[str, float | str] = {"spread over the radii": float(np.ptp(body / true))}
    return Finding(*worst(body, true), _QUADRATURE, details)


EXPERIMENTS = (
    experiment(
        "equivalent-body",
        "Body of revolution that a profile stands for, against the one that it was made from",
        "exponent n of f = c r^n",
        "exponent",
        _body,
    ),
)
