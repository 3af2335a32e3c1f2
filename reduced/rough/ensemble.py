"""Many realisations of a rough line: statistics by load, reproducible and in bounded memory."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, fields

import numpy as np

from reduced.arguments import count_faults, refuse
from reduced.rough.line_spectrum import LineSpectrum, synthesise
from reduced.rough.press import LineContact, press

QUANTITIES = tuple(each.name for each in fields(LineContact))
_MEMORY = 2**26  # bytes of lines that one worker holds at a time


@dataclass(frozen=True)
class Statistics:
    """Statistics of one quantity over the realisations, by load.

    Attributes
    ----------
    mean, standard_error : ndarray, shape (k,)
        Mean, and its standard error s/sqrt(m) (0 for a single realisation, which has none).
    quantiles : ndarray, shape (levels, k)
        Quantiles at `Ensemble.levels`.
    """

    mean: np.ndarray
    standard_error: np.ndarray
    quantiles: np.ndarray


@dataclass(frozen=True)
class Ensemble:
    """Load curves of all realisations; ``ensemble["contact_area"]`` are their statistics.

    Attributes
    ----------
    samples : dict of str to ndarray, shape (m, k)
        Every realisation's curve of every quantity asked for; fields of `press.LineContact`.
    levels : ndarray
        Levels of the quantiles.
    """

    samples: dict[str, np.ndarray]
    levels: np.ndarray

    def __getitem__(self, quantity: str) -> Statistics:
        values = self.samples[quantity].astype(float)
        count = values.shape[0]
        error = (
            values.std(axis=0, ddof=1) / np.sqrt(count) if count > 1 else np.zeros(len(values.T))
        )
        return Statistics(values.mean(axis=0), error, np.quantile(values, self.levels, axis=0))


def stream(seed: int, line: int) -> np.random.Generator:
    """Random stream of line k: one child of the seed per line, whoever asks and in what order."""
    return np.random.default_rng(np.random.SeedSequence(seed, spawn_key=(1, line)))


def lines(
    spectrum: LineSpectrum,
    points: int,
    realisations: Sequence[int],
    *,
    seed: int = 0,
    length: float | None = None,
) -> np.ndarray:
    """Realisations of a rough line by number, shape (len(realisations), points)."""
    return np.stack(
        [synthesise(spectrum, points, stream(seed, k), length=length) for k in realisations]
    )


def press_ensemble(
    spectrum: LineSpectrum,
    points: int,
    realisations: int,
    effective_modulus: float,
    *,
    force: Sequence[float] | np.ndarray | None = None,
    penetration: Sequence[float] | np.ndarray | None = None,
    mean_gap: Sequence[float] | np.ndarray | None = None,
    length: float | None = None,
    seed: int = 0,
    edges: str = "sub_cell",
    quantities: Sequence[str] = QUANTITIES,
    levels: Sequence[float] = (0.05, 0.25, 0.5, 0.75, 0.95),
    workers: int = 1,
) -> Ensemble:
    """Press many realisations of a rough line.

    Lines are made and pressed in blocks of at most 64 MiB per worker; what grows with the number of
    realisations are the curves asked for, 8 bytes a number. Each line has its own child of the
    seed, so line k is the same line in every ensemble, and nothing depends on workers or blocks.

    Parameters
    ----------
    spectrum : LineSpectrum
        Amplitudes, see `line_spectrum`.
    points : int
        Points of each line.
    realisations : int
        Number of lines m, >= 1.
    effective_modulus, force, penetration, mean_gap, edges
        As for `rough.press.press`; lines are periodic.
    length : float, optional
        Period of the lines, the spectrum's own without it.
    seed : int
        Seed of the ensemble; line k draws from ``SeedSequence(seed, spawn_key=(1, k))``.
    quantities : sequence of str
        Fields of `press.LineContact` to keep.
    levels : sequence of float
        Levels of the quantiles, in [0, 1].
    workers : int
        Threads.

    Returns
    -------
    Ensemble

    Raises
    ------
    ValueError
        If an argument is out of range.
    ConvergenceError
        If a load could not be inverted.

    Examples
    --------
    >>> from reduced.rough.line_spectrum import prescribed
    >>> line = prescribed(64, 1.0, hurst=0.8, rms_slope=0.1)
    >>> found = press_ensemble(line, 256, 20, 1.0, force=[1e-4, 1e-3], quantities=["contact_area"])
    >>> found["contact_area"].mean.shape, found["contact_area"].quantiles.shape
    ((2,), (5, 2))
    """
    _check(realisations, quantities, levels, workers)
    period = spectrum.length if length is None else length
    loads = {"force": force, "penetration": penetration, "mean_gap": mean_gap}

    def press_block(block: range) -> dict[str, np.ndarray]:
        heights = lines(spectrum, points, block, seed=seed, length=length)
        contact = press(heights, period / points, effective_modulus, edges=edges, **loads)
        return {name: getattr(contact, name) for name in quantities}

    blocks = list(_blocks(realisations, max(1, _MEMORY // (8 * points))))
    if workers == 1:
        parts = [press_block(block) for block in blocks]
    else:
        # More blocks than workers need: results do not depend on how lines are grouped.
        blocks = list(_blocks(realisations, min(len(blocks[0]), -(-realisations // workers))))
        with ThreadPoolExecutor(workers) as pool:
            parts = list(pool.map(press_block, blocks))
    samples = {name: np.concatenate([part[name] for part in parts]) for name in quantities}
    return Ensemble(samples, np.asarray(levels, dtype=float))


def _blocks(count: int, size: int) -> Iterator[range]:
    for begin in range(0, count, size):
        yield range(begin, min(begin + size, count))


def _check(
    realisations: int, quantities: Sequence[str], levels: Sequence[float], workers: int
) -> None:
    """Raise one ValueError for everything wrong."""
    wrong = count_faults(realisations=realisations, workers=workers)
    unknown = [name for name in quantities if name not in QUANTITIES]
    if unknown:
        wrong.append(f"quantities must be among {', '.join(QUANTITIES)}, got {', '.join(unknown)}")
    if not all(0 <= level <= 1 for level in levels):
        wrong.append(f"levels must be in [0, 1], got {levels!r}")
    refuse(wrong)
