"""Make the tables of docs/finite-elements.md: errors, penalties, stresses, waves, rough surfaces.

Run from the repository's root (five minutes on one core). Tables that the page shows are written
into it, others are printed; all of them, or those that are named::

    python docs/examples/finite_element_tables.py NAME
"""

# %%
import resource
import sys
import time
from collections.abc import Callable, Iterator
from concurrent.futures import ProcessPoolExecutor
from multiprocessing import get_context
from pathlib import Path

import numpy as np
import psutil
from scipy.integrate import quad
from scipy.special import gamma
from skfem import MeshTet, MeshTet2
from threadpoolctl import threadpool_limits

import roughline
from comparisons.questions.benchmarks import fem as fem_benchmark
from reference.closed_form import ellipsoid
from reference.contact import press as unilateral
from reference.elasticity import largest_shear
from reference.fem import (
    Enforcement,
    Material,
    RingMesh,
    grid_body,
    half_space_body,
    indent,
    press,
    recover,
)
from reference.fem.columns import ELEMENTS, compliance
from reference.fem.condensed_body import supported_body
from reference.fem.grid_body import PeriodicBody
from reference.fem.solid_mesh import KINDS, SolidMesh, SupportedMesh
from reference.halfspace import PeriodicOperator, kernels
from reference.halfspace.areas import contact_stiffness, located_area
from reference.layered import Stack
from reference.loads import Load, LoadPath
from reference.surfaces import SelfAffine, refine, rms_gradient_spectral, self_affine
from reports.tables.written import rewrite

PAGE = Path(__file__).resolve().parents[1] / "finite-elements.md"
LAYERS = PAGE.with_name("half-space.md")
RATIOS = (0.0, 0.3, 0.49, 0.4999)
LEVELS = (2, 4, 6)
Shape = Callable[[np.ndarray, np.ndarray], np.ndarray]


# %% [markdown]
# Every shape has contact radius 1 and, where it is smooth, penetration 1 (Hertz's ellipsoids 0.1);
# forces are compared with closed forms.


# %%
def power_law(exponent: int) -> tuple[Shape, float]:
    """Return ``c r^n`` and its force over E*: ``F = 2 n/(n + 1)`` (Popov & Hess 2015)."""
    kappa = np.sqrt(np.pi) / 2 * exponent * gamma(exponent / 2) / gamma((exponent + 1) / 2)
    return lambda x, y: np.hypot(x, y) ** exponent / kappa, 2.0 * exponent / (exponent + 1)


def power_law_error(exponent: int) -> Callable[[int, float], float]:
    """Error of the force of ``c r^n``."""
    shape, exact = power_law(exponent)

    def error(elements: int, nu: float) -> float:
        body = half_space_body(RingMesh(1.0, edge=1.0, elements=elements), Material(1.0, nu))
        _, step = next(indent(body, shape, Load("penetration", 1.0)))
        return step.force / (exact * body.effective_modulus) - 1.0

    return error


def cylinder_error(elements: int, nu: float) -> float:
    """Error of the stiffness ``2 E* a``."""
    body = half_space_body(
        RingMesh(1.0, edge=1.0, elements=elements, sharp=True), Material(1.0, nu)
    )
    gap = np.where(body.scaled_radii <= 1.0 + 1e-9, 0.0, np.inf)
    (step,) = press(body, gap, Load("penetration", 0.01))
    return step.stiffness / (2.0 * body.effective_modulus) - 1.0


def rounded_punch_error(elements: int, nu: float) -> float:
    """Error of the force of ``(r - 1)^2/2`` beyond r = 1, contact radius 1.5."""

    def profile(x: float) -> float:
        return x * (np.sqrt(x * x - 1.0) - np.arccos(1.0 / x)) if x > 1.0 else 0.0

    def shape(x: np.ndarray, y: np.ndarray) -> np.ndarray:
        return 0.5 * np.clip(np.hypot(x, y) - 1.0, 0.0, None) ** 2

    body = half_space_body(
        RingMesh(1.0, edge=1.0, elements=elements, sharp=True), Material(1.0, nu)
    )
    depth = profile(1.5)
    exact = 2.0 * (1.5 * depth - quad(profile, 1.0, 1.5)[0])
    _, step = next(indent(body, shape, Load("penetration", depth)))
    return step.force / (exact * body.effective_modulus) - 1.0


def ellipsoid_error(ratio: float) -> Callable[[int, float], float]:
    """Error of the force of Hertz's ellipsoid with these radii of curvature."""
    half_x, half_y = ellipsoid(ratio, 1.0, 1.0).semi_axes(1.0)
    root = float(np.sqrt(half_x / half_y))

    def error(elements: int, nu: float) -> float:
        body = half_space_body(
            RingMesh(1.0, edge=1.0, elements=elements, stretch=(root, 1.0 / root)),
            Material(1.0, nu),
        )
        exact = ellipsoid(ratio, 1.0, body.effective_modulus).force(0.1)
        _, step = next(
            indent(body, lambda x, y: 0.5 * (x**2 / ratio + y**2), Load("penetration", 0.1))
        )
        return step.force / exact - 1.0

    return error


SHAPES: dict[str, Callable[[int, float], float]] = {
    "cone": power_law_error(1),
    "paraboloid": power_law_error(2),
    "third power": power_law_error(3),
    "fourth power": power_law_error(4),
    "flat cylinder (stiffness)": cylinder_error,
    "rounded punch": rounded_punch_error,
    "ellipsoid, R'/R'' = 4": ellipsoid_error(4.0),
    "ellipsoid, R'/R'' = 25": ellipsoid_error(25.0),
}


def order(errors: list[float]) -> str:
    """Observed order, the slope of log error against log elements; none where the sign changes."""
    if min(errors) < 0.0 < max(errors):
        return "±"
    return f"{-np.polyfit(np.log(LEVELS), np.log(np.abs(errors)), 1)[0]:.1f}"


def error_table() -> list[list[str]]:
    """Errors at 2, 4 and 6 elements per contact radius, with the observed order."""
    rows = [["shape", *(f"nu = {nu:g}" for nu in RATIOS)]]
    for name, error in SHAPES.items():
        cells = []
        for nu in RATIOS:
            errors = [error(n, nu) for n in LEVELS]
            cells.append(", ".join(f"{error:.0e}" for error in errors) + f" ({order(errors)})")
        rows.append([name, *cells])
    return rows


# %% [markdown]
# Penalties, and the active set on random shapes.


# %%
def penalties() -> Iterator[tuple[float, float, int, float]]:
    """Yield eps h/E*, force error against rigid contact, iterations, condition of the stiffness.

    The condition is that of the stiffness with the springs in it, which primal codes factorise.
    """
    body = half_space_body(RingMesh(1.0, elements=4), Material(1.0, 0.3))
    gap = 0.5 * (body.points**2).sum(axis=1)
    (exact,) = press(body, gap, Load("penetration", 1.0))
    stiffness = np.linalg.inv(body.scaled_compliance)
    weights = body.scaled_weights * exact.active
    for penalty in 10.0 ** np.arange(0, 17, 2):
        (step,) = press(
            body, gap, Load("penetration", 1.0), Enforcement(method="penalty", penalty=penalty)
        )
        springs = penalty / (1.0 - 0.3**2) / body.spacing_scaled * weights
        condition = np.linalg.cond(stiffness + np.diag(springs))
        yield penalty, step.force / exact.force - 1.0, step.iterations, condition


def primal_error(penalty: float) -> float:
    """Force error of the same equations solved for displacements, as primal codes do."""
    body = half_space_body(RingMesh(1.0, elements=4), Material(1.0, 0.3))
    gap = 0.5 * (body.points**2).sum(axis=1)
    (exact,) = press(
        body, gap, Load("penetration", 1.0), Enforcement(method="penalty", penalty=penalty)
    )
    springs = penalty / (1.0 - 0.3**2) / body.spacing_scaled * body.scaled_weights * exact.active
    matrix = np.linalg.inv(body.scaled_compliance) + np.diag(springs)
    pushed = np.linalg.solve(matrix, springs * (1.0 - gap))
    force = body.symmetry * springs @ (1.0 - gap - pushed)
    return float(force / exact.force - 1.0)


def penalty_table() -> list[list[str]]:
    """Tabulate the sweep of the penalty."""
    head = ["eps h/E*", "force error", "iterations", "condition, primal", "loss of a primal solve"]
    return [
        head,
        *(
            [
                f"1e{np.log10(eps):.0f}",
                f"{error:.1e}",
                str(count),
                f"{condition:.0e}",
                f"{abs(primal_error(eps)):.0e}",
            ]
            for eps, error, count, condition in penalties()
        ),
    ]


# %%
def depth_profile(elements: int, nu: float = 0.3) -> tuple[float, float, float]:
    """Largest shear and von Mises stress on the axis over p0, and their depth over a.

    The maximum of a parabola through the largest nodal value and its neighbours.
    """
    body = half_space_body(RingMesh(1.0, edge=1.0, elements=elements), Material(1.0, nu))
    fitted, step = next(indent(body, power_law(2)[0], Load("penetration", 1.0)))
    fields = recover(fitted, step.reactions)
    axis = np.flatnonzero((np.abs(fields.points[:, :2]) < 1e-12).all(axis=1))
    axis = axis[np.argsort(fields.points[axis, 2])]
    shear = largest_shear(fields.stress)
    top = int(np.argmax(shear[axis]))
    near = axis[top - 1 : top + 2]
    z = fields.points[near, 2] / fitted.length
    parabola = np.polyfit(z, shear[near], 2)
    depth = -parabola[1] / (2.0 * parabola[0])
    peak = 2.0 * fitted.effective_modulus / np.pi / fitted.length * step.penetration
    mises = np.polyval(np.polyfit(z, fields.von_mises[near], 2), depth)
    return float(np.polyval(parabola, depth) / peak), float(mises / peak), float(depth)


def stress_table() -> list[list[str]]:
    """Stresses under Hertz's contact against Johnson (1985), sec. 4.2."""
    rows = [["elements per radius", "largest shear / p0", "von Mises / p0", "depth / a"]]
    for elements in (4, 6, 8, 10):
        stresses = depth_profile(elements)
        rows += [[str(elements), *(f"{stress:.4f}" for stress in stresses)]]
    z = np.linspace(0.3, 0.7, 4001)
    radial = 0.5 / (1 + z**2) - 1.3 * (1 - z * np.arctan(1 / z))
    shear = 0.5 * (radial + 1 / (1 + z**2))
    top = int(np.argmax(shear))
    rows.append(["exact", f"{shear[top]:.4f}", f"{2 * shear[top]:.4f}", f"{z[top]:.4f}"])
    return rows


# %% [markdown]
# Meshes that repeat from cell to cell: waves, and a rough surface.

# %%
WAVES = np.array([32.0, 16.0, 8.0, 4.0, 2.0])
SPECTRUM = SelfAffine(hurst=0.8, rms_slope=0.1, short_cutoff=1 / 16)


def wave_table() -> list[list[str]]:
    """Errors of the compliance for waves along x of some cells."""
    q = 2 * np.pi / WAVES
    rows = [["", "nu", *(f"{cells:g} cells" for cells in WAVES)]]
    for element in ELEMENTS:
        for nu in (0.0, 0.3, 0.5):
            layers = Stack([4 * WAVES[0]], [Material(1.0, nu)])
            values = compliance((q, 0 * q), (1.0, 1.0), layers, element=element)
            errors = values * q / (2 * (1 - nu**2)) - 1
            rows.append([element, f"{nu:g}", *(f"{100 * error:.2g}" for error in errors)])
    cells = kernels.periodic((32, 32), (1.0, 1.0), 1.0, "cells")[32 // WAVES.astype(int), 0]
    return [*rows, ["cells", "any", *(f"{100 * e:.2g}" for e in cells * q / 2 - 1)]]


def dispersion_table() -> list[list[str]]:
    """Errors of the elements alone, pressures being the waves."""
    q = 2 * np.pi / WAVES
    layers = Stack([4 * WAVES[0]], [Material(1.0, 0.3)])
    rows = [["", *(f"{cells:g} cells" for cells in WAVES)]]
    for element in ELEMENTS:
        values = compliance(
            (q, 0 * q), (1.0, 1.0), layers, element=element, growth=1.08, smooth=True
        )
        errors = values * q / (2 * (1 - 0.3**2)) - 1
        rows.append([element, *(f"{100 * error:.2g}" for error in errors)])
    return rows


def floor_table() -> list[list[str]]:
    """Errors of a long wave by the growth of the elements' depths."""
    growths = (1.5, 1.3, 1.25, 1.15, 1.08)
    wave = (np.array([2 * np.pi / 800]), np.zeros(1))
    layers = Stack([1600.0], [Material(1.0, 0.3)])
    rows = [["", *(f"growth {growth:g}" for growth in growths)]]
    for element in ELEMENTS:
        values = [
            compliance(wave, (1.0, 1.0), layers, element=element, growth=growth, smooth=True)[0]
            for growth in growths
        ]
        errors = np.array(values) * wave[0] / (2 * (1 - 0.3**2)) - 1
        rows.append([element, *(f"{error:.1e}" for error in errors)])
    return rows


def bottom_table() -> list[list[str]]:
    """Errors of splines alone, clamped far below or on the stiffness of a half-space."""
    waves, steel = np.array([800.0, 64.0, 16.0, 8.0, 4.0]), Material(1.0, 0.3)
    q = 2 * np.pi / waves
    bottoms = {
        "clamped below 1600 cells": Stack([1600.0], [steel]),
        "impedance below 8 cells": Stack([8.0], [steel], steel),
        "impedance below 2 cells": Stack([2.0], [steel], steel),
    }
    rows = [["", *(f"{cells:g} cells" for cells in waves)]]
    for name, layers in bottoms.items():
        errors = (
            compliance((q, 0 * q), (1.0, 1.0), layers, smooth=True) * q / (2 * (1 - 0.3**2)) - 1
        )
        rows.append([name, *(f"{error:.1e}" for error in errors)])
    return rows


def rough_table() -> list[list[str]]:
    """Finite elements against boundary elements on three grids of one surface."""
    surface = self_affine(64, 1.0, SPECTRUM, seed=1, realisation=0)
    slope = rms_gradient_spectral(surface, (1 / 64, 1 / 64))
    rows = [["cells", "penetration", "area", "stiffness", "elements, s", "set-up", "bem_fft, s"]]
    for cells in (64, 128, 256):
        heights = refine(surface, cells // 64)
        gap, spacing = heights.max() - heights, (1 / cells, 1 / cells)
        load = Load("force", slope * np.array([0.01, 0.1]))
        start = time.process_time()
        body = PeriodicBody(gap.shape, spacing, Material(1 - 0.3**2, 0.3))
        body.convolution(np.float64)
        made = time.process_time() - start
        elements = list(grid_body.sweep(body, gap, load))
        middle = time.process_time()
        half_space = PeriodicOperator(gap.shape, spacing, 1.0)
        half = list(unilateral.sweep(half_space, gap, load))
        end = time.process_time()
        pairs = list(zip(elements, half, strict=True))
        errors = [[a.penetration / b.penetration - 1 for a, b in pairs]]
        errors.append([located_area(a) / located_area(b) - 1 for a, b in pairs])
        stiff = [[contact_stiffness(c.operator, c.mask) for c in pair] for pair in pairs]
        errors.append([a / b - 1 for a, b in stiff])
        texts = [" and ".join(f"{100 * e:+.2f} %" for e in row) for row in errors]
        times = middle - start - made, made, end - middle
        rows.append([f"{cells}²", *texts, *(f"{seconds:.2f}" for seconds in times)])
    return rows


def large(cells: int) -> list[str]:
    """One load on a large period, in a process of its own: its peak memory is that of the solve."""
    surface = self_affine(256, 1.0, SPECTRUM, seed=1, realisation=0)
    slope = rms_gradient_spectral(surface, (1 / 256, 1 / 256))
    heights = refine(surface, cells // 256)
    gap, spacing = heights.max() - heights, (1 / cells, 1 / cells)
    load = Load("force", 0.05 * slope)
    corner, little = gap[:32, :32] - gap[:32, :32].min(), Load("force", 1e-3 * slope)
    for kind in (
        PeriodicBody(corner.shape, spacing, Material(1.0, 0.3)),
        PeriodicOperator(corner.shape, spacing, 1.0),
    ):
        unilateral.press(kind, corner, little)  # loads what is compiled
    start = time.process_time()
    body = PeriodicBody(gap.shape, spacing, Material(1 - 0.3**2, 0.3))
    body.convolution(np.float64)
    made = time.process_time()
    (elements,) = grid_body.sweep(body, gap, load)
    end = time.process_time()
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 2**20
    middle = time.process_time()
    half = unilateral.press(PeriodicOperator(gap.shape, spacing, 1.0), gap, load)
    times = made - start, end - made, time.process_time() - middle
    apart = elements.penetration / half.penetration - 1
    area = located_area(elements) / located_area(half) - 1
    numbers = *(f"{seconds:.2f}" for seconds in times), f"{peak:.2f} GB"
    return [f"{cells}²", *numbers, f"{apart:.0e}", f"{area:.0e}"]


def large_table() -> list[list[str]]:
    """Cost and memory of one load on large periods."""
    rows = [["cells", "set-up, s", "elements, s", "bem_fft, s", "peak", "penetration", "area"]]
    for cells in (256, 512, 1024):
        with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
            rows.append(process.submit(large, cells).result())
    return rows


# %% [markdown]
# Hertz at thirty depths by both solvers: the job of `roughline bench fem`.


# %%
def hertz_job(elements: int, solver: str) -> tuple[int, float, float, float, str]:
    """Return unknowns, error, seconds, memory and steps, in a process of its own."""
    fem_benchmark.run(2, solver)  # loads what is compiled
    before, start = psutil.Process().memory_info().rss, time.process_time()
    with threadpool_limits(limits=1):
        job = fem_benchmark.run(elements, solver)
    spent = time.process_time() - start
    taken = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    steps = "" if job.body.iterative is None else str(max(job.body.iterative.iterations))
    return job.body.unknowns, float(np.abs(job.errors).max()), spent, taken, steps


def iterative_table() -> list[list[str]]:
    """Cost and memory of conjugate gradients and of the elimination."""
    head = ["unknowns", "force error", "steps", "seconds", "memory", "per unknown"]
    rows = [[*head, "eliminated, s", "memory", "per unknown"]]
    for elements in (4, 6, 10, 14, 26):
        solvers = ["conjugate_gradients", "nested_dissection"][: 2 if elements <= 10 else 1]
        cells: list[str] = []
        for solver in solvers:
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
                job = process.submit(hertz_job, elements, solver).result()
            unknowns, error, spent, taken, steps = job
            cells = cells or [f"{unknowns:,}".replace(",", " "), f"{error:.0e}", steps]
            cells += [f"{spent:.2g}", f"{taken / 1e9:.2f} GB", f"{taken / unknowns / 1e3:.2f} kB"]
        rows.append(cells + ["not run", "", ""][: 9 - len(cells)])
    return rows


# %% [markdown]
# A ball on a body of a file: a cube of ten-node tetrahedra, its bottom fixed.


# %%
def body_job(cells: int, solver: str) -> tuple[int, int, float, float, float]:
    """Return unknowns, nodes in contact, force, seconds and memory, in a process of its own."""
    ball = LoadPath("penetration", [0.005, 0.01, 0.02])

    def run(cells: int) -> tuple[int, int, float]:
        line = np.linspace(0.0, 1.0, cells + 1)
        mesh = MeshTet2.from_mesh(MeshTet.init_tensor(line, line, line))
        solid = SolidMesh(KINDS["tetra10"], mesh.doflocs.T.copy(), mesh.dofs.element_dofs.T.copy())
        fixed = np.repeat(solid.points[:, 2:] == 1.0, 3, axis=1)
        surface = solid.faces_within(solid.points[:, 2] == 0.0)
        supported = SupportedMesh(solid, surface, fixed)
        body = supported_body(supported, Material(1.0, 0.3), solver=solver)
        gap = ((body.points - 0.5) ** 2).sum(axis=1)
        *_, last = press(body, gap, ball)
        return body.unknowns, int(last.active.sum()), last.force

    run(3)  # loads what is compiled
    before, start = psutil.Process().memory_info().rss, time.process_time()
    with threadpool_limits(limits=1):
        unknowns, touching, force = run(cells)
    spent = time.process_time() - start
    taken = 1024 * resource.getrusage(resource.RUSAGE_SELF).ru_maxrss - before
    return unknowns, touching, force, spent, taken


def body_table() -> list[list[str]]:
    """Cost and memory of the elimination, and of a column by multigrid for every contact node."""
    head = ["unknowns", "nodes in contact", "eliminated, s", "memory"]
    rows = [[*head, "by conjugate gradients, s", "memory", "force differs by"]]
    for cells in (10, 15, 20):
        jobs = []
        for solver in ("nested_dissection", "conjugate_gradients"):
            with ProcessPoolExecutor(1, mp_context=get_context("spawn")) as process:
                jobs.append(process.submit(body_job, cells, solver).result())
        (unknowns, touching, force, *_), (_, _, same, *_) = jobs
        costs = [text for job in jobs for text in (f"{job[3]:.2g}", f"{job[4] / 1e9:.2f} GB")]
        number = f"{unknowns:,}".replace(",", " ")
        rows.append([number, str(touching), *costs, f"{abs(same / force - 1):.0e}"])
    return rows


# %% [markdown]
# Incompressible layers that are thin against a cell, on a rigid base (docs/half-space.md).


# %%
def rubber_table() -> list[list[str]]:
    """Compliance to a wave of 32 cells, against the closed form (Johnson 1985, 5.8), nu = 1/2."""
    rows = [["thickness in cells", *ELEMENTS]]
    q = np.array([2 * np.pi / 32])
    for thickness in (1.0, 0.1, 1 / 30):
        a = float(q[0]) * thickness
        exact = 1.5 / q[0] * (np.sinh(2 * a) - 2 * a) / (np.cosh(2 * a) + 2 * a**2 + 1)
        layer = Stack([thickness], [Material(1.0, 0.5)])
        errors = (
            compliance((q, 0 * q), (1.0, 1.0), layer, element=element, growth=1.1, smooth=True)
            / exact
            for element in ELEMENTS
        )
        rows.append([f"{thickness:.2g}", *(f"{100 * float(e[0] - 1):+.3f} %" for e in errors)])
    return rows


def rubber_ball_table() -> list[list[str]]:
    """Force on a ball, nu = 1/2, on cells of a sixteenth of the contact radius."""
    rows = [["thickness in cells", "bem_fft", *ELEMENTS]]
    for thickness in (40, 10, 5):
        scene = {
            "name": "ball-on-rubber",
            "half_space": {
                "youngs_modulus": "3 MPa",
                "poisson_ratio": 0.5,
                "thickness": f"{thickness} um",
            },
            "indenter": {"shape": "paraboloid", "radius": "10 mm"},
            "loading": {"penetration": ["1 um"]},
            "compare": {"quantities": ["force", "contact_radius"]},
        }
        exact = roughline.solve(scene, "closed_form")
        cell = exact["contact_radius"][0] / 16
        forces = [roughline.solve(scene, "bem_fft", resolution=16)["force"][0]]
        for element in ELEMENTS:
            meshed = scene | {"methods": {"fem": {"element": element}}}
            forces.append(roughline.solve(meshed, "fem", resolution=16)["force"][0])
        errors = [f"{100 * (force / exact['force'][0] - 1):+.2f} %" for force in forces]
        rows.append([f"{thickness * 1e-6 / cell:.2g}", *errors])
    return rows


# %%
TABLES = {
    "errors": error_table,
    "penalty": penalty_table,
    "stresses": stress_table,
    "dispersion": dispersion_table,
    "floor": floor_table,
    "bottom": bottom_table,
    "waves": wave_table,
    "rough": rough_table,
    "large": large_table,
    "iterative": iterative_table,
    "bodies": body_table,
}


# %%
LAYER_TABLES = {"rubber": rubber_table, "rubber-ball": rubber_ball_table}


# %%
if __name__ == "__main__":
    rewrite(PAGE, TABLES, sys.argv[1:])
    rewrite(LAYERS, LAYER_TABLES, sys.argv[1:])
