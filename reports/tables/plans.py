"""Tables of plans: the model and resolutions of each method, or the reason for a refusal."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from comparisons import formatting as fmt
from comparisons.judging.multilevel import ensemble_text
from comparisons.results.record import SceneRecord
from comparisons.solving.plan_record import MethodPlan
from reports.plots.style import look
from reports.tables import cells
from reports.tables.table import Table, table

if TYPE_CHECKING:  # a page of results needs no solver
    from comparisons.solving.plan import Plan


def plan(planned: Plan) -> Table:
    """Return the planned model and resolutions of each method."""
    rows = []
    for method in planned.methods:
        levels = ", ".join(str(n) for n in method.resolutions) if method.supported else fmt.MISSING
        left_out = f" [{method.reason}]" if method.reason.startswith("left out") else ""
        modelled = method.modelled + left_out if method.supported else f"not run: {method.reason}"
        ensemble = ensemble_text(method.method, method.numbers, method.resolutions)
        if ensemble:
            modelled += f"; to begin with, {ensemble}"
        rows.append((cells.method(method.method, method.method), levels, modelled))
    title = f"{planned.scene.heading} ({planned.scene.name})"
    return table(("method", "resolutions", "plan"), rows, title=title)


def plan_rows(scene: SceneRecord) -> list[dict[str, Any]]:
    """Return the model and resolutions of each method that ran, or the reason for a refusal."""
    refused = scene.unsupported
    planned = {item.method: item for item in scene.plan.methods}
    rows = []
    for method in scene.methods:
        item = planned.get(method, MethodPlan(method, True, ""))
        levels = item.resolutions or scene.resolutions_solved(method)
        ensemble = ensemble_text(method, item.numbers, item.resolutions)
        modelled = "; ".join(filter(None, [item.modelled, ensemble]))
        rows.append(
            {
                "method": method,
                "label": look(method, scene).label,
                "supported": method not in refused,
                "text": refused.get(method) or modelled,
                "resolutions": ", ".join(fmt.count(level) for level in levels),
            }
        )
    return rows
