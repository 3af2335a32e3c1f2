"""The friction law (19.1) and Fig. 19.4 against the truth, both rooms together; their page."""

import re
from pathlib import Path

import numpy as np
import pytest

from comparisons.questions.experiments import coulomb
from comparisons.questions.experiments.coulomb import march
from reduced.motion.blocks import Blocks, integrate
from reduced.motion.course import Stepping
from reports.tables.written import markdown_rows

ROOT = Path(__file__).resolve().parents[3]


def block_of(name, page):
    page = (ROOT / "docs" / page).read_text(encoding="utf-8")
    (block,) = re.findall(f"<!-- table: {name} -->\n(.*?)\n<!-- end -->", page, re.DOTALL)
    return block


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "page"), [("stopping", "friction.md"), ("backbone", "rubber-and-impact.md")]
)
def test_the_tables_of_a_page_are_those_of_the_script(script, name, page):
    """Those without times or scatter are made anew and compared; the tests below are their law."""
    number = r"[-+]?\d+\.\d+(?:e[-+]\d+)?"
    block = block_of(name, page)
    anew = markdown_rows(script("friction_and_impact_tables").TABLES[name]())
    assert re.sub(number, "#", anew) == re.sub(number, "#", block)
    shown, result = ([float(x) for x in re.findall(number, t)] for t in (block, anew))
    np.testing.assert_allclose(shown, result, rtol=2e-3)


def test_implicit_euler_becomes_the_step_of_moreau_and_jean():
    """Three coupled blocks on a belt, v0 = 1e-13 of the speeds: the same numbers to 1e-6.

    The difference where a block just comes to rest goes as sqrt(v0).
    """
    K = np.array([[2.0, -1.0, 0.0], [-1.0, 2.0, -1.0], [0.0, -1.0, 1.0]])
    data = {"stiffness": K, "belt": 0.1, "load": [0.1, 0.0, -0.2], "damping": 0.05}
    args = ([1.0, 2.0, 1.0], [0.3, 0.5, 0.2])
    soft = integrate(Blocks(*args, **data), 1e-13, Stepping(0.01, 1000))
    hard = march(coulomb.Blocks(*args, **data), step=0.01, steps=1000, theta=1.0)
    np.testing.assert_allclose(soft.position, hard.position, atol=1e-6)
