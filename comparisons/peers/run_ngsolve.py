"""NGSolve for single contacts in a separate process: tetrahedra of fourth order.

The mesh is a quarter ball of the half-space, with a circle (ellipse) on the expected contact edge
and small elements along it. Contact is a penalty at the integration points of the surface, nearly
rigid (overlap 1e-5 of the penetration), solved by an active set on those points with a direct
factorisation per round. The outer boundary follows the Boussinesq field of the unknown total force
(Johnson 1985, eq. 3.18); the remainder decreases with the cube of the extent, and is 1e-5 of the
force here.

Lengths are in contact radii, displacements in penetrations, and E* = 1.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable
from typing import Any

import psutil
from netgen.occ import Box, Glue, OCCGeometry, Pnt, Sphere
from ngsolve import (
    CF,
    BilinearForm,
    Grad,
    GridFunction,
    IfPos,
    InnerProduct,
    LinearForm,
    Mesh,
    Parameter,
    SetNumThreads,
    VectorH1,
    div,
    ds,
    dx,
    sqrt,
    x,
    y,
    z,
)

ORDER = 4
EXTENT = 24.0
# In units of E* over the contact radius; the relative overlap is about 1e-5.
PENALTY = 1e5
# Growth of elements outside the contact; the error of elongated contacts is 5e-4 at 0.5, 6e-5 at
# 0.25.
GRADING = 0.3
# Elements per length along the contact edge relative to the inside; at sharp edges the pressure is
# singular.
EDGE, SHARP_EDGE = 2.5, 5.0
MOST_ROUNDS = 40
# Relative change of the answer in the last round; single points at the edge may switch forever.
SETTLED = 1e-6
PARTS = 4  # a quarter is meshed
SURFACE = "inside|outside"
SHARP = ("cylinder", "elliptic_punch")


def solve(problem: dict[str, Any]) -> dict[str, Any]:
    """Solve all loads of a problem.

    The problem: resolution (elements per contact radius), poisson_ratio, stretch (x, y), shape and
    its parameters, control ("penetration" | "force"), steps: a list of {radius, depth, load}, the
    load in units of depth, or of E* radius depth. Returns lists over the steps: penetration, force,
    stiffness, counted_area, second, fourth (moments of the pressure), rounds, reason; and unknowns,
    seconds, setup_seconds, memory.
    """
    SetNumThreads(1)
    before = psutil.Process().memory_info().rss
    start = time.perf_counter()
    edge = SHARP_EDGE if problem["shape"] in SHARP else EDGE
    model = _Model(problem["resolution"], edge, problem["poisson_ratio"], problem["stretch"])
    setup = time.perf_counter() - start
    steps = []
    for step in problem["steps"]:  # by an active set on the integration points
        contact, value, rounds = _Contact(model, problem, step), math.inf, 0
        for rounds in range(1, MOST_ROUNDS + 1):
            before_round, value = value, contact.round()
            if abs(value - before_round) <= SETTLED * abs(value):
                steps.append(contact.answer() | {"rounds": rounds, "reason": ""})
                break
        else:
            reason = f"the contact did not converge in {MOST_ROUNDS} rounds"
            steps.append({"rounds": rounds, "reason": reason})
    return {
        "seconds": time.perf_counter() - start,
        "setup_seconds": setup,
        "unknowns": int(model.space.ndof),
        "memory": psutil.Process().memory_info().rss - before,
        "steps": steps,
    }


def _quarter(radius: float) -> Any:
    return Sphere(Pnt(0, 0, 0), radius) * Box(Pnt(0, 0, 0), Pnt(*[1.01 * radius] * 3))


def _mesh(resolution: int, edge_density: float) -> Mesh:
    """Return a quarter ball of radius EXTENT around one of radius 1; z points into the body."""
    inner = _quarter(1.0)
    outer = _quarter(EXTENT) - inner
    inner.maxh = 1.0 / resolution
    for solid, surface in ((inner, "inside"), (outer, "outside")):
        for face in solid.faces:
            low, high = face.bounding_box
            size = [high.x - low.x, high.y - low.y, high.z - low.z]
            flat = [k for k in range(3) if size[k] < 1e-6 * max(size)]
            if flat:
                face.name = ("x", "y", surface)[flat[0]]
            elif high.x > 1.5:
                face.name = "far"
    body = Glue([inner, outer])
    for edge in body.edges:
        low, high = edge.bounding_box
        if abs(high.z) < 1e-6 and abs(high.x - 1) < 1e-5 and abs(high.y - 1) < 1e-5:
            edge.maxh = 1.0 / (edge_density * resolution)
    return Mesh(OCCGeometry(body).GenerateMesh(maxh=EXTENT / 2, grading=GRADING)).Curve(3)


class _Model:
    """Mesh, space and far field, common to all loads because a half-space has no length scale."""

    def __init__(
        self, resolution: int, edge: float, poisson_ratio: float, stretch: list[float]
    ) -> None:
        self.mesh = _mesh(resolution, edge)
        if stretch[0] != stretch[1]:
            # circles become ellipses, fading towards the far boundary
            r = sqrt(x * x + y * y + z * z)
            fade = IfPos(1 - r, 1.0, IfPos(EXTENT - r, (EXTENT - r) / (EXTENT - 1), 0.0))
            move = GridFunction(VectorH1(self.mesh, order=2))
            move.Set(CF(((stretch[0] - 1) * x * fade, (stretch[1] - 1) * y * fade, 0)))
            self.mesh.SetDeformation(move)
        self.space = VectorH1(
            self.mesh, order=ORDER, dirichlet="far", dirichletx="x", dirichlety="y"
        )
        nu = poisson_ratio
        self.shear = 0.5 * (1 - nu)  # E = 1 - nu^2
        self.lame = 2 * self.shear * nu / (1 - 2 * nu)
        r = sqrt(x * x + y * y + z * z)
        across = z / r**3 - (1 - 2 * nu) / (r * (r + z))
        field = CF((x * across, y * across, z * z / r**3 + 2 * (1 - nu) / r))
        # The field of the total force; the model is a quarter of the body.
        self.far = GridFunction(self.space)
        far = self.mesh.Boundaries("far")
        self.far.Set(field / (4 * math.pi * self.shear), definedon=far)
        u, v = self.space.TnT()
        self.elastic = BilinearForm(self.energy(u, v), symmetric=True).Assemble()
        self.tests = [self._test(CF(1), far), self._test(x * x + y * y, far)]
        self.tests.append(self._test((x * x + y * y) ** 2, far))
        self.ring = self.mesh.BoundaryCF({"inside": 1.0}, default=0.0)

    def energy(self, u: Any, v: Any) -> Any:
        """Return the bilinear form of the elastic energy."""

        def strain(w: Any) -> Any:
            return 0.5 * (Grad(w) + Grad(w).trans)

        elastic = 2 * self.shear * InnerProduct(strain(u), strain(v))
        return (elastic + self.lame * div(u) * div(v)) * dx

    def _test(self, value: Any, far: Any) -> Any:
        """Return a virtual displacement along z on the surface, to weight contact forces."""
        test = GridFunction(self.space)
        test.Set(CF((0, 0, value)), definedon=self.mesh.Boundaries(SURFACE))
        for dof, is_far in enumerate(self.space.GetDofs(far)):
            if is_far:
                test.vec[dof] = 0.0
        return test


def _gap(shape: str, p: dict[str, Any], radius: float, depth: float) -> Any:
    """Return the shape with lengths in contact radii and heights in penetrations."""
    a, b = radius * x, radius * y
    r = sqrt(a * a + b * b)
    makers: dict[str, Callable[[], Any]] = {
        "paraboloid": lambda: r * r / (2 * p["radius"]),
        "sphere": lambda: r * r / (p["radius"] + sqrt(_positive(p["radius"] ** 2 - r * r))),
        "cone": lambda: p["slope"] * r,
        "power_law": lambda: p["coefficient"] * r ** p["exponent"],
        "rounded_punch": lambda: _positive(r - p["flat_radius"]) ** 2 / (2 * p["edge_radius"]),
        "ellipsoid": lambda: a * a / (2 * p["radius_x"]) + b * b / (2 * p["radius_y"]),
        "cylinder": lambda: Parameter(0.0),
        "elliptic_punch": lambda: Parameter(0.0),
    }
    return makers[shape]() / depth


def _positive(value: Any) -> Any:
    return IfPos(value, value, 0.0)


class _Contact:
    """One load; for a given set of contact points, force and penetration are related linearly."""

    def __init__(self, model: _Model, problem: dict[str, Any], step: dict[str, float]) -> None:
        self.model, self.load = model, step["load"]
        self.by_force = problem["control"] == "force"
        gap = _gap(problem["shape"], problem["parameters"], step["radius"], step["depth"])
        u, v = model.space.TnT()
        self.now, self.depth = GridFunction(model.space), Parameter(1.0)
        self.first, self.force, self.stiffness = Parameter(1.0), 0.0, 0.0
        touching = IfPos(self.depth - gap - self.now[2], 1.0, 0.0)
        if problem["shape"] in SHARP:  # a punch ends at its edge
            touching = model.ring * touching
        # The first round assumes contact within the expected edge.
        self.active = PENALTY * IfPos(self.first - 0.5, model.ring, touching)
        surface = ds(SURFACE, bonus_intorder=2)
        energy = model.energy(u, v) + self.active * u[2] * v[2] * surface
        self.system = BilinearForm(energy, symmetric=True)
        self.plain = LinearForm(self.active * v[2] * surface)
        self.shaped = LinearForm(self.active * gap * v[2] * surface)

    def round(self) -> float:
        """Solve with the current set; return the unknown one of force and penetration."""
        model, uniform = self.model, self.model.tests[0].vec
        for form in (self.system, self.plain, self.shaped):
            form.Assemble()
        inverse = self.system.mat.Inverse(model.space.FreeDofs(), inverse="sparsecholesky")
        raised = (inverse * self.plain.vec).Evaluate()
        formed = (inverse * self.shaped.vec).Evaluate()
        pulled = (model.far.vec - inverse * (self.system.mat * model.far.vec)).Evaluate()
        # u = d raised - formed + F pulled, so the contact force is F = d a - b - F c
        a = PARTS * (InnerProduct(self.plain.vec, uniform) - InnerProduct(self.plain.vec, raised))
        b = PARTS * (InnerProduct(self.shaped.vec, uniform) - InnerProduct(self.plain.vec, formed))
        c = PARTS * InnerProduct(self.plain.vec, pulled)
        depth = (self.load * (1 + c) + b) / a if self.by_force else self.load
        self.force = self.load if self.by_force else (depth * a - b) / (1 + c)
        self.stiffness = a / (1 + c)
        self.depth.Set(depth)
        self.now.vec.data = depth * raised - formed + self.force * pulled
        self.first.Set(0.0)
        return depth if self.by_force else self.force

    def answer(self) -> dict[str, float]:
        """Return the quantities of the last round, with moments of the nodal forces."""
        model = self.model
        forces = (model.elastic.mat * self.now.vec).Evaluate()
        total, second, fourth = (InnerProduct(forces, test.vec) for test in model.tests)
        self.plain.Assemble()
        counted = PARTS * InnerProduct(self.plain.vec, model.tests[0].vec) / PENALTY
        return {
            "penetration": self.depth.Get(),
            "force": self.force,
            "stiffness": self.stiffness,
            "counted_area": counted,
            "second": second / total,
            "fourth": fourth / total,
        }
