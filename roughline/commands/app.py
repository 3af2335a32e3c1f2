"""The command line ``roughline``, also available as ``python -m roughline``.

Heavy packages are imported inside the commands, so that help and error messages appear at once.
"""

from __future__ import annotations

import io
import sys

from cyclopts import App, CycloptsError, Group, Parameter, UnknownCommandError

from comparisons.errors import InputError, LostWorkError, is_interrupt
from roughline.commands import say
from roughline.commands.arguments import FINE, INTERRUPTED, WRONG_INPUT
from roughline.commands.everyday import advise, compare, list_, new, paper, report, run, solve
from roughline.commands.shared import ensemble, leaderboard, merge, problems, submit
from roughline.commands.validation import bench, calibrate, check, claims, hard_cases

RESUMABLE = ("run", "claims", "ensemble")  # commands with --resume
# What is no command, but an option or a catalogue.
MEANT = {name: f"list {name}" for name in ("scenes", "methods")}
MEANT |= {"plan": "run --plan", "known": "advise --known"}


def _version() -> str:
    from comparisons.machine import own_version

    return own_version()


app = App(
    name="roughline",
    help="Is the fast contact model accurate? Compare it with 3-D solvers on the same scene.",
    version=_version,
    version_flags=["--version"],
    help_format="plaintext",
    suppress_keyboard_interrupt=False,  # our own exit code says that --resume will go on
    default_parameter=Parameter(negative_iterable=(), show_default=False),
)
EVERYDAY, SHARED, VALIDATION = (
    Group(name, sort_key=place)
    for place, name in enumerate(
        ("Everyday", "Problems for all methods, and many surfaces", "For validation")
    )
)
for _group, _commands in {
    EVERYDAY: (new, run, solve, advise, report, compare, paper, list_),
    SHARED: (problems, submit, leaderboard, ensemble, merge),
    VALIDATION: (claims, hard_cases, bench, calibrate, check),
}.items():
    for _command in _commands:
        app.command(_command, name=_command.__name__.strip("_").replace("_", "-"), group=_group)

app.register_install_completion_command(help="Complete commands and options in your shell.")


def run_command(arguments: list[str]) -> int:
    """Run a command and report every expected error as one clear message.

    Exit codes: 0 success, 1 a solve failed, 2 invalid input, 3 interrupted.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            # A console that cannot show a narrow space or a micro sign shows a question mark.
            stream.reconfigure(errors="replace")
    try:
        if {"--full", "--quick"} <= set(arguments):
            raise InputError("expected one of --full and --quick, got both")
        result = app(arguments, exit_on_error=False, print_error=True, result_action="return_value")
    except CycloptsError as error:
        if isinstance(error, UnknownCommandError) and arguments[0] in MEANT:
            say(f"did you mean `roughline {MEANT[arguments[0]]}`?", sys.stderr)
        return WRONG_INPUT
    except InputError as error:
        return _complain(error, str(error))
    except LostWorkError as error:
        return _interrupted(str(error), arguments)
    except KeyboardInterrupt:
        return _interrupted("interrupted", arguments)
    except BrokenPipeError:
        # The reader went away (roughline ... | head): nothing is left to say.
        sys.stderr.close()
        return FINE
    except OSError as error:
        return _complain(error, f"cannot read or write: {error}")
    return result if isinstance(result, int) else FINE


def _complain(error: Exception, message: str) -> int:
    if is_interrupt(error):
        raise error
    say(message, sys.stderr)
    return WRONG_INPUT


def _interrupted(reason: str, arguments: list[str]) -> int:
    resumes = bool(arguments) and arguments[0] in RESUMABLE
    hint = "; finished solves are kept, continue with --resume" if resumes else ""
    say(f"{reason}{hint}", sys.stderr)
    return INTERRUPTED


for _name in app:
    if not _name.startswith("-"):
        # What renders Markdown takes as long to import as all the rest: not for the first help.
        app[_name].help_format = "markdown"
