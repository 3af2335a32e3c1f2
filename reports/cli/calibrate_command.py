"""The command ``roughline calibrate``: error bars of the references against their true errors."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from reports.cli.workers import ALONE, Workers
from reports.printable import say

if TYPE_CHECKING:
    from comparisons.questions.calibration_cases import Case

FINE, MISSED = 0, 1
# What the bars must reach on shapes that had no part in fixing them.
COVERAGE, WIDTHS = 0.95, {"single contacts": 3.5, "rough surfaces": 3.0}
# Share of all bars, each of one load step, that may miss a proved interval.
REFUTED = 0.005
# What bars of single contacts are multiplied by, to see what narrower or wider ones would do.
SCALES = (0.7, 0.8, 0.9, 1.1, 1.2)


def calibrate(
    *, out: Path = Path("roughline-results/calibration"), workers: Workers = ALONE
) -> int:
    """Compare the references' error bars with true errors: closed forms, rough surfaces.

    Exits with code 1 if the bars cover less than 95 % of the cases, their median width exceeds
    3.5 times the true error (rough surfaces: three times), or one does not reach what is proved.

    Parameters
    ----------
    out
        Folder for calibration.csv and report.html; existing ones are replaced.
    """
    from comparisons.judging.uncertainty import SHARE_RULE
    from comparisons.questions.calibration import Calibration
    from comparisons.questions.calibration_cases import summary
    from comparisons.questions.shares import fitted_rule
    from comparisons.results.folder import PAGE
    from reports.cli.live import watching
    from reports.pages.calibration import kinds, write_calibration_report

    command = shlex.join(["roughline", *sys.argv[1:]])
    with watching() as watch:
        executor = workers.executor(default=2)
        record = Calibration(out, command=command, executor=executor, watch=watch).run()
    cases = record.cases
    write_calibration_report(cases, command, out / PAGE)
    fine = True
    for kind, part in kinds([case for case in cases if case.half == "reported"]).items():
        reached = summary(part)
        fine &= reached.coverage >= COVERAGE and reached.width <= WIDTHS[kind]
        print(
            f"{kind}: {reached.count} cases that were not used to fit the estimator: the bar "
            f"covers the true error in {reached.coverage:.1%}; its median width is "
            f"{reached.width:.1f} times the error"
        )
    print(record.held)
    for case in cases:
        if case.missed:
            kind = "defect: " if case.refuted else ""
            print(
                f"{kind}{case.in_words}: at {case.missed} of {case.bars.size} loads the bar misses "
                f"the proved interval, at worst by {case.excess:.0%} of the bar"
            )
    _trade_off(cases)
    # no bar may be refuted by a theorem over its loads; of bars at 95 %, few at single ones
    fine &= record.held.missed <= REFUTED * record.held.bars
    fine &= not any(case.refuted for case in cases)
    print(f"rule in use: {SHARE_RULE}; fitted to the first half: {fitted_rule(cases)}")
    say(out / PAGE)
    return FINE if fine else MISSED


def _trade_off(cases: list[Case]) -> None:
    """Print what other widths of the bars of single contacts would do."""
    from comparisons.questions.calibration_cases import held, summary
    from comparisons.questions.shares import scaled

    for by in SCALES:
        made = scaled(cases, by)
        if not (reported := [case for case in made if case.half == "reported"]):
            return
        reached, proved = summary(reported), held(made)
        print(
            f"single contacts with bars {by:g} times as wide: {reached.coverage:.1%} covered, "
            f"width {reached.width:.1f}, {proved.missed} of {proved.bars} miss what is proved"
        )
