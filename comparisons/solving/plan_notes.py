"""What a plan says about itself: what is not modelled and why, and what to keep in mind."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from comparisons.facts.methods import ELEMENTS, GRID
from comparisons.formatting import number, with_unit
from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.plausibility import scene_notes, surface_notes
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.normal.grid import SIDE, cells
from comparisons.scene.physics.descriptions import left_out
from comparisons.scene.scene import Scene
from comparisons.solving.plan import Plan
from comparisons.solving.plan_record import MethodPlan
from comparisons.tasks.shown_loads import MOST_POINTS

# Means of nonlinear curves differ by what is held: where the gap is, high peaks carry most force.
MEANS_AT_EQUAL_GAP = (
    "means over surfaces and lines are taken at equal mean gap, where the few with high peaks "
    "carry most of the force: prescribe the force for means at equal force, which is another curve"
)


def notes_of(draft: Plan, methods: tuple[MethodPlan, ...]) -> Iterable[str]:
    """Yield what a reader of the results should know of the surface, the body and the effort."""
    scene, geometry = draft.scene, draft.geometry
    if isinstance(geometry, RoughGeometry):
        yield from (*geometry.treatment, *surface_notes(geometry))
    yield from _loads(draft)
    yield from scene_notes(scene, geometry)
    grids = [max(m.resolutions) for m in methods if m.method == GRID and m.resolutions]
    finest = max(grids, default=0)
    if isinstance(geometry, RoughGeometry) and cells(geometry, finest) > MOST_POINTS:
        yield (
            f"fields of {GRID} above {MOST_POINTS} cells are stored as means over blocks, "
            f"at most {SIDE} a side; quantities are of all cells"
        )
    if scene.physics and draft.realisations < scene.realisations:
        yield (
            f"quick: {draft.realisations} of {scene.realisations} realisations "
            "(--full runs all of them)"
        )
    if isinstance(geometry, RoughGeometry) and draft.loads.control == "mean_gap":
        yield MEANS_AT_EQUAL_GAP
    if scene.counter_body is not None:
        yield "both bodies are elastic: their compliances 1/E* add"
    assumed = scene.half_space.poisson_ratio is None and scene.viscoelastic is None
    if assumed and any(m.method == ELEMENTS and m.supported for m in methods):
        yield "only E* is given: fem takes nu = 0.3; frictionless contact depends on E* alone"
    if draft.loads.normal is not None and len(scene.loading.range.values) > 1:
        yield "only the last of the normal loads is held"


def _loads(draft: Plan) -> Iterable[str]:
    """Say which nominal pressures the forces on a rough surface or a flat face are."""
    geometry, loads = draft.geometry, draft.loads.normal or draft.loads
    rough = geometry if isinstance(geometry, RoughGeometry) else None
    face = geometry.indenter.face_area if isinstance(geometry, IndenterGeometry) else None
    area = rough.area if rough else face
    if loads.control != "force" or area is None:
        return
    with np.errstate(over="ignore"):  # absurd forces are answered by the solvers
        pressures = loads.values / area
    said = f"loads: F = {_span(loads.values, 'N')}, nominal pressure F/A0 = "
    said += _span(pressures, "Pa")
    if rough:
        shares = pressures / (draft.scene.effective_modulus * rough.rms_slope)
        said += f", F/(E* A0 h') = {_span(shares)}"
    yield said


def _span(values: np.ndarray, unit: str = "") -> str:
    ends = dict.fromkeys((values.min(), values.max()))
    return " to ".join(with_unit(end, unit) if unit else number(end) for end in ends)


def omissions(scene: Scene, geometry: Geometry) -> Iterable[tuple[str, str]]:
    """Yield what is not modelled, with the reason."""
    quantities = set(scene.compare.quantities)
    if "pressure" not in quantities:
        yield "pressure fields", 'not asked for (add "pressure" to compare.quantities)'
    if not quantities & {"stiffness", "contact_length_stiffness"}:
        yield (
            "contact stiffness, in the half-space methods",
            "not asked for; it would need one more linear solve per load",
        )
    yield from left_out(scene)
    if isinstance(geometry, BodyGeometry):
        yield "a far field", "the body is finite and held only by its supports"
    elif isinstance(geometry, IndenterGeometry):
        if scene.adhesion is None:
            yield (
                "the surface beyond the geometric overlap",
                "contact cannot reach it, because without adhesion the surface never rises",
            )
        if geometry.indenter.axisymmetric and not geometry.indenter.flat:
            yield "three dimensions, in the reduced model", "a line carries the same force"
        even = geometry.indenter.even
        if all(even) and not scene.physics:
            planes = "x = 0 and y = 0 are symmetry planes"
            yield "three quarters of the finite-element mesh", planes
        elif any(even) and not scene.physics:
            yield (
                "half of the finite-element mesh",
                f"{'xy'[even.index(True)]} = 0 is a symmetry plane",
            )
    else:
        yield (
            "the body below the surface, in the half-space methods",
            "its response to pressure is known in closed form (kernel)",
        )
