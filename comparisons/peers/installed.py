"""The versions of packages, asked in an interpreter by `comparisons.methods.peers.live`."""

from __future__ import annotations

from importlib import metadata


def versions(packages: list[str]) -> dict[str, str]:
    """Return the version of each package, "" where it is not installed."""
    found = {}
    for name in packages:
        try:
            found[name] = metadata.version(name)
        except metadata.PackageNotFoundError:
            found[name] = ""
    return found
