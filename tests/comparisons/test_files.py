"""Files are whole or not there; what is no file is written through, never replaced."""

import gc
import os
import stat
import subprocess
import sys
import threading
import zipfile
from pathlib import Path

import numpy as np
import pytest

from comparisons.files import (
    write_arrays,
    write_atomically,
    write_named,
    write_named_text,
    write_text,
)
from roughline.commands.app import run_command

ROOT = Path(__file__).resolve().parents[2]


def test_a_failure_while_writing_leaves_the_old_file_and_no_other(tmp_path):
    path = tmp_path / "file.txt"
    write_text(path, "old")

    def half(stream):
        stream.write(b"half of the new")
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_atomically(path, half)
    assert path.read_text() == "old"
    assert os.listdir(tmp_path) == ["file.txt"]


def test_an_interrupt_while_arrays_are_packed_is_an_interrupt(tmp_path, monkeypatch):
    """Not a complaint of the archive that a member is still open, nor of a closed file later."""
    whole = zipfile.ZipFile.open

    def interrupted(archive, *arguments, **options):
        member = whole(archive, *arguments, **options)
        assert member
        raise KeyboardInterrupt

    monkeypatch.setattr(zipfile.ZipFile, "open", interrupted)
    with pytest.raises(KeyboardInterrupt):
        write_arrays(tmp_path / "a.npz", {"x": np.zeros(3)})
    gc.collect()  # what a destructor complains of fails a test
    assert not list(tmp_path.iterdir())


def test_files_are_readable_by_others(tmp_path):
    """Temporary files are private; results follow the umask, like any other file."""
    reference = tmp_path / "reference"
    reference.write_text("")
    write_text(tmp_path / "deep" / "down" / "file.txt", "\u00e9")
    written = tmp_path / "deep" / "down" / "file.txt"
    assert written.read_text(encoding="utf-8") == "\u00e9"
    assert stat.S_IMODE(written.stat().st_mode) == stat.S_IMODE(reference.stat().st_mode)


@pytest.mark.skipif(os.name != "posix", reason="permissions of POSIX")
def test_a_private_file_stays_private(tmp_path):
    """Replaced by a new file, it would be as public as the umask says."""
    path = tmp_path / "private.csv"
    path.write_text("old")
    path.chmod(0o600)
    write_named_text(path, "new")
    assert path.read_text() == "new"
    assert stat.S_IMODE(path.stat().st_mode) == 0o600


def read_in_background(pipe: Path) -> tuple[list[str], threading.Thread]:
    """Read a pipe to its end, from which time on the list has its content."""
    content: list[str] = []
    reader = threading.Thread(target=lambda: content.append(pipe.read_text()), daemon=True)
    reader.start()
    return content, reader


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no named pipes here")
@pytest.mark.parametrize("linked", [False, True])
def test_a_pipe_is_written_through(tmp_path, linked):
    pipe = tmp_path / "pipe.csv"
    os.mkfifo(pipe)
    name = tmp_path / "link.csv" if linked else pipe
    if linked:
        name.symlink_to(pipe)
    content, reader = read_in_background(pipe)
    assert run_command(["solve", "cone", "--method", "closed_form", "--csv", str(name)]) == 0
    reader.join(10)
    assert content[0].startswith("step,")
    assert stat.S_ISFIFO(pipe.stat().st_mode)
    assert name.is_symlink() == linked


@pytest.mark.parametrize("target", ["there.csv", "not-yet.csv"])
def test_a_link_stays_and_leads_to_the_new_file(tmp_path, target):
    """Over two links, one of them relative to its own folder."""
    (tmp_path / "deep").mkdir()
    (tmp_path / "deep" / "there.csv").write_text("old")
    (tmp_path / "deep" / "link.csv").symlink_to(target)
    link = tmp_path / "link.csv"
    link.symlink_to("deep/link.csv")
    write_named_text(link, "new")
    assert link.is_symlink()
    assert (tmp_path / "deep" / "link.csv").is_symlink()
    assert (tmp_path / "deep" / target).read_text() == "new"


def test_links_that_lead_in_a_circle_are_an_error_and_stay(tmp_path):
    one, other = tmp_path / "one", tmp_path / "other"
    one.symlink_to(other)
    other.symlink_to(one)
    with pytest.raises(OSError, match="one"):
        write_named_text(one, "text")
    assert one.is_symlink()
    assert other.is_symlink()


def test_a_link_in_a_results_folder_does_not_lead_out_of_it(tmp_path):
    """Results come from strangers: their report.html may be a link to a file of mine."""
    mine = tmp_path / "mine"
    mine.write_text("mine")
    link = tmp_path / "report.html"
    link.symlink_to(mine)
    write_text(link, "report")
    assert (mine.read_text(), link.read_text()) == ("mine", "report")


STDOUT = next((p for p in ("/proc/self/fd/1", "/dev/fd/1") if os.path.exists(p)), None)


@pytest.mark.skipif(STDOUT is None, reason="open files have no names here")
@pytest.mark.parametrize("regular", [False, True])
def test_standard_output_is_written_to_as_it_is(tmp_path, regular):
    """As in > file: what is printed before and after is kept; in a pipe as well.

    By a link of our own: /dev/stdout itself would be lost where this fails as root.
    """
    link = tmp_path / "stdout"
    link.symlink_to(STDOUT)
    program = (
        "from pathlib import Path; from comparisons.files import write_named_text;"
        f"print('before'); write_named_text(Path({str(link)!r}), 'table\\n'); print('after')"
    )
    sent = tmp_path / "sent.txt"
    with sent.open("wb") as file:
        done = subprocess.run(
            [sys.executable, "-c", program],
            env=os.environ | {"PYTHONPATH": str(ROOT)},
            stdout=file if regular else subprocess.PIPE,
            check=True,
        )
    printed = sent.read_text() if regular else done.stdout.decode()
    assert printed.split() == ["before", "table", "after"]
    assert link.is_symlink()


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no full device here")
def test_a_full_disk_is_one_clear_line(tmp_path, capsys):
    link = tmp_path / "full.csv"
    link.symlink_to("/dev/full")
    assert run_command(["solve", "cone", "--method", "closed_form", "--csv", str(link)]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert "No space left on device" in printed.err
    assert printed.err.endswith(f"{str(link)!r}\n")
    assert printed.err.count("\n") == 1
    assert link.is_symlink()


def test_an_error_names_the_file_that_was_asked_for(tmp_path):
    """Not the temporary one beside it, which nobody has heard of."""
    (tmp_path / "folder").mkdir()
    with pytest.raises(OSError, match="folder") as caught:
        write_named(tmp_path / "folder", lambda stream: stream.write(b"x"))
    assert caught.value.filename == str(tmp_path / "folder")
    (tmp_path / "file").write_text("")
    with pytest.raises(OSError, match="file") as caught:
        write_atomically(tmp_path / "file" / "below.csv", lambda stream: stream.write(b"x"))
    assert caught.value.filename == str(tmp_path / "file" / "below.csv")


@pytest.mark.parametrize(
    "arguments",
    [
        ["solve", "cone", "--method", "bem_fft", "--resolution", "8", "--vtu"],
        ["bench", "nothing-slow", "--json"],
    ],
)
def test_every_command_writes_where_a_link_leads(tmp_path, monkeypatch, arguments):
    from comparisons.questions import benchmarks

    monkeypatch.setitem(benchmarks.BENCHMARKS, "nothing-slow", list)
    link = tmp_path / "link"
    link.symlink_to(tmp_path / "target")
    assert run_command([*arguments, str(link)]) == 0
    assert link.is_symlink()
    assert (tmp_path / "target").stat().st_size > 0
