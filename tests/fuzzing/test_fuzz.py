"""Damaged input: whatever a file holds, a command ends in an answer or in one clear error.

Lines and bytes of scenes, maps, claims and results are changed, a few at a time.
"""

import contextlib
import io
import os
import signal
import tempfile
import time
from functools import cache
from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, given, settings
from hypothesis import strategies as st
from scipy.io import savemat

from comparisons.questions.claims.families import HERE
from comparisons.scene.scene import Scene, builtin_folder
from comparisons.solving.execution import peak_memory
from roughline.commands.app import run_command

try:  # of the extra topography; without it their suffixes hold text
    import h5py
    import tifffile
except ImportError:
    h5py = tifffile = None

SECONDS, BYTES = 5, 1_000_000_000
SCHEMA = Scene.model_json_schema()
KEYS = sorted(
    {key for table in (SCHEMA, *SCHEMA["$defs"].values()) for key in table.get("properties", ())}
)
# Two spaces, or the end of a line, part one value from the next.
VALUES = (
    r"""
0  -0.0  -1  1  2  64  1e-320  1e-30  1e30  1e308  nan  inf  -inf  99999999999999999999  true
""  "x"  "1 m"  "5 kg"  "1e999 m"  "-3 um"  "nan mm"  []  {}  [[1]]  [1,[2]]  ["a"]  [1e-6,1e-6]
[3,2,1]  [nan]  0x10  1979-05-27  "../../../etc/passwd"  "/dev/zero"  "/dev/stdin"  "."  null
"a\\u0000b"  "<script>alert(1)</script>"  "self_affine"  "map"  "cone"  "profile"  "periodic"
"reduced"  "fem"  {values=[1]}  {from=1,to=2,steps=3}  {from=2,to=1,steps=3}  {"a": 1}
{from=1,to=2,steps=1000000000}  {from=1e-300,to=1e300,steps=5,spacing="log"}
""".strip()
    .replace("\n", "  ")
    .split("  ")
)

place = st.integers(0, 10_000)
value, key = st.sampled_from(VALUES), st.sampled_from(KEYS)
LINES = st.lists(
    st.one_of(
        *3 * [st.tuples(st.just("value"), place, value)],
        st.tuples(st.just("insert"), place, st.builds("{} = {}".format, key, value)),
        st.tuples(st.just("insert"), place, st.builds("[{}]".format, key)),
        st.tuples(st.sampled_from(["double", "drop"]), place, st.just("")),
    ),
    max_size=5,
)
BYTES_CHANGED = st.lists(
    st.tuples(place, st.integers(0, 40), st.binary(max_size=20), st.integers(0, 20)), max_size=3
)


def damaged(data, lines, pieces):
    """Return a text with other lines, and with other bytes at some places."""
    if lines:
        text = data.decode("utf-8").splitlines() or [""]
        for act, at, new in lines:
            at %= len(text) or 1
            here = text[at] if text else ""
            mark = next((mark for mark in ("=", ":") if mark in here), "")
            if act == "value" and mark:
                end = "," * here.endswith(",")
                text[at] = f"{here.partition(mark)[0]}{mark} {new}{end}"
            elif act == "drop":
                del text[at : at + 1]
            else:
                text.insert(at, new or here)
        data = "\n".join(text).encode()
    for at, far, new, times in pieces:
        at %= len(data) + 1
        data = data[:at] + new + data[at : at + far] * times + data[at + far :]
    return data


MAP_SCENE = """name = "map"
[half_space]
effective_modulus = "1 GPa"
[surface]
kind = "map"
file = "map.{}"
{}
[loading]
force = {{ from = 1e-3, to = 1e-2, steps = 2, relative_to = "E* A0 h'" }}
"""


def maps():
    """Return a map in formats of its own, and as text under suffixes of instruments."""
    heights = np.random.default_rng(0).standard_normal((9, 7))
    listed = np.vstack([np.indices(heights.shape).reshape(2, -1), heights.ravel()]).T
    stored = {"npy": np.save, "zip": np.savez_compressed, "xyz": lambda s, _: np.savetxt(s, listed)}
    stored["mat"] = lambda s, h: savemat(s, {"heights": h}, do_compression=True)
    if h5py is not None:
        stored["tif"] = lambda s, h: tifffile.imwrite(s, h.astype("f4"), compression="zlib")

        def hdf5(stream, heights):
            with h5py.File(stream, "w") as file:
                file.create_dataset("heights", data=heights, compression="gzip")

        stored["h5"] = hdf5
    for suffix in [
        "npy",
        "csv",
        "xyz",
        "zip",
        "tif",
        "h5",
        "mat",
        "sdf",
        "asc",
        "x3p",
        "gwy",
        "nc",
    ]:
        stored.get(suffix, np.savetxt)(stream := io.BytesIO(), heights)
        size = "lateral_unit" if suffix == "xyz" else "size"
        text = MAP_SCENE.format(suffix, f'{size} = "1 um"\nheight_unit = "nm"')
        yield {f"map.{suffix}": stream.getvalue(), "scene.toml": text.encode()}


@cache
def sound():
    """Return folders of each kind, and the command that reads them."""
    with tempfile.TemporaryDirectory() as name, contextlib.redirect_stdout(io.StringIO()):
        asked = ["--methods", "closed_form,reduced", "--no-pictures"]
        run_command(["run", "paraboloid", *asked, "--out", f"{name}/run"])
        files = [
            path for path in Path(name).rglob("*.*") if path.suffix in (".json", ".csv", ".npz")
        ]
        study = {path.relative_to(name).as_posix(): path.read_bytes() for path in files}
    scenes = builtin_folder()
    beside = {"measured-map.csv": (scenes / "measured-map.csv").read_bytes()}
    plan = ["run", "scene.toml", "--plan"]
    return {
        "scene": (
            [{"scene.toml": path.read_bytes()} | beside for path in sorted(scenes.glob("*.toml"))],
            plan,
        ),
        "map": ([*maps()], plan),
        # Of a method that does not exist, so that nothing is solved.
        "claim": (
            [{"claim.toml": path.read_bytes()} for path in sorted(HERE.glob("*.toml"))],
            ["claims", "claim.toml", "--method", "none", "--out", "out"],
        ),
        "results": ([study], ["report", "run", "--no-pictures"]),
    }


@pytest.mark.slow
@pytest.mark.parametrize("kind", ["scene", "map", "claim", "results"])
@settings(
    max_examples=2 * settings.default.max_examples,
    deadline=None,
    suppress_health_check=[HealthCheck.too_slow, HealthCheck.data_too_large],
)
@given(which=place, file=place, lines=LINES, pieces=BYTES_CHANGED)
def test_damaged_input_ends_in_an_answer_or_one_clear_error(kind, which, file, lines, pieces):
    """Exit code 0 or 2, no traceback, nothing written astray, in little time and memory."""
    folders, command = sound()[kind]
    files = dict(folders[which % len(folders)])
    name = sorted(files)[file % len(files)]
    textual = name.endswith(("toml", "json", "csv"))
    files[name] = damaged(files[name], lines if textual else [], pieces)
    home, peak, before = Path.cwd(), peak_memory(), time.process_time()
    told, complained = io.StringIO(), io.StringIO()
    # What hangs is interrupted, which is code 3.
    signal.signal(signal.SIGALRM, signal.default_int_handler)
    with tempfile.TemporaryDirectory(prefix="roughline-fuzz-") as outside:
        for path, data in files.items():
            target = Path(outside) / "work" / path
            target.parent.mkdir(parents=True, exist_ok=True)
            target.write_bytes(data)
        os.chdir(Path(outside) / "work")
        signal.alarm(20 * SECONDS)
        try:
            with contextlib.redirect_stdout(told), contextlib.redirect_stderr(complained):
                code = run_command(command)
        finally:
            signal.alarm(0)
            os.chdir(home)
        assert os.listdir(outside) == ["work"]
    said = complained.getvalue()
    assert code in (0, 2), said
    assert code == 0 or said.strip()
    assert "Traceback" not in said
    assert time.process_time() - before < SECONDS
    assert peak_memory() <= max(peak, BYTES)
