"""Three-dimensional pictures: the body cut open, the rough surface with its contacts.

Rendering runs in a separate process with a time limit (`reports.pictures.rendering`), so that a
study survives a graphics driver that crashes or hangs. A note replaces a picture that cannot be
rendered.
"""

from __future__ import annotations

import contextlib
import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from io import BytesIO
from pathlib import Path

import numpy as np
from scipy.spatial import cKDTree

from comparisons import formatting as fmt
from comparisons.facts.methods import METHODS, references
from comparisons.files import write_atomically
from comparisons.results.record import SceneRecord
from reports.pictures import NOTHING, ColourBar, Picture, turning
from reports.pictures.rendering import Piece, Shape, deformed_piece, opened_surface, surface
from reports.plots.stored import stored_fields

FOLDER = "pictures"  # in the results folder
MOST_BYTES = 4_000_000  # of a stored picture
DIGITS = 32  # of a digest
DRAWING = "rendering.py"  # what a picture depends on besides its data
STARTUP_SECONDS, PICTURE_SECONDS = 60.0, 30.0
RENDERER_MISSING = "No picture: this machine has no working renderer."


@dataclass(frozen=True)
class Job:
    """What the rendering process draws, and the picture to complete with its PNG."""

    shape: Shape
    caption: str
    bar: ColourBar


def draw(scenes: Sequence[SceneRecord], directory: Path) -> list[Picture]:
    """Return one picture or note per scene. Renderer failures raise no error.

    What was drawn stays in the results folder `directory`, for the next report.
    """
    jobs = [picture_job(scene) for scene in scenes]
    images = iter(stored_or_rendered([job.shape.arrays for job in jobs if job], directory / FOLDER))
    drawn = []
    for job in jobs:
        if job is None:
            drawn.append(Picture(note=NOTHING))
            continue
        png = next(images)
        note = "" if png else RENDERER_MISSING
        drawn.append(Picture(png, job.caption, job.bar, note, turning.view(job.shape)))
    return drawn


def stored_or_rendered(jobs: Sequence[dict[str, np.ndarray]], folder: Path) -> list[bytes]:
    """Return the PNG of every job, from `folder` where it is there; empty where rendering failed.

    A picture is named by the digest of its data and of the program that draws it; those of no job
    are removed.
    """
    code = Path(__file__).with_name(DRAWING).read_bytes()
    paths, images = [], []
    for job in jobs:
        digest = hashlib.sha256(code)
        for name, array in sorted(job.items()):
            digest.update(f"{name} {array.dtype} {array.shape} ".encode())
            digest.update(np.ascontiguousarray(array).tobytes())
        path = folder / f"{digest.hexdigest()[:DIGITS]}.png"
        # A link, or a file of another kind, is no picture.
        known = path.is_file() and not path.is_symlink() and path.stat().st_size <= MOST_BYTES
        png = path.read_bytes() if known else b""
        paths.append(path)
        images.append(png if png.startswith(b"\x89PNG") else b"")
    missing = [index for index, png in enumerate(images) if not png]
    for index, png in zip(missing, render([jobs[index] for index in missing]), strict=True):
        images[index] = png
        if png:
            write_atomically(paths[index], partial(shutil.copyfileobj, BytesIO(png)))
    for path in {*folder.glob("[0-9a-f]" * DIGITS + ".png")}.difference(paths):
        path.unlink()
    return images


def render(jobs: Sequence[dict[str, np.ndarray]], command: Sequence[str] = ()) -> list[bytes]:
    """Render jobs in another process; failed ones return empty bytes.

    After a crash the current job is dropped and the rest is retried; two crashes without a single
    picture mean that no renderer is available.
    """
    start = list(command) or [sys.executable, "-m", "reports.pictures.rendering"]
    root = str(Path(__file__).resolve().parents[2])
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    environment["PYTHONPATH"] = os.pathsep.join(
        filter(None, [root, environment.get("PYTHONPATH", "")])
    )
    environment["PYVISTA_OFF_SCREEN"] = "true"
    images = [b""] * len(jobs)
    todo = list(range(len(jobs)))
    barren = 0
    with tempfile.TemporaryDirectory(prefix="roughline-pictures-") as folder:
        sources = [Path(folder) / f"{index}.npz" for index in todo]
        targets = [source.with_suffix(".png") for source in sources]
        for source, job in zip(sources, jobs, strict=True):
            np.savez(source, allow_pickle=False, **job)
        while todo and barren < 2:
            pairs = [str(path) for index in todo for path in (sources[index], targets[index])]
            # A crash or a missing interpreter leaves no files, which is all that counts here; the
            # drivers' own warnings would only alarm the reader of a terminal.
            with contextlib.suppress(subprocess.TimeoutExpired, OSError):
                subprocess.run(  # noqa: S603
                    start + pairs,
                    env=environment,
                    cwd=folder,
                    timeout=STARTUP_SECONDS + PICTURE_SECONDS * len(todo),
                    stdin=subprocess.DEVNULL,
                    stdout=subprocess.DEVNULL,
                    stderr=subprocess.DEVNULL,
                    check=False,
                )
            done = [index for index in todo if targets[index].exists()]
            for index in done:
                images[index] = targets[index].read_bytes()
            barren = 0 if done else barren + 1
            # The first job without a picture is the one that was at work.
            todo = [index for index in todo if index not in done][1:]
    return images


def picture_job(scene: SceneRecord) -> Job | None:
    """Choose the picture: rough surface, body cut open, particles, or pressure surface."""
    order = sorted(references(), key=lambda name: not METHODS[name].grid)
    order += [name for name in scene.methods if name not in order]
    stored = list(stored_fields(scene, order))
    for build in (_rough_job, _body_job, particle_job, _hill_job):
        for item in stored:
            # External arrays may not make a shape.
            with contextlib.suppress(ValueError, ArithmeticError, IndexError, MemoryError):
                if job := build(item.source, item.fields):
                    return job
    return None


def _rough_job(source: str, fields: dict[str, np.ndarray]) -> Job | None:
    if not {"heights", "size"} <= fields.keys():
        return None
    heights = np.asarray(fields["heights"], dtype=float)
    # Half a cell or more in contact, as stored, or where the stored pressure is positive.
    contact = fields.get("contact", fields.get("pressure", np.empty(0)) > 0)
    if np.size(contact) != heights.size or np.ptp(heights) == 0:
        return None
    touching = np.reshape(contact, heights.shape) >= 0.5
    size = np.ravel(fields["size"]) * np.ones(2)
    exaggeration = _exaggeration(size.max(), np.ptp(heights))
    scale = fmt.prefix_for(heights, "m")
    # In units of its longer side, about its middle.
    sides = zip(heights.shape, size / size.max(), strict=True)
    x, y = np.meshgrid(*(((np.arange(n) + 0.5) / n - 0.5) * a for n, a in sides), indexing="ij")
    z = (heights - heights.mean()) * exaggeration / size.max()
    shade = np.where(touching, np.nan, (heights - heights.min()) / np.ptp(heights))
    caption = (
        f"The rough surface, peaks up ({fmt.with_unit(size[0], 'm')} × "
        f"{fmt.with_unit(size[1], 'm')}); its contacts at the last load in orange ({source}). "
        f"{_exaggerated('Heights', exaggeration)}"
    )
    bar = ColourBar(
        f"height h / {scale.unit}",
        fmt.number(heights.min() * scale.factor),
        fmt.number(heights.max() * scale.factor),
        "cividis",
    )
    return Job(surface(x, y, z, shade, "cividis", 0.0), caption, bar)


def _body_job(source: str, fields: dict[str, np.ndarray]) -> Job | None:
    needed = {"mesh_points", "mesh_cells", "mesh_displacement", "mesh_von_mises", "pressure"}
    if not needed <= fields.keys():
        return None
    x, y, pressure = (np.ravel(fields[f"pressure{end}"]) for end in ("_x", "_y", ""))
    points, patch = np.asarray(fields["mesh_points"], dtype=float), np.hypot(x, y)[pressure > 0]
    known = np.isfinite(points).all() and np.isfinite([x, y]).all()
    if not known or patch.max(initial=0.0) == 0:
        return None
    # Three contact radii, or what a ball of coarse facets can fill to the corners.
    filled = np.linalg.norm(points, axis=1).max() / 2.1
    reach = float(min(3 * patch.max(), max(filled, 1.5 * patch.max())))
    near = np.abs(points).max(axis=1) <= reach
    if not near.any():
        return None
    deepest = np.abs(fields["mesh_displacement"][near]).max()
    exaggeration = _exaggeration(reach, deepest)
    stress = np.asarray(fields["mesh_von_mises"], dtype=float)
    # Under sharp edges a few nodes tower over all others; they would leave the rest dark.
    highest = float(np.quantile(stress[near], 0.995))
    # The pressure at mesh points of the surface, zero beside the contact, none inside.
    distance, nearest = cKDTree(np.column_stack([x, y])).query(points[:, :2])
    on_top = np.abs(points[:, 2]) <= 1e-9 * reach
    known = np.where(distance < 1e-6 * reach, pressure[nearest], 0.0)
    whole = Piece(points / reach, fields["mesh_cells"], stress, np.where(on_top, known, np.nan))
    shift = fields["mesh_displacement"] / reach * exaggeration
    body = opened_surface(deformed_piece(whole, shift))
    caption = (
        f"The body cut open ({source}) at the last load; the line is the "
        f"contact boundary. {_exaggerated('Displacements', exaggeration)} The part shown is "
        f"{fmt.with_unit(2 * reach, 'm')} wide."
    )
    shade, triangles = body.stress / highest, body.cells
    shape = Shape(body.points, shade, "viridis", -0.36, 1.32, (), triangles, body.pressure)
    return Job(shape, caption, _from_zero("von Mises stress", highest))


def particle_job(source: str, fields: dict[str, np.ndarray]) -> Job | None:
    """Return the particles around the contact, with a quarter of them taken away."""
    needed = {"particle_places", "particle_displacement", "particle_von_mises", "particle_spacing"}
    if not {*needed, "pressure"} <= fields.keys():
        return None
    touching = np.ravel(fields["pressure"]) > 0
    x, y = (np.ravel(fields[f"pressure{end}"])[touching] for end in ("_x", "_y"))
    spacing = float(fields["particle_spacing"])
    places = np.asarray(fields["particle_places"], dtype=float)
    reach = 3 * float(np.hypot(x, y).max(initial=0.0)) or 3 * spacing
    near = np.abs(places).max(axis=1) <= reach
    # the quarter in front is taken away: one sees into the body
    near &= (places[:, 0] <= spacing / 4) | (places[:, 1] >= -spacing / 4)
    if not near.any():
        return None
    # Those with all of their twelve neighbours cannot be seen.
    tree = cKDTree(places[near])
    near[near] = tree.query_ball_point(places[near], 1.1 * spacing, return_length=True) < 13
    shift = np.asarray(fields["particle_displacement"], dtype=float)[near]
    deepest = np.abs(shift).max()
    exaggeration = _exaggeration(reach, deepest)
    stress = np.asarray(fields["particle_von_mises"], dtype=float)[near]
    highest = float(np.quantile(stress, 0.999))
    shown = (places[near] + exaggeration * shift) / reach * np.array([1.0, 1.0, -1.0])
    caption = (
        f"The particles around the contact ({source}) at the last load, a "
        f"quarter of them taken away. {_exaggerated('Displacements', exaggeration)} The part shown "
        f"is {fmt.with_unit(2 * reach, 'm')} wide."
    )
    shape = Shape(shown, stress / highest, "viridis", -0.36, 1.32, ball=spacing / reach)
    return Job(shape, caption, _from_zero("von Mises stress", highest))


def _hill_job(source: str, fields: dict[str, np.ndarray]) -> Job | None:
    sides = [int(side) for side in np.ravel(fields.get("pressure_shape", []))]
    pressure = np.ravel(fields.get("pressure", []))
    if len(sides) != 2 or len(pressure) != sides[0] * sides[1] or not (pressure > 0).any():
        return None
    x, y, p = (np.ravel(fields[f"pressure{end}"]).reshape(sides) for end in ("_x", "_y", ""))
    # Peaks at sharp edges tower over the pressure below which half of the force is borne.
    peak, rising = float(np.max(p)), np.sort(p[p > 0])
    borne = np.cumsum(rising)
    highest = min(peak, 4 * float(rising[np.searchsorted(borne, borne[-1] / 2)]))
    caption = f"The contact pressure at the last load as a surface ({source})."
    if highest < peak:
        caption += f" Peaks above {fmt.with_unit(highest, 'Pa')} are cut off."
    # In units of some 1.3 times the width of the contact, about its middle.
    inside, shade = p > 0, np.minimum(p, highest) / highest
    side = max(np.ptp(x[inside]), np.ptp(y[inside])) * 1.3 or 1.0
    x, y = ((values - values[inside].mean()) / side for values in (x, y))
    box = np.ix_(np.abs(x[:, 0]) <= 0.5, np.abs(y[0, :]) <= 0.5)
    shape = surface(x[box], y[box], 0.4 * shade[box], shade[box], "viridis", 0.12)
    return Job(shape, caption, _from_zero("pressure p", highest))


def _from_zero(label: str, highest: float) -> ColourBar:
    scale = fmt.prefix_for(highest, "Pa")
    top = fmt.number(highest * scale.factor)
    return ColourBar(f"{label} / {scale.unit}", "0", top, "viridis")


def _exaggeration(size: float, extent: float) -> float:
    """Return how many times an extent is drawn as large, to be seen on what has a size."""
    return max(1.0, float(f"{0.12 * size / extent:.0e}")) if extent > 0 else 1.0


def _exaggerated(deformation: str, factor: float) -> str:
    return (
        f"{deformation} exaggerated {fmt.number(factor, 1)} times." if factor > 1 else "To scale."
    )
