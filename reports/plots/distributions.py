"""Distributions over rough contacts: densities of pressure, gap and size of contacts."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.methods import METHODS
from comparisons.facts.quantities import DISTRIBUTIONS, quantity
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.plots.axes import log_axis, value_axis
from reports.plots.figure import Figure, Series
from reports.plots.style import DOTTED, MUTED, Look, drawing_order, look

# Power of the value that the density of a surface follows near zero, from p ~ s^(1/2) and
# gap ~ s^(3/2) at the distance s from the edge of a contact; on a line both are linear in s.
AT_ZERO = {"pressure_distribution": (1.0, "∝ p"), "gap_distribution": (-1 / 3, "∝ g^(−1/3)")}
# What stands along the axis: in words, with its symbol.
VALUES = {
    "pressure_distribution": ("contact pressure", "p"),
    "gap_distribution": ("gap", "g"),
    "contact_sizes": ("area of a contact", "A"),
}
_SHOWN = 1e-3  # of the highest share per decade: bins with less are left out
_GUIDE = 1.5  # decades that the law at zero is drawn over


def distributions(scene: SceneRecord) -> list[Figure]:
    """Return the density of each compared distribution at the last load, all methods together."""
    return [figure for name in DISTRIBUTIONS if (figure := _figure(scene, name))]


def _of(scene: SceneRecord) -> set[str]:
    table = scene.distributions
    return set(table["quantity"]) & set(scene.quantities) if "quantity" in table else set()


def _figure(scene: SceneRecord, name: str) -> Figure | None:
    table = scene.distributions
    if name not in _of(scene):
        return None
    rows = table[table["quantity"] == name]
    series: list[Series] = []
    solved: list[Series] = []
    for method in drawing_order(dict.fromkeys(rows["method"])):
        own = rows[rows["method"] == method].sort_values("low")
        middle, density = _density(*(selection.column(own, key) for key in _COLUMNS))
        if len(middle):
            series.append(Series(look(method, scene), middle, density, marks=False, hover=""))
            if METHODS[method].dimension == 3:
                solved.append(series[-1])
    if not series:
        return None
    series += _law(name, solved)
    x = np.concatenate([item.x for item in series])
    y = np.concatenate([item.y for item in series])
    limits = float(y.min()) / 1.5, float(y.max()) * 1.5
    row, (title, symbol) = quantity(name), VALUES[name]
    return Figure(
        f"distribution-{name}",
        f"{row.label[0].upper()}{row.label[1:]}",
        "Density at the last load, mean over surfaces or lines, normalised. Dotted: the law of "
        "surfaces near zero; on grids cells that the rim of a contact cuts hide it below."
        if name in AT_ZERO
        else "Density at the last load, mean over surfaces or lines, normalised.",
        replace(value_axis(name, x, log=True), quantity="", title=title, symbol=symbol),
        log_axis(f"density times the mean, {row.symbol} ⟨{symbol}⟩", limits, _tick),
        tuple(series),
        quantity=name,
    )


_COLUMNS = ("low", "high", "amount")


def _density(low: np.ndarray, high: np.ndarray, amount: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return middles of bins and the normalised density there times the mean value."""
    good = np.isfinite(low) & (low > 0) & (high > low) & (amount > 0)
    low, high, amount = low[good], high[good], amount[good]
    some = amount > _SHOWN * np.max(amount, initial=0.0)
    middle = np.sqrt(low * high)
    mean = float(np.sum(middle * amount) / np.sum(amount)) if len(amount) else 1.0
    density = amount / np.sum(amount) / (high - low) * mean if len(amount) else amount
    return middle[some], density[some]


def _law(name: str, curves: list[Series]) -> list[Series]:
    """Return the law near zero as a line through a surface's curve at a tenth of the mean."""
    if name not in AT_ZERO or not curves:
        return []
    power, text = AT_ZERO[name]
    curve = curves[-1]
    weight = curve.y * np.gradient(curve.x) if len(curve.x) > 1 else curve.y
    end = float(np.sum(curve.x * weight) / np.sum(weight)) / 10
    x = np.geomspace(end / 10**_GUIDE, end, 8)
    height = float(np.interp(end, curve.x, curve.y))
    return [Series(Look(text, MUTED, dash=DOTTED), x, height * (x / end) ** power, marks=False)]


def _tick(value: float) -> str:
    return fmt.number(value, 1)
