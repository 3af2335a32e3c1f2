"""The card of a scene: what touches, how it is loaded, and how large the pressures are."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
from pydantic import BaseModel

from comparisons import formatting as fmt
from comparisons.facts.methods import CLOSED_FORM, MODEL
from comparisons.facts.quantities import quantity
from comparisons.facts.quantities.rows import HALF_AXES
from comparisons.judging.verdicts import WITHIN
from comparisons.questions.claims.nearest import in_words, nearest_to
from comparisons.results.finding import is_found
from comparisons.results.record import SceneRecord, once
from comparisons.results.rows import Rows
from comparisons.scene.fields import unit_of
from comparisons.scene.loading import LoadRange
from comparisons.scene.scene import PREPARATION, Scene
from comparisons.tasks.stresses import FROM_PRESSURE
from reports.plots.axes import key_words
from reports.plots.stored import stored_fields
from reports.tables.scene import stresses

NO_INPUT = {"name", "title", "loading", "compare", "methods", "directory"}
UNSAID = {"seed", "realisations"}  # of a surface: the report names them elsewhere
KINDS = {"shape", "kind", "model"}  # keys whose value says what the table is
SIDES = {"size", "points"}
LOADS = ("penetration", "force", "mean_gap", "contact_area", *HALF_AXES)
# Dimensions whose unit takes a prefix, and what is easier to read than base units.
PREFIXED = {"m", "s", "N", "Pa"}


TRUE_VALUES, VON_MISES, YIELD = "true values by", "von Mises' stress", "yield stress Y"
OUTLINE_STIFF = "largest stiffness"
# Also below the verdicts of one scene in a terminal.
SAID = (TRUE_VALUES, VON_MISES, YIELD, OUTLINE_STIFF)
HARDNESS = 3.0  # over the yield stress
FIRST_YIELD = 1.6  # highest pressure over the yield stress, under a ball (Johnson 1985, eq. 6.9)
# Share of the stiffness of a flat punch as large as the patch that is worth a word.
OUTLINE = 0.5
# Yield stress over E* of the strongest metals: 2 GPa of a bearing steel with E* = 230 GPa; and E*
# of the softest ones that bear loads, as lead.
STRONGEST, SOFTEST_METAL = 0.01, 15e9


@once
def card(scene: SceneRecord) -> list[tuple[str, str]]:
    """Return the lines of a scene's card, each a heading and a text.

    Bodies with their moduli; loads and true values, from the smallest to the largest, with their
    bars; where nothing pulls, the mean pressure F/A, and under an indenter without an edge the
    highest pressure that the reference found, with the largest von Mises stress inside; of rough
    surfaces the reduced load F/(E* A0 h'), and below which yield stress they are plastic.
    """
    body = scene.scene
    if body is None:
        return _loads(scene)
    surface, indenter = scene.plan.roughness, body.indenter
    nominal = surface.area if surface else indenter.face_area if indenter else None
    lines = list(_bodies(body))
    if (truth := scene.reference.method) and truth != CLOSED_FORM:
        said = f"{scene.title_of(truth)}, N = {scene.reference.resolution}"
        sources = {  # of more than a tenth of the bar of any true value
            source: None
            for name, parts in scene.reference.sources.items()
            for source, part in parts.items()
            if (np.array(part) > 0.1 * scene.reference.bar(name)).any()
        }
        if sources:
            said += f"; ± of {fmt.listed([*sources])} alone"
        if surface and surface.skewness is not None:
            if PREPARATION not in body.sweep:  # else a table has all of them
                said += "; how the map was prepared may move them more (--sensitivity)"
        elif surface and body.realisations == 1:
            said += "; of one surface: others of this spectrum may differ by more"
        lines.append((TRUE_VALUES, said))
    lines += _loads(scene, nominal)
    rows = _reference_curve(scene)
    steps = rows["step"]
    most = (
        stresses(scene, scene.reference.method, int(steps[-1]), FROM_PRESSURE) if len(steps) else {}
    )
    # a free edge of a patch is as sharp as a punch
    free = body.surface is not None and not body.surface.periodic
    edged = free and (body.realisations > 1 or _may_reach_the_edge(scene))
    if most.get("pressure_peak"):
        which = "" if scene.of_one_load else ", last load"
        text = fmt.with_unit(most["pressure_peak"], "Pa")
        text += " (singular where a contact reaches the patch's edge)" if edged else ""
        lines.append((f"highest pressure{which}", text))
    if fmt.finite(most.get("von_mises_max")) and "von_mises_depth" in most:
        stress = fmt.with_unit(most["von_mises_max"], "Pa")
        depth = fmt.with_unit(most["von_mises_depth"], "m")
        of = ""
        if body.counter_body:
            of = f" of the half-space (ν = {body.half_space.poisson_ratio:g})"
        text = (
            f"{stress}, {depth} below the surface{of}: elastic only if its yield stress is higher"
        )
        text += "" if body.dynamics else " ([plasticity] models what yields)"
        lines.append((VON_MISES, text))
    pressed = rows["contact_area"] > 0
    if body.rough and not body.physics and pressed.any():
        # The mean pressure of contacts is at most the hardness, 3 Y (Tabor 1951).
        least = float(np.max(rows["force"][pressed] / rows["contact_area"][pressed])) / HARDNESS
        text = f"below F/(3 A) = {fmt.with_unit(least, 'Pa')} contacts are plastic throughout"
        if most.get("pressure_peak") and not edged:
            first = fmt.with_unit(most["pressure_peak"] / FIRST_YIELD, "Pa")
            text += f"; all is elastic only above {first} (highest pressure/{FIRST_YIELD})"
        modulus = body.effective_modulus
        if _one_body(body) and least > STRONGEST * modulus > STRONGEST * SOFTEST_METAL:
            text += f". It is E*/{fmt.number(modulus / least, 2)}, and metals have up to "
            text += f"E*/{1 / STRONGEST:.0f}: a [plasticity] table models that they yield"
        lines.append((YIELD, text))
    if roughness := scene.plan.roughness:
        height, slope = fmt.with_unit(roughness.rms_height, "m"), roughness.rms_slope
        noise = roughness.noise_wavelength if roughness.skewness is not None else 0.0
        text = f"; waves below {fmt.with_unit(noise, 'm')} have a flat spectrum, as noise has"
        text = f"rms height {height}, rms slope h' {fmt.number(slope)}{text if noise else ''}"
        lines.append(("roughness", text))
        force = rows["force"]
        if roughness.area and np.isfinite(force).any():
            scale = body.effective_modulus * roughness.area * slope
            lines.append(("reduced load F/(E* A₀ h')", _range(force / scale, "")))
        stiffness = rows["stiffness"]
        if body.surface and not (body.surface.periodic or body.physics) and nominal:
            face = 2 * body.effective_modulus * np.sqrt(nominal / np.pi)
            share = float(np.fmax.reduce(stiffness, initial=0.0)) / face
            if share > OUTLINE:
                text = f"{fmt.number(share)} of that of a flat punch as large as the patch, 2 E* "
                text += "√(A₀/π), about the most there is: near it the size decides, not the "
                text += "roughness. If the borders join, periodic = true has no edge"
                lines.append((OUTLINE_STIFF, text))
    if said := not_known_here(scene):
        lines.append(("use the reduced model?", said))
    return lines


def not_known_here(scene: SceneRecord) -> str:
    """Return that the reduced model can agree by chance only, and what is known; else ""."""
    held = any(item.word == WITHIN for item in scene.verdicts_on(MODEL) if is_found(scene, item))
    if not held or not (reason := scene.by_chance(MODEL)):
        return ""
    said = f"Not known here, because agreement is chance: {reason}."
    return " ".join(filter(None, [said, in_words(nearest_to(scene), scene.tolerance)]))


def _one_body(scene: Scene) -> bool:
    """Tell whether E* is of one body on a rigid one: a given E* may be of two elastic ones."""
    return scene.half_space.effective_modulus is None and scene.counter_body is None


def _bodies(scene: Scene) -> Iterator[tuple[str, str]]:
    """Yield each table of bodies and physics as words with units, and E*."""
    for name in Scene.model_fields:
        table = getattr(scene, name)
        words = list(_words(table)) if isinstance(table, BaseModel) else []
        if words and name not in NO_INPUT:
            rigid = "rigid " if name == "indenter" and _one_body(scene) else ""
            yield name.replace("_", " "), rigid + ", ".join(words)
    if scene.half_space.effective_modulus is None or scene.counter_body is not None:
        yield "effective modulus E*", fmt.with_unit(scene.effective_modulus, "Pa")


def _words(table: BaseModel) -> Iterator[str]:
    """Yield what a table says, key by key, with units; tables in it in brackets."""
    for key, field in type(table).model_fields.items():
        value = getattr(table, key)
        if key not in table.model_fields_set or key in UNSAID:
            continue
        if key in KINDS:
            yield str(value).replace("_", " ")
            continue
        unit = unit_of(field)
        if key == "coefficient" and hasattr(table, "exponent"):  # of f = c r^n
            unit = f"1/m^{table.exponent - 1:g}"
        if isinstance(value, LoadRange):
            texts = [
                _text(end, unit)
                for end in dict.fromkeys(value.values[:: len(value.values) - 1 or 1])
            ]
            joint = " to "
        else:
            several = value if isinstance(value, tuple) else (value,)
            texts, joint = [_text(item, unit) for item in several], " × " if key in SIDES else " / "
        if texts and all(texts):
            yield f"{key_words(key)} {joint.join(texts)}"


def _text(value: Any, unit: str) -> str:
    """Return a number, a word or a table of a table; nothing for a switch."""
    if isinstance(value, str):
        return value
    if isinstance(value, BaseModel):
        return f"({', '.join(_words(value))})"
    if isinstance(value, bool) or not isinstance(value, (int, float)):
        return ""
    if unit in PREFIXED:
        return fmt.unpadded(value, unit)
    return f"{fmt.unpadded(value, '')} {unit}".strip()


def _reference_curve(scene: SceneRecord) -> Rows:
    return scene.curve(scene.reference.method)


def _loads(scene: SceneRecord, nominal: float | None = None) -> list[tuple[str, str]]:
    rows = _reference_curve(scene)
    lines = [
        (quantity(name).label, value)
        for name in dict.fromkeys((*LOADS, *scene.quantities))
        if (value := true_value(scene, name))
    ]
    force, area = rows["force"], rows["contact_area"]
    if nominal and np.isfinite(force).any():
        lines.append(("nominal pressure F/A₀", _range(force / nominal, "Pa")))
    pressed = (force > 0) & (area > 0)
    if pressed.any() and not (force < 0).any():
        lines.append(("mean pressure F/A", _range(force[pressed] / area[pressed], "Pa")))
    return lines


def true_value(scene: SceneRecord, name: str, *, nominal: float | None = None) -> str:
    """Return what the reference found at all loads, and how well that is known.

    "" where it has not computed the quantity. What is exact, prescribed or not compared, as the
    area of a flat face, has no bar. Areas and forces may be over the `nominal` area.
    """
    values = _reference_curve(scene)[name] / (nominal or 1.0)
    if not np.isfinite(values).any():
        return ""
    unit = quantity(name).unit
    if nominal:
        unit = "Pa" if name == "force" else ""
    text = _range(values, unit)
    bars = scene.reference.known_to(name)
    if scene.reference.exact:
        bars = bars[bars > fmt.ROUND_OFF]
    if name == scene.control or (scene.reference.exact and not len(bars)):
        return text
    if len(bars):
        return f"{text} ± {fmt.relative_range(bars)}"
    return f"{text} ± ?" if name in scene.quantities else text


def _may_reach_the_edge(scene: SceneRecord) -> bool:
    """Tell whether the one surface is pressed at the edge of its patch, or that is not known."""
    fields = next((item.fields for item in stored_fields(scene, [scene.reference.method])), {})
    if "pressure_shape" not in fields:
        return True
    pressure = fields["pressure"].reshape(fields["pressure_shape"])
    return bool(np.any(pressure[[0, -1]]) or np.any(pressure[:, [0, -1]]))


def _range(values: np.ndarray, unit: str) -> str:
    """Return the smallest and the largest of what is known."""
    least, most = float(np.nanmin(values)), float(np.nanmax(values))
    ends = (fmt.with_unit(end, unit) if end or least == most else "0" for end in (least, most))
    return " to ".join(dict.fromkeys(ends))
