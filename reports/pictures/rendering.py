"""Rendering of three-dimensional pictures in a separate process, which may crash safely.

Run as ``python -m reports.pictures.rendering IN.npz OUT.png [IN.npz OUT.png ...]``;
`reports.pictures.pictures` defines the contents of the input. Only the parts of VTK that draw are
imported: all of it takes longer to import than a picture takes to draw.
"""

from __future__ import annotations

import gc
import sys
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from vtkmodules import vtkRenderingOpenGL2  # its import makes windows and mappers those of OpenGL
from vtkmodules.util.numpy_support import numpy_to_vtk, numpy_to_vtkIdTypeArray
from vtkmodules.vtkCommonCore import vtkLookupTable, vtkPoints
from vtkmodules.vtkCommonDataModel import (
    VTK_HEXAHEDRON,
    VTK_TETRA,
    vtkCellArray,
    vtkPolyData,
    vtkStructuredGrid,
    vtkUnstructuredGrid,
)
from vtkmodules.vtkCommonExecutionModel import vtkAlgorithm
from vtkmodules.vtkFiltersCore import (
    vtkContourFilter,
    vtkFeatureEdges,
    vtkGlyph3D,
    vtkPolyDataNormals,
    vtkStaticCleanUnstructuredGrid,
)
from vtkmodules.vtkFiltersGeneral import vtkBoxClipDataSet
from vtkmodules.vtkFiltersGeometry import vtkGeometryFilter
from vtkmodules.vtkFiltersSources import vtkSphereSource
from vtkmodules.vtkIOImage import vtkPNGWriter
from vtkmodules.vtkRenderingCore import (
    vtkActor,
    vtkLightKit,
    vtkPolyDataMapper,
    vtkProperty,
    vtkRenderer,
    vtkRenderWindow,
    vtkWindowToImageFilter,
)

from reports.pictures.shapes import deformed_piece, pressure_hill, rough_surface
from reports.plots.style import CONTACT, PALETTES

WINDOW = (810, 540)
MOST_SURFACE_POINTS = 400
VIEW = np.array([1.0, -1.25, 0.95])  # the common camera: front right, from above
SHADES = 256
BIG = 1e3  # beyond everything that is drawn
Job = dict[str, np.ndarray]
Frame = tuple[tuple[float, float, float], float]  # the centre of a picture, and half its height


def _rough(renderer: vtkRenderer, job: Job) -> Frame:
    x, y, z, heights, touching = rough_surface(job, MOST_SURFACE_POINTS)
    shown = np.where(touching, np.nan, heights)
    surface, smooth = _surface(x, y, z, shown), vtkPolyDataNormals(splitting=False)
    smooth.SetInputConnection(surface.GetOutputPort())
    limits = float(job["heights"].min()), float(job["heights"].max())
    mapper, look = _added(renderer, smooth, "cividis", limits)
    mapper.SetInterpolateScalarsBeforeMapping(False)  # the edge of a contact is sharp
    look.SetInterpolationToPhong()
    width, depth = job["size"] / job["size"].max()
    return (width / 2, depth / 2, 0.0), 0.53


def _hill(renderer: vtkRenderer, job: Job) -> Frame:
    x, y, p = pressure_hill(job)
    look = _added(renderer, _surface(x, y, 0.4 * p, p), "viridis", (0.0, 1.0))[1]
    look.SetInterpolationToFlat()
    return (0.0, 0.0, 0.12), 0.53


def _body(renderer: vtkRenderer, job: Job) -> Frame:
    """Draw the body near the contact, cut open, with the rim of the contact."""
    piece = deformed_piece(job)
    body = vtkUnstructuredGrid(points=_points(piece.points))
    corners = piece.cells.shape[1]
    cells = vtkCellArray()
    cells.SetData(corners, numpy_to_vtkIdTypeArray(piece.cells.ravel().astype(np.int64), deep=True))
    body.SetCells(VTK_TETRA if corners == 4 else VTK_HEXAHEDRON, cells)
    for name in ("stress", "pressure"):
        _put(body, name, getattr(piece, name))
    # Mirror images are sewn together: no seam in the picture.
    sewn = vtkStaticCleanUnstructuredGrid(tolerance_is_absolute=True)
    sewn.SetAbsoluteTolerance(1e-9)
    sewn.SetInputData(body)
    box = vtkBoxClipDataSet()
    box.SetInputConnection(sewn.GetOutputPort())
    box.SetBoxClip(-1.0, 1.0, -1.0, 1.0, -0.9, BIG)
    skin = _without_quarter(box)
    highest = float(job["highest"])
    look = _added(renderer, skin, "viridis", (0.0, highest))[1]
    look.SetLighting(False)  # shading would tell other stresses than the colour bar
    edges = vtkFeatureEdges(
        feature_angle=40.0, boundary_edges=False, non_manifold_edges=False, coloring=False
    )
    edges.SetInputConnection(skin.GetOutputPort())
    look = _added(renderer, edges)[1]
    look.SetColor(*_rgb("#808080"))
    look.SetLineWidth(1.5)
    top = float(np.max(piece.pressure, initial=0.0))
    if top > 0:
        whole, rim = vtkGeometryFilter(), vtkContourFilter()
        whole.SetInputConnection(box.GetOutputPort())
        rim.SetInputConnection(whole.GetOutputPort())
        rim.SetInputArrayToProcess(0, 0, 0, 0, "pressure")
        rim.SetValue(0, 0.02 * top)
        look = _added(renderer, _without_quarter(rim))[1]
        look.SetColor(*_rgb(CONTACT))
        look.SetLineWidth(8.0)
        look.SetLighting(False)
    return (0.0, 0.0, -0.36), 1.32


def _particles(renderer: vtkRenderer, job: Job) -> Frame:
    """Draw the particles as balls, a quarter of them taken away, with the surface up."""
    cloud = vtkPolyData(points=_points(job["places"] * np.array([1.0, 1.0, -1.0])))
    _put(cloud, "stress", job["stress"])
    ball = vtkSphereSource(
        radius=0.5 * float(job["spacing"]), theta_resolution=14, phi_resolution=10
    )
    balls = vtkGlyph3D(scaling=False, orient=False)
    balls.SetColorModeToColorByScalar()
    balls.SetInputData(cloud)
    balls.SetSourceConnection(ball.GetOutputPort())
    look = _added(renderer, balls, "viridis", (0.0, float(job["highest"])))[1]
    look.SetInterpolationToPhong()
    look.SetAmbient(0.5)
    return (0.0, 0.0, -0.36), 1.32


DRAWERS = {"rough": _rough, "body": _body, "particles": _particles, "hill": _hill}


def _without_quarter(shape: vtkAlgorithm) -> vtkGeometryFilter:
    """Return the surface of a body, or lines, without the quarter in front."""
    cut, rest = vtkBoxClipDataSet(generate_clipped_output=True), vtkGeometryFilter()
    cut.SetInputConnection(shape.GetOutputPort())
    cut.SetBoxClip(0.0, BIG, -BIG, 0.0, -BIG, BIG)
    rest.SetInputConnection(cut.GetOutputPort(1))  # what is outside the box
    return rest


def _surface(x: np.ndarray, y: np.ndarray, z: np.ndarray, shown: np.ndarray) -> vtkGeometryFilter:
    """Return the surface above a grid, with the values that its colours show."""
    grid = vtkStructuredGrid(dimensions=(*x.shape, 1))
    grid.SetPoints(_points(np.column_stack([part.ravel(order="F") for part in (x, y, z)])))
    _put(grid, "shown", shown.ravel(order="F"))
    surface = vtkGeometryFilter()
    surface.SetInputData(grid)
    return surface


def _points(places: np.ndarray) -> vtkPoints:
    points = vtkPoints()
    points.SetData(numpy_to_vtk(np.ascontiguousarray(places), deep=True))
    return points


def _put(data: Any, name: str, values: np.ndarray) -> None:
    """Give values to the points; the first ones are those that colours show."""
    array = numpy_to_vtk(np.ascontiguousarray(values), deep=True)
    array.SetName(name)
    data.GetPointData().AddArray(array)
    if data.GetPointData().GetNumberOfArrays() == 1:
        data.GetPointData().SetActiveScalars(name)


def _added(
    renderer: vtkRenderer,
    shape: vtkAlgorithm,
    palette: str = "",
    limits: tuple[float, float] = (0.0, 1.0),
) -> tuple[vtkPolyDataMapper, vtkProperty]:
    """Add a shape to the picture, in the colours of a palette or in a single one."""
    mapper = vtkPolyDataMapper(scalar_visibility=bool(palette))
    mapper.SetInputConnection(shape.GetOutputPort())
    if palette:
        colours = np.array([_rgb(tone) for tone in PALETTES[palette]])
        places = np.linspace(0, 1, len(colours))
        shades = np.linspace(0, 1, SHADES)
        table = vtkLookupTable(number_of_table_values=SHADES, range=limits)
        for index, shade in enumerate(shades):
            table.SetTableValue(index, *(np.interp(shade, places, part) for part in colours.T))
        table.SetNanColor([*_rgb(CONTACT), 1.0])
        mapper.SetLookupTable(table)
        mapper.SetScalarRange(limits)
        mapper.SetInterpolateScalarsBeforeMapping(True)
    actor = vtkActor(mapper=mapper)
    renderer.AddActor(actor)
    return mapper, actor.GetProperty()


def _rgb(tone: str) -> tuple[float, ...]:
    return tuple(byte / 255 for byte in bytes.fromhex(tone.removeprefix("#")))


def main(arguments: Sequence[str]) -> None:
    """Render every IN.npz to its OUT.png, written atomically."""
    for source, target in zip(arguments[::2], arguments[1::2], strict=True):
        with np.load(source, allow_pickle=False) as archive:
            job = {name: archive[name] for name in archive.files}
        renderer = vtkRenderer(background=(0.3, 0.3, 0.3), background_alpha=0.0)
        vtkLightKit().AddLightsToRenderer(renderer)
        centre, extent = DRAWERS[str(job["kind"])](renderer, job)
        camera = renderer.GetActiveCamera()
        camera.SetParallelProjection(True)
        camera.SetFocalPoint(*centre)
        camera.SetPosition(*(np.array(centre) + 5 * extent * VIEW))
        camera.SetViewUp(0.0, 0.0, 1.0)
        camera.SetParallelScale(extent)
        renderer.ResetCameraClippingRange()
        smooth = vtkRenderingOpenGL2.vtkSSAAPass(
            delegate_pass=vtkRenderingOpenGL2.vtkRenderStepsPass()
        )
        renderer.SetPass(smooth)
        window = vtkRenderWindow(off_screen_rendering=True, size=WINDOW, alpha_bit_planes=True)
        window.SetMultiSamples(0)
        window.AddRenderer(renderer)
        window.Render()
        image = vtkWindowToImageFilter(input=window, read_front_buffer=False)
        image.SetInputBufferTypeToRGBA()
        unfinished = Path(target).with_suffix(".part.png")
        writer = vtkPNGWriter(file_name=str(unfinished))
        writer.SetInputConnection(image.GetOutputPort())
        writer.Write()
        unfinished.replace(target)


if __name__ == "__main__":
    main(sys.argv[1:])
    gc.freeze()  # the process ends: its objects are not looked through for garbage before
