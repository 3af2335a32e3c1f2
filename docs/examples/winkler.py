"""A Winkler foundation: what is left of contact mechanics without the half-space."""

import numpy as np

from comparisons.methods import method


def refuses(scene):
    """Return why a scene cannot be done, "" where it can."""
    modelled = scene.indenter is not None and scene.loading.control == "penetration"
    return "" if modelled else "indenters under prescribed penetration only"


@method("winkler", title="Winkler foundation", resolutions=(20, 40, 80), refuses=refuses)
def winkler(task, load, realisation):
    """Springs of stiffness E*/a per area under the undeformed surface."""
    # what the scene says: task.scene.indenter.radius, task.scene.half_space.youngs_modulus, ...
    a = task.geometry.contact_radius  # at the largest load: the springs' scale
    axis = (np.arange(-task.resolution, task.resolution) + 0.5) * 1.5 * a / task.resolution
    x, y = np.meshgrid(axis, axis)
    overlap = np.maximum(load - task.geometry.indenter.gap(x, y), 0)
    cell = (axis[1] - axis[0]) ** 2
    force = task.scene.effective_modulus / a * overlap.sum() * cell
    return {"force": force, "contact_area": (overlap > 0).sum() * cell}
