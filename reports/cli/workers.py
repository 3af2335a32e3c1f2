"""Options of every command that runs many solves: who carries them out."""

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
class Crew:
    """Who carries out the solves.

    Parameters
    ----------
    workers
        Processes, each on one thread; times are cleanest with 1. Default: 1 for scenes and hard
        cases, the cores here (at most 2) for claims and calibration.
    scheduler
        Address of a dask.distributed scheduler (tcp://HOST:PORT): its workers solve
        (docs/cluster.md).
    """

    workers: MaybeWhole = None
    scheduler: str | None = None

    def executor(self, usual: int = 1) -> Executor:
        """Return what carries out the work.

        Raises
        ------
        InputError
            If the number of workers is wrong here, or the cluster cannot be used, with the reason.
        """
        from comparisons.errors import InputError
        from comparisons.solving.executors import executor_for

        cores = os.cpu_count() or 1
        chosen = min(usual, cores) if self.workers is None else self.workers
        most = max(2, cores)
        if not 1 <= chosen <= most:
            raise InputError(f"--workers: expected 1 to {most}, the cores here, got {chosen}")
        if self.scheduler is not None and self.workers is not None:
            raise InputError("--workers and --scheduler: expected at most one of them")
        return executor_for(chosen, self.scheduler)


ALONE = Crew()
