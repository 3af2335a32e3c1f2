"""Springs whose profile wears: round bodies by their exact pressure, or lines by (19.37)."""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry, RoughGeometry
from comparisons.methods.friction.path import normal_load
from comparisons.methods.normal.reduced import ReducedProfile
from comparisons.methods.normal.reduced_lines import Lines, ReducedLines
from comparisons.methods.solver import Refused
from comparisons.methods.wear.motion import FRETTING, SLIDING, Motion, worn_picture
from comparisons.scene.scene import Scene
from comparisons.tasks.solution import Solution
from comparisons.tasks.steps import Row, Step, solve_rows
from comparisons.tasks.task import Task
from reduced.loads import EDGES, Load
from reduced.rough.lines import RoughLines
from reduced.rough.press import press
from reduced.wear.archard import (
    LineRule,
    Oscillation,
    RoundBody,
    WearingBody,
    WearingLine,
    WornLine,
    wear,
)

_RULES: dict[str, LineRule] = {"local": "own_curvature", "one_radius": "one_radius"}
_WORDS = {
    "abel": "the body wears by its exact pressure and its profile follows",
    "local": "the profile itself wears by the stress (19.37), with its curvature at each spring",
    "one_radius": "the profile itself wears by the stress (19.37), with one radius for a contact",
}
# Widths of a line of heights beyond the reach of the contact.
_BEYOND = 1.05


class ReducedWear(ReducedProfile):
    """A profile over springs that wears under a constant load."""

    physics = SLIDING
    options_read = frozenset({"rule", "stress"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.options_read = frozenset({"rule", "stress"})
        self.motion = Motion.of(scene)
        if not self.indenter.axisymmetric:
            raise Refused("springs wear round bodies: other shapes wear out of theirs")

    def model(self, geometry: IndenterGeometry) -> str:
        """Name the line, and what wears."""
        return f"{super().model(geometry)}; {_WORDS[self.options.stress]}"

    def resolutions(self, geometry: IndenterGeometry) -> tuple[int, ...]:
        """Springs per contact radius; steps grow in number with them."""
        finest = int(np.clip(40 * np.sqrt(0.01 / self.scene.compare.tolerance), 40, 120))
        return finest // 4, finest // 2, finest

    def memory(self, task: Task[IndenterGeometry]) -> float:
        """Bytes of the matrices between rings and springs."""
        return 8.0 * 8 * (4 * task.resolution) ** 2

    def warm_up(self, task: Task[IndenterGeometry]) -> None:
        """Compile the springs of a line."""
        _compile()

    def rows(self, task: Task[IndenterGeometry]) -> Iterator[Row]:
        """Yield the profile."""
        body = self._body(task)
        yield Row(partial(self._steps, task, body), unknowns=body.places)

    def solve(self, task: Task[IndenterGeometry]) -> Solution:
        """Wear it from distance to distance."""
        return solve_rows(task, self.rows(task))

    def _body(self, task: Task[IndenterGeometry]) -> WearingBody:
        reach = min(_BEYOND * float(task.geometry.reach[0]), self.profile.edge)
        width = self._stuck(task) or task.geometry.contact_radius
        # what sticks at the start ends between two springs, so that all of a ring wears or none
        spacing = width / max(1, round(task.resolution * width / task.geometry.contact_radius))
        count = max(2, int(np.ceil(reach / spacing - 1e-9)))
        if count * spacing > self.profile.edge:
            spacing = self.profile.edge / count
        body = RoundBody(self.profile, count * spacing, count)
        if self.options.stress == "abel":
            return body
        return WearingLine(body.line(np.zeros(count)), _RULES[self.options.stress])

    def _stuck(self, task: Task[IndenterGeometry]) -> float:
        """Return the stick radius at the start."""
        if self.motion.oscillation is None:
            return 0.0
        control, load = normal_load(task)
        depth = load
        if control == "force":
            depth = float(self.bed.press(Load("force", load), 40, "sub_cell").penetration[0])
        inner = depth - self.motion.oscillation[1]
        return float(self.profile.contact_radius(inner)) if inner > 0 else 0.0

    def _steps(
        self, task: Task[IndenterGeometry], body: WearingBody, distances: np.ndarray
    ) -> Iterator[Step]:
        control, load = normal_load(task)
        swing = self.motion.oscillation
        oscillation = None if swing is None else Oscillation(*swing)
        states = wear(
            body, self.modulus, Load(control, load), self.motion.coefficient, distances, oscillation
        )
        shapes: list[np.ndarray] = []
        for state in states:
            shapes.append(state.worn)
            yield Step(
                _quantities(state, swing is not None) | _round_contact(state),
                unknowns=body.places,
                iterations=state.steps,
                fields=partial(self._picture, body, shapes),
            )

    def _picture(self, body: WearingBody, worn: list[np.ndarray]) -> dict[str, np.ndarray]:
        if not isinstance(body, RoundBody):
            half = body.places // 2
            x = (np.arange(half) + 0.5) * body.spacing
            line = -body.line(np.zeros(body.places)).single()[half:]
            return worn_picture(x, [line, *(line + lost[half:] for lost in worn)])
        section = self.profile.section
        assert section is not None
        r = body.rings.radii
        shape = np.asarray(section.height(np.minimum(r, section.edge)), dtype=float)
        return worn_picture(r, [shape, *(shape + lost for lost in worn)])


class ReducedFretting(ReducedWear):
    """A profile that wears where its springs slip, with stick inside."""

    physics = FRETTING


def _compile() -> None:
    line = RoughLines(np.cos(np.arange(16.0)), 1.0)
    for edges in EDGES:
        press(line, 1.0, Load("force", 0.5), edges=edges)
        press(line, 1.0, Load("penetration", 0.5), edges=edges)


def _quantities(state: WornLine, fretting: bool) -> dict[str, float]:
    values = {
        "penetration": state.penetration,
        "force": state.force,
        "worn_volume": state.volume,
        "wear_depth": float(state.worn.max()),
    }
    return values | ({"stick_area": np.pi / 4 * state.stick_length**2} if fretting else {})


def _round_contact(state: WornLine) -> dict[str, float]:
    length = float(state.contact.contact_length[0, 0])
    return {"contact_length": length, "equivalent_radius": length / 2}


class ReducedWearLines(ReducedLines):
    """Rough lines whose heights wear by the stress that the chapter defines on springs (19.37)."""

    physics = SLIDING
    options_read = frozenset({"stress", "spectrum", "line_length", "line_points"})

    def __init__(self, scene: Scene) -> None:
        super().__init__(scene)
        self.motion = Motion.of(scene)
        # a surface has no exact pressure on its line: (19.37) with one radius for each contact
        self.rule: LineRule = "own_curvature" if self.options.stress == "local" else "one_radius"
        if self.options.stress == "one_radius":
            self.options_read -= {"stress"}

    def model(self, geometry: RoughGeometry) -> str:
        """Name the line, and what wears it."""
        own = self.rule == "own_curvature"
        radius = "the curvature at each spring" if own else "one radius for each contact"
        return f"{super().model(geometry)}; the line wears by the stress (19.37), with {radius}"

    def warm_up(self, task: Task[RoughGeometry]) -> None:
        """Compile the walk along a line."""
        _compile()

    def resolutions(self, geometry: RoughGeometry) -> tuple[int, ...]:
        """Points per side: two lines, as steps grow in number with the points."""
        return super().resolutions(geometry)[:2]

    def solve(self, task: Task[RoughGeometry]) -> Solution:
        """Wear each line by itself."""
        return solve_rows(task, self.rows(task))

    def rows(self, task: Task[RoughGeometry]) -> Iterator[Row]:
        """Draw all lines."""
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
        for state in wear(body, self.modulus, held, self.motion.coefficient, distances):
            contact = state.contact
            yield Step(
                {
                    **_quantities(state, fretting=False),
                    "force": state.force / patches,
                    "worn_volume": state.volume / patches,
                    "contact_area": float(contact.contact_area[0, 0]) / patches,
                    "contact_length": float(contact.contact_length[0, 0]) / patches,
                    "contact_count": float(contact.contact_count[0, 0]) / patches,
                    "mean_gap": float(contact.mean_gap[0, 0]),
                },
                iterations=state.steps,
            )
