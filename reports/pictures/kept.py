"""Pictures that stay in the results folder: drawn anew only where data or drawing changed."""

from __future__ import annotations

import hashlib
from collections.abc import Callable, Sequence
from pathlib import Path

import numpy as np

from comparisons.files import write_atomically

FOLDER = "pictures"
Job = dict[str, np.ndarray]
MOST_BYTES = 4_000_000
DIGITS = 32
DRAWING = ("rendering.py", "body_piece.py")  # what else a picture depends on


def rendered(
    jobs: Sequence[Job], folder: Path, render: Callable[[Sequence[Job]], list[bytes]]
) -> list[bytes]:
    """Return the PNG of every job, from `folder` where it is there; empty where rendering failed.

    A picture is named by the digest of its data and of the program that draws it.
    """
    code = b"".join(Path(__file__).with_name(name).read_bytes() for name in DRAWING)
    paths = [folder / f"{_digest(job, code)}.png" for job in jobs]
    images = [_stored(path) for path in paths]
    missing = [index for index, png in enumerate(images) if not png]
    for index, png in zip(missing, render([jobs[index] for index in missing]), strict=True):
        images[index] = png
        if png:
            _store(paths[index], png)
    for path in {*folder.glob("[0-9a-f]" * DIGITS + ".png")}.difference(paths):
        path.unlink()
    return images


def _digest(job: Job, code: bytes) -> str:
    digest = hashlib.sha256(code)
    for name, array in sorted(job.items()):
        digest.update(f"{name} {array.dtype} {array.shape} ".encode())
        digest.update(np.ascontiguousarray(array).tobytes())
    return digest.hexdigest()[:DIGITS]


def _stored(path: Path) -> bytes:
    """Return a picture that is there; a link, or a file of another kind, is none."""
    if path.is_symlink() or not path.is_file() or path.stat().st_size > MOST_BYTES:
        return b""
    png = path.read_bytes()
    return png if png.startswith(b"\x89PNG") else b""


def _store(path: Path, png: bytes) -> None:
    write_atomically(path, lambda file: file.write(png))
