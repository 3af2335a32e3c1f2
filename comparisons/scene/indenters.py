"""Rigid indenters: their keys in scene files and their initial gaps.

One class per shape; what a new one needs elsewhere is listed in docs/where-things-are.md. The gap
f(x, y) is the height of the shape above the undeformed half-space at first touch: zero at the apex
or under a flat face, ``inf`` where the shape has no material (beyond a sharp edge). Grids and
meshes take the gap from here; the reduced model and the closed forms build their own description
from the same parameters, so they share no formula.
"""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import cached_property
from types import ModuleType
from typing import TYPE_CHECKING, Annotated, Any, Literal, Union, get_args

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator, model_validator

from comparisons.scene.fields import FiniteLength, Length, Positive, fail
from comparisons.scene.polygons import crosses_itself, sides, signed_area
from comparisons.scene.units import NUMBER, Dimension, to_si

if TYPE_CHECKING:
    from scipy.interpolate import PchipInterpolator

# The exact transform of a table costs the square of its points.
MOST_TABLE_POINTS = 2000


class Indenter(BaseModel):
    """What every shape has; the subclasses are the catalogue."""

    model_config = ConfigDict(extra="forbid", frozen=True, strict=False)

    shape: str

    @property
    def in_words(self) -> str:
        """The shape in words."""
        return self.shape.replace("_", " ")

    @property
    def parameters(self) -> dict[str, Any]:
        """Its sizes, by the names that functions of the shape take them by."""
        return self.model_dump(exclude={"shape"})

    def made_by(self, room: ModuleType, **more: float) -> Any:
        """Return what a module's public function of the shape's name makes; None without one."""
        if self.shape not in room.__all__:
            return None
        return getattr(room, self.shape)(**self.parameters, **more)

    @property
    def regular(self) -> bool:
        """Whether errors of grids were measured on its like: no corners, no kinks of a table."""
        return True

    @property
    def axisymmetric(self) -> bool:
        """Whether the gap depends on the radius only."""
        return True

    @property
    def quarter_symmetric(self) -> bool:
        """Whether x = 0 and y = 0 are planes of symmetry."""
        return True

    @property
    def even(self) -> tuple[bool, bool]:
        """Whether the gap is even in x, and in y: x = 0, y = 0 are planes of symmetry."""
        return (self.quarter_symmetric, self.quarter_symmetric)

    @property
    def face_area(self) -> float | None:
        """Area of a flat face, None where there is none, or one with a rounded edge."""
        return None

    @property
    def flat(self) -> bool:
        """Whether the contact is the whole flat face at any load."""
        return self.face_area is not None

    @property
    def outline(self) -> np.ndarray | None:
        """Corners (n, 2) of a flat face with straight sharp edges, else None."""
        return None

    @property
    def flat_within(self) -> float:
        """Radius of a flat part inside a rounded edge, 0 where there is none."""
        return 0.0

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the initial gap at the points (x, y)."""
        raise NotImplementedError

    def reach(self, penetration: float) -> tuple[float, float]:
        """Return half-widths in x and y of the region where the gap is below `penetration`.

        Contact can only be inside this geometric overlap, because the surface of a half-space
        without adhesion never rises above its undeformed level.
        """
        raise NotImplementedError


class _Axisymmetric(Indenter):
    """A shape given by f(r)."""

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return f(r)."""
        raise NotImplementedError

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return f(sqrt(x^2 + y^2))."""
        return self.radial_gap(np.hypot(x, y))

    def overlap_radius(self, penetration: float) -> float:
        """Return r with f(r) = penetration."""
        raise NotImplementedError

    def reach(self, penetration: float) -> tuple[float, float]:
        """Return the overlap radius in both directions."""
        radius = self.overlap_radius(penetration)
        return radius, radius


class RigidPlane(Indenter):
    """What presses where a scene has a [body] and no [indenter]: no scene file names it."""

    shape: Literal["plane"] = "plane"

    @property
    def axisymmetric(self) -> bool:
        """No: its contact has the shape of the body."""
        return False

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return zeros."""
        return np.zeros(np.shape(x))


class Paraboloid(_Axisymmetric):
    """f = r^2 / (2 R)."""

    shape: Literal["paraboloid"]
    radius: Length

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return r^2 / (2 R)."""
        return r**2 / (2 * self.radius)

    def overlap_radius(self, penetration: float) -> float:
        """Return sqrt(2 R d)."""
        return float(np.sqrt(2 * self.radius * penetration))


class Sphere(_Axisymmetric):
    """f = R - sqrt(R^2 - r^2), up to the equator."""

    shape: Literal["sphere"]
    radius: Length

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return the sphere's gap, in the form that keeps its digits near the apex."""
        ratio = np.asarray(r) / self.radius
        with np.errstate(invalid="ignore"):
            height = self.radius * ratio**2 / (1 + np.sqrt(1 - ratio**2))
        return np.where(ratio <= 1, height, np.inf)

    def overlap_radius(self, penetration: float) -> float:
        """Return sqrt(d (2 R - d)), at most R."""
        depth = min(penetration, self.radius)
        return float(np.sqrt(depth * (2 * self.radius - depth)))


class Cone(_Axisymmetric):
    """f = slope * r; the slope is the tangent of the angle between flank and surface."""

    shape: Literal["cone"]
    slope: Positive

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return slope * r."""
        return self.slope * r

    def overlap_radius(self, penetration: float) -> float:
        """Return d / slope."""
        return penetration / self.slope


class PowerLaw(_Axisymmetric):
    """f = coefficient * r^exponent; the coefficient has the unit m^(1 - exponent)."""

    shape: Literal["power_law"]
    exponent: Positive
    coefficient: float

    @field_validator("exponent")
    @classmethod
    def _monotone_slope(cls, value: float) -> float:
        if not 0.1 <= value <= 100:
            raise fail("expected an exponent from 0.1 to 100", value)
        return value

    @model_validator(mode="before")
    @classmethod
    def _coefficient_with_unit(cls, data: Any) -> Any:
        """Convert the coefficient here, because its unit depends on the exponent."""
        if not isinstance(data, dict) or not isinstance(data.get("coefficient"), str):
            return data
        try:
            exponent = to_si(data.get("exponent"), NUMBER)
            if not exponent.is_integer():
                return data
            dimension = Dimension(length=1 - int(exponent))
            return data | {"coefficient": to_si(data["coefficient"], dimension)}
        except ValueError:
            return data

    @field_validator("coefficient", mode="before")
    @classmethod
    def _positive_coefficient(cls, value: Any) -> float:
        number = isinstance(value, (int, float)) and not isinstance(value, bool)
        if not number or not sys.float_info.min <= value < sys.float_info.max:
            raise fail(
                "expected a positive number in m^(1 - exponent), or a text with that unit"
                ' (for an integer exponent) such as "1e6 m^-2" for exponent 3',
                value,
            )
        return float(value)

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return coefficient * r^exponent; inf, which never touches, where it overflows."""
        with np.errstate(over="ignore"):
            return self.coefficient * np.asarray(r) ** self.exponent

    def overlap_radius(self, penetration: float) -> float:
        """Return (d / coefficient)^(1 / exponent)."""
        return float((penetration / self.coefficient) ** (1 / self.exponent))


class Cylinder(_Axisymmetric):
    """A flat circular punch."""

    shape: Literal["cylinder"]
    radius: Length

    @property
    def face_area(self) -> float:
        """Area of the circle."""
        return float(np.pi * self.radius**2)

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return 0 on the face and inf outside."""
        return np.where(np.asarray(r) <= self.radius, 0.0, np.inf)

    def overlap_radius(self, penetration: float) -> float:
        """Return the radius of the face, at any depth."""
        return self.radius


class RoundedPunch(_Axisymmetric):
    """Flat to r = b, then (r - b)^2 / (2 R)."""

    shape: Literal["rounded_punch"]
    flat_radius: Length
    edge_radius: Length

    @property
    def flat_within(self) -> float:
        """The radius b."""
        return self.flat_radius

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return the height beyond the flat part."""
        return np.maximum(np.asarray(r) - self.flat_radius, 0) ** 2 / (2 * self.edge_radius)

    def overlap_radius(self, penetration: float) -> float:
        """Return b + sqrt(2 R d)."""
        return float(self.flat_radius + np.sqrt(2 * self.edge_radius * penetration))


class Profile(_Axisymmetric):
    """An axisymmetric table f(r) from r = 0, f = 0; a sharp edge at the last r."""

    shape: Literal["profile"]
    r: tuple[FiniteLength, ...]
    f: tuple[FiniteLength, ...]
    interpolation: Literal["pchip", "linear"] = "pchip"

    @property
    def regular(self) -> bool:
        """No."""
        return False

    @model_validator(mode="after")
    def _a_monotone_table(self) -> Profile:
        r, f = np.array(self.r), np.array(self.f)
        if len(r) > MOST_TABLE_POINTS:
            raise fail(f"expected at most {MOST_TABLE_POINTS} points, got {len(r)}")
        if len(r) != len(f) or len(r) < 2:
            raise fail(f"expected r and f of the same length, at least 2, got {len(r)}, {len(f)}")
        if r[0] != 0 or f[0] != 0 or np.any(np.diff(r) <= 0):
            raise fail("expected r strictly increasing from 0, and f = 0 at r = 0")
        if np.any(np.diff(f) < 0):
            first = int(np.argmax(np.diff(f) < 0))
            raise fail(
                f"expected a non-decreasing f: hollow profiles have no reduced model "
                f"(f decreases after r = {r[first]:g} m)"
            )
        return self

    @property
    def face_area(self) -> float | None:
        """Area inside the sharp edge where the table is all zeros: a cylinder."""
        return float(np.pi * self.r[-1] ** 2) if max(self.f) == 0 else None

    @cached_property
    def _interpolant(self) -> PchipInterpolator:
        from scipy.interpolate import PchipInterpolator

        return PchipInterpolator(self.r, self.f)

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return the interpolated table, inf beyond its end."""
        inside = np.minimum(r, self.r[-1])
        if self.interpolation == "linear":
            height = np.interp(inside, self.r, self.f)
        else:
            height = np.maximum(self._interpolant(inside), 0.0)
        return np.where(np.asarray(r) <= self.r[-1], height, np.inf)

    def overlap_radius(self, penetration: float) -> float:
        """Return a radius at which the table lies above `penetration`, or the edge."""
        above = np.flatnonzero(np.array(self.f) > penetration)
        if not len(above):
            return self.r[-1]
        # Halving between two tabulated radii: a table of few points must not ask for a grid that
        # reaches to the next of them.
        low, high = self.r[above[0] - 1], self.r[above[0]]
        for _ in range(30):
            middle = 0.5 * (low + high)
            if float(self.radial_gap(np.array(middle))) > penetration:
                high = middle
            else:
                low = middle
        return high


class Ellipsoid(Indenter):
    """x^2 / (2 Rx) + y^2 / (2 Ry), with radii of curvature Rx and Ry."""

    shape: Literal["ellipsoid"]
    radius_x: Length
    radius_y: Length

    @property
    def axisymmetric(self) -> bool:
        """Only when both radii are equal."""
        return self.radius_x == self.radius_y

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return the elliptic paraboloid."""
        return x**2 / (2 * self.radius_x) + y**2 / (2 * self.radius_y)

    def reach(self, penetration: float) -> tuple[float, float]:
        """Return sqrt(2 Rx d) and sqrt(2 Ry d)."""
        return (
            float(np.sqrt(2 * self.radius_x * penetration)),
            float(np.sqrt(2 * self.radius_y * penetration)),
        )


class _FlatPunch(Indenter):
    """A flat face with a sharp outline."""

    @property
    def axisymmetric(self) -> bool:
        """No."""
        return False

    @property
    def face_area(self) -> float:
        """Area of the face."""
        raise NotImplementedError


class EllipticPunch(_FlatPunch):
    """Flat face with semi-axes a (along x) and b (along y)."""

    shape: Literal["elliptic_punch"]
    semi_axes: tuple[Length, Length]

    @property
    def parameters(self) -> dict[str, Any]:
        """The semi-axes by a name each."""
        return {"semi_axis_x": self.semi_axes[0], "semi_axis_y": self.semi_axes[1]}

    @property
    def axisymmetric(self) -> bool:
        """Only when both axes are equal."""
        return self.semi_axes[0] == self.semi_axes[1]

    @property
    def face_area(self) -> float:
        """Area pi a b."""
        return float(np.pi * self.semi_axes[0] * self.semi_axes[1])

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return 0 on the face and inf outside."""
        a, b = self.semi_axes
        return np.where((x / a) ** 2 + (y / b) ** 2 <= 1, 0.0, np.inf)

    def reach(self, penetration: float) -> tuple[float, float]:
        """Return the semi-axes."""
        return self.semi_axes


class RightAngledPunch(_FlatPunch):
    """Flat rectangular face, sides along x and y."""

    @property
    def regular(self) -> bool:
        """No."""
        return False

    @property
    def lengths(self) -> tuple[float, float]:
        """Sides along x and y."""
        raise NotImplementedError

    @property
    def face_area(self) -> float:
        """Area of the rectangle."""
        return self.lengths[0] * self.lengths[1]

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return 0 on the face and inf outside."""
        half_x, half_y = self.reach(0.0)
        inside = (np.abs(x) <= half_x) & (np.abs(y) <= half_y)
        return np.where(inside, 0.0, np.inf)

    @property
    def outline(self) -> np.ndarray:
        """The four corners."""
        corners = np.array([[-0.5, -0.5], [0.5, -0.5], [0.5, 0.5], [-0.5, 0.5]])
        return corners * self.lengths

    def reach(self, penetration: float) -> tuple[float, float]:
        """Return half the sides."""
        return self.lengths[0] / 2, self.lengths[1] / 2


class SquarePunch(RightAngledPunch):
    """Flat square face, sides along x and y."""

    shape: Literal["square_punch"]
    side: Length

    @property
    def lengths(self) -> tuple[float, float]:
        """The side, twice."""
        return self.side, self.side


class RectanglePunch(RightAngledPunch):
    """Flat rectangular face, sides along x and y."""

    shape: Literal["rectangle_punch"]
    sides: tuple[Length, Length]

    @property
    def lengths(self) -> tuple[float, float]:
        """The sides."""
        return self.sides


class PolygonPunch(_FlatPunch):
    """Flat face with the outline of a simple polygon; its centroid is moved to the origin."""

    shape: Literal["polygon_punch"]
    vertices: tuple[tuple[FiniteLength, FiniteLength], ...]

    @property
    def regular(self) -> bool:
        """No."""
        return False

    @model_validator(mode="after")
    def _a_simple_polygon(self) -> PolygonPunch:
        corners = np.array(self.vertices)
        if len(corners) < 3:
            raise fail(f"expected at least 3 vertices, got {len(corners)}")
        if len(corners) > 1000:
            raise fail(f"expected at most 1000 vertices, got {len(corners)}")
        span = np.ptp(corners, axis=0).max()
        if not span or abs(signed_area(corners)) < 1e-12 * span**2:
            raise fail("expected a polygon with non-zero area")
        if crosses_itself(corners):
            raise fail("expected a simple polygon, got one whose sides touch or cross")
        return self

    @cached_property
    def corners(self) -> np.ndarray:
        """Vertices relative to the centroid, shape (n, 2), counter-clockwise."""
        corners = np.array(self.vertices)
        if signed_area(corners) < 0:
            corners = corners[::-1]
        corners = corners - corners.mean(axis=0)
        following = np.roll(corners, -1, axis=0)
        cross = corners[:, 0] * following[:, 1] - corners[:, 1] * following[:, 0]
        centroid = ((corners + following) * cross[:, None]).sum(axis=0) / (3 * cross.sum())
        return corners - centroid

    @property
    def outline(self) -> np.ndarray:
        """The vertices."""
        return self.corners

    @property
    def quarter_symmetric(self) -> bool:
        """Not even a rectangle among the polygons is meshed as one: its lines are even."""
        return False

    @cached_property
    def even(self) -> tuple[bool, bool]:
        """Whether the outline is its own mirror image; to rounding, corner by corner."""
        noise = 1e-9 * float(np.ptp(self.corners, axis=0).max())

        def mirrored(signs: tuple[int, int]) -> bool:
            image = self.corners * signs
            return all(np.abs(self.corners - corner).max(axis=1).min() < noise for corner in image)

        return mirrored((-1, 1)), mirrored((1, -1))

    @property
    def face_area(self) -> float:
        """Area by the shoelace formula."""
        return abs(signed_area(np.array(self.vertices)))

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return 0 inside (even-odd rule) and inf outside."""
        x, y = np.broadcast_arrays(x, y)
        inside = np.zeros(x.shape, dtype=bool)
        for (x0, y0), (x1, y1) in sides(self.corners):
            straddles = (y0 > y) != (y1 > y)
            if y0 != y1:
                inside ^= straddles & (x < x0 + (y - y0) * (x1 - x0) / (y1 - y0))
        return np.where(inside, 0.0, np.inf)

    def reach(self, penetration: float) -> tuple[float, float]:
        """Return the half-widths of the box around the centroid."""
        half = np.abs(self.corners).max(axis=0)
        return float(half[0]), float(half[1])


def _catalogue(family: type[Indenter]) -> Iterator[type[Indenter]]:
    """Yield the classes that a scene file can name: their `shape` is theirs, and required."""
    for model in family.__subclasses__():
        if "shape" in model.__annotations__ and model.model_fields["shape"].is_required():
            yield model
        yield from _catalogue(model)


_MODELS = {
    get_args(model.model_fields["shape"].annotation)[0]: model for model in _catalogue(Indenter)
}
SHAPES = tuple(_MODELS)

if TYPE_CHECKING:
    AnyIndenter = Indenter
else:
    AnyIndenter = Annotated[Union[tuple(_MODELS.values())], Field(discriminator="shape")]  # noqa: UP007 - made of a tuple
