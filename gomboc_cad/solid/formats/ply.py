"""PLY files, text and binary of either byte order: vertices and polygons."""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import BinaryIO

import numpy as np

from gomboc_cad.body.sphere import Array, IntArray
from gomboc_cad.errors import InspectionError
from gomboc_cad.solid.formats.content import (
    MAX_CORNERS,
    MAX_FACETS,
    MAX_LINE_BYTES,
    FileMesh,
    check_count,
    text_lines,
)
from gomboc_cad.solid.formats.polygons import triangulate

PLY = "a PLY file"

_MAX_HEADER_LINES = 1000
_BYTE_ORDERS = {"binary_little_endian": "<", "binary_big_endian": ">"}
_TYPES = {
    "char": "i1",
    "uchar": "u1",
    "short": "i2",
    "ushort": "u2",
    "int": "i4",
    "uint": "u4",
    "float": "f4",
    "double": "f8",
    "int8": "i1",
    "uint8": "u1",
    "int16": "i2",
    "uint16": "u2",
    "int32": "i4",
    "uint32": "u4",
    "float32": "f4",
    "float64": "f8",
}
_CORNERS = ("vertex_indices", "vertex_index")


@dataclass(frozen=True)
class _Property:
    """A column of an element: a number, or a list of numbers behind its length."""

    name: str
    type: str
    length_type: str | None = None


@dataclass(frozen=True)
class _Element:
    """A table of a PLY file."""

    name: str
    count: int
    properties: tuple[_Property, ...]

    def list_property(self) -> _Property | None:
        """The only list property; None where there is none.

        Raises:
            ValueError: If there are several.
        """
        lists = [p for p in self.properties if p.length_type]
        if len(lists) > 1:
            raise ValueError(f"the element {self.name!r} has several lists, which is not read")
        return lists[0] if lists else None


@dataclass(frozen=True)
class _Table:
    """Numbers of an element, and its list: lengths and one list after another."""

    columns: dict[str, Array]
    lengths: IntArray | None = None
    items: IntArray | None = None


def read_ply(path: Path, name: str) -> FileMesh:
    """Read the vertices and facets of a PLY file.

    Raises:
        InspectionError: If it is cut off, does not follow the format, holds no facets, or is too large.
    """
    with path.open("rb") as stream:
        try:
            encoding, elements = _header(stream)
            for element in elements:
                limit = MAX_FACETS if element.name == "face" else MAX_CORNERS
                check_count(name, f"rows of {element.name}", element.count, limit)
            if encoding == "ascii":
                tables = _text_tables(name, stream, elements)
            else:
                tables = _binary_tables(stream.read(), _BYTE_ORDERS[encoding], elements)
            return _mesh(name, tables)
        except (ValueError, OverflowError, KeyError) as error:
            raise InspectionError(f"{name} is damaged: {_clause(error)}.") from error


def _clause(error: Exception) -> str:
    return f"it lacks {error}" if isinstance(error, KeyError) else str(error)


def _mesh(name: str, tables: dict[str, _Table]) -> FileMesh:
    vertex = tables["vertex"].columns
    vertices = np.stack([vertex["x"], vertex["y"], vertex["z"]], axis=1).astype(float)
    if "face" not in tables:
        extra = "triangle strips" if "tristrips" in tables else "points only"
        raise InspectionError(f"{name} holds {extra}; export it with its facets.")
    face = tables["face"]
    if face.lengths is None or face.items is None:
        raise ValueError("its facets have no list vertex_indices")
    faces, notes = triangulate(name, vertices, face.lengths, face.items)
    return FileMesh(PLY, vertices, faces, notes=notes)


def _header(stream: BinaryIO) -> tuple[str, list[_Element]]:
    """Read the encoding and the elements that the header declares."""
    encoding = ""
    elements: list[_Element] = []
    for _ in range(_MAX_HEADER_LINES):
        words = stream.readline(MAX_LINE_BYTES).decode("ascii", "replace").split()
        match words:
            case ["end_header"]:
                if encoding not in ("ascii", *_BYTE_ORDERS):
                    raise ValueError(f"its format is {encoding or 'not stated'!r}")
                if len({element.name for element in elements}) < len(elements):
                    raise ValueError("its header names an element twice")
                return encoding, elements
            case ["format", encoding, _]:
                pass
            case ["element", element, count]:
                elements.append(_Element(element, _count(count), ()))
            case ["property", "list", length_type, item_type, column] if elements:
                column_type = _Property(column, _TYPES[item_type], _TYPES[length_type])
                elements[-1] = _with_property(elements[-1], column_type)
            case ["property", column_type_name, column] if elements:
                elements[-1] = _with_property(elements[-1], _Property(column, _TYPES[column_type_name]))
            case ["ply"] | ["comment", *_] | ["obj_info", *_]:
                pass
            case _:
                raise ValueError("its header does not follow the format")
    raise ValueError("its header has no end")


def _count(text: str) -> int:
    count = int(text)
    if count < 0:
        raise ValueError("its header declares a negative number of rows")
    return count


def _with_property(element: _Element, column: _Property) -> _Element:
    if any(column.name == other.name for other in element.properties):
        raise ValueError(f"its header names the property {column.name!r} twice")
    return _Element(element.name, element.count, (*element.properties, column))


def _text_tables(name: str, stream: BinaryIO, elements: list[_Element]) -> dict[str, _Table]:
    lines = (line for line in text_lines(name, stream) if line.strip())
    tables = {element.name: _text_table(name, lines, element) for element in elements}
    if next(lines, None) is not None:
        raise ValueError("it goes on after the rows that its header declares")
    return tables


def _text_table(name: str, lines: Iterator[bytes], element: _Element) -> _Table:
    listed = element.list_property()
    before = element.properties.index(listed) if listed else len(element.properties)
    numbers, lengths, items = array("d"), array("q"), array("q")
    for row in range(element.count):
        words = next(lines, b"").split()
        length = int(words[before]) if listed and len(words) > before else 0
        if length < 0 or len(words) != len(element.properties) + length:
            raise ValueError(f"row {row + 1} of {element.name} is missing or incomplete")
        if listed:
            lengths.append(length)
            items.extend(map(int, words[before + 1 : before + 1 + length]))
            words[before : before + 1 + length] = []
            check_count(name, "corners of facets", len(items), MAX_CORNERS)
        numbers.extend(map(float, words))
    names = [p.name for p in element.properties if p is not listed]
    columns = dict(zip(names, _numbers(numbers).reshape(element.count, len(names)).T, strict=True))
    if listed is None or listed.name not in _CORNERS:
        return _Table(columns)
    return _Table(columns, _numbers(lengths), _numbers(items))


def _numbers(values: array) -> np.ndarray:
    return np.array(values, dtype=float if values.typecode == "d" else np.int64)


def _binary_tables(data: bytes, order: str, elements: list[_Element]) -> dict[str, _Table]:
    tables, offset = {}, 0
    for element in elements:
        tables[element.name], offset = _binary_table(data, offset, order, element)
    if offset != len(data):
        raise ValueError(f"it holds {len(data) - offset:,} bytes more than its header declares")
    return tables


def _binary_table(data: bytes, offset: int, order: str, element: _Element) -> tuple[_Table, int]:
    """Read one element from an offset on; also gives the offset of what follows."""
    listed = element.list_property()
    if listed is None or not element.count:
        rows, end = _rows(data, offset, _row_type(element, order, 0), element)
        return _Table({p.name: rows[p.name] for p in element.properties if p is not listed}), end
    before = _row_type(_Element("", 0, element.properties[: element.properties.index(listed)]), order, 0)
    length_type = np.dtype(order + str(listed.length_type))

    def length_at(start: int) -> int:
        place = start + before.itemsize
        if place + length_type.itemsize > len(data):
            raise ValueError(f"the rows of {element.name} are cut off")
        length = int(np.frombuffer(data, length_type, count=1, offset=place)[0])
        if not 0 <= length <= len(data):
            raise ValueError(f"a list of {element.name} claims {length:,} entries")
        return length

    first = length_at(offset)
    row_type = _row_type(element, order, first)
    if offset + element.count * row_type.itemsize <= len(data):
        rows, end = _rows(data, offset, row_type, element)
        if np.all(rows["length"] == first):
            return _Table({}, *_listed(listed, rows["length"], [rows[listed.name].ravel()])), end
    # Lists of different lengths: where a row begins is known only after the one before.
    lengths, items, end = [], [], offset
    types: dict[int, np.dtype] = {}
    for _ in range(element.count):
        length = length_at(end)
        row_type = types.setdefault(length, _row_type(element, order, length))
        row, end = _rows(data, end, row_type, _Element(element.name, 1, element.properties))
        lengths.append(length)
        items.append(row[listed.name].ravel())
    return _Table({}, *_listed(listed, np.array(lengths), items)), end


def _listed(
    listed: _Property, lengths: IntArray, items: list[np.ndarray]
) -> tuple[IntArray, IntArray] | tuple[None, None]:
    if listed.name not in _CORNERS:
        return None, None
    return lengths.astype(np.int64), np.concatenate(items).astype(np.int64)


def _row_type(element: _Element, order: str, length: int) -> np.dtype:
    """Layout of a row whose list has a given length."""
    fields: list[tuple] = []
    for column in element.properties:
        if column.length_type:
            fields += [
                ("length", order + column.length_type),
                (column.name, order + column.type, (length,)),
            ]
        else:
            fields.append((column.name, order + column.type))
    return np.dtype(fields)


def _rows(data: bytes, offset: int, row_type: np.dtype, element: _Element) -> tuple[np.ndarray, int]:
    end = offset + element.count * row_type.itemsize
    if end > len(data):
        raise ValueError(f"the {element.count:,} rows of {element.name} are cut off")
    if not row_type.itemsize:
        return np.zeros(element.count, dtype=row_type), end
    return np.frombuffer(data, row_type, element.count, offset), end
