"""Files that unpack to more than they may, crash or stall their reader end in words."""

import os
import time
import zipfile
import zlib

import meshio
import numpy as np
import pytest

from comparisons import machine
from comparisons.geometry import reading
from comparisons.geometry.body_files import read_body
from comparisons.geometry.faces import read_map
from comparisons.geometry.reading import FileError, read_apart
from comparisons.scene.surface import MeasuredMap

LIMIT = 6e8  # bytes in these tests, so that bombs are small
BOMB = bytes(800_000_000)  # zeros: packed two-hundredfold in a moment
POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])


@pytest.fixture(autouse=True)
def _small_limit(monkeypatch):
    monkeypatch.setattr(reading, "MOST_MEMORY", LIMIT)


def refusal(path, **options) -> str:
    with pytest.raises(FileError) as caught:
        read_map(path, MeasuredMap(kind="map", file=path.name, **options))
    return str(caught.value)


def dataset(path, shape, **options):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file.create_dataset("heights", shape=shape, dtype="f8", **options)
    return path


def take(path, size):
    return {"heights": np.ones(int(size))}


def stall(path):
    time.sleep(60)


def die(path):
    os._exit(11)


@pytest.mark.slow
@pytest.mark.parametrize(
    ("reader", "arguments", "words"),
    [
        (take, (1e9,), "needs more than 600\u202fMB of memory, to be read: use less"),
        (stall, (), "not read within 1 s: use less"),
        (die, (), "cannot be read (the process ended with exit code 11)"),
    ],
)
def test_a_reader_that_ends_without_an_answer(tmp_path, monkeypatch, reader, arguments, words):
    monkeypatch.setattr(reading, "MOST_SECONDS", 1.0 if reader is stall else 600.0)
    path = tmp_path / "file"
    path.write_bytes(b"1")
    with pytest.raises(FileError) as caught:
        read_apart(f"{__name__}:{reader.__name__}", path, *arguments, remedy="use less")
    assert words in str(caught.value)


@pytest.mark.slow
def test_the_free_memory_bounds_what_is_read(tmp_path, monkeypatch):
    """Of a container with 0.5 GB left, too: its limit counts, not the machine's memory."""
    path = tmp_path / "file"
    path.write_bytes(b"1")
    assert len(read_apart(f"{__name__}:take", path, 3e7, remedy="")["heights"]) == 3e7
    monkeypatch.setattr(machine, "_left_in", lambda group: 2.5e8)
    with pytest.raises(FileError, match="200\u202fMB of memory, 80 % of the free memory"):
        read_apart(f"{__name__}:take", path, 3e7, remedy="")


@pytest.mark.parametrize(
    ("magic", "name"), [(b"\x1f\x8b\x08", "gzip"), (b"BZh9", "bzip2"), (b"\xfd7zXZ\0", "xz")]
)
def test_files_packed_as_a_whole_are_named(tmp_path, magic, name):
    path = tmp_path / "map.gz"
    path.write_bytes(magic + bytes(100))
    assert refusal(path) == f"compressed by {name}: unpack it first"


def test_hdf5_that_declares_too_much(tmp_path):
    """No chunk is stored at all: 2 kB of file declare 80 GB of heights."""
    path = dataset(tmp_path / "map.h5", (10**5, 10**5), chunks=(10, 10))
    assert path.stat().st_size < 10_000
    assert "10000000100 points need" in refusal(path, size=1e-6, height_unit="nm")


@pytest.mark.slow
def test_hdf5_whose_chunk_lies(tmp_path):
    """A chunk of 800 declared bytes holds a stream of 800 MB."""
    h5py = pytest.importorskip("h5py")
    path = dataset(tmp_path / "map.h5", (10, 10), chunks=(10, 10), compression="gzip")
    with h5py.File(path, "r+") as file:
        file["heights"].id.write_direct_chunk((0, 0), zlib.compress(BOMB, 1))
    assert "of memory, to be read: save the heights as .npy" in refusal(
        path, size=1e-6, height_unit="nm"
    )


@pytest.mark.slow
def test_archive_that_unpacks_too_far(tmp_path):
    pytest.importorskip("SurfaceTopography")
    path = tmp_path / "map.x3p"
    with zipfile.ZipFile(path, "w", zipfile.ZIP_DEFLATED) as file:
        file.writestr("main.xml", b"<a>" + b"<b/>" * 15_000_000 + b"</a>")
    assert path.stat().st_size < 1e6
    assert "of memory, to be read: save the heights as .npy" in refusal(path)


@pytest.mark.slow
def test_tiff_that_declares_too_much(tmp_path):
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "map.tif"
    quickly = {"compression": "zlib", "compressionargs": {"level": 1}}
    tifffile.imwrite(path, np.zeros((15_000, 15_000), np.float32), **quickly)
    assert path.stat().st_size < 1e7
    assert "of memory" in refusal(path, size=1e-6, height_unit="nm")


@pytest.mark.slow
def test_mesh_that_unpacks_too_far(tmp_path):
    """The arrays beside an XDMF belong to it."""
    pytest.importorskip("h5py")
    meshio.Mesh(POINTS, [("tetra", [[0, 1, 2, 3]])]).write(tmp_path / "body.xdmf")
    assert len(read_body(tmp_path / "body.xdmf").mesh.points) == 4
    text = (tmp_path / "body.xdmf").read_text()
    name = text.partition("body.h5:/")[2].partition("<")[0].strip()
    h5py = pytest.importorskip("h5py")
    with h5py.File(tmp_path / "body.h5", "w") as file:
        file.create_dataset(name, shape=(10**8, 3), dtype="f8", chunks=(10, 3))
    with pytest.raises(FileError, match=r"file: .* of memory, to be read: use a coarser mesh"):
        read_body(tmp_path / "body.xdmf")
