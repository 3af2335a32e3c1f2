"""The contact patch test and two-body Hertz, mortar and node-to-surface side by side.

``python docs/examples/two_bodies.py`` prints the table of docs/finite-elements.md (half a minute).
"""

from __future__ import annotations

import numpy as np
from skfem import MeshHex, MeshHex2

from reference.closed_form import paraboloid
from reference.fem import Material, TensorMesh, half_space_body
from reference.fem.condensed_body import CondensedBody, supported_body
from reference.fem.solid_mesh import KINDS, SolidMesh, SupportedMesh
from reference.fem.two_bodies import couple
from reference.loads import Load

LOWER, UPPER = (1.0, 0.3), (2.0, 0.2)  # E and nu of both bodies
COMBINED = 1.0 / sum((1.0 - nu**2) / modulus for modulus, nu in (LOWER, UPPER))
WAYS = (("mortar", "dual"), ("mortar", "standard"), ("node_to_surface", "dual"))


def cube(cells: int, moduli: tuple[float, float]) -> CondensedBody:
    """Return a cube of 27-node hexahedra on rollers."""
    lines = np.linspace(0.0, 1.0, cells + 1)
    mesh = MeshHex2.from_mesh(MeshHex.init_tensor(lines, lines, lines))
    nodes = np.asarray(mesh.dofs.element_dofs.T)
    solid = SolidMesh(KINDS["hexahedron27"], np.array(mesh.doflocs.T), nodes)
    fixed = solid.points < 1e-12
    fixed[:, 2] = solid.points[:, 2] > 1.0 - 1e-12
    return supported_body(
        SupportedMesh(solid, solid.faces_within(solid.points[:, 2] < 1e-12), fixed),
        Material(*moduli),
    )


def half_space(cells: int, moduli: tuple[float, float]) -> CondensedBody:
    """Return a quarter of a half-space with `cells` per contact radius at the largest load."""
    lines = np.linspace(0.0, 1.25, round(1.25 * cells) + 1)
    return half_space_body(TensorMesh(lines, lines, symmetry="quarter", order=2), Material(*moduli))


def patch_error(coupling: str, multipliers: str) -> float:
    """Return the largest relative error of the pressure between blocks of 3 and 4 cells a side."""
    pair = couple(cube(3, LOWER), cube(4, UPPER), coupling=coupling, multipliers=multipliers)
    (step,) = pair.press(lambda x, y: 0.0 * x, Load("penetration", 0.15))
    return float(np.abs(step.pressure / 0.1 - 1.0).max())


def hertz_errors(
    cells: int, bodies: tuple[CondensedBody, CondensedBody], coupling: str, multipliers: str
) -> tuple[float, float, float]:
    """Return rms error of force over depths, and L2 and largest errors of pressure in 0.85 a."""
    pair = couple(*bodies, coupling=coupling, multipliers=multipliers)
    exact, forces, pressures = paraboloid(1.0, COMBINED), [], []
    for depth in np.linspace(0.6, 1.0, 5):
        (step,) = pair.press(
            lambda x, y: (x**2 + y**2) * (1 / 6 + 1 / 3), Load("penetration", depth)
        )
        radius = np.hypot(*pair.combined.points.T)
        inside = radius < 0.85 * np.sqrt(depth)
        truth, weight = exact.pressure(radius[inside], 0.0, depth), pair.combined.weights[inside]
        error = step.pressure[inside] - truth
        share = np.sqrt((weight * error**2).sum() / (weight * truth**2).sum())
        pressures.append((share, np.abs(error).max() / truth.max()))
        forces.append(step.force / exact.force(depth) - 1.0)
    return float(np.sqrt(np.mean(np.square(forces)))), *np.max(pressures, axis=0)


def main() -> None:
    """Print the table."""
    print("| coupling | patch test | cells | force, rms | pressure, L2 | pressure, largest |")
    print("|---|---|---|---|---|---|")
    for cells in (4, 6):
        bodies = half_space(cells, LOWER), half_space(cells + 1, UPPER)
        for coupling, multipliers in WAYS:
            patch = patch_error(coupling, multipliers)
            errors = " | ".join(
                f"{error:.1e}" for error in hertz_errors(cells, bodies, coupling, multipliers)
            )
            name = coupling.replace("_", "-") + (f", {multipliers}" if coupling == "mortar" else "")
            print(f"| {name} | {patch:.0e} | {cells} on {cells + 1} | {errors} |")


if __name__ == "__main__":
    main()
