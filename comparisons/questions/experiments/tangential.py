"""(19.18): k_x/k_z = 2(1 - nu)/(2 - nu) for every sticking contact."""

from __future__ import annotations

from typing import Annotated, Literal

import numpy as np
from scipy import stats

from comparisons.judging.uncertainty import RULE, combined, grid_uncertainty
from comparisons.questions.experiments.experiment import (
    Above,
    Finding,
    OneOf,
    experiment,
    number_of,
)
from comparisons.questions.experiments.proved import equal_area
from comparisons.solving.shared import shared
from reduced.friction.slide import stiffness_ratio
from reference import closed_form
from reference.contact.press import press
from reference.halfspace import areas
from reference.halfspace.friction import tangential_stiffness
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.loads import Load
from reference.surfaces import SelfAffine, self_affine, subdivide

SHAPES = ("ellipse", "rectangle", "triangle", "rough")
# Side of the grid in units of the contact half-width.
_SIDE = 2.1
# Faces whose normal stiffness is proved: their names and sides there.
_FACES = {"rectangle": ("rectangle", 4), "triangle": ("polygon", 3)}


@experiment(
    "tangential-stiffness",
    "Ratio of tangential to normal contact stiffness against the half-space",
    "poisson_ratio",
    "Poisson's ratio nu",
)
def ratio(
    effort: str,
    *,
    poisson_ratio: Annotated[float, Above(-1)] = 0.3,
    shape: Annotated[str, OneOf(*SHAPES)] = "ellipse",
    aspect: Annotated[float, Above(0)] = 1.0,
    direction: Literal["x", "y"] = "x",
    quantity: Literal["ratio", "stiffness"] = "ratio",
    realisations: Annotated[float, Above(1)] = 12,
) -> Finding:
    """Compare the stiffness of springs with that of the half-space without coupling.

    `aspect` is length along x over width. Quantities: the ``"ratio"`` k_x/k_z, both on the same
    cells, so that errors at cell edges cancel; or the ``"stiffness"`` k_x itself against G* D, D =
    (4A/pi)^(1/2), from the ratio and the proved bounds of k_z (rectangles and triangles). The bar
    follows from three grids; of rough contacts from two grids and the scatter of the surfaces.
    """
    along = (1.0, 0.0) if direction == "x" else (0.0, 1.0)
    if shape == "rough":
        # The contact is another on a finer grid of the same surface; of first order.
        count = number_of(realisations, effort, 4)
        means, scatter = [], 0.0
        for factor in (1, 2) if effort == "quick" else (1, 2, 4):
            found = [_rough_ratio(factor, k, poisson_ratio, along) for k in range(count)]
            means.append(float(np.mean(found)))
            scatter = float(stats.t.ppf(0.975, count - 1) * np.std(found, ddof=1) / np.sqrt(count))
        change = (RULE.safe if effort == "full" else RULE.two) * abs(means[-1] / means[-2] - 1)
        true, bar = means[-1], float(combined(change, scatter / means[-1]))
    else:
        resolutions = np.array([32, 64, 96] if effort == "quick" else [64, 96, 128])
        ratios = np.array(
            [_half_space(int(n), poisson_ratio, shape, aspect, along) for n in resolutions]
        )
        true, bar = float(ratios[-1]), float(grid_uncertainty(resolutions, ratios[:, None])[0])
    stated = stiffness_ratio(poisson_ratio)
    details: dict[str, float | str] = {
        "k_x/k_z of the springs": stated,
        "k_x/k_z of the half-space": true,
    }
    if shape == "ellipse":
        axes = (aspect, 1.0) if direction == "x" else (1.0, aspect)
        exact = closed_form.stiffness_ratio(*axes, poisson_ratio)
        details["k_x/k_z of the ellipse, exact"] = exact
    if quantity == "stiffness":
        if shape not in _FACES:
            raise ValueError(f"the normal stiffness is proved of {', '.join(_FACES)}, not {shape}")
        kind, sides = _FACES[shape]
        normal = equal_area(effort, shape=kind, sides=sides, aspect=aspect)
        details["error of the normal stiffness"] = normal.error
        stated, true = stated * normal.stated, true * normal.true
        bar += normal.uncertainty
    return Finding(stated, true, bar * (1 + abs(stated / true - 1)), details)


_ROUGH_POINTS = 48


@shared(maxsize=256)
def _rough_ratio(
    factor: int, realisation: int, poisson_ratio: float, along: tuple[float, float]
) -> float:
    """Return k_x/k_z of a rough contact on a grid `factor` times finer than its surface.

    Patches with H = 0.8, waves of 1/2 to 1/16 of their side, F = 0.05 E* A0 h'.
    """
    points = _ROUGH_POINTS * factor
    body = NormalAndTangential((points,) * 2, (1 / points,) * 2, Compliance.of(1.0, poisson_ratio))
    spectrum = SelfAffine(hurst=0.8, rms_slope=0.1, long_cutoff=1 / 2, short_cutoff=1 / 16)
    native = self_affine(_ROUGH_POINTS, 1.0, spectrum, seed=4, realisation=realisation)
    height = subdivide(native, factor)
    force = 0.05 * body.compliance.effective_modulus * 0.1
    mask = press(body.normal, height.max() - height, Load("force", force)).mask
    return tangential_stiffness(body, mask, along)[0] / areas.contact_stiffness(body.normal, mask)


def _half_space(
    points: int, poisson_ratio: float, shape: str, aspect: float, along: tuple[float, float]
) -> float:
    """Return k_x/k_z of a contact of half-length one, or half-width one if wider than long."""
    step = _SIDE / points
    body = NormalAndTangential((points,) * 2, (step,) * 2, Compliance.of(1.0, poisson_ratio))
    centres = (np.arange(points) - points / 2 + 0.5) * step
    x, y = np.meshgrid(centres, centres, indexing="ij")
    x, y = (x, y * aspect) if aspect >= 1 else (x / aspect, y)
    if shape == "ellipse":
        mask = np.hypot(x, y) < 1
    elif shape == "rectangle":
        mask = np.maximum(np.abs(x), np.abs(y)) < 1
    else:
        mask = (x > -0.5) & (x + np.sqrt(3) * np.abs(y) < 1)
    return tangential_stiffness(body, mask, along)[0] / areas.contact_stiffness(body.normal, mask)
