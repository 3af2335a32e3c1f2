"""Cost of the finite-element reference, with one Pardiso factorisation of its matrix as yardstick.

The job is Hertz's paraboloid at thirty penetrations with closed-form forces: mesh, assembly,
condensation and all loads, on one thread. The yardstick is the ordering and factorisation of the
same matrix by MKL Pardiso (symmetric positive definite), measured in turns with the job. Processor
times are used, which are independent of other load on the machine.
"""

from __future__ import annotations

import statistics
import time
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from functools import cache, partial
from importlib.util import find_spec
from pathlib import Path

import numpy as np
from scipy import sparse
from threadpoolctl import threadpool_limits

from comparisons.facts.methods import METHODS
from comparisons.judging.metrics import rms_and_maximum
from comparisons.machine import free_memory
from comparisons.methods import runner
from comparisons.methods.fem.step import bytes_of_elimination
from comparisons.methods.registry import solver_of
from comparisons.questions.benchmarks.yardstick import Measurement, growth, interleaved, measurement
from comparisons.scene.scene import parse_scene
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from reference import fem
from reference.fem.condensation import LinearSystem
from reference.loads import Load

DEPTHS = np.linspace(0.1, 1.0, 30)  # with unit radii: contact radii from 0.32 to 1
POISSON = 0.3
READINGS = 5
LEVELS = (2, 3, 4, 5, 6, 7, 8)
ITERATIVE_LEVEL = 6
SIZES = (3, 4, 6, 8, 10, 12, 14)
LARGEST_PARDISO = 150_000  # largest number of unknowns; beyond it, the yardstick takes minutes
NO_PARDISO = "no pypardiso: pip install 'roughline[fast]'"
FACTORISATION = "one Pardiso factorisation of the same matrix"
NOT_FACTORISED = "not factorised at this size"
WHOLE, FIXED, ITERATIVE, PEER = 2.0, 3.0, 1.0, 1 / 20
ITERATIVE_SOLVER, LARGEST_LEVEL = "conjugate_gradients", 26
PEER_LEVELS = (2, 3, 4, 6, 8, 12, 16)


def measure() -> list[Measurement]:
    """Run the measurements; takes minutes."""
    rows = [*hertz(2e-4), *hertz(2e-5), fixed_mesh(5e-4), iterative()]
    return [*rows, against_peer("ngsolve"), *sizes()]


@dataclass(frozen=True)
class Swept:
    """Results of a complete job."""

    body: fem.CondensedBody
    errors: np.ndarray
    sweep_seconds: float


def run(elements: int, solver: str = "nested_dissection") -> Swept:
    """Mesh, assemble, condense, and solve all depths on the mesh scaled to the contact."""
    body = fem.half_space_body(_rings(elements), fem.Material(1.0, POISSON), solver=solver)
    return _job(body, partial(fem.indent, body, _paraboloid, Load("penetration", DEPTHS)))


def _timed(elements: int, solver: str = "nested_dissection") -> tuple[Swept, float]:
    """Return a job and its processor time on one thread."""
    with threadpool_limits(limits=1):
        start = time.process_time()
        job = run(elements, solver)
        return job, time.process_time() - start


def run_fixed(elements: int) -> Swept:
    """Solve on one mesh with straight lines, independent of the contact edge."""
    lines = np.linspace(0.0, 1.02, elements + 1)
    body = fem.half_space_body(
        fem.TensorMesh(lines, lines, symmetry="quarter", order=2, extent=2.0),
        fem.Material(1.0, POISSON),
    )
    gap = _paraboloid(*body.points.T)
    return _job(
        body, lambda: ((body, depth) for depth in fem.press(body, gap, Load("penetration", DEPTHS)))
    )


def hertz(bound: float) -> list[Measurement]:
    """Time the job and its parts on the coarsest mesh with its largest error within the bound."""
    elements = next(n for n in LEVELS if _worst(n) <= bound)
    job = run(elements)
    title = f"Hertz, 30 depths, force within {bound:.0e} (found {_worst(elements):.1e}), "
    title += f"{job.body.unknowns} unknowns"
    rows, shares = _against_pardiso(f"{title}: whole job", partial(run, elements), job, WHOLE)
    job_row = rows[0]
    parts = [job.body.seconds | {"sweep": job.sweep_seconds} for job in shares]
    for name in parts[0]:
        share = statistics.median(timing[name] / sum(timing.values()) for timing in parts)
        ratio = None if job_row.ratio is None else share * job_row.ratio
        part = share * job_row.seconds
        rows.append(
            Measurement(
                f"{title}: {name}", part, job_row.yardstick, job_row.yardstick_seconds, ratio
            )
        )
    return rows


def fixed_mesh(bound: float) -> Measurement:
    """Time the job without scaling, with the rms of the relative errors within the bound."""
    elements = next(n for n in range(6, 16) if rms_and_maximum(run_fixed(n).errors)[0] <= bound)
    job = run_fixed(elements)
    title = f"Hertz, 30 depths, fixed mesh, force rms within {bound:.0e} (found "
    title += f"{rms_and_maximum(job.errors)[0]:.1e}), {job.body.unknowns} unknowns: whole job"
    return _against_pardiso(title, partial(run_fixed, elements), job, FIXED)[0][0]


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
        before = _peak_memory()
        job, spent = _timed(elements)
        unknowns, memory = job.body.unknowns, _peak_memory()
        grown = f", peak memory {memory / 1e9:.2f} GB" if memory > before else ""
        title = f"cost at {unknowns} unknowns{grown}"
        rows[unknowns] = Measurement(title, spent, NOT_FACTORISED)
        if unknowns <= LARGEST_PARDISO and _has_pardiso():
            matrix = _stiffness(job.body.system)
            with threadpool_limits(limits=1):
                start = time.process_time()
                _factorise(matrix)
                factorised = time.process_time() - start
            rows[unknowns] = measurement(title, [spent], FACTORISATION, [factorised])
    late = {unknowns: row for unknowns, row in rows.items() if unknowns >= 1e4}
    job, spent = _timed(LARGEST_LEVEL, ITERATIVE_SOLVER)
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


def _job(
    body: fem.CondensedBody,
    press: Callable[[], Iterable[tuple[fem.CondensedBody, fem.NodalContact]]],
) -> Swept:
    start = time.perf_counter()
    steps = list(press())
    spent = time.perf_counter() - start
    hertz_force = 4.0 / 3.0 * body.effective_modulus * DEPTHS**1.5
    errors = np.array([step.force for _, step in steps]) / hertz_force - 1.0
    return Swept(body, errors, spent)


@cache
def _worst(elements: int) -> float:
    return float(np.abs(run(elements).errors).max())


def _against_pardiso(
    title: str, task: Callable[[], Swept], job: Swept, target: float
) -> tuple[list[Measurement], list[Swept]]:
    """Time a job and Pardiso in turns; also return the jobs with the times of their parts."""
    jobs: list[Swept] = []
    tasks: dict[str, Callable[[], object]] = {"job": lambda: jobs.append(task())}
    if not _has_pardiso():
        times = interleaved(tasks, READINGS, time.process_time)["job"]
        row = Measurement(title, statistics.median(times), NO_PARDISO, target=target)
        return [row], jobs
    matrix = _stiffness(job.body.system)
    tasks["yardstick"] = partial(_factorise, matrix)
    both = interleaved(tasks, READINGS, time.process_time)
    return [measurement(title, both["job"], FACTORISATION, both["yardstick"], target)], jobs


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
    scene = f"""
name = "hertz"
[half_space]
youngs_modulus = 1.0
poisson_ratio = {POISSON}
[indenter]
shape = "paraboloid"
radius = 1.0
[loading]
penetration = [0.01]
[compare]
methods = ["{peer}"]
resolutions = {list(PEER_LEVELS)}
"""
    (plan, *_) = plan_scene(parse_scene(scene, "hertz", Path()), "full")
    (planned,) = [method for method in plan.methods if method.method == peer]
    if not planned.supported:
        return planned.reason
    exact = 4.0 / 3.0 / (1.0 - POISSON**2) * 0.01**1.5
    best = np.inf
    for level in planned.resolutions:
        start = time.process_time()
        task = task_of(plan, peer, level)
        solution = runner.run(solver_of(task), task)
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


def _peak_memory() -> float:
    """Return the peak resident memory of this process in bytes (NaN if unknown)."""
    try:
        import resource
    except ImportError:  # Windows
        return float("nan")
    return 1024.0 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
