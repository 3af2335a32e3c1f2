"""Planning: methods and resolutions for a scene, and the reason for everything left out.

A scene becomes one plan, or two: a measured map too large for the dense solver, which it names,
gets a second, smaller scene - a patch of the same map, repeatable - on which all methods meet.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from comparisons.errors import InputError
from comparisons.facts.methods import CLOSED_FORM, ELEMENTS, GRID, METHODS, MODEL, NOT_ASKED
from comparisons.facts.quantities import quantity
from comparisons.formatting import number, relative, unpadded, with_unit
from comparisons.geometry.bodies import BodyGeometry, with_body
from comparisons.geometry.map_files.text import read_curve
from comparisons.geometry.plausibility import scene_notes, surface_notes
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry, prepare
from comparisons.geometry.reading import FileError
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods.normal.bem import BYTES_FREE, BYTES_PERIODIC
from comparisons.methods.normal.grid import SIDE, cells
from comparisons.methods.normal.proved import check_enclosed
from comparisons.methods.registry import concerned, solver_for
from comparisons.methods.solver import NO_GRID, Refusal, Refused, Solver
from comparisons.scene.half_space import HalfSpace
from comparisons.scene.indenters.axisymmetric import Paraboloid, Sphere
from comparisons.scene.loading import AbsoluteLoads, loads_of
from comparisons.scene.scene import (
    PREPARATION,
    SUITES,
    Scene,
    SceneError,
    load_scene,
    load_scenes,
    member,
    validated,
)
from comparisons.scene.surface import TRENDS, MeasuredMap, SelfAffine, trend_of, trend_problem
from comparisons.solving.plan import (
    QUICK_REALISATIONS,
    Effort,
    Measured,
    MethodPlan,
    Plan,
    PlanRecord,
    realisation_count,
    surface_cost,
    task_of,
)
from comparisons.tasks.shown_loads import MOST_POINTS
from comparisons.tasks.stresses import FROM_PRESSURE
from comparisons.tasks.task import Task
from reference.dynamics.collision import radiation_number, weak_loss

Source = str | Path | Mapping[str, Any] | Scene

# Bytes below which the plan does not mention memory, nor ask how much is free.
WORTH_SAYING = 5e7


# Surfaces on each grid, coarse to fine, that a plan begins with: their scatter says how many are
# needed (`judging.refinement`). Of large surfaces, on which a solve costs more than DEAR of those
# on 64 x 64 points, as few as tell a scatter.
PILOTS, FEW_PILOTS = (50, 8, 4, 3), (8, 4, 3)
DEAR = 20.0


def plan_scene(scene: Scene, effort: Effort = "quick") -> list[Plan]:
    """Plan a scene; a large map with the dense solver yields a second plan, for a patch of it.

    SceneError if it cannot be prepared or does not fit into memory; InputError of a user's method.
    """
    # what cannot fit is refused before any memory is taken
    problems = []
    if isinstance(scene.surface, SelfAffine):
        nx, ny = scene.surface.points
        free = free_memory()
        need = float(BYTES_PERIODIC if scene.surface.periodic else BYTES_FREE) * nx * ny
        if need > MEMORY_SHARE * free:
            problems.append(
                f"surface.points: expected arrays that fit into {MEMORY_SHARE:.0%} of the free "
                f"memory ({free / 1e9:.1f} GB), got {nx} x {ny} points, "
                f"which need about {need / 1e9:.1f} GB"
            )
    rows = len(loads_of(scene).values) * scene.realisations
    if rows > 20_000_000:
        problems.append(
            "surface.realisations: expected at most 20 million realisations times load steps, "
            f"got {rows}"
        )
    if problems:
        raise SceneError(scene.name, problems)
    plans = [_plan(scene, effort)]
    if scene.compare.proved is True:
        try:
            check_enclosed(scene, plans[0].geometry, plans[0].loads)
        except Refused as reason:  # no theorem covers it
            problem = f"compare.proved: {reason.refusal.reason}"
            raise SceneError(scene.name, [problem]) from None
    patch = patch_of(scene, plans[0].geometry)
    if patch is not None and isinstance(patch.surface, MeasuredMap):
        crop = list(patch.surface.crop or ())
        plans.append(_plan(patch, effort))
        plans[0] = replace(
            plans[0],
            notes=(
                *plans[0].notes,
                f"all methods meet on the scene {patch.name}: "
                f"the patch crop = {crop} of the same map, whose rms slope is the median of "
                "all such patches away from the rim",
            ),
        )
    return plans


def plan_from(scene: Scene, said: PlanRecord, effort: Effort) -> Plan:
    """Return the plan of a record as it was; InputError if it has a method that is not known."""
    unknown = [method.method for method in said.methods if method.method not in METHODS]
    if unknown:
        problem = f"{', '.join(unknown)} not known here (--method-file adds methods)"
        raise InputError(f"{scene.name}: {problem}")
    return replace(
        _draft(scene, effort),
        methods=said.methods,
        left_out=said.left_out,
        notes=said.notes,
        switched_on=said.switched_on,
    )


def _draft(scene: Scene, effort: Effort) -> Plan:
    geometry, loads = prepare(scene)
    if isinstance(geometry, IndenterGeometry) and scene.body is not None:
        geometry = with_body(scene, geometry)
    total = scene.realisations
    realisations = min(total, QUICK_REALISATIONS) if effort == "quick" else total
    measured = None
    if scene.compare.measured is not None:
        try:
            depth, force = read_curve(Path(scene.directory) / scene.compare.measured)
        except FileError as error:
            where = f"compare.measured: {scene.compare.measured}"
            raise SceneError(scene.name, [f"{where}: {text}" for text in error.problems]) from error
        measured = Measured(
            tuple(depth.tolist()),
            tuple(force.tolist()),
            scene.effective_modulus,
            scene.compare.fit_zero,
        )
    return Plan(
        scene=scene, geometry=geometry, loads=loads, realisations=realisations, measured=measured
    )


def _plan(scene: Scene, effort: Effort) -> Plan:
    draft = _draft(scene, effort)
    methods, broken = [], []
    for name in concerned(scene):
        try:
            planned = _plan_method(draft, name)
            if (row := METHODS[name]).user_made:  # it may not be there when results are read
                planned = replace(planned, title=row.title, dimension=row.dimension)
            methods.append(planned)
        except InputError as error:
            broken.append(str(error))
    if broken:
        raise InputError("\n".join(broken))
    return replace(
        draft,
        methods=tuple(methods),
        left_out=tuple(omissions(scene, draft.geometry)),
        notes=tuple(notes_of(draft, tuple(methods))),
        switched_on=tuple(switched_on(scene, draft.loads)),
    )


def _plan_method(draft: Plan, name: str) -> MethodPlan:
    scene = draft.scene
    asked = scene.compare.methods is None or name in scene.compare.methods
    if not asked and name != CLOSED_FORM:
        return MethodPlan(name, False, NOT_ASKED)
    # A closed form is the truth wherever there is one, and costs next to nothing.
    solver = solver_for(name, scene)
    if isinstance(solver, Refusal):
        if not asked:
            return MethodPlan(name, False, NOT_ASKED)
        if solver.broken:
            raise InputError(f"--method-file: {name}: {scene.name}: {solver.reason}")
        return MethodPlan(name, False, solver.reason)
    if METHODS[name].on_request and scene.compare.methods is None:
        return MethodPlan(name, False, "takes seconds per load: runs only if named")
    planned = solver.resolutions(draft.geometry)
    if scene.compare.resolutions is not None and planned != NO_GRID:
        planned = scene.compare.resolutions
    refusals = {n: refusal(draft, name, n, solver) for n in planned}
    feasible = tuple(n for n in planned if not refusals[n])
    dropped = [f"{n}: {reason}" for n, reason in refusals.items() if reason]
    if not feasible:
        return MethodPlan(name, False, dropped[0].partition(": ")[2])
    reason = solver.note if not dropped else "left out " + "; ".join(dropped)
    modelled = solver.model(draft.geometry)
    if not asked:
        modelled += "; not asked for: it is the reference"
    tasks = [_first_task(draft, name, solver, n) for n in feasible]
    need, most = (max(map(estimate, tasks)) for estimate in (solver.memory, solver.most_memory))
    if need > WORTH_SAYING:
        modelled += f"; about {need / 1e9:.1f} GB of memory"
        if most > MEMORY_SHARE * free_memory():
            modelled += f", but {most / 1e9:.1f} GB, too much, should single precision stall"
    numbers = pilots(solver, feasible)
    title = solver.title if solver.title != METHODS[name].title else ""
    return MethodPlan(name, True, reason, feasible, modelled, numbers, title)


def pilots(solver: Solver[Any], resolutions: tuple[int, ...]) -> tuple[int, ...]:
    """Return how many surfaces or lines are solved, in whole tasks, to know a scatter; or ()."""
    scene = solver.scene
    if scene.surface is None or scene.physics or solver.name not in (GRID, MODEL):
        return ()
    blocks = [solver.block(n) for n in resolutions]
    if solver.name == MODEL:
        return tuple(blocks)
    if not scene.random or scene.realisations == 1:
        return ()
    random = [face for face in scene.surfaces if isinstance(face, SelfAffine)]
    dear = surface_cost(GRID, max(random[0].points)) > DEAR
    first = FEW_PILOTS if dear else PILOTS
    numbers = (*first, *(first[-1:] * len(blocks)))
    whole = (-(-n // block) * block for n, block in zip(numbers, blocks, strict=False))
    return tuple(min(n, scene.realisations) for n in whole)


def single_resolution(planned: tuple[int, ...], geometry: Geometry) -> int:
    """Return the one resolution that a single solve uses: a synthetic surface's own points.

    Else the finest planned; of a map not one beyond `MOST_POINTS`: it only narrows the bar.
    """
    if isinstance(geometry, RoughGeometry):
        if geometry.random:
            return max(planned[0], min(geometry.points[0], planned[-1]))
        if len(planned) > 2 and planned[-1] ** 2 > MOST_POINTS:
            return planned[-2]
    return planned[-1]


def _first_task(draft: Plan, name: str, solver: Solver[Any], resolution: int) -> Task:
    """Return a whole task of a method: as many surfaces or lines as it holds at once."""
    first = pilots(solver, (resolution,))
    count = first[0] if first else realisation_count(draft.scene, name, draft.realisations)
    block = tuple(range(min(count, solver.block(resolution))))
    return task_of(draft, name, resolution, block)


def refusal(
    draft: Plan, name: str, resolution: int, solver: Solver[Any] | Refusal | None = None
) -> str:
    """Return why a resolution is not run, or an empty text."""
    solver, geometry = solver or solver_for(name, draft.scene), draft.geometry
    if isinstance(solver, Refusal):
        return solver.reason
    if isinstance(geometry, RoughGeometry) and METHODS[name].dimension == 3:
        points = geometry.points[0]
        step = points // resolution if points % resolution == 0 else 0
        divides = step and all(n % step == 0 for n in geometry.points)
        if resolution % points and not divides:
            return f"neither a multiple nor a divisor of the surface's own {points} points per side"
    task = _first_task(draft, name, solver, resolution)
    try:
        refused = solver.refusal(task)
    except (ValueError, ArithmeticError) as error:
        return str(error)
    if refused:
        return refused
    need = solver.memory(task)
    if need > WORTH_SAYING and need > MEMORY_SHARE * (free := free_memory()):
        return f"needs about {need / 1e9:.1f} GB, and {free / 1e9:.1f} GB are free"
    return ""


def plan_all(
    sources: Iterable[Source],
    overrides: Mapping[str, Any],
    effort: Effort,
    options: Mapping[str, str] = {},
    brought: Sequence[str] = (),
    *,
    sensitivity: bool = False,
) -> list[Plan]:
    """Load and plan all scenes and suites.

    `overrides` are dotted keys put into every scene, `options` what sets them, by how they begin,
    if not just "changes". A user's own methods (`brought`) run, too, where only others are named.
    `sensitivity` plans measured maps as they might have been prepared. InputError lists every
    problem of all scenes, or those that no method can do.
    """
    members: list[Source] = []
    for source in sources:
        suite = SUITES.get(source.lower()) if isinstance(source, str) else None
        members += (source,) if suite is None else suite
    plans: list[Plan] = []
    problems: list[str] = []
    of_options: dict[str, dict[str, list[str]]] = {}  # option -> problem -> scenes that have it

    def option_of(text: str) -> str:
        return next((name for key, name in options.items() if text.startswith(key)), "changes")

    given = list(dict.fromkeys(map(option_of, overrides)))
    for source in members:
        try:
            try:
                scenes = load_scenes(source, overrides)
            except SceneError as error:
                own = []  # what is wrong without the options, and not mended by them
                try:
                    load_scenes(source)
                except SceneError as unchanged:
                    own = [text for text in unchanged.problems if text in error.problems]
                for text in error.problems:
                    if text not in own:
                        option = option_of(text) if option_of(text) in given else ", ".join(given)
                        problem = of_options.setdefault(option, {})
                        problem.setdefault(text, []).append(error.source)
                if own:
                    raise SceneError(error.source, own) from None
                continue
            if sensitivity:
                scenes = [variant for scene in scenes for variant in prepared_otherwise(scene)]
            for scene in scenes:
                plans += plan_scene(with_brought(scene, brought), effort)
        except InputError as error:
            problems.append(str(error))
    for option, faults in of_options.items():
        told = [
            fault if len(scenes) == len(members) else f"{fault} (in {', '.join(scenes)})"
            for fault, scenes in faults.items()
        ]
        problems.append(str(SceneError(option, told)))
    if not plans and not problems:
        problems.append("expected at least one scene")
    names = [plan.scene.name for plan in plans]
    problems += [
        f"{name}: expected different names, two scenes have this one"
        for name in sorted({n for n in names if names.count(n) > 1})
    ]
    problems += unsolvable(plans)
    if problems:
        raise InputError("\n".join(dict.fromkeys(problems)))
    return plans


def with_brought(scene: Scene, brought: Sequence[str]) -> Scene:
    """Return a scene that names a user's own methods, too, if it names others only."""
    named = scene.compare.methods
    if named is None or not brought or set(brought).intersection(named):
        return scene
    return load_scene(scene, {"compare.methods": [*named, *brought]})


def unsolvable(plans: Sequence[Plan]) -> list[str]:
    """Name the scenes for which no method plans anything, methods with the same reason together.

    Where methods are named that is told only if they leave every scene none.
    """
    problems = []
    for plan in plans:
        names = plan.scene.compare.methods
        asked = [method for method in plan.methods if names is None or method.method in names]
        if any(method.supported for method in asked):
            continue
        reasons: dict[str, list[str]] = {}
        for method in asked:
            reasons.setdefault(method.reason, []).append(method.method)
        refusals = "".join(f"\n  {', '.join(m)}: {reason}" for reason, m in reasons.items())
        named = "" if names is None else " asked for"
        text = f"{plan.scene.name}: no method{named} can solve this scene{refusals}"
        problems.append((names is None, text))
    return [text for free, text in problems if free or len(problems) == len(plans)]


Crop = tuple[int, int, int, int]
DENSE = "bem_dense"
PATCH_POINTS = 16
# Slopes that differ by less are the same: which place is the median must not hang on rounding.
_SAME = 1e-9


def patch_of(scene: Scene, geometry: Geometry) -> Scene | None:
    """Return the scene of a typical patch of a map, or None if none is needed."""
    if not isinstance(scene.surface, MeasuredMap) or not isinstance(geometry, RoughGeometry):
        return None
    # it would have to be cut from both faces; under physics the dense method gains nothing
    if scene.surface2 is not None or scene.physics or DENSE not in (scene.compare.methods or ()):
        return None
    if geometry.periodic or max(geometry.points) <= PATCH_POINTS or min(geometry.points) < 8:
        return None
    assert geometry.measured is not None
    x0, y0, nx, ny = typical_window(geometry.measured, geometry.spacing(geometry.measured))
    origin = (0, 0) if scene.surface.crop is None else scene.surface.crop[:2]
    crop = origin[0] + x0, origin[1] + y0, nx, ny
    share = nx * ny / (geometry.points[0] * geometry.points[1])
    data = scene.model_dump(exclude_defaults=True, by_alias=True)
    data["directory"] = scene.directory
    data["name"] = f"{scene.name[:90]}-patch"
    data["title"] = f"{scene.heading}: patch of {nx} x {ny} points"
    data["surface"] |= {"crop": crop}
    data.get("compare", {}).pop("resolutions", None)
    force = scene.loading.force
    if force is not None and force.relative_to is None:
        values = [share * load for load in force.values]
        data["loading"] = {"force": {"values": values}}
    return validated(data)


def typical_window(heights: NDArray[np.float64], spacing: tuple[float, float]) -> Crop:
    """Return the window of median rms slope, half a window away from the rim where that fits.

    >>> ramp = np.outer(np.arange(64.0) ** 2, np.ones(64))
    >>> typical_window(ramp, (1.0, 1.0))
    (24, 24, 16, 16)
    """
    nx, ny = (min(PATCH_POINTS, n) for n in heights.shape)
    rise = [np.diff(heights, axis=axis) ** 2 / spacing[axis] ** 2 for axis in (0, 1)]
    starts = []  # of windows along each axis, half a window apart and away from the rim
    for n, side in zip(heights.shape, (nx, ny), strict=True):
        rim = min(side // 2, (n - side) // 2)
        starts.append(np.arange(rim, n - side - rim + 1, max(side // 2, 1)))
    squares = np.zeros((len(starts[0]), len(starts[1])))
    low_x, low_y = starts
    for part, sides in zip(rise, ((nx - 1, ny), (nx, ny - 1)), strict=True):
        # the sum over all windows, from the sums from the corner
        total = np.pad(part, ((1, 0), (1, 0))).cumsum(0).cumsum(1)
        high_x, high_y = low_x + sides[0], low_y + sides[1]
        within = (
            total[np.ix_(high_x, high_y)]
            - total[np.ix_(low_x, high_y)]
            - total[np.ix_(high_x, low_y)]
            + total[np.ix_(low_x, low_y)]
        )
        squares += within / (sides[0] * sides[1])
    slopes = np.sqrt(squares).ravel()
    steps = np.round(slopes / max(float(slopes.max()), np.finfo(float).tiny) / _SAME)
    place = np.argsort(steps, kind="stable")[(len(steps) - 1) // 2]
    i, j = np.unravel_index(place, (len(starts[0]), len(starts[1])))
    return int(starts[0][i]), int(starts[1][j]), nx, ny


# Points a side of the smallest quarter that is pressed.
LEAST = 16


def prepared_otherwise(scene: Scene) -> list[Scene]:
    """Return a scene of a map as it is, with other trends and cut-offs, and each quarter alone.

    A mean height moves a contact as a whole: maps without any trend subtracted add nothing.
    Cut-offs are twice and four times the given one, or else the shortest wave of the map, 2 cells.
    Quarters, of free patches, have a quarter of the forces. InputError if the scene has no map, or
    two faces.
    """
    face, (geometry, loads) = scene.surface, prepare(scene)
    if not isinstance(face, MeasuredMap) or not isinstance(geometry, RoughGeometry):
        raise InputError(f"{scene.name}: --sensitivity: expected a [surface] of kind map")
    if scene.surface2 is not None:
        raise InputError(f"{scene.name}: --sensitivity: expected one rough face, got two")
    variants: dict[str, dict[str, Any]] = {}
    for trend in TRENDS:
        other = trend != trend_of(face.detrend, face.periodic)
        if trend != "none" and other and not trend_problem(trend, face.periodic):
            variants[f"detrend {trend}"] = {"surface.detrend": trend}
    (nx, ny), (x0, y0) = geometry.points, (face.crop or (0, 0))[:2]
    for times in (2, 4):
        cutoff = times * (
            face.short_cutoff or 2 * max(geometry.size[0] / nx, geometry.size[1] / ny)
        )
        if cutoff <= min(geometry.size):
            variants[f"cut-off {with_unit(cutoff, 'm')}"] = {"surface.short_cutoff": cutoff}
    divides = (face.short_cutoff or 0.0) <= min(geometry.size) / 2 and min(nx, ny) >= 2 * LEAST
    if not face.periodic and divides:
        for x in (x0, x0 + nx - nx // 2):
            for y in (y0, y0 + ny - ny // 2):
                crop = [x, y, nx // 2, ny // 2]
                variants[f"crop at {x}, {y}"] = {"surface.crop": crop}
    if scene.loading.force is not None:  # relative to the slopes it would change with them
        for changes in variants.values():
            *_, px, py = changes.get("surface.crop", (nx, ny))
            changes["loading.force"] = (loads.values * (px * py / (nx * ny))).tolist()
    variants = {"as given": {}, **variants}
    return [
        load_scene(
            scene,
            changes
            | {
                "sweep": {PREPARATION: words},
                "name": member(scene.name, words),
                "title": f"{scene.heading}, {words}"[:300],
            },
        )
        for words, changes in variants.items()
    ]


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
