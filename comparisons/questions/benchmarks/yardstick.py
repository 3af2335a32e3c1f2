"""Relative times: task and yardstick take turns on one thread, under the same machine load."""

from __future__ import annotations

import gc
import statistics
import time
from collections.abc import Callable, Mapping
from dataclasses import asdict, dataclass

import numpy as np
from threadpoolctl import threadpool_limits

_LEAST_SECONDS = 2e-4  # seconds; shorter calls are repeated within a reading


@dataclass(frozen=True)
class Measurement:
    """One line of a benchmark."""

    name: str  # the measured task
    seconds: float  # median time of one call on warm code
    yardstick: str
    # Median time of the yardstick, measured in turns; None without a yardstick or its time.
    yardstick_seconds: float | None = None
    # Median of the ratios of neighbouring readings; None without a yardstick.
    ratio: float | None = None
    target: float | None = None  # largest acceptable ratio; None if the row is for information

    @property
    def met(self) -> bool | None:
        """Whether the target is met; None without one, or without a yardstick."""
        if self.target is None or self.ratio is None:
            return None
        return bool(self.ratio <= self.target)  # errors are NumPy numbers, and JSON has no np.bool

    def row(self) -> dict[str, object]:
        """Return the row of the JSON file."""
        return asdict(self) | {"met": self.met}


def interleaved(
    tasks: Mapping[str, Callable[[], object]],
    repeats: int = 7,
    clock: Callable[[], float] = time.perf_counter,
) -> dict[str, list[float]]:
    """Return seconds per call of the tasks: `repeats` readings in turns after an unmeasured call.

    Garbage is collected before them. The clock `time.process_time` leaves out other load.
    """
    with threadpool_limits(limits=1):
        counts = {}
        for name, task in tasks.items():
            task()
            start = time.perf_counter()
            task()
            once = time.perf_counter() - start
            counts[name] = max(1, int(np.ceil(_LEAST_SECONDS / once)))
        times: dict[str, list[float]] = {name: [] for name in tasks}
        gc.collect()
        gc.disable()
        try:
            for _ in range(repeats):
                for name, task in tasks.items():
                    start = clock()
                    for _ in range(counts[name]):
                        task()
                    times[name].append((clock() - start) / counts[name])
        finally:
            gc.enable()
    return times


def measurement(
    name: str,
    task: list[float],
    yardstick: str,
    yardstick_readings: list[float],
    target: float | None = None,
) -> Measurement:
    """Compare the readings of a task with those of its yardstick."""
    ratios = [a / b for a, b in zip(task, yardstick_readings, strict=True)]
    return Measurement(
        name,
        statistics.median(task),
        yardstick,
        statistics.median(yardstick_readings),
        statistics.median(ratios),
        target,
    )


def in_turns(
    tasks: Mapping[str, Callable[[], object]],
    yardstick: str,
    unit: Callable[[], object],
    repeats: int,
    target: float | None = None,
) -> list[Measurement]:
    """Time tasks and their yardstick in turns; return a row for each task."""
    times = interleaved({"": unit, **tasks}, repeats)
    return [measurement(name, times[name], yardstick, times[""], target) for name in tasks]


def growth(
    rows: Mapping[int, Measurement],
    size: str,
    law: tuple[str, Callable[[np.ndarray], np.ndarray]],
    target: float | None = None,
) -> Measurement:
    """Compare the growth of a cost with its size with that of a law, by fitted powers.

    >>> rows = {n: Measurement("", 1e-9 * n**2, "") for n in (100, 200, 400)}
    >>> row = growth(rows, "unknowns", ("N^2", lambda n: n**2.0))
    >>> row.name, round(row.ratio, 12)
    ('exponent of the cost in unknowns from 100 to 400: 2.00', 1.0)
    """
    sizes, seconds = np.array(list(rows)), np.array([row.seconds for row in rows.values()])
    found, bound = (np.polyfit(np.log(sizes), np.log(y), 1)[0] for y in (seconds, law[1](sizes)))
    ratio = float((sizes[-1] / sizes[0]) ** (found - bound))
    return Measurement(
        f"exponent of the cost in {size} from {sizes[0]} to {sizes[-1]}: {found:.2f}",
        float(seconds[-1]),
        f"{law[0]} from the same start ({bound:.2f})",
        float(seconds[-1] / ratio),
        ratio,
        target,
    )


def vector_features() -> str:
    """Return the vector units that NumPy uses, on which the speed of sorting depends."""
    units = np.show_config(mode="dicts").get("SIMD Extensions", {})
    used = [*units.get("baseline", ()), *units.get("found", ())]
    return f"{', '.join(used) or 'none'} (NumPy {np.__version__})"
