"""Quantities of normal contact."""

import numpy as np

from comparisons.facts.quantities.row import Derived, Quantity

ROWS = (
    Quantity(
        "force",
        "force",
        "F",
        "N",
        comparable=True,
        default=True,
        load="normal",
        counterpart="penetration",
    ),
    Quantity(
        "penetration",
        "penetration depth",
        "d",
        "m",
        comparable=True,
        default=True,
        load="normal",
        counterpart="force",
    ),
    Quantity(
        "penetration_mean_plane",
        "penetration from the mean plane",
        "d_mean",
        "m",
        comparable=True,
        signed=True,
    ),
    Quantity(
        "contact_area",
        "contact area",
        "A",
        "m2",
        comparable=True,
        default=True,
        derived=Derived("equivalent_radius", lambda k, _: np.pi * k["equivalent_radius"] ** 2),
    ),
    Quantity(
        "contact_area_raw",
        "contact area, cells counted",
        "A_raw",
        "m2",
        comparable=True,
        derived=Derived("contact_area", lambda k, _: k["contact_area"]),
    ),
    Quantity(
        "contact_radius",
        "contact radius",
        "a",
        "m",
        comparable=True,
        derived=Derived("equivalent_radius", lambda k, _: k["equivalent_radius"], round_only=True),
    ),
    Quantity(
        "equivalent_radius",
        "equivalent radius",
        "√(A/π)",
        "m",
        comparable=True,
        derived=Derived("contact_area", lambda k, _: np.sqrt(k["contact_area"] / np.pi)),
    ),
    Quantity("stiffness", "contact stiffness", "k", "N/m", comparable=True),
    Quantity("mean_gap", "mean gap", "ū", "m", comparable=True, load="normal", counterpart="force"),
    Quantity("contact_length", "contact length", "l", "m", comparable=True),
    Quantity(
        "contact_length_stiffness",
        "contact length from stiffness",
        "k/E*",
        "m",
        comparable=True,
        derived=Derived("stiffness", lambda k, scene: k["stiffness"] / scene.effective_modulus),
    ),
    Quantity("contact_count", "number of contacts", "n", comparable=True),
    Quantity("energy", "elastic energy", "U", "J", comparable=True),
)
