"""Zip archives from anywhere: members are read in memory with a limit, and never unpacked to the disk."""

from __future__ import annotations

import zipfile
import zlib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path, PurePosixPath

from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.formats.content import MAX_BYTES

_MAX_MEMBERS = 2000
_MAX_DIRECTORY_BYTES = 2**20
_END_RECORD, _END_RECORD_64, _LOCATOR_64 = b"PK\x05\x06", b"PK\x06\x06", b"PK\x06\x07"
_END_BYTES = 2**16 + 200
"""Where the end records of an archive can be, counted from its end."""

_BLOCK_BYTES = 2**20
_MAX_RATIO = 250
"""Text of coordinates shrinks five- to twentyfold; the most that deflate can do is about a thousand."""

_RATIO_FROM_BYTES = 2**24
"""Members that unpack to less are read whatever their ratio is."""


class Archive:
    """A zip archive whose directory has been looked through.

    Attributes:
        names: Its members.
    """

    def __init__(self, name: str, archive: zipfile.ZipFile):
        self._name = name
        self._archive = archive
        self._left = MAX_BYTES
        infos = archive.infolist()
        if len(infos) > _MAX_MEMBERS:
            raise InspectionError(
                f"{name} holds {len(infos):,} members, more than the {_MAX_MEMBERS} allowed."
            )
        self.names = frozenset(info.filename for info in infos)
        if len(self.names) < len(infos):
            raise InspectionError(f"{name} is damaged: two of its members have the same name.")
        for info in infos:
            if ".." in PurePosixPath(info.filename.replace("\\", "/")).parts or ":" in info.filename:
                raise InspectionError(
                    f"{name} is not to be trusted: it holds a member named {info.filename!r}."
                )

    def blocks(self, member: str) -> Iterator[bytes]:
        """Unpack a member block by block.

        All members together may unpack to `MAX_BYTES`, whatever the directory says about their size.

        Raises:
            InspectionError: If there is no such member, it is damaged, encrypted or a zip bomb.
        """
        if member not in self.names:
            raise InspectionError(f"{self._name} is incomplete: it lacks {member}; save it again.")
        info = self._archive.getinfo(member)
        if info.flag_bits & 1:
            raise InspectionError(f"{self._name} is encrypted; save it without a password.")
        if info.compress_type not in (zipfile.ZIP_STORED, zipfile.ZIP_DEFLATED):
            raise InspectionError(f"{self._name} is packed in a way that the 3MF format does not allow.")
        unpacked = 0
        try:
            with self._archive.open(info) as stream:
                while block := stream.read(_BLOCK_BYTES):
                    unpacked += len(block)
                    self._left -= len(block)
                    if self._left < 0 or unpacked > max(_RATIO_FROM_BYTES, _MAX_RATIO * info.compress_size):
                        raise InspectionError(
                            f"{self._name} is not to be trusted: {member} unpacks from "
                            f"{info.compress_size:,} bytes to more than {unpacked:,}, as in a zip bomb."
                        )
                    yield block
        except (zipfile.BadZipFile, zlib.error, EOFError, OSError, NotImplementedError, ValueError) as error:
            raise InspectionError(f"{self._name} is damaged: {member} cannot be unpacked.") from error


@contextmanager
def open_archive(path: Path, name: str) -> Iterator[Archive]:
    """Open a zip archive.

    Raises:
        InspectionError: If it is cut off or damaged, or not to be trusted.
    """
    _check_directory(path, name)
    try:
        archive = zipfile.ZipFile(path)
    except (zipfile.BadZipFile, OSError, ValueError, NotImplementedError) as error:
        raise InspectionError(
            f"{name} is cut off or damaged: it is no whole zip archive; save it again."
        ) from error
    with archive:
        yield Archive(name, archive)


def _check_directory(path: Path, name: str) -> None:
    """Refuse an archive with a huge directory, which the zip module would read whole.

    Source: PKWARE, APPNOTE 6.3, sections 4.3.14 to 4.3.16.
    """
    with path.open("rb") as stream:
        stream.seek(max(0, path.stat().st_size - _END_BYTES))
        tail = stream.read()
    end = tail.rfind(_END_RECORD)
    declared = [tail[end + 12 : end + 16]] if end >= 0 else []
    if tail[max(0, end - 20) :].startswith(_LOCATOR_64):
        end_64 = tail.rfind(_END_RECORD_64)
        declared = [tail[end_64 + 40 : end_64 + 48]] if end_64 >= 0 else []
    if not declared:
        raise InspectionError(f"{name} is cut off or damaged: it is no whole zip archive; save it again.")
    if int.from_bytes(declared[0], "little") > _MAX_DIRECTORY_BYTES:
        raise InspectionError(f"{name} is not to be trusted: it holds far too many members.")
