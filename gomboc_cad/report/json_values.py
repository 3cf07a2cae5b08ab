"""Values of JSON files that remember where they stand, so that a page can say where each number is from."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import Any

from gomboc_cad.errors import InspectionError

_MISSING: Any = object()
_MOST_ITEMS = 2000
_LONGEST_TEXT = 20_000
"""A longer list or text is none of ours."""


class Value:
    """A value with the file and the pointer (RFC 6901) at which it stands.

    A key that is not there gives an absent value, which is false and has absent keys in turn; only reading a
    number or a text from it is an error. Null is absent too.
    """

    __slots__ = ("_file", "_pointer", "_raw")

    def __init__(self, raw: Any, file: str, pointer: str = "") -> None:
        self._raw, self._file, self._pointer = raw, file, pointer

    @classmethod
    def absent(cls, file: str) -> Value:
        """The content of a file that is not there."""
        return cls(_MISSING, file)

    def __getitem__(self, key: str | int) -> Value:
        raw, where = self._raw, f"{self._pointer}/{_escaped(key)}"
        if isinstance(raw, dict) and isinstance(key, str):
            return Value(raw.get(key, _MISSING), self._file, where)
        if isinstance(raw, list) and isinstance(key, int):
            return Value(raw[key] if 0 <= key < len(raw) else _MISSING, self._file, where)
        if raw is _MISSING or raw is None:
            return Value(_MISSING, self._file, where)
        raise self.refused("an object" if isinstance(key, str) else "a list")

    def __iter__(self) -> Iterator[Value]:
        return (self[place] for place in range(len(self)))

    def __len__(self) -> int:
        if not self.there:
            return 0
        if not isinstance(self._raw, list):
            raise self.refused("a list")
        if len(self._raw) > _MOST_ITEMS:
            raise InspectionError(f"{self.where} has more than {_MOST_ITEMS} entries.")
        return len(self._raw)

    def __bool__(self) -> bool:
        raw = self._raw
        if raw is _MISSING or raw is None:
            return False
        return raw if isinstance(raw, bool) else not isinstance(raw, str | list | dict) or bool(raw)

    def __eq__(self, other: object) -> bool:
        return bool(self._raw == (other._raw if isinstance(other, Value) else other))

    def __hash__(self) -> int:
        return hash((self._file, self._pointer))

    def names(self) -> list[str]:
        """Keys of an object, in their order; none of what is absent."""
        if not self.there:
            return []
        if not isinstance(self._raw, dict):
            raise self.refused("an object")
        return list(self._raw)[:_MOST_ITEMS]

    @property
    def there(self) -> bool:
        """Whether there is such a key with anything but null."""
        return self._raw is not _MISSING and self._raw is not None

    @property
    def raw(self) -> Any:
        """The plain value; None if it is absent."""
        return None if self._raw is _MISSING else self._raw

    @property
    def address(self) -> str:
        """File and pointer: `verdict.json#/assembly/mass_g`."""
        return f"{self._file}#{self._pointer}"

    @property
    def key(self) -> str:
        """The last key of its pointer."""
        return self._pointer.rsplit("/", 1)[-1].replace("~1", "/").replace("~0", "~")

    @property
    def where(self) -> str:
        """File and key for a sentence: `verdict.json: assembly.mass_g`."""
        key = self._pointer.removeprefix("/").replace("/", ".")
        return f"{self._file}: {key}" if key else self._file

    @property
    def number(self) -> float:
        """The number.

        Raises:
            InspectionError: If it is none, or not finite.
        """
        raw = self._raw
        if isinstance(raw, bool) or not isinstance(raw, int | float):
            raise self.refused("a number")
        try:
            value = float(raw)
        except OverflowError:
            value = math.inf
        if not math.isfinite(value) or abs(value) > 1e30:
            raise InspectionError(f"{self.where} is not a number of use.")
        return value

    @property
    def text(self) -> str:
        """The text.

        Raises:
            InspectionError: If it is none.
        """
        if not isinstance(self._raw, str) or len(self._raw) > _LONGEST_TEXT:
            raise self.refused("a text")
        return self._raw

    @property
    def numbers(self) -> list[float]:
        """The numbers of a list.

        Raises:
            InspectionError: If they are not.
        """
        return [value.number for value in self]

    def refused(self, wanted: str) -> InspectionError:
        """The error of a value that is not what is wanted there: `a number`, `a text`."""
        if self._raw is _MISSING:
            return InspectionError(f"{self.where} is missing; write the folder again.")
        return InspectionError(f"{self.where} must be {wanted}; write the folder again.")


def _escaped(key: str | int) -> str:
    return str(key).replace("~", "~0").replace("/", "~1")


def lookup(document: Any, pointer: str) -> Any:
    """The value at a pointer of RFC 6901.

    Raises:
        KeyError, IndexError: If there is none.
    """
    for part in pointer.split("/")[1:]:
        key = part.replace("~1", "/").replace("~0", "~")
        document = document[int(key)] if isinstance(document, list) else document[key]
    return document
