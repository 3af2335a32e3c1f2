"""Memory of springs with dry friction at a constant normal load: the branches of a loading path.

Every spring sticks until its friction is used up and keeps what it had: a stop operator with the
threshold w(x) = d - g(x). A row of them is a Prandtl-Ishlinskii model, known whole by its first
loading curve phi: after a reversal every spring needs twice its threshold, so that the force
departs from the turning point by 2 phi(half the way) (Masing 1926); a loop that closes is
forgotten, and the curve it interrupted goes on (Madelung's rules; Visintin, *Differential Models of
Hysteresis*, 1994, sec. III). The same holds with force and displacement exchanged: phi rises.

In the units of this module displacement is w = G* u/(mu E*) and force T = F_x/(mu E*), so that
phi(w) = N(d) - N(d - w) with N = F/E* the normal law of the same springs (Jaeger 1995; Ciavarella
1998; Popov & Hess 2015, sec. 5.3): exact for the discrete springs, edges inside cells included.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass(frozen=True)
class Branches:
    """A path cut into stretches that each follow one branch; arrays over the m nodes.

    Attributes
    ----------
    value : ndarray, shape (m,)
        The path with the points inserted at which loops close.
    start : ndarray of int, shape (m,)
        Node at which the branch that leads to this node began; -1 for the first loading.
    given : ndarray of int, shape (k,)
        Nodes of the points of the path itself.
    """

    value: np.ndarray
    start: np.ndarray
    points: np.ndarray

    @property
    def factor(self) -> np.ndarray:
        """1 on the first loading, 2 (Masing) on every other branch."""
        return np.where(self.start < 0, 1.0, 2.0)

    @property
    def reach(self) -> np.ndarray:
        """Signed way from the start of each branch to its node, over the branch's factor."""
        return self._way(self.value)

    @property
    def reach_before(self) -> np.ndarray:
        """The same for the node before, which lies on the branch, too."""
        return self._way(np.concatenate([[0.0], self.value[:-1]]))

    def _way(self, value: np.ndarray) -> np.ndarray:
        origin = np.append(self.value, 0.0)[self.start]
        return (value - origin) / self.factor


def branches(path: np.ndarray) -> Branches:
    """Follow a path of force or displacement from zero and find the branch of each point.

    Parameters
    ----------
    path : ndarray, shape (k,)
        Values at the end of each monotone stretch (or at any points on the way).

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
    turns: list[int] = []  # nodes where the open loops began, oldest first

    def at(node: int) -> float:
        return value[node] if node >= 0 else 0.0

    for goal in path:
        last = at(len(value) - 1)
        origin = at(turns[-1]) if turns else 0.0
        if np.sign(goal - last) * np.sign(last - origin) < 0:  # products of values may underflow
            turns.append(len(value) - 1)
        while turns:
            # the first loop closes where the first loading of the other sign takes over
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
    """Answer at every node: where its branch began plus factor times what the branch gained.

    Parameters
    ----------
    branch : Branches
    gain : ndarray, shape (m,)
        Signed first-loading answer to `branch.reach`.
    """
    answer = np.zeros(branch.value.size + 1)
    for node, (start, step) in enumerate(zip(branch.start, branch.factor * gain, strict=True)):
        answer[node] = answer[start] + step
    return answer[:-1]
