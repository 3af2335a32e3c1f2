"""Rigid indenters: their keys in scene files and their initial gaps.

One class per shape; a new file here adds its shapes, and what they need elsewhere is listed in
docs/reading.md. The gap f(x, y) is the height of the shape above the undeformed half-space
at first touch: zero at the apex or under a flat face, ``inf`` where the shape has no material
(beyond a sharp edge). Grids and meshes take the gap from here; the reduced model and the closed
forms build their own description from the same parameters, so they share no formula.
"""

from __future__ import annotations

import sys
from typing import TYPE_CHECKING, Annotated, Any, Union, get_args

from pydantic import BeforeValidator, Field

from comparisons.discovery import classes_of
from comparisons.scene.indenters.indenter import Indenter

# What a scene file can name: the `shape` is the class's own, and required.
_MODELS = {
    get_args(model.model_fields["shape"].annotation)[0]: model
    for model in classes_of(sys.modules[__name__], Indenter)
    if "shape" in model.__annotations__ and model.model_fields["shape"].is_required()
}
SHAPES = tuple(_MODELS)


def _in_small_letters(table: Any) -> Any:
    """Return the table of an indenter with its shape as it is spelt here."""
    if isinstance(table, dict) and isinstance(table.get("shape"), str):
        return table | {"shape": table["shape"].lower()}
    return table


if TYPE_CHECKING:
    AnyIndenter = Indenter
else:
    _Shapes = Annotated[Union[tuple(_MODELS.values())], Field(discriminator="shape")]  # noqa: UP007 - made of a tuple
    AnyIndenter = Annotated[_Shapes, BeforeValidator(_in_small_letters)]
