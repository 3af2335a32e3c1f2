"""What the command line prints: tables for people, and progress where someone watches."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.markup import escape
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn
from rich.table import Table
from rich.text import Text

from reports.cli.live import COMPILED, compiled
from reports.printable import printable

if TYPE_CHECKING:
    from pathlib import Path

    from comparisons.methods import Task
    from comparisons.questions.benchmarks.yardstick import Measurement
    from comparisons.questions.claims.record import ClaimsRecord
    from comparisons.questions.hard_cases.record import HardCasesRecord, OutcomeRecord
    from comparisons.questions.regression import Finding
    from comparisons.questions.single import SingleResult
    from comparisons.questions.study import Progress as Report
    from comparisons.results.advice import Advice
    from comparisons.results.decisions import Verdict
    from comparisons.results.runs import RunComparison
    from comparisons.results.store import StudyRecord
    from comparisons.solving.planning import Plan

MANY = 12
UNFOLDED = 100_000  # columns, more than any line has


@contextmanager
def progress() -> Iterator[Report]:
    """Give a study something to report to: a bar on a terminal, silence elsewhere."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda done, total, task: None
        return
    columns = (TextColumn("{task.description}"), BarColumn(), MofNCompleteColumn())
    with Progress(*columns, TimeElapsedColumn(), console=console, transient=True) as bar:
        line = bar.add_task("solving", total=None)

        def report(done: int, total: int, task: Task | None) -> None:
            name = "" if task is None else f" {task.scene.name} {task.method} {task.resolution}"
            bar.update(line, completed=done, total=total, description=f"solved{name}")

        yield report


@contextmanager
def claim_progress() -> Iterator[Callable[[int, int, str], None]]:
    """Give a run of claims something to report to, as `progress` does for a study."""
    with progress() as report:
        yield lambda done, total, name: report(done, total, None)


def print_plans(plans: list[Plan]) -> None:
    """Print what would be modelled, and what is left out and why."""
    console = _console()
    for plan in plans:
        table = _table(f"{plan.scene.heading} ({plan.scene.name})", "method", "resolutions", "plan")
        for planned in plan.methods:
            if planned.supported:
                levels = ", ".join(str(n) for n in planned.resolutions)
                reason = f" [{planned.reason}]" if planned.reason.startswith("left out") else ""
                table.add_row(planned.method, levels, escape(planned.modelled + reason))
            else:
                table.add_row(planned.method, "–", escape(f"not run: {planned.reason}"))
        console.print(table)
        for what, how in plan.switched_on:
            console.print(f"  switched on: {what} – {how}", markup=False, highlight=False)
        for what, why in plan.left_out:
            console.print(f"  left out: {what} – {why}", markup=False, highlight=False)
        for note in plan.notes:
            console.print(f"  note: {note}", markup=False, highlight=False)
        console.print()


def print_study(record: StudyRecord, lost: list[tuple[Task, str]]) -> None:
    """Print the verdicts, each scene's answer, and where the report is."""
    from comparisons.formatting import duration
    from comparisons.geometry.plausibility import CHECK
    from comparisons.results.advice import advise
    from comparisons.results.decisions import asked_in_vain, judged_methods, title_of, verdicts

    console = _console()
    for scene in record.scenes:
        for note in scene.plan.get("notes", []):
            if note.startswith(CHECK):
                console.print(f"{scene.name}: {note}", markup=False, highlight=False)
        for sentence in scene.disagreements:
            console.print(f"{scene.name}: {sentence}", style="bold", markup=False)
    methods = list(dict.fromkeys(name for each in record.scenes for name in judged_methods(each)))
    for method in methods:
        heads = ("scene", "quantity", "largest error", "at", "verdict")
        table = _table(f"The {title_of(method)}", *heads)
        for scene in record.scenes:
            found = verdicts(scene, method)
            for index, each in enumerate(found):
                table.add_row(scene.name if index == 0 else "", *_verdict_cells(each))
        console.print(table)
    for scene in record.scenes:
        console.print(f"{scene.name}: {advise(scene).sentence}", markup=False, highlight=False)
    for line in asked_in_vain(record.scenes):
        console.print(line, style="bold", markup=False)
    for task, reason in lost[:MANY]:
        where = f"{task.scene.name} {task.method} {task.resolution}"
        console.print(f"lost: {where}: {reason}", style="bold", markup=False)
    if len(lost) > MANY:
        console.print(f"... and {len(lost) - MANY} more lost solves", style="bold")
    console.print(
        f"\n{record.directory / 'report.html'}  ({duration(record.seconds)})", markup=False
    )


def _verdict_cells(verdict: Verdict) -> tuple[str, str, str, str]:
    from comparisons.formatting import quantity, tolerance

    words = quantity(verdict.quantity).words
    if verdict.word == "no result":
        return words, "–", "", escape(f"no result: {verdict.reason}")
    return words, verdict.number, verdict.when, f"{verdict.word} {tolerance(verdict.tolerance)}"


def print_solution(result: SingleResult) -> None:
    """Print the load steps of one solve."""
    from comparisons.formatting import duration, prefix_for, quantity

    solution = result.solution
    given = (*result.plan.loads.columns,)
    asked = (*given, *(q for q in result.plan.scene.compare.quantities if q not in given))
    found = result.columns()
    columns = {name: found[name] for name in asked if name in found}
    headings, texts = [], []
    for name, values in columns.items():
        scale = prefix_for(values, quantity(name).unit)
        unit = f" / {scale.unit}" if scale.unit else ""
        headings.append(name.replace("_", " ") + unit)
        texts.append([f"{value * scale.factor:.6g}" for value in values])
    table = _table(f"{result.plan.scene.heading}: {result.method}", *headings)
    for row in zip(*texts, strict=True):
        table.add_row(*row)
    console = _console()
    console.print(table)
    console.print(
        f"resolution {result.resolution}, {solution.unknowns} unknowns, "
        f"{duration(solution.seconds)} (set-up {duration(solution.setup_seconds)})",
        highlight=False,
    )
    if solution.compile_seconds > COMPILED:
        console.print(compiled(result.method, solution.compile_seconds), highlight=False)


def print_claims(record: ClaimsRecord, report: Path) -> None:
    """Print each verdict with its numbers, what disagrees, and where the report is."""
    from comparisons.formatting import duration

    console = _console()
    for claim in record.claims:
        for text in claim.disagreements:
            console.print(f"{claim.id}: {text}", style="bold", markup=False)
    table = _table(f"Claims, {record.effort}", "claim", "equation", "verdict", "what was found")
    for claim in record.claims:
        word = f"{claim.verdict}, expected {claim.expected}" if claim.differs else claim.verdict
        cells = (claim.id, claim.equation, word, claim.sentence)
        table.add_row(*map(escape, cells), style="bold" if claim.differs else None)
    console.print(table)
    console.print(f"\n{report}  ({duration(record.seconds)})", markup=False)


def print_lists() -> None:
    """Print how many there are of everything that can be listed."""
    from comparisons.questions.claims.headlines import builtin_claims
    from comparisons.questions.hard_cases.catalogue import catalogue
    from comparisons.scene.method_names import known_methods
    from comparisons.scene.scene import builtin_names

    console = _console()
    known = {
        "scenes": builtin_names(),
        "methods": known_methods(),
        "claims": builtin_claims(),
        "hard-cases": catalogue(),
    }
    for what, names in known.items():
        words = what.replace("-", " ")
        console.print(f"{len(names):5} {words:<11} roughline list {what}", highlight=False)


def print_claim_list() -> None:
    """Print the built-in claims."""
    from comparisons.questions.claims.headlines import headlines

    table = _table("Built-in claims", "id", "equation", "reading", "what it says")
    for claim in headlines():
        table.add_row(*map(escape, (claim.id, claim.equation, claim.reading, claim.text)))
    _console().print(table)


def print_benchmarks(found: dict[str, list[Measurement]]) -> None:
    """Print each benchmark's times as ratios to its yardsticks, and on what it ran."""
    from comparisons.formatting import duration
    from comparisons.machine import machine, machine_text
    from comparisons.questions.benchmarks.yardstick import vector_features

    console = _console()
    words = {None: "", True: "met", False: "not met"}
    for name, rows in found.items():
        heads = ("what", "time", "yardstick", "its time", "ratio", "target", "")
        table = _table(f"Benchmark: {name}", *heads)
        for row in rows:
            target = "" if row.target is None else f"{row.target:g}"
            its = "" if row.yardstick_seconds is None else duration(row.yardstick_seconds)
            ratio = "" if row.ratio is None else f"{row.ratio:.3g}"
            cells = (row.name, duration(row.seconds), row.yardstick, its, ratio, target)
            table.add_row(*map(escape, cells), words[row.met])
        console.print(table)
    console.print(f"one thread; {machine_text(machine(1))}", markup=False, highlight=False)
    console.print(f"vector units: {vector_features()}", markup=False, highlight=False)


@contextmanager
def status() -> Iterator[Callable[[str], None]]:
    """Give a long command somewhere to say what it is at: one line, on a terminal only."""
    console = Console(stderr=True)
    if not console.is_terminal:
        yield lambda text: None
        return
    with console.status("starting") as line:
        yield lambda text: line.update(escape(printable(text)))


def print_findings(findings: list[Finding], baseline: Path) -> None:
    """Print what a check found: everything that drifted, and what is worth knowing besides."""
    console = _console()
    if not findings:
        console.print(f"a new baseline: {baseline}", markup=False)
        return
    scenes = list(dict.fromkeys(each.scene for each in findings))
    table = _table(f"Against {baseline}", "scene", "what", "found")
    for scene in scenes:
        own = [each for each in findings if each.scene == scene]
        told = [each for each in own if each.drifted or each.notable]
        if not told:
            table.add_row(scene, "", "as in the baseline")
        for index, each in enumerate(told):
            style = "bold" if each.drifted else ""
            name = scene if index == 0 else ""
            table.add_row(name, each.subject, escape(each.text), style=style)
    console.print(table)
    drifted = len({each.scene for each in findings if each.drifted})
    words = f"{drifted} of {len(scenes)} scenes drifted" if drifted else "nothing drifted"
    console.print(words, markup=False)


def print_advice(found: list[tuple[str, Advice]], *, as_json: bool = False) -> None:
    """Print which method to use for each plan of a scene, and all that was measured for it."""
    import json

    if as_json:
        print(json.dumps([advice.document(name) for name, advice in found], indent=1))
        return
    from comparisons.formatting import duration
    from comparisons.machine import machine, machine_text

    console = _console()
    for name, advice in found:
        console.print(f"{name}: {advice.sentence}", markup=False, highlight=False)
        heads = ("method", "N", "time", "verdict", "decided by")
        table = _table("Measured just now, fastest first", *heads)
        for each in advice.settings:
            name = f"{each.title}{', the truth' if each.is_truth else ''}"
            cells = (name, str(each.resolution), duration(each.seconds), each.verdict)
            cells += (each.deciding.text,)
            chosen = "bold" if each is advice.cheapest else ""
            table.add_row(*map(escape, cells), style=chosen)
        console.print(table)
    console.print(f"one thread; {machine_text(machine(1))}", markup=False, highlight=False)


def print_hard_cases(record: HardCasesRecord, page: Path) -> None:
    """Print the stability table, and what differs from the catalogue."""
    console = _console()
    cases: dict[str, dict[str, OutcomeRecord]] = {}
    for outcome in record.outcomes:
        cases.setdefault(outcome.case, {})[outcome.method] = outcome
    table = _table(f"Hard cases ({record.effort})", "case", *map(escape, record.methods))
    table.columns[0].no_wrap = True
    for case, row in cases.items():
        table.add_row(case, *(_outcome_cell(row.get(name)) for name in record.methods))
    console.print(table)
    for each in (*record.deviations, *record.lost):
        why = each.deviation or f"lost: {each.reason}"
        console.print(f"{each.case}, {each.method}: {why}", style="bold", markup=False)
    if record.outcomes and not (record.deviations or record.lost):
        console.print("every outcome is as the catalogue expects", highlight=False)
    console.print(f"\n{page}", markup=False)


def _outcome_cell(outcome: OutcomeRecord | None) -> str:
    from comparisons.formatting import ROUND_OFF, relative

    if outcome is None:
        return ""
    number = ""
    if outcome.error is not None:
        number = f" {'round-off' if outcome.error < ROUND_OFF else relative(outcome.error)}"
    return escape(f"{outcome.kind}{number}{' (!)' if outcome.deviation else ''}")


def print_hard_case_list() -> None:
    """Print the catalogue: what is hard about each case."""
    from comparisons.questions.hard_cases.catalogue import catalogue

    table = _table("Hard cases", "id", "title", "what is hard")
    table.columns[0].no_wrap = True
    for case in catalogue().values():
        table.add_row(case.id, escape(case.title), escape(case.hard))
    _console().print(table)


def print_scenes() -> None:
    """Print the built-in scenes and the suites."""
    from comparisons.scene.scene import builtin_names, load_scene
    from comparisons.scene.suites import SUITES

    table = _table("Built-in scenes", "name", "title", "suites")
    for name in builtin_names():
        suites = ", ".join(suite for suite, members in SUITES.items() if name in members)
        table.add_row(name, escape(load_scene(name).heading), suites)
    _console().print(table)


def print_methods() -> None:
    """Print the methods."""
    from comparisons.scene.method_names import known_methods

    table = _table("Methods", "name", "what", "solves")
    for name, method in known_methods().items():
        solves = "a line" if method.dimension == 1 else "the 3-D contact"
        table.add_row(name, method.title, solves)
    _console().print(table)


def print_run_comparison(record: RunComparison, page: Path) -> None:
    """Print what moved between two runs, the worst first."""
    from comparisons.formatting import duration
    from comparisons.results.runs import SAME

    console = _console()
    for note in record.notes:
        console.print(escape(note), highlight=False)
    notable = sorted((c for c in record.changes if c.kinds != (SAME,)), key=lambda c: not c.bad)
    table = _table("Solves that changed", "scene", "method", "N", "what", "time")
    for each in notable[: 4 * MANY]:
        before, after = each.seconds
        times = f"{duration(before)}, {duration(after)}" if before > 0 and after > 0 else ""
        where = escape(each.scene), escape(each.method), str(each.resolution or "")
        words = escape(each.text.replace("\N{NARROW NO-BREAK SPACE}", " "))
        table.add_row(*where, words, times, style="bold" if each.bad else None)
    if notable:
        console.print(table)
    if len(notable) > 4 * MANY:
        console.print(f"... and {len(notable) - 4 * MANY} more")
    same = len(record.changes) - len(notable)
    console.print(f"{same} of {len(record.changes)} solves are the same\n{page}", markup=False)


class _Terminal(Console):
    def render_str(self, text: str, **options: Any) -> Text:
        """Render text of others without what would command the terminal."""
        return super().render_str(printable(text), **options)

    def on_broken_pipe(self) -> None:
        """Tell the caller: rich would end the program with exit code 1."""
        raise BrokenPipeError


def _console() -> Console:
    """Return where to print; lines are folded for a terminal only, not for a file or a pipe."""
    console = _Terminal(emoji=False)
    if not console.is_terminal and "COLUMNS" not in os.environ:
        console.width = UNFOLDED
    return console


def _table(title: str, *headings: str) -> Table:
    table = Table(title=escape(title), title_justify="left", box=None, pad_edge=False)
    for heading in headings:
        table.add_column(heading, overflow="fold")
    return table
