"""Progress of a running campaign, with the remaining time.

An interactive terminal shows a live display; a plain one (TERM=dumb), a pipe or a file a line for
each finished scene, at most one a second, and an occasional one on the way.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn

if TYPE_CHECKING:
    from comparisons.questions.campaign import Campaign, Watch
    from comparisons.solving.jobs import Done

R = TypeVar("R")
# Seconds between plain lines, and between those of finished scenes.
LINE, SCENE_LINE = 30.0, 1.0
# Compilation shorter than this is the reading of what was compiled before.
COMPILED = 2.0
# Remaining seconds that are worth a word.
WORTH_SAYING = 1.0


def watched(campaign: Campaign[Any, R], write_page: Callable[[], object], report: float = 0.0) -> R:
    """Run a campaign with progress on the terminal; write its page even after an interrupt.

    The report that is written afterwards usually takes `report` seconds of the remaining time.
    """
    from comparisons.errors import InputError, LostWorkError

    with watching(report) as campaign.watch:
        try:
            return campaign.run()
        except (KeyboardInterrupt, LostWorkError) as error:
            stopped = error
        # outside the handler: an error of the page is none of the interrupt's
        with suppress(InputError):
            write_page()
        raise stopped


@contextmanager
def watching(report: float = 0.0) -> Iterator[Watch]:
    """Yield a progress display that suits the terminal."""
    with _bar() as (console, bar):
        yield _Watcher(console, bar, report)


@contextmanager
def counting(participle: str) -> Iterator[Callable[[int, int, str], None]]:
    """Yield what shows how many of several like things are done, with the remaining time.

    For work that no campaign carries out, such as drawing; the time left is that of the average.
    """
    started = time.monotonic()
    with _bar() as (_, bar):

        def advance(done: int, total: int, name: str) -> None:
            text = f"{participle} {done} of {total}"
            if 0 < done < total:
                text += left_over((time.monotonic() - started) * (total - done) / done)
            if bar is not None:
                bar.update(bar.task_ids[0], completed=done, total=total, text=f"{text}  {name}")

        yield advance


@contextmanager
def _bar() -> Iterator[tuple[Console, Progress | None]]:
    """Yield the console, and a bar of progress with a text where the terminal can move."""
    console = Console(stderr=True, emoji=False)
    if not console.is_interactive:
        yield console, None
        return
    columns = BarColumn(bar_width=24), TextColumn("{task.fields[text]}", markup=False)
    with Progress(*columns, console=console, transient=True) as bar:
        bar.add_task("", text="")
        yield console, bar


def left_over(seconds: float, about: str = "about") -> str:
    r"""Return the remaining time as the end of a line.

    >>> left_over(12.0)
    ', about 12\u202fs left'
    """
    from comparisons.formatting import duration

    return f", {about} {duration(seconds)} left"


class _Watcher:
    """Report compilations at once; show progress on a bar, or in lines where there is no screen.

    A line stands for finished scenes, an occasional one for the way, and one for the end.
    """

    def __init__(self, console: Console, bar: Progress | None, report: float) -> None:
        self._console, self._bar, self._report = console, bar, report
        self._said, self._known = time.monotonic(), set[str]()

    def __call__(self, campaign: Campaign[Any, Any], done: Done | None) -> None:
        seconds = 0.0 if done is None else getattr(done.value, "compile_seconds", 0.0)
        if done is not None and seconds > COMPILED:
            self._say(compiled(done.job.kind.method, seconds))
        solved, total = campaign.counts
        if self._bar is not None:
            text = f"{progress(campaign, self._report)}  {_task_line(done)}"
            self._bar.update(self._bar.task_ids[0], completed=solved, total=total, text=text)
            return
        finished = [name for name in campaign.finished if name not in self._known]
        now = time.monotonic()
        pause = SCENE_LINE if finished else LINE
        if done is None or now - self._said >= pause or solved == total:
            at = f"done: {', '.join(finished)}" if finished else _task_line(done)
            self._say(", ".join(filter(None, (progress(campaign, self._report), at))))
            self._said = now
            self._known.update(finished)

    def _say(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)


def compiled(method: str, seconds: float) -> str:
    r"""Report the compilation of a method, which is cached for later runs.

    >>> compiled("bem_fft", 13.2)
    'bem_fft: compiled in 13\u202fs, cached for the next runs'
    """
    from comparisons.formatting import duration

    return f"{method}: compiled in {duration(seconds)}, cached for the next runs"


def progress(campaign: Campaign[Any, Any], report: float = 0.0) -> str:
    """Report the progress of a campaign and its remaining time, estimated from similar solves."""
    from comparisons.formatting import duration

    done, total = campaign.counts
    text = f"solved {done} of {total}"
    remaining = campaign.remaining()
    report *= remaining.pace
    seconds = remaining.seconds + report
    if seconds < WORTH_SAYING:
        return text
    if done == total and report:
        return f"{text}, the report takes about {duration(report)}"
    return text + left_over(seconds, "about" if remaining.complete else "at least")


def _task_line(done: Done | None) -> str:
    if done is None:
        return ""
    kind = done.job.kind
    return f"{kind.scene} {kind.method} {kind.resolution}"
