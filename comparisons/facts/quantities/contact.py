"""Quantities of every contact that is pressed."""

import numpy as np

from comparisons.facts.quantities.row import Derived, Quantity

ROWS = (
    Quantity(
        "force",
        "force",
        "F",
        "N",
        asked=True,
        default=True,
        load="normal",
        counterpart="penetration",
    ),
    Quantity(
        "penetration",
        "penetration depth",
        "d",
        "m",
        asked=True,
        default=True,
        load="normal",
        counterpart="force",
    ),
    Quantity(
        "penetration_mean_plane",
        "penetration from the mean plane",
        "d_mean",
        "m",
        asked=True,
        signed=True,
    ),
    Quantity(
        "contact_area",
        "contact area",
        "A",
        "m2",
        asked=True,
        default=True,
        derived=Derived("equivalent_radius", lambda k, _: np.pi * k["equivalent_radius"] ** 2),
    ),
    Quantity(
        "contact_area_raw",
        "contact area, cells counted",
        "A_raw",
        "m2",
        asked=True,
        derived=Derived("contact_area", lambda k, _: k["contact_area"]),
    ),
    Quantity(
        "contact_radius",
        "contact radius",
        "a",
        "m",
        asked=True,
        derived=Derived("equivalent_radius", lambda k, _: k["equivalent_radius"], round_only=True),
    ),
    Quantity(
        "equivalent_radius",
        "equivalent radius",
        "√(A/π)",
        "m",
        asked=True,
        derived=Derived("contact_area", lambda k, _: np.sqrt(k["contact_area"] / np.pi)),
    ),
    Quantity("stiffness", "contact stiffness", "k", "N/m", asked=True),
    Quantity("mean_gap", "mean gap", "ū", "m", asked=True, load="normal", counterpart="force"),
    Quantity("contact_length", "contact length", "l", "m", asked=True),
    Quantity(
        "contact_length_stiffness",
        "contact length from stiffness",
        "k/E*",
        "m",
        asked=True,
        derived=Derived("stiffness", lambda k, scene: k["stiffness"] / scene.effective_modulus),
    ),
    Quantity("contact_count", "number of contacts", "n", asked=True),
    Quantity("energy", "elastic energy", "U", "J", asked=True),
)
