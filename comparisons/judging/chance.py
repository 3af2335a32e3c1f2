"""Where a line that agrees with a rough surface does so by chance."""

from __future__ import annotations

import numpy as np

from comparisons.formatting import count, number
from comparisons.geometry.prepare import RoughGeometry
from comparisons.judging.truth import Truth
from comparisons.solving.plan import Plan

# F/(E* A0 h') from which on claims have compared lines with surfaces (rough_area.toml).
LIGHTEST = 1e-3
# Contacts below which the area of a single one is a large part of the whole.
FEWEST = 30
# Of the apparent area: above it contacts are few because they have merged.
MERGED = 0.1
UNKNOWN = np.array([np.nan])


def chance(plan: Plan, truth: Truth | None) -> str:
    """Return why lines that agree at the heaviest load do so by chance; "" where they do not."""
    geometry = plan.geometry
    if truth is None or not isinstance(geometry, RoughGeometry) or plan.scene.physics:
        return ""
    reasons = []
    force, area, contacts = (
        float(truth.curves.get(name, UNKNOWN)[-1])
        for name in ("force", "contact_area", "contact_count")
    )
    load = force / (plan.scene.effective_modulus * geometry.area * geometry.rms_slope)
    if load < LIGHTEST:
        reasons.append(f"F/(E* A₀ h') = {number(load)}, below {number(LIGHTEST, 1)}")
    surfaces = max(len(solution.converged) for solution in truth.levels.solutions.values())
    if area < MERGED * geometry.area and surfaces * contacts < FEWEST:
        reasons.append(f"{count(surfaces * contacts)} contacts, fewer than {FEWEST}")
    return " and ".join(reasons)
