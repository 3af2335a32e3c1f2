"""Write docs/lammps-tests: six contacts with known forces, in the form of LAMMPS' test suite.

Its granular tests name the pair law, an analytic model and a tolerance. Here the values stand
beside them: overlap, force, and for `mdr` the contact area. Run from the repository's root (half a
minute)::

    python docs/examples/lammps_tests.py
"""

# %%
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import NamedTuple

import numpy as np

from comparisons.questions.experiments.yielding import known_to
from reduced.loads import LoadPath as SpringPath
from reduced.plasticity import ZunkerKamrin
from reference.closed_form import paraboloid
from reference.closed_form.adhesive import AdhesiveForm
from reference.elasticity import Material
from reference.loads import LoadPath
from reference.plastic import PlasticMaterial, Walk

FOLDER = Path(__file__).resolve().parents[1] / "lammps-tests"
# Balls of aluminium; MODULUS is that of a ball under a rigid flat, half a pair.
YOUNG, NU, RADIUS, YIELD_STRESS = 70e9, 0.3, 5e-3, 0.5e9
MODULUS = YOUNG / (1 - NU**2)
WORK = 0.2  # J/m^2
OVERLAPS = np.array([1e-6, 1e-5, 1e-4, 4e-4])
DENTS = np.array([2e-5, 4e-5, 8e-5, 2e-4])
GRIDS = (3, 6)
Rows = tuple[np.ndarray, ...]  # overlap, force, and of some the area


class Contact(NamedTuple):
    """A pair of balls under a law, what is exact about it and to what."""

    title: str
    diameters: tuple[float, float]
    law: str
    model: str
    tolerance: float
    rows: Callable[[], Rows]
    columns: str = "overlap/m force/N"


def hertz(radius: float) -> Rows:
    """Return Hertz's force of two balls with this common radius of curvature."""
    return OVERLAPS, paraboloid(radius, MODULUS / 2).force(OVERLAPS)


def jkr() -> Rows:
    """Return the force of JKR on the way in and out, to its minimum, the pull-off force."""
    form = AdhesiveForm(paraboloid(RADIUS / 2, MODULUS / 2), WORK)
    a_least = (9 * np.pi * (RADIUS / 2) ** 2 * WORK / (8 * MODULUS / 2)) ** (1 / 3)
    least = float(form.penetration(a_least))
    overlaps = np.array([1e-9, 1e-8, 5e-8, 1e-8, 1e-9, 0.0, 0.99 * least])
    return overlaps, form.follow("penetration", overlaps).force


def zunker_kamrin() -> Rows:
    """Return force and area of the springs of the paper; a ball has half the overlap."""
    law = ZunkerKamrin(RADIUS, MODULUS, YIELD_STRESS, sphere=True)
    line = law.walk(SpringPath("penetration", DENTS[:3] / 2))
    return DENTS[:3], line.force, np.pi * line.contact_radius**2


def elements() -> Rows:
    """Return force and area of finite elements that yield, and the bars of both."""
    steel = PlasticMaterial(Material(YOUNG, NU), YIELD_STRESS)
    rows = []
    for depth in map(float, DENTS / 2):
        found = []
        for grid in GRIDS:
            walk = Walk(
                steel,
                lambda r: r**2 / (2 * RADIUS),
                float(np.sqrt(1.7 * RADIUS * depth)),
                per_radius=grid,
            )
            (moment,) = walk.along(LoadPath("penetration", depth))
            found.append((moment.force, walk.contact_area(moment)))
        (f, a), (force, area) = found
        bars = known_to("force", GRIDS, (f, force)), known_to("area", GRIDS, (a, area))
        rows.append((2 * depth, force, area, *bars))
    return tuple(np.array(rows).T)


GRANULAR = "tangential linear_nohistory 0.0 0.0"
ELASTIC = f"hertz/material {YOUNG:g} 0.0 {NU:g} {GRANULAR} damping velocity"
EQUAL = (2 * RADIUS, 2 * RADIUS)
MDR = "mdr {0:g} {1:g} {2:g} 0.0 0.5 0.0 damping mdr 1 {3}"
PLASTIC = MDR.format(YOUNG, NU, YIELD_STRESS, GRANULAR)
AREA = "overlap/m force/N area/m2"
CONTACTS = {
    "hertz-equal": Contact(
        "Hertz, equal balls", EQUAL, ELASTIC, "Hertz 1882", 1e-9, lambda: hertz(RADIUS / 2)
    ),
    "hertz-unequal": Contact(
        "Hertz, balls of 5 and 10 mm radius",
        (2 * RADIUS, 4 * RADIUS),
        ELASTIC,
        "Hertz 1882",
        1e-9,
        lambda: hertz(RADIUS / 1.5),
    ),
    "jkr-in-and-out": Contact(
        "JKR, pressed and drawn off to the force minimum; the energy of the law is half the work",
        EQUAL,
        f"jkr {YOUNG:g} 0.0 {NU:g} {WORK / 2:g} {GRANULAR} damping velocity",
        "Johnson, Kendall & Roberts 1971; tolerance relative to the pull-off force",
        1e-7,
        jkr,
    ),
    "mdr-elastic": Contact(
        "mdr before it yields",
        EQUAL,
        MDR.format(YOUNG, NU, 100 * YIELD_STRESS, GRANULAR),
        "Hertz 1882; with the ellipse in place of the ball mdr lacks 0.0375 overlap/radius",
        4e-3,
        lambda: hertz(RADIUS / 2),
    ),
    "mdr-law": Contact(
        "mdr on loading, as its paper has it without the growth of the ball",
        EQUAL,
        PLASTIC,
        "Zunker & Kamrin 2024; steps below 2e-8 m",
        2e-3,
        zunker_kamrin,
        AREA,
    ),
    "mdr-elements": Contact(
        "A ball that yields (von Mises, perfectly plastic): what mdr is a model of",
        EQUAL,
        PLASTIC,
        "finite elements of a half-space below a rigid ball; bars of force and area beside them; "
        "mdr is known to miss them",
        0.03,
        elements,
        f"{AREA} +-force +-area",
    ),
}


def text(name: str) -> str:
    """Return the file of a contact."""
    contact = CONTACTS[name]
    first, second = contact.diameters
    return "\n".join(
        [
            "---",
            f"# {contact.title}.",
            f"# Computed by roughline: python docs/examples/lammps_tests.py, {name}.",
            "tags: granular",
            f"epsilon: {contact.tolerance:g}",
            "prerequisites: |",
            "  atom sphere",
            "  pair granular",
            "variables: |",
            f"  diam1 {first:g}",
            f"  diam2 {second:g}",
            "pair_style: granular",
            "pair_coeff: |",
            f"  * * {contact.law}",
            f"analytic_model: {contact.model}",
            f"analytic_tol: {contact.tolerance:g}",
            f"# {contact.columns}",
            "analytic_rows: |2",
            *("    " + line(row) for row in zip(*contact.rows(), strict=True)),
            "...",
            "",
        ]
    )


def line(row: Iterable[float]) -> str:
    """Return a row of numbers; ten digits, which other processors compute alike."""
    return " ".join(f"{value:.9e}" for value in row)


if __name__ == "__main__":
    for name in CONTACTS:
        (FOLDER / f"{name}.yaml").write_text(text(name), encoding="utf-8")
