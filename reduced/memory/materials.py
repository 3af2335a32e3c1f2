"""Linear viscoelastic materials in shear, in the common form used by the springs.

Every model of springs and dashpots is a relaxation function

    G(t) = G_inf + sum_i G_i exp(-t/tau_i) + eta delta(t)

(Prony series with a parallel Newtonian dashpot; Ferry 1980, ch. 3; Tschoegl 1989): Kelvin-Voigt
has no arm, Maxwell has one and G_inf = 0, the standard solid one and G_inf > 0. Springs of the
reduced model follow G(t - t') in (19.31) with the factor 4 of (19.30), or 2/(1 - nu).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike
from scipy.optimize import nnls

from reduced.errors import nonnegative_faults, poisson_faults, positive_faults, refuse

_ROUNDING = 1e-12  # fraction of a datum that least squares cannot resolve


@dataclass(frozen=True)
class Creep:
    """Creep compliance J(t) = J_0 + t/eta + sum_i J_i (1 - exp(-t/lambda_i)): strain per stress.

    `instantaneous` is J_0, 0 with a parallel dashpot; `fluidity` 1/eta, 0 for solids; `compliances`
    and `times` (m,) are J_i and retardation times lambda_i, longest first.
    """

    instantaneous: float
    fluidity: float
    compliances: np.ndarray
    times: np.ndarray

    def compliance(self, time: float | np.ndarray) -> np.ndarray:
        """Return J(t) for t >= 0, any shape."""
        t = _times(time)
        delayed = -self.compliances * np.expm1(-t[..., None] / self.times)
        return self.instantaneous + t * self.fluidity + delayed.sum(axis=-1)


@dataclass(frozen=True)
class Prony:
    """Relaxation function G(t) = G_inf + sum_i G_i exp(-t/tau_i) + eta delta(t) in shear.

    Make one with `prony`, `kelvin_voigt`, `standard_solid` or `fit`: arms `moduli`, `times` (m,)
    are positive, distinct, longest first. G_inf = 0 for fluids; `viscosity` is eta.
    """

    long_term: float
    moduli: np.ndarray
    times: np.ndarray
    viscosity: float = 0.0

    @property
    def glassy(self) -> float:
        """G_inf + sum G_i, the modulus of fast loading without the parallel dashpot."""
        return self.long_term + float(self.moduli.sum())

    @property
    def steady_viscosity(self) -> float:
        """Sum of G_i tau_i plus eta: stress per rate of slow flow in addition to G_inf."""
        return float((self.moduli * self.times).sum()) + self.viscosity

    def relaxation(self, time: float | np.ndarray) -> np.ndarray:
        """Return G(t) for t > 0 (without the pulse of the parallel dashpot), any shape."""
        t = _times(time)
        return self.long_term + (self.moduli * np.exp(-t[..., None] / self.times)).sum(axis=-1)

    def complex_modulus(self, frequency: float | np.ndarray) -> np.ndarray:
        """Return G'(w) + i G''(w) = G_inf + sum_i G_i i w tau_i/(1 + i w tau_i) + i w eta.

        >>> complex(kelvin_voigt(2.0, 0.5).complex_modulus(4.0))
        (2+2j)
        """
        w = np.asarray(frequency, dtype=float)
        turns = w[..., None] * self.times
        size = np.hypot(1.0, turns)
        storage = self.long_term + (self.moduli * (turns / size) ** 2).sum(axis=-1)
        loss = (self.moduli * (turns / size) / size).sum(axis=-1) + w * self.viscosity
        return storage + 1j * loss

    def ramp_modulus(self, duration: float) -> float:
        """Return stress over strain after a linear strain from rest, without the parallel dashpot.

        It is the mean of G, exactly: G_inf + sum_i G_i (tau_i/dt) (1 - exp(-dt/tau_i)); of a jump,
        dt = 0, the glassy modulus (Taylor, Pister & Goudreau 1970).

        >>> round(prony(1.0, [2.0], [0.5]).ramp_modulus(1.0), 12)  # 2 - exp(-2)
        1.864664716763
        """
        ratio = _times(duration) / self.times
        safe = np.where(ratio > 0, ratio, 1.0)
        gain = np.where(ratio > 0, -np.expm1(-safe) / safe, 1.0)
        return self.long_term + float((self.moduli * gain).sum())

    def scaled(self, factor: float) -> Prony:
        """Return the material with every modulus and viscosity times a factor > 0."""
        refuse(positive_faults(factor=factor))
        return Prony(
            factor * self.long_term, factor * self.moduli, self.times, factor * self.viscosity
        )

    def creep(self) -> Creep:
        """Return the exact creep function of the material: retardation times and compliances.

        J^(s) = 1/(s Q(s)) with Q(s) = G_inf + sum_i G_i s tau_i/(1 + s tau_i) + eta s. The zeros s
        = -1/lambda of Q are real and interlace with the -1/tau_i (Gross 1953); a solid has one rate
        1/lambda below all 1/tau_i, a parallel dashpot adds one above all; J_i =
        lambda_i/Q'(-1/lambda_i).

        >>> solid = kelvin_voigt(2.0, 1.0).creep()  # J = (1 - exp(-G t/eta))/G
        >>> solid.compliances.tolist(), solid.times.tolist()
        ([0.5], [0.5])
        """
        ends = [*(1 / self.times)]
        slow, fast = self.long_term > 0, self.viscosity > 0
        rates = np.array([self.long_term / self.viscosity] if slow and fast else [])
        if ends:
            # the zeros x of Q(-x), which decreases in every interval between the poles 1/tau_i, by
            # bisection in log x, relative to the end of the interval: no digits are lost to units
            if slow:
                flow = 2 * self.steady_viscosity
                ends.insert(0, 0.5 * min(0.5 * ends[0], self.long_term / flow))
            if fast:
                ends.append(2 * max(2 * ends[-1], 2 * self.glassy / self.viscosity))
            low = np.array(ends[:-1])
            inner, outer = np.zeros(low.size), np.log(np.array(ends[1:]) / low)
            middle = outer / 2
            while ((inner < middle) & (middle < outer)).any():
                rate = low * np.exp(middle)
                turns = rate[:, None] * self.times
                with np.errstate(divide="ignore"):
                    arms = (self.moduli * turns / (turns - 1)).sum(axis=-1)
                above = self.long_term + arms - self.viscosity * rate > 0
                inner, outer = np.where(above, middle, inner), np.where(above, outer, middle)
                middle = (inner + outer) / 2
            rates = low * np.exp(middle)
        spread = 1 - rates[:, None] * self.times
        with np.errstate(divide="ignore"):  # zero on its pole: an arm of negligible weight
            slope = (self.moduli * self.times / spread**2).sum(axis=-1) + self.viscosity
        return Creep(
            instantaneous=0.0 if self.viscosity > 0 else 1 / self.glassy,
            fluidity=0.0 if self.long_term > 0 else 1 / self.steady_viscosity,
            compliances=1 / (rates * slope),
            times=1 / rates,
        )


def prony(
    long_term: float,
    moduli: Sequence[float] | np.ndarray = (),
    times: Sequence[float] | np.ndarray = (),
    *,
    viscosity: float = 0.0,
) -> Prony:
    """Return a Prony series with sorted arms, merged equal times, and no arms of zero modulus.

    >>> prony(1.0, [2.0, 3.0, 1.0], [0.1, 5.0, 0.1]).moduli.tolist()
    [3.0, 3.0]
    """
    arms, decay = np.asarray(moduli, dtype=float), np.asarray(times, dtype=float)
    wrong = nonnegative_faults(long_term=long_term, viscosity=viscosity)
    if arms.ndim != 1 or arms.shape != decay.shape:
        wrong.append(f"moduli and times must be lists of one length, got {moduli!r}, {times!r}")
    if not (np.isfinite(arms).all() and (arms >= 0).all()):
        wrong.append(f"moduli must be finite and >= 0, got {moduli!r}")
    if not (np.isfinite(decay).all() and (decay > 0).all()):
        wrong.append(f"times must be finite and positive, got {times!r}")
    if not wrong and not (long_term > 0 or viscosity > 0 or (arms > 0).any()):
        wrong.append("a material needs a modulus or a viscosity above zero")
    refuse(wrong)
    distinct, place = np.unique(decay[arms > 0], return_inverse=True)
    joined = np.zeros(distinct.size)
    np.add.at(joined, place, arms[arms > 0])
    return Prony(float(long_term), joined[::-1].copy(), distinct[::-1].copy(), float(viscosity))


def contact_modulus(material: Prony, poisson_ratio: float = 0.5) -> Prony:
    """Return E*(t) = 2 G(t)/(1 - nu) for a constant Poisson's ratio; 4 G for rubber (19.30)."""
    refuse(poisson_faults(poisson_ratio))
    return material.scaled(2 / (1 - poisson_ratio))


def kelvin_voigt(shear_modulus: float, viscosity: float) -> Prony:
    """Return a spring and dashpot in parallel, G(w) = G + i w eta, the rubber of Problem 1."""
    refuse(positive_faults(shear_modulus=shear_modulus, viscosity=viscosity))
    return prony(shear_modulus, viscosity=viscosity)


def standard_solid(long_term: float, shear_modulus: float, relaxation_time: float) -> Prony:
    """Return a spring parallel to a Maxwell arm (Zener 1948), G(t) = G_inf + G_1 exp(-t/tau)."""
    wrong = positive_faults(long_term=long_term, shear_modulus=shear_modulus)
    refuse(wrong + positive_faults(relaxation_time=relaxation_time))
    return prony(long_term, [shear_modulus], [float(relaxation_time)])


@dataclass(frozen=True)
class Fit:
    """Prony series fitted to measured moduli, and |G_fit - G|/|G| at their frequencies."""

    material: Prony
    error: np.ndarray

    @property
    def rms_error(self) -> float:
        """Root mean square of the relative errors."""
        return float(np.sqrt(np.mean(self.error**2)))


def fit(
    frequency: ArrayLike,
    modulus: ArrayLike,
    *,
    times: Sequence[float] | np.ndarray | None = None,
    per_decade: float = 2.0,
    dashpot: bool = False,
) -> Fit:
    """Return a fit of G'(w), G''(w) by a Prony series with G_i >= 0 (Baumgaertel & Winter 1989).

    Least squares of (G_fit - G)/|G| over real and imaginary parts at fixed relaxation times, by
    the non-negative algorithm of Lawson & Hanson (1974): the result is always a passive material
    and needs no regularisation. Arms that do not improve the fit are dropped.

    Angular frequencies w > 0 (k,) are in any order, the modulus G' + i G'' is not negative in
    either part. Relaxation times are by default `per_decade` per decade over [1/w_max, 1/w_min]; a
    parallel `dashpot` may be included.

    >>> w = np.geomspace(1e-2, 1e2, 9)
    >>> exact = standard_solid(1.0, 4.0, relaxation_time=1.0)
    >>> data = exact.complex_modulus(w)
    >>> fitted = fit(w, data, times=[0.1, 1.0, 10.0])
    >>> fitted.material.times.tolist(), bool(fitted.rms_error < 1e-12)
    ([1.0], True)
    """
    w, data = np.asarray(frequency, dtype=float), np.asarray(modulus, dtype=complex)
    wrong = positive_faults(per_decade=per_decade)
    if w.ndim != 1 or w.size == 0 or w.shape != data.shape:
        shapes = f"{w.shape}, {data.shape}"
        wrong.append(f"frequency and modulus must be lists of one length, got {shapes}")
    if not (np.isfinite(w).all() and (w > 0).all()):
        wrong.append(f"frequency must be finite and positive, got {w}")
    for name, values in (("storage", data.real), ("loss", data.imag)):
        if not (np.isfinite(values).all() and (values >= 0).all()):
            wrong.append(f"{name} must be finite and >= 0, got {values}")
    if not wrong and not (data != 0).all():
        wrong.append("storage and loss must not both be zero at a frequency")
    refuse(wrong)
    if times is None:
        count = max(1, round(per_decade * np.log10(w.max() / w.min())) + 1)
        tau = np.geomspace(1 / w.max(), 1 / w.min(), count)
    else:
        tau = np.asarray(times, dtype=float)
    if tau.ndim != 1 or not (np.isfinite(tau).all() and (tau > 0).all()):
        raise ValueError(f"times must be a list of positive numbers, got {times!r}")
    turns = w[:, None] * tau
    columns = [turns * (turns + 1j) / (1 + turns * turns)]
    # all unknowns in units of modulus: the dashpot by its stress at the highest frequency
    columns.append(np.full((w.size, 1), 1.0 + 0j))
    columns.append(1j * np.repeat(w[:, None] / w.max(), int(dashpot), axis=1))
    matrix, weight = np.hstack(columns), 1 / np.abs(data)
    unit = 2.0 ** np.round(np.log2(np.abs(data).max()))
    relative = matrix * (unit * weight)[:, None]
    goal = np.concatenate([(data * weight).real, (data * weight).imag])
    coefficients = nnls(np.vstack([relative.real, relative.imag]), goal)[0]
    # Coefficients that change the data by less than rounding are rounding errors.
    coefficients = unit * np.where(
        np.abs(relative * coefficients).max(axis=0) > _ROUNDING, coefficients, 0.0
    )
    material = prony(
        coefficients[tau.size],
        coefficients[: tau.size],
        tau,
        viscosity=coefficients[-1] / w.max() if dashpot else 0.0,
    )
    return Fit(material, np.abs(material.complex_modulus(w) - data) * weight)


def _times(time: float | np.ndarray) -> np.ndarray:
    """Return times as an array; raise ValueError for negative times."""
    t = np.asarray(time, dtype=float)
    if not (np.isfinite(t).all() and (t >= 0).all()):
        raise ValueError(f"times must be finite and >= 0, got {time!r}")
    return t
