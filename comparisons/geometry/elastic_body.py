"""The elastic body of a scene whose stiffness depends on depth."""

from __future__ import annotations

from comparisons.scene.scene import Scene
from reference.elasticity import Material
from reference.layered import Graded, Stack


def elastic_body(scene: Scene) -> Stack | Graded:
    """Return the layers or the grading of a scene; a half-space is a stack without layers."""
    table = scene.half_space
    material = Material(*table.elastic_constants)
    if table.grading is not None:
        return Graded(material, table.grading.exponent, table.grading.depth)
    thicknesses = [layer.thickness for layer in table.layers]
    materials = [Material(layer.youngs_modulus, layer.poisson_ratio) for layer in table.layers]
    if table.thickness is None:
        return Stack(thicknesses, materials, material)
    return Stack([*thicknesses, table.thickness], [*materials, material])
