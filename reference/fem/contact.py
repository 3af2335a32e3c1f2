"""Frictionless contact of a condensed body with a rigid shape.

`press` leaves the mesh as it is, `indent` scales it with a single contact. A half-space has no
length scale, so a mesh scaled by s has its compliance divided by s, and the mesh circle can be
placed on the contact edge at every load without a new condensation. The contact area is that with
the largest force at a given penetration (Barber 1974, *J. Strain Anal.* 9, 230), which gives s; the
active set on the scaled body then confirms or corrects it.
"""

from collections.abc import Callable, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg import cho_factor, cho_solve
from scipy.optimize import minimize_scalar
from scipy.special import ellipk
from skfem.element import ElementQuad1, ElementQuad2

from reference.arrays import Array, Mask
from reference.contact.pivot import pivot
from reference.errors import ConvergenceError, choice_faults, count_faults, positive_faults, refuse
from reference.fem.condensed_body import CondensedBody, DenseFlexibility
from reference.fem.element_stiffness import facet_quadrature, gauss_square, shape_functions
from reference.loads import LoadPath

METHODS = ("active_set", "penalty", "augmented_lagrangian")
CONTROLS = ("penetration", "force")


@dataclass(frozen=True, eq=False)
class NodalContact:
    """One converged load step: forces, area and energy are those of all symmetric parts."""

    penetration: float
    force: float
    # (n,): normal forces on the candidates of the meshed part, the same over their areas, and u
    # into the body
    reactions: Array
    pressure: Array
    displacement: Array
    active: Mask  # (n,) bool, candidates that carry a force
    stiffness: float  # dF/dd on the fixed contact set
    energy: float  # elastic energy ``1/2 sum R u``
    # best estimate; tributary area of the active points
    contact_area: float
    contact_area_raw: float
    iterations: int
    # largest overlap over the penetration from first touch of a point; with a penalty also
    # that inside the contact
    violation: float
    history: list[int] = field(default_factory=list)  # number of wrong points by iteration


@dataclass(frozen=True)
class Enforcement:
    """Enforcement of contact on the candidates.

    Parameters
    ----------
    method : {"active_set", "penalty", "augmented_lagrangian"}
        The primal-dual active set (Hintermüller, Ito & Kunisch 2002) is exact. "penalty" uses nodal
        springs of stiffness eps per area between shape and body, with an error of O(1/eps).
        "augmented_lagrangian" repeats it with the forces of the last solution until the overlap
        vanishes.
    penalty : float
        ``eps h / E*`` with h the size of the surface elements.
    max_iterations : int
        Limit of active-set iterations per load.
    """

    method: str = "active_set"
    penalty: float = 1e3
    max_iterations: int = 100

    def __post_init__(self) -> None:
        faults = choice_faults("method", self.method, METHODS)
        faults += positive_faults(penalty=self.penalty)
        refuse(faults + count_faults(1, max_iterations=self.max_iterations))


EXACT = Enforcement()


def press(
    body: CondensedBody,
    gap: ArrayLike,
    load: LoadPath,
    enforcement: Enforcement = EXACT,
    *,
    start: ArrayLike | None = None,
) -> Iterator[NodalContact]:
    """Yield the contact of a rigid shape with the body, load by load.

    Linearised kinematics: ``u = d - g`` at the undeformed position in contact; ``u >= d - g`` and
    no force elsewhere.

    Parameters
    ----------
    gap : (n,)
        Initial gap of the rigid shape over `body.points`, relative to which the penetration is
        measured; +inf where contact is impossible.
    load : LoadPath
        Penetrations or forces on the whole contact (all symmetric parts), positive, in any order;
        every step starts from the previous contact set (`reference.contact.pivot`).
    start : (n,) bool, optional
        Initial contact set; by default (and if empty) all points with geometric overlap, under a
        force those of first touch.

    Raises ConvergenceError on iteration, if a step does not converge or overflows.
    """
    gap = np.asarray(gap, dtype=float)
    weights, method = body.scaled_weights, enforcement.method
    faults = []
    if gap.shape != weights.shape:
        faults.append(f"gap must have shape {weights.shape}, not {gap.shape}")
    elif np.isnan(gap).any() or np.isneginf(gap).any() or not np.isfinite(gap).any():
        faults.append("gap must be finite or +inf, and finite somewhere")
    if start is not None and np.shape(start) != weights.shape:
        faults.append(f"start must have shape {weights.shape}, not {np.shape(start)}")
    if method != "penalty" and body.interpolation is not None:
        faults.append(
            f"method must be 'penalty' at quadrature points, not {method!r}: there are more of "
            "them than nodes, so that rigid contact in all of them is not defined"
        )
    refuse(faults)
    load.one_of(*CONTROLS)
    load.positive()

    # Lengths of body.length, forces of E length^2, depths from first touch: a distant shape then
    # loses no digits of the overlap.
    by_force = load.control == "force"
    length, unit = body.length, body.youngs_modulus * body.length * body.length
    first_touch = float(gap.min())
    scaled = (gap - first_touch) / length
    softness = np.zeros_like(weights)
    if method != "active_set":
        per_area = enforcement.penalty / (1.0 - body.poisson_ratio**2) / body.spacing_scaled
        softness = 1.0 / (per_area * weights)
    respond = partial(body.flexibility.respond, softness=softness)

    def steps(active: Mask) -> Iterator[NodalContact]:
        for value in load.values:
            depth = (value - first_touch) / length
            history: list[int] = []
            if not by_force and depth <= 0.0:  # first touch may be between the points
                reactions = displacement = np.zeros_like(weights)
                slope = violation = 0.0
            else:
                if not active.any():
                    active = scaled == 0.0 if by_force else scaled < depth
                target = value / (unit * body.symmetry) if by_force else depth
                offset = np.zeros_like(scaled)
                for _ in range(enforcement.max_iterations):
                    settled = pivot(
                        respond,
                        scaled - offset,
                        active,
                        target,
                        per_depth=0.0 if by_force else 1.0,
                        per_pressure=1.0 if by_force else 0.0,
                        max_rounds=enforcement.max_iterations,
                    )
                    history += settled.history
                    active, depth, slope = settled.active, settled.depth, settled.slope
                    reactions, displacement = settled.pressures, settled.displacement
                    overlap = float(np.max(depth - scaled - displacement, initial=0.0))
                    if method != "augmented_lagrangian" or overlap <= 1e-10 * depth:
                        break
                    offset = reactions * softness  # the forces of the last solution, as multipliers
                else:
                    raise ConvergenceError(
                        f"the overlap did not vanish in {enforcement.max_iterations} updates of "
                        "the multipliers",
                        history,
                    )
                violation = overlap / depth
                if method == "augmented_lagrangian":  # without the springs
                    inside = np.flatnonzero(active)
                    forces, _ = body.flexibility.respond(inside, np.ones((len(inside), 1)))
                    slope = float(forces.sum())
            penetration = float(first_touch + depth * length if by_force else value)
            force = float(value) if by_force else float(body.symmetry * unit * reactions.sum())
            reactions, displacement = reactions * unit, displacement * length
            touching = reactions > 0.0
            # area: of the mesh circle if exactly its nodes touch and the shape ends there, of one
            # round or elliptic contact by its radius, else of the nodes, to half a spacing
            raw = area = float(body.symmetry * body.weights[touching].sum())
            if body.ring is not None and touching.any():
                radius = contact_radius(body, reactions, touching)
                if not np.isfinite(gap).all() and np.array_equal(touching, body.inside_ring):
                    radius = body.ring * length
                area = raw if radius is None else _ellipse(body, radius)
            with np.errstate(over="ignore", invalid="ignore"):
                energy = float(0.5 * body.symmetry * reactions @ displacement)
            if not np.isfinite(energy):
                raise ConvergenceError(
                    f"the energy overflows at penetration {penetration:.6g}", history
                )
            yield NodalContact(
                penetration=penetration,
                force=force,
                reactions=reactions,
                pressure=reactions / body.weights,
                displacement=displacement,
                active=touching,
                stiffness=slope * body.symmetry * body.youngs_modulus * length,
                energy=energy,
                contact_area=area,
                contact_area_raw=raw,
                iterations=len(history),
                violation=violation,
                history=history,
            )

    nowhere = np.zeros(weights.shape, bool)
    return steps(nowhere if start is None else np.asarray(start, bool) & np.isfinite(gap))


def at_quadrature_points(body: CondensedBody) -> CondensedBody:
    """Return the body with Gauss points of its candidate surface as candidates, 3 x 3 an element.

    With a penalty eps the pressure at a point is ``eps <d - g - u>`` and the nodal forces are its
    moments ``int N_i p dA`` (Wriggers 2006, *Computational Contact Mechanics*, sec. 9.1): in the
    terms of the points, ``(N C N^T + 1/(eps w)) R = d - g``, the problem that `press` solves. A
    uniform pressure then gives exactly the consistent nodal forces, and gaps inside the elements
    are considered. There are more points than nodes, so rigid contact ("active_set") is undefined:
    `press` accepts "penalty" only, with the gap at the `points` of the result. Interior fields and
    energies follow as for nodal contact (`recover`).
    """
    if body.nodal is not None:
        raise ValueError("contact at quadrature points needs a body with nodes as candidates")
    if not isinstance(body.flexibility, DenseFlexibility):
        raise ValueError(
            "contact at quadrature points needs a condensed body, got solver conjugate_gradients"
        )
    mesh = body.grid.mesh
    place = np.full(mesh.doflocs.shape[1], -1)
    place[body.nodes] = np.arange(len(body.nodes))
    nodes, shapes, points, areas = facet_quadrature(mesh, body.grid.surface, 3)
    covered = (place[nodes] >= 0).all(axis=1)
    count = int(covered.sum()) * shapes.shape[1]
    interpolation = np.zeros((count, len(body.nodes)))
    columns = np.repeat(place[nodes[covered]], shapes.shape[1], axis=0)
    values = np.tile(shapes.T, (int(covered.sum()), 1))
    interpolation[np.arange(count)[:, None], columns] = values
    return replace(
        body,
        scaled_points=points[covered, :, :2].reshape(-1, 2) + body.offset,
        scaled_weights=np.abs(areas[covered, :, 2]).ravel(),
        flexibility=DenseFlexibility(
            interpolation @ body.scaled_compliance @ interpolation.T, body.system
        ),
        ring=None,
        nodal=body,
        interpolation=interpolation,
    )


def fitted_area(body: CondensedBody, stiffness: float) -> float:
    """Return the area of a smooth contact with its edge on the mesh circle, or a node beside it.

    The area of the flat punch with the stiffness ``pi E* a / K(1 - b^2/a^2)`` (Johnson 1985) of
    the contact set: nodes on the circle carry load slightly beyond it, 0.2 % of the radius.
    """
    minor, major = sorted(body.stretch)
    assert body.ring is not None, "only meshes with a ring are fitted"
    radius = body.ring * body.length
    exact = np.pi * body.effective_modulus * major * radius / ellipk(1.0 - (minor / major) ** 2)
    return _ellipse(body, radius * stiffness / exact)


def _ellipse(body: CondensedBody, radius: float) -> float:
    return float(np.pi * body.stretch[0] * body.stretch[1] * radius * radius)


def contact_radius(body: CondensedBody, reactions: Array, active: Mask) -> float | None:
    """Return the radius (before stretching) of a round contact from the moments of its pressure.

    Moments are as accurate as the force, while the set of active nodes jumps by whole spacings.
    Some are active. None if the pressure is not of the form of `moment_radius`: the contact is not
    a full disc, or the result differs from the active nodes by more than a spacing (cone, flat
    punch).
    """
    radii = body.scaled_radii
    reach = radii[active].max()
    radius = radius_from_moments(radii, reactions)
    if radius is None or not active[radii < 0.8 * reach].all():
        return None
    spacing = body.spacing_scaled / np.sqrt(body.stretch[0] * body.stretch[1])
    return float(radius * body.length) if abs(radius - reach) < spacing else None


def radius_from_moments(radii: Array, reactions: Array) -> float | None:
    """Return `moment_radius` of nodal forces at the given radii."""
    second, fourth = (reactions @ radii**k / reactions.sum() for k in (2, 4))
    return moment_radius(second, fourth)


def moment_radius(second: float, fourth: float) -> float | None:
    """Return the contact radius a from the force-weighted means of r^2 and r^4.

    With ``p = sqrt(a^2 - r^2) (c_0 + c_1 r^2)``, exact for a paraboloid (Hertz) and for
    ``f = c r^4`` (Johnson 1985, sec. 5.3), ``a^2 = (7 <r^2> - sqrt(49 <r^2>^2 - 63/2 <r^4>)) / 2``.
    None if such a pressure cannot have these means.

    Hertz's pressure of radius one:

    >>> round(moment_radius(2.0 / 5.0, 8.0 / 35.0), 12)
    1.0
    """
    root = 49.0 * second**2 - 31.5 * fourth
    return None if root < 0.0 else float(np.sqrt(0.5 * (7.0 * second - np.sqrt(root))))


Shape = Callable[[Array, Array], Array]
Projection = Callable[[CondensedBody, Array], Array]

GAUSS_POINTS = 6  # per direction; error by the root at the rim 1e-5 of its force


def indent(
    body: CondensedBody,
    shape: Shape,
    load: LoadPath,
    enforcement: Enforcement = EXACT,
    *,
    points: str = "nodes",
) -> Iterator[tuple[CondensedBody, NodalContact]]:
    """Solve a single convex contact, with the mesh fitted to the contact at every load.

    Parameters
    ----------
    body : CondensedBody
        From a `RingMesh`, best with ``edge=contact_radius``; its size is arbitrary, but its
        `stretch` determines the aspect ratio of the contact.
    shape : callable
        Initial gap ``g(x, y)`` of arrays; +inf outside a sharp edge. Even in x and y for a quarter.
    load : LoadPath
        Positive penetrations or forces.
    points : {"nodes", "quadrature"}
        Points of the contact conditions; "quadrature" (`at_quadrature_points`) needs the method
        "penalty".

    Yields
    ------
    (CondensedBody, NodalContact)
        The body scaled to this load, with its `points` for nodal values.
        ``contact_area`` is that of the ellipse with the stiffness of the contact set; if that is
        the mesh circle, ``pressure`` is a weighted projection (`ring_pressure`).

    Raises ConvergenceError if no size of the mesh carries the load, or every size does because the
    gap does not increase.

    Examples
    --------
    >>> from reference.fem import Material, RingMesh, half_space_body
    >>> body = half_space_body(RingMesh(1.0, edge=1.0), Material(1.0, 0.3))
    >>> ball = indent(body, lambda x, y: 0.5 * (x**2 + y**2), LoadPath("penetration", 1e-6))
    >>> _, step = next(ball)
    >>> hertz = 4.0 / 3.0 * body.effective_modulus * 1e-9
    >>> bool(abs(step.force / hertz - 1.0) < 5e-4)
    True
    """
    faults = choice_faults("points", points, ("nodes", "quadrature"))
    if body.ring is None:
        faults.append("indent needs a body from a RingMesh: a TensorMesh has no mesh circle")
    refuse(faults)
    load.one_of(*CONTROLS)
    load.positive()
    pressed = body if points == "nodes" else at_quadrature_points(body)

    def gap_at(places: Array) -> Array:
        x, y = places.T
        with np.errstate(over="ignore", invalid="ignore"):  # gaps may overflow at large distances
            gaps = np.asarray(shape(x, y), dtype=float)
        if gaps.shape != x.shape:
            raise ValueError(f"shape must return one gap per point {x.shape}, got {gaps.shape}")
        return gaps

    # v: forces on the circle at unit penetration, E s times which is the stiffness at the size s
    circle = body.inside_ring
    disc = body.points[circle]
    columns, _ = body.flexibility.respond(np.flatnonzero(circle), np.ones((len(disc), 1)))
    forces, modulus = columns[:, 0] * body.symmetry, body.youngs_modulus * body.length

    gaps = gap_at(disc)
    noise = 1e-9 * np.abs(gaps[np.isfinite(gaps)]).max(initial=0.0)
    for axis in np.flatnonzero(body.grid.planes):
        mirrored = gap_at(disc * np.where(np.arange(2) == axis, -1.0, 1.0))
        if not np.allclose(gaps, mirrored, rtol=0.0, atol=noise, equal_nan=True):
            raise ValueError(
                f"the gap must be even in {'xy'[axis]}, of which only the positive side is "
                "meshed; centre the shape, or build the body with symmetry = 'none'"
            )

    def fitted_contacts() -> Iterator[tuple[CondensedBody, NodalContact]]:
        projection = None
        for value in load.values:

            def loss(size: float, value: float = value) -> float:
                gaps = gap_at(disc * size)
                if load.control == "force":  # the penetration (F/(E s) + v . g(s x)) / sum v
                    return value / (modulus * size) + float(forces @ gaps)
                return -size * float(forces @ (value - gaps))  # minus the force over E

            size = _best_size(loss, lambda size: bool(np.isfinite(gap_at(disc * size)).all()))
            fitted = pressed.scaled(size)
            gap = gap_at(fitted.points)
            start = fitted.inside_ring & np.isfinite(gap)
            step = next(press(fitted, gap, LoadPath(load.control, value), enforcement, start=start))
            if np.isfinite(gap).all():
                area = fitted_area(fitted.nodal or fitted, step.stiffness)
                step = replace(step, contact_area=area)
                if fitted.nodal is None and np.array_equal(step.active, fitted.inside_ring):
                    projection = projection or ring_pressure(body, float(forces.sum()) * modulus)
                    step = replace(step, pressure=projection(fitted, step.reactions))
            yield fitted, step

    return fitted_contacts()


def _best_size(loss: Callable[[float], float], finite: Callable[[float], bool]) -> float:
    """Return the size of the mesh with the least loss, at which its gaps are finite."""
    # a bracket of the minimum by factors of two, from a size with a finite gap
    power = next((p for k in range(200) for p in (k, -k) if finite(2.0**p)), None)
    if power is None:
        raise ConvergenceError("the gap is infinite at every size of the contact")
    value = loss(2.0**power)
    for step in (1, -1):
        for _ in range(400):
            trial = power + step
            if not finite(2.0**trial) or (new := loss(2.0**trial)) >= value:
                break
            power, value = trial, new
        else:
            raise ConvergenceError("the contact grows without end: the shape does not rise")
    low, high = 2.0 ** (power - 1), 2.0 ** (power + 1)
    # the largest size at which no point inside the circle is beyond a sharp edge
    edge = high
    if not finite(high):
        edge, beyond = low, high
        while edge < (middle := 0.5 * (edge + beyond)) < beyond:
            edge, beyond = (middle, beyond) if finite(middle) else (edge, middle)
    minimum = minimize_scalar(
        lambda power: loss(2.0**power),
        bounds=(np.log2(low), np.log2(edge)),
        method="bounded",
        options={"xatol": 1e-9},
    )
    return min((2.0**minimum.x, edge), key=loss)


def ring_pressure(body: CondensedBody, stiffness: float) -> Projection:
    """Return the weighted projection of nodal forces onto ``p = q sqrt(1 - rho^2)``.

    Nodal forces are the moments ``R_i = int N_i p dA`` of the pressure. Force over tributary area
    mixes values over an element, and with nodal contact conditions on quadratic elements
    neighbouring forces alternate by some per cent. Solving ``int M_i M_j sqrt(1 - rho^2) dA q_j =
    sum_k M_i(x_k) R_k`` for a q that is bilinear between the corners of the elements (shape
    functions M) averages over patches of elements, conserves force and first moments, and separates
    the known root at the edge from the interpolation: for Hertz q is constant. Rho is the radius
    over that of the contact, which is slightly larger than the mesh circle: that of a punch of the
    `stiffness` dF/dd. The size of the body does not matter.

    The projection takes the body, scaled or not, and nodal forces (n,); it is zero outside.
    """
    mesh, inside = body.grid.mesh, body.inside_ring
    area = fitted_area(body, stiffness) / (body.length * body.length)
    reach = np.sqrt(area / (np.pi * np.prod(body.stretch)))

    def root(points: Array) -> Array:
        x, y = (points[..., axis] / body.stretch[axis] / reach for axis in (0, 1))
        return np.asarray(np.sqrt(np.clip(1.0 - x**2 - y**2, 0.0, None)))

    at_candidates = root(body.scaled_points[inside])
    place = np.full(mesh.p.shape[1], -1)
    place[body.nodes[inside]] = np.arange(int(inside.sum()))
    nodes, _, points, areas = facet_quadrature(mesh, body.grid.surface, GAUSS_POINTS)
    covered = (place[nodes] >= 0).all(axis=1)
    nodes = place[nodes[covered]]
    weight = np.abs(areas[covered, :, 2]) * root(points[covered, :, :2])
    used, corners = np.unique(nodes[:, :4], return_inverse=True)
    corners = corners.reshape(-1, 4)
    shapes, _ = shape_functions(ElementQuad1, gauss_square(GAUSS_POINTS)[0])
    matrix = np.zeros((len(used), len(used)))
    blocks = np.einsum("nq,fq,mq->fnm", shapes, weight, shapes, optimize=True)
    np.add.at(matrix, (corners[:, :, None], corners[:, None, :]), blocks)
    factor = cho_factor(matrix, overwrite_a=True)
    interpolation = np.zeros((len(at_candidates), len(used)))
    at_nodes, _ = shape_functions(ElementQuad1, ElementQuad2.doflocs.T)
    interpolation[nodes[:, None, :], corners[:, :, None]] = at_nodes

    def pressure(scaled: CondensedBody, reactions: Array) -> Array:
        result = np.zeros_like(reactions)
        smooth = interpolation @ cho_solve(factor, interpolation.T @ reactions[inside])
        result[inside] = smooth * at_candidates / (scaled.length * scaled.length)
        return result

    return pressure
