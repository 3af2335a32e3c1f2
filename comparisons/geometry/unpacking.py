"""Unpacked size of compressed files, determined before any reader unpacks them.

Instruments store heights in archives (X3P and most others: ZIP), HDF5, TIFF, MAT and OLE files;
meshes come as HDF5 and compressed XML. A file of a few megabytes may unpack to any size, and the
sizes in its directory may be wrong. Therefore the declared sizes are compared with the limits
first; then every compressed stream is inflated once, in pieces that are counted and dropped, up to
the limit.
"""

from __future__ import annotations

import base64
import copy
import lzma
import mmap
import re
import string
import zipfile
import zlib
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from comparisons.formatting import memory
from comparisons.geometry.silence import quiet
from comparisons.machine import MEMORY_SHARE, free_memory

# Largest unpacked size of a file in bytes: 11 000 x 11 000 points in double precision.
LARGEST = 1e9
# Text readers store numbers as objects: bytes in memory per byte of the file.
_TEXT_GROWTH = 20
# Parsers store XML as objects: bytes in memory per byte of text.
_XML_GROWTH = 30
# Bytes per piece of unpacking, and bytes examined to recognise a stream.
_PIECE, _FIRST_PIECE = 2**16, 2**10
_XZ, _XZ_MEMORY = b"\xfd7zXZ\0", 2**28
_PACKED_WHOLE = {
    b"\x1f\x8b": "gzip",
    b"BZh": "bzip2",
    _XZ: "xz",
    b"(\xb5/\xfd": "zstandard",
    b"7z\xbc\xaf\x27\x1c": "7z",
}
# Byte order marks and blanks.
_BEFORE_XML = b"\xff\xfe\xef\xbb\xbf \t\r\n"
_TIFF = (b"II*\0", b"MM\0*", b"II+\0", b"MM\0+")
_OLE = b"\xd0\xcf\x11\xe0\xa1\xb1\x1a\xe1"
_HDF5 = b"\x89HDF\r\n\x1a\n"
# Tag 259 of TIFF: none, LZW, deflate (new and old), PackBits. Except for deflate, the declared size
# of a strip limits the growth.
_TIFF_COMPRESSIONS = (1, 5, 8, 32773, 32946)
# Compressing HDF5 filters; several in a row would multiply the growth.
_HDF5_DEFLATE = 1
_HDF5_COMPRESSING = (_HDF5_DEFLATE, 4, 5, 6, 32000)  # and szip, nbit, scale-offset, LZF
_HDF5_HARMLESS = (2, 3)  # shuffle, checksum


def _zlib_headers() -> bytes:
    """Return a pattern for the first two bytes of a zlib stream without a dictionary (RFC 1950)."""
    pairs = []
    for method in range(0x08, 0x79, 0x10):
        flags = [f for f in range(256) if not f & 0x20 and (256 * method + f) % 31 == 0]
        pairs.append(re.escape(bytes([method])) + b"[" + b"".join(map(_escaped, flags)) + b"]")
    return b"|".join(pairs)


def _escaped(byte: int) -> bytes:
    return b"\\x%02x" % byte


_STREAM = re.compile(_zlib_headers() + b"|" + _XZ, re.DOTALL)
_TEXT = re.compile(rb"[^<>]{8,}")  # of an XML element
_NOT_BASE64 = bytes(set(range(256)) - set(b"=+/" + (string.ascii_letters + string.digits).encode()))


class _TooLargeError(Exception):
    """The unpacked file exceeds the limit."""


class _Budget:
    """Counter of unpacked bytes that raises at the limit."""

    def __init__(self, limit: float) -> None:
        self.limit = limit
        self.spent = 0.0

    def spend(self, count: float) -> None:
        self.spent += count
        if self.spent > self.limit:
            raise _TooLargeError


def size_problems(path: Path, remedy: str) -> list[str]:
    """Return the reasons why a file, packed or unpacked, is too large to be read.

    Parameters
    ----------
    path : Path
        The file; its format is recognised by content, not by suffix.
    remedy : str
        Advice at the end of the message.
    """
    with path.open("rb") as file:
        start = file.read(4096)
    size, free = path.stat().st_size, MEMORY_SHARE * free_memory()
    need = size * (1 if b"\0" in start else _TEXT_GROWTH)
    if need > free:
        return [
            f"a file of {memory(size)} may need {memory(need)} of memory, 80 % of the free memory "
            f"are {memory(free)}: {remedy}"
        ]
    return _unpacking_problems(path, start, remedy)


def _unpacking_problems(path: Path, start: bytes, remedy: str) -> list[str]:
    packer = next((name for magic, name in _PACKED_WHOLE.items() if start.startswith(magic)), None)
    if packer is not None:
        return [f"compressed by {packer}: unpack it first"]
    limit = min(LARGEST, MEMORY_SHARE * free_memory())
    budget = _Budget(limit)
    try:
        return [problem for weigh in _weighers(path, start) for problem in weigh(path, budget)]
    except _TooLargeError:
        free = "" if limit == LARGEST else ", 80 % of the free memory"
        return [
            f"this file of {memory(path.stat().st_size)} unpacks to more than "
            f"{memory(limit)}{free}: {remedy}"
        ]


def _weighers(path: Path, start: bytes) -> list[Callable[[Path, _Budget], list[str]]]:
    """Return the functions that measure a file; several if it matches several formats."""
    kinds = {
        _weigh_zip: zipfile.is_zipfile(path),
        _weigh_tiff: start.startswith(_TIFF),
        _weigh_ole: start.startswith(_OLE),
        _weigh_streams: start.startswith(b"MATLAB 5"),
        _weigh_hdf5: _is_hdf5(path),
        _weigh_xml: start.replace(b"\0", b"").lstrip(_BEFORE_XML).startswith(b"<"),
    }
    return [weigh for weigh, applies in kinds.items() if applies]


def _weigh_zip(path: Path, budget: _Budget) -> list[str]:
    try:
        with zipfile.ZipFile(path) as archive:
            members = archive.infolist()
            kinds = {member.compress_type for member in members}
            if not kinds <= {zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED}:
                return ["an archive not compressed by deflate: save it as plain ZIP"]
            _Budget(budget.limit).spend(sum(member.file_size for member in members))
            for member in members:
                _weigh_member(archive, member, budget)
    except (zipfile.BadZipFile, zlib.error, EOFError, OSError, RuntimeError, ValueError) as error:
        return [f"an archive that cannot be unpacked ({error})"]
    return []


def _weigh_member(archive: zipfile.ZipFile, member: zipfile.ZipInfo, budget: _Budget) -> None:
    # Read to the end: at the declared size the library stops counting, but not inflating.
    honest = copy.copy(member)
    honest.file_size = int(budget.limit) + 2 * _PIECE
    length, growth = 0, 1
    with archive.open(honest) as stream:
        while piece := stream.read(_PIECE):
            if length == 0 and piece.lstrip(_BEFORE_XML).startswith(b"<"):
                growth = _XML_GROWTH
            length += len(piece)
            budget.spend(growth * len(piece))
    if length != member.file_size:
        raise zipfile.BadZipFile(
            f"{member.filename} is declared as {member.file_size} bytes and has {length}"
        )


def _weigh_tiff(path: Path, budget: _Budget) -> list[str]:
    try:
        import tifffile
    except ImportError:
        return []
    packed = set()
    try:
        with quiet(), tifffile.TiffFile(path) as image:
            for page in image.pages:
                itemsize = np.dtype(page.dtype or "u1").itemsize
                for shape in (page.shape, page.chunks):
                    _Budget(budget.limit).spend(itemsize * float(np.prod(shape, dtype=float)))
                packed.add(int(page.compression))
    except _TooLargeError:
        raise
    except Exception as error:  # damaged tags raise arbitrary exceptions
        return [f"a damaged TIFF image ({type(error).__name__}: {error})"]
    if not packed <= set(_TIFF_COMPRESSIONS):
        return ["a TIFF image not compressed by deflate or LZW: save it uncompressed"]
    return _weigh_streams(path, budget) if packed & {8, 32946} else []


def _weigh_ole(path: Path, budget: _Budget) -> list[str]:
    """Measure the streams of an OLE file (Mountains' .mnt), whose sectors may be in any order."""
    try:
        import olefile
    except ImportError:
        return []
    try:
        with olefile.OleFileIO(path) as document:
            for name in document.listdir():
                _weigh_buffer(document.openstream(name).read(), budget)
    except _TooLargeError:
        raise
    except Exception as error:  # damaged sectors raise arbitrary exceptions
        return [f"a damaged OLE file ({type(error).__name__}: {error})"]
    return []


def _is_hdf5(path: Path) -> bool:
    """Return whether the HDF5 signature is at 0, 512, 1024, 2048, ..., the permitted positions."""
    size, place = path.stat().st_size, 0
    with path.open("rb") as file:
        while place < size:
            file.seek(place)
            if file.read(8) == _HDF5:
                return True
            place = 2 * place or 512
    return False


def _weigh_hdf5(path: Path, budget: _Budget) -> list[str]:
    try:
        import h5py
    except ImportError:
        return []
    problems: list[str] = []
    used: set[int] = set()

    def weigh(name: str, node: Any) -> None:
        if not isinstance(node, h5py.Dataset) or node.shape is None:
            return
        for shape in (node.shape, node.chunks or ()):
            # Chunks are read one at a time.
            _Budget(budget.limit).spend(node.dtype.itemsize * float(np.prod(shape, dtype=float)))
        creation = node.id.get_create_plist()
        filters = [creation.get_filter(k)[0] for k in range(creation.get_nfilters())]
        compressing = [filter_name for filter_name in filters if filter_name not in _HDF5_HARMLESS]
        if len(compressing) > 1 or not set(compressing) <= set(_HDF5_COMPRESSING):
            problems.append(f"{name}: not compressed by gzip: save it uncompressed")
        used.update(compressing)

    try:
        with h5py.File(path, "r") as file:
            file.visititems(weigh)
    except (OSError, RuntimeError, ValueError, KeyError, TypeError) as error:
        return [f"a damaged HDF5 file ({error})"]
    if problems or _HDF5_DEFLATE not in used:
        return problems
    return _weigh_streams(path, budget)


def _weigh_xml(path: Path, budget: _Budget) -> list[str]:
    """Measure the streams of a VTK file, raw or as base64 within the XML."""
    content = _bytes_of(path)
    if b"\0" in content[:_FIRST_PIECE].lstrip(_BEFORE_XML)[:2]:
        return ["XML in UTF-16: save it as UTF-8"]
    for text in _TEXT.finditer(content):
        # Decoders skip line ends and foreign characters, and restart after padding.
        for run in text[0].translate(None, _NOT_BASE64).split(b"="):
            quads = run[: len(run) - (len(run) % 4 == 1)]
            _weigh_buffer(base64.b64decode(quads + b"=" * (-len(quads) % 4)), budget)
    return _weigh_streams(path, budget)


def _weigh_streams(path: Path, budget: _Budget) -> list[str]:
    _weigh_buffer(_bytes_of(path), budget)
    return []


def _bytes_of(path: Path) -> mmap.mmap:
    """Map a file into memory until its last view is closed."""
    with path.open("rb") as file:
        return mmap.mmap(file.fileno(), 0, access=mmap.ACCESS_READ)


def _weigh_buffer(content: bytes | mmap.mmap, budget: _Budget) -> None:
    """Inflate every zlib and xz stream that begins somewhere in a buffer, and count the bytes.

    About one in 2000 pairs of bytes looks like a header by chance; such streams end at once.
    """
    view, place = memoryview(content), 0
    while match := _STREAM.search(content, place):
        begin = match.start()
        place = begin + (_inflate(view[begin:], budget) or 1)


def _inflate(view: memoryview, budget: _Budget) -> int:
    """Return the length of the compressed stream at the beginning of a buffer, 0 if none."""
    xz = view[0] == _XZ[0]
    packed: Any = lzma.LZMADecompressor(memlimit=_XZ_MEMORY) if xz else zlib.decompressobj()
    end, unread, step = 0, b"", _FIRST_PIECE
    try:
        while not packed.eof:
            if unread or not getattr(packed, "needs_input", True):
                piece = packed.decompress(unread, _PIECE)
            else:
                fed = bytes(view[end : end + step])
                if not fed:
                    return 0
                end, step = end + len(fed), _PIECE
                piece = packed.decompress(fed, _PIECE)
            unread = getattr(packed, "unconsumed_tail", b"")
            budget.spend(len(piece))
    except (zlib.error, lzma.LZMAError, MemoryError):
        return 0
    return end - len(packed.unused_data) - len(unread)
