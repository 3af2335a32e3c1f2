"""Comparison of methods on one scene, with an error bar on the reference."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.errors import InputError
from comparisons.judging.verdicts import Verdict, worst
from comparisons.questions.study import solved_in_memory
from comparisons.results.advice import Setting, advise
from comparisons.results.record import SceneRecord, asked_in_vain
from comparisons.results.recording import record_scene
from comparisons.results.store import curves, measures
from comparisons.solving.plan import Effort
from comparisons.solving.planning import Source, plan_scene, unsolvable
from reports.tables.judged import methods_table
from reports.tables.scene import lost_solves
from roughline import notebook
from roughline.scenes import scene_of

if TYPE_CHECKING:
    from reports.paper.figures import PaperFigure

COLUMNS = ["method", "resolution", "quantity", "at", "step", "error", "uncertainty"]
COLUMNS += ["maximum", "rms", "verdict", "seconds", "surfaces", "seconds_all", "unknowns"]
COLUMNS += ["single_low", "single_high", "single_step"]


@dataclass(frozen=True, repr=False)
class Comparison:
    """Results of all methods on one scene.

    Attributes
    ----------
    record : comparisons.results.record.SceneRecord
    patch : Comparison, optional
        With "bem_dense" on a measured map too large for it: the comparison on a patch.
    """

    record: SceneRecord
    patch: Comparison | None = None

    @property
    def name(self) -> str:
        """The scene's name."""
        return self.record.name

    @property
    def answer(self) -> str:
        """One sentence: the cheapest setting of each method within the tolerance."""
        return advise(self.record).sentence

    @property
    def reference(self) -> str:
        """The reference and its uncertainty."""
        return self.record.reference.text or "there is none"

    @property
    def proved(self) -> str:
        """What theorems say of the truth where the scene asks (`compare.proved`), else nothing.

        The sides are columns of `steps`, in the rows of the reference: ``force_lower`` and so on.
        """
        proved = self.record.reference.proved
        return f"Proved: {proved.in_words}" if proved else ""

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of the plan; those that begin with "check the" question the scene."""
        return self.record.plan.notes

    @property
    def disagreements(self) -> tuple[str, ...]:
        """References that differ by more than their bars, in words."""
        return self.record.disagreements

    @property
    def verdict(self) -> str:
        """On the reduced model, or your own method without it: "within", "outside" ..."""
        return self.judged().word

    @property
    def cheapest(self) -> Setting | None:
        """The fastest setting within the tolerance, bar included; closed forms do not count."""
        return advise(self.record).cheapest

    @property
    def lost(self) -> list[str]:
        """Planned solves that failed, with their reasons."""
        return lost_solves(self.record)

    def judged(self, method: str | None = None) -> Verdict:
        """Return the deciding verdict on a method at its finest resolution, with its numbers.

        Default: the reduced model or, if it was not run, your own method.
        """
        return worst(self.record.verdicts_on(method or self._leading))

    @property
    def _leading(self) -> str:
        return self.record.judged_methods[0]

    def table(self) -> pd.DataFrame:
        """Return one row per method, resolution and compared quantity.

        ``error`` is the relative error at the load step that decides, with its sign (NaN: the
        distance of two fields has none), ``uncertainty`` the 95 % half-width of its bar, ``step``
        (from 0) where it is, ``maximum`` its size, ``rms`` the root mean square; ``at`` says at
        which equal load. `judged` tells which rows decide. Of random surfaces the errors are
        those of means, which took ``seconds_all``; ``seconds`` is the time of one surface or line,
        whose own errors lie from ``single_low`` to ``single_high`` (5 to 95 %, at ``single_step``).
        """
        table = measures(self.record).reindex(columns=COLUMNS)
        return table[table["quantity"].isin(self.record.quantities)].reset_index(drop=True)

    def steps(self) -> pd.DataFrame:
        """Return one row per method, resolution, realisation and load step, as in results.csv."""
        rows = self.record.rows
        return rows.where(np.isfinite(rows["step"])).frame()

    def curves(self) -> pd.DataFrame:
        """Return one row per load, a column per method and quantity with its unit (SI).

        Each method at its finest resolution; of random surfaces the means. As in curves.csv.
        """
        return curves(self.record).drop(columns="scene")

    @property
    def plots(self) -> list[str]:
        """Names of the available plots: "force-penetration", "error-force", "speed-force" ..."""
        from reports.paper.figures import panels

        return list(panels(self.record))

    def plot(self, name: str | None = None) -> PaperFigure:
        """Return a print-ready figure; ``savefig`` writes PDF, SVG or PNG.

        InputError if the plot does not exist, or matplotlib is missing (extra `paper`).

        Parameters
        ----------
        name : str, optional
            One of `plots`, one column wide; default: page-wide curves, error and cost.
        """
        from reports.paper.figures import overview, panels, single

        drawable = panels(self.record)
        figure = overview(self.record) if name is None else None
        if name in drawable:
            figure = single(drawable[name])
        if figure is None:
            reason = "nothing to draw" if name is None else f"got {name!r}"
            if name == "pressure":
                reason += "; it is kept in the folder of a Study that compares it"
            raise InputError(f"plot: expected one of {', '.join(drawable) or 'none'}, {reason}")
        return figure

    def __repr__(self) -> str:
        heading = f"{self.record.title}: {self.record.title_of(self._leading)} {self.verdict}"
        measures = self.table()
        finest = measures[
            measures["resolution"] == measures.groupby("method")["resolution"].transform("max")
        ]
        lines = heading, *self.record.plan.doubts, *self.disagreements, self.answer, self.proved
        return "\n".join([*filter(None, lines), finest.to_string(index=False)])

    def _repr_html_(self) -> str:
        tolerance = fmt.tolerance(self.record.tolerance)
        return notebook.block(
            f"{self.record.title} ({self.name}), asked: {tolerance}",
            *self.record.plan.doubts,
            *self.disagreements,
            self.answer,
            self.proved,
            notebook.table(methods_table(self.record)),
            *self.lost,
        )


def compare(
    scene: Source,
    *methods: str,
    tolerance: float | None = None,
    quantities: list[str] | None = None,
    resolutions: list[int] | None = None,
    full: bool = False,
) -> Comparison:
    """Solve a scene with several methods, and compare them with the most accurate solution.

    InputError if the scene or an argument is invalid, or if no method can solve the scene or
    compute a requested quantity. Failed solves are rows with their reason.

    Parameters
    ----------
    scene : Source
        Anything that `load_scene` takes.
    *methods : str
        Names of `list_methods`; default: all that can solve the scene. At least one must be 3-D or
        a closed form, to serve as the reference.
    tolerance : float, optional
        Acceptable relative error; default: the scene's (0.01 if it has none).
    quantities : list of str, optional
        Compared quantities: "force", "contact_area", "pressure" ...; default: the scene's.
    resolutions : list of int, optional
        Common to all methods that have one; default: at least three for each, as planned.
    full : bool
        Solve as many surfaces and grids as `roughline run --full`; otherwise as many as `run`.

    Returns
    -------
    Comparison
        Kept in memory; `Study` keeps a folder, resumes, and writes the report.

    Examples
    --------
    >>> comparison = compare("paraboloid", "closed_form", "reduced", quantities=["force"])
    >>> comparison.verdict
    'within'
    >>> comparison.table()["quantity"].unique().tolist()
    ['force']
    """
    choices = {"tolerance": tolerance, "quantities": quantities, "resolutions": resolutions}
    effort: Effort = "full" if full else "quick"
    plans = plan_scene(scene_of(scene, methods, **choices), effort)
    if problems := unsolvable(plans):
        raise InputError("\n".join(problems))
    comparison = None
    for plan in reversed(plans):
        comparison = Comparison(record_scene(*solved_in_memory(plan, effort)), comparison)
    assert comparison is not None  # a scene has at least one plan
    vain = asked_in_vain([comparison.record])
    if vain:
        raise InputError("\n".join(vain))
    return comparison
