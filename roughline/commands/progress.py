"""Progress of a running campaign, with the remaining time.

An interactive terminal shows a live display; a plain one (TERM=dumb), a pipe or a file a line for
each finished scene, at most one a second, and an occasional one on the way.
"""

from __future__ import annotations

import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager, nullcontext, suppress
from typing import TYPE_CHECKING, Any, TypeVar

from rich.console import Console
from rich.progress import BarColumn, Progress, TextColumn, track

from comparisons.errors import InputError, LostWorkError

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


def watched(
    campaign: Campaign[Any, R], write_page: Callable[[R], object], report: float = 0.0
) -> R:
    """Run a campaign with progress on the terminal; write its page even after an interrupt.

    The page usually takes `report` seconds of the remaining time.
    """
    stopped: KeyboardInterrupt | LostWorkError | None = None
    with watching(report) as campaign.watch:
        try:
            record = campaign.run()
        except (KeyboardInterrupt, LostWorkError) as error:
            stopped = error
    if stopped is None:
        write_page(record)
        return record
    # outside the handler: an error of the page is none of the interrupt's
    with suppress(InputError):
        if campaign.saved is not None:
            write_page(campaign.saved)
    raise stopped


@contextmanager
def watching(report: float = 0.0) -> Iterator[Watch]:
    """Yield a progress display that suits the terminal.

    It reports compilations at once, and progress on a bar; where there is no screen in lines, for
    finished scenes, an occasional one on the way, and one for the end.
    """
    console = Console(stderr=True, emoji=False)
    columns = BarColumn(bar_width=24), TextColumn("{task.fields[text]}", markup=False)
    moving = Progress(*columns, console=console, transient=True)
    with moving if console.is_interactive else nullcontext() as bar:
        said, known = time.monotonic(), set[str]()
        if bar is not None:
            bar.add_task("", text="")

        def say(text: str) -> None:
            console.print(text, markup=False, highlight=False, soft_wrap=True)

        def watch(campaign: Campaign[Any, Any], done: Done | None) -> None:
            nonlocal said
            if done is not None and done.compile_seconds > COMPILED:
                say(compiled(done.job.kind.method, done.compile_seconds))
            kind = None if done is None else done.job.kind
            task = f"{kind.scene} {kind.method} {kind.resolution}" if kind else ""
            text, (solved, total) = progress(campaign, report), campaign.under_way.counts
            if bar is not None:
                text = f"{text}  {task}"
                bar.update(bar.task_ids[0], completed=solved, total=total, text=text)
                return
            finished = [name for name in campaign.under_way.ended if name not in known]
            now = time.monotonic()
            pause = SCENE_LINE if finished else LINE
            if done is None or now - said >= pause or solved == total:
                at = f"done: {', '.join(finished)}" if finished else task
                say(", ".join(filter(None, (text, at))))
                said = now
                known.update(finished)

        yield watch


def drawing(figures: Sequence[R]) -> Iterable[R]:
    """Yield figures that are drawn one after the other, with a bar where a terminal can move."""
    console = Console(stderr=True, emoji=False)
    still = not console.is_interactive
    return track(figures, "drawing", console=console, transient=True, disable=still)


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

    done, total = campaign.under_way.counts
    text = f"solved {done} of {total}"
    remaining = campaign.remaining()
    report *= remaining.pace
    seconds = remaining.seconds + report
    if seconds < WORTH_SAYING:
        return text
    if done == total and report:
        return f"{text}, the report takes about {duration(report)}"
    return f"{text}, {'about' if remaining.complete else 'at least'} {duration(seconds)} left"
