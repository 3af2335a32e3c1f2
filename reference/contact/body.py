"""An elastic body as the linear map from pressures on a grid of cells to their displacements.

Solvers use only `ElasticBody`: shape, spacing, the convolution with its compliance, and the
stiffness of its waves. The half-space, layered bodies and finite elements on a grid are its
subclasses; they define the body beyond the grid (free, or periodic images of the grid).
"""

from __future__ import annotations

from collections.abc import Callable, Hashable
from typing import Any, Self, TypeVar

import numpy as np
from numpy.typing import ArrayLike, DTypeLike, NDArray

from reference.arguments import positive_faults, refuse, spacing_faults
from reference.contact.convolution import Convolution

Cached = TypeVar("Cached")

# Kernels of coarser grids and of windows are kept for the next solve up to so many cells.
LARGEST_KEPT = 2**20


class ElasticBody:
    """A body under a grid of cells: u = K p, a convolution.

    Kernels are computed on first use and cached, and a preconditioner is adapted to every contact,
    so a body must be used by one thread at a time. Pickles contain only the arguments.

    Attributes
    ----------
    periodic : bool
        Whether the grid repeats.
    rim_excess : float
        How far outside Hertz's circle the law of `contact_line`, which is that of Love's cells,
        puts the rim, in cells (`docs/examples/rim_excess.py`).
    """

    periodic: bool
    rim_excess: float = 0.0

    def __init__(
        self, shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
    ) -> None:
        check_grid(shape, spacing, effective_modulus)
        self.shape = (int(shape[0]), int(shape[1]))
        self.spacing = (float(spacing[0]), float(spacing[1]))
        self.effective_modulus = float(effective_modulus)
        # a period needs no padding
        self._padded = self.shape
        self._cache: dict[Hashable, Any] = {}

    def __getstate__(self) -> dict[str, Any]:
        return self.__dict__ | {"_cache": {}}

    @property
    def cell_area(self) -> float:
        """Area of one cell, dx dy."""
        return self.spacing[0] * self.spacing[1]

    @property
    def mean_compliance(self) -> float:
        """Mean displacement per mean pressure of a periodic body; zero on the half-space."""
        return float(self.convolution(np.float64).transfer[0, 0]) * self.unit

    @property
    def sinks(self) -> bool:
        """Whether a uniform pressure displaces a periodic body: not so on the half-space."""
        return self.periodic and self.mean_compliance > 0

    @property
    def bounded(self) -> bool:
        """Whether cells with g >= d are never in contact, as where pressure lifts no cell."""
        return False

    def coefficients(self, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Displacement per pressure at offsets from zero to less than `shape`, of a free body."""
        raise NotImplementedError

    def restrict(self, shape: tuple[int, int]) -> Self:
        """Return the same body on a smaller rectangle of cells, where it is `bounded`."""
        raise NotImplementedError

    def cached(self, key: Hashable, make: Callable[[], Cached]) -> Cached:
        """Return the cached result of `make` for this key."""
        if key not in self._cache:
            self._cache[key] = make()
        return self._cache[key]

    def forget(self) -> None:
        """Drop all that is kept; it is made again when needed."""
        self._cache.clear()

    def _transfer(self) -> NDArray[np.float64]:
        """Return the transfer function on the modes of `rfft2`; those of q_x < 0 are not read."""
        raise NotImplementedError

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        """Return the same body under other cells."""
        raise NotImplementedError

    def wave_stiffness(self, wavenumber: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return pressure over displacement of waves, in units of E*/2: |q| on the half-space."""
        return wavenumber

    @property
    def unit(self) -> float:
        """Power of two near the largest transfer factor, the unit of `convolution`."""
        return self._exact()[1]

    @property
    def transfer(self) -> NDArray[np.float64]:
        """Transfer function from pressure to displacement on the padded grid.

        On the modes of `rfft2` with q_x >= 0; it is even in both wavenumbers. A new array.
        """
        return np.asarray(self.convolution(np.float64).transfer * self.unit, np.float64)

    def coarser(self) -> Self | None:
        """Body under every second point (cached), or None if the period is no multiple of it."""
        if self.periodic and any(n % 2 for n in self.shape):
            return None
        shape = (self.shape[0] + 1) // 2, (self.shape[1] + 1) // 2
        spacing = 2 * self.spacing[0], 2 * self.spacing[1]
        return self.cached("coarser", lambda: self._alike(shape, spacing))

    def convolution(self, dtype: DTypeLike) -> Convolution:
        """Return the convolution from pressure to displacement/`unit` in a given precision."""
        dtype, exact = np.dtype(dtype), self._exact()[0]
        if dtype == np.float64:
            return exact
        return self.cached(
            ("convolution", dtype.name),
            lambda: Convolution(self.shape, self._padded, exact.transfer, dtype),
        )

    def _exact(self) -> tuple[Convolution, float]:
        """Return the convolution in double precision, which alone keeps the kernel, and `unit`."""

        def make() -> tuple[Convolution, float]:
            transfer = self._transfer()[: self._padded[0] // 2 + 1]
            unit = power_of_two(transfer.max())
            return Convolution(self.shape, self._padded, transfer / unit, np.float64), unit

        return self.cached("exact", make)

    def apply(self, pressure: ArrayLike) -> NDArray[np.float64]:
        """Return the displacement of all cell centres under cell pressures of shape `shape`."""
        pressure = np.ascontiguousarray(check_pressure(pressure, self.shape))
        displacement = np.asarray(self.convolution(np.float64)(pressure), dtype=np.float64)
        displacement *= self.unit
        return displacement


def window(
    parts: dict[tuple[int, int], Cached],
    shape: tuple[int, int],
    make: Callable[[tuple[int, int]], Cached],
) -> Cached:
    """Return the operator on a window of cells, of the kept ones or a new one.

    The last ones are kept, of `LARGEST_KEPT` cells together: a sweep has as many as loads.
    """
    part = parts.pop(shape, None)
    while parts and sum(n * m for n, m in (*parts, shape)) > LARGEST_KEPT:
        del parts[next(iter(parts))]
    parts[shape] = make(shape) if part is None else part
    return parts[shape]


def power_of_two(value: float) -> float:
    """Return the largest power of two up to a positive value."""
    return float(2.0 ** (np.frexp(value)[1] - 1)) if value > 0 else 1.0


def check_grid(
    shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
) -> None:
    """Raise one ValueError that lists all errors in a grid or its modulus."""
    faults = []
    if len(shape) != 2 or any(int(n) != n or n < 1 for n in shape):
        faults.append(f"shape must be two positive integers, not {shape!r}")
    faults += spacing_faults(spacing)
    faults += positive_faults(effective_modulus=effective_modulus)
    refuse(faults)


def check_pressure(pressure: ArrayLike, shape: tuple[int, int]) -> NDArray[np.float64]:
    """Return the pressure as a double array of the operator's shape, or raise ValueError."""
    pressure = np.asarray(pressure, dtype=float)
    if pressure.shape != shape:
        raise ValueError(f"pressure has shape {pressure.shape}, the operator {shape}")
    return pressure
