"""The method `reduced`: the model under test, a profile or rough lines on independent springs."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial
from typing import NamedTuple

import numpy as np

from comparisons.geometry.bodies import BodyGeometry
from comparisons.geometry.faces import MeasuredFace, SyntheticFace, together
from comparisons.geometry.prepare import (
    IndenterGeometry,
    RoughGeometry,
    elastic_body,
    equivalent_profile,
    grading_of,
)
from comparisons.methods import Refused, Scene, Solver, Task, needed
from comparisons.methods.normal.closed_form import profile_fields, unit_rings
from comparisons.methods.runner import run
from comparisons.scene.loading import AbsoluteLoads
from comparisons.tasks.distributions import Stretches, of_values, wanted
from comparisons.tasks.solution import Solution, Stopwatch
from reduced.errors import ConvergenceError
from reduced.loads import EDGES, Load
from reduced.profiles import equivalents
from reduced.rough import ensemble, surface_spectrum
from reduced.rough import line_spectrum as spectrum
from reduced.rough.press import LineContact, RoughLines, press
from reduced.rough.regions import line_stress, regions
from reduced.rough.surface_spectrum import SelfAffineLaw, SurfaceSpectrum
from reduced.springs import stress
from reduced.springs.indent import Indentation, indent
from reduced.springs.layers import Coatings, Grading
from reduced.springs.line import Springs
from reference.layered.stack import Stack

# Rounds in which a force finds the radius that its own modulus depends on.
_ROUNDS = 200
_SETTLED = 1e-13


@dataclass(frozen=True)
class Bed:
    """The springs under a profile."""

    profile: equivalents.Profile
    modulus: float  # E* of all springs; of a graded body that of the springs at its depth c0
    # Their stiffness in words, and by which reading.
    springs: str = "E* dx"
    note: str = ""
    coatings: Coatings | None = None  # from which the modulus of each contact follows
    grading: Grading | None = None

    @property
    def uniform(self) -> bool:
        """Whether springs know one modulus, so that a pressure follows from them."""
        return self.coatings is None and self.grading is None

    def press(self, load: Load, per_radius: int, edges: str) -> Indentation:
        """Press the profile on the springs, at all loads at once."""
        if self.grading is not None:
            assert self.profile.section is not None
            even = self.grading.profile(self.profile.section)
            contact = indent(Springs(even, self.modulus, per_radius, edges=edges), load)
            return replace(contact, contact_radius=self.grading.place(contact.contact_radius))
        if self.coatings is None:
            return indent(Springs(self.profile, self.modulus, per_radius, edges=edges), load)
        # Springs of unit modulus; each contact has the modulus of its radius.
        springs = Springs(self.profile, 1.0, per_radius, edges=edges)
        moduli = np.ones(load.values.size)
        for _ in range(_ROUNDS):
            values = load.values / moduli if load.control == "force" else load.values
            contact = indent(springs, Load(load.control, values))
            before, moduli = moduli, self.coatings.modulus(contact.contact_radius)
            if load.control != "force" or np.abs(moduli / before - 1).max() <= _SETTLED:
                return replace(
                    contact,
                    force=contact.force * moduli,
                    stiffness=contact.stiffness * moduli,
                    # no potential: the modulus changes with the radius
                    energy=np.full_like(moduli, np.nan),
                )
        raise ConvergenceError("no radius has the modulus that its force asks for", [])


def bed_of(scene: Scene, profile: equivalents.Profile) -> Bed:
    """Return the springs for a scene's elastic body, by the reading of its options."""
    table = scene.half_space
    if table.grading is not None:
        if profile.section is None or scene.methods.reduced.rule != "mdr":
            raise Refused("springs for a graded half-space are known under bodies of revolution")
        grading, law = grading_of(scene), "c_N |x/c0|^k dx"
        note = "springs graded with the distance from the axis (Hess 2016)"
        return Bed(profile, grading.spring_modulus, law, note, grading=grading)
    if table.uniform:
        return Bed(profile, scene.effective_modulus)
    reading, body = scene.methods.reduced.layers, elastic_body(scene)
    assert isinstance(body, Stack)
    if reading == "effective":
        moduli = [material.effective_modulus for material in body.materials]
        base = np.inf if body.base is None else body.base.effective_modulus
        coatings = Coatings(body.thicknesses, moduli, base, body.top.poisson_ratio)
        note = "one modulus for each contact radius (Xu & Pharr 2006)"
        return Bed(profile, coatings.base, "E*(a) dx", note, coatings)
    lowest = "substrate" if body.base is not None else "layer on the rigid base"
    modulus, note = scene.effective_modulus, f"layers read as a half-space of the {lowest}"
    if reading == "layer":
        modulus, note = (
            body.top.effective_modulus,
            "layers read as a half-space of the uppermost one",
        )
    return Bed(profile, modulus, "E* dx", note)


# That compile everything.
_FEW_SPRINGS = 4
NO_PLANE = "the contact is not that of an indenter on a plane surface"


class ProfileSolver(Solver[IndenterGeometry]):
    """An equivalent profile on springs, whatever happens to it: what all physics share."""

    bodies = True
    rough = False  # rough surfaces become lines
    depths = True
    # What the physics adds to the model, in words.
    beside = ""
    # Why a scene without an indenter is none for this physics.
    only_indenters = NO_PLANE

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.indenter = needed(scene.indenter, self.only_indenters if scene.rough else NO_PLANE)
        rule = scene.methods.reduced.rule
        self.profile = equivalent_profile(self.indenter)
        if rule == "half_radius":
            if self.profile.section is None:
                raise Refused("the half-radius rule needs an axisymmetric section")
            self.profile = equivalents.half_radius(self.profile.section)
            read = "half the radius of curvature (19.17), for any shape"
        elif self.indenter.axisymmetric:
            read = "exact transform (MDR) of the axisymmetric profile"
        elif self.indenter.flat:
            read = "circle of equal area, D = (4 A/pi)^(1/2)"
        else:
            read = "Gaussian radius of curvature sqrt(Rx Ry)"
        self.modulus = scene.effective_modulus
        self.bed = bed_of(scene, self.profile)
        self.note = "; ".join(filter(None, [read, self.bed.note]))
        if scene.body is not None:
            self.note = "treats the [body] as a half-space; its error includes this approximation"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Springs per contact radius."""
        return self.series(40, 40, 1000)

    def refusal(self, task: Task[IndenterGeometry]) -> str:
        geometry = task.geometry
        return NO_PLANE if isinstance(geometry, BodyGeometry) and not geometry.flat_surface else ""

    def memory(self, task: Task[IndenterGeometry]) -> float:
        return 130.0 * task.resolution

    def model(self, geometry: IndenterGeometry) -> str:
        text = f"an equivalent 1-D profile on springs of stiffness {self.bed.springs}; {self.note}"
        return f"{text}; {self.beside}" if self.beside else text

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs: a few of them solve the task, whatever becomes of it."""
        run(self, replace(task, resolution=_FEW_SPRINGS, with_body=False))


class ReducedProfile(ProfileSolver):
    """Method of dimensionality reduction (chapter 19; Popov & Hess 2015)."""

    name = "reduced"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.edges = scene.methods.reduced.edges
        # The pressure below other outlines is no function of the line.
        self.stress = scene.methods.reduced.stress if self.indenter.axisymmetric else None

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        load = Load(task.loads.control, task.loads.values)
        contact = self.bed.press(load, task.resolution, self.edges)
        depths, radii = contact.penetration, np.asarray(contact.contact_radius)
        curves = {
            "penetration": depths,
            "force": contact.force,
            "equivalent_radius": radii,
            "contact_length": 2 * radii,
            "stiffness": contact.stiffness,
            "energy": contact.energy,
        }
        if not np.isfinite(contact.energy).all():
            del curves["energy"]
        solution = Solution.of(task, curves, unknowns=int(contact.springs))
        last = float(depths[-1]), float(radii[-1])
        solution.fields = line_picture(self.profile, *last, contact.spacing)
        if task.wants_pressure and self.stress is not None and self.bed.uniform:
            solution.fields |= self._pressure(*last)
            for step, (depth, radius) in enumerate(zip(depths, radii, strict=True)):
                solution.keep(task, (0, step), partial(self._pressure, float(depth), float(radius)))
        return solution

    def _pressure(self, depth: float, radius: float) -> dict[str, np.ndarray]:
        r = radius * unit_rings()[0]
        contact = self.profile, self.bed.modulus, depth, r
        if self.stress == "abel":
            pressure = stress.abel(*contact)
        elif self.stress == "one_radius":
            pressure = stress.one_radius_rule(*contact)
        else:
            pressure, valid = stress.local_rule(*contact)
            # Where the rule has no real value there is no pressure to show: NaN, and the report
            # counts it.
            pressure = np.where(valid, pressure, np.nan)
        return profile_fields(radius, radius, r, np.asarray(pressure))


def line_picture(
    profile: equivalents.Profile, penetration: float, contact_radius: float, spacing: float
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


# Lines that distributions are taken of: the mean of three hundred scatters by some per cent.
MOST_LINES = 300


def line_values(
    line: RoughLines, modulus: float, edges: str, depth: float, size: tuple[float, float]
) -> dict[str, Stretches]:
    """Return pressures, gaps and sizes of a line; weights as of a surface of the given sides."""
    contacts = regions(line, depth, edges=edges)
    # Of each stretch the deflections at its ends, its width, and its region (-1: none). A free line
    # goes on for half a cell beyond its outer points, at their height.
    heights = line.single()
    delta = heights - heights.max() + depth
    label = np.full(len(delta), -1)
    label[contacts.points] = contacts.region
    if line.periodic:
        begin, end = np.arange(len(delta)), np.roll(np.arange(len(delta)), -1)
        width = np.full(len(delta), line.spacing)
    else:
        points = np.arange(len(delta))
        begin, end = np.concatenate([[0], points]), np.concatenate([points, points[-1:]])
        width = np.full(len(delta) + 1, line.spacing)
        width[[0, -1]] /= 2
    first, last, region = delta[begin], delta[end], np.maximum(label[begin], label[end])
    touching = region >= 0
    share = np.pi / 4 * contacts.lengths[region[touching]]
    stiff = modulus / share
    area = size[0] * size[1]
    return {
        "pressure_distribution": Stretches(
            first[touching] * stiff,
            last[touching] * stiff,
            share * width[touching] / line.length**2,
        ),
        "gap_distribution": Stretches(-first, -last, width / line.length),
        "contact_sizes": Stretches.points(np.pi / 4 * contacts.lengths**2, area / line.length**2),
    }


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


class LineSolver(Solver[RoughGeometry]):
    """Rough lines on springs, whatever happens to them: what all physics share."""

    rough = True
    depths = True
    # What the physics adds to the model, in words.
    beside = ""

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        options = scene.methods.reduced
        if scene.surface is None:
            raise Refused("lines are drawn for rough surfaces")
        if scene.half_space.grading is not None:
            raise Refused("graded springs stand around the axis of one contact; a line has many")
        self.surface, self.modulus, reading = scene.surface, scene.effective_modulus, ""
        if not scene.half_space.uniform and options.layers == "effective":
            raise Refused("the effective modulus of layers is that of one contact with a radius")
        if not scene.half_space.uniform and options.layers == "layer":
            body = elastic_body(scene)
            assert isinstance(body, Stack)
            self.modulus, reading = body.top.effective_modulus, "; layers read as the uppermost one"
        elif not scene.half_space.uniform:
            reading = "; layers read as their substrate"
        self.note = f"rough line with C1D = pi q C2D (19.26), area rule (19.29){reading}"
        self.spectrum, self.points = options.spectrum, options.line_points
        self.length = options.line_length  # in sides of the surface
        self._shortest: float | None = None

    def resolutions(self, geometry: RoughGeometry) -> tuple[int, ...]:
        """Points per side of the surface's grid.

        The line then has two points for each of the grid's, so that it resolves the shortest
        wave that the grid holds.
        """
        if self.points is not None:
            return (max(2, round(self.points / 2 / self.length)),)
        n = max(geometry.points)
        return (n, 2 * n, 4 * n)

    def block(self, resolution: int) -> int:
        """Return how many lines are one task: a million points."""
        points = self.points or 2 * resolution * self.length
        return int(np.clip(1_000_000 // points, 1, 1000))

    def refusal(self, task: Task[RoughGeometry]) -> str:
        if self._shortest is None:  # the same at every resolution, and a second on a large map
            source = line_spectrum(task.geometry, self.spectrum)
            self._shortest = float(source.wavenumber[np.asarray(source.power) > 0].max())
        side = float(np.sqrt(task.geometry.area))
        waves = int(np.ceil(self._shortest * side / (2 * np.pi) * (1 - 1e-12)))
        if self._points(task) > 2 * waves * self.length:
            return ""
        return f"the shortest of {waves} waves per side needs more than {2 * waves} points"

    def memory(self, task: Task[RoughGeometry]) -> float:
        """Bytes of a block's lines with sorted copies and running sums."""
        return 80.0 * len(task.realisations) * self._points(task)

    def model(self, geometry: RoughGeometry) -> str:
        kinds = ("prescribed" if face.random else "measured" for face in geometry.faces)
        source = " and the ".join(dict.fromkeys(kinds))
        text = f"a rough line from the {source} 2-D spectrum, on springs of stiffness E* dx"
        return text + self.beside

    def warm_up(self, task: Task[RoughGeometry]) -> None:
        line = RoughLines(np.cos(np.arange(16.0)), 1.0)
        for control in ("penetration", "force"):
            for edges in EDGES:
                press(line, 1.0, Load(control, 0.5), edges=edges)

    def _points(self, task: Task[RoughGeometry]) -> int:
        return self.points or max(8, round(2 * task.resolution * self.length))

    def draw(self, task: Task[RoughGeometry]) -> Lines:
        """Return the lines of a task."""
        length = self.length * float(np.sqrt(task.geometry.area))
        source, count = line_spectrum(task.geometry, self.spectrum), len(task.realisations)
        seed = self.surface.seed
        random = ensemble.RandomLines(source, self._points(task), count, seed, length)
        return Lines(random.draw(task.realisations), self.length**2)


class ReducedLines(LineSolver):
    """Method of dimensionality reduction on rough lines (19.26), with the area rule (19.29)."""

    name = "reduced"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.stress, self.edges = scene.methods.reduced.stress, scene.methods.reduced.edges

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        with Stopwatch() as setup:
            lines = self.draw(task)
        load = Load(task.loads.control, lines.loads(task.loads))
        contact = press(lines.rough, self.modulus, load, edges=self.edges)
        curves = line_curves(contact, lines)
        if self.stress == "local" and task.wants_pressure:
            # The share of contact points where the local rule (19.37) has no real value.
            curves["local_stress_undefined_share"] = np.array(
                [
                    [line_stress(line, 1.0, d, edges=self.edges).undefined_share for d in depths]
                    for line, depths in zip(
                        (RoughLines(row, lines.rough.spacing) for row in lines.rough.heights),
                        contact.penetration,
                        strict=True,
                    )
                ]
            )
        solution = Solution.of(task, curves, unknowns=lines.points, setup_seconds=setup.seconds)
        if (names := wanted(task)) and task.realisations[0] < MOST_LINES:
            for row, depth in enumerate(contact.penetration[:MOST_LINES, -1]):
                size = task.geometry.size
                found = line_values(lines.rough[row], self.modulus, self.edges, float(depth), size)
                some = of_values(task, {name: found[name] for name in names})
                solution.put_distributions(row, some)
        # A mean gap wider than at first touch leaves a line without contact.
        for row, step in np.argwhere(contact.contact_count == 0):
            solution.fail((int(row), int(step)), "nothing touches at this load")
        if (0, task.shape[1] - 1) not in solution.reasons:
            solution.fields = line_fields(lines, float(contact.penetration[0, -1]))
        return solution


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


def line_spectrum(geometry: RoughGeometry, rule: str) -> spectrum.LineSpectrum:
    """Return the spectrum of the line: from the recipe of the surface, or from the measured map.

    Of two faces the spectra add: the phases of one do not know those of the other. Two measured
    maps are one, the sum of their heights.
    """
    random = [face for face in geometry.faces if isinstance(face, SyntheticFace)]
    if len(random) == 1 == len(geometry.faces):
        recipe = random[0].recipe
        law = SelfAffineLaw(**recipe.law)
        return spectrum.prescribed(recipe.points, recipe.size, law, rule=rule)
    return spectrum.line_of(whole_spectrum(geometry), rule)


def whole_spectrum(geometry: RoughGeometry) -> SurfaceSpectrum:
    """Return the power of all modes of a surface: prescribed, measured, or the sum of both."""
    random = [face for face in geometry.faces if isinstance(face, SyntheticFace)]
    parts = [
        surface_spectrum.self_affine(face.points, face.size, SelfAffineLaw(**face.recipe.law))
        for face in random
    ]
    maps = [face for face in geometry.faces if isinstance(face, MeasuredFace)]
    if maps:
        heights = together(maps, 0)
        parts.append(surface_spectrum.measured(heights, geometry.size, periodic=geometry.periodic))
    return SurfaceSpectrum(np.sum([part.power for part in parts], axis=0), parts[0].size)
