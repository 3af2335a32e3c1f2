"""The method `fem`: the 3-D finite-element body under a rigid shape."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import Any

import numpy as np

from comparisons.geometry import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.methods.sweeps import outcomes
from comparisons.options import FemOptions
from comparisons.scene import Scene
from comparisons.shapes import Ellipsoid, Indenter, PolygonPunch, RoundedPunch, SquarePunch
from reference import fem
from reference.errors import ConvergenceError
from reference.halfspace.areas import corrected_area

LARGEST_POISSON = 0.4999
# Surface points per side of a rough patch: 32 take 2 s, and the cost grows as the fourth power.
LARGEST_PATCH = 48
# Condensed compliance, elimination fronts and mesh, per unknown: measured peak over 20 000 to
# 60 000 unknowns, rounded up.
BYTES_PER_UNKNOWN = 20_000
ELLIPSE_EXPONENT = 1 / 3


class Fem(Method):
    """Elastic body of hexahedra with a Boussinesq far field, condensed onto the surface."""

    name = "fem"
    title = "finite elements"

    def supports(self, scene: Scene) -> Support:
        """Free half-space, nu up to 0.4999, force or penetration control."""
        _, nu = scene.half_space.elastic_constants
        if nu > LARGEST_POISSON:
            return Support(
                False, f"nu = {nu:g} is incompressible: a displacement element locks above 0.4999"
            )
        if scene.loading.control == "mean_gap":
            return Support(False, "no mean-gap control")
        if scene.surface is not None and scene.surface.periodic:
            return Support(False, "models one free patch, not a periodic half-space")
        return Support(True)

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Elements per contact radius; a rough patch takes the points of its map."""
        if isinstance(geometry, RoughGeometry):
            n, most = geometry.points[0], max(geometry.points)
            return tuple(f * n for f in (1, 2, 3) if f * most <= LARGEST_PATCH) or (n,)
        if geometry.indenter.flat or _edge(geometry.indenter, geometry.contact_radius):
            # Elements crowd towards the edge, so each resolution costs several times more.
            return (3, 4, 5) if scene.compare.tolerance >= 0.003 else (4, 6, 8)
        return (4, 6, 8) if scene.compare.tolerance >= 0.003 else (6, 9, 12)

    def refused(self, task: Task) -> str:
        """Refuse patches whose elimination would take minutes."""
        if not isinstance(task.geometry, RoughGeometry):
            return ""
        points = max(task.geometry.heights(0, task.resolution).shape)
        if points <= LARGEST_PATCH:
            return ""
        return f"{points} points per side, more than {LARGEST_PATCH}: the mesh would be too large"

    def memory(self, task: Task) -> float:
        """Bytes of the elimination, from the number of unknowns expected."""
        if isinstance(task.geometry, RoughGeometry):
            return BYTES_PER_UNKNOWN * 1.1 * task.resolution**3
        return BYTES_PER_UNKNOWN * 250.0 * task.resolution**2

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the mesh."""
        far = "outside it Boussinesq fields"
        if isinstance(geometry, RoughGeometry):
            return f"a block below the patch, mesh nodes at the points of the map; {far}"
        part = "a quarter of " if geometry.indenter.quarter_symmetric else ""
        return f"{part}a block of graded hexahedra around the contact; {far}"

    def solve(self, task: Task) -> Solution:
        """Build and condense the body once, then press it load by load."""
        solution = Solution.empty(task)
        assert isinstance(task.options, FemOptions)
        with solution.setup():
            body = make_body(task)
        solution.unknowns = body.unknowns
        last: fem.Contact | None = None
        for row, realisation in enumerate(task.realisations):
            gap = _gap(task, body, realisation)
            for step, outcome in enumerate(
                outcomes(_sweep(task, body, gap), task.loads.values, ConvergenceError)
            ):
                if isinstance(outcome, ConvergenceError):
                    solution.fail((row, step), outcome.reason)
                    continue
                solution.put((row, step), _quantities(task, body, gap, outcome))
                solution.iterations[row, step] = outcome.iterations
                solution.violation[row, step] = outcome.violation
                if row == 0 and step == len(task.loads.values) - 1:
                    last = outcome
        if last is not None:
            solution.fields = _fields(task, body, last)
        return solution


def _sweep(
    task: Task, body: fem.CondensedBody, gap: np.ndarray
) -> Callable[[np.ndarray], Iterator[fem.Contact]]:
    options = task.options
    assert isinstance(options, FemOptions)

    def run(loads: np.ndarray) -> Iterator[fem.Contact]:
        load: dict[str, Any] = {task.loads.control: loads}
        return fem.press(body, gap, **load, contact=options.contact, penalty=options.penalty)

    return run


def make_body(task: Task) -> fem.CondensedBody:
    """Return the condensed half-space that fits the scene's contact."""
    modulus, nu = task.scene.half_space.elastic_constants
    geometry = task.geometry
    if isinstance(geometry, RoughGeometry):
        shape = geometry.heights(task.realisations[0], task.resolution).shape
        lines = [
            (np.arange(n) + 0.5) * side / n for n, side in zip(shape, geometry.size, strict=True)
        ]
        return fem.tensor_body(*lines, modulus, nu)
    indenter = geometry.indenter
    if isinstance(indenter, (SquarePunch, PolygonPunch)):
        return _punch_body(geometry, task.resolution, modulus, nu)
    radius = geometry.contact_radius
    return fem.ball_body(
        radius,
        modulus,
        nu,
        elements=task.resolution,
        edge=_edge(indenter, radius),
        stretch=_stretch(indenter),
    )


def _edge(indenter: Indenter, radius: float) -> float | None:
    """Return where the mesh should have a circle: a sharp edge, or the end of a flat part."""
    if indenter.flat:
        return radius
    if isinstance(indenter, RoundedPunch) and indenter.flat_radius >= 0.2 * radius:
        return indenter.flat_radius
    return None


def _stretch(indenter: Indenter) -> tuple[float, float]:
    """Return how the contact ellipse deviates from the circle of equal area.

    Hertz: the ratio of the semi-axes is close to (Rx/Ry)^(2/3); the mesh need not know better.
    """
    if isinstance(indenter, Ellipsoid):
        ratio = (indenter.radius_x / indenter.radius_y) ** ELLIPSE_EXPONENT
        return ratio, 1 / ratio
    axes = getattr(indenter, "semi_axes", None)
    if axes is not None:
        ratio = float(np.sqrt(axes[0] / axes[1]))
        return ratio, 1 / ratio
    return 1.0, 1.0


def _punch_body(
    geometry: IndenterGeometry, resolution: int, modulus: float, nu: float
) -> fem.CondensedBody:
    """Return a mesh of straight lines; at the edges of a square they crowd, where it is sharp."""
    half_x, half_y = geometry.reach
    counts = [max(2, round(h * resolution / geometry.contact_radius)) for h in (half_x, half_y)]
    if geometry.indenter.quarter_symmetric:
        lines = [
            half * (1 - (1 - np.arange(n + 1) / n) ** 2)
            for half, n in zip((half_x, half_y), counts, strict=True)
        ]
        return fem.tensor_body(*lines, modulus, nu, symmetry="quarter", order=2)
    lines = [
        np.linspace(-half, half, 2 * n + 1)
        for half, n in zip((half_x, half_y), counts, strict=True)
    ]
    return fem.tensor_body(*lines, modulus, nu)


def _gap(task: Task, body: fem.CondensedBody, realisation: int) -> np.ndarray:
    if isinstance(task.geometry, RoughGeometry):
        heights = task.geometry.heights(realisation, task.resolution)
        return np.ravel(heights.max() - heights)
    # A mesh node on a sharp edge belongs to the face: its rounding must not decide.
    points = body.points * (1 - 1e-9)
    return task.geometry.indenter.gap(points[:, 0], points[:, 1])


def _quantities(
    task: Task, body: fem.CondensedBody, gap: np.ndarray, contact: fem.Contact
) -> dict[str, float]:
    area = _area(task.geometry, contact)
    values = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area": area,
        "contact_area_raw": contact.contact_area_raw,
        "equivalent_radius": float(np.sqrt(area / np.pi)),
        "stiffness": contact.stiffness,
        "contact_length_stiffness": contact.stiffness / body.effective_modulus,
        "energy": contact.energy,
    }
    if isinstance(task.geometry, RoughGeometry):
        values["mean_gap"] = float(np.mean(gap + contact.displacement) - contact.penetration)
        values["penetration_mean_plane"] = contact.penetration - float(gap.mean())
    elif task.geometry.indenter.axisymmetric:
        values["contact_radius"] = values["equivalent_radius"]
    return values


def _area(geometry: Geometry, contact: fem.Contact) -> float:
    """Return the best estimate of the contact area.

    The nodes of a rough patch form a grid, so the perimeter correction of grids applies. The face
    of a punch whose edges are mesh lines is known.
    """
    if isinstance(geometry, RoughGeometry):
        points = round(np.sqrt(contact.active.size * geometry.points[0] / geometry.points[1]))
        mask = contact.active.reshape(points, -1)
        spacing = geometry.spacing(mask)
        return float(corrected_area(mask, spacing))
    if isinstance(geometry.indenter, SquarePunch):
        return geometry.indenter.area
    return contact.contact_area


def _fields(task: Task, body: fem.CondensedBody, contact: fem.Contact) -> dict[str, np.ndarray]:
    """Return pressure and, with it, the body's displacement and stress for pictures and VTU."""
    fields = {"penetration": np.array(contact.penetration)}
    if isinstance(task.geometry, RoughGeometry):
        fields["heights"] = task.geometry.heights(task.realisations[0], task.resolution)
        fields["size"] = np.array(task.geometry.size)
        fields["contact"] = (contact.pressure > 0).reshape(fields["heights"].shape)
    if not task.wants_pressure:
        return fields
    recovered = fem.recover(body, contact.reactions)
    fields |= {
        "pressure_x": body.points[:, 0],
        "pressure_y": body.points[:, 1],
        "pressure": contact.pressure,
        # The symmetric parts count with the one that is meshed.
        "pressure_weight": body.symmetry * body.weights,
        "mesh_points": recovered.points,
        "mesh_cells": recovered.hexahedra,
        "mesh_displacement": recovered.displacement,
        "mesh_von_mises": recovered.von_mises,
    }
    return fields
