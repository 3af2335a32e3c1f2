"""The command ``roughline solve``: one scene, one method."""

from __future__ import annotations

import sys
from pathlib import Path

from reports.cli.arguments import Flag, MaybeWhole, overrides_of
from reports.cli.method_files import NO_METHOD_FILES, MethodFiles
from reports.printable import say

FINE, LOST = 0, 1


def solve(
    scene: str,
    *,
    method: str,
    resolution: MaybeWhole = None,
    option: tuple[str, ...] = (),
    json: Flag = False,
    csv: Path | None = None,
    vtu: Path | None = None,
    threads: int = 1,
    method_files: MethodFiles = NO_METHOD_FILES,
) -> int:
    """Solve one scene with one method.

    Parameters
    ----------
    scene
        A scene file or the name of a built-in scene.
    method
        The method, one of those in `roughline list methods`.
    resolution
        Springs, cells or elements per contact radius; for rough surfaces, points per side.
    option
        KEY=VALUE, an option of the method; may be repeated.
    json
        Print one JSON object.
    csv
        Write the load steps to this CSV file.
    vtu
        Write the fields at the last load to this VTU file, for ParaView.
    threads
        Threads that share large grids of the half-space (from 512 x 512); digits do not change.
    """
    from comparisons.errors import InputError
    from comparisons.questions.single import solve_scene
    from reports.cli import terminal

    method_files.load()
    if json and csv is not None:
        raise InputError("--json and --csv: expected at most one")
    if csv is not None and csv == vtu:
        raise InputError(f"--csv and --vtu: expected two files, got {csv} twice")
    for target in (csv, vtu):
        if (
            target is not None
            and Path(scene).exists()
            and target.exists()
            and target.samefile(scene)
        ):
            raise InputError(f"{target}: expected a file other than the scene itself")
    options = tuple(
        setting if "." in setting.partition("=")[0] else f"{method}.{setting}" for setting in option
    )
    overrides = overrides_of(method, options)
    result = solve_scene(
        scene, method, resolution, overrides, with_fields=vtu is not None, threads=threads
    )
    if vtu is not None:
        result.write_vtu(vtu)
    if json:
        print(result.to_json())
    elif csv is not None:
        result.write_csv(csv)
    else:
        terminal.print_solution(result)
    for note in result.plan.doubts:
        say(note, sys.stderr)
    if not result.converged:
        say("\n".join(result.reasons), sys.stderr)
    return FINE if result.converged else LOST
