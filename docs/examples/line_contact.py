"""Judge Kratos on Hertz's line contact: the table of Kratos in docs/other-codes.md.

A rigid parabolic cylinder on a block in plane strain: the pressure in the middle over Hertz's at
the same force, of Kratos and of the nine-node elements of `who_is_right.py` on the same block.
Kratos' interpreter is that of ``ROUGHLINE_PYTHON_KRATOS``. Run from the repository's root::

    python docs/examples/line_contact.py
"""

# %%
from typing import Any

import numpy as np
from numpy.typing import NDArray
from who_is_right import Answer, Section, growth, middle, refined, touch

from comparisons.judging.verdicts import judged
from comparisons.methods.peers.live import Code
from reference.fem.half_space_mesh import growing_lines

KRATOS = Code(
    "Kratos",
    {"KratosContactStructuralMechanicsApplication": "10.4.4", "KratosLinearSolversApplication": ""},
    "pip install KratosContactStructuralMechanicsApplication==10.4.4 "
    "KratosLinearSolversApplication==10.4.4",
)
# In half-widths of the contact: where the surface may touch, and the block.
REACH, BLOCK = 1.5, 40.0
POISSON, TOLERANCE = 0.3, 0.001
# Half-width over radius, elements per half-width, growth from one element beyond it to the next.
MESHES = [(strain, count, growth(count)) for strain in (1e-4, 0.03) for count in (6, 12, 24)]
MESHES[3:3] = [(1e-4, count, 2.0) for count in (6, 12, 24)]


def lines(count: int, more: float) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return lines across and below: even where it may touch, and one half-width deep."""
    wide, deep = (np.linspace(0, end, int(end * count) + 1) for end in (REACH, 1.0))
    return tuple(
        np.concatenate([even[:-1], growing_lines(even[-1], BLOCK, 1 / count, more)])
        for even in (wide, deep)
    )


def depth(radius: float) -> float:
    """Return a depth at which the half-width is about 1, of a plane that ends at the block's."""
    return float(2 * np.log(4 * BLOCK) - 1) / (4 * radius)


def hertz(force: float, radius: float) -> float:
    """Return the largest pressure of a line contact, (F E*/(pi R))^(1/2) (Johnson 1985, 4.45)."""
    return float(np.sqrt(force / ((1 - POISSON**2) * np.pi * radius)))


def ours() -> Answer:
    """Return the pressure over Hertz's on nine-node elements, at small strains, and its bar."""
    radius = 1e4

    def solve(count: int) -> dict[str, float]:
        x, z = lines(count, growth(count))
        held = {"axis": "x", "far": "xy", "back": "xy"}
        body = Section((x, z), lambda x, z: (x, -z), (1.0, POISSON), held)
        x, _, rows = body.touchable(REACH * (1 + 1e-9))
        gap = x**2 / (2 * radius) - depth(radius)
        forces = touch(body.under_units(rows)[rows], gap, 0 * rows, x < 1).normal
        ratio = middle(x, forces, 0.6, False) / hertz(2 * forces.sum(), radius)
        return {"pressure": ratio}

    return refined((8, 16), solve)["pressure"]


def theirs(strain: float, count: int, more: float) -> dict[str, Any]:
    """Return the answer of Kratos."""
    x, z = lines(count, more)
    radius = 1 / strain
    outcome = KRATOS.ask(
        {
            "x": x.tolist(),
            "depths": z.tolist(),
            "touching": int(REACH * count) + 1,
            "radius": radius,
            "penetration": depth(radius),
            "steps": 2,
            "poisson_ratio": POISSON,
        }
    )
    if not outcome.ok:
        raise RuntimeError(f"Kratos: {outcome.reason}")
    return outcome.answer | {"hertz": hertz(outcome.answer["force"], radius)}


if __name__ == "__main__":
    known = ours()
    print(f"Kratos {KRATOS.version()}; ours {known.value - 1:+.2%} ± {known.bar:.2%}")
    for strain, count, more in MESHES:
        found = theirs(strain, count, more)
        error = found["pressure"][0] / found["hertz"] / known.value - 1
        cells = [
            f"{strain:.4f}",
            f"{count}",
            f"{more:.2f}",
            f"{found['unknowns']}",
            f"{error:+.2%}",
        ]
        cells += [judged(error, known.bar, TOLERANCE).word, f"{found['seconds']:.2g} s"]
        print(f"| {' | '.join(cells)} |".replace("-", "\N{MINUS SIGN}"), flush=True)
