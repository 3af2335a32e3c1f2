"""Preparation of a user's body for contact: reading, checks, rotation to the contact frame.

In the frame of the contact z points into the body, x and y are the two other axes of the file in
alphabetical order, and the origin is where the indenter's axis meets the highest point of the
contact surface. (This frame may be left-handed, which does not affect isotropic elasticity.)
"""

from __future__ import annotations

import hashlib
from dataclasses import dataclass, fields
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from comparisons.geometry.prepare import IndenterGeometry
from comparisons.geometry.reading import FileError
from comparisons.scene.fields import excerpt
from comparisons.scene.half_space import AXES, Body
from comparisons.scene.scene import Scene, SceneError
from reference.fem.solid_mesh import SolidMesh, contact_nodes, free_motions

if TYPE_CHECKING:
    from comparisons.geometry.body_files import BodyFile, NamedPart

# Contact is linearised about the direction of the indenter: at this slope the surface normal
# deviates by 30 degrees, and forces along it by one seventh.
STEEPEST = np.cos(np.radians(30.0))
# A surface with a smaller ratio of height variation to width counts as plane.
FLAT = 1e-6
# Largest angle (as a sine) between an axis and the normal of a face on a roller.
ALIGNED = 1e-6
SHOWN_CELLS = 5


@dataclass(frozen=True, eq=False)
class Support:
    """Displacement components that are zero on faces (k, 2), or at nodes outside all faces."""

    faces: np.ndarray
    nodes: np.ndarray
    components: tuple[int, ...]


@dataclass(frozen=True, eq=False, kw_only=True)
class BodyGeometry(IndenterGeometry):
    """An indenter (or a rigid plane) over a supported body."""

    solid: SolidMesh  # the mesh in metres, in the contact frame
    surface: np.ndarray  # faces of the potential contact surface
    supports: tuple[Support, ...]
    symmetric_parts: int
    # The contact frame: a point p of the file has the coordinates ``axes @ (p - origin)``.
    origin: np.ndarray
    axes: np.ndarray

    @property
    def flat_surface(self) -> bool:
        """Whether the contact surface is a plane perpendicular to the indenter's axis."""
        points = self.solid.points[self.solid.nodes_of(self.surface)]
        return bool(np.ptp(points[:, 2]) <= FLAT * np.ptp(points[:, :2]))

    @property
    def digest(self) -> str:
        """Identifier of the mesh, in addition to the text of the scene."""
        state = hashlib.sha256(super().digest.encode())
        arrays = [self.solid.points, self.solid.cells, self.surface]
        arrays += [array for s in self.supports for array in (s.faces, s.nodes)]
        for array in arrays:
            state.update(np.ascontiguousarray(array).tobytes())
        return state.hexdigest()

    def fixed_components(
        self, mesh: SolidMesh, numbers: np.ndarray, faces: list[np.ndarray]
    ) -> np.ndarray:
        """Return which displacement components (n, 3) are zero on a refined mesh."""
        fixed = np.zeros(mesh.points.shape, dtype=bool)
        for support, surface_faces in zip(self.supports, faces, strict=True):
            nodes = np.concatenate([numbers[support.nodes], mesh.nodes_of(surface_faces)]).astype(
                np.int64
            )
            fixed[np.ix_(nodes, np.array(support.components))] = True
        return fixed


def with_body(scene: Scene, contact: IndenterGeometry) -> BodyGeometry:
    """Read and check the body of a scene, under the indenter on a half-space of its constants."""
    from comparisons.geometry.body_files import read_body

    assert scene.body is not None
    try:
        return _checked(scene.body, read_body(Path(scene.directory) / scene.body.file), contact)
    except FileError as error:
        raise SceneError(scene.name, [f"body.{problem}" for problem in error.problems]) from error


def _checked(table: Body, read: BodyFile, contact: IndenterGeometry) -> BodyGeometry:
    """Return the body in the frame of the contact; FileError where it or its table is wrong."""
    # as rows the two transverse axes (in alphabetical order) and the indenter's direction
    along = AXES.index(table.direction[1])
    rows = [np.eye(3)[k] for k in range(3) if k != along]
    axes = np.array([*rows, (1.0 if table.direction[0] == "+" else -1.0) * np.eye(3)[along]])
    problems, inverted, pieces = [], read.mesh.inverted(), read.mesh.parts()
    if len(inverted):
        some = ", ".join(str(cell) for cell in inverted[:SHOWN_CELLS])
        more = ", ..." if len(inverted) > SHOWN_CELLS else ""
        problems.append(
            f"file: expected cells of positive volume, got {len(inverted)} of "
            f"{len(read.mesh.cells)} inverted or flat (numbered from 0: {some}{more})"
        )
    if pieces > 1:
        problems.append(f"file: expected one connected body, got {pieces} separate pieces")
    surface, surface_problems = _contact_surface(table, read, axes)
    problems += surface_problems
    for name in table.supports:
        if name not in read.parts:
            problems.append(f"supports.{name}: {_unknown(name, read)}")
    if problems:
        raise FileError(*problems)
    mesh = read.mesh.transformed(np.zeros(3), table.unit * axes)
    # where the axis of the indenter meets the top of the surface, in rotated coordinates
    points = mesh.points[mesh.nodes_of(surface)]
    low, high = points[:, :2].min(axis=0), points[:, :2].max(axis=0)
    if table.position is None:
        parts = mesh.face_integrals(surface)
        moments = sum(
            np.einsum("kni,nq,kq->i", mesh.points[nodes], shapes, np.abs(areas[..., 2]))
            for nodes, shapes, areas in parts
        )
        position = moments[:2] / sum(np.abs(areas[..., 2]).sum() for *_, areas in parts)
    else:
        position = np.array(table.position)
    slack = 1e-9 * (high - low)
    if ((position < low - slack) | (position > high + slack)).any():
        ranges = " x ".join(f"{a:.6g} to {b:.6g} m" for a, b in zip(low, high, strict=True))
        came = ", ".join(f"{coordinate:.6g}" for coordinate in position)
        problems.append(f"position: expected a place on the surface ({ranges}), got [{came}]")
    origin = np.array([*position, points[:, 2].min()])
    mesh = mesh.transformed(origin, np.eye(3))
    supports = []
    for name, constraint in table.supports.items():
        supports.append(_support(mesh, read.parts[name], constraint, axes, name, problems))
    if problems:
        raise FileError(*problems)
    geometry = BodyGeometry(
        **{field.name: getattr(contact, field.name) for field in fields(contact)},
        solid=mesh,
        surface=surface,
        supports=tuple(supports),
        symmetric_parts=table.symmetric_parts,
        origin=axes.T @ origin,
        axes=axes,
    )
    same = np.arange(len(mesh.points))
    fixed = geometry.fixed_components(mesh, same, [support.faces for support in geometry.supports])
    free = free_motions(mesh.points, fixed)
    if free:
        # The motions are in the contact frame; the message names the axes of the file.
        letters = [AXES[int(np.abs(row).argmax())] for row in geometry.axes]
        motions = [motion[:-1] + letters[AXES.index(motion[-1])] for motion in free]
        problems.append(
            f"supports: expected supports that hold the body, got free {', '.join(motions)}"
        )
    if fixed[contact_nodes(mesh, geometry.surface), 2].any():
        problems.append(
            "supports: expected supports away from the contact surface, got nodes of it that "
            "are held along the indenter's direction"
        )
    if problems:
        raise FileError(*problems)
    return geometry


def _unknown(name: str, read: BodyFile) -> str:
    names = [excerpt(name) for name, part in read.parts.items() if len(part.nodes)]
    return f"expected one of the file's names ({', '.join(names) or 'it has none'}), got {name!r}"


def _contact_surface(table: Body, read: BodyFile, axes: np.ndarray) -> tuple[np.ndarray, list[str]]:
    """Return the faces of the potential contact surface, and the problems with them."""
    name = table.contact_surface
    part = read.parts.get(name)
    if part is None:
        return np.zeros((0, 2), np.int64), [f"contact_surface: {_unknown(name, read)}"]
    if part.inside or not len(part.faces):
        came = f"{part.inside} faces that are not" if part.inside else "no face of it"
        return part.faces, [f"contact_surface: expected faces on the body's boundary, got {came}"]
    areas = np.concatenate([a.sum(axis=1) for *_, a in read.mesh.face_integrals(part.faces)])
    normals = areas / np.linalg.norm(areas, axis=1, keepdims=True)
    facing = -normals @ axes[2]
    mean = areas.sum(axis=0) / np.linalg.norm(areas.sum(axis=0))
    text = f"the indenter moves along {table.direction}"
    if -mean @ axes[2] <= 0.0:
        normal = ", ".join(f"{component:.2g}" for component in mean)
        return part.faces, [
            f"contact_surface: expected to face the indenter; {text}, and the outward normal is "
            f"({normal})"
        ]
    if facing.min() < STEEPEST:
        steep = int((facing < STEEPEST).sum())
        lean = np.degrees(np.arccos(facing.min()))
        return part.faces, [
            f"contact_surface: expected to lean at most 30 degrees, because contact is linearised "
            f"({text}), got {steep} of {len(facing)} faces that lean up to {lean:.0f} degrees"
        ]
    return part.faces, []


def _support(
    mesh: SolidMesh,
    part: NamedPart,
    constraint: str,
    axes: np.ndarray,
    name: str,
    problems: list[str],
) -> Support:
    """Return a support in the contact frame; errors are appended to the problems."""
    if constraint != "roller":
        turned = [int(np.abs(axes[:, AXES.index(axis)]).argmax()) for axis in constraint]
        return Support(part.faces, part.nodes, tuple(sorted(turned)))
    normals = np.zeros((0, 3))
    if len(part.faces):
        normals = np.concatenate([a.sum(axis=1) for *_, a in mesh.face_integrals(part.faces)])
        normals = np.abs(normals) / np.linalg.norm(normals, axis=1, keepdims=True)
    axis = int(normals.sum(axis=0).argmax()) if len(normals) else 0
    if not len(normals) or (np.delete(normals, axis, axis=1) > ALIGNED).any():
        problems.append(
            f"supports.{name}: expected plane faces across x, y or z for a roller, got "
            + ("faces of other directions" if len(normals) else "no faces")
        )
    return Support(part.faces, mesh.nodes_of(part.faces), (axis,))
