"""Start-up check: the five packages have common names and may be shadowed by others."""

from __future__ import annotations

from importlib.util import find_spec
from pathlib import Path

SHADOWED = "roughline's packages are shadowed by others:"
PACKAGES = ("reduced", "reference", "comparisons", "reports")


def foreign_packages() -> list[str]:
    """Return one line for each of our packages that is shadowed.

    Resolves the packages as an import would, without importing them.

    Examples
    --------
    >>> foreign_packages()
    []
    """
    home = Path(__file__).resolve().parents[1]
    lines = []
    for name in PACKAGES:
        spec = find_spec(name)
        origin = (
            None
            if spec is None
            else spec.origin or next(iter(spec.submodule_search_locations or []), None)
        )
        if origin is None:
            lines.append(f"{name}: not found; roughline's own is {home / name}")
        elif Path(origin).resolve().parent != home / name:
            lines.append(
                f"{name}: {Path(origin).resolve().parent} shadows roughline's own {home / name}"
            )
    return lines
