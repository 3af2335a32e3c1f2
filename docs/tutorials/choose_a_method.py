"""
Choose a method for a parameter study
=====================================

You want the force on ten thousand ellipsoidal contacts within 2 %. Which method, at which
resolution, and what will it cost? Measure it on one scene, find where the answer stops being true,
and only then run the study.
"""

# %%
# Measure one scene
# -----------------
# The tolerance is part of the question. ``cheapest`` is the fastest setting that is *sure* to be
# within it: its error plus the bar of the truth.
import time

import numpy as np

import roughline

scene = roughline.load_scene("ellipsoid-2")
comparison = roughline.compare(
    scene, "closed_form", "reduced", "bem_fft", tolerance=0.02, quantities=["force"]
)
comparison

# %%
# Both methods get there. The sentence names settings that were run, each with its measured time.
best = comparison.cheapest
print(comparison.answer)
print(f"cheapest: {best.method}, N = {best.resolution}")
assert best.method == "reduced"

# %%
# Down and left is better. Points beyond the horizontal line are not good enough, however fast.
comparison.plot("speed-force")

# %%
# Where does that stop being true?
# --------------------------------
# A choice that was measured on one scene holds for that scene. The parameter of the study is the
# ratio of the radii of curvature, so ask along it:
question = {
    "id": "gaussian-radius-two-per-cent",
    "text": "With the Gaussian radius the force on an ellipsoid comes out within 2 %.",
    "equation": "(5.30)",
    "scene": "ellipsoid-2",
    "vary": {
        "path": "indenter.radius_x",
        "name": "larger radius of curvature / m",
        "from": 0.01,
        "to": 0.1,
        "steps": 5,
        "spacing": "log",
    },
    "quantity": "force",
    "tolerance": 0.02,
    "refuted_by": "an error beyond 2 % at some radius",
}
limits = roughline.check_claim(question)
print(limits)
limits.plot()

# %%
# So the study is cut in two: the reduced model up to the limit, the half-space solver beyond.
(low, high), *_ = limits.ranges
smaller = scene.indenter.radius_y
print(f"reduced model up to R'/R'' = {high / smaller:.2f}")
assert limits.verdict == "holds in a range"

# %%
# The study
# ---------
# One solve per geometry, each with the resolution that was found. What it costs is what was
# measured, plus the overhead of describing each scene.
start = time.perf_counter()
forces = {}
for radius in np.geomspace(smaller, high, 10):
    contact = roughline.load_scene(scene, {"indenter.radius_x": float(radius)})
    forces[radius / smaller] = roughline.solve(contact, best.method, best.resolution)["force"][-1]
seconds = (time.perf_counter() - start) / len(forces)
for ratio, force in forces.items():
    print(f"R'/R'' = {ratio:.2f}: {force:8.1f} N")
print(f"{best.seconds * 1e6:.0f} us per solve, {seconds * 1e3:.0f} ms with its scene")

# %%
# The force grows with the square root of the Gaussian radius, as it should. Ten thousand contacts
# are a matter of minutes - and one of them is checked at the end of the range, where the model is
# at its worst:
last = roughline.load_scene(scene, {"indenter.radius_x": float(high)})
check = roughline.compare(last, "closed_form", "reduced", tolerance=0.02, quantities=["force"])
print(f"at the limit: {check.judged().error:.2%}, {check.verdict}")
assert check.verdict == "within"

# %%
# For hundreds of *rough* surfaces the same reasoning holds with realisations instead of geometries:
# ``roughline.Study(..., full=True, workers=2)`` keeps a folder, resumes after an interruption, and
# writes the report.
