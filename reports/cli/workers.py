"""Options of every command that runs many solves: worker processes or a cluster."""

from __future__ import annotations

import os
from dataclasses import dataclass
from typing import TYPE_CHECKING

from cyclopts import Parameter

from reports.cli.arguments import MaybeWhole

if TYPE_CHECKING:
    from comparisons.solving.executors import Executor


@Parameter(name="*")
@dataclass(frozen=True)
class Workers:
    """Where the solves run.

    Parameters
    ----------
    workers
        Number of single-threaded processes; 1 gives the cleanest times. Default: 1 for scenes and
        hard cases, the number of cores (at most 2) for claims and calibration.
    scheduler
        Address of a dask.distributed scheduler (tcp://HOST:PORT) whose workers solve
        (docs/cluster.md).
    """

    workers: MaybeWhole = None
    scheduler: str | None = None

    def executor(self, default: int = 1) -> Executor:
        """Return the executor.

        Raises
        ------
        InputError
            If the number of workers is invalid, or the cluster cannot be used, with the reason.
        """
        from comparisons.errors import InputError
        from comparisons.solving.executors import executor_for

        cores = os.cpu_count() or 1
        chosen = min(default, cores) if self.workers is None else self.workers
        most = max(2, cores)
        if not 1 <= chosen <= most:
            raise InputError(
                f"--workers: expected 1 to {most} (the cores of this machine), got {chosen}"
            )
        if self.scheduler is not None and self.workers is not None:
            raise InputError("--workers and --scheduler: expected at most one")
        return executor_for(chosen, self.scheduler)


ALONE = Workers()
