"""Workers of a ``dask.distributed`` cluster: one thread each, and the same versions as here.

Jobs and results travel as pickles, so a cluster must be as trusted as the user's own account. A
worker that dies is replaced by another (the scheduler gives up on a job after
``distributed.scheduler.allowed-failures``). A scheduler that goes away ends the run.
"""

from __future__ import annotations

import contextlib
import logging
import sys
import time
from collections.abc import Callable, Iterable, Iterator
from functools import lru_cache
from importlib import metadata
from typing import TYPE_CHECKING, Any

from comparisons.errors import InputError, LostWorkError
from comparisons.machine import source_digest, versions
from comparisons.methods.user.external import adopt, announced, digests
from comparisons.solving.jobs import Done, Executor, Job, timed
from comparisons.solving.processes import PROCESS

if TYPE_CHECKING:
    from distributed import Client, Future

MISSING = "--scheduler needs dask.distributed: python -m pip install 'roughline[cluster]'"
# Packages whose versions must be the same on the scheduler, the workers and here.
TRANSPORT = ("dask", "distributed", "cloudpickle", "msgpack")
# Seconds to wait for the scheduler, and between looks at who is there.
CONNECT, LOOK = 10.0, 5.0
# Jobs handed over at a time: enough to keep every worker busy, without all of a million at once.
LEAST_AHEAD, AHEAD_OF_A_WORKER = 200, 4
MOST_PROBLEMS = 12


class ClusterExecutor(Executor):
    """Does jobs on the workers of a scheduler that runs already, as at ``tcp://login-1:8786``."""

    def __init__(self, address: str) -> None:
        super().__init__()
        self._address = address
        self._expected = identity(announced())
        self._client = _connected(address)
        try:
            versions_there: Any = self._client.get_versions()  # of asynchronous clients a coroutine
            packages = versions_there["scheduler"]["packages"]
            problems = [
                f"the scheduler has {name} {packages[name]}, here {self._expected[name]}"
                for name in TRANSPORT
                if name in packages and packages[name] != self._expected[name]
            ]
            threads = self._client.nthreads()
            problems += [
                f"worker {where} has {count} threads, expected one: dask worker --nthreads 1"
                for where, count in threads.items()
                if count != 1
            ]
            answers = self._client.run(identity, announced(), on_error="return")
            for where, answer in answers.items():
                if isinstance(answer, Exception):
                    problems.append(f"worker {where} cannot run roughline: {answer}")
                else:
                    problems += [
                        f"worker {where}: {difference}"
                        for difference in differences(self._expected, answer)
                    ]
        except OSError as error:
            problems = [f"it went away ({error})"]
        if problems:
            self._client.close()
            lines = problems[:MOST_PROBLEMS]
            if len(problems) > MOST_PROBLEMS:
                lines.append(f"... and {len(problems) - MOST_PROBLEMS} more")
            raise InputError("\n  ".join([f"--scheduler {address}:", *lines]))
        self._running: dict[Future, Job] = {}
        self._limits: dict[str, float] = {}
        self._looked = -LOOK
        self._look()

    def finished(self) -> Iterator[Done]:
        """Yield jobs as the workers finish them; the connection is closed at the end."""
        from distributed import CancelledError, KilledWorker, as_completed

        flow, told = as_completed(loop=self._client.loop), False
        try:
            while self._waiting or self._running:
                yield from self._submit(flow)
                if not self._running:
                    continue
                if not (self._limits or told):  # no worker is there; one may come at any time
                    try:
                        self._client.wait_for_workers(1, timeout=LOOK)
                    except TimeoutError:
                        waiting = f"the scheduler {self._address} has no workers: waiting for one"
                        print(
                            f"{waiting} (dask worker {self._address} --nthreads 1)", file=sys.stderr
                        )
                        told = True
                    except (OSError, RuntimeError):  # it went away: the jobs tell
                        pass
                future = next(flow)
                job = self._running.pop(future)
                try:
                    answer = future.result()
                except CancelledError as error:  # the connection was lost, maybe only now
                    raise self._gone() from error
                except KilledWorker as error:
                    died = f"its worker died {error.allowed_failures + 1} times, the last one at "
                    died += f"{error.last_worker.address}; most likely for lack of memory"
                    yield Done(job, lost=died)
                    continue
                finally:
                    future.release()
                yield Done(job, *answer)
        finally:
            with contextlib.suppress(Exception):  # nothing to be told about a lost scheduler
                self._client.cancel(list(self._running))
            self._client.close()

    def _look(self) -> None:
        """See who is there: clusters grow and shrink."""
        if time.monotonic() - self._looked < LOOK:
            return
        workers = self._client.scheduler_info(n_workers=-1)["workers"]
        self._limits = {
            where: worker["memory_limit"] or float("inf") for where, worker in workers.items()
        }
        self.workers = max(1, len(workers))
        self._looked = time.monotonic()

    def _submit(self, flow: Any) -> Iterator[Done]:
        """Hand over jobs; those that fit into no worker come back at once."""
        import cloudpickle

        most = max(LEAST_AHEAD, AHEAD_OF_A_WORKER * self.workers)
        if len(self._running) > most // 2:
            return
        if self._client.status == "closed":  # it has tried in vain to find the scheduler again
            raise self._gone()
        self._look()
        while self._waiting and len(self._running) < most:
            job = self._waiting.popleft()
            fitting = [w for w, limit in self._limits.items() if job.memory + PROCESS <= limit]
            if self._limits and not fitting:
                need = f"needs {(job.memory + PROCESS) / 1e9:.1f} GB"
                largest = f"the largest worker has {max(self._limits.values()) / 1e9:.1f} GB"
                yield Done(job, lost=f"{need}, and {largest}")
                continue
            chosen = fitting if len(fitting) < len(self._limits) else None
            # As bytes, which the scheduler passes on unopened: it needs no roughline, and does not
            # rebuild every scene.
            contents = self._expected, announced(), job.work, job.arguments
            sealed = cloudpickle.dumps(contents)
            future = self._client.submit(
                _opener(), sealed, key=f"{job.key}-{id(self):x}", workers=chosen, pure=False
            )
            self._running[future] = job
            flow.add(future)

    def _gone(self) -> LostWorkError:
        return LostWorkError(f"the scheduler {self._address} is gone")


def _connected(address: str) -> Client:
    try:
        from distributed import Client
        from distributed.comm import parse_address, parse_host_port
        from distributed.comm.registry import get_backend
    except ImportError as error:
        raise InputError(MISSING) from error
    # What it would log is said in our own words, once.
    for name in ("distributed", "distributed.client"):  # dask gives the second a level of its own
        logging.getLogger(name).setLevel(logging.CRITICAL)
    try:
        # First, as a client that fails at an address complains again when Python ends.
        scheme, place = parse_address(address)
        get_backend(scheme)
        parse_host_port(place)
        return Client(address, timeout=CONNECT, set_as_default=False)
    except (OSError, ValueError, TimeoutError) as error:
        raise InputError(f"--scheduler {address}: no scheduler answers there ({error})") from error


@lru_cache(maxsize=4)
def identity(methods: str) -> dict[str, str]:
    """Return what must be the same on all machines: packages, our source, methods from outside."""
    adopt(methods)
    transport = {}
    for name in TRANSPORT:
        with contextlib.suppress(metadata.PackageNotFoundError):
            transport[name] = metadata.version(name)
    return versions() | transport | {"roughline's source": source_digest()[:12]} | digests()


def differences(expected: dict[str, str], actual: dict[str, str]) -> list[str]:
    """Return what differs, in words."""
    return [
        f"{name}: {actual.get(name, 'nothing')}, here {expected.get(name, 'nothing')}"
        for name in dict.fromkeys([*expected, *actual])
        if expected.get(name) != actual.get(name)
    ]


def _opener() -> Callable[[bytes], tuple[Any, float, float]]:
    """Return a function that travels by value: the scheduler must not import roughline for it."""

    def open_and_do(sealed: bytes) -> Any:
        import pickle

        from comparisons.solving.cluster import on_worker

        return on_worker(*pickle.loads(sealed))  # noqa: S301 (sealed by our own client)

    return open_and_do


def on_worker(
    expected: dict[str, str], methods: str, work: Callable[..., Any], arguments: Iterable[Any]
) -> tuple[Any, float, float]:
    """Do a job on a worker, if it is the same as the machine that asks (it may have come late)."""
    if differing := differences(expected, identity(methods)):
        text = "\n  ".join(differing)
        raise LostWorkError(f"a worker joined whose versions differ:\n  {text}\n")
    return timed(work, tuple(arguments))
