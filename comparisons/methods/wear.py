"""Rigid bodies that wear on an elastic half-space, in sliding or in fretting.

Springs wear round bodies by their exact pressure, or lines by (19.37); cells of a grid by their own
pressure; a flat punch in closed form (Galin; Goryacheva 1998).
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry
from comparisons.methods import Refused, Row, Scene, Solution, Step, Task, needed
from comparisons.methods.friction import normal_load
from comparisons.methods.normal.bem import BemFft
from comparisons.methods.normal.closed_form import FormSolver
from comparisons.methods.normal.grid import SMALL_BALL, Grid, contact_quantities
from comparisons.methods.normal.reduced import Lines, LineSolver, ProfileSolver
from reduced import wear as worn_springs
from reduced.loads import Load
from reduced.rough.press import RoughLines
from reduced.wear import LineRule, RoundBody, WearingBody, WearingLine, WornLine
from reference import loads as reference_loads
from reference.closed_form.worn import WornPunch
from reference.contact.body import ElasticBody
from reference.halfspace import areas
from reference.halfspace.wear import Oscillation, wear

SLIDING = frozenset({"wear"})
FRETTING = frozenset({"wear", "friction"})
# Points of a worn profile that are kept for the report.
_POINTS = 160


def motion_of(scene: Scene) -> tuple[float, tuple[float, float] | None]:
    """Return k, and amplitude U and lag G* U/(mu E*) of the oscillation: None where all slides."""
    table = needed(scene.wear, "no [wear]")
    if table.amplitude is None or scene.friction is None:
        return table.coefficient, None
    ratio = scene.tangential_modulus / (scene.friction.coefficient * scene.effective_modulus)
    return table.coefficient, (table.amplitude, ratio * table.amplitude)


def worn_picture(r: np.ndarray, shapes: list[np.ndarray]) -> dict[str, np.ndarray]:
    """Return the fields of worn profiles: heights at distances r, unworn and at each step."""
    keep = np.unique(np.linspace(0, r.size - 1, min(r.size, _POINTS)).round().astype(int))
    return {"worn_r": r[keep], "worn_shapes": np.array(shapes)[:, keep]}


_RULES: dict[str, LineRule] = {"local": "own_curvature", "one_radius": "one_radius"}
_WORDS = {
    "abel": "the body wears by its exact pressure and its profile follows",
    "local": "the profile itself wears by the stress (19.37), with its curvature at each spring",
    "one_radius": "the profile itself wears by the stress (19.37), with one radius for a contact",
}
# Widths of a line of heights beyond the reach of the contact.
_BEYOND = 1.05


class ReducedWear(ProfileSolver):
    """A profile over springs that wears under a constant load."""

    name = "reduced"
    physics = SLIDING

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.stress = scene.methods.reduced.stress
        self.coefficient, self.swing = motion_of(scene)
        if not self.indenter.axisymmetric:
            raise Refused("springs wear round bodies only")
        self.beside = _WORDS[self.stress]

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Springs per contact radius; steps grow in number with them."""
        return self.series(40, 40, 120)

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the matrices between rings and springs."""
        return 8.0 * 8 * (4 * task.resolution) ** 2

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Yield the profile, on springs fitted to what sticks at the start."""
        reach = min(_BEYOND * float(task.geometry.reach[0]), self.profile.edge)
        width = task.geometry.contact_radius
        if self.swing is not None:
            control, depth = normal_load(task)
            if control == "force":
                load = Load("force", depth)
                depth = float(self.bed.press(load, 40, "sub_cell").penetration[0])
            if depth > self.swing[1]:
                width = float(self.profile.contact_radius(depth - self.swing[1])) or width
        # what sticks at the start ends between two springs, so that all of a ring wears or none
        spacing = width / max(1, round(task.resolution * width / task.geometry.contact_radius))
        count = max(2, int(np.ceil(reach / spacing - 1e-9)))
        if count * spacing > self.profile.edge:
            spacing = self.profile.edge / count
        body: WearingBody = RoundBody(self.profile, count * spacing, count)
        if self.stress != "abel":
            body = WearingLine(body.line(np.zeros(count)), _RULES[self.stress])
        swing = None if self.swing is None else worn_springs.Oscillation(*self.swing)
        shapes: list[np.ndarray] = []

        def picture() -> dict[str, np.ndarray]:
            if not isinstance(body, RoundBody):
                half = body.places // 2
                x = (np.arange(half) + 0.5) * body.spacing
                line = -body.line(np.zeros(body.places)).single()[half:]
                return worn_picture(x, [line, *(line + lost[half:] for lost in shapes)])
            section = self.profile.section
            assert section is not None
            r = body.rings.radii
            shape = np.asarray(section.height(np.minimum(r, section.edge)), dtype=float)
            return worn_picture(r, [shape, *(shape + lost for lost in shapes)])

        def steps(distances: np.ndarray) -> Iterator[Step]:
            load = Load(*normal_load(task))
            shapes.clear()
            for state in worn_springs.wear(
                body, self.modulus, load, self.coefficient, distances, swing
            ):
                shapes.append(state.worn)
                length = float(state.contact.contact_length[0, 0])
                yield Step(
                    _spring_quantities(state, swing is not None)
                    | {"contact_length": length, "equivalent_radius": length / 2},
                    unknowns=body.places,
                    iterations=state.steps,
                    fields=picture,
                )

        yield Row(steps, unknowns=body.places)


class ReducedFretting(ReducedWear):
    """A profile that wears where its springs slip, with stick inside."""

    physics = FRETTING


def _spring_quantities(state: WornLine, fretting: bool) -> dict[str, float]:
    values = {
        "penetration": state.penetration,
        "force": state.force,
        "worn_volume": state.volume,
        "wear_depth": float(state.worn.max()),
    }
    return values | ({"stick_area": np.pi / 4 * state.stick_length**2} if fretting else {})


class ReducedWearLines(LineSolver):
    """Rough lines whose heights wear by the stress that the chapter defines on springs (19.37)."""

    name = "reduced"
    physics = SLIDING

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.coefficient, _ = motion_of(scene)
        # a surface has no exact pressure on its line: (19.37) with one radius for each contact
        self.rule: LineRule = "one_radius"
        if scene.methods.reduced.changes.get("stress") != "one_radius":
            self.rule = _RULES.get(scene.methods.reduced.stress, "one_radius")
        own = self.rule == "own_curvature"
        radius = "the curvature at each spring" if own else "one radius for each contact"
        self.beside = f"; the line wears by the stress (19.37), with {radius}"

    def resolutions(self, geometry: RoughGeometry) -> tuple[int, ...]:
        """Points per side: two lines, as steps grow in number with the points."""
        return super().resolutions(geometry)[:2]

    def rows(self, task: Task[RoughGeometry]) -> Iterator[Row]:
        lines = self.draw(task)
        for row in range(len(lines.rough)):
            yield Row(partial(self._steps, task, lines, row), unknowns=lines.points)

    def _steps(
        self, task: Task[RoughGeometry], lines: Lines, row: int, distances: np.ndarray
    ) -> Iterator[Step]:
        line, patches = lines.rough[row], lines.patches
        control, load = normal_load(task)
        held = Load(control, load * (patches if control == "force" else 1.0))
        top = float(line.heights.max())
        body = WearingLine(RoughLines(line.heights - top, line.spacing, line.periodic), self.rule)
        for state in worn_springs.wear(body, self.modulus, held, self.coefficient, distances):
            contact = state.contact
            yield Step(
                {
                    **_spring_quantities(state, fretting=False),
                    "force": state.force / patches,
                    "worn_volume": state.volume / patches,
                    "contact_area": float(contact.contact_area[0, 0]) / patches,
                    "contact_length": float(contact.contact_length[0, 0]) / patches,
                    "contact_count": float(contact.contact_count[0, 0]) / patches,
                    "mean_gap": float(contact.mean_gap[0, 0]),
                },
                iterations=state.steps,
            )


class GridWear(BemFft):
    """The half-space on a grid, on which every cell of the shape wears by its own pressure."""

    physics = SLIDING
    beside = "each cell wears by its own pressure and slip"

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.face = None  # a flat face wears, and has no edge cells then
        self.tolerance = scene.methods.bem_fft.tolerance
        self.coefficient, self.swing = motion_of(scene)

    def resolutions(self, geometry: Geometry) -> tuple[int, ...]:
        """Return fewer cells than without wear: steps grow in number with them."""
        if isinstance(geometry, RoughGeometry):
            return super().resolutions(geometry)[:2]
        return self.series(24, 16, 32)

    def warm_up(self, task: Task) -> None:
        operator = self.operator(task, SMALL_BALL.shape, (1.0, 1.0))
        force = reference_loads.Load("force", 0.1 * operator.effective_modulus)
        for _ in wear(operator, SMALL_BALL, force, 0.1 / operator.effective_modulus, np.ones(1)):
            pass

    def _steps(
        self, task: Task, operator: ElasticBody, grid: Grid, distances: np.ndarray
    ) -> Iterator[Step]:
        swing = None if self.swing is None else Oscillation(*self.swing)
        load = reference_loads.Load(*normal_load(task))
        area = partial(areas.corrected_area, spacing=grid.spacing, periodic=operator.periodic)
        depths: list[np.ndarray] = []

        def picture() -> dict[str, np.ndarray]:
            """Return the worn section through the middle, or along a row of a rough surface."""
            x, _ = grid.centres
            middle = grid.gap.shape[1] // 2
            shape = grid.gap[:, middle]
            inside = np.isfinite(shape)
            place = x[inside, middle]
            return worn_picture(
                place, [shape[inside], *(shape[inside] + lost[inside] for lost in depths)]
            )

        for state in wear(
            operator, grid.gap, load, self.coefficient, distances, swing, tolerance=self.tolerance
        ):
            depths.append(state.depth[:, grid.gap.shape[1] // 2])
            values = contact_quantities(task, operator, state.contact, grid)
            values |= {"worn_volume": state.volume, "wear_depth": float(state.depth.max())}
            # the edge of a worn contact is no smooth one, in which a contact could be located
            values["contact_area"] = float(area(state.contact.mask))
            if swing is not None:
                values["stick_area"] = float(area(state.sticking))
            yield Step(
                values,
                iterations=state.iterations,
                violation=state.contact.violation,
                fields=picture,
            )


class GridFretting(GridWear):
    """A shape that wears where it slips: in proportion to the gap that its stick circle leaves."""

    physics = FRETTING


# From this k E* s/b on the series is exact to far less than any tolerance.
_SHORTEST = 1e-3


class ClosedFormWear(FormSolver):
    """The pressure below a flat punch decays to the uniform one, mode by mode."""

    name = "closed_form"
    physics = SLIDING

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        if self.indenter.shape != "cylinder":
            raise Refused("the wear of flat circular punches only is known in closed form")
        radius, (coefficient, _) = float(self.indenter.parameters["radius"]), motion_of(scene)
        self.punch = WornPunch(radius, self.modulus, coefficient)
        assert scene.wear is not None
        travelled = scene.wear.varied[1][0] * self.punch.coefficient * self.modulus
        if travelled < _SHORTEST * self.punch.radius:
            raise Refused(f"the series needs k E* s/b of {_SHORTEST:g} and more")
        self.note = "Galin; Goryacheva 1998, ch. 7"

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        control, load = normal_load(task)
        worn = self.punch.under_force if control == "force" else self.punch.at_penetration
        rows = np.array([worn(load, float(distance)) for distance in task.loads.values])
        names = ("penetration", "force", "worn_volume")
        area = np.pi * self.punch.radius**2
        curves = dict(zip(names, rows.T, strict=True)) | {"contact_area": area}
        return Solution.of(task, curves, unknowns=1, violation=0.0)


class ClosedFormFretting(FormSolver):
    """Fretting: none but the limit of many cycles, of which a claim makes use."""

    name = "closed_form"
    physics = FRETTING

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        raise Refused("of fretting only the limit of many cycles is known in closed form")
