"""What a plan says of its scene: notes, what is not modelled and why, which physics act."""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from comparisons.facts.methods import ELEMENTS, GRID
from comparisons.facts.quantities import quantity
from comparisons.formatting import number, relative, unpadded, with_unit
from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.plausibility import scene_notes, surface_notes
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.normal.grid import SIDE, cells
from comparisons.scene.half_space import HalfSpace
from comparisons.scene.indenters.axisymmetric import Paraboloid, Sphere
from comparisons.scene.loading import AbsoluteLoads
from comparisons.scene.scene import Scene
from comparisons.solving.plan import MethodPlan, Plan
from comparisons.tasks.shown_loads import MOST_POINTS
from comparisons.tasks.stresses import FROM_PRESSURE
from reference.dynamics.collision import radiation_number, weak_loss

LARGE_LOSS = 0.3  # of energy: from here on the first order in the radiation says no number

EDGE_CELLS = 4  # of a grid, across which the pressure on a rounded edge has its peak


def notes_of(draft: Plan, methods: tuple[MethodPlan, ...]) -> Iterable[str]:
    """Yield what a reader of the results should know of the surface, the body and the effort."""
    scene, geometry = draft.scene, draft.geometry
    if isinstance(geometry, RoughGeometry):
        yield from (*geometry.treatment, *surface_notes(geometry))
    # which nominal pressures the forces on a rough surface or a flat face are
    loads = draft.loads.normal or draft.loads
    rough = geometry if isinstance(geometry, RoughGeometry) else None
    face = geometry.indenter.face_area if isinstance(geometry, IndenterGeometry) else None
    area = rough.area if rough else face
    if loads.control == "force" and area is not None:
        with np.errstate(over="ignore"):  # absurd forces are answered by the solvers
            pressures = loads.values / area
        said = f"loads: F = {_span(loads.values, 'N')}, nominal pressure F/A0 = "
        said += _span(pressures, "Pa")
        if rough:
            shares = pressures / (scene.effective_modulus * rough.rms_slope)
            said += f", F/(E* A0 h') = {_span(shares)}"
        yield said
    yield from scene_notes(scene, geometry, draft.loads)
    grids = [max(m.resolutions) for m in methods if m.method == GRID and m.resolutions]
    finest = max(grids, default=0)
    stresses = FROM_PRESSURE - {"pressure_peak"} & set(scene.compare.quantities)
    if isinstance(geometry, RoughGeometry) and cells(geometry, finest) > MOST_POINTS:
        yield (
            f"fields of {GRID} above {MOST_POINTS} cells are stored as means over blocks, "
            f"at most {SIDE} a side; quantities are of all cells"
            + (", but for stresses inside, which are not computed" if stresses else "")
        )
    if isinstance(geometry, IndenterGeometry) and geometry.indenter.flat_within and finest:
        edge = geometry.contact_radius - geometry.indenter.flat_within
        if edge < EDGE_CELLS * geometry.contact_radius / finest:
            yield (
                f"rounded edge: contact on it is at most {with_unit(edge, 'm')} wide, "
                f"{number(edge * finest / geometry.contact_radius, 2)} cells of {GRID} at N = "
                f"{finest}: too few for the pressure there; finer compare.resolutions, or a method "
                "of round bodies"
            )
    if scene.physics and draft.realisations < scene.realisations:
        yield (
            f"quick: {draft.realisations} of {scene.realisations} realisations "
            "(--full runs all of them)"
        )
    if isinstance(geometry, RoughGeometry) and draft.loads.control == "mean_gap":
        # means of nonlinear curves differ by what is held
        yield (
            "means over surfaces and lines are taken at equal mean gap, where the few with high "
            "peaks carry most of the force: prescribe the force for means at equal force, which is "
            "another curve"
        )
    if scene.counter_body is not None:
        yield "both bodies are elastic: their compliances 1/E* add"
    assumed = scene.half_space.poisson_ratio is None and scene.viscoelastic is None
    if assumed and any(m.method == ELEMENTS and m.supported for m in methods):
        yield "only E* is given: fem takes nu = 0.3; frictionless contact depends on E* alone"
    if draft.loads.normal is not None and len(scene.loading.range.values) > 1:
        yield "only the last of the normal loads is held"


def _span(values: np.ndarray, unit: str = "") -> str:
    ends = dict.fromkeys((values.min(), values.max()))
    return " to ".join(with_unit(end, unit) if unit else number(end) for end in ends)


def omissions(scene: Scene, geometry: Geometry) -> Iterable[tuple[str, str]]:
    """Yield what is not modelled, with the reason."""
    quantities = set(scene.compare.quantities)
    if "pressure" not in quantities:
        yield "comparison of pressures", 'not asked for (add "pressure" to compare.quantities)'
    if not quantities & {"stiffness", "contact_length_stiffness"}:
        yield (
            "contact stiffness, in the half-space methods",
            "not asked for; it would need one more linear solve per load",
        )
    if scene.half_space.layers or scene.half_space.thickness is not None:
        yield "slip and gaps between layers", "layers are bonded to what lies below"
    if scene.physics:  # else memory, friction, adhesion and inertia were never in question
        if scene.viscoelastic is None:
            yield "memory of the material", "no [viscoelastic] in the scene: nothing relaxes"
        if scene.friction is None and scene.sliding is None:
            yield "tangential displacements at the surface", "no friction in the scene"
        if scene.friction is not None:
            if scene.friction.coupling == "none":
                yield "tangential displacements due to pressure", 'coupling = "none" in [friction]'
            elif scene.poisson_ratio != 0.5:
                yield (
                    "tangential displacements due to pressure, in the reduced model",
                    "its normal and tangential springs are uncoupled, "
                    "which is exact only at ν = 1/2",
                )
            if scene.poisson_ratio != 0 and scene.loading.tangential is not None:
                yield (
                    "slip across the tangential load, in the reduced model",
                    "its springs slip along the load alone: "
                    "exact at ν = 0, and below a flat circle",
                )
        if scene.adhesion is None:
            yield "attraction of the surfaces", "no [adhesion] in the scene"
        if scene.dynamics is None and not scene.methods.fem.inertia:
            yield "inertia", "no [dynamics] in the scene: loading is quasi-static"
        elif scene.dynamics is not None:
            yield "waves in the half-space", _waves(scene)
        if scene.sliding is not None:
            yield "Coulomb friction at the surface", "the loss is due to the body alone"
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


def switched_on(scene: Scene, loads: AbsoluteLoads) -> Iterable[tuple[str, str]]:
    """Yield each part of the physics beyond frictionless elastic contact, and how it acts."""
    body = scene.half_space
    if body.grading is not None:
        law = f"E (z/{with_unit(body.grading.depth, 'm')})^{number(body.grading.exponent)}"
        text = f"a half-space graded as {law} at the depth z, E = {_modulus(body)}"
        yield "elastic body", text
    elif not body.uniform:  # from its surface down
        parts = [
            f"{with_unit(layer.thickness, 'm')} of E = {with_unit(layer.youngs_modulus, 'Pa')}, "
            f"ν = {number(layer.poisson_ratio)}"
            for layer in body.layers
        ]
        main = f"E = {_modulus(body)}, ν = {number(body.nu)}"
        if body.thickness is None:
            parts.append(f"below a half-space of {main}")
        else:
            parts += [f"{with_unit(body.thickness, 'm')} of {main}", "below a rigid base"]
        yield "elastic body", "; ".join(parts)
    for name in scene.physics:
        yield getattr(scene, name).description(scene.poisson_ratio)
    if not scene.physics:
        return
    # what the steps are, and at which normal load
    steps = len(loads.values)
    control_label = quantity(loads.control).label
    if loads.axis == "step":
        text = f"a path of {steps} steps in {control_label}"
    elif loads.axis == "time":
        history = "" if loads.control == "time" else f" of {control_label}"
        text = f"a history{history} in {steps} times"
    else:
        text = f"{steps} independent values of {control_label}"
    if loads.normal is not None:
        normal = quantity(loads.normal.control)
        text += f", at {normal.label} {unpadded(float(loads.normal.values[0]), normal.unit)}"
    yield "load axis", text


def _waves(scene: Scene) -> str:
    """Say that the half-space has no mass, and what waves take from a ball if it is as dense."""
    ball, table = scene.indenter, scene.dynamics
    said = "it has no mass: right while the speed is far below that of sound"
    uniform = scene.half_space.uniform and scene.viscoelastic is None
    if table is None or table.at_rest or not (isinstance(ball, Sphere | Paraboloid) and uniform):
        return said
    modulus, nu, radius = scene.half_space.modulus, scene.half_space.nu, ball.radius
    if nu < 0:  # beyond the range of `radiation_number`
        return said
    speed = max(table.velocity.values)
    density = table.mass / (4 / 3 * np.pi * radius**3)
    depth = (15 / 16 * table.mass * speed**2 / (scene.effective_modulus * radius**0.5)) ** 0.4
    force = 4 / 3 * scene.effective_modulus * radius**0.5 * depth**1.5
    shear = modulus * (1 - nu) / 2
    delay = radiation_number(nu) / (2 * np.pi * shear * (shear / density) ** 0.5)
    lost = weak_loss(delay * force * speed / depth**2)
    taken = f"about {relative(lost)}" if lost < LARGE_LOSS else "a large part"
    sound = (modulus * (1 - nu**2) / density) ** 0.5
    return (
        f"{said}. As dense as a ball of this mass, it would take {taken} of the energy at "
        f"{with_unit(speed, 'm/s')}, v/c0 = {number(speed / sound, 2)} (Johnson 1985, 11.4)"
    )


def _modulus(body: HalfSpace) -> str:
    return with_unit(body.elastic_constants[0], "Pa")
