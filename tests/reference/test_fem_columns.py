"""Finite elements that repeat from cell to cell: the assembled problem, transforms, contacts."""

from functools import partial

import numpy as np
import pytest
from scipy.sparse import csr_array, hstack
from scipy.sparse.linalg import spsolve
from skfem import Basis, BilinearForm, ElementHex2, ElementVector, MeshHex, asm
from skfem.element import ElementDG

from reference.contact.press import assemble, sweep
from reference.errors import ConvergenceError
from reference.fem import Enforcement, Material, grid_body
from reference.fem.columns import ELEMENTS, compliance, elements_of
from reference.fem.grid_body import FreeBody, PeriodicBody
from reference.halfspace import FreeOperator, PeriodicOperator
from reference.halfspace.areas import located_area
from reference.layered import Graded, Stack
from reference.loads import Load
from reference.surfaces import SelfAffine, refine, self_affine

SPACING = 1.0, 1.4


def hats(x, nodes, period):
    """Periodic piecewise linear functions at x, one column a node."""
    apart = (x[:, None] - nodes + period / 2) % period - period / 2
    step = period / len(nodes)
    return np.maximum(1 - np.abs(apart) / step, 0.0)


def splines(x, nodes, period):
    """Periodic quadratic B-splines at x, one column a node in the middle of a cell."""
    step = period / len(nodes)
    apart = np.abs((x[:, None] - nodes + period / 2) % period - period / 2) / step
    inner = 0.75 - apart**2
    outer = 0.5 * np.maximum(1.5 - apart, 0.0) ** 2
    return np.where(apart < 0.5, inner, outer)


def quadratics(z, lines):
    """Quadratic shape functions on the intervals of `lines`, one column a node."""
    nodes = np.sort(np.concatenate([lines, (lines[1:] + lines[:-1]) / 2]))
    values = np.zeros((len(z), len(nodes)))
    for k in range(len(lines) - 1):
        inside = (z >= lines[k] - 1e-12) & (z <= lines[k + 1] + 1e-12)
        s = (z[inside] - lines[k]) / (lines[k + 1] - lines[k])
        values[inside, 2 * k] = (1 - s) * (1 - 2 * s)
        values[inside, 2 * k + 1] = 4 * s * (1 - s)
        values[inside, 2 * k + 2] = s * (2 * s - 1)
    return values


def in_plane(element, points, axis, sides):
    """Return shape functions at points along an axis, and pressures by their degree in a cell."""
    n, step = sides[axis], SPACING[axis]
    edges, middles = np.arange(n) * step, (np.arange(n) + 0.5) * step
    cell = np.floor(points / step)
    mine = (cell.astype(int)[:, None] == np.arange(n)).astype(float)
    if element == "linear":
        return hats(points, edges, n * step), [mine]
    if element == "splines":
        return splines(points, middles, n * step), [hats(points, edges, n * step)]
    shapes = quadratics(points % (n * step), np.append(edges, n * step))
    shapes[:, 0] += shapes[:, -1]
    return shapes[:, :-1], [mine, mine * (2 * points / step - 2 * cell - 1)[:, None]]


def cells_along(element, n):
    """Return the forces of a pressure on the first cell, and the centres of cells by the nodes."""
    force, read = np.zeros(n), np.eye(n)
    if element == "quadratic":
        force, read = np.zeros(2 * n), np.eye(2 * n)[1::2]
        force[:3] = 1 / 6, 4 / 6, 1 / 6
    elif element == "linear":
        force[[-1, 0, 1]] = 1 / 8, 6 / 8, 1 / 8
    else:
        force[[-1, 0, 1]] = 1 / 6, 4 / 6, 1 / 6
        read = 6 / 8 * read + (np.roll(read, 1, 0) + np.roll(read, -1, 0)) / 8
    return force, read


def together(x, y, z):
    """Products of functions of x, y and z at the same points, (points, all)."""
    return csr_array(
        (x[:, :, None, None] * y[:, None, :, None] * z[:, None, None, :]).reshape(len(x), -1)
    )


@BilinearForm
def deviator(u, v, _):
    grad, test = u.grad, v.grad
    return 0.5 * np.sum(
        (grad + grad.transpose(1, 0, 2, 3)) * (test + test.transpose(1, 0, 2, 3)), (0, 1)
    )


@BilinearForm
def volume(u, p, _):
    return (u.grad[0, 0] + u.grad[1, 1] + u.grad[2, 2]) * p


@BilinearForm
def mass(p, q, _):
    return p * q


def bases(lines, sides):
    """Return scikit-fem's 27-node displacements and discontinuous pressures of one mesh."""
    x, y = (np.arange(n + 1) * step for n, step in zip(sides, SPACING, strict=True))
    mesh = MeshHex.init_tensor(x, y, lines)
    basis = Basis(mesh, ElementVector(ElementHex2()), intorder=5)
    return basis, basis.with_element(ElementDG(ElementHex2()))


def displacements(basis, element, lines, sides):
    """Return 27-node displacements as combinations of ours, (theirs, ours), by component."""
    shapes = [in_plane(element, basis.doflocs[axis], axis, sides)[0] for axis in (0, 1)]
    move = together(*shapes, quadratics(basis.doflocs[2], lines)).tocoo()
    component = np.empty(basis.N, dtype=int)
    component[basis.element_dofs] = (np.arange(len(basis.element_dofs)) % 3)[:, None]
    columns = move.col + move.shape[1] * component[move.row]
    return csr_array((move.data, (move.row, columns)), (basis.N, 3 * move.shape[1]))


def pressures_of(basis, element, lines, sides):
    mesh = basis.mesh
    low, high = mesh.p[:, mesh.t].min(1), mesh.p[:, mesh.t].max(1)
    # the mesh turns the local axes as it likes
    inside = basis.mapping.F(ElementHex2().doflocs.T).transpose(0, 2, 1)
    # a hair inside their own cell
    inside = inside + 1e-12 * ((low + high)[:, None] / 2 - inside)
    place, layer = np.empty((3, basis.N)), np.empty(basis.N, dtype=int)
    place[:, basis.element_dofs] = inside
    layer[basis.element_dofs] = np.searchsorted(lines, (low[2] + high[2]) / 2) - 1
    depth = (place[2] - lines[layer]) / np.diff(lines)[layer]
    mine = (layer[:, None] == np.arange(len(lines) - 1)).astype(float)
    deep = [mine, mine * (2 * depth - 1)[:, None]]
    x, y = (in_plane(element, place[axis], axis, sides)[1] for axis in (0, 1))
    modes = [(0, 0, 0), (0, 0, 1), *([(1, 0, 0), (0, 1, 0)] if len(x) > 1 else [])]
    return hstack([together(x[i], y[j], deep[k]) for i, j, k in modes], format="csr")


def assembled(element, nu, lines, sides):
    """Displacement of the cells under unit pressure on the first, E = 1, nu < 0.5, clamped below.

    scikit-fem's matrices of 27-node hexahedra, of whose functions ours are combinations.
    """
    basis, discontinuous = bases(lines, sides)
    move = displacements(basis, element, lines, sides)
    press = pressures_of(discontinuous, element, lines, sides)
    shear = 1 / (2 + 2 * nu)
    stiffness = shear * (move.T @ asm(deviator, basis) @ move)
    coupling = press.T @ asm(volume, basis, discontinuous) @ move
    stored = press.T @ asm(mass, discontinuous) @ press
    ratio = 2 * nu / (1 - 2 * nu) * shear
    stiffness = stiffness + ratio * coupling.T @ spsolve(stored.tocsc(), coupling.tocsc())
    (pull_x, at_x), (pull_y, at_y) = (cells_along(element, n) for n in sides)
    shape = 3, pull_x.size, pull_y.size, 2 * len(lines) - 1
    index = np.arange(np.prod(shape)).reshape(shape)
    free = index[..., :-1].ravel()
    load = np.zeros(index.size)
    load[index[2, :, :, 0]] = np.outer(pull_x, pull_y) * np.prod(SPACING)
    answer = np.zeros(index.size)
    answer[free] = spsolve(stiffness.tocsc()[free][:, free], load[free])
    return at_x @ answer[index[2, :, :, 0]] @ at_y.T


@pytest.mark.parametrize("element", ELEMENTS)
@pytest.mark.parametrize(
    ("nu", "sides"),
    [
        (0.3, (3, 3)),
        *(pytest.param(nu, (8, 8), marks=pytest.mark.slow) for nu in (0.0, 0.3, 0.45, 0.4999)),
    ],
)
def test_waves_one_by_one_are_the_assembled_problem(element, nu, sides):
    """The same functions, so the same answer but for rounding.

    The assembled matrices lose up to lambda/mu of their digits: 1e-12 grows with it.
    """
    layers = Stack([8.0], [Material(1.0, nu)])
    depths = {"first": 0.6, "growth": 1.5}
    lines = np.concatenate([[0.0], np.cumsum([t for t, _ in elements_of(layers, **depths)])])
    waves = 2 * np.pi * np.fft.fftfreq(sides[0])[:, None], 2 * np.pi * np.fft.rfftfreq(sides[1])
    columns = np.fft.irfft2(compliance(waves, SPACING, layers, element=element, **depths), sides)
    expected = assembled(element, nu, lines, sides)
    tolerance = 1e-12 * max(1.0, 2 * nu / (1 - 2 * nu))
    assert len(lines) == 6
    assert np.abs(columns - expected).max() < tolerance * np.abs(expected).max()


def half_space(q, nu):
    return 2 * (1 - nu**2) / q


@pytest.mark.parametrize(
    ("element", "order", "at_four"),
    [("linear", 2, 0.13), ("splines", 4, 0.011), ("quadratic", 4, 0.005)],
)
@pytest.mark.parametrize("nu", [0.3, 0.45, 0.5])
def test_elements_alone_disperse_with_their_own_order(element, order, at_four, nu):
    """Pressures that are the waves: energies err by the square of slopes, and are too low."""
    body = Stack([200.0], [Material(1.0, nu)])
    q = 2 * np.pi / np.array([16.0, 8.0, 4.0])
    values = compliance((q, 0 * q), (1.0, 1.0), body, element=element, growth=1.08, smooth=True)
    errors = 1 - values / half_space(q, nu)
    assert np.all(errors > 0)
    assert errors[2] < at_four
    assert np.log2(errors[2] / errors[1]) == pytest.approx(order, abs=0.7)


@pytest.mark.parametrize("element", ["splines", "quadratic"])
@pytest.mark.parametrize(
    ("ratio", "within"), [(1e-3, 1e-5), (0.1, 1e-5), (10.0, 1e-5), (100.0, 5e-5), (1e3, 1e-4)]
)
def test_coatings_have_the_closed_transform(element, ratio, within):
    """32 cells a wave, from a sixteenth to once the wave; a hard plate bends like (q h)^4."""
    q = 2 * np.pi / np.array([32.0])
    base = Material(1.0, 0.3)
    for nu in (0.0, 0.5):
        for thickness in (2.0, 8.0, 30.0):
            coating = Material(ratio, nu)
            exact = Stack([thickness], [coating], base).compliance(q)
            body = Stack([thickness, 300.0], [coating, base])
            waves = 0.6 * q, 0.8 * q
            value = compliance(waves, (1.0, 1.0), body, element=element, growth=1.08, smooth=True)
            assert value == pytest.approx(exact, rel=within)


def test_uniform_pressure_squeezes_a_layer():
    """At q = 0: thickness (1 - 2 nu)(1 + nu)/(E (1 - nu)), layer by layer, to rounding."""
    still = (np.zeros(1), np.zeros(1))
    body = Stack([2.0, 5.0], [Material(3.0, 0.3), Material(0.5, 0.0)])
    expected = 2.0 * 0.4 * 1.3 / (3.0 * 0.7) + 5.0 / 0.5
    assert compliance(still, (1.0, 1.0), body)[0] == pytest.approx(expected, rel=1e-12)
    rigid = Stack([2.0], [Material(3.0, 0.5)])
    assert abs(compliance(still, (1.0, 1.0), rigid)[0]) < 1e-12


def test_needle_cells_and_any_units_give_the_same_digits():
    waves = (np.array([0.3, 2.0]), np.array([1.0, 0.1]))
    body = Stack([50.0], [Material(2.0, 0.3)])
    value = compliance(waves, (1.0, 30.0), body)
    tiny = compliance(waves, (1e-9, 30e-9), Stack([50e-9], [Material(2e9, 0.3)]))
    assert np.isfinite(value).all()
    assert tiny == pytest.approx(value * 1e-18, rel=1e-12)
    assert np.all(value > 0)


@pytest.mark.parametrize("nu", [0.0, 0.3, 0.5])
@pytest.mark.parametrize(("element", "order"), [("linear", 2), ("splines", 4), ("quadratic", 4)])
def test_shallow_mesh_on_an_impedance_is_a_half_space_with_the_order_of_its_elements(
    element, order, nu
):
    """Oblique waves on two cells of mesh; what the elements err by grows with its share."""
    material = Material(2.0, nu)
    q = 2 * np.pi / np.array([800.0, 16.0, 8.0])
    waves, exact = (0.8 * q, -0.6 * q), half_space(q, nu) / 2.0
    shallow, deeper = (
        compliance(waves, (1.0, 1.0), layers, element=element, growth=1.08, smooth=True)
        for layers in (Stack([t], [material], material) for t in (2.0, 8.0))
    )
    clamped = compliance(
        waves, (1.0, 1.0), Stack([1600.0], [material]), element=element, growth=1.08, smooth=True
    )
    errors, whole = (np.abs(value / exact - 1) for value in (shallow, clamped))
    # no floor from the growth of layers: a hundredth of what the clamped mesh has
    assert errors[0] < (3e-2 if element == "linear" else 1e-4) * whole[0]
    assert np.log2(errors[2] / errors[1]) > order - 0.5
    # eight cells below a wave of eight nothing is left of the bottom
    np.testing.assert_allclose(deeper[2], clamped[2], rtol=5e-5)


def test_bodies_on_an_impedance_answer_as_clamped_ones():
    """Clamped two periods down the floor of growing layers is left: 1e-5 of the longest waves."""
    hard, soft = Material(100.0, 0.2), Material(1.0, 0.3)
    for kind, body in ((PeriodicBody, Stack([0.02], [hard], soft)), (FreeBody, soft)):
        grid = (16, 48), (1 / 16, 1 / 48), body
        clamped, ended = (kind(*grid, bottom=end) for end in ("clamped", "impedance"))
        np.testing.assert_allclose(ended.elastic, clamped.elastic, rtol=2e-5)
        assert ended.softened(1.0).bottom == ended.coarser().bottom == "impedance"
    for body in (Stack([1.0], [soft]), Graded(soft, 0.3, 1.0)):
        with pytest.raises(ValueError, match="no half-space of one modulus"):
            PeriodicBody((4, 4), (1.0, 1.0), body, bottom="impedance")


STEEL = Material(1 - 0.3**2, 0.3)  # effective modulus 1


def ball(radius, shift=(0.0, 0.0)):
    """Return the gap of a paraboloid that touches a round of `radius` cells, curvature 1/100."""
    n = int(2.6 * radius) + 4
    x, y = (np.arange(n) - (n - 1) / 2 + s for s in shift)
    return (x[:, None] ** 2 + y**2) / 200


@pytest.mark.parametrize(
    ("element", "nu"), [("splines", 0.0), ("linear", 0.0), ("linear", 0.5), ("quadratic", 0.5)]
)
def test_area_inside_the_contact_line_of_hertz(element, nu):
    """The rim lies on Hertz's circle to 0.008 cells, with the excess of every element taken away.

    Without, hats with nu = 1/2 put it 0.05 cells too far out, splines with nu = 0 0.013 too far in.
    Mean over places on the grid, whose scatter is 0.005 cells, and 0.002 in the mean.
    """
    rng = np.random.default_rng(5)
    errors = []
    for radius in np.linspace(5, 12, 8):
        gap = ball(radius, rng.uniform(-0.5, 0.5, 2))
        body = FreeBody(gap.shape, (1.0, 1.0), Material(1 - nu**2, nu), element)
        load = Load("force", 4 / 3 * radius**3 / 100)
        (contact,) = grid_body.sweep(body, gap - gap.min(), load)
        errors.append((located_area(contact) / (np.pi * radius**2) - 1) * radius / 2)
    assert abs(np.mean(errors)) < 0.008
    assert np.std(errors) < 0.02


def rough(n):
    """Return a periodic gap whose shortest wave has four points on 32."""
    spectrum = SelfAffine(power=3.6, rms_height=1.0, short_cutoff=4.0)
    heights = refine(self_affine(32, 32.0, spectrum, seed=0, realisation=0), n // 32)
    return heights.max() - heights


@pytest.mark.parametrize("periodic", [True, False])
def test_rough_contact_converges_to_the_half_space(periodic):
    """Elements and half-space on the same cells, by one iteration: differences fall with them."""
    differences = []
    area = partial(located_area, patch=True)
    for n in (32, 64, 128):
        gap, spacing = rough(n), (32 / n, 32 / n)
        load = Load("force", np.array([0.02, 0.1]) * 32**2)
        kind = PeriodicOperator if periodic else FreeOperator
        half = list(sweep(kind(gap.shape, spacing, 1.0), gap, load))
        body = (PeriodicBody if periodic else FreeBody)(gap.shape, spacing, STEEL)
        elements = list(grid_body.sweep(body, gap, load))
        differences.append(
            [
                (abs(a.penetration / b.penetration - 1), abs(area(a) / area(b) - 1))
                for a, b in zip(elements, half, strict=True)
            ]
        )
    coarse, _, fine = np.array(differences)
    assert np.all(fine[:, 0] < 1.5e-3)
    assert np.all(fine[:, 1] < 1.5e-2)
    # two halvings: first order and more (penetrations count from the highest point of a grid)
    assert np.all(fine[:, 0] < coarse[:, 0] / 4)
    assert np.all(fine[:, 1] < coarse[:, 1] / 3)


@pytest.mark.parametrize(
    ("sides", "element", "nu"),
    [
        *(((1.0, 1.0), element, nu) for element in ("linear", "splines") for nu in (0.3, 0.5)),
        pytest.param((1.0, 1.0), "quadratic", 0.5, marks=pytest.mark.slow),
        pytest.param((1.0, 10.0), "splines", 0.5, marks=pytest.mark.slow),
        pytest.param((1.0, 10.0), "linear", 0.3, marks=pytest.mark.slow),
    ],
)
def test_free_patch_does_not_see_its_images(sides, element, nu):
    """Coefficients of a small grid are those of one whose images are twice as far away.

    At 64 long sides of cells elements and continuum differ by 1e-5 of what is under the load,
    where nu = 0.5 and cells are long by 3e-4.
    """
    small, large = (8, 8), tuple(max(8, int(100 * max(sides) / s)) for s in sides)
    one, two = (
        FreeBody(shape, sides, Material(1 - nu**2, nu), element).coefficients((8, 8))
        for shape in (small, large)
    )
    assert np.abs(one - two).max() < 5e-4 * two.max()


def test_what_is_lifted_beside_long_cells_is_seen():
    """Elements below cells of 1:30 raise the neighbours of a loaded one, which may touch then."""
    body = FreeBody((32, 32), (1.0, 30.0), Material(0.75, 0.5), "splines")
    gap = np.full((32, 32), 1.001)
    gap[16, 16] = 0.0
    (contact,) = grid_body.sweep(body, gap, Load("penetration", 1.0))
    anew = assemble(body, gap, contact.pressure, contact.penetration, 0, [0.0])
    assert not body.bounded
    assert anew.violation < 1e-7


def test_penalty_is_a_softer_body_and_multipliers_take_it_back():
    """Overlap of the penalty method falls as 1/eps; multipliers leave none."""
    gap, load = rough(32), Load("force", np.array([0.05 * 32**2]))
    body = PeriodicBody(gap.shape, (1.0, 1.0), STEEL)
    (exact,) = grid_body.sweep(body, gap, load)
    errors = []
    for eps in (1e1, 1e2, 1e3):
        (soft,) = grid_body.sweep(body, gap, load, Enforcement("penalty", eps))
        # every depth sinks by the overlap of the mean pressure, and the pressure moves too
        errors.append(soft.penetration - exact.penetration)
    assert np.all(np.array(errors) > 0)
    assert np.log10(errors[1] / errors[2]) == pytest.approx(1.0, abs=0.1)
    for control, value in (("force", exact.force), ("penetration", exact.penetration)):
        how = Enforcement("augmented_lagrangian", 1e2)
        (same,) = grid_body.sweep(body, gap, Load(control, value), how)
        assert same.force == pytest.approx(exact.force, rel=1e-6)
        assert same.penetration == pytest.approx(exact.penetration, rel=1e-6)
        assert same.violation < 1e-7
    (half,) = grid_body.sweep(body, gap, Load("mean_gap", exact.mean_gap), how)
    assert half.force == pytest.approx(exact.force, rel=1e-5)


def test_multipliers_answer_and_refuse_as_the_exact_method_does():
    """A flat face, first touch, one cell; a depth beyond the mean gap; too low a penalty."""
    body, how = PeriodicBody((8, 8), (1.0, 1.0), STEEL), Enforcement("augmented_lagrangian", 1e2)
    flat, bowl = np.zeros((8, 8)), rough(32)[::4, ::4] + 3.0
    for gap, load in (
        (flat, Load("force", 2.0)),
        (bowl, Load("penetration", 1.0)),
        (np.zeros((1, 1)), Load("force", 2.0)),
    ):
        below = body if gap.size > 1 else PeriodicBody((1, 1), (1.0, 1.0), STEEL)
        exact, same = (next(grid_body.sweep(below, gap, load, e)) for e in (Enforcement(), how))
        assert (same.force, same.penetration) == (exact.force, exact.penetration)
    with pytest.raises(ValueError, match="full contact"):
        next(grid_body.sweep(body, bowl, Load("penetration", 9.0), how))
    low = Enforcement("augmented_lagrangian", 1e-2)
    with pytest.raises(ConvergenceError, match="a larger one needs fewer"):
        next(grid_body.sweep(body, bowl, Load("force", 20.0), low))


@pytest.mark.parametrize("kind", [PeriodicBody, FreeBody])
def test_softer_coarser_and_smaller_bodies_are_what_they_are_made_of(kind):
    """Made from another body or from the start, the compliance is the same."""
    body = kind((8, 12), (1.0, 1.5), STEEL, "linear", 0.5)
    whole = kind((8, 12), (1.0, 1.5), STEEL, "linear", 0.75).transfer
    np.testing.assert_allclose(body.softened(0.25).transfer, whole, rtol=1e-13)
    coarser = kind((4, 6), (2.0, 3.0), STEEL, "linear", 0.5).transfer
    np.testing.assert_allclose(body.coarser().transfer, coarser, rtol=1e-13)
    if kind is FreeBody:
        smaller = kind((4, 5), (1.0, 1.5), STEEL, "linear", 0.5).transfer
        # the images that are taken away lie elsewhere: 1e-5 of what is under the load
        np.testing.assert_allclose(body.restrict((4, 5)).transfer, smaller, rtol=1e-4)
