"""A campaign that judges claims, one inquiry per claim; solves needed repeatedly run once.

A grid along a claim's parameter is measured, then every interval that contains a boundary is
bisected. A verdict that hangs on a choice that the statement does not make is a verdict on the
choice: along each of these nuisance parameters a claim is measured from end to end, then over a
space-filling sample of all of them shows what they do together. Quick effort asks for the verdict
only: it measures nothing that cannot change it.

The record of a full run carries a digest of all modules of ours that a claim's experiment, or the
solvers of its scene, import in turn, of the data and built-in scenes that an experiment reads, and
of the claim's own keys: it tells which stored verdicts are older than what they came from. Comments
and docstrings of code do not enter it.
"""

from __future__ import annotations

import ast
import hashlib
import json
import math
import shlex
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import asdict, replace
from functools import cache, partial
from itertools import groupby, pairwise, product
from pathlib import Path
from typing import Any, Unpack

import numpy as np
from scipy.stats import qmc

from comparisons.errors import LostWorkError, NotInstalledError, ResultsError
from comparisons.facts.methods import METHODS
from comparisons.files import plain, write_text
from comparisons.judging.verdicts import OUTSIDE, WITHIN, judged
from comparisons.machine import OWN_PACKAGES, source_digest, versions
from comparisons.methods import registry
from comparisons.methods.solver import Refusal
from comparisons.methods.user.external import user_methods
from comparisons.questions.campaign import Campaign, Options
from comparisons.questions.claims.claim import Claim, scene_of
from comparisons.questions.claims.parameters import Nuisance, Vary
from comparisons.questions.claims.record import (
    IN_A_RANGE,
    NOT_RUN,
    RECORD,
    STORED,
    ClaimRecord,
    ClaimsRecord,
    MapRecord,
    NuisanceRecord,
    PointRecord,
    RangeRecord,
    RowRecord,
    load_claims_record,
    not_run,
    verdict_of,
    verdict_over_all,
)
from comparisons.questions.claims.scenes import DISAGREE, measure_scene
from comparisons.questions.claims.wording import WRONG_SIGN, finding
from comparisons.questions.claims.wording import value as in_words
from comparisons.questions.experiments import EXPERIMENTS, Measurement
from comparisons.questions.experiments.experiment import Effort
from comparisons.reasons import one_line
from comparisons.results.folder import Header, Layout
from comparisons.scene.scene import builtin_folder
from comparisons.solving.inquiries import A, Inquiry, answer_of, together, value_of
from comparisons.solving.jobs import Archive, Done, Job, JobKind

MEASUREMENTS = "measurements"
COPIED = {
    *("id", "text", "equation", "reading", "corrects", "author", "confirmed_by", "method"),
    *("measure", "factor", "tolerance", "tolerance_from", "refuted_by", "theorem", "expected"),
}
# Assumed memory of an experiment in bytes: grids of 1024 x 1024 and meshes of 1e5 unknowns.
MEMORY = 1e9


class ClaimRun(Campaign[ClaimRecord, ClaimsRecord]):
    """All claims of a run, and the folder of its results."""

    layout = Layout(RECORD, kept=MEASUREMENTS)

    def __init__(self, claims: list[Claim], directory: Path, **options: Unpack[Options]) -> None:
        super().__init__(directory, **options)
        self.claims = claims

    def inquiries(self) -> dict[str, Inquiry[ClaimRecord]]:
        """Return one inquiry per claim; experiments first, as work while scenes are planned."""
        claims = sorted(self.claims, key=lambda claim: claim.experiment is None)
        return {claim.id: judged_claim(claim, self.effort) for claim in claims}

    def record_of(self, header: Header, answers: Mapping[str, ClaimRecord]) -> ClaimsRecord:
        """Return the judged claims in order."""
        judged = [answers[claim.id] for claim in self.claims if claim.id in answers]
        return ClaimsRecord(**header.model_dump(), claims=judged)

    def save(self, record: ClaimsRecord) -> None:
        """Write claims.json."""
        record.write(self.directory / RECORD)

    def seconds_before(self) -> float:
        """Return the seconds of the resumed run."""
        return load_claims_record(self.directory).seconds


SEED = 19  # of the space-filling sample
Measure = Callable[[float | None], Inquiry[Measurement]]
# The measurement of a claim under a setting of its nuisance parameters.
Under = Callable[[Mapping[str, float], float | None], Inquiry[Measurement]]


def along(claim: Claim, measure: Measure, effort: Effort) -> Inquiry[list[PointRecord]]:
    """Measure a claim along its own parameter; without one, once.

    Quick effort asks for the verdict only, and stops once that is known: it measures the ends, then
    every second value of a grid of more than three, then beside the smallest error.
    """
    if claim.vary is None:
        return (yield from points_at([None], claim.tolerance, measure))
    values = claim.vary.numbers()
    points: list[PointRecord] = []

    def measured(asked: Sequence[float]) -> Inquiry[None]:
        known = {point.parameter for point in points}
        new = [value for value in dict.fromkeys(asked) if value not in known]
        points.extend((yield from points_at(new, claim.tolerance, measure)))
        points.sort(key=lambda point: _number(point.parameter))

    if effort == "full":
        yield from measured(values)
    else:
        yield from measured([values[0], values[-1]])
        if not is_final(points, effort):
            few = len(values) <= 3
            yield from measured(values if few else values[1 + len(values) % 2 :: 2])
        if all(point.word != WITHIN for point in points):
            place = values.index(_number(representative(points).parameter))
            yield from measured(values[max(place - 1, 0) : place + 2])
    return (yield from bisected(claim.vary, points, claim.tolerance, measure, effort))


def is_final(points: Sequence[PointRecord], effort: Effort) -> bool:
    """Return whether a quick verdict is final: some points are within, some outside."""
    return effort == "quick" and verdict_of([point.word for point in points]) == IN_A_RANGE


def bisected(
    span: Vary | Nuisance,
    points: list[PointRecord],
    tolerance: float,
    measure: Measure,
    effort: Effort,
) -> Inquiry[list[PointRecord]]:
    """Bisect all intervals between points that contain a boundary.

    These are intervals between a point within and one outside, and intervals between two points
    outside with errors of opposite signs, because the error passes zero there and the claim holds
    nearby. If a midpoint is not resolved, the bisection ends. Points come back in order.
    """
    intervals = list(pairwise(points))
    for _ in range(span.halvings(effort)):
        if is_final(points, effort):
            break
        split = []
        for low, high in intervals:
            words = {low.word, high.word}
            opposite = words == {OUTSIDE} and _number(low.error) * _number(high.error) < 0
            ends = _number(low.parameter), _number(high.parameter)
            middle = span.between(*ends)
            consecutive = span.is_integer and not ends[0] < middle < ends[1]
            if (words == {WITHIN, OUTSIDE} or opposite) and not consecutive:
                split.append((low, middle, high))
        if not split:
            break
        middles = yield from points_at([middle for _, middle, _ in split], tolerance, measure)
        halves = zip(split, middles, strict=True)
        intervals = [
            half for (low, _, high), point in halves for half in ((low, point), (point, high))
        ]
        points = points + middles
    return sorted(points, key=lambda point: _number(point.parameter))


def points_at(
    values: Sequence[float | None],
    tolerance: float,
    measure: Measure,
    setting: dict[str, str] | None = None,
) -> Inquiry[list[PointRecord]]:
    """Measure and judge a claim at several values of a parameter, under a setting in words."""
    measured = yield from together(measure(value) for value in values)
    return [
        PointRecord(
            word=judged(m.error, m.uncertainty, tolerance).word,
            setting=setting or {},
            **plain(asdict(m)),
        )
        for m in measured
    ]


def _number(value: float | None) -> float:
    return np.nan if value is None else value


def ranges_of(points: list[PointRecord]) -> list[RangeRecord]:
    """Return the intervals in which a claim holds (none without a parameter)."""
    stretches, start = [], 0
    for word, group in groupby(points, key=lambda point: point.word):
        members = list(group)
        stop = start + len(members)
        low, high = members[0].parameter, members[-1].parameter
        if word == WITHIN and low is not None and high is not None:
            below = points[start - 1].parameter if start else None
            above = points[stop].parameter if stop < len(points) else None
            stretches.append(RangeRecord(low=low, high=high, below=below, above=above))
        start = stop
    return stretches


def along_nuisance(
    claim: Claim, nuisance: Nuisance, at: float | None, under: Under, effort: Effort
) -> Inquiry[NuisanceRecord]:
    """Measure a claim along a nuisance parameter, at a value of its own, the others as stated."""

    def measure(number: float | None) -> Inquiry[Measurement]:
        assert number is not None
        measured = yield from under({**claim.as_stated, nuisance.key: number}, at)
        return replace(measured, parameter=number)

    points = yield from points_at(nuisance.numbers(), claim.tolerance, measure)
    if not nuisance.values:
        points = yield from bisected(nuisance, points, claim.tolerance, measure, effort)
    return NuisanceRecord(
        name=nuisance.name,
        reason=nuisance.reason,
        stated=nuisance.stated_number,
        spacing=nuisance.spacing,
        choices=nuisance.choices,
        at=at,
        points=points,
        ranges=[] if nuisance.values else ranges_of(points),
    )


def representative(points: Sequence[PointRecord]) -> PointRecord:
    """Return the middle one of the points within, else that of the smallest error."""
    within = [point for point in points if point.word == WITHIN]
    if within:
        return within[len(within) // 2]
    return min(points, key=lambda p: np.inf if p.error is None else abs(p.error))


def drawn(claim: Claim, share: np.ndarray, under: Under) -> Inquiry[PointRecord]:
    """Measure a claim at one place of the sample."""
    setting = {n.key: n.draw(float(s)) for n, s in zip(claim.nuisance, share, strict=False)}
    words = {
        n.name: n.choices[int(setting[n.key])] if n.values else in_words(setting[n.key])
        for n in claim.nuisance
    }
    value = None
    if claim.vary is not None:
        value = claim.vary.between(claim.vary.start, claim.vary.end, float(share[-1]))
    (point,) = yield from points_at([value], claim.tolerance, partial(under, setting), words)
    return point


def shares(claim: Claim, effort: Effort, seed: int = SEED) -> np.ndarray:
    """Return the sample, one row per draw: scrambled Sobol points (Owen 1998) in the unit cube.

    The last column is the claim's own parameter. Quick effort takes the first eighth, at least two.
    """
    sample = qmc.Sobol(len(claim.nuisance) + 1, scramble=True, seed=seed)
    points: np.ndarray = sample.random_base2(int(np.ceil(np.log2(max(claim.draws, 1)))))
    few = min(claim.draws, max(2, claim.draws // 8))
    return points[: claim.draws if effort == "full" else few]


def mapped(claim: Claim, under: Under, effort: Effort) -> Inquiry[MapRecord | None]:
    """Measure a claim along its own parameter in rows of a nuisance parameter, if it has a map."""
    if claim.map is None:
        return None
    nuisance = next(n for n in claim.nuisance if n.key == claim.map.up)
    numbers = nuisance.numbers()
    if not nuisance.values:
        count = claim.map.rows if effort == "full" else 2
        numbers = [nuisance.draw(share) for share in np.linspace(0, 1, count)]
    settings = [{**claim.as_stated, nuisance.key: number} for number in numbers]
    lines = yield from together(
        along(claim, partial(under, setting), effort) for setting in settings
    )
    rows = [
        RowRecord(number=number, points=points, ranges=ranges_of(points))
        for number, points in zip(numbers, lines, strict=True)
    ]
    return MapRecord(
        up=nuisance.name, spacing=nuisance.spacing, choices=nuisance.choices, rows=rows
    )


def measured_under(claim: Claim, effort: Effort, spent: dict[str, float]) -> Under:
    """Return the measurement of a claim, for a setting of its nuisance parameters.

    The seconds of each job are put into `spent`, by its key.
    """

    def under(setting: Mapping[str, float], value: float | None) -> Inquiry[Measurement]:
        measured, own = yield from priced(_measured(claim.under(setting), value, effort))
        spent.update(own)
        measured = replace(measured, seconds=math.fsum(own.values()))
        return measured if claim.factor is None else as_factor(measured)

    return under


def judge_claim(claim: Claim, effort: Effort) -> ClaimRecord:
    """Measure a claim in this process; return the verdict and measurements."""
    return answer_of(judged_claim(claim, effort))


def priced(inquiry: Inquiry[A]) -> Inquiry[tuple[A, dict[str, float]]]:
    """Return the answer of an inquiry, and the seconds of its jobs by their keys."""
    seconds: dict[str, float] = {}
    done: Mapping[str, Done] | None = None
    while True:
        try:
            jobs = next(inquiry) if done is None else inquiry.send(done)
        except StopIteration as end:
            return end.value, seconds
        done = yield jobs
        for job in jobs:  # what a method times itself is NaN where it has no answer
            seconds[job.key] = float(np.nan_to_num(getattr(done[job.key].value, "seconds", 0.0)))


def judged_claim(claim: Claim, effort: Effort) -> Inquiry[ClaimRecord]:
    """Request a claim's solves; return the verdict, measurements and what all of it took."""
    spent: dict[str, float] = {}
    under = measured_under(claim, effort, spent)
    points = yield from along(claim, partial(under, claim.as_stated), effort)
    nuisances: Sequence[NuisanceRecord] = ()
    draws: Sequence[PointRecord] = ()
    validity = None
    able = not_run(points) == ""
    unstated: list[PointRecord] = []
    if claim.nuisance and able and not is_final(points, effort):
        at = representative(points).parameter
        nuisances = yield from together(
            along_nuisance(claim, nuisance, at, under, effort) for nuisance in claim.nuisance
        )
        unstated += [p for line in nuisances for p in line.points if p.parameter != line.stated]
        if not is_final([*points, *unstated], effort):
            draws = yield from together(
                drawn(claim, share, under) for share in shares(claim, effort)
            )
    if able and not is_final([*points, *unstated, *draws], effort):
        validity = yield from mapped(claim, under, effort)
    rows = [] if validity is None else validity.rows
    stated = {nuisance.name: nuisance.stated_number for nuisance in claim.nuisance}
    unstated += [
        p for row in rows if validity and row.number != stated[validity.up] for p in row.points
    ]
    beside = [*(line.points for line in nuisances), *(row.points for row in rows)]
    measured = [*points, *(point for line in beside for point in line), *draws]
    record = ClaimRecord(
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
        sentence="",
        points=points,
        ranges=ranges_of(points),
        nuisances=list(nuisances),
        draws=list(draws),
        map=validity,
        disagreements=[
            (claim.parameter and f"at {claim.parameter} {in_words(point.parameter)}: ") + str(text)
            for point in measured
            if (text := point.details.get(DISAGREE))
        ],
        command=_repeats(claim, effort),
        seconds=math.fsum(spent.values()),
        effort=effort,
        digest=digest_of(claim) if effort == "full" else "",
    )
    return record.model_copy(update={"sentence": finding(claim, record)})


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
            JobKind(claim.id, claim.experiment),
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
    cause = error.__cause__ or error
    key, reason = NOT_RUN, str(cause)
    if not isinstance(cause, NotInstalledError):
        words = f"{type(error).__name__}: {error}" if str(error) else type(error).__name__
        key, reason = "no result", one_line(words)
    return Measurement(value, float("nan"), float("nan"), {key: reason})


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
        read = sorted({path for module in imported(starts) for path in _code(module)[2]})
        keys += "".join(path.read_text(encoding="utf-8") for path in read)
    else:
        first = None if claim.vary is None else claim.vary.start
        sides = claim.under(claim.as_stated).sides(first)
        scenes = [scene_of(claim, side) for side in sides if side.solved]
        keys += "".join(dict.fromkeys(scene.text for scene in scenes))
        judged = {side.method for side in sides}
        concerned = [n for n in METHODS if n in judged or METHODS[n].dimension == 3]
        starts = ["comparisons.questions.claims.scenes"]
        for scene, name in product(scenes, concerned):
            solver = registry.solver_for(name, scene)
            if not isinstance(solver, Refusal):
                starts.append(type(solver).__module__)
            elif solver.missing and name in judged:  # the digest is that of where it is installed
                starts += [maker.__module__ for maker in registry.SOLVERS[name]]
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
def _code(module: str) -> tuple[str, tuple[str, ...], tuple[Path, ...]]:
    """Return the digest of a module without docstrings, and what it may import and read."""
    file = _file(module)
    assert file is not None
    tree = ast.parse(file.read_bytes())
    names: list[str] = []
    data: list[Path] = []
    for node in ast.walk(tree):
        match node:
            case ast.Import():
                names += [alias.name for alias in node.names]
            case ast.ImportFrom():
                origin = node.module or ""
                names += [origin, *(f"{origin}.{alias.name}" for alias in node.names)]
            case ast.Constant(value=str(name)) if name.endswith(".toml"):
                data.append(file.parent / name)
            case ast.Call(func=ast.Name("load_scene"), args=[ast.Constant(value=str(name)), *_]):
                data.append(builtin_folder() / f"{name}.toml")
            case ast.Module() | ast.ClassDef() | ast.FunctionDef() if ast.get_docstring(
                node, clean=False
            ):
                del node.body[0]
    code = hashlib.sha256(ast.dump(tree).encode()).hexdigest()
    return code, tuple(names), tuple(path for path in data if path.is_file())
