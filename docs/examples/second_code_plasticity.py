"""Make the table of docs/plasticity.md, "Finite elements": the same dent by NGSolve's elements.

Triangles of third order of NGSolve's mesh in a quarter disc whose far side is held, full
integration, NGSolve's derivatives of the potential of a step, contact as a penalty: nothing but the
equations is shared with `reference.plastic`. Run from the repository's root with NGSolve
(`pip install 'roughline[peers]'`; two minutes on one core)::

    python docs/examples/second_code_plasticity.py
"""

# %%
from importlib.util import find_spec
from pathlib import Path
from typing import Any

import numpy as np

from reference.elasticity import Material
from reference.loads import LoadPath
from reference.plastic import PlasticMaterial, Walk
from reports.tables.written import rewrite

HERE = find_spec("ngsolve") is not None
if HERE:
    import ngsolve as ngs
    from netgen.occ import Circle, Glue, MoveTo, OCCGeometry
    from ngsolve.comp import IntegrationRuleSpace

PAGE = Path(__file__).resolve().parents[1] / "plasticity.md"
# R = E = 1
NU, YIELD_STRESS = 0.3, 1 / 500
SHEAR, BULK, MODULUS = 0.5 / (1 + NU), 1 / (3 * (1 - 2 * NU)), 1 / (1 - NU**2)
DEPTH = (np.pi * 1.6 * YIELD_STRESS / (2 * MODULUS)) ** 2
FORCE = 4 / 3 * MODULUS * DEPTH**1.5
SHARES = (5, 20)
# In contact radii: elements on the surface and below the contact, where they begin to grow, the
# held side (its displacement is 6e-4 of the penetration), and the stiffness of the penalty in E*.
ON_TOP, BELOW, FINE, FAR, PENALTY = 1 / 24, 1 / 6, 1.5, 1000.0, 1000.0
ORDER = 3
# Of the logarithm of the load, at its end; before it as `reference.plastic.indentation` has it.
STEP, FIRST = 0.03, 1 / 32
ROUNDS, SETTLED = 40, 1e-12


def radius_at(share: float) -> float:
    """Return the contact radius, roughly."""
    return float(np.sqrt(share * DEPTH * min(2.0, 1 + 0.25 * np.log10(share) ** 1.2)))


def section() -> Any:
    """Return a mesh of the half-section r, z >= 0 in contact radii."""
    whole = MoveTo(0, 0).Rectangle(FAR, FAR).Face()
    fine = Circle((0, 0), FINE).Face() * whole
    fine.maxh = BELOW
    shape = Glue([fine, Circle((0, 0), FAR).Face() * whole - fine])
    for edge in shape.edges:
        at = edge.center
        if abs(at.x) < 1e-9:
            edge.name = "axis"
        elif abs(at.y) < 1e-9:
            edge.name = "top" if at.x < FINE else "free"
            edge.maxh = ON_TOP if at.x < FINE else FAR
        else:
            edge.name = "far" if np.hypot(at.x, at.y) > FAR / 2 else "inside"
    return ngs.Mesh(OCCGeometry(shape, dim=2).GenerateMesh(maxh=FAR / 4, grading=0.4))


# %% [markdown]
# A step minimises the potential of stress and flow: below the yield stress that of the trial
# stress, beyond it its Moreau envelope, whose gradient is the radial return.


# %%
class Ball:
    """NGSolve's ball at a depth in d_y."""

    def __init__(self, share: float) -> None:
        self.unit = radius_at(share)
        self.mesh = section()
        space = ngs.VectorH1(self.mesh, order=ORDER, dirichletx="axis|far", dirichlety="far")
        points = IntegrationRuleSpace(self.mesh, order=2 * ORDER - 2)
        self.flow, self.next = ngs.GridFunction(points**4), ngs.GridFunction(points**4)
        self.sunk, self.free = ngs.GridFunction(space), space.FreeDofs()
        self.depth = ngs.Parameter(0.0)
        u = space.TrialFunction()
        deviator, mises, dilatation = self._trial(u, ngs.Grad(u))
        excess = ngs.IfPos(mises - YIELD_STRESS, mises - YIELD_STRESS, 0)
        density = BULK / 2 * dilatation**2 + (mises**2 - excess**2) / (6 * SHEAR)
        r = ngs.x
        self.form = ngs.BilinearForm(space, symmetric=True)
        rules = points.GetIntegrationRules()
        self.form += ngs.Variation((2 * np.pi * r * density).Compile() * ngs.dx(intrules=rules))
        self.top = ngs.ds("top", bonus_intorder=8)
        over = self._overlap(u)
        self.form += ngs.Variation(np.pi * r * PENALTY * MODULUS * over**2 * self.top)
        deviator, mises, _ = self._trial(self.sunk, ngs.Grad(self.sunk))
        share_lost = ngs.IfPos(mises - YIELD_STRESS, (mises - YIELD_STRESS) / mises, 0)
        self.flown = ngs.CF(
            tuple(self.flow[i] + share_lost * s / (2 * SHEAR) for i, s in enumerate(deviator))
        )

    def _trial(self, u: Any, slope: Any) -> tuple[list[Any], Any, Any]:
        """Return the trial stress's deviator (rr, zz, tt, rz) and von Mises; the dilatation."""
        total = slope[0, 0], slope[1, 1], u[0] / ngs.x, (slope[0, 1] + slope[1, 0]) / 2
        elastic = [e - self.flow[i] for i, e in enumerate(total)]
        mean = (elastic[0] + elastic[1] + elastic[2]) / 3
        deviator = [2 * SHEAR * (e - mean) for e in elastic[:3]] + [2 * SHEAR * elastic[3]]
        squares = sum(s * s for s in deviator) + deviator[3] * deviator[3]
        return deviator, ngs.sqrt(1.5 * squares + 1e-24), total[0] + total[1] + total[2]

    def _overlap(self, u: Any) -> Any:
        over = self.depth - self.unit * ngs.x**2 / 2 - u[1]
        return ngs.IfPos(over, over, 0)

    def press(self, depth: float) -> float:
        """Go to a depth (in contact radii) in one step; return the force in F_y."""
        self.depth.Set(depth)
        at = self.sunk.vec
        rest, change, there = (at.CreateVector() for _ in range(3))
        for _ in range(ROUNDS):
            self.form.AssembleLinearization(at)
            self.form.Apply(at, rest)
            inverse = self.form.mat.Inverse(self.free, inverse="sparsecholesky")
            change.data = inverse * rest
            fall, energy = ngs.InnerProduct(change, rest), self.form.Energy(at)
            if fall <= SETTLED * energy:
                break
            part = 1.0
            while part > 1e-3:
                there.data = at - part * change
                if self.form.Energy(there) <= energy - 1e-4 * part * fall:
                    break
                part /= 2
            at.data = there
        else:
            raise SystemExit(f"NGSolve: no balance at {depth * self.unit / DEPTH:.3g} d_y")
        self.next.Interpolate(self.flown)
        self.flow.vec.data = self.next.vec
        pressure = 2 * np.pi * ngs.x * PENALTY * MODULUS * self._overlap(self.sunk)
        return float(ngs.Integrate(pressure * self.top, self.mesh)) * self.unit**2 / FORCE


def by_ngsolve(share: float) -> tuple[float, int]:
    """Return the force in F_y, and the number of unknowns."""
    ball, shares = Ball(share), [1.0]
    while shares[-1] > FIRST:
        shares.append(shares[-1] * np.exp(-STEP / shares[-1] ** 0.75))
    forces = [ball.press(part * share * DEPTH / ball.unit) for part in shares[::-1]]
    return forces[-1], len(ball.sunk.vec) * 2


def by_ours(share: float, per_radius: int = 9) -> tuple[float, int]:
    """Return the same of `reference.plastic`."""
    steel = PlasticMaterial(Material(1.0, NU), YIELD_STRESS)
    walk = Walk(steel, lambda r: r**2 / 2, radius_at(share), per_radius=per_radius)
    (moment,) = walk.along(LoadPath("penetration", share * DEPTH))
    return moment.force / FORCE, walk.mesh.size


def two_codes() -> list[list[str]]:
    """Return the forces of both, and how far they are apart."""
    rows = [["d/d_y", "F/F_y, NGSolve", "unknowns", "F/F_y, here", "unknowns", "difference"]]
    for share in SHARES:
        (theirs, many), (ours, count) = by_ngsolve(share), by_ours(share)
        difference = f"{100 * (ours / theirs - 1):+.2f} %"
        rows.append([str(share), f"{theirs:.3f}", str(many), f"{ours:.3f}", str(count), difference])
    return rows


# %%
if __name__ == "__main__":
    if HERE:
        ngs.SetNumThreads(1)
        rewrite(PAGE, {"two codes": two_codes})
    else:
        print("skipped: NGSolve is missing (pip install 'roughline[peers]')")
