"""The method `reduced` on rough surfaces: lines with the surface's spectrum, on springs."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from comparisons.geometry.elastic_body import elastic_body
from comparisons.geometry.faces import MeasuredFace, SyntheticFace, together
from comparisons.geometry.prepare import RoughGeometry
from comparisons.methods.normal.line_distributions import Springs, put_distributions
from comparisons.methods.solver import Refused, Solver
from comparisons.scene.options import ReducedOptions
from comparisons.scene.physics.absolute_loads import AbsoluteLoads
from comparisons.scene.scene import Scene
from comparisons.scene.surface import SelfAffine as SelfAffineTable
from comparisons.tasks.solution import Solution, Stopwatch
from comparisons.tasks.task import Task
from reduced.loads import Load
from reduced.rough import ensemble, regions, surface_spectrum
from reduced.rough import line_spectrum as spectrum
from reduced.rough.lines import RoughLines
from reduced.rough.press import LineContact, press
from reduced.rough.surface_spectrum import SelfAffine, SurfaceSpectrum
from reference.layered.stack import Stack, plane_modulus


class Lines(NamedTuple):
    """Heights (realisations, points), the distance of the points, and how many patches one is.

    A line of length L1 stands for a patch of side L1 (19.29) under the same nominal pressure: it
    carries F = p L1^2, and its area, force and stiffness are those of L1^2.
    """

    rough: RoughLines
    patches: float

    @property
    def points(self) -> int:
        """Points of a line."""
        return self.rough.heights.shape[1]

    def loads(self, loads: AbsoluteLoads) -> np.ndarray:
        """Return the loads of a line under those of a patch."""
        return loads.values * self.patches if loads.control == "force" else loads.values


class ReducedLines(Solver[RoughGeometry]):
    """Method of dimensionality reduction on rough lines (19.26), with the area rule (19.29)."""

    name = "reduced"
    depths = True
    options_read = frozenset(
        {"stress", "edges", "spectrum", "line_length", "line_points", "layers"}
    )

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.options = scene.methods.reduced
        if scene.surface is None:
            raise Refused("lines are drawn for rough surfaces")
        self.surface = scene.surface
        self.modulus, reading = _modulus(scene)
        self.note = f"rough line with C1D = pi q C2D (19.26), area rule (19.29){reading}"
        if scene.half_space.uniform:
            self.options_read -= {"layers"}

    @classmethod
    def takes(cls, scene: Scene) -> bool:
        """Rough surfaces."""
        return scene.rough

    def resolutions(self, geometry: RoughGeometry) -> tuple[int, ...]:
        """Points per side of the surface's grid.

        The line then has two points for each of the grid's, so that it resolves the shortest
        wave that the grid holds.
        """
        points = self.options.line_points
        if points is not None:
            return (max(2, round(points / 2 / self.options.line_length)),)
        n = max(geometry.points)
        return (n, 2 * n, 4 * n)

    def block(self, resolution: int) -> int:
        """Return how many lines are one task: a million points."""
        points = self.options.line_points or 2 * resolution * self.options.line_length
        return int(np.clip(1_000_000 // points, 1, 1000))

    def refusal(self, task: Task[RoughGeometry]) -> str:
        """Refuse lines too coarse for their own shortest wave."""
        waves = highest_mode(task.geometry, self.options)
        if self._points(task) > 2 * waves * self.options.line_length:
            return ""
        return f"the shortest of {waves} waves per side needs more than {2 * waves} points"

    def memory(self, task: Task[RoughGeometry]) -> float:
        """Bytes of a block's lines with sorted copies and running sums."""
        return 80.0 * len(task.realisations) * self._points(task)

    def model(self, geometry: RoughGeometry) -> str:
        """Name the line."""
        kinds = ("prescribed" if face.random else "measured" for face in geometry.faces)
        source = " and the ".join(dict.fromkeys(kinds))
        return f"a rough line from the {source} 2-D spectrum, on springs of stiffness E* dx"

    def warm_up(self, task: Task[RoughGeometry]) -> None:
        """Compile the walk along a line."""
        line = RoughLines(np.cos(np.arange(16.0)), 1.0)
        press(line, 1.0, Load(task.loads.control, 0.5), edges=self.options.edges)

    def _points(self, task: Task[RoughGeometry]) -> int:
        options = self.options
        return options.line_points or max(8, round(2 * task.resolution * options.line_length))

    def draw(self, task: Task[RoughGeometry]) -> Lines:
        """Return the lines of a task."""
        length = self.options.line_length * float(np.sqrt(task.geometry.area))
        points = self._points(task)
        source = line_spectrum(task.geometry, self.options)
        count = len(task.realisations)
        random = ensemble.RandomLines(source, points, count, self.surface.seed, length)
        return Lines(random.draw(task.realisations), self.options.line_length**2)

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        """Press all lines to all loads at once."""
        with Stopwatch() as setup:
            lines = self.draw(task)
        load = Load(task.loads.control, lines.loads(task.loads))
        contact = press(lines.rough, self.modulus, load, edges=self.options.edges)
        curves = line_curves(contact, lines)
        if self.options.stress == "local" and task.wants_pressure:
            shares = _undefined_shares(lines, contact.penetration, self.options.edges)
            curves["local_stress_undefined_share"] = shares
        solution = Solution.of(task, curves, unknowns=lines.points, setup_seconds=setup.seconds)
        springs = Springs(self.modulus, self.options.edges)
        put_distributions(solution, task, lines.rough, springs, contact.penetration[:, -1])
        # A mean gap wider than at first touch leaves a line without contact.
        for row, step in np.argwhere(contact.contact_count == 0):
            solution.fail((int(row), int(step)), "nothing touches at this load")
        if (0, task.shape[1] - 1) not in solution.reasons:
            solution.fields = line_fields(lines, float(contact.penetration[0, -1]))
        return solution


def _modulus(scene: Scene) -> tuple[float, str]:
    """Return E* of all springs, and by which reading of layers.

    Raises
    ------
    Refused
        For readings that need one contact with a radius.
    """
    reading = scene.methods.reduced.layers
    if scene.half_space.grading is not None:
        raise Refused("graded springs stand around the axis of one contact; a line has many")
    if scene.half_space.uniform or reading == "substrate":
        note = "" if scene.half_space.uniform else "; layers read as their substrate"
        return scene.effective_modulus, note
    if reading == "effective":
        raise Refused("the effective modulus of layers is that of one contact with a radius")
    body = elastic_body(scene)
    assert isinstance(body, Stack)
    return plane_modulus(body.top), "; layers read as the uppermost one"


def line_fields(lines: Lines, penetration: float) -> dict[str, np.ndarray]:
    """Return the first of the lines, for pictures."""
    return {
        "penetration": np.array(penetration),
        "line_x": np.arange(lines.points) * lines.rough.spacing,
        "line_height": lines.rough.heights[0],
        "line_penetration": np.array(penetration),
    }


def line_curves(contact: LineContact, lines: Lines) -> dict[str, np.ndarray]:
    """Return the quantities of lines that each stand for a number of patches, per patch."""
    heights, patches = lines.rough.heights, lines.patches
    peak = heights.max(axis=1) - heights.mean(axis=1)
    return {
        "penetration": contact.penetration,
        "penetration_mean_plane": contact.penetration - peak[:, None],
        "force": contact.force / patches,
        "contact_area": contact.contact_area / patches,
        "contact_length": contact.contact_length / patches,
        "contact_count": contact.contact_count / patches,
        "mean_gap": contact.mean_gap,
        "stiffness": contact.stiffness / patches,
        "energy": contact.energy / patches,
    }


def _undefined_shares(lines: Lines, penetration: np.ndarray, edges: str) -> np.ndarray:
    """Return the share of contact points where the local rule (19.37) has no real value."""
    return np.array(
        [
            [
                regions.line_stress(
                    RoughLines(line, lines.rough.spacing), 1.0, d, edges=edges
                ).undefined_share
                for d in depths
            ]
            for line, depths in zip(lines.rough.heights, penetration, strict=True)
        ]
    )


def line_spectrum(geometry: RoughGeometry, options: ReducedOptions) -> spectrum.LineSpectrum:
    """Return the spectrum of the line: from the recipe of the surface, or from the measured map.

    Of two faces the spectra add: the phases of one do not know those of the other. Two measured
    maps are one, the sum of their heights.
    """
    random = [face for face in geometry.faces if isinstance(face, SyntheticFace)]
    if len(random) == 1 == len(geometry.faces):
        recipe = random[0].recipe
        return spectrum.prescribed(
            recipe.points, recipe.size, _roughness(recipe), rule=options.spectrum
        )
    return spectrum.line_of(whole_spectrum(geometry), options.spectrum)


def whole_spectrum(geometry: RoughGeometry) -> SurfaceSpectrum:
    """Return the power of all modes of a surface: prescribed, measured, or the sum of both."""
    random = [face for face in geometry.faces if isinstance(face, SyntheticFace)]
    parts = [
        surface_spectrum.self_affine(face.points, face.size, _roughness(face.recipe))
        for face in random
    ]
    maps = [face for face in geometry.faces if isinstance(face, MeasuredFace)]
    if maps:
        heights = together(maps, 0)
        parts.append(surface_spectrum.measured(heights, geometry.size, periodic=geometry.periodic))
    return SurfaceSpectrum(np.sum([part.power for part in parts], axis=0), parts[0].size)


def _roughness(recipe: SelfAffineTable) -> SelfAffine:
    names = ("hurst", "power", "rms_slope", "rms_height", "long_cutoff", "short_cutoff")
    return SelfAffine(**{name: getattr(recipe, name) for name in names})


def highest_mode(geometry: RoughGeometry, options: ReducedOptions) -> int:
    """Return the number of the shortest wave per side that the surface's spectrum holds."""
    source = line_spectrum(geometry, options)
    present = source.wavenumber[np.asarray(source.power) > 0]
    side = float(np.sqrt(geometry.area))
    return int(np.ceil(float(present.max()) * side / (2 * np.pi) * (1 - 1e-12)))
