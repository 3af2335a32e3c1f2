"""What every indenter has, and every round one."""

from __future__ import annotations

from types import ModuleType
from typing import Any, ClassVar, Literal

import numpy as np

from comparisons.scene.fields import SceneTable


class Indenter(SceneTable):
    """What every shape has; its subclasses in this package are the catalogue."""

    shape: str
    # Whether errors of grids were measured on its like: no corners, no kinks of a table.
    regular: ClassVar[bool] = True

    def __eq__(self, other: object) -> bool:
        """Compare the keys: what properties remember of them, arrays among it, cannot differ."""
        return isinstance(other, type(self)) and self.model_dump() == other.model_dump()

    @property
    def in_words(self) -> str:
        """The shape in words."""
        return self.shape.replace("_", " ")

    @property
    def parameters(self) -> dict[str, Any]:
        """Its sizes, by the names that functions of the shape take them by."""
        return self.model_dump(exclude={"shape"})

    def made_by(self, module: ModuleType, **more: float) -> Any:
        """Return what a module's public function of the shape's name makes; None without one."""
        make = getattr(module, self.shape, None)
        return make(**self.parameters, **more) if callable(make) else None

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
    def sharp_tip(self) -> bool:
        """Whether the gap has a slope at the tip: then the material below yields at any load.

        Tables of heights say False: their slope at the tip is one of the interpolation.
        """
        return False

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


class Axisymmetric(Indenter):
    """A shape given by f(r)."""

    def radial_gap(self, r: np.ndarray) -> np.ndarray:
        """Return f(r)."""
        raise NotImplementedError

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return self.radial_gap(np.hypot(x, y))

    def overlap_radius(self, penetration: float) -> float:
        """Return r with f(r) = penetration."""
        raise NotImplementedError

    def reach(self, penetration: float) -> tuple[float, float]:
        radius = self.overlap_radius(penetration)
        return radius, radius


class RigidPlane(Indenter):
    """What presses where a scene has a [body] and no [indenter]: no scene file names it."""

    shape: Literal["plane"] = "plane"
    axisymmetric: ClassVar[bool] = False  # its contact has the shape of the body

    def gap(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return np.zeros(np.shape(x))
