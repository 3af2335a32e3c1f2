"""Planning: methods and resolutions for a scene, and the reason for everything left out.

A scene becomes one plan, or two: a measured map too large for the dense solver, which it names,
gets a second, smaller scene - a patch of the same map, repeatable - on which all methods meet.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from comparisons.errors import InputError
from comparisons.facts.methods import CLOSED_FORM, GRID, METHODS, MODEL, NOT_ASKED
from comparisons.geometry.bodies import with_body
from comparisons.geometry.map_files.text import read_curve
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry, prepare
from comparisons.geometry.reading import FileError
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods.normal.bem import BYTES_FREE, BYTES_PERIODIC
from comparisons.methods.normal.proved import check_enclosed
from comparisons.methods.registry import concerned, solver_for
from comparisons.methods.solver import NO_GRID, Refusal, Refused, Solver
from comparisons.scene.loading import loads_of
from comparisons.scene.scene import SUITES, Scene, SceneError, load_scene, load_scenes
from comparisons.scene.surface import MeasuredMap, SelfAffine
from comparisons.solving.map_scenes import patch_of, prepared_otherwise
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
from comparisons.solving.plan_notes import notes_of, omissions, switched_on
from comparisons.tasks.shown_loads import MOST_POINTS
from comparisons.tasks.task import Task

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
