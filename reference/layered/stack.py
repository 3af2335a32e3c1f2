r"""Bodies that change with depth: their normal compliance to waves of pressure.

`Stack` has elastic layers. Under a pressure p cos(q x) its displacements and stresses are

    u_x = U sin q x,   u_z = W cos q x,   s_xz = G q T sin q x,   s_zz = G q S cos q x,

with z into the body. In a layer Hooke's law and equilibrium make y = (U, W, T, S) obey y' = A y
over the depth in units of 1/q,

    A = [[0, 1, 1, 0], [-b, 0, 0, c], [2/(1-nu), 0, 0, b], [0, 0, -1, 0]],

b = nu/(1 - nu), c = (1 - 2 nu)/(2 (1 - nu)), regular up to nu = 0.5. A has the twofold eigenvalues
1 and -1, so that for a slice of thickness h

    exp(A h) = (ch - h sh/2) + (3 sh - h ch)/2 A + h sh/2 A^2 + (h ch - sh)/2 A^3

(E. Kausel and J. M. Roesset, Bull. Seism. Soc. Am. 71 (1981) 1743, have the same as stiffnesses).
Products of such matrices overflow at short waves and lose all digits long before. What is carried
from the bottom up is the compliance R, (U, W) = R (T, S), of what lies below,

    R_top = (E11 R + E12) (E21 R + E22)^-1,    E = exp(-A h),

over slices of h <= 1: numbers of order one whose errors decay on the way up like the field itself.
On a rigid base R = 0; of a half-space it is known.

`Graded` is the half-space whose modulus is a power of the depth, E = E0 (z/c0)^k, -1 < k < 1.

A point force F displaces the surface by

    u = F cos(pi k/2) c0^k/(pi c_N r^(1+k)),    c_N = h(k, nu) E0/(1 - nu^2)

(Booker, Balaam & Davis, Int. J. Numer. Anal. Meth. Geomech. 9 (1985) 353; Giannakopoulos & Suresh,
Int. J. Solids Struct. 34 (1997) 2357; in this form Hess, Int. J. Eng. Sci. 104 (2016) 20), so that
a wave of pressure gives C(q) ~ q^(k-1). c_N |x/c0|^k is the stiffness per length of springs that
give the same force, penetration and radius of every round contact, under the line g(x) = x^(1-k)
int_0^x f'(r) (x^2 - r^2)^((k-1)/2) dr. For k >= 1 the integral of u over a loaded area diverges:
such a body has no compliance.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field

import numpy as np
from numpy.typing import ArrayLike
from scipy.interpolate import CubicSpline
from scipy.special import gamma

from reference.arrays import Array
from reference.elasticity import Material
from reference.errors import positive_faults, refuse

# Layers thicker than this over 2 pi of a wavelength hide what is below: exp(-2 x 24) = 1e-21.
HIDDEN = 24.0
# Nodes per decade of tables: cubic splines between them err by 1e-11.
PER_DECADE = 400


@dataclass(frozen=True)
class Stack:
    """Bonded elastic layers on an elastic half-space or on a rigid base.

    A half-space has 2/(E* q):

    >>> body = Stack([], [], Material(1.0, 0.5))
    >>> float(np.round(body.compliance(2.0), 12))
    0.75
    """

    thicknesses: Sequence[float]  # from the surface down; at least one on a rigid base
    materials: Sequence[Material]  # of the layers
    # the half-space below; None is a rigid base to which the lowest layer is bonded
    base: Material | None = field(default=None)

    def __post_init__(self) -> None:
        object.__setattr__(self, "thicknesses", tuple(float(t) for t in self.thicknesses))
        object.__setattr__(self, "materials", tuple(self.materials))
        faults = []
        if len(self.thicknesses) != len(self.materials):
            count = f"{len(self.thicknesses)} and {len(self.materials)}"
            faults.append(f"thicknesses and materials must be as many, not {count}")
        if self.base is None and not self.thicknesses:
            faults.append("a rigid base must carry at least one layer")
        for index, thickness in enumerate(self.thicknesses):
            faults += positive_faults(**{f"thicknesses[{index}]": thickness})
        refuse(faults)

    @property
    def top(self) -> Material:
        """The uppermost material."""
        if self.materials:
            return self.materials[0]
        assert self.base is not None
        return self.base

    @property
    def total(self) -> float:
        """Thickness of all layers."""
        return float(sum(self.thicknesses))

    @property
    def squeezed(self) -> float:
        """Compliance under uniform pressure: infinite on a half-space.

        Where nothing moves sideways, the strain per pressure is (1 + nu)(1 - 2 nu)/(E (1 - nu)).
        """
        if self.base is not None:
            return np.inf
        total = 0.0
        for t, material in zip(self.thicknesses, self.materials, strict=True):
            E, nu = material.youngs_modulus, material.poisson_ratio
            total += t * ((1 + nu) * (1 - 2 * nu) / (E * (1 - nu)))
        return total

    def compliance(self, wavenumber: ArrayLike) -> Array:
        """Return the normal displacement of the surface per pressure, for waves q >= 0.

        At q = 0 `squeezed`. Relative error about 1e-14.
        """
        q = np.asarray(wavenumber, dtype=float)
        result = np.full(q.size, self.squeezed)
        moving = q.ravel() > 0
        waves = q.ravel()[moving]
        # in units of 1/(G q) of the material that it is in
        below, modulus = np.zeros((waves.size, 2, 2)), 1.0
        if self.base is not None:
            below, modulus = below + half_space(self.base), self.base.shear_modulus
        layers = list(zip(self.thicknesses, self.materials, strict=True))
        for thickness, material in reversed(layers):
            below *= material.shear_modulus / modulus
            modulus = material.shear_modulus
            below = through(below, waves * thickness, material)
        result[moving] = -below[:, 1, 1] / (modulus * waves)
        return result.reshape(q.shape)[()]

    def softening(self, lowest: float, highest: float) -> Callable[[Array], Array]:
        """Return M - 1 as a function of q, M = q C(q)/(q C(q) at short waves), from a table.

        Short waves see the uppermost material only, for which M = 1.
        """
        highest = max(highest, 2 * lowest)
        number = int(PER_DECADE * np.log10(highest / lowest)) + 8
        logs = np.linspace(np.log(lowest), np.log(highest), number)
        q = np.exp(logs)
        table = CubicSpline(logs, np.log(q * self.compliance(q) * self.top.effective_modulus / 2))

        def excess(wavenumber: Array) -> Array:
            inside = np.clip(np.log(wavenumber), logs[0], logs[-1])
            hidden = wavenumber * self.thicknesses[0] > HIDDEN
            return np.where(hidden, 0.0, np.expm1(table(inside)))

        return excess


def half_space(material: Material) -> Array:
    """Compliance R of a half-space below, times G q (Johnson 1985, ch. 13)."""
    nu = material.poisson_ratio
    return np.array([[nu - 1, 0.5 - nu], [0.5 - nu, nu - 1]])


def through(below: Array, depth: Array, material: Material, down: Array | None = None) -> Array:
    """Return the compliance at the top of layers of thicknesses q t, from that at their bottom.

    `down` (n, 2, 2), if given, is filled with what takes tractions (T, S) from the top to the
    bottom: the product of (E21 R + E22)^-1; zero where the layer is so thick that nothing passes.
    """
    nu = material.poisson_ratio
    b, c = nu / (1 - nu), (1 - 2 * nu) / (2 * (1 - nu))
    first = np.array([[0, 1, 1, 0], [-b, 0, 0, c], [2 / (1 - nu), 0, 0, b], [0, 0, -1, 0]])
    endless = half_space(material)
    if (below == endless).all():
        # More of the half-space below: its states decay as exp(-q z), with the double root -1.
        if down is not None:
            nilpotent = first[2:, :2] @ endless + first[2:, 2:] + np.eye(2)
            down[:] = np.exp(-depth)[:, None, None] * (
                np.eye(2) + np.multiply.outer(depth, nilpotent)
            )
        return below.copy()
    slices = np.ceil(np.minimum(depth, HIDDEN)).astype(int)
    hidden = depth > HIDDEN
    result = np.where(hidden[:, None, None], endless, below)
    if down is not None:
        down[:] = np.where(hidden[:, None, None], 0.0, np.eye(2))
    second = first @ first
    for count in range(1, int(slices.max(initial=0)) + 1):
        active = (slices >= count) & ~hidden
        # E = exp(-A h), which takes (U, W, T, S) from the bottom of a slice to its top
        h = (depth[active] / slices[active])[:, None, None]
        ch, sh, small = np.cosh(h), np.sinh(h), rest(h)
        E = (ch - h * sh / 2) * np.eye(4) - (sh - small) * first
        E = E + h * sh / 2 * second - small * (second @ first)
        known = result[active]
        rows = E[:, :2, :2] @ known + E[:, :2, 2:]
        columns = E[:, 2:, :2] @ known + E[:, 2:, 2:]
        moved = np.linalg.solve(columns.transpose(0, 2, 1), rows.transpose(0, 2, 1))
        # symmetric by reciprocity
        result[active] = (moved + moved.transpose(0, 2, 1)) / 2
        if down is not None:
            down[active] = down[active] @ np.linalg.inv(columns)
    return result


def rest(h: Array) -> Array:
    """(h ch - sh)/2 to full accuracy: h^3/6 + h^5/60 + ..., a series up to h = 1."""
    h = np.asarray(h, dtype=float)
    total, term = np.zeros_like(h), h.copy()
    for k in range(1, 12):
        term = term * h**2 / ((2 * k) * (2 * k + 1))
        total = total + k * term
    return np.where(h <= 1.0, total, (h * np.cosh(h) - np.sinh(h)) / 2)


@dataclass(frozen=True)
class Graded:
    """A half-space that grows stiffer (k > 0) or softer (k < 0) with depth.

    k = 0 is a half-space, 2/(E* q):

    >>> float(np.round(Graded(Material(1.0, 0.5), 0.0, 1.0).compliance(2.0), 12))
    0.75
    """

    material: Material  # modulus E0 at the depth c0, and Poisson's ratio everywhere
    # k and c0
    exponent: float
    depth: float

    def __post_init__(self) -> None:
        faults = positive_faults(depth=self.depth)
        if not -1 < self.exponent < 1:
            faults.append(f"exponent must lie between -1 and 1, not {self.exponent!r}")
        refuse(faults)

    @property
    def top(self) -> Material:
        """The material at the depth c0; at the surface there is none."""
        return self.material

    @property
    def spring_modulus(self) -> float:
        """c_N: stiffness of the equivalent springs per length at x = c0."""
        k, nu = self.exponent, self.material.poisson_ratio
        # h(k, nu), one for k = 0 (Hess 2016, eq. 9 with (5))
        root = np.sqrt((1 + k) * (1 - k * nu / (1 - nu)))
        C = 2 ** (1 + k) * gamma((3 + k + root) / 2) * gamma((3 + k - root) / 2)
        C /= np.pi * gamma(2 + k)
        upper = 2 * (1 + k) * np.cos(np.pi * k / 2) * gamma(1 + k / 2)
        lower = np.sqrt(np.pi) * C * root * np.sin(np.pi * root / 2) * gamma((1 + k) / 2)
        return float(upper / lower) * self.material.youngs_modulus / (1 - nu**2)

    @property
    def point_factor(self) -> float:
        """Displacement times r^(1+k) of a point force, over the force."""
        k = self.exponent
        return float(np.cos(np.pi * k / 2) * self.depth**k / (np.pi * self.spring_modulus))

    def compliance(self, wavenumber: ArrayLike) -> Array:
        """Return the displacement of the surface per pressure, for waves; infinite at q = 0."""
        k = self.exponent
        factor = 2 * np.pi * self.point_factor * 2**-k * gamma((1 - k) / 2) / gamma((1 + k) / 2)
        with np.errstate(divide="ignore"):
            return factor * np.asarray(wavenumber, dtype=float) ** (k - 1)

    def slices(self, ends: Array) -> list[Material]:
        """Return the materials of slices between increasing depths, from zero on.

        E of the geometric mean of their ends; of the uppermost, up to the surface where E is zero
        or infinite, by the mean of 1/E.
        """
        k, nu = self.exponent, self.material.poisson_ratio
        ratios = np.append((1 - k) * ends[1] ** k, (ends[1:-1] * ends[2:]) ** (k / 2))
        moduli = self.material.youngs_modulus * ratios / self.depth**k
        return [Material(float(E), nu) for E in moduli]
