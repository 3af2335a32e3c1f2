"""What a plan says, as it is kept with the results: methods, what was left out, what is known."""

from __future__ import annotations

from dataclasses import dataclass, replace


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


@dataclass(frozen=True, kw_only=True)
class PlanRecord:
    """What a plan says: kept with the results."""

    methods: tuple[MethodPlan, ...] = ()
    left_out: tuple[tuple[str, str], ...] = ()  # effects that are not modelled, with the reason
    notes: tuple[str, ...] = ()
    switched_on: tuple[tuple[str, str], ...] = ()  # physics, with its model
    measured: Measured | None = None
    roughness: Roughness | None = None  # of a rough surface, where its results are recorded
