"""Planning: methods and resolutions for a scene, and the reason for everything left out.

A scene becomes one plan, or two: a measured map too large for the dense solver gets a second,
smaller scene - a patch of the same map, named and repeatable - on which all methods meet.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any, Literal

import numpy as np

from comparisons.errors import InputError
from comparisons.facts.methods import GRID, METHODS, MODEL, growth
from comparisons.geometry.bodies import BodyGeometry, with_body
from comparisons.geometry.plausibility import scene_notes
from comparisons.geometry.prepare import Geometry, IndenterGeometry, RoughGeometry, prepare
from comparisons.geometry.roughness import surface_notes
from comparisons.machine import MEMORY_SHARE, free_memory
from comparisons.methods.normal.bem_fft import BYTES_FREE, BYTES_PERIODIC
from comparisons.methods.normal.blocks import SIDE
from comparisons.methods.normal.grid import cells
from comparisons.methods.normal.proved import check_enclosed
from comparisons.methods.registry import concerns, solver_for
from comparisons.methods.solver import Refusal, Refused, Solver
from comparisons.scene.physics.absolute_loads import AbsoluteLoads, loads_of
from comparisons.scene.physics.descriptions import left_out, switched_on
from comparisons.scene.scene import Scene, SceneError
from comparisons.scene.surface import SelfAffine
from comparisons.solving.map_patches import patch_of
from comparisons.tasks.shown_loads import MOST_POINTS
from comparisons.tasks.task import Task

Effort = Literal["quick", "full"]
QUICK_REALISATIONS = 10
# Surfaces of methods that are compared with the leading grid surface by surface.
PAIRED_REALISATIONS = 4
# Surfaces on each grid, coarse to fine, that a plan begins with: their scatter says how many are
# needed (`judging.ensembles`). Of large surfaces, on which a solve costs more than DEAR of those on
# 64 x 64 points, as few as tell a scatter.
PILOTS, FEW_PILOTS = (50, 8, 4, 3), (8, 4, 3)
DEAR = 20.0
# Bytes below which the plan does not mention memory.
WORTH_SAYING = 5e7
# What a method without a discretisation plans: nothing can refine it.
EXACT = (1,)
# Means of nonlinear curves differ by what is held: where the gap is, high peaks carry most force.
MEANS_AT_EQUAL_GAP = (
    "means over surfaces and lines are taken at equal mean gap, where the few with high peaks "
    "carry most of the force: prescribe the force for means at equal force, which is another curve"
)


@dataclass(frozen=True)
class MethodPlan:
    """The plan of one method for a scene, or the reason for a refusal.

    Attributes
    ----------
    numbers : tuple of int
        Surfaces or lines at each resolution, not increasing; empty: `Plan.realisations`.
    """

    method: str
    supported: bool
    reason: str
    resolutions: tuple[int, ...] = ()
    modelled: str = ""
    numbers: tuple[int, ...] = ()

    def finer(self, resolution: int) -> MethodPlan:
        """Return it with one more resolution, on as many surfaces as the finest one so far."""
        numbers = (*self.numbers, self.numbers[-1]) if self.numbers else ()
        return replace(self, resolutions=(*self.resolutions, resolution), numbers=numbers)


@dataclass(frozen=True)
class Plan:
    """All solves of one scene, and what was left out."""

    scene: Scene
    geometry: Geometry
    loads: AbsoluteLoads
    methods: tuple[MethodPlan, ...]
    left_out: tuple[tuple[str, str], ...]
    notes: tuple[str, ...]
    realisations: int
    switched_on: tuple[tuple[str, str], ...] = ()

    @cached_property
    def tasks(self) -> tuple[Task, ...]:
        """The independent solves, cheap methods first."""
        pictured = "pressure" in self.scene.compare.quantities
        return tuple(
            task_of(
                self,
                planned.method,
                resolution,
                block,
                with_body=pictured and block[0] == 0 and resolution == planned.resolutions[-1],
            )
            for planned in self.methods
            for resolution in planned.resolutions
            for block in self.blocks(planned.method, resolution)
        )

    @property
    def settings(self) -> dict[tuple[str, int], list[Task]]:
        """The tasks of each method at each resolution: its blocks of realisations."""
        settings: dict[tuple[str, int], list[Task]] = {}
        for task in self.tasks:
            settings.setdefault((task.method, task.resolution), []).append(task)
        return settings

    @property
    def compared(self) -> tuple[str, ...]:
        """The quantities that are compared: all that are asked for, but what is prescribed.

        Force and penetration can each be compared at the other; along a path, in time or over
        speeds the prescribed load is the same for all.
        """
        quantities = self.scene.compare.quantities
        return tuple(
            q for q in quantities if self.loads.compares_itself or q not in self.loads.columns
        )

    def blocks(self, method: str, resolution: int = 1) -> list[tuple[int, ...]]:
        """Return the realisations of a method in blocks of one task each, smaller on fine grids."""
        count, size = self.number(method, resolution), self.block(method, resolution)
        return [tuple(range(k, min(k + size, count))) for k in range(0, count, size)]

    def number(self, method: str, resolution: int) -> int:
        """Return how many surfaces or lines a method solves at a resolution."""
        for planned in self.methods:
            if planned.method == method and planned.numbers and resolution in planned.resolutions:
                return planned.numbers[planned.resolutions.index(resolution)]
        return realisation_count(self.scene, method, self.realisations)

    def block(self, method: str, resolution: int) -> int:
        """Return how many surfaces or lines are one task: the same whatever their number."""
        solver = solver_for(method, self.scene)
        return 1 if isinstance(solver, Refusal) else solver.block(resolution)

    def document(self) -> dict[str, Any]:
        """Return the plan as plain data for study.json."""
        return {
            "methods": [
                {
                    "method": m.method,
                    "supported": m.supported,
                    "reason": m.reason,
                    "resolutions": list(m.resolutions),
                    "modelled": m.modelled,
                    "numbers": list(m.numbers),
                }
                for m in self.methods
            ],
            "switched_on": [{"what": effect, "how": model} for effect, model in self.switched_on],
            "left_out": [{"what": effect, "why": reason} for effect, reason in self.left_out],
            "notes": list(self.notes),
        }


def plan_scene(scene: Scene, effort: Effort = "quick") -> list[Plan]:
    """Plan a scene; a large measured map yields a second plan, for a patch of it.

    Raises
    ------
    SceneError
        If the geometry cannot be prepared, or the scene does not fit into memory.
    InputError
        If a method from a user's file breaks when it is asked for its plan.
    """
    _check_size(scene)
    plans = [_plan(scene, effort)]
    if scene.compare.proved is True:
        _check_proof(plans[0])
    part = patch_of(scene, plans[0].geometry)
    if part is not None:
        patch, crop = part
        plans.append(_plan(patch, effort))
        plans[0] = replace(
            plans[0],
            notes=(
                *plans[0].notes,
                f"all methods meet on the scene {patch.name}: "
                f"the patch crop = {list(crop)} of the same map, whose rms slope is the median of "
                "all such patches away from the rim",
            ),
        )
    return plans


def _check_proof(plan: Plan) -> None:
    """Refuse to prove what no theorem covers."""
    try:
        check_enclosed(plan.scene, plan.loads)
    except Refused as reason:
        problem = f"compare.proved: {reason.refusal.reason}"
        raise SceneError(plan.scene.name, [problem]) from None


def task_of(
    plan: Plan,
    method: str,
    resolution: int,
    realisations: tuple[int, ...] = (0,),
    *,
    with_body: bool = False,
) -> Task:
    """Return the task of one method at one resolution."""
    return Task(
        scene=plan.scene,
        geometry=plan.geometry,
        loads=plan.loads,
        method=method,
        resolution=resolution,
        quantities=plan.scene.compare.quantities,
        realisations=realisations,
        with_body=with_body,
    )


def realisation_count(scene: Scene, method: str, limit: int) -> int:
    """Return how many realisations a method solves: on a measured map only lines are drawn."""
    if scene.surface is None or METHODS[method].dimension == 2:
        return 1
    if not scene.random and METHODS[method].dimension == 3:
        return 1
    # What is compared surface by surface needs few of them: differences scatter little.
    return min(scene.realisations, limit if scene.physics else PAIRED_REALISATIONS)


def plan_from(scene: Scene, document: Mapping[str, Any], effort: Effort) -> Plan:
    """Return the plan that `Plan.document` describes, whatever this machine would have planned.

    Raises
    ------
    InputError
        If the document is no such plan, or has a method that is not known here.
    """
    try:
        methods = tuple(
            MethodPlan(**method | {key: tuple(method[key]) for key in ("resolutions", "numbers")})
            for method in document["methods"]
        )
        omitted = tuple((entry["what"], entry["why"]) for entry in document["left_out"])
        notes = tuple(document["notes"])
        applied = tuple((entry["what"], entry["how"]) for entry in document["switched_on"])
    except (KeyError, TypeError) as error:
        raise InputError(f"{scene.name}: not a plan of this roughline ({error})") from error
    unknown = [method.method for method in methods if method.method not in METHODS]
    if unknown:
        problem = f"{', '.join(unknown)} not known here (--method-file adds methods)"
        raise InputError(f"{scene.name}: {problem}")
    return replace(
        _draft(scene, effort),
        methods=methods,
        left_out=omitted,
        notes=notes,
        switched_on=applied,
    )


def _draft(scene: Scene, effort: Effort) -> Plan:
    geometry, loads = prepare(scene)
    if isinstance(geometry, IndenterGeometry) and scene.body is not None:
        geometry = with_body(scene, geometry)
    total = scene.realisations
    realisations = min(total, QUICK_REALISATIONS) if effort == "quick" else total
    return Plan(scene, geometry, loads, (), (), (), realisations)


def _plan(scene: Scene, effort: Effort) -> Plan:
    draft = _draft(scene, effort)
    geometry, loads, realisations = draft.geometry, draft.loads, draft.realisations
    total = scene.realisations
    methods = tuple(_plan_methods(draft))
    notes = (
        [*geometry.treatment, *surface_notes(geometry)]
        if isinstance(geometry, RoughGeometry)
        else []
    )
    notes += scene_notes(scene, geometry)
    notes += _coarser_pictures(draft, methods)
    if scene.physics and realisations < total:
        notes.append(f"quick: {realisations} of {total} realisations (--full runs all of them)")
    if isinstance(geometry, RoughGeometry) and loads.control == "mean_gap":
        notes.append(MEANS_AT_EQUAL_GAP)
    if scene.counter_body is not None:
        notes.append("both bodies are elastic: their compliances 1/E* add")
    if scene.half_space.poisson_ratio is None and scene.viscoelastic is None:
        notes.append(
            "only E* is given: fem takes nu = 0.3; frictionless contact depends on E* alone"
        )
    if loads.normal is not None and len(scene.loading.range.values) > 1:
        notes.append("only the last of the normal loads is held")
    return replace(
        draft,
        methods=methods,
        left_out=tuple(_left_out(scene, geometry)),
        notes=tuple(notes),
        switched_on=tuple(switched_on(scene, loads)),
    )


def _coarser_pictures(draft: Plan, methods: tuple[MethodPlan, ...]) -> Iterable[str]:
    """Say that fields of large grids are stored coarser than they are solved."""
    finest = max(
        (max(m.resolutions) for m in methods if m.method == GRID and m.resolutions), default=0
    )
    if isinstance(draft.geometry, RoughGeometry) and cells(draft.geometry, finest) > MOST_POINTS:
        yield (
            f"fields of {GRID} above {MOST_POINTS} cells are stored as means over blocks, "
            f"at most {SIDE} a side; quantities are of all cells"
        )


def _plan_methods(draft: Plan) -> Iterable[MethodPlan]:
    """Yield the plan of every method; all that broke is told at once."""
    broken = []
    for name in (known for known in METHODS if concerns(known, draft.scene)):
        try:
            yield _plan_method(draft, name)
        except InputError as error:
            broken.append(str(error))
    if broken:
        raise InputError("\n".join(broken))


def _plan_method(draft: Plan, name: str) -> MethodPlan:
    scene = draft.scene
    if scene.compare.methods is not None and name not in scene.compare.methods:
        return MethodPlan(name, False, "not asked for")
    solver = solver_for(name, scene)
    if isinstance(solver, Refusal):
        if solver.broken:
            raise InputError(f"--method-file: {name}: {scene.name}: {solver.reason}")
        return MethodPlan(name, False, solver.reason)
    if METHODS[name].on_request and scene.compare.methods is None:
        return MethodPlan(name, False, "takes seconds per load: runs only if named")
    planned = solver.resolutions(draft.geometry)
    if scene.compare.resolutions is not None and planned != EXACT:
        planned = scene.compare.resolutions
    refusals = {n: _refusal(draft, name, solver, n) for n in planned}
    feasible = tuple(n for n in planned if not refusals[n])
    dropped = [f"{n}: {reason}" for n, reason in refusals.items() if reason]
    if not feasible:
        return MethodPlan(name, False, dropped[0].partition(": ")[2])
    reason = solver.note if not dropped else "left out " + "; ".join(dropped)
    modelled = solver.model(draft.geometry)
    need = max(solver.memory(_first_task(draft, solver, n)) for n in feasible)
    if need > WORTH_SAYING:
        modelled += f"; about {need / 1e9:.1f} GB of memory"
    return MethodPlan(name, True, reason, feasible, modelled, pilots(solver, feasible))


def pilots(solver: Solver[Any], resolutions: tuple[int, ...]) -> tuple[int, ...]:
    """Return how many surfaces or lines are solved before their scatter is known, whole tasks.

    Empty where the number is not a matter of scatter: single contacts, single surfaces, physics
    with ensembles of their own, methods that are compared with the leading grid in pairs.
    """
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


def surface_cost(method: str, resolution: int) -> float:
    """Return the cost of a surface, in solves of 64 x 64 points; measured once (`facts`).

    Times measured in a run would give other numbers of surfaces, and other digits, in the next.
    """
    return float(growth(method) ** np.log2(resolution / 64))


def single_resolution(planned: tuple[int, ...], geometry: Geometry) -> int:
    """Return the one resolution that a single solve uses: a synthetic surface's own points.

    Else the finest planned, which is the one that aims at the tolerance.
    """
    synthetic = isinstance(geometry, RoughGeometry) and geometry.random
    return planned[0] if synthetic else planned[-1]


def _first_task(draft: Plan, solver: Solver[Any], resolution: int) -> Task:
    """Return a whole task of a method: as many surfaces or lines as it holds at once."""
    first = pilots(solver, (resolution,))
    count = first[0] if first else realisation_count(draft.scene, solver.name, draft.realisations)
    block = tuple(range(min(count, solver.block(resolution))))
    return task_of(draft, solver.name, resolution, block)


def refusal(draft: Plan, name: str, resolution: int) -> str:
    """Return why a resolution is not run, or an empty text."""
    solver = solver_for(name, draft.scene)
    return (
        solver.reason if isinstance(solver, Refusal) else _refusal(draft, name, solver, resolution)
    )


def _refusal(draft: Plan, name: str, solver: Solver[Any], resolution: int) -> str:
    geometry = draft.geometry
    if isinstance(geometry, RoughGeometry) and METHODS[name].dimension == 3:
        problem = _grid_problem(geometry, resolution)
        if problem:
            return problem
    task = _first_task(draft, solver, resolution)
    try:
        refused = solver.refusal(task)
    except (ValueError, ArithmeticError) as error:
        return str(error)
    if refused:
        return refused
    need, free = solver.memory(task), free_memory()
    if need > MEMORY_SHARE * free:
        return f"needs about {need / 1e9:.1f} GB, and {free / 1e9:.1f} GB are free"
    return ""


def _grid_problem(geometry: RoughGeometry, resolution: int) -> str:
    points = geometry.points[0]
    step = points // resolution if points % resolution == 0 else 0
    if resolution % points == 0 or (step and all(n % step == 0 for n in geometry.points)):
        return ""
    return f"neither a multiple nor a divisor of the surface's own {points} points per side"


def _check_size(scene: Scene) -> None:
    """Refuse what cannot fit before any memory is taken."""
    problems = []
    free = free_memory()
    if isinstance(scene.surface, SelfAffine):
        nx, ny = scene.surface.points
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


def _mirrored_part(even: tuple[bool, bool]) -> tuple[str, str]:
    if all(even):
        return "three quarters of the finite-element mesh", "x = 0 and y = 0 are symmetry planes"
    return "half of the finite-element mesh", f"{'xy'[even.index(True)]} = 0 is a symmetry plane"


def _left_out(scene: Scene, geometry: Geometry) -> Iterable[tuple[str, str]]:
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
        if any(geometry.indenter.even) and not scene.physics:
            yield _mirrored_part(geometry.indenter.even)
    else:
        yield (
            "the body below the surface, in the half-space methods",
            "its response to pressure is known in closed form (kernel)",
        )
