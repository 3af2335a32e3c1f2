"""Three-dimensional pictures: the body cut open, the rough surface with its contacts.

Rendering runs in a separate process with a time limit (`reports.pictures.rendering`), so that a
study survives a graphics driver that crashes or hangs. A note replaces a picture that cannot be
rendered.
"""

from __future__ import annotations

import contextlib
import os
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
from scipy.spatial import cKDTree

from comparisons import formatting as fmt
from comparisons.facts.methods import METHODS, references
from comparisons.results import selection
from comparisons.results.store import SceneRecord
from reports.pictures import kept, turning
from reports.plots.style import look

STARTUP_SECONDS, PICTURE_SECONDS = 60.0, 30.0
NOTHING = "No picture: no method stored a surface or a body for this scene."
RENDERER_MISSING = "No picture: this machine has no working renderer."


@dataclass(frozen=True)
class ColourBar:
    """A colour bar, drawn by the page so that its text follows light and dark mode."""

    label: str
    low: str
    high: str
    palette: str  # "viridis" or "cividis"


@dataclass(frozen=True)
class Picture:
    """A picture, or the note that replaces it if `png` is empty.

    `view` is the same picture as an interactive plotly scene; it needs no renderer.
    """

    png: bytes = b""
    caption: str = ""
    bar: ColourBar | None = None
    note: str = ""
    view: dict[str, Any] | None = field(default=None, repr=False)


@dataclass(frozen=True)
class Job:
    """Input of the rendering process, and the picture to complete with its PNG."""

    arrays: dict[str, np.ndarray]
    caption: str
    bar: ColourBar


def draw(scenes: Sequence[SceneRecord], directory: Path) -> list[Picture]:
    """Return one picture or note per scene. Renderer failures raise no error.

    What was drawn stays in the results folder `directory`, for the next report.
    """
    jobs = [_job(scene) for scene in scenes]
    drawable = [job.arrays for job in jobs if isinstance(job, Job)]
    images = iter(kept.rendered(drawable, directory / kept.FOLDER, render))
    drawn = []
    for job in jobs:
        if isinstance(job, str):
            drawn.append(Picture(note=job))
            continue
        png = next(images)
        note = "" if png else RENDERER_MISSING
        drawn.append(Picture(png, job.caption, job.bar, note, _view(job.arrays)))
    return drawn


def _view(arrays: dict[str, np.ndarray]) -> dict[str, Any] | None:
    """Return the interactive view, or None if external arrays do not allow one."""
    with contextlib.suppress(ValueError, ArithmeticError, IndexError, MemoryError):
        return turning.view(arrays)
    return None


def render(jobs: Sequence[dict[str, np.ndarray]], command: Sequence[str] = ()) -> list[bytes]:
    """Render jobs in another process; failed ones return empty bytes.

    After a crash the current job is dropped and the rest is retried; two crashes without a single
    picture mean that no renderer is available.
    """
    images = [b""] * len(jobs)
    todo = list(range(len(jobs)))
    barren = 0
    with tempfile.TemporaryDirectory(prefix="roughline-pictures-") as folder:
        for index, job in enumerate(jobs):
            np.savez(Path(folder) / f"{index}.npz", allow_pickle=False, **job)
        while todo and barren < 2:
            _run([Path(folder) / f"{index}.npz" for index in todo], command)
            done = [index for index in todo if (Path(folder) / f"{index}.png").exists()]
            for index in done:
                images[index] = (Path(folder) / f"{index}.png").read_bytes()
            barren = 0 if done else barren + 1
            # The first job without a picture is the one that was at work.
            todo = [index for index in todo if index not in done][1:]
    return images


def _run(inputs: list[Path], command: Sequence[str]) -> None:
    start = list(command) or [sys.executable, "-m", "reports.pictures.rendering"]
    pairs = [
        str(path) for input_path in inputs for path in (input_path, input_path.with_suffix(".png"))
    ]
    root = str(Path(__file__).resolve().parents[2])
    environment = {name: value for name, value in os.environ.items() if name != "DISPLAY"}
    environment["PYTHONPATH"] = os.pathsep.join(
        filter(None, [root, environment.get("PYTHONPATH", "")])
    )
    environment["PYVISTA_OFF_SCREEN"] = "true"
    limit = STARTUP_SECONDS + PICTURE_SECONDS * len(inputs)
    # A crash or a missing interpreter leaves no files, which is all the caller looks at; the
    # drivers' own warnings would only alarm the reader of a terminal.
    try:
        subprocess.run(  # noqa: S603
            start + pairs,
            env=environment,
            cwd=inputs[0].parent,
            timeout=limit,
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
            check=False,
        )
    except (subprocess.TimeoutExpired, OSError):
        return


def _job(scene: SceneRecord) -> Job | str:
    """Choose the picture: rough surface, body cut open, particles, or pressure surface."""
    finest: dict[str, int] = {}
    for method, level in scene.fields:
        finest[method] = max(level, finest.get(method, level))
    order = sorted(references(), key=lambda name: not METHODS[name].grid)
    order += [name for name in selection.methods(scene) if name not in order]
    stored = {m: scene.load_fields(m, finest[m]) for m in order if m in finest}
    for build in (_rough_job, _body_job, _particle_job, _hill_job):
        for method, fields in stored.items():
            job = build(method, finest[method], fields)
            if job is not None:
                return job
    return NOTHING


def _touching(fields: dict[str, np.ndarray], shape: tuple[int, ...]) -> np.ndarray | None:
    """Return the contact cells: as stored, or where the stored pressure is positive."""
    contact = fields.get("contact", fields.get("pressure"))
    if contact is None or np.size(contact) != np.prod(shape):
        return None
    return np.reshape(contact, shape) > 0


def _rough_job(method: str, level: int, fields: dict[str, np.ndarray]) -> Job | None:
    if not {"heights", "size"} <= fields.keys():
        return None
    heights = np.asarray(fields["heights"], dtype=float)
    touching = _touching(fields, heights.shape)
    if touching is None or np.ptp(heights) == 0:
        return None
    size = np.ravel(fields["size"]) * np.ones(2)
    exaggeration = _rounded(0.12 * size.max() / np.ptp(heights))
    scale = fmt.prefix_for(heights, "m")
    arrays = {
        "kind": np.array("rough"),
        "heights": heights,
        "touching": touching,
        "size": size,
        "exaggeration": np.array(exaggeration),
    }
    caption = (
        f"The rough surface, peaks up ({fmt.with_unit(size[0], 'm')} × "
        f"{fmt.with_unit(size[1], 'm')}); its contacts at the last load in orange "
        f"({fmt.relative(touching.mean())} of the cells, {look(method).label}, N = {level}). "
        f"{_exaggerated('Heights', exaggeration)}"
    )
    bar = ColourBar(
        f"height h / {scale.unit}",
        fmt.number(heights.min() * scale.factor),
        fmt.number(heights.max() * scale.factor),
        "cividis",
    )
    return Job(arrays, caption, bar)


def _body_job(method: str, level: int, fields: dict[str, np.ndarray]) -> Job | None:
    needed = {"mesh_points", "mesh_cells", "mesh_displacement", "mesh_von_mises", "pressure"}
    if not needed <= fields.keys():
        return None
    x, y, pressure = (np.ravel(fields[f"pressure{end}"]) for end in ("_x", "_y", ""))
    patch = np.hypot(x, y)[pressure > 0]
    if not len(patch) or patch.max() == 0:
        return None
    points = np.asarray(fields["mesh_points"], dtype=float)
    # Three contact radii, or what a ball of coarse facets can fill to the corners.
    filled = np.linalg.norm(points, axis=1).max() / 2.1
    reach = float(min(3 * patch.max(), max(filled, 1.5 * patch.max())))
    near = np.abs(points).max(axis=1) <= reach
    if not near.any():
        return None
    deepest = np.abs(fields["mesh_displacement"][near]).max()
    exaggeration = _rounded(0.12 * reach / deepest) if deepest > 0 else 1.0
    stress = np.asarray(fields["mesh_von_mises"], dtype=float)
    # Under sharp edges a few nodes tower over all others; they would leave the rest dark.
    highest = float(np.quantile(stress[near], 0.995))
    scale = fmt.prefix_for(highest, "Pa")
    arrays = {name: np.asarray(fields[name]) for name in sorted(needed)}
    arrays |= {
        "kind": np.array("body"),
        "pressure_x": x,
        "pressure_y": y,
        "reach": np.array(reach),
        "highest": np.array(highest),
        "exaggeration": np.array(exaggeration),
    }
    caption = (
        f"The body cut open ({look(method).label}, N = {level}) at the last load; the line is the "
        f"contact boundary. {_exaggerated('Displacements', exaggeration)} The part shown is "
        f"{fmt.with_unit(2 * reach, 'm')} wide."
    )
    top = fmt.number(highest * scale.factor)
    bar = ColourBar(f"von Mises stress / {scale.unit}", "0", top, "viridis")
    return Job(arrays, caption, bar)


def _particle_job(method: str, level: int, fields: dict[str, np.ndarray]) -> Job | None:
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
    near[near] = _exposed(places[near], spacing)
    shift = np.asarray(fields["particle_displacement"], dtype=float)[near]
    deepest = np.abs(shift).max()
    exaggeration = _rounded(0.12 * reach / deepest) if deepest > 0 else 1.0
    stress = np.asarray(fields["particle_von_mises"], dtype=float)[near]
    highest = float(np.quantile(stress, 0.999))
    scale = fmt.prefix_for(highest, "Pa")
    arrays = {
        "kind": np.array("particles"),
        "places": (places[near] + exaggeration * shift) / reach,
        "stress": stress,
        "spacing": np.array(spacing / reach),
        "highest": np.array(highest),
    }
    caption = (
        f"The particles around the contact ({look(method).label}, N = {level}) at the last load, a "
        f"quarter of them taken away. {_exaggerated('Displacements', exaggeration)} The part shown "
        f"is {fmt.with_unit(2 * reach, 'm')} wide."
    )
    top = fmt.number(highest * scale.factor)
    return Job(arrays, caption, ColourBar(f"von Mises stress / {scale.unit}", "0", top, "viridis"))


def _exposed(places: np.ndarray, spacing: float) -> np.ndarray:
    """Return which particles can be seen: those without all of their twelve neighbours."""
    tree = cKDTree(places)
    return tree.query_ball_point(places, 1.1 * spacing, return_length=True) < 13


def _hill_job(method: str, level: int, fields: dict[str, np.ndarray]) -> Job | None:
    sides = [int(side) for side in np.ravel(fields.get("pressure_shape", []))]
    pressure = np.ravel(fields.get("pressure", []))
    if len(sides) != 2 or len(pressure) != sides[0] * sides[1] or not (pressure > 0).any():
        return None
    x, y, p = (np.ravel(fields[f"pressure{end}"]).reshape(sides) for end in ("_x", "_y", ""))
    highest = float(min(np.max(p), 4 * np.mean(p[p > 0])))
    scale = fmt.prefix_for(highest, "Pa")
    arrays = {
        "kind": np.array("hill"),
        "x": x,
        "y": y,
        "pressure": np.minimum(p, highest),
        "highest": np.array(highest),
    }
    caption = (
        f"The contact pressure at the last load as a surface ({look(method).label}, N = {level})."
    )
    top = fmt.number(highest * scale.factor)
    return Job(arrays, caption, ColourBar(f"pressure p / {scale.unit}", "0", top, "viridis"))


def _rounded(factor: float) -> float:
    """Round an exaggeration factor to one digit."""
    return max(1.0, float(f"{factor:.0e}"))


def _exaggerated(deformation: str, factor: float) -> str:
    return (
        f"{deformation} exaggerated {fmt.number(factor, 1)} times." if factor > 1 else "To scale."
    )
