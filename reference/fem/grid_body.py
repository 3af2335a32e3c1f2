r"""Elastic bodies of finite elements below a grid of cells, and contact on them.

The compliance of the columns (`columns.compliance`) on all modes of an FFT is the inverse of the
condensed stiffness of a mesh that repeats; with it `reference.contact.press`, stiffnesses and
energies work on finite elements as they do on the half-space, and share its contact iteration.

A periodic body is clamped two periods below its layers, where no more than 1e-8 of the longest
wave's compliance comes from: nothing of it is taken from the half-space. With an impedance bottom
the mesh ends eight cells below its layers, on the stiffness of a half-space's surface: a third of
the elements at 256 points a side, no floor from their growth, but a theory shared with half-space
solvers. On a free surface the body
differs from the continuum within some cells only, where the elements do:

    K_free = K_continuum + (K_columns - K_cells),

K_continuum has the coefficients of pressures uniform on cells (Love's on a half-space, Cerruti's
for tangential tractions), K_cells the same with all periodic images, K_columns those of elements. A
layer on a rigid base that is thin against the patch needs no continuum.
"""

from __future__ import annotations

import math
from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import replace
from functools import cached_property, lru_cache
from typing import Literal, Self

import numpy as np
from scipy import fft

from reference.arrays import Array
from reference.contact import press as unilateral
from reference.contact.body import check_grid
from reference.contact.press import Contact, assemble, check_gap
from reference.elasticity import Material
from reference.errors import ConvergenceError, choice_faults, refuse
from reference.fem.columns import ELEMENTS, Element, compliance, tensor
from reference.fem.contact import EXACT, Enforcement
from reference.halfspace import kernels
from reference.halfspace.kernels import FreeOperator
from reference.halfspace.traction import Cerruti, Compliance, NormalAndTangential, wave_factors
from reference.layered.layered_grid import (
    Body,
    OfBody,
    cell_coefficients,
    cell_modes,
    cell_modulus,
    is_local,
    uniform,
)
from reference.layered.stack import Graded, Stack
from reference.loads import Load

Bottom = Literal["clamped", "impedance"]
BOTTOMS: tuple[Bottom, ...] = ("clamped", "impedance")

# Where a body without a rigid base is clamped, in the longer period.
_DEPTH = 2.0
# Where a half-space's stiffness takes over, in the longer side of a cell: aliases of the longest
# waves have died away to exp(-50) there.
_SHALLOW = 8.0
# Slices of a graded body: the uppermost in cells, and each over the one above.
_FIRST, _SLICE = 0.05, 1.1
# Long sides of cells from one loaded cell to its image where elements and continuum are the same;
# of a body with inertia, in its own length.
_APART, _FAR = 64, 4
# How far outside Hertz's circle the law of cells puts the rim, in cells: for nu = 0 and 1/2.
_RIM_EXCESS: dict[Element, tuple[float, float]] = {
    "linear": (0.007, 0.049),
    "splines": (-0.013, -0.002),
    "quadratic": (0.005, 0.016),
}
# What is kept of the last bodies: some of up to 1024 points a side, on 2048, in 40 MB.
_KEPT, _LARGEST = 4, 1.2e6
# Longer cells need more modes for that than there is use for them.
LONGEST = 100


class GridBody(OfBody):
    """A half-space, layers, or a modulus that is a power of the depth, below (nx, ny) cells.

    Parameters
    ----------
    element : {"linear", "splines", "quadratic"}
        See `columns`.
    contact_compliance : float
        Depth per pressure by which shape and body may overlap, on top of all displacements: the
        penalty method, 1/eps.
    bottom : {"clamped", "impedance"}
        Of bodies with a half-space at their base.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        body: Material | Body,
        element: Element = "splines",
        contact_compliance: float = 0.0,
        bottom: Bottom = "clamped",
    ) -> None:
        self.body: Body = Stack([], [], body) if isinstance(body, Material) else body
        check_grid(shape, spacing, self.body.top.effective_modulus)
        super().__init__(shape, spacing, cell_modulus(self.body, spacing))
        faults = choice_faults("element", element, ELEMENTS)
        faults += choice_faults("bottom", bottom, BOTTOMS)
        half_space_below = isinstance(self.body, Stack) and self.body.base is not None
        if bottom == "impedance" and not half_space_below:
            faults.append("bottom must be clamped where no half-space of one modulus lies below")
        if not self.periodic and max(self.spacing) > LONGEST * min(self.spacing):
            faults.append(
                f"spacing must be sides within a factor of {LONGEST} below a free patch, "
                f"not {self.spacing!r}"
            )
        refuse(faults)
        self.element, self.bottom = element, bottom
        compressible, incompressible = _RIM_EXCESS[element]
        ratio = self.body.top.poisson_ratio
        self.rim_excess = compressible + 2 * ratio * (incompressible - compressible)
        self.contact_compliance = contact_compliance

    @property
    @abstractmethod
    def elastic(self) -> Array:
        """Compliance of the body without its contact's, as the kind of body keeps it."""

    def _alike(
        self, shape: tuple[int, int], spacing: tuple[float, float], more: float = 0.0
    ) -> Self:
        """Return a body of the same elements on other cells, with more overlap per pressure."""
        total = self.contact_compliance + more
        return type(self)(shape, spacing, self.body, self.element, total, self.bottom)

    def softened(self, compliance: float) -> Self:
        """Return the same body with more overlap per pressure (kept)."""
        key = "softened", compliance
        if key not in self._cache:
            body = self._cache[key] = self._alike(self.shape, self.spacing, compliance)
            body._cache["elastic"] = self.elastic
        softer: Self = self._cache[key]
        return softer


class PeriodicBody(GridBody):
    """Finite elements below one period of a surface; on no rigid base without mean displacement."""

    periodic = True

    @property
    def elastic(self) -> Array:
        """Displacement per pressure of waves."""
        form = self.body, self.element, self.bottom
        return self.cached("elastic", lambda: modes(self.shape, self.spacing, *form))

    def _transfer(self) -> Array:
        return self.elastic + self.contact_compliance


class FreeBody(GridBody, FreeOperator):
    """Finite elements below a rectangle of cells, free around it.

    Cells are at most `LONGEST` times longer than wide.
    """

    @property
    def bounded(self) -> bool:
        """Not so where pressure on a cell raises another one, as elements below long cells do."""
        return bool(self.elastic.min() >= 0)

    def coefficients(self, shape: tuple[int, int]) -> Array:
        """Coefficients at offsets from zero to less than `shape`, the springs' at zero."""

        def make() -> Array:
            whole = self.elastic.copy()
            whole[0, 0] += self.contact_compliance
            return whole

        return self.cached("body", make)[: shape[0], : shape[1]]

    @property
    def elastic(self) -> Array:
        """Displacement per pressure at offsets of cells."""

        def make() -> Array:
            rows, columns = self.shape
            period = _period(self.shape, self.spacing, _APART)
            more = modes(period, self.spacing, self.body, self.element, self.bottom)
            local = is_local(self.body, self.shape, period, self.spacing)
            if not local:
                more -= cell_modes(self.body, period, self.spacing)
            near = fft.irfft2(more, period, workers=1)[:rows, :columns].copy()
            return near if local else cell_coefficients(self.body, self.shape, self.spacing) + near

        return self.cached("elastic", make)

    def _part(self, shape: tuple[int, int]) -> Self:
        part = self._alike(shape, self.spacing)
        part._cache["elastic"] = self.elastic[: shape[0], : shape[1]]
        return part


def sweep(
    body: FreeBody | PeriodicBody,
    gap: Array,
    load: Load,
    enforcement: Enforcement = EXACT,
    *,
    tolerance: float = 1e-8,
) -> Iterator[Contact]:
    """Press a rigid shape on the body, load by load.

    The contact conditions hold at the centres of the cells. With springs of stiffness eps per area
    between shape and body the compliance of every wave is C + 1/eps, exactly: the penalty method is
    a softer body. Multipliers take its overlap away: the shape is moved by what the last solution
    lets it overlap, and solved again.

    Parameters
    ----------
    gap : ndarray, shape (nx, ny)
        Initial gap; +inf where the shape can never touch.
    load : Load
        Penetrations, forces or mean gaps, strictly increasing.
    enforcement : Enforcement
        `penalty` is eps h/E* with h the smaller side of the cells.
    tolerance : float
        Largest overlap and gap of what should touch, relative to the penetration.

    Raises ConvergenceError from the `next` of a load that fails.

    Examples
    --------
    >>> x = (np.arange(24) - 11.5) / 12
    >>> body = FreeBody((24, 24), (1 / 12, 1 / 12), Material(1 - 0.3**2, 0.3))
    >>> ball = (x[:, None] ** 2 + x**2) / 2
    >>> (hertz,) = sweep(body, ball, Load("penetration", 0.5))
    >>> bool(abs(hertz.force / (4 / 3 * 0.5**1.5) - 1) < 5e-3)
    True
    """
    if enforcement.method != "augmented_lagrangian":
        yield from unilateral.sweep(body_under(body, enforcement), gap, load, tolerance=tolerance)
        return
    gap = check_gap(body, gap)
    soft = body_under(body, replace(enforcement, method="penalty"))
    compliance, by_depth = soft.contact_compliance, load.control == "penetration"
    answer = None
    for value in load.values:
        # What needs no multipliers, or has no answer, is the exact solver's.
        closed = body.periodic and by_depth and value >= gap.mean()
        if closed or not gap.any() or (by_depth and value <= gap.min()):
            answer = unilateral.press(body, gap, Load(load.control, value), tolerance=tolerance)
            yield answer
            continue
        multipliers = np.zeros(soft.shape) if answer is None else answer.pressure
        contact, history = None, []
        for _ in range(enforcement.max_iterations):
            lifted = gap - compliance * multipliers
            shift = float(lifted.min())
            aim = Load(load.control, value - shift if by_depth else value)
            contact = unilateral.press(
                soft, lifted - shift, aim, tolerance=tolerance / 4, start=contact
            )
            depth = contact.penetration + shift
            overlap = compliance * float(np.abs(contact.pressure - multipliers).max())
            history += [*contact.history, overlap / depth if depth > 0 else np.inf]
            if overlap <= tolerance / 2 * depth:
                break
            multipliers = contact.pressure
        else:
            raise ConvergenceError(
                f"the overlap did not vanish in {enforcement.max_iterations} updates of the "
                f"multipliers with a penalty of {enforcement.penalty:g} E*/h: a larger one needs "
                "fewer",
                history,
            )
        answer = assemble(body, gap, contact.pressure, depth, len(history), history)
        yield answer


def body_under(body: FreeBody | PeriodicBody, enforcement: Enforcement) -> FreeBody | PeriodicBody:
    """Return what the shape is pressed on: with a penalty, the body with its springs on it."""
    if enforcement.method != "penalty":
        return body
    return body.softened(min(body.spacing) / (enforcement.penalty * body.effective_modulus))


def _period(shape: tuple[int, int], spacing: tuple[float, float], apart: float) -> tuple[int, int]:
    """Return an even period of so many long sides, whose half does not see the images."""
    n, m = (
        2 * int(fft.next_fast_len(max(n, math.ceil(apart / 2 * max(spacing) / step - 1e-9)), True))
        for n, step in zip(shape, spacing, strict=True)
    )
    return n, m


def modes(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    body: Body,
    element: Element,
    bottom: Bottom,
) -> Array:
    """Compliance on the modes of `rfft2`, from an octant or a quarter of them; length/pressure.

    That of a uniform pressure is zero where no rigid base is, the datum of a periodic half-space.
    """
    small = (shape[0] // 2 + 1) * (shape[1] // 2 + 1) <= _LARGEST
    # the next realisation, load or repetition of a solve on the same cells has no set-up
    quarter = (_kept_quarter if small else _quarter)(shape, spacing, body, element, bottom)
    return kernels.whole(quarter, shape[0])


def _quarter(
    shape: tuple[int, int],
    spacing: tuple[float, float],
    body: Body,
    element: Element,
    bottom: Bottom,
) -> Array:
    # the layers of elements, down to a rigid base or to a half-space
    depth = _DEPTH * max(n * step for n, step in zip(shape, spacing, strict=True))
    if isinstance(body, Graded):
        ratio = depth / (_FIRST * min(spacing))
        number = int(np.ceil(np.log(ratio) / np.log(_SLICE)))
        ends = np.append(0.0, depth * ratio ** -(np.arange(number, -1, -1.0) / number))
        layers = Stack(np.diff(ends).tolist(), body.slices(ends))
    elif body.base is None:
        layers = body
    else:
        below = body.base if bottom == "impedance" else None
        thickness = depth if below is None else _SHALLOW * max(spacing)
        layers = Stack([*body.thicknesses, thickness], [*body.materials, body.base], below)
    along, across = (2 * np.pi * np.arange(n // 2 + 1) / n for n in shape)
    if shape[0] == shape[1] and spacing[0] == spacing[1]:
        m, n = np.tril_indices(along.size)
        quarter = np.empty((along.size, across.size))
        values = compliance((along[m], across[n]), spacing, layers, element=element)
        quarter[m, n] = quarter[n, m] = values
    else:
        quarter = compliance((along[:, None], across), spacing, layers, element=element)
    quarter[0, 0] = uniform(body)
    quarter.flags.writeable = False
    return quarter


_kept_quarter = lru_cache(maxsize=_KEPT)(_quarter)


class ShearBody(NormalAndTangential):
    """A half-space of finite elements below a rectangle of cells, under tractions of any direction.

    For friction and for rolling. Under rollers the mesh stands still and the material flows through
    it (arbitrary Lagrange-Euler; Nackenhorst 2004); its inertia, rho V^2, is a part of the columns.

    `inertia` is rho V^2/G of a body that flows along x (see `columns.tensor`); pressures and normal
    displacements are those at rest.
    """

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        material: Material,
        *,
        element: Element = "splines",
        inertia: float = 0.0,
    ) -> None:
        super().__init__(
            shape, spacing, Compliance.of(material.shear_modulus, material.poisson_ratio)
        )
        self.normal = FreeBody(shape, spacing, material, element)
        self.material, self.element, self.inertia = material, element, inertia

    def _part(self, shape: tuple[int, int]) -> ShearBody:
        return ShearBody(
            shape, self.spacing, self.material, element=self.element, inertia=self.inertia
        )

    @cached_property
    def period(self) -> tuple[int, int]:
        """Cells of the period on which elements and continuum are compared."""
        apart = _APART if self.inertia == 0 else max(_APART, _FAR * max(self.shape))
        return _period(self.shape, self.spacing, apart)

    def free_coefficients(self) -> Cerruti:
        """Displacements by tractions on a cell, at offsets from zero on."""
        nx, ny = self.shape
        cells = super().free_coefficients()
        more = beyond_cells(
            self.period, self.spacing, self.material, element=self.element, inertia=self.inertia
        )
        return Cerruti(*(base + field[:nx, :ny] for base, field in zip(cells, more, strict=True)))


def beyond_cells(
    period: tuple[int, int],
    spacing: tuple[float, float],
    material: Material,
    *,
    element: Element,
    inertia: float,
) -> Cerruti:
    """Return displacements of elements less those of the half-space, by tractions on a cell.

    Fields have the shape of the period, the cells to the next images of load and displacement, at
    offsets modulo it, up to constants. A period of one cell across is plane strain: tractions do
    not vary with y.
    """
    phases = (
        2 * np.pi * fft.fftfreq(period[0])[:, None],
        2 * np.pi * fft.rfftfreq(period[1])[None, :],
    )
    sides = [n * side for n, side in zip(period, spacing, strict=True)]
    layers = Stack([_DEPTH * max(sides)], [material])
    elements = tensor(phases, spacing, layers, element=element, inertia=inertia)
    # of the gauge i u_x, i u_y, u_z
    columns = elements[0, 0], elements[1, 1], elements[0, 1], *-elements[2, :2]
    # tractions uniform on cells, with all periodic images: the factors of the half-space, times
    # the sincs of the cells, summed over the aliases
    body = Compliance.of(material.shear_modulus, material.poisson_ratio)
    qx, qy = kernels.wavenumbers(period, spacing)
    sums = np.zeros((5, qx.size, qy.size))
    along, sinc_x = kernels.aliases(qx.ravel(), spacing[0])
    across, sinc_y = kernels.aliases(qy.ravel(), spacing[1])
    for kx, share_x in zip(along, sinc_x, strict=True):
        for ky, share_y in zip(across, sinc_y, strict=True):
            share = share_x[:, None] * share_y
            for total, factor in zip(sums, wave_factors(body, kx[:, None], ky), strict=True):
                total += share * factor
    # the last two are odd in one coordinate: of imaginary modes
    fields = []
    for ours, theirs, turn in zip(columns, sums, (1, 1, 1, 1j, 1j), strict=True):
        difference = (ours - theirs) * complex(turn)
        difference[0, 0] = 0.0
        fields.append(fft.irfft2(difference, period, workers=1))
    return Cerruti(*fields)
