"""A shape that only the scene knows: each method that lacks its part says so."""

from typing import Literal

import numpy as np
import pytest

from comparisons.geometry.prepare import equivalent_profile, prepare
from comparisons.methods.adhesion import adhesive_form_of
from comparisons.methods.registry import solver_for
from comparisons.methods.solver import Refusal
from comparisons.scene.indenters.indenter import Indenter
from comparisons.scene.scene import SceneError, load_scene


class Wedge(Indenter):
    """f = slope |x|, cut off at |y| = length: nothing but what a scene asks for."""

    shape: Literal["blunt_wedge"] = "blunt_wedge"
    slope: float = 0.1
    length: float = 1e-3

    @property
    def axisymmetric(self):
        """No."""
        return False

    def gap(self, x, y):
        """Return slope |x|."""
        return np.where(np.abs(y) <= self.length, self.slope * np.abs(x), np.inf)

    def reach(self, penetration):
        """Return d / slope, and the length."""
        return penetration / self.slope, self.length


@pytest.fixture
def scene():
    # of a shape of one's own no theorem of this repository proves anything
    unproved = load_scene("paraboloid", {"compare.proved": False})
    return unproved.model_copy(update={"indenter": Wedge()})


@pytest.mark.parametrize(
    ("method", "reason"),
    [
        ("closed_form", "no closed form is known for a blunt wedge"),
        ("fem", "no mesh is fitted to the contact of a blunt wedge"),
    ],
)
def test_a_method_without_its_part_of_a_shape_refuses_the_scene(scene, method, reason):
    """Finite elements fit a mesh to the contact: that of a wedge is no circle, nor an ellipse."""
    refusal = solver_for(method, scene)
    assert isinstance(refusal, Refusal)
    assert reason in str(refusal)


def test_a_grid_needs_nothing_but_the_gap(scene):
    assert not isinstance(solver_for("bem_fft", scene), Refusal)


def test_a_shape_without_an_equivalent_profile_is_an_error_of_the_scene(scene):
    """Estimates of the contact come from the profile, and all grids and meshes from them."""
    with pytest.raises(ValueError, match="no equivalent profile is known for a blunt wedge"):
        equivalent_profile(scene.indenter)
    with pytest.raises(SceneError, match="no equivalent profile is known for a blunt wedge"):
        prepare(scene)


def test_a_shape_without_an_adhesive_solution_has_none():
    assert adhesive_form_of(Wedge(), 1.0, 1.0) is None
