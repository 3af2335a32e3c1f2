"""What an ensemble costs on one and on two processes, and what a task costs a cluster beside.

The tables of docs/cluster.md are printed by (some minutes on two cores; needs the extra
``cluster``)::

    python docs/examples/scaling.py
"""

# %%
import argparse
import os
import pickle
import tempfile
import time
from pathlib import Path

import numpy as np

from comparisons.questions.study import solve_task
from comparisons.scene.scene import make_scene
from comparisons.solving.execution import compile_apart, execute
from comparisons.solving.jobs import Job, executor_for
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene
from comparisons.solving.processes import ProcessExecutor
from comparisons.tasks.solution import Solution, save_solution
from comparisons.tasks.task import Task

SCENE = {
    "name": "ensemble",
    "half_space": {"effective_modulus": 1e9},
    "surface": {
        "kind": "self_affine",
        "hurst": 0.8,
        "size": 1e-6,
        "points": 64,
        "rms_slope": 0.1,
        "realisations": 450,
    },
    "loading": {
        "force": {
            "from": 1e-3,
            "to": 1e-1,
            "steps": 15,
            "spacing": "log",
            "relative_to": "E* A0 h'",
        }
    },
}


def tasks(method: str, count: int) -> list[Task]:
    """Return the first tasks of the ensemble."""
    plan = plan_scene(make_scene(SCENE, "ensemble", Path()), "full")[0]
    return [task_of(plan, method, 64, block) for block in plan.blocks(method, 64)[:count]]


def timed(task: Task) -> tuple[float, int]:
    """Return processor seconds of a solve, and which process did it."""
    start = time.process_time()
    execute(task, repeats=1)
    return time.process_time() - start, os.getpid()


# %% [markdown]
# One and two processes in turn, on the same tasks; the processes are there and warm.


# %%
def scaling(rounds: int, count: int) -> list[tuple[float, float, float, float]]:
    """Return wall and processor seconds of a surface with one and two processes, per round."""
    work = tasks("bem_fft", count)
    surfaces = sum(len(task.realisations) for task in work)
    compile_apart(work[0])
    times = []
    for _ in range(rounds):
        row: list[float] = []
        for workers in (1, 2):
            executor = ProcessExecutor(workers)
            executor.add(Job(f"warm {k}", timed, (work[0],)) for k in range(workers))
            list(executor.finished())
            start = time.perf_counter()
            executor.add(Job(str(k), timed, (task,)) for k, task in enumerate(work))
            done = list(executor.finished())
            wall = time.perf_counter() - start
            row += [wall / surfaces, sum(job.value[0] for job in done) / surfaces]
        times.append((row[0], row[1], row[2], row[3]))
    return times


def sizes(method: str) -> tuple[int, int, int]:
    """Return the bytes of a task, of its solution on the way, and of its file."""
    task = tasks(method, 2)[1]
    solution: Solution = solve_task(task)
    with tempfile.TemporaryDirectory() as name:
        path = Path(name) / "solution.npz"
        save_solution(path, solution)
        return len(pickle.dumps(task)), len(pickle.dumps(solution)), path.stat().st_size


def overhead(count: int) -> tuple[float, float]:
    """Return wall and processor seconds that a job of no work costs client and scheduler.

    Both are in this process; the two workers are not.
    """
    from distributed import LocalCluster

    options = {"n_workers": 2, "threads_per_worker": 1, "dashboard_address": ":0"}
    with LocalCluster(**options) as cluster:
        task = tasks("bem_fft", 1)[0]
        executor = executor_for(scheduler=cluster.scheduler_address)
        executor.add([Job(f"{k}", len, ((task,),)) for k in range(count)])
        start, cpu = time.perf_counter(), time.process_time()
        done = len(list(executor.finished()))
        return (time.perf_counter() - start) / done, (time.process_time() - cpu) / done


def main() -> None:
    """Print everything."""
    parser = argparse.ArgumentParser()
    for option, default in (("rounds", 5), ("tasks", 6), ("jobs", 2000)):
        parser.add_argument(f"--{option}", type=int, default=default)
    options = parser.parse_args()
    rows = np.array(scaling(options.rounds, options.tasks))
    print("| round | 1 process, ms wall (cpu) | 2 processes, ms wall (cpu) | wall | cpu |")
    print("|---|---|---|---|---|")
    for k, (serial, cpu_one, two, cpu_two) in enumerate(rows, start=1):
        cells = f"{1e3 * serial:.1f} ({1e3 * cpu_one:.1f}) | {1e3 * two:.1f} ({1e3 * cpu_two:.1f})"
        print(f"| {k} | {cells} | {serial / (2 * two):.2f} | {cpu_one / cpu_two:.2f} |")
    walls, cpus = rows[:, 0] / (2 * rows[:, 2]), rows[:, 1] / rows[:, 3]
    print(f"median efficiency: wall {np.median(walls):.2f}, processor {np.median(cpus):.2f}")
    for method in ("bem_fft", "reduced"):
        task, solution, file = sizes(method)
        print(f"{method}: task {task} bytes, solution {solution} bytes, file {file} bytes")
    wall, cpu = overhead(options.jobs)
    print(f"a job of no work on a cluster: {1e3 * wall:.1f} ms, {1e3 * cpu:.1f} ms of processor")


if __name__ == "__main__":
    main()
