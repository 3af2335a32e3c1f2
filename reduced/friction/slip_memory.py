"""Memory of springs with dry friction at constant normal load: the branches of a loading path.

Every spring sticks up to its friction limit and then keeps this force: a stop operator with the
threshold w(x) = d - g(x). A row of springs is a Prandtl-Ishlinskii model, determined by its first
loading curve phi: after a reversal every spring needs twice its threshold, so the force changes
from the turning point by 2 phi(half the displacement) (Masing 1926); a closed loop is forgotten,
and the interrupted curve continues (Madelung's rules; Visintin, *Differential Models of
Hysteresis*, 1994, sec. III). The same holds with force and displacement exchanged, because phi
increases.

In the units of this module displacement is w = G* u/(mu E*) and force T = F_x/(mu E*), so that
phi(w) = N(d) - N(d - w) with N = F/E* the normal law of the same springs (Jaeger 1995; Ciavarella
1998; Popov & Hess 2015, sec. 5.3): exact for the discrete springs, edges inside cells included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Branches:
    """A path divided into parts that follow one branch; arrays over the m nodes.

    Attributes
    ----------
    value : ndarray, shape (m,)
        The path with inserted points at which loops close.
    start : ndarray of int, shape (m,)
        First node of the branch that leads to this node; -1 for the first loading.
    given : ndarray of int, shape (k,)
        Nodes of the original points of the path.
    """

    value: np.ndarray
    start: np.ndarray
    points: np.ndarray

    @property
    def factor(self) -> np.ndarray:
        """1 for the first loading, 2 (Masing) for all other branches."""
        return np.where(self.start < 0, 1.0, 2.0)

    @property
    def reach(self) -> np.ndarray:
        """Signed distance from the start of the branch to the node, over the branch's factor."""
        return self._way(self.value)

    @property
    def reach_before(self) -> np.ndarray:
        """The same for the preceding node, which is on the same branch."""
        return self._way(np.concatenate([[0.0], self.value[:-1]]))

    def _way(self, value: np.ndarray) -> np.ndarray:
        origin = np.append(self.value, 0.0)[self.start]
        return (value - origin) / self.factor


def branches(path: np.ndarray) -> Branches:
    """Return the branches of a path of force or displacement from zero.

    Parameters
    ----------
    path : ndarray, shape (k,)
        Values at the turning points (or at any points in between).

    Examples
    --------
    A loop inside the first loading closes at 2 and is forgotten:

    >>> loop = branches(np.array([2.0, 1.0, 3.0]))
    >>> loop.value, loop.start
    (array([2., 1., 2., 3.]), array([-1, 0, 1, -1]))
    """
    value: list[float] = []
    start: list[int] = []
    points: list[int] = []
    turns: list[int] = []  # first nodes of the open loops, oldest first

    def at(node: int) -> float:
        return value[node] if node >= 0 else 0.0

    for goal in path:
        last = at(len(value) - 1)
        origin = at(turns[-1]) if turns else 0.0
        if np.sign(goal - last) * np.sign(last - origin) < 0:  # products of values may underflow
            turns.append(len(value) - 1)
        while turns:
            # the first loop closes where the first loading of the other sign continues
            close = at(turns[-2]) if len(turns) > 1 else -at(turns[0])
            if abs(goal - at(turns[-1])) <= abs(close - at(turns[-1])):
                break
            value.append(close)
            start.append(turns[-1])
            del turns[-2:]
        value.append(float(goal))
        start.append(turns[-1] if turns else -1)
        points.append(len(value) - 1)
    return Branches(np.array(value), np.array(start), np.array(points))


def accumulate(branch: Branches, gain: np.ndarray) -> np.ndarray:
    """Return the response at every node: that at the start of its branch plus factor times gain.

    Parameters
    ----------
    gain : ndarray, shape (m,)
        Signed first-loading response to `branch.reach`.
    """
    answer = np.zeros(branch.value.size + 1)
    for node, (start, step) in enumerate(zip(branch.start, branch.factor * gain, strict=True)):
        answer[node] = answer[start] + step
    return answer[:-1]
