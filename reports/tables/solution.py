"""The load steps of one solve."""

from __future__ import annotations

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.questions.single import SingleResult
from reports.tables import cells
from reports.tables.table import Table, table


def shown_columns(result: SingleResult) -> list[str]:
    """Return the prescribed and the compared quantities."""
    prescribed = list(result.plan.loads.columns)
    compared = [q for q in result.plan.scene.compare.quantities if q not in prescribed]
    columns = result.solved()
    return [name for name in (*prescribed, *compared) if name in columns]


def load_steps(result: SingleResult, digits: int = 4) -> Table:
    """Return one row per load step, each quantity in one unit."""
    solved = result.solved()
    columns = {name: solved[name] for name in shown_columns(result)}
    scales = {name: fmt.prefix_for(v, quantity(name).unit) for name, v in columns.items()}
    heads = [quantity(name).title(scale.unit) for name, scale in scales.items()]
    rows = zip(
        *(
            [cells.number(fmt.number(v * scales[name].factor, digits), float(v)) for v in values]
            for name, values in columns.items()
        ),
        strict=True,
    )
    return table(heads, rows, title=f"{result.plan.scene.heading}: {result.method}")
