"""(19.18): k_x/k_z = 2(1 - nu)/(2 - nu) for every sticking contact."""

from __future__ import annotations

import numpy as np

from comparisons.judging.uncertainty import grid_uncertainty
from comparisons.questions.experiments.running import Finding, above, experiment, one_of
from reduced.friction.slide import stiffness_ratio
from reference import closed_form
from reference.halfspace import areas, fft
from reference.halfspace.cerruti import Compliance
from reference.halfspace.friction import tangential_stiffness
from reference.halfspace.solution import Press
from reference.halfspace.traction import NormalAndTangential
from reference.loads import Load
from reference.surfaces import SelfAffine, self_affine

SHAPES = ("ellipse", "rectangle", "triangle", "rough")
# Side of the grid in units of the contact half-width.
_SIDE = 2.1


def _ratio(
    effort: str,
    *,
    poisson_ratio: float = 0.3,
    shape: str = "ellipse",
    aspect: float = 1.0,
    direction: str = "x",
) -> Finding:
    """Compare the stiffness ratio of springs with that of the half-space without coupling.

    `aspect` is length along x over width. Both stiffnesses use the same cells, so that errors at
    cell edges cancel in the ratio. The bar follows from three grids.
    """
    one_of("shape", shape, *SHAPES)
    one_of("direction", direction, "x", "y")
    above("poisson_ratio", poisson_ratio, -1)
    above("aspect", aspect, 0)
    resolutions = np.array([32, 64, 96] if effort == "quick" else [64, 96, 128])
    true = np.array(
        [_half_space(int(n), poisson_ratio, shape, aspect, direction) for n in resolutions]
    )
    error = stiffness_ratio(poisson_ratio) / true - 1
    bar = float(grid_uncertainty(resolutions, true[:, None])[0]) * (1 + abs(float(error[-1])))
    details: dict[str, float | str] = {
        "k_x/k_z of the springs": stiffness_ratio(poisson_ratio),
        "k_x/k_z of the half-space": float(true[-1]),
    }
    if shape == "ellipse":
        axes = (aspect, 1.0) if direction == "x" else (1.0, aspect)
        exact = closed_form.stiffness_ratio(*axes, poisson_ratio)
        details["k_x/k_z of the ellipse, exact"] = exact
    return Finding(float(error[-1]), bar, details)


def _half_space(
    points: int, poisson_ratio: float, shape: str, aspect: float, direction: str
) -> float:
    """Return k_x/k_z of the contact on a grid of cells."""
    step = _SIDE / points
    body = NormalAndTangential((points,) * 2, (step,) * 2, Compliance.of(1.0, poisson_ratio))
    mask = _contact(body, shape, aspect)
    along = (1.0, 0.0) if direction == "x" else (0.0, 1.0)
    normal = areas.contact_stiffness(body.normal, mask)
    return tangential_stiffness(body, mask, along)[0] / normal


def _contact(body: NormalAndTangential, shape: str, aspect: float) -> np.ndarray:
    """Return the cells of a contact of half-length one, or half-width one if wider than long."""
    if shape == "rough":
        return _rough_contact(body)
    points, step = body.shape[0], body.spacing[0]
    centres = (np.arange(points) - points / 2 + 0.5) * step
    x, y = np.meshgrid(centres, centres, indexing="ij")
    x, y = (x, y * aspect) if aspect >= 1 else (x / aspect, y)
    if shape == "ellipse":
        return np.hypot(x, y) < 1
    if shape == "rectangle":
        return np.maximum(np.abs(x), np.abs(y)) < 1
    return (x > -0.5) & (x + np.sqrt(3) * np.abs(y) < 1)


def _rough_contact(body: NormalAndTangential) -> np.ndarray:
    """Return the contact of a rough patch (H = 0.8, waves 1/2 to 1/16 of it), F = 0.05 E* A0 h'."""
    height = self_affine(
        body.shape[0],
        _SIDE,
        SelfAffine(hurst=0.8, rms_slope=0.1, long_cutoff=_SIDE / 2, short_cutoff=_SIDE / 16),
        seed=4,
        realisation=0,
    )
    modulus = body.compliance.effective_modulus
    force = 0.05 * modulus * _SIDE**2 * 0.1
    return fft.solve(Press(body.normal, height.max() - height), Load("force", force)).mask


EXPERIMENTS = (
    experiment(
        "tangential-stiffness",
        "Ratio of tangential to normal contact stiffness against the half-space",
        "Poisson's ratio nu",
        "poisson_ratio",
        _ratio,
    ),
)
