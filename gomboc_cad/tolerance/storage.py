"""A study on disk that can be interrupted at any moment and goes on from its last whole batch.

Beside the file to be, a manifest says which study it belongs to, and a journal takes the batches as they
come, each with its number and a checksum: a batch that was cut off, or that never reached the disk, is found
and done again. Only when all rows are there is the file written from the journal, whole or not at all, and
the journal removed.
"""

from __future__ import annotations

import csv
import json
import os
import struct
from collections.abc import Iterable, Iterator, Mapping
from contextlib import suppress
from pathlib import Path
from types import TracebackType
from typing import BinaryIO, Self
from zlib import crc32

import numpy as np

from gomboc_cad.errors import StudyError
from gomboc_cad.solid.output import atomic_path, write_bytes, writing_to
from gomboc_cad.tolerance.judging import ROW, RowArray
from gomboc_cad.tolerance.sampling import BATCH_ROWS
from gomboc_cad.tolerance.tables import CHUNK_ROWS, table_for

Identity = Mapping[str, str | int | float]

_HEADER = struct.Struct("<QII")


class Store:
    """The rows of one study, for writing.

    Args:
        path: The file to be: .csv or .parquet.
        variants: How many rows it will have.
        identity: What the rows depend on. A file of another study is left alone.

    Raises:
        StudyError: If the path is that of another study or of something else, or cannot be such a file.
        OutputError: If nothing can be written there.
    """

    def __init__(self, path: Path, variants: int, identity: Identity) -> None:
        self.path = path
        self._variants = variants
        self._table = table_for(path)
        self._manifest = path.with_name(f"{path.name}.study.json")
        self._journal = path.with_name(f"{path.name}.journal")
        self._stream: BinaryIO | None = None
        self._claim({**identity, "variants": variants})

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        if self._stream is not None:
            self._stream.close()

    def stored(self) -> Iterator[RowArray]:
        """Give the rows that are there, from the first on without a gap; what is cut off behind them goes.

        Raises:
            StudyError: If the finished file is not as it was written.
        """
        return self._finished() if self.path.exists() else self._whole_batches()

    def append(self, batch: int, rows: RowArray) -> None:
        """Write one more batch behind those that `stored` gave.

        Raises:
            OutputError: If the disk is full, or writing is refused.
        """
        payload = rows.tobytes()
        with writing_to(self._journal):
            if self._stream is None:
                self._stream = self._journal.open("ab")
            self._stream.write(_HEADER.pack(batch, len(rows), crc32(payload)) + payload)
            self._stream.flush()

    def finish(self) -> None:
        """Write the file and remove the journal.

        Raises:
            StudyError: If the journal does not hold all rows, as when two runs wrote to it.
            OutputError: If the disk is full, or writing is refused.
        """
        if not self.path.exists():
            with atomic_path(self.path) as part:
                self._table.write(part, _chunks(self._all_rows(self._journal, self._whole_batches())))
                with part.open("rb+") as stream:
                    os.fsync(stream.fileno())
        with writing_to(self._journal):
            self._journal.unlink(missing_ok=True)

    def _claim(self, identity: Identity) -> None:
        if not self._manifest.exists():
            if self.path.exists() or self._journal.exists():
                raise StudyError(f"{self.path} is there already and is no study; name another file.")
            write_bytes(self._manifest, (json.dumps(dict(identity), indent=2) + "\n").encode())
            return
        try:
            there = json.loads(self._manifest.read_bytes())
        except (OSError, ValueError):
            there = None
        if there != identity:
            other = sorted(
                key for key in identity if not isinstance(there, dict) or there.get(key) != identity[key]
            )
            raise StudyError(
                f"{self.path} belongs to another study: its {', '.join(other)} differ; name another file, or "
                f"remove it together with {self._manifest.name}."
            )

    def _finished(self) -> Iterator[RowArray]:
        try:
            yield from self._all_rows(self.path, self._table.read(self.path))
        except (OSError, ValueError, csv.Error) as error:
            raise self._damaged(self.path) from error

    def _all_rows(self, path: Path, chunks: Iterable[RowArray]) -> Iterator[RowArray]:
        """Pass the rows of a file on, and refuse it in the end if they are not as many as there should be."""
        count = 0
        for rows in chunks:
            count += len(rows)
            yield rows
        if count != self._variants:
            raise self._damaged(path)

    def _damaged(self, path: Path) -> StudyError:
        return StudyError(
            f"{path} is not as it was written; remove it together with {self._manifest.name}, and run the "
            "study again."
        )

    def _whole_batches(self) -> Iterator[RowArray]:
        with suppress(FileNotFoundError), self._journal.open("r+b") as stream:
            end, batch = 0, 0
            while (rows := self._read(stream, batch)) is not None:
                yield rows
                end, batch = stream.tell(), batch + 1
            stream.truncate(end)

    def _read(self, stream: BinaryIO, batch: int) -> RowArray | None:
        """The rows of a batch at the place of the stream; None if they are not there whole."""
        expected = min(BATCH_ROWS, self._variants - batch * BATCH_ROWS)
        head = stream.read(_HEADER.size)
        if expected <= 0 or len(head) < _HEADER.size:
            return None
        payload = stream.read(expected * ROW.itemsize)
        if _HEADER.unpack(head) != (batch, expected, crc32(payload)):
            return None
        return np.frombuffer(payload, ROW)


def _chunks(batches: Iterable[RowArray]) -> Iterator[RowArray]:
    """Join batches to chunks, which are written faster."""
    gathered: list[RowArray] = []
    for rows in batches:
        gathered.append(rows)
        if len(gathered) * BATCH_ROWS >= CHUNK_ROWS:
            yield np.concatenate(gathered)
            gathered.clear()
    if gathered:
        yield np.concatenate(gathered)
