"""The command ``roughline calibrate``: error bars of the references against their true errors."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from reports.cli.workers import ALONE, Workers
from reports.printable import say

if TYPE_CHECKING:
    from comparisons.questions.calibration import CalibrationRecord

FINE, MISSED = 0, 1
# What the bars must reach on shapes that had no part in fixing them.
COVERAGE, WIDTH = 0.95, 3.0
# Share of all bars, each of one load step, that may miss a proved interval.
REFUTED = 0.005


def calibrate(
    *, out: Path = Path("roughline-results/calibration"), workers: Workers = ALONE
) -> int:
    """Compare the references' error bars with true errors: closed forms, rough surfaces.

    Exits with code 1 if the bars of single contacts or of rough surfaces cover less than 95 % of
    the cases that had no part in fixing them, if their median width exceeds three times the true
    error, or if more than one in two hundred does not reach what is proved.

    Parameters
    ----------
    out
        Folder for calibration.csv and report.html; existing ones are replaced.
    """
    from comparisons.questions.calibration import Calibration
    from comparisons.questions.calibration_cases import summary
    from comparisons.questions.shares import fitted_rule
    from comparisons.results.folder import PAGE, held
    from reports.cli.live import watching
    from reports.cli.terminal import print_line, print_table
    from reports.pages.calibration import write_calibration_report
    from reports.tables.calibration import by_quantity, kinds, other_widths, rule

    command = shlex.join(["roughline", *sys.argv[1:]])
    with held(out):
        with watching() as watch:
            executor = workers.executor(default=2)
            record = Calibration(out, command=command, executor=executor, watch=watch).run()
        cases = record.cases
        write_calibration_report(cases, command, out / PAGE)
    reported = [case for case in cases if case.half == "reported"]
    print_line(
        "Cases that were not used to fit the rule: coverage, and median of bar over true error, "
        "in the rms over the loads of a case, and of the bars at every load by themselves."
    )
    for made in (*by_quantity(reported), rule(fitted_rule(cases)), *other_widths(cases)):
        print_line("")
        print_table(made)
        if made.note:
            print_line(made.note)
    _print_missed(record)
    fine = all(
        (got := summary(part)).coverage >= COVERAGE and got.width <= WIDTH
        for part in kinds(reported).values()
    )
    # no bar may be refuted by a theorem over its loads; of bars at 95 %, few at single ones
    fine &= record.held.missed <= REFUTED * record.held.bars
    fine &= not any(case.refuted for case in cases)
    say(out / PAGE)
    return FINE if fine else MISSED


def _print_missed(record: CalibrationRecord) -> None:
    """Print how many bars miss what is proved, and which."""
    from reports.cli.terminal import print_line

    print_line(f"\n{record.held}.")
    for case in record.cases:
        if case.missed:
            kind = "defect: " if case.refuted else ""
            print_line(
                f"{kind}{case.in_words}: at {case.missed} of {case.bars.size} loads, "
                f"at worst by {case.excess:.0%} of the bar"
            )
