"""The half-space of a transversely isotropic material whose axis is the normal of the surface.

H. A. Elliott (Proc. Camb. Phil. Soc. 44 (1948) 522; 45 (1949) 621): frictionless contact is that of
an isotropic half-space with one modulus, as every wave of pressure p cos(q x) sinks in by
2 p/(E* q).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from reference.arguments import finite_faults, positive_faults, refuse


@dataclass(frozen=True)
class TransverselyIsotropic:
    """Moduli c11, c13, c33, c44; z is the axis.

    Raises
    ------
    ValueError
        Unless c11, c33, c44 > 0 and c13^2 < c11 c33.

    Examples
    --------
    >>> steel = TransverselyIsotropic(1.4, 0.6, 1.4, 0.4)  # isotropic: (c11 - c13)/2 = c44
    >>> round(steel.effective_modulus, 12) == round(4 * 0.4 * (1.4 - 0.4) / 1.4, 12)
    True
    """

    c11: float
    c13: float
    c33: float
    c44: float

    def __post_init__(self) -> None:
        wrong = positive_faults(c11=self.c11, c33=self.c33, c44=self.c44)
        wrong += finite_faults(c13=self.c13)
        if not wrong and self.c13**2 >= self.c11 * self.c33:
            wrong.append("c13^2 must be below c11 c33")
        refuse(wrong)

    @property
    def effective_modulus(self) -> float:
        """E* = 2 sqrt((c11 c33 - c13^2)/c11 / (1/c44 + 2/(c13 + sqrt(c11 c33))))."""
        stiff = (self.c11 * self.c33 - self.c13**2) / self.c11
        soft = 1 / self.c44 + 2 / (self.c13 + math.sqrt(self.c11 * self.c33))
        return 2 * math.sqrt(stiff / soft)

    def modulus_of_a_wave(self) -> float:
        """Return 2 p/(q u_z) of a wave of pressure, by equilibrium, from the two fields that decay.

        u_x = i U exp(i x - l z), u_z = W exp(i x - l z), q = 1; no shear traction. Where the two
        rates l coincide, as in isotropic bodies, there are no two fields.
        """
        c11, c13, c33, c44 = self.c11, self.c13, self.c33, self.c44
        squares = [c33 * c44, (c13 + c44) ** 2 - c11 * c33 - c44**2, c11 * c44]
        rates = np.sqrt(np.roots(squares).astype(complex))
        rates = np.where(rates.real < 0, -rates, rates)
        along, across = 1j * (c13 + c44) * rates, c44 * rates**2 - c11
        shear = c44 * (1j * across - rates * along)
        normal = 1j * c13 * along - c33 * rates * across
        share = np.linalg.solve(np.array([shear, normal]), [0, -1])
        return float((2 / (share @ across)).real)
