"""A rigid rough line on independent springs: connected contacts and the area rule (19.29)."""

from __future__ import annotations

from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from reduced.errors import ConvergenceError, choice_faults, count_faults, positive_faults, refuse
from reduced.loads import EDGES, Load
from reduced.rough import inversion
from reduced.rough.walk import Ends

CONTROLS = {
    "penetration": inversion.PENETRATION,
    "force": inversion.FORCE,
    "mean_gap": inversion.MEAN_GAP,
}
_SHORT = 1024  # points up to which sorting a line is cheaper than a ladder of levels
_BLOCK = 2**15  # points per block, or one long line


@dataclass(frozen=True, eq=False)
class RoughLines:
    """Rigid rough lines, one or many: heights (m, n) or (n,), positive towards the half-space.

    A free line of n points is n dx long, half a cell beyond its outer points.

    >>> RoughLines([0.0, 1.0, 0.0, 0.0], 0.5).length
    2.0
    """

    heights: np.ndarray
    spacing: float
    periodic: bool = True

    def __post_init__(self) -> None:
        heights = np.atleast_2d(np.ascontiguousarray(self.heights, dtype=float))
        object.__setattr__(self, "heights", heights)
        wrong = []
        if heights.ndim != 2 or heights.shape[1] < 2 or heights.shape[0] < 1:
            wrong.append(f"lines must have shape (m, n) or (n,), n >= 2, got {heights.shape}")
        elif not np.all(np.isfinite(heights)):
            wrong.append("lines must be finite")
        refuse(wrong + positive_faults(spacing=self.spacing))

    @property
    def length(self) -> float:
        """Length of the lines."""
        return self.heights.shape[1] * self.spacing

    def __len__(self) -> int:
        return len(self.heights)

    def __getitem__(self, row: int) -> RoughLines:
        """Return one of the lines."""
        return RoughLines(self.heights[row], self.spacing, self.periodic)

    def single(self) -> np.ndarray:
        """Return the heights of a single line, shape (n,); raise an error if there are several."""
        if len(self.heights) != 1:
            raise ValueError(f"give one line, got {len(self.heights)}")
        return self.heights[0]


@dataclass(frozen=True)
class LineContact:
    """Contact of m lines at k loads; every array has shape (m, k).

    The penetration d counts from first touch of the highest peak (negative if a prescribed mean gap
    leaves the line out of contact); F = E* int (h - z)_+ dx, springs of stiffness E* dx (19.14);
    A = (pi/4) sum l_j^2 over the connected contacts (19.29); the contact length is sum l_j, the
    mean gap that of (z - h)_+ over the line. The stiffness is dF/dd on the fixed contact set,
    E* sum l_j, the energy the integral of F over d.
    """

    penetration: np.ndarray
    force: np.ndarray
    contact_area: np.ndarray
    contact_length: np.ndarray
    contact_count: np.ndarray
    mean_gap: np.ndarray
    stiffness: np.ndarray
    energy: np.ndarray


def press(
    lines: RoughLines,
    effective_modulus: float,
    load: Load,
    *,
    edges: str = "sub_cell",
    threads: int = 1,
) -> LineContact:
    """Solve the contact of rigid rough lines on independent springs, all loads together.

    With ``edges="sub_cell"`` the line is linear between its points and a contact ends where it
    meets the surface; ``"nodal"`` uses the chapter's sums over whole springs with h_i > z. Forces
    and mean gaps, those of one line, are inverted to rounding. A contact across the seam of a
    periodic line is one contact. Values beyond the range of floating point are inf.

    >>> tent = RoughLines([0.0, 1.0, 0.0, 0.0], 1.0)  # slopes of 1 at both sides of one peak
    >>> contact = press(tent, 1.0, Load("penetration", 0.5))
    >>> contact.contact_length, contact.force
    (array([[1.]]), array([[0.25]]))
    """
    wrong = positive_faults(effective_modulus=effective_modulus)
    refuse(wrong + choice_faults("edges", edges, EDGES) + count_faults(threads=threads))
    control, loads, heights = load.one_of(*CONTROLS), load.values, lines.heights
    stiff, cell = effective_modulus * lines.spacing, lines.spacing
    goals = loads / stiff if control == "force" else loads
    found = np.empty((inversion.FOUND, heights.shape[0], loads.size))
    ends = Ends(edges == "sub_cell", bool(lines.periodic))

    def press_rows(rows: slice) -> None:
        block = heights[rows]
        ordered = control != "penetration" and block.shape[1] <= _SHORT
        orders = (block if ordered else block[:, :0]).argsort(axis=1)
        steps = inversion.press_lines(
            *(heights, orders, rows.start, CONTROLS[control], goals, ends, found)
        )
        if not np.all(steps <= inversion.CONVERGED):
            row = rows.start + int(np.argmax(~(steps <= inversion.CONVERGED)))
            raise ConvergenceError(f"{control} of line {row} could not be inverted", steps.tolist())

    # blocks of rows small enough for the cache
    count, rows = heights.shape[0], max(1, _BLOCK // heights.shape[1])
    blocks = [slice(begin, min(begin + rows, count)) for begin in range(0, count, rows)]
    if threads == 1 or len(blocks) == 1:
        for block in blocks:
            press_rows(block)
    else:
        with ThreadPoolExecutor(threads) as pool:
            list(pool.map(press_rows, blocks))
    force, length, squares, count, energy, penetration, gap = found
    given = np.broadcast_to(loads, force.shape).copy()
    return LineContact(
        penetration=penetration,
        force=given if control == "force" else stiff * force,
        contact_area=np.pi / 4 * cell * cell * squares,
        contact_length=cell * length,
        contact_count=count.astype(np.int64),
        mean_gap=given if control == "mean_gap" else gap,
        stiffness=stiff * length,
        energy=stiff * energy,
    )
