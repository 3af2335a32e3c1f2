"""Scenes with a user's body: files of three programs, frames, supports, and what is refused."""

import shutil
from pathlib import Path

import meshio
import numpy as np
import pytest

from comparisons.geometry.body_files import FACES
from comparisons.methods.fem import user_body
from comparisons.methods.registry import solver_for
from comparisons.questions.single import solve_scene
from comparisons.results.store import mesh_of
from comparisons.scene.scene import SceneError, load_scene, make_scene, parse_scene
from comparisons.solving.execution import execute
from comparisons.solving.plan import task_of
from comparisons.solving.planning import plan_scene

EXAMPLES = Path(__file__).parents[3] / "docs" / "examples"
E, NU, R = 1e9, 0.3, 0.1
CORNERS = ((0, 0), (1, 0), (1, 1), (0, 1))


def hexahedra(lines):
    """Points and cells of a box between mesh lines; z up, the top is the last plane."""
    points = np.stack(np.meshgrid(*lines, indexing="ij"), axis=-1).reshape(-1, 3)
    number = np.arange(len(points)).reshape([len(line) for line in lines])
    n = [len(line) - 1 for line in lines]
    cells = [
        number[i : i + n[0], j : j + n[1], k : k + n[2]].ravel() for k in (0, 1) for i, j in CORNERS
    ]
    return points, np.stack(cells, axis=-1), number


def sides(number):
    """Return the quadrilaterals of the top, the bottom and the four walls."""
    parts = {"top": number[:, :, -1], "bottom": number[:, :, 0], "x0": number[0]}
    parts |= {"x1": number[-1], "y0": number[:, 0], "y1": number[:, -1]}
    return {
        name: np.stack(
            [s[i : i + s.shape[0] - 1, j : j + s.shape[1] - 1].ravel() for i, j in CORNERS], 1
        )
        for name, s in parts.items()
    }


LINES = (np.linspace(-1.0, 1.0, 7), np.linspace(-1.0, 1.0, 7), np.linspace(-1.0, 0.0, 5))


def write(path, lines=LINES, turn=None, change=None):
    """Write a block of 2 x 2 x 1 in the format that the ending names, with names on its sides."""
    points, cells, number = hexahedra(lines)
    quads = sides(number)
    if turn is not None:
        points = points @ turn.T
    if change is not None:
        points, cells = change(points, cells)
    if path.suffix == ".msh":
        tags = [np.full(len(q), k) for k, q in enumerate(quads.values(), 1)]
        physical = [np.concatenate(tags), np.full(len(cells), 9)]
        mesh = meshio.Mesh(
            points,
            [("quad", np.concatenate(list(quads.values()))), ("hexahedron", cells)],
            cell_data={"gmsh:physical": physical, "gmsh:geometrical": physical},
            field_data={name: np.array([k, 2]) for k, name in enumerate(quads, 1)},
        )
        meshio.write(path, mesh, file_format="gmsh22")
    elif path.suffix == ".inp":
        sets = {name: np.unique(q) for name, q in quads.items()}
        meshio.write(path, meshio.Mesh(points, [("hexahedron", cells)], point_sets=sets))
    else:
        everything = np.concatenate(list(quads.values()))
        start = np.cumsum([0, *(len(q) for q in quads.values())])
        marks = {}
        for k, name in enumerate(quads):
            mark = np.zeros(len(everything), dtype=np.int64)
            mark[start[k] : start[k + 1]] = 1
            marks[name] = [mark, np.zeros(len(cells), dtype=np.int64)]
        blocks = [("quad", everything), ("hexahedron", cells)]
        meshio.write(path, meshio.Mesh(points, blocks, cell_data=marks))
    return path


def tables(file, **body):
    return {
        "name": "own-body",
        "half_space": {"youngs_modulus": E, "poisson_ratio": NU},
        "indenter": {"shape": "paraboloid", "radius": R},
        "body": {"file": file, "length_unit": "mm", "contact_surface": "top"}
        | {"supports": {"bottom": "fixed"}}
        | body,
        "loading": {"penetration": [2e-6, 4e-6]},
    }


def scene(tmp_path, file="block.msh", **body):
    return make_scene(tables(file, **body), "test", tmp_path)


def problems_of(tmp_path, **body):
    with pytest.raises(SceneError) as caught:
        plan_scene(scene(tmp_path, **body))
    return "\n".join(caught.value.problems)


@pytest.mark.filterwarnings("ignore::UserWarning")
def test_abaqus_surfaces_name_faces_of_element_sets(solved, tmp_path):
    """As Abaqus/CAE writes them: the same faces, and the same force, as the node set of the top.

    A surface by element numbers is none, and says what names there are.
    """
    path = write(tmp_path / "block.inp")
    top = np.arange(4, 6 * 6 * 4 + 1, 4)  # the uppermost of each column of four cells
    rows = [", ".join(map(str, top[k : k + 12])) for k in range(0, len(top), 12)]
    lines = ["*ELSET, ELSET=_roof_S2, INTERNAL", *rows]
    lines += ["*Surface, type=ELEMENT, name=roof", "_ROOF_S2, S2", "** a comment"]
    lines += ["*SURFACE, NAME=floor, TYPE=NODE", "bottom, 1.0"]
    lines += ["*SURFACE, NAME=numbered", "109, S2"]
    path.write_text(path.read_text() + "\n".join(lines) + "\n")
    by_sets = solved(scene(tmp_path, "block.inp"), "fem")
    named = {"contact_surface": "roof", "supports": {"floor": "fixed"}}
    by_surfaces = solved(scene(tmp_path, "block.inp", **named), "fem")
    np.testing.assert_array_equal(by_surfaces.quantities["force"], by_sets.quantities["force"])
    assert "roof" in problems_of(tmp_path, file="block.inp", contact_surface="numbered")


@pytest.mark.parametrize(("kind", "count"), [("tetra", 4), ("hexahedron", 6)])
def test_abaqus_faces_are_all_faces_of_a_cell(kind, count):
    """Each corner pair of an edge is in two faces; opposite quadrilaterals share nothing."""
    faces = FACES[kind]
    assert len({frozenset(face) for face in faces}) == count
    edges = [frozenset((a, b)) for f in faces for a, b in zip(f, (*f[1:], f[0]), strict=True)]
    assert all(edges.count(edge) == 2 for edge in edges)


def test_gmsh_abaqus_and_vtu_files_of_one_body_in_any_unit_are_one_body(solved, tmp_path):
    """The same block four times: the same force to the digits that a text file keeps."""
    write(tmp_path / "metres.msh", [1e-3 * line for line in LINES])
    (msh, *others) = [
        solved(scene(tmp_path, write(tmp_path / f"block{ending}").name), "fem").quantities["force"]
        for ending in (".msh", ".inp", ".vtu")
    ]
    others.append(solved(scene(tmp_path, "metres.msh", length_unit="m"), "fem").quantities["force"])
    for force in others:
        np.testing.assert_allclose(force, msh, rtol=1e-9)


def quarter_turns():
    """Rotations that bring the top (+z) of the block to each of the six sides."""
    x = np.array([[0, 0, 1], [0, 1, 0], [-1, 0, 0]], dtype=float)
    y = np.array([[1, 0, 0], [0, 0, 1], [0, -1, 0]], dtype=float)
    return {"-x": x, "+x": x.T, "-y": y, "+y": y.T, "-z": np.eye(3), "+z": y @ y}


@pytest.mark.parametrize("direction", quarter_turns())
def test_a_body_may_lie_on_any_side(solved, tmp_path, direction):
    """Turned in space, it carries the same force; its results come back in the file's axes."""
    write(tmp_path / "upright.msh")
    write(tmp_path / "block.msh", turn=quarter_turns()[direction])
    upright = solved(scene(tmp_path, "upright.msh"), "fem", with_body=True)
    turned = solved(scene(tmp_path, direction=direction), "fem", with_body=True)
    force = upright.quantities["force"]
    np.testing.assert_allclose(turned.quantities["force"], force, rtol=1e-9)
    back = mesh_of(turned.fields)
    raw = meshio.read(tmp_path / "block.msh")
    np.testing.assert_allclose(back.points.min(0), 1e-3 * raw.points.min(0), atol=1e-12)
    np.testing.assert_allclose(back.points.max(0), 1e-3 * raw.points.max(0), atol=1e-12)
    corners = back.points[back.cells[0].data]
    assert (np.linalg.det(corners[:, [1, 3, 4]] - corners[:, [0]]) > 0).all()
    moved = back.point_data["displacement"]
    along = "xyz".index(direction[1])
    assert np.abs(moved[:, along]).max() == pytest.approx(
        np.abs(mesh_of(upright.fields).point_data["displacement"][:, 2]).max(), rel=1e-6
    )


def test_a_rigid_plane_compresses_a_block_uniformly(solved, tmp_path):
    """Without an [indenter] a plane presses: F = E A d / H on rollers, exactly (patch test)."""
    write(tmp_path / "block.msh")
    data = tables("block.msh", supports={"bottom": "z", "x0": "roller", "y0": "roller"})
    del data["indenter"]
    solution = solved(make_scene(data, "test", tmp_path), "fem")
    exact = E * 4e-6 * np.array([2e-6, 4e-6]) / 1e-3
    np.testing.assert_allclose(solution.quantities["force"][0], exact, rtol=1e-9)
    np.testing.assert_allclose(solution.quantities["contact_area"][0], 4e-6, rtol=1e-9)


def test_a_quarter_stands_for_the_whole(solved, tmp_path):
    """Rollers on two planes of symmetry, and the forces of four parts."""
    write(tmp_path / "block.msh")
    write(tmp_path / "quarter.msh", (LINES[0][3:], LINES[1][3:], LINES[2]))
    whole = solved(scene(tmp_path), "fem")
    supports = {"bottom": "fixed", "x0": "roller", "y0": "y"}
    own = {"supports": supports, "symmetric_parts": 4, "position": [0, 0]}
    quarter = solved(scene(tmp_path, "quarter.msh", **own), "fem")
    for name in ("force", "energy", "stiffness", "contact_area_raw"):
        np.testing.assert_allclose(
            quarter.quantities[name], whole.quantities[name], rtol=1e-9, err_msg=name
        )


def test_the_surface_itself_is_part_of_the_gap(solved, tmp_path):
    """A crowned block under a plane is a flat one under the same crown: the same contact.

    The crown is 1e-3 high, so the difference of the meshes is of that order.
    """

    def crown(points, cells):
        lowered = points.copy()
        lowered[:, 2] -= 0.5e-2 * (points[:, :2] ** 2).sum(axis=1) * (1.0 + points[:, 2])
        return lowered, cells

    write(tmp_path / "crowned.msh", change=crown)
    write(tmp_path / "block.msh")
    data = tables("crowned.msh")
    del data["indenter"]
    crowned = solved(make_scene(data, "test", tmp_path), "fem").quantities["force"]
    flat = solved(scene(tmp_path), "fem").quantities["force"]
    np.testing.assert_allclose(crowned, flat, rtol=0.01)


def test_half_space_methods_say_that_the_body_is_finite(planned, tmp_path):
    write(tmp_path / "block.msh")
    plans = planned(scene(tmp_path))
    assert plans["fem"].resolutions == (1, 2)
    assert "held by its supports; no far field" in plans["fem"].modelled
    for name in ("closed_form", "bem_dense", "bem_fft"):
        assert not plans[name].supported
        assert plans[name].reason == "models a half-space, and the [body] is finite"
    assert plans["reduced"].supported
    assert "half-space" in plans["reduced"].reason


@pytest.mark.slow
def test_a_large_body_is_solved_by_multigrid_and_the_plan_says_so(solved, tmp_path, monkeypatch):
    """The same forces to 1e-7; which solver from which size on, and what it cannot do."""
    write(tmp_path / "block.msh")
    for load in ({"penetration": [2e-6, 4e-6]}, {"force": [1e-4, 1e-3]}):
        data = tables("block.msh") | {"loading": load}
        made = make_scene(data, "test", tmp_path)
        chosen = make_scene(
            data | {"methods": {"fem": {"solver": "conjugate_gradients"}}}, "test", tmp_path
        )
        both = solved(made, "fem"), solved(chosen, "fem")
        for name in ("force", "penetration", "stiffness", "energy"):
            direct, iterated = (solution.quantities[name] for solution in both)
            np.testing.assert_allclose(iterated, direct, rtol=1e-7, err_msg=name)
    (plan,) = plan_scene(made)
    solver, geometry = solver_for("fem", made), plan.geometry
    assert "above 200 000 unknowns solved by conjugate gradients" in solver.model(geometry)
    assert "by conjugate gradients" in solver_for("fem", chosen).model(geometry)
    monkeypatch.setattr(user_body.FemBody, "most_factorised", 100)
    task = task_of(plan, "fem", 1)
    larger = execute(task, 1).quantities["force"]
    np.testing.assert_allclose(larger, both[0].quantities["force"], rtol=1e-7)
    assert not solver.refusal(task)
    monkeypatch.setattr(user_body, "MOST_ITERATED", 1e2)
    assert "nodes in contact" in solver.refusal(task)
    monkeypatch.setattr(user_body.FemBody, "largest_poisson", 0.2)
    limited = type(solver)(made)
    assert "more than 100" in limited.refusal(task)
    assert "nu above 0.2: many steps" in limited.model(geometry)


def test_cells_that_would_lock_are_refused(planned, tmp_path):
    """A displacement form on hexahedra goes to 0.4999, whatever their order."""
    write(tmp_path / "block.msh")
    data = tables("block.msh") | {"half_space": {"shear_modulus": E, "poisson_ratio": 0.49995}}
    fem = planned(make_scene(data, "test", tmp_path))["fem"]
    assert not fem.supported
    assert "0.4999" in fem.reason


def test_material_may_stand_in_the_body(tmp_path):
    write(tmp_path / "block.msh")
    data = tables("block.msh")
    data["body"] |= data.pop("half_space")
    moved = make_scene(data, "test", tmp_path)
    assert moved == scene(tmp_path)
    assert parse_scene(moved.text, "test", tmp_path) == moved
    del data["body"]["poisson_ratio"]
    with pytest.raises(SceneError, match=r"body: expected youngs_modulus and poisson_ratio"):
        make_scene(data, "test", tmp_path)


def test_names_with_spaces_survive_the_canonical_text(tmp_path):
    made = scene(tmp_path, supports={"left side": "xy", 'a "b"': ["z"]})
    assert made.body.supports == {"left side": "xy", 'a "b"': "z"}
    assert parse_scene(made.text, "test", tmp_path) == made


def test_the_example_runs_from_its_scene_file(script, tmp_path):
    """The block of docs/examples: its script makes the shipped file, and `solve` its fields."""
    script("block_mesh").main(str(tmp_path))
    shipped = (EXAMPLES / "block.msh").read_bytes()
    assert (tmp_path / "block.msh").read_bytes() == shipped
    shutil.copy(EXAMPLES / "block.toml", tmp_path)
    result = solve_scene(str(tmp_path / "block.toml"), "fem", 1, with_fields=True)
    assert result.converged, result.reasons
    result.to_vtu(tmp_path / "block.vtu")
    mesh = meshio.read(tmp_path / "block.vtu")
    assert mesh.point_data["von_mises"].max() > 0
    assert load_scene(EXAMPLES / "block.toml").body.symmetric_parts == 4


def test_missing_and_wrong_keys_are_all_listed(tmp_path):
    data = tables("block.msh", supports={"bottom": "glued"}, direction="down", colour="red")
    del data["body"]["length_unit"]
    del data["body"]["contact_surface"]
    data["body"]["symmetric_parts"] = 4
    with pytest.raises(SceneError) as caught:
        make_scene(data, "test", tmp_path)
    text = "\n".join(caught.value.problems)
    for part in (
        "body.length_unit: expected, but missing",
        "body.contact_surface: expected, but missing",
        'body.supports.bottom: expected "fixed", "roller", or held directions',
        "body.direction: expected '+x', '-x'",
        "body.colour: unknown key",
        "body.position: expected, because the mesh is a part",
    ):
        assert part in text, part


def inverted(points, cells):
    cells = cells.copy()
    cells[7, :4], cells[7, 4:] = cells[7, 4:].copy(), cells[7, :4].copy()
    return points, cells


def bent(points, cells):
    return points - 0.8 * np.abs(points[:, :1]) * [0, 0, 1], cells


def doubled(points, cells):
    return np.concatenate([points, points + 5.0]), np.concatenate([cells, cells + len(points)])


ASKEW = np.array([[0.8, -0.6, 0], [0.6, 0.8, 0], [0, 0, 1.0]])


@pytest.mark.parametrize(
    ("block", "body", "said"),
    [
        ({}, {"contact_surface": "lid"}, "body.contact_surface: expected one of the file's names"),
        ({}, {"supports": {"floor": "fixed"}}, "supports.floor: expected one of the file's names"),
        ({"change": inverted}, {}, "got 1 of 144 inverted or flat (numbered from 0: 7)"),
        ({}, {"direction": "+z"}, "and the outward normal is (0, 0, 1)"),
        ({}, {"direction": "-x"}, "expected to face the indenter; the indenter moves along"),
        ({"change": bent}, {}, "that lean up to 39 degrees"),
        ({}, {"supports": {"bottom": "z"}}, "translation along x, translation along y, rotation"),
        ({}, {"supports": {"x0": "fixed"}}, "held along the indenter's direction"),
        (
            {"turn": ASKEW},
            {"supports": {"bottom": "fixed", "x0": "roller"}},
            "body.supports.x0: expected plane faces across x, y or z for a roller",
        ),
        ({}, {"position": ["3 mm", 0]}, "position: expected a place on the surface (-0.001 to"),
        ({"change": doubled}, {}, "expected one connected body, got 2 separate pieces"),
        *(
            ({}, {"length_unit": unit}, "body.length_unit: expected the unit of the file")
            for unit in ("furlong", "N", "", 3, "1 mm", "0 mm")
        ),
    ],
)
def test_a_body_that_cannot_be_held_or_pressed_is_refused(tmp_path, block, body, said):
    write(tmp_path / "block.inp", **block)
    assert said in problems_of(tmp_path, file="block.inp", **body)


@pytest.mark.parametrize("content", [b"", b"$MeshFormat\n9 9 9\n", b"\x00\xff" * 50])
def test_files_that_are_no_mesh_are_said_to_be_none(tmp_path, content, capfd):
    """The reader prints and would end the program; neither may reach the user."""
    (tmp_path / "block.msh").write_bytes(content)
    assert "body.file: block.msh is no mesh that meshio reads" in problems_of(tmp_path)
    assert capfd.readouterr() == ("", "")


def test_missing_files_and_other_cells_are_named(tmp_path):
    assert "which is no file" in problems_of(tmp_path, file="nowhere.msh")
    wedge = [[0, 1, 2, 3, 4, 5]]
    points = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1], [1, 0, 1], [0, 1, 1]], float)
    meshio.write(tmp_path / "wedge.vtu", meshio.Mesh(points, [("wedge", wedge)]))
    assert "got 1 wedge" in problems_of(tmp_path, file="wedge.vtu")
    meshio.write(tmp_path / "flat.vtu", meshio.Mesh(points, [("triangle", [[0, 1, 2]])]))
    assert "got no volume cells" in problems_of(tmp_path, file="flat.vtu")


def test_tables_that_do_not_go_together_are_refused(tmp_path):
    data = tables("block.msh")
    data["half_space"] = {"effective_modulus": 1e9}
    data["surface"] = {"kind": "map", "file": "a.csv"}
    data["loading"] = {"mean_gap": [1e-6]}
    del data["indenter"]
    with pytest.raises(SceneError) as caught:
        make_scene(data, "test", tmp_path)
    text = "\n".join(caught.value.problems)
    assert "surface: expected an [indenter] with a [body]" in text
    assert "a finite body needs two elastic constants" in text
    assert "a [body] has no mean gap" in text
    plain = {**tables("x"), "compare": {"resolutions": [1, 2]}}
    del plain["body"]
    with pytest.raises(SceneError, match="or equal to 2 without a"):
        make_scene(plain, "test", tmp_path)
