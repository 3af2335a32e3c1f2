"""The method `reduced`: the model under test, a profile or a rough line on independent springs."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.prepare import (
    Geometry,
    IndenterGeometry,
    RoughGeometry,
    equivalent_profile,
)
from comparisons.methods.base import Method, Solution, Support, Task
from comparisons.methods.radial import profile_fields, unit_rings
from comparisons.scene.method_names import METHOD_NAMES
from comparisons.scene.options import ReducedOptions
from comparisons.scene.scene import Scene
from comparisons.scene.shapes import Indenter, RigidPlane
from reduced.errors import ConvergenceError
from reduced.profiles import shapes
from reduced.rough import ensemble, regions, surface_spectrum
from reduced.rough import line_spectrum as spectrum
from reduced.rough.press import LineContact, press
from reduced.springs import stress
from reduced.springs.indent import Indentation, indent


class Reduced(Method):
    """Method of dimensionality reduction (chapter 19; Popov & Hess 2015)."""

    name = "reduced"
    title = METHOD_NAMES[name].title
    dimension = METHOD_NAMES[name].dimension

    def supports(self, scene: Scene) -> Support:
        """Every scene; the rule used is the reason."""
        if scene.indenter is None:
            return Support(True, "rough line with C1D = pi q C2D (19.26), area rule (19.29)")
        options = scene.methods.reduced
        if options.rule == "half_radius" and equivalent_profile(scene.indenter).section is None:
            return Support(False, "the half-radius rule needs an axisymmetric section")
        return Support(True, _rule(scene.indenter, options))

    def supports_body(self, geometry: BodyGeometry) -> Support:
        """Under an indenter on a plane surface, as if the body were a half-space."""
        if isinstance(geometry.indenter, RigidPlane) or not geometry.flat_surface:
            return Support(False, "the contact is not that of an indenter on a plane surface")
        return Support(True, "takes the [body] for a half-space: its error is that of doing so")

    def resolutions(self, scene: Scene, geometry: Geometry) -> tuple[int, ...]:
        """Springs per contact radius; on rough scenes the points per side of the surface's grid.

        The line then has two points for each of the grid's, so that it resolves the shortest
        wave that the grid holds.
        """
        if isinstance(geometry, RoughGeometry):
            points = scene.methods.reduced.line_points
            if points is not None:
                return (max(2, round(points / 2 / scene.methods.reduced.line_length)),)
            n = max(geometry.points)
            return (n, 2 * n, 4 * n)
        finest = int(np.clip(40 * np.sqrt(0.01 / scene.compare.tolerance), 40, 1000))
        return finest // 4, finest // 2, finest

    def refused(self, task: Task) -> str:
        """Refuse lines too coarse for their own shortest wave."""
        if not isinstance(task.geometry, RoughGeometry):
            return ""
        waves = highest_mode(task.geometry, _options(task))
        if _line_points(task) > 2 * waves * _options(task).line_length:
            return ""
        return f"the shortest of {waves} waves per side needs more than {2 * waves} points"

    def memory(self, task: Task) -> float:
        """Bytes of a block's lines with sorted copies and running sums, or of the springs."""
        if isinstance(task.geometry, RoughGeometry):
            return 80.0 * len(task.realisations) * _line_points(task)
        return 130.0 * task.resolution

    def model(self, scene: Scene, geometry: Geometry) -> str:
        """Name the line."""
        if isinstance(geometry, RoughGeometry):
            source = "prescribed" if geometry.recipe is not None else "measured"
            return f"a rough line from the {source} 2-D spectrum, on springs of stiffness E* dx"
        return f"an equivalent 1-D profile on springs of stiffness E* dx; {_rule_of(scene)}"

    def warm_up(self, task: Task) -> None:
        """Compile the springs of a profile, or the walk along a line."""
        options = _options(task)
        if not isinstance(task.geometry, RoughGeometry):
            small = shapes.power_law(4.0, 1.0)
            control: dict[str, Any] = {task.loads.control: np.array([0.5, 1.0])}
            indent(small, 1.0, **control, springs=4, edges=options.edges)
            return
        line = np.cos(np.arange(16.0))[None, :]
        load: dict[str, Any] = {task.loads.control: np.array([0.5])}
        press(line, 1.0, 1.0, **load, edges=options.edges, periodic=True)

    def solve(self, task: Task) -> Solution:
        """Solve all loads at once, from one profile or one set of lines."""
        solution = Solution.empty(task)
        try:
            if isinstance(task.geometry, RoughGeometry):
                _solve_lines(task, task.geometry, solution)
            else:
                _solve_profile(task, task.geometry, solution)
        except ConvergenceError as error:
            for index in np.ndindex(solution.converged.shape):
                solution.fail((index[0], index[1]), error.reason)
        return solution


def _options(task: Task) -> ReducedOptions:
    assert isinstance(task.options, ReducedOptions)
    return task.options


def _rule_of(scene: Scene) -> str:
    assert scene.indenter is not None
    return _rule(scene.indenter, scene.methods.reduced)


def _rule(indenter: Indenter, options: ReducedOptions) -> str:
    if options.rule == "half_radius":
        return "half the radius of curvature (19.17), for any shape"
    if indenter.axisymmetric:
        return "exact transform (MDR) of the axisymmetric profile"
    if indenter.flat:
        return "circle of equal area, D = (4 A/pi)^(1/2)"
    return "Gaussian radius of curvature sqrt(Rx Ry)"


def profile_of(scene: Scene) -> shapes.Profile:
    """Return the 1-D profile of a scene's indenter, by the rule of the scene's options."""
    assert scene.indenter is not None
    profile = equivalent_profile(scene.indenter)
    if scene.methods.reduced.rule == "half_radius":
        assert profile.section is not None
        return shapes.half_radius(profile.section)
    return profile


def _solve_profile(task: Task, geometry: IndenterGeometry, solution: Solution) -> None:
    options, modulus = _options(task), task.scene.effective_modulus
    with solution.setup():
        profile = profile_of(task.scene)
    load: dict[str, Any] = task.loads.keyword
    contact = indent(profile, modulus, **load, springs=task.resolution, edges=options.edges)
    radius = np.asarray(contact.contact_radius)
    area = np.pi * radius**2
    curves = {
        "penetration": contact.penetration,
        "force": contact.force,
        "contact_area": area,
        "contact_area_raw": area,
        "equivalent_radius": radius,
        "contact_length": 2 * radius,
        "stiffness": contact.stiffness,
        "contact_length_stiffness": contact.stiffness / modulus,
        "energy": contact.energy,
    }
    if geometry.indenter.axisymmetric:
        curves["contact_radius"] = radius
    solution.quantities = {k: np.array(v, dtype=float)[None, :] for k, v in curves.items()}
    solution.converged[:] = True
    solution.unknowns = int(contact.springs)
    solution.fields = _profile_fields(task, geometry, profile, contact)
    if _has_pressure(task, geometry):
        for step, depth in enumerate(contact.penetration):
            build = partial(_radial, task, profile, float(depth), float(radius[step]))
            solution.keep((0, step), build)


def line_picture(
    profile: shapes.Profile, penetration: float, contact_radius: float, spacing: float
) -> dict[str, np.ndarray]:
    """Return the fields that the report draws the one-dimensional model from."""
    x = np.linspace(-1.5, 1.5, 301) * contact_radius
    x = x[np.abs(x) <= profile.edge]
    return {
        "penetration": np.array(penetration),
        "profile_x": x,
        "profile_height": np.asarray(profile.height(np.abs(x))),
        "profile_spacing": np.array(spacing),
    }


def _profile_fields(
    task: Task,
    geometry: IndenterGeometry,
    profile: shapes.Profile,
    contact: Indentation,
) -> dict[str, np.ndarray]:
    depth, radius = float(contact.penetration[-1]), float(contact.contact_radius[-1])
    fields = line_picture(profile, depth, radius, contact.spacing)
    return fields | (_radial(task, profile, depth, radius) if _has_pressure(task, geometry) else {})


def _has_pressure(task: Task, geometry: IndenterGeometry) -> bool:
    """Tell whether a pressure is asked for and exists: a map from 1-D does for round bodies."""
    return task.wants_pressure and geometry.indenter.axisymmetric


def _radial(
    task: Task, profile: shapes.Profile, depth: float, radius: float
) -> dict[str, np.ndarray]:
    r = radius * unit_rings()[0]
    return profile_fields(radius, radius, r, _pressure(task, profile, depth, r))


def _pressure(task: Task, profile: shapes.Profile, depth: float, r: np.ndarray) -> np.ndarray:
    modulus = task.scene.effective_modulus
    if _options(task).stress == "abel":
        return np.asarray(stress.abel(profile, modulus, depth, r))
    pressure, valid = stress.local_rule(profile, modulus, depth, r)
    # Where the rule has no real value there is no pressure to show: NaN, and the report counts it.
    return np.where(valid, pressure, np.nan)


def _line_points(task: Task) -> int:
    options = _options(task)
    return options.line_points or max(8, round(2 * task.resolution * options.line_length))


def draw_lines(task: Task, geometry: RoughGeometry) -> tuple[np.ndarray, float, float]:
    """Return the lines of a task, the distance of their points, and how many patches one is.

    A line of length L1 stands for a patch of side L1 (19.29) under the same nominal pressure: it
    carries F = p L1^2, and its area, force and stiffness are those of L1^2.
    """
    options = _options(task)
    length = options.line_length * float(np.sqrt(geometry.area))
    points = _line_points(task)
    source = line_spectrum(geometry, options)
    seed = _seed(task.scene)
    lines = ensemble.lines(source, points, task.realisations, seed=seed, length=length)
    return lines, length / points, options.line_length**2


def _solve_lines(task: Task, geometry: RoughGeometry, solution: Solution) -> None:
    options, modulus = _options(task), task.scene.effective_modulus
    with solution.setup():
        lines, spacing, patches = draw_lines(task, geometry)
    loads = task.loads.values
    if task.loads.control == "force":
        loads = loads * patches
    load: dict[str, Any] = {task.loads.control: loads}
    contact = press(lines, spacing, modulus, **load, edges=options.edges, periodic=True)
    solution.quantities = _line_quantities(contact, lines, patches, modulus)
    if options.stress == "local" and task.wants_pressure:
        solution.quantities["local_stress_undefined_share"] = _undefined_shares(
            lines, spacing, contact.penetration, options.edges
        )
    # A mean gap wider than at first touch leaves a line without contact: a step without answer.
    solution.converged[:] = contact.contact_count > 0
    for row, step in np.argwhere(~solution.converged):
        solution.fail((int(row), int(step)), "nothing touches at this load")
        for values in solution.quantities.values():
            values[row, step] = np.nan
    solution.unknowns = lines.shape[1]
    if not solution.converged[0, -1]:
        return
    solution.fields = {
        "penetration": np.array(contact.penetration[0, -1]),
        "line_x": np.arange(lines.shape[1]) * spacing,
        "line_height": lines[0],
        "line_penetration": np.array(contact.penetration[0, -1]),
    }


def _line_quantities(
    contact: LineContact, lines: np.ndarray, patches: float, modulus: float
) -> dict[str, np.ndarray]:
    """Return the quantities of lines that each stand for a number of patches, per patch."""
    peak = lines.max(axis=1) - lines.mean(axis=1)
    area = contact.contact_area / patches
    return {
        "penetration": contact.penetration,
        "penetration_mean_plane": contact.penetration - peak[:, None],
        "force": contact.force / patches,
        "contact_area": area,
        "contact_area_raw": area,
        "equivalent_radius": np.sqrt(area / np.pi),
        "contact_length": contact.contact_length / patches,
        "contact_count": contact.contact_count / patches,
        "mean_gap": contact.mean_gap,
        "stiffness": contact.stiffness / patches,
        "contact_length_stiffness": contact.stiffness / patches / modulus,
        "energy": contact.energy / patches,
    }


def _undefined_shares(
    lines: np.ndarray, spacing: float, penetration: np.ndarray, edges: str
) -> np.ndarray:
    """Return the share of contact points where the local rule (19.37) has no real value."""
    return np.array(
        [
            [
                regions.line_stress(line, spacing, 1.0, d, edges=edges).undefined_share
                for d in depths
            ]
            for line, depths in zip(lines, penetration, strict=True)
        ]
    )


def line_spectrum(geometry: RoughGeometry, options: ReducedOptions) -> spectrum.LineSpectrum:
    """Return the spectrum of the line: from the recipe of the surface, or from the measured map."""
    recipe = geometry.recipe
    if recipe is not None:
        names = ("hurst", "power", "rms_slope", "rms_height", "long_cutoff", "short_cutoff")
        return spectrum.prescribed(
            recipe.points,
            recipe.size,
            **{name: getattr(recipe, name) for name in names},
            rule=options.spectrum,
        )
    heights = geometry.heights(0, geometry.points[0])
    surface = surface_spectrum.measured(heights, geometry.size, periodic=geometry.periodic)
    return spectrum.line_of(surface, options.spectrum)


def _seed(scene: Scene) -> int:
    assert scene.surface is not None
    seed: int = scene.surface.seed
    return seed


def highest_mode(geometry: RoughGeometry, options: ReducedOptions) -> int:
    """Return the number of the shortest wave per side that the surface's spectrum holds."""
    source = line_spectrum(geometry, options)
    present = source.wavenumber[np.asarray(source.power) > 0]
    side = float(np.sqrt(geometry.area))
    return int(np.ceil(float(present.max()) * side / (2 * np.pi) * (1 - 1e-12)))
