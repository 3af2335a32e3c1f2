"""The check: a run compared with a stored one; who moved, the model, a reference, or all alike."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, replace
from pathlib import Path
from tempfile import TemporaryDirectory

from comparisons.errors import InputError, ResultsError
from comparisons.facts.methods import GRID, INDEPENDENT, method_named, title_of
from comparisons.facts.methods import MODEL as MODEL_NAME
from comparisons.formatting import listed, number
from comparisons.questions.campaign import Watch
from comparisons.questions.study import Study
from comparisons.results.record import MEAN, StudyRecord
from comparisons.results.rows import NO_ROWS
from comparisons.results.run_comparison import (
    CHANGED,
    LOST,
    MOVED,
    ONE_SIDED,
    SLOW,
    Change,
    compare_runs,
    problem_of,
)
from comparisons.results.store import load_study, save_study
from comparisons.scene.scene import SINGLE, load_scene
from comparisons.solving.planning import plan_scene

# Made by `roughline check --update --baseline FOLDER`; a regression baseline, from our own output.
PACKAGED = Path(__file__).with_name("check_baseline")
CHECK_SCENES = (*SINGLE, "rough-periodic")
REALISATIONS = 3

MODEL, REFERENCES, AGREEMENT, SPEED = "reduced model", "references", "agreement", "speed"
# The model does not iterate: processors and library versions change its last digits only.
MODEL_TOLERANCE = 1e-9
# Two curves changed equally if their factors agree to this fraction of the change.
ALIKE = 0.1


@dataclass(frozen=True)
class Finding:
    """A line of a check."""

    scene: str
    subject: str  # one of those above
    text: str  # the finding in words
    drifted: bool = False  # whether the check fails
    notable: bool = False  # whether the finding is shown although the check does not fail


def run_for_check(
    method: str = MODEL_NAME, scenes: Iterable[str] = CHECK_SCENES, watch: Watch | None = None
) -> StudyRecord:
    """Solve scenes here with the judged method and references that share no code with it."""
    method = method_named(method)
    plans = []
    for source in scenes:
        changes: dict[str, object] = {"compare.methods": [*INDEPENDENT, method]}
        scene = load_scene(source, changes)
        if scene.surface is not None:
            # Finite elements would take most of the time, and solve a patch, which is another
            # problem.
            changes["compare.methods"] = [GRID, method]
            changes["surface.realisations"] = REALISATIONS
            scene = load_scene(source, changes)
        plans.append(plan_scene(scene)[0])
    with TemporaryDirectory(prefix="roughline-") as folder:
        record = Study(plans, Path(folder), command="roughline check", watch=watch).run()
    kept = []  # what is compared: curves, of ensembles their means, a tenth of all that there is
    for done in record.scenes:
        names = done.rows["realisation"]
        means = done.rows.where(names == MEAN) if MEAN in names else done.rows
        kept.append(replace(done, rows=means, distributions=NO_ROWS, fields={}, verdicts=()))
    return record.model_copy(update={"scenes": tuple(kept)})


def drift(
    stored: StudyRecord,
    now: StudyRecord,
    method: str = MODEL_NAME,
    tolerance: float = MODEL_TOLERANCE,
) -> list[Finding]:
    """Compare a run with the stored one: every scene's model, references, agreement, and speed.

    Changes of the method up to `tolerance` count as none, of references those up to `MOVED`.
    """
    changes = compare_runs(stored, now, tolerances={method: tolerance}).changes
    before = {scene.name: scene for scene in stored.scenes}
    findings = []
    for scene in now.scenes:
        was, changed = before.get(scene.name), ""
        if was is None or method not in was.methods:
            changed = "not in the baseline: --update adds it"
        elif problem_of(was) != problem_of(scene):
            changed = "the scene itself is not the baseline's: --update takes the new one"
        if was is None or changed:
            findings.append(Finding(scene.name, MODEL, changed, True))
            continue
        own = [change for change in changes if change.scene == scene.name]
        findings += _moves(scene.name, method, own)
        # references that differ beyond their bars are a drift where none did before
        told = " ".join(scene.disagreements)
        new = not {*map(_pair, was.disagreements)}.issuperset(map(_pair, scene.disagreements))
        text = told if new or not told else f"as in the baseline: {told}"
        text = text or "the references agree within their bars"
        findings.append(Finding(scene.name, AGREEMENT, text, drifted=new, notable=bool(told)))
        timed = [change for change in own if change.method == method and change.only_timed]
        findings += [
            Finding(scene.name, SPEED, f"{title_of(method)}: {change.text}", notable=True)
            for change in timed[-1:]
            if SLOW in change.kinds
        ]
    return findings


def _moves(name: str, method: str, changes: list[Change]) -> list[Finding]:
    """Return what became of the model and the references; the same in both is nobody's fault."""
    moved: dict[str, Change] = {}  # by the finest grid that moved
    for change in changes:
        if {CHANGED, LOST, ONE_SIDED} & change.kinds.keys():
            moved[change.method] = change
    truths = dict.fromkeys(change.method for change in changes if change.method != method)
    still = listed([title_of(truth) for truth in truths if truth not in moved])
    subject = "the reduced model" if method == MODEL_NAME else title_of(method)
    model = moved.pop(method, None)
    shared = []  # references whose common quantities all changed by the model's factor
    for truth, move in moved.items():
        if model is None:
            break
        common = [name for name in model.moves if name in move.moves]
        size = max((abs(model.moves[name]) for name in common), default=0.0)
        apart_by = max((abs(model.moves[name] - move.moves[name]) for name in common), default=0.0)
        whole = not {LOST, ONE_SIDED} & {*model.kinds, *move.kinds}
        if whole and size > MOVED and apart_by <= ALIKE * size:
            shared.append(truth)
    if model is not None and shared:
        both = listed([subject, *map(title_of, shared)])
        factor = f"{number(1 + model.change, 6)} ({model.quantity.replace('_', ' ')})"
        text = f"{both} moved by the same factor {factor}: something they share has changed"
        text += f"; {still} did not move" if still else ""
        apart = [
            f"{title_of(truth)}: {m.what}" for truth, m in moved.items() if truth not in shared
        ]
        text += f"; otherwise moved {'; '.join(apart)}" if apart else ""
        return [Finding(name, MODEL, text, True)]
    own, others = "unchanged", "unchanged"
    if model is not None:
        own = f"{subject} moved: {model.what}"
    if moved:
        texts = [f"{title_of(truth)}: {move.what}" for truth, move in moved.items()]
        others = f"the reference moved: {'; '.join(texts)}" + (
            f"; {still} did not" if still else ""
        )
    return [
        Finding(name, MODEL, own, model is not None),
        Finding(name, REFERENCES, others, bool(moved)),
    ]


def _pair(disagreement: str) -> str:
    """Return who differs in what: the words before "by" how much."""
    return disagreement.rpartition(" by ")[0] or disagreement


def check_against(
    baseline: Path,
    method: str = MODEL_NAME,
    scenes: Iterable[str] = CHECK_SCENES,
    *,
    tolerance: float = MODEL_TOLERANCE,
    watch: Watch | None = None,
    update: bool = False,
) -> list[Finding]:
    """Solve scenes and compare them with a stored run; `update` stores the current one.

    Other scenes of the baseline are kept then, and a missing one is created. InputError if the
    baseline is missing or damaged, or the method or a scene is invalid.
    """
    stored = None
    if baseline.exists() or not update:
        try:
            stored = load_study(baseline)
        except ResultsError as error:
            raise InputError(f"{error}; --update writes a baseline into a new folder") from error
    now = run_for_check(method, scenes, watch)
    findings = [] if stored is None else drift(stored, now, method, tolerance)
    if update:
        old = () if stored is None else stored.scenes
        new = {scene.name for scene in now.scenes}
        kept = tuple(scene for scene in old if scene.name not in new)
        baseline.mkdir(parents=True, exist_ok=True)
        every = (*kept, *now.scenes)
        save_study(now.model_copy(update={"scenes": every, "directory": baseline}))
    return findings
