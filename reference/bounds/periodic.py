r"""Energy and penetration of a periodic rough contact between proved bounds.

At a mean pressure P the elastic energy and the work against the gap g are together as small as any
pressure of that mean, nowhere negative, makes them,

    Pi(P) = min <p, K p>/2 + <p, g>  = int d dF,        dPi/dP = A0 d,        U = A0 P d - Pi,

with the penetration d of the rigid surface against the mean plane of the half-space, counted from
the surface's highest sample. *Above*: the energy of any pressure uniform on the grid's cells, with
all its aliases. *Below*: for any displacement v of mean zero

    Pi >= -<v, K^-1 v>/2 + P A0 min (v + g)

(Fenchel's inequality, as <p, v + g> >= P A0 min (v + g)). So <v, K^-1 v>/2 is not below the energy
U stored at the penetration min (v + g), which is convex with the slope A0 P. Here v is a
trigonometric polynomial, so its energy is a sum over modes, and its minimum is bounded everywhere
(`least_on_cells`). The polynomial comes from a body that is raised wherever it would fall short, so
that little is lost to the minimum.
"""

import math

import numpy as np
from scipy import fft as transforms

from reference.arrays import Array
from reference.bounds.interval import EPSILON, Interval, above, below, inverse
from reference.bounds.trigonometric import Waves, least_on_cells, levelled, transform_rounding
from reference.contact.press import press
from reference.errors import count_faults, positive_faults, refuse
from reference.halfspace import Contact, PeriodicOperator
from reference.halfspace.kernels import cell_energies, wavenumbers
from reference.loads import Load

_ROUNDS = 4
# Rounding of a sum of squares over all modes, added up by halves, of the few products in each.
_SUM = 512
# Steps of the mean pressure, relative to it, of the penetration's two difference quotients: their
# errors, both of second order, against the width of the energies over the step.
_STEPS = 0.1, 0.12
# The same of the second differences, from the width of the energies: (10 w)^(1/3), at most.
_BEND, _LARGEST = 10.0, 0.45
# Roughly the power of the mean pressure with which the penetration grows.
_POWER = 0.5


class PeriodicSurface:
    """A band-limited periodic surface over a half-space, on cells some times finer along a side.

    It is the trigonometric polynomial through heights (n, m), which grow towards the half-space.
    Whatever takes no modulus is for E* = 1.
    """

    def __init__(self, heights: Array, size: tuple[float, float], finer: int = 4) -> None:
        heights = levelled(heights)
        # at least two: a wave of two cells is none of the polynomials below
        refuse(positive_faults(length=size[0], width=size[1]) + count_faults(2, finer=finer))
        self.waves = Waves(heights, size)
        self.grid = (finer * heights.shape[0], finer * heights.shape[1])
        self.spacing = (size[0] / self.grid[0], size[1] / self.grid[1])
        self.area = size[0] * size[1]
        self.top = self.waves.highest()[0]
        self.gap = self.top - self.waves.at(self.grid, (0.0, 0.0))
        self.operator = PeriodicOperator(self.grid, self.spacing, 1.0)

    def energy(self, mean_pressure: float, effective_modulus: float) -> Interval:
        """Pi at a mean pressure, per area."""
        refuse(positive_faults(mean_pressure=mean_pressure, effective_modulus=effective_modulus))
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
        refuse(positive_faults(mean_pressure=mean_pressure, effective_modulus=effective_modulus))
        P = mean_pressure / effective_modulus
        return Interval(self._not_below(P), self._not_above(P))

    def mean_pressure(self, penetration: float, effective_modulus: float) -> Interval:
        """Mean pressure at a penetration, which grows with it."""
        refuse(positive_faults(penetration=penetration, effective_modulus=effective_modulus))

        def on_grid(P: float) -> float:
            return float(self.on_grid(P).penetration)

        start = penetration / max(self.spacing[0] * self.grid[0], self.spacing[1] * self.grid[1])
        near = inverse(penetration, on_grid, on_grid, start, _POWER).middle
        sides = self._not_below, self._not_above
        return effective_modulus * inverse(penetration, *sides, near, _POWER)

    def stored(
        self, mean_pressure: Interval, penetration: Interval, effective_modulus: float
    ) -> Interval:
        """Energy U per area where both are enclosed, one of them given exactly or both.

        It is the largest of P d - Pi(P) over all P, and at d not above that at another penetration
        less P times what that lies deeper.
        """
        P = Interval(*(x / effective_modulus for x in (mean_pressure.lower, mean_pressure.upper)))
        least, most = self._dual(P.middle)
        ahead = max(P.lower * (penetration.upper - least), P.upper * (penetration.upper - least))
        work = below(P.middle * penetration.lower, 2)
        lower = max(work - self._above(P.middle), 0.0)
        return effective_modulus * Interval(below(lower, 4), above(most + above(ahead, 4), 4))

    def stiffness(self, mean_pressure: Interval, effective_modulus: float) -> Interval:
        """Stiffness dP/dd per area at a mean pressure that is enclosed itself.

        It grows with the pressure. As the penetration d = Pi' is concave, and -s without a load, of
        a surface that rises s above its samples, Pi''(P) is not above (d + s)/P, nor what second
        differences of Pi make it over [P - 2 h, P], and not below these over [P, P + 2 h].
        ArithmeticError if a second difference is left within the width of Pi, or the pressure is
        not proved to be positive.
        """
        light, heavy = (x / effective_modulus for x in (mean_pressure.lower, mean_pressure.upper))
        if not light > 0:
            raise ArithmeticError(f"no stiffness is proved at a pressure from {light:.4g} E* on")
        ends = self._below(light), self._above(light)
        # a chord's excess grows with the step, and what the width of Pi makes of it falls twice
        share = ((ends[1] - ends[0]) / ends[1] * _BEND) ** (1 / 3)
        steps = min(share, _LARGEST) * light, share * heavy
        behind = self._above(light - 2 * steps[0]) - 2 * self._below(light - steps[0]) + ends[1]
        ahead = self._below(heavy) - 2 * self._above(heavy + steps[1])
        ahead += self._below(heavy + 2 * steps[1])
        loss = 16 * EPSILON * abs(self._above(heavy + 2 * steps[1]))
        started = self.waves.highest()[1] - self.top
        softest = min((behind + loss) / steps[0] ** 2, (self._not_above(light) + started) / light)
        stiffest = (ahead - loss) / steps[1] ** 2
        if not 0 < stiffest <= softest:
            raise ArithmeticError(f"no stiffness is proved at a pressure of {heavy:.4g} E*")
        return effective_modulus * Interval(below(1 / softest, 8), above(1 / stiffest, 8))

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

    def on_grid(self, P: float, raised: Array | float = 0.0) -> Contact:
        """Return the contact of the grid's points with the body raised, which proves nothing."""
        gap = self.gap - raised
        return press(self.operator, gap - gap.min(), Load("force", P * self.area))

    def _above(self, P: float) -> float:
        """Upper bound of Pi per area, by the pressure under the grid's points."""
        contact = self.on_grid(P)
        return self.energy_of(contact.pressure * (P / contact.pressure.mean()))

    def energy_of(self, pressure: Array) -> float:
        """Upper bound of Pi per area that a pressure on the cells proves, nowhere negative."""
        if not (pressure >= 0).all():
            least = float(pressure.min())
            raise ValueError(f"pressure must be at least 0 everywhere, not {least!r}")
        transfer, remainder = cell_energies(self.grid, self.spacing, 1.0)
        modes = transforms.rfft2(pressure, norm="forward")
        square = np.abs(modes) ** 2 * _both_signs(self.grid)
        stored = 0.5 * ((transfer + remainder) * square).sum()
        # means of the heights over the cells: every wave times two sincs
        qx, qy = wavenumbers(self.grid, self.spacing)
        modes = transforms.rfft2(self.top - self.gap)
        modes *= np.sinc(qx * self.spacing[0] / (2 * np.pi))
        modes *= np.sinc(qy * self.spacing[1] / (2 * np.pi))
        work = (pressure * (self.top - transforms.irfft2(modes, self.grid))).mean()
        # transforms err in the root mean square, relative to that of what they transform: what the
        # energy makes of it by Cauchy and Schwarz, and the work, of two transforms of the heights
        noise = 1.1 * transform_rounding(*self.grid) + _SUM * EPSILON
        size, lift = (float(np.sqrt((field**2).mean())) for field in (pressure, self.gap))
        amiss = noise * size * math.sqrt(0.5 * float((transfer + remainder).max()))
        stored = (math.sqrt(stored * (1 + _SUM * EPSILON)) + amiss) ** 2
        return float(stored + work + 4 * noise * size * (lift + abs(self.top)))

    def _below(self, P: float) -> float:
        """Lower bound of Pi per area: Fenchel's."""
        least, stored = self._dual(P)
        return below(P * least, 2) - above(stored, 4)

    def _dual(self, P: float) -> tuple[float, float]:
        """Least sum with the gap (from below) and energy (from above) of what proves most at P."""
        heights = transforms.rfft2(self.top - self.gap, norm="forward")
        wave = np.hypot(*wavenumbers(self.grid, self.spacing))
        rounding = 4 * self.waves.rounding_on(self.grid)
        raised = np.zeros(self.grid)
        best, most = (0.0, 0.0), -math.inf
        for _ in range(_ROUNDS):
            # the displacement v under a raised body, without its mean and waves of two cells
            contact = self.on_grid(P, raised)
            modes = transforms.rfft2(contact.displacement, norm="forward")
            modes[0, 0] = 0.0
            if self.grid[0] % 2 == 0:
                modes[self.grid[0] // 2] = 0.0
            if self.grid[1] % 2 == 0:
                modes[:, self.grid[1] // 2] = 0.0
            # v + g is bounded sharply where it lies below its mean under the pressure
            total = modes - heights
            field = transforms.irfft2(total, self.grid, norm="forward")
            ceiling = _mean_under(contact.pressure, field)
            least = self.top + least_on_cells(total, self.spacing, self.grid, ceiling)
            least = least - rounding - 4 * EPSILON * abs(self.top)
            stored = float(0.25 * (wave * np.abs(modes) ** 2 * _both_signs(self.grid)).sum())
            stored *= 1 + _SUM * EPSILON
            if P * least.min() - stored > most:
                best, most = (float(least.min()), stored), P * least.min() - stored
            # raised where the sum is least, by how much it lies below its mean under the pressure
            raised += np.maximum(_mean_under(contact.pressure, least) - least, 0.0)
        return best


def _mean_under(pressure: Array, field: Array) -> float:
    """Mean of a field, weighted with a pressure."""
    return float((field * pressure).sum() / pressure.sum())


def _both_signs(grid: tuple[int, int]) -> Array:
    """How often the modes of a real transform count."""
    weights = np.full(grid[1] // 2 + 1, 2.0)
    weights[0] = 1.0
    if grid[1] % 2 == 0:
        weights[-1] = 1.0
    return weights
