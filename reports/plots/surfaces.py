"""What rough surfaces are made of, and how pressure, gap and contacts are distributed over them."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from comparisons import formatting as fmt
from comparisons.facts.quantities import DISTRIBUTIONS, quantity
from comparisons.results.record import SceneRecord
from reports.plots.axes import log_axis, log_ticks, one_digit, padded, value_axis
from reports.plots.figure import Axis, Figure, Series
from reports.plots.stored import at_last_load
from reports.plots.style import DOTTED, INK, MUTED, Look, drawing_order, look

# What stands along the axis of a distribution: in words, with its symbol.
VALUES = {
    "pressure_distribution": ("contact pressure", "p"),
    "gap_distribution": ("gap", "g"),
    "contact_sizes": ("area of a contact", "A"),
}
# Power of the value that the density of a surface follows near zero, from p ~ s^(1/2) and
# gap ~ s^(3/2) at the distance s from the edge of a contact; on a line both are linear in s.
AT_ZERO = {"pressure_distribution": (1.0, "∝ p"), "gap_distribution": (-1 / 3, "∝ g^(−1/3)")}
LEAST_SHARE = 1e-3  # of the highest share per decade: bins with less are left out
LAW_DECADES = 1.5  # that the law at zero is drawn over


def roughness(scene: SceneRecord) -> list[Figure]:
    """Return the radial spectrum of the surface and its statistics; nothing for indenters."""
    stored = scene.plan.roughness
    if stored is None or len(stored.wavenumber) < 2:
        return []
    wavenumber, density = np.array(stored.wavenumber), np.array(stored.density)
    longest, shortest = (fmt.with_unit(2 * np.pi / wavenumber[end], "m") for end in (0, -1))
    curvature = fmt.prefix_for(1 / stored.rms_curvature, "m")
    radius = fmt.number(curvature.factor / stored.rms_curvature)
    heights = (
        f"; heights with skewness {fmt.number(stored.skewness, 2)} and kurtosis "
        f"{fmt.number(stored.kurtosis, 2)} (Gaussian: 0 and 3)"
        if stored.skewness is not None
        else ""
    )
    caption = (
        f"Mean of C2D over circles (19.23), waves from {longest} to {shortest}. "
        f"Rms height {fmt.with_unit(stored.rms_height, 'm')}, "
        f"rms slope h' = {fmt.number(stored.rms_slope)}, rms curvature 1/({radius} "
        f"{curvature.unit}), Nayak's parameter {fmt.number(stored.nayak)}{heights}."
    )
    scale = fmt.Scale(1e-6, "1/µm")
    limits, spectrum = padded(wavenumber, 0.05, 0.2), Look("C2D", INK, size=5)
    ticks = log_ticks(limits, one_digit, factor=scale.factor)
    return [
        Figure(
            "roughness-spectrum",
            "Power spectrum of the surface",
            caption,
            Axis("wavenumber", "q", scale=scale, log=True, limits=limits, ticks=ticks),
            log_axis("spectrum C2D / m⁴", padded(density, 0.05, 0.2), most=6),
            (Series(spectrum, wavenumber, density, hover=spectrum.label, width=1.0),),
            legend=False,
        )
    ]


def distributions(scene: SceneRecord) -> list[Figure]:
    """Return the density of each compared distribution at the last load, all methods together."""
    table = scene.distributions
    figures = []
    for name in DISTRIBUTIONS:
        rows = table.where(table["quantity"] == name)
        if name not in scene.quantities or not len(rows):
            continue
        series: list[Series] = []
        solved: list[Series] = []
        for method in drawing_order(dict.fromkeys(rows["method"])):
            own = rows.where(rows["method"] == method)
            own = own.where(np.argsort(own["low"], kind="stable"))
            low, high, amount = (own[key] for key in ("low", "high", "amount"))
            good = np.isfinite(low) & (low > 0) & (high > low) & (amount > 0)
            if not good.any():
                continue
            low, high, amount = low[good], high[good], amount[good]
            middle = np.sqrt(low * high)
            mean = float(np.sum(middle * amount) / np.sum(amount))
            density = amount / np.sum(amount) / (high - low) * mean
            some = amount > LEAST_SHARE * np.max(amount)
            at = middle[some], density[some]
            series.append(Series(look(method, scene), *at, marks=False, hover=""))
            if scene.dimension_of(method) == 3:
                solved.append(series[-1])
        if not series:
            continue
        if name in AT_ZERO and solved:
            # The law near zero, through a surface's curve at a tenth of its mean.
            curve, (power, text) = solved[-1], AT_ZERO[name]
            weight = curve.y * np.gradient(curve.x) if len(curve.x) > 1 else curve.y
            end = float(np.sum(curve.x * weight) / np.sum(weight)) / 10
            x = np.geomspace(end / 10**LAW_DECADES, end, 8)
            y = float(np.interp(end, curve.x, curve.y)) * (x / end) ** power
            series.append(Series(Look(text, MUTED, dash=DOTTED), x, y, marks=False))
        x, y = (np.concatenate([getattr(item, axis) for item in series]) for axis in "xy")
        limits = float(y.min()) / 1.5, float(y.max()) * 1.5
        row, (title, symbol) = quantity(name), VALUES[name]
        law = (
            " Dotted: the law of surfaces near zero; on grids cells that the rim of a contact cuts "
            "hide it below."
        )
        figures.append(
            Figure(
                f"distribution-{name}",
                fmt.capitalised(row.label),
                f"Density{at_last_load(scene)}, mean over surfaces or lines, normalised."
                + law * (name in AT_ZERO),
                replace(value_axis(name, x, log=True), quantity="", title=title, symbol=symbol),
                log_axis(f"density times the mean, {row.symbol} ⟨{symbol}⟩", limits),
                tuple(series),
                quantity=name,
            )
        )
    return figures
