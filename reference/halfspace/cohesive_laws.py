"""Tension between two surfaces as a function of the gap between them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reference.arguments import positive_faults, refuse

Field = NDArray[np.float64]


@dataclass(frozen=True)
class CohesiveLaw:
    """Non-increasing tension sigma(h) >= 0 at gaps h >= 0; at h = 0 the surfaces are hard.

    Attributes
    ----------
    name : str
    work : float
        Work of adhesion w, the integral of the tension over all gaps.
    strength : float
        sigma(0), the largest tension.
    reach : float
        w/sigma(0), the range.
    tension, softening, energy : callable
        sigma(h), -sigma'(h) >= 0 and the integral of sigma from h to infinity, on arrays.
    """

    name: str
    work: float
    strength: float
    reach: float
    tension: Callable[[Field], Field]
    softening: Callable[[Field], Field]
    energy: Callable[[Field], Field]

    def weakened(self, share: float) -> CohesiveLaw:
        """Return the law with all tensions scaled by a factor, and the same range."""
        return replace(
            self,
            work=share * self.work,
            strength=share * self.strength,
            tension=lambda h: share * self.tension(h),
            softening=lambda h: share * self.softening(h),
            energy=lambda h: share * self.energy(h),
        )


def exponential(work: float, reach: float) -> CohesiveLaw:
    """Return the smooth law sigma = (w/rho) exp(-h/rho) (Rey, Anciaux & Molinari 2017).

    Examples
    --------
    >>> law = exponential(2.0, 0.5)
    >>> float(law.tension(np.array(0.0)))
    4.0
    """
    refuse(positive_faults(work=work, reach=reach))
    strength = work / reach

    def tension(h: Field) -> Field:
        return strength * np.exp(-h / reach)

    return CohesiveLaw(
        name="exponential",
        work=work,
        strength=strength,
        reach=reach,
        tension=tension,
        softening=lambda h: tension(h) / reach,
        energy=lambda h: tension(h) * reach,
    )


def dugdale(work: float, strength: float, ramp: float = 0.3) -> CohesiveLaw:
    """Return Maugis' law, sigma0 up to the gap w/sigma0, with a ramp instead of the step.

    The tension decreases from sigma0 at (1 - ramp) w/sigma0 to zero at (1 + ramp) w/sigma0, as a
    cubic with zero end slopes: the same work of adhesion, and a continuous slope for Newton's
    method.

    Parameters
    ----------
    work, strength : float
        w and sigma0.
    ramp : float
        Relative half-width of the ramp, in (0, 1].
    """
    refuse(positive_faults(work=work, strength=strength, ramp=ramp))
    if ramp > 1:
        raise ValueError(f"ramp must be at most 1, not {ramp!r}")
    reach = work / strength
    low, high = (1 - ramp) * reach, (1 + ramp) * reach

    def tension(h: Field) -> Field:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return strength * t * t * (3 - 2 * t)

    def softening(h: Field) -> Field:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return 6 * strength / (high - low) * t * (1 - t)

    def energy(h: Field) -> Field:
        t = np.clip((high - h) / (high - low), 0.0, 1.0)
        return strength * ((high - low) * t**3 * (1 - t / 2) + np.maximum(low - h, 0.0))

    return CohesiveLaw("dugdale", work, strength, reach, tension, softening, energy)
