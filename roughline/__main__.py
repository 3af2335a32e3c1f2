"""``roughline`` or ``python -m roughline``: the way in, from the first import to the last flush."""

from __future__ import annotations

import _thread
import atexit
import gc
import math
import os
import signal
import sys
import threading
import time
from importlib.util import find_spec
from pathlib import Path
from types import FrameType
from typing import Any

FINE, WRONG_INPUT, INTERRUPTED = 0, 2, 3
# One press may come twice: `timeout` and some terminals tell the program and its whole group.
SAME_PRESS = 0.5
# Seconds in which a destructor or a callback that swallowed a press ends, before it comes again.
UNTIL_AGAIN = 0.01
SHOW_CURSOR = b"\x1b[?25h"  # a bar on the terminal had hidden it
SHADOWED = "roughline's packages are shadowed by others:"
# The other packages have common names.
PACKAGES = ("reduced", "reference", "comparisons", "reports")


class Interrupts:
    """What a ctrl-C or TERM does: the first one is an exception, so that what is done is kept.

    There is no second exception, which would meet the first one's handling and end in a traceback:
    a later press ends the program at once, and processes that it has started end with it.
    """

    def __init__(self) -> None:
        self.pressed = False
        self._first = math.inf  # when the one came that is being dealt with
        self._number = int(signal.SIGINT)
        self._hooked = self._over = False

    def listen(self) -> None:
        """Take both over, unless whoever started the program had it ignored (a shell's ``&``)."""
        if signal.getsignal(signal.SIGINT) is signal.default_int_handler:
            signal.signal(signal.SIGINT, self._press)
        if signal.getsignal(signal.SIGTERM) is signal.SIG_DFL:
            signal.signal(signal.SIGTERM, self._press)
        sys.unraisablehook = self._swallowed

    def _swallowed(self, lost: Any) -> None:
        """Press again in a moment, where a destructor or a callback swallowed the exception."""
        if lost.exc_type is not KeyboardInterrupt:
            sys.__unraisablehook__(lost)
        elif not self._over:
            self._first, self._hooked = math.inf, True
            try:
                self._press_again()
            finally:
                self._hooked = False

    def _press_again(self) -> None:
        if sys.platform == "win32":
            again = threading.Timer(UNTIL_AGAIN, _thread.interrupt_main, [self._number])
        else:  # a real signal ends a wait of the main thread, too
            main_thread = threading.main_thread().ident or 0
            wanted = [main_thread, self._number]
            again = threading.Timer(UNTIL_AGAIN, signal.pthread_kill, wanted)
        again.daemon = True
        again.start()

    def ignore(self) -> None:
        """All is done and said: a ctrl-C that comes now would only spoil the exit code."""
        self._over = True
        signal.signal(signal.SIGINT, signal.SIG_IGN)
        signal.signal(signal.SIGTERM, signal.SIG_IGN)

    def _press(self, number: int, frame: FrameType | None) -> None:
        now = time.monotonic()
        if self._over:
            return
        if self._hooked:  # an exception in the hook would be lost like the one that it hands on
            self._press_again()
            return
        if math.isinf(self._first):
            self.pressed, self._first, self._number = True, now, number
            raise KeyboardInterrupt
        if now - self._first > SAME_PRESS:
            cursor = SHOW_CURSOR if os.isatty(2) else b""
            os.write(2, cursor + b"interrupted again: ended at once\n")
            os._exit(INTERRUPTED)


def open_standard_streams() -> None:
    """Give what is closed (``>&-``) to nothing: no file of ours may get its number."""
    for number, name in enumerate(("stdin", "stdout", "stderr")):
        if getattr(sys, name) is None:
            mode = "r" if name == "stdin" else "w"
            stream = open(os.devnull, mode, encoding="utf-8")  # noqa: SIM115 (until the end)
            if stream.fileno() != number:
                os.dup2(stream.fileno(), number)
            setattr(sys, name, stream)


def foreign_packages() -> list[str]:
    """Return one line for each of our packages that is shadowed.

    Resolves the packages as an import would, without importing them.
    """
    home = Path(__file__).resolve().parents[1]
    lines = []
    for name in PACKAGES:
        spec = find_spec(name)
        origin = spec and (spec.origin or next(iter(spec.submodule_search_locations or []), None))
        if not origin:
            lines.append(f"{name}: not found; roughline's own is {home / name}")
        elif (other := Path(origin).resolve().parent) != home / name:
            lines.append(f"{name}: {other} shadows roughline's own {home / name}")
    return lines


def main() -> None:
    """Run a command and exit with its code; a ctrl-C while packages are imported is one too."""
    interrupts = Interrupts()
    # Imports, a plan and a page make 400 000 objects, none of them garbage to be looked for.
    gc.set_threshold(500_000)
    try:
        interrupts.listen()
        open_standard_streams()
        shadows = foreign_packages()
        if shadows:
            # before the first import that would end in a riddle
            print("\n  ".join([SHADOWED, *shadows]), file=sys.stderr)
            code = WRONG_INPUT
        else:
            from comparisons.isolation import ONE_THREAD

            # threads of linear algebra would wait for each other in problems as small as these
            os.environ.update(dict.fromkeys(ONE_THREAD, "1"))
            from roughline.commands.app import run_command

            code = run_command(sys.argv[1:])
        interrupts.ignore()
    except BaseException as error:
        from comparisons.errors import is_interrupt

        # A C extension that is loading forgets the interrupt that it met; so may a clean-up.
        met = isinstance(error.__context__, KeyboardInterrupt)
        lost = interrupts.pressed and (met or isinstance(error, (ImportError, SystemError)))
        if not (lost or is_interrupt(error)):
            raise
        print("interrupted", file=sys.stderr)
        code = INTERRUPTED
        interrupts.ignore()
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
    # The process ends, and its objects with it: not to be looked through for garbage before.
    gc.freeze()
    sys.exit(code)


if __name__ == "__main__":
    main()
