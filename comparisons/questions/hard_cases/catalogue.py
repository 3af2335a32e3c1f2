"""Files of hard cases: reading, merging with baselines, and validation with all errors at once."""

from __future__ import annotations

import math
import tempfile
from collections import Counter
from collections.abc import Iterable, Mapping
from copy import deepcopy
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

from pydantic import Field, ValidationError

from comparisons.errors import InputError
from comparisons.files import read_toml
from comparisons.questions.hard_cases.case import JUDGED, OUTCOME_KEYS, REFUSED, HardCase
from comparisons.reasons import near
from comparisons.scene.fields import SceneTable
from comparisons.scene.problems import readable
from comparisons.scene.scene import SceneError, override

FOLDER = Path(__file__).parent
# Key of an expectation that applies to all methods.
ALL = "all"


class HardCaseError(InputError):
    """Invalid files of hard cases; ``problems`` lists all errors, one entry per key."""

    def __init__(self, problems: list[str]) -> None:
        self.problems = problems
        super().__init__("\n".join(problems))


class Family(SceneTable):
    """A file of hard cases."""

    order: float = math.inf  # position of its cases relative to other files; by default last
    like: str = ""  # the default baseline of its cases
    # Common keys of cases, by name; available to all files.
    baselines: dict[str, dict[str, Any]] = Field(default={})
    # The keys of a `HardCase` by its id, and `like`: the baseline that they override.
    cases: dict[str, dict[str, Any]] = Field(default={})


class Layer(NamedTuple):
    """The keys of a case or baseline as written in its file, and their location."""

    source: str
    keys: Mapping[str, Any]


@cache
def catalogue() -> Mapping[str, HardCase]:
    """Return the built-in hard cases by id, ordered by family."""
    return {case.id: case for case in read_cases(builtin_files())}


def builtin_files() -> list[Path]:
    """Return the files of the built-in cases."""
    return sorted(FOLDER.glob("*.toml"))


def load_cases(names: Iterable[str]) -> list[HardCase]:
    """Return cases by id, and all of user files; HardCaseError lists all problems of both."""
    builtin_cases, files, problems = catalogue(), [], []
    for name in names:
        if name not in builtin_cases and Path(name).is_file():
            files.append(Path(name))
        elif name not in builtin_cases:
            problem = f"--case: no such case or file: {name!r}; see `roughline list hard-cases`"
            problems.append(problem + near(name, builtin_cases))
    file_cases: list[HardCase] = []
    try:
        file_cases = read_cases(files, builtin_files())
    except HardCaseError as error:
        problems += error.problems
    if problems:
        raise HardCaseError(problems)
    chosen = [builtin_cases[name] for name in names if name in builtin_cases]
    return list({case.id: case for case in (*chosen, *file_cases)}.values())


def read_cases(files: Iterable[Path], context_files: Iterable[Path] = ()) -> list[HardCase]:
    """Return the cases of files, which may use baselines of others, or all their problems."""
    problems: list[str] = []
    families, context = _families(files, problems), _families(context_files, problems)
    baselines: dict[str, Layer] = {}
    names: Counter[str] = Counter()
    for file, family in (*context, *families):
        names.update(list(family.cases))
        for name, keys in family.baselines.items():
            layer = Layer(f"{file}: baselines.{name}", keys)
            if name in baselines:
                problems.append(f"{layer.source}: expected a name that is not taken")
            baselines[name] = layer
    cases: list[HardCase] = []
    for file, family in families:
        shared = {"like": family.like} if family.like else {}
        for name, keys in family.cases.items():
            case_layer = Layer(f"{file}: {name}", shared | keys)
            if names[name] > 1:
                problems.append(f"{case_layer.source}: expected an id that is not taken")
            cases += _case(name, _lineage(case_layer, baselines, problems), problems)
    if problems:
        raise HardCaseError(list(dict.fromkeys(problems)))
    return cases


def _families(files: Iterable[Path], problems: list[str]) -> list[tuple[Path, Family]]:
    """Return the families of files in order; errors are appended to the problems."""
    families = []
    for file in files:
        try:
            families.append((file, Family.model_validate(read_toml(file))))
        except ValidationError as error:
            problems += [f"{file}: {readable(problem)}" for problem in error.errors()]
        except ValueError as error:
            problems.append(f"{file}: {error}")
    return sorted(families, key=lambda pair: pair[1].order)


def _lineage(layer: Layer, baselines: Mapping[str, Layer], problems: list[str]) -> list[Layer]:
    """Return the chain of a case and its successive baselines."""
    lineage = [layer]
    while "like" in lineage[-1].keys:
        source, keys = lineage[-1]
        name = keys["like"]
        if not isinstance(name, str) or name not in baselines:
            names = ", ".join(baselines) or "none"
            problems.append(f"{source}: like: expected one of {names}, got {name!r}")
            break
        if baselines[name] in lineage:
            problems.append(f"{source}: like: expected no circle, {name} is like this one")
            break
        lineage.append(baselines[name])
    return lineage


def _case(name: str, lineage: list[Layer], problems: list[str]) -> list[HardCase]:
    """Return the merged case of these layers, or None and the problems."""
    keys: dict[str, Any] = {}
    for layer in reversed(lineage):
        keys = _put_over(keys, layer.keys)
    if "id" in keys:
        problems.append(f"{_owner(('id',), lineage).source}: id: unknown key")
    try:
        case = HardCase.model_validate(keys | {"id": name})
    except ValidationError as error:
        problems += [
            f"{_owner(problem['loc'], lineage).source}: {readable(problem)}"
            for problem in error.errors()
        ]
        return []
    wrong = _scene_problems(case)
    problems += [f"{lineage[0].source}: {problem}" for problem in wrong]
    return [] if wrong else [case]


def _owner(location: tuple[int | str, ...], lineage: list[Layer]) -> Layer:
    """Return the layer that defines the value at a location, by default the case."""
    for layer in lineage:
        table: Any = layer.keys
        for key in location[:2]:
            table = table.get(key) if isinstance(table, Mapping) else None
        if table is not None:
            return layer
    return lineage[0]


def _put_over(base: Mapping[str, Any], keys: Mapping[str, Any]) -> dict[str, Any]:
    """Merge scenes by path, expectations by method, maps by file; other keys replace."""
    merged = {**base, **keys}
    merged.pop("like", None)
    for name in ("scene", "expected", "maps"):
        old, new = base.get(name, {}), keys.get(name, {})
        if not (isinstance(old, Mapping) and isinstance(new, Mapping) and (old or new)):
            continue
        merged[name] = {**old, **new}
        if name == "expected":
            merged[name] = dict.fromkeys(JUDGED, new[ALL]) if ALL in new else dict(old)
            for method, change in new.items():
                before = merged[name].get(method)
                if method == ALL:
                    continue
                if isinstance(before, Mapping) and isinstance(change, Mapping):
                    # another outcome replaces the baseline's, else it is completed by it
                    another = any(key in change and key not in before for key in OUTCOME_KEYS)
                    if not (another and any(key in before for key in OUTCOME_KEYS)):
                        change = {**before, **change}
                merged[name][method] = change
        if name == "scene":
            merged[name] = deepcopy(dict(old))
            for path, value in new.items():
                override(merged[name], path, deepcopy(value))
    return merged


def _scene_problems(case: HardCase) -> list[str]:
    """Return problems of the scene or the reference's scene, except for expected refusals."""
    with tempfile.TemporaryDirectory(prefix="roughline-") as folder:
        for name in case.maps:
            (Path(folder) / name).touch()
        try:
            scene = case.scene_in(Path(folder))
        except SceneError as error:
            expected = all(
                expectation.kind == REFUSED and expectation.reason in str(error)
                for expectation in case.expected.values()
            )
            return [] if expected else [f"scene: {problem}" for problem in error.problems]
        try:
            case.scene_in(Path(folder), case.truth.scene)
        except SceneError as error:
            return [f"truth.scene: {problem}" for problem in error.problems]
        file = getattr(scene.surface, "file", "")
        if file and not (Path(folder) / file).is_file():
            return [f"scene: surface.file: expected a file, or one of maps, got {file!r}"]
    missing = case.truth.formula.missing(scene) if case.truth.formula is not None else []
    return [f"truth.formula: expected {key} in the scene, which has none" for key in missing]
