"""Pictures of what the physics of a scene stores at a load: slip, films, wear, dents, stresses.

Every function takes a SceneRecord and returns maps and curves over a place, by the reference if it
has stored them, or none if no method has.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import griddata

from comparisons import formatting as fmt
from comparisons.facts.quantities import quantity
from comparisons.results.record import SceneRecord
from comparisons.tasks.shown_loads import SLIP, at_step, stored_steps
from reports.plots.axes import log_axis
from reports.plots.figure import NO_SCALE, Axis, Figure, Map, coarsened, line, map_figure, outer
from reports.plots.stored import Fields, at_last_load, finest_fields, slider_steps
from reports.plots.style import DASHED, DOTTED, INK, MUTED, Look, look

# Colours and section of a film end at this multiple of its central value: outside the gap is wide.
WIDEST_FILM = 5.0
HIGHEST_WORN = 1.5  # heights of a worn body are shown up to so many times the highest that wears
SHADES = ("#9ecae1", "#4292c6", "#08519c", "#08306b")
SECTION_POINTS = 160  # a side of a section
BEYOND_YIELD = 1.4  # its reach over what has yielded
SECTION_DEPTHS = 120
DENTED = "residual_depth force contact_area"
STRESSED = "pressure force contact_area"


def slips(scene: SceneRecord) -> list[Figure]:
    """Return the map of stick and slip under a roller and that of the traction, for every creep."""
    stored = finest_fields(scene, *SLIP)
    if stored is None:
        return []
    last, loads = stored.fields, slider_steps(scene)
    known = set(stored_steps(last))
    frames = [at_step(last, step) for step in loads.steps[:-1] if step in known] + [last]
    if len(frames) != len(loads.steps):
        frames = [last]

    def in_contact(frame: Fields, name: str) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return x, y and the values on the rows and columns of the grid that carry pressure."""
        shape = tuple(int(side) for side in np.ravel(frame["pressure_shape"]))
        x, y, pressure, values = (
            np.reshape(frame[key], shape) for key in ("pressure_x", "pressure_y", "pressure", name)
        )
        rows, columns = (np.flatnonzero((pressure > 0).any(axis=axis)) for axis in (1, 0))
        inside = slice(rows[0], rows[-1] + 1), slice(columns[0], columns[-1] + 1)
        return x[inside][:, 0], y[inside][0], np.where(pressure > 0, values, np.nan)[inside]

    bound = "Traction over its bound µp: 1 where it slips."
    drawn = [("friction_used", "slip-map", "Stick and slip", bound, "|q|/(µp)", NO_SCALE)]
    for axis in "xy":
        name, key, title = f"traction_{axis}", f"traction-{axis}", f"Traction along {axis}"
        traction = np.abs(last[name])
        if np.nanmax(traction) > 0:
            scale = fmt.prefix_for(traction, "Pa")
            drawn.append((name, key, title, "On the half-space.", "q", scale))
    figures = []
    for name, key, title, what, symbol, scale in drawn[:2]:
        highest = max(float(np.nanmax(frame[name])) for frame in frames)
        maps = [Map(*in_contact(frame, name), symbol, scale, highest) for frame in frames]
        caption = f"{what} {stored.source}. The contact moves to the right."
        shown = "traction tangential_force stick_area"
        figures.append(map_figure(key, title, caption, maps, shown))
    return figures


def films(scene: SceneRecord) -> list[Figure]:
    """Return the map of a lubricating film with its cavity, and a section with the pressure."""
    names = ("film", "vapour", "pressure", "pressure_x", "pressure_y")
    stored = finest_fields(scene, *names, "pressure_shape")
    if stored is None:
        return []
    shape = tuple(int(n) for n in stored.fields["pressure_shape"])
    if len(shape) != 2 or any(stored.fields[name].size != np.prod(shape) for name in names):
        return []
    film, vapour, pressure, x, y = (stored.fields[name].reshape(shape) for name in names)
    central = float(film.ravel()[np.argmin(np.hypot(x, y))])
    source, shown = f"{stored.source}{at_last_load(scene)}.", "film_central film_minimum"
    cavity = "Oil comes from the left. Empty: vapour fills a part of the gap. "
    on_map = map_figure(
        "film-map",
        "Film and cavity",
        f"Thickness of the film, {source} {cavity if np.any(vapour > 0) else ''}The colours end at "
        "five times its central value.",
        [
            Map(
                *coarsened(x[:, 0], y[0, :], np.where(vapour > 0, np.nan, film)),
                "h",
                fmt.prefix_for(WIDEST_FILM * central, "m"),
                WIDEST_FILM * central,
            )
        ],
        shown,
    )
    row = shape[1] // 2
    along, thickness = x[:, row], film[:, row] / central
    near = thickness < WIDEST_FILM
    colour = look(stored.method).colour
    section = Figure(
        "film-section",
        "Section through film and pressure",
        f"Through the middle, {source}",
        Axis("x", scale=fmt.prefix_for(along, "m"), limits=outer(along[near])),
        Axis("film, pressure", limits=(0.0, WIDEST_FILM / 2)),
        tuple(
            line(style, along[near], values[near])
            for style, values in (
                (Look("film over central film", colour), thickness),
                (Look("oil in the gap", colour, dash=DOTTED), thickness * (1 - vapour[:, row])),
                (
                    Look("pressure over its maximum", INK),
                    pressure[:, row] / max(pressure.max(), 1e-300),
                ),
            )
        ),
        quantity=shown,
    )
    return [on_map, section]


def worn_profiles(scene: SceneRecord) -> list[Figure]:
    """Return the section of a body that wears, before and after each step."""
    stored = finest_fields(scene, "worn_r", "worn_shapes")
    if stored is None:
        return []
    x, shapes = np.ravel(stored.fields["worn_r"]), stored.fields["worn_shapes"]
    if shapes.ndim != 2 or shapes.shape[1] != x.size or len(shapes) < 2:
        return []
    worn = shapes[-1] > shapes[0]
    if not worn.any():
        return []
    top = HIGHEST_WORN * float(shapes[-1][worn].max())
    near = (shapes[0] <= top) | worn
    steps, row = len(shapes) - 1, quantity(scene.control)
    rows = scene.curve(stored.method, stored.resolution)
    values = rows[scene.control][:steps]
    if len(values) < steps:
        labels = [f"step {number}" for number in range(1, steps + 1)]
    elif row.unit:
        labels = [fmt.with_unit(value, row.unit) for value in values]
    else:
        labels = [f"{fmt.number(value)} {row.label}" for value in values]
    looks = [Look("unworn", MUTED, dash=DASHED)]
    for number, label in enumerate(labels, 1):
        shade = SHADES[round((len(SHADES) - 1) * number / steps)]
        looks.append(Look(label, INK if number == steps else shade))
    return [
        Figure(
            "worn-profile",
            "Worn profile",
            f"{stored.source}: a section of the body, which touches from above. Heights count from "
            "its unworn lowest point.",
            Axis("place x", scale=fmt.prefix_for(x[near], "m")),
            Axis("height", scale=fmt.prefix_for(top, "m")),
            tuple(
                line(style, x[near], shape[near])
                for style, shape in zip(looks, shapes, strict=True)
            ),
        )
    ]


def dents(scene: SceneRecord) -> list[Figure]:
    """Return what yields: the dents of a rough surface, or the section below an indenter."""
    flat = finest_fields(scene, "dent")
    if flat is not None:
        depth, size = flat.fields["dent"], np.ravel(flat.fields["size"])
        x, y = ((np.arange(n) + 0.5) * side / n for n, side in zip(depth.shape, size, strict=True))
        return [
            map_figure(
                "dent-map",
                "Dents of the surface",
                "Plastic displacement under a pressure that has reached the hardness. "
                f"{flat.source}{at_last_load(scene)}.",
                [Map(x, y, depth, "depth", fmt.prefix_for(depth, "m"), float(depth.max()))],
                "residual_depth plastic_share contact_area",
            )
        ]
    stored = finest_fields(scene, "section_plastic_strain")
    if stored is None or not np.any(stored.fields["section_plastic_strain"] > 0):
        return []
    r, z, strain, stress, surface_r, sunk = (
        np.ravel(stored.fields[name])
        for name in (
            *("section_r", "section_z", "section_plastic_strain", "section_von_mises"),
            *("surface_r", "surface_depth"),
        )
    )
    source = f"{stored.source}{at_last_load(scene)}."
    reach = BEYOND_YIELD * float(np.hypot(r, z)[strain > 0].max())
    near = (r < 1.5 * reach) & (z < 1.5 * reach)
    points = r[near], z[near]
    axis = np.linspace(0, reach, SECTION_POINTS)
    figures = []
    percent, pascal = fmt.Scale(100.0, "%"), fmt.prefix_for(stress, "Pa")
    unloaded = "Von Mises' stress; without a load, what is left of it"
    for key, title, subject, values, symbol, scale in (
        ("plastic-zone", "Plastic zone", "Equivalent plastic strain", strain, "ε", percent),
        ("von-mises", "Von Mises' stress", unloaded, stress, "σ", pascal),
    ):
        grid = tuple(np.meshgrid(axis, axis, indexing="ij"))
        inside = griddata(points, values[near], grid, method="linear")
        # between the axis or the surface and the first points of the elements: the nearest
        rim = np.isnan(inside)
        inside[rim] = griddata(points, values[near], tuple(g[rim] for g in grid), method="nearest")
        figures.append(
            map_figure(
                key,
                title,
                f"{subject}, in a half-section: the axis on the left, the surface at the top. "
                f"{source}",
                [Map(axis, -axis[::-1], inside[:, ::-1], symbol, scale, float(inside.max()))],
                DENTED,
                (Axis("radius", "r"), Axis("height", "z")),
            )
        )
    shown = np.flatnonzero(surface_r <= 4 * BEYOND_YIELD * float(r[strain > 0].max()))
    shown = shown[np.argsort(surface_r[shown])]
    profile = Figure(
        "dent-profile",
        "Shape of the surface",
        f"Height of the half-space's surface; a dent is below zero, what piles up above. {source}",
        Axis("radius", "r", scale=fmt.prefix_for(surface_r[shown], "m")),
        Axis("height", "z", scale=fmt.prefix_for(sunk[shown], "m")),
        (line(look(stored.method), surface_r[shown], -sunk[shown]),),
        quantity=DENTED,
    )
    return [*figures, profile]


def stresses_below(scene: SceneRecord) -> list[Figure]:
    """Return von Mises' stress in a section below a contact on a grid, and the largest by depth."""
    stored = finest_fields(scene, "von_mises_highest")
    if stored is None:
        return []
    cells, about, first = stored.fields.get("stressed_cells"), "", ", where the body first yields"
    if cells is not None:
        about = f" Computed below {cells[0]} × {cells[1]} cells about the highest pressure alone."
        first = ""
    source = f"{stored.source}{at_last_load(scene)}.{about}"
    depth, highest = stored.fields["von_mises_depth"], stored.fields["von_mises_highest"]
    points = stored.fields["mesh_points"].reshape(len(depth), -1, 3)
    x, y = (np.unique(points[0, :, k]) for k in (0, 1))
    stress = stored.fields["mesh_von_mises"].reshape(len(depth), len(x), len(y))
    through = int(np.unravel_index(stress.argmax(), stress.shape)[2])
    down = np.linspace(0.0, min(float(depth[-1]), float(np.ptp(x)) / 2), SECTION_DEPTHS)
    cut = np.array([np.interp(down, depth, column) for column in stress[:, :, through].T])
    scale = fmt.prefix_for(stress, "Pa")
    section = map_figure(
        "stress-section",
        "Von Mises' stress below the contact",
        f"In a section along x where it is largest, the surface at the top. {source}",
        [Map(x, -down[::-1], cut[:, ::-1], "σ", scale, float(stress.max()))],
        STRESSED,
        (Axis("x"), Axis("height", "z")),
    )
    worst = int(highest.argmax())
    place, value = (
        fmt.with_unit(float(depth[worst]), "m"),
        fmt.with_unit(float(highest[worst]), "Pa"),
    )
    hover = [
        f"{fmt.with_unit(value, 'Pa')} at a depth of {fmt.with_unit(place, 'm')}"
        for place, value in zip(depth[1:], highest[1:], strict=True)
    ]
    where = "at the surface" if worst == 0 else f"{place} below the surface"
    profile = Figure(
        "stress-depth",
        "Largest stress at a depth",
        f"Von Mises' stress, the largest of all places at a depth. It peaks at {value}, "
        f"{where}{first}. {source}",
        log_axis("depth −z", (depth[1], depth[-1]), lambda value: fmt.with_unit(value, "m", 1)),
        Axis("largest von Mises' stress", "σ", scale=fmt.prefix_for(highest[1:], "Pa")),
        (replace(line(look(stored.method), depth[1:], highest[1:]), hover=tuple(hover)),),
        quantity=STRESSED,
    )
    return [section, profile]
