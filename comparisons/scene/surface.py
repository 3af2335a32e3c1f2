"""The table [surface]: a rigid rough surface, synthetic or measured; trends of measured maps."""

from __future__ import annotations

from typing import Annotated, Any, Literal, NamedTuple

import numpy as np
from numpy.typing import NDArray
from pydantic import (
    BeforeValidator,
    Field,
    StrictBool,
    ValidationInfo,
    field_validator,
    model_validator,
)

from comparisons.formatting import with_unit
from comparisons.scene.fields import Finite, Length, Positive, SceneTable, fail


def _pair(value: Any) -> Any:
    return tuple(value) if isinstance(value, (list, tuple)) else (value, value)


# TOML has whole numbers and switches of its own: "64", 64.0 or true in their place are mistakes.
Points = Annotated[int, Field(strict=True, ge=4, le=2**20)]
Seed = Annotated[int, Field(strict=True, ge=0, lt=2**63)]
Count = Annotated[int, Field(strict=True, ge=1, le=1_000_000)]
Index = Annotated[int, Field(strict=True, ge=0)]
Window = Annotated[int, Field(strict=True, ge=2)]
PointsPair = Annotated[tuple[Points, Points], BeforeValidator(_pair)]
SizePair = Annotated[tuple[Length, Length], BeforeValidator(_pair)]


def _named(value: Any) -> Any:
    """Let a number stand for its digits."""
    return str(value) if type(value) is int else value


class SelfAffine(SceneTable):
    """A synthetic self-affine surface, (19.22) with fixed amplitudes and random phases."""

    kind: Literal["self_affine"]
    size: SizePair
    points: PointsPair
    hurst: Annotated[Finite, Field(ge=0, le=1)] | None = None
    power: Annotated[Finite, Field(ge=0, le=8)] | None = None
    rms_slope: Positive | None = None
    rms_height: Length | None = None
    long_cutoff: Length | None = None
    short_cutoff: Length | None = None
    periodic: StrictBool = False
    seed: Seed = 0
    realisations: Count = 1

    @model_validator(mode="after")
    def _complete(self) -> SelfAffine:
        problems = []
        if (self.hurst is None) == (self.power is None):
            problems.append("expected exactly one of hurst and power")
        if (self.rms_slope is None) == (self.rms_height is None):
            problems.append("expected exactly one of rms_slope and rms_height")
        shortest = 2 * max(s / n for s, n in zip(self.size, self.points, strict=True))
        short = self.short_cutoff or shortest
        long = self.long_cutoff or min(self.size)
        if short < shortest * (1 - 1e-9):
            enough = int(np.ceil(2 * max(self.size) / short * (1 - 1e-9)))
            problems.append(
                f"short_cutoff: expected at least 2 cells = {with_unit(shortest, 'm')}, got "
                f"{with_unit(short, 'm')}, for which points = {enough} are enough"
            )
        if not short <= long <= max(self.size) * (1 + 1e-9):
            problems.append(
                f"long_cutoff: expected from short_cutoff = {with_unit(short, 'm')} to the side "
                f"{with_unit(max(self.size), 'm')}, got {with_unit(long, 'm')}"
            )
        if problems:
            raise fail("; ".join(problems))
        return self

    @property
    def law(self) -> dict[str, Any]:
        """What functions of its spectrum take."""
        return self.model_dump(
            exclude={"kind", "size", "points", "periodic", "seed", "realisations"}
        )


class MeasuredMap(SceneTable):
    """A measured surface, read and treated by comparisons.geometry.faces.

    Without `detrend` a plane is subtracted; of a periodic map the mean (`TRENDS`).
    """

    kind: Literal["map"]
    file: Annotated[str, Field(min_length=1, max_length=4096)]
    size: SizePair | None = None
    height_unit: Annotated[str, Field(max_length=20)] | None = None
    lateral_unit: Annotated[str, Field(max_length=20)] | None = None
    channel: Annotated[str, Field(max_length=200), BeforeValidator(_named)] | None = None
    periodic: StrictBool = False  # before detrend, which depends on it
    detrend: Literal["none", "mean", "tilt", "curvature"] | None = None
    short_cutoff: Length | None = None  # of the Gaussian filter that takes shorter waves away
    crop: tuple[Index, Index, Window, Window] | None = None
    invert: StrictBool = False
    undefined: Literal["interpolate", "lowest", "refuse"] | None = None
    seed: Seed = 0
    realisations: Count = 100

    @field_validator("detrend")
    @classmethod
    def _a_trend_that_it_can_have(cls, value: str | None, info: ValidationInfo) -> str | None:
        problem = trend_problem(value, info.data.get("periodic", False))
        if problem:
            raise fail(problem)
        return value


Surface = Annotated[SelfAffine | MeasuredMap, Field(discriminator="kind")]


Heights = NDArray[np.float64]


class Trend(NamedTuple):
    """A polynomial in x and y."""

    powers: tuple[tuple[int, int], ...]  # powers of (x, y) of its terms
    done: str  # what its subtraction is called in the report


_LINEAR = ((0, 0), (1, 0), (0, 1))
TRENDS = {
    "none": Trend((), "left as read, no trend subtracted"),
    "mean": Trend(((0, 0),), "mean subtracted"),
    "tilt": Trend(_LINEAR, "least-squares plane subtracted"),
    "curvature": Trend(
        (*_LINEAR, (2, 0), (1, 1), (0, 2)), "least-squares polynomial of second order subtracted"
    ),
}


def trend_of(detrend: str | None, periodic: bool) -> str:
    """Return the trend to subtract: without a choice the plane, of a periodic map the mean."""
    return detrend or ("mean" if periodic else "tilt")


def trend_problem(detrend: str | None, periodic: bool) -> str:
    """Return why a trend cannot be subtracted, or an empty text.

    A plane or a parabola does not continue itself: subtracted from a periodic surface it leaves a
    jump at the sides, and a surface that depends on where its period was cut.
    """
    if detrend is not None and detrend not in TRENDS:
        return f"expected one of {', '.join(TRENDS)}, got {detrend!r}"
    if periodic and len(TRENDS[trend_of(detrend, periodic)].powers) > 1:
        return f"expected 'mean' (the default) or 'none' with periodic = true, got {detrend!r}"
    return ""


def subtracted(heights: Heights, defined: NDArray[np.bool_], trend: str) -> Heights:
    """Return the heights less the least-squares polynomial; NaN where they are not defined.

    The normal equations separate into moments X^T W Y of the weights W (1 on defined points), so
    that no matrix of the size of the map times the number of terms is formed. In coordinates from
    -1 to 1 they are well-conditioned; a second pass removes what the first one rounded off.
    """
    powers = TRENDS[trend].powers
    if not powers:
        return heights.copy()
    weight = defined.astype(np.float64)
    residual = np.where(defined, heights, 0.0)
    x, y = (np.vander(np.linspace(-1, 1, n), 5, increasing=True) for n in heights.shape)
    moments = x.T @ weight @ y
    matrix = np.array([[moments[a + c, b + d] for c, d in powers] for a, b in powers])
    for _ in range(2):
        projection = x.T @ residual @ y
        right = np.array([projection[a, b] for a, b in powers])
        coefficients = np.linalg.lstsq(matrix, right, rcond=None)[0]
        table = np.zeros((5, 5))
        for (a, b), value in zip(powers, coefficients, strict=True):
            table[a, b] = value
        residual -= (x @ table @ y.T) * weight
    return np.where(defined, residual, np.nan)
