"""The folder of an ensemble: Parquet files of all curves, their statistics and a record.

::

    ensemble.json          scene, loads, what is solved and what is missing, digests of the curves
    statistics.csv         a row per method, resolution, load step and quantity
    surfaces/KEY.parquet   the curves of a bundle of surfaces

Files are read one after the other, a few megabytes at a time: memory does not grow with the number
of surfaces. A bundle is a range of consecutively numbered surfaces, solved as one job. The metadata
of its file state what it holds, so that a folder of a million surfaces is surveyed without reading
a column. pyarrow (optional extra ``parquet``) writes and reads them.
"""

from __future__ import annotations

import hashlib
import json
from collections.abc import Iterable, Iterator
from dataclasses import asdict, dataclass, field, replace
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import pandas as pd

from comparisons.errors import InputError, ResultsError
from comparisons.files import write_atomically
from comparisons.results.folder import Form, PartHeader, read_record
from comparisons.tasks.solution import Solution

RECORD, TABLE, SURFACES = "ensemble.json", "statistics.csv", "surfaces"
# Surfaces summed at once: the same number whatever the bundles, so that sums round alike.
_BLOCK = 1000


class SettingRecord(Form):
    """A method at a resolution."""

    method: str
    resolution: int
    identity: str  # key of its first surface: setting, options, code and packages
    # How many surfaces are solved, in how many bundles; load steps of them without an answer.
    surfaces: int
    bundles: int
    lost: int
    # Wall and processor time of their solves.
    seconds: float
    processor_seconds: float
    digest: str  # SHA-256 of all curves in the order of the surfaces, whatever the bundles


class EnsembleRecord(PartHeader):
    """An ensemble: scene, loads, what is solved and what is missing."""

    # The scene, as TOML in SI units.
    name: str
    text: str
    control: str  # the prescribed quantity
    loads: list[float]
    surfaces: int  # number of the whole ensemble
    missing: list[str]  # setting and range of the surfaces that are not solved
    settings: list[SettingRecord]


class EnsembleResult(NamedTuple):
    """The record and the statistics of its curves."""

    record: EnsembleRecord
    statistics: pd.DataFrame


def survey(folder: Path) -> dict[str, Files]:
    """Return the files of a folder by the identity of their setting.

    Incomplete files are skipped, and those with a surface that an earlier one has: what else they
    have counts as not solved.
    """
    files: Files = {}
    for path in folder.glob(f"[!.]*{SUFFIX}"):
        try:
            bundle = read_bundle(path)
        except ResultsError:
            continue
        # A bundle without any answer is solved again.
        if bundle.count and bundle.lost < bundle.answers:
            files[path] = bundle
    settings: dict[str, Files] = {}
    for path, bundle in sorted(files.items(), key=lambda item: item[1].first):
        own = settings.setdefault(bundle.identity, {})
        if not own or next(reversed(own.values())).end <= bundle.first:
            own[path] = bundle
    return settings


def gaps(surfaces: range, bundles: Iterable[Bundle]) -> list[range]:
    """Return the stretches of surfaces that no bundle has; bundles come in order.

    >>> gaps(range(100), [Bundle("bem_fft", 64, "", first=20, count=30)])
    [range(0, 20), range(50, 100)]
    """
    stretches, start = [], surfaces.start
    for bundle in bundles:
        stretches.append(range(start, min(bundle.first, surfaces.stop)))
        start = max(start, bundle.end)
    stretches.append(range(start, surfaces.stop))
    return [stretch for stretch in stretches if len(stretch)]


def summary(files: Files, control: str, loads: list[float]) -> tuple[SettingRecord, pd.DataFrame]:
    """Return the record and the statistics of a setting, in one pass over its curves."""
    bundles = list(files.values())
    digest, names = hashlib.sha256(), [""]

    def blocks() -> Iterator[np.ndarray]:
        nonlocal names
        for own, values in curves(files, len(loads), _BLOCK):
            names = own
            digest.update(values.tobytes())
            yield values

    found = moments(blocks())
    first = bundles[0]
    record = SettingRecord(
        method=first.method,
        resolution=first.resolution,
        identity=first.identity,
        surfaces=sum(bundle.count for bundle in bundles),
        bundles=len(bundles),
        lost=sum(bundle.lost for bundle in bundles),
        seconds=sum(bundle.seconds for bundle in bundles),
        processor_seconds=sum(bundle.processor_seconds for bundle in bundles),
        digest=digest.hexdigest(),
    )
    index = pd.MultiIndex.from_product([range(len(loads)), names], names=["step", "quantity"])
    table = pd.DataFrame({name: values.ravel() for name, values in found.items()}, index)
    table = table[table["count"] > 0].reset_index()
    table.insert(1, control, np.asarray(loads)[table["step"]])
    table.insert(0, "resolution", first.resolution)
    table.insert(0, "method", first.method)
    return record, table


def load_ensemble(directory: Path) -> EnsembleRecord:
    """Read ensemble.json; ResultsError where it is none."""
    missing = f"{directory}: no ensemble here ({RECORD} is missing)"
    return read_record(EnsembleRecord, directory / RECORD, missing)


def moments(blocks: Iterable[np.ndarray]) -> dict[str, np.ndarray]:
    """Return number, mean, scatter and extremes over the first axis of all blocks, per entry.

    Blocks are joined by the formula of Chan, Golub & LeVeque (1979): with n, m, S the number, mean
    and sum of squared deviations of each, d the difference of the means,

    S = S_1 + S_2 + d² n_1 n_2/(n_1 + n_2),   m = m_1 + d n_2/(n_1 + n_2).

    NaN is not counted.

    >>> import numpy as np
    >>> found = moments([np.array([[1.0], [3.0]]), np.array([[5.0], [np.nan]])])
    >>> [found[name].tolist() for name in ("count", "mean", "standard_deviation")]
    [[3], [3.0], [2.0]]
    """
    count, mean, squares = np.zeros(1, int), np.zeros(1), np.zeros(1)
    low, high = np.full(1, np.inf), np.full(1, -np.inf)
    for values in blocks:
        known = np.isfinite(values)
        number = known.sum(axis=0)
        own = np.where(known, values, 0.0).sum(axis=0) / np.maximum(number, 1)
        deviations, change = np.where(known, values - own, 0.0), own - mean
        share = number / np.maximum(count + number, 1)
        squares = squares + (deviations**2).sum(axis=0) + change**2 * count * share
        count, mean = count + number, mean + change * share
        low = np.minimum(low, np.where(known, values, np.inf).min(axis=0))
        high = np.maximum(high, np.where(known, values, -np.inf).max(axis=0))
    deviation = np.sqrt(squares / np.maximum(count - 1, 1))  # of one surface; 0 of a single one
    return {
        "count": count,
        "mean": mean,
        "standard_error": deviation / np.sqrt(np.maximum(count, 1)),
        "standard_deviation": deviation,
        "minimum": low,
        "maximum": high,
    }


SUFFIX = ".parquet"
MISSING = "ensembles need pyarrow: python -m pip install 'roughline[parquet]'"
# Columns that are not quantities of the contact.
INDEX = ("surface", "step", "converged", "iterations", "violation", "reason")
_KEY = b"roughline"
# Rows that are written and read at a time: 2 MB of all columns.
_ROWS = 15_000


@dataclass(frozen=True)
class Bundle:
    """Surfaces ``first`` to ``first + count - 1`` of one method at one resolution."""

    method: str
    resolution: int
    identity: str  # the same exactly when setting, loads, options, code and packages are the same
    first: int
    count: int
    # Number of load steps of all surfaces, and of those without an answer.
    answers: int = 0
    lost: int = 0
    # Wall and processor time of the solves; without compilation, which is apart.
    seconds: float = 0.0
    processor_seconds: float = 0.0
    compile_seconds: float = 0.0
    machine: str = ""
    # The curves, until they are written.
    solution: Solution | None = field(default=None, repr=False, compare=False)

    @property
    def end(self) -> int:
        """The number after its last surface."""
        return self.first + self.count


# Bundles of one setting: files and what they hold, in the order of their surfaces.
Files = dict[Path, Bundle]


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

    The blocks have `size` surfaces, the last one the rest: sums over blocks round alike.
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
