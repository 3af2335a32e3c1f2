"""Claims judged: on several cores, and after an interruption from where it stopped."""

from __future__ import annotations

import datetime
import hashlib
import json
import re
import shlex
import time
from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass
from pathlib import Path

import numpy as np

from comparisons.errors import InputError, LostWorkError, ResultsError
from comparisons.files import plain, write_text
from comparisons.machine import machine, versions
from comparisons.methods.user.external import outside_methods
from comparisons.questions.claims.claim import Claim, overrides
from comparisons.questions.claims.record import (
    RECORD,
    ClaimRecord,
    ClaimsRecord,
    PointRecord,
    RangeRecord,
    save_claims,
)
from comparisons.questions.claims.scenes import measure_scene
from comparisons.questions.claims.search import Point, ranges_of, search, verdict_of
from comparisons.questions.claims.wording import sentence, value
from comparisons.questions.experiments import EXPERIMENTS, Measurement
from comparisons.questions.experiments.base import Effort
from comparisons.reasons import one_line
from comparisons.results.folder import clear_leftovers
from comparisons.scene.scene import load_scene
from comparisons.solving.execution import THREADS
from comparisons.solving.executors import Done, Executor, Job, executor_for

MEASUREMENTS = "measurements"
OWN_FILE = re.compile(r"[a-z0-9-]+-[0-9a-f]{16}\.json|[a-z0-9_-]+-[0-9a-f]{12}\.npz")
COPIED = {"id", "text", "equation", "reading", "corrects", "method", "measure"}
COPIED |= {"tolerance", "tolerance_from", "refuted_by", "expected"}
Progress = Callable[[int, int, str], None]
# Bytes that judging a claim is taken to need: grids of 1024 x 1024 and meshes of 1e5 unknowns.
MEMORY = 1e9


@dataclass
class ClaimRun:
    """All claims of a run, and where the results go.

    Parameters
    ----------
    claims : list of Claim
    directory : Path
        Created when the run starts. A folder with results needs `resume` or `overwrite`.
    effort : {"quick", "full"}
    command : str
        The command line, for the report.
    workers : int
        Processes; each judges whole claims.
    resume, overwrite : bool
        Go on with the measurements that are there; or start anew.
    progress : callable, optional
        Called with (done, total, id of the claim just judged).
    executor : Executor, optional
        Carries out the work; default: `workers` processes here.
    """

    claims: list[Claim]
    directory: Path
    effort: Effort = "quick"
    command: str = ""
    workers: int = 1
    resume: bool = False
    overwrite: bool = False
    progress: Progress | None = None
    executor: Executor | None = None

    def run(self) -> ClaimsRecord:
        """Judge all claims and write claims.json; what is measured is kept at once.

        Raises
        ------
        ResultsError
            If the folder is used and neither `resume` nor `overwrite` was said.
        KeyboardInterrupt, LostWorkError
            After writing what was judged.
        """
        started = time.perf_counter()
        created = datetime.datetime.now(datetime.UTC).astimezone().isoformat(timespec="seconds")
        self._open()
        done: dict[str, ClaimRecord] = {}
        lost: list[str] = []
        interrupted: KeyboardInterrupt | LostWorkError | None = None
        try:
            for each in self._judged():
                if each.lost:
                    lost.append(f"{each.job.key}: {each.lost}")
                else:
                    done[each.job.key] = each.value
                if self.progress is not None:
                    self.progress(len(done), len(self.claims), each.job.key)
        except (KeyboardInterrupt, LostWorkError) as error:
            interrupted = error
        if lost and interrupted is None:
            advice = "what was measured is kept: --resume goes on, --workers 1 needs less memory"
            interrupted = LostWorkError("\n".join([*lost, advice]))
        result = ClaimsRecord(
            created=created,
            command=self.command,
            effort=self.effort,
            seconds=time.perf_counter() - started,
            machine=machine(THREADS),
            versions=versions(),
            interrupted=interrupted is not None,
            claims=[done[claim.id] for claim in self.claims if claim.id in done],
        )
        save_claims(self.directory, result)
        if interrupted is not None:
            raise interrupted
        return result

    def _judged(self) -> Iterator[Done]:
        kept = self.directory / MEASUREMENTS
        executor = self.executor or executor_for(self.workers)
        executor.add(
            Job(claim.id, judge_claim, (claim, self.effort, kept), MEMORY) for claim in self.claims
        )
        yield from executor.finished()

    def _open(self) -> None:
        if self.directory.exists() and not self.directory.is_dir():
            raise ResultsError(f"{self.directory}: expected a folder for the results, got a file")
        if self.resume and self.overwrite:
            raise ResultsError("--resume and --overwrite: expected at most one of them")
        used = self.directory.exists() and any(self.directory.iterdir())
        if used and not (self.resume or self.overwrite):
            raise ResultsError(
                f"{self.directory} is in use: say --resume to go on with it, --overwrite to start "
                "anew, or --out for another folder"
            )
        kept = self.directory / MEASUREMENTS
        if used and not kept.is_dir():
            raise ResultsError(f"{self.directory} has no claims of roughline: choose another --out")
        if used and kept.is_symlink():
            raise ResultsError(f"{kept}: expected a folder, got a link to elsewhere")
        kept.mkdir(parents=True, exist_ok=True)
        clear_leftovers(self.directory, {RECORD, "report.html"})
        clear_leftovers(kept, pattern=OWN_FILE)
        if self.overwrite:
            for old in kept.iterdir():
                if OWN_FILE.fullmatch(old.name):
                    old.unlink()


def judge_claim(claim: Claim, effort: Effort, kept: Path | None = None) -> ClaimRecord:
    """Measure a claim along its parameter and return the verdict with what it follows from.

    Parameters
    ----------
    claim : Claim
    effort : {"quick", "full"}
    kept : Path, optional
        Folder of finished measurements and solves: what is there is taken, what is new is added.
    """
    started = time.perf_counter()

    def measure(value: float | None) -> Measurement:
        path = None if kept is None else kept / f"{claim.id}-{_key(claim, value, effort)}.json"
        known = None if path is None else _restored(path)
        if known is not None:
            return known
        found = _measured(claim, value, effort, kept)
        if path is not None:
            write_text(path, json.dumps(plain(asdict(found))))
        return found

    halvings = 0 if claim.vary is None else claim.vary.halvings(effort)
    points = search(claim.vary, claim.tolerance, measure, halvings)
    verdict, ranges = verdict_of(points, effort), ranges_of(points)
    return ClaimRecord(
        **claim.model_dump(include=COPIED),
        what=_what(claim),
        quantity=list(claim.quantity),
        parameter=claim.parameter,
        spacing="linear" if claim.vary is None else claim.vary.spacing,
        verdict=verdict,
        sentence=sentence(claim, verdict, points, ranges),
        points=[_point(point) for point in points],
        ranges=[RangeRecord(**asdict(each)) for each in ranges],
        disagreements=_disagreements(points),
        command=_repeats(claim, effort),
        seconds=time.perf_counter() - started,
        effort=effort,
    )


def _repeats(claim: Claim, effort: Effort) -> str:
    """Return the command that judges the claim again."""
    command = f"roughline claims {claim.id} --{effort}"
    sources = {made.name: made.origin.source for made in outside_methods()}
    if claim.method not in sources:
        return command
    kind, _, where = sources[claim.method].partition(":")
    file = f" --method-file {shlex.quote(where)}" if kind == "file" else ""
    return f"{command} --method {claim.method}{file}"


def _measured(claim: Claim, value: float | None, effort: Effort, kept: Path | None) -> Measurement:
    """Measure; an error costs this point only."""
    try:
        if claim.experiment is not None:
            return EXPERIMENTS[claim.experiment].measure(value, effort, **claim.parameters)
        checked: tuple[float | None, ...] = (None,)
        if claim.vary is not None:
            # References check each other where the range begins; at full effort also at its end.
            checked = (claim.vary.start, claim.vary.end if effort == "full" else None)
        independent = value in checked
        return measure_scene(claim, value, effort, independent=independent, kept=kept)
    except Exception as error:  # one measurement must not end a run of an hour
        why = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        return Measurement(value, float("nan"), float("nan"), {"no result": one_line(why)})


def _key(claim: Claim, value: float | None, effort: Effort) -> str:
    """Return a name that is the same exactly when the measurement is the same."""
    names = ("experiment", "parameters", "method", "quantity", "at", "measure", "tolerance")
    identity = {
        "claim": claim.model_dump(mode="json", include=set(names)),
        "value": None if value is None else float(value).hex(),
        "effort": effort,
        "versions": versions(),
    }
    if claim.scene is not None:
        try:
            identity["scene"] = load_scene(claim.source, overrides(claim, value)).text
        except InputError as error:  # the measurement will say so
            identity["scene"] = str(error)
    text = json.dumps(identity, sort_keys=True)
    return hashlib.sha256(text.encode()).hexdigest()[:16]


def _restored(path: Path) -> Measurement | None:
    """Return a kept measurement; one without a number, or a torn file, is measured again."""
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        found = Measurement(**data)
        if found.error is None or found.uncertainty is None:
            return None
    except (OSError, ValueError, TypeError):
        return None
    return found


def _what(claim: Claim) -> str:
    """Return what was measured, in words."""
    if claim.experiment is not None:
        return EXPERIMENTS[claim.experiment].title
    names = " and ".join(name.replace("_", " ") for name in claim.quantity)
    at = f" at equal {claim.at}" if claim.at else ""
    options = [f"{key} = {value}" for key, value in claim.changes.items()]
    return f"{names}{at} on the scene {claim.scene}" + "".join(f", {each}" for each in options)


def _point(point: Point) -> PointRecord:
    measured = point.measurement
    return PointRecord(word=point.word, **plain(asdict(measured)))


def _disagreements(points: list[Point]) -> list[str]:
    found = []
    for point in points:
        text = point.measurement.details.get("references disagree")
        if text:
            where = "" if np.isnan(point.parameter) else f"at {value(point.parameter)}: "
            found.append(f"{where}{text}")
    return found
