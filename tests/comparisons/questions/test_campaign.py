"""Campaigns: whatever is asked, solves are shared, watched, and lost one by one.

SIGKILL at any moment: what is finished is kept, nothing torn is read, nothing differs.
"""

import pickle
import subprocess
import sys
from collections import Counter
from pathlib import Path

import pytest

from comparisons.errors import LostWorkError, ResultsError
from comparisons.questions.calibration import Calibration
from comparisons.questions.claims.claim import load_claims
from comparisons.questions.claims.record import load_claims_record
from comparisons.questions.claims.runner import MEASUREMENTS, ClaimRun
from comparisons.questions.hard_cases.case import catalogue
from comparisons.questions.hard_cases.run import HardCases
from comparisons.questions.study import Study
from comparisons.results.folder import LOCK
from comparisons.results.record import FIELDS_FOLDER
from comparisons.results.store import STUDY, load_study
from comparisons.scene.scene import load_scene
from comparisons.solving import inquiries
from comparisons.solving.jobs import Done, SerialExecutor
from comparisons.solving.planning import plan_scene


class Losing(SerialExecutor):
    """Loses the solves of one method, as if their process had been killed again and again."""

    def __init__(self, method):
        super().__init__()
        self.method = method

    def finished(self):
        for done in super().finished():
            yield Done(done.job, lost="killed") if done.job.kind.method == self.method else done


def test_claims_on_one_scene_share_its_solves(tmp_path, monkeypatch):
    """Force and area of the same springs: no solve is done twice, nor again on resuming."""
    done = Counter()
    execute = inquiries.execute

    def count(task, repeats):
        done[task.scene.text.partition("[compare]")[0], task.method, task.resolution] += 1
        return execute(task, repeats)

    monkeypatch.setattr(inquiries, "execute", count)
    claims = load_claims(("springs-force", "springs-area"))
    vary = claims[0].vary.model_copy(update={"steps": 2, "bisections": 1})
    claims = [claim.model_copy(update={"vary": vary, "tolerance": 0.1}) for claim in claims]
    record = ClaimRun(claims, tmp_path / "out", effort="full").run()
    assert len({point.parameter for claim in record.claims for point in claim.points}) > 2
    assert set(done.values()) == {1}
    files = len(list((tmp_path / "out" / MEASUREMENTS).iterdir()))
    assert files == len(done)
    done.clear()
    again = ClaimRun(claims, tmp_path / "out", effort="full", resume=True).run()
    assert not done
    assert again.claims == record.claims
    assert again.seconds > record.seconds


def test_a_claim_whose_solve_is_lost_is_no_verdict_and_the_others_stand(tmp_path):
    claims = load_claims(("ellipsoid-force", "friction-law-force"))
    with pytest.raises(LostWorkError, match="ellipsoid-force: killed\ncompleted solves are kept"):
        ClaimRun(claims, tmp_path / "out", executor=Losing("reduced")).run()
    record = load_claims_record(tmp_path / "out")
    assert record.interrupted
    assert [claim.id for claim in record.claims] == ["friction-law-force"]


def test_a_hard_case_loses_only_the_method_whose_process_is_killed(tmp_path):
    case = catalogue()["load-one"]
    run = HardCases([case], ["reduced", "bem_fft"], tmp_path / "out", executor=Losing("reduced"))
    lost, sound = run.run().outcomes
    assert (lost.kind, lost.reason) == ("lost", "killed")
    assert lost.deviation == "lost instead of accurate"
    assert not sound.deviation


CAMPAIGNS = {
    "claims": lambda out: ClaimRun(load_claims(("ellipsoid-force",)), out),
    "hard cases": lambda out: HardCases([catalogue()["load-one"]], ["reduced", "bem_dense"], out),
    "a study": lambda out: Study([plan_scene(load_scene("paraboloid"))[0]], out),
}


@pytest.mark.slow
@pytest.mark.parametrize("name", CAMPAIGNS)
def test_every_campaign_tells_how_far_it_is_and_how_long_the_rest_takes(tmp_path, name):
    """From nothing to all; solves come one at a time, and at the end nothing is left."""
    told = []
    campaign = CAMPAIGNS[name](tmp_path / "out")
    campaign.watch = lambda run, done: told.append((run.under_way.counts, run.remaining(), done))
    campaign.run()
    counts = [counts for counts, _, _ in told]
    assert told[0][2] is None
    assert [done for done, _ in counts] == list(range(len(counts)))
    assert counts[-1] == (len(counts) - 1, len(counts) - 1)
    assert told[-1][1].seconds == 0.0
    assert told[-1][1].complete


RUNS = {
    "claims": lambda folder: ClaimRun([], folder, overwrite=True),
    "study": lambda folder: Study([], folder, overwrite=True),
    "hard cases": lambda folder: HardCases([], [], folder),
    "calibration": Calibration,
}


@pytest.mark.parametrize(
    ("theirs", "foreign_to"),
    [
        ("report.html", set(RUNS)),
        ("study.json", set(RUNS) - {"study"}),
        ("claims.json", set(RUNS) - {"claims"}),
        ("results.csv", {"study"}),  # the table of another program
    ],
)
def test_no_campaign_writes_over_the_results_of_another(tmp_path, theirs, foreign_to):
    (tmp_path / theirs).write_text("precious")
    for name in sorted(foreign_to, reverse=True):  # a whole calibration last
        with pytest.raises(ResultsError, match=theirs):
            RUNS[name](tmp_path).run()
    assert [path.name for path in tmp_path.iterdir()] == [theirs]


def test_a_campaign_that_has_not_begun_travels_to_another_process(scene, tmp_path):
    """As tests do that compare a serial run with one on workers."""
    plans = plan_scene(scene(compare={"methods": ["closed_form"]}))
    study = pickle.loads(pickle.dumps(Study(plans, tmp_path / "out")))
    study.run()
    assert study.lost() == []


EXAMPLES = Path(__file__).resolve().parents[3] / "docs" / "examples"


@pytest.mark.slow
@pytest.mark.parametrize(
    ("kind", "workers", "runs"),
    [
        ("run", "0", "3"),
        pytest.param("run", "2", "1", marks=pytest.mark.nightly),
        ("claims", "0", "1"),
        ("ensemble", "0", "2"),
    ],
)
def test_what_is_killed_at_random_moments_ends_like_what_is_not(kind, workers, runs, monkeypatch):
    """A few moments of the twenty of docs/cluster.md, and one of a command with two processes.

    Each command spends seconds on its start, in which nothing can be torn.
    """
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parents[1]))
    words = [kind, "--workers", workers, "--runs", runs, "--size", "20", "--seed", "7"]
    command = [sys.executable, EXAMPLES / "killed_runs.py", *words]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    lines = [line.strip("| ").split(" | ") for line in done.stdout.splitlines()[-int(runs) :]]
    for _, kept, _, redone, left, identical in lines:
        assert (redone, left, identical) == ("0", "0", "yes")
        solves, total = map(int, kept.split(" of "))
        assert solves <= total


def test_what_a_kill_leaves_behind_is_cleaned_and_does_not_stop_a_resume(scene, tmp_path):
    """Temporary files beside whole ones, tables without a study, a torn solution."""
    plans = plan_scene(scene(compare={"methods": ["closed_form", "reduced"]}))
    Study(plans, tmp_path).run()
    fields = tmp_path / FIELDS_FOLDER
    (path, *_) = sorted(fields.glob("*.npz"))
    ours = [
        *(tmp_path / f".{name}.abcd1234" for name in ("results.csv", "study.json", "report.html")),
        *(fields / f".{path.name}.abcd_234", fields / f".{path.stem}.vtu.abcd1234"),
    ]
    theirs = [tmp_path / ".gitignore", tmp_path / ".notes.txt.abcd1234", fields / ".hidden"]
    for part in (*ours, *theirs):
        part.write_bytes(b"torn")
    path.write_bytes(path.read_bytes()[:100])
    study = Study(plans, tmp_path, resume=True)
    study.run()
    assert study.lost() == []
    assert not any(part.exists() for part in ours)
    assert all(part.exists() for part in theirs)


def test_a_folder_is_known_as_ours_from_the_first_moment(scene, tmp_path, monkeypatch):
    """Killed between results.csv and study.json, a first run must not look like someone else's."""
    plans = plan_scene(scene(compare={"methods": ["closed_form"]}))
    seen = []

    def killed(study):
        seen.append(load_study(study.directory).interrupted)
        raise MemoryError

    with monkeypatch.context() as patched:
        patched.setattr(Study, "inquiries", killed)
        with pytest.raises(MemoryError):
            Study(plans, tmp_path / "out").run()
    assert seen == [True]
    assert (tmp_path / "out" / STUDY).exists()
    Study(plans, tmp_path / "out", resume=True).run()
    assert not load_study(tmp_path / "out").interrupted


HOLDER = """
import signal, sys
from pathlib import Path
from comparisons.results.folder import held
with held(Path(sys.argv[1])), held(Path(sys.argv[1])):
    print("held", flush=True)
    signal.pause()
"""


@pytest.mark.skipif(sys.platform == "win32", reason="signals")
def test_one_process_writes_a_folder_and_a_killed_one_lets_go(scene, tmp_path, monkeypatch):
    """The other one is told who has it, nothing is touched, and what a kill leaves is no result."""
    monkeypatch.setenv("PYTHONPATH", str(EXAMPLES.parents[1]))
    plans = plan_scene(scene(compare={"methods": ["closed_form"]}))
    out = tmp_path / "out"
    command = [sys.executable, "-c", HOLDER, out]
    with subprocess.Popen(command, stdout=subprocess.PIPE, text=True) as holder:
        assert holder.stdout.readline() == "held\n"
        for options in ({}, {"overwrite": True}, {"resume": True}):
            with pytest.raises(ResultsError, match=f"in use by process {holder.pid} since 2"):
                Study(plans, out, **options).run()
        holder.kill()
    assert [path.name for path in out.iterdir()] == [LOCK]
    Study(plans, out).run()
    assert not (out / LOCK).exists()
