"""Integrals over isotropic hexahedra and tetrahedra, all elements at once, and over their faces.

`skfem.BilinearForm` on vector elements loops over pairs of the 81 vector basis functions; here the
gradients of the 27 scalar ones come from the scikit-fem element, and all element matrices from one
batched matrix product, 26 to 96 times faster.
"""

import numpy as np
from skfem import MeshHex, MeshHex2, MeshTet
from skfem.element import Element, ElementHex2, ElementQuad1, ElementQuad2, ElementTetP2

from reference.arrays import Array, Integers
from reference.elasticity import lame_parameters

# Elements whose gradients are held at once: 20 MB of them, and of products.
AT_ONCE = 256
STRESSES = 4  # mean-stress unknowns of an element: a constant, and three slopes


def gauss_rule(count: int, dimensions: int) -> tuple[Array, Array]:
    """Return a tensor Gauss rule on the unit line, square or cube: points (dimensions, n), weights.

    Passed to scikit-fem explicitly, because the rule selected by ``intorder`` for hexahedra has
    more points than requested, and never one point per direction.
    """
    nodes, weights = np.polynomial.legendre.leggauss(count)
    nodes, weights = 0.5 * (nodes + 1.0), 0.5 * weights
    points = np.stack(np.meshgrid(*[nodes] * dimensions, indexing="ij"))
    product = weights
    for _ in range(dimensions - 1):
        product = np.multiply.outer(product, weights)
    return points.reshape(dimensions, -1), product.ravel()


def gauss_square(per_direction: int) -> tuple[Array, Array]:
    """Return the rule on the unit square with x running first, as the nodes of faces do."""
    points, weights = gauss_rule(per_direction, 2)
    return points[::-1], weights


def simplex_points(degree: int) -> tuple[Array, Array]:
    """Return a rule on the unit tetrahedron exact to `degree` 0, 1 (one point) or 2 (four).

    Four points on the medians (Zienkiewicz & Taylor 2000, *The Finite Element Method*, table 9.2):
    sufficient for the stiffness of a straight ten-node tetrahedron.
    """
    if degree < 2:
        return np.full((3, 1), 0.25), np.array([1.0 / 6.0])
    near, far = (5.0 + 3.0 * np.sqrt(5.0)) / 20.0, (5.0 - np.sqrt(5.0)) / 20.0
    points = np.full((3, 4), far)
    points[np.arange(3), np.arange(1, 4)] = near
    return points, np.full(4, 1.0 / 24.0)


def shape_functions(element: type[Element], points: Array) -> tuple[Array, Array]:
    """Return values (n, q) and gradients (n, d, q) of the nodes at local points (d, q)."""
    both = [element().lbasis(points, i) for i in range(len(element.doflocs))]
    return np.array([value for value, _ in both]), np.array([slope for _, slope in both])


def element_order(mesh: MeshHex | MeshTet) -> int:
    """Return 1 for linear elements, 2 for 27-node hexahedra and ten-node tetrahedra."""
    return 2 if mesh.elem in (ElementHex2, ElementTetP2) else 1


def facet_nodes(mesh: MeshHex, facets: Integers) -> Integers:
    """Return numbers of all nodes (corner, edge and face nodes) on the given facets."""
    return np.asarray(mesh.dofs.get_facet_dofs(facets).flatten(), dtype=np.int64)


def facet_quadrature(
    mesh: MeshHex, facets: Integers, per_direction: int
) -> tuple[Integers, Array, Array, Array]:
    """Return Gauss points on the facets of hexahedra.

    That is nodes (facets, n), values of their shape functions (n, points), points (facets, points,
    3), and Gauss weights times normal area vectors (facets, points, 3), of either sign.
    """
    nodes, element = mesh.facets[:, facets], ElementQuad1
    if mesh.elem is ElementHex2:
        element, dofs = ElementQuad2, mesh.dofs
        nodes = np.vstack(
            [nodes, dofs.edge_dofs[0, mesh.f2e[:, facets]], dofs.facet_dofs[:, facets]]
        )
    local, weights = gauss_square(per_direction)
    shapes, slopes = shape_functions(element, local)
    corners = mesh.p.T[nodes.T]
    points = np.einsum("fni,nq->fqi", corners, shapes)
    tangents = np.einsum("fni,ndq->dfqi", corners, slopes)
    areas = np.cross(tangents[0], tangents[1]) * weights[:, None]
    return nodes.T, shapes, points, areas


def shape_gradients(
    mesh: MeshHex | MeshTet, per_direction: int, part: slice = slice(None)
) -> tuple[Array, Array]:
    """Return gradients (elements, points, nodes, 3) of the scalar shape functions, and volumes.

    At Gauss points, whose volumes (elements, points) are weight times Jacobian. Hexahedra use
    `per_direction` points per direction; tetrahedra the rule that is exact to one degree less, as
    needed for their gradients.
    """
    simplex = isinstance(mesh, MeshTet)
    rule = simplex_points(per_direction - 1) if simplex else gauss_rule(per_direction, 3)
    points, weights = rule
    nodes = mesh.dofs.element_dofs[:, part]
    # (nodes, 3, points): the reference gradients are equal for all elements
    local = shape_functions(mesh.elem, points)[1]
    corners = mesh.doflocs[:, nodes].transpose(2, 0, 1)
    jacobian = np.matmul(corners, local.reshape(len(nodes), -1))
    # rows of the Jacobian are the coordinates, columns the local directions
    jacobian = jacobian.reshape(-1, 3, 3, len(weights)).transpose(0, 3, 1, 2)
    # inverse by cofactors
    a, b, c = jacobian[..., 0, :], jacobian[..., 1, :], jacobian[..., 2, :]
    cofactors = np.stack([np.cross(b, c), np.cross(c, a), np.cross(a, b)], axis=-1)
    determinant = (a * cofactors[..., 0]).sum(axis=-1)
    gradients = np.matmul(local.transpose(2, 0, 1), cofactors / determinant[..., None, None])
    return gradients, np.abs(determinant) * weights


def stiffness_matrices(mesh: MeshHex | MeshTet, poisson_ratio: float) -> Array:
    """Return stiffness matrices (elements, 3 nodes, 3 nodes) for a unit Young's modulus.

    ``K = int lambda div(v) div(u) + 2 mu eps(v) : eps(u)``; degrees of freedom are ordered
    component fastest. The lambda term uses one Gauss point per direction less (selective reduced
    integration; Hughes, *The Finite Element Method*, 2000, sec. 4.4), without which nearly
    incompressible elements lock. Linear elements and tetrahedra use the mean dilatation instead
    (Nagtegaal, Parks & Rice 1974), which is equivalent for bricks but passes the patch test for
    distorted cells. A negative lambda (nu < 0) is fully integrated, because there is no locking
    and reduced integration would lose positive definiteness.
    """
    lame, shear = lame_parameters(poisson_ratio)
    full = element_order(mesh) + 1
    mean = element_order(mesh) == 1 or isinstance(mesh, MeshTet)
    nodes = mesh.dofs.element_dofs
    count, size = nodes.shape[1], 3 * len(nodes)
    result = np.empty((count, size, size))
    for start in range(0, count, AT_ONCE):
        part = slice(start, start + AT_ONCE)
        products = _gradient_products(*shape_gradients(mesh, full, part))
        _shear_stiffness(products, shear, result[part])
        if lame > 0.0 and mean:  # V <dN_a/dx_i> <dN_b/dx_j> with means over the elements
            gradients, volumes = shape_gradients(mesh, full, part)
            total = np.einsum("eqaj,eq->eaj", gradients, volumes, optimize=True)
            total = total.reshape(-1, size) / np.sqrt(volumes.sum(axis=1))[:, None]
            products = total[:, :, None] * total[:, None, :]
        elif lame > 0.0:
            products = _gradient_products(*shape_gradients(mesh, full - 1, part))
        products *= lame
        result[part] += products
    return result


def mixed_matrices(mesh: MeshHex2, poisson_ratio: float) -> Array:
    """Return symmetric indefinite matrices (elements, 81 + 4, 81 + 4) for a unit Young's modulus.

    ``int 2 mu eps(u) : eps(v) + s div v = f(v)`` and ``int t (div u - s / lambda) = 0`` for the
    mean stress s = lambda div u, discontinuous and element-wise linear (Q2/P1; Boffi, Brezzi &
    Fortin 2013, *Mixed Finite Element Methods and Applications*, sec. 8.6.3: inf-sup stable, fourth
    order in the force like the compressible element). With 1/lambda = 0 the body is exactly
    incompressible. The displacements come first, component fastest, then the mean stresses.
    """
    shear = 0.5 / (1.0 + poisson_ratio)
    inverse_lame = (1.0 + poisson_ratio) * (1.0 - 2.0 * poisson_ratio) / poisson_ratio
    gradients, volumes = shape_gradients(mesh, 3)
    size = 3 * gradients.shape[2]
    flat = gradients.reshape(*volumes.shape, size)
    modes = mean_stress_modes(mesh, 3)
    coupling = np.einsum("eqi,eq,eqj->eij", flat, volumes, modes, optimize=True)
    result = np.zeros((len(flat), size + STRESSES, size + STRESSES))
    result[:, :size, size:] = coupling
    result[:, size:, :size] = coupling.transpose(0, 2, 1)
    result[:, size:, size:] = -inverse_lame * np.einsum("eqi,eq,eqj->eij", modes, volumes, modes)
    _shear_stiffness(_gradient_products(gradients, volumes), shear, result[:, :size, :size])
    return result


def mean_stress_modes(mesh: MeshHex2, per_direction: int) -> Array:
    """Return 1 and the coordinates in the element at its Gauss points, (elements, points, 4).

    Relative to centre and size of the element: linear in space, not in local coordinates, which
    preserves the order on distorted cells.
    """
    points, _ = gauss_rule(per_direction, 3)
    corners = mesh.doflocs[:, mesh.dofs.element_dofs].transpose(2, 1, 0)
    places = np.matmul(shape_functions(mesh.elem, points)[0].T, corners)
    size = np.ptp(corners, axis=1)
    local = (places - corners.mean(axis=1)[:, None, :]) / size[:, None, :]
    return np.concatenate([np.ones((*local.shape[:2], 1)), local], axis=2)


def _gradient_products(gradients: Array, volumes: Array) -> Array:
    """Return ``int dN_a/dx_i dN_b/dx_j`` as (elements, 3 nodes, 3 nodes); weights the gradients."""
    flat = gradients.reshape(*gradients.shape[:2], -1)
    flat *= np.sqrt(volumes)[..., None]
    return np.matmul(flat.transpose(0, 2, 1), flat)


def _shear_stiffness(products: Array, shear: float, result: Array) -> None:
    """Set ``int 2 mu eps(v) : eps(u)`` from the products of gradients."""
    count, size, _ = products.shape
    split = products.reshape(count, size // 3, 3, size // 3, 3)
    stiffness = np.multiply(shear, split.transpose(0, 1, 4, 3, 2), order="C")
    laplacian = shear * np.einsum("eakbk->eab", split)
    for component in range(3):
        stiffness[:, :, component, :, component] += laplacian
    result[:] = stiffness.reshape(products.shape)
