"""Random and mutated input: every case ends in an answer or in one clear error.

``python tests/fuzzing/fuzz.py --cases 20000 --seed 1`` plans mutated scenes, claims, maps and
meshes, and writes reports of mutated results folders. A case is a fault if the command
raises, ends with another code than 0 or 2, takes more than SECONDS of processor time, or if the
process grows beyond BYTES.
Every case is made from its own number: a fault is repeated with ``--only KIND NUMBER``.
"""

import argparse
import contextlib
import io
import json
import os
import re
import shutil
import signal
import sys
import tempfile
import time
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from types import FrameType

import numpy as np
from scipy.io import savemat

from comparisons.questions.claims.families import HERE
from comparisons.scene.scene import Scene, builtin_folder
from comparisons.solving.execution import _peak
from roughline.commands.app import run_command

try:  # of the extra topography; without it their suffixes hold text
    import h5py
    import tifffile
except ImportError:
    h5py = tifffile = None

SECONDS, BYTES = 5, 1_000_000_000
SCENES = builtin_folder()
CLAIMS = sorted(HERE.glob("*.toml"))
Files = dict[str, bytes]

# Two spaces, or the end of a line, part one value from the next.
TOKENS = re.split(
    "  |\n",
    r"""
0  -0.0  -1  1  2  64  1e-320  1e-30  1e30  1e308  nan  inf  -inf  99999999999999999999  true
""  "x"  "1 m"  "5 kg"  "1e999 m"  "-3 um"  "nan mm"  []  {}  [[1]]  [1,[2]]  ["a"]  [1e-6,1e-6]
[3,2,1]  [nan]  0x10  1979-05-27  "../../../etc/passwd"  "/dev/zero"  "/dev/stdin"  "."
"a\\u0000b"  "<script>alert(1)</script>"  "self_affine"  "map"  "cone"  "profile"  "periodic"
"reduced"  "fem"  {values=[1]}  {from=1,to=2,steps=3}  {from=2,to=1,steps=3}
{from=1,to=2,steps=1000000000}  {from=1e-300,to=1e300,steps=5,spacing="log"}
""".strip(),
)
SCHEMA = Scene.model_json_schema()
TABLES = [SCHEMA, *SCHEMA["$defs"].values()]
KEYS = sorted({key for table in TABLES for key in table.get("properties", ())})


class HangError(Exception):
    """A case took longer than it may."""


@dataclass(frozen=True)
class Fault:
    """A case that did not end as it should."""

    kind: str
    number: int
    what: str


def mutated_bytes(data: bytes, rng: np.random.Generator) -> bytes:
    """Flip, drop, double, insert or cut bytes, a few times."""
    out = bytearray(data)
    for _ in range(int(rng.integers(1, 6))):
        at = int(rng.integers(0, len(out) + 1))
        far = min(len(out), at + int(rng.integers(1, 40)))
        act = int(rng.integers(0, 6))
        if act == 0 and at < len(out):
            out[at] ^= 1 << int(rng.integers(0, 8))
        elif act == 1:
            del out[at:far]
        elif act == 2:
            out[at:at] = out[at:far] * int(rng.integers(1, 20))
        elif act == 3:
            out[at:at] = rng.bytes(int(rng.integers(1, 20)))
        elif act == 4:
            del out[at:]
        else:
            other = int(rng.integers(0, len(out) + 1))
            out[at:far] = out[other : other + far - at]
    return bytes(out)


def mutated_lines(text: str, rng: np.random.Generator) -> str:
    """Replace values and keys, drop, double and swap lines."""
    lines = text.splitlines() or [""]
    for _ in range(int(rng.integers(1, 5))):
        at = int(rng.integers(0, len(lines)))
        act = int(rng.integers(0, 6))
        key, equals, _ = lines[at].partition("=")
        if act <= 2 and equals:
            lines[at] = f"{key}= {rng.choice(TOKENS)}"
        elif act == 3:
            lines.insert(at, f"{rng.choice(KEYS)} = {rng.choice(TOKENS)}")
        elif act == 4:
            lines.insert(at, lines[int(rng.integers(0, len(lines)))])
        elif len(lines) > 1:
            del lines[at]
        if rng.random() < 0.1:
            lines.insert(int(rng.integers(0, len(lines) + 1)), f"[{rng.choice(KEYS)}]")
    return "\n".join(lines)


def mutated_text(data: bytes, rng: np.random.Generator) -> bytes:
    """Mutate lines mostly, bytes sometimes; rarely throw everything away."""
    chance = rng.random()
    if chance < 0.03:
        return rng.bytes(int(rng.integers(0, 300)))
    if chance < 0.25:
        return mutated_bytes(data, rng)
    return mutated_lines(data.decode("utf-8"), rng).encode("utf-8", "surrogatepass")


def scene_case(rng: np.random.Generator) -> tuple[Files, list[str]]:
    """Plan a mutated scene."""
    source = rng.choice(sorted(SCENES.glob("*.toml")))
    files = {"measured-map.csv": (SCENES / "measured-map.csv").read_bytes()}
    files["scene.toml"] = mutated_text(Path(source).read_bytes(), rng)
    return files, ["run", "scene.toml", "--plan"]


def claim_case(rng: np.random.Generator) -> tuple[Files, list[str]]:
    """Read a mutated claim; the method that it judges does not exist, so nothing is solved."""
    source = rng.choice(CLAIMS)
    text = mutated_text(Path(source).read_bytes(), rng)
    return {"claim.toml": text}, ["claims", "claim.toml", "--method", "none", "--out", "out"]


MAP_SCENE = """name = "map"
[half_space]
effective_modulus = "1 GPa"
[surface]
kind = "map"
file = "{file}"
{more}
[loading]
force = {{ from = 1e-3, to = 1e-2, steps = 2, relative_to = "E* A0 h'" }}
"""
SIZE = 'size = "1 um"\nheight_unit = "nm"'
UNITS = 'lateral_unit = "um"\nheight_unit = "nm"'
MAP_SUFFIXES = (
    *("npy", "csv", "txt", "xyz", "sdf", "asc", "x3p", "gwy", "di", "nc"),
    *("tif", "zip", "h5", "mat"),
)


def stored_heights(heights: np.ndarray, suffix: str, rng: np.random.Generator) -> bytes:
    """Return a map in the format that a suffix names, or as text."""
    stream = io.BytesIO()
    if suffix == "npy":
        odd = rng.random()
        given = heights.astype("complex" if odd < 0.1 else ("U5" if odd < 0.2 else "float64"))
        np.save(stream, given)
    elif suffix == "xyz":
        place = np.indices(heights.shape).reshape(2, -1)
        np.savetxt(stream, np.vstack([place, heights.ravel()]).T)
    elif suffix == "tif" and tifffile is not None:
        compression = "zlib" if rng.random() < 0.5 else None
        tifffile.imwrite(stream, heights.astype(np.float32), compression=compression)
    elif suffix == "zip":
        np.savez_compressed(stream, heights=heights)
    elif suffix == "h5" and h5py is not None:
        with h5py.File(stream, "w") as file:
            file.create_dataset("heights", data=heights, compression="gzip")
    elif suffix == "mat":
        savemat(stream, {"heights": heights}, do_compression=True)
    else:
        np.savetxt(stream, heights, delimiter="," if suffix == "csv" else " ")
    return stream.getvalue()


def map_case(rng: np.random.Generator) -> tuple[Files, list[str]]:
    """Plan a scene whose map is damaged: npy, csv, xyz and formats of instruments by name."""
    heights = rng.standard_normal((int(rng.integers(1, 24)), int(rng.integers(1, 24))))
    suffix = str(rng.choice(MAP_SUFFIXES))
    data = stored_heights(heights, suffix, rng)
    if rng.random() < 0.9:
        data = mutated_bytes(data, rng)
    if rng.random() < 0.05:
        data = b""
    more = UNITS if suffix == "xyz" else SIZE
    scene = MAP_SCENE.format(file=f"map.{suffix}", more=more).encode()
    if rng.random() < 0.3:
        scene = mutated_text(scene, rng)
    return {f"map.{suffix}": data, "scene.toml": scene}, ["run", "scene.toml", "--plan"]


def results_case(rng: np.random.Generator, study: Files) -> tuple[Files, list[str]]:
    """Write the report of a damaged results folder."""
    files = dict(study)
    for _ in range(int(rng.integers(1, 3))):
        name = str(rng.choice(sorted(files)))
        if name.endswith("json") and rng.random() < 0.5:
            files[name] = _mutated_json(files[name], rng)
        else:
            files[name] = mutated_bytes(files[name], rng)
        if rng.random() < 0.05:
            del files[name]
            break
    return {f"run/{k}": v for k, v in files.items()}, ["report", "run", "--no-pictures"]


def _mutated_json(data: bytes, rng: np.random.Generator) -> bytes:
    """Replace one value somewhere in a document by something of another kind."""
    try:
        document = json.loads(data)
    except ValueError:
        return data
    values = [None, 0, -1, 1e308, "x", "../../x", "<script>", [], {}, [None], {"a": 1}, True]
    here = document
    while isinstance(here, dict | list) and len(here):
        keys = list(here) if isinstance(here, dict) else list(range(len(here)))
        key = keys[int(rng.integers(0, len(keys)))]
        if not isinstance(here[key], dict | list) or not here[key] or rng.random() < 0.2:
            here[key] = values[int(rng.integers(0, len(values)))]
            break
        here = here[key]
    return json.dumps(document).encode()


def small_study() -> Files:
    """Solve one scene cheaply and return its results folder."""
    with tempfile.TemporaryDirectory(prefix="roughline-") as name:
        out = Path(name) / "run"
        arguments = ["run", "paraboloid", "--methods", "closed_form,reduced", "--no-pictures"]
        with contextlib.redirect_stdout(io.StringIO()):
            run_command([*arguments, "--out", str(out)])
        kept = [path for path in out.rglob("*") if path.suffix in (".json", ".csv", ".npz")]
        return {path.relative_to(out).as_posix(): path.read_bytes() for path in kept}


def run_case(files: Files, arguments: list[str]) -> str:
    """Run one case in a folder of its own; return what is wrong, "" if nothing."""
    home = Path.cwd()
    with tempfile.TemporaryDirectory(prefix="roughline-fuzz-") as name:
        folder = Path(name) / "work"
        for path, data in files.items():
            (folder / path).parent.mkdir(parents=True, exist_ok=True)
            (folder / path).write_bytes(data)
        os.chdir(folder)
        try:
            wrong = _command(arguments)
        finally:
            os.chdir(home)
        outside = [item.name for item in Path(name).iterdir() if item != folder]
    return wrong or (f"wrote outside its folder: {outside}" if outside else "")


def _command(arguments: list[str]) -> str:
    told, complained = io.StringIO(), io.StringIO()
    # Processor time, so that a busy machine is no fault; and a limit for what sleeps or waits.
    signal.setitimer(signal.ITIMER_PROF, SECONDS)
    signal.setitimer(signal.ITIMER_REAL, 20 * SECONDS)
    try:
        with contextlib.redirect_stdout(told), contextlib.redirect_stderr(complained):
            code = run_command(arguments)
    except HangError:
        return f"more than {SECONDS} s"
    except BaseException as error:
        return f"{type(error).__name__}: {error}"[:300]
    finally:
        signal.setitimer(signal.ITIMER_PROF, 0)
        signal.setitimer(signal.ITIMER_REAL, 0)
    if code not in (0, 2):
        return f"exit code {code}: {complained.getvalue()[:200]}"
    if code == 2 and not complained.getvalue().strip():
        return "exit code 2 without a word"
    return "Traceback in the message" if "Traceback" in complained.getvalue() else ""


def _hang(number: int, frame: FrameType | None) -> None:
    raise HangError


def kinds() -> dict[str, tuple[float, Callable[[np.random.Generator], tuple[Files, list[str]]]]]:
    """Return the kinds of cases with their shares."""
    study = small_study()
    return {
        "scene": (0.5, scene_case),
        "map": (0.25, map_case),
        "claim": (0.1, claim_case),
        "results": (0.15, lambda rng: results_case(rng, study)),
    }


def fuzz(cases: int, seed: int = 0, only: tuple[str, int] | None = None) -> list[Fault]:
    """Run the cases; print the counts; return the faults."""
    for alarm in (signal.SIGALRM, signal.SIGPROF):
        signal.signal(alarm, _hang)
    faults: list[Fault] = []
    counts: Counter[str] = Counter()
    slowest = peak = 0.0
    for kind, (share, make) in kinds().items():
        for number in range(max(int(share * cases), 1)):
            if only is not None and only != (kind, number):
                continue
            files, arguments = make(np.random.default_rng([seed, number, *kind.encode()]))
            start = time.process_time()
            wrong = run_case(files, arguments)
            slowest = max(slowest, time.process_time() - start)
            counts[kind] += 1
            if not wrong and (grown := _peak()) > max(peak, BYTES):
                wrong = f"the process grew to {grown / 1e9:.2f} GB"
            peak = _peak()
            if wrong:
                faults.append(Fault(kind, number, wrong))
                print(f"{kind} {number}: {wrong}", file=sys.stderr, flush=True)
                if only is not None:
                    _keep(files, Path("fuzz-case"))
    print(f"{sum(counts.values())} cases {dict(counts)}, {len(faults)} faults, seed {seed}")
    print(f"slowest {slowest:.2f} s of processor time, peak memory {peak / 1e9:.2f} GB")
    return faults


def _keep(files: Files, folder: Path) -> None:
    shutil.rmtree(folder, ignore_errors=True)
    for path, data in files.items():
        (folder / path).parent.mkdir(parents=True, exist_ok=True)
        (folder / path).write_bytes(data)
    print(f"the files are in {folder}", file=sys.stderr)


def main() -> int:
    """Read the arguments and run."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--cases", type=int, default=20_000)
    parser.add_argument("--seed", type=int, default=0)
    parser.add_argument("--only", nargs=2, metavar=("KIND", "NUMBER"))
    given = parser.parse_args()
    only = (given.only[0], int(given.only[1])) if given.only else None
    return 1 if fuzz(given.cases, given.seed, only) else 0


if __name__ == "__main__":
    sys.exit(main())
