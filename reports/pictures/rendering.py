"""The shapes of pictures as arrays, and their rendering in a process of its own, which may crash.

Run as ``python -m reports.pictures.rendering IN.npz OUT.png [IN.npz OUT.png ...]``;
`reports.pictures.pictures` defines the contents of the input, and `reports.pictures.turning` draws
the same shapes: rough surfaces, hills of pressure, bodies deformed and cut open.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from reports.plots.style import CONTACT

if TYPE_CHECKING:
    from vtkmodules.vtkRenderingCore import vtkActor, vtkRenderer

WINDOW = (810, 540)
MOST_SURFACE_POINTS = 400
VIEW = np.array([1.0, -1.25, 0.95])  # the common camera: front right, from above
# Viridis and cividis in ten steps (van der Walt & Smith, 2015; Nunez, Anderton & Renslow, PLoS ONE
# 13 (2018) e0199239).
VIRIDIS = (
    "#440154", "#482878", "#3e4989", "#31688e", "#26828e",
    "#1f9e89", "#35b779", "#6ece58", "#b5de2b", "#fde725",
)  # fmt: skip
CIVIDIS = (
    "#00224e", "#123570", "#3b496c", "#575d6d", "#707173",
    "#8a8678", "#a59c74", "#c3b369", "#e1cc55", "#fee838",
)  # fmt: skip
GREY = "#808080"
VTK_KIND = {4: 10, 8: 12}  # of a tetrahedron and of a brick, by its corners
Job = dict[str, np.ndarray]
Frame = tuple[tuple[float, float, float], float]  # the centre of a picture, and half its height
# Corners of the faces of a brick and of a tetrahedron in VTK order, normals outwards.
_FACES = {
    8: ((0, 3, 2, 1), (4, 5, 6, 7), (0, 1, 5, 4), (1, 2, 6, 5), (2, 3, 7, 6), (3, 0, 4, 7)),
    4: ((0, 2, 1), (0, 1, 3), (1, 2, 3), (2, 0, 3)),
}


def rough_surface(job: Job, most: int) -> tuple[np.ndarray, ...]:
    """Return x, y, exaggerated z, heights and contacts, at most so many points per side.

    The longer side is 1.
    """
    heights, longest = job["heights"], job["size"].max()
    step = int(np.ceil(max(heights.shape) / most))
    sides = zip(heights.shape, job["size"] / longest, strict=True)
    x, y = np.meshgrid(*((np.arange(n) + 0.5) / n * side for n, side in sides), indexing="ij")
    z = (heights - heights.mean()) * float(job["exaggeration"]) / longest
    return tuple(values[::step, ::step] for values in (x, y, z, heights, job["touching"]))


def pressure_hill(job: Job) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return x, y around the contact, some 1.3 times as wide as it, and p over the highest."""
    x, y, p = job["x"], job["y"], job["pressure"]
    inside = p > 0
    side = max(np.ptp(x[inside]), np.ptp(y[inside])) * 1.3 or 1.0
    x, y = (values - values[inside].mean() for values in (x, y))
    box = np.ix_(np.abs(x[:, 0]) <= side / 2, np.abs(y[0, :]) <= side / 2)
    return x[box] / side, y[box] / side, p[box] / float(job["highest"])


@dataclass(frozen=True)
class Piece:
    """Part of a mesh, with lengths in units of the reach and the body below z = 0."""

    points: np.ndarray
    cells: np.ndarray
    stress: np.ndarray
    pressure: np.ndarray


def deformed_piece(job: Job, *, clipped: bool = False) -> Piece:
    """Return the body in a box of twice the reach around the contact, completed by symmetry.

    Cells that cross the box are kept whole; `clipped` moves their corners onto its walls and
    interpolates the fields there.
    """
    reach = float(job["reach"])
    points = job["mesh_points"] / reach
    shift = job["mesh_displacement"] / reach * float(job["exaggeration"])
    stress, cells = job["mesh_von_mises"], job["mesh_cells"]
    cells = cells[np.abs(points[cells]).min(axis=1).max(axis=1) <= (1.0 if clipped else 1.1)]
    if clipped:
        # Points outside of the box go onto its walls, with the fields of four neighbours.
        inside = np.clip(points, -1.0, 1.0)
        beyond = (inside != points).any(axis=1)
        if beyond.any():
            from scipy.spatial import cKDTree  # half as long to import as VTK, which needs none

            distance, near = cKDTree(points).query(inside[beyond], k=4)
            weight = 1.0 / np.maximum(distance, 1e-12) ** 2
            weight /= weight.sum(axis=1, keepdims=True)
            shift, stress = shift.copy(), stress.copy()
            shift[beyond] = np.einsum("pk,pkc->pc", weight, shift[near])
            stress[beyond] = np.einsum("pk,pk->p", weight, stress[near])
            points = inside
    pressure = job["pressure"]
    moved = points + shift
    if points[:, 2].mean() > 0:
        moved, cells = mirrored(moved, cells, 2)
    for side in (0, 1):
        if points[:, side].min() >= -1e-9:  # half of a symmetric body: complete it
            image, image_cells = mirrored(moved, cells, side)
            cells = np.vstack([cells, image_cells + len(moved)])
            moved = np.vstack([moved, image])
            stress, pressure = np.tile(stress, 2), np.tile(pressure, 2)
    return Piece(moved, cells, stress, pressure)


def mirrored(points: np.ndarray, cells: np.ndarray, side: int) -> tuple[np.ndarray, np.ndarray]:
    """Return the mirror image, with corners renumbered to keep volumes positive."""
    image = points.copy()
    image[:, side] *= -1
    order = [1, 0, 2, 3] if cells.shape[1] == 4 else [1, 0, 3, 2, 5, 4, 7, 6]
    return image, cells[:, order]


def opened_surface(piece: Piece) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Return surface points, triangles and stress with the quarter x > 0, y < 0 cut out."""
    middle = piece.points[piece.cells].mean(axis=1)
    cells = piece.cells[~((middle[:, 0] > 0) & (middle[:, 1] < 0))]
    # Mirror images meet in points of their own: those at one place become one.
    _, first, number = np.unique(
        np.round(piece.points, 7), axis=0, return_index=True, return_inverse=True
    )
    cells = number.ravel()[cells]
    faces = cells[:, _FACES[piece.cells.shape[1]]].reshape(-1, len(_FACES[cells.shape[1]][0]))
    _, place, count = np.unique(
        np.sort(faces, axis=1), axis=0, return_index=True, return_counts=True
    )
    outer = faces[place[count == 1]]
    halves = [[0, 1, 2]] if outer.shape[1] == 3 else [[0, 1, 2], [0, 2, 3]]
    triangles = np.vstack([outer[:, half] for half in halves])
    used, triangles = np.unique(triangles, return_inverse=True)
    chosen = first[used]
    return piece.points[chosen], triangles.reshape(-1, 3), piece.stress[chosen]


def _shaped(kind: Any, points: np.ndarray, **fields: np.ndarray) -> Any:
    """Return a shape of VTK's with its points and fields; the first is shown."""
    from vtkmodules.util.numpy_support import numpy_to_vtk
    from vtkmodules.vtkCommonCore import vtkPoints

    shape, places = kind(), vtkPoints()
    places.SetData(numpy_to_vtk(np.ascontiguousarray(points, dtype=float), deep=True))
    shape.SetPoints(places)
    for name, values in fields.items():
        array = numpy_to_vtk(np.ascontiguousarray(values, dtype=float), deep=True)
        array.SetName(name)
        shape.GetPointData().AddArray(array)
    shape.GetPointData().SetActiveScalars(next(iter(fields)))
    return shape


def _relief(x: np.ndarray, y: np.ndarray, z: np.ndarray, values: np.ndarray) -> Any:
    """Return a surface over a grid."""
    from vtkmodules.vtkCommonDataModel import vtkStructuredGrid
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    points = np.column_stack([x.ravel(), y.ravel(), z.ravel()])
    grid = _shaped(vtkStructuredGrid, points, values=values.ravel())
    grid.SetDimensions(x.shape[1], x.shape[0], 1)
    return vtkDataSetSurfaceFilter()(grid)


def _show(
    renderer: vtkRenderer, shape: Any, tones: Sequence[str], low: float = 0.0, high: float = 1.0
) -> vtkActor:
    """Show a shape by its scalars on a scale of colours, or in one colour; NaN is contact."""
    from vtkmodules.vtkRenderingCore import vtkActor, vtkColorTransferFunction, vtkDataSetMapper

    scale = vtkColorTransferFunction()
    *shades, touching = ([c / 255 for c in bytes.fromhex(t[1:])] for t in (*tones, CONTACT))
    for place, shade in zip(np.linspace(low, high, len(tones)), shades, strict=True):
        scale.AddRGBPoint(place, *shade)
    scale.SetNanColor(touching)
    mapper, actor = vtkDataSetMapper(), vtkActor()
    mapper.SetInputDataObject(shape)
    mapper.SetLookupTable(scale)
    mapper.UseLookupTableScalarRangeOn()
    mapper.SetScalarVisibility(len(tones) > 1)
    mapper.InterpolateScalarsBeforeMappingOn()
    actor.SetMapper(mapper)
    actor.GetProperty().SetColor(shades[0])
    actor.GetProperty().SetInterpolationToFlat()
    renderer.AddActor(actor)
    return actor


def _rough(renderer: vtkRenderer, job: Job) -> Frame:
    from vtkmodules.vtkFiltersCore import vtkPolyDataNormals

    x, y, z, heights, touching = rough_surface(job, MOST_SURFACE_POINTS)
    relief = vtkPolyDataNormals(splitting=False)(
        _relief(x, y, z, np.where(touching, np.nan, heights))
    )
    actor = _show(renderer, relief, CIVIDIS, job["heights"].min(), job["heights"].max())
    actor.GetMapper().InterpolateScalarsBeforeMappingOff()
    actor.GetProperty().SetInterpolationToPhong()
    width, depth = job["size"] / job["size"].max()
    return (width / 2, depth / 2, 0.0), 0.53


def _hill(renderer: vtkRenderer, job: Job) -> Frame:
    x, y, p = pressure_hill(job)
    _show(renderer, _relief(x, y, 0.4 * p, p), VIRIDIS)
    return (0.0, 0.0, 0.12), 0.53


def _body(renderer: vtkRenderer, job: Job) -> Frame:
    """Draw the body near the contact, cut open, with the rim of the contact."""
    from vtkmodules import vtkFiltersCore
    from vtkmodules.util.numpy_support import numpy_to_vtkIdTypeArray
    from vtkmodules.vtkCommonDataModel import vtkCellArray, vtkUnstructuredGrid
    from vtkmodules.vtkFiltersGeneral import vtkBoxClipDataSet
    from vtkmodules.vtkFiltersGeometry import vtkDataSetSurfaceFilter

    piece = deformed_piece(job)
    body = _shaped(vtkUnstructuredGrid, piece.points, stress=piece.stress, pressure=piece.pressure)
    cells, numbers = vtkCellArray(), np.ascontiguousarray(piece.cells, dtype=np.int64)
    cells.SetData(numbers.shape[1], numpy_to_vtkIdTypeArray(numbers.ravel(), deep=True))
    body.SetCells(VTK_KIND[numbers.shape[1]], cells)
    # Sewn together where mirror images meet: no seam in the picture.
    sewn = vtkFiltersCore.vtkStaticCleanUnstructuredGrid(
        tolerance_is_absolute=True, absolute_tolerance=1e-9
    )
    big = 1e3
    box, quarter = vtkBoxClipDataSet(), vtkBoxClipDataSet(generate_clipped_output=True)
    box.SetBoxClip(-1.0, 1.0, -1.0, 1.0, -0.9, big)
    quarter.SetBoxClip(0.0, big, -big, 0.0, -big, big)
    near = box(sewn(body))[0]
    opened = vtkDataSetSurfaceFilter()(quarter(near)[1])
    # Shading would tell other stresses than the colour bar.
    _show(renderer, opened, VIRIDIS, 0.0, float(job["highest"])).GetProperty().LightingOff()
    edges = vtkFiltersCore.vtkFeatureEdges(
        feature_angle=40.0, boundary_edges=False, non_manifold_edges=False
    )
    _show(renderer, edges(opened), (GREY,)).GetProperty().SetLineWidth(1.5)
    top = vtkDataSetSurfaceFilter()(near)
    highest = top.GetPointData().GetArray("pressure").GetRange()[1]
    if highest > 0:
        rim = vtkFiltersCore.vtkContourFilter()
        rim.SetInputArrayToProcess(0, 0, 0, 0, "pressure")
        rim.SetValue(0, 0.02 * highest)
        line = _show(renderer, quarter(rim(top))[1], (CONTACT,)).GetProperty()
        line.LightingOff()
        line.SetLineWidth(8)
    return (0.0, 0.0, -0.36), 1.32


def _particles(renderer: vtkRenderer, job: Job) -> Frame:
    """Draw the particles as balls, a quarter of them taken away, with the surface up."""
    from vtkmodules.vtkCommonDataModel import vtkPolyData
    from vtkmodules.vtkFiltersCore import vtkGlyph3D
    from vtkmodules.vtkFiltersSources import vtkSphereSource

    places = job["places"] * np.array([1.0, 1.0, -1.0])
    ball = vtkSphereSource(
        radius=0.5 * float(job["spacing"]), theta_resolution=14, phi_resolution=10
    )
    balls = vtkGlyph3D(scaling=False, orient=False, color_mode=1)
    balls.SetSourceConnection(ball.GetOutputPort())
    cloud = balls(_shaped(vtkPolyData, places, stress=job["stress"]))
    light = _show(renderer, cloud, VIRIDIS, 0.0, float(job["highest"])).GetProperty()
    light.SetInterpolationToPhong()
    light.SetAmbient(0.5)
    return (0.0, 0.0, -0.36), 1.32


DRAWERS = {"rough": _rough, "body": _body, "particles": _particles, "hill": _hill}


def main(arguments: Sequence[str]) -> None:
    """Render every IN.npz to its OUT.png, written atomically."""
    from vtkmodules import vtkRenderingCore
    from vtkmodules.vtkIOImage import vtkPNGWriter
    from vtkmodules.vtkRenderingOpenGL2 import vtkRenderStepsPass, vtkSSAAPass

    for source, target in zip(arguments[::2], arguments[1::2], strict=True):
        with np.load(source, allow_pickle=False) as archive:
            job = {name: archive[name] for name in archive.files}
        renderer = vtkRenderingCore.vtkRenderer(background=(1.0, 1.0, 1.0))
        window = vtkRenderingCore.vtkRenderWindow()
        window.SetOffScreenRendering(True)
        window.SetSize(*WINDOW)
        window.SetAlphaBitPlanes(True)
        window.AddRenderer(renderer)
        vtkRenderingCore.vtkLightKit().AddLightsToRenderer(renderer)
        smooth = vtkSSAAPass()
        smooth.SetDelegatePass(vtkRenderStepsPass())
        renderer.SetPass(smooth)
        centre, extent = DRAWERS[str(job["kind"])](renderer, job)
        camera = renderer.GetActiveCamera()
        camera.ParallelProjectionOn()
        camera.SetFocalPoint(centre)
        camera.SetPosition(*(np.array(centre) + 5 * extent * VIEW))
        camera.SetViewUp(0.0, 0.0, 1.0)
        camera.SetParallelScale(extent)
        renderer.ResetCameraClippingRange()
        image = vtkRenderingCore.vtkWindowToImageFilter(input=window, read_front_buffer=False)
        image.SetInputBufferTypeToRGBA()
        unfinished = Path(target).with_suffix(".part.png")
        writer = vtkPNGWriter(file_name=str(unfinished))
        writer.SetInputConnection(image.GetOutputPort())
        writer.Write()
        unfinished.replace(target)


if __name__ == "__main__":
    main(sys.argv[1:])
    gc.freeze()  # the process ends: its objects are not looked through for garbage before
