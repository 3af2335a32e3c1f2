"""Studies of many scenes: a results folder that is resumed, read back, reported, and compared."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import pandas as pd

from comparisons import formatting as fmt
from comparisons.errors import InputError
from comparisons.methods.user.external import brought
from comparisons.questions import study
from comparisons.questions.campaign import Campaign
from comparisons.results import run_comparison
from comparisons.results.finding import methods_of
from comparisons.results.folder import PAGE, held
from comparisons.results.record import StudyRecord
from comparisons.results.run_comparison import MOVED, SAME, SLOWER, Change, RunComparison
from comparisons.results.store import load_study
from comparisons.scene.scene import as_changes
from comparisons.solving.jobs import Done
from comparisons.solving.plan import Effort
from comparisons.solving.planning import Source, plan_all
from comparisons.tasks.task import Task
from reports.tables.judged import finding_table, summary_lines
from reports.tables.runs import changes
from reports.tables.written import plain
from roughline import notebook
from roughline.commands.arguments import Workers
from roughline.comparing import Comparison
from roughline.scenes import Plan

Progress = Callable[[int, int, Task | None], None]
MOST_ROWS = 30


@dataclass(frozen=True, repr=False)
class Results:
    """A results folder: ``results["paraboloid"]`` is the comparison of one scene.

    Attributes
    ----------
    record : comparisons.results.record.StudyRecord
    """

    record: StudyRecord

    @property
    def folder(self) -> Path:
        """Where the results are."""
        return self.record.directory

    @property
    def names(self) -> list[str]:
        """The names of the scenes."""
        return [scene.name for scene in self.record.scenes]

    def __getitem__(self, name: str) -> Comparison:
        for scene in self.record.scenes:
            if scene.name == name:
                return Comparison(scene)
        raise KeyError(f"{name!r}: expected one of {', '.join(self.names)}")

    def __iter__(self) -> Iterator[Comparison]:
        return (Comparison(scene) for scene in self.record.scenes)

    def __len__(self) -> int:
        return len(self.record.scenes)

    @property
    def lost(self) -> dict[str, list[str]]:
        """Scene -> solves that were planned and have no answer, with their reasons."""
        return {comparison.name: comparison.lost for comparison in self if comparison.lost}

    def table(self) -> pd.DataFrame:
        """Return `Comparison.table` of all scenes, with the scene as first column."""
        frames = [comparison.table().assign(scene=comparison.name) for comparison in self]
        filled = [frame for frame in frames if len(frame)]
        if not filled:
            return pd.DataFrame(columns=["scene"])
        table = pd.concat(filled, ignore_index=True)
        return table[["scene", *(name for name in table if name != "scene")]]

    def report(self, *, pictures: bool = True) -> Path:
        """Write the report, one HTML file that opens offline, and return its path."""
        from reports.pages.study import write_report

        path = self.folder / PAGE
        with held(self.folder):
            write_report(self.record, path, pictures=pictures)
        return path

    def paper(
        self,
        folder: str | Path,
        *,
        formats: tuple[str, ...] = ("pdf",),
        figures: tuple[str, ...] = ("verdicts", "*-overview"),
    ) -> list[Path]:
        """Write chosen figures, tables in LaTeX and Markdown, an index (``roughline paper``)."""
        from reports.paper.files import write_paper

        return write_paper(self.record, Path(folder), formats, figures=figures)

    def __repr__(self) -> str:
        tables = [
            finding_table(self.record.scenes, name) for name in methods_of(self.record.scenes)
        ]
        return "\n".join([f"{self.folder}: {len(self)} scenes", *map(plain, tables)])

    def _repr_html_(self) -> str:
        scenes = self.record.scenes[:MOST_ROWS]
        lines = summary_lines(scenes)
        sentences = [
            f"{comparison.name}: {text}" for comparison in self for text in comparison.disagreements
        ]
        return notebook.block(
            f"{self.folder}, {self.record.effort}, {fmt.duration(self.record.seconds)}",
            *sentences,
            *(notebook.table(finding_table(scenes, name)) for name in methods_of(scenes)),
            notebook.table(lines),
            lines.note,
            notebook.more(len(self) - MOST_ROWS, "scenes"),
        )


class Study:
    """Scenes, methods, and a folder for the results; nothing is solved before `run`.

    InputError lists everything that is wrong with all scenes.

    Parameters
    ----------
    scenes : Source or list of Source
        Anything that `load_scene` takes, and names of suites ("quick", "single", "rough",
        "physics").
    folder : str or Path
        Created when the study runs. One with results needs `resume` or `overwrite`.
    methods : list of str, optional
        Only these.
    changes : mapping, optional
        Dotted key -> value, put into every scene: ``{"methods.fem.contact": "penalty"}``.
    full : bool
        Every realisation, and a truth refined to a fifth of the tolerance.
    workers : int, optional
        Processes, each on one thread; times are cleanest with 1, the default.
    scheduler : str, optional
        Address of a dask.distributed scheduler whose workers solve (the documentation's page on
        clusters).
    resume, overwrite : bool
        Go on with what is there, also after the process was killed; or start anew.
    progress : callable, optional
        Called with (solves done, solves in all, task just finished or None).
    """

    def __init__(
        self,
        scenes: Source | list[Source] | tuple[Source, ...],
        folder: str | Path,
        *,
        methods: list[str] | None = None,
        changes: Mapping[str, Any] | None = None,
        full: bool = False,
        workers: int | None = None,
        scheduler: str | None = None,
        resume: bool = False,
        overwrite: bool = False,
        progress: Progress | None = None,
    ) -> None:
        overrides = as_changes(changes)
        if methods is not None:
            overrides["compare.methods"] = methods
        effort: Effort = "full" if full else "quick"
        sources = scenes if isinstance(scenes, (list, tuple)) else [scenes]

        def watch(campaign: Campaign[Any, Any], done: Done | None) -> None:
            if progress is not None:
                progress(
                    *campaign.under_way.counts, None if done is None else done.job.arguments[0]
                )

        self._study = study.Study(
            plan_all(
                *(sources, overrides, effort, {"compare.methods": "methods"}),
                brought() if methods is None else (),
            ),
            Path(folder),
            command="roughline.Study",
            effort=effort,
            executor=Workers(workers, scheduler).executor(),
            resume=resume,
            overwrite=overwrite,
            watch=watch,
        )

    @property
    def plan(self) -> Plan:
        """The planned models, and everything left out with the reason."""
        return Plan(self._study.plans)

    def run(self) -> Results:
        """Solve what is not solved yet, compare, and write the folder.

        An interrupt keeps finished solves; the same study with ``resume=True`` continues.
        """
        self._study.run()
        return load_results(self._study.directory)  # as everybody else will read it


def load_results(folder: str | Path) -> Results:
    """Read a results folder written by `Study` or ``roughline run``.

    InputError if the folder has no results, or damaged ones. Nothing in a folder is ever executed.
    """
    return Results(load_study(folder))


MOST_CHANGES = 20


@dataclass(frozen=True, repr=False)
class Changes:
    """The changes of every solve between two runs.

    Attributes
    ----------
    record : comparisons.results.run_comparison.RunComparison
    """

    record: RunComparison

    @property
    def notes(self) -> tuple[str, ...]:
        """Overall differences between the runs: versions, machines, scenes, references."""
        return self.record.notes

    @property
    def failed(self) -> tuple[Change, ...]:
        """Solves that moved, were lost or changed their verdict."""
        return self.record.failed

    def table(self) -> pd.DataFrame:
        """Return one row per solve of both runs."""
        rows = [
            {
                "scene": change.scene,
                "method": change.method,
                "resolution": change.resolution,
                "what": ", ".join(change.kinds),
                "quantity": change.quantity,
                "change": change.change,
                "error_before": change.errors[0],
                "error_after": change.errors[1],
                "seconds_before": change.seconds[0],
                "seconds_after": change.seconds[1],
                "bad": change.bad,
            }
            for change in self.record.changes
        ]
        return pd.DataFrame(rows)

    @property
    def _notable(self) -> list[Change]:
        return [change for change in self.record.changes if SAME not in change.kinds]

    def __repr__(self) -> str:
        lines = [f"{c.scene} {c.method} {c.resolution}: {c.text}" for c in self._notable]
        return "\n".join([self.record.sentence, *self.notes, *lines])

    def _repr_html_(self) -> str:
        notable = sorted(self._notable, key=lambda change: not change.bad)
        body = notebook.table(changes(notable[:MOST_CHANGES])) if notable else ""
        left = notebook.more(len(notable) - MOST_CHANGES, "solves that changed")
        return notebook.block(self.record.sentence, *self.notes, body, left)


def compare_runs(
    before: str | Path | Results,
    after: str | Path | Results,
    *,
    tolerance: float = MOVED,
    slower: float = SLOWER,
) -> Changes:
    """Compare two results folders, solve by solve.

    InputError if a folder has no results, or a threshold is invalid.

    Parameters
    ----------
    before, after : str, Path or Results
    tolerance : float
        Smallest relative change of a quantity that counts (iterations leave about 1e-6).
    slower : float
        Smallest ratio of times that is told; not between different machines.
    """
    problems = [
        f"{name}: expected a number above {least}, got {number}"
        for name, number, least in (("tolerance", tolerance, 0), ("slower", slower, 1))
        if not least < number < float("inf")
    ]
    if problems:
        raise InputError("\n".join(problems))
    return Changes(run_comparison.compare_runs(_record(before), _record(after), tolerance, slower))


def _record(run: str | Path | Results) -> StudyRecord:
    return run.record if isinstance(run, Results) else load_study(run)
