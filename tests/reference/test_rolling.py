"""Steady rolling: Kalker's coefficients, Carter's plane, CONTACT's examples, a transient."""

import numpy as np
import pytest
from numpy.testing import assert_allclose

from reference.fem import Material
from reference.fem.columns import tensor
from reference.fem.grid_body import ShearBody
from reference.halfspace.friction import FrictionalPress, sweep
from reference.halfspace.traction import Compliance, NormalAndTangential
from reference.layered import Stack
from reference.loads import Load, LoadPath
from reference.rolling.creep_theories import EllipticContact, fastsim, linear, on_grid
from reference.rolling.roll import Creep, pressed, roll


def ball(cells, nu=0.5, friction=0.3, coupled=False, ahead=1):
    """Return a paraboloid of R = 1 that reaches 1 where it is pressed by 1, and its half-space."""
    side = 1.0 / cells
    x = (np.arange(-cells, cells + ahead) + 0.5) * side
    y = (np.arange(-cells, cells) + 0.5) * side
    compliance = Compliance.of(1.0, nu)
    body = NormalAndTangential((x.size, y.size), (side, side), compliance)
    return FrictionalPress(body, (x[:, None] ** 2 + y**2) / 2, friction, coupled)


def hertz_force(nu):
    return 4 / 3 * 2 / (1 - nu) * 0.9


@pytest.mark.slow
def test_creep_curve_of_contact_on_its_own_grid():
    """The example tractcurv of the public program CONTACT (Vollebregt & Kalker), cell for cell.

    F 106.7 kN, R 625 mm, a/b 0.5, G 82 GPa, nu 0.28, mu 0.33; printed to four digits.
    """
    press = contacts_press((0.2889, 0.6304), (48, 44), (0.8e-3, 0.2814e-3), 0.33)
    creeps = [Creep(c) for c in (4e-4, 8e-4, 24e-4, 28e-4, 32e-4)]
    steps = list(roll(press, Load("force", 106.7e3), creeps))
    tractions = [step.tangential_force / (0.33 * step.force) for step in steps]
    assert_allclose(tractions, [0.2588, 0.4742, 0.9467, 0.9832, 0.9976], atol=5e-5)
    assert [int(step.sticking.sum()) for step in steps] == [1182, 976, 262, 132, 32]
    assert_allclose(steps[0].pressure.max(), 640.7, atol=0.05)
    # its frictional power at 10 m/s
    power = [29.67, 120.7, 773.8, 942.1, 1096]
    assert_allclose([10 * step.loss for step in steps], power, rtol=1e-3)


@pytest.mark.slow
def test_spin_of_contact_on_its_own_grid():
    """CONTACT's example fastsim: a/b 2, lateral creep against spin, both 6.25e-4 (per mm)."""
    press = contacts_press((0.4, 0.2), (44, 44), (0.8464e-3, 2.406e-3), 0.3)
    (step,) = roll(press, Load("force", 82e3), [Creep(0.0, -6.25e-4, 6.25e-4)])
    assert_allclose(step.lateral_force / (0.3 * step.force), 0.6074, atol=5e-5)
    assert_allclose(step.moment, 4.821e4, rtol=1e-4)
    assert abs(step.tangential_force) < 1e-9 * step.force
    assert (int(step.sticking.sum()), int((step.pressure > 0).sum())) == (356, 1276)
    assert_allclose(30 * step.loss, 540.4, rtol=1e-3)


def contacts_press(spacing, shape, curvatures, friction):
    """Return a wheel of CONTACT's examples: G 82 GPa, nu 0.28, two bodies."""
    x, y = ((np.arange(n) - (n - 1) / 2) * s for n, s in zip(shape, spacing, strict=True))
    body = NormalAndTangential(shape, spacing, Compliance.of(41000.0, 0.28))
    gap = curvatures[0] * x[:, None] ** 2 + curvatures[1] * y**2
    return FrictionalPress(body, gap, friction, False)


def test_cattaneo_of_contact():
    """The example cattaneo: R 50, G 200, nu 0.42, mu 0.4, F_x = 7/8 mu F on cells of 2/15 a."""
    side = 2 / 15
    x = (np.arange(17) - 8) * side
    body = NormalAndTangential((17, 17), (side, side), Compliance.of(100.0, 0.42))
    press = FrictionalPress(body, (x[:, None] ** 2 + x**2) / 100, 0.4, False)
    force = 9.1954
    (step,) = sweep(press, LoadPath("force", force), LoadPath("tangential_force", 0.35 * force))
    assert_allclose(step.tangential_displacement, 8.155e-3, rtol=1e-3)
    assert_allclose(step.pressure.max(), 4.393, rtol=1e-3)
    assert (int(step.sticking.sum()), int((step.pressure > 0).sum())) == (45, 177)


def test_coulombs_law_holds_on_every_cell():
    press = ball(8, nu=0.25)
    creep = Creep(0.15, -0.1, 0.2)
    (step,) = roll(press, Load("force", hertz_force(0.25)), [creep])
    bound, size = press.friction * step.pressure, np.hypot(*step.traction)
    assert (size <= bound * (1 + 1e-8)).all()
    slip = np.hypot(*step.slip)
    assert slip[step.sticking].max() < 1e-6 * slip.max()
    sliding = (step.pressure > 0) & ~step.sticking
    across = step.traction[0] * step.slip[1] - step.traction[1] * step.slip[0]
    along = (step.traction * step.slip).sum(axis=0)
    assert (along[sliding] >= 0).all()
    assert np.abs(across[sliding]).max() < 1e-6 * along.max()


def test_loss_approaches_the_work_of_the_creep():
    """What the creep does is lost by slip: the elastic tractions do no work as they travel."""
    losses = []
    for cells in (6, 12):
        (step,) = roll(ball(cells), Load("force", 4.0), [Creep(0.3)])
        losses.append(1 - step.loss / (step.tangential_force * 0.3))
    assert 0 < losses[1] < 0.65 * losses[0] < 0.2


def test_braking_mirrors_driving_without_coupling():
    creeps = [Creep(c) for c in (-0.2, -1e-9, 0.0, 1e-9, 0.2)]
    steps = list(roll(ball(6, nu=0.3), Load("force", 2.0), creeps))
    forces = np.array([step.tangential_force for step in steps])
    assert_allclose(forces, -forces[::-1], rtol=1e-7, atol=0)
    assert forces[2] == 0.0
    assert steps[2].sticking.sum() == (steps[2].pressure > 0).sum()


def test_coupling_tells_driving_from_braking():
    """A rigid ball on a body of nu < 1/2 is pulled along by pressure: at no creep, too."""
    creeps = [Creep(c) for c in (-0.2, 0.0, 0.2)]
    brakes, free, drives = roll(ball(6, 0.0, 0.5, coupled=True), Load("force", 2.0), creeps)
    assert abs(brakes.tangential_force + drives.tangential_force) > 1e-3
    assert np.abs(free.traction).max() > 0.01
    assert max(brakes.violation, free.violation, drives.violation) <= 1e-8


@pytest.mark.parametrize("friction", [1e-6, 10.0])
@pytest.mark.parametrize("creep", [1e-9, 1e-3, 1.0])
def test_extreme_friction_and_creep_are_solved(friction, creep):
    (step,) = roll(ball(5, friction=friction), Load("force", 3.0), [Creep(creep)])
    assert 0 < step.tangential_force <= friction * step.force * (1 + 1e-9)
    assert step.error < 1e-8


def test_rough_roller_is_pressed_anew_at_every_step():
    press = ball(6)
    rng = np.random.default_rng(1)
    rough = 0.02 * rng.standard_normal((press.body.shape[0] + 4, press.body.shape[1]))
    fields = list(pressed(press.body, press.gap, rough, Load("force", 3.0)))
    assert len(fields) == 5
    assert_allclose([p.sum() * press.body.cell_area for p in fields], 3.0, rtol=1e-6)


@pytest.mark.parametrize("cells", [1, 7, 40])
def test_fastsim_turns_the_force_with_the_creep(cells):
    contact = EllipticContact((1.0, 1.0), 1.0, 0.0, 0.01)
    rolled = fastsim(contact, 3.0, 4.0, cells=cells)
    assert_allclose(
        np.array((rolled.tangential_force, rolled.lateral_force)),
        0.01 * np.array((0.6, 0.8)),
        rtol=0.3 / cells**2 + 1e-3,
    )


def test_spin_of_fastsim_is_that_of_contacts_fastsim():
    """Its 0.6098 and 0.6338 on 40 and 200 cells, of first order: 0.640 in the limit.

    Its flexibilities, interpolated otherwise, differ by 2 %.
    """
    contact = EllipticContact((8.0, 4.0), 41000.0, 0.28, 0.3 * 82e3)
    assert_allclose(
        fastsim(contact, 0.0, -6.25e-4, 6.25e-4).lateral_force / contact.limit, 0.64, rtol=0.015
    )
    little = fastsim(contact, 0.0, 0.0, 1e-9, cells=100).lateral_force
    assert_allclose(little, linear(contact, 0.0, 0.0, 1e-9).lateral_force, rtol=1e-3)


def test_spin_turns_the_contact_and_drives_it_aside():
    """Spin alone: F_x vanishes by symmetry, F_y and M_z have the signs of the spin."""
    left, right = roll(ball(8, nu=0.25), Load("force", 2.0), [Creep(0, 0, s) for s in (-0.2, 0.2)])
    assert abs(right.tangential_force) < 1e-9 * right.force
    assert right.lateral_force > 0.02 * right.force
    assert right.moment > 0
    assert_allclose((left.lateral_force, left.moment), (-right.lateral_force, -right.moment))


def elements(nu, inertia=0.0):
    """Return what makes a surface of finite elements of G = 1."""
    material = Material(2 * (1 + nu), nu)
    return lambda shape, side: ShearBody(shape, (side, side), material, inertia=inertia)


@pytest.mark.parametrize("component", range(5))
def test_elements_are_the_half_space_some_cells_away(component):
    body = elements(0.3)((16, 16), 1.0)
    far = NormalAndTangential((16, 16), (1.0, 1.0), Compliance.of(1.0, 0.3))
    ours, theirs = body.free_coefficients()[component], far.free_coefficients()[component]
    scale = np.abs(theirs[8:, 8:]).max()
    assert np.abs(ours - theirs)[8:, 8:].max() < 0.02 * scale


@pytest.mark.slow
def test_a_window_of_elements_is_of_the_same_elements():
    body = ShearBody((12, 12), (1.0, 1.0), Material(1.0, 0.3), element="linear", inertia=0.1)
    window = np.s_[:, 2:6, 3:7]
    traction = np.zeros((2, 12, 12))
    traction[window] = np.arange(32.0).reshape(2, 4, 4)
    moved = body.restrict((4, 4)).shear(traction[window])
    assert_allclose(moved, body.shear(traction)[window], rtol=1e-9)


@pytest.mark.slow
def test_a_coupled_roller_on_elements_is_that_on_the_half_space():
    press = ball(5, nu=0.2, coupled=True)
    body = elements(0.2)(press.body.shape, press.body.spacing[0])
    creeps, load = [Creep(0.0), Creep(0.1)], Load("force", 2.0)
    ours = list(roll(press, load, creeps))
    theirs = list(roll(FrictionalPress(body, press.gap, press.friction), load, creeps))
    scale = press.friction * ours[0].force
    for one, other in zip(ours, theirs, strict=True):
        # 3 % on five cells per radius, 0.7 % on eight
        assert abs(one.tangential_force - other.tangential_force) < 0.05 * scale
        assert_allclose(other.penetration, one.penetration, rtol=0.01)


@pytest.mark.slow
def test_flow_through_the_mesh_softens_it():
    """Inertia: the compliance of a load that moves, by Rayleigh's function (here nu = 0)."""
    wave = (np.array([2 * np.pi / 64]), np.array([0.0]))
    layers = Stack([400.0], [Material(2.0, 0.0)])
    rest, flow = (tensor(wave, (1.0, 1.0), layers, inertia=m)[0, 0, 0] for m in (0.0, 0.01))
    b, a = np.sqrt(1 - 0.01), np.sqrt(1 - 0.01 / 2)
    exact = 0.01 * b / (4 * a * b - (1 + b * b) ** 2)
    assert_allclose(flow / rest, exact, rtol=1e-3)
    slow, fast = (on_grid(elements(0.25, m), 1.0, 6) for m in (0.0, 0.05))
    assert (0.9 * slow < fast).all()
    assert (fast < 0.992 * slow).all()
