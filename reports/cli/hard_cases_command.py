"""The command ``roughline hard-cases``: every method on scenes that are hard to solve."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from reports.cli.arguments import Full
from reports.cli.method_files import NO_METHOD_FILES, MethodFiles
from reports.cli.workers import ALONE, Workers

FINE, DIFFERS = 0, 1


def hard_cases(
    *methods: str,
    full: Full = False,
    out: Path = Path("roughline-results/hard-cases"),
    json: Path | None = None,
    case: tuple[str, ...] = (),
    workers: Workers = ALONE,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Run the hard cases and compare the outcomes with the expected ones.

    Parameters
    ----------
    methods
        The methods; default: all, the peers (tamaas, ...) in full runs only.
    full
        Run every method on every case; --quick: leave out the slow combinations.
    out
        Folder for hard-cases.json, hard-cases.csv and report.html.
    json
        Also write the record of the run to this file.
    case
        Run only this case, or the cases of this file; may be repeated.
    """
    from comparisons.errors import InputError
    from comparisons.facts.methods import METHODS, method_named
    from comparisons.files import write_named_text
    from comparisons.questions.hard_cases.catalogue import HardCaseError, catalogue, load_cases
    from comparisons.questions.hard_cases.record import load_record
    from comparisons.questions.hard_cases.run import HardCases
    from comparisons.results.folder import PAGE, held
    from reports.cli import terminal
    from reports.cli.live import watched
    from reports.pages.hard_cases import write_hard_cases_report

    method_files.load()
    chosen: list[str] = []
    problems: list[str] = []
    for name in methods:
        try:
            chosen.append(method_named(name, "methods: "))
        except InputError as error:
            problems.append(str(error))
    try:
        cases = load_cases(case) if case else list(catalogue().values())
    except HardCaseError as error:
        problems += error.problems
    if problems:
        raise InputError("\n".join(problems))
    # Each solve of a peer starts a process: quick runs have them only if they are named.
    judged = tuple(name for name, method in METHODS.items() if full or not method.peer)
    run = HardCases(
        cases,
        chosen or judged,
        out,
        command=shlex.join(["roughline", *sys.argv[1:]]),
        effort="full" if full else "quick",
        executor=workers.executor(),
    )
    page = out / PAGE
    with held(out):
        record = watched(run, lambda: write_hard_cases_report(load_record(out), page))
        write_hard_cases_report(record, page)
    if json is not None:
        write_named_text(json, record.model_dump_json(indent=1) + "\n")
    terminal.print_hard_cases(record, page)
    return DIFFERS if record.deviations or record.lost else FINE
