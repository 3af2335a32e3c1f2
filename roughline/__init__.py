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
    from comparisons.methods.function import method
    from roughline.changes import Changes, compare_runs
    from roughline.claims import ClaimVerdict, check_claim, list_claims
    from roughline.comparing import Comparison, compare
    from roughline.methods import add_method, list_methods
    from roughline.scenes import Plan, list_scenes, load_scene, plan
    from roughline.solving import Solution, solve
    from roughline.studies import Results, Study, load_results

_HOMES = {
    "InputError": "comparisons.errors",
    "method": "comparisons.methods.function",
    "Changes": "roughline.changes",
    "compare_runs": "roughline.changes",
    "ClaimVerdict": "roughline.claims",
    "check_claim": "roughline.claims",
    "list_claims": "roughline.claims",
    "Comparison": "roughline.comparing",
    "compare": "roughline.comparing",
    "add_method": "roughline.methods",
    "list_methods": "roughline.methods",
    "Plan": "roughline.scenes",
    "list_scenes": "roughline.scenes",
    "load_scene": "roughline.scenes",
    "plan": "roughline.scenes",
    "Solution": "roughline.solving",
    "solve": "roughline.solving",
    "Results": "roughline.studies",
    "Study": "roughline.studies",
    "load_results": "roughline.studies",
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
