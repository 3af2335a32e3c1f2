"""Arguments and options that several commands share."""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

from cyclopts import Parameter, Token

from comparisons.errors import InputError
from roughline.commands import say

if TYPE_CHECKING:
    from comparisons.solving.jobs import Executor


def _count(_type: type, tokens: Sequence[Token]) -> int:
    """Parse a whole number strictly; cyclopts would round 1.5."""
    text = tokens[0].value
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"expected a whole number, got {text!r}") from None


def share(text: str) -> float:
    """Parse a relative tolerance: 5%, 5 % or 0.05."""
    bare = text.strip().removesuffix("%")
    try:
        return float(bare) / (100 if bare != text.strip() else 1)
    except ValueError:
        raise InputError(
            f"--tolerance: expected a relative error such as 5% or 0.05, got {text!r}"
        ) from None


def part_of(text: str) -> tuple[int, int]:
    """Parse the part of a study to solve: 2/5 is the second of five."""
    number, _, parts = text.partition("/")
    try:
        fraction = int(number), int(parts)
    except ValueError:
        fraction = 0, 0
    if 1 <= fraction[0] <= fraction[1]:
        return fraction
    raise InputError(f"--part: expected K/N with K from 1 to N, such as 2/5, got {text[:40]!r}")


def flags_of(changes: tuple[str, ...]) -> dict[str, str]:
    """Return what sets a key of the scene on the command line, by how the key begins."""
    return {
        **{f"compare.{key}": f"--{key}" for key in ("methods", "tolerance", "quantities")},
        "compare.proved": "--prove",
        "loading": "--loads",
        "methods": "--option",
        **{text.partition(".")[0]: "--set" for text in changes},
    }


def overrides_of(
    methods: str | None = None,
    options: tuple[str, ...] = (),
    tolerance: str | None = None,
    quantities: str | None = None,
    loads: str | None = None,
    changes: tuple[str, ...] = (),
) -> dict[str, Any]:
    """Turn options of the command line into keys of the scene, to be validated with it."""
    overrides: dict[str, Any] = {}
    for key, names in (("methods", methods), ("quantities", quantities)):
        if names is not None:
            overrides[f"compare.{key}"] = [name.strip() for name in names.split(",")]
    if tolerance is not None:
        overrides["compare.tolerance"] = share(tolerance)
    if loads is not None:
        control, equals, values = loads.partition("=")
        if not equals:
            raise InputError(f"--loads: expected CONTROL=VALUE,VALUE,..., got {loads!r}")
        listed = [_parsed(value.strip()) for value in values.split(",")]
        overrides["loading"] = {control.strip(): {"values": listed}}
    settings = [(text, "--set", "KEY", "") for text in changes]
    settings += [(text, "--option", "METHOD.KEY", "methods.") for text in options]
    for text, flag, form, table in settings:
        key, equals, value = text.partition("=")
        if not equals or (table and key.count(".") != 1):
            raise InputError(f"{flag}: expected {form}=VALUE, got {text!r}")
        overrides[f"{table}{key}"] = _parsed(value)
    return overrides


def _parsed(value: str) -> Any:
    """Return a value of TOML; a text needs no quotation marks."""
    import tomllib

    try:
        return tomllib.loads(f"value = {value}")["value"]
    except tomllib.TOMLDecodeError:
        return value


# Exit codes. FAILED: a solve is lost, a verdict or a result differs from what was expected.
FINE, FAILED, WRONG_INPUT, INTERRUPTED = 0, 1, 2, 3
DEFAULT_FOLDER = Path("roughline-results")

MaybeWhole = Annotated[int | None, Parameter(converter=_count)]
Changes = Annotated[tuple[str, ...], Parameter(name="--set")]
Flag = Annotated[bool, Parameter(negative=())]
Share = Annotated[str, Parameter(allow_leading_hyphen=True)]  # -5% is told to be wrong
Full = Annotated[bool, Parameter(name="--full", negative="--quick")]
Verbose = Annotated[bool, Parameter(name=["--verbose", "-v"], negative=())]


@Parameter(name="*")
@dataclass(frozen=True)
class MethodFiles:
    """User-supplied methods.

    Parameters
    ----------
    method_file
        A Python file with your own method (the documentation has a page on it), which then
        runs, also where others are named; may be repeated.
    method_seconds
        Time limit for one solve of your method, including the start of its process; default: 120.
    method_gigabytes
        Memory limit for the process of your method; default: 2.
    """

    method_file: tuple[Path, ...] = ()
    method_seconds: float = 120.0
    method_gigabytes: float = 2.0

    def load(self) -> None:
        """Register the methods of the files, and of installed packages.

        InputError lists every invalid file and limit.
        """
        from importlib import metadata

        from comparisons.facts.methods import GROUP

        limits = {"seconds": self.method_seconds, "gigabytes": self.method_gigabytes}
        wrong = [
            f"--method-{name}: expected a positive number, got {value:g}"
            for name, value in limits.items()
            if not 0 < value < float("inf")
        ]
        if wrong:
            raise InputError("\n".join(wrong))
        if not (self.method_file or metadata.entry_points(group=GROUP)):
            return
        from comparisons.isolation.parent import Limits
        from comparisons.methods.user.external import add_methods

        bounds = Limits(self.method_seconds, 1e9 * self.method_gigabytes)
        for notice in add_methods(self.method_file, bounds):
            say(f"left out: {notice}", sys.stderr)


NO_METHOD_FILES = MethodFiles()


@Parameter(name="*")
@dataclass(frozen=True)
class Workers:
    """Where the solves run.

    Parameters
    ----------
    workers
        Number of single-threaded processes; 1 gives the cleanest times. Default: 1 for scenes and
        hard cases, the number of cores (at most 2) for claims and calibration.
    scheduler
        Address of a dask.distributed scheduler (tcp://HOST:PORT) whose workers solve (the
        documentation's page on clusters).
    """

    workers: MaybeWhole = None
    scheduler: str | None = None

    def executor(self, default: int = 1) -> Executor:
        """Return the executor.

        InputError if the number of workers is invalid, or why the cluster cannot be used.
        """
        from comparisons.solving.jobs import executor_for

        cores = os.cpu_count() or 1
        chosen = min(default, cores) if self.workers is None else self.workers
        most = max(2, cores)
        if not 1 <= chosen <= most:
            raise InputError(
                f"--workers: expected 1 to {most} (the cores of this machine), got {chosen}"
            )
        if self.scheduler is not None and self.workers is not None:
            raise InputError("--workers and --scheduler: expected at most one")
        return executor_for(chosen, self.scheduler)


ALONE = Workers()
