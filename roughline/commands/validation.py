"""Commands for validation: claims, calibration of the bars, hard cases."""

from __future__ import annotations

from pathlib import Path

from comparisons.errors import InputError, ProblemsError
from roughline.commands import say, typed
from roughline.commands.arguments import (
    ALONE,
    DEFAULT_FOLDER,
    FAILED,
    FINE,
    NO_METHOD_FILES,
    Flag,
    Full,
    MethodFiles,
    Workers,
)


def claims(
    *ids: str,
    full: Full = False,
    out: Path | None = None,
    json: Path | None = None,
    overwrite: Flag = False,
    resume: Flag = False,
    stored: Flag = False,
    stale: Flag = False,
    method: str | None = None,
    workers: Workers = ALONE,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Test claims about the reduced model: hold, fail, or what they hang on.

    Parameters
    ----------
    ids
        Ids of built-in claims, or claim files; default: all built-in claims.
    full
        Refine the reference until its bar is a fifth of the tolerance, and narrow each range;
        --quick: wider bars, so that more claims may stay unresolved, and no more points than the
        verdict needs.
    out
        Folder for claims.json, the measurements and report.html; default roughline-results/claims,
        for named claims claims-NAME. There, what this version has measured before is used again.
    json
        Also write the record of the run to this file.
    overwrite
        Replace existing results.
    resume
        Continue an interrupted run.
    stored
        Run nothing: write the page of the full runs that come with the package.
    stale
        Run nothing: print the ids of those claims whose stored verdict is older than the code that
        it came from; exit code 1 if there are any.
    method
        Test this method instead of the reduced model, on the claims that are based on a scene.
    """
    from comparisons.files import write_named_text, write_text
    from comparisons.questions.claims.claim import about_method, load_claims
    from comparisons.questions.claims.record import STORED, load_claims_record
    from comparisons.questions.claims.runner import ClaimRun
    from comparisons.questions.claims.runner import stale as stale_claims
    from comparisons.results.folder import PAGE, held
    from reports.pages.claims import claims_page
    from roughline.commands import terminal
    from roughline.commands.progress import watched

    method_files.load()
    chosen_claims = load_claims(ids)
    if method is not None:
        chosen_claims = about_method(chosen_claims, method)
    if stale:
        old = stale_claims(chosen_claims)
        say("\n".join(old) or "No stored verdict is older than its code.")
        return FAILED if old else FINE
    if stored:
        names = {claim.id for claim in chosen_claims}
        record = load_claims_record(STORED)
        record = record.model_copy(
            update={"claims": [claim for claim in record.claims if claim.id in names]}
        )
        page = (out or DEFAULT_FOLDER / "claims-stored") / PAGE
        write_text(page, claims_page(record))
        terminal.print_claims(record, page, "the stored run of all claims took ")
        return FINE
    # Pages of studies look into the folder of all claims.
    name = f"claims-{'+'.join(claim.id for claim in chosen_claims)}"[:100] if ids else "claims"
    directory = out or DEFAULT_FOLDER / name
    run = ClaimRun(
        chosen_claims,
        directory,
        effort="full" if full else "quick",
        command=typed(),
        executor=workers.executor(default=2),
        # Answers are kept under hashes of all that they hang on: none can be taken for another.
        resume=resume or (out is None and not overwrite),
        overwrite=overwrite,
    )
    page = directory / PAGE
    with held(directory):
        record = watched(run, lambda record: write_text(page, claims_page(record)))
    if json is not None:
        write_named_text(json, record.model_dump_json(indent=1) + "\n")
    terminal.print_claims(record, page)
    return FAILED if any(claim.differs for claim in record.claims) else FINE


# What the bars must reach on shapes that had no part in fixing them.
COVERAGE, WIDTH = 0.95, 3.0
# Share of all bars, each of one load step, that may miss a proved interval.
REFUTED = 0.005


def calibrate(*, out: Path = DEFAULT_FOLDER / "calibration", workers: Workers = ALONE) -> int:
    """Compare the references' error bars with true errors: closed forms, rough surfaces.

    Exits with code 1 if the bars of single contacts or of rough surfaces cover less than 95 % of
    the cases that had no part in fixing them, if their median width exceeds three times the true
    error, or if more than one in two hundred does not reach what is proved.

    Parameters
    ----------
    out
        Folder for calibration.csv and report.html; existing ones are replaced.
    """
    from comparisons.files import write_text
    from comparisons.questions.calibration import Calibration
    from comparisons.questions.calibration_cases import fitted_shares, summary
    from comparisons.results.folder import PAGE, held
    from reports.pages.calibration import calibration_page
    from reports.tables.validation import by_quantity, kinds, other_widths, rule
    from roughline.commands.progress import watching
    from roughline.commands.terminal import Terminal

    console = Terminal()
    command = typed()
    executor = workers.executor(default=2)
    with held(out):
        with watching() as watch:
            record = Calibration(out, command=command, executor=executor, watch=watch).run()
        cases = record.cases
        write_text(out / PAGE, calibration_page(cases, command))
    reported = [case for case in cases if case.half == "reported"]
    console.print(
        "Cases that were not used to fit the rule: coverage, and median of bar over true error, "
        "in the rms over the loads of a case, and of the bars at every load by themselves."
    )
    for made in (*by_quantity(reported), rule(fitted_shares(cases)), *other_widths(cases)):
        console.print()
        console.show(made)
        if made.note:
            console.print(made.note)
    console.print(f"\n{record.held}.")
    for case in cases:
        if case.missed:
            kind = "defect: " if case.refuted else ""
            console.print(
                f"{kind}{case.in_words}: at {case.missed} of {case.bars.size} loads, "
                f"at worst by {case.excess:.0%} of the bar"
            )
    fine = all(
        (got := summary(part)).coverage >= COVERAGE and got.width <= WIDTH
        for part in kinds(reported).values()
    )
    # no bar may be refuted by a theorem over its loads; of bars at 95 %, few at single ones
    fine &= record.held.missed <= REFUTED * record.held.bars
    fine &= not any(case.refuted for case in cases)
    say(out / PAGE)
    return FINE if fine else FAILED


def hard_cases(
    *methods: str,
    full: Full = False,
    out: Path = DEFAULT_FOLDER / "hard-cases",
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
    from comparisons.facts.methods import METHODS, method_named
    from comparisons.files import write_named_text, write_text
    from comparisons.questions.hard_cases.case import catalogue, load_cases
    from comparisons.questions.hard_cases.run import HardCases
    from comparisons.results.folder import PAGE, held
    from reports.pages.hard_cases import hard_cases_page
    from reports.tables.validation import outcomes
    from roughline.commands.progress import watched
    from roughline.commands.terminal import Terminal

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
    except ProblemsError as error:
        problems += error.problems
    if problems:
        raise InputError("\n".join(problems))
    # Each solve of a peer starts a process: quick runs have them only if they are named.
    judged = tuple(name for name, method in METHODS.items() if full or not method.peer)
    run = HardCases(
        cases,
        chosen or judged,
        out,
        command=typed(),
        effort="full" if full else "quick",
        executor=workers.executor(),
    )
    page = out / PAGE
    with held(out):
        record = watched(run, lambda record: write_text(page, hard_cases_page(record)))
    if json is not None:
        write_named_text(json, record.model_dump_json(indent=1) + "\n")
    console = Terminal()
    console.show(outcomes(record), unfolded=True)
    for outcome in (*record.deviations, *record.lost):
        reason = outcome.deviation or f"lost: {outcome.reason}"
        console.print(f"{outcome.case}, {outcome.method}: {reason}", style="bold")
    if record.outcomes and not (record.deviations or record.lost):
        console.print("every outcome is as the catalogue expects")
    console.print(f"\n{page}")
    return FAILED if record.deviations or record.lost else FINE


def bench(benchmark: str | None = None, *, json: Path | None = None) -> int:
    """Measure the speed of the solvers against yardsticks timed in the same run.

    Parameters
    ----------
    benchmark
        "reduced", "bem" or "fem"; default: all.
    json
        Write the rows to this file, as a list of {name, seconds, yardstick, yardstick_seconds,
        ratio, target, met}.
    """
    import json as json_format

    from comparisons.files import write_named_text
    from comparisons.machine import machine, machine_text
    from comparisons.questions.benchmarks import BENCHMARKS
    from comparisons.questions.benchmarks.yardstick import vector_features
    from reports.tables.validation import measured
    from roughline.commands.terminal import Terminal

    if benchmark is not None and benchmark not in BENCHMARKS:
        raise InputError(f"bench: expected one of {', '.join(BENCHMARKS)}, got {benchmark!r}")
    names = list(BENCHMARKS) if benchmark is None else [benchmark]
    timings = {name: BENCHMARKS[name]() for name in names}
    console = Terminal()
    for name, taken in timings.items():
        console.show(measured(name, taken))
    console.print(f"one thread; {machine_text(machine(1))}\nvector units: {vector_features()}")
    if json is not None:
        rows = [measurement.row() for rows in timings.values() for measurement in rows]
        write_named_text(json, json_format.dumps(rows, indent=1) + "\n")
    return FINE


def check(
    *scenes: str,
    method: str = "reduced",
    baseline: Path | None = None,
    update: Flag = False,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Check for drift against a stored run, and attribute it to the model or a reference.

    Parameters
    ----------
    scenes
        Scene files or built-in scenes; default: all single contacts and a rough surface.
    method
        The method to check.
    baseline
        The folder of the stored run; default: roughline-baseline in this folder, else the
        packaged one.
    update
        Show the drift, then store the new run, by default in roughline-baseline.
    """
    from comparisons.questions.check import CHECK_SCENES, PACKAGED, check_against
    from reports.tables.validation import against_baseline
    from roughline.commands.progress import watching
    from roughline.commands.terminal import Terminal

    method_files.load()
    stored_baseline = Path("roughline-baseline")
    stored = baseline or (stored_baseline if stored_baseline.exists() or update else PACKAGED)
    with watching() as watch:
        scenes = scenes or CHECK_SCENES
        findings = check_against(stored, method, scenes, watch=watch, update=update)
    drifted = {finding.scene for finding in findings if finding.drifted}
    console = Terminal()
    if not findings:
        console.print(f"new baseline: {stored}")
    else:
        console.show(against_baseline(findings, str(stored)))
        count = len({finding.scene for finding in findings})
        told = f"{len(drifted)} of {count} scenes drifted" if drifted else "nothing drifted"
        console.print(told)
    return FAILED if drifted and not update else FINE
