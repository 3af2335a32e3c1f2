"""The pressure field and its measures at the last load."""

from comparisons.facts.quantities.row import Quantity

ROWS = (
    Quantity("pressure", "contact pressure", "p", "Pa", comparable=True, field=True, norm=True),
    Quantity("pressure_peak", "peak pressure", "p_max", "Pa", field=True),
    Quantity(
        "pressure_same_grid",
        "pressure against FFT BEM on the same grid",
        "p",
        "Pa",
        field=True,
        norm=True,
    ),
    Quantity("pressure_integral", "integrated pressure", "∫p dA", "N", field=True),
)
