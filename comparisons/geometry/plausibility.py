"""Plausibility of a scene: units, and the limits of linear contact mechanics.

`youngs_modulus = 210` means 210 Pa, and a reduced model that agrees with a 3-D solver to 1 % proves
nothing if the slopes are large, because both assume small slopes. A wrong unit of a map changes its
slope by a factor of a thousand without any error. The notes of the plan therefore question
implausible values, and state size and roughness; whoever has a plan shows them.
"""

from __future__ import annotations

import numpy as np
import scipy

from comparisons.formatting import count, number, relative, with_unit
from comparisons.geometry.prepare import (
    Geometry,
    IndenterGeometry,
    RoughGeometry,
    equivalent_profile,
    largest_contact,
)
from comparisons.reasons import CHECK, STEEP, STRAINED, THICKENED
from comparisons.scene.loading import AbsoluteLoads
from comparisons.scene.scene import Scene

# E* below the softest gels in indentation tests, and above diamond on diamond.
SOFTEST, STIFFEST = 1e3, 2e12
# Penetration over contact radius: a/R of a paraboloid, the mean slope of a body in the contact. At
# 0.3 a paraboloid differs from a ball by 2 % of the penetration, and strains are about 0.2 x 0.3.
STEEPEST = 0.3
# From here on the difference, (a/R)^2/3 of the penetration, can be told: 0.3 %.
LARGE = 0.1
# No elastic contact is deeper than wide.
DEEPEST = 2.0
# Wheels and tyres slip all over at a creep of 0.01 to 0.2; 1 is a locked wheel.
LARGEST_CREEP = 0.2
# 1/Pa. Metals without oil have k = K/H up to some 1e-11/Pa: K = 0.007 of mild steel on itself
# (Archard & Hirst 1956), H of some GPa. K is a plain number.
LARGEST_WEAR = 1e-9
# Under more pressure the viscosity of an oil is no constant: exp(alpha p) with alpha about 20/GPa.
THICKENS = 1e8
# Limits of measured surfaces; beyond them, a wrong unit or size is more likely.
SMALLEST_SIDE, LARGEST_SIDE = 1e-9, 1.0  # metres: a few atoms; larger than any profiler's stage
LEAST_SLOPE = 1e-6  # superpolished mirrors have about 1e-5
LARGEST_SLOPE = 1.0  # 45 degrees; the half-space itself holds for small slopes
LARGEST_ASPECT = 10.0  # aspect ratio of a cell: scan lines much farther apart than points
# Rms heights by which one spot, of this share of the map, stands above all others. Of a hundred
# normal summits the highest stands so high with a probability of exp(-2 sqrt(2 ln 100)), 0.2 %.
LONE, LONE_SHARE = 2.0, 0.01
# Standard deviations from which on a point is off its neighbours: a normal one once in 1e15.
SPIKE = 8.0


def scene_notes(scene: Scene, geometry: Geometry, loads: AbsoluteLoads) -> list[str]:
    """Return notes on doubtful units and large slopes in a scene."""
    doubts, slopes = [], []
    modulus = scene.effective_modulus
    if modulus < SOFTEST:
        doubts.append(
            f"E* = {with_unit(modulus, 'Pa')} is softer than any gel ({with_unit(SOFTEST, 'Pa')})"
        )
    elif modulus > STIFFEST:
        doubts.append(
            f"E* = {with_unit(modulus, 'Pa')} is stiffer than diamond ({with_unit(STIFFEST, 'Pa')})"
        )
    if scene.rolling is not None:
        creep = max(map(abs, (*scene.rolling.creep.values, *scene.rolling.lateral_creep.values)))
        if creep > LARGEST_CREEP:
            doubts.append(
                f"a creep of {number(creep)} is {relative(creep)} of the speed (wheels slip below "
                f"{relative(LARGEST_CREEP)}, at 100 % they are locked)"
            )
    if scene.wear is not None and scene.wear.coefficient > LARGEST_WEAR:
        doubts.append(
            f"a wear coefficient of {number(scene.wear.coefficient)}/Pa is more than "
            f"{number(LARGEST_WEAR, 1)}/Pa (dry metals have up to 10⁻¹¹/Pa; Archard's K, a plain "
            "number, is this times the hardness)"
        )
    if scene.plasticity is not None:
        slope, youngs = scene.plasticity.hardening, scene.half_space.elastic_constants[0]
        if slope > youngs:
            doubts.append(
                f"a hardening of {with_unit(slope, 'Pa')} is steeper than E = "
                f"{with_unit(youngs, 'Pa')} (metals harden by less than a tenth of it)"
            )
    if isinstance(geometry, IndenterGeometry) and geometry.contact_radius > 0:  # NaN: no contact
        depth, radius = geometry.penetration, geometry.contact_radius
        if scene.wear is not None:  # what is worn off strains nothing, and loads spread
            unworn = scene.model_copy(update={"wear": None})
            depth, radius = largest_contact(unworn, equivalent_profile(geometry.indenter), loads)
        steepness, ratio, checked = depth / radius, "d/a", STEEP
        means = f"penetration {with_unit(depth, 'm')} over contact radius"
        if scene.adhesion is not None:
            profile = equivalent_profile(geometry.indenter)
            # not so of a flat face, whose rim has no height
            opened = float(profile.height(np.array([radius]))[0]) if radius < profile.edge else 0.0
            if opened > depth:
                steepness, ratio = opened / radius, "g(a)/a"
                checked = f"{STEEP}, the work of adhesion"
                means = "the line's profile g at the contact radius over that radius,"
        if scene.lubrication is not None and loads.normal is not None:
            highest = 1.5 * float(loads.normal.values[-1]) / (np.pi * radius**2)
            if loads.normal.control == "force" and highest > THICKENS:
                slopes.append(
                    f"{THICKENED}under {with_unit(highest, 'Pa')} oil thickens by powers of "
                    "ten (Barus), and films between hard bodies are several times as thick; "
                    f"those here are of soft bodies, up to some {with_unit(THICKENS, 'Pa')}"
                )
        if steepness > LARGE:
            slopes.append(
                f"{STRAINED if steepness <= STEEPEST else f'{checked}: '}{ratio} = "
                f"{number(steepness)} (a/R of a paraboloid), {means} {with_unit(radius, 'm')}; "
                "every method here takes slopes and strains as small, and errors are against this "
                f"linear theory, not reality; it is an approximation from {ratio} = "
                f"{number(LARGE, 1)} on, and from {number(STEEPEST, 1)} on agreement says nothing"
            )
        if depth > DEEPEST * radius:
            doubts.append("the contact is deeper than wide")
    units = [f"{CHECK}units of the scene: {'; '.join(doubts)}"] if doubts else []
    return units + slopes


def surface_notes(geometry: RoughGeometry) -> list[str]:
    """Return a sentence on size and roughness of a surface, and a warning if implausible."""
    nx, ny = geometry.points
    size = " x ".join(_metres(side) for side in geometry.size)
    stated = (
        f"surface: {size}, {count(nx)} x {count(ny)} points, "
        f"rms height {_metres(geometry.rms_height)}, rms slope h' = {number(geometry.rms_slope)}"
    )
    doubts = []
    slope, sides = geometry.rms_slope, geometry.size
    if slope > LARGEST_SLOPE:
        limit = f"{number(LARGEST_SLOPE, 1)}, where every method here takes slopes as small"
        doubts.append(f"an rms slope of {number(slope)} is steeper than {limit}")
    elif slope < LEAST_SLOPE:
        doubts.append(f"an rms slope of {number(slope)} is less than {number(LEAST_SLOPE, 1)}")
    if min(sides) < SMALLEST_SIDE:
        doubts.append(f"a side of {_metres(min(sides))} is less than {_metres(SMALLEST_SIDE)}")
    if max(sides) > LARGEST_SIDE:
        doubts.append(f"a side of {_metres(max(sides))} is more than {_metres(LARGEST_SIDE)}")
    cells = [side / n for side, n in zip(sides, geometry.points, strict=True)]
    aspect = max(cells) / min(cells)
    if aspect > LARGEST_ASPECT:
        doubts.append(f"points are {number(aspect)} times farther apart along one side")
    notes = [stated]
    if doubts:
        notes.append(f"{CHECK}units and the size of the surface: {', '.join(doubts)}")
    heights = geometry.measured
    if heights is not None:  # a single spot far above all else: dust, or a lost point
        rise = LONE * geometry.rms_height
        spots, number_of_spots = scipy.ndimage.label(heights > heights.max() - rise)
        if number_of_spots == 1 and 0 < spots.mean() < LONE_SHARE:
            place = np.unravel_index(np.argmax(heights), heights.shape)
            steps = geometry.spacing(heights)
            at = (_metres(p * step) for p, step in zip(place, steps, strict=True))
            notes.append(
                f"{CHECK}highest point, at {' and '.join(at)} from the corner: it stands more than "
                f"{number(LONE, 1)} rms heights above all other spots (dust?), and light loads "
                "rest on it alone"
            )
        # spikes and pits: far off the median of their four neighbours, which one of these hardly
        # moves; the median deviation, too, and 1.4826 of it is a standard deviation
        wide = np.pad(heights, 1, mode="reflect")
        beside = wide[2:, 1:-1], wide[:-2, 1:-1], wide[1:-1, 2:], wide[1:-1, :-2]
        largest, least = np.maximum.reduce(beside), np.minimum.reduce(beside)
        above = heights - (sum(beside) - largest - least) / 2
        off = np.abs(above)
        usual = float(np.median(off))
        spikes = off > SPIKE * 1.4826 * usual
        if spikes.any() and usual > 0:
            up = np.count_nonzero(spikes & (above > 0))
            first = ", the highest of the map among them" if spikes.flat[heights.argmax()] else ""
            notes.append(
                f"far off their neighbours: {count(spikes.sum())} of the points ({count(up)} "
                f"upwards{first}), by up to {_metres(float(off.max()))} ({number(SPIKE, 1)} times "
                "as far as is usual, or more): spikes, or steps of the surface"
            )
    return notes


def _metres(length: float) -> str:
    return with_unit(length, "m")
