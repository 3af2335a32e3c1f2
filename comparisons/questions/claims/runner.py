"""A campaign that judges claims, one inquiry per claim; solves needed repeatedly run once.

The record of a full run carries a digest of all modules of ours that a claim's experiment, or the
solvers of its scene, import in turn, and of the claim's own keys: it tells which stored verdicts
are older than the code that they came from. Comments and docstrings do not enter it.
"""

from __future__ import annotations

import ast
import hashlib
import json
import shlex
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from functools import cache
from pathlib import Path
from typing import Any, Unpack

import numpy as np

from comparisons.errors import LostWorkError, NotInstalledError, ResultsError
from comparisons.facts.methods import METHODS
from comparisons.files import plain, write_text
from comparisons.machine import OWN_PACKAGES, source_digest, versions
from comparisons.methods import registry
from comparisons.methods.solver import Refusal
from comparisons.methods.user.external import user_methods
from comparisons.questions.campaign import Campaign, Options
from comparisons.questions.claims.claim import Claim, scene_of
from comparisons.questions.claims.record import (
    NOT_RUN,
    RECORD,
    STORED,
    ClaimRecord,
    ClaimsRecord,
    NuisanceRecord,
    PointRecord,
    load_claims_record,
    not_run,
    verdict_over_all,
)
from comparisons.questions.claims.scenes import measure_scene
from comparisons.questions.claims.search import (
    SEED,
    Measure,
    Setting,
    along,
    along_nuisance,
    drawn,
    mapped,
    ranges_of,
    representative,
    shares,
)
from comparisons.questions.claims.wording import WRONG_SIGN, finding, value
from comparisons.questions.experiments import EXPERIMENTS, Measurement
from comparisons.questions.experiments.experiment import Effort
from comparisons.reasons import one_line
from comparisons.results.folder import Header, Layout
from comparisons.solving.inquiries import Inquiry, answer_of, together, value_of
from comparisons.solving.jobs import Archive, Job, Kind

MEASUREMENTS = "measurements"
COPIED = {
    *("id", "text", "equation", "reading", "corrects", "author", "confirmed_by", "method"),
    *("measure", "factor", "tolerance", "tolerance_from", "refuted_by", "theorem", "expected"),
}
# Assumed memory of an experiment in bytes: grids of 1024 x 1024 and meshes of 1e5 unknowns.
MEMORY = 1e9


class ClaimRun(Campaign[ClaimRecord, ClaimsRecord]):
    """All claims of a run, and the folder of its results."""

    layout = Layout(RECORD, answers=MEASUREMENTS)

    def __init__(self, claims: list[Claim], directory: Path, **options: Unpack[Options]) -> None:
        super().__init__(directory, **options)
        self.claims = claims

    def inquiries(self) -> dict[str, Inquiry[ClaimRecord]]:
        """Return one inquiry per claim; experiments first, as work while scenes are planned."""
        claims = sorted(self.claims, key=lambda claim: claim.experiment is None)
        return {claim.id: judged_claim(claim, self.effort) for claim in claims}

    def answer(self, header: Header, answers: Mapping[str, ClaimRecord]) -> ClaimsRecord:
        """Return the judged claims in order."""
        judged = [answers[claim.id] for claim in self.claims if claim.id in answers]
        return ClaimsRecord(**header.model_dump(), claims=judged)

    def save(self, record: ClaimsRecord) -> None:
        """Write claims.json."""
        record.write(self.directory / RECORD)

    def seconds_before(self) -> float | None:
        """Return the seconds of the resumed run."""
        if not (self.directory / RECORD).exists():
            return None
        return load_claims_record(self.directory).seconds


def judge_claim(claim: Claim, effort: Effort, seed: int = SEED) -> ClaimRecord:
    """Measure a claim in this process; return the verdict and measurements."""
    return answer_of(judged_claim(claim, effort, seed))


def judged_claim(claim: Claim, effort: Effort, seed: int = SEED) -> Inquiry[ClaimRecord]:
    """Request a claim's solves, with a seed for its draws; return the verdict and measurements."""

    def under(setting: Setting) -> Measure:
        there = claim.under(setting)

        def measure(value: float | None) -> Inquiry[Measurement]:
            measured = yield from _measured(there, value, effort)
            return measured if claim.factor is None else as_factor(measured)

        return measure

    points = yield from along(claim, under(claim.as_stated), effort)
    nuisances: Sequence[NuisanceRecord] = ()
    draws: Sequence[PointRecord] = ()
    able = not_run(points) == ""
    if claim.nuisance and able:
        at = representative(points).parameter
        nuisances = yield from together(
            along_nuisance(claim, nuisance, at, under, effort) for nuisance in claim.nuisance
        )
        draws = yield from together(
            drawn(claim, share, under) for share in shares(claim, effort, seed)
        )
    validity = (yield from mapped(claim, under, effort)) if able else None
    rows = [] if validity is None else validity.rows
    stated = {nuisance.name: nuisance.stated_number for nuisance in claim.nuisance}
    unstated = [p for line in nuisances for p in line.points if p.parameter != line.stated]
    unstated += [
        p for row in rows if validity and row.number != stated[validity.up] for p in row.points
    ]
    beside = [*(line.points for line in nuisances), *(row.points for row in rows)]
    measured = [*points, *(point for line in beside for point in line), *draws]
    return ClaimRecord(
        **claim.model_dump(include=COPIED),
        author=claim.author,
        what=claim.what,
        quantity=list(claim.quantity),
        parameter=claim.parameter,
        spacing="linear" if claim.vary is None else claim.vary.spacing,
        verdict=verdict_over_all(
            [point.word for point in points],
            [point.word for point in unstated],
            [point.word for point in draws],
            effort,
        ),
        sentence=finding(
            claim, effort, points, ranges_of(points), list(nuisances), list(draws), validity
        ),
        points=points,
        ranges=ranges_of(points),
        nuisances=list(nuisances),
        draws=list(draws),
        map=validity,
        disagreements=[
            (claim.parameter and f"at {claim.parameter} {value(point.parameter)}: ") + str(text)
            for point in measured
            if (text := point.details.get("references disagree"))
        ],
        command=_repeats(claim, effort),
        seconds=sum(point.seconds for point in measured),
        effort=effort,
        digest=digest_of(claim) if effort == "full" else "",
    )


def as_factor(measured: Measurement) -> Measurement:
    """Return stated/true - 1 as a factor less one, negative where stated is the smaller.

    One tenth of the truth is as far from it as ten times the truth: -9 and 9. A statement of the
    wrong sign is infinitely far.

    >>> as_factor(Measurement(None, -0.9, 0.0)).error, as_factor(Measurement(None, 9.0, 0.0)).error
    (-9.0, 9.0)
    """
    ratio = 1 + measured.error
    factors = []
    for part in (ratio - measured.uncertainty, ratio, ratio + measured.uncertainty):
        if part <= 0:
            factors.append(WRONG_SIGN)  # no factor, but finite as every result of an experiment
        else:
            factors.append(round(part - 1 if part >= 1 else 1 - 1 / part, 12))
    low, middle, high = factors
    bar = max(abs(high - middle), abs(middle - low))
    return replace(measured, error=middle, uncertainty=bar)


def _repeats(claim: Claim, effort: Effort) -> str:
    """Return the command that repeats the claim."""
    command = f"roughline claims {claim.id} --{effort}"
    sources = {method.name: method.origin.source for method in user_methods()}
    if claim.method not in sources:
        return command
    kind, _, where = sources[claim.method].partition(":")
    file = f" --method-file {shlex.quote(where)}" if kind == "file" else ""
    return f"{command} --method {claim.method}{file}"


def _measured(claim: Claim, value: float | None, effort: Effort) -> Inquiry[Measurement]:
    """Measure a point; an exception affects this point only."""
    if claim.experiment is not None:
        arguments = EXPERIMENTS[claim.experiment].arguments(value, claim.parameters)
        # Neither the claim nor its tolerance is in it: claims that ask for the same share a job.
        identity = {
            "experiment": claim.experiment,
            "arguments": {k: a.hex() if isinstance(a, float) else a for k, a in arguments.items()},
            "effort": effort,
            "versions": versions(),
            "source": source_digest(),
        }
        digest = hashlib.sha256(json.dumps(identity, sort_keys=True).encode()).hexdigest()[:16]
        job = Job(
            f"{claim.experiment}-{digest}",
            measure_experiment,
            (claim.experiment, value, effort, claim.parameters),
            MEMORY,
            Kind(claim.id, claim.experiment),
            MEASUREMENT,
        )
        done = yield [job]
        measurement: Measurement = value_of(done[job.key])
        # another claim may have asked for it, along another of its parameters
        return replace(measurement, parameter=None if value is None else float(value))
    checked: tuple[float | None, ...] = (None,)
    if claim.vary is not None:
        # References check each other at the beginning of the range; at full effort also at its end.
        checked = (claim.vary.start, claim.vary.end if effort == "full" else None)
    try:
        return (yield from measure_scene(claim, value, effort, independent=value in checked))
    except LostWorkError:
        raise
    except Exception as error:  # a failed measurement must not end a run of an hour
        return _no_result(value, error)


def _no_result(value: float | None, error: Exception) -> Measurement:
    if isinstance(error.__cause__ or error, NotInstalledError):
        return Measurement(
            value, float("nan"), float("nan"), {NOT_RUN: str(error.__cause__ or error)}
        )
    reason = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
    return Measurement(value, float("nan"), float("nan"), {"no result": one_line(reason)})


def measure_experiment(
    name: str, value: float | None, effort: Effort, parameters: dict[str, Any]
) -> Measurement:
    """Run an experiment at a value of its parameter."""
    try:
        return EXPERIMENTS[name].measure(value, effort, **parameters)
    except Exception as error:  # as in `_measured`
        return _no_result(value, error)


def _load(path: Path) -> Measurement:
    try:
        data = json.loads(path.read_text(encoding="utf-8"))
        missing = {key: float("nan") for key in ("error", "uncertainty") if data[key] is None}
        return Measurement(**data | missing)
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise ResultsError(f"{path}: not a measurement ({error})") from error


MEASUREMENT = Archive(
    ".json",
    save=lambda path, measured: write_text(path, json.dumps(plain(asdict(measured)))),
    load=_load,
    is_final=lambda measured: bool(np.isfinite([measured.error, measured.uncertainty]).all()),
)


_HOME = Path(__file__).resolve().parents[3]
# What moves no number: words, who says it, and the verdict that is expected.
_WORDS = {"id", "text", "equation", "reading", "corrects", "says", "citation", "confirmed_by"}
_WORDS |= {"tolerance_from", "refuted_by", "theorem", "expected"}


def stale(claims: Iterable[Claim]) -> list[str]:
    """Return the ids of claims whose stored verdict is older than its code, or that have none."""
    stored = {record.id: record.digest for record in load_claims_record(STORED).claims}
    return [claim.id for claim in claims if stored.get(claim.id) != digest_of(claim)]


def digest_of(claim: Claim) -> str:
    """Return the digest of a claim's keys and of the code that measures it."""
    keys = claim.model_dump_json(exclude=_WORDS)
    if claim.experiment is not None:
        registry.load()
        starts = [EXPERIMENTS[claim.experiment].run.__module__]
        if registry.__name__ in imported(starts):  # it solves scenes, by whatever method is found
            starts += [maker.__module__ for makers in registry.SOLVERS.values() for maker in makers]
    else:
        first = None if claim.vary is None else claim.vary.start
        sides = claim.under(claim.as_stated).sides(first)
        scenes = [scene_of(claim, side) for side in sides if side.solved]
        keys += "".join(dict.fromkeys(scene.text for scene in scenes))
        judged = {side.method for side in sides}
        concerned = [n for n in METHODS if n in judged or METHODS[n].dimension == 3]
        solvers = (registry.solver_for(name, scene) for scene in scenes for name in concerned)
        starts = [type(s).__module__ for s in solvers if not isinstance(s, Refusal)]
        starts.append("comparisons.questions.claims.scenes")
    digest = hashlib.sha256(keys.encode())
    for module in sorted(imported(starts)):
        digest.update(f"{module} {_code(module)[0]}\n".encode())
    return digest.hexdigest()[:16]


def imported(starts: Iterable[str]) -> set[str]:
    """Return the modules of ours that some modules import in turn, those themselves among them."""
    found: set[str] = set()
    ahead = list(starts)
    while ahead:
        module = ahead.pop()
        if module not in found and _file(module) is not None:
            found.add(module)
            ahead += _code(module)[1]
    return found


def _file(module: str) -> Path | None:
    place = _HOME.joinpath(*module.split("."))
    files = (place.with_suffix(".py"), place / "__init__.py")
    ours = module.split(".")[0] in OWN_PACKAGES
    return next((file for file in files if ours and file.is_file()), None)


@cache
def _code(module: str) -> tuple[str, tuple[str, ...]]:
    """Return the digest of a module without its docstrings, and the modules that it may import."""
    file = _file(module)
    assert file is not None
    tree = ast.parse(file.read_bytes())
    names: list[str] = []
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            names += [alias.name for alias in node.names]
        elif isinstance(node, ast.ImportFrom):
            origin = node.module or ""
            names += [origin, *(f"{origin}.{alias.name}" for alias in node.names)]
        elif isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef) and ast.get_docstring(
            node, clean=False
        ):
            del node.body[0]
    return hashlib.sha256(ast.dump(tree).encode()).hexdigest(), tuple(names)
