r"""Energy and penetration of a periodic rough contact between proved bounds.

At a mean pressure P the elastic energy and the work against the gap g are together as small as any
pressure of that mean, nowhere negative, makes them,

    Pi(P) = min <p, K p>/2 + <p, g>  = int d dF,        dPi/dP = A0 d,

with the penetration d of the rigid surface against the mean plane of the half-space, counted from
the surface's highest sample. *Above*: the energy of any pressure uniform on the grid's cells, with
all its aliases. *Below*: for any displacement v of mean zero

    Pi >= -<v, K^-1 v>/2 + P A0 min (v + g)

(Fenchel's inequality, as <p, v + g> >= P A0 min (v + g)). Here v is a trigonometric polynomial, so
its energy is a sum over modes, and its minimum is bounded everywhere (`least_on_cells`). The
polynomial comes from a body that is raised wherever it would fall short, so that little is lost to
the minimum.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy import fft as transforms

from reference.arguments import count_faults, positive_faults, refuse
from reference.bounds.heights import Waves, levelled
from reference.bounds.interval import EPSILON, Interval, above, below
from reference.bounds.inverse import inverse
from reference.bounds.polynomials import least_on_cells
from reference.halfspace import Contact, PeriodicOperator, fft
from reference.halfspace.kernels import cell_energies, wavenumbers
from reference.halfspace.solution import Press
from reference.loads import Load

Array = NDArray[np.float64]

_ROUNDS = 4
# Steps of the mean pressure, relative to it, of the penetration's two difference quotients: their
# errors, both of second order, against the width of the energies over the step.
_STEPS = 0.1, 0.12
# Roughly the power of the mean pressure with which the penetration grows.
_POWER = 0.5


class PeriodicSurface:
    """A band-limited periodic surface over a half-space with E* = 1, its cells n x m times finer.

    Parameters
    ----------
    heights : (n, m)
        Growing towards the half-space; the surface is the trigonometric polynomial through them.
    size : (float, float)
    finer : int
        Cells per point along a side.

    Raises
    ------
    ValueError
        Listing what is wrong.
    """

    def __init__(self, heights: Array, size: tuple[float, float], finer: int = 4) -> None:
        heights = levelled(heights)
        refuse(positive_faults(length=size[0], width=size[1]) + count_faults(1, finer=finer))
        self.waves = Waves(heights, size)
        self.grid = (finer * heights.shape[0], finer * heights.shape[1])
        self.spacing = (size[0] / self.grid[0], size[1] / self.grid[1])
        self.area = size[0] * size[1]
        self.top = self.waves.highest()[0]
        self.gap = self.top - self.waves.at(self.grid, (0.0, 0.0))
        self.operator = PeriodicOperator(self.grid, self.spacing, 1.0)

    def energy(self, mean_pressure: float, effective_modulus: float) -> Interval:
        """Pi at a mean pressure, per area.

        Raises
        ------
        ValueError
            For a pressure or modulus that is not positive and finite.
        """
        _check(mean_pressure, effective_modulus)
        P = mean_pressure / effective_modulus
        return effective_modulus * Interval(self._below(P), self._above(P))

    def penetration(self, mean_pressure: float, effective_modulus: float) -> Interval:
        """Penetration at a mean pressure.

        It grows with the pressure, and so does the contact area (Barber 1974) and with it the
        stiffness; so the penetration d is concave. It is not below its mean over [P - h, P + h],
        and not above what its means M1 over [P, P + h] and M2 over [P + h, P + 2 h] extrapolate,
        (3 M1 - M2)/2: that holds for constants and for min(P, c) with any c, of which all growing
        concave functions consist. The means are difference quotients of Pi.
        """
        _check(mean_pressure, effective_modulus)
        P = mean_pressure / effective_modulus
        return Interval(self._not_below(P), self._not_above(P))

    def mean_pressure(self, penetration: float, effective_modulus: float) -> Interval:
        """Mean pressure at a penetration, which grows with it.

        Raises
        ------
        ValueError
            For a penetration or modulus that is not positive and finite.
        """
        refuse(positive_faults(penetration=penetration, effective_modulus=effective_modulus))

        def on_grid(P: float) -> float:
            return float(self.on_grid(P).penetration)

        start = penetration / max(self.spacing[0] * self.grid[0], self.spacing[1] * self.grid[1])
        near = inverse(penetration, on_grid, on_grid, start, _POWER).middle
        sides = self._not_below, self._not_above
        return effective_modulus * inverse(penetration, *sides, near, _POWER)

    def _not_below(self, P: float) -> float:
        less, more = P * (1 - _STEPS[0]), P * (1 + _STEPS[0])
        under, over = self._below(more), self._above(less)
        # differences of near numbers: rounded as those are, not as what is left of them
        loss = EPSILON * (abs(under) + abs(over)) / (more - less)
        return below((under - over) / (more - less), 8) - 8 * loss

    def _not_above(self, P: float) -> float:
        step = _STEPS[1] * P
        at_once, beyond = self._below(P), self._below(P + 2 * step)
        ahead = self._above(P + step)
        gain = EPSILON * (2 * abs(ahead) + 1.5 * abs(at_once) + 0.5 * abs(beyond)) / step
        return above((2 * ahead - 1.5 * at_once - 0.5 * beyond) / step, 8) + 8 * gain

    def _press(self, gap: Array) -> Press:
        return Press(self.operator, gap - gap.min())

    def on_grid(self, P: float) -> Contact:
        """Return the contact of the grid's points, which proves nothing."""
        return fft.solve(self._press(self.gap), Load("force", P * self.area))

    def _above(self, P: float) -> float:
        """Energy of a pressure on cells, per area."""
        contact = self.on_grid(P)
        pressure = contact.pressure * (P / contact.pressure.mean())
        return self.energy_of(pressure)

    def energy_of(self, pressure: Array) -> float:
        """Upper bound of Pi that a pressure on the cells proves, per area.

        Raises
        ------
        ValueError
            For a pressure that is negative anywhere.
        """
        if not (pressure >= 0).all():
            raise ValueError(f"a contact nowhere pulls; the least pressure is {pressure.min()}")
        transfer, remainder = cell_energies(self.grid, self.spacing, 1.0)
        modes = transforms.rfft2(pressure, norm="forward")
        square = np.abs(modes) ** 2 * _both_signs(self.grid)
        stored = 0.5 * ((transfer + remainder) * square).sum()
        work = (pressure * (self.top - self._cell_means())).mean()
        # transforms err in the mean of squares, relative to that of what they transform
        noise = 64 * EPSILON * math.log2(2 * pressure.size)
        sizes = (float(np.sqrt((field**2).mean())) for field in (pressure, self.gap))
        return float(stored * (1 + noise) + work + noise * math.prod(sizes))

    def _cell_means(self) -> Array:
        """Means of the heights over the cells: every wave times two sincs."""
        qx, qy = wavenumbers(self.grid, self.spacing)
        modes = transforms.rfft2(self.top - self.gap)
        modes *= np.sinc(qx * self.spacing[0] / (2 * np.pi))
        modes *= np.sinc(qy * self.spacing[1] / (2 * np.pi))
        return transforms.irfft2(modes, self.grid)

    def _below(self, P: float) -> float:
        """Bound from below by the displacement under a body that is raised where it fell short."""
        raised = np.zeros(self.grid)
        best = -math.inf
        for _ in range(_ROUNDS):
            gap = self.gap - raised
            contact = fft.solve(self._press(gap), Load("force", P * self.area))
            modes = transforms.rfft2(contact.displacement, norm="forward")
            least = self.least_sum(modes, contact.pressure)
            best = max(best, self.bound_of(modes, float(least.min()), P))
            # where the sum is least, and by how much below its mean under the pressure
            raised += np.maximum(_mean_under(contact.pressure, least) - least, 0.0)
        return best

    def bound_of(self, modes: NDArray[np.complex128], least: float, P: float) -> float:
        """Lower bound of Pi per area, of a displacement whose sum with the gap is nowhere less."""
        wave = np.hypot(*wavenumbers(self.grid, self.spacing))
        stored = 0.25 * (wave * np.abs(modes) ** 2 * _both_signs(self.grid)).sum()
        noise = 64 * EPSILON * math.log2(2 * self.grid[0] * self.grid[1])
        return float(P * least - stored * (1 + noise) - noise * P * np.ptp(self.gap))

    def least_sum(self, modes: NDArray[np.complex128], pressure: Array) -> Array:
        """Lower bound of v + g on each cell, v the polynomial with the given modes.

        The modes at half the sampling frequency must be zero; they are set to zero here. The bound
        is sharp where v + g lies below its mean under a pressure.
        """
        _drop_half(modes, self.grid)
        total = modes - transforms.rfft2(self.top - self.gap, norm="forward")
        ceiling = _mean_under(pressure, transforms.irfft2(total, self.grid, norm="forward"))
        least = least_on_cells(total, self.spacing, self.grid, ceiling)
        return self.top + least - 4 * self.waves.rounding - 4 * EPSILON * abs(self.top)


def _mean_under(pressure: Array, field: Array) -> float:
    return float((field * pressure).sum() / pressure.sum())


def _drop_half(modes: NDArray[np.complex128], grid: tuple[int, int]) -> None:
    if grid[0] % 2 == 0:
        modes[grid[0] // 2] = 0.0
    if grid[1] % 2 == 0:
        modes[:, grid[1] // 2] = 0.0
    modes[0, 0] = 0.0


def _both_signs(grid: tuple[int, int]) -> Array:
    """How often the modes of a real transform count."""
    weights = np.full(grid[1] // 2 + 1, 2.0)
    weights[0] = 1.0
    if grid[1] % 2 == 0:
        weights[-1] = 1.0
    return weights


def _check(mean_pressure: float, effective_modulus: float) -> None:
    if not all(x > 0 and math.isfinite(x) for x in (mean_pressure, effective_modulus)):
        raise ValueError(
            "mean pressure and modulus must be positive and finite, got "
            f"{mean_pressure!r} and {effective_modulus!r}"
        )
