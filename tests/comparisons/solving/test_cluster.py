"""Solves on a cluster: the same digits, deaths survived, other versions refused.

The cluster is local: a scheduler and workers in processes of their own.
"""

import os
import signal
import threading
import time

import pandas as pd
import pytest

from comparisons.errors import InputError, LostWorkError
from comparisons.questions.study import Study
from comparisons.results.store import RESULTS, load_study
from comparisons.solving import cluster
from comparisons.solving.jobs import Job, executor_for
from comparisons.solving.planning import plan_scene


def results(directory):
    table = pd.read_csv(directory / RESULTS, dtype=str).drop(columns="memory")
    return table[[name for name in table if "seconds" not in name]]


def test_without_dask_the_message_says_what_to_install(monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "distributed", None)
    with pytest.raises(InputError, match=r"pip install 'roughline\[cluster\]'"):
        cluster._connected("tcp://127.0.0.1:1")


distributed = pytest.importorskip("distributed", reason="needs the extra 'cluster'")


def workers(number, threads=1):
    options = {"n_workers": number, "threads_per_worker": threads}
    return distributed.LocalCluster(**options, dashboard_address=":0")


@pytest.fixture(scope="module")
def address():
    with workers(2) as local:
        yield local.scheduler_address


@pytest.fixture
def mortal():
    """Start three workers, of which two may die for good: a nanny may start no other."""
    import dask

    allowed = dask.config.set({"distributed.scheduler.allowed-failures": 1})
    with allowed, workers(3) as local:
        yield local.scheduler_address


@pytest.fixture(scope="module")
def ensemble(rough):
    """Return plans of nine tasks of 25 surfaces, and of the reduced model."""
    compared = {"tolerance": 0.5, "methods": ["reduced", "bem_fft"], "resolutions": [16, 32]}
    return plan_scene(rough(realisations=100, compare=compared), "full")


@pytest.fixture(scope="module")
def serial(ensemble, run_apart, tmp_path_factory):
    out = tmp_path_factory.mktemp("serial") / "out"
    run_apart(Study(list(ensemble), out, effort="full"))
    return results(out)


def pids(address):
    with distributed.Client(address, set_as_default=False) as client:
        return list(client.run(os.getpid).values())


def test_nobody_at_the_address_is_an_input_error(monkeypatch):
    monkeypatch.setattr(cluster, "CONNECT", 0.5)
    with pytest.raises(InputError, match="no scheduler answers there"):
        executor_for(scheduler="tcp://127.0.0.1:9")


@pytest.mark.parametrize("address", ["", "login-1", "tcp://login-1", "post://login-1:8786"])
def test_what_is_no_address_makes_no_client(address, monkeypatch):
    monkeypatch.setattr(distributed, "Client", None)
    with pytest.raises(InputError, match=f"--scheduler {address}: no scheduler answers there"):
        executor_for(scheduler=address)


def test_what_differs_is_listed():
    here = {"numpy": "2.4", "scipy": "1.17", "method own": "abc"}
    there = {"numpy": "2.3", "scipy": "1.17", "tamaas": "2.9"}
    assert cluster.differences(here, there) == [
        "numpy: 2.3, here 2.4",
        "method own: nothing, here abc",
        "tamaas: 2.9, here nothing",
    ]
    assert cluster.differences(here, dict(here)) == []


@pytest.mark.slow
def test_other_versions_are_refused_before_anything_is_solved(address, monkeypatch):
    monkeypatch.setattr(cluster, "source_digest", lambda: "edited here")
    cluster.identity.cache_clear()
    with pytest.raises(InputError, match=r"worker tcp:.*roughline's source: \w+, here edited here"):
        executor_for(scheduler=address)
    cluster.identity.cache_clear()


@pytest.mark.slow
def test_a_worker_that_joins_later_with_other_versions_ends_the_run(address, monkeypatch):
    executor = executor_for(scheduler=address)
    monkeypatch.setattr(executor, "_expected", executor._expected | {"numpy": "99"})
    executor.add([Job("one", pow, (2, 2))])
    with pytest.raises(LostWorkError, match=r"versions differ:\n  numpy: .*, here 99"):
        list(executor.finished())
    assert cluster.identity("[]")["numpy"] != "99"


@pytest.mark.slow
def test_workers_with_more_threads_are_refused():
    refused = pytest.raises(InputError, match="has 2 threads, expected one")
    with workers(1, threads=2) as local, refused:
        executor_for(scheduler=local.scheduler_address)


@pytest.mark.slow
@pytest.mark.nightly
def test_a_study_on_a_cluster_with_a_killed_worker_is_the_serial_one(
    ensemble, mortal, tmp_path, serial
):
    """The worker is killed when a few tasks are done."""
    victim, done = pids(mortal)[0], []

    def kill(campaign, last):
        done.append(last)
        if len(done) == 3:
            os.kill(victim, signal.SIGKILL)

    executor = executor_for(scheduler=mortal)
    study = Study(
        list(ensemble), tmp_path / "cluster", effort="full", executor=executor, watch=kill
    )
    study.run()
    assert study.lost() == []
    pd.testing.assert_frame_equal(results(tmp_path / "cluster"), serial)


@pytest.mark.slow
def test_a_job_that_kills_every_worker_is_lost_with_the_reason(mortal):
    culprit = Job("culprit", os.system, ("kill -KILL $PPID",))
    executor = executor_for(scheduler=mortal)
    executor.add([culprit, Job("good", pow, (2, 3))])
    result = {done.job.key: done for done in executor.finished()}
    assert "died" in result["culprit"].lost
    assert "lack of memory" in result["culprit"].lost
    assert result["good"].value == 8


@pytest.mark.slow
def test_what_fits_into_no_worker_is_lost_at_once(address):
    executor = executor_for(scheduler=address)
    executor.add([Job("huge", pow, (2, 3), memory=1e15), Job("small", pow, (2, 3))])
    result = {done.job.key: done for done in executor.finished()}
    assert result["huge"].lost.startswith("needs 1000000.4 GB, and the largest worker has ")
    assert result["small"].value == 8


@pytest.mark.slow
def test_a_cluster_without_workers_is_told_and_does_the_job_once_one_comes(monkeypatch, capsys):
    monkeypatch.setattr(cluster, "LOOK", 0.5)
    with workers(0) as local:
        executor = executor_for(scheduler=local.scheduler_address)
        executor.add([Job("one", pow, (2, 3))])
        threading.Timer(2.0, local.scale, (1,)).start()
        assert [done.value for done in executor.finished()] == [8]
    assert capsys.readouterr().err.count("has no workers: waiting for one") == 1


@pytest.mark.slow
@pytest.mark.parametrize("seconds", [0.2, 3.0])
def test_a_scheduler_lost_before_the_first_job_ends_the_run(seconds, monkeypatch):
    """Planning or a refinement may take long: the client has given up by then, or not yet."""
    monkeypatch.setattr(cluster, "CONNECT", 1.0)
    with workers(1) as lost:
        executor = executor_for(scheduler=lost.scheduler_address)
    time.sleep(seconds)
    executor.add([Job("one", pow, (2, 2))])
    with pytest.raises(LostWorkError, match=r"the scheduler tcp:.* is gone"):
        list(executor.finished())


@pytest.mark.slow
def test_a_lost_scheduler_keeps_what_is_done_and_resuming_completes_it(
    ensemble, tmp_path, run_apart, serial
):
    local = workers(1)

    def stop(campaign, last):
        if campaign.under_way.counts[0] == 3:
            threading.Thread(target=local.close, daemon=True).start()
            time.sleep(1.0)

    executor = executor_for(scheduler=local.scheduler_address)
    plans, out = list(ensemble), tmp_path / "out"
    with pytest.raises(LostWorkError, match=r"the scheduler tcp:.* is gone"):
        Study(plans, out, effort="full", executor=executor, watch=stop).run()
    assert load_study(out).interrupted
    kept = len(list((out / "fields").glob("*.npz")))
    assert kept >= 3
    run_apart(Study(list(ensemble), out, effort="full", resume=True))
    assert not load_study(out).interrupted
    pd.testing.assert_frame_equal(results(out), serial)
