"""The quantities of every physics, in the order in which tables show them."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Literal, Protocol

import numpy as np

Curves = Mapping[str, np.ndarray]


class Contact(Protocol):
    """What derived quantities may depend on beside others: a scene."""

    @property
    def effective_modulus(self) -> float:
        """E* in Pa."""


@dataclass(frozen=True)
class Derived:
    """How a quantity follows by all known curves and the scene if no method has computed it."""

    of: tuple[str, ...]
    by: Callable[[Curves, Contact], np.ndarray]
    round_only: bool = False


@dataclass(frozen=True)
class Bins:
    """The bins of a distribution on all surfaces: equal steps of a value's logarithm."""

    scale: Literal["pressure", "height", "area"]  # E* h', the rms height, the nominal area A0
    low: float  # ends, in units of the scale; what lies beyond counts to the outer bins
    high: float

    @property
    def edges(self) -> np.ndarray:
        """Edges in units of the scale, 16 steps per decade."""
        decades = round(math.log10(self.high / self.low))
        return np.geomspace(self.low, self.high, 16 * decades + 1)


@dataclass(frozen=True)
class Quantity:
    """Facts about a quantity: a column of results.csv, or a measure of measures.csv.

    Beside a column ``force`` stand ``error_force`` and ``reference_uncertainty_force``, and
    ``stderr_force`` of an ensemble.
    """

    name: str
    label: str  # what it is called in text and on axes
    symbol: str = ""
    unit: str = ""  # base SI: "m", "m2", "N", "N/m", "J", "Pa", "s", "B" or "" for a pure number
    comparable: bool = True  # a scene may name it in ``compare.quantities``
    default: bool = False  # it is compared where an elastic scene names none
    physics: tuple[str, ...] = ()  # only scenes with one of these tables have it; else all
    load: Literal["", "normal", "tangential"] = ""  # it may be prescribed, as such a load
    counterpart: str = ""  # where it is prescribed: at which other load all is compared, too
    field: bool = False  # it is compared as a field at the last load, not as a curve
    norm: bool = False  # its error is the distance of two fields, which has no sign
    single: bool = False  # it is one value of a whole scene, the same at every step
    signed: bool = False  # it passes zero, so that relative changes of it mean nothing
    only: str = ""  # why who asks for it may ask in vain
    derived: Derived | None = None
    bins: Bins | None = None  # it is a distribution over a rough surface, in these bins

    def title(self, unit: str) -> str:
        """Return "label symbol / unit" for an axis.

        >>> Quantity("penetration", "penetration depth", "d", "m").title("µm")
        'penetration depth d / µm'
        """
        text = f"{self.label} {self.symbol}".strip()
        return f"{text} / {unit}" if unit else text


# Of the contact of an ellipsoid, which is an ellipse.
HALF_AXES = ("half_axis_x", "half_axis_y")
_ADHERES, _HITS, _LUBRICATED = ("adhesion",), ("dynamics",), ("lubrication",)
_ROLLS, _WEARS, _YIELDS = ("rolling",), ("wear",), ("plasticity",)
_BOUNDED = "unbounded at a sharp edge or tip"
_ELLIPTIC = "known for ellipsoids on uniform elastic half-spaces alone"
_UNIFORM = "known for uniform elastic half-spaces alone"
_STICKS, _DRAGS = ("friction",), ("friction", "sliding")


def _distribution(name: str, label: str, symbol: str, unit: str, bins: Bins) -> Quantity:
    return Quantity(name, label, symbol, unit, field=True, norm=True, bins=bins)


# What follows from other quantities.
_AREA = Derived(("equivalent_radius",), lambda k, _: np.pi * k["equivalent_radius"] ** 2)
_COUNTED = Derived(("contact_area",), lambda k, _: k["contact_area"])
_ROUND = Derived(("equivalent_radius",), lambda k, _: k["equivalent_radius"], round_only=True)
_RADIUS = Derived(("contact_area",), lambda k, _: np.sqrt(k["contact_area"] / np.pi))
_LENGTH = Derived(("stiffness",), lambda k, scene: k["stiffness"] / scene.effective_modulus)
_RATIO = Derived(
    ("tangential_stiffness", "stiffness"), lambda k, _: k["tangential_stiffness"] / k["stiffness"]
)
_MEAN = Derived(
    ("force", "contact_area"),
    lambda k, _: np.divide(
        *(k["force"], k["contact_area"]),
        out=np.zeros(k["force"].shape),
        where=k["contact_area"] > 0,
    ),
)

COMPUTED = (
    # Adhesion
    Quantity(
        "pull_off_force",
        "largest pull",  # the pull-off force, if the contact parts
        "F_off",
        "N",
        physics=_ADHERES,
        single=True,
    ),
    # Normal contact
    Quantity("force", "force", "F", "N", default=True, load="normal", counterpart="penetration"),
    Quantity(
        "penetration",
        "penetration depth",
        "d",
        "m",
        default=True,
        load="normal",
        counterpart="force",
    ),
    Quantity(
        "penetration_mean_plane", "penetration from the mean plane", "d_mean", "m", signed=True
    ),
    Quantity("contact_area", "contact area", "A", "m2", default=True, derived=_AREA),
    Quantity("contact_area_raw", "contact area, cells counted", "A_raw", "m2", derived=_COUNTED),
    Quantity("contact_radius", "contact radius", "a", "m", derived=_ROUND),
    Quantity("equivalent_radius", "equivalent radius", "√(A/π)", "m", derived=_RADIUS),
    *(
        Quantity(name, f"half-axis along {axis}", f"a_{axis}", "m", only=_ELLIPTIC)
        for name, axis in zip(HALF_AXES, "xy", strict=True)
    ),
    Quantity("stiffness", "contact stiffness", "k", "N/m"),
    Quantity("mean_gap", "mean gap", "ū", "m", load="normal", counterpart="force"),
    Quantity("contact_length", "contact length", "l", "m"),
    Quantity(
        "contact_length_stiffness", "contact length from stiffness", "k/E*", "m", derived=_LENGTH
    ),
    # What yields
    Quantity("pressure_mean", "mean pressure", "F/A", "Pa", derived=_MEAN),
    Quantity("pressure_peak", "peak pressure", "p_max", "Pa", only=_BOUNDED),
    *(
        Quantity(name, label, symbol, unit, only=f"{_BOUNDED}, {_UNIFORM}")
        for name, label, symbol, unit in (
            ("shear_max", "largest shear stress inside", "τ_max", "Pa"),
            ("shear_max_depth", "depth of the largest shear stress", "z_τ", "m"),
            ("von_mises_max", "largest von Mises stress inside", "σ_v", "Pa"),
            ("von_mises_depth", "depth of the largest von Mises stress", "z_v", "m"),
        )
    ),
    Quantity("contact_count", "number of contacts", "n"),
    Quantity("energy", "elastic energy", "U", "J"),
    # Number of contacts of a size
    _distribution(
        "contact_sizes",
        "areas of single contacts, distribution",
        "n(A)",
        "m2",
        bins=Bins("area", 1e-8, 1.0),
    ),
    # Friction and sliding
    Quantity("tangential_force", "tangential force", "Fₓ", "N", physics=_DRAGS, load="tangential"),
    Quantity(
        "tangential_displacement",
        "tangential displacement",
        "uₓ",
        "m",
        physics=_STICKS,
        load="tangential",
    ),
    Quantity("tangential_stiffness", "tangential stiffness", "kₓ", "N/m", physics=_STICKS),
    Quantity(
        *("stiffness_ratio", "tangential over normal stiffness", "kₓ/k"),
        physics=_STICKS,
        derived=_RATIO,
    ),
    Quantity("stick_area", "sticking area", "A_stick", "m2", physics=_STICKS),
    Quantity("friction_coefficient", "coefficient of friction", "µ", physics=_DRAGS),
    # Share of the surface that is open by a gap
    _distribution(
        "gap_distribution", "gap, distribution", "P(g)", "m", bins=Bins("height", 1e-6, 1e2)
    ),
    # Impact
    Quantity("restitution", "coefficient of restitution", "e", physics=_HITS),
    Quantity("contact_duration", "duration of contact", "T", "s", physics=_HITS),
    # Parameters of load steps other than loads, which are never compared
    Quantity("time", "time", "t", "s", comparable=False),
    Quantity("speed", "speed", "v", "m/s", comparable=False),
    Quantity("velocity", "velocity of impact", "v₀", "m/s", comparable=False),
    Quantity("sliding_distance", "sliding distance", "s", "m", comparable=False),
    Quantity("cycles", "cycles", "n", comparable=False),
    Quantity("step", "step of the path", comparable=False),
    # Lubrication
    Quantity("film_central", "central film thickness", "h_c", "m", physics=_LUBRICATED),
    Quantity("film_minimum", "minimum film thickness", "h_min", "m", physics=_LUBRICATED),
    Quantity("lubrication_force", "force of the film", "F_film", "N", physics=_LUBRICATED),
    Quantity("friction_force", "friction of the film", "F_fr", "N", physics=_LUBRICATED),
    # Plasticity
    Quantity("residual_depth", "depth that remains after unloading", "d_res", "m", physics=_YIELDS),
    Quantity("plastic_share", "share of the contact that yields", "A_p/A", physics=_YIELDS),
    Quantity("first_yield", "penetration at first yield", "d_y", "m", physics=_YIELDS, single=True),
    # Pressure at the last load
    Quantity("pressure", "contact pressure", "p", "Pa", field=True, norm=True),
    Quantity(
        "pressure_same_grid",
        "pressure against FFT BEM on the same grid",
        "p",
        "Pa",
        field=True,
        norm=True,
        comparable=False,
    ),
    Quantity(
        "pressure_integral", "integrated pressure", "∫p dA", "N", field=True, comparable=False
    ),
    # Share of the surface that carries a pressure
    _distribution(
        "pressure_distribution",
        "contact pressure, distribution",
        "P(p)",
        "Pa",
        bins=Bins("pressure", 1e-5, 1e2),
    ),
    # Rolling
    Quantity("traction", "utilised friction", "Fₓ/(µF)", physics=_ROLLS, signed=True),
    Quantity("lateral_force", "lateral force", "F_y", "N", physics=_ROLLS, signed=True),
    Quantity("creep", "creep", "ξ", signed=True, comparable=False),
    Quantity("lateral_creep", "lateral creep", "η", signed=True, comparable=False),
    # Wear
    Quantity("worn_volume", "worn volume", "V", "m3", physics=_WEARS),
    Quantity("wear_depth", "largest worn depth", "h_w", "m", physics=_WEARS),
)

# What theorems enclose, but where it is prescribed itself, and the columns of both sides.
ENCLOSED = ("force", "penetration", "stiffness", "energy")
SIDES = {"lower": "proved not below", "upper": "proved not above"}

ROWS = (
    *COMPUTED,
    *(
        Quantity(
            f"{row.name}_{side}", f"{row.label}, {meaning}", row.symbol, row.unit, comparable=False
        )
        for row in COMPUTED
        if row.name in ENCLOSED
        for side, meaning in SIDES.items()
    ),
)
