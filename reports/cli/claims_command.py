"""The command ``roughline claims``: statements about the reduced model, judged."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from reports.cli.method_files import NOTHING, Outside
from reports.cli.workers import ALONE, Crew

FINE, DIFFERS = 0, 1


def claims(
    *ids: str,
    full: Annotated[bool, Parameter(name="--full", negative="--quick")] = False,
    out: Path = Path("roughline-results/claims"),
    json: Path | None = None,
    overwrite: Annotated[bool, Parameter(negative=())] = False,
    resume: Annotated[bool, Parameter(negative=())] = False,
    method: str | None = None,
    crew: Crew = ALONE,
    outside: Outside = NOTHING,
) -> int:
    """Judge claims about the reduced model: holds, fails, holds in a range, not resolved.

    Parameters
    ----------
    ids
        Built-in claims by their id, or claim files; default: all built-in ones.
    full
        Refine the truth until its bar is a fifth of the tolerance, and each boundary further;
        --quick: wider bars, so more may stay unresolved.
    out
        Folder for claims.json, the measurements and report.html.
    json
        Write the record of the run to this file too.
    overwrite
        Start anew in a folder that has results.
    resume
        Go on with the measurements of an interrupted run.
    method
        Judge this method instead of the reduced model, by the claims that stand on a scene.
    """
    from comparisons.files import write_named_text
    from comparisons.questions.claims.claim import about_method, load_claims
    from comparisons.questions.claims.record import load_claims_record
    from comparisons.questions.claims.runner import ClaimRun
    from reports.cli import terminal
    from reports.cli.live import watched
    from reports.pages.claims import write_claims_report

    outside.load()
    chosen_claims = load_claims(ids)
    if method is not None:
        chosen_claims = about_method(chosen_claims, method)
    run = ClaimRun(
        chosen_claims,
        out,
        effort="full" if full else "quick",
        command=shlex.join(["roughline", *sys.argv[1:]]),
        executor=crew.executor(usual=2),
        resume=resume,
        overwrite=overwrite,
    )
    page = out / "report.html"
    record = watched(run, lambda: write_claims_report(load_claims_record(out), page))
    write_claims_report(record, page)
    if json is not None:
        write_named_text(json, record.model_dump_json(indent=1) + "\n")
    terminal.print_claims(record, page)
    return DIFFERS if any(claim.differs for claim in record.claims) else FINE
