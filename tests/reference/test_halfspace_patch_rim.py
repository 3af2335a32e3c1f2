"""Contact at the rim of a free patch acts as the edge of a flat face: proved on such faces."""

import numpy as np
import pytest

from reference.contact.press import press
from reference.halfspace import FreeOperator, areas
from reference.halfspace.areas import located_area, on_whole_patch, reaches_rim
from reference.loads import Load

# k/(E* side) of a flat square face.
SQUARE = 1.15230


def pressed(gap, spacing, control, value):
    """Return the contact on the grid, and on the whole patch."""
    operator = FreeOperator(gap.shape, spacing, 1.0)
    contact = press(operator, gap, Load(control, value))
    response = areas.contact_response(operator, contact.mask, 1e-8)
    area = located_area(contact, patch=True)
    return contact, on_whole_patch(contact, response, control, area)


@pytest.mark.parametrize("shape", [(16, 16), (32, 16), (16, 64)])
def test_a_square_face_on_cells_of_any_aspect_has_the_known_stiffness(shape):
    """Cells alone leave 2 % and more, to first order; what is left is the corners' share."""
    spacing = 1 / shape[0], 1 / shape[1]
    for control in ("force", "penetration"):
        contact, whole = pressed(np.zeros(shape), spacing, control, 1.0)
        errors = [part.force / part.penetration / SQUARE - 1 for part in (contact, whole)]
        assert errors[0] < -0.01
        assert abs(errors[1]) < 0.0025
        assert getattr(whole, control) == getattr(contact, control)


def test_a_ball_on_the_rim_converges_beyond_first_order():
    """Its top stands on the rim of the patch: penetration, mean gap and area at a given force."""
    known = []
    for n in (16, 32, 64, 256):
        x = (np.arange(n) + 0.5) / n
        gap = (x[:, None] ** 2 + (x - 0.5) ** 2) / 2
        contact, whole = pressed(gap - gap.min(), (1 / n, 1 / n), "force", 0.03)
        depth = contact.penetration, whole.penetration
        known.append((*(d + gap.min() for d in depth), contact.mean_gap, whole.mean_gap))
    errors = np.abs(np.array(known[:3]) / known[3] - 1)
    assert (errors[-1, [1, 3]] < errors[-1, [0, 2]] / 3).all()
    assert errors[0, 1] > 2.5**2 * errors[2, 1]


def test_what_is_prescribed_stays_and_the_others_meet_at_the_same_state():
    """Given its force, its depth or its mean gap, the contact is the same to second order."""
    x = np.arange(24) / 24
    gap = (np.sin(7 * x)[:, None] + np.cos(5 * x + 1) + 2) / 60
    gap -= gap.min()
    spacing = (1 / 24, 1 / 24)
    _, whole = pressed(gap, spacing, "force", 0.01)
    for control in ("penetration", "mean_gap"):
        value = getattr(whole, control)
        contact, again = pressed(gap, spacing, control, value)
        assert getattr(again, control) == pytest.approx(value, rel=1e-7)
        assert again.force == pytest.approx(0.01, rel=5e-3)
        assert abs(again.force - 0.01) < abs(contact.force - 0.01) / 4


def test_contact_away_from_the_rim_is_left_as_it_is():
    x = np.arange(16) - 7.3
    contact, whole = pressed((x[:, None] ** 2 + x**2) / 200, (1.0, 1.0), "force", 1.0)
    assert not reaches_rim(contact.mask)
    assert whole.penetration == contact.penetration
    assert whole.contact_area == located_area(contact)
