"""The command ``roughline ensemble``: very many surfaces, in Parquet files."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

from reports.cli.arguments import Flag, MaybeWhole, overrides_of, part_of
from reports.cli.method_files import NO_METHOD_FILES, MethodFiles
from reports.cli.workers import ALONE, Workers

FINE, LOST = 0, 1


def ensemble(
    scene: str,
    *,
    surfaces: MaybeWhole = None,
    methods: str = "bem_fft",
    option: tuple[str, ...] = (),
    out: Path | None = None,
    overwrite: Flag = False,
    part: str | None = None,
    resume: Flag = False,
    workers: Workers = ALONE,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Solve very many surfaces of a scene; write their curves as Parquet files, and statistics.

    Parameters
    ----------
    scene
        A scene file or built-in scene with a random surface.
    surfaces
        Number of surfaces; default: `realisations` of the scene.
    methods
        Comma-separated list of methods, at the resolutions of the scene's [compare], by default the
        surface's own points.
    option
        METHOD.KEY=VALUE, an option of a method; may be repeated.
    out
        Folder for the results; default roughline-results/NAME-ensemble.
    overwrite
        Replace existing results.
    part
        K/N: solve only the Kth of N equal ranges of the surfaces, for `roughline merge`.
    resume
        Continue an interrupted run, or one with fewer surfaces.
    """
    from comparisons.questions.ensemble import WHOLE, Ensemble
    from comparisons.scene.scene import load_scene
    from reports.cli import terminal
    from reports.cli.live import watched

    method_files.load()
    overrides = overrides_of(methods, option)
    if surfaces is not None:
        overrides["surface.realisations"] = surfaces
    loaded = load_scene(scene, overrides)
    campaign = Ensemble(
        loaded,
        out or Path("roughline-results") / f"{loaded.name}-ensemble",
        part=WHOLE if part is None else part_of(part),
        command=shlex.join(["roughline", *sys.argv[1:]]),
        effort="full",
        executor=workers.executor(),
        resume=resume,
        overwrite=overwrite,
    )
    result = watched(campaign, lambda: None)
    terminal.print_ensemble(result, campaign.directory)
    lost = sum(setting.lost for setting in result.record.settings)
    return LOST if lost or result.record.missing else FINE
