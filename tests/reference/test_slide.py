"""Tractions within friction bounds: `contact.slide` against sweeps, and where little is left.

Cattaneo, Carter, reversing paths and steady rolling stand in test_halfspace_friction and
test_rolling.
"""

import os
import subprocess
import sys

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from reference.contact.slide import slide
from reference.errors import ConvergenceError


class Dense:
    """A body by its matrix (2 n, 2 n)."""

    def __init__(self, matrix):
        self.matrix, self.own = matrix, float(matrix.diagonal().max())

    def shear(self, traction):
        return (self.matrix @ traction.ravel()).reshape(traction.shape)

    def near(self, slip):
        return slip / self.own


def random_body(rng, count, twisted):
    """Return a body of random eigenvalues over three decades, not symmetric by `twisted`."""
    turn = np.linalg.qr(rng.standard_normal((2 * count, 2 * count)))[0]
    matrix = turn @ np.diag(10.0 ** rng.uniform(-1.5, 1.5, 2 * count)) @ turn.T
    other = rng.standard_normal(matrix.shape)
    return Dense(matrix + twisted * (other - other.T))


def swept(body, bound, target):
    """Return the tractions by projected Gauss-Seidel, for symmetric bodies."""
    count = bound.size
    table = body.matrix.reshape(2, count, 2, count)
    q = np.zeros((2, count))
    for _ in range(200_000):
        before = q.copy()
        for i in range(count):
            own = table[:, i, :, i]
            tried = q[:, i] + (target - body.shear(q))[:, i] / np.linalg.norm(own, 2)
            q[:, i] = tried * min(1.0, bound[i] / max(np.hypot(*tried), 1e-300))
        if np.abs(q - before).max() <= 1e-12 * np.abs(q).max():
            break
    return q


def violation(body, bound, target, answer):
    """Return how far Coulomb's law is from holding, over the largest traction."""
    q, slip = answer.traction, target - body.shear(answer.traction)
    slip[0] += answer.shift
    tried = q + slip / body.own
    size = np.hypot(*tried)
    within = tried * np.minimum(1.0, bound / np.where(size > 0, size, 1.0))
    return np.abs(q - np.where(bound > 0, within, 0.0)).max() / np.hypot(*q).max()


@given(seed=st.integers(0, 10**6))
@settings(max_examples=20, deadline=None)
def test_tractions_are_those_of_sweeps_point_by_point(seed):
    rng = np.random.default_rng(seed)
    count = int(rng.integers(1, 6))
    body = random_body(rng, count, 0.0)
    bound, target = rng.uniform(0, 1, count), rng.standard_normal((2, count))
    answer = slide(body, bound, target, tolerance=1e-11)
    expected = swept(body, bound, target)
    assert np.abs(answer.traction - expected).max() < 1e-8 * np.abs(expected).max()


@pytest.mark.slow
@given(
    seed=st.integers(0, 10**6),
    twisted=st.sampled_from([0.0, 0.05]),
    scale=st.sampled_from([1e-200, 1e-6, 1.0, 1e6]),
    share=st.sampled_from([None, 0.0, 0.3, -0.99, 0.9999]),
)
@settings(max_examples=150, deadline=None)
def test_every_problem_is_solved(seed, twisted, scale, share):
    """Unsymmetric, targets of all sizes, empty and immovable points, totals to the last percent."""
    rng = np.random.default_rng(seed)
    count = int(rng.integers(2, 30))
    body = random_body(rng, count, twisted)
    bound = 10.0 ** rng.uniform(-3, 0, count) * (rng.random(count) < 0.8)
    bound[0] = 1.0
    if share is None and rng.random() < 0.3:
        bound[rng.random(count) < 0.3] = np.inf
    target = scale * rng.standard_normal((2, count))
    start = rng.standard_normal((2, count)) if rng.random() < 0.3 else None
    total = None if share is None else share * bound.sum()
    answer = slide(body, bound, target, total=total, start=start)
    q = answer.traction
    assert (np.hypot(*q) <= bound * (1 + 1e-12)).all()
    if total is not None:
        assert abs(q[0].sum() - total) <= 1e-8 * count * np.hypot(*q).max()
    if total != 0 or np.count_nonzero(bound) > 1:
        assert violation(body, bound, target, answer) < 1e-8


def test_what_asks_for_nothing_carries_nothing():
    """Without a target the start is forgotten, and a target on unloaded points is none."""
    body, bound = Dense(np.eye(4)), np.array([1.0, 0.0])
    for target in (np.zeros((2, 2)), np.array([[0.0, 1.0], [0.0, 0.0]])):
        answer = slide(body, bound, target, start=np.ones((2, 2)))
        assert not answer.traction.any()
        assert not answer.sliding.any()


def test_a_body_without_resistance_to_a_common_force_slides():
    """As a periodic grid in full contact, whose mean displacement is zero."""
    mean = np.full((5, 5), 1 / 5)
    body = Dense(np.kron(np.eye(2), np.eye(5) - mean))
    target = np.zeros((2, 5))
    target[1] = 0.1
    answer = slide(body, np.ones(5), target)
    assert np.allclose(answer.traction, [[0.0] * 5, [1.0] * 5])


def test_refusals():
    body, bound, target = Dense(np.eye(4)), np.array([1.0, 2.0]), np.ones((2, 2))
    with pytest.raises(ConvergenceError, match="a total of 3 is not below that of the bounds"):
        slide(body, bound, target, total=3.0)
    with pytest.raises(ConvergenceError, match=r"violated by .* after 2 rounds") as caught:
        slide(
            random_body(np.random.default_rng(0), 8, 0.0), np.ones(8), np.ones((2, 8)), max_rounds=2
        )
    assert len(caught.value.history) == 2
    with pytest.raises(ConvergenceError, match="violated by nan"):
        slide(body, bound, target * np.nan)


SHEARED = """
import time
import numpy as np
from reference.contact.slide import slide

class Springs:
    own = 1.0
    shear = near = staticmethod(lambda field: field + 0.2 * np.roll(field, 1, 1))

rng = np.random.default_rng(0)
bound, target = rng.uniform(0.5, 2.0, 50_000), rng.uniform(-1.0, 1.0, (2, 50_000))
time.sleep(0.5)  # threads of BLAS are busy for a while after they have started
every, own = time.process_time(), time.thread_time()
slide(Springs(), bound, target)
own = time.thread_time() - own
print(time.process_time() - every - own, own)
"""


@pytest.mark.slow
def test_scalar_products_wake_no_threads():
    """Two threads of BLAS took four times the processor's time; now the others' share is a tenth.

    (On 160 x 160 cells.)
    """
    environment = os.environ | {"OPENBLAS_NUM_THREADS": "2"}
    ran = subprocess.run(
        [sys.executable, "-c", SHEARED], env=environment, capture_output=True, text=True, check=True
    )
    others, own = map(float, ran.stdout.split())
    assert others < 0.1 * own
