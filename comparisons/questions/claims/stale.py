"""Which stored verdicts are older than the code that they came from.

The record of a full run carries a digest of all modules of ours that a claim's experiment, or the
solvers of its scene, import in turn, and of the claim's own keys. Comments and docstrings do not
enter it.
"""

from __future__ import annotations

import ast
import hashlib
from collections.abc import Iterable
from functools import cache
from pathlib import Path

from comparisons.facts.methods import METHODS
from comparisons.machine import OWN_PACKAGES
from comparisons.methods import registry
from comparisons.methods.solver import Refusal
from comparisons.questions.claims.claim import Claim, scene_of
from comparisons.questions.claims.record import STORED, load_claims_record
from comparisons.questions.experiments import EXPERIMENTS

_HOME = Path(__file__).resolve().parents[3]
# What moves no number: words, who says it, and the verdict that is expected.
_WORDS = {"id", "text", "equation", "reading", "corrects", "says", "citation", "confirmed_by"}
_WORDS |= {"tolerance_from", "refuted_by", "theorem", "expected"}


def stale(claims: Iterable[Claim]) -> list[str]:
    """Return the ids of the claims whose stored verdict is older than its code, or that have none.

    A verdict of which no digest was stored is older.
    """
    stored = {record.id: record.digest for record in load_claims_record(STORED).claims}
    return [claim.id for claim in claims if stored.get(claim.id) != digest_of(claim)]


def digest_of(claim: Claim) -> str:
    """Return the digest of a claim's keys and of the code that measures it."""
    keys = claim.model_dump_json(exclude=_WORDS)
    if claim.experiment is not None:
        registry.load()
        starts = [EXPERIMENTS[claim.experiment].module]
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
