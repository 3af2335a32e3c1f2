"""Terminal output of the commands: tables, and progress on an interactive terminal."""

from __future__ import annotations

import os
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING, Any

from rich.console import Console
from rich.text import Text

from comparisons.results.folder import PAGE
from reports.tables.written import drawn
from roughline.commands import printable
from roughline.commands.progress import COMPILED, compiled

if TYPE_CHECKING:
    from comparisons.questions.claims.record import ClaimsRecord
    from comparisons.questions.single import SingleResult
    from comparisons.results.advice import Advice
    from comparisons.results.ensemble_folder import EnsembleResult
    from comparisons.results.record import StudyRecord
    from comparisons.results.run_comparison import RunComparison
    from comparisons.solving.plan import Plan
    from comparisons.tasks.task import Task
    from reports.tables.cells import Table

MANY = 12
FEW = 12  # quantities of all scenes that are printed without being asked
SCREEN = 21  # lines of tables, beside the notes and the path
NARROW = 64  # columns: fewer leave a table no room for whole words
WIDE = 200  # columns of sentences in a file
UNFOLDED = 100_000  # columns, more than any line has


class Terminal(Console):
    """A console without markup; its lines are wrapped on a terminal, not in a file or a pipe."""

    def __init__(self) -> None:
        super().__init__(emoji=False, markup=False, highlight=False)
        if not self.is_terminal and "COLUMNS" not in os.environ:
            self.width = UNFOLDED

    def render_str(self, text: str, **options: Any) -> Text:
        """Render external text without terminal control sequences."""
        return super().render_str(printable(text), **options)

    def on_broken_pipe(self) -> None:
        """Tell the caller: rich would end the program with exit code 1."""
        raise BrokenPipeError

    def show(self, table: Table, *, unfolded: bool = False, width: int | None = None) -> None:
        """Print a table with its title; `drawn` says how it is folded."""
        self.print(drawn(table, unfolded=unfolded), width=width)

    def print_rows(self, table: Table) -> None:
        """Print a table with its note; on narrow terminals its rows as lines."""
        if self.width < NARROW:
            for row in table.rows:
                self.print(" ".join(cell.text for cell in row))
        else:
            self.print(drawn(table, tight=True))
        self.print(table.note, style="dim")

    def print_path(self, path: Path, seconds: float, took: str = "") -> None:
        """Print a path in one piece, to be copied, with the time that it, or another run, took."""
        from comparisons.formatting import duration

        self.print(f"{path}  ({took}{duration(seconds)})", soft_wrap=True)


def print_plans(plans: list[Plan]) -> None:
    """Print what would be modelled, what is left out and why; what is true of all, once."""
    from reports.tables.runs import plan as plan_table

    console = Terminal()
    printed_lines: set[str] = set()
    for plan in plans:
        console.show(plan_table(plan))
        lines = [
            *(f"switched on: {effect} – {model}" for effect, model in plan.switched_on),
            *(f"left out: {effect} – {reason}" for effect, reason in plan.left_out),
            *(f"note: {note}" for note in plan.notes),
        ]
        for line in lines:
            if line not in printed_lines:
                console.print(f"  {line}")
        if printed_lines.intersection(lines):
            console.print("  and as above", style="dim")
        printed_lines.update(lines)
        console.print()


def print_study(
    record: StudyRecord, lost: list[tuple[Task, str]], *, verbose: bool = False
) -> None:
    """Print what was found and the path of the report, in some 25 lines; all if `verbose`.

    What a reader must know first stands first: doubtful input, references that disagree. Every
    quantity of few scenes; of more a line for each, where there is room.
    """
    from comparisons.facts.methods import METHODS
    from comparisons.judging.truth import tally
    from comparisons.results.advice import advise, wide_truth
    from comparisons.results.finding import methods_of
    from comparisons.results.measured import modulus_sentence
    from comparisons.results.record import asked_in_vain
    from reports.tables.card import SAID, card
    from reports.tables.judged import (
        finding_table,
        others_table,
        prepared_table,
        summary_lines,
        verdict_table,
    )

    console = Terminal()
    for scene in record.scenes:
        for note in scene.plan.doubts:
            console.print(f"{scene.name}: {note}")
        for sentence in scene.disagreements:
            console.print(f"{scene.name}: {sentence}", style="bold")
        if wide := wide_truth(scene, record.effort):
            console.print(f"{scene.name}: {wide}")
    methods = methods_of(record.scenes)
    findings = [finding_table(record.scenes, method) for method in methods]
    every = [verdict_table(record.scenes, method).without("cheapest") for method in methods]
    if verbose or sum(len(table.rows) for table in every) <= FEW:
        for table in every:
            console.show(table)
    else:
        lines = summary_lines(record.scenes)
        room = SCREEN - sum(len(table.rows) + 2 for table in findings)
        if len(lines.rows) < room:
            console.print_rows(lines)
        else:
            console.print(f"{len(record.scenes)} scenes; -v prints every quantity", style="dim")
    if verbose:
        for scene in record.scenes:
            console.print(f"{scene.name}: {advise(scene).sentence}")
    for scene in record.scenes:
        if single := advise(scene).single:
            console.print(f"{scene.name}: {single}")
        if sentence := modulus_sentence(scene):
            console.print(f"{scene.name}: {sentence}")
    if len(record.scenes) == 1:
        if (others := others_table(record.scenes[0])).rows:
            console.print_rows(others)
        for heading, text in card(record.scenes[0]):
            if heading in SAID:
                console.print(f"{heading}: {text}")
    if len((prepared := prepared_table(record.scenes)).rows) in range(1, SCREEN):
        console.print_rows(prepared)
    for line in asked_in_vain(record.scenes):
        console.print(line, style="bold")
    # the blocks of an ensemble are solves of their own, with one reason
    reasons = dict.fromkeys((t.scene.name, t.method, t.resolution, reason) for t, reason in lost)
    peers = {name for name, row in METHODS.items() if row.peer}  # their failures are footnotes
    for name, method, resolution, reason in sorted(reasons, key=lambda r: r[1] in peers)[:MANY]:
        style = "dim" if method in peers else "bold"
        setting = f"{name}, {method}, N = {resolution}"
        console.print(f"lost: {setting}: {reason}", style=style)
    if len(reasons) > MANY:
        console.print(f"... and {len(reasons) - MANY} more lost solves", style="bold")
    for table in findings:
        console.print()
        console.print_rows(table)
    proved = [known for scene in record.scenes if (known := scene.reference.proved)]
    if proved:
        console.print(tally(proved))
    console.print_path(record.directory / PAGE, record.seconds)


def print_ensemble(result: EnsembleResult, directory: Path) -> None:
    """Print what an ensemble cost, means at three loads, and what is missing."""
    from reports.tables.runs import means, settings

    console, record = Terminal(), result.record
    console.show(settings(record))
    console.show(means(record, result.statistics))
    for line in record.missing[:MANY]:
        console.print(f"missing: {line}", style="bold")
    console.print_path(directory, record.seconds)


def print_solution(result: SingleResult) -> None:
    """Print the load steps of one solve."""
    from comparisons.formatting import duration, relative
    from reports.tables.runs import load_steps

    solution, console = result.solution, Terminal()
    console.show(load_steps(result, digits=6))
    console.print(
        f"resolution {result.resolution}, {solution.unknowns} unknowns, "
        f"{duration(solution.seconds)} (set-up {duration(solution.setup_seconds)})"
    )
    surfaces = len(solution.converged)
    if surfaces > 1:
        console.print(
            f"means over {surfaces} surfaces or lines, known to {relative(result.half_width)} at "
            "worst; `roughline run` compares methods on the same ones"
        )
    if solution.compile_seconds > COMPILED:
        console.print(compiled(result.method, solution.compile_seconds))


def print_claims(record: ClaimsRecord, report: Path, took: str = "") -> None:
    """Print disagreements, the verdicts with their numbers, and the path of the report.

    Of more claims than a screen holds a terminal shows those that differ, and counts the verdicts.
    """
    from reports.tables.validation import claims

    console = Terminal()
    disagreeing: dict[str, dict[str, None]] = {}  # text -> claims: they may share measurements
    for claim in record.claims:
        for text in claim.disagreements:
            disagreeing.setdefault(text, {})[claim.id] = None
    for text, ids in disagreeing.items():
        console.print(f"{', '.join(ids)}: {text}", style="bold")
    shown = record.claims
    if (console.is_terminal or took) and len(shown) > SCREEN:
        counts = Counter(claim.verdict for claim in shown).most_common()
        told = ", ".join(f"{number} {verdict}" for verdict, number in counts)
        console.print(f"{len(shown)} claims: {told}")
        shown = [claim for claim in shown if claim.differs]
    if shown:
        # Findings are sentences: they wrap in a file, too, beside ids and verdicts in one piece.
        width = console.width if console.is_terminal else min(console.width, WIDE)
        rows = claims(record.model_copy(update={"claims": shown}))
        console.show(rows, unfolded=not console.is_terminal, width=width)
        console.print()
    console.print_path(report, record.seconds, took)


def print_advice(advices: list[tuple[str, Advice]]) -> None:
    """Print the method to use for each plan of a scene, and the settings measured."""
    from comparisons.machine import machine, machine_text
    from reports.tables.judged import measured_settings

    console = Terminal()
    for name, advice in advices:
        for text in filter(None, (f"{name}: {advice.sentence}", advice.single)):
            console.print(text)
        console.show(measured_settings(advice))
    console.print(f"one thread; {machine_text(machine(1))}")


def print_run_comparison(record: RunComparison, page: Path) -> None:
    """Print the changes of answers between two runs, the worst first, and count those of times."""
    from comparisons.results.run_comparison import SAME, TIMED
    from reports.tables.runs import changes

    console = Terminal()
    for note in record.notes:
        console.print(note)
    alike = record.alike
    for told in alike.values():
        console.print(told)
    moved = [c for c in record.changes if SAME not in c.kinds]
    rows = (c for c in moved if not (c.only_timed or (c.moved and c.scene in alike)))
    notable = sorted(rows, key=lambda c: not c.bad)
    if notable:
        console.show(changes(notable[: 4 * MANY]).only("scene", "method", "N", "in words"))
    if len(notable) > 4 * MANY:
        console.print(f"... and {len(notable) - 4 * MANY} more")
    timed = {word: sum(word in c.kinds for c in moved) for word in TIMED}
    if any(timed.values()):
        counts = ", ".join(f"{count} {word}" for word, count in timed.items())
        console.print(f"times: {counts}; listed on the page")
    console.print(f"{record.sentence}\n{page}")
