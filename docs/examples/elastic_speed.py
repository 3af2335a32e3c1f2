"""Compare what a purely elastic, frictionless scene costs with what it cost at another commit.

Run from the repository's root, which must be a git clone (five minutes on one core)::

    python docs/examples/elastic_speed.py            # before: e6960eb, after: the tree as it is
    python docs/examples/elastic_speed.py --before COMMIT --sessions 12 --rounds 7

Two worker processes stay warm, one in a worktree of each commit. They take turns on one core: each
round every task is done before and after, in an order that swaps from round to round, and counted
in processor time. A task is everything that `roughline run` does for a scene with one method:
reading, planning, solving at a resolution that both have. Where the arrays of a process lie in
memory shifts its times by some per cent for as long as it lives: every session has new processes.
The ratio of a task is the median over the sessions of the median over a session's rounds, its
interval that of the ordered sessions (95 %, binomial). The last column is the ratio of the shortest
times of all, which other work on the machine disturbs least.
"""

# %%
import argparse
import json
import math
import os
import statistics
import subprocess
import sys
import tempfile
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
BEFORE = "e6960eb"
TARGET = 1.02
# Scene, method, resolution, solves per reading: readings of a tenth of a second or so.
TASKS = (
    ("paraboloid", "closed_form", 2, 16),
    ("paraboloid", "reduced", 40, 16),
    ("paraboloid", "bem_fft", 32, 4),
    ("paraboloid", "bem_dense", 10, 4),
    ("cone", "reduced", 40, 16),
    ("square-punch", "bem_fft", 64, 4),
    ("rough-free", "reduced", 64, 12),
    ("rough-free", "bem_fft", 64, 1),
    ("rough-periodic", "bem_fft", 64, 1),
)

Readings = dict[tuple, list[tuple[float, float]]]
TOGETHER = ("all", "", "", 1)

# %% [markdown]
# The worker: one line of JSON asks, one answers. It uses only what both trees have.

# %%
WORKER = """
import json, sys, time
from comparisons.planning import plan_scene
from comparisons.scene import load_scene
from comparisons.solving import solve_plan

def task(name, method, resolution):
    changes = {"compare.methods": [method], "compare.resolutions": [resolution]}
    for plan in plan_scene(load_scene(name, changes))[:1]:
        solved = solve_plan(plan, repeats=1, bodies=False)
        assert all(solution.converged.all() for solution in solved.values()), (name, method)

for line in sys.stdin:
    name, method, resolution, count = json.loads(line)
    start = time.process_time()
    for _ in range(count):
        task(name, method, resolution)
    print(json.dumps((time.process_time() - start) / count), flush=True)
"""


class Worker:
    """A warm process in a tree of its own."""

    def __init__(self, tree: Path) -> None:
        names = ("OMP_NUM_THREADS", "NUMBA_NUM_THREADS", "OPENBLAS_NUM_THREADS")
        environment = {**os.environ, "PYTHONPATH": str(tree), **dict.fromkeys(names, "1")}
        self.process = subprocess.Popen(  # noqa: S603
            [sys.executable, "-c", WORKER],
            cwd=tree,
            env=environment,
            text=True,
            stdin=subprocess.PIPE,
            stdout=subprocess.PIPE,
        )

    def ask(self, task: tuple) -> float:
        """Return the seconds of a task."""
        assert self.process.stdin is not None
        assert self.process.stdout is not None
        self.process.stdin.write(json.dumps(task) + "\n")
        self.process.stdin.flush()
        answer = self.process.stdout.readline()
        if not answer:
            raise RuntimeError(f"the worker ended at {task}")
        return float(json.loads(answer))

    def close(self) -> None:
        """End the process."""
        assert self.process.stdin is not None
        self.process.stdin.close()
        self.process.wait()


def paired(before: Worker, after: Worker, rounds: int) -> Readings:
    """Seconds of every task before and after, round by round; the first round only warms up."""
    seconds: Readings = {task: [] for task in TASKS}
    for number in range(rounds + 1):
        for task in TASKS:
            if number % 2:
                old, new = before.ask(task), after.ask(task)
            else:
                new, old = after.ask(task), before.ask(task)
            if number:
                seconds[task].append((old, new))
    return seconds


def interval(ratios: list[float]) -> tuple[float, float]:
    """Return the 95 % interval of a median: order statistics by the binomial distribution."""
    ordered, n = sorted(ratios), len(ratios)
    below, k = 0.0, 0
    while (below := below + math.comb(n, k) / 2**n) <= 0.025:
        k += 1
    return ordered[max(k - 1, 0)], ordered[min(n - k, n - 1)]


def summed(seconds: Readings) -> Readings:
    """Add the time of all tasks together, as one more."""
    together = zip(*seconds.values(), strict=True)
    return {**seconds, TOGETHER: [tuple(map(sum, zip(*pairs, strict=True))) for pairs in together]}


def rows(sessions: list[Readings]) -> list[list[str]]:
    """Return the table; its last row is all tasks together."""
    table = [["scene", "method", "N", "before", "after", "after/before", "95 %", "of the least"]]
    for task in sessions[0]:
        pairs = [pair for seconds in sessions for pair in seconds[task]]
        times = [
            f"{1e3 * statistics.median(round_seconds):.1f} ms"
            for round_seconds in zip(*pairs, strict=True)
        ]
        ratios = [
            statistics.median(new / old for old, new in seconds[task]) for seconds in sessions
        ]
        low, high = interval(ratios)
        old, new = (min(round_seconds) for round_seconds in zip(*pairs, strict=True))
        ratio_cells = [
            f"{statistics.median(ratios):.3f}",
            f"{low:.3f}-{high:.3f}",
            f"{new / old:.3f}",
        ]
        table.append([*(str(parameter) for parameter in task[:3]), *times, *ratio_cells])
    return table


def session(tree: Path, rounds: int) -> Readings:
    """Measure with two new processes."""
    before, after = Worker(tree), Worker(ROOT)
    seconds = paired(before, after, rounds)
    before.close()
    after.close()
    return summed(seconds)


def main() -> int:
    """Print the table; 1 if the whole, or a task for certain, is slower than the target allows."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--before", default=BEFORE)
    parser.add_argument("--sessions", type=int, default=8)
    parser.add_argument("--rounds", type=int, default=5)
    options = parser.parse_args()
    with tempfile.TemporaryDirectory() as folder:
        tree = Path(folder) / "before"
        git = ["git", "-C", str(ROOT), "worktree"]
        subprocess.run(  # noqa: S603
            [*git, "add", "--detach", "-f", str(tree), options.before], check=True
        )
        try:
            table = rows([session(tree, options.rounds) for _ in range(options.sessions)])
        finally:
            subprocess.run([*git, "remove", "--force", str(tree)], check=True)  # noqa: S603
    for row in table:
        print(f"| {' | '.join(row)} |")
    fast_enough = float(table[-1][5]) <= TARGET
    single = all(float(row[6].split("-")[0]) <= TARGET for row in table[1:])
    return 0 if fast_enough and single else 1


# %%
if __name__ == "__main__":
    sys.exit(main())
