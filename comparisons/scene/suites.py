"""Named sets of built-in scenes."""

from __future__ import annotations

SINGLE = (
    *("paraboloid", "sphere", "cone", "power-law-3", "power-law-4", "rounded-punch"),
    *("ellipsoid-2", "ellipsoid-5", "cylinder", "elliptic-punch", "square-punch"),
    "triangle-punch",
)
ROUGH = ("rough-patch", "rough-free", "rough-periodic", "measured-map")
# Scenes with friction, memory, sliding, rolling, films, adhesion, yield, wear, inertia, layers.
PHYSICS = (
    *("impact-ball", "impact-square", "impact-course", "pushed-ball"),
    *("rubber-ball", "rubber-again", "rubber-creep", "impact-rubber"),
    *("friction-rubber", "friction-steel", "friction-rough"),
    *("adhesive-ball", "adhesive-ball-range", "adhesive-punch"),
    *("sliding-ball", "sliding-rough", "rolling-ball", "rolling-rubber", "plastic-ball"),
    *("plastic-ellipsoid", "plastic-rough"),
    *("coated-ball", "layer-on-base", "graded-ball"),
    *("soft-ball-film", "wavy-ball-film", "squeezed-ball"),
    *("worn-ball", "worn-punch", "worn-rough", "fretting-ball"),
)
SUITES: dict[str, tuple[str, ...]] = {
    "quick": (*SINGLE, *ROUGH),
    "single": SINGLE,
    "rough": ROUGH,
    "physics": PHYSICS,
}
