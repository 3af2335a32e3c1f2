"""Files that unpack to more than they may are refused before anything unpacks them."""

from __future__ import annotations

import base64
import io
import lzma
import struct
import zipfile
import zlib

import meshio
import numpy as np
import pytest

from comparisons import machine
from comparisons.geometry import unpacking
from comparisons.geometry.body_files import BodyError, read_body
from comparisons.geometry.topography import MapError, read_map
from comparisons.geometry.unpacking import size_problems
from comparisons.scene.surface import MeasuredMap

LIMIT = 1e6  # bytes in these tests, so that bombs are small
BOMB = bytes(4_000_000)  # zeros: packed a thousandfold
REMEDY = "use something else"


@pytest.fixture(autouse=True)
def _small_limit(monkeypatch):
    monkeypatch.setattr(unpacking, "LARGEST", LIMIT)


def refused(path) -> str:
    """Return the one reason for which a file is not unpacked."""
    problems = size_problems(path, REMEDY)
    assert len(problems) == 1
    return problems[0]


def archive(path, content, compression=zipfile.ZIP_DEFLATED):
    """Write a ZIP archive with one member."""
    with zipfile.ZipFile(path, "w", compression) as file:
        file.writestr("bindata/data.bin", content)
    return path


def lie(path, declared):
    """Let an archive's directory, and the member itself, declare another length."""
    content = bytearray(path.read_bytes())
    with zipfile.ZipFile(path) as file:
        (member,) = file.infolist()
        directory = file.start_dir
    struct.pack_into("<I", content, member.header_offset + 22, declared)
    struct.pack_into("<I", content, directory + 24, declared)
    path.write_bytes(content)


def test_archive_that_declares_too_much_is_not_inflated(tmp_path, monkeypatch):
    """A few kilobytes of ZIP, with nothing read beyond its directory."""
    path = archive(tmp_path / "map.x3p", BOMB)
    assert path.stat().st_size < 10_000
    monkeypatch.setattr(zipfile.ZipFile, "open", lambda *_: pytest.fail("inflated all the same"))
    assert "unpacks to more than 1.00\u202fMB: use something else" in refused(path)


def test_archive_that_lies_is_inflated_no_further_than_the_limit(tmp_path):
    path = archive(tmp_path / "map.x3p", BOMB)
    lie(path, 1000)
    assert "unpacks to more than" in refused(path)


def test_archive_that_lies_within_the_limit_is_damaged(tmp_path):
    path = archive(tmp_path / "map.x3p", bytes(5000))
    lie(path, 1000)
    assert "declared as 1000 bytes and has 5000" in refused(path)


def test_archive_in_another_compression_is_refused(tmp_path):
    """The library inflates bzip2 and LZMA without any bound."""
    path = archive(tmp_path / "map.zip", BOMB, zipfile.ZIP_LZMA)
    assert "not compressed by deflate" in refused(path)


def test_xml_counts_as_what_a_parser_makes_of_it(tmp_path):
    """100 kB of heights fit, 100 kB of XML are some 3 MB of objects."""
    assert size_problems(archive(tmp_path / "heights.zip", bytes(100_000)), REMEDY) == []
    text = b"<a>" + b"<b/>" * 25_000 + b"</a>"
    assert "unpacks to more than" in refused(archive(tmp_path / "xml.zip", text))


def test_the_free_memory_bounds_what_is_unpacked(tmp_path, monkeypatch):
    """Of a container with 50 kB left, too: its limit counts, not the machine's memory."""
    path = archive(tmp_path / "map.x3p", bytes(100_000))
    assert size_problems(path, REMEDY) == []
    monkeypatch.setattr(machine, "_left_in", lambda group: 5e4)
    assert "40.0\u202fkB, 80 % of the free memory" in refused(path)


def test_a_file_that_is_two_kinds_at_once_is_weighed_as_both(tmp_path):
    """A harmless archive behind a MAT file does not hide it: directories are at the end."""
    path = tmp_path / "both.mat"
    harmless = io.BytesIO()
    with zipfile.ZipFile(harmless, "w") as file:
        file.writestr("a", b"b")
    path.write_bytes(mat_file(BOMB) + harmless.getvalue())
    assert "unpacks to more than" in refused(path)


@pytest.mark.parametrize(
    ("magic", "name"), [(b"\x1f\x8b\x08", "gzip"), (b"BZh9", "bzip2"), (b"\xfd7zXZ\0", "xz")]
)
def test_files_packed_as_a_whole_are_named(tmp_path, magic, name):
    path = tmp_path / "map.gz"
    path.write_bytes(magic + bytes(100))
    assert refused(path) == f"compressed by {name}: unpack it first"


# --- HDF5, TIFF, MAT, OLE -------------------------------------------------------------------


def dataset(path, data, **options):
    h5py = pytest.importorskip("h5py")
    with h5py.File(path, "w") as file:
        file.create_dataset("heights", **({"data": data} if data is not None else {}), **options)
    return path


def test_hdf5_that_declares_too_much(tmp_path):
    """No chunk is stored at all: 2 kB of file declare 80 GB of heights."""
    path = dataset(tmp_path / "map.h5", None, shape=(10**5, 10**5), dtype="f8", chunks=(10, 10))
    assert path.stat().st_size < 10_000
    assert "unpacks to more than" in refused(path)


def test_hdf5_whose_chunk_lies(tmp_path):
    """A chunk of 800 declared bytes holds a stream of 4 MB."""
    h5py = pytest.importorskip("h5py")
    path = dataset(tmp_path / "map.h5", None, shape=(10, 10), dtype="f8", chunks=(10, 10),
                   compression="gzip")  # fmt: skip
    with h5py.File(path, "r+") as file:
        file["heights"].id.write_direct_chunk((0, 0), zlib.compress(BOMB))
    assert "unpacks to more than" in refused(path)


def test_compressed_heights_of_common_size_are_read(tmp_path):
    heights = np.random.default_rng(1).normal(size=(40, 40))
    path = dataset(tmp_path / "map.h5", heights, compression="gzip", shuffle=True)
    assert size_problems(path, REMEDY) == []


def test_filters_that_compress_twice_are_refused(tmp_path):
    """Deflate within deflate: a thousandfold of a thousandfold."""
    h5py = pytest.importorskip("h5py")
    plist = h5py.h5p.create(h5py.h5p.DATASET_CREATE)
    plist.set_chunk((10, 10))
    plist.set_deflate(9)
    plist.set_deflate(9)
    with h5py.File(tmp_path / "map.h5", "w") as file:
        space = h5py.h5s.create_simple((10, 10))
        h5py.h5d.create(file.id, b"heights", h5py.h5t.IEEE_F64LE, space, plist)
    assert "not compressed by gzip" in refused(tmp_path / "map.h5")


def test_tiff_that_declares_too_much(tmp_path):
    """4 million pixels of zeros in a few kilobytes."""
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "map.tif"
    tifffile.imwrite(path, np.zeros((2000, 2000), np.float32), compression="zlib")
    assert "unpacks to more than" in refused(path)


def test_tiff_whose_strip_lies(tmp_path):
    """10 x 10 pixels are declared; their strip inflates to 4 MB."""
    tifffile = pytest.importorskip("tifffile")
    path = tmp_path / "map.tif"

    def strips():
        yield zlib.compress(BOMB)

    tifffile.imwrite(path, strips(), shape=(10, 10), dtype=np.float32, compression="zlib")
    assert "unpacks to more than" in refused(path)


def mat_file(content: bytes) -> bytes:
    """Return a MAT file of version 5 with one compressed element."""
    packed = zlib.compress(content)
    head = b"MATLAB 5.0 MAT-file".ljust(124) + b"\0\x01IM"
    return head + struct.pack("<II", 15, len(packed)) + packed


def test_mat_file_that_inflates_too_far(tmp_path):
    path = tmp_path / "map.mat"
    path.write_bytes(mat_file(BOMB))
    assert "unpacks to more than" in refused(path)


def test_streams_of_noise_are_no_streams(tmp_path):
    """1 MB of random bytes begins 500 streams by chance; none of them inflates far."""
    path = tmp_path / "map.mat"
    noise = np.random.default_rng(1).integers(0, 256, 10**6, dtype=np.uint8).tobytes()
    path.write_bytes(mat_file(b"heights") + noise)
    assert size_problems(path, REMEDY) == []


def test_maps_and_bodies_are_weighed_before_they_are_read(tmp_path):
    path = archive(tmp_path / "scan.x3p", BOMB)
    with pytest.raises(MapError, match=r"unpacks to more than .* save the heights as \.npy"):
        read_map(path, MeasuredMap(kind="map", file=path.name))
    mesh = dataset(tmp_path / "body.med", None, shape=(10**5, 10**5), dtype="f8", chunks=(10, 10))
    with pytest.raises(BodyError, match=r"body\.med: .*unpacks to more than"):
        read_body(mesh)


# --- meshes ---------------------------------------------------------------------------------

POINTS = np.array([[0, 0, 0], [1, 0, 0], [0, 1, 0], [0, 0, 1.0]])


def vtu(path, compression):
    """Write one tetrahedron, with a compressed array of zeros of 4 MB."""
    mesh = meshio.Mesh(POINTS, [("tetra", [[0, 1, 2, 3]])], field_data={})
    mesh.write(path, compression=compression)
    return path


def folded(text, width):
    """Break base64 into lines, which its decoders pass over."""
    return b"\n".join(text[i : i + width] for i in range(0, len(text), width))


@pytest.mark.parametrize("width", [10**9, 76, 12])
@pytest.mark.parametrize(("name", "pack"), [("zlib", zlib.compress), ("lzma", lzma.compress)])
def test_vtu_whose_block_lies(tmp_path, name, pack, width):
    """The header of a block says 32 bytes, its stream holds 4 MB, on one line or on many."""
    path = vtu(tmp_path / "body.vtu", name)
    assert size_problems(path, REMEDY) == []
    packed = pack(BOMB)
    header = base64.b64encode(struct.pack("<IIII", 1, 32, 32, len(packed)))
    text = path.read_bytes()
    start = text.index(b">", text.index(b"<DataArray")) + 1
    end = text.index(b"</DataArray", start)
    stream = folded(base64.b64encode(packed), width)
    path.write_bytes(text[:start] + header + stream + text[end:])
    with pytest.raises(BodyError, match="unpacks to more than"):
        read_body(path)


def test_arrays_beside_an_xdmf_are_weighed(tmp_path):
    pytest.importorskip("h5py")
    meshio.Mesh(POINTS, [("tetra", [[0, 1, 2, 3]])]).write(tmp_path / "body.xdmf")
    assert len(read_body(tmp_path / "body.xdmf").mesh.points) == 4
    dataset(tmp_path / "body.h5", None, shape=(10**5, 10**5), dtype="f8", chunks=(10, 10))
    with pytest.raises(BodyError, match=r"body\.h5: .*unpacks to more than"):
        read_body(tmp_path / "body.xdmf")
