"""The error table of docs/finite-elements.md: every shape, every Poisson ratio, with its order."""

import importlib.util
from pathlib import Path

import numpy as np
import pytest

SCRIPT = Path(__file__).resolve().parents[2] / "docs" / "examples" / "finite_element_tables.py"
# Largest error of the force at four and six elements per radius, and the least order from two
# elements on: a third of a decade above what is measured. Powers of the radius change the sign of
# their error below nu = 0.3, where an order would be an accident (0: not asked).
BOUNDS = {
    "cone": (2e-4, 6e-5, 0.0),
    "paraboloid": (2e-4, 3e-5, 3.5),
    "third power": (2e-4, 6e-5, 3.0),
    "fourth power": (4e-4, 1e-4, 2.5),
    "flat cylinder (stiffness)": (3e-3, 6e-4, 3.0),
    "rounded punch": (8e-4, 4e-4, 2.8),
    "ellipsoid, R'/R'' = 4": (3e-4, 5e-5, 3.5),
    "ellipsoid, R'/R'' = 25": (7e-4, 1.3e-4, 3.4),
}


@pytest.fixture(scope="module")
def tables():
    spec = importlib.util.spec_from_file_location("finite_element_tables", SCRIPT)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.slow
@pytest.mark.parametrize("nu", [0.0, 0.3, 0.49, 0.4999])
@pytest.mark.parametrize("shape", BOUNDS)
def test_errors_and_orders_of_every_shape(tables, shape, nu):
    errors = np.abs([tables.SHAPES[shape](n, nu) for n in (2, 4, 6)])
    coarse, fine, order = BOUNDS[shape]
    assert errors[1] < coarse
    assert errors[2] < fine
    # where both parts of the error have one sign; sharp edges have it at every ratio
    one_sign = nu >= 0.49 or "power" not in shape
    if order and one_sign and (nu >= 0.3 or shape != "paraboloid"):
        assert -np.polyfit(np.log([2, 4, 6]), np.log(errors), 1)[0] > order
