"""Ensembles of rough lines: statistics by load, reproducible and with bounded memory."""

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, fields

import numpy as np

from reduced.errors import count_faults, refuse
from reduced.loads import Load
from reduced.rough.line_spectrum import LineSpectrum, synthesise
from reduced.rough.press import LineContact, RoughLines, press

QUANTITIES = tuple(field.name for field in fields(LineContact))

_MEMORY = 2**26  # bytes of lines that are pressed at once


@dataclass(frozen=True)
class Statistics:
    """Mean of one quantity over m realisations by load (k,); its error s/sqrt(m), 0 for one."""

    mean: np.ndarray
    standard_error: np.ndarray


@dataclass(frozen=True)
class Ensemble:
    """Load curves of all realisations by quantity, (m, k).

    Statistics are ``ensemble["contact_area"]``.
    """

    samples: dict[str, np.ndarray]

    def __getitem__(self, quantity: str) -> Statistics:
        values = self.samples[quantity].astype(float)
        count = values.shape[0]
        error = (
            values.std(axis=0, ddof=1) / np.sqrt(count) if count > 1 else np.zeros(len(values.T))
        )
        return Statistics(values.mean(axis=0), error)


def stream(seed: int, line: int) -> np.random.Generator:
    """Return the random stream of line k: ``SeedSequence(seed, spawn_key=(1, k))``."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1, line)))


@dataclass(frozen=True)
class RandomLines:
    """Numbered realisations of a rough line, the same in every ensemble and any order.

    `length` is the period, by default that of the spectrum.
    """

    spectrum: LineSpectrum
    points: int
    count: int
    seed: int = 0
    length: float | None = None

    def __post_init__(self) -> None:
        refuse(count_faults(realisations=self.count))

    def draw(self, numbers: Iterable[int] | None = None) -> RoughLines:
        """Return the periodic lines with these numbers, by default all."""
        chosen = range(self.count) if numbers is None else numbers
        streams = (stream(self.seed, k) for k in chosen)
        heights = synthesise(self.spectrum, self.points, streams, self.length)
        period = self.spectrum.length if self.length is None else self.length
        return RoughLines(heights, period / self.points)


def press_ensemble(
    lines: RandomLines,
    effective_modulus: float,
    load: Load,
    *,
    edges: str = "sub_cell",
    quantities: Sequence[str] = QUANTITIES,
) -> Ensemble:
    """Solve many realisations of a rough line, 64 MiB at once; keep the named fields.

    >>> from reduced.rough.line_spectrum import prescribed
    >>> from reduced.rough.surface_spectrum import SelfAffineLaw
    >>> line = prescribed(64, 1.0, SelfAffineLaw(hurst=0.8, rms_slope=0.1))
    >>> pressed = press_ensemble(RandomLines(line, 256, 20), 1.0, Load("force", [1e-4, 1e-3]))
    >>> pressed["contact_area"].mean.shape
    (2,)
    """
    unknown = [name for name in quantities if name not in QUANTITIES]
    if unknown:
        refuse([f"quantities must be among {', '.join(QUANTITIES)}, got {', '.join(unknown)}"])
    size = max(1, _MEMORY // (8 * lines.points))
    parts: dict[str, list[np.ndarray]] = {name: [] for name in quantities}
    for first in range(0, lines.count, size):
        block = range(first, min(first + size, lines.count))
        contact = press(lines.draw(block), effective_modulus, load, edges=edges)
        for name in quantities:
            parts[name].append(getattr(contact, name))
    return Ensemble({name: np.concatenate(values) for name, values in parts.items()})
