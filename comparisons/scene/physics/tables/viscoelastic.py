"""The table [viscoelastic]: springs and dashpots of the shear modulus, as one Prony series."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Annotated, Any, Literal

from pydantic import model_validator

from comparisons.formatting import unpadded
from comparisons.scene.fields import (
    PRESSURE,
    TIME,
    VISCOSITY,
    Dimension,
    Sign,
    WithUnit,
    fail,
    quantity,
)
from comparisons.scene.physics.tables.physics_table import PhysicsTable

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene

# Moduli that a user rounds in two tables are the same if they agree so well.
SAME_MODULUS = 1e-3
_ELEMENTS = {"kelvin_voigt": (1, 1), "maxwell": (1, 1), "standard": (2, 1)}


def _listed(dimension: Dimension, kind: str, sign: Sign = "positive") -> Any:
    """Return the validator of a list of quantities, or of a single one that stands for it."""
    check: Any = quantity(dimension, sign=sign, kind=kind).func

    def read(value: Any) -> Any:
        listed = value if isinstance(value, (list, tuple)) else [value]
        if not listed:
            raise fail(f"expected a {kind}, or a list of them, got an empty list")
        return tuple(check(entry) for entry in listed)

    return WithUnit(read, dimension=dimension)


class Viscoelastic(PhysicsTable):
    """Shear relaxation of an isotropic body of constant Poisson ratio."""

    key = "viscoelastic"
    place = 2
    one_body = True
    # "kelvin_voigt" (spring G and dashpot eta side by side), "maxwell" (G and eta in a row),
    # "standard" (G0 beside a Maxwell element G1, eta1) or "prony" (G0 beside any number).
    model: Literal["kelvin_voigt", "maxwell", "standard", "prony"]
    # [G], [G], [G0, G1], [G0, G1, ..., Gn]; G0 of a Prony series may be zero: a fluid.
    shear_moduli: Annotated[tuple[float, ...], _listed(PRESSURE, "modulus", "not negative")]
    # Either: one for each dashpot, tau = eta/G with the modulus of its own element.
    viscosities: Annotated[tuple[float, ...] | None, _listed(VISCOSITY, "viscosity")] = None
    relaxation_times: Annotated[tuple[float, ...] | None, _listed(TIME, "time")] = None

    @model_validator(mode="after")
    def _complete(self) -> Viscoelastic:
        problems = []
        moduli = len(self.shear_moduli)
        if self.model == "prony":
            springs, dashpots = max(moduli, 2), max(moduli - 1, 1)
        else:
            springs, dashpots = _ELEMENTS[self.model]
        if moduli != springs:
            at_least = "at least " if self.model == "prony" else ""
            problems.append(f"shear_moduli: expected {at_least}{springs} of them, got {moduli}")
        elif not all(self.shear_moduli[1:] if springs > 1 else self.shear_moduli):
            problems.append("shear_moduli: expected positive moduli, but for G0")
        if (self.viscosities is None) == (self.relaxation_times is None):
            problems.append("expected exactly one of viscosities and relaxation_times")
        for name in ("viscosities", "relaxation_times"):
            entries = getattr(self, name)
            if entries is not None and len(entries) != dashpots:
                problems.append(
                    f"{name}: expected {dashpots}, one for each dashpot, got {len(entries)}"
                )
        if problems and self.model == "prony":
            problems.append("the moduli begin with the long-term G0, which may be 0")
        if problems:
            raise fail("; ".join(problems))
        return self

    @classmethod
    def misfits(cls, data: Mapping[str, Any], loading: Mapping[str, Any]) -> Iterator[str]:
        """Expect the times of the loads, unless the motion gives them."""
        if "time" not in loading and not {"sliding", "dynamics"} & set(data):
            yield "viscoelastic: expected loading.time, the time of each load: the material relaxes"

    def check(self, scene: Scene) -> None:
        """Let moduli that stand in [half_space], too, agree: those of this table count."""
        table = scene.half_space
        if not (table.youngs_modulus or table.shear_modulus or table.effective_modulus):
            return
        modulus = 0.5 * table.modulus * (1 - scene.poisson_ratio)
        moduli = (self.long_term_modulus, self.instantaneous_modulus)
        known = [choice for choice in moduli if 0 < choice < math.inf]
        if not any(abs(modulus - choice) <= SAME_MODULUS * choice for choice in known):
            either = " or ".join(f"{choice:g} Pa" for choice in known)
            raise fail(
                f"half_space: expected poisson_ratio alone, or a shear modulus of {either} as in "
                f"[viscoelastic], got {modulus:g} Pa"
            )

    @property
    def dashpot_viscosity(self) -> float:
        """Viscosity of a dashpot without a spring in its row (Kelvin-Voigt), else zero."""
        if self.model != "kelvin_voigt":
            return 0.0
        if self.viscosities is not None:
            return self.viscosities[0]
        assert self.relaxation_times is not None
        return self.shear_moduli[0] * self.relaxation_times[0]

    @property
    def long_term_modulus(self) -> float:
        """Shear modulus G0 after all relaxation; zero for a fluid."""
        return 0.0 if self.model == "maxwell" else self.shear_moduli[0]

    @property
    def branches(self) -> tuple[tuple[float, float], ...]:
        """Modulus G_i and relaxation time tau_i of each Maxwell element.

        The Prony series G(t) = G0 + sum_i G_i exp(-t/tau_i); a Kelvin-Voigt body has none, but a
        dashpot.
        """
        if self.model == "kelvin_voigt":
            return ()
        moduli = self.shear_moduli if self.model == "maxwell" else self.shear_moduli[1:]
        if self.relaxation_times is not None:
            times = self.relaxation_times
        else:
            assert self.viscosities is not None
            times = tuple(v / g for v, g in zip(self.viscosities, moduli, strict=True))
        return tuple(zip(moduli, times, strict=True))

    @property
    def instantaneous_modulus(self) -> float:
        """Shear modulus of a sudden step; infinite where a dashpot stands alone."""
        if self.dashpot_viscosity:
            return math.inf
        return self.long_term_modulus + sum(modulus for modulus, _ in self.branches)

    def ramp_modulus(self, duration: float) -> float:
        """Return the mean shear modulus of a strain that grows steadily for so long."""
        relaxed = sum(g * tau / duration * -math.expm1(-duration / tau) for g, tau in self.branches)
        return self.long_term_modulus + self.dashpot_viscosity / duration + relaxed

    def softest_modulus(self, duration: float) -> float:
        """Return a bound below 1/J(t) for all t up to a duration, J the creep compliance.

        A solid creeps up to 1/G0. A fluid goes on: J(t) <= J_e + t/eta with the steady-state
        compliance J_e = sum G_i tau_i^2 / eta^2 and eta = sum G_i tau_i (Ferry, *Viscoelastic
        Properties of Polymers*, 1980, ch. 3). It sizes grids; no result depends on it.
        """
        if self.long_term_modulus > 0:
            return self.long_term_modulus
        viscosity = sum(modulus * time for modulus, time in self.branches)
        recoverable = sum(modulus * time**2 for modulus, time in self.branches) / viscosity**2
        return 1.0 / (recoverable + duration / viscosity)

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        lasting = unpadded(self.long_term_modulus, "Pa")
        parts = [
            f"{unpadded(modulus, 'Pa')} relaxing in {unpadded(time, 's')}"
            for modulus, time in self.branches
        ]
        if self.dashpot_viscosity:
            parts = [f"a dashpot of {unpadded(self.dashpot_viscosity, 'Pa s')}"]
        name, nu = self.model.replace("_", "-"), unpadded(poisson_ratio, "")
        text = f"{name}: long-term G = {lasting}, and {', '.join(parts)}; ν = {nu}"
        return "memory of the material", text
