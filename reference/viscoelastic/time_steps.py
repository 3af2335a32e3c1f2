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

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from reference.arrays import Array
from reference.contact.body import ElasticBody
from reference.contact.press import Contact, check_gap, press
from reference.loads import History, Load
from reference.viscoelastic.hereditary import contact_factor
from reference.viscoelastic.materials import GeneralisedMaxwell


@dataclass(frozen=True)
class Instant:
    """Contact at one instant: with J_0 = 0 in the middle of a step, else at its end.

    `violation` of the contact conditions is that of `Contact`.
    """

    time: float
    penetration: float
    force: float
    pressure: Array
    violation: float


def press_in_time(
    operator: ElasticBody,
    gap: ArrayLike,
    material: GeneralisedMaxwell,
    history: History,
    *,
    poisson_ratio: float = 0.5,
    tolerance: float = 1e-9,
) -> Iterator[Instant]:
    """Yield the contact of a rigid shape on a viscoelastic half-space at each time of a history.

    With J_0 = 0 at the middle of each step. The modulus of the operator is not used. Forces are
    positive, but the first may be 0: first touch. A positive first value is a jump.
    """
    name, values = history.one_of("penetration", "force"), history.values
    if name == "force" and not (values[0] >= 0 and (values[1:] > 0).all()):
        raise ValueError(f"force must be positive (the first may be 0), not {values!r}")
    if material.viscosity > 0 and name == "penetration" and values[0] > 0:
        raise ValueError("penetration must start at 0 against a dashpot")
    shape, creep = check_gap(operator, gap), material.creep_modes
    factor = contact_factor(poisson_ratio)

    def steps() -> Iterator[Instant]:
        damped = creep.instantaneous == 0
        pressure, elastic, flowed = np.zeros((3, *operator.shape))  # p, v, y
        modes = np.zeros((len(creep.times), *operator.shape))  # w
        contact: Contact | None = None
        depth = 0.0
        for step, duration in enumerate(np.diff(history.time, prepend=history.time[0]).tolist()):
            if step == 0 and damped:
                continue  # pressures on a dashpot need time to act
            load = float(values[step])
            if name == "force" and damped:
                load = float(values[step - 1 : step + 1].mean())
            # weights of the last v and of this one in the modes: v linear in a step, or constant
            z = duration / creep.times
            decay = np.exp(-z)
            mean = np.divide(-np.expm1(-z), z, out=np.ones(z.size), where=z > 0)
            late = creep.compliances * (1 - (decay if damped else mean))
            early = creep.compliances * (0.0 if damped else mean - decay)
            flow = creep.fluidity * duration * (1.0 if damped else 0.5)
            early_flow = creep.fluidity * duration - flow
            # u = C v + what is known, which increases the gap
            modes = decay[:, None, None] * modes + early[:, None, None] * elastic
            raised = shape + (modes.sum(axis=0) + flowed + early_flow * elastic)
            compliance = creep.instantaneous + float(late.sum()) + flow
            # contact at that compliance, with a gap of any sign; the operator has another modulus:
            # its pressure is `scale` times that here
            scale = compliance * operator.effective_modulus / factor
            top = float(raised[np.isfinite(raised)].min())
            before = depth
            if (load <= top) if name == "penetration" else (load == 0):
                # a force of zero occurs only at the start, at first touch: the depth is zero
                depth = load if name == "penetration" else 0.0
                pressure, contact, now = np.zeros(raised.shape), None, np.zeros(raised.shape)
            else:
                prescribed = Load(name, load - top if name == "penetration" else load * scale)
                start = None if contact is None else replace(contact, pressure=pressure * scale)
                contact = press(
                    operator, raised - top, prescribed, tolerance=tolerance, start=start
                )
                pressure, depth = contact.pressure / scale, contact.penetration + top
                now = contact.displacement / compliance
            modes = modes + late[:, None, None] * now
            flowed = flowed + early_flow * elastic + flow * now
            elastic = now
            yield Instant(
                time=float(history.time[step] - (duration / 2 if damped else 0.0)),
                penetration=(before + depth) / 2 if damped else depth,
                force=float(pressure.sum() * operator.cell_area),
                pressure=pressure,
                violation=0.0 if contact is None else contact.violation,
            )

    return steps()
