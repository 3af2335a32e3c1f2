"""What a plan says, as it is kept with the results: methods, what was left out, what is known."""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import pi
from statistics import median

from comparisons.reasons import CHECK, STRAINED, THICKENED


@dataclass(frozen=True)
class MethodPlan:
    """The plan of one method for a scene, or the reason for a refusal."""

    method: str
    supported: bool
    reason: str
    resolutions: tuple[int, ...] = ()
    modelled: str = ""
    # Surfaces or lines at each resolution, not increasing; empty: `Plan.realisations`.
    numbers: tuple[int, ...] = ()
    title: str = ""  # what the method is called on this scene; "": as everywhere
    dimension: int | None = None  # of a method from outside

    def finer(self, resolution: int) -> MethodPlan:
        """Return it with one more resolution, on as many surfaces as the finest one so far."""
        numbers = (*self.numbers, self.numbers[-1]) if self.numbers else ()
        return replace(self, resolutions=(*self.resolutions, resolution), numbers=numbers)


@dataclass(frozen=True)
class Measured:
    """A measured curve in SI units, the modulus that the scene states, and whether zero moves."""

    penetration: tuple[float, ...]
    force: tuple[float, ...]
    modulus: float
    fit_zero: bool

    def __post_init__(self) -> None:
        if len(self.penetration) != len(self.force) or not self.modulus > 0:
            raise ValueError("expected as many forces as penetrations, and a positive modulus")


@dataclass(frozen=True)
class Roughness:
    """Spectrum C2D(q) and statistics of a surface in SI units; skewness and kurtosis of maps.

    `area` is the apparent one, A0.
    """

    wavenumber: tuple[float, ...]
    density: tuple[float, ...]
    rms_height: float
    rms_slope: float
    rms_curvature: float
    nayak: float
    skewness: float | None = None
    kurtosis: float | None = None
    area: float | None = None

    def __post_init__(self) -> None:
        pairs = len(self.wavenumber) == len(self.density)
        if not pairs or min(*self.wavenumber, *self.density, self.rms_curvature) <= 0:
            raise ValueError("expected pairs of a wavenumber and a density, all positive")

    @property
    def noise_wavelength(self) -> float:
        """The wavelength below which the spectrum is flat, as that of white noise is; else 0.

        Over the last octave that of a surface, q^(-2 - 2H), falls to a quarter or less: flat is
        what falls to no less than half, by the medians of the octave's first and last third.
        """
        rings = list(zip(self.wavenumber, self.density, strict=True))
        octave = [density for q, density in rings if q > self.wavenumber[-1] / 2]
        third = len(octave) // 3
        if third < 2 or median(octave[:third]) > 2 ** (2 / 3) * median(octave[-third:]):
            return 0.0
        floor = median(octave)
        low = [density <= 2 * floor for _, density in rings]
        flat = next((k for k in range(len(rings) - 1) if low[k] and low[k + 1]), 0)
        return 2 * pi / self.wavenumber[flat] if flat else 0.0


@dataclass(frozen=True, kw_only=True)
class PlanRecord:
    """What a plan says: kept with the results."""

    methods: tuple[MethodPlan, ...] = ()
    left_out: tuple[tuple[str, str], ...] = ()  # effects that are not modelled, with the reason
    notes: tuple[str, ...] = ()
    switched_on: tuple[tuple[str, str], ...] = ()  # physics, with its model
    measured: Measured | None = None
    roughness: Roughness | None = None  # of a rough surface, where its results are recorded

    @property
    def doubts(self) -> list[str]:
        """The notes that question the scene (units, slopes, strains, oil): to be seen first."""
        return [note for note in self.notes if note.startswith((CHECK, STRAINED, THICKENED))]
