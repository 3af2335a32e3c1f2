"""The command ``roughline claims``: tests of statements about the reduced model."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from reports.cli.arguments import Flag, Full
from reports.cli.method_files import NO_METHOD_FILES, MethodFiles
from reports.cli.workers import ALONE, Workers

FINE, DIFFERS = 0, 1
DEFAULT_FOLDER = Path("roughline-results")


def claims(
    *ids: str,
    full: Full = False,
    out: Path | None = None,
    json: Path | None = None,
    overwrite: Flag = False,
    resume: Flag = False,
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
        Refine the reference until its bar is a fifth of the tolerance, and narrow each range
        further; --quick: wider bars, so that more claims may stay unresolved.
    out
        Folder for claims.json, the measurements and report.html; default roughline-results/claims,
        for named claims claims-NAME. There, what this version has measured before is used again.
    json
        Also write the record of the run to this file.
    overwrite
        Replace existing results.
    resume
        Continue an interrupted run.
    stale
        Run nothing: print the ids of those claims whose verdict on the pages is older than the code
        that it came from; exit code 1 if there are any.
    method
        Test this method instead of the reduced model, on the claims that are based on a scene.
    """
    from comparisons.files import write_named_text
    from comparisons.questions.claims.claim import about_method, load_claims
    from comparisons.questions.claims.record import load_claims_record
    from comparisons.questions.claims.runner import ClaimRun
    from comparisons.questions.claims.stale import stale as stale_claims
    from comparisons.results.folder import held
    from reports.cli import terminal
    from reports.cli.live import watched
    from reports.pages.claims import write_claims_report

    method_files.load()
    chosen_claims = load_claims(ids)
    if method is not None:
        chosen_claims = about_method(chosen_claims, method)
    if stale:
        old = stale_claims(chosen_claims)
        print("\n".join(old) or "No stored verdict is older than its code.")
        return DIFFERS if old else FINE
    directory = out or DEFAULT_FOLDER / _folder_name([claim.id for claim in chosen_claims], ids)
    run = ClaimRun(
        chosen_claims,
        directory,
        effort="full" if full else "quick",
        command=shlex.join(["roughline", *sys.argv[1:]]),
        executor=workers.executor(default=2),
        # Answers are kept under hashes of all that they hang on: none can be taken for another.
        resume=resume or (out is None and not overwrite),
        overwrite=overwrite,
    )
    page = directory / "report.html"
    with held(directory):
        record = watched(run, lambda: write_claims_report(load_claims_record(directory), page))
        write_claims_report(record, page)
    if json is not None:
        write_named_text(json, record.model_dump_json(indent=1) + "\n")
    terminal.print_claims(record, page)
    return DIFFERS if any(claim.differs for claim in record.claims) else FINE


def _folder_name(claims: list[str], named: tuple[str, ...]) -> str:
    """Return the folder of all claims, which pages of studies look into, or of a few."""
    return f"claims-{'+'.join(claims)}"[:100] if named else "claims"
