"""The command ``roughline hard-cases``: every method on scenes that break solvers."""

from __future__ import annotations

import datetime
import shlex
import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

from cyclopts import Parameter

from reports.cli.method_files import NOTHING, Outside
from reports.cli.workers import ALONE, Crew

if TYPE_CHECKING:
    from comparisons.questions.hard_cases.case import HardCase
    from comparisons.questions.hard_cases.record import HardCasesRecord, OutcomeRecord
    from comparisons.solving.executors import Executor

FINE, DIFFERS = 0, 1


def hard_cases(
    *methods: str,
    full: Annotated[bool, Parameter(name="--full", negative="--quick")] = False,
    out: Path = Path("roughline-results/hard-cases"),
    json: Path | None = None,
    case: tuple[str, ...] = (),
    crew: Crew = ALONE,
    outside: Outside = NOTHING,
) -> int:
    """Run the catalogue of hard cases: accurate, degraded, or refused, as expected or not.

    Parameters
    ----------
    methods
        The methods; default: all of them, peers (tamaas, ...) in full runs only.
    full
        Every method on every case; --quick: the slow pairs are left out.
    out
        Folder for hard-cases.json, hard-cases.csv and report.html.
    json
        Write the record of the run to this file too.
    case
        Only this case, or those of a file of yours; may be repeated.
    """
    from comparisons.errors import InputError
    from comparisons.facts.methods import METHODS
    from comparisons.files import write_named_text
    from comparisons.questions.hard_cases.catalogue import HardCaseError, catalogue, load_cases
    from comparisons.questions.hard_cases.record import PAGE, open_folder, save_record
    from reports.cli import terminal
    from reports.pages.hard_cases import write_hard_cases_report

    outside.load()
    problems = [
        f"methods: expected one of {', '.join(METHODS)}, got {name!r}"
        for name in methods
        if name not in METHODS
    ]
    try:
        cases = load_cases(case) if case else list(catalogue().values())
    except HardCaseError as error:
        problems += error.problems
    if problems:
        raise InputError("\n".join(problems))
    executor = crew.executor()
    open_folder(out)
    # Each solve of a peer starts a process: quick runs have them only if they are named.
    named = tuple(name for name, method in METHODS.items() if full or not method.peer)
    record, interrupt = _run(methods or named, cases, full, executor)
    save_record(out, record)
    write_hard_cases_report(record, out / PAGE)
    if json is not None:
        write_named_text(json, record.model_dump_json(indent=1) + "\n")
    terminal.print_hard_cases(record, out / PAGE)
    if interrupt is not None:
        raise interrupt
    return DIFFERS if record.deviations or record.lost else FINE


def _run(
    methods: tuple[str, ...], cases: list[HardCase], full: bool, executor: Executor
) -> tuple[HardCasesRecord, BaseException | None]:
    """Run the cases; what ended them before their time comes with what is done."""
    from comparisons.errors import LostWorkError
    from comparisons.machine import machine, versions
    from comparisons.questions.hard_cases.record import HardCasesRecord, recorded
    from comparisons.questions.hard_cases.run import run_cases
    from comparisons.solving.execution import THREADS
    from reports.cli import terminal

    start = time.perf_counter()
    interrupt: BaseException | None = None
    found: dict[str, list[OutcomeRecord]] = {}
    created = datetime.datetime.now(datetime.UTC).astimezone().isoformat(timespec="seconds")
    try:
        with terminal.status() as say:
            for each in run_cases(cases, methods, full=full, executor=executor):
                found[each[0].case] = [recorded(outcome) for outcome in each]
                say(f"{each[0].case} is done ({len(found)} of {len(cases)})")
    except (KeyboardInterrupt, LostWorkError) as error:
        interrupt = error
    record = HardCasesRecord(
        created=created,
        command=shlex.join(["roughline", *sys.argv[1:]]),
        effort="full" if full else "quick",
        seconds=time.perf_counter() - start,
        machine=machine(THREADS),
        versions=versions(),
        interrupted=interrupt is not None,
        hard={case.id: case.hard for case in cases},
        outcomes=[outcome for case in cases for outcome in found.get(case.id, [])],
    )
    return record, interrupt
