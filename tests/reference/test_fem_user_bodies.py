"""Finite bodies with supports: patch tests, a layer against its asymptotic solution, refinement."""

import meshio
import numpy as np
import pytest
from skfem import MeshHex, MeshTet

from reference.errors import ConvergenceError
from reference.fem import Enforcement, Material, matrix_free, press, recover
from reference.fem.condensed_body import supported_body
from reference.fem.solid_mesh import KINDS, SolidMesh, SupportedMesh, contact_nodes, free_motions
from reference.fem.two_bodies import couple
from reference.layered import RoundContact, Stack
from reference.loads import Load, LoadPath

ALL_KINDS = (*KINDS, "hexahedron20")


def block(name, lines, *, distort=0.0, curve=None):
    """Return a box between mesh lines x, y, z, numbered as in a file (VTK), z into the body.

    `distort` moves inner corners by that share of a cell; `curve` maps all points.
    """
    order = 2 if name in ("hexahedron20", "hexahedron27", "tetra10") else 1
    kind = KINDS["hexahedron27" if name == "hexahedron20" else name]
    mesh = kind.straight.init_tensor(*lines)
    p = np.array(mesh.p)
    inner = np.all([(c > c.min()) & (c < c.max()) for c in p], axis=0)
    cell = min(np.diff(line).min() for line in lines)
    moves = np.random.default_rng(1).uniform(-0.5, 0.5, p.shape) * distort * cell
    p[:, inner] += moves[:, inner]
    mesh = kind.straight(p, mesh.t)
    mesh = kind.mesh.from_mesh(mesh) if order == 2 else mesh
    points = np.array(mesh.doflocs.T)
    points = points if curve is None else curve(points)
    cells = np.empty_like(mesh.dofs.element_dofs.T)
    cells[:, kind.from_vtk] = mesh.dofs.element_dofs.T
    corners = points[cells[:, : kind.corners]]
    edges = corners[:, [1, 2, 3] if kind.simplex else [1, 3, 4]] - corners[:, [0]]
    mirrored = np.linalg.det(edges) < 0.0
    if mirrored.any():
        cells[mirrored] = cells[mirrored][:, mirror_of(kind)]
    if name == "hexahedron20":
        cells = cells[:, :20]
    return SolidMesh.from_vtk(name, points, cells)


def mirror_of(kind):
    """Numbering (VTK) of the same cell seen in a mirror: x and y exchanged."""
    wanted = kind.vtk[:, [1, 0, 2]]
    return np.linalg.norm(wanted[:, None] - kind.vtk, axis=-1).argmin(axis=1)


def on_rollers(mesh):
    """Hold x = 0, y = 0 and the bottom along their normals."""
    held = mesh.points[:, :3] < 1e-12
    held[:, 2] = mesh.points[:, 2] > mesh.points[:, 2].max() - 1e-12
    return held


def top(mesh):
    return mesh.faces_within(mesh.points[:, 2] < 1e-12)


CUBE = [np.linspace(0.0, 1.0, 4)] * 3


@pytest.mark.parametrize("name", ALL_KINDS)
def test_a_compressed_block_is_in_uniform_stress(name):
    """The patch test: F = E A d / H, and the same stress everywhere, whatever the cells' shape.

    1e-10: rounding of the elimination; any flaw of integration or weights would show as 1e-2.
    """
    mesh = block(name, CUBE, distort=0.3)
    assert len(mesh.inverted()) == 0
    body = supported_body(SupportedMesh(mesh, top(mesh), on_rollers(mesh)), Material(2.0, 0.3))
    (step,) = press(body, np.zeros(len(body.points)), Load("penetration", 0.1))
    assert step.force == pytest.approx(0.2, rel=1e-10)
    np.testing.assert_allclose(step.pressure, 0.2, rtol=1e-10)
    fields = recover(body, step.reactions)
    np.testing.assert_allclose(fields.stress[:, 2], -0.2, rtol=1e-10)
    np.testing.assert_allclose(np.delete(fields.stress, 2, axis=1), 0.0, atol=1e-10)
    np.testing.assert_allclose(fields.von_mises, 0.2, rtol=1e-10)


@pytest.mark.parametrize("name", ALL_KINDS)
def test_refined_cells_fill_the_same_curved_body(name):
    """Cutting follows the mesh's own curves, so the volume is kept to rounding."""

    def bulge(p):
        return p * (1.0 + 0.2 * np.sin(p[:, [1, 2, 0]]))

    mesh = block(name, [np.linspace(0.0, 1.0, 3)] * 3, curve=bulge)
    surface = mesh.boundary_faces
    finer, numbers, (cut,) = mesh.refined(surface)
    assert len(finer.cells) == 8 * len(mesh.cells)
    np.testing.assert_allclose(finer.points[numbers], mesh.points, rtol=1e-14)
    assert volume(finer) == pytest.approx(volume(mesh), rel=1e-12)
    np.testing.assert_array_equal(np.unique(cut, axis=0), np.unique(finer.boundary_faces, axis=0))


def volume(mesh):
    """Gauss's theorem over the boundary: V = (1/3) int x . n dA."""
    total = 0.0
    for nodes, shapes, areas in mesh.face_integrals(mesh.boundary_faces):
        places = np.einsum("kni,nq->kqi", mesh.points[nodes], shapes)
        total += (places * areas).sum() / 3.0
    return total


def test_a_crack_stays_open_when_cells_are_cut():
    """Nodes that coincide without being the same are two sides of a crack, also when refined."""
    mesh = block("hexahedron27", CUBE)
    both = SolidMesh(
        mesh.kind,
        np.concatenate([mesh.points, mesh.points + np.eye(3)[0]]),
        np.concatenate([mesh.cells, mesh.cells + len(mesh.points)]),
    )
    assert both.parts() == 2
    assert both.refined()[0].parts() == 2


@pytest.mark.parametrize("name", ALL_KINDS)
def test_an_inverted_cell_is_named(name):
    """Two corners exchanged turn a cell inside out."""
    mesh = block(name, CUBE)
    cells = mesh.cells.copy()
    cells[5, [0, 1]] = cells[5, [1, 0]]
    assert 5 in SolidMesh(mesh.kind, mesh.points, cells).inverted()


@pytest.mark.parametrize(
    ("name", "tolerance"),
    [("hexahedron27", 0.01), pytest.param("tetra10", 0.02, marks=pytest.mark.slow)],
)
def test_a_bonded_layer_is_stiffer_than_a_half_space(name, tolerance):
    """The real boundary counts: 18 % over Hertz at a sixth of the thickness.

    The rim is four thicknesses away, where it no longer matters. The layer's own force is that of
    the integral equation.
    """
    edges = np.concatenate([np.linspace(0.0, 0.4, 7), 0.4 + 3.6 * np.linspace(0, 1, 6)[1:] ** 1.6])
    depth = np.concatenate([np.linspace(0.0, 0.4, 5), np.linspace(0.4, 1.0, 4)[1:]])
    mesh = block(name, [edges, edges, depth])
    held = mesh.points < 1e-12
    held[:, 2] = False
    held[mesh.points[:, 2] > 1.0 - 1e-12] = True
    surface = mesh.faces_within((mesh.points[:, 2] < 1e-12) & (mesh.points[:, :2].max(1) < 0.5))
    body = supported_body(SupportedMesh(mesh, surface, held), Material(1.0, 0.3), symmetry=4)
    depth, radius = 0.03, 1.0
    (step,) = press(body, (body.points**2).sum(axis=1) / (2.0 * radius), Load("penetration", depth))
    hertz = 4.0 / 3.0 / (1.0 - 0.3**2) * np.sqrt(radius) * depth**1.5
    layer = RoundContact(Stack([1.0], [Material(1.0, 0.3)]), lambda x: x**2)
    exact = layer.at("penetration", depth, np.sqrt(depth)).force / hertz
    assert exact > 1.17
    assert step.force / hertz == pytest.approx(exact, rel=tolerance)


def test_free_motions_are_named_one_by_one():
    points = np.array([[x, y, z] for x in (0, 1) for y in (0, 1) for z in (0, 1)], dtype=float)
    held = np.zeros(points.shape, dtype=bool)
    assert len(free_motions(points, held)) == 6
    held[points[:, 2] == 0, 2] = True
    held[points[:, 0] == 0, 0] = True
    assert free_motions(points, held) == ["translation along y"]
    held[0, 1] = True
    assert free_motions(points, held) == []


def test_what_cannot_be_solved_is_refused_all_at_once():
    mesh = block("tetra", CUBE)
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.points[:, 2] < 1e-12, 2] = True
    with pytest.raises(ValueError, match=r"translation along x.*must not be held along z"):
        SupportedMesh(mesh, top(mesh), held)
    with pytest.raises(ValueError, match="lock"):
        supported_body(SupportedMesh(mesh, top(mesh), on_rollers(mesh)), Material(1.0, 0.49))
    with pytest.raises(ValueError, match="got 'wedge'"):
        SolidMesh.from_vtk("wedge", mesh.points, mesh.cells)


def test_corners_of_ten_node_tetrahedra_are_no_candidates():
    """They carry nothing of a uniform pressure: a nodal pressure there would divide by zero."""
    mesh = block("tetra10", CUBE)
    nodes = contact_nodes(mesh, top(mesh))
    assert len(nodes) == len(mesh.nodes_of(top(mesh))) - 16
    assert isinstance(mesh.to_scikit()[0], MeshTet)
    assert isinstance(block("hexahedron", CUBE).to_scikit()[0], MeshHex)


def both(mesh, held, nu=0.3, **options):
    """Return the body condensed by nested dissection, and that of conjugate gradients."""
    supported = SupportedMesh(mesh, top(mesh), held)
    return [
        supported_body(supported, Material(1.0, nu), solver=solver, **options)
        for solver in ("nested_dissection", "conjugate_gradients")
    ]


def on_its_bottom(mesh):
    held = np.zeros(mesh.points.shape, dtype=bool)
    held[mesh.points[:, 2] > mesh.points[:, 2].max() - 1e-12] = True
    return held


@pytest.mark.slow
@pytest.mark.parametrize("name", ALL_KINDS)
@pytest.mark.parametrize("hold", [on_rollers, on_its_bottom])
def test_multigrid_solves_what_the_factorisation_does(name, hold, tmp_path):
    """Meshes written and read by meshio, loads of both kinds, springs: 1e-7, ten tolerances."""
    lines = np.linspace(0.0, 1.0, 5 if block(name, CUBE).kind.order == 2 else 7)
    mesh = block(name, [lines] * 3, distort=0.3)
    cells = np.empty_like(mesh.cells)
    cells[:, mesh.kind.from_vtk] = mesh.cells
    vtk = name if name != "hexahedron20" else "hexahedron27"
    meshio.write(tmp_path / "body.vtu", meshio.Mesh(mesh.points, [(vtk, cells)]))
    read = meshio.read(tmp_path / "body.vtu")
    mesh = SolidMesh.from_vtk(read.cells[0].type, read.points, read.cells[0].data)
    direct, iterative = both(mesh, hold(mesh))
    gap = 0.3 * ((direct.points - 0.45) ** 2).sum(axis=1)
    for load, how in (
        (LoadPath("penetration", [0.02, 0.05]), Enforcement()),
        (LoadPath("force", [0.01, 0.003]), Enforcement()),
        (LoadPath("penetration", [0.03]), Enforcement("penalty", 30.0)),
        (LoadPath("penetration", [0.03]), Enforcement("augmented_lagrangian", 30.0)),
    ):
        for exact, step in zip(
            press(direct, gap, load, how), press(iterative, gap, load, how), strict=True
        ):
            assert np.array_equal(step.active, exact.active)
            assert step.force == pytest.approx(exact.force, rel=1e-7)
            assert step.penetration == pytest.approx(exact.penetration, rel=1e-7)
            scale = exact.reactions.max()
            np.testing.assert_allclose(step.reactions, exact.reactions, atol=1e-7 * scale, rtol=0)
    fields = [recover(body, exact.reactions).displacement for body in (direct, iterative)]
    np.testing.assert_allclose(fields[1], fields[0], atol=1e-7 * np.abs(fields[0]).max(), rtol=0)


@pytest.mark.slow
def test_only_points_that_may_touch_take_a_column():
    mesh = block("tetra10", [np.linspace(0.0, 1.0, 7)] * 3)
    iterative = both(mesh, on_its_bottom(mesh))[1]
    gap = 0.5 * ((iterative.points - 0.5) ** 2).sum(axis=1)
    (step,) = press(iterative, gap, Load("penetration", 0.03))
    known = iterative.iterative.known
    assert step.active.sum() <= known.sum() < 0.5 * len(known)
    assert not (step.active & ~known).any()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["hexahedron", "hexahedron27", "tetra", "tetra10"])
def test_steps_of_multigrid_do_not_grow_with_the_mesh(name):
    """The rigid motions are in the coarse space: without the turns steps would double.

    On 6 and on 12 elements a side (linear), half as many (quadratic).
    """
    steps = []
    for cells in (6, 12) if name in ("hexahedron", "tetra") else (3, 6):
        mesh = block(name, [np.linspace(0.0, 1.0, cells + 1)] * 3)
        body = both(mesh, on_its_bottom(mesh))[1]
        body.flexibility.respond(np.arange(3), np.ones((3, 1)))
        steps += body.iterative.iterations
    assert steps[1] <= 2 * steps[0]
    assert steps[1] < 60


@pytest.mark.slow
def test_units_do_not_change_digits_of_multigrid():
    """By powers of two no digit, from metres to nanometres rounding times the steps."""
    mesh = block("tetra10", [np.linspace(0.0, 1.0, 5)] * 3, distort=0.2)
    forces = []
    for size, modulus in ((1.0, 1.0), (2.0**-20, 2.0**33), (1e-9, 2e11)):
        scaled = SolidMesh(mesh.kind, mesh.points * size, mesh.cells)
        body = supported_body(
            SupportedMesh(scaled, top(mesh), on_its_bottom(mesh)),
            Material(modulus, 0.3),
            solver="conjugate_gradients",
        )
        gap = ((body.points / size - 0.5) ** 2).sum(axis=1) * size
        (step,) = press(body, gap, Load("penetration", 0.1 * size))
        forces.append(step.force / (modulus * size**2))
    assert forces[0] == forces[1]
    assert forces[2] == pytest.approx(forces[0], rel=1e-7)


def test_multigrid_reports_no_convergence(monkeypatch):
    mesh = block("hexahedron", CUBE)
    body = both(mesh, on_rollers(mesh))[1]
    one = np.arange(1)
    monkeypatch.setattr(matrix_free, "MOST_STEPS", 1)
    with pytest.raises(ConvergenceError, match="did not converge") as caught:
        body.flexibility.respond(one, np.ones((1, 1)))
    assert caught.value.history[0] == 1.0
    assert len(caught.value.history) == 2
    with pytest.raises(ConvergenceError, match="broke down"):
        body.flexibility.interior(np.full(len(body.nodes), np.nan))
    assert not body.flexibility.interior(np.zeros(len(body.nodes))).any()
    with pytest.raises(ValueError, match="both bodies must be condensed"):
        couple(body, body)
