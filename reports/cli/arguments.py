"""Command-line arguments that cyclopts would parse too leniently."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Annotated, Any

from cyclopts import Parameter, Token


def _count(_type: type, tokens: Sequence[Token]) -> int:
    """Parse a whole number strictly; cyclopts would round 1.5."""
    text = tokens[0].value
    try:
        return int(text)
    except ValueError:
        raise ValueError(f"expected a whole number, got {text!r}") from None


def share(text: str) -> float:
    """Parse a relative tolerance: 5%, 5 % or 0.05.

    Raises
    ------
    comparisons.errors.InputError
    """
    from comparisons.errors import InputError

    bare = text.strip().removesuffix("%")
    try:
        return float(bare) / (100 if bare != text.strip() else 1)
    except ValueError:
        raise InputError(
            f"--tolerance: expected a relative error such as 5% or 0.05, got {text!r}"
        ) from None


def part_of(text: str) -> tuple[int, int]:
    """Parse the part of a study to solve: 2/5 is the second of five.

    Raises
    ------
    comparisons.errors.InputError
    """
    from comparisons.errors import InputError

    number, _, parts = text.partition("/")
    try:
        fraction = int(number), int(parts)
    except ValueError:
        fraction = 0, 0
    if 1 <= fraction[0] <= fraction[1]:
        return fraction
    raise InputError(f"--part: expected K/N with K from 1 to N, such as 2/5, got {text[:40]!r}")


def overrides_of(
    methods: str | None = None,
    options: tuple[str, ...] = (),
    tolerance: str | None = None,
    quantities: str | None = None,
) -> dict[str, Any]:
    """Turn options of the command line into keys of the scene, to be validated with it."""
    import tomllib

    from comparisons.errors import InputError

    overrides: dict[str, Any] = {}
    for key, names in (("methods", methods), ("quantities", quantities)):
        if names is not None:
            overrides[f"compare.{key}"] = [name.strip() for name in names.split(",")]
    if tolerance is not None:
        overrides["compare.tolerance"] = share(tolerance)
    for text in options:
        key, equals, value = text.partition("=")
        if not equals or key.count(".") != 1:
            raise InputError(f"--option: expected METHOD.KEY=VALUE, got {text!r}")
        try:
            parsed = tomllib.loads(f"value = {value}")["value"]
        except tomllib.TOMLDecodeError:
            parsed = value
        overrides[f"methods.{key}"] = parsed
    return overrides


MaybeWhole = Annotated[int | None, Parameter(converter=_count)]
Flag = Annotated[bool, Parameter(negative=())]
Full = Annotated[bool, Parameter(name="--full", negative="--quick")]
Verbose = Annotated[bool, Parameter(name=["--verbose", "-v"], negative=())]
