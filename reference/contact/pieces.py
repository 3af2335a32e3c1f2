"""Work on large fields in pieces, by as many threads as allowed.

Pieces have a fixed size, and sums over them are added in their order: results do not depend on the
number of threads, by default one. SciPy's transforms and the compiled loops release the
interpreter's lock.
"""

from collections import deque
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor, wait
from contextlib import contextmanager
from typing import Any, TypeVar

import numpy as np

Answer = TypeVar("Answer")

# Numbers in a piece: small beside a large field, large beside the cost of a call.
SIZE = 2**18


class _Threads:
    """The threads that share pieces: none but the caller's own unless asked for."""

    pool: ThreadPoolExecutor | None = None
    others = 0


@contextmanager
def threads(number: int) -> Iterator[None]:
    """Share the pieces of large fields among some threads.

    >>> with threads(2):
    ...     over(4, 2, lambda part: part)
    [slice(0, 2, None), slice(2, 4, None)]
    """
    if number < 1:
        raise ValueError(f"threads must be at least 1, not {number!r}")
    if number == 1:
        yield
        return
    before = _Threads.pool, _Threads.others
    with ThreadPoolExecutor(number - 1) as pool:
        _Threads.pool, _Threads.others = pool, number - 1
        try:
            yield
        finally:
            _Threads.pool, _Threads.others = before


def over(length: int, step: int, work: Callable[[slice], Answer]) -> list[Answer]:
    """Return what `work` makes of every piece of `step` items, in order."""
    parts = [slice(start, min(start + step, length)) for start in range(0, length, step)]
    if _Threads.pool is None or len(parts) == 1:
        return [work(part) for part in parts]
    answers: dict[int, Answer] = {}
    # each thread takes the next piece when it is done with one; the caller is one of them
    numbers = iter(range(len(parts)))

    def share() -> None:
        try:
            for number in numbers:
                answers[number] = work(parts[number])
        except BaseException:
            deque(numbers, maxlen=0)  # none is left for the other threads
            raise

    others = [_Threads.pool.submit(share) for _ in range(_Threads.others)]
    try:
        share()
    finally:
        wait(others)
    for other in others:
        other.result()
    return [answers[number] for number in range(len(parts))]


def rows_of(width: int) -> int:
    """Return how many rows of a field are a piece."""
    return max(1, SIZE // width)


def each_piece(work: Callable[..., Any], *arguments: Any) -> list[Any]:
    """Return what a compiled loop makes of every piece of the flat maps among its arguments."""
    size = arguments[0].size
    if size <= SIZE:
        return [work(*arguments)]

    def piece(part: slice) -> Any:
        return work(*(a[part] if isinstance(a, np.ndarray) else a for a in arguments))

    return over(size, SIZE, piece)


def sums(parts: list[Any]) -> Any:
    """Return the sums of the tuples that `each_piece` gives, one for every piece."""
    return parts[0] if len(parts) == 1 else tuple(map(sum, zip(*parts, strict=True)))
