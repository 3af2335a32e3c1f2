"""The calculation procedure of section 19.7, from a measured map to contact and stress."""

from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike

from reduced.loads import Load
from reduced.rough.ensemble import Ensemble, RandomLines, press_ensemble
from reduced.rough.line_spectrum import LineSpectrum, SumRules, line_of, sum_rules
from reduced.rough.regions import line_stress
from reduced.rough.surface_spectrum import SurfaceSpectrum


@dataclass(frozen=True)
class Variant:
    """A variant of the procedure, by rules of `line_of`, `press` and `line_stress`.

    `refinement` is the number of points of the line per point of the map's longer side.
    """

    name: str
    spectrum: str
    edges: str
    stress: str
    refinement: int


LITERAL = Variant("literal", "printed", "nodal", "own_curvature", 1)
"""As printed: ring averages with (19.26), nodal sums on the map's own spacing, (19.37) with R_i."""

CORRECTED = Variant("corrected", "rings", "sub_cell", "one_radius", 8)
"""Ring sums that conserve <h^2>, a resolved line with sub-cell edges, one radius per contact."""


@dataclass(frozen=True)
class Procedure:
    """Results of section 19.7 for one variant; k loads."""

    variant: Variant
    # steps 2 and 3: the spectrum of the map, the line's spectrum, sum rules
    surface: SurfaceSpectrum
    line: LineSpectrum
    sums: SumRules
    ensemble: Ensemble  # step 7: force, area, length, ... of all lines at all loads
    # distributions, one per load: lengths l_j of all contacts of all lines, and stresses at all
    # their contact points at which the rule has a real value
    contact_sizes: tuple[np.ndarray, ...]
    pressures: tuple[np.ndarray, ...]
    # (k,): fraction of contact points at which it has none; F/A as a mean over the lines
    undefined_share: np.ndarray
    mean_pressure: np.ndarray


def calculate(
    surface: SurfaceSpectrum,
    effective_modulus: float,
    force: ArrayLike,
    variant: Variant = CORRECTED,
    *,
    realisations: int = 100,
    seed: int = 0,
) -> Procedure:
    """Carry out steps 3-5 and 7 of section 19.7 on the spectrum of a prepared map (steps 1, 2).

    The spectrum of the map becomes that of a line of the map's longer side (19.26), lines are
    synthesised from it (19.24) and pressed on springs of stiffness E* dx (19.14) with the forces
    that the map carries; area (19.29), contact length, stress (19.37) and their distributions
    follow. A line of another length with the same nominal pressure gives another area.

    >>> from reduced.rough.surface_spectrum import measured
    >>> h = np.random.default_rng(0).normal(size=(16, 16))
    >>> result = calculate(measured(h, 1.0), 1.0, 0.1, realisations=3)
    >>> round(float(result.sums.ratio[0]), 12), float(result.undefined_share[0])
    (1.0, 0.0)
    """
    line = line_of(surface, variant.spectrum)
    modes = np.flatnonzero(line.power > 0)
    if modes.size == 0:
        raise ValueError("the map is flat: its spectrum has no power")
    # corner modes are beyond the map's Nyquist wavenumber
    points = max(variant.refinement * max(surface.power.shape), 2 * int(modes[-1] + 1) + 2)
    lines = RandomLines(line, points, realisations, seed)
    load = Load("force", force)
    ensemble = press_ensemble(lines, effective_modulus, load, edges=variant.edges)
    penetrations = ensemble.samples["penetration"]
    # contact lengths and stresses of all lines by load, and the points without a stress
    steps = penetrations.shape[1]
    sizes: list[list[np.ndarray]] = [[] for _ in range(steps)]
    pressures: list[list[np.ndarray]] = [[] for _ in range(steps)]
    valid, total = np.zeros(steps), np.zeros(steps)
    for k, depths in enumerate(penetrations):
        line_k = lines.draw([k])
        for step, depth in enumerate(depths):
            stress = line_stress(
                *(line_k, effective_modulus, depth), rule=variant.stress, edges=variant.edges
            )
            sizes[step].append(stress.regions.lengths)
            pressures[step].append(stress.pressure[stress.valid])
            valid[step] += np.count_nonzero(stress.valid)
            total[step] += stress.valid.size
    area = ensemble.samples["contact_area"]
    return Procedure(
        *(variant, surface, line, sum_rules(surface, line), ensemble),
        contact_sizes=tuple(map(np.concatenate, sizes)),
        pressures=tuple(map(np.concatenate, pressures)),
        undefined_share=1 - valid / total,
        mean_pressure=np.mean(ensemble.samples["force"] / area, axis=0),
    )


def side_by_side(
    surface: SurfaceSpectrum,
    effective_modulus: float,
    force: ArrayLike,
    *,
    realisations: int = 100,
    seed: int = 0,
) -> tuple[Procedure, Procedure]:
    """Return the results of `calculate` on the same map, as printed and as corrected."""
    both = {"realisations": realisations, "seed": seed}
    return (
        calculate(surface, effective_modulus, force, LITERAL, **both),
        calculate(surface, effective_modulus, force, CORRECTED, **both),
    )
