"""Make the arena: all codes on the same cases, ours, live ones of others, and printed numbers.

Writes a page, and its first table into docs/other-codes.md where no code is missing. Interpreters
of live codes are those of ``ROUGHLINE_PYTHON_DRAKE`` and so on. FOLDER, which may be left out, has
the numbers of others (docs/other-codes.md). Run from the repository's root::

    python docs/examples/arena.py FOLDER
"""

# %%
import sys
import tomllib
from collections.abc import Iterator
from itertools import pairwise
from pathlib import Path

import line_contact
import numpy as np
import who_is_right
from balls_that_strike import curves
from numbers_of_others import EXAMPLES, compared

import roughline
from comparisons.facts.methods import title_of
from comparisons.facts.quantities import quantity
from comparisons.files import write_text
from comparisons.judging.verdicts import judged
from comparisons.methods.peers.live import LiveCode
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal, Refused
from reports.pages.page import render
from reports.tables import cells
from reports.tables.cells import Cell, Table, table
from reports.tables.written import rewrite
from roughline.commands import say

PAGE, DOCS = Path("roughline-results/arena/report.html"), Path("docs/other-codes.md")
TOLERANCE = 0.01
HEADS = ("case", "code", "quantity", "largest error", "within 1 %?", "time")
OURS, GRIDS = ("closed_form", "reduced", "bem_dense", "bem_fft"), ("tamaas", "contactmechanics")
# Scene, changes, quantities and methods.
CASES = {
    "ball on steel, 2 to 200 µm deep": (
        "paraboloid",
        {"loading": {"penetration": np.geomspace(2e-6, 2e-4, 5).tolist()}},
        ("force", "contact_area"),
        (*OURS, "fem", *GRIDS, "ngsolve", "lammps_hertz", "slippy", "drake"),
    ),
    "ball on steel, 1 to 100 N": (
        "paraboloid",
        {"loading": {"force": np.geomspace(1.0, 100.0, 5).tolist()}},
        ("penetration",),
        (*OURS, "fem", *GRIDS, "ngsolve", "mujoco"),
    ),
    "adhesive ball, drawn off": (
        "adhesive-ball",
        {"loading": {"penetration": [8e-6, 4e-6, 0.0, -1e-6]}},
        ("force",),
        ("closed_form", "reduced", "lammps_jkr"),
    ),
    "ball that dents steel, 4 µm deep": (
        "plastic-ball",
        {"loading": {"penetration": [4e-6]}},
        ("force", "contact_area", "residual_depth"),
        ("reduced", "fem", "lammps_mdr"),
    ),
    "rough patch": (
        "rough-patch",
        {},
        ("contact_area", "penetration", "stiffness"),
        ("reduced", "bem_dense", "bem_fft", *GRIDS),
    ),
}
Row = tuple[Cell | str, ...]


def row(case: str, code: Cell | str, what: str, error: float, bar: float, seconds: float) -> Row:
    """Return a row of the table: the error that decides, and the verdict on it."""
    time = cells.duration(seconds) if seconds else cells.NOTHING
    verdict = cells.verdict(judged(error, bar, TOLERANCE).word)
    return (case, code, what, cells.error(error, bar), verdict, time)


def solved(missing: list[str]) -> Iterator[Row]:
    """Solve the cases by all codes that are here, each at its finest resolution."""
    for case, (name, changes, quantities, methods) in CASES.items():
        asked = changes | {"compare.quantities": list(quantities)}
        titles = {}
        for method in methods:
            scene = roughline.load_scene(name, asked | {"compare.methods": [method]})
            solver = solver_for(method, scene)
            if isinstance(solver, Refusal):
                missing.append(f"{case}: no {title_of(method)}: {solver.reason}")
                continue
            version = f" {solver.code.version()}" if isinstance(solver, LiveCode) else ""
            titles[method] = title_of(method) + version
        scene = roughline.load_scene(name, asked | {"compare.methods": list(titles)})
        solved_by_all = roughline.compare(scene)
        missing += [f"{case}: {reason}" for reason in solved_by_all.lost]
        errors = solved_by_all.table().dropna(subset=["error"])
        errors = errors[errors["at"].isin([scene.loading.control, "step"])]
        for method, title in titles.items():
            own = errors[errors["method"] == method]
            for at in own[own["resolution"] == own["resolution"].max()].itertuples():
                what = quantity(at.quantity).label
                code = cells.method(method, title)
                yield row(case, code, what, at.error, at.uncertainty, at.seconds)
    try:
        version = line_contact.KRATOS.version()
    except Refused as refused:
        missing.append(f"no Kratos: {refused}")
        return
    for strain in (1e-4, 0.03):
        known, found = line_contact.ours(), line_contact.theirs(strain, 12, who_is_right.growth(12))
        error = found["pressure"][0] / found["hertz"] / known.value - 1
        case = f"cylinder on a block, a/R = {strain:g}"
        code = f"Kratos {version}"
        yield row(case, code, "largest pressure", error, known.bar, found["seconds"])


def printed(folder: Path) -> Iterator[Row]:
    """Hold the numbers of others against ours: of each case the one that is furthest off."""
    for example in EXAMPLES:
        numbers = compared(folder, example)
        worst = max(numbers, key=lambda number: abs(number.off))
        error = abs(float(worst.printed) / worst.ours) - 1
        bar = abs(error / worst.off) / 2 if worst.off else 0.0  # half a digit of theirs
        what = f"{worst.column}, worst of {len(numbers)}"
        yield row(example.rsplit("/", 1)[-1], "CONTACT", what, error, bar, 0.0)
    read = curves(folder)
    digitising = max(np.abs(one.off).max() for one in read[:4])  # of Hertz's law
    for one in read:
        error = one.off[np.abs(one.off).argmax()]
        case, what = one.name.split(", ", 1)
        shown = row(f"Chung & Ooi, {case}", "benchmark", what, error, digitising, 0.0)
        # held against springs, which cells and elements with coupling leave at small angles
        yield (*shown[:4], cells.NOTHING, cells.NOTHING)
    known = tomllib.loads(who_is_right.PROBLEMS.read_text(encoding="utf-8"))
    for problem in known["problems"]:
        if "model" not in problem:
            continue
        answer, numbers = who_is_right.answered(folder, problem)
        code = known["sources"][problem["source"]]["code"]
        for kind in ("reference", "result"):
            own = [number.error for number in numbers if number.kind == kind]
            if own:
                what = f"{kind}, worst of {len(own)}" if len(own) > 1 else kind
                error, bar = max(own, key=abs), answer.bar + answer.unsolved
                yield row(problem["name"], code, what, error, bar, 0.0)


def text(made: Table) -> list[list[str]]:
    """Return the rows of a table for Markdown, without times and our references.

    Case and code stand where they change.
    """
    ours = {title_of(name) for name in (*OURS, "fem")} - {title_of("reduced")}
    shown = [[cell.text for cell in one] for one in made.without("time").rows]
    body = [one for one in shown if one[1] not in ours]
    for upper, lower in reversed(list(pairwise(body))):
        lower[1] = "" if lower[:2] == upper[:2] else lower[1]
        lower[0] = "" if lower[0] == upper[0] else lower[0]
    return [[head.text for head in made.without("time").heads], *body]


if __name__ == "__main__":
    missing: list[str] = []
    run = table(HEADS, solved(missing))
    if missing:
        say("\n".join([*missing, f"{DOCS} keeps its table, which has all codes"]))
    else:
        rewrite(DOCS, {"arena": lambda: text(run)})
    tables = {"Solved here": run}
    if len(sys.argv) > 1:
        tables["Numbers of others"] = table(HEADS, printed(Path(sys.argv[1]))).without("time")
    write_text(PAGE, render("arena.html.j2", {}, tables=tables))
    say(f"{PAGE}")
