"""Section 19.3 (a): an impact far below the speed of sound is quasi-static."""

from __future__ import annotations

from typing import Annotated

from comparisons.questions.experiments.experiment import Above, Finding, OneOf, Share, experiment
from reference.dynamics.wave_impact import rayleigh_share, wave_impact, weak_loss

QUANTITIES = ("energy", "restitution", "duration", "force")


@experiment(
    "quasi-static-impact",
    "Hertz's quasi-static impact of a sphere against the impact with waves",
    "speed",
    "speed over that of sound v/c0",
)
def quasi_static_impact(
    effort: str,
    *,
    speed: float = 0.01,
    quantity: Annotated[str, OneOf(*QUANTITIES)] = "energy",
    poisson_ratio: float = 0.3,
    density_ratio: Annotated[float, Above(0)] = 1.0,
    elastic_sphere: bool = False,
) -> Finding | Share:
    """Compare Hertz's quasi-static impact of a sphere at v/c0 with an impact that radiates waves.

    ``"energy"``: the share of the kinetic energy that is radiated; Hertz's theory loses none. The
    bar is the effect of the next order of the expansion in contact radius over wavelength.
    """
    collision = wave_impact(speed, poisson_ratio, density_ratio, bool(elastic_sphere))
    # the larger of the expansion parameter and the difference of its two forms
    orders = max(collision.slowness, weak_loss(collision.radiation) / collision.energy_lost - 1)
    lost = collision.energy_lost
    details: dict[str, float | str] = {
        "energy radiated": lost,
        "to first order": weak_loss(collision.radiation),
        "energy radiated over (v/c0)^(3/5)": lost / speed**0.6,
        "share of surface waves in it": rayleigh_share(poisson_ratio),
        "restitution": collision.restitution,
        "duration over Hertz's": collision.duration,
        "force over Hertz's": collision.force,
    }
    if quantity == "energy":
        return Share(lost, lost * orders, details)
    true = {
        "restitution": collision.restitution,
        "duration": collision.duration,
        "force": collision.force,
    }[quantity]
    return Finding(1.0, true, abs(1 / true - 1) * orders, details)
