"""Cost of the finite-element reference, with one Pardiso factorisation of its matrix as yardstick.

The job is Hertz's paraboloid at thirty penetrations with closed-form forces: mesh, assembly,
condensation and all loads, on one thread. The yardstick is the ordering and factorisation of the
same matrix by MKL Pardiso (symmetric positive definite), measured in turns with the job. Processor
times are used, which are independent of other load on the machine.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable
from dataclasses import dataclass
from functools import cache, partial
from importlib.util import find_spec
from typing import Any, TypeVar

import numpy as np
from scipy import sparse
from threadpoolctl import threadpool_limits

from comparisons.facts.methods import METHODS
from comparisons.judging.metrics import rms_and_maximum
from comparisons.machine import free_memory
from comparisons.methods import runner
from comparisons.methods.fem.step import bytes_of_elimination
from comparisons.methods.registry import planned_solver
from comparisons.questions.benchmarks.yardstick import Measurement, growth, interleaved, measurement
from comparisons.scene.scene import load_scene
from comparisons.solving.execution import peak_memory
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference import fem
from reference.fem.condensation import LinearSystem
from reference.loads import Load

T = TypeVar("T")
DEPTHS = np.linspace(0.1, 1.0, 30)  # with unit radii: contact radii from 0.32 to 1
POISSON = 0.3
READINGS = 5
LEVELS = (2, 3, 4, 5, 6, 7, 8)
ITERATIVE_LEVEL = 6
SIZES = (3, 4, 6, 8, 10, 12, 14)
LARGEST_PARDISO = 150_000  # largest number of unknowns; beyond it, the yardstick takes minutes
NO_PARDISO = "no pypardiso: pip install 'roughline[pardiso]'"
FACTORISATION = "one Pardiso factorisation of the same matrix"
NOT_FACTORISED = "not factorised at this size"
WHOLE, FIXED, ITERATIVE, PEER = 2.0, 3.0, 1.0, 1 / 20
ITERATIVE_SOLVER, LARGEST_LEVEL = "conjugate_gradients", 26
PEER_LEVELS = (2, 3, 4, 6, 8, 12, 16)


def measure() -> list[Measurement]:
    """Run the measurements; takes minutes."""
    rows = [*hertz(2e-4), *hertz(2e-5), *hertz(5e-4, fixed=True), iterative()]
    return [*rows, against_peer("ngsolve"), *sizes()]


@dataclass(frozen=True)
class Swept:
    """Results of a complete job."""

    body: fem.CondensedBody
    errors: np.ndarray
    sweep_seconds: float


def run(elements: int, solver: str = "nested_dissection", *, fixed: bool = False) -> Swept:
    """Mesh, assemble, condense, and solve all depths on the mesh scaled to the contact.

    Or on a fixed one with straight lines, independent of the contact edge.
    """
    mesh: fem.RingMesh | fem.TensorMesh = _rings(elements)
    if fixed:
        lines = np.linspace(0.0, 1.02, elements + 1)
        mesh = fem.TensorMesh(lines, lines, symmetry="quarter", order=2, extent=2.0)
    body = fem.half_space_body(mesh, fem.Material(1.0, POISSON), solver=solver)
    start, loads = time.perf_counter(), Load("penetration", DEPTHS)
    if fixed:
        contacts = list(fem.press(body, _paraboloid(*body.points.T), loads))
    else:
        contacts = [contact for _, contact in fem.indent(body, _paraboloid, loads)]
    spent = time.perf_counter() - start
    hertz_force = 4.0 / 3.0 * body.effective_modulus * DEPTHS**1.5
    return Swept(body, np.array([c.force for c in contacts]) / hertz_force - 1.0, spent)


@cache
def _error(elements: int, fixed: bool) -> float:
    return rms_and_maximum(run(elements, fixed=fixed).errors)[0 if fixed else 1]


def _timed(work: Callable[..., T], *arguments: Any) -> tuple[T, float]:
    """Return the answer of a function and its processor time on one thread."""
    with threadpool_limits(limits=1):
        start = time.process_time()
        return work(*arguments), time.process_time() - start


def hertz(bound: float, *, fixed: bool = False) -> list[Measurement]:
    """Time the job and Pardiso in turns, on the coarsest mesh with its error within the bound.

    The largest error over the depths, on a fixed mesh the rms. On others, the job's parts, too.
    """
    levels = range(6, 16) if fixed else LEVELS
    elements = next(n for n in levels if _error(n, fixed) <= bound)
    task, target = partial(run, elements, fixed=fixed), FIXED if fixed else WHOLE
    job, jobs = task(), list[Swept]()
    kind = "fixed mesh, force rms" if fixed else "force"
    title = f"Hertz, 30 depths, {kind} within {bound:.0e} (found {_error(elements, fixed):.1e}), "
    title += f"{job.body.unknowns} unknowns"
    tasks: dict[str, Callable[[], object]] = {"job": lambda: jobs.append(task())}
    if _has_pardiso():
        tasks["yardstick"] = partial(_factorise, _stiffness(job.body.system))
    times, whole = interleaved(tasks, READINGS, time.process_time), f"{title}: whole job"
    row = Measurement(whole, statistics.median(times["job"]), NO_PARDISO, target=target)
    if _has_pardiso():
        row = measurement(whole, times["job"], FACTORISATION, times["yardstick"], target)
    rows, parts = [row], [job.body.seconds | {"sweep": job.sweep_seconds} for job in jobs]
    for name in parts[0] if not fixed else ():
        share = statistics.median(timing[name] / sum(timing.values()) for timing in parts)
        ratio = None if row.ratio is None else share * row.ratio
        seconds, yardstick = share * row.seconds, (row.yardstick, row.yardstick_seconds)
        rows.append(Measurement(f"{title}: {name}", seconds, *yardstick, ratio))
    return rows


def iterative() -> Measurement:
    """Time conjugate gradients against a condensed job at about 25 000 unknowns."""
    elements = ITERATIVE_LEVEL
    direct = "nested_dissection"
    tasks = {name: partial(run, elements, name) for name in (ITERATIVE_SOLVER, direct)}
    times = interleaved(tasks, 3, time.process_time)
    job = run(elements, ITERATIVE_SOLVER)
    title = f"conjugate gradients, {job.body.unknowns} unknowns, "
    title += f"force {np.abs(job.errors).max():.1e}: whole job"
    yardstick = f"whole job, condensed by {direct}"
    return measurement(title, times[ITERATIVE_SOLVER], yardstick, times[direct], ITERATIVE)


def against_peer(peer: str) -> Measurement:
    """Compare with an independent code at one depth with at most our error."""
    ours = run(LEVELS[1])
    worst = float(np.abs(ours.errors).max())
    name = f"Hertz, one depth, error {worst:.1e}"

    def single() -> None:
        body = fem.half_space_body(_rings(LEVELS[1]), fem.Material(1.0, POISSON))
        next(fem.indent(body, _paraboloid, Load("penetration", 1.0)))

    times = interleaved({"ours": single}, READINGS, time.process_time)["ours"]
    if peer not in METHODS:
        return Measurement(name, statistics.median(times), f"{peer}: no such method")
    peer_run = _peer_seconds(peer, worst)
    if isinstance(peer_run, str):
        return Measurement(name, statistics.median(times), peer_run, target=PEER)
    seconds, error, unknowns = peer_run
    yardstick = f"{peer}, {unknowns} unknowns, error {error:.1e}"
    return measurement(name, times, yardstick, [seconds] * len(times), PEER)


def sizes() -> list[Measurement]:
    """Return cost and memory against the number of unknowns, and the exponent of the cost.

    Nested dissection of a cube costs N^2 at most (George 1973). Two million unknowns are solved by
    conjugate gradients.
    """
    rows: dict[int, Measurement] = {}
    for elements in SIZES:
        if bytes_of_elimination(_rings(elements)) > free_memory():
            break
        before = peak_memory()
        job, spent = _timed(run, elements)
        unknowns, memory = job.body.unknowns, peak_memory()
        grown = f", peak memory {memory / 1e9:.2f} GB" if memory > before else ""
        title = f"cost at {unknowns} unknowns{grown}"
        rows[unknowns] = Measurement(title, spent, NOT_FACTORISED)
        if unknowns <= LARGEST_PARDISO and _has_pardiso():
            _, factorised = _timed(_factorise, _stiffness(job.body.system))
            rows[unknowns] = measurement(title, [spent], FACTORISATION, [factorised])
    late = {unknowns: row for unknowns, row in rows.items() if unknowns >= 1e4}
    job, spent = _timed(run, LARGEST_LEVEL, ITERATIVE_SOLVER)
    assert job.body.iterative is not None
    steps = " and ".join(str(count) for count in job.body.iterative.iterations)
    title = f"conjugate gradients, {job.body.unknowns} unknowns, {steps} steps, "
    title += f"force {np.abs(job.errors).max():.1e}: whole job"
    fronts = growth(late, "unknowns", ("N^2 of dense fronts", np.square))
    return [*rows.values(), fronts, Measurement(title, spent, NOT_FACTORISED)]


def _rings(elements: int) -> fem.RingMesh:
    return fem.RingMesh(1.0, elements=elements, edge=1.0)


def _paraboloid(x: np.ndarray, y: np.ndarray) -> np.ndarray:
    return 0.5 * (x**2 + y**2)


def _has_pardiso() -> bool:
    """Return whether pypardiso can be imported (wheels for 64-bit Intel and AMD only)."""
    return find_spec("pypardiso") is not None


def _stiffness(system: LinearSystem) -> sparse.csr_array:
    """Return the sparse symmetric matrix on the free unknowns, followed by the far-field unknowns.

    Boundary displacements are replaced by the far-field unknowns that they follow.
    """
    unknowns = system.unknowns
    size = unknowns.shape[1]
    rows = np.repeat(unknowns, size, axis=1).ravel()
    columns = np.tile(unknowns, (1, size)).ravel()
    inside = (rows >= 0) & (columns >= 0)
    total = system.first + len(system.boundary)
    entries = (system.matrices.ravel()[inside], (rows[inside], columns[inside]))
    matrix = sparse.coo_array(entries, shape=(total, total)).tocsr()
    if system.exterior is not None:
        follow = sparse.block_diag([sparse.eye_array(system.first), system.boundary], format="csr")
        zero = sparse.csr_array((system.first, system.first))
        matrix = follow.T @ matrix @ follow
        matrix = sparse.csr_array(matrix + sparse.block_diag([zero, system.exterior], format="csr"))
    matrix.sort_indices()
    return matrix


def _factorise(matrix: sparse.csr_array) -> None:
    """Order and factorise a symmetric positive definite matrix: the least cost of a direct one."""
    from pypardiso import PyPardisoSolver

    upper = sparse.csr_matrix(sparse.triu(matrix, format="csr"))
    upper.sort_indices()
    solver = PyPardisoSolver(mtype=2)  # MKL's number for real symmetric positive definite ones
    solver.factorize(upper)
    solver.free_memory(everything=True)


def _peer_seconds(peer: str, bound: float) -> tuple[float, float, int] | str:
    """Return time, error and unknowns of a peer's coarsest mesh within the given error."""
    tables = {
        "name": "hertz",
        "half_space": {"youngs_modulus": 1.0, "poisson_ratio": POISSON},
        "indenter": {"shape": "paraboloid", "radius": 1.0},
        "loading": {"penetration": [0.01]},
        "compare": {"methods": [peer], "resolutions": list(PEER_LEVELS)},
    }
    (plan, *_) = plan_scene(load_scene(tables), "full")
    (planned,) = [method for method in plan.methods if method.method == peer]
    if not planned.supported:
        return planned.reason
    exact = 4.0 / 3.0 / (1.0 - POISSON**2) * 0.01**1.5
    best = np.inf
    for level in planned.resolutions:
        start = time.process_time()
        task = task_of(plan, peer, level)
        solution = runner.run(planned_solver(task), task)
        # a peer measures its time itself, in its separate process
        timed = np.isfinite(solution.seconds)
        spent = solution.seconds if timed else time.process_time() - start
        if not solution.converged.all():
            continue
        error = abs(float(solution.quantities["force"][0, 0]) / exact - 1.0)
        best = min(best, error)
        if error <= bound:
            return spent, error, solution.unknowns
    return f"{peer}: best error {best:.1e} on the meshes it can do"
