"""Solution of one scene by one method, as arrays and as a table; the methods that there are."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import pandas as pd

from comparisons import formatting as fmt
from comparisons.errors import InputError
from comparisons.facts.quantities import quantity
from comparisons.methods.registry import add_class
from comparisons.methods.solver import Solver
from comparisons.methods.user.external import add_methods, names_in
from comparisons.questions.single import SingleResult, solve_scene
from comparisons.scene.scene import Scene
from comparisons.solving.planning import Source
from reports.plots.curves import pressure_figure, solution_figure
from reports.tables import lists
from reports.tables.runs import load_steps, shown_columns
from reports.tables.written import frame
from roughline import notebook
from roughline.scenes import load_scene

if TYPE_CHECKING:
    import xarray

    from reports.paper.figures import PaperFigure

MOST_ROWS = 12


class Solution(SingleResult):
    """The answer of one method at one resolution; ``solution["force"]`` is an array over the loads.

    Attributes
    ----------
    plan : comparisons.solving.plan.Plan
    method : str
    resolution : int
        Springs, cells or elements per contact radius; points per side of a rough surface.
    solution : comparisons.tasks.solution.Solution
        As the method returned it.
    converged : bool
        Whether every load step has an answer; that no equilibrium exists, or many do, is one.
    reasons : list of str
        Why load steps have no values.
    """

    @property
    def scene(self) -> Scene:
        """The scene that was solved."""
        return self.plan.scene

    @property
    def seconds(self) -> float:
        """Time of the solve in seconds, on warm code, median of repeats."""
        return self.solution.seconds

    @property
    def unknowns(self) -> int:
        """Number of unknowns."""
        return self.solution.unknowns

    @property
    def quantities(self) -> list[str]:
        """Names of the quantities available as ``solution[name]``."""
        return list(self.columns())

    @property
    def pressure(self) -> dict[str, np.ndarray]:
        """Pressure at the last load: {r, p} for circular contacts, else {x, y, p}.

        InputError if there is none: it was not asked for, or the method does not compute it.
        """
        return self.pressures[max(self.pressures)]

    @property
    def pressures(self) -> dict[int, dict[str, np.ndarray]]:
        """Load step, from 0 -> pressure: of all steps, of more than eight of eight among them."""
        stored = self.stored_pressures()
        if not stored:
            asked = "pressure" in self.scene.compare.quantities
            lacking = f"{self.method} computes none here" if asked else "solve with fields=True"
            raise InputError(f"pressure: {lacking}")
        return stored

    def pressure_along(self, axis: Literal["x", "y"] = "x") -> pd.DataFrame:
        """Return the pressure at the last load along a line through the middle of the contact.

        Columns are the place ``x / m`` (or ``y / m``), increasing, and ``p / Pa``. Of a circular
        contact the radius to both sides; of cells the mean of the rows next to the line; of a mesh
        its points on the line. Cells on the rim of a flat face are left out if their middle is
        beyond it.

        InputError where `pressure` has one.

        Examples
        --------
        >>> line = solve("paraboloid", "closed_form", fields=True).pressure_along("x")
        >>> bool(abs(line["x / m"][line["p / Pa"].idxmax()]) < 1e-6)
        True
        """
        if axis not in ("x", "y"):
            raise InputError(f"axis: expected 'x' or 'y', got {axis!r}")
        field, indenter = self.pressure, self.scene.indenter
        if indenter is not None and indenter.flat:
            x = field["r" if "r" in field else "x"]
            y = field.get("y", np.zeros_like(x))
            within = 1 - 1e-9  # nodes of a mesh lie on the edge
            on_face = np.isfinite(indenter.gap(within * x, within * y))
            field = {name: values[on_face] for name, values in field.items()}
        if "r" in field:
            inside = field["r"] > 0
            place = np.concatenate([-field["r"][inside][::-1], field["r"]])
            p = np.concatenate([field["p"][inside][::-1], field["p"]])
        else:
            place, across = field[axis], field["y" if axis == "x" else "x"]
            # An indenter's axis is the origin, from which a rough patch begins.
            middle = 0.0 if across.min() < 0 else (across.min() + across.max()) / 2
            away = np.abs(across - middle)
            near = away <= away.min() + 1e-9 * np.ptp(across)
            place, p = place[near], field["p"][near]
        line = pd.DataFrame({f"{axis} / m": place, "p / Pa": p})
        return line.groupby(f"{axis} / m", as_index=False).mean()

    def table(self) -> pd.DataFrame:
        """Return one row per load step, in SI units."""
        return pd.DataFrame(self.columns()).rename_axis("step")

    def to_xarray(self) -> xarray.Dataset:
        """Return the answer as arrays with names and units (extra `xarray`).

        Every quantity over the dimension ``step``. Where fields were computed, the ``pressure`` of
        the loads of `pressures` (NaN at others): over ``x`` and ``y`` where its points are a grid
        that all loads share, else over ``point``, with the coordinates ``r``, or ``x`` and ``y``.

        InputError if xarray is not installed.
        """
        try:
            import xarray
        except ImportError as error:
            raise InputError("to_xarray needs xarray: pip install 'roughline[xarray]'") from error

        def described(name: str) -> dict[str, str]:
            row = quantity(name.removesuffix("_stderr"))
            words = f"{row.label}, standard error" if name.endswith("_stderr") else row.label
            return {"long_name": words, "units": row.unit or "1"}

        dataset = xarray.Dataset(
            {name: ("step", self[name], described(name)) for name in self.quantities},
            {"step": np.arange(len(self[self.quantities[0]]))},
            {"scene": self.scene.name, "method": self.method, "resolution": self.resolution},
        )
        stored = self.stored_pressures()
        if not stored:
            return dataset
        first, most = stored[min(stored)], max(field["p"].size for field in stored.values())
        of_points = {name: np.full((dataset.step.size, most), np.nan) for name in first}
        for step, field in stored.items():
            for name, values in field.items():
                of_points[name][step, : values.size] = values
        metres = {"units": "m"}
        shared = "x" in first and all(np.array_equal(f["x"], first["x"]) for f in stored.values())
        if shared:
            (x, i), (y, j) = (np.unique(first[axis], return_inverse=True) for axis in "xy")
            if x.size * y.size == most:
                grid = np.empty((dataset.step.size, x.size, y.size))
                grid[:, i, j] = of_points["p"]
                dataset = dataset.assign_coords(x=("x", x, metres), y=("y", y, metres))
                return dataset.assign(pressure=(("step", "x", "y"), grid, described("pressure")))
        over = "step", "point"
        places = {name: (over, of_points[name], metres) for name in first if name != "p"}
        dataset = dataset.assign_coords(places)
        return dataset.assign(pressure=(over, of_points["p"], described("pressure")))

    def plot(self, quantity: str | None = None) -> PaperFigure:
        """Return a quantity against load as a single-column figure (extra `paper`).

        Parameters
        ----------
        quantity : str, optional
            One of `quantities`; default: the first that the scene compares. "pressure" is drawn
            over the radius or the x axis, at the loads of `pressures`.
        """
        from reports.paper.figures import single

        if quantity == "pressure":
            return single(pressure_figure(self, self.pressures))
        if quantity is not None:
            self[quantity]  # an unknown one is told
        return single(solution_figure(self, quantity))

    @property
    def notes(self) -> tuple[str, ...]:
        """Notes of the plan; those that begin with "check the" question the scene."""
        return self.plan.notes

    def __repr__(self) -> str:
        steps = pd.DataFrame(self.curves()).rename_axis("step")
        table = steps[shown_columns(self)].to_string()
        return "\n".join([self._heading(), *self.plan.doubts, table])

    def _repr_html_(self) -> str:
        steps = load_steps(self)
        left = notebook.more(len(steps.rows) - MOST_ROWS, "load steps")
        return notebook.block(
            self._heading(),
            *self.plan.doubts,
            notebook.table(steps.first(MOST_ROWS)),
            left,
            *self.reasons,
        )

    def _heading(self) -> str:
        time = fmt.duration(self.seconds)
        return f"{self.scene.heading}: {self.method}, N = {self.resolution}, {time}"


def solve(
    scene: Source,
    method: str,
    resolution: int | None = None,
    *,
    fields: bool = False,
    **options: Any,
) -> Solution:
    """Solve a scene with one method.

    InputError if the scene, the method, an option or the resolution is invalid or not supported.

    Parameters
    ----------
    scene : Source
        Anything that `load_scene` takes.
    method : str
        One of `list_methods`.
    resolution : int, optional
        Springs, cells or elements per contact radius at the largest load; for rough surfaces,
        points per side. Default: chosen from the scene's tolerance.
    fields : bool
        Also compute pressure and the fields in the body at the last load.
    **options
        Options of the method: ``contact="penalty"``.

    Returns
    -------
    Solution
        Failed load steps raise no exception: they are NaN, with ``solution.reasons``.

    Examples
    --------
    >>> solution = solve("paraboloid", "reduced", 20)
    >>> solution["contact_radius"].shape == solution["force"].shape
    True
    """
    overrides = {f"methods.{method}.{key}": value for key, value in options.items()}
    found = solve_scene(load_scene(scene), method, resolution, overrides, with_fields=fields)
    return Solution(found.plan, found.method, found.resolution, found.solution)


def list_methods() -> pd.DataFrame:
    """Return all methods with their titles, and whether they solve a line or the 3-D contact.

    Examples
    --------
    >>> list_methods().loc["reduced", "solves"]
    'a line'
    """
    return frame(lists.methods()).set_index("name")


def add_method(method: type[Solver[Any]] | str | Path) -> list[str]:
    """Add your own method, to be tested like the built-in ones; return the names added.

    It runs also where a scene names others, but not beside those that a call names.

    InputError if the file or class does not define a method, or a built-in method has the same
    name.

    Parameters
    ----------
    method : class, str or Path
        The result of the decorator `method`, or a class derived from
        ``comparisons.methods.Solver``, known in this process only. Or a Python file with methods:
        each call then runs in a separate process with limits on time and memory, and is also
        available to the worker processes of a `Study`.

    Notes
    -----
    A user-supplied method never serves as the reference, whatever its dimension.
    """
    if not isinstance(method, (str, Path)):
        return [add_class(method)]
    add_methods([method])
    return names_in(method)
