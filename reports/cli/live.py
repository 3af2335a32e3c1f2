"""Progress of a running campaign: remaining time and, for a study, speed against error so far.

An interactive terminal shows a live display; a plain one (TERM=dumb), a pipe or a file a line for
each finished scene, at most one a second, and an occasional one on the way.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress
from typing import TYPE_CHECKING, Any, TypeVar

from rich.console import Console, Group
from rich.live import Live
from rich.progress_bar import ProgressBar
from rich.table import Table
from rich.text import Text

if TYPE_CHECKING:
    from comparisons.questions.campaign import Campaign, Watch
    from comparisons.results.advice import Setting
    from comparisons.results.store import SceneRecord
    from comparisons.solving.jobs import Done

R = TypeVar("R")
# Seconds of a run before its speeds and errors are drawn, between drawings, between plain lines,
# and between those of finished scenes; and the share of the time that drawing may cost.
LONG, DRAW, LINE, SCENE_LINE, SHARE = 10.0, 5.0, 30.0, 1.0, 0.02
# Compilation shorter than this is the reading of what was compiled before.
COMPILED = 2.0
# A lower bound on the remaining seconds says nothing below this.
WORTH_SAYING = 1.0
WIDTH, HEIGHT = 56, 9
LETTERS = "abcdefghijklmnopqrstuvwxyz"


def watched(campaign: Campaign[Any, R], write_page: Callable[[], object]) -> R:
    """Run a campaign with progress on the terminal; write its page even after an interrupt."""
    from comparisons.errors import InputError, LostWorkError

    with watching() as campaign.watch:
        try:
            return campaign.run()
        except (KeyboardInterrupt, LostWorkError):
            # A second one may have come while the first was being dealt with.
            with suppress(InputError):
                write_page()
            raise


@contextmanager
def watching() -> Iterator[Watch]:
    """Yield a progress display that suits the terminal."""
    console = Console(stderr=True, emoji=False)
    if console.is_interactive:
        with Live(console=console, transient=True, auto_refresh=False) as live:
            yield _Screen(live)
    else:
        yield _Lines(console)


@contextmanager
def counting(participle: str) -> Iterator[Callable[[int, int, str], None]]:
    """Yield what shows how many of several like things are done, with the remaining time.

    For work that no campaign carries out, such as drawing; the time left is that of the average.
    """
    console = Console(stderr=True, emoji=False)
    if not console.is_interactive:
        yield lambda done, total, name: None
        return
    started = time.monotonic()
    with Live(console=console, transient=True, auto_refresh=False) as live:

        def advance(done: int, total: int, name: str) -> None:
            text = f"{participle} {done} of {total}"
            if 0 < done < total:
                text += left_over((time.monotonic() - started) * (total - done) / done)
            live.update(_bar_line(done, total, f"{text}  {name}"), refresh=True)

        yield advance


def left_over(seconds: float, about: str = "about") -> str:
    r"""Return the remaining time as the end of a line.

    >>> left_over(12.0)
    ', about 12\u202fs left'
    """
    from comparisons.formatting import duration

    return f", {about} {duration(seconds)} left"


def _bar_line(done: int, total: int, text: str) -> Table:
    """Return a bar of progress with a text beside it."""
    line = Table.grid(padding=(0, 1))
    bar = ProgressBar(total=max(total, 1), completed=done, width=24)
    line.add_row(bar, Text(text, overflow="ellipsis"))
    return line


class _Watcher:
    """Common part of both displays: reports compilations at once, progress when due."""

    def __init__(self) -> None:
        self.started = time.monotonic()

    def __call__(self, campaign: Campaign[Any, Any], done: Done | None) -> None:
        seconds = 0.0 if done is None else getattr(done.value, "compile_seconds", 0.0)
        if done is not None and seconds > COMPILED:
            self.say(compiled(done.job.kind.method, seconds))
        self.show(campaign, done)

    def say(self, text: str) -> None:
        raise NotImplementedError

    def show(self, campaign: Campaign[Any, Any], done: Done | None) -> None:
        raise NotImplementedError


class _Lines(_Watcher):
    """A line for finished scenes, an occasional one on the way, and one at the end."""

    def __init__(self, console: Console) -> None:
        super().__init__()
        self._console, self._said = console, self.started
        self._known: set[str] = set()

    def say(self, text: str) -> None:
        self._console.print(text, markup=False, highlight=False, soft_wrap=True)

    def show(self, campaign: Campaign[Any, Any], done: Done | None) -> None:
        solved, total = campaign.counts
        finished = [name for name in campaign.finished if name not in self._known]
        now = time.monotonic()
        pause = SCENE_LINE if finished else LINE
        if done is not None and (now - self._said >= pause or solved == total):
            at = f"done: {', '.join(finished)}" if finished else _task_line(done)
            self.say(f"{progress(campaign)}, {at}")
            self._said = now
            self._known.update(finished)


class _Screen(_Watcher):
    """A progress bar with the remaining time, above the plot of the current scene."""

    def __init__(self, live: Live) -> None:
        super().__init__()
        self._live, self._plot = live, ""
        self._due = self.started + LONG

    def say(self, text: str) -> None:
        self._live.console.print(text, markup=False, highlight=False)

    def show(self, campaign: Campaign[Any, Any], done: Done | None) -> None:
        now = time.monotonic()
        if done is not None and now >= self._due:
            scene = campaign.so_far(done)
            self._plot = "" if scene is None else drawn(scene)
            spent = time.monotonic() - now
            self._due = now + max(DRAW, spent / SHARE)
        solved, total = campaign.counts
        line = _bar_line(solved, total, f"{progress(campaign)}  {_task_line(done)}")
        self._live.update(Group(line, Text(self._plot)), refresh=True)


def compiled(method: str, seconds: float) -> str:
    r"""Report the compilation of a method, which is cached for later runs.

    >>> compiled("bem_fft", 13.2)
    'bem_fft: compiled in 13\u202fs, cached for the next runs'
    """
    from comparisons.formatting import duration

    return f"{method}: compiled in {duration(seconds)}, cached for the next runs"


def progress(campaign: Campaign[Any, Any]) -> str:
    """Report the progress of a campaign and its remaining time, estimated from similar solves."""
    done, total = campaign.counts
    text = f"solved {done} of {total}"
    remaining = campaign.remaining()
    if done == total or remaining.seconds < (0.0 if remaining.complete else WORTH_SAYING):
        return text
    about = "about" if remaining.complete else "at least"
    return text + left_over(remaining.seconds, about)


def _task_line(done: Done | None) -> str:
    if done is None:
        return ""
    kind = done.job.kind
    return f"{kind.scene} {kind.method} {kind.resolution}"


def drawn(scene: SceneRecord) -> str:
    """Plot speed against error for a scene, from the solves finished so far."""
    from comparisons.results.advice import advise

    advice = advise(scene)
    points = [setting for setting in advice.settings if setting.counted]
    truth = [f"{s.method} {s.resolution}" for s in advice.settings if s.is_truth]
    plot = scatter(points)
    if not plot:
        return ""
    against = f", against {truth[0]} for now" if truth else ""
    return f"\n{scene.name}: largest error over time{against}\n{plot}"


def scatter(points: list[Setting], width: int = WIDTH, height: int = HEIGHT) -> str:
    """Plot settings on logarithmic axes, one letter per method; "" if nothing is known.

    The reference is a capital letter at its own error bar. Errors that are zero or unknown are left
    out, because a logarithmic axis cannot show them.
    """
    from comparisons.formatting import duration, relative

    timed = [p for p in points if p.seconds > 0 and 0 < p.worst < math.inf]
    if not timed:
        return ""
    names = list(dict.fromkeys(p.method for p in timed))
    letter = dict(zip(names, LETTERS, strict=False))
    columns, (fast, slow) = _places([p.seconds for p in timed], width)
    rows, (small, large) = _places([p.worst for p in timed], height)
    canvas = [[" "] * width for _ in range(height)]
    for point, column, row in zip(timed, columns, rows, strict=True):
        mark = letter.get(point.method, "?")
        canvas[height - 1 - row][column] = mark.upper() if point.is_truth else mark
    labels = [relative(large), *[""] * (height - 2), relative(small)]
    margin = max(map(len, labels))
    lines = [
        f"{label:>{margin}} |{''.join(row).rstrip()}"
        for label, row in zip(labels, canvas, strict=True)
    ]
    ends = duration(fast), duration(slow)
    lines.append(" " * (margin + 1) + "+" + "-" * width)
    lines.append(" " * (margin + 2) + ends[0] + ends[1].rjust(width - len(ends[0])))
    return "\n".join([*lines, "  ".join(f"{letter.get(n, '?')} {n}" for n in names)])


def _places(values: list[float], cells: int) -> tuple[list[int], tuple[float, float]]:
    """Return the cell of each value on a logarithmic axis of whole decades, and its limits."""
    logs = [math.log10(value) for value in values]
    low, high = math.floor(min(logs)), math.ceil(max(logs))
    high = max(high, low + 1)
    scale = (cells - 1) / (high - low)
    return [round((logarithm - low) * scale) for logarithm in logs], (10.0**low, 10.0**high)
