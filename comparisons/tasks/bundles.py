"""Many surfaces of one method as a Parquet file: a row for each surface and load step.

A bundle is a range of consecutively numbered surfaces, solved as one job. The metadata of its file
state what it holds, so that a folder of a million surfaces is surveyed without reading a column.
pyarrow (optional extra ``parquet``) writes and reads them.
"""

from __future__ import annotations

import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.errors import InputError, ResultsError
from comparisons.files import write_atomically
from comparisons.tasks.solution import Solution

SUFFIX = ".parquet"
MISSING = "ensembles need pyarrow: python -m pip install 'roughline[parquet]'"
# Columns that are not quantities of the contact.
INDEX = ("surface", "step", "converged", "iterations", "violation", "reason")
_KEY = b"roughline"
# Rows that are written and read at a time: 2 MB of all columns.
_ROWS = 15_000


@dataclass(frozen=True)
class Bundle:
    """Surfaces ``first`` to ``first + count - 1`` of one method at one resolution.

    Attributes
    ----------
    identity : str
        The same exactly when scene, loads, options, code and packages are the same.
    answers, lost : int
        Number of load steps of all surfaces, and of those without an answer.
    seconds, processor_seconds : float
        Wall and processor time of the solves; without compilation, which is apart.
    solution : Solution or None
        The curves, until they are written.
    """

    method: str
    resolution: int
    identity: str
    first: int
    count: int
    answers: int = 0
    lost: int = 0
    seconds: float = 0.0
    processor_seconds: float = 0.0
    compile_seconds: float = 0.0
    machine: str = ""
    solution: Solution | None = field(default=None, repr=False, compare=False)

    @property
    def end(self) -> int:
        """The number after its last surface."""
        return self.first + self.count


def without_curves(bundle: Bundle) -> Bundle:
    """Return the bundle as it stays in memory once its curves are in a file."""
    return replace(bundle, solution=None)


def parquet() -> tuple[Any, Any]:
    """Return pyarrow and its Parquet module; InputError where it is not installed."""
    try:
        import pyarrow
        import pyarrow.parquet as files
    except ImportError as error:
        raise InputError(MISSING) from error
    return pyarrow, files


def write_bundle(path: Path, bundle: Bundle) -> None:
    """Write the curves of a bundle atomically."""
    pyarrow, files = parquet()
    assert bundle.solution is not None
    solution = bundle.solution
    count, steps = solution.converged.shape
    reasons = np.full((count, steps), None, dtype=object)
    for index, text in solution.reasons.items():
        reasons[index] = text
    numbers = np.arange(bundle.first, bundle.end, dtype=np.int32)
    columns = {
        "surface": np.repeat(numbers, steps),
        "step": np.tile(np.arange(steps, dtype=np.int16), count),
        "converged": solution.converged.ravel(),
        "iterations": solution.iterations.astype(np.int32).ravel(),
        "violation": solution.violation.ravel(),
        "reason": pyarrow.array(reasons.ravel(), pyarrow.string()),
        **{name: values.ravel() for name, values in solution.quantities.items()},
    }
    head = asdict(without_curves(bundle))
    table = pyarrow.table(columns).replace_schema_metadata({_KEY: json.dumps(head)})
    # Values of curves hardly ever repeat: a dictionary of them would only cost time.
    write_atomically(
        path,
        lambda stream: files.write_table(
            table,
            stream,
            row_group_size=_ROWS,
            compression="zstd",
            use_dictionary=["surface", "step", "reason"],
        ),
    )


def read_bundle(path: Path) -> Bundle:
    """Return what a file holds, without its curves; ResultsError where it is none of ours."""
    _, files = parquet()
    try:
        head = files.read_metadata(path).metadata[_KEY]
        return Bundle(**json.loads(head))
    except (OSError, ValueError, TypeError, KeyError) as error:
        raise ResultsError(f"{path}: not a file of an ensemble ({error})") from error


def curves(paths: Iterable[Path], steps: int, size: int) -> Iterator[tuple[list[str], np.ndarray]]:
    """Yield names of quantities and their values (surfaces, steps, quantities), file after file.

    The blocks have `size` surfaces, the last one the rest, whatever the bundles are: sums over
    blocks round alike. NaN where there is no answer.
    """
    rest: list[np.ndarray] = []
    names: list[str] = []
    _, files = parquet()
    rows = max(1, _ROWS // steps) * steps  # of a file, whole surfaces at a time
    for path in paths:
        try:
            with files.ParquetFile(path) as file:
                names = sorted(set(file.schema_arrow.names) - set(INDEX))
                for batch in file.iter_batches(batch_size=rows, columns=names):
                    columns = [batch.column(name).to_numpy(zero_copy_only=False) for name in names]
                    rest.append(np.stack(columns, axis=-1).reshape(-1, steps, len(names)))
                    joined = np.concatenate(rest)
                    whole = len(joined) // size * size
                    for start in range(0, whole, size):
                        yield names, joined[start : start + size]
                    rest = [joined[whole:]]
        except (OSError, ValueError) as error:
            raise ResultsError(f"{path}: damaged results ({error})") from error
    if rest and len(rest[0]):
        yield names, rest[0]
