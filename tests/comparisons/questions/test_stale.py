"""A stored verdict is as old as the code that it came from."""

from __future__ import annotations

import pytest

from comparisons.questions.claims import stale as subject
from comparisons.questions.claims.claim import load_claims
from comparisons.questions.claims.record import STORED, load_claims_record
from comparisons.questions.claims.stale import digest_of, imported, stale
from roughline.commands.app import run_command

IDS = ("kernel-printed", "punch-square")


@pytest.fixture
def stored(monkeypatch):
    """Return the two claims, with a stored record of this very code."""
    claims = load_claims(IDS)
    digests = {claim.id: digest_of(claim) for claim in claims}
    record = load_claims_record(STORED)
    told = [r.model_copy(update={"digest": digests.get(r.id, "")}) for r in record.claims]
    record = record.model_copy(update={"claims": told})
    monkeypatch.setattr(subject, "load_claims_record", lambda path: record)
    return claims


@pytest.mark.slow
def test_a_verdict_is_old_when_its_keys_or_its_code_have_changed(stored, monkeypatch):
    kernel, _ = stored
    assert stale(stored) == []
    assert stale([kernel.model_copy(update={"text": "In other words."})]) == []
    assert stale([kernel.model_copy(update={"tolerance": 0.3})]) == ["kernel-printed"]
    code = subject._code
    changed = "reference.halfspace.kernels"
    monkeypatch.setattr(
        subject, "_code", lambda module: ("new", ()) if module == changed else code(module)
    )
    assert changed in imported(["comparisons.questions.experiments.boundary_elements"])
    assert stale(stored) == ["kernel-printed", "punch-square"]


def test_comments_and_docstrings_make_nothing_older(monkeypatch, tmp_path):
    def digest(text):
        (tmp_path / "reduced").mkdir(exist_ok=True)
        (tmp_path / "reduced" / "made_up.py").write_text(text)
        monkeypatch.setattr(subject, "_HOME", tmp_path)
        return subject._code.__wrapped__("reduced.made_up")[0]

    first = digest('"""One."""\ndef f():\n    """Two."""\n    return 1\n')
    assert digest("def f():\n    return 1  # three\n") == first
    assert digest("def f():\n    return 2\n") != first


def test_the_command_lists_what_is_old(stored, capsys):
    assert run_command(["claims", *IDS, "--stale"]) == 0
    assert "No stored verdict is older" in capsys.readouterr().out
    assert run_command(["claims", *IDS, "punch-l", "--stale"]) == 1
    assert capsys.readouterr().out == "punch-l\n"


def test_the_page_of_stored_verdicts_is_written_without_a_run(tmp_path, monkeypatch):
    """Of the claims that are named, and no other."""
    monkeypatch.chdir(tmp_path)
    assert run_command(["claims", "kernel-printed", "--stored"]) == 0
    page = (tmp_path / "roughline-results/claims-stored/report.html").read_text(encoding="utf-8")
    assert 'id="claim-kernel-printed"' in page
    assert 'id="claim-punch-square"' not in page
