"""STL files, binary and text. The format has neither a unit nor shared corners."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path
from typing import BinaryIO

import numpy as np

from gomboc_cad.body.sphere import Array
from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.formats.content import MAX_FACETS, FileMesh, check_count

BINARY, TEXT = "a binary STL file", "a text STL file"

_HEADER_BYTES = 84
_FACET = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_BLOCK_BYTES = 2**23
_WORDS = b"facet normal # # # outer loop vertex # # # vertex # # # vertex # # # endloop endfacet".split()
_NUMBERS = [i for i, word in enumerate(_WORDS) if word == b"#"]
_KEYWORDS = [i for i, word in enumerate(_WORDS) if word != b"#"]
_LONGEST_WORD = 64
_FRAME_LINE = re.compile(rb"^[ \t]*(?:end)?solid\b[^\r\n]*", re.MULTILINE)
_LAST_LINE = re.compile(rb"^[ \t]*endsolid\b[^\r\n]*\s*\Z", re.MULTILINE)


def declared_size(head: bytes) -> int | None:
    """Size in bytes that a binary STL file with this beginning must have; None if it is too short."""
    if len(head) < _HEADER_BYTES:
        return None
    return _HEADER_BYTES + _FACET.itemsize * int.from_bytes(head[80:84], "little")


def read_binary_stl(path: Path, name: str) -> FileMesh:
    """Read a binary STL file.

    Raises:
        InspectionError: If its size is not what its header says, or too large.
    """
    with path.open("rb") as stream:
        head = stream.read(_HEADER_BYTES)
        declared, size = declared_size(head), path.stat().st_size
        count = int.from_bytes(head[80:84], "little")
        if declared != size:
            raise InspectionError(
                f"{name} is damaged: its header says {count:,} facets, which is {declared or 0:,} bytes, but "
                f"it has {size:,}; save it again."
            )
        check_count(name, "facets", count, MAX_FACETS)
        corners = np.fromfile(stream, dtype=_FACET, count=count)["corners"]
    return _soup(BINARY, corners.astype(float).reshape(-1, 3))


def read_text_stl(path: Path, name: str) -> FileMesh:
    """Read a text STL file; several solids in it become one mesh.

    Raises:
        InspectionError: If it is cut off or does not follow the format, or is too large.
    """
    blocks, count = [], 0
    with path.open("rb") as stream:
        for block in _blocks(name, stream):
            blocks.append(_corners(name, block))
            count += len(blocks[-1]) // 3
            check_count(name, "facets", count, MAX_FACETS)
    return _soup(TEXT, np.concatenate([np.zeros((0, 3)), *blocks]))


def _blocks(name: str, stream: BinaryIO) -> Iterator[bytes]:
    """Pieces of the text that end after a facet, in small letters; the last line must end the solid."""
    rest = b""
    while data := stream.read(_BLOCK_BYTES):
        text = rest + data.lower()
        end = text.rfind(b"endfacet") + len(b"endfacet")
        if end < len(b"endfacet"):
            if len(text) > 2 * _BLOCK_BYTES:
                raise InspectionError(f"{name} is damaged: it does not follow the text STL format.")
            end = 0
        rest = text[end:]
        yield text[:end]
    if not _LAST_LINE.search(rest):
        raise InspectionError(f"{name} is cut off: it does not end with endsolid; save it again.")
    yield rest


def _corners(name: str, block: bytes) -> Array:
    """Corners of the whole facets in a piece of text, shape (3 m, 3)."""
    words = _FRAME_LINE.sub(b"", block).split()
    facets, left = divmod(len(words), len(_WORDS))
    if not left and max(map(len, words), default=0) <= _LONGEST_WORD:
        table = np.array(words, dtype=f"S{_LONGEST_WORD}").reshape(facets, len(_WORDS))
        if np.all(table[:, _KEYWORDS] == np.array([_WORDS[i] for i in _KEYWORDS])):
            try:
                return table[:, _NUMBERS[3:]].astype(float).reshape(-1, 3)
            except ValueError:
                pass
    raise InspectionError(f"{name} is damaged: it does not follow the text STL format.")


def _soup(kind: str, corners: Array) -> FileMesh:
    return FileMesh(kind, corners, np.arange(len(corners), dtype=np.int64).reshape(-1, 3))
