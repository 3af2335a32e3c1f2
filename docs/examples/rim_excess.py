"""Measure how far outside Hertz's circle the law of `areas.located_area` puts the rim, by operator.

Run from the repository's root (two minutes); prints the means, in cells, that `rim_excess` of the
operators keeps, and what is left with it::

    python docs/examples/rim_excess.py
"""

# %%
from collections.abc import Callable, Iterator

import numpy as np

from reference.contact.body import ElasticBody
from reference.contact.press import press
from reference.fem import Material
from reference.fem.columns import ELEMENTS
from reference.fem.grid_body import FreeBody
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.halfspace.areas import located_area
from reference.loads import Load

CONTACTS, RADII, SPARE = 40, (4.0, 14.0), 8
# Beside images so far away the radius is Hertz's to 1e-4.
PERIOD = 256


# %%
def operators() -> Iterator[tuple[str, int, Callable[[int], ElasticBody]]]:
    """Yield names, a period (0: free) and what makes an operator of so many cells a side."""
    sides = (1.0, 1.0)
    yield "Love", 0, lambda n: FreeOperator((n, n), sides, 1.0)
    for kernel in ("cells", "continuum"):
        yield kernel, PERIOD, lambda n, k=kernel: PeriodicOperator((n, n), sides, 1.0, kernel=k)
    for element in ELEMENTS:
        for nu in (0.0, 0.15, 0.3, 0.4, 0.5):
            body = Material(1 - nu**2, nu)
            name = f"{element}, nu = {nu}"
            yield name, 0, lambda n, b=body, e=element: FreeBody((n, n), sides, b, e)


def excess(make: Callable[[int], ElasticBody], period: int) -> tuple[float, float]:
    """Return mean and standard error of the area above Hertz's, over the perimeter, in cells."""
    rng = np.random.default_rng(11)
    errors = []
    for _ in range(CONTACTS):
        radius = rng.uniform(*RADII)
        count = period or int(2 * radius) + SPARE
        x, y = (np.arange(count) - (count - 1) / 2 + rng.uniform(-0.5, 0.5) for _ in range(2))
        gap = (x[:, None] ** 2 + y**2) / 200
        load = Load("force", 4 / 3 * radius**3 / 100)
        contact = press(make(count), gap - gap.min(), load)
        errors.append((located_area(contact) - np.pi * radius**2) / (2 * np.pi * radius))
    return float(np.mean(errors)), float(np.std(errors) / np.sqrt(CONTACTS))


# %%
if __name__ == "__main__":
    for name, period, make in operators():
        left, error = excess(make, period)
        known = make(4).rim_excess
        kept = f"left beside {known:+.4f}: {left:+.4f}"
        print(f"{name:22s} {left + known:+.4f} +- {error:.4f}; {kept}")
