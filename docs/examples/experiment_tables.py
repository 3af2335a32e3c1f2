"""Make the tables of docs/experiments.md: readings of Fig. 19.8, and the verdicts on the claims.

Run from the repository's root (a quarter of an hour on one core); the tables between the markers of
the page are written anew::

    python docs/examples/experiment_tables.py
"""

# %%
import re
from pathlib import Path

from comparisons.claims.claim import load_claims
from comparisons.claims.runner import judge_claim
from comparisons.experiments import EXPERIMENTS

PAGE = Path(__file__).resolve().parents[1] / "experiments.md"
LOADS = (0.001, 0.003, 0.01, 0.03, 0.1)

# %% [markdown]
# What "the surface's contact area" and "the line" may mean in Fig. 19.8.

COUNTED = {"quantity": "contact_area_raw", "grid": "native"}
READINGS = {
    "counted cells, C1D sampled (as printed)": {**COUNTED, "rule": "printed"},
    "as printed, H = 0.3": {**COUNTED, "rule": "printed", "hurst": 0.3},
    "as printed, springs counted whole": {
        **COUNTED,
        "rule": "printed",
        "edges": "nodal",
        "line_points": 64,
    },
    "area at vanishing spacing, ring sums": {},
    "the same, periodic": {"periodic": True},
    "the same, H = 0.3": {"hurst": 0.3},
    "the same, plateau above L/8": {"roll_off": 8},
    "the same, shortest wave 8 dx": {"shortest": 8},
    "the same, line of L/8": {"line_length": 0.125},
    "counted, H = 0.3, plateau above L/8, line of L/8": {
        **COUNTED,
        "hurst": 0.3,
        "roll_off": 8,
        "line_length": 0.125,
    },
}


def readings(realisations: int = 120, effort: str = "full") -> list[list[str]]:
    """Area of the line over that of the surface, by reading and load, with its bar."""
    measure = EXPERIMENTS["rough-contact"].measure
    rows = [["reading (H = 0.8 unless said)", *(f"F = {load:g}" for load in LOADS)]]
    for name, parameters in READINGS.items():
        found = [measure(load, effort, realisations=realisations, **parameters) for load in LOADS]
        cells = [f"{1 + each.error:.2f} ± {each.uncertainty:.2f}" for each in found]
        rows.append([name, *cells])
    return rows


def load_curves(realisations: int = 300, effort: str = "full") -> list[list[str]]:
    """Other quantities of the line over those of the surface, by load."""
    measure = EXPERIMENTS["rough-contact"].measure
    rows = [
        ["quantity (line over surface, H = 0.8, free patch)", *(f"F = {load:g}" for load in LOADS)]
    ]
    for name in ("penetration", "stiffness", "mean_gap", "contact_length", "contact_area"):
        found = [measure(load, effort, realisations=realisations, quantity=name) for load in LOADS]
        cells = [f"{1 + each.error:.2f} ± {each.uncertainty:.2f}" for each in found]
        rows.append([name.replace("_", " "), *cells])
    return rows


# %%
def verdicts() -> list[list[str]]:
    """Every claim that an experiment judges, at full effort."""
    rows = [["claim", "equation", "verdict", "found"]]
    for claim in load_claims():
        if claim.experiment is None:
            continue
        record = judge_claim(claim, "full")
        rows.append([f"`{claim.id}`", claim.equation, record.verdict, record.sentence])
    return rows


# %%
def markdown(rows: list[list[str]]) -> str:
    """Rows as a table."""
    head, *body = (f"| {' | '.join(row)} |" for row in rows)
    return "\n".join([head, "|" + "---|" * len(rows[0]), *body])


TABLES = {"readings": readings, "load-curves": load_curves, "verdicts": verdicts}


def written(page: str) -> str:
    """Return the page with every table between its markers made anew."""
    for name, make in TABLES.items():
        block = re.compile(f"(<!-- table: {name} -->\n).*?(<!-- end -->)", re.DOTALL)
        table = markdown(make())
        page = block.sub(lambda found, table=table: f"{found[1]}{table}\n{found[2]}", page)
    return page


# %%
if __name__ == "__main__":
    PAGE.write_text(written(PAGE.read_text(encoding="utf-8")), encoding="utf-8")
