"""The command ``roughline compare``: changes between two runs."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

FINE, MOVED_SOMETHING = 0, 1


def compare(
    before: Path,
    after: Path,
    *,
    tolerance: str = "1e-5",
    slower: float = 1.5,
    out: Path = Path("roughline-results/comparison"),
) -> int:
    """Compare two results folders: changes in value, error and time.

    Parameters
    ----------
    before, after
        Folders written by `roughline run`.
    tolerance
        Smallest relative change of a quantity that counts, e.g. 1e-5 or 1%.
    slower
        Smallest ratio of times that counts as slower; between different machines, times are
        shown but not judged.
    out
        Folder for comparison.html.
    """
    from comparisons.errors import InputError
    from comparisons.results.folder import held
    from comparisons.results.runs import compare_runs
    from comparisons.results.store import load_study
    from reports.cli import terminal
    from reports.cli.arguments import share
    from reports.pages.runs import write_comparison_page

    moved = share(tolerance)
    problems = [
        f"{name}: expected a number above {least}, got {number}"
        for name, number, least in (("--tolerance", moved, 0), ("--slower", slower, 1))
        if not least < number < float("inf")
    ]
    if problems:
        raise InputError("\n".join(problems))
    record = compare_runs(load_study(before), load_study(after), moved, slower)
    page = out / "comparison.html"
    with held(out):
        write_comparison_page(record, shlex.join(["roughline", *sys.argv[1:]]), page)
    terminal.print_run_comparison(record, page)
    return MOVED_SOMETHING if record.failed else FINE
