"""The rows of a study as a file: CSV, or Parquet where pyarrow is installed. Both keep every bit."""

from __future__ import annotations

import csv
import importlib.util
from collections.abc import Iterable, Iterator
from itertools import islice
from pathlib import Path
from typing import TYPE_CHECKING, Any, Protocol

import numpy as np

from gomboc_cad.errors import StudyError
from gomboc_cad.tolerance.judging import ROW, RowArray

if TYPE_CHECKING:
    import pyarrow

VERDICTS = ("monostable", "multistable", "undecided")
"""Names of the verdicts 0, 1 and 2."""

CHUNK_ROWS = 2**16
_NUMBERS = tuple(name for name in ROW.names or () if name != "verdict")
_COLUMNS = ("row", "verdict", *_NUMBERS)


class Table(Protocol):
    """A kind of file."""

    def write(self, path: Path, chunks: Iterable[RowArray]) -> None:
        """Write all rows, as they come in chunks."""

    def read(self, path: Path) -> Iterator[RowArray]:
        """Give all rows in chunks.

        Raises:
            ValueError: If the file holds anything else.
        """


def table_for(path: Path) -> Table:
    """The kind of file that a name stands for.

    Raises:
        StudyError: If the name ends otherwise than with .csv or .parquet, or pyarrow is missing.
    """
    if path.suffix == ".csv":
        return CsvTable()
    if path.suffix != ".parquet":
        raise StudyError(f"A study is written as .csv or .parquet, not as {path.name}; name it so.")
    if not parquet_is_possible():
        raise StudyError("Parquet files need pyarrow: install gomboc-cad[parquet], or name a .csv file.")
    return ParquetTable()


def parquet_is_possible() -> bool:
    """Whether pyarrow is installed."""
    return importlib.util.find_spec("pyarrow") is not None


class CsvTable:
    """Comma-separated values; an unknown value is empty, a number is the shortest exact one."""

    def write(self, path: Path, chunks: Iterable[RowArray]) -> None:
        """Write all rows."""
        count = 0
        with path.open("x", encoding="ascii", newline="") as stream:
            stream.write(",".join(_COLUMNS) + "\n")
            for chunk in chunks:
                columns = [range(count, count + len(chunk)), (VERDICTS[code] for code in chunk["verdict"])]
                columns += [map(_text, chunk[name].tolist()) for name in _NUMBERS]
                stream.writelines(",".join(map(str, row)) + "\n" for row in zip(*columns, strict=True))
                count += len(chunk)

    def read(self, path: Path) -> Iterator[RowArray]:
        """Give all rows in chunks."""
        with path.open(encoding="ascii", newline="") as stream:
            lines = csv.reader(stream)
            if tuple(next(lines, ())) != _COLUMNS:
                raise ValueError("other columns")
            while texts := list(islice(lines, CHUNK_ROWS)):
                _, verdicts, *numbers = zip(*texts, strict=True)
                rows = np.empty(len(texts), ROW)
                rows["verdict"] = [VERDICTS.index(verdict) for verdict in verdicts]
                for name, column in zip(_NUMBERS, numbers, strict=True):
                    rows[name] = [float(text) if text else np.nan for text in column]
                yield rows


def _text(value: float) -> str:
    return "" if value != value else repr(value)


class ParquetTable:
    """Apache Parquet, the verdict as a dictionary of texts."""

    def write(self, path: Path, chunks: Iterable[RowArray]) -> None:
        """Write all rows, each chunk a row group."""
        import pyarrow.parquet as pq

        count = 0
        with pq.ParquetWriter(path, _schema()) as writer:
            for chunk in chunks:
                writer.write_table(_arrow(chunk, count))
                count += len(chunk)

    def read(self, path: Path) -> Iterator[RowArray]:
        """Give all rows in chunks."""
        import pyarrow.parquet as pq

        with pq.ParquetFile(path) as file:
            if tuple(file.schema_arrow.names) != _COLUMNS:
                raise ValueError("other columns")
            for batch in file.iter_batches(CHUNK_ROWS):
                rows = np.empty(batch.num_rows, ROW)
                rows["verdict"] = [VERDICTS.index(verdict) for verdict in batch["verdict"].to_pylist()]
                for name in _NUMBERS:
                    rows[name] = batch[name].to_numpy(zero_copy_only=False)
                yield rows


def _schema() -> pyarrow.Schema:
    import pyarrow as pa

    kinds: dict[str, Any] = {name: pa.from_numpy_dtype(ROW[name]) for name in _NUMBERS}
    kinds |= {"row": pa.int64(), "verdict": pa.dictionary(pa.int8(), pa.string())}
    return pa.schema([pa.field(name, kinds[name], nullable=False) for name in _COLUMNS])


def _arrow(rows: RowArray, first: int) -> pyarrow.Table:
    import pyarrow as pa

    verdict = pa.DictionaryArray.from_arrays(np.ascontiguousarray(rows["verdict"]), list(VERDICTS))
    numbers = [pa.array(np.ascontiguousarray(rows[name])) for name in _NUMBERS]
    number = pa.array(np.arange(first, first + len(rows), dtype=np.int64))
    return pa.Table.from_arrays([number, verdict, *numbers], schema=_schema())
