"""What a results folder says of itself to archives: RO-Crate 1.1, and CodeMeta for the program.

``ro-crate-metadata.json`` lists the files of the folder with what they are, the command that wrote
them, when and on which machine (https://w3id.org/ro/crate/1.1); ``codemeta.json`` describes
roughline and the packages that its results depend on (https://w3id.org/codemeta/3.0).
"""

from __future__ import annotations

import json
from importlib import metadata
from pathlib import Path
from typing import Any

from comparisons.files import write_text
from comparisons.machine import machine, machine_text, versions
from comparisons.results.folder import CODEMETA, CRATE, PAGE

PROFILE = "https://w3id.org/ro/crate/1.1"
MOST_BYTES = 5_000_000  # a longer crate is none of ours
# What the files of a folder are, by name and else by ending.
ABOUT = {
    PAGE: "Report: verdicts, figures and tables in one page that opens offline",
    "study.json": "What was asked, plans, references, machine and versions",
    "results.csv": "A row for each scene, method, resolution, surface and load step, SI units",
    "measures.csv": "A row for each quantity of each setting: errors, bars, verdicts",
    "ensemble.json": "An ensemble of surfaces: what was asked, how far it is, digests",
    "statistics.csv": "Mean and scatter of each quantity over the surfaces, per load step",
    "claims.json": "Verdicts on claims with their measurements",
    "hard-cases.json": "Outcomes of methods on hard cases",
    "calibration.csv": "Error bars of references beside their true errors",
    CODEMETA: "The program that wrote this folder",
}
ENDINGS = {
    **dict.fromkeys((".npz", ".vtu"), "Fields of one solve"),
    ".parquet": "Curves of many surfaces",
}
FORMATS = {
    ".csv": "text/csv",
    ".html": "text/html",
    ".json": "application/json",
    ".npz": "application/zip",
    ".parquet": "application/vnd.apache.parquet",
    ".vtu": "application/vtk",
}


def describe(directory: Path, created: str, command: str) -> None:
    """Write both descriptions of a folder that a command has filled.

    Parameters
    ----------
    directory : Path
    created : str
        ISO date and time.
    command : str
        The command line.
    """
    write_text(directory / CODEMETA, _text(codemeta()))
    program = {"@id": CODEMETA, "name": f"roughline {versions().get('roughline', '')}".strip()}
    action = {
        "@id": "#run",
        "@type": "CreateAction",
        "name": command,
        "endTime": created,
        "instrument": {"@id": program["@id"]},
        "description": machine_text(machine(1)),
        "result": {"@id": "./"},
    }
    root = {
        "@id": "./",
        "@type": "Dataset",
        "name": f"Results of {program['name']}: {directory.resolve().name}",
        "description": "Contact of bodies, by the method of dimensionality reduction and by 3-D "
        "solvers on the same scenes, with errors and their bars.",
        "datePublished": created,
        "license": "not stated: whoever publishes the folder chooses it",
        "mentions": {"@id": "#run"},
    }
    _write(directory, [_itself(), root, action])


def relist(directory: Path) -> None:
    """List the files anew in the description of a folder, if it has one of ours."""
    try:
        text = (directory / CRATE).read_text(encoding="utf-8")
        graph = json.loads(text)["@graph"] if len(text) < MOST_BYTES else []
        own = [item for item in graph if item["@type"] != "File"]
    except (OSError, ValueError, KeyError, TypeError, RecursionError):
        return
    if [item.get("@id") for item in own] == [CRATE, "./", "#run"]:
        _write(directory, own)


def codemeta() -> dict[str, Any]:
    """Return the description of the program."""
    about = metadata.metadata("roughline")
    return {
        "@context": "https://w3id.org/codemeta/3.0",
        "@type": "SoftwareSourceCode",
        "name": "roughline",
        "version": about["Version"],
        "description": about["Summary"],
        "license": "https://spdx.org/licenses/MIT",
        "programmingLanguage": "Python",
        "keywords": (about["Keywords"] or "").split(","),
        "author": [{"@type": "Organization", "name": about["Author"]}],
        "softwareRequirements": [
            {"@type": "SoftwareApplication", "name": name, "version": version}
            for name, version in versions().items()
            if name != "roughline"
        ],
    }


def _itself() -> dict[str, Any]:
    return {
        "@id": CRATE,
        "@type": "CreativeWork",
        "conformsTo": {"@id": PROFILE},
        "about": {"@id": "./"},
    }


def _write(directory: Path, own: list[dict[str, Any]]) -> None:
    files = [_file(path, directory) for path in _files(directory)]
    parts = {"hasPart": [{"@id": item["@id"]} for item in files]}
    graph = [item | parts if item["@id"] == "./" else item for item in own]
    document = {"@context": f"{PROFILE}/context", "@graph": [*graph, *files]}
    write_text(directory / CRATE, _text(document))


def _files(directory: Path) -> list[Path]:
    """Return the files of a folder and of the folders in it, but those that are being written."""
    paths = [*directory.glob("*"), *directory.glob("*/*")]
    return sorted(
        path
        for path in paths
        if path.is_file()
        and path.name != CRATE
        and path.suffix in FORMATS
        and not any(part.startswith(".") for part in path.relative_to(directory).parts)
    )


def _file(path: Path, directory: Path) -> dict[str, Any]:
    about = ABOUT.get(path.name, ENDINGS.get(path.suffix, ""))
    return {
        "@id": path.relative_to(directory).as_posix(),
        "@type": "File",
        "name": about or path.name,
        "encodingFormat": FORMATS[path.suffix],
        "contentSize": str(path.stat().st_size),
    }


def _text(document: dict[str, Any]) -> str:
    return json.dumps(document, indent=1, ensure_ascii=False) + "\n"
