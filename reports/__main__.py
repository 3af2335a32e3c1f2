"""``python -m reports`` is ``roughline``: the way in, from the first import to the last flush."""

from __future__ import annotations

import atexit
import os
import signal
import sys

INTERRUPTED = 3


def main() -> None:
    """Run a command and exit with its code; a ctrl-C while packages are imported is one too."""
    try:
        from reports.cli import run_command

        code = run_command(sys.argv[1:])
    except KeyboardInterrupt:
        print("interrupted before anything was started", file=sys.stderr)
        code = INTERRUPTED
    # All is done and said: a ctrl-C that comes now would only spoil the exit code.
    signal.signal(signal.SIGINT, signal.SIG_IGN)
    try:
        sys.stdout.flush()
    except BrokenPipeError:
        # The reader went away (roughline ... | head): what is left to say goes nowhere, or the
        # interpreter would complain about it on its way out.
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    if code == INTERRUPTED:
        # An interrupt inside exec(), with which libraries make classes while they are imported,
        # makes CPython end itself by SIGINT even though the exception was dealt with.
        atexit._run_exitfuncs()
        os._exit(code)
    sys.exit(code)


if __name__ == "__main__":
    main()
