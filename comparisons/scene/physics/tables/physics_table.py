"""Base class of the physics tables, such as [friction]."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING, Any, ClassVar

from comparisons.scene.fields import SceneTable
from comparisons.scene.loading import Control

if TYPE_CHECKING:
    from comparisons.scene.scene import Scene


class PhysicsTable(SceneTable):
    """A table that switches on physics beyond frictionless elastic contact.

    A subclass with a `key` is a table of scenes, its fields are the table's keys; unknown ones are
    errors. Methods solve scenes with it where their solvers name it in `physics`.

    key: the name of the table.
    place: where plans name it among others, of whose `compared` the first counts; new ones come
    last.
    compared: what is compared where a scene does not say, in place of an elastic scene's
    quantities.
    adds: what is compared beside those, where no table of the scene replaces them.
    apart: other tables that contradict this one, or with which nothing here could be meant -> why.
    two_constants: why one elastic constant, E*, does not do; "" where it does.
    remembers: what a normal load does depends on those before it: loads are a path, in the order
    given.
    one_body: with it the properties of two elastic bodies do not add up to one E*.
    """

    key: ClassVar[str] = ""
    place: ClassVar[float] = math.inf
    compared: ClassVar[tuple[str, ...]] = ()
    adds: ClassVar[tuple[str, ...]] = ()
    apart: ClassVar[Mapping[str, str]] = {}
    two_constants: ClassVar[str] = ""
    remembers: ClassVar[bool] = False
    one_body: ClassVar[bool] = False

    @property
    def varied(self) -> tuple[Control, tuple[float, ...]] | None:
        """Along what a scene is solved, and its values, in place of the normal loads; or None."""
        return None

    @classmethod
    def misfits(cls, data: Mapping[str, Any], loading: Mapping[str, Any]) -> Iterator[str]:
        """Yield what in the raw tables of a scene does not go with this one, or is missing."""
        yield from ()

    def check(self, scene: Scene) -> None:
        """Raise what is wrong with this table in a scene whose single tables are right."""

    def description(self, poisson_ratio: float) -> tuple[str, str]:
        """Say in the plan what acts, and how; by default the docstring and the keys."""
        keys = ", ".join(f"{key} = {value}" for key, value in self.model_dump().items())
        return (type(self).__doc__ or self.key).strip().splitlines()[0].rstrip("."), keys
