"""Speed of the solvers relative to yardsticks measured in the same run: ``roughline bench``."""

from __future__ import annotations

from collections.abc import Callable

from comparisons.questions.benchmarks import bem, fem, memory, reduced
from comparisons.questions.benchmarks.yardstick import Measurement

BENCHMARKS: dict[str, Callable[[], list[Measurement]]] = {
    "reduced": reduced.measure,
    "bem": lambda: [*bem.measure(), *memory.rows(memory.CASES["bem"])],
    "fem": lambda: [*fem.measure(), *memory.rows(memory.CASES["fem"])],
}
