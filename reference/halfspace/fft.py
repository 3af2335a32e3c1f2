"""`reference.contact.press` by descent, of a `Press`."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from reference.contact import press as contact
from reference.contact.press import Contact
from reference.halfspace.solution import Press
from reference.loads import Load


def solve(press: Press, load: Load, **options: Any) -> Contact:
    """Return the contact at one load."""
    return contact.press(press.operator, press.gap, load, cap=press.hardness, **options)


def sweep(press: Press, load: Load, **options: Any) -> Iterator[Contact]:
    """Yield the contacts of increasing loads."""
    return contact.sweep(press.operator, press.gap, load, cap=press.hardness, **options)
