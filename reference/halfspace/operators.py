"""The half-space under pressure on rectangular cells: free around the grid, or periodic."""

from __future__ import annotations

from typing import Self

import numpy as np
from numpy.typing import NDArray
from scipy import fft

from reference.contact import pieces
from reference.contact.body import LARGEST_KEPT, ElasticBody, window
from reference.halfspace import kernels

# The rim of pressures through the cells' values lies further out than that of uniform ones.
RIM_EXCESS: dict[str, float] = {"continuum": 0.016, "cells": 0.0}
# Arrays that Love's formula needs beside its result.
_TEMPORARIES = 16


class FreeOperator(ElasticBody):
    """Free half-space under a rectangle of cells with uniform pressure: u = K p, (19.2).

    The sum over cells is an exact linear convolution with Love's coefficients (`kernels.love`),
    by real FFTs on a zero-padded grid, without periodic images.

    Of cells (nx, ny) of sides (dx, dy), and E*, in consistent units.

    Examples
    --------
    >>> import numpy as np
    >>> K = FreeOperator((3, 3), (1.0, 1.0), 1.0)
    >>> u = K.apply(np.ones((3, 3)))
    >>> bool(np.isclose(u[1, 1], 3 * 4 * np.log(1 + np.sqrt(2)) / np.pi))
    True
    """

    periodic = False

    @property
    def lifts(self) -> bool:
        """Whether pressure on a cell may raise another: never on the half-space."""
        return False

    @property
    def bounded(self) -> bool:
        """On the half-space u >= 0; not so below long cells of finite elements, or on rubber."""
        return not self.lifts

    def __init__(
        self, shape: tuple[int, int], spacing: tuple[float, float], effective_modulus: float
    ) -> None:
        super().__init__(shape, spacing, effective_modulus)
        # an even number of cells, so that the kernel's transform is one of cosines
        self._padded = tuple(2 * fft.next_fast_len(n, real=True) for n in self.shape)

    def coefficients(self, shape: tuple[int, int]) -> NDArray[np.float64]:
        """Love's coefficients at offsets from zero to less than `shape`; (19.3)."""
        coefficients = self._cache.get("coefficients")
        if coefficients is None or any(
            n > k for n, k in zip(shape, coefficients.shape, strict=True)
        ):
            # more than needed, as the next window of a sweep may be larger
            size = tuple(min(n, max(64, k)) for n, k in zip(self.shape, shape, strict=True))
            coefficients = np.empty(size)

            def fill(part: slice) -> None:  # some rows at a time
                i, j = np.ix_(np.arange(part.start, part.stop), np.arange(size[1]))
                coefficients[part] = kernels.love(i, j, self.spacing, self.effective_modulus)

            pieces.over(size[0], pieces.rows_of(_TEMPORARIES * size[1]), fill)
            self._cache["coefficients"] = coefficients
        return coefficients[: shape[0], : shape[1]]

    def _transfer(self) -> NDArray[np.float64]:
        """Return the transform of the even kernel, by cosines; unused offsets are zero."""
        kernel = np.zeros([n // 2 + 1 for n in self._padded])
        kept = "coefficients" in self._cache
        kernel[: self.shape[0], : self.shape[1]] = self.coefficients(self.shape)
        if not kept and kernel.size > LARGEST_KEPT:
            self._cache.pop("coefficients", None)  # no window has asked for them
        for axis in (0, 1):
            kernel = fft.dct(kernel, type=1, axis=axis, overwrite_x=True, workers=1)
        return kernel

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        return type(self)(shape, spacing, self.effective_modulus)

    def restrict(self, shape: tuple[int, int]) -> Self:
        """Return the operator of the same body on a smaller rectangle of cells (cached)."""
        parts: dict[tuple[int, int], Self] = self.cached("restricted", dict)
        return window(parts, shape, self._part)

    def _part(self, shape: tuple[int, int]) -> Self:
        part = self._alike(shape, self.spacing)
        part._cache["coefficients"] = self.coefficients(shape)
        return part


class PeriodicOperator(ElasticBody):
    """Half-space under periodic pressure with zero mean displacement: u^(q) = T(q) p^(q).

    The period is (nx dx, ny dy). With the kernel "continuum" T = 2/(E*|q|), with "cells" the
    same for pressures uniform on cells: see `kernels.periodic`.

    Examples
    --------
    >>> import numpy as np
    >>> x = np.arange(16) / 16
    >>> p = np.broadcast_to(np.cos(2 * np.pi * x)[:, None], (16, 16))
    >>> u = PeriodicOperator((16, 16), (1 / 16, 1 / 16), 1.0).apply(p)
    >>> bool(np.allclose(u, p / np.pi))
    True
    """

    periodic = True

    def __init__(
        self,
        shape: tuple[int, int],
        spacing: tuple[float, float],
        effective_modulus: float,
        kernel: kernels.Kernel = "continuum",
    ) -> None:
        super().__init__(shape, spacing, effective_modulus)
        self.kernel = kernel
        self.rim_excess = RIM_EXCESS.get(kernel, 0.0)
        _ = self.unit  # raises for an unknown kernel

    def _transfer(self) -> NDArray[np.float64]:
        grid = self.shape, self.spacing
        return kernels.periodic_quarter(*grid, self.effective_modulus, self.kernel)

    def _alike(self, shape: tuple[int, int], spacing: tuple[float, float]) -> Self:
        return type(self)(shape, spacing, self.effective_modulus, self.kernel)
