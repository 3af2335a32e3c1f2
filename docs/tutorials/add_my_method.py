"""
Add my method
=============

You have a contact model of your own. This tutorial has it judged by the same scenes, truths and
claims as the built-in methods, without changing a line of roughline.
"""

# %%
# A method is a function
# ----------------------
# It is called for every load and returns quantities in SI units. This one is a Winkler foundation:
# springs of stiffness E*/a per area under the undeformed surface, the oldest shortcut of all.
import numpy as np

import roughline


def refuses(scene):
    """Return why a scene cannot be done, "" where it can."""
    modelled = scene.indenter is not None and scene.loading.control == "penetration"
    return "" if modelled else "indenters under prescribed penetration only"


@roughline.method("winkler", title="Winkler foundation", resolutions=(20, 40, 80), refuses=refuses)
def winkler(task, load, realisation):
    """Springs of stiffness E*/a per area under the undeformed surface."""
    # what the scene says: task.scene.indenter.radius, task.scene.half_space.youngs_modulus, ...
    a = task.geometry.contact_radius  # at the largest load
    axis = (np.arange(-task.resolution, task.resolution) + 0.5) * 1.5 * a / task.resolution
    x, y = np.meshgrid(axis, axis)
    overlap = np.maximum(load - task.geometry.indenter.gap(x, y), 0)
    cell = (axis[1] - axis[0]) ** 2
    force = task.scene.effective_modulus / a * overlap.sum() * cell
    return {"force": force, "contact_area": (overlap > 0).sum() * cell}


roughline.add_method(winkler)

# %%
# Run the cell again after a change: the new definition replaces the old one.
#
# One scene
# ---------
# Three resolutions of the method, the exact solution as the truth, and the reduced model beside it.
comparison = roughline.compare(
    "paraboloid", "closed_form", "reduced", "winkler", quantities=["force", "contact_area"]
)
comparison

# %%
# The steps tell what is wrong. The area is twice the true one at every load: 2 pi R d, the
# geometric overlap, instead of pi R d, because the surface of an elastic body sinks beside the
# contact, too. The force grows as d^2 instead of d^1.5: too small at the lightest load, too large
# at the heaviest. Refinement changes nothing; it is the model's own error and not its
# discretisation's.
steps = comparison.steps().query("method == 'winkler' and resolution == 80")
print(steps[["penetration", "error_force", "error_contact_area"]].to_string(index=False))
assert abs(steps["error_contact_area"] - 1).max() < 0.02
assert steps["error_force"].iloc[0] < -0.4 < 1.3 < steps["error_force"].iloc[-1]
assert comparison.verdict == "within"  # the reduced model
assert comparison.judged("winkler").word == "outside"

# %%
# The plot shows the same at a glance: the method's line does not go down with its cost.
comparison.plot("speed-force")

# %%
# A claim
# -------
# Every claim that stands on a scene can be about your method: does it at least get an ellipsoid's
# force within the tolerance?
judged = roughline.check_claim("ellipsoid-force", method="winkler", full=False)
print(judged)
assert judged.verdict == "fails"

# %%
# In a file
# ---------
# Saved as ``winkler.py`` the method goes everywhere, in a process of its own with limits on time
# and memory: ``roughline.add_method("winkler.py")`` here, and on the command line
#
# .. code-block:: bash
#
#    roughline run paraboloid --method-file winkler.py
#    roughline hard-cases winkler --method-file winkler.py
#    roughline claims --method winkler --method-file winkler.py
#
# Nothing that it does can harm the study: a method that hangs, raises or returns nonsense loses its
# own rows, with the reason. And it never becomes the truth, whatever it says about itself.
