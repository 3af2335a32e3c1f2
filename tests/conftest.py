"""Fixtures that tests of several rooms share."""

from __future__ import annotations

import signal

import pytest

from comparisons.methods import METHODS
from comparisons.methods.user.external import VARIABLE
from comparisons.scene import method_names


@pytest.fixture
def methods_restored(monkeypatch):
    """Take away again the methods that a test adds."""
    known = dict(METHODS)
    monkeypatch.setenv(VARIABLE, "[]")
    monkeypatch.setattr(method_names, "_from_outside", dict(method_names._from_outside))
    yield
    for name in [each for each in METHODS if each not in known]:
        del METHODS[name]


@pytest.fixture
def interruptible():
    """Let a ctrl-C reach the programs that a test starts, wherever the tests themselves run.

    A job in the background of a shell, as on some build servers, ignores SIGINT, and a program
    inherits that from the one that starts it; a handler is not inherited.
    """
    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    yield
    signal.signal(signal.SIGINT, before)
