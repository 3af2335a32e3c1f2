"""Viscoelastic half-space under any rigid shape: one elastic contact problem per time step.

With one Poisson's ratio at all times, u(t) = int J*(t - s) d[v(s)], v = E K p the displacement of
an elastic half-space of modulus one. J* is a sum of exponentials, so u depends only on its modes:

    u = J_0 v + y + sum_k w_k,   dy/dt = v/eta,   lambda_k dw_k/dt = J_k v - w_k.

With p linear in time over a step, u at its end is C v + (known terms), and the contact conditions
are those of an elastic half-space of modulus 1/C whose gap is increased by the known terms. Cells
may lose and regain contact; neither symmetry nor springs are assumed. The error in time decreases
as dt^2 (for a dashpot without a spring in series, J_0 = 0, pressure may jump: then p is constant
over a step and belongs to its middle).
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from reference.halfspace.fft import solve
from reference.halfspace.operators import HalfSpace
from reference.halfspace.solution import Contact, Press
from reference.loads import History, Load
from reference.viscoelastic.hereditary import contact_factor
from reference.viscoelastic.materials import GeneralisedMaxwell

Field = NDArray[np.float64]


@dataclass(frozen=True)
class Instant:
    """Contact at one instant.

    Attributes
    ----------
    time, penetration, force : float
        With J_0 = 0 values in the middle of a step, else at its end.
    pressure : ndarray, shape (nx, ny)
    violation : float
        Violation of the contact conditions, as in `Contact`.
    """

    time: float
    penetration: float
    force: float
    pressure: Field
    violation: float


def press_in_time(
    press: Press,
    material: GeneralisedMaxwell,
    history: History,
    *,
    poisson_ratio: float = 0.5,
    tolerance: float = 1e-9,
) -> Iterator[Instant]:
    """Solve the contact of a rigid shape on a viscoelastic half-space along a history.

    Parameters
    ----------
    press : Press
        The shape, with gap 0 at first touch; the modulus of the half-space is not used.
    material : GeneralisedMaxwell
        Shear behaviour.
    history : History
        ``"penetration"`` or ``"force"``, forces > 0 (the first may be 0: first touch). There is no
        contact before the first time; a positive first value is a jump.
    poisson_ratio : float
    tolerance : float
        Tolerance of every contact problem, as for `fft.solve`.

    Yields
    ------
    Instant
        One per time (with J_0 = 0: one per step, at its middle).

    Raises
    ------
    ValueError
        If the history is not of this type.
    ConvergenceError
        On iteration, if a contact problem fails.
    """
    name, values = history.one_of("penetration", "force"), history.values
    if name == "force" and not (values[0] >= 0 and (values[1:] > 0).all()):
        raise ValueError(f"force must be positive (the first may be 0), not {values!r}")
    if material.viscosity > 0 and name == "penetration" and values[0] > 0:
        raise ValueError("penetration must start at 0 against a dashpot")
    surface = _Surface(press.operator, material, contact_factor(poisson_ratio))
    return _march(surface, press.gap, history, tolerance)


def _march(surface: _Surface, gap: Field, history: History, tolerance: float) -> Iterator[Instant]:
    name, times, values = history.control, history.time, history.values
    depth = 0.0
    for step, duration in enumerate(np.diff(times, prepend=times[0])):
        if step == 0 and surface.damped:
            continue  # pressures on a dashpot need time to act
        load = values[step]
        if name == "force" and surface.damped:
            load = values[step - 1 : step + 1].mean()
        before = depth
        depth, contact = surface.step(gap, name, float(load), float(duration), tolerance)
        yield Instant(
            time=float(times[step] - (duration / 2 if surface.damped else 0.0)),
            penetration=(before + depth) / 2 if surface.damped else depth,
            force=surface.force,
            pressure=surface.pressure,
            violation=0.0 if contact is None else contact.violation,
        )


class _Surface:
    """The half-space with its memory, per unit of G/E*.

    Attributes
    ----------
    pressure : ndarray
    damped : bool
        Whether J_0 = 0.
    """

    def __init__(self, operator: HalfSpace, material: GeneralisedMaxwell, factor: float) -> None:
        self._operator, self._factor = operator, factor
        self._creep = material.creep_modes
        self.damped = self._creep.instantaneous == 0
        self.pressure = np.zeros(operator.shape)
        self._elastic = np.zeros(operator.shape)  # v
        self._flow = np.zeros(operator.shape)  # y
        self._modes = np.zeros((len(self._creep.times), *operator.shape))  # w
        self._last: Contact | None = None
        self._compliance = 1.0

    @property
    def force(self) -> float:
        """Sum of the pressure."""
        return float(self.pressure.sum() * self._operator.cell_area)

    def step(
        self, gap: Field, name: str, load: float, duration: float, tolerance: float
    ) -> tuple[float, Contact | None]:
        """Advance by one step; return the depth at its end and the solved contact problem."""
        creep, z = self._creep, duration / self._creep.times
        decay = np.exp(-z)
        mean = np.divide(-np.expm1(-z), z, out=np.ones(z.size), where=z > 0)
        # Weights of v0 and v1 in the modes: v linear over the step, or constant v1.
        late = creep.compliances * (1 - (decay if self.damped else mean))
        early = creep.compliances * (0.0 if self.damped else mean - decay)
        flow = creep.fluidity * duration * (1.0 if self.damped else 0.5)
        early_flow = creep.fluidity * duration - flow
        modes = decay[:, None, None] * self._modes + early[:, None, None] * self._elastic
        recovered = modes.sum(axis=0) + self._flow + early_flow * self._elastic
        compliance = creep.instantaneous + float(late.sum()) + flow
        depth, contact = self._solve(gap + recovered, name, load, compliance, tolerance)
        elastic = np.zeros(gap.shape) if contact is None else contact.displacement / compliance
        self._modes = modes + late[:, None, None] * elastic
        self._flow = self._flow + early_flow * self._elastic + flow * elastic
        self._elastic = elastic
        return depth, contact

    def _solve(
        self, gap: Field, name: str, load: float, compliance: float, tolerance: float
    ) -> tuple[float, Contact | None]:
        """Return the contact of a surface of compliance J* E*/G with a gap of any sign."""
        # The operator has another modulus: its pressure is `scale` times ours.
        scale = compliance * self._operator.effective_modulus / self._factor
        top = float(gap[np.isfinite(gap)].min())
        free = load <= top if name == "penetration" else load == 0
        if free:
            self.pressure, self._last = np.zeros(gap.shape), None
            # Zero force occurs only at the start, at first touch, where the depth is zero.
            return load if name == "penetration" else 0.0, None
        prescribed = Load(name, load - top if name == "penetration" else load * scale)
        start = self._last
        if start is not None:
            start = replace(start, pressure=self.pressure * scale)
        contact = solve(
            Press(self._operator, gap - top), prescribed, tolerance=tolerance, start=start
        )
        self.pressure, self._last = contact.pressure / scale, contact
        return contact.penetration + top, contact
