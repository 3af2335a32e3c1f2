"""roughline in Python: the commands of ``roughline`` as functions, for notebooks and scripts.

The reduced model (Popov, *Contact Mechanics and Friction*, ch. 19) and 3-D solvers on the same
scene, with an error bar on the reference and the cost of each answer. Quantities are in SI units;
scenes also accept units such as "10 mm".

>>> import roughline
>>> ball = roughline.load_scene("paraboloid", {"compare.tolerance": 0.02})
>>> hertz = roughline.solve(ball, "closed_form")
>>> bool(hertz["force"][-1] > 0)
True
>>> comparison = roughline.compare(ball, "closed_form", "reduced")
>>> comparison.verdict
'within'

Importing the package is fast: each name is loaded on first use.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from comparisons.errors import InputError
    from comparisons.methods.solver import method
    from roughline.claims import ClaimVerdict, check_claim, list_claims
    from roughline.comparing import Comparison, compare
    from roughline.scenes import Plan, list_scenes, load_scene, plan
    from roughline.solving import Solution, add_method, list_methods, solve
    from roughline.studies import Changes, Results, Study, compare_runs, load_results

_HOMES = {
    name: home
    for home, names in {
        "comparisons.errors": ("InputError",),
        "comparisons.methods.solver": ("method",),
        "roughline.claims": ("ClaimVerdict", "check_claim", "list_claims"),
        "roughline.comparing": ("Comparison", "compare"),
        "roughline.scenes": ("Plan", "list_scenes", "load_scene", "plan"),
        "roughline.solving": ("Solution", "add_method", "list_methods", "solve"),
        "roughline.studies": ("Changes", "Results", "Study", "compare_runs", "load_results"),
    }.items()
    for name in names
}

__all__ = [
    "Changes",
    "ClaimVerdict",
    "Comparison",
    "InputError",
    "Plan",
    "Results",
    "Solution",
    "Study",
    "add_method",
    "check_claim",
    "compare",
    "compare_runs",
    "list_claims",
    "list_methods",
    "list_scenes",
    "load_results",
    "load_scene",
    "method",
    "plan",
    "solve",
]


def __getattr__(name: str) -> Any:
    if name == "__version__":
        from comparisons.machine import own_version

        return own_version()
    if name not in _HOMES:
        raise AttributeError(f"module 'roughline' has no attribute {name!r}")
    value = getattr(import_module(_HOMES[name]), name)
    globals()[name] = value
    return value


def __dir__() -> list[str]:
    return [*__all__, "__version__"]
