"""Executors of independent jobs: this process, local processes, or a cluster.

A study, a run of claims, a calibration and the hard cases are lists of independent jobs. Each
executor takes jobs at any time (`add`) and gives their results as they come (`finished`); what a
job finds does not depend on the executor, on the number of workers, or on the order.
"""

from __future__ import annotations

from comparisons.solving.executors.base import Executor, SerialExecutor
from comparisons.solving.executors.local import ProcessExecutor

__all__ = ["Executor", "ProcessExecutor", "SerialExecutor", "executor_for"]


def executor_for(workers: int = 1, scheduler: str | None = None) -> Executor:
    """Return what carries out the work: a cluster, processes here, or this process.

    Parameters
    ----------
    workers : int
        Processes here, each on one thread; 1 works in this process.
    scheduler : str, optional
        Address of a running ``dask.distributed`` scheduler; its workers are used, none here.

    Raises
    ------
    comparisons.errors.InputError
        If no scheduler answers there, the packages are missing, or its workers run other versions.
    """
    if scheduler is not None:
        from comparisons.solving.executors.cluster import ClusterExecutor

        return ClusterExecutor(scheduler)
    return SerialExecutor() if workers == 1 else ProcessExecutor(workers)
