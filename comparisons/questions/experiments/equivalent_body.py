"""The body represented by a one-dimensional profile: inverse of the transform of Popov and Hess."""

from __future__ import annotations

from typing import Annotated

import numpy as np

from comparisons.questions.experiments.experiment import Above, Finding, OneOf, experiment, worst
from reduced.profiles import equivalents

RULES = ("half_radius", "transform")
_RADII = np.linspace(0.05, 1.0, 20)
_QUADRATURE = 1e-11  # of the transform and its inverse, both to 1e-12


@experiment(
    "equivalent-body",
    "Body of revolution that a profile stands for, against the one that it was made from",
    "exponent",
    "exponent n of f = c r^n",
)
def equivalent_body(
    effort: str,
    *,
    exponent: Annotated[float, Above(0)] = 2.0,
    rule: Annotated[str, OneOf(*RULES)] = "half_radius",
) -> Finding:
    """Measure the relative error of the body represented by the profile made from f = r^n.

    The largest error over radii up to one. ``"half_radius"``: the chapter's profile;
    ``"transform"``: the profile of the general transform, by quadrature of the slope f'.
    """
    if rule == "half_radius":
        section = equivalents.power_law(exponent, 1.0).section
        assert section is not None  # all shapes except for tables have one
        profile = equivalents.half_radius(section)
    else:
        profile = equivalents.from_function(lambda r: exponent * r ** (exponent - 1), length=1.0)
    body, true = equivalents.inverse_transform(profile, _RADII), _RADII**exponent
    details: dict[str, float | str] = {"spread over the radii": float(np.ptp(body / true))}
    return Finding(*worst(body, true), _QUADRATURE, details)
